"""A controller knows the sample time that its gains are made for, and runs at no other."""

import copy
import json
import pickle
import subprocess
import sys

import nfopidn
import nominal
import numpy as np
import pytest
from nfopidn import (
    Controller,
    Objective,
    Rival,
    Scenario,
    Trajectory,
    commands,
    compare,
    simulate,
    stability,
)
from nfopidn.fractional import retune, truncation_report

TUNED = Controller.tuned_nominal()
CIRCLE = Scenario(Trajectory.circle(period=60, dt=0.1), rng=0)
REFUSAL = r"sample_time of the controller is 0\.2 s; must be the scenario's dt, 0\.1 s .*retune"


def test_who_knows_it():
    assert Controller.published().sample_time is None
    assert TUNED.sample_time == 0.2
    gains = np.ones((3, 3)) / 10
    assert Controller(gains, 0.5, 0.5).sample_time is None
    assert Controller(gains, 0.5, 0.5, sample_time=0.05).sample_time == 0.05
    assert Controller.from_continuous(gains, 0.5, 0.5, 0.05).sample_time == 0.05
    assert Controller.from_taps(np.ones((3, 4)), sample_time=0.3).sample_time == 0.3
    assert TUNED.replace(sample_time=None).sample_time is None
    assert TUNED.replace(alpha=0.5).sample_time == 0.2
    for value in (0, -1, np.nan, np.inf):
        with pytest.raises(ValueError, match=r"sample_time is .*greater than 0 s"):
            TUNED.replace(sample_time=value)


@pytest.mark.parametrize("duplicate", [copy.copy, lambda it: pickle.loads(pickle.dumps(it))])
def test_it_is_part_of_the_value(duplicate, tmp_path):
    assert duplicate(TUNED).sample_time == 0.2
    assert TUNED.replace(sample_time=None) != TUNED
    TUNED.save(tmp_path / "c.json")
    assert json.loads((tmp_path / "c.json").read_text())["version"] == 2
    assert Controller.load(tmp_path / "c.json") == TUNED


@pytest.mark.parametrize(
    "call",
    [
        lambda: simulate(CIRCLE, TUNED),
        lambda: compare({"tuned": [TUNED]}, {"circle": CIRCLE}),
        lambda: stability.loop(CIRCLE, TUNED),
        lambda: stability.basin(CIRCLE, TUNED),
        lambda: stability.margins(TUNED, speed=0.2, scenario=CIRCLE),
        lambda: nominal.tune(CIRCLE, structure="incremental", start=TUNED, maxfev=20),
        lambda: nominal.tune(CIRCLE, structure={"sample_time": 0.2}, maxfev=20),
        lambda: Objective(CIRCLE, structure={"sample_time": 0.2}),
        lambda: Objective(CIRCLE, structure="incremental").parameters_of(TUNED),
        lambda: nfopidn.study.open_loop_optimum(CIRCLE, controllers=[TUNED]),
    ],
)
def test_another_one_is_refused(call):
    with pytest.raises(ValueError, match=REFUSAL):
        call()


@pytest.mark.parametrize("write", [nfopidn.export_c, nfopidn.export_cpp])
def test_export_never_names_another_one(write, tmp_path):
    with pytest.raises(ValueError, match=REFUSAL):
        write(TUNED, tmp_path, scenario=CIRCLE, name="law")
    assert list(tmp_path.iterdir()) == []
    for controller, text in [
        (TUNED, "Sample time: 0.2 s. The gains hold for it alone."),
        (Controller.published(), "Sample time: not known. The gains hold for one alone."),
    ]:
        assert text in write(controller, tmp_path, name="law")[0].read_text()
    assert (
        "Sample time: 0.1 s."
        in write(Controller.published(), tmp_path, scenario=CIRCLE, name="law")[0].read_text()
    )


def test_hardware_is_made_for_the_scenarios_sample_time_alone(tmp_path):
    other = TUNED.replace(sample_time=0.05)
    published = Scenario.published(rng=0)
    with pytest.raises(ValueError, match=r"0\.05 s; must be the scenario's dt, 0\.2 s"):
        nfopidn.export_c(other, tmp_path, scenario=published, hardware=True)
    # No sample time stands in for a scenario's, not even the published one's.
    for controller in (other, TUNED):
        with pytest.raises(ValueError, match=r"sample time\) without a scenario"):
            nfopidn.export_c(controller, tmp_path, hardware=True)
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_one_fits_any():
    unknown = TUNED.replace(sample_time=None)
    at_rest = simulate(CIRCLE, unknown)
    assert at_rest.cost == simulate(CIRCLE, TUNED.replace(sample_time=0.1)).cost
    assert at_rest.controller == unknown
    # Digits that a log's stamps do not have are no other sample time.
    close = Scenario(Trajectory.circle(period=60, dt=0.2 * (1 + 5e-10)), rng=0)
    assert simulate(close, TUNED).controller == TUNED
    with pytest.raises(ValueError, match="sample_time"):
        simulate(Scenario(Trajectory.circle(period=60, dt=0.2 * (1 + 2e-9)), rng=0), TUNED)


def test_rivals_fit_any():
    """Their parameters are of continuous time; LQR samples its model at the scenario's dt."""
    for law in Rival.laws():
        assert np.isfinite(simulate(CIRCLE, Rival(law)).cost)


@pytest.mark.parametrize("structure", ["incremental", "taps"])
def test_what_is_tuned_has_the_scenarios(structure):
    result = nominal.tune(CIRCLE, structure=structure, rng=0, maxfev=60)
    assert result.controller.sample_time == 0.1
    assert simulate(CIRCLE, result.controller).cost == pytest.approx(result.fun, rel=1e-3)
    assert Objective(CIRCLE).controller([0.1] * 11).sample_time == 0.1
    two = [CIRCLE, Scenario(Trajectory.circle(period=60, dt=0.2), rng=0)]
    assert nominal.tune(two, rng=0, maxfev=20).controller.sample_time is None


def test_retune_takes_the_controllers_own():
    with pytest.warns(UserWarning, match="largest change of the frequency response"):
        report = retune(TUNED, new_dt=0.1)
    with pytest.warns(UserWarning, match="largest change of the frequency response"):
        assert report.controller == retune(TUNED, 0.2, new_dt=0.1).controller
    assert (report.dt, report.controller.sample_time) == (0.1, 0.1)
    assert np.isfinite(simulate(CIRCLE, report.controller).cost)
    with pytest.warns(UserWarning, match="largest change of the frequency response"):
        back = retune(report.controller, new_dt=0.2).controller
    np.testing.assert_allclose(back.gains, TUNED.gains, rtol=1e-14, atol=1e-300)
    assert truncation_report(TUNED) == truncation_report(TUNED, 0.2)
    for call in (retune, truncation_report):
        with pytest.raises(ValueError, match=r"does not know its sample time; give dt"):
            call(Controller.published())
        with pytest.raises(ValueError, match=r"dt is 0\.1 s; must be .*0\.2 s"):
            call(TUNED, 0.1)
    assert retune(Controller.published(), 0.2).controller.sample_time == 0.2


def old_file(path):
    """Make a file as version 1 had it."""
    document = json.loads(TUNED.to_json())
    del document["sample_time"]
    path.write_text(json.dumps({**document, "version": 1}))
    return path


def test_a_file_of_version_1_is_read_with_one_warning_a_process(tmp_path):
    code = f"""
import warnings
import nfopidn
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    controllers = [nfopidn.Controller.load({str(old_file(tmp_path / "old.json"))!r}) for _ in "12"]
    nfopidn.Controller.from_json(controllers[0].to_json())
assert controllers[0] == nfopidn.Controller.tuned_nominal().replace(sample_time=None)
print(len(said), said[0].category.__name__, said[0].message, said[0].filename)
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.startswith(f"1 UserWarning {tmp_path / 'old.json'}: a controller file of ver")
    assert "does not carry its sample time" in run.stdout
    assert run.stdout.strip().endswith("<string>")


def test_the_commands_say_so(sim, tmp_path, capsys):
    path, scenario = old_file(tmp_path / "old.json"), tmp_path / "scenario.json"
    CIRCLE.save(scenario)
    run = sim("--controller", path, "--json")
    assert run.returncode == 0
    assert run.stderr == (
        f"nfopidn_sim: {path} does not carry its sample time; the controller is run at the "
        "scenario's, 0.2 s (--sample-time says it)\n"
    )
    for known in (["--sample-time", "0.2"], ["--quiet"]):
        again = sim("--controller", path, "--json", *known)
        assert (again.stdout, again.stderr) == (run.stdout, "")
    assert commands.main(["export", str(path), "-o", str(tmp_path)]) == 0
    assert capsys.readouterr().err.count("old.json does not carry its sample time") == 1


def test_the_commands_refuse_another_one(sim, tmp_path, capsys):
    path, scenario = tmp_path / "tuned.json", tmp_path / "scenario.json"
    TUNED.save(path)
    CIRCLE.save(scenario)
    for arguments in (
        ["--dt", "0.1"],
        ["--scenario", scenario],
        ["--scenario", scenario, "--tune"],
    ):
        run = sim("--controller", path, *arguments)
        assert (run.returncode, run.stdout) == (2, "")
        assert run.stderr.startswith(f"nfopidn_sim: {path}: sample_time of the controller is 0.2 s")
    assert sim("--controller", path, "--json").returncode == 0
    words = ["export", str(path), "--scenario", str(scenario), "-o", str(tmp_path / "out")]
    assert commands.main(words) == 2
    assert "0.2 s; must be the scenario's dt, 0.1 s" in capsys.readouterr().err


def test_the_executable_writes_what_it_tuned_for(sim, tmp_path):
    path = tmp_path / "tuned.json"
    arguments = ["--traj", "circle", "--period", "60", "--dt", "0.1", "--velocity", "reference"]
    run = sim(*arguments, "--tune", "--maxfev", "100", "--quiet", "--save-controller", path)
    assert run.returncode == 0
    assert Controller.load(path).sample_time == 0.1
