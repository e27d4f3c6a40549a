"""What a report is made of: a tuning result, from memory or from a file, looked through."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Real
from os import PathLike
from pathlib import Path
from typing import Any

from nfopidn.tuning.result import TuneResult, check_names

#: Fields that a page shows, and what they must be; those of the second group may be missing.
_NEEDED: Mapping[str, tuple[type, str]] = {
    "fun": (Real, "a number"),
    "nfev": (Real, "a number"),
    "seed": (Real, "a number"),
    "message": (str, "a text"),
    "parameters": (list, "a list of names"),
}
_OPTIONAL: Mapping[str, tuple[type | tuple[type, ...], str]] = {
    "elapsed": (Real, "a number"),
    "method": (str, "a text"),
    "structure": ((str, Mapping), "a name or settings"),
    "options": (Mapping, "settings"),
}


def read(result: TuneResult | str | PathLike[str]) -> TuneResult:
    """Return a tuning result whose fields are what a page needs.

    Raises
    ------
    ValueError
        If it is none; names the field, and the file if there is one.
    OSError
        If the file cannot be read.
    """
    if isinstance(result, TuneResult):
        _check(result, "result")
        return result
    if not isinstance(result, str | PathLike):
        raise ValueError(
            f"result is a {type(result).__name__}; must be a TuneResult or the path of one's file"
        )
    try:
        found = TuneResult.from_json(result)
    except RecursionError:
        raise ValueError(f"{result}: not a tuning result: nested too deeply") from None
    _check(found, f"{result}: not a tuning result")
    return found


def refuse_same_file(result: object, path: str | PathLike[str]) -> None:
    """Refuse to write a page over the result that it is made of.

    Raises
    ------
    ValueError
        If both are one file.
    """
    if not isinstance(result, str | PathLike):
        return
    source, target = Path(result), Path(path)
    if source.exists() and target.exists() and source.samefile(target):
        raise ValueError(f"{target}: is the result itself; name another file for the page")


def _check(result: Mapping[str, Any], where: str) -> None:
    for key in ("scenario", "controller", "history", "x", *_NEEDED):
        if key not in result:
            raise ValueError(f"{where}: has no {key}")
    for key, (kind, words) in {**_NEEDED, **_OPTIONAL}.items():
        if key in result and not isinstance(result[key], kind):
            raise ValueError(f"{where}: {key} must be {words}")
    try:
        check_names(result["parameters"], result["x"])
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
