"""`nfopidn physics`: what it tells and writes."""

import csv
import json
import os
import sys

import pytest
from nfopidn import Controller, Rival, Scenario, simulate
from nfopidn.commands import main
from nfopidn.mujoco import run

FAST = Scenario.published(heading="continuous", period=50.0, rng=0)


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Controller.recommended().save("controller.json")
    Rival("samson").save("rival.json")
    FAST.save("scenario.json")
    return ["controller.json", "--scenario", "scenario.json"]


def told(capsys):
    return json.loads(capsys.readouterr().out)


def test_the_command_is_listed(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "physics" in capsys.readouterr().out


def test_the_metrics_are_those_of_run_and_simulate(files, capsys):
    assert main(["physics", *files, "--json"]) == 0
    shown = told(capsys)
    assert shown["mujoco"] == run(FAST, Controller.recommended()).metrics
    assert shown["simulated"] == simulate(FAST, Controller.recommended()).metrics
    assert shown["diverged_at"] is None
    assert main(["physics", *files]) == 0
    assert "MuJoCo    simulated\ncost " in capsys.readouterr().out


def test_each_option_counts(files, capsys):
    costs = {}
    for words in (
        [],
        ["--wheels", "cylinder"],
        ["--joint-friction", "0.05"],
        ["--step", "0.004"],
        ["--odometry"],
        ["--odometry", "--counts", "30"],
        ["--floor", "0.1"],
        ["--slope", "0.02"],
    ):
        assert main(["physics", *files, "--json", *words]) == 0
        costs[" ".join(words)] = told(capsys)["mujoco"]["cost"]
    assert len(set(costs.values())) == len(costs)


def test_the_table_is_written(files, capsys):
    assert main(["physics", "rival.json", "--csv", "run.csv"]) == 0
    with open("run.csv") as lines:
        assert len(list(csv.reader(lines))) == 752
    assert not os.path.exists("MUJOCO_LOG.TXT")


def test_a_run_that_diverges_is_said(files, capsys):
    Scenario.published(rng=0, delay=10, divergence_distance=2.0).save("late.json")
    Controller.published().save("paper.json")
    assert main(["physics", "paper.json", "--scenario", "late.json"]) == 3
    assert "diverges at" in capsys.readouterr().err


def test_an_animation_is_written_or_refused_in_words(files, capsys):
    words = ["--render", "run.gif", "--speed", "1000"]
    code = main(["physics", *files, *words])
    if code:
        assert "renders" in capsys.readouterr().err
    assert os.path.exists("run.gif") == (code == 0)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--counts", "144"], "give --odometry too"),
        (["--step", "0.003"], "must be a whole number"),
        (["--wheels", "square"], "must be one of ellipsoid, cylinder, sphere"),
        (["--render", "run.avi"], "must end in one of .gif, .mp4"),
        (["--csv", "scenario.json"], "is the file of the input too"),
        (["--slope", "1"], "slope is 1.0"),
    ],
)
def test_bad_words_are_refused(files, capsys, words, message):
    before = set(os.listdir())
    assert main(["physics", *files, *words]) == 2
    assert message in capsys.readouterr().err
    assert set(os.listdir()) == before


def test_the_missing_extra_is_told(files, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert main(["physics", *files]) == 2
    assert 'pip install "nfopidn[physics]"' in capsys.readouterr().err
