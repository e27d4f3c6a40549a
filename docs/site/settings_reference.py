"""Tables of every setting, and the help of every command, as the program itself tells them.

The docstrings of the settings' classes are made from the C++ structs' fields(); here they are read
back. The searches' options, which have no class in Python, are read from the structs.
"""

import contextlib
import inspect
import io
import os
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Setting:
    """One setting, in words."""

    name: str
    text: str
    unit: str
    allowed: str
    default: str


ENTRY = re.compile(
    r"^(?P<name>\w+)\n[ ]{4}(?P<text>[^\n]+?)"
    r"(?: \[(?P<unit>[^\]\d][^\]]*)\])?"
    r"(?:; (?P<allowed>in \[[^\]]*\]|one of [^\n]*?|(?:greater than|at least) [^\n]*?))?"
    r"\. Default: (?P<default>[^\n]*)\.$",
    re.MULTILINE,
)


def settings_of(docstring: str) -> list[Setting]:
    """Return the settings that a docstring lists, those with a default."""
    return [
        Setting(
            entry["name"],
            entry["text"],
            entry["unit"] or "",
            (entry["allowed"] or "").removeprefix("in ").removeprefix("one of "),
            entry["default"],
        )
        for entry in ENTRY.finditer(inspect.cleandoc(docstring))
    ]


def table(settings: list[Setting], options: Callable[[str], str] | None = None) -> list[str]:
    """Return settings as a table of Markdown, with the executable's options if those are known."""

    def cell(text: str) -> str:
        return re.sub(r"([|*_$\[\]<>\\])", r"\\\1", text)

    def code(text: str) -> str:
        return f"`{text}`" if text else ""

    names = [setting for setting in settings if options and options(setting.text)]
    head = ["name", "meaning", "unit", "allowed", "default"]
    if names:
        head.insert(1, "option of nfopidn_sim")
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    for setting in settings:
        cells = [
            code(setting.name),
            cell(setting.text),
            cell(setting.unit),
            code(setting.allowed),
            code(setting.default),
        ]
        if names and options:
            cells.insert(1, code(options(setting.text)))
        lines.append("| " + " | ".join(cells) + " |")
    return [*lines, ""]


def sim_options(help_text: str) -> Callable[[str], str]:
    """Return a function that finds the executable's option by what is told about it.

    Of an option with a short name it gives both.
    """
    found = re.findall(r"^  (--[a-z-]+(?:,--[a-z-]+)*)\s+(.*)$", help_text, re.MULTILINE)

    def option(text: str) -> str:
        names = next((names for names, told in found if told.startswith(text)), "")
        return names.replace(",", ", ")

    return option


def struct_settings(source: str) -> dict[str, list[Setting]]:
    """Return the fields of the structs `...Options` of a header."""
    found: dict[str, list[Setting]] = {}
    pattern = r"^struct (\w+Options) \{\n(.*?)^\};"
    for struct in re.finditer(pattern, source, re.MULTILINE | re.DOTALL):
        defaults = dict(re.findall(r"^  [\w:]+ (\w+) = ([^;]+);", struct[2], re.MULTILINE))
        entries = re.findall(
            r"field\(\s*\"(\w+)\",\s*&\w+::(\w+),\s*\"([^\"]*)\",\s*(.*?),\s*"
            r"((?:\"(?:\\.|[^\"\\])*\"\s*)+)\)\)",
            struct[2],
            re.DOTALL,
        )
        found[struct[1]] = [
            Setting(
                name,
                "".join(re.findall(r"\"((?:\\.|[^\"\\])*)\"", text)).replace('\\"', '"'),
                unit,
                re.sub(r"^between\((.*)\)$", r"[\1]", limits).replace("any_number()", ""),
                defaults.get(member, ""),
            )
            for name, member, unit, limits, text in entries
        ]
    return found


def python_settings(package: Any) -> list[tuple[str, list[Setting]]]:
    """Return the settings of every public class and of the constructors beside it."""
    found: list[tuple[str, list[Setting]]] = []
    for name in package.__all__:
        owner = getattr(package, name)
        if not inspect.isclass(owner):
            continue
        own = settings_of(owner.__doc__ or "")
        if own:
            found.append((f"nfopidn.{name}", own))
        for member in sorted(vars(owner)):
            static = isinstance(inspect.getattr_static(owner, member), staticmethod)
            text = getattr(owner, member).__doc__ or "" if static else ""
            if settings := settings_of(text):
                found.append((f"nfopidn.{name}.{member}", settings))
    return found


def settings_page(repository: Path, sim_help: str) -> str:
    """Return the page of settings."""
    package = import_module("nfopidn")
    lines = [
        "# Settings",
        "",
        "Every setting is one line in its struct's `fields()`. From that line follow the Python",
        "keyword, the key in JSON files, the option of `nfopidn_sim`, the range that is checked,",
        "and this page.",
        "",
    ]
    alike: dict[tuple[Setting, ...], list[str]] = {}
    for title, settings in python_settings(package):
        alike.setdefault(tuple(settings), []).append(title)
    for same, titles in alike.items():
        shared = [title.rpartition(".")[2] for title in titles[1:]]
        lines += [f"## {', '.join(titles[:1] + shared)}", ""]
        lines += table(list(same), sim_options(sim_help))
    lines += ["## Other control laws", "", "Settings of `nfopidn.Rival`; bounds of a search.", ""]
    for law in package.Rival.laws():
        rows = [
            Setting(name, text, unit, f"[{low:g}, {high:g}]", f"{getattr_of(package, law, name)}")
            for name, unit, low, high, text in package.Rival.describe(law)
        ]
        lines += [f"### {law}", "", *table(rows)]
    lines += ["## Options of the searches", "", "The argument `options` of `tune` and `bfoa`.", ""]
    for path in sorted((repository / "cpp" / "include").rglob("*.hpp")):
        for name, settings in struct_settings(path.read_text()).items():
            if settings:
                lines += [f"### {name}", "", *table(settings)]
    return "\n".join(lines)


def getattr_of(package: Any, law: str, name: str) -> str:
    """Return the default of a law's parameter."""
    value = package.Rival(law).parameters[name]
    return f"{value:.6g}"


def console_help(arguments: list[str]) -> str:
    """Return what the command `nfopidn` prints."""
    (command,) = entry_points(group="console_scripts", name="nfopidn")
    main = command.load()
    printed = io.StringIO()
    before = sys.argv
    sys.argv = ["nfopidn", *arguments]
    try:
        with contextlib.redirect_stdout(printed), contextlib.suppress(SystemExit):
            main()
    finally:
        sys.argv = before
    return printed.getvalue()


def commands_page(executable: Path, sim_help: str) -> str:
    """Return the page of commands: the help of each."""
    os.environ["COLUMNS"] = "100"
    overview = console_help(["--help"])
    lines = ["# Commands", "", "## nfopidn", "", "```text", overview.rstrip(), "```", ""]
    for name in re.findall(r"^    ([a-z][\w-]*)  +\S", overview, re.MULTILINE):
        if name == "simulate":  # prints past sys.stdout what nfopidn_sim prints
            lines += [
                f"## nfopidn {name}",
                "",
                f"Does what `{executable.name}` does, which is told",
            ]
            lines += ["below, with the same options.", ""]
            continue
        told = console_help([name, "--help"])
        lines += [f"## nfopidn {name}", "", "```text", told.rstrip(), "```", ""]
    lines += [f"## {executable.name}", "", "```text", sim_help.rstrip(), "```", ""]
    return "\n".join(lines)


def executable_help(executable: Path) -> str:
    """Return the help of nfopidn_sim."""
    run = subprocess.run([executable, "--help"], capture_output=True, text=True, check=True)
    return run.stdout
