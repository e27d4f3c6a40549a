"""A checkpoint has one search at a time."""

import os
import subprocess
import sys
import threading
import time

import nfopidn
import pytest
from refusal import refused
from results import same

BOX = [(-2.0, 3.0), (0.0, 1.0)]
OTHER = """
import sys, nfopidn
def func(x):
    print("begun", flush=True)
    sys.stdin.readline()
    return 0.5
nfopidn.bfoa(func, [(-2.0, 3.0), (0.0, 1.0)], rng=1, maxfev=600, checkpoint=sys.argv[1])
"""


def bowl(x):
    return float(((x - 0.25) ** 2).sum())


def search(path, func=bowl, **arguments):
    return nfopidn.bfoa(func, BOX, **({"rng": 1, "maxfev": 600, "checkpoint": path} | arguments))


@pytest.fixture
def path(tmp_path):
    return tmp_path / "search.checkpoint"


def test_two_processes_do_not_share_a_checkpoint(path):
    command = [sys.executable, "-c", OTHER, str(path)]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **pipes) as process:
        try:
            assert process.stdout.readline() == "begun\n"
            with refused("checkpoint", str(path), f"is in use by process {process.pid}"):
                search(path)
            search(path.with_name("other"))
        finally:
            process.kill()
    # A killed one holds it no more.
    same(search(path), search(None))
    assert sorted(os.listdir(path.parent)) == ["other", path.name]


def test_two_threads_do_not_share_a_checkpoint(path):
    begun, done = threading.Event(), threading.Event()

    def slow(x):
        begun.set()
        assert done.wait(60)
        return bowl(x)

    thread = threading.Thread(target=search, args=(path, slow))
    thread.start()
    try:
        assert begun.wait(60)
        folder = path.with_name("folder")
        folder.symlink_to(path.parent)
        for name in (path, folder / path.name):
            with refused("checkpoint", "is in use by another thread"):
                search(name)
    finally:
        done.set()
        thread.join()
    same(search(path), search(None))


def test_the_processes_of_a_search_do_not_hold_its_checkpoint(path):
    """A fork has the parent's files, but not its lock."""

    read, write = os.pipe()
    child = os.fork()
    if child == 0:

        def fork_and_end(x):
            grandchild = os.fork()
            if grandchild == 0:
                time.sleep(100)
            os.write(write, f"{grandchild}\n".encode())
            os._exit(0)

        search(path, fork_and_end)
        os._exit(1)
    os.waitpid(child, 0)
    grandchild = int(os.read(read, 100))
    try:
        same(search(path), search(None))
    finally:
        os.kill(grandchild, 9)
