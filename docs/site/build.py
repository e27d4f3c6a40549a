"""Build the documentation, with warnings as errors.

python docs/site/build.py --executable build/nfopidn_sim

It lays out the pages in build/docs/source, runs Doxygen and Sphinx, and checks the result in
build/docs/html.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

SITE = Path(__file__).resolve().parent
REPOSITORY = SITE.parents[1]
sys.path.insert(0, str(SITE))

import check
import cpp_reference
import equations
import python_reference
import settings_reference
import source_pages

PAGES = ("docs/*.md", "docs/study/*.md", "bench/*.md", "tests/golden/*.md", "*.md")
NOT_PAGES = {"README.md"}  # index.md says the same for the site
ASSETS = ("docs/images/*", "docs/study/*")

# The order of the sidebar. Guides that are not named come after those that are.
GUIDES = (
    *("trajectories", "formats", "identification"),
    *("tuning", "stability", "robustness", "physics", "comparison", "rivals", "embedding"),
    "fractional",
    "report",
)
PAPER = ("theory", "reproduction", "study/README", "equations")
REFERENCE = ("api/index", "settings", "commands", "cpp/index")
TITLES = {"study/README": "Tables and figures", "bench/firmware": "Figures of the firmware"}
PROJECT = ("CONTRIBUTING", "CHANGELOG", "bench/README", "bench/firmware", "tests/golden/README")

LINK = re.compile(r"(?<=\]\()([^)\s#:]+)(#[^)\s]*)?(?=\))")


def staged(path: str) -> str:
    """Return where a file of the repository stands among the site's pages."""
    return path.removeprefix("docs/")


class Links:
    """Where the Markdown's links lead on the site; what they need besides pages."""

    def __init__(self, pages: set[str]) -> None:
        self.pages = pages
        self.files: set[str] = set()
        self.folders: set[str] = set()
        self.broken: list[str] = []

    def target(self, path: str) -> str | None:
        """Return the page of a file or folder of the repository, None for what is none."""
        place = REPOSITORY / path
        if path in NOT_PAGES:
            return "index.md"
        if path in self.pages or any(place.match(pattern) for pattern in ASSETS):
            return staged(path) if place.exists() else None
        if place.is_dir():
            self.folders.add(path)
            return f"source/{path}/folder.rst"
        if re.fullmatch(r"examples/\w+\.py", path):
            return f"gallery/{place.stem}.rst" if place.exists() else None
        if place.is_file():
            self.files.add(path)
            return f"source/{path}.rst"
        return None

    def rewritten(self, path: str, text: str) -> str:
        """Return a page of Markdown with its links as they are on the site."""
        folder = Path(path).parent
        here = Path(staged(path)).parent

        def replace(match: re.Match[str]) -> str:
            named = os.path.normpath(folder / match[1])
            target = self.target(named)
            if target is None:
                self.broken.append(f"{path}: {match[0]}")
                return match[0]
            return Path(os.path.relpath(target, here)).as_posix() + (match[2] or "")

        pieces = re.split(r"(```.*?```)", text, flags=re.DOTALL)
        pieces[::2] = [LINK.sub(replace, piece) for piece in pieces[::2]]
        return "".join(pieces)


def markdown_pages() -> dict[str, str]:
    """Return the repository's Markdown by path."""
    found = [path for pattern in PAGES for path in sorted(REPOSITORY.glob(pattern))]
    names = {path.relative_to(REPOSITORY).as_posix(): path for path in found}
    return {name: path.read_text() for name, path in names.items() if name not in NOT_PAGES}


def contents(names: set[str]) -> str:
    """Return the sidebar: hidden lists of pages under a caption each."""
    captioned = {"Guides": list(GUIDES), "The paper": list(PAPER)}
    captioned["Reference"] = list(REFERENCE)
    captioned["Project"] = list(PROJECT)
    known = {name for group in captioned.values() for name in group}
    captioned["Guides"] += sorted(names - known)
    captioned["Guides"].insert(0, "gallery/index")
    generated = {"gallery/index", "equations", *REFERENCE}
    lines: list[str] = []
    for caption, group in captioned.items():
        lines += ["", "```{toctree}", ":hidden:", f":caption: {caption}", ""]
        for name in group:
            if name in names or name in generated:
                lines.append(f"{TITLES[name]} <{name}>" if name in TITLES else name)
        lines.append("```")
    return "\n".join(lines) + "\n"


def lay_out(source: Path, executable: Path) -> None:
    """Write all pages; those that have not changed stay as they are, for Sphinx to skip."""
    originals = markdown_pages()
    links = Links(set(originals))
    pages = {staged(path): links.rewritten(path, text) for path, text in originals.items()}
    names = {path.removesuffix(".md") for path in pages}
    pages["index.md"] = (SITE / "index.md").read_text() + contents(names)
    links.target("examples/firmware")
    links.target("examples/tune.cpp")
    if links.broken:
        sys.exit("links to what does not exist:\n" + "\n".join(links.broken))

    help_text = settings_reference.executable_help(executable)
    pages["settings.md"] = settings_reference.settings_page(REPOSITORY, help_text)
    pages["commands.md"] = settings_reference.commands_page(executable, help_text)
    pages["equations.md"], cited = equations.page(REPOSITORY)
    pages |= python_reference.pages()
    pages |= cpp_reference.pages(REPOSITORY)

    root = Path(cpp_reference.INCLUDE)
    files = links.files | cited
    files |= {(root / header).as_posix() for header in cpp_reference.headers(REPOSITORY)}
    for folder in links.folders:
        own = [path for path in (REPOSITORY / folder).rglob("*") if path.is_file()]
        held = sorted(path.relative_to(REPOSITORY).as_posix() for path in own)
        held = [path for path in held if "__pycache__" not in path]
        files.update(held)
        pages |= source_pages.folder_page(REPOSITORY, folder, held)
    for path in files:
        pages |= source_pages.page(REPOSITORY, path)

    write(source, pages)


def write(source: Path, pages: dict[str, str]) -> None:
    """Bring the folder of sources to these pages and the assets, and nothing else."""
    wanted = {source / name: text.encode() for name, text in pages.items()}
    for pattern in ASSETS:
        for path in REPOSITORY.glob(pattern):
            if path.suffix != ".md":
                wanted[source / staged(path.relative_to(REPOSITORY).as_posix())] = path.read_bytes()
    for path in [*source.rglob("*")]:
        made_by_sphinx = path.is_relative_to(source / "gallery")
        if path.is_file() and path not in wanted and not made_by_sphinx:
            path.unlink()
    for path, text in wanted.items():
        if not path.exists() or path.read_bytes() != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(text)


def copy_examples(folder: Path) -> None:
    """Copy the examples to where the gallery runs them: they write files beside themselves."""
    folder.mkdir(parents=True, exist_ok=True)
    scripts = sorted((REPOSITORY / "examples").glob("*.py"))
    for path in folder.glob("*.py"):
        if path.name not in {script.name for script in scripts}:
            path.unlink()
    for path in [*scripts, SITE / "GALLERY_HEADER.rst"]:
        shutil.copy2(path, folder)


def main() -> None:
    """Build and check."""
    parser = argparse.ArgumentParser(description="Build the documentation.")
    parser.add_argument("--output", type=Path, default=REPOSITORY / "build" / "docs")
    parser.add_argument("--executable", type=Path, default=REPOSITORY / "build" / "nfopidn_sim")
    arguments = parser.parse_args()
    output = arguments.output.resolve()
    os.environ["NFOPIDN_DOCS"] = str(output)

    import nfopidn

    lay_out(output / "source", arguments.executable.resolve())
    copy_examples(output / "examples")
    cpp_reference.run_doxygen(REPOSITORY, output / "doxygen", nfopidn.__version__)
    command = [sys.executable, "-m", "sphinx", "-b", "html", "-c", str(SITE), "-W", "--keep-going"]
    command += ["-q", "-d", str(output / "doctrees"), str(output / "source"), str(output / "html")]
    if subprocess.run(command, check=False).returncode != 0:
        sys.exit("the documentation has warnings")
    faults = check.faults(output / "html", list(python_reference.public_objects()))
    if faults:
        sys.exit("the documentation has faults:\n" + "\n".join(faults))
    print(output / "html" / "index.html")


if __name__ == "__main__":
    main()
