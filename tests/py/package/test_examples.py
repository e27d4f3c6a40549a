"""Every example runs, in a folder of its own, and writes what it says."""

import runpy
import sys

import pytest
from conftest import REPOSITORY

EXAMPLES = sorted(path.name for path in (REPOSITORY / "examples").glob("*.py"))


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_runs(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [name])
    runpy.run_path(str(REPOSITORY / "examples" / name), run_name="__main__")
    written = list(tmp_path.iterdir())
    assert capsys.readouterr().out or written
    assert all(path.stat().st_size > 0 for path in written)
