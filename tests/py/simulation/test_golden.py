"""The published figures, against an implementation that shares no code with this one."""

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Scenario

TOLERANCE = 1e-9


def test_every_column_of_the_published_run(published, golden_run):
    assert list(published.columns) == list(golden_run)
    for name, expected in golden_run.items():
        np.testing.assert_allclose(
            published.columns[name], expected, rtol=0, atol=TOLERANCE, err_msg=name
        )


@pytest.mark.parametrize("memory", range(1, 9))
def test_cost_for_each_memory(golden_costs, memory):
    cost = nfopidn.simulate(Scenario.published(), Controller.published(memory)).cost
    assert cost == pytest.approx(golden_costs["E_by_memory"][str(memory)], rel=0, abs=TOLERANCE)


def test_the_smallest_cost_is_at_the_papers_memory(golden_costs):
    costs = {
        memory: nfopidn.simulate(controller=Controller.published(int(memory))).cost
        for memory in golden_costs["E_by_memory"]
    }
    assert min(costs, key=costs.get) == "5"


def test_defaults_are_the_published_run(published):
    again = nfopidn.simulate()
    assert again.metrics == published.metrics
    assert np.array_equal(again.pose, published.pose)


def test_pose_mse_and_peaks(published, golden_costs):
    peak = golden_costs["peak"]
    measured = {
        "abs_v": np.abs(published.columns["v"]).max(),
        "abs_omega": np.abs(published.columns["omega"]).max(),
        "abs_tau": published.metrics["torque_peak"],
        "v_ref": published.scenario.trajectory.peak_speed,
    }
    assert measured == pytest.approx(peak, rel=0, abs=TOLERANCE)
    assert published.cost == pytest.approx(golden_costs["E_published_M5"], rel=0, abs=TOLERANCE)
    assert published.metrics["pose_mse"] == pytest.approx(
        golden_costs["pose_mse_published_M5"], rel=0, abs=TOLERANCE
    )


def test_metrics_follow_from_the_columns(published):
    """Every metric again in NumPy, from its definition."""
    columns = published.columns
    robot = published.scenario.robot
    dt = published.scenario.trajectory.dt
    distance = np.hypot(columns["x_ref"] - columns["x"], columns["y_ref"] - columns["y"])
    heading = (columns["theta_ref"] - columns["theta"] + np.pi) % (2 * np.pi) - np.pi
    torque = np.column_stack([columns["tau_left"], columns["tau_right"]])
    reference = np.column_stack([columns["tau_ref_left"], columns["tau_ref_right"]])
    turn = columns["omega"] * robot.track_width / 2
    wheels = np.column_stack([columns["v"] + turn, columns["v"] - turn]) / robot.wheel_radius
    expected = {
        "cost": np.mean(distance**2 + heading**2 + ((reference - torque) ** 2).sum(axis=1)),
        "pose_mse": np.mean(distance**2 + heading**2),
        "position_rms": np.sqrt(np.mean(distance**2)),
        "position_max": distance.max(),
        "heading_rms": np.sqrt(np.mean(heading**2)),
        "iae": distance.sum() * dt,
        "ise": (distance**2).sum() * dt,
        "itae": (distance * columns["t"]).sum() * dt,
        "torque_peak": np.abs(torque).max(),
        "torque_variation": np.abs(np.diff(torque, axis=0)).sum(),
        "share_at_limit": 0.0,
        "energy": np.abs(torque * wheels).sum() * dt,
        "lateral_force_peak": np.abs(robot.mass * columns["v"] * columns["omega"]).max(),
    }
    assert published.metrics == pytest.approx(expected, rel=1e-12)


def test_share_at_the_limit():
    result = nfopidn.simulate(Scenario.published(torque_limit=0.3))
    at_limit = (np.abs(result.torque) >= 0.3).any(axis=1)
    assert 0 < at_limit.mean() < 1
    assert result.metrics["share_at_limit"] == at_limit.mean()
    assert result.metrics["torque_peak"] == 0.3


@pytest.mark.parametrize(
    ("scenario", "controller"),
    [
        (Scenario.published(period=25), Controller.published()),
        (Scenario.published(), Controller.published(frame="world")),
        (Scenario.published(), Controller.published(form="incremental")),
        (Scenario.published(heading="continuous"), Controller.published(lateral="plain")),
    ],
    ids=["25 s lap", "world frame", "incremental", "continuous heading, plain e_y"],
)
def test_what_diverges_with_the_published_gains(scenario, controller):
    assert nfopidn.simulate(scenario, controller).diverged_at is not None


def test_continuous_heading_with_the_default_lateral_channel():
    cost = nfopidn.simulate(Scenario.published(heading="continuous")).cost
    assert cost == pytest.approx(0.082229, abs=5e-7)
