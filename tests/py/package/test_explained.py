"""What tests/mutants.txt and tests/uncovered.txt explain stands in the core as they quote it."""

import importlib.util

import pytest


@pytest.mark.parametrize(("file", "arrow"), [("mutants.txt", " -> "), ("uncovered.txt", None)])
def test_every_explained_line_is_there(file, arrow, repository):
    """A line that has changed since is one that nothing explains."""
    spec = importlib.util.spec_from_file_location("explained", repository / "tests/explained.py")
    explained = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(explained)
    reasons = explained.read(repository / "tests" / file)
    assert reasons
    gone = []
    for name, reason in reasons.items():
        assert reason, name
        header, _, line = name.partition(": ")
        line = line.partition(arrow)[0] if arrow else line
        code = (repository / "cpp/include/nfopidn" / header).read_text().splitlines()
        if line not in [one.strip() for one in code]:
            gone.append(name)
    assert not gone
