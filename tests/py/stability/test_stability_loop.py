"""nfopidn.stability.loop: verdicts and multipliers against runs of simulate()."""

from itertools import pairwise

import numpy as np
import pytest
from nfopidn import Controller, Robot, Scenario, Trajectory, simulate, stability
from nfopidn.stability.closed_loop import jacobians, repeated
from refusal import refused

PUBLISHED = Controller.published()
INCREMENTAL = Controller.published(form="incremental")


@pytest.mark.parametrize(
    ("scenario", "controller", "verdict", "radius"),
    [
        ({}, PUBLISHED, "stable", 0.0911),
        ({"period": 25}, PUBLISHED, "unstable", 3.292),
        ({}, INCREMENTAL, "unstable", 1.32e74),
        ({"heading": "continuous"}, PUBLISHED, "stable", 7.37e-6),
        ({"heading": "continuous"}, PUBLISHED.replace(lateral="plain"), "unstable", 1.39e5),
        ({}, Controller.published(memory=0), "unstable", 1.22e5),
        ({}, Controller.tuned_nominal(), "stable", 5.58e-4),
        ({"heading": "continuous"}, Controller.tuned_nominal(), "stable", 2.5e-7),
    ],
)
def test_the_verdict_is_the_simulations(scenario, controller, verdict, radius):
    found = stability.loop(Scenario.published(**scenario), controller)
    assert found.verdict == verdict
    assert found.spectral_radius == pytest.approx(radius, rel=0.02)
    assert found.agrees
    assert found.simulated.arrived == (verdict == "stable")
    assert found.spectral_radius_per_sample**found.period == pytest.approx(
        found.spectral_radius, rel=1e-9
    )
    assert abs(found.multipliers[0]) == pytest.approx(found.spectral_radius)
    assert np.all(np.diff(np.abs(found.multipliers)) <= 0)
    assert found.residual <= 1e-10


def test_without_an_orbit_the_evidence_is_a_simulation():
    found = stability.loop(Scenario.published(), Controller.published(frame="world"))
    assert found.verdict == "no_orbit"
    assert found.multipliers.size == 0
    assert np.isnan(found.spectral_radius)
    assert found.heading_wrap is None
    assert found.simulated.diverged_at == pytest.approx(37.4)
    assert found.agrees
    assert "no orbit found" in str(found)
    assert "diverges at 37.4 s" in str(found)


def test_a_start_outside_the_basin_disagrees():
    far = Scenario.published(initial_pose=(-1, -2, 1.0))
    found = stability.loop(far, PUBLISHED)
    assert found.verdict == "stable"
    assert found.simulated.diverged_at is not None
    assert not found.agrees


def states(run):
    """The map's states (N, n) from a run's table alone; the first memory + 1 are unknown."""
    controller, table = run.controller, run.columns
    error = np.column_stack([table["e_x"], table["e_y"], table["e_theta"]])
    cosine, sine = np.cos(error[:, 2]), np.sin(error[:, 2])
    x, y, turn = error.T
    fed = error.copy()
    fed[run.scenario.trajectory.reverse[: len(run)], 1] *= -1
    columns = [cosine * x + sine * y, cosine * y - sine * x, turn, table["v"], table["omega"]]
    for channel in range(3):
        columns += [np.roll(fed[:, channel], age) for age in range(1, controller.memory + 2)]
    if controller.form == "incremental":
        columns += [np.roll(table[f"tau_fb_{side}"], 1) for side in ("left", "right")]
    for age in range(run.scenario.delay, 0, -1):
        columns += [np.roll(table[f"tau_{side}"], age) for side in ("left", "right")]
    return np.column_stack(columns)


@pytest.mark.parametrize(
    ("controller", "settings", "bound"),
    [
        (PUBLISHED, {}, 3e-3),
        (PUBLISHED, {"heading": "continuous"}, 1e-4),
        (Controller.tuned_nominal(), {}, 1e-4),
        (Controller.tuned_nominal(), {"delay": 1, "viscous_friction": 0.01}, 1e-3),
    ],
)
def test_two_runs_come_together_as_the_jacobians_say(controller, settings, bound):
    scenario = Scenario.published(laps=4, **settings)
    found = stability.loop(scenario, controller)
    assert found.verdict == "stable"
    steps = jacobians(scenario, controller, found)
    one = states(simulate(scenario, controller))
    other = states(simulate(scenario.replace(initial_pose=(3.9, 0.1, 1.1)), controller))
    begin, end = 1100, 1700  # over a cusp
    deviation = other[begin] - one[begin]
    assert 1e-9 < np.linalg.norm(deviation) < 0.05
    for k in range(begin, end):
        deviation = steps[k % found.period] @ deviation
    difference = other[end] - one[end]
    assert np.linalg.norm(deviation - difference) < bound * np.linalg.norm(difference)


def test_a_perturbed_start_contracts_at_the_spectral_radius():
    scenario = Scenario.published(laps=6)
    found = stability.loop(scenario, PUBLISHED)
    run = states(simulate(scenario, PUBLISHED))
    # Once the deviation is along the slowest direction, a lap multiplies it by the multiplier.
    laps = [run[750 * lap + 100] - found.orbit[100] for lap in (3, 4, 5)]
    for before, after in pairwise(laps):
        ratio = np.dot(before, after) / np.dot(before, before)
        assert ratio == pytest.approx(found.multipliers[0].real, rel=5e-3)


def test_a_run_leaves_an_unstable_orbit_at_the_spectral_radius():
    start = {"initial_pose": (1e-11, 2e-11, 1e-11), "initial_velocity": "reference"}
    scenario = Scenario(Trajectory.line(), **start)
    found = stability.loop(scenario, INCREMENTAL)
    assert (found.period, found.verdict) == (1, "unstable")
    assert found.agrees
    run = states(simulate(scenario, INCREMENTAL))
    deviation = np.linalg.norm(run[40:95] - found.orbit[0], axis=1)
    assert deviation[-1] < 0.1
    growth = np.polyfit(np.arange(55), np.log(deviation), 1)[0]
    assert growth == pytest.approx(found.log_radius, rel=0.03)


@pytest.mark.parametrize("name", ["line", "circle"])
def test_on_line_and_circle_the_map_is_one_sample(name):
    scenario = Scenario(getattr(Trajectory, name)())
    found = stability.loop(scenario, Controller.tuned_nominal())
    assert (found.period, found.laps) == (1, 0)
    assert found.verdict == "stable"
    assert found.agrees
    assert found.orbit.shape == (1, len(found.state_names)) == (1, 25)
    if name == "line":  # nothing to correct
        np.testing.assert_allclose(found.orbit[0, :3], 0, atol=1e-9)


def test_a_circle_is_not_one_sample_in_the_worlds_frame():
    scenario = Scenario(Trajectory.circle(period=60))
    assert stability.loop(scenario, Controller.published(frame="world")).period == 300


def test_states_are_named_in_order():
    found = stability.loop(Scenario.published(delay=2), Controller.tuned_nominal())
    names = found.state_names
    assert len(names) == 5 + 18 + 2 + 4 == found.orbit.shape[1]
    assert names[:5] == ("e_x", "e_y", "e_theta", "v", "omega")
    assert names[5] == "e_x(k-1)"
    assert names[-6:-4] == ("tau_fb_left(k-1)", "tau_fb_right(k-1)")
    assert names[-4:] == ("tau_left(k-2)", "tau_right(k-2)", "tau_left(k-1)", "tau_right(k-1)")


def test_switches_are_the_orbits():
    scenario = Scenario.published()
    found = stability.loop(scenario, PUBLISHED)
    wrap = np.pi - np.abs(found.orbit[:, 2])
    assert found.heading_wrap.distance == pytest.approx(wrap.min())
    assert found.heading_wrap.sample == wrap.argmin()
    run = simulate(Scenario.published(laps=6))
    torque = np.abs(run.torque[750 * 4 : 750 * 5])
    for wheel, switch in enumerate((found.torque_left, found.torque_right)):
        nearest = np.abs(scenario.torque_limit - torque[:, wheel])
        assert switch.distance == pytest.approx(nearest.min(), abs=1e-3)
        # The three cusps are alike but for rounding: the first one is named.
        assert switch.sample <= 250
        assert nearest[switch.sample] == pytest.approx(nearest.min(), abs=1e-3)
    assert found.limited_samples == 0


def test_the_verdict_of_samples_is_that_of_the_named_path():
    path = Trajectory.ranunculoid()
    sampled = Trajectory.from_samples(path.x, path.y, path.dt)
    named = stability.loop(Scenario(path), PUBLISHED)
    found = stability.loop(Scenario(sampled), PUBLISHED)
    assert found.period == named.period
    assert found.log_radius == pytest.approx(named.log_radius, rel=1e-6)


def test_noise_is_left_out():
    quiet = stability.loop(Scenario.published(), PUBLISHED)
    noisy = stability.loop(Scenario.published(pose_noise=(0.1, 0.1)), PUBLISHED)
    assert noisy.log_radius == quiet.log_radius
    assert noisy.simulated == quiet.simulated


def test_what_the_speed_is_scaled_by_is_the_scenarios():
    controller = Controller.tuned_nominal().replace(lateral="speed")
    scenario = Scenario.published()
    given = controller.replace(speed_scale=scenario.trajectory.peak_speed)
    found = stability.loop(scenario, controller)
    assert found.log_radius == stability.loop(scenario, given).log_radius
    # No central difference exceeds the larger one-sided one: more laps have the same peak speed.
    longer = repeated(scenario.trajectory, 4)
    assert longer.peak_speed == pytest.approx(scenario.trajectory.peak_speed, rel=1e-9)
    assert found.agrees


def test_the_robot_matters():
    heavy = stability.loop(Scenario.published(robot=Robot(mass=23)), PUBLISHED)
    assert heavy.log_radius != stability.loop(Scenario.published(), PUBLISHED).log_radius


def test_what_cannot_be_analysed_is_refused():
    with refused("stability.loop", "trajectory.period is 150.1 s, 750.", "whole number of samples"):
        stability.loop(Scenario.published(period=150.1))
    open_path = Trajectory.from_samples([0, 1, 2, 3, 5, 7, 9, 8, 7], [0, 1, 0, 1, 2, 3, 1, 1, 0], 1)
    with refused("distance of the trajectory's ends is 7 m", "in [0, 1e-06] m", "periodic"):
        stability.loop(Scenario(open_path))
    with refused("number of states (memory 65, delay 0) is 203", "in [1, 200]"):
        stability.loop(controller=Controller.published(memory=65, alpha=1.5))
    with refused("disturbance is one pair a sample", "constant"):
        stability.loop(Scenario.published(disturbance=np.zeros((751, 2))))
    with refused("trajectory.period / dt is 15000", "in [1, 10000] samples"):
        stability.loop(Scenario.published(dt=0.01))


def test_the_text_has_verdict_radius_and_switches():
    text = str(stability.loop())
    assert text.startswith("stable; simulation after 4 periods")
    assert "spectral radius 0.09112 a period, 0.996811 a sample" in text
    assert "heading error from pi at least 2.57 rad, at sample 1" in text


def test_long_memory_takes_part_as_modes():
    circle = Scenario(Trajectory.circle(period=60))
    plain = stability.loop(circle, PUBLISHED.replace(memory=60))
    for memory, verdict in ((100, "stable"), (np.inf, "marginal")):
        found = stability.loop(circle, PUBLISHED.replace(memory=memory))
        assert found.verdict == verdict
        assert len(found.state_names) == found.orbit.shape[1] <= 200
        assert found.state_names.count("e_y(k-9)") == 1
        assert "e_y(k-10)" not in found.state_names
        assert "mode_y(1)" in found.state_names
        # The robot's own numbers on the orbit are those of a plain memory, nearly.
        np.testing.assert_allclose(found.orbit[0, :5], plain.orbit[0, :5], atol=2e-3)
