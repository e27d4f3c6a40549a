"""Scenario.cost_weights: how much position, heading and torque errors count."""

import json

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Rival, Scenario, simulate
from nominal import tune

WEIGHTS = (3.0, 0.5, 0.25)


def shares(run):
    """The mean squares of position, heading and torque errors, from the columns of a run."""
    columns = run.columns
    reference = np.column_stack([columns["tau_ref_left"], columns["tau_ref_right"]])
    return np.array(
        [
            (columns["e_x"] ** 2 + columns["e_y"] ** 2).mean(),
            (columns["e_theta"] ** 2).mean(),
            ((reference - run.torque) ** 2).sum(axis=1).mean(),
        ]
    )


def test_eq_41_is_the_default_to_the_bit():
    scenario = Scenario.published(rng=0)
    assert scenario.cost_weights == (1, 1, 1)
    assert "cost_weights" not in json.loads(scenario.to_json())
    run = simulate(scenario)
    assert run.cost == pytest.approx(shares(run).sum(), rel=1e-12)
    assert simulate(scenario.replace(cost_weights=(1, 1, 1))).cost == run.cost


@pytest.mark.parametrize("controller", [Controller.published(), Rival("lqr")])
@pytest.mark.parametrize("changes", [{}, {"pose_noise": (0.01, 0.01)}, {"integrator": "exact"}])
def test_each_share_counts_by_its_weight(controller, changes):
    scenario = Scenario.published(rng=0, **changes)
    plain = simulate(scenario, controller)
    weighted = simulate(scenario.replace(cost_weights=WEIGHTS), controller)
    assert np.array_equal(weighted.pose, plain.pose)
    assert weighted.cost == pytest.approx(WEIGHTS @ shares(plain), rel=1e-12)
    others = {name: value for name, value in plain.metrics.items() if name != "cost"}
    assert {name: weighted.metrics[name] for name in others} == others


def test_lanes_and_gradients_weigh_alike():
    scenario = Scenario.published(rng=0, cost_weights=WEIGHTS)
    objective = nfopidn.Objective(scenario, structure="decoupled")
    x = objective.parameters_of(Controller.published())
    expected = simulate(scenario, Controller.published(allocation="decoupled")).cost
    assert objective.costs(np.tile(x, (9, 1))) == pytest.approx(np.full(9, expected), rel=1e-9)
    cost, slopes = objective.gradient(x)
    assert cost == pytest.approx(expected, rel=1e-9)
    step = 1e-6 * np.eye(len(x))[0]
    difference = (objective(x + step) - objective(x - step)) / 2e-6
    assert slopes[0] == pytest.approx(difference, rel=1e-4)


@pytest.mark.parametrize("weight", [0.01, 1, 100])
def test_divergence_is_the_same_and_costs_by_the_position_s_weight(weight):
    """A light weight hides no divergence, and each sample after it costs the distance squared."""
    scenario = Scenario.published(rng=0, divergence_distance=1.2)
    weighted = scenario.replace(cost_weights=(weight, 1, 1))
    lost = Controller.published(gains=np.zeros((3, 3)))
    plain, run = simulate(scenario, lost), simulate(weighted, lost)
    assert plain.diverged_at is not None
    assert run.diverged_at == plain.diverged_at
    count = len(scenario.trajectory)
    before = shares(run) * len(run.t)  # of the samples before it
    missing = (count - len(run.t)) * weight * 1.2**2
    assert run.cost * count == pytest.approx(np.array([weight, 1, 1]) @ before + missing, rel=1e-9)


def test_what_is_weighed_is_what_a_search_makes_small():
    near, lazy = (
        tune(
            Scenario.published(rng=0, cost_weights=weights),
            structure="decoupled",
            rng=0,
            maxfev=1000,
        )
        for weights in ((100, 1, 1), (1, 1, 100))
    )
    scenario = Scenario.published(rng=0)
    places, torques = shares(simulate(scenario, near.controller))[[0, 2]]
    lazy_places, lazy_torques = shares(simulate(scenario, lazy.controller))[[0, 2]]
    assert places < lazy_places
    assert torques > lazy_torques


def test_friction_s_cap_weighs_torques():
    scenario = Scenario.published(rng=0, coulomb_friction=1.5)
    cap = nfopidn._core.family_cap
    assert cap(scenario) > 1
    heavy = scenario.replace(cost_weights=(1, 1, 2))
    assert cap(heavy) == pytest.approx(2 * cap(scenario), rel=1e-12)


def test_weights_stand_in_the_file_and_are_refused_out_of_range():
    scenario = Scenario.published(rng=0, cost_weights=WEIGHTS)
    assert json.loads(scenario.to_json())["cost_weights"] == list(WEIGHTS)
    assert Scenario.from_json(scenario.to_json()) == scenario
    for bad in (0, -1, np.nan, np.inf, 2e6):
        with pytest.raises(ValueError, match=r"cost_weights\[1\] is .*; must be"):
            scenario.replace(cost_weights=(1, bad, 1))
    with pytest.raises(ValueError, match=r"cost_weights is .*; must be a list of 3 numbers"):
        scenario.replace(cost_weights=(1, 1))
