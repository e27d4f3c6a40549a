"""Verdicts in controller files."""

from __future__ import annotations

import json
from os import PathLike

from nfopidn import _core
from nfopidn._core import Controller, Rival
from nfopidn.files import replace_file
from nfopidn.robustness.verdict import Verdict


def save_with_verdict(
    controller: Controller | Rival, path: str | PathLike[str], verdict: Verdict
) -> None:
    """Write a controller file, or a rival file, that carries its verdict.

    Controller.load() reads it as any other.
    """
    document = json.loads(controller.to_json())
    document["verdict"] = verdict.to_dict()
    try:
        replace_file(path, json.dumps(document, indent=2, allow_nan=False) + "\n")
    except OSError as error:
        raise ValueError(f"{path}: cannot be written: {error.strerror}") from None


def read_verdict(path: str | PathLike[str]) -> Verdict | None:
    """Read the verdict that a controller file carries; None if it has none.

    Raises
    ------
    ValueError
        Names the file: not a document, or its verdict is none.
    """
    try:
        document = json.loads(_core.read_text(path))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path}: {error}") from None
    if not isinstance(document, dict) or document.get("verdict") is None:
        return None
    try:
        return Verdict.from_dict(document["verdict"])
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
