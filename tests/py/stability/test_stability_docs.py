"""The examples of nfopidn.stability's docstrings and of docs/stability.md."""

import doctest
import runpy
import sys
from importlib import import_module

import pytest


@pytest.mark.parametrize("name", ["attraction", "closed_loop", "loop_margins", "pole_map"])
def test_docstrings(name):
    failed, run = doctest.testmod(import_module(f"nfopidn.stability.{name}"))
    assert run > 0
    assert failed == 0


def test_document(repository):
    failed, run = doctest.testfile(str(repository / "docs" / "stability.md"), module_relative=False)
    assert run > 10
    assert failed == 0


def test_example(repository, tmp_path, monkeypatch, capsys):
    picture = tmp_path / "stability.png"
    monkeypatch.setattr(sys, "argv", ["stability.py", str(picture)])
    runpy.run_path(str(repository / "examples" / "stability.py"))
    assert picture.stat().st_size > 50_000
    assert "lap of 25 s: unstable; simulation diverges at 19.4 s" in capsys.readouterr().out
