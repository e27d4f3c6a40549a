"""`nfopidn tune` with --objectives and --constraint: what it writes, and what it refuses."""

import csv
import json
import os
import signal

import nfopidn
import pytest
from nfopidn import Controller, ParetoResult, Scenario, TuneResult, commands
from nfopidn.robustness import read_verdict

WORDS = ("--nominal", "--structure", "decoupled", "--seed", "3", "--scenario", "s.json")
FRONT = (*WORDS, "--maxfev", "300", "--objectives", "position_rms,torque_variation")
SHORT = Scenario.published(period=100.0, rng=0)


@pytest.fixture
def cli(tmp_path, monkeypatch, capsys):
    """Run it within this process: exit code, standard output, standard error."""
    monkeypatch.chdir(tmp_path)
    SHORT.save("s.json")

    def run(*words):
        try:
            code = commands.main(["tune", *map(str, words)])
        except SystemExit as end:  # of argparse
            code = end.code
        return (code, *capsys.readouterr())

    return run


def test_the_front_and_its_knee_are_written(cli):
    code, out, _ = cli(*FRONT, "--population", 30, "--result", "f.json", "--front", "f.csv")
    assert code == 0
    front = ParetoResult.from_json("f.json")
    same = nfopidn.tune(
        SHORT,
        robustness=None,
        structure="decoupled",
        rng=3,
        maxfev=300,
        population=30,
        objectives=("position_rms", "torque_variation"),
    )
    assert front.objectives.tolist() == same.objectives.tolist()
    knee = front.choose()
    assert Controller.load("controller.json") == front.controllers[knee]
    verdict = read_verdict("controller.json")
    assert verdict.line == front.verdict(knee).line
    assert f"knee: {verdict.line}" in out
    with open("f.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["torque_variation"]) for row in rows] == front.objectives[:, 1].tolist()
    assert "(knee)" in out
    assert "written: controller.json" in out


def test_the_front_is_drawn(cli, tmp_path):
    three = "position_rms,heading_rms,torque_variation"
    for place, words in enumerate((FRONT, (*FRONT[:-1], three))):
        code, out, _ = cli(*words, "--plot", f"{place}.png", "--quiet")
        assert (code, out) == (0, "")
        assert (tmp_path / f"{place}.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("--objectives", "position_rms"), "has 1 names"),
        (("--objectives", "position_rms,torque_peek"), "did you mean 'torque_peak'?"),
        (("--objectives", "cost,energy", "--population", "3"), "population is 3"),
        (("--objectives", "cost,energy", "--constraint", "energy=:1"), "with objectives"),
        (("--front", "f.csv"), "give --objectives too"),
        (("--constraint", "energy"), "must be NAME=LOW:HIGH"),
        (("--constraint", "energy=1"), "must be NAME=LOW:HIGH"),
        (("--constraint", "energy=a:b"), "a:b is no pair of numbers"),
        (("--constraint", "energy=:1", "--constraint", "energy=:2"), "energy is given twice"),
        (("--constraint", "enegry=:1"), "did you mean 'energy'?"),
        (("--constraint", "energy=:"), "must limit something"),
    ],
)
def test_what_does_not_fit_is_refused(words, text, cli, tmp_path):
    code, out, error = cli(*WORDS, *words)
    assert (code, out) == (2, "")
    assert text in error
    assert error.count("\n") == 1
    assert not (tmp_path / "controller.json").exists()


def test_a_front_that_cannot_be_written_shows_before_the_search(cli):
    code, _, error = cli(*FRONT, "--front", "nowhere/f.csv")
    assert code == 2
    assert "--front" in error


def test_a_constraint_is_kept_and_told(cli):
    code, out, _ = cli(
        *WORDS, "--maxfev", 600, "--constraint", "torque_variation=:33", "--result", "r.json"
    )
    assert code == 0
    result = TuneResult.from_json("r.json")
    row = result.constraints["torque_variation"]
    run = nfopidn.simulate(SHORT, Controller.load("controller.json"))
    assert row["value"] == run.metrics["torque_variation"] <= 33.0
    assert f"torque_variation {row['value']:.6g} N m: met" in out


def test_a_constraint_that_is_broken_exits_with_3(cli, tmp_path):
    code, out, error = cli(*WORDS, "--maxfev", 200, "--constraint", "position_rms=:1e-6")
    assert code == 3
    assert "must be at most 1e-06 m" in error
    assert "position_rms" in out
    assert "NOT met" in out
    assert json.loads((tmp_path / "controller.json").read_text())["format"]


def test_ctrl_c_writes_the_front_so_far(cli, monkeypatch):
    measured = nfopidn.tuning.pareto.Measured.of
    blocks = []

    def third(self, points):
        blocks.append(len(points))
        if len(blocks) == 3:
            os.kill(os.getpid(), signal.SIGINT)
        return measured(self, points)

    monkeypatch.setattr(nfopidn.tuning.pareto.Measured, "of", third)
    code, out, _ = cli(*FRONT, "--population", 20, "--result", "f.json")
    assert code == 130
    front = ParetoResult.from_json("f.json")
    assert front.nit in (2, 3)
    assert not front.success
    assert "interrupted" in out
    assert Controller.load("controller.json") in front.controllers
