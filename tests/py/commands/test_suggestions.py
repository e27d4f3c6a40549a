"""What is unknown is refused with the nearest word that is known, wherever words are listed."""

import json

import nfopidn
import pytest
from nfopidn import Controller, Rival, Robot, Scenario, commands
from nfopidn.arguments import suggestion
from nfopidn.fractional import discretise
from refusal import refused

RUN = nfopidn.compare([Controller.published()], ["published"])

EXECUTABLE = {
    "option": (["--inital-pose", "1,2,3"], "--inital-pose", "--initial-pose"),
    "option with a value": (["--masss=3"], "--masss=3", "--mass"),
    "option in Python's spelling": (["--initial_pose=1"], "--initial_pose=1", "--initial-pose"),
    "short name": (["--trai=circle"], "--trai=circle", "--traj"),
    "flag": (["--no-feedfoward"], "--no-feedfoward", "--no-feedforward"),
    "file": (["--save-controler", "c.json"], "--save-controler", "--save-controller"),
    "choice": (["--form", "incrementel"], 'form is "incrementel"', "incremental"),
    "path": (["--trajectory", "cirlce"], 'name is "cirlce"', "circle"),
    "allocation": (["--allocation", "Decoupled"], 'allocation is "Decoupled"', "decoupled"),
    "structure": (["--tune", "--structure", "extendet"], 'structure is "extendet"', "extended"),
    "method": (["--tune", "--method", "bfoa-"], "method is bfoa-", "bfoa+"),
    "option of a method": (["--tune", "--option", "cell=8"], "cell is unknown", "cells"),
}


@pytest.mark.parametrize(("words", "refusal", "near"), EXECUTABLE.values(), ids=EXECUTABLE)
def test_the_executable_names_the_nearest(words, refusal, near, sim, tmp_path):
    run = sim(*words, cwd=tmp_path)
    assert (run.returncode, run.stdout) == (2, "")
    assert f"{refusal} (did you mean {near}?)" in run.stderr
    assert run.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "words", [["--colour", "3"], ["-x"], ["word"], ["--tune", "--method", "de"]]
)
def test_the_executable_names_none_that_is_far(words, sim):
    run = sim(*words)
    assert run.returncode == 2
    assert "did you mean" not in run.stderr


def test_an_unknown_key_of_a_file(tmp_path):
    path = tmp_path / "scenario.json"
    Scenario.published(rng=0).save(path)
    document = json.loads(path.read_text())
    document["robot"]["wheel_radios"] = document["robot"].pop("wheel_radius")
    path.write_text(json.dumps(document))
    with refused("robot.wheel_radios is unknown (did you mean wheel_radius?); known: mass, "):
        Scenario.load(path)


PYTHON = {
    "keyword": (lambda: Robot(mas=1), "'mas' (did you mean mass?)", TypeError),
    "choice": (lambda: Controller.published(form="Incremental"), "(did you mean incremental?)"),
    "law": (lambda: Rival("kanyama"), '"kanyama" (did you mean kanayama?)'),
    "parameter of a law": (
        lambda: Rival("lqr", tolerance_xx=1),
        "(did you mean tolerance_x?)",
        TypeError,
    ),
    "structure": (lambda: nfopidn.tune(structure="papr"), '"papr" (did you mean paper?)'),
    "method": (lambda: nfopidn.tune(method="bfoa++"), "'bfoa++' (did you mean 'bfoa+'?)"),
    "option": (lambda: nfopidn.tune(options={"cell": 8}), "cell is unknown (did you mean cells?)"),
    "bound": (lambda: nfopidn.tune(bounds={"kpx": (0, 1)}), "'kpx' (did you mean 'kp_x'?)"),
    "scenario": (lambda: nfopidn.compare([Rival("lqr")], ["eigth"]), "(did you mean 'eight'?)"),
    "condition": (
        lambda: nfopidn.compare([Rival("lqr")], ["eight/nois"]),
        "(did you mean 'noise'?)",
    ),
    "metric": (lambda: RUN.median("csot"), "'csot' (did you mean 'cost'?)"),
    "compared scenario": (lambda: RUN.ranking("publishd"), "(did you mean 'published'?)"),
    "optimum": (lambda: RUN.with_optima({"publishd": 1}), "(did you mean 'published'?)"),
    "rule": (lambda: discretise(0.5, 0.1, method="tusin"), "'tusin' (did you mean 'tustin'?)"),
}


@pytest.mark.parametrize("case", PYTHON.values(), ids=PYTHON)
def test_python_names_the_nearest(case):
    call, message, *exception = case
    with refused(message, exception=(*exception, ValueError)[0]):
        call()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["tun"], "'tun' is no command (did you mean 'tune'?); known: simulate, tune, "),
        (["colour"], "'colour' is no command; known: simulate, tune, "),
        (["tune", "--sed", "3"], "unrecognized arguments: --sed 3 (did you mean '--seed'?)"),
        (["tune", "--methd=cma"], "--methd=cma (did you mean '--method'?)"),
        (["tune", "--colour"], "unrecognized arguments: --colour\n"),
        (["tune", "word"], "unrecognized arguments: word\n"),
        (["compare", "--controllers", "extendd"], "is not known (did you mean 'extended'?)"),
    ],
)
def test_the_commands_name_the_nearest(words, message, capsys):
    try:
        code = commands.main(words)
    except SystemExit as end:
        code = end.code
    out, err = capsys.readouterr()
    assert (code, out) == (2, "")
    assert message in err


def test_a_suggestion_is_near_or_nothing():
    assert suggestion("masss", ["inertia", "mass"]) == " (did you mean 'mass'?)"
    assert suggestion("MASS", ["inertia", "mass"]) == " (did you mean 'mass'?)"
    assert suggestion("colour", ["inertia", "mass"]) == ""
    assert suggestion(3, ["3"]) == ""
