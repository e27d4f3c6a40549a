"""MuJoCo itself: loaded when it is wanted, and kept from writing into the user's folder."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Any


def load() -> Any:
    """Import MuJoCo.

    Raises
    ------
    ImportError
        It is not installed; says how it is.
    """
    try:
        import mujoco
    except ImportError as error:
        raise ImportError(
            "nfopidn.mujoco needs MuJoCo 4 (the package mujoco-core): "
            'pip install "nfopidn[physics]"'
        ) from error
    version = str(mujoco.__version__)
    if int(version.split(".", maxsplit=1)[0]) < 4:
        raise ImportError(
            f'nfopidn.mujoco needs MuJoCo 4 and found {version}: pip install "nfopidn[physics]"'
        )
    return mujoco


class _Handler:
    """Counts who wants MuJoCo quiet: its handler of warnings is one for the whole process."""

    def __init__(self) -> None:
        self.lock = Lock()
        self.users = 0
        self.before: Any = None

    def enter(self, mujoco: Any) -> None:
        with self.lock:
            if self.users == 0:
                self.before = mujoco.get_mju_user_warning()
                mujoco.set_mju_user_warning(_ignore)
            self.users += 1

    def leave(self, mujoco: Any) -> None:
        with self.lock:
            self.users -= 1
            if self.users == 0:
                mujoco.set_mju_user_warning(self.before)


_HANDLER = _Handler()


@contextmanager
def quiet_warnings() -> Iterator[None]:
    """Keep MuJoCo from printing its warnings and from writing them to MUJOCO_LOG.TXT.

    They are counted in mjData.warning all the same, where a run looks for them. The handler of
    before comes back once the last run of the process is over.
    """
    mujoco = load()
    _HANDLER.enter(mujoco)
    try:
        yield
    finally:
        _HANDLER.leave(mujoco)


def _ignore(_message: str) -> None:
    """Take a warning that is counted elsewhere."""
