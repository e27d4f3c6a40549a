"""Pages for every public Python name, from the modules' `__all__`."""

import inspect
from importlib import import_module
from types import ModuleType


def submodules(package: ModuleType) -> list[ModuleType]:
    """Return the public modules of the package, those in its `__all__`."""
    members = [getattr(package, name) for name in package.__all__]
    return [member for member in members if inspect.ismodule(member)]


def public_names(module: ModuleType) -> list[str]:
    """Return the names of a module that have pages: no modules, no dunders."""
    return [
        name
        for name in module.__all__
        if not name.startswith("__") and not inspect.ismodule(getattr(module, name))
    ]


def kind(thing: object) -> str:
    """Return autodoc's word for a member of a module."""
    if inspect.isclass(thing):
        return "class"
    return "function" if callable(thing) else "data"


GROUPS = {"class": "Classes", "function": "Functions", "data": "Constants"}


def heading(title: str, line: str) -> list[str]:
    """Return a title with its underline."""
    return [title, line * len(title), ""]


def summaries(module: ModuleType) -> list[str]:
    """Return a table of the names of each kind, and the hidden list of their pages."""
    lines: list[str] = []
    names = public_names(module)
    for word, title in GROUPS.items():
        own = [name for name in names if kind(getattr(module, name)) == word]
        if own:
            lines += [*heading(title, "-"), ".. autosummary::", "   :nosignatures:", ""]
            lines += [f"   {name}" for name in own] + [""]
    lines += [".. toctree::", "   :hidden:", ""]
    return lines + [f"   {name} <{module.__name__}.{name}>" for name in names] + [""]


def name_page(module: ModuleType, name: str) -> str:
    """Return the page of one name."""
    lines = heading(f"{module.__name__}.{name}", "=")
    lines += [f".. currentmodule:: {module.__name__}", ""]
    word = kind(getattr(module, name))
    lines += [f".. auto{word}:: {name}"]
    if word == "class":  # what it inherits, but not from Python's own classes
        lines += ["   :inherited-members: Sequence, dict, ABC, object"]
    return "\n".join(lines) + "\n"


def module_page(module: ModuleType) -> str:
    """Return the page of a public module: its docstring and its names."""
    lines = heading(module.__name__, "=")
    lines += [f".. automodule:: {module.__name__}", "   :no-members:", ""]
    lines += [f".. currentmodule:: {module.__name__}", ""]
    return "\n".join(lines + summaries(module))


def index_page(package: ModuleType) -> str:
    """Return the page of the package."""
    modules = submodules(package)
    lines = heading("Python reference", "=")
    lines += [
        "Every public name. Angles are radians, units SI, torque pairs (left, right).",
        "",
        f".. currentmodule:: {package.__name__}",
        "",
        *heading("Modules", "-"),
        ".. list-table::",
        "   :widths: 30 70",
        "",
    ]
    for module in modules:
        first = (module.__doc__ or "").strip().splitlines()[0]
        lines += [f"   * - :doc:`{module.__name__}`", f"     - {first}"]
    lines += ["", *summaries(package)]
    lines += [".. toctree::", "   :hidden:", ""]
    return "\n".join(lines + [f"   {module.__name__}" for module in modules]) + "\n"


def pages(package_name: str = "nfopidn") -> dict[str, str]:
    """Return the reference's pages by name."""
    package = import_module(package_name)
    found = {"api/index.rst": index_page(package)}
    for module in submodules(package):
        found[f"api/{module.__name__}.rst"] = module_page(module)
    for module in [package, *submodules(package)]:
        for name in public_names(module):
            found[f"api/{module.__name__}.{name}.rst"] = name_page(module, name)
    return found


def public_objects(package_name: str = "nfopidn") -> dict[str, object]:
    """Return every public object by the name by which it is imported."""
    package = import_module(package_name)
    modules = [package, *submodules(package)]
    return {
        f"{module.__name__}.{name}": getattr(module, name)
        for module in modules
        for name in public_names(module)
    }
