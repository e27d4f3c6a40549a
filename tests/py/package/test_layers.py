"""Includes and imports point down: the folders are the layers."""

import ast
import re

import pytest

#: From the bottom up. A folder includes those before it, and itself.
HEADERS = [
    "foundation",
    "math",
    "plant",
    "control",
    "loop",
    "firmware",
    "long_memory",
    "parallel",
    "simulation",
    "search",
    "tuning",
    "rivals",
    "io",
    "analysis",
]
#: Modules and packages of nfopidn, likewise.
MODULES = [
    "_core",
    "arguments",
    "arithmetic",
    "pickling",
    "files",
    "console",
    "scoring",
    "mujoco",
    "trajectories",
    "formats",
    "engines",
    "fractional",
    "stability",
    "families",
    "robustness",
    "plot",
    "identification",
    "montecarlo",
    "search",
    "tuning",
    "comparison",
    "export",
    "reporting",
    "study",
    "commands",
    "__init__",
    "__main__",
]


def includes(path):
    return re.findall(r'^#include "nfopidn/([^"]+)"', path.read_text(), flags=re.MULTILINE)


def test_headers_include_no_folder_above_their_own(repository):
    root = repository / "cpp" / "include" / "nfopidn"
    headers = sorted(root.glob("*/*.hpp"))
    assert {path.parent.name for path in headers} == set(HEADERS)
    upward = [
        f"{path.parent.name}/{path.name} includes {included}"
        for path in headers
        for included in includes(path)
        if HEADERS.index(included.split("/")[0]) > HEADERS.index(path.parent.name)
    ]
    assert upward == []


def test_headers_form_no_circle(repository):
    root = repository / "cpp" / "include" / "nfopidn"
    graph = {str(path.relative_to(root)): includes(path) for path in sorted(root.rglob("*.hpp"))}
    finished = set()

    def visit(header, way):
        assert header not in way, " -> ".join([*way, header])
        if header in finished:
            return
        for included in graph[header]:
            visit(included, [*way, header])
        finished.add(header)

    for header in graph:
        visit(header, [])


def test_firmware_needs_nothing_of_the_host(repository):
    root = repository / "cpp" / "include" / "nfopidn"
    reached, waiting = set(), ["firmware.hpp"]
    while waiting:
        header = waiting.pop()
        if header not in reached:
            reached.add(header)
            waiting += includes(root / header)
    system = {
        name
        for header in reached
        for name in re.findall(r"^#include <([^>]+)>", (root / header).read_text(), re.MULTILINE)
    }
    assert {header.split("/")[0] for header in reached} - {"firmware.hpp"} <= set(HEADERS[:6])
    assert system <= {"cstdint", "limits", "type_traits", "utility", "stdint.h", "float.h"}


def imported(tree, package):
    """Names of the nfopidn modules that a module imports when it is loaded or later."""
    guarded = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING"
        for inner in ast.walk(node)
    }
    for node in ast.walk(tree):
        if id(node) in guarded:
            continue
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("nfopidn"):
            parts = node.module.split(".")[1:]
            names = [parts[0]] if parts else [alias.name for alias in node.names]
            yield from (name for name in names if name in MODULES)
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.startswith("nfopidn."):
                    yield alias.name.split(".")[1]


def test_modules_import_nothing_above_them(repository):
    root = repository / "python" / "nfopidn"
    upward = []
    for path in sorted(root.rglob("*.py")):
        own = path.relative_to(root).parts[0].removesuffix(".py")
        assert own in MODULES, f"{own} has no place in the list of layers"
        upward += [
            f"{path.relative_to(root)} imports {name}"
            for name in imported(ast.parse(path.read_text()), own)
            if MODULES.index(name) > MODULES.index(own)
        ]
    assert upward == []


@pytest.mark.parametrize("kind", ["*", "*/*"])
def test_one_name_has_an_underscore(repository, kind):
    root = repository / "python" / "nfopidn"
    private = {
        path.name.split(".")[0]
        for path in root.glob(kind)
        if path.name.startswith("_") and path.suffix in {".py", ".pyi", ""}
    }
    assert private - {"__init__", "__main__", "__pycache__"} <= {"_core"}
