"""A disk that is full for a moment loses nothing of a search."""

import json
import os
import resource
import time

import nfopidn
import pytest
from results import same

BOX = [(-2.0, 3.0), (0.0, 1.0)]


def bowl(x):
    return float(((x - 0.25) ** 2).sum())


def search(path, func=bowl, **arguments):
    return nfopidn.bfoa(func, BOX, **({"rng": 1, "maxfev": 600, "checkpoint": path} | arguments))


@pytest.fixture
def path(tmp_path):
    return tmp_path / "search.checkpoint"


class FullDisk:
    """A cost function during which files may hold nothing for a while.

    Python ignores the signal, so that writing more fails as on a full disk.
    """

    def __init__(self, path, ends):
        self.path, self.ends = path, ends
        self.full = self.begun = None
        self.soft, self.hard = resource.getrlimit(resource.RLIMIT_FSIZE)

    def __call__(self, x):
        time.sleep(0.005)
        now = time.monotonic()
        if self.begun is None and self.path.exists():
            self.begun = now
            resource.setrlimit(resource.RLIMIT_FSIZE, (10, self.hard))
        if self.ends and self.begun is not None and now > self.begun + 0.8:
            self.restore()
        return bowl(x)

    def restore(self):
        resource.setrlimit(resource.RLIMIT_FSIZE, (self.soft, self.hard))


def test_a_search_outlives_a_disk_that_is_full_for_a_moment(path):
    func = FullDisk(path, ends=True)
    try:
        with pytest.warns(RuntimeWarning, match="cannot be written: File too large; the search"):
            result = search(path, func)
    finally:
        func.restore()
    whole = search(None)
    same(result, whole)
    assert len(json.loads(path.read_text())["record"]) == 600
    assert sorted(os.listdir(path.parent)) == [path.name, path.name + ".previous"]


def test_a_disk_that_stays_full_is_told_with_the_result(path):
    func = FullDisk(path, ends=False)
    try:
        with (
            pytest.warns(RuntimeWarning, match="the search goes on, and tries again"),
            pytest.raises(ValueError, match="cannot be written: File too large") as caught,
        ):
            search(path, func)
    finally:
        func.restore()
    assert caught.value.best.fun == search(None).fun
    assert 0 < len(json.loads(path.read_text())["record"]) < 600  # the last good state
    same(search(path), search(None))


def test_a_warning_that_is_an_error_ends_the_search(path):
    func = FullDisk(path, ends=False)
    try:
        with pytest.raises(RuntimeWarning, match="cannot be written") as caught:  # pytest's setting
            search(path, func)
    finally:
        func.restore()
    assert caught.value.best.nfev < 600
