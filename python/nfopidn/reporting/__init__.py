"""The report of a tuning: one page of HTML that opens without a network."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from nfopidn.tuning.result import TuneResult


def report(result: TuneResult | str | PathLike[str], path: str | PathLike[str]) -> Path:
    """Write what a tuning has found as one self-contained page of HTML.

    The page has the controller, the search, and for each scenario its settings, the simulated run
    with its metrics, the loop's stability and the basin of attraction, with interactive figures.
    It loads nothing from anywhere. The same result gives the same page.

    Parameters
    ----------
    result
        What `tune` has returned, or the path of a file that `TuneResult.to_json` or
        ``nfopidn tune --result`` has written.
    path
        The file to write. It is written atomically; one that exists is replaced.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ValueError
        If `result` is no tuning result, or a file of another kind or version, or is `path` itself.
    OSError
        If a file cannot be read or written.
    ImportError
        If Bokeh is not installed.
    """
    from nfopidn.reporting.page import page, write_page
    from nfopidn.reporting.source import read, refuse_same_file

    refuse_same_file(result, path)
    return write_page(path, page(read(result)))
