import inspect
import os
import runpy
import subprocess
import sys

import pytest

import inhabit

PYTHON = os.path.join(os.environ["INHABIT_SOURCE"], "python")


def test_stubs_are_those_of_the_module():
    made = runpy.run_path(os.path.join(PYTHON, "tools/make_stubs.py"))["stubs"]()
    with open(os.path.join(PYTHON, "inhabit/__init__.pyi")) as file:
        assert file.read() == made, "run: PYTHONPATH=build/release/python python3 python/tools/make_stubs.py > python/inhabit/__init__.pyi"


def test_stubs_are_python():
    compile(open(os.path.join(PYTHON, "inhabit/__init__.pyi")).read(), "__init__.pyi", "exec")


def words_of(member):
    """A docstring without the signature that pybind11 writes."""
    first, _, rest = (member.__doc__ or "").strip().partition("\n")
    return rest.strip() if " -> " in first else first


def test_everything_is_documented():
    for name in inhabit.__all__:
        member = getattr(inhabit, name)
        assert words_of(member), name
        for inner, of in vars(member).items() if inspect.isclass(member) else ():
            assert inner.startswith("_") or words_of(of), f"{name}.{inner}"


def test_stubs_say_what_may_be_none():
    made = runpy.run_path(os.path.join(PYTHON, "tools/make_stubs.py"))["result_of"]
    assert made("numpy.ndarray", "(T, 3) float32, or None.") == "Optional[numpy.ndarray]"
    assert made("numpy.ndarray", "scene: left out, None is assumed.") == "numpy.ndarray"
    assert made("Any", "Returns the Dataset, or None where ...") == "Optional[Dataset]"


def test_stubs_type_check(tmp_path):
    pytest.importorskip("mypy")
    run = subprocess.run([sys.executable, "-m", "mypy", "--cache-dir", str(tmp_path), os.path.join(PYTHON, "inhabit/__init__.pyi")],
                         capture_output=True, text=True)
    assert run.returncode == 0, run.stdout
