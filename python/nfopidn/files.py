"""Files that the commands are given, and that they write."""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nfopidn import _core
from nfopidn._core import Controller, Rival

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def load_controller(path: str) -> Controller | Rival:
    """Read a controller file or a rival file.

    Raises
    ------
    ValueError
        Names the file, and what in it is not as it must be.
    """
    try:
        rival = json.loads(_core.read_text(path))["format"] == "nfopidn-rival"
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        rival = False  # Controller.load says what is wrong
    return Rival.load(path) if rival else load_nfopidn(path)


def load_nfopidn(path: str) -> Controller:
    """Read a controller file, and say if it does not carry its sample time."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # said below, for every file
        controller = Controller.load(path)
    if controller.sample_time is None:
        print(
            f"nfopidn: {path} does not carry its sample time; the controller is taken to be made "
            "for the scenario's",
            file=sys.stderr,
        )
    return controller


def check_picture(path: str | None) -> None:
    """Refuse a picture's name that matplotlib has no format for, before any work."""
    if path is None:
        return
    from matplotlib.backend_bases import FigureCanvasBase

    known = FigureCanvasBase.get_supported_filetypes()
    if Path(path).suffix[1:].lower() not in known:
        raise ValueError(f"--plot {path}: must end in one of {', '.join(sorted(known))}")


def check_outputs(outputs: Mapping[str, str | None], inputs: Sequence[str] = ()) -> None:
    """Refuse names that cannot be written, and one name given twice; by option, before any work."""
    taken = {Path(name).resolve(): "the input" for name in inputs if Path(name).is_file()}
    for option, name in outputs.items():
        if name is None:
            continue
        path = Path(name)
        try:
            _core.check_writable(name)
        except OSError as error:
            raise ValueError(f"{option} {name}: cannot be written: {error.strerror}") from None
        if path.resolve() in taken:
            raise ValueError(f"{option} {name}: is the file of {taken[path.resolve()]} too")
        if not path.exists() or path.is_file():
            taken[path.resolve()] = option


def replace_file(path: str | PathLike[str], content: str | bytes) -> None:
    """Write a file atomically; to a stream, such as /dev/stdout, the text is appended."""
    if sys.stdout is not None:
        sys.stdout.flush()
    _core.write_file(path, content.encode() if isinstance(content, str) else content)


@contextmanager
def collect_fault(faults: list[OSError | ValueError]) -> Iterator[None]:
    """Keep what one of several files is refused for: the others are written all the same."""
    try:
        yield
    except (OSError, ValueError) as error:  # the core raises the latter
        faults.append(error)


def raise_kept(faults: list[OSError | ValueError]) -> None:
    """Raise the faults that were collected, if there are any.

    Raises
    ------
    OSError, ValueError
        The one, or, of several, a ValueError that names them all.
    """
    if len(faults) == 1:
        raise faults[0]
    if faults:
        raise ValueError("; ".join(map(str, faults)))


def save_picture(figure: Figure, path: str | PathLike[str], **settings: Any) -> None:
    """Save a figure atomically, in the format that the name's suffix asks for."""
    picture = BytesIO()
    figure.savefig(picture, format=Path(path).suffix[1:].lower(), **settings)
    replace_file(path, picture.getvalue())
