"""Scenario.encoder_counts: the controller sees a pose by odometry, the true one is scored."""

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Rival, Scenario, simulate

LAP = {"period": 60.0, "dt": 0.1, "heading": "continuous", "integrator": "exact", "rng": 0}


def reckoned(run, scenario, counts, errors=(0.0, 0.0, 0.0)):
    """Give the pose by odometry (N, 3) from the true speeds, integrated densely between samples.

    An implementation of its own: the distances are sums of the speeds by the trapezium rule, which
    are linear in time between samples under constant torques.
    """
    robot, dt = scenario.robot, scenario.trajectory.dt
    v, omega = run.columns["v"], run.columns["omega"]
    way = np.concatenate([[0], np.cumsum(0.5 * (v[1:] + v[:-1]) * dt)])
    turned = np.concatenate([[0], np.cumsum(0.5 * (omega[1:] + omega[:-1]) * dt)])
    per_turn = counts / (2 * np.pi)
    rolled = []
    for sign, error in zip((1, -1), errors[:2], strict=True):
        angle = (way + sign * turned * robot.track_width / 2) / robot.wheel_radius
        rolled.append(np.floor(angle * per_turn) / per_turn * robot.wheel_radius * (1 + error))
    left, right = np.diff(rolled[0]), np.diff(rolled[1])
    theta = run.pose[0, 2] + np.concatenate(
        [[0], np.cumsum((left - right) / (robot.track_width * (1 + errors[2])))]
    )
    half = np.diff(theta) / 2
    chord = 0.5 * (left + right) * np.sinc(half / np.pi)
    mean = theta[:-1] + half
    steps = np.column_stack([chord * np.cos(mean), chord * np.sin(mean)])
    position = run.pose[0, :2] + np.vstack([[0, 0], np.cumsum(steps, axis=0)])
    return np.column_stack([position, theta])


def shown_torques(scenario, controller, poses):
    """Give the torques (N, 2) of a controller that is shown these poses."""
    law = controller.replace()
    law.reset()
    rows = scenario.reference
    return np.array([law.step(pose, row) for pose, row in zip(poses, rows, strict=True)])


def test_the_torques_are_those_of_a_controller_that_is_shown_the_counts():
    errors = (0.004, -0.002, 0.01)
    scenario = Scenario.published(**LAP, encoder_counts=2000, odometry_errors=errors)
    controller = Controller.recommended(sample_time=0.1)
    run = simulate(scenario, controller)
    poses = reckoned(run, scenario, 2000, errors)
    torques = shown_torques(scenario, controller, poses)
    assert np.allclose(torques, run.torque, rtol=0, atol=1e-10)
    measured = simulate(scenario.replace(encoder_counts=0), controller)
    assert np.abs(run.torque - measured.torque).max() > 1e-3


def test_fine_encoders_of_a_known_robot_are_the_measured_pose():
    fine = Scenario.published(**LAP, encoder_counts=10**6)
    expected = simulate(fine.replace(encoder_counts=0))
    assert simulate(fine).cost == pytest.approx(expected.cost, rel=1e-2)


def test_drift_counts_by_the_true_pose():
    exact = Scenario.published(**LAP, encoder_counts=10**5)
    wrong = exact.replace(odometry_errors=(0.01, 0.01, 0.01))
    controller = Controller.recommended(sample_time=0.1)
    # Ways are taken for 1 % longer than they are, turns for what they are: the path driven is
    # smaller by 1 %.
    run = simulate(wrong, controller)
    size = np.ptp(run.pose[100:, 0]) / np.ptp(simulate(exact, controller).pose[100:, 0])
    assert size == pytest.approx(1 / 1.01, abs=2e-3)
    assert run.metrics["position_rms"] > 0.02


@pytest.mark.parametrize("law", ["samson", "lqr"])
def test_rivals_are_shown_it_too(law):
    coarse = Scenario.published(**LAP, encoder_counts=100)
    measured = simulate(coarse.replace(encoder_counts=0), Rival(law))
    assert simulate(coarse, Rival(law)).cost != measured.cost


def test_objectives_and_monte_carlo_have_it():
    scenario = Scenario.published(**LAP, encoder_counts=400, odometry_errors=(0.002, 0, 0))
    controller = Controller.published(allocation="decoupled", sample_time=None)
    expected = simulate(scenario, controller).cost
    objective = nfopidn.Objective(scenario, structure="decoupled")
    x = objective.parameters_of(controller)
    assert objective.costs(np.tile(x, (3, 1))) == pytest.approx(np.full(3, expected), rel=1e-9)
    assert objective.gradient(x)[0] == pytest.approx(expected, rel=1e-9)
    runs = nfopidn.monte_carlo(
        scenario, controller, 4, rng=0, distributions={"mass": nfopidn.montecarlo.Uniform(10, 13)}
    )
    assert simulate(runs.replay(3), controller).cost == runs.costs[3]
