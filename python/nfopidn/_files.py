"""Files that the commands are given, and that they write."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

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
        rival = json.loads(Path(path).read_text(encoding="utf-8"))["format"] == "nfopidn-rival"
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        rival = False  # Controller.load says what is wrong
    return Rival.load(path) if rival else Controller.load(path)


def check_picture(path: str | None) -> None:
    """Refuse a picture's name that matplotlib has no format for, before any work."""
    if path is None:
        return
    from matplotlib.backend_bases import FigureCanvasBase

    known = FigureCanvasBase.get_supported_filetypes()
    if Path(path).suffix[1:].lower() not in known:
        raise ValueError(f"--plot {path}: must end in one of {', '.join(sorted(known))}")


def _resolved(path: Path) -> Path:
    """Give the file that a link points to, which is replaced in place of the link."""
    try:
        return path.resolve()
    except RuntimeError:  # before Python 3.13
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), os.fspath(path)) from None


def _draft_name(target: Path) -> Path:
    return target.with_name(f"{target.name}.part{os.getpid()}")


def _try_to_write(path: Path) -> None:
    """Raise OSError for a name that draft_of() could not write."""
    descriptor = _core.descriptor_of(os.fsencode(path))
    if descriptor >= 0:
        if fcntl.fcntl(descriptor, fcntl.F_GETFL) & os.O_ACCMODE == os.O_RDONLY:
            raise OSError(errno.EBADF, os.strerror(errno.EBADF))
        return
    if path.is_dir():
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
    if path.exists() and not os.access(path, os.W_OK):
        raise OSError(errno.EACCES, os.strerror(errno.EACCES))
    if path.is_file() or not path.exists():
        draft = _draft_name(_resolved(path))
        draft.touch()
        draft.unlink()


def check_outputs(outputs: Mapping[str, str | None], inputs: Sequence[str] = ()) -> None:
    """Refuse names that cannot be written, and one name given twice; by option, before any work."""
    taken = {Path(name).resolve(): "the input" for name in inputs if Path(name).is_file()}
    for option, name in outputs.items():
        if name is None:
            continue
        path = Path(name)
        try:
            _try_to_write(path)
        except OSError as error:
            raise ValueError(f"{option} {name}: cannot be written: {error.strerror}") from None
        if path.resolve() in taken:
            raise ValueError(f"{option} {name}: is the file of {taken[path.resolve()]} too")
        if not path.exists() or path.is_file():
            taken[path.resolve()] = option


@contextmanager
def draft_of(path: str | PathLike[str]) -> Iterator[Path]:
    """Give a draft to write, which takes the file's place at the end: whole or not at all."""
    target = Path(path)
    descriptor = _core.descriptor_of(os.fsencode(path))
    if descriptor >= 0:
        with _draft_for(descriptor) as draft:
            yield draft
        return
    if target.exists() and not target.is_file():  # a pipe: written directly
        yield target
        return
    target = _resolved(target)
    draft = _draft_name(target)
    try:
        yield draft
        with draft.open("rb") as written:
            os.fsync(written.fileno())
        if target.exists():
            shutil.copymode(target, draft)
        draft.replace(target)
    finally:
        draft.unlink(missing_ok=True)


@contextmanager
def _draft_for(descriptor: int) -> Iterator[Path]:
    """Give a draft that ends up in an open file, a log perhaps, after what is there."""
    with tempfile.TemporaryDirectory() as folder:
        draft = Path(folder) / "draft"
        yield draft
        if sys.stdout is not None:
            sys.stdout.flush()
        with os.fdopen(os.dup(descriptor), "wb") as stream:
            stream.write(draft.read_bytes())


def replace_file(path: str | PathLike[str], text: str) -> None:
    """Write a file whole or not at all."""
    with draft_of(path) as draft:
        try:
            draft.write_text(text, encoding="utf-8")
        except OSError as error:  # a write that fails names no file
            raise OSError(error.errno, error.strerror, os.fspath(path)) from None


@contextmanager
def kept(faults: list[OSError | ValueError]) -> Iterator[None]:
    """Keep what one of several files is refused for: the others are written all the same."""
    try:
        yield
    except (OSError, ValueError) as error:  # the core raises the latter
        faults.append(error)


def save_picture(figure: Figure, path: str) -> None:
    """Save a figure whole or not at all, in the format that the name's end asks for."""
    with draft_of(path) as draft:
        figure.savefig(draft, format=Path(path).suffix[1:].lower())
