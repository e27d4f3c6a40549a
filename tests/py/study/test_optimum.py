"""open_loop_optimum against other solvers, an independent replay, and its contract."""

import pickle
import signal
import sys
import threading

import numpy as np
import pytest
from nfopidn import Controller, Robot, Scenario, Trajectory, _core, plot, simulate
from nfopidn.study import guesses, open_loop_optimum, optimum, transcription
from nfopidn.study.guesses import other_turns
from nfopidn.study.motion import branches
from nominal import tune
from scipy.optimize import least_squares

NAMES = ("x", "y", "theta", "v", "omega")


def wrap(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


def motion(scenario, torque):
    """States (N, 5, ...) under torques (N, 2, ...): design equations, one substep after another.

    Any number type does, so that derivatives can be taken by complex steps.
    """
    robot, h = scenario.robot, scenario.trajectory.dt / scenario.substeps
    r, width = robot.wheel_radius, robot.track_width
    reference = scenario.reference
    pose = reference[0, :3] if scenario.initial_pose is None else scenario.initial_pose
    velocity = scenario.initial_velocity
    velocity = reference[0, 3:5] if velocity == "reference" else velocity
    pushes = np.broadcast_to(scenario.disturbance, (len(reference), 2))
    extra = torque.shape[2:]
    state = [np.full(extra, value, dtype=torque.dtype) for value in (*pose, *velocity)]
    rows = []
    nothing = np.zeros((scenario.delay, *torque.shape[1:]), dtype=torque.dtype)
    arriving = np.concatenate([nothing, torque])[: len(torque)]
    for k, (left, right) in enumerate(arriving):
        rows.append(np.array(state))
        x, y, theta, v, omega = state
        for _ in range(scenario.substeps):
            v = v + h * ((left + right) / (robot.mass * r) + pushes[k, 0] / robot.mass)
            omega = omega + h * (
                width * (left - right) / (2 * robot.inertia * r) + pushes[k, 1] / robot.inertia
            )
            v = v / (1 + h * 2 * scenario.viscous_friction / (robot.mass * r**2))
            omega = omega / (
                1
                + h * scenario.viscous_friction * width**2 / (2 * robot.inertia * r**2)
                + h * scenario.viscous_scrub / robot.inertia
            )
            x = x + h * v * np.cos(theta)
            y = y + h * v * np.sin(theta)
            theta = theta + h * omega
        state = [x, y, theta, v, omega]
    return np.array(rows)


def residuals(scenario, torque):
    """What eq. 41 squares and sums, (N, 5, ...), without the wrap of the heading error."""
    states = motion(scenario, torque)
    reference = scenario.reference.reshape(*scenario.reference.shape, *[1] * (torque.ndim - 2))
    return np.concatenate([reference[:, :3] - states[:, :3], reference[:, 5:7] - torque], axis=1)


def cost(scenario, torque):
    error = residuals(scenario, torque)
    error[:, 2] = wrap(error[:, 2])
    return np.mean(np.sum(error**2, axis=1))


def scipy_optimum(scenario):
    """Eq. 41's minimum by SciPy over the torques alone, with derivatives by complex steps."""
    count = len(scenario.reference)
    steps = 1e-30j * np.eye(2 * count)

    def value(x):
        return residuals(scenario, x.reshape(count, 2)).ravel()

    def jacobian(x):
        error = residuals(scenario, (x[:, None] + steps).reshape(count, 2, 2 * count))
        return error.imag.reshape(5 * count, 2 * count) / 1e-30

    limit = scenario.torque_limit
    first = np.clip(scenario.reference[:, 5:7].ravel(), -0.9 * limit, 0.9 * limit)
    found = least_squares(
        value, first, jac=jacobian, bounds=(-limit, limit), xtol=1e-9, ftol=1e-12, gtol=1e-9
    )
    return 2 * found.cost / count, found.x.reshape(count, 2)


def short(**changes):
    """Sixty samples of a circle, from a place beside it."""
    path = Trajectory.circle(period=12.0, dt=0.2)
    points = slice(0, 60)
    path = Trajectory.from_samples(path.x[points], path.y[points], 0.2)
    return Scenario(path, **{"initial_pose": (2.4, -0.3, 1.2), "rng": 0} | changes)


HARD = {
    "substeps": 3,
    "viscous_friction": 0.02,
    "viscous_scrub": 0.05,
    "robot": Robot.eddie_datasheet(),
    "initial_velocity": "reference",
    "disturbance": np.column_stack([np.sin(np.arange(60)), 0.1 * np.cos(np.arange(60))]),
}


# The value


@pytest.mark.parametrize(
    "changes",
    [{"torque_limit": 0.8, "disturbance": (1.0, -0.2)}, HARD, {"delay": 2}, HARD | {"delay": 1}],
    ids=["limited", "hard", "delayed", "hard and delayed"],
)
def test_it_is_the_minimum_that_scipy_finds(changes):
    scenario = short(**changes)
    found = open_loop_optimum(scenario, maxfev=0)
    value, torque = scipy_optimum(scenario)
    assert found.success
    assert found.cost == pytest.approx(value, rel=1e-6)
    assert np.allclose(found.torque, torque, atol=1e-3)
    assert np.abs(found.torque).max() <= scenario.torque_limit


def test_the_limit_binds_where_it_should():
    free = open_loop_optimum(short(), maxfev=0)
    bound = open_loop_optimum(short(torque_limit=0.4), maxfev=0)
    assert np.abs(free.torque).max() > 0.4
    assert np.abs(bound.torque).max() == pytest.approx(0.4, abs=1e-6)
    assert bound.cost > 1.01 * free.cost


@pytest.mark.parametrize("substeps", [1, 3])
def test_coulomb_friction_is_a_constant_push_where_the_wheels_roll_one_way(substeps):
    friction = 0.05
    path = Trajectory.line(period=12.0)
    moving = {"initial_velocity": "reference", "initial_pose": (-0.1, 0, 0), "substeps": substeps}
    scenario = Scenario(path, coulomb_friction=friction, rng=0, **moving)
    push = -2 * friction / scenario.robot.wheel_radius
    pushed = Scenario(path, disturbance=(push, 0.0), rng=0, **moving)
    rubbed, free = open_loop_optimum(scenario, maxfev=0), open_loop_optimum(pushed, maxfev=0)
    assert rubbed.run.columns["v"].min() > 0.1  # it never stops
    assert rubbed.cost == pytest.approx(free.cost, rel=1e-4)
    assert rubbed.cost >= free.cost * (1 - 1e-9)


def test_coulomb_friction_costs_less_than_any_controller_s_run():
    scenario = short(coulomb_friction=0.1)
    found = open_loop_optimum(scenario, maxfev=0)
    tuned = tune(scenario, structure="tracking", rng=1, maxfev=600)
    assert open_loop_optimum(short(), maxfev=0).cost < found.cost < tuned.fun


def test_a_straight_line_has_a_closed_form():
    """Along a line the problem is linear least squares in the wheels' common torque."""
    scenario = Scenario(Trajectory.line(period=12.0), initial_pose=(-0.3, 0, 0), rng=0)
    count, dt, robot = len(scenario.reference), 0.2, scenario.robot
    push = 2 * dt**2 / (robot.mass * robot.wheel_radius)
    lag = np.subtract.outer(np.arange(count), np.arange(count))
    matrix = np.vstack([push * np.maximum(lag, 0), np.sqrt(2) * np.eye(count)])
    wanted = np.concatenate([scenario.reference[:, 0] + 0.3, np.sqrt(2) * scenario.reference[:, 5]])
    torque = np.linalg.lstsq(matrix, wanted, rcond=None)[0]
    value = np.sum((matrix @ torque - wanted) ** 2) / count
    found = open_loop_optimum(scenario, maxfev=0)
    assert found.cost == pytest.approx(value, rel=1e-9)
    assert np.allclose(found.torque, torque[:, None], atol=1e-6)


@pytest.mark.parametrize(
    ("changes", "best"),
    [
        ({}, 0.014163),
        ({"heading": "continuous"}, 0.013464),
        ({"heading": "continuous", "period": 50}, 0.045385),
    ],
    ids=str,
)
def test_the_known_optima_are_reached(changes, best):
    found = open_loop_optimum(Scenario.published(rng=0, **changes), maxfev=0)
    assert 0.98 * best < found.cost <= best
    assert found.cost == pytest.approx(cost(found.scenario, found.torque), rel=1e-9)


def test_no_controller_is_better():
    scenario = Scenario.published(rng=0)
    best = open_loop_optimum(scenario, maxfev=0)
    assert best.cost < simulate(scenario, Controller.tuned_nominal()).cost


# Replay


def test_a_run_played_again_is_the_same_run():
    scenario = short(**HARD)
    run = simulate(scenario, Controller.published())
    assert run.diverged_at is None
    again = _core.play(scenario, run.torque)
    assert again.cost == run.cost
    for name, column in again.columns.items():
        if not name.startswith("tau_fb"):
            assert np.array_equal(column, run.columns[name]), name
    total = again.columns["tau_fb_left"] + again.columns["tau_ref_left"]
    assert np.allclose(total, run.torque[:, 0], rtol=0, atol=1e-12)
    states = np.column_stack([run.columns[name] for name in NAMES])
    assert np.allclose(motion(scenario, run.torque), states, rtol=0, atol=1e-12)
    assert cost(scenario, run.torque) == pytest.approx(run.cost, rel=1e-12)
    copied = pickle.loads(pickle.dumps(again))
    assert (copied.controller, copied.metrics) == (None, again.metrics)


def test_torques_that_cannot_be_played_are_named():
    scenario = short()
    with pytest.raises(ValueError, match=r"must have the shape \(\d+, 2\)"):
        _core.play(scenario, np.zeros((3, 2)))
    for bad in (np.nan, 400.0):
        torque = np.zeros((len(scenario.trajectory), 2))
        torque[1, 0] = bad
        with pytest.raises(ValueError, match=r"torque\[1\] is (nan|400); must be in \[-"):
            _core.play(scenario, torque)


@pytest.mark.parametrize("changes", [{}, HARD], ids=["plain", "hard"])
def test_the_torques_replayed_give_the_cost(changes):
    scenario = short(**changes)
    found = open_loop_optimum(scenario, maxfev=300)
    assert cost(scenario, found.torque) == pytest.approx(found.cost, rel=1e-9)
    states = motion(scenario, found.torque)
    assert np.allclose(found.pose, states[:, :3], atol=1e-9)
    assert np.allclose(found.run.columns["v"], states[:, 3], atol=1e-9)


def test_noise_and_seed_do_not_matter():
    plain, noisy = (
        open_loop_optimum(short(pose_noise=noise, rng=seed), maxfev=0)
        for noise, seed in (((0, 0), 0), ((0.01, 0.02), 7))
    )
    assert noisy.cost == pytest.approx(plain.cost, rel=1e-9)


# Guesses


def test_every_guess_is_told():
    found = open_loop_optimum(Scenario.published(rng=0, period=40), maxfev=300)
    names = [guess.name for guess in found.guesses]
    assert names[:3] == ["reference", "published gains", "tuned_nominal"]
    assert names[3:6] == ["tuned, decoupled", "tuned, extended", "tuned, incremental"]
    assert {"+1 turn at the start", "-1 turn at the start"} <= set(names)
    assert sum("turn at 13.4 s" in name for name in names) == 2
    solved = [guess.cost for guess in found.guesses if guess.cost is not None]
    assert found.cost == pytest.approx(min(solved), rel=1e-9)


def test_the_heading_takes_the_shorter_way_round():
    """From a start turned beyond half a turn the wrapped error counts, not the angle itself."""
    pose = (2.4, -0.3, 1.2)
    turned = (2.4, -0.3, 1.2 + 6 * np.pi)
    one, other = (open_loop_optimum(short(initial_pose=p), maxfev=0) for p in (pose, turned))
    assert other.cost == pytest.approx(one.cost, rel=1e-9)


def test_own_controllers_are_guesses():
    found = open_loop_optimum(short(), controllers=[Controller.published(memory=2)], maxfev=0)
    assert "controllers[0]" in [guess.name for guess in found.guesses]


def test_a_guess_whose_run_diverges_has_no_number():
    found = open_loop_optimum(Scenario.published(rng=0, period=25), maxfev=0)
    (row,) = (guess for guess in found.guesses if guess.name == "published gains")
    assert (row.cost, row.status) == (None, "its run diverges")
    assert found.success


def test_without_convergence_there_is_no_number():
    found = open_loop_optimum(short(), maxfev=0, max_iter=1)
    assert (found.cost, found.success) == (None, False)
    assert found.message == "No guess converged."
    assert {guess.status for guess in found.guesses} == {"Maximum_Iterations_Exceeded"}
    assert {guess.cost for guess in found.guesses} == {None}
    assert found.torque.shape == (0, 2)
    assert found.pose.shape == (0, 3)
    assert found.run is None


def interrupt():
    signal.raise_signal(signal.SIGINT)


def interrupt_main():
    signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)


@pytest.mark.parametrize("changes", [{}, {"coulomb_friction": 0.1}], ids=str)
def test_ctrl_c_returns_the_best_so_far(changes, monkeypatch):
    """The signal comes when the first guesses are solved; no other turn is tried."""

    def turns(scenario, motion):
        interrupt()
        return other_turns(scenario, motion)

    monkeypatch.setattr(optimum, "other_turns", turns)
    found = open_loop_optimum(short(**changes), maxfev=0)
    assert found.cost is not None
    assert (found.success, found.interrupted) == (False, True)
    message = "The search was interrupted. The best of the guesses that converged."
    assert found.message.startswith(message)
    assert ("did not settle" in found.message) == bool(changes)  # its refinement was not begun
    assert len(found.guesses) == 3
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_stops_the_solver(monkeypatch):
    """The signal comes before the first iteration; the solver ends at it, without a number."""

    def first_guess(*_):
        interrupt()
        return branches(*_)

    monkeypatch.setattr(transcription, "branches", first_guess)
    found = open_loop_optimum(short(), maxfev=0)
    assert [guess.status for guess in found.guesses] == ["User_Requested_Stop"]
    assert (found.cost, found.success) == (None, False)


def test_ctrl_c_ends_the_tuning(monkeypatch):
    """The signal comes while the first structure is tuned; the runs before it have their costs."""
    timers = []

    def tuned(*arguments, **options):
        timers.append(threading.Timer(0.3, interrupt_main))
        timers[0].start()
        return tune(*arguments, **options)

    monkeypatch.setattr(guesses, "tune", tuned)
    found = open_loop_optimum(short(), maxfev=10**9)
    assert len(timers) == 1
    assert len(found.guesses) == 3
    assert found.cost is not None
    assert found.interrupted
    assert not found.success


@pytest.mark.parametrize("count", [3, 4, 5])
def test_the_shortest_paths_do(count):
    path = Trajectory.from_samples(0.05 * np.arange(count), np.zeros(count), 0.2)
    scenario = Scenario(path, rng=0)
    found = open_loop_optimum(scenario, maxfev=0)
    assert found.success
    assert found.cost <= cost(scenario, scenario.reference[:, 5:7]) + 1e-12
    assert found.cost == pytest.approx(cost(scenario, found.torque), rel=1e-9, abs=1e-15)


def test_the_figures_of_runs_draw_it():
    found = open_loop_optimum(short(), maxfev=0)
    for draw in (plot.path, plot.orientation, plot.total_torque, plot.velocities):
        draw(found.run)
    plot.path(found.run).figure.clear()


# Refusals


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"integrator": "exact"}, "integrator 'exact'"),
        ({"coulomb_scrub": 0.1}, "coulomb_scrub 0.1 N m, which is no part"),
    ],
    ids=str,
)
def test_what_is_not_smooth_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        open_loop_optimum(short(**changes))


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        *[("maxfev", bad) for bad in (-1, 1.5, True, np.nan)],
        *[("max_iter", bad) for bad in (0, 0.5, False, np.inf)],
        *[("rng", bad) for bad in (-1, 0.3, "one", None)],
        *[("scenario", bad) for bad in ("published", 3)],
        *[("controllers", bad) for bad in ([3], 5)],
    ],
)
def test_bad_arguments_are_refused_by_name(argument, value):
    arguments = {"scenario": short(), argument: value}
    with pytest.raises(ValueError, match=argument):
        open_loop_optimum(**arguments)


def test_a_missing_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(ImportError, match=r"^\S.* pip install 'nfopidn\[optimum\]'$"):
        open_loop_optimum(short())
