"""Turn the headers' plain comments into those that Doxygen reads.

A block of `//` lines directly above a declaration documents it, a comment behind a member documents
the member, and the block at the top of a file documents the file. Comments inside function bodies
stay as they are. Doxygen calls this as its INPUT_FILTER, with the file's path.
"""

import re
import sys
from pathlib import Path

# What opens a scope of declarations; string literals are blank: extern "C".
SCOPE = re.compile(r"(?:inline\s+)?(?:namespace|class|struct|union|enum)\b|extern\s+_")
LITERAL = re.compile(r"\"(?:\\.|[^\"\\])*\"|'(?:\\.|[^'\\])'")


def split_comment(line: str) -> tuple[str, str | None]:
    """Return the code of a line and its `//` comment, None if it has none."""
    masked = LITERAL.sub(lambda match: "_" * len(match[0]), line)
    place = masked.find("//")
    return (line, None) if place < 0 else (line[:place], line[place + 2 :])


def comment_column(line: str) -> int | None:
    """Return where the comment behind a member starts, None if there is none."""
    code, comment = split_comment(line)
    return len(code) if comment is not None and code.strip() else None


def without_template(statement: str) -> str:
    """Return a declaration without the `template <...>` before it."""
    statement = statement.strip()
    while match := re.match(r"template\s*<", statement):
        depth, end = 1, match.end()
        while depth and end < len(statement):
            depth += {"<": 1, ">": -1}.get(statement[end], 0)
            end += 1
        statement = statement[end:].strip()
    return statement


class Scopes:
    """Which braces are open, and whether each holds declarations."""

    def __init__(self) -> None:
        self.open: list[bool] = []
        self.statement = ""
        self.parentheses = 0

    @property
    def declares(self) -> bool:
        """Whether a declaration can stand here."""
        return all(self.open) and self.parentheses == 0

    def read(self, code: str) -> None:
        """Go on by a line of code."""
        if code.lstrip().startswith("#"):
            return
        for letter in LITERAL.sub("_", code):
            if letter == "{":
                self.open.append(SCOPE.match(without_template(self.statement)) is not None)
            elif letter == "}" and self.open:
                self.open.pop()
            self.parentheses += {"(": 1, ")": -1}.get(letter, 0)
            self.statement = "" if letter in "{};" else self.statement + letter
        self.statement += " "


def escaped(text: str) -> str:
    """Return plain text in which Doxygen finds no commands; `code` becomes code."""
    text = re.sub(r"([\\@<>&#%$\"])", r"\\\1", text)
    return re.sub(r"`([^`]+)`", r"<tt>\1</tt>", text)


def documentation(comments: list[str], indent: str) -> list[str]:
    """Return a block's lines as Doxygen's; lines set in by two more blanks are formulas."""
    formulas = [comment.startswith("   ") for comment in comments]
    if not any(formulas):
        return [f"{indent}///{escaped(comment)}" for comment in comments]
    # Of a /// block Doxygen would show the slashes beside a formula.
    lines = [f"{indent}/**"]
    before = False
    for comment, formula in zip([*comments, ""], [*formulas, False], strict=True):
        if formula != before:
            lines.append("@verbatim" if formula else "@endverbatim")
        lines.append(comment[3:] if formula else escaped(comment))
        before = formula
    return [*lines, f"{indent}*/"]


def filtered(source: str) -> str:
    """Return the source with Doxygen's comments."""
    lines = source.splitlines()
    scopes = Scopes()
    result: list[str] = []
    at_top = True
    i = 0
    while i < len(lines):
        block: list[str] = []
        start = i
        while i < len(lines) and lines[i].lstrip().startswith("//"):
            block.append(lines[i].lstrip()[2:])
            i += 1
        following = lines[i].strip() if i < len(lines) else ""
        if block:
            indent = lines[start][: len(lines[start]) - len(lines[start].lstrip())]
            if at_top:
                documented = documentation(block, indent)
                # In a /** block @file stands in a line of its own behind the opening.
                opening = documented[:1] if documented[0].endswith("/**") else []
                mark = f"{indent}/// @file" if not opening else "@file"
                result += [*opening, mark, *documented[len(opening) :]]
            elif start and comment_column(lines[start - 1]) == len(indent):
                result += [f"{indent}///<{escaped(comment)}" for comment in block]  # it goes on
            elif scopes.declares and following and not following.startswith(("#", "}")):
                result += documentation(block, indent)
            else:
                result += lines[start:i]
            at_top = False
            continue
        at_top = False
        code, comment = split_comment(lines[i])
        scopes.read(code)
        # Behind a member or the value of an enum; what closes a scope has nothing to document.
        member = code.rstrip().endswith((";", ",")) and not code.lstrip().startswith("}")
        if comment is not None and scopes.declares and member:
            result.append(f"{code}///<{escaped(comment)}")
        else:
            result.append(lines[i])
        i += 1
    return "\n".join(result) + "\n"


if __name__ == "__main__":
    sys.stdout.write(filtered(Path(sys.argv[1]).read_text()))
