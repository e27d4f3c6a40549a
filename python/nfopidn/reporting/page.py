"""The page: its template filled in, and written."""

from __future__ import annotations

import base64
import gzip
import json
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Any, Literal

from nfopidn._core import __version__
from nfopidn.files import replace_file
from nfopidn.reporting.content import gather
from nfopidn.reporting.numbers import readable
from nfopidn.reporting.strokes import style_sheet
from nfopidn.tuning.result import TuneResult

#: The figures, and the classes of its interface; widgets, tables and WebGL are left out.
_BOKEH: list[Literal["bokeh", "bokeh-api"]] = ["bokeh", "bokeh-api"]


def _resource(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def packed(text: str) -> str:
    """Pack a text for a page, which unpacks it: gzip, in base 64.

    The same text packs alike, and nothing in it can end the element that it stands in.
    """
    return base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode("ascii")


def packed_json(document: Any) -> str:
    """Pack a document for a page; a number that JSON does not have is refused (ValueError)."""
    return packed(json.dumps(document, separators=(",", ":"), allow_nan=False))


def bokeh_script() -> str:
    """Return what draws the figures."""
    from bokeh.resources import Resources

    # One script a component; a last one, which sets the level of the log, would write to the log.
    scripts = Resources(mode="inline", components=list(_BOKEH)).js_raw[: len(_BOKEH)]
    return "\n".join(scripts)


def page(result: TuneResult) -> str:
    """Return the page of a tuning result.

    Raises
    ------
    ImportError
        If Bokeh is not installed.
    """
    try:
        from jinja2 import Environment, StrictUndefined
        from markupsafe import Markup

        script = bokeh_script()
    except ImportError:
        raise ImportError("a report needs Bokeh: pip install 'nfopidn[report]'") from None
    content = gather(result)
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["readable"] = readable
    # What is marked as safe are the package's own files, and what is in base 64.
    return environment.from_string(_resource("page.html")).render(
        page=content,
        version=__version__,
        colours=Markup(style_sheet()),
        style=Markup(_resource("page.css")),
        bokeh=Markup(packed(script)),
        figures=Markup(_resource("figures.js")),
        data=Markup(packed_json(content.data())),
        script=Markup(_resource("page.js")),
    )


def write_page(path: str | PathLike[str], text: str) -> Path:
    """Write a page atomically: all of it, or nothing.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    target = Path(path)
    if target.exists() and not target.is_file():
        raise OSError(f"{target}: is no regular file; name one to write the page to")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"{target}: No such directory: {target.parent}")
    replace_file(target, text)
    return target
