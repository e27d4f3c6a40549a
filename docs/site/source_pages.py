"""Pages that show a source file, line by line, so that other pages can point at a line."""

from pathlib import Path

from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import TextLexer, get_lexer_for_filename
from pygments.util import ClassNotFound

WORDS = {".hpp": "x.cpp", ".cff": "x.yaml", ".ld": "x.c"}  # how Pygments knows them


def listing(path: Path) -> str:
    """Return a file as HTML; line 7 has the anchor line-7."""
    try:
        lexer = get_lexer_for_filename(WORDS.get(path.suffix, path.name))
    except ClassNotFound:
        lexer = TextLexer()
    formatter = HtmlFormatter(linenos="inline", lineanchors="line", anchorlinenos=True)
    return highlight(path.read_text(), lexer, formatter)


def page(repository: Path, path: str) -> dict[str, str]:
    """Return the page of a file, and the listing that it includes, by name."""
    name = Path(path).name
    return {
        f"source/{path}.rst": "\n".join(
            [
                ":orphan:",
                "",
                name,
                "=" * len(name),
                "",
                f"``{path}``",
                "",
                ".. raw:: html",
                f"   :file: {name}.listing",
                "",
            ]
        ),
        f"source/{path}.listing": listing(repository / path),
    }


def folder_page(repository: Path, path: str, files: list[str]) -> dict[str, str]:
    """Return the page of a folder: links to the pages of its files."""
    title = path
    lines = [":orphan:", "", title, "=" * len(title), ""]
    lines += [f"- :doc:`{file.removeprefix(path + '/')} </source/{file}>`" for file in files]
    return {f"source/{path}/folder.rst": "\n".join(lines) + "\n"}
