"""Check the built pages: nothing comes by the network, links lead somewhere, all names are there.

python docs/site/check.py build/docs/html
"""

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {
    "audio": ("src",),
    "embed": ("src",),
    "iframe": ("src",),
    "img": ("src", "srcset"),
    "input": ("src",),
    "object": ("data",),
    "script": ("src",),
    "source": ("src", "srcset"),
    "track": ("src",),
    "video": ("src", "poster"),
    "use": ("href", "xlink:href"),
    "image": ("href", "xlink:href"),
}
LOADING_LINKS = {"stylesheet", "icon", "preload", "modulepreload", "prefetch", "manifest"}
ELSEWHERE = re.compile(r"^(?:[a-z][a-z0-9+.-]*:)?//", re.IGNORECASE)
STYLE_LOADS = re.compile(r"(?:url\(\s*|@import\s+)[\"']?([^\"')\s;]+)", re.IGNORECASE)


class Page(HTMLParser):
    """What a page loads, links to and can be linked at."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.links: list[str] = []
        self.anchors: set[str] = {"", "top"}
        self.in_style = False
        self.feed(text)

    def handle_starttag(self, tag: str, pairs: list[tuple[str, str | None]]) -> None:
        """Take note of a tag."""
        attributes = {name: value or "" for name, value in pairs}
        self.anchors.update(attributes[name] for name in ("id", "name") if name in attributes)
        for name in LOADED.get(tag, ()):
            for part in attributes.get(name, "").split(","):
                self.loads += part.split()[:1]
        words = set(attributes.get("rel", "").lower().split())
        if tag == "link" and words & LOADING_LINKS:
            self.loads.append(attributes.get("href", ""))
        if tag == "a" and "href" in attributes:
            self.links.append(attributes["href"])
        self.loads += STYLE_LOADS.findall(attributes.get("style", ""))
        self.in_style = tag == "style"

    def handle_data(self, data: str) -> None:
        """Take note of what a style sheet in the page loads."""
        if self.in_style:
            self.loads += STYLE_LOADS.findall(data)


def loads_from_elsewhere(root: Path, pages: dict[Path, Page]) -> list[str]:
    """Return what pages and style sheets load by the network."""
    found = [
        f"{path.relative_to(root)} loads {load}"
        for path, page in pages.items()
        for load in page.loads
        if ELSEWHERE.match(load)
    ]
    for path in sorted(root.rglob("*.css")):
        for load in STYLE_LOADS.findall(path.read_text(errors="replace")):
            if ELSEWHERE.match(load):
                found.append(f"{path.relative_to(root)} loads {load}")
    return found


def broken_links(root: Path, pages: dict[Path, Page]) -> list[str]:
    """Return links and loads within the site that lead nowhere."""
    found = []
    for path, page in pages.items():
        for link in [*page.links, *page.loads]:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            name = unquote(parts.path)
            target = (path.parent / name).resolve() if name else path
            if not target.exists():
                found.append(f"{path.relative_to(root)} links to {link}")
            elif target in pages and unquote(parts.fragment) not in pages[target].anchors:
                found.append(f"{path.relative_to(root)}: no place {link}")
    return sorted(set(found))


def missing_names(pages: dict[Path, Page], names: list[str]) -> list[str]:
    """Return the public names that no page documents."""
    anchors = set().union(*(page.anchors for page in pages.values()))
    return [f"{name} has no entry" for name in names if name not in anchors]


def faults(root: Path, names: list[str]) -> list[str]:
    """Return all that is wrong with a built site."""
    root = root.resolve()
    pages = {path: Page(path.read_text()) for path in sorted(root.rglob("*.html"))}
    if root / "index.html" not in pages:
        return [f"no start page in {root}"]
    return [
        *loads_from_elsewhere(root, pages),
        *broken_links(root, pages),
        *missing_names(pages, names),
    ]


if __name__ == "__main__":
    found = faults(Path(sys.argv[1]), sys.argv[2:])
    print("\n".join(found) or "no faults")
    sys.exit(bool(found))
