"""tune(objectives=...): what a front is, that it is of simulate()'s numbers, how it ends."""

import json
import os
import pickle
import signal
import sys

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, ParetoResult, Rival, Scenario, Trajectory
from nfopidn.tuning import pareto
from nfopidn.tuning.pareto import OBJECTIVES
from nfopidn.tuning.plan import Plan

SHORT = Scenario.published(period=100.0, rng=0)
PAIR = ("position_rms", "torque_variation")
SETTINGS = {
    "robustness": None,
    "structure": "decoupled",
    "rng": 3,
    "maxfev": 600,
    "population": 40,
}


def front_of(scenario=SHORT, objectives=PAIR, **changes):
    """A front that is small and quick."""
    return nfopidn.tune(scenario, objectives=objectives, **{**SETTINGS, **changes})


@pytest.fixture(scope="module")
def front():
    """One to look at."""
    return front_of()


def dominates(a, b):
    """Whether a is at least as good in all and better in one."""
    return bool((a <= b).all() and (a < b).any())


def test_the_front_is_of_the_metrics_that_simulate_gives(front):
    assert isinstance(front, ParetoResult)
    assert front.success
    assert len(front) == len(front.controllers) == len(front.objectives) >= 5
    for controller, row in zip(front.controllers, front.objectives, strict=True):
        metrics = nfopidn.simulate(SHORT, controller).metrics
        assert [metrics[name] for name in PAIR] == row.tolist()


def test_no_point_of_a_front_dominates_another(front):
    rows = front.objectives
    assert not any(dominates(a, b) for a in rows for b in rows)
    assert (np.diff(rows[:, 0]) > 0).all()
    assert (np.diff(rows[:, 1]) < 0).all()


def test_the_points_are_within_the_bounds_and_make_the_controllers(front):
    low, high = front.bounds.T
    assert ((front.x >= low) & (front.x <= high)).all()
    assert front.parameters == list(nfopidn.default_bounds("decoupled"))
    gains = np.array([one.gains.ravel() for one in front.controllers])
    np.testing.assert_array_equal(gains, front.x[:, :9])


def test_a_front_knows_its_best_single_costs(front):
    # The search for the cost alone is a part of it, so that no point of that dominates the front.
    single = nfopidn.tune(SHORT, robustness=None, structure="decoupled", rng=3, maxfev=120)
    metrics = nfopidn.simulate(SHORT, single.controller).metrics
    row = np.array([metrics[name] for name in PAIR])
    assert not any(dominates(row, other) for other in front.objectives)


def test_the_hypervolume_grows_to_what_it_is(front):
    history = front.history
    assert (np.diff(history["hypervolume"]) >= 0).all()
    assert (np.diff(history["nfev"]) > 0).all()
    assert history["nfev"][-1] == front.nfev <= 600
    assert history["points"][-1] == len(front)
    # Of two objectives it is a sum of rectangles.
    low = front.objectives.min(axis=0)
    width = front.reference_point - low
    rows = (front.objectives - low) / width
    right = np.append(rows[1:, 0], 1.0)
    area = float(((right - rows[:, 0]) * (1.0 - rows[:, 1])).sum())
    assert history["hypervolume"][-1] == pytest.approx(area, rel=1e-12)
    high = front.objectives.max(axis=0)
    np.testing.assert_allclose(front.reference_point, high + 0.1 * (high - low), rtol=1e-14)


def test_the_seed_alone_decides(front):
    again = front_of(workers=2)
    for name in ("objectives", "x", "history"):
        np.testing.assert_array_equal(again[name], front[name])
    assert again.seed == front.seed == 3
    other = front_of(rng=4)
    assert other.objectives.shape != front.objectives.shape or (other.x != front.x).any()


def test_a_generation_is_as_large_as_asked():
    front = front_of(population=10, maxfev=100)
    assert front.population == 10
    assert np.diff(front.history["nfev"]).tolist() == [10] * (len(front.history) - 1)


def test_over_several_scenarios_objectives_are_means_over_the_worst_share():
    heavy = SHORT.replace(robot=SHORT.robot.replace(mass=14.0), model=SHORT.robot)
    family = nfopidn.Family(
        ("own", "heavy", "late"), (SHORT, heavy, SHORT.replace(delay=1)), ("",) * 3
    )
    names = ("cost", "worst", "heading_rms")
    front = front_of(family, names, maxfev=300, worst_share=2 / 3)
    for controller, row in zip(front.controllers, front.objectives, strict=True):
        runs = nfopidn.simulate_many(family, controller)
        worst = np.sort(runs.costs)[::-1]
        rms = np.sort(runs.metrics["heading_rms"])[::-1]
        assert row == pytest.approx([worst[:2].mean(), worst[0], rms[:2].mean()], rel=1e-12)
    assert front.scenario == list(family)
    assert front.family is family


def test_costs_beyond_the_cap_count_by_their_logarithm():
    scenarios = [SHORT, SHORT.replace(delay=1)]
    front = front_of(scenarios, ("worst", "energy"), maxfev=200, cost_cap=0.01)
    for controller, row in zip(front.controllers, front.objectives, strict=True):
        costs = nfopidn.simulate_many(scenarios, controller).costs
        seen = np.where(costs > 0.01, 0.01 * (1 + np.log(costs / 0.01)), costs)
        assert row[0] == pytest.approx(seen.max(), rel=1e-12)


def test_a_robust_search_is_over_the_variations():
    front = nfopidn.tune(
        SHORT, objectives=("position_rms", "worst"), rng=1, maxfev=200, population=20
    )
    assert front.structure == "tracking"
    assert len(front.family) > 10
    runs = nfopidn.simulate_many(front.family, front.controllers[0])
    assert not runs.diverged.any()
    assert front.objectives[0, 0] == pytest.approx(runs.metrics["position_rms"].mean(), rel=1e-12)
    assert front.scenario == SHORT
    verdict = front.verdict(0)
    assert verdict.is_of(front.controllers[0], SHORT)
    assert front.verdict(0) is verdict


def test_a_rival_has_a_front_too():
    front = front_of(structure="samson", maxfev=200, population=20)
    assert all(isinstance(one, Rival) for one in front.controllers)
    metrics = nfopidn.simulate(SHORT, front.controllers[-1]).metrics
    assert front.objectives[-1].tolist() == [metrics[name] for name in PAIR]


def test_frozen_parameters_and_a_start_are_heeded():
    start = nfopidn.tune(SHORT, robustness=None, structure="decoupled", rng=1, maxfev=500)
    alpha = start.controller.alpha
    front = front_of(start=start.controller, frozen={"alpha": alpha}, maxfev=100)
    assert "alpha" not in front.parameters
    assert {one.alpha for one in front.controllers} == {alpha}


def test_choosing_by_weights_is_the_least_weighted_share(front):
    rows = front.objectives
    shares = (rows - rows.min(axis=0)) / np.ptp(rows, axis=0)
    for weights in ((1.0, 0.0), (0.0, 1.0), (3.0, 1.0)):
        place = front.choose(weights)
        assert place == int(np.argmin(shares @ np.array(weights)))
    assert front.choose({"torque_variation": 1.0}) == len(front) - 1
    # In the plane the knee is farthest under the line between the ends.
    assert front.choose() == front.choose("knee") == int(np.argmin(shares.sum(axis=1)))


def test_the_knee_in_space_is_farthest_under_the_plane_through_the_extremes():
    front = front_of(objectives=("position_rms", "heading_rms", "torque_variation"), maxfev=1000)
    rows = front.objectives
    shares = (rows - rows.min(axis=0)) / np.ptp(rows, axis=0)
    a, b, c = shares[np.argmin(shares, axis=0)]
    normal = np.cross(b - a, c - a)
    normal *= np.sign(normal.sum())
    assert (normal > 0).all()  # else there is no such plane
    distance = (a - shares) @ normal
    assert distance[front.choose()] == pytest.approx(distance.max(), rel=1e-9)


@pytest.mark.parametrize(
    ("by", "text"),
    [
        ("ankle", "must be 'knee' or weights"),
        ((1.0,), "must have 2 weights"),
        ((1.0, -1.0), "0 or more"),
        ((0.0, 0.0), "not all 0"),
        ({"energy": 1.0}, "by names 'energy'"),
    ],
)
def test_a_choice_that_is_none_is_refused(front, by, text):
    with pytest.raises(ValueError, match=text):
        front.choose(by)


def test_a_place_that_is_none_is_refused(front):
    with pytest.raises(ValueError, match="place is"):
        front.verdict(len(front))


def test_a_point_is_a_tuning_result(front, tmp_path):
    point = front.at(2)
    assert isinstance(point, nfopidn.TuneResult)
    assert point.fun == front.objectives[2, 0]
    assert point.controller == front.controllers[2]
    assert str(front.objectives[2, 0])[:6] in str(point)
    point.to_json(tmp_path / "point.json")
    again = nfopidn.TuneResult.from_json(tmp_path / "point.json")
    assert again.controller == point.controller
    assert again.x.tolist() == front.x[2].tolist()


def test_files_and_pickles_keep_everything(front, tmp_path):
    path = tmp_path / "front.json"
    front.to_json(path)
    for again in (ParetoResult.from_json(path), pickle.loads(pickle.dumps(front))):
        assert set(again) == set(front)
        for name in ("objectives", "x", "bounds", "reference_point", "history"):
            np.testing.assert_array_equal(again[name], front[name])
        for name in ("objective_names", "parameters", "seed", "message", "structure", "nfev"):
            assert again[name] == front[name]
        assert again.controllers == front.controllers
        assert again.scenario == SHORT
    front.to_csv(tmp_path / "front.csv")
    lines = (tmp_path / "front.csv").read_text().splitlines()
    assert lines[0].split(",") == [*PAIR, *front.parameters]
    table = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
    np.testing.assert_array_equal(table, np.hstack([front.objectives, front.x]))


def test_a_file_that_is_no_front_is_refused(front, tmp_path):
    path = tmp_path / "front.json"
    front.to_json(path)
    document = json.loads(path.read_text())
    document["objectives"] = document["objectives"][1:]
    path.write_text(json.dumps(document))
    with pytest.raises(ValueError, match=r"front\.json: not a Pareto front"):
        ParetoResult.from_json(path)
    path.write_text("{}")
    with pytest.raises(ValueError, match="not a Pareto front"):
        ParetoResult.from_json(path)


def test_it_prints_as_a_table(front):
    text = str(front)
    assert "position_rms [m]" in text
    assert "torque_variation [N m]" in text
    assert "(knee)" in text
    assert repr(front).startswith(f"ParetoResult({len(front)} points of position_rms")


def test_a_callback_sees_the_front_and_may_end_the_search():
    seen = []

    def callback(result):
        seen.append(len(result.controllers))
        return len(seen) == 3

    front = front_of(callback=callback)
    assert len(seen) == 3 == front.nit
    assert seen[-1] == len(front)
    assert front.message == "The callback asked to stop."


def test_ctrl_c_gives_the_front_so_far():
    def callback(result):
        if result.nit == 2:
            os.kill(os.getpid(), signal.SIGINT)

    front = front_of(callback=callback)
    assert front.nit == 2
    assert not front.success
    assert "interrupted" in front.message
    assert len(front) > 0


def test_ctrl_c_in_the_search_for_cost_gives_the_best_of_it(monkeypatch):
    run = Plan.run

    def interrupted(self, settings, callback):
        found = run(self, settings, callback)
        os.kill(os.getpid(), signal.SIGINT)
        return found

    monkeypatch.setattr(Plan, "run", interrupted)
    front = front_of(structure="extended", maxfev=2000)
    assert not front.success
    assert "interrupted" in front.message
    assert front.nit == 1
    assert front.nfev in (408, 439)  # eight of its points, or a generation that was under way
    single = nfopidn.tune(SHORT, robustness=None, structure="extended", rng=3, maxfev=400)
    metrics = nfopidn.simulate(SHORT, single.controller).metrics
    row = np.array([metrics[name] for name in PAIR])
    assert not any(dominates(row, other) for other in front.objectives)
    assert any((other <= row).all() for other in front.objectives)


def test_ctrl_c_before_there_is_anything_raises(monkeypatch):
    def interrupted(self, settings, callback):
        os.kill(os.getpid(), signal.SIGINT)
        raise KeyboardInterrupt

    monkeypatch.setattr(Plan, "run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        front_of()


def test_the_time_is_kept(monkeypatch):
    # A clock of its own, of 1000 s a look: one as it begins, and one after each generation.
    looks = iter(range(0, 10**6, 1000))
    monkeypatch.setattr(pareto, "monotonic", lambda: next(looks))
    front = front_of(maxfev=10**4, maxtime=3500.0)
    assert front.message == "The time is up."
    assert front.nit == 4


def test_where_everything_diverges_the_front_is_empty():
    # It starts at its limit, at rest, while the reference drives away.
    line = Scenario(Trajectory.line(period=20.0), initial_pose=(-0.1, 0.0, 0.0), rng=0)
    front = front_of(line.replace(divergence_distance=0.1 + 1e-9), maxfev=100)
    assert len(front) == 0
    assert not front.success
    assert "has a run that diverges" in front.message
    assert front.controllers == []
    with pytest.raises(ValueError, match="front is empty"):
        front.choose()
    assert "0 points" in str(front)


@pytest.mark.parametrize(
    ("objectives", "text"),
    [
        (("position_rms", "torqe_variation"), r"did you mean 'torque_variation'\?"),
        (("position_rms",), "has 1 names; must have 2 to 6"),
        ((), "has 0 names"),
        (("cost", "energy", "cost"), "'cost' twice"),
        (OBJECTIVES[2:9], "has 7 names"),
        ("cost", "must be a list of names"),
        (("cost", 3), "must be a list of names"),
        (("cost", "worst"), "is over one scenario"),
    ],
)
def test_objectives_that_are_none_are_refused(objectives, text):
    with pytest.raises(ValueError, match=text):
        front_of(objectives=objectives)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"structure": "taps"}, "'taps' is tried with two values of lateral"),
        ({"stopval": 0.1}, "stopval is of one cost"),
        ({"checkpoint": "front.checkpoint"}, "checkpoint is of a search for one cost"),
        ({"population": 4}, r"population is 4; must be a whole number in \[8, 10000\]"),
        ({"maxfev": 79}, "at least twice the population, 80"),
        ({"constraints": {"energy": (None, 1.0)}}, "must be None with objectives"),
        ({"method": "nsga2"}, "method is 'nsga2'"),
    ],
)
def test_settings_that_do_not_fit_are_refused(changes, text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=text):
        front_of(**changes)


def test_without_pymoo_it_is_said_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pymoo.algorithms.moo.nsga2", None)
    with pytest.raises(ImportError, match=r'pip install "nfopidn\[pareto\]"'):
        front_of()


def test_free_taps_with_one_law_have_a_front():
    front = front_of(
        structure={"allocation": "decoupled", "lateral": "speed", "parameters": "taps"},
        maxfev=100,
    )
    assert len(front) > 0
    assert isinstance(front.controllers[0], Controller)
