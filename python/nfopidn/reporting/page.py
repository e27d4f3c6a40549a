"""The page: its template filled in, and written."""

from __future__ import annotations

from importlib.resources import files
from os import PathLike
from pathlib import Path

from nfopidn._core import __version__
from nfopidn.files import replace_file
from nfopidn.reporting.content import gather
from nfopidn.reporting.numbers import readable, script_json
from nfopidn.tuning.result import TuneResult


def _resource(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def page(result: TuneResult) -> str:
    """Return the page of a tuning result.

    Raises
    ------
    ImportError
        If Jinja2 or Plotly is not installed.
    """
    try:
        from jinja2 import Environment, StrictUndefined
        from markupsafe import Markup
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise ImportError(
            "a report needs Jinja2 and Plotly: pip install 'nfopidn[report]'"
        ) from None
    content = gather(result)
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["readable"] = readable
    # What is marked as safe are the package's own files, Plotly's, and JSON made safe.
    return environment.from_string(_resource("page.html")).render(
        page=content,
        version=__version__,
        style=Markup(_resource("page.css")),
        plotly=Markup(get_plotlyjs()),
        data=Markup(script_json(content.data())),
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
