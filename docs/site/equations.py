"""Where is it? From the equations of the paper to the lines and tests that cite them.

A line cites an equation by `eq. 34` or `eqs. 31-36` in a comment or docstring. What another source
numbers is told apart by the year before it ("IEEE ICRA 1990, eq. 7") and by its form (eq. 5.12).
"""

import ast
import io
import re
import tokenize
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

EQUATIONS = range(1, 45)  # the paper's

GAP = r"(?:\s|\n[ \t]*(?://|#)[ \t]*)"
CITATION = re.compile(
    rf"\b[Ee]qs?\.{GAP}+(\d+(?!\.\d)(?:{GAP}*(?:,|-|\u2013|and|to){GAP}*\d+(?!\.\d))*)(?!\.?\d)"
)
OTHER_SOURCE = re.compile(rf"\b(?:19|20)\d\d,{GAP}*$")


def numbers(text: str) -> list[int]:
    """Return the numbers of a list such as `5, 6, 9 and 16-19`."""
    found: list[int] = []
    words = re.findall(r"\d+|-|\u2013|to\b", text)
    for i, word in enumerate(words):
        if not word.isdigit():
            continue
        first = found[-1] + 1 if i and not words[i - 1].isdigit() else int(word)
        found += range(first, int(word) + 1)
    return found


def citations(text: str) -> list[tuple[int, list[int]]]:
    """Return the lines that cite equations, counted from 1, each with their numbers."""
    found = []
    for match in CITATION.finditer(text):
        if OTHER_SOURCE.search(text[: match.start()]):
            continue
        cited = [number for number in numbers(match[1]) if number in EQUATIONS]
        if cited:
            found.append((text.count("\n", 0, match.start()) + 1, cited))
    return found


def cpp_prose(source: str) -> str:
    """Return a C++ source with all but its `//` comments blank, line by line."""
    lines = []
    for line in source.splitlines():
        masked = re.sub(r"\"(?:\\.|[^\"\\])*\"", lambda match: "_" * len(match[0]), line)
        place = masked.find("//")
        lines.append(line[place:] if place >= 0 else "")
    return "\n".join(lines)


def python_prose(source: str) -> str:
    """Return a Python source with all but comments and docstrings blank, line by line."""
    kept: set[int] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            kept.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    comments = {
        token.start[0]: token.string
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type == tokenize.COMMENT
    }
    lines = source.splitlines()
    return "\n".join(
        line if i in kept else comments.get(i, "") for i, line in enumerate(lines, start=1)
    )


@dataclass(frozen=True)
class Place:
    """A line of a file that cites an equation."""

    path: str
    line: int


def search(repository: Path, folders: list[str]) -> dict[int, list[Place]]:
    """Return the places under some folders that cite each equation."""
    found: dict[int, list[Place]] = defaultdict(list)
    for folder in folders:
        for path in sorted((repository / folder).rglob("*")):
            if path.suffix in {".hpp", ".cpp"}:
                prose = cpp_prose(path.read_text())
            elif path.suffix == ".py":
                prose = python_prose(path.read_text())
            else:
                continue
            for line, cited in citations(prose):
                for number in cited:
                    found[number].append(Place(path.relative_to(repository).as_posix(), line))
    return found


def slug(title: str) -> str:
    """Return the anchor that Markdown gives a heading."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def sections(text: str) -> dict[int, list[tuple[str, str]]]:
    """Return the headings, with their anchors, of the sections that treat each equation."""
    found: dict[int, list[tuple[str, str]]] = defaultdict(list)
    title = ""
    prose = re.sub(r"```.*?```", lambda match: "\n" * match[0].count("\n"), text, flags=re.DOTALL)
    for line in prose.splitlines():
        if heading := re.match(r"#+\s+(.*)", line):
            title = heading[1]
        for _, cited in citations(line):
            for number in cited:
                entry = (re.sub(r"\s*\(eqs?\..*\)", "", title), slug(title))
                if title and entry not in found[number]:
                    found[number].append(entry)
    return found


def documents(folder: Path) -> dict[int, list[tuple[str, str]]]:
    """Return the sections that explain each equation: theory.md's, else those of other pages."""
    found: dict[int, list[tuple[str, str]]] = defaultdict(list)
    names = sorted(path.name for path in folder.glob("*.md"))
    for name in sorted(names, key=lambda name: name != "theory.md"):
        for number, entries in sections((folder / name).read_text()).items():
            if all(place.startswith(name) for _, place in found[number]):
                found[number] += [(title, f"{name}#{anchor}") for title, anchor in entries]
    return found


def page(repository: Path) -> tuple[str, set[str]]:
    """Return the page, and the files that it points at."""
    code = search(repository, ["cpp", "python"])
    tests = search(repository, ["tests"])
    explained = documents(repository / "docs")
    lines = [
        "# Where is it?",
        "",
        "From the paper's equations to the lines that implement them and the tests that cite them,",
        "gathered from the comments and docstrings. Equations are grouped where the same places",
        "cite them.",
        "",
        "| equation | explained in | code | tests |",
        "| --- | --- | --- | --- |",
    ]
    cited: set[str] = set()

    def links(places: list[Place]) -> str:
        cited.update(place.path for place in places)
        by_file: dict[str, list[int]] = defaultdict(list)
        for place in places:
            by_file[place.path].append(place.line)
        return "<br>".join(
            f"`{Path(path).parent.name}/{Path(path).name}`"
            + ",".join(f' <a href="source/{path}.html#line-{n}">{n}</a>' for n in sorted(set(own)))
            for path, own in by_file.items()
        )

    rows: dict[tuple[str, str, str], list[int]] = defaultdict(list)
    for number in EQUATIONS:
        told = "<br>".join(f"[{title}]({place})" for title, place in explained[number])
        rows[told, links(code[number]), links(tests[number])].append(number)
    for row, group in rows.items():
        lines.append(f"| {ranges(group)} | " + " | ".join(row) + " |")
    return "\n".join(lines) + "\n", cited


def ranges(group: list[int]) -> str:
    """Return numbers as `5, 6, 9-12`."""
    parts: list[list[int]] = []
    for number in group:
        if parts and parts[-1][-1] == number - 1:
            parts[-1].append(number)
        else:
            parts.append([number])
    return ", ".join(str(part[0]) if len(part) == 1 else f"{part[0]}-{part[-1]}" for part in parts)
