"""tune(constraints=...): what is kept to, in what order, and what is said where it is not."""

import os
import pickle
import signal

import nfopidn
import numpy as np
import pytest
from nfopidn import Scenario, TuneResult, _core
from nfopidn.robustness.limits import find_limits, find_margin
from nfopidn.robustness.long_runs import OnPath
from nfopidn.tuning.constrained import BROKEN, told
from nfopidn.tuning.constraints import CONSTRAINTS, Judge, check_constraints

SHORT = Scenario.published(period=100.0, rng=0)
SETTINGS = {"robustness": None, "structure": "decoupled", "rng": 2, "maxfev": 1200}


def tuned(constraints=None, scenario=SHORT, **changes):
    """A search that is small and quick."""
    return nfopidn.tune(scenario, constraints=constraints, **{**SETTINGS, **changes})


@pytest.fixture(scope="module")
def free():
    """The search without constraints."""
    return tuned()


def test_a_metric_is_kept_under_its_limit_at_a_cost(free):
    before = nfopidn.simulate(SHORT, free.controller).metrics["torque_variation"]
    limit = 0.95 * before
    result = tuned({"torque_variation": (None, limit)})
    run = nfopidn.simulate(SHORT, result.controller)
    assert result.success
    assert run.metrics["torque_variation"] <= limit
    row = result.constraints["torque_variation"]
    assert row == {
        "value": run.metrics["torque_variation"],
        "low": None,
        "high": limit,
        "unit": "N m",
        "met": True,
    }
    # The constraint is what the answer lies on, and the cost is told as it is.
    assert run.metrics["torque_variation"] > 0.97 * limit
    assert result.fun == pytest.approx(run.cost, rel=1e-9)
    assert result.fun > free.fun
    assert result.nfev == 1200
    assert result.history["nfev"][-1] == 1200
    np.testing.assert_array_equal(
        nfopidn.Objective(SHORT, structure="decoupled").parameters_of(result.controller), result.x
    )


def test_margins_and_delay_are_those_of_the_verdict():
    limits = {"gain_margin": (9.0, None), "delay_bearable": (1.0, None)}
    result = tuned(limits)
    assert result.success
    on_path = OnPath(SHORT, result.controller.replace(robot=None))
    borne = find_limits(on_path).extra_delay
    margin = find_margin(on_path, SHORT, borne)
    assert result.constraints["gain_margin"]["value"] == margin.decibels >= 9.0
    assert result.constraints["gain_margin"]["unit"] == "dB"
    assert result.constraints["delay_bearable"]["value"] == borne >= 1
    assert all(row["met"] for row in result.constraints.values())


def test_what_cannot_be_kept_is_said_and_is_no_success():
    result = tuned({"position_rms": (None, 1e-6), "energy": (0.0, None)}, maxfev=400)
    assert not result.success
    row = result.constraints["position_rms"]
    assert not row["met"]
    assert result.constraints["energy"]["met"]
    expected = f"position_rms is {row['value']:.6g}; must be at most 1e-06 m"
    assert expected in result.message
    assert "energy" not in result.message
    assert row["value"] == nfopidn.simulate(SHORT, result.controller).metrics["position_rms"]


def test_the_least_violation_wins_where_nothing_keeps_to_all(free):
    result = tuned({"position_rms": (None, 1e-6)})
    least = result.constraints["position_rms"]["value"]
    assert least < nfopidn.simulate(SHORT, free.controller).metrics["position_rms"]


def test_the_seed_alone_decides():
    limits = {"torque_variation": (None, 30.0), "gain_margin": (8.0, None)}
    one, two = (tuned(limits, maxfev=600, workers=workers) for workers in (1, 2))
    np.testing.assert_array_equal(one.x, two.x)
    np.testing.assert_array_equal(one.history, two.history)
    assert one.fun == two.fun
    assert one.constraints == two.constraints


def test_a_constraint_that_binds_nothing_changes_the_answer_to_no_worse(free):
    result = tuned({"diverged": (None, 0)})
    first = tuned(maxfev=600)
    assert result.fun <= first.fun
    assert result.constraints["diverged"]["value"] == 0.0


def test_diverged_counts_the_scenarios_that_are_searched():
    judge = Judge(check_constraints({"diverged": (None, 0)}), [SHORT], [SHORT] * 3, 1)
    lost = Scenario.published(period=25.0, rng=0)
    judge.searched[1] = lost
    bad = nfopidn.Controller.published()
    assert nfopidn.simulate(lost, bad).diverged_at is not None
    assert judge.table(bad)["diverged"]["value"] == 1.0
    assert judge.run_violation([bad])[0] > 0


def test_a_metric_of_a_run_that_diverges_is_infinite_and_breaks_its_limit():
    lost = Scenario.published(period=25.0, rng=0)
    judge = Judge(check_constraints({"position_rms": (None, 100.0)}), [lost], [lost], 1)
    row = judge.table(nfopidn.Controller.published())["position_rms"]
    assert np.isinf(row["value"])
    assert not row["met"]


def test_of_several_scenarios_the_worst_counts():
    scenarios = [SHORT, SHORT.replace(delay=1), SHORT.replace(initial_pose=(3.0, 0.0, 1.0))]
    controller = nfopidn.Controller.recommended().replace(robot=None)
    rms = [nfopidn.simulate(one, controller).metrics["position_rms"] for one in scenarios]
    for pair, worst in (
        ((None, 1.0), max(rms)),
        ((None, 1e-3), max(rms)),
        ((1e-9, None), min(rms)),
        ((1.0, None), min(rms)),
    ):
        judge = Judge(check_constraints({"position_rms": pair}), scenarios, scenarios, 1)
        assert judge.table(controller)["position_rms"]["value"] == worst


def test_a_robust_search_keeps_to_constraints_on_the_scenario_given():
    limits = {"diverged": (None, 0), "position_max": (None, 1.2)}
    result = nfopidn.tune(SHORT, constraints=limits, rng=1, maxfev=400)
    value = nfopidn.simulate(SHORT, result.controller).metrics["position_max"]
    assert result.constraints["position_max"]["value"] == value
    lost = nfopidn.simulate_many(result.family, result.controller).diverged.sum()
    assert result.constraints["diverged"]["value"] == lost


def test_a_rival_keeps_to_constraints_too():
    free = tuned(structure="samson", maxfev=600)
    limit = 0.9 * nfopidn.simulate(SHORT, free.controller).metrics["torque_variation"]
    result = tuned({"torque_variation": (None, limit)}, structure="samson", maxfev=600)
    assert result.success
    run = nfopidn.simulate(SHORT, result.controller)
    assert run.metrics["torque_variation"] <= limit
    assert result.fun == run.cost


def test_numbers_that_the_search_is_told_keep_debs_order():
    costs = np.array([0.0, 1.0, 499.0, 500.0, 501.0, 1e4, 1e9])
    seen = told(costs)
    assert (np.diff(seen) > 0).all()
    assert seen[:4].tolist() == costs[:4].tolist()
    assert seen[-1] < BROKEN
    limits = {one.name: one for one in check_constraints({"energy": (1.0, 2.0)})}
    found = limits["energy"].violation(np.array([1.0, 2.0, 2.2, 4.0, np.inf, 0.5, np.nan]))
    (margin,) = check_constraints({"gain_margin": (6.0, None)})
    assert margin.violation(np.array([np.inf, 3.0, np.nan])).tolist() == [0.0, 0.5 / 1.5, 1.0]
    (least,) = check_constraints({"energy": (1.0, None)})
    assert least.violation(np.array([np.inf, 2.0])).tolist() == [1.0, 0.0]
    assert found[:2].tolist() == [0.0, 0.0]
    assert found[2] == pytest.approx(0.1 / 1.1)
    assert (np.diff(found[1:5]) > 0).all()
    assert found[5] == pytest.approx(0.5 / 1.5)
    assert found[6] == 1.0


def test_analyses_are_made_of_what_could_be_the_answer_alone(monkeypatch):
    asked = []
    loop_violation = Judge.loop_violation

    def counted(self, controller):
        asked.append(nfopidn.simulate(SHORT, controller).cost)
        return loop_violation(self, controller)

    monkeypatch.setattr(Judge, "loop_violation", counted)
    result = tuned({"gain_margin": (6.0, None)}, maxfev=600)
    assert result.success
    assert 0 < len(asked) < 100
    assert min(asked) <= result.fun * (1 + 1e-9)


def test_a_callback_sees_points_within_the_bounds_and_all_evaluations():
    seen = []

    def callback(result):
        seen.append((result.nfev, result.x))

    result = tuned({"torque_variation": (None, 30.0)}, maxfev=600, callback=callback)
    counts = [nfev for nfev, _ in seen]
    assert counts == sorted(counts)
    assert 500 < counts[-1] <= result.nfev
    low, high = np.array(list(nfopidn.default_bounds("decoupled").values())).T
    assert max(x.max() for _, x in seen) > 1  # in the parameters' units, not in the box's
    assert all(((x >= low) & (x <= high)).all() for _, x in seen)


@pytest.mark.parametrize("late", [False, True])
def test_ctrl_c_gives_the_best_so_far(late):
    def callback(result):
        if (result.nfev > 700) == late:
            os.kill(os.getpid(), signal.SIGINT)

    result = tuned({"torque_variation": (None, 30.0)}, callback=callback)
    assert not result.success
    assert "interrupted" in result.message
    assert "torque_variation" in result.constraints
    assert (result.nfev > 700) == late


def test_the_table_is_kept_in_files(tmp_path):
    result = tuned({"torque_variation": (None, 30.0)}, maxfev=200)
    result.to_json(tmp_path / "result.json")
    assert TuneResult.from_json(tmp_path / "result.json").constraints == result.constraints
    assert pickle.loads(pickle.dumps(result)).constraints == result.constraints


def test_every_constraint_has_a_value_and_a_unit():
    controller = nfopidn.Controller.recommended().replace(robot=None)
    limits = check_constraints(dict.fromkeys(CONSTRAINTS, (0.0, None)))
    table = Judge(limits, [SHORT], [SHORT], 1).table(controller)
    assert set(table) == set(CONSTRAINTS) >= {*_core.metric_fields(), "gain_margin", "diverged"}
    assert {name: row["unit"] for name, row in table.items()} == {
        name: unit for name, (unit, _) in CONSTRAINTS.items()
    }


@pytest.mark.parametrize(
    ("constraints", "text"),
    [
        ({}, "must be a mapping by name"),
        (["energy"], "must be a mapping by name"),
        ({"position_rsm": (None, 1.0)}, r"'position_rsm' \(did you mean 'position_rms'\?\)"),
        ({"energy": 1.0}, r"constraints\['energy'\] is 1.0; must be \(low, high\)"),
        ({"energy": (None, None)}, "must limit something"),
        ({"energy": (-np.inf, np.inf)}, "must limit something"),
        ({"energy": (2.0, 1.0)}, "low must not be above high"),
        ({"energy": (np.inf, None)}, "allow some value"),
        ({"energy": (None, np.nan)}, r"must be \(low, high\)"),
        ({"energy": (None, "1")}, r"must be \(low, high\)"),
    ],
)
def test_constraints_that_are_none_are_refused(constraints, text):
    with pytest.raises(ValueError, match=text):
        tuned(constraints)


def test_a_checkpoint_does_not_fit(tmp_path):
    with pytest.raises(ValueError, match="checkpoint must be None with constraints"):
        tuned({"energy": (None, 1.0)}, checkpoint=tmp_path / "search")


@pytest.mark.parametrize(
    "asked", [{"objectives": ("cost", "position_rms")}, {"constraints": {"cost": (None, 1)}}]
)
def test_engines_are_for_a_plain_search(asked):
    with pytest.raises(ValueError, match=r"workers is .*map.*; with objectives or"):
        nfopidn.tune(robustness=None, rng=0, workers=map, **asked)
