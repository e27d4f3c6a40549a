"""The law called sample by sample, its taps, and its parameter vectors."""

import contextlib

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Scenario, Trajectory

DECOUPLED = {"form": "incremental", "allocation": "decoupled"}
SMALL_GAINS = np.array([[0.5, 0.1, 0.2], [0.3, 0.05, 0.1], [0.4, 0.1, 0.1]])
RUNS = {
    "published": ({}, {}),
    "no memory": ({"memory": 0}, {}),
    "memory 8": ({"memory": 8}, {}),
    "memory 9": ({"memory": 9}, {}),
    "longest memory": ({"memory": 1024}, {}),
    "order pairs": ({"alpha": (0.1, 0.5, 1.2), "sigma": (0.9, 0.8, -0.3)}, {}),
    "hold": ({**DECOUPLED, "gains": SMALL_GAINS, "anti_windup": "hold"}, {"torque_limit": 0.2}),
    "clamp": ({**DECOUPLED, "gains": SMALL_GAINS, "anti_windup": "clamp"}, {"torque_limit": 0.2}),
    "free": ({**DECOUPLED, "gains": SMALL_GAINS}, {"torque_limit": 0.2}),
    "linear": ({"activation": "linear", "gains": SMALL_GAINS}, {}),
    "gl": ({"generator": "gl", "alpha": 1, "sigma": 1}, {}),
    "world": ({"frame": "world"}, {}),
    "matrix": ({"allocation": [[1, 0.5, 0.3], [1, -0.2, -0.9]]}, {}),
    "reverse": ({"lateral": "direction"}, {"heading": "continuous"}),
    "plain": ({"lateral": "plain"}, {"heading": "continuous"}),
    "speed": ({"lateral": "speed"}, {"heading": "continuous"}),
    "speed scale": ({"lateral": "speed", "speed_scale": 0.7}, {}),
    "no feedforward": ({}, {"feedforward": False}),
    "delay": ({}, {"delay": 2}),
    "exact": ({}, {"integrator": "exact", "coulomb_friction": 0.1}),
}


def replay(controller, result):
    """The torques that step() gives for a recorded run's poses."""
    scenario = result.scenario
    reference = scenario.reference.copy()
    if not scenario.feedforward:
        reference[:, 5:7] = 0
    torques, feedback = [], []
    for pose, sample in zip(result.pose, reference, strict=False):
        torques.append(controller.step(pose, sample, scenario.torque_limit))
        feedback.append(controller.feedback())
    return np.array(torques), np.array(feedback)


@pytest.mark.parametrize(("settings", "changes"), RUNS.values(), ids=RUNS.keys())
def test_step_gives_the_torques_of_the_simulation(settings, changes):
    controller = Controller.published().replace(**settings)
    scenario = Scenario.published(**changes)
    result = nfopidn.simulate(scenario, controller)
    assert len(result) > 100
    if controller.lateral == "speed" and controller.speed_scale == 0:
        controller = controller.replace(speed_scale=scenario.trajectory.peak_speed)
    torques, feedback = replay(controller, result)
    assert np.array_equal(torques, result.torque)
    assert np.array_equal(feedback[:, 0], result.columns["tau_fb_left"])
    assert np.array_equal(feedback[:, 1], result.columns["tau_fb_right"])


def test_reset_forgets_everything(published):
    controller = Controller.published(form="incremental")
    first = replay(controller, published)
    assert not np.array_equal(replay(controller, published), first)
    controller.reset()
    assert controller.feedback() == (0.0, 0.0)
    assert np.array_equal(replay(controller, published), first)


def test_a_simulation_leaves_the_controller_s_memory_alone(published):
    controller = Controller.published(form="incremental")
    twin = Controller.published(form="incremental")
    reference = published.scenario.reference
    for k in range(5):
        assert controller.step(published.pose[k], reference[k]) == twin.step(
            published.pose[k], reference[k]
        )
        nfopidn.simulate(controller=controller)


def test_speeds_in_the_measurement_are_not_read(controller, published):
    reference = published.scenario.reference
    for k in range(20):
        twin = Controller.published()
        controller.reset()
        measurement = [*published.pose[k], 17.0, -3.0]
        assert controller.step(measurement, reference[k]) == twin.step(
            published.pose[k], reference[k]
        )


def test_the_torque_limit_holds_for_the_total(controller, published):
    reference = published.scenario.reference[0].copy()
    reference[5:7] = (5.0, -5.0)
    limited = {}
    for limit in (1e3, 3.078, 0.1):
        controller.reset()
        limited[limit] = controller.step(published.pose[0], reference, torque_limit=limit)
    assert max(limited[1e3]) > 3.078
    assert limited[3.078] == (3.078, -3.078)
    assert limited[0.1] == (0.1, -0.1)
    controller.reset()
    assert controller.step(published.pose[0], reference) == limited[3.078]


@pytest.mark.parametrize("fault", [{"measurement": [0, np.nan, 0]}, {"reference": [np.inf] * 8}])
def test_a_refused_step_leaves_the_memory_as_it_was(fault, published):
    controller, twin = Controller.published(**DECOUPLED), Controller.published(**DECOUPLED)
    reference = published.scenario.reference
    for k in range(10):
        good = {"measurement": published.pose[k], "reference": reference[k]}
        assert controller.step(**good) == twin.step(**good)
        with pytest.raises(ValueError, match=r"\[[01]\] is"):
            controller.step(**(good | fault))
        assert controller.feedback() == twin.feedback()


@pytest.mark.parametrize("pose", [(1e300, 0, 0), (0, 0, 1e300), (1e308, -1e308, 1.0)])
def test_a_finite_measurement_never_leaves_nan_behind(pose, controller, published):
    reference = published.scenario.reference[0]
    with contextlib.suppress(ValueError):  # to refuse it is as good
        assert np.isfinite(controller.step(pose, reference)).all()
    assert np.isfinite(controller.step(published.pose[0], reference)).all()


def weights(generator, order, memory):
    """Weights of the power series, by the recursions of the design."""
    w = [1.0]
    for j in range(1, memory + 1):
        if generator == "gl":
            w.append(w[-1] * (j - 1 - order) / j)
        else:
            w.append((-2 * order * w[-1] + (j - 2) * (w[-2] if j > 1 else 0)) / j)
    return np.array(w)


@pytest.mark.parametrize("generator", ["tustin", "gl"])
@pytest.mark.parametrize("memory", [0, 1, 2, 5, 60])
def test_taps_equal_the_three_sums(generator, memory):
    gains = np.array([[0.3, 0.7, 0.8], [1.1, 0.2, -0.3], [0.0, -1.4, 0.2]])
    alpha, sigma = (0.1, 1.5, -0.7), (0.8, 1.0, -1.2)
    controller = Controller(gains, alpha, sigma, memory, generator=generator)
    errors = np.random.default_rng(0).normal(size=memory + 2)  # newest first
    for channel, (kp, ki, kd) in enumerate(gains):
        derivative = weights(generator, alpha[channel], memory)
        integral = weights(generator, 1 - sigma[channel], memory)
        older = errors[1:] if generator == "tustin" else 0.0
        net = (
            kp * (errors[0] - errors[1])
            + kd * np.sum(derivative * (errors[:-1] - errors[1:]))
            + ki * np.sum(integral * (errors[:-1] + older))
        )
        assert controller.taps.shape == (3, memory + 2)
        assert controller.taps[channel] @ errors == pytest.approx(net, rel=1e-12)


def test_textbook_pid(published):
    """Generator gl, orders (1, 1), linear, incremental: a PID with backward differences."""
    gains = [[0.5, 0.05, 0.2], [0, 0, 0], [0, 0, 0]]
    pid = Controller(gains, 1, 1, 3, "incremental", [[1, 0, 0], [2, 0, 0]], "linear", "world", "gl")
    errors = np.array([1.0, 0.4, -0.3, 0.2, 0.25, -1.0, 2.0, 0.5])
    total = 0.0
    for k, error in enumerate(errors):
        total += error
        previous = errors[k - 1] if k else 0.0
        expected = 0.5 * error + 0.05 * total + 0.2 * (error - previous)
        left, right = pid.step([-error, 0, 0], np.zeros(8), torque_limit=1e3)
        assert (left, right) == pytest.approx((expected, 2 * expected), rel=1e-12)


ELEVEN = np.arange(1, 12) / 7
FIFTEEN = np.concatenate([np.arange(9) / 5, [0.1, 0.9, 0.2, 0.8, 0.3, 0.7]])


@pytest.mark.parametrize("vector", [ELEVEN, FIFTEEN], ids=[11, 15])
@pytest.mark.parametrize("structure", [{}, {"memory": 9, **DECOUPLED, "generator": "gl"}])
def test_vectors_there_and_back(vector, structure):
    controller = Controller.from_vector(vector, **structure)
    assert np.array_equal(controller.to_vector(), vector)
    assert np.array_equal(controller.gains, vector[:9].reshape(3, 3))
    assert Controller.from_vector(list(vector), **structure) == controller
    assert {name: getattr(controller, name) for name in structure} == structure


def test_orders_of_a_vector():
    shared = Controller.from_vector(ELEVEN)
    assert (shared.alpha, shared.sigma) == (ELEVEN[9], ELEVEN[10])
    pairs = Controller.from_vector(FIFTEEN)
    assert (pairs.alpha, pairs.sigma) == ((0.1, 0.2, 0.3), (0.9, 0.8, 0.7))


def test_the_published_vector():
    table = [0.2797, 0.7614, 0.8477, 0.7177, 0.2782, 0.3294, 1.0707, 1.3720, 0.1827]
    assert np.array_equal(Controller.published().to_vector(), [*table, 0.1078, 0.8161])


def test_turning_the_robot_round():
    """Decoupled, driving a path backwards with the robot turned by pi swaps the wheels' torques."""
    path = Trajectory.eight(period=60)
    scenario = Scenario(path, initial_pose=(0.1, -0.2, path.theta[0] + 0.3))
    controller = Controller.published(allocation="decoupled")
    result = nfopidn.simulate(scenario, controller)
    turned = scenario.reference.copy()
    turned[:, 2] += np.pi
    turned[:, 3] *= -1
    turned[:, 5:7] = -turned[:, 6:4:-1]
    turned[:, 7] = 1
    pose = result.pose + np.array([0, 0, np.pi])
    torques = np.array([controller.step(*row) for row in zip(pose, turned, strict=True)])
    np.testing.assert_allclose(torques, -result.torque[:, ::-1], rtol=0, atol=1e-12)
