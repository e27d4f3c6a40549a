"""Scenario.feedforward_limit: reference torques that can be driven, in loop and cost."""

import json
import re
import warnings

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Rival, Scenario, simulate
from nfopidn.robustness.reference_limits import beyond_the_robot
from nominal import tune

FINE = Scenario.published(dt=0.05, rng=0)  # a cusp takes 31 N m
LIMIT = 2.0


def test_no_limit_is_the_default_and_changes_no_bit():
    scenario = Scenario.published(rng=0)
    assert scenario.feedforward_limit is None
    assert "feedforward_limit" not in json.loads(scenario.to_json())
    wide = scenario.replace(feedforward_limit=3.078)  # the published torques are within it
    assert np.array_equal(wide.reference, scenario.reference)
    assert simulate(wide).cost == simulate(scenario).cost
    assert wide != scenario
    assert wide.replace(feedforward_limit=None) == scenario


def test_the_reference_torques_are_clipped_and_nothing_else():
    limited = FINE.replace(feedforward_limit=LIMIT)
    before, after = FINE.reference, limited.reference
    assert np.abs(before[:, 5:7]).max() > 30
    assert np.array_equal(after[:, 5:7], np.clip(before[:, 5:7], -LIMIT, LIMIT))
    rest = [0, 1, 2, 3, 4, 7]
    assert np.array_equal(after[:, rest], before[:, rest])


@pytest.mark.parametrize("controller", [Controller.published(), Rival("samson")])
def test_the_controller_is_given_them_and_the_cost_compares_with_them(controller):
    limited = FINE.replace(feedforward_limit=LIMIT)
    run = simulate(limited, controller)
    columns = run.columns
    reference = np.clip(FINE.reference[:, 5:7], -LIMIT, LIMIT)
    shown = np.column_stack([columns["tau_ref_left"], columns["tau_ref_right"]])
    assert np.array_equal(shown, reference)
    feedback = np.column_stack([columns["tau_fb_left"], columns["tau_fb_right"]])
    total = np.clip(feedback + reference, -3.078, 3.078)
    assert np.allclose(run.torque, total, rtol=0, atol=1e-12)
    # Eq. 41, from the columns of the run.
    errors = sum(columns[name] ** 2 for name in ("e_x", "e_y", "e_theta"))
    torques = ((reference - run.torque) ** 2).sum(axis=1)
    assert run.cost == pytest.approx((errors + torques).mean(), rel=1e-12)


def test_lanes_and_gradients_have_them_too():
    limited = FINE.replace(feedforward_limit=LIMIT)
    objective = nfopidn.Objective(limited, structure="decoupled")
    x = objective.parameters_of(Controller.published())
    expected = simulate(limited, Controller.published(allocation="decoupled")).cost
    assert objective.costs(np.tile(x, (9, 1))) == pytest.approx(np.full(9, expected), rel=1e-9)
    cost, _ = objective.gradient(x)
    assert cost == pytest.approx(expected, rel=1e-9)


def test_it_stands_in_the_file_and_is_refused_out_of_range():
    limited = FINE.replace(feedforward_limit=LIMIT)
    assert json.loads(limited.to_json())["feedforward_limit"] == LIMIT
    assert Scenario.from_json(limited.to_json()) == limited
    assert "feedforward_limit=2.0" in repr(limited)
    for bad in (0, -1, np.nan, np.inf, 2e6):
        with pytest.raises(ValueError, match=r"feedforward_limit is .*; must be"):
            FINE.replace(feedforward_limit=bad)


def test_an_exported_table_holds_them(tmp_path):
    published = Scenario.published(rng=0)
    rows = []
    for scenario in (published, published.replace(feedforward_limit=0.5)):
        nfopidn.export_c(Controller.recommended(), tmp_path, scenario=scenario, reference=True)
        text = next(tmp_path.glob("*_reference.c")).read_text()
        table = re.findall(r"^    {(.*)}", text, re.MULTILINE)
        rows.append(np.array([[float(n.strip("F")) for n in row.split(", ")] for row in table]))
    before, after = rows
    assert np.abs(before[:, -3:-1]).max() > 1.9
    assert np.array_equal(after[:, -3:-1], np.clip(before[:, -3:-1], -0.5, 0.5))


def test_tuning_on_torques_beyond_the_limit_is_warned_about():
    coarse = {"structure": "decoupled", "rng": 0, "maxfev": 20}
    with pytest.warns(UserWarning, match=r"torques reach 31 N m, at .*feedforward_limit=3.078"):
        tune(FINE, **coarse)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tune(FINE.replace(feedforward_limit=3.078), **coarse)
        tune(FINE.replace(feedforward=False), **coarse)
        tune(Scenario.published(rng=0), **coarse)


def test_a_verdict_goes_on_to_tell_what_the_motion_asks():
    limited = FINE.replace(feedforward_limit=LIMIT)
    assert beyond_the_robot(limited) == beyond_the_robot(FINE) != ()
