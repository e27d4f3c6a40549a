"""Many runs of which only the figures are kept: simulate()'s bits, in memory that is bounded."""

import resource
import sys

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Rival, Robot, Scenario, Trajectory, _core
from nfopidn.comparison import METRICS

SHORT = Scenario.published(period=60.0, rng=0)
NOISE = (0.02, 0.02)


def figures(run):
    """What the core measures of a run, from its columns."""
    at = np.nan if run.diverged_at is None else run.diverged_at
    return [*run.metrics.values(), _core.settling_time(run), _core.torque_deviation(run), at]


@pytest.mark.parametrize("source", ["counter", "mersenne"])
@pytest.mark.parametrize(
    "controller",
    [Controller.published(), Controller.recommended(), Rival("samson")],
    ids=["published", "recommended", "rival"],
)
def test_draws_are_the_runs_of_simulate_to_the_last_bit(source, controller):
    scenario = SHORT.replace(pose_noise=NOISE, noise_source=source)
    seeds = [5, 3, 2**52, *range(100, 134)]  # more than fit a block of lanes, and no multiple of it
    rows = _core.measure_draws(scenario, controller, seeds, 2)
    for seed, row in zip(seeds, rows, strict=True):
        run = nfopidn.simulate(scenario.replace(rng=seed), controller)
        np.testing.assert_array_equal(row, figures(run))
    assert len({tuple(row) for row in rows}) == len(seeds)


def test_lanes_that_diverge_leave_the_others_as_they_are():
    scenario = SHORT.replace(pose_noise=(0.2, 0.2), noise_source="counter")
    costs = _core.measure_draws(scenario, Controller.recommended(), range(64), 1)
    far = float(np.quantile(costs[:, _core.FIGURES.index("position_max")], 0.5))
    scenario = scenario.replace(divergence_distance=far)
    rows = _core.measure_draws(scenario, Controller.recommended(), range(64), 1)
    lost = np.isfinite(rows[:, _core.FIGURES.index("diverged_at")])
    assert 16 < lost.sum() < 48
    for seed, row in enumerate(rows):
        run = nfopidn.simulate(scenario.replace(rng=seed), Controller.recommended())
        np.testing.assert_array_equal(row, figures(run))


def test_the_scenarios_of_a_family_share_lanes_where_they_may():
    base = SHORT.replace(noise_source="counter", pose_noise=NOISE, model=Robot.eddie())
    scenarios = [
        *[base.replace(rng=i, robot=Robot.eddie().replace(mass=10.0 + 0.1 * i)) for i in range(20)],
        *[base.replace(rng=i, delay=1) for i in range(3)],
        *[base.replace(rng=i, initial_pose=(4.0, 0.1 * i, 1.0)) for i in range(3)],
        base.replace(coulomb_friction=0.1),
        base.replace(coulomb_friction=0.1, integrator="exact"),  # not in lanes
        base.replace(pose_noise=(0.0, 0.0)),
        base.replace(torque_limit=1.0),
        base.replace(trajectory=Trajectory.circle(period=60.0), initial_pose=None),
        base.replace(noise_source="mersenne"),
        base.replace(disturbance=(1.0, 0.1)),
        base.replace(cost_weights=(2.0, 1.0, 0.5)),
        base.replace(model=Robot.eddie_datasheet()),
        base,
    ]
    for controller in (Controller.published(), Rival("lqr")):
        runs = nfopidn.simulate_many(scenarios, controller, workers=2)
        for place, scenario in enumerate(scenarios):
            run = nfopidn.simulate(scenario, controller)
            assert runs.costs[place] == run.cost
            assert {name: column[place] for name, column in runs.metrics.items()} == run.metrics
            at = runs.diverged_at[place]
            assert at == run.diverged_at or (np.isnan(at) and run.diverged_at is None)


def test_compare_in_lanes_has_the_figures_of_each_run():
    scenario = SHORT.replace(pose_noise=NOISE, noise_source="counter")
    members = [Controller.published(), Controller.tuned_nominal()]
    found = nfopidn.compare({"two": members, "rival": Rival("lqr")}, {"noisy": scenario}, seeds=9)
    assert found.values["cost"].shape == (2, 1, 18)
    for place in range(18):
        run = nfopidn.simulate(scenario.replace(rng=place % 9), members[place // 9])
        for name, metric in METRICS.items():
            assert found.values[name][0, 0, place] == metric.of(run)
    # One controller against lists of two: its nine draws count twice, and are told to be the same.
    np.testing.assert_array_equal(found.draws[1, 0], [*range(9), *range(9)])
    np.testing.assert_array_equal(found.draws[0, 0], np.arange(18))
    assert found.first_runs["two", "noisy"].cost == found.values["cost"][0, 0, 0]


def test_figures_are_those_of_the_columns():
    run = nfopidn.simulate(SHORT, Controller.recommended())
    c = run.columns
    squares = (c["tau_ref_left"] - c["tau_left"]) ** 2 + (c["tau_ref_right"] - c["tau_right"]) ** 2
    assert _core.torque_deviation(run) == pytest.approx(np.sqrt(squares.mean()), rel=1e-12)
    distance = np.hypot(c["x_ref"] - c["x"], c["y_ref"] - c["y"])
    settled = _core.settling_time(run)
    after = run.t > settled
    assert 0 < after.sum() < len(run)
    assert distance[after].max() <= 0.05 < distance[np.flatnonzero(after)[0] - 1]


@pytest.mark.skipif(sys.platform != "linux", reason="ru_maxrss has another unit elsewhere")
def test_many_draws_are_not_kept():
    path = Trajectory.circle(period=60.0)
    scenario = Scenario(path, pose_noise=(0.01, 0.01), noise_source="counter", rng=0)
    controllers = {"one": Controller.recommended().replace(robot=None)}
    nfopidn.compare(controllers, {"circle": scenario}, seeds=9000)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    found = nfopidn.compare(controllers, {"circle": scenario}, seeds=40_000)
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before  # [kB]
    assert found.values["cost"].shape == (1, 1, 40_000)
    # Ten columns twice and a block of rows are 10 MB; the runs themselves were 1.7 GB.
    assert grown < 40_000
