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


def test_everything_is_documented():
    for name in inhabit.__all__:
        assert getattr(inhabit, name).__doc__, name


def test_stubs_type_check(tmp_path):
    pytest.importorskip("mypy")
    run = subprocess.run([sys.executable, "-m", "mypy", "--cache-dir", str(tmp_path), os.path.join(PYTHON, "inhabit/__init__.pyi")],
                         capture_output=True, text=True)
    assert run.returncode == 0, run.stdout
