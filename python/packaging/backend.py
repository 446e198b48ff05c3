"""Builds the wheel with CMake and Python's standard library alone, so that `pip install .` needs no package but those of
scripts/dependencies.sh, with and without build isolation (PEP 517).

--config-settings build-dir=build/release takes a build tree that is there; else build/wheel is made.
"""

import base64
import hashlib
import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
NAME = "inhabit"
with open(os.path.join(ROOT, "inhabit", "version.h"), encoding="utf-8") as header:
    VERSION = re.search(r'INHABIT_VERSION "([0-9.]+)"', header.read())[1]
METADATA = f"""Metadata-Version: 2.1
Name: {NAME}
Version: {VERSION}
Summary: Human motion in 3D scenes
License: MIT
Requires-Python: >=3.8
Requires-Dist: numpy>=1.22
"""


def get_requires_for_build_wheel(config_settings=None):
    return []


def get_requires_for_build_editable(config_settings=None):
    return []


def get_requires_for_build_sdist(config_settings=None):
    return []


def python_of(cache):
    """The Python that a build tree is for: what it was told, else Debian's."""
    with open(cache, encoding="utf-8") as lines:
        told = re.search(r"^_?Python_EXECUTABLE:\w+=(.+)$", lines.read(), re.MULTILINE)
    return told[1] if told else "/usr/bin/python3"


def build_module(build):
    """Configures the tree `build` and builds the module in it."""
    cmake = ["cmake", "-S", ROOT, "-B", build, "-DINHABIT_BUILD_PYTHON=ON"]
    cache = os.path.join(build, "CMakeCache.txt")
    # A tree of the Python that a virtual environment was made from stays as it is.
    if not os.path.exists(cache) or os.path.realpath(python_of(cache)) != os.path.realpath(sys.executable):
        cmake.append(f"-DPython_EXECUTABLE={sys.executable}")
    if not os.path.exists(cache):
        cmake += ["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DINHABIT_BUILD_TESTS=OFF"]
    subprocess.run(cmake, check=True)
    subprocess.run(["cmake", "--build", build, "--target", "inhabit_python"], check=True)


def built(build, prefix):
    """Builds the module in `build` and installs it to `prefix`; the package's folder."""
    build_module(build)
    subprocess.run(["cmake", "--install", build, "--component", "python", "--prefix", prefix], check=True)
    for folder, _, files in os.walk(prefix):
        if "__init__.py" in files:
            return folder
    raise RuntimeError("the Python module was not built: scripts/dependencies.sh installs what it needs")


def build_folder(config_settings):
    return os.path.join(ROOT, (config_settings or {}).get("build-dir", "build/wheel"))


def write_wheel(wheel_directory, contents):
    """A wheel of (name, content) each, for this Python and this machine; its file name."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
    wheel, info = f"{NAME}-{VERSION}-{tag}.whl", f"{NAME}-{VERSION}.dist-info"
    record = []
    with zipfile.ZipFile(os.path.join(wheel_directory, wheel), "w", zipfile.ZIP_DEFLATED) as out:

        def add(name, content):
            out.writestr(name, content)
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
            record.append(f"{name},sha256={digest},{len(content)}")

        for name, content in contents:
            add(name, content)
        add(f"{info}/METADATA", METADATA.encode())
        add(f"{info}/WHEEL", f"Wheel-Version: 1.0\nGenerator: inhabit\nRoot-Is-Purelib: false\nTag: {tag}\n".encode())
        out.writestr(f"{info}/RECORD", "\n".join(record + [f"{info}/RECORD,,"]) + "\n")
    return wheel


def files_of(package):
    """The package with the models."""
    models = os.path.join(ROOT, "models")
    files = [(f"{NAME}/{name}", os.path.join(package, name)) for name in sorted(os.listdir(package))]
    files += [
        (f"{NAME}/models/{name}", os.path.join(models, name))
        for name in sorted(os.listdir(models))
        if name.endswith((".safetensors", ".md"))
    ]
    for name, path in files:
        if os.path.isfile(path):
            with open(path, "rb") as file:
                yield name, file.read()


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    with tempfile.TemporaryDirectory() as prefix:
        return write_wheel(wheel_directory, files_of(built(build_folder(config_settings), prefix)))


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    """A wheel that names the build tree's package (PEP 660): what is built there next is what is imported next."""
    build = build_folder(config_settings)
    build_module(build)
    return write_wheel(wheel_directory, [(f"__editable__.{NAME}.pth", (os.path.join(build, "python") + "\n").encode())])


def build_sdist(sdist_directory, config_settings=None):
    name = f"{NAME}-{VERSION}"
    files = subprocess.run(["git", "-C", ROOT, "ls-files"], check=True, capture_output=True, text=True).stdout.split("\n")
    with tarfile.open(os.path.join(sdist_directory, name + ".tar.gz"), "w:gz") as out:
        for file in filter(None, files):
            out.add(os.path.join(ROOT, file), f"{name}/{file}")
    return name + ".tar.gz"
