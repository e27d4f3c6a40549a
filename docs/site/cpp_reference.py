"""Run Doxygen over the public headers, and write a page for each, a list for each folder."""

import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

SITE = Path(__file__).resolve().parent
INCLUDE = "cpp/include"
SECTIONS = (  # of Doxygen's: what is public
    "briefdescription detaileddescription innernamespace innerclass define enum func var typedef "
    "public-type public-func public-attrib public-static-func public-static-attrib"
)


def headers(repository: Path) -> list[Path]:
    """Return the public headers, relative to the folder of includes."""
    root = repository / INCLUDE
    return sorted(path.relative_to(root) for path in root.rglob("*.hpp"))


def summary(source: str) -> str:
    """Return the first sentence of the comment at the top of a header, without its layer."""
    block = re.match(r"(?://[^\n]*\n)+", source)
    text = " ".join(re.findall(r"// ?(.*)", block[0])) if block else ""
    text = re.sub(r"^L\d\.\s+", "", text)
    return re.split(r"(?<=[.:])\s", text, maxsplit=1)[0].rstrip(":")


def macros(sources: list[str]) -> list[str]:
    """Return how Doxygen expands the macros of attributes: to `inline` or to nothing."""
    found: dict[str, str] = {}
    for source in sources:
        for name, value in re.findall(r"#define (NFOPIDN_\w+)[ \t]+([^\n]*)", source):
            if "[[" in value or "__attribute__" in value or value.strip() == "inline":
                found[name] = "inline" if re.search(r"\binline\b", value) else ""
    return sorted(f"{name}={value}" for name, value in found.items())


def doxyfile(repository: Path, output: Path, version: str) -> str:
    """Return Doxygen's settings."""
    root = repository / INCLUDE
    sources = [(root / path).read_text() for path in headers(repository)]
    python = Path(sys.executable).as_posix()
    settings: dict[str, str | list[str]] = {
        "PROJECT_NAME": "nfopidn",
        "PROJECT_NUMBER": version,
        "OUTPUT_DIRECTORY": str(output),
        "INPUT": str(root),
        "RECURSIVE": "YES",
        "FILE_PATTERNS": "*.hpp",
        "STRIP_FROM_PATH": str(root),
        "STRIP_FROM_INC_PATH": str(root),
        "INPUT_FILTER": f"{python} {SITE / 'comment_filter.py'}",
        "FILTER_SOURCE_FILES": "YES",
        "EXTRACT_ALL": "YES",
        "EXCLUDE_SYMBOLS": ["detail", "*::detail", "*::detail::*"],
        "JAVADOC_AUTOBRIEF": "NO",
        "MARKDOWN_SUPPORT": "NO",  # comments are plain text
        "AUTOLINK_SUPPORT": "NO",
        "ENABLE_PREPROCESSING": "YES",
        "MACRO_EXPANSION": "YES",
        "EXPAND_ONLY_PREDEF": "YES",
        "PREDEFINED": [*macros(sources), "__restrict="],  # Sphinx does not know the word
        "SORT_MEMBER_DOCS": "NO",
        "GENERATE_HTML": "NO",
        "GENERATE_LATEX": "NO",
        "GENERATE_XML": "YES",
        "XML_PROGRAMLISTING": "NO",
        "QUIET": "YES",
        "WARN_IF_UNDOCUMENTED": "NO",
        "WARN_IF_DOC_ERROR": "YES",
        "WARN_AS_ERROR": "FAIL_ON_WARNINGS",
    }

    def text(value: str | list[str]) -> str:
        words = [value] if isinstance(value, str) else value
        return " ".join(f'"{word}"' if re.search(r"[\s=]", word) else word for word in words)

    return "".join(f"{name} = {text(value)}\n" for name, value in settings.items())


def run_doxygen(repository: Path, output: Path, version: str) -> Path:
    """Write the XML that Breathe reads; return its folder. Doxygen's warnings are errors."""
    output.mkdir(parents=True, exist_ok=True)
    file = output / "Doxyfile"
    file.write_text(doxyfile(repository, output, version))
    run = subprocess.run(["doxygen", str(file)], capture_output=True, text=True, check=False)
    if run.returncode != 0:
        sys.exit(f"doxygen failed:\n{run.stdout}{run.stderr}")
    name_files_by_path(output / "xml")
    return output / "xml"


def name_files_by_path(xml: Path) -> None:
    """Give the files their paths in Doxygen's index, which has bare names: Breathe looks there."""
    index = ElementTree.parse(xml / "index.xml")
    for compound in index.iterfind("compound[@kind='file']"):
        own = ElementTree.parse(xml / f"{compound.get('refid')}.xml")
        (location,) = own.iterfind("compounddef/location")
        (name,) = compound.iterfind("name")
        name.text = location.get("file")
    index.write(xml / "index.xml", encoding="utf-8", xml_declaration=True)


def page_name(header: Path) -> str:
    """Return the page of a header, relative to the C++ reference."""
    return header.relative_to("nfopidn").with_suffix("").as_posix()


def pages(repository: Path) -> dict[str, str]:
    """Return the reference's pages by name: the index, and one for each header."""
    root = repository / INCLUDE
    folders: dict[str, list[tuple[str, str, Path]]] = {}
    found: dict[str, str] = {}
    for header in headers(repository):
        name = page_name(header)
        told = summary((root / header).read_text())
        folder = header.parent.relative_to("nfopidn").as_posix()
        folders.setdefault("" if folder == "." else folder, []).append((name, told, header))
        found[f"cpp/{name}.rst"] = header_page(header, name)
    found["cpp/index.rst"] = index_page(folders)
    return found


def header_page(header: Path, name: str) -> str:
    """Return the page of a header. It does not stand in the sidebar, which would be too long."""
    title = header.relative_to("nfopidn").as_posix()
    source = f"{'../' * (name.count('/') + 1)}source/{INCLUDE}/{header.as_posix()}"
    return f""":orphan:

{title}
{"=" * len(title)}

:doc:`C++ reference </cpp/index>` · ``#include "{header.as_posix()}"`` ·
:doc:`source <{source}>`

.. doxygenfile:: {header.as_posix()}
   :project: nfopidn
   :sections: {SECTIONS}
"""


def index_page(folders: dict[str, list[tuple[str, str, Path]]]) -> str:
    """Return the list of all headers."""
    lines = [
        "C++ reference",
        "=============",
        "",
        "The public headers, folder by folder. Names in ``detail`` are left out. A firmware needs",
        ":doc:`firmware.hpp <firmware>` alone; :doc:`/embedding` tells more.",
        "",
    ]
    for folder, rows in sorted(folders.items()):
        title = f"nfopidn/{folder}" if folder else "nfopidn"
        lines += [title, "-" * len(title), "", ".. list-table::", "   :widths: 35 65", ""]
        for name, told, header in rows:
            lines += [f"   * - :doc:`{header.name} <{name}>`", f"     - {rst_text(told)}"]
        lines += [""]
    return "\n".join(lines)


def rst_text(text: str) -> str:
    """Return plain text in which reStructuredText finds no markup; `code` becomes code."""
    parts = re.split(r"`([^`]+)`", text)
    plain = [re.sub(r"([\\*|_`])", r"\\\1", part) for part in parts[::2]]
    code = [f"``{part}``" for part in parts[1::2]]
    return "".join(a + b for a, b in zip(plain, [*code, ""], strict=True))
