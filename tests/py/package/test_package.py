"""What is installed: the import's cost, the wheel's and the source distribution's contents."""

import ast
import json
import os
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from email.parser import Parser
from pathlib import Path

import nfopidn
import pybind11
import pytest


def python(*arguments, **options):
    return subprocess.run(
        [sys.executable, *arguments], capture_output=True, text=True, check=False, **options
    )


def test_import_brings_no_library_but_numpy():
    code = "import sys, nfopidn; print(sorted({name.split('.')[0] for name in sys.modules}))"
    run = python("-c", code)
    assert run.returncode == 0, run.stderr
    loaded = ast.literal_eval(run.stdout)
    assert "nfopidn" in loaded
    assert not {"matplotlib", "scipy", "rich", "bokeh", "pandas", "numba"} & set(loaded)


def build(repository, folder, *command):
    """Build in a folder of its own, so that nobody else's build tree is touched."""
    run = python(
        *["-m", *command, f"-Cbuild-dir={folder / 'tree'}", str(repository)],
        cwd=folder,
        env=os.environ | {"PIP_DISABLE_PIP_VERSION_CHECK": "1"},
    )
    assert run.returncode == 0, run.stdout + run.stderr


@pytest.fixture(scope="module")
def wheel(repository, tmp_path_factory):
    """An already built wheel if NFOPIDN_WHEEL names one; to build it takes a minute."""
    path = os.environ.get("NFOPIDN_WHEEL")
    if not path:
        folder = tmp_path_factory.mktemp("wheel")
        build(
            *[repository, folder, "pip", "wheel", "--no-build-isolation", "--no-deps"],
            *["-w", str(folder)],
        )
        (path,) = folder.glob("*.whl")
    return zipfile.ZipFile(path)


@pytest.fixture(scope="module")
def sdist(repository, tmp_path_factory):
    folder = tmp_path_factory.mktemp("sdist")
    build(repository, folder, "build", "--sdist", "--no-isolation", "-o", str(folder))
    (path,) = folder.glob("*.tar.gz")
    return tarfile.open(path)


def metadata(text):
    return Parser().parsestr(text.decode())


def python_files(repository):
    package = repository / "python" / "nfopidn"
    return {
        f"nfopidn/{path.relative_to(package).as_posix()}"
        for pattern in ("*.py", "*.pyi", "py.typed", "*.in", "*.html", "*.css", "*.js")
        for path in package.rglob(pattern)
    }


def test_the_wheel_holds_the_package_alone(wheel, repository):
    info = f"nfopidn-{nfopidn.__version__}.dist-info"
    names = [name for name in wheel.namelist() if not name.endswith("/")]
    assert {name.split("/")[0] for name in names} == {"nfopidn", info}
    package = {name for name in names if name.startswith("nfopidn/")}
    (module,) = (name for name in package if re.fullmatch(r"nfopidn/_core\..*\.so", name))
    assert package - {module} == python_files(repository)
    assert {"nfopidn/py.typed", "nfopidn/_core.pyi"} <= package
    assert f"{info}/licenses/LICENSE" in names


def test_the_wheel_says_what_it_is(wheel):
    info = f"nfopidn-{nfopidn.__version__}.dist-info"
    about = metadata(wheel.read(f"{info}/METADATA"))
    assert about["Name"] == "nfopidn"
    assert about["License-Expression"] == "MIT"
    needs = {
        re.match(r"[\w-]+", need)[0] for need in about.get_all("Requires-Dist") if ";" not in need
    }
    assert needs == {"numpy", "scipy", "matplotlib", "rich"}
    assert b"Root-Is-Purelib: false" in wheel.read(f"{info}/WHEEL")


def test_the_wheel_s_module_is_for_every_machine(wheel, repository, tmp_path):
    """It runs from the wheel alone, and does what is asked of the wheels of all systems."""
    wheel.extractall(tmp_path)
    run = python(
        str(repository / "tests" / "wheel.py"),
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
    )
    assert run.returncode == 0, run.stderr
    assert Path(run.stdout.split(": ")[1].strip()).is_relative_to(tmp_path)


@pytest.mark.skipif(sys.platform != "linux", reason="auditwheel is for wheels of Linux")
def test_the_wheel_needs_no_library_that_linux_may_lack(wheel):
    """Whatever glibc it was built with: nothing to graft, no instructions beyond the baseline."""
    run = python("-m", "auditwheel", "show", "--json", wheel.filename)
    assert run.returncode == 0, run.stderr
    found = json.loads(run.stdout)
    assert found["overall_tag"].startswith("manylinux_")
    assert found["external_libs"] == {}
    assert not found["unsupported_isa"]
    assert not found["pure"]
    libraries = {name.split(".so")[0] for name in found["versioned_symbols"]}
    assert libraries <= {"libc", "libm", "libgcc_s", "libstdc++", "libpthread", "ld-linux-aarch64"}


def test_an_index_takes_the_metadata(wheel, sdist):
    run = python("-m", "twine", "check", "--strict", wheel.filename, sdist.name)
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout.count("PASSED") == 2


def test_the_source_distribution_can_be_configured(sdist, tmp_path):
    """CMake finds all that it names; compiling is for the workflow of wheels."""
    sdist.extractall(tmp_path, filter="data")
    (source,) = tmp_path.iterdir()
    settings = tomllib.loads((source / "pyproject.toml").read_text())["tool"]["scikit-build"]
    defined = {name: str(value).upper() for name, value in settings["cmake"]["define"].items()}
    defined["pybind11_DIR"] = pybind11.get_cmake_dir()
    for name in ("Python", "Python3", "PYTHON"):
        defined[f"{name}_EXECUTABLE"] = sys.executable
    run = subprocess.run(
        [
            *["cmake", "-S", str(source), "-B", str(tmp_path / "build"), "-G", "Ninja"],
            *[f"-D{name}={value}" for name, value in defined.items()],
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr


def test_the_source_distribution_holds_what_a_build_needs(sdist, repository):
    root = f"nfopidn-{nfopidn.__version__}/"
    names = {name.removeprefix(root) for name in sdist.getnames()}
    headers = (repository / "cpp").rglob("*.?pp")
    needed = {path.relative_to(repository).as_posix() for path in headers}
    needed |= {f"python/{name}" for name in python_files(repository)}
    needed |= {"CMakeLists.txt", "pyproject.toml", "LICENSE", "README.md"}
    assert "cpp/include/nfopidn/control/controller.hpp" in needed
    assert needed <= names
    top = {name.split("/")[0] for name in names}
    assert not top & {"build", "tests", ".venv", ".git", "docs", "bench", ".github"}
    assert not any(name.endswith((".so", ".pyc")) for name in names)


def test_the_source_distribution_has_the_version(sdist):
    root = f"nfopidn-{nfopidn.__version__}"
    about = metadata(sdist.extractfile(f"{root}/PKG-INFO").read())
    assert about["Version"] == nfopidn.__version__


def test_the_project_has_one_version(repository):
    cmake = (repository / "CMakeLists.txt").read_text()
    assert re.search(r"project\(nfopidn VERSION ([\d.]+)", cmake)[1] == nfopidn.__version__
