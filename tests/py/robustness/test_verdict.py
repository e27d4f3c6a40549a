"""Verdicts: what is stable, what is borne, and the colour that follows."""

import json
import subprocess
import sys

import nfopidn
import nominal
import numpy as np
import pytest
from nfopidn import Controller, Rival, Robot, Scenario, Trajectory, Verdict, simulate
from nfopidn.robustness import digest, read_verdict, save_with_verdict
from nfopidn.robustness.limits import LoopMargin
from nfopidn.robustness.long_runs import OnPath, largest, long_run, path_size

P = Scenario.published(rng=0)
TRACKING = Controller(
    [[1.97, 0, 0], [0.317, 0, 0], [0.881, 0, 0]],
    *(0.5, 0.5),
    allocation="decoupled",
    lateral="scheduled",
    net="speed-errors",
    speed_gain_x=12.4,
    speed_gain_theta=2.8,
    speed_order_x=1.137,
    speed_order_theta=1.256,
    amplitude_x=0.648,
    amplitude_y=7.89,
    amplitude_theta=0.2327,
    pole_x=0.0829,
    pole_theta=0.2395,
    integral_x=0.0223,
    integral_y=0.00168,
    integral_theta=0.00101,
    integral_retention=0.9925,
    integral_limit=0.1546,
    lateral_speed=0.2231,
    lateral_power=1.553,
)
CIRCLE = Scenario(Trajectory.circle(period=45, dt=0.2), initial_velocity="reference", rng=0)


@pytest.fixture(scope="module")
def good():
    return nfopidn.verdict(TRACKING, P)


def test_a_good_controller_is_green(good):
    assert (good.colour, good.reasons, good.stable) == ("green", (), True)
    assert good.spectral_radius == nfopidn.stability.loop(P, TRACKING).spectral_radius_per_sample
    family = P.variations("standard")
    assert good.runs.names == family.names
    assert good.runs.costs.tolist() == nfopidn.simulate_many(family, TRACKING).costs.tolist()
    margins = nfopidn.stability.margins(TRACKING, P.replace(integrator="exact"))
    assert good.margin.gain[1] == min(margins.drive.gain[1], margins.steering.gain[1])
    assert good.margin.phase == min(margins.drive.phase, margins.steering.phase)
    assert good.margin.delay == min(margins.drive.delay, margins.steering.delay) / 0.2
    assert good.scenario_digest == digest(P) != digest(CIRCLE)
    assert good.controller_digest == digest(TRACKING) != digest(TRACKING.replace(pole_x=0.083))
    assert good.line.startswith("verdict: green: worst variation 'delay +1, inertia x0.5")


def test_limits_are_where_runs_leave_the_path(good):
    """Each limit by runs of the scenario itself, three laps long."""
    limits, own = good.limits, P.robot
    longer = P.replace(trajectory=Trajectory.ranunculoid(laps=3))

    def late(**changes):
        run = simulate(longer.replace(**changes), TRACKING)
        if run.diverged_at is not None:
            return np.inf
        far = np.hypot(run.columns["e_x"], run.columns["e_y"])
        return np.sqrt(np.mean(far[len(far) // 2 :] ** 2))

    most = 0.05 * path_size(P)
    assert most > 10 * late()
    assert late(delay=limits.extra_delay) <= most < late(delay=limits.extra_delay + 1)
    for factor, beyond in ((limits.mass[1], 1.01), (limits.mass[0], 0.99)):
        if factor == pytest.approx(0.1):
            continue

        def heavier(more):
            robot = own.replace(mass=own.mass * more, inertia=own.inertia * more)
            return late(robot=robot, model=own)

        assert heavier(factor) <= most < heavier(factor * beyond)
    friction = limits.friction * P.torque_limit
    assert late(coulomb_friction=friction) <= most < late(coulomb_friction=1.01 * friction)
    assert limits.start > 0.3


def test_other_robots_are_tried_without_a_warning(monkeypatch):
    """Warnings are errors here. Without linear analysis the margin is found on lighter robots."""

    def unknown(*_):
        raise ValueError

    monkeypatch.setattr(nfopidn.robustness.limits, "margins", unknown)
    found = nfopidn.verdict(Controller.recommended(), P)
    assert found.margin.source == "simulated"
    assert found.controller_digest == digest(Controller.recommended())
    with pytest.warns(UserWarning, match="made for another robot: its mass"):
        nfopidn.verdict(Controller.recommended(), P.replace(robot=Robot(mass=23.0)))


def test_an_unstable_loop_is_red():
    incremental = Controller.published(form="incremental")
    found = nfopidn.verdict(incremental, P)
    assert nfopidn.stability.loop(P, incremental).verdict == "unstable"
    assert (found.colour, found.stable, found.margin) == ("red", False, None)
    assert "not stable: unstable on its orbit, spectral radius" in found.reasons[0]
    assert found.line.startswith("verdict: red: not stable")


def test_what_diverges_is_named():
    found = nfopidn.verdict(Controller.published(), P)
    assert found.colour == "red"
    lost = nfopidn.simulate_many(P.variations("standard"), Controller.published()).diverged
    names = np.array(P.variations("standard").names)[lost].tolist()
    assert found.diverged == tuple(names)
    assert f"2 of 17 variations diverge: {names[0]!r}, {names[1]!r}" in found.reasons
    assert "less than one sample of delay is borne" in found.reasons


def test_bounds_and_margins_are_amber():
    found = nfopidn.verdict(TRACKING, P, at_bound=["kp_x at its upper bound"])
    assert found.colour == "amber"
    assert found.reasons == ("the search ended on a bound: kp_x at its upper bound",)
    louder = TRACKING.replace(speed_gain_x=26.0)
    found = nfopidn.verdict(louder, P)
    assert (found.colour, len(found.reasons)) == ("amber", 1)
    assert found.margin.decibels < 6
    assert found.reasons[0].startswith(f"the gain margin is {found.margin.decibels:.3g} dB")


def test_a_reference_beyond_the_robot_is_amber():
    short = P.replace(trajectory=Trajectory.ranunculoid(dt=0.02))
    asked = np.abs(short.reference[:, 5:7]).max()
    assert asked > 100  # at the cusps the heading turns at once
    found = nfopidn.verdict(Controller.published(), short)
    assert any(f"the reference torques reach {asked:.3g} N m" in why for why in found.reasons)
    assert nfopidn.verdict(TRACKING, P).beyond == ()
    slow = CIRCLE.replace(viscous_friction=1.0)
    beyond = nfopidn.verdict(TRACKING, slow).beyond
    turn = 0.5 * slow.robot.track_width * slow.trajectory.omega
    wheel = (slow.trajectory.v + turn).max() / slow.robot.wheel_radius
    assert f"friction takes {wheel:.3g} N m a wheel" in beyond[0]


def test_rivals_are_judged_by_runs():
    found = nfopidn.verdict(Rival("samson"), P)
    assert found.colour == "red"
    assert found.margin.source == "simulated"
    assert "simulated for" in found.stability
    assert np.isnan(found.spectral_radius)
    factor = found.margin.gain[1]
    assert 1 < factor < 16
    longer = P.replace(trajectory=Trajectory.ranunculoid(laps=3))
    far = []
    for own in (factor, 1.05 * factor):
        robot = P.robot.replace(mass=P.robot.mass / own, inertia=P.robot.inertia / own)
        run = simulate(longer.replace(robot=robot, model=robot), Rival("samson"))
        late = np.hypot(run.columns["e_x"], run.columns["e_y"])[len(longer.trajectory) // 2 :]
        far.append(np.inf if run.diverged_at is not None else np.sqrt(np.mean(late**2)))
    assert far[0] <= 0.05 * path_size(P) < far[1]


def test_long_runs_agree_with_the_loop_s_eigenvalues():
    told = 0
    for controller in (TRACKING, Controller.tuned_nominal(), Controller.published()):
        for scenario in (CIRCLE, CIRCLE.replace(delay=1), P, P.replace(delay=1)):
            exact = nfopidn.stability.loop(scenario, controller)
            run = long_run(scenario, controller)
            near = np.hypot(*exact.orbit[:, :2].T).max() < 0.05 * path_size(scenario)
            if exact.verdict in ("stable", "unstable") and exact.agrees and near:
                told += 1
                assert run.stable == (exact.verdict == "stable"), (controller, scenario, run)
    assert told >= 6


def test_an_open_path_is_judged_as_far_as_it_goes():
    x = np.linspace(0, 8, 161)
    open_path = Trajectory.from_samples(x, 0.3 * np.sin(x), 0.2)
    scenario = Scenario(open_path, initial_velocity="reference", rng=0)
    found = nfopidn.verdict(TRACKING, scenario)
    assert "simulated for 32 s, the whole of its open path" in found.stability
    assert found.stable
    on_path = OnPath(scenario, TRACKING)
    assert (on_path.scenario, on_path.closed) == (scenario, False)


def test_the_gain_margin_in_decibels_is_the_smaller_one():
    assert LoopMargin((0.25, 4), 1, 1, "").decibels == pytest.approx(12.04, abs=0.01)
    assert LoopMargin((0.8, 4), 1, 1, "").decibels == pytest.approx(1.938, abs=0.001)
    assert LoopMargin((0.0, np.inf), 1, 1, "").decibels == np.inf


def test_bisection_finds_the_end():
    assert largest(lambda x: x < 0.3, 0.0, 1.0) == pytest.approx(0.3, abs=2e-5)
    assert largest(lambda x: x > -0.3, 0.0, -1.0) == pytest.approx(-0.3, abs=2e-5)
    assert largest(lambda _: True, 0.0, 1.0) == 1.0
    assert largest(lambda _: False, 0.0, 1.0) == 0.0


def test_a_reference_that_never_moves_has_no_verdict():
    still = Trajectory.from_samples([1.0] * 5, [2.0] * 5, 0.1, theta=[0.3] * 5)
    with pytest.raises(ValueError, match=r"the reference never moves: .* each of its 5 samples"):
        nfopidn.verdict(TRACKING, Scenario(still, rng=0))


def test_what_is_no_controller_is_refused():
    with pytest.raises(ValueError, match="controller is 3; must be a Controller or a Rival"):
        nfopidn.verdict(3, P)
    with pytest.raises(ValueError, match="scenario is None; must be a Scenario"):
        nfopidn.verdict(TRACKING, None)
    with pytest.raises(ValueError, match=r"sample_time of the controller is 0.2 s"):
        nfopidn.verdict(
            Controller.tuned_nominal(), CIRCLE.replace(trajectory=Trajectory.circle(dt=0.1))
        )


def test_verdicts_do_not_depend_on_workers(good):
    assert nfopidn.verdict(TRACKING, P, workers=2).to_dict() == good.to_dict()


def test_verdicts_are_kept_in_files(tmp_path, good):
    file = tmp_path / "controller.json"
    for controller in (TRACKING, Rival("lqr")):
        save_with_verdict(controller, file, good)
        assert type(controller).load(file) == controller
        again = read_verdict(file)
        assert str(again) == str(good)
        assert again.to_dict() == good.to_dict()
    TRACKING.save(file)
    assert read_verdict(file) is None
    file.write_text('{"verdict": {"colour": "blue"}}')
    with pytest.raises(ValueError, match=r"controller.json: verdict: .*colour must be one of"):
        read_verdict(file)
    file.write_text("{")
    with pytest.raises(ValueError, match=r"controller.json"):
        read_verdict(file)


def command(*words):
    return subprocess.run(
        [sys.executable, "-m", "nfopidn", *map(str, words)],
        check=False,
        capture_output=True,
        text=True,
    )


def test_the_command_tells_colours_by_its_exit_code(tmp_path, good):
    controller, scenario = tmp_path / "controller.json", tmp_path / "scenario.json"
    P.save(scenario)
    TRACKING.save(controller)
    run = command("verdict", controller, "--scenario", scenario, "--json")
    assert run.returncode == 0
    assert json.loads(run.stdout) == good.to_dict()
    assert Verdict.from_dict(json.loads(run.stdout)).line == good.line
    Controller.published().save(controller)
    out = tmp_path / "judged.json"
    run = command("verdict", controller, "--scenario", scenario, "-o", out)
    assert run.returncode == 3
    assert run.stdout.startswith("verdict: red: 2 of 17 variations diverge")
    assert read_verdict(out).colour == "red"
    assert "no --scenario; judged on the published one" not in run.stderr
    run = command("verdict", controller)
    assert "no --scenario; judged on the published one" in run.stderr
    assert command("verdict", "missing.json").returncode == 2


def test_export_refuses_what_is_red(tmp_path):
    controller, scenario = tmp_path / "controller.json", tmp_path / "scenario.json"
    P.save(scenario)
    red = nfopidn.verdict(Controller.published(), P)
    save_with_verdict(Controller.published(), controller, red)
    words = ("export", controller, "-o", tmp_path, "--scenario", scenario)
    run = command(*words)
    assert run.returncode == 2
    assert "is not exported, since its verdict is red: 2 of 17 variations diverge" in run.stderr
    assert not (tmp_path / "nfopidn.c").exists()
    assert command(*words, "--force").returncode == 0
    assert (tmp_path / "nfopidn.c").exists()
    known = TRACKING.replace(sample_time=0.2)  # without which a law of speeds needs the scenario
    green = nfopidn.verdict(known, P)
    save_with_verdict(known, controller, green)
    run = command(*words)
    assert (run.returncode, "not verified" in run.stderr) == (0, False)
    assert (
        f"On scenario {green.scenario_digest}, verdict: green"
        in (tmp_path / "nfopidn.h").read_text()
    )
    CIRCLE.save(tmp_path / "circle.json")
    for other in (words[:4], [*words[:4], "--scenario", tmp_path / "circle.json"]):
        run = command(*other)
        assert (run.returncode, "not verified" in run.stderr) == (0, True)
        assert "not verified on this scenario" in (tmp_path / "nfopidn.h").read_text()
    known.save(controller)
    run = command(*words)
    assert "has no verdict: not verified" in run.stderr
    assert "Verdict: not verified." in (tmp_path / "nfopidn.h").read_text()


def test_a_verdict_on_other_numbers_is_none(tmp_path, good):
    """A file whose numbers were edited keeps a verdict that says nothing of them."""
    controller, scenario = tmp_path / "controller.json", tmp_path / "scenario.json"
    P.save(scenario)
    edited = TRACKING.replace(pole_x=0.5)
    save_with_verdict(edited, controller, good)
    run = command("export", controller, "--cpp", "-o", tmp_path, "--scenario", scenario)
    assert run.returncode == 0
    assert "has a verdict on other numbers than its own: not verified" in run.stderr
    assert "Verdict: not verified." in (tmp_path / "nfopidn_controller.hpp").read_text()
    nfopidn.export_cpp(edited, tmp_path, scenario=P, verdict=good)
    assert "Verdict: not verified." in (tmp_path / "nfopidn_controller.hpp").read_text()


def test_results_of_tuning_have_a_verdict():
    result = nominal.tune(P, structure="decoupled", rng=1, maxfev=300)
    bound = [f"{name} at its {side} bound" for name, side in result.at_bounds().items()]
    found = nfopidn.verdict(result.controller, P, at_bound=bound)
    assert result.verdict.to_dict() == found.to_dict()
    assert result.verdict is result.verdict
    both = nominal.tune([P, CIRCLE], structure="decoupled", rng=1, maxfev=300).verdict
    assert both.reasons == () or both.reasons[0].startswith("scenario ")


def test_robots_of_other_sizes_are_judged_alike():
    """A robot twice as heavy under twice the gains and limits: the same numbers."""
    twice = Robot(23.0, 2 * 0.5873, 0.452, 0.076)
    scenario = P.replace(robot=twice, torque_limit=2 * 3.078)
    gains = TRACKING.gains[:, 0] * 2
    document = json.loads(TRACKING.to_json())
    document["gains"] = [[gain, 0, 0] for gain in gains]
    for name in ("speed_gain_x", "speed_gain_theta", "integral_x", "integral_y", "integral_theta"):
        document[name] *= 2
    for name in ("amplitude_x", "amplitude_y", "amplitude_theta", "integral_limit"):
        document[name] *= 2
    found = nfopidn.verdict(Controller.from_json(json.dumps(document)), scenario)
    own = nfopidn.verdict(TRACKING, P)
    assert found.limits.mass == pytest.approx(own.limits.mass, rel=1e-3)
    assert found.limits.friction == pytest.approx(own.limits.friction, rel=1e-3)
    assert found.limits.extra_delay == own.limits.extra_delay
    assert found.margin.gain == pytest.approx(own.margin.gain, rel=1e-9)
