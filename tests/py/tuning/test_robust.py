"""The robust search, which is the default: what it is over, its cost, and what it says."""

import inspect
import json

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Family, Objective, Scenario, Trajectory, TuneResult
from nfopidn.tuning.robust import standard_family
from nominal import tune as nominal_tune

P = Scenario.published(rng=0)
SHORT = Scenario.published(rng=0, period=20)


def capped(costs, cap):
    return np.where(costs > cap, cap * (1 + np.log(np.maximum(costs, 1e-9) / cap)), costs)


def test_the_default_is_the_tracking_law_over_standard_variations():
    result = nfopidn.tune(SHORT, rng=1, maxfev=60)
    assert result.structure == "tracking"
    assert result.controller.net == "speed-errors"
    assert result.scenario == SHORT
    exact = SHORT.replace(integrator="exact", substeps=1)
    assert result.family[:14] == exact.variations("standard")
    assert len(result.family) == 18  # and four with the scenario's own integrator
    assert result.fun == nfopidn.tune(SHORT, rng=1, maxfev=60, workers=2).fun
    named = nfopidn.tune(SHORT, rng=1, maxfev=60, structure="tracking", robustness="standard")
    assert named.x.tolist() == result.x.tolist()
    runs = nfopidn.simulate_many(result.family, result.controller)
    assert result.fun == pytest.approx(capped(runs.costs, 1.0).mean(), rel=1e-9)
    assert inspect.signature(nfopidn.tune).parameters["robustness"].default == "standard"


def test_a_nominal_search_is_the_paper_s_over_the_scenario():
    result = nominal_tune(rng=1, maxfev=300)
    assert result.structure == "paper"
    assert "family" not in result
    assert nfopidn.simulate(P, result.controller).cost == pytest.approx(result.fun, rel=1e-9)


@pytest.mark.parametrize("structure", ["decoupled", "samson", {"law": "lqr"}])
def test_every_structure_is_searched_robustly(structure):
    result = nfopidn.tune(SHORT, structure=structure, rng=1, maxfev=60)
    assert result.family == standard_family([SHORT])
    runs = nfopidn.simulate_many(result.family, result.controller)
    assert result.fun == pytest.approx(capped(runs.costs, 1.0).mean(), rel=1e-9)


def test_a_family_is_searched_as_it_is():
    family = SHORT.variations(mass=(0.8, 1.2))
    result = nfopidn.tune(family, structure="decoupled", rng=1, maxfev=100, cost_cap=None)
    assert result.family is family
    costs = nfopidn.simulate_many(family, result.controller).costs
    assert result.fun == pytest.approx(costs.mean(), rel=1e-9)
    assert result.scenario == list(family)
    assert result.verdict.runs.names == family.names
    nominal = nominal_tune(family, structure="decoupled", rng=1, maxfev=100)
    assert nominal.x.tolist() == result.x.tolist()


def test_gains_for_an_ordinary_robot_take_it_back_to_its_path():
    """Friction alone teaches a search nothing of errors beside the path; starts there do."""
    path = Trajectory.eight(period=18.0, dt=0.02, scale=0.3, derivatives="analytic")
    robot = nfopidn.Robot(5.0, 0.08, 0.30, 0.033)
    scenario = Scenario(
        *(path, robot),
        torque_limit=0.6,
        coulomb_friction=0.03,
        integrator="exact",
        rng=0,
    )
    x, y, theta = path.x[0], path.y[0], path.theta[0]
    beside = scenario.replace(
        initial_pose=(x - 0.1 * np.sin(theta), y + 0.1 * np.cos(theta), theta)
    )

    def millimetres(one, controller):
        return 1e3 * nfopidn.simulate(one, controller).metrics["position_rms"]

    found = nfopidn.tune(scenario, rng=1, maxfev=4000)
    assert millimetres(scenario, found.controller) < 13
    assert millimetres(scenario.replace(delay=2), found.controller) < 16
    assert millimetres(beside, found.controller) < 38
    never = Family.of(
        (name, one, "") for name, one in found.family.items() if not name.startswith("start")
    )
    without = nfopidn.tune(never, rng=1, maxfev=4000, structure="tracking")
    lost = millimetres(beside, without.controller)
    assert lost > 1.05 * millimetres(beside, found.controller)


def test_several_scenarios_have_all_their_variations():
    eight = Scenario(Trajectory.eight(period=20), rng=0)
    family = nfopidn.tune([SHORT, eight], structure="decoupled", rng=1, maxfev=20).family
    assert len(family) == 36
    assert family.names[0] == "scenario 1/nominal"
    assert family["scenario 2/mass x1.2"].trajectory == eight.trajectory
    own = [name for name, one in family.items() if one.integrator != "exact"]
    assert own[:4] == [
        f"scenario 1/{name}, integrator semi-implicit-euler"
        for name in ("nominal", "mass x0.8", "inertia x0.5", "delay +1")
    ]
    assert len(own) == 8
    exact = eight.replace(integrator="exact")
    family = nfopidn.tune(exact, structure="decoupled", rng=1, maxfev=20).family
    assert family == exact.variations("standard")


def test_gains_hold_on_the_scenario_s_own_integrator():
    """Gains that serve the accurate integrator alone are lost with one Euler step in 0.2 s."""
    scenario = Scenario.published(heading="continuous")
    found = nfopidn.tune(scenario, rng=1, maxfev=4000)
    assert nfopidn.simulate(scenario, found.controller).cost < 0.03
    assert found.verdict.colour != "red"


@pytest.mark.parametrize("cap", [0.02, "friction", None])
def test_caps_are_counted_as_they_say(cap):
    rubbing = SHORT.replace(coulomb_friction=0.3)
    start = Controller.tuned_nominal()
    objective = Objective([SHORT, rubbing], structure="incremental", cost_cap=cap)
    x = objective.parameters_of(start)
    costs = nfopidn.simulate_many([SHORT, rubbing], objective.controller(x)).costs
    caps = {
        0.02: np.array([0.02, 0.02]),
        "friction": np.array([1.0, 10 * 2 * 0.3**2]),
        None: np.array([np.inf, np.inf]),
    }[cap]
    expected = np.mean(
        [
            capped(cost, one) if np.isfinite(one) else cost
            for cost, one in zip(costs, caps, strict=True)
        ]
    )
    assert objective(x) == pytest.approx(expected, rel=1e-2 if cap == "friction" else 1e-9)
    slope = objective.gradient(x)[1]
    step = 1e-6
    for place in (0, 5):
        ends = [x + sign * step * np.eye(len(x))[place] for sign in (1, -1)]
        high, low = objective.costs(ends)
        assert slope[place] == pytest.approx((high - low) / (2 * step), rel=1e-4, abs=1e-7)


BAD = [
    ({"robustness": "usual"}, "robustness is 'usual'; must be 'standard' or None"),
    ({"robustness": True}, "robustness is True; must be 'standard' or None"),
    ({"cost_cap": 0}, "cost_cap is 0; must be a positive number, 'friction' or None"),
    ({"cost_cap": -1.0}, "cost_cap is -1.0; must be a positive number"),
    ({"cost_cap": float("nan")}, "cost_cap is nan; must be a positive number"),
    ({"cost_cap": float("inf")}, "cost_cap is inf; must be a positive number"),
    ({"cost_cap": "much"}, "cost_cap is 'much'; must be a positive number"),
]


@pytest.mark.parametrize(("given", "message"), BAD)
def test_bad_settings_are_refused(given, message):
    with pytest.raises(ValueError, match=message):
        nfopidn.tune(SHORT, rng=1, maxfev=20, **given)


def test_members_that_diverge_are_named():
    """One start is beyond what any controller can bear; no candidate can do anything about it."""
    weak = SHORT.replace(torque_limit=1e-3, feedforward_limit=1e-3)
    far = weak.replace(divergence_distance=1.0, initial_pose=(3.4, 0.3, 1))
    family = Family(("easy", "hopeless"), (SHORT, far), ("", "hardly any torque"))
    result = nfopidn.tune(family, structure="decoupled", rng=1, maxfev=200)
    assert not result.success
    assert "diverges on 'hopeless' at " in result.message
    assert "Every controller of the last population diverges on 'hopeless'." in result.message
    assert "'easy'" not in result.message


def test_results_keep_their_family(tmp_path):
    result = nfopidn.tune(SHORT, structure="decoupled", rng=1, maxfev=40)
    result.to_json(tmp_path / "result.json")
    again = TuneResult.from_json(tmp_path / "result.json")
    assert again.family == result.family
    assert again.scenario == SHORT
    assert again.verdict.to_dict() == result.verdict.to_dict()


def test_checkpoints_tell_caps_apart(tmp_path):
    path = tmp_path / "search"
    first = nfopidn.tune(SHORT, structure="decoupled", rng=1, maxfev=40, checkpoint=path)
    assert nfopidn.tune(SHORT, structure="decoupled", rng=1, maxfev=40, checkpoint=path).fun == (
        first.fun
    )
    with pytest.raises(ValueError, match="checkpoint"):
        nfopidn.tune(SHORT, structure="decoupled", rng=1, maxfev=40, checkpoint=path, cost_cap=0.5)
    document = json.loads(SHORT.to_json())
    assert "model" not in document
