"""`nfopidn tune` and `nfopidn_sim --tune`: what they write, and what they refuse."""

import json
import os
import pty
import stat
import subprocess
import sys

import nfopidn
import pytest
from nfopidn import (
    Controller,
    Scenario,
    Trajectory,
    TuneResult,
    commands,
    default_bounds,
    simulate,
)
from nfopidn.console import shows_progress
from nominal import tune

SHORT = ("--nominal", "--maxfev", "300", "--seed", "1")


@pytest.fixture
def command(tmp_path):
    """Run `python -m nfopidn` in a directory of its own."""

    def run(*words, **options):
        settings = {"cwd": tmp_path, "capture_output": True, "text": True, "timeout": 120}
        line = [sys.executable, "-m", "nfopidn", *map(str, words)]
        return subprocess.run(line, check=False, **(settings | options))

    return run


@pytest.fixture
def cli_tune(tmp_path, monkeypatch, capsys):
    """The same within this process, nominal: exit code, standard output, standard error."""
    monkeypatch.chdir(tmp_path)

    def run(*words):
        try:
            code = commands.main(["tune", "--nominal", *map(str, words)])
        except SystemExit as end:  # of argparse
            code = end.code
        return (code, *capsys.readouterr())

    return run


def cost_of(sim, path, *words):
    run = sim("--controller", path, "--json", *words)
    assert run.stderr == ""
    return json.loads(run.stdout)["cost"]


# nfopidn tune


def test_the_command_writes_a_controller_for_the_executable(command, sim, tmp_path):
    run = command("tune", *SHORT)
    assert (run.returncode, run.stderr) == (0, "")
    assert os.listdir(tmp_path) == ["controller.json"]
    result = tune(rng=1, maxfev=300)
    path = tmp_path / "controller.json"
    assert Controller.load(path) == result.controller
    assert cost_of(sim, path) == pytest.approx(result.fun, rel=1e-9)
    lines = run.stdout.splitlines()
    assert lines[0].startswith(f"cost {result.fun:.8g} after 300 evaluations, ")
    assert lines[1] == "seed 1. The budget of evaluations is used up."
    assert lines[-2].startswith("verdict: ")
    printed = dict(line.split()[:2] for line in lines[2:-2])
    marked = {line.split()[0] for line in lines[2:-2] if line.endswith(" bound)")}
    assert marked == set(result.at_bounds())
    assert list(printed) == result.parameters
    assert [float(value) for value in printed.values()] == pytest.approx(result.x, rel=1e-9)
    assert lines[-2] == result.verdict.line
    assert lines[-1] == "written: controller.json"


@pytest.mark.parametrize("structure", ["paper", "decoupled", "incremental", "extended", "taps"])
def test_every_structure_is_written_for_the_executable(structure, cli_tune, sim, tmp_path):
    words = ("--structure", structure, "--result", "result.json", "--maxfev", "2000")
    assert cli_tune(*words, "--seed", "1")[0] == 0
    result = TuneResult.from_json(tmp_path / "result.json")
    assert result.fun < 0.09
    assert result.structure == structure
    cost = cost_of(sim, tmp_path / "controller.json")
    assert cost == pytest.approx(result.fun, rel=1e-9)


def test_the_options_reach_tune(cli_tune, tmp_path):
    scenarios = [Scenario.published(rng=0, delay=k) for k in (0, 1)]
    for k, scenario in enumerate(scenarios):
        scenario.save(tmp_path / f"{k}.json")
    start = Controller.tuned_nominal()
    start.save(tmp_path / "start.json")
    words = "--output own.json --result result.json --scenario 0.json --scenario 1.json"
    words += " --worst-share 0.5 --structure incremental --start start.json"
    words += " --option cells=20 --option step=0.2"
    words += " --freeze kp_x=0.25 --freeze sigma=-1e-1 --tie kp_y=kp_theta --tie kd_y=kd_x"
    words += " --bound ki_x=0:0.2 --bound alpha=-0.5:0.5 --maxfev 500 --seed 9 --workers 2"
    words += " --stopval 0.001 --maxtime 1000 --checkpoint search.checkpoint --method bfoa+"
    assert cli_tune(*words.split())[::2] == (0, "")
    result = tune(
        [Scenario.load(tmp_path / f"{k}.json") for k in (0, 1)],
        structure="incremental",
        start=start,
        worst_share=0.5,
        options={"cells": 20, "step": 0.2},
        frozen={"kp_x": 0.25, "sigma": -0.1},
        tied={"kp_y": "kp_theta", "kd_y": "kd_x"},
        bounds={"ki_x": (0, 0.2), "alpha": (-0.5, 0.5)},
        stopval=0.001,
        maxfev=500,
        rng=9,
    )
    written = TuneResult.from_json(tmp_path / "result.json")
    assert written.fun == result.fun
    assert written.x.tolist() == result.x.tolist()
    assert written.options == {"cells": 20, "step": 0.2}
    assert Controller.load(tmp_path / "own.json") == result.controller == written.controller
    assert (tmp_path / "search.checkpoint").exists()


BASE = {"--maxfev": "300", "--seed": "1"}


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--structure", "decoupled"),
        ("--method", "bfoa"),
        ("--option", "differential_share=0.1"),
        ("--bound", "kp_x=0:0.5"),
        ("--freeze", "kp_x=0.5"),
        ("--tie", "kp_x=kp_y"),
        ("--start", "start.json"),
        ("--scenario", "scenario.json"),
        ("--seed", "2"),
        ("--maxfev", "200"),
        ("--stopval", "0.5"),
    ],
)
def test_an_option_changes_the_result(option, value, cli_tune, tmp_path):
    Controller.published().save(tmp_path / "start.json")
    Scenario.published(rng=0, delay=1).save(tmp_path / "scenario.json")
    histories = []
    for change in ({}, {option: value}):
        words = [word for pair in (BASE | change).items() for word in pair]
        assert cli_tune(*words, "--result", "result.json")[0] == 0
        histories.append(TuneResult.from_json(tmp_path / "result.json").history.tolist())
    assert histories[0] != histories[1]


def test_without_a_seed_it_is_0_as_the_executable_s_is(cli_tune, sim, tmp_path):
    code, text, _ = cli_tune("--maxfev", "200")
    assert code == 0
    assert "\nseed 0. " in text
    found = Controller.load(tmp_path / "controller.json")
    assert tune(rng=0, maxfev=200).controller == found
    path = tmp_path / "of_the_executable.json"
    run = sim("--tune", "--maxfev", "200", "--quiet", "--save-controller", path)
    assert run.returncode in (0, 3)
    assert Controller.load(path) == found


@pytest.mark.parametrize("structure", ["paper", "taps"])
def test_without_a_seed_a_checkpoint_s_search_goes_on(structure, cli_tune):
    words = ("--structure", structure, "--maxfev", "300", "--checkpoint", "search.checkpoint")
    first = cli_tune(*words, "--seed", "7")
    again = cli_tune(*words)
    assert first[0] == again[0] == 0
    assert "\nseed 7. " in again[1]
    code, _, err = cli_tune(*words, "--seed", "0")
    assert code == 2
    assert "another search" in err


def test_the_convergence_is_drawn(cli_tune, tmp_path):
    assert cli_tune(*SHORT, "--plot", "search.png")[0] == 0
    assert (tmp_path / "search.png").read_bytes().startswith(b"\x89PNG")


@pytest.fixture
def hopeless(tmp_path):
    """A scenario that no start from rest survives."""
    path = Trajectory.circle(period=8, dt=0.2, scale=5)
    Scenario(path, rng=0, divergence_distance=0.5).save(tmp_path / "hopeless.json")
    return "hopeless.json"


def test_a_search_in_which_all_diverges_is_told_and_exits_with_3(command, hopeless, tmp_path):
    run = command("tune", "--scenario", hopeless, *SHORT, "--quiet", "--result", "r.json")
    assert (run.returncode, run.stdout) == (3, "")
    assert run.stderr.startswith("nfopidn: The best controller that was found diverges at 0.2 s. ")
    assert 'initial_velocity="reference"' in run.stderr
    assert run.stderr.count("\n") == 1
    assert (tmp_path / "controller.json").exists()
    assert not TuneResult.from_json(tmp_path / "r.json").success


def test_the_executable_tells_that_all_diverges(sim, hopeless, tmp_path):
    words = ("--tune", "--scenario", hopeless, "--maxfev", "300")
    run = sim(*words, "--quiet", cwd=tmp_path)
    assert (run.returncode, run.stdout) == (3, "")
    assert "the best controller that was found diverges at 0.2 s" in run.stderr
    assert "moves at 7.85 m/s" in run.stderr
    assert "--initial-velocity reference" in run.stderr
    run = sim(*words, cwd=tmp_path)
    assert run.returncode == 3
    assert "--initial-velocity reference" in run.stdout
    assert run.stderr.count("\n") == 1
    run = sim(*words, "--velocity", "reference", "--json", cwd=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")


def test_quiet_prints_nothing(command, tmp_path):
    run = command("tune", *SHORT, "--quiet")
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    assert (tmp_path / "controller.json").exists()


def test_a_checkpoint_goes_on_and_a_finished_one_is_repeated(cli_tune, tmp_path):
    words = (*SHORT, "--checkpoint", "search.checkpoint")
    first = cli_tune(*words)
    found = Controller.load(tmp_path / "controller.json")
    assert cli_tune(*words)[0] == first[0] == 0
    assert Controller.load(tmp_path / "controller.json") == found


def test_a_progress_bar_is_for_terminals_only(command, tmp_path):
    leader, follower = pty.openpty()
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "100"}
    run = command(
        "tune",
        *SHORT,
        capture_output=False,
        stdout=subprocess.PIPE,
        stderr=follower,
        env=environment,
    )
    os.close(follower)
    shown = os.read(leader, 100_000).decode()
    os.close(leader)
    assert run.returncode == 0
    assert "tune" in shown
    assert "evaluations, cost" in shown
    assert "evaluations, cost" not in run.stdout


def test_only_a_terminal_has_a_bar(monkeypatch):
    for terminal in (True, False):
        monkeypatch.setattr(sys.stderr, "isatty", lambda is_one=terminal: is_one, raising=False)
        assert shows_progress(quiet=False) == terminal
        assert not shows_progress(quiet=True)


def test_a_checkpoint_that_cannot_be_saved_loses_nothing(cli_tune, tmp_path, monkeypatch):
    """Found out after the search, as on a disk that has filled up meanwhile."""

    def with_full_disk(*scenarios, **arguments):
        arguments["callback"] = lambda _: (tmp_path / "ck").mkdir(exist_ok=True)
        return tune(*scenarios, **arguments)

    monkeypatch.setattr(nfopidn, "tune", with_full_disk)
    code, out, err = cli_tune(*SHORT, "--checkpoint", "ck")
    assert (code, err.count("\n")) == (2, 1)
    assert "ck: cannot be written" in err
    assert "kp_x" in out
    assert Controller.load(tmp_path / "controller.json") == tune(rng=1, maxfev=300).controller


@pytest.mark.parametrize("option", ["--output", "--result", "--plot", "--checkpoint"])
def test_names_that_cannot_be_written_show_before_the_search(option, cli_tune, tmp_path):
    (tmp_path / "loop.png").symlink_to("loop.png")
    names = {"a" * 250 + ".png": "too long", "none/a.png": "No such file", "loop.png": "levels"}
    if option != "--plot":
        names |= {"/dev/fd/987": "Bad file", "/dev/fd/abc": "No such file"}
    for name, reason in names.items():
        code, _, err = cli_tune(option, name, "--maxfev", str(10**12))
        assert (code, err.count("\n")) == (2, 1)
        assert f"{option} {name}: cannot be written: " in err
        assert reason in err
    assert os.listdir(tmp_path) == ["loop.png"]


def test_help_names_every_option_of_tune(cli_tune):
    code, text, _ = cli_tune("--help")
    assert code == 0
    for option in (
        "--output",
        "--scenario",
        "--structure",
        "--worst-share",
        "--checkpoint",
        "--plot",
    ):
        assert option in text
    for structure in ("paper", "decoupled", "incremental", "extended", "taps"):
        assert structure in text


def test_the_version_and_no_command(command):
    assert command("--version").stdout == f"nfopidn {nfopidn.__version__}\n"
    run = command()
    assert run.returncode == 2
    assert run.stdout == ""


FAULTS = {
    "scenario": (["--scenario", "none.json"], ["none.json", "No such file"]),
    "wrong document": (["--scenario", "start.json"], ["start.json", "nfopidn-scenario"]),
    "structure": (["--structure", "pid"], ['structure is "pid"', '"taps"']),
    "method": (["--method", "pso"], ["method is 'pso'", "'bfoa+'"]),
    "option": (["--option", "cellz=3"], ["options", "cellz is unknown"]),
    "option out of range": (["--option", "cells=3"], ["cells is 3"]),
    "option without value": (["--option", "cells"], ["--option cells", "NAME=NUMBER"]),
    "option of text": (["--option", "cells=many"], ["--option cells=many", "no number"]),
    "option NaN": (["--option", "step=nan"], ["step", "nan"]),
    "option infinite": (["--option", "step=inf"], ["step", "inf"]),
    "bound": (["--bound", "kp=0:1"], ["bounds names 'kp'"]),
    "bound without value": (["--bound", "kp_x"], ["--bound kp_x", "NAME=LOW:HIGH"]),
    "one bound": (["--bound", "kp_x=1"], ["--bound kp_x=1", "NAME=LOW:HIGH"]),
    "bound of text": (["--bound", "kp_x=a:b"], ["--bound kp_x=a:b", "no number"]),
    "bounds reversed": (["--bound", "kp_x=2:1"], ["bounds of kp_x", "smaller"]),
    "freeze": (["--freeze", "kp=1"], ["frozen names 'kp'"]),
    "freeze without value": (["--freeze", "kp_x"], ["--freeze kp_x", "NAME=NUMBER"]),
    "freeze text": (["--freeze", "kp_x=a"], ["--freeze kp_x=a", "no number"]),
    "frozen twice": (["--freeze", "kp_x=1", "--freeze", "kp_x=2"], ["kp_x is given twice"]),
    "no UTF-8": (["--start", "\udcff.json"], ["is not UTF-8"]),
    "deep file": (["--start", "deep.json"], ["deep.json"]),
    "deep checkpoint": (["--checkpoint", "deep.json"], ["deep.json"]),
    "freeze out of range": (["--freeze", "alpha=7"], ["alpha is 7"]),
    "tie": (["--tie", "kp_x=kp"], ["tied names 'kp'"]),
    "tie without value": (["--tie", "kp_x"], ["--tie kp_x", "NAME=NAME"]),
    "start": (["--start", "none.json"], ["none.json", "No such file"]),
    "start of another memory": (["--start", "start.json"], ["start has memory 3"]),
    "worst_share": (["--worst-share", "2"], ["worst_share is 2", "[0, 1]"]),
    "seed": (["--seed", "-1"], ["rng is -1"]),
    "maxfev": (["--maxfev", "0"], ["maxfev is 0"]),
    "maxtime": (["--maxtime", "0"], ["maxtime is 0"]),
    "stopval": (["--stopval", "nan"], ["stopval is nan"]),
    "workers": (["--workers", "0"], ["workers is 0"]),
    "checkpoint": (["--checkpoint", "none/search"], ["none/search", "No such file"]),
    "checkpoint of another": (["--checkpoint", "other"], ["other", "another search"]),
    "output": (["--output", "none/c.json"], ["none/c.json", "No such file"]),
    "output directory": (["--output", "."], ["directory"]),
    "result": (["--result", "none/r.json"], ["none/r.json", "No such file"]),
    "plot": (["--plot", "none/p.png"], ["none/p.png", "No such file"]),
    "one file twice": (
        ["--result", "./controller.json"],
        ["--result ./controller.json", "is the file of --output"],
    ),
    "format of the plot": (["--plot", "search.xyz"], ["xyz"]),
}


@pytest.mark.parametrize(("words", "parts"), FAULTS.values(), ids=FAULTS.keys())
def test_the_command_refuses(words, parts, cli_tune, tmp_path):
    Controller.published(memory=3, sample_time=0.2).save(tmp_path / "start.json")
    (tmp_path / "deep.json").write_text("[" * 200_000)
    tune(rng=5, maxfev=20, checkpoint=tmp_path / "other")
    (tmp_path / "controller.json").write_text("precious")
    code, out, err = cli_tune(*SHORT, *words)
    assert (code, out) == (2, "")
    assert err.startswith("nfopidn: ")
    assert err.count("\n") == 1
    assert all(part in err for part in parts), err
    assert (tmp_path / "controller.json").read_text() == "precious"
    assert sorted(os.listdir(tmp_path)) == [
        "controller.json",
        "deep.json",
        "other",
        "start.json",
    ]


def test_a_refused_command_leaves_no_file(cli_tune, tmp_path):
    code, _, _ = cli_tune("--structure", "bogus", "--output", "new.json", "--result", "r.json")
    assert code == 2
    assert not os.listdir(tmp_path)


def test_what_can_be_written_is_written(cli_tune, tmp_path):
    code, out, err = cli_tune(*SHORT, "-o", "/dev/full", "--result", "r.json")
    assert (code, err.count("\n")) == (2, 1)
    assert "No space left" in err
    assert "kp_x" in out
    assert TuneResult.from_json(tmp_path / "r.json").nfev == 300


def test_all_that_cannot_be_written_is_named(cli_tune, sim, tmp_path):
    (tmp_path / "full.png").symlink_to("/dev/full")
    words = ("-o", "/dev/full", "--plot", "full.png", "--result", "r.json")
    code, _, err = cli_tune(*SHORT, *words)
    assert (code, err.count("\n"), err.count("No space left")) == (2, 1, 2)
    assert "/dev/full" in err
    assert "full.png" in err
    assert TuneResult.from_json(tmp_path / "r.json").nfev == 300
    words = ("--out", "/dev/full", "--save-scenario", "full.png", "--save-controller", "c.json")
    run = sim(*words, cwd=tmp_path)
    assert (run.returncode, run.stderr.count("\n")) == (2, 1)
    assert run.stderr.count("No space left") == 2
    assert Controller.load(tmp_path / "c.json") == Controller.published()


def test_a_stages_checkpoint_is_no_place_for_another_file(cli_tune, tmp_path):
    words = ("--structure", "taps", "--checkpoint", "ck", "-o", "ck.gains")
    code, _, err = cli_tune(*SHORT, *words)
    assert code == 2
    assert "--checkpoint.gains ck.gains: is the file of --output" in err


def test_a_reader_that_has_gone_is_no_fault(command, tmp_path):
    reading, writing = os.pipe()
    os.close(reading)
    options = {"capture_output": False, "stdout": writing, "stderr": subprocess.PIPE}
    run = command("tune", *SHORT, **options)
    os.close(writing)
    assert (run.returncode, run.stderr) == (141, "")
    assert Controller.load(tmp_path / "controller.json").memory == 5


def test_links_are_followed_and_devices_written_to(cli_tune, tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "real.json").write_text("old")
    (tmp_path / "link.json").symlink_to("there/real.json")
    code, _, _ = cli_tune(*SHORT, "--result", "link.json", "--output", "/dev/null")
    assert code == 0
    assert (tmp_path / "link.json").is_symlink()
    assert TuneResult.from_json(tmp_path / "there" / "real.json").nfev > 0
    assert os.listdir(tmp_path / "there") == ["real.json"]
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


@pytest.mark.parametrize(
    "words",
    [["--worst-share", "high"], ["--seed", "1.5"], ["--maxfev", "x"], ["--unknown"], ["word"]],
)
def test_what_is_no_option_or_number_is_refused(words, cli_tune, tmp_path):
    code, out, err = cli_tune(*SHORT, *words)
    assert (code, out) == (2, "")
    assert words[0] in err
    assert not os.listdir(tmp_path)


def test_a_refusal_is_one_line_of_the_program(command):
    run = command("tune", "--worst-share", "2")
    assert (run.returncode, run.stdout) == (2, "")
    assert run.stderr == "nfopidn: worst_share is 2.0; must be in [0, 1]\n"


# nfopidn_sim --tune


@pytest.mark.parametrize("structure", ["paper", "decoupled", "incremental", "extended", "taps"])
def test_the_executable_tunes_and_runs_the_result(structure, sim, tmp_path):
    path = tmp_path / "controller.json"
    words = ("--tune", "--structure", structure, "--maxfev", "2000", "--tune-seed", "1", "--json")
    run = sim(*words, "--save-controller", path)
    assert (run.returncode, run.stderr) == (0, "")
    cost = json.loads(run.stdout)["cost"]
    assert cost_of(sim, path) == cost
    assert simulate(Scenario.published(rng=0), Controller.load(path)).cost == cost
    assert sim(*words).stdout == run.stdout
    assert cost < 0.05


@pytest.mark.parametrize("structure", ["paper", "decoupled", "incremental", "extended", "taps"])
def test_the_executable_finds_what_tune_finds(structure, sim, tmp_path):
    """To the last bit, if both are built from the same sources."""
    path = tmp_path / "controller.json"
    words = ("--structure", structure, "--maxfev", "600", "--tune-seed", "3")
    assert sim("--tune", *words, "--quiet", "--save-controller", path).returncode in (0, 3)
    assert Controller.load(path) == tune(structure=structure, rng=3, maxfev=600).controller


@pytest.mark.parametrize("structure", ["paper", "taps"])
@pytest.mark.parametrize(
    ("method", "options"),
    [("cma", {"population": 9, "step": 0.25}), ("bfoa", {"cells": 6}), ("bfoa+", {"colonies": 2})],
)
def test_the_executable_takes_every_method(method, options, structure, sim, tmp_path):
    path = tmp_path / "controller.json"
    words = ["--structure", structure, "--maxfev", "700", "--tune-seed", "3", "--method", method]
    for name, value in options.items():
        words += ["--option", f"{name}={value}"]
    assert sim("--tune", *words, "--quiet", "--save-controller", path).returncode in (0, 3)
    found = tune(structure=structure, rng=3, maxfev=700, method=method, options=options)
    assert Controller.load(path) == found.controller


def test_the_executable_has_one_schedule_of_passino_s_method(sim, tmp_path):
    path = tmp_path / "controller.json"
    words = ("--method", "bfoa", "--tune-seed", "1", "--quiet", "--save-controller", path)
    assert sim("--tune", *words).returncode == 0
    assert Controller.load(path) == tune(method="bfoa", rng=1).controller


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--method", "de"], "method is de; must be one of bfoa+, bfoa, cma"),
        (["--method", "bfoa", "--option", "cells=7"], "cells is 7; must be an even number"),
        (["--method", "cma", "--option", "population=1"], "population is 1; must be 0 or at least"),
        (["--option", "step=2"], "step is 2; must be in [1e-09, 1]"),
        (["--option", "swims=2"], "swims is unknown; known: cells, "),
        (["--option", "step"], "--option is step; must be NAME=NUMBER"),
        (["--option", "=2"], "--option is =2; must be NAME=NUMBER"),
        (["--option", "step=fast"], "step is "),
        (["--option", "step=0.1", "--option", "step=0.2"], "--option: step twice"),
    ],
)
def test_the_executable_refuses_methods_and_options_that_are_none(words, message, sim):
    run = sim("--tune", *words)
    assert (run.returncode, run.stdout) == (2, "")
    assert run.stderr.startswith(f"nfopidn_sim: {message}")
    assert run.stderr.count("\n") == 1


def test_the_executable_s_defaults(sim):
    defaults = (
        "--structure",
        "paper",
        "--maxfev",
        "10000",
        "--tune-seed",
        "0",
        "--method",
        "bfoa+",
    )
    run = sim("--tune", "--json")
    assert run.stdout == sim("--tune", "--json", *defaults).stdout
    for k in (0, 2, 4, 6):
        other = [
            *defaults[:k],
            defaults[k],
            ("decoupled", "900", "1", "cma")[k // 2],
            *defaults[k + 2 :],
        ]
        assert run.stdout != sim("--tune", "--json", *other).stdout


def test_the_executable_goes_on_from_a_controller_file(sim, tmp_path):
    path = tmp_path / "controller.json"
    Controller.tuned_nominal().save(path)
    cost = cost_of(sim, path)
    run = sim("--tune", "--controller", path, "--maxfev", "20", "--json")
    assert json.loads(run.stdout)["cost"] <= cost * (1 + 1e-9)


def test_the_executable_tunes_for_the_scenario_given(sim, tmp_path):
    path = tmp_path / "controller.json"
    words = ("--delay", "1", "--maxfev", "1000", "--structure", "decoupled")
    run = sim("--tune", *words, "--json", "--save-controller", path)
    assert cost_of(sim, path, "--delay", "1") == json.loads(run.stdout)["cost"] < 0.05
    undelayed = sim("--tune", *words[2:], "--json", "--save-controller", path)
    assert json.loads(undelayed.stdout)["cost"] < 0.05 < cost_of(sim, path, "--delay", "1")


def test_the_executable_tunes_with_other_settings(sim, tmp_path):
    path = tmp_path / "controller.json"
    words = ("--memory", "3", "--activation", "linear", "--maxfev", "200")
    assert sim("--tune", *words, "--quiet", "--save-controller", path).returncode in (0, 3)
    structure = {"memory": 3, "activation": "linear"}
    assert Controller.load(path) == tune(structure=structure, rng=0, maxfev=200).controller


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (["--structure", "pid"], ['structure is "pid"', '"taps"']),
        (["--maxfev", "0"], ["--maxfev"]),
        (["--maxfev", "x"], ["--maxfev"]),
        (["--maxfev", "1.5"], ["--maxfev"]),
        (["--tune-seed", "-1"], ["--tune-seed"]),
        (["--tune-seed", "x"], ["--tune-seed"]),
        (["--tune-seed", str(2**53 + 1)], ["--tune-seed"]),
        (["--delay", "-1"], ["delay is -1"]),
        (["--controller", "none.json"], ["none.json"]),
        (["--gains", "0,0,0,0,0,0,0,0,0"], ["--tune", "gains are what is searched for"]),
        (["--alpha", "0.5"], ["--tune", "alpha is what is searched for"]),
    ],
)
def test_the_executable_refuses(words, parts, sim, tmp_path):
    path = tmp_path / "controller.json"
    run = sim("--tune", *words, "--save-controller", path, cwd=tmp_path)
    assert (run.returncode, run.stdout) == (2, "")
    assert run.stderr.startswith("nfopidn_sim: ")
    assert run.stderr.count("\n") == 1
    assert all(part in run.stderr for part in parts), run.stderr
    assert not os.listdir(tmp_path)


@pytest.mark.parametrize(
    ("structure", "settings", "part"),
    [
        ("incremental", {}, 'form of start.json is "positional"; must be "incremental"'),
        ("decoupled", {}, 'allocation of start.json is "paper"; must be "decoupled"'),
        ("extended", {"allocation": "decoupled"}, 'lateral of start.json is "direction"'),
        ("paper", None, "start.json has free taps"),
    ],
)
def test_the_executable_refuses_a_start_of_another_structure(
    structure, settings, part, sim, tmp_path
):
    start = Controller.published(**settings) if settings is not None else taps_of_tuned()
    start.save(tmp_path / "start.json")
    run = sim("--tune", "--structure", structure, "--controller", "start.json", cwd=tmp_path)
    assert (run.returncode, run.stdout) == (2, "")
    assert part in run.stderr


def test_a_start_beyond_the_executable_s_bounds_is_refused(sim, tmp_path):
    Controller.published(gains=[[100.0] * 3] * 3).save(tmp_path / "far.json")
    run = sim("--tune", "--controller", "far.json", cwd=tmp_path)
    assert (run.returncode, run.stdout) == (2, "")
    assert "far.json: kp_x is 100; must be in [0, 3]" in run.stderr


def taps_of_tuned():
    return tune(structure="taps", rng=1, maxfev=20, start=Controller.tuned_nominal()).controller


def test_parameters_are_printed_by_their_names(cli_tune):
    for structure in ("paper", "extended"):
        text = cli_tune(*SHORT, "--structure", structure)[1]
        assert [line.split()[0] for line in text.splitlines()[2:-2]] == list(
            default_bounds(structure)
        )
