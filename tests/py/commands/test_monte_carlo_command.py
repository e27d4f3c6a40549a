"""`nfopidn monte-carlo`: what it tells and writes."""

import csv
import json
import os
import signal
import subprocess
import sys

import nfopidn
import pytest
from nfopidn.commands import monte_carlo as monte_carlo_command
from nfopidn.commands.entry import main
from nfopidn.montecarlo import Choice, LogNormal, Normal, Uniform, runs


@pytest.fixture
def files(tmp_path):
    controller, scenario = tmp_path / "controller.json", tmp_path / "scenario.json"
    nfopidn.Controller.recommended().save(controller)
    nfopidn.Scenario.published(pose_noise=(0.005, 0.005), rng=0).save(scenario)
    return [str(controller), "--scenario", str(scenario)]


DRAW = ["--draw", "mass=normal:11.5:0.5"]


def expected(files, n, **changes):
    return nfopidn.monte_carlo(
        nfopidn.Scenario.load(files[2]),
        nfopidn.Controller.load(files[0]),
        n,
        rng=3,
        distributions={"mass": Normal(11.5, 0.5)},
        **changes,
    )


def test_json_tells_what_the_result_does(files, capsys):
    words = ["monte-carlo", *files, *DRAW, "-n", "200", "--seed", "3", "--limit", "cost=0.033"]
    assert main([*words, "--interval", "clopper-pearson", "--workers", "2", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    result = expected(files, 200)
    assert told["runs"] == 200
    assert list(told["quantiles"].values()) == result.quantiles((0.05, 0.5, 0.95, 1)).tolist()
    found = result.yield_({"cost": 0.033}, interval="clopper-pearson")
    assert (told["yield"]["low"], told["yield"]["high"]) == (found.low, found.high)
    assert told["worst"][0]["run"] == result.worst(1)[0]
    assert told["rank_correlations"]["mass"] == result.sensitivity().correlations[0]


def test_text_and_files(files, tmp_path, capsys):
    table, picture = tmp_path / "runs.csv", tmp_path / "costs.png"
    words = ["monte-carlo", *files, *DRAW, "-n", "64", "--seed", "3", "--method", "sobol"]
    words += ["--csv", str(table), "--plot", str(picture), "--column", "energy"]
    assert main([*words, "--limit", "position_max=0.2"]) == 0
    text = capsys.readouterr().out
    assert "64 runs, seed 3, drawn: mass" in text
    assert "within limits: " in text
    result = expected(files, 64, method="sobol", columns=("energy", "position_max"))
    with table.open() as rows:
        read = list(csv.DictReader(rows))
    assert list(read[0]) == ["mass", "cost", "position_max", "energy"]
    assert [float(row["cost"]) for row in read] == result.costs.tolist()
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_other_distributions(files, capsys):
    words = ["--draw", "inertia=uniform:0.5:0.6", "--draw", "delay=choice:0:1"]
    words += ["--draw", "track_width=lognormal:0.45:0.01", "-n", "20", "--json"]
    assert main(["monte-carlo", *files, *words]) == 0
    told = json.loads(capsys.readouterr().out)
    drawn = {
        "inertia": Uniform(0.5, 0.6),
        "delay": Choice([0, 1]),
        "track_width": LogNormal(0.45, 0.01),
    }
    scenario, controller = nfopidn.Scenario.load(files[2]), nfopidn.Controller.load(files[0])
    result = nfopidn.monte_carlo(scenario, controller, 20, rng=0, distributions=drawn)
    assert list(told["quantiles"].values()) == result.quantiles((0.05, 0.5, 0.95, 1)).tolist()
    assert set(told["rank_correlations"]) == set(drawn)


def test_a_parameter_that_never_changes_has_no_correlation(files, capsys):
    words = ["monte-carlo", *files, "--draw", "delay=choice:0", "-n", "4"]
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["rank_correlations"] == {"delay": None}
    assert main(words) == 0
    assert "not known" in capsys.readouterr().out


def test_one_file_that_fails_does_not_lose_the_others(files, tmp_path, monkeypatch, capsys):
    def fail(*_):
        raise OSError("the disk is full")

    monkeypatch.setattr(monte_carlo_command, "save_picture", fail)
    table = tmp_path / "runs.csv"
    words = ["--csv", str(table), "--plot", str(tmp_path / "a.png"), "-n", "4"]
    assert main(["monte-carlo", *files, *DRAW, *words]) == 2
    output = capsys.readouterr()
    assert "4 runs" in output.out
    assert "the disk is full" in output.err
    assert len(table.read_text().splitlines()) == 5


def test_the_published_scenario_is_said(files, capsys):
    assert main(["monte-carlo", files[0], "-n", "2", *DRAW, "--quiet"]) == 0
    output = capsys.readouterr()
    assert output.out == ""
    assert "no --scenario" in output.err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["-n", "0"], "n is 0"),
        (["--draw", "mass"], "--draw mass: must be NAME=normal:MEAN:STD"),
        (["--draw", "mass=norml:1:2"], "did you mean 'normal'?"),
        (["--draw", "mass=normal:1"], "must be NAME=normal:MEAN:STD"),
        (["--draw", "mass=normal:a:b"], "must have numbers"),
        (["--draw", "mass=normal:inf:1"], "must be finite"),
        (["--draw", "mass=uniform:2:1"], "low must be less than high"),
        (["--draw", "mss=normal:1:0.1"], "did you mean 'mass'?"),
        ([*DRAW, *DRAW], "mass is given twice"),
        (["--limit", "cost"], "--limit cost: must be NAME=NUMBER"),
        (["--limit", "costs=1"], "did you mean 'cost'?"),
        (["--interval", "wald", "--limit", "cost=1"], "interval is 'wald'"),
        (["--interval", "wald"], "interval is 'wald'"),
        (["--csv", "no/such/folder/a.csv"], "cannot be written"),
    ],
)
def test_bad_words_are_refused(files, words, says, capsys):
    assert main(["monte-carlo", *files, "-n", "4", *words]) == 2
    assert says in capsys.readouterr().err


def test_a_bad_interval_is_refused_before_the_runs(files, monkeypatch, capsys):
    monkeypatch.setattr(monte_carlo_command, "monte_carlo", None)
    assert main(["monte-carlo", *files, "-n", "4", "--interval", "wald"]) == 2
    assert "interval is 'wald'" in capsys.readouterr().err


def test_ctrl_c_tells_what_is_done(files, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(runs, "BLOCK", 64)
    block = runs.Analysis.block

    def interrupted(self, first, count, workers):
        if first == 128:
            signal.raise_signal(signal.SIGINT)
        return block(self, first, count, workers)

    monkeypatch.setattr(runs.Analysis, "block", interrupted)
    path = str(tmp_path / "runs.npz")
    words = ["monte-carlo", *files, *DRAW, "-n", "300", "--seed", "3", "--checkpoint", path]
    assert main([*words, "--json"]) == 130
    output = capsys.readouterr()
    assert json.loads(output.out)["runs"] == 128
    assert "128 runs are kept" in output.err
    monkeypatch.setattr(runs.Analysis, "block", block)
    assert main([*words, "--json"]) == 0
    result = expected(files, 300)
    assert json.loads(capsys.readouterr().out)["worst"][0]["cost"] == result.costs.max()


def test_as_a_program(files):
    words = [sys.executable, "-m", "nfopidn", "monte-carlo", *files, *DRAW, "-n", "10"]
    done = subprocess.run(
        words, capture_output=True, text=True, check=True, timeout=120, env=dict(os.environ)
    )
    assert "10 runs, seed 0" in done.stdout
