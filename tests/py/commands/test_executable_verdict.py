"""The line of the executable that says what is known of a controller."""

import json
import re

import nfopidn
import pytest
from nfopidn import Controller, Robot, Scenario, Trajectory
from nfopidn.robustness.files import save_with_verdict


@pytest.fixture(scope="module")
def circle():
    return Scenario(Trajectory.circle(period=30, dt=0.2), rng=0)


@pytest.fixture(scope="module")
def judged(circle, tmp_path_factory):
    """Give a controller's file with its verdict, and the scenario's file."""
    folder = tmp_path_factory.mktemp("judged")
    controller = Controller.recommended(robot=Robot.eddie(), sample_time=circle.trajectory.dt)
    verdict = nfopidn.verdict(controller, circle, family=circle.variations(mass=1.2))
    save_with_verdict(controller, folder / "controller.json", verdict)
    circle.save(folder / "scenario.json")
    return verdict, folder / "controller.json", folder / "scenario.json"


def line_of(run):
    lines = [line for line in run.stdout.splitlines() if line.startswith("verdict: ")]
    assert len(lines) == 1
    return lines[0]


def test_verdict_of_the_file_counts_for_its_scenario_alone(sim, judged):
    verdict, controller, scenario = judged
    run = sim("--controller", controller, "--scenario", scenario)
    reasons = "".join(f": {reason}" for reason in verdict.reasons[:1])
    assert line_of(run).startswith(f"verdict: {verdict.colour}{reasons}")
    assert line_of(run).endswith(" (from the controller's file)")
    for changed in (["--mass", "12"], ["--memory", "4"]):
        other = sim("--controller", controller, "--scenario", scenario, *changed)
        assert line_of(other).startswith("verdict: not verified (its file's is on another ")


def test_stored_reasons_stand_on_the_line(sim, judged, tmp_path):
    _, controller, scenario = judged
    document = json.loads(controller.read_text())
    document["verdict"] |= {"colour": "amber", "reasons": ["one", "two"]}
    changed = tmp_path / "controller.json"
    changed.write_text(json.dumps(document))
    run = sim("--controller", changed, "--scenario", scenario)
    assert line_of(run) == "verdict: amber: one; two (from the controller's file)"
    document["verdict"]["colour"] = "blue"
    changed.write_text(json.dumps(document))
    run = sim("--controller", changed, "--scenario", scenario)
    assert line_of(run).startswith("verdict: not verified")


def test_what_diverges_is_red(sim):
    run = sim("--frame", "world")
    assert run.returncode == 3
    assert line_of(run) == "verdict: red: the run diverges at 37.4 s"


def test_one_sample_of_delay_that_is_not_borne_is_red(sim):
    late = nfopidn.simulate(Scenario.published(delay=2))
    run = sim("--delay", "1")
    red = f"verdict: red: with one sample of delay more it diverges at {late.diverged_at:.4g} s"
    assert (run.returncode, line_of(run)) == (0, red)
    assert line_of(sim()).startswith("verdict: not verified; ")


def test_a_search_s_controller_is_not_verified(sim, judged, tmp_path):
    _, controller, scenario = judged
    tuned = tmp_path / "tuned.json"
    run = sim("--tune", "--controller", controller, "--scenario", scenario, "--maxfev", "50",
              "--save-controller", tuned)  # fmt: skip
    assert re.match("verdict: (not verified|red)", line_of(run))
    assert "verdict" not in json.loads(tuned.read_text())
