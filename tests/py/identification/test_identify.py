"""Identification finds a robot that another integrator moved, and says what it cannot find."""

import json

import numpy as np
import pytest
from identification_logs import COULOMB, DT, INERTIA, MASS, VISCOUS, drive, log_of, steps
from nfopidn import Motor, Robot, Scenario, formats, identify

TRUTH = {
    "mass": MASS,
    "inertia": INERTIA,
    "coulomb_friction": COULOMB,
    "viscous_friction": VISCOUS,
}
ROBOT = Robot()


@pytest.fixture(scope="module")
def driven():
    torque = steps(801)
    return torque, drive(torque, delay=3)


@pytest.fixture(scope="module")
def log(driven):
    return log_of(*driven)


@pytest.fixture(scope="module")
def found(log):
    return identify(log, robot=ROBOT)


def near(result, share=0.02, but=()):
    for name, value in TRUTH.items():
        if name not in but:
            assert result.parameters[name] == pytest.approx(value, rel=share), name


def test_the_truth_is_found(found):
    near(found)
    assert found.delay == 3
    assert found.parameters["delay"] == 3
    assert found.noise == pytest.approx((0.01, 0.01), rel=0.1)
    assert not found.undetermined
    assert not found.indistinguishable


def test_standard_errors_are_those_of_many_logs(driven):
    results = [identify(log_of(*driven, seed=s), robot=ROBOT, delay=3) for s in range(2, 7)]
    for name, value in TRUTH.items():
        off = [(r.parameters[name] - value) / r.standard_errors[name] for r in results]
        # Chi square of 5 is within 0.3 to 19 in 99.5 of 100 cases.
        assert 0.3 < np.sum(np.square(off)) < 19, name


def test_covariance_is_of_the_names(found):
    assert found.names == tuple(TRUTH)
    sure = np.sqrt(np.diag(found.covariance))
    np.testing.assert_allclose(sure, [found.standard_errors[n] for n in found.names])


def test_robot_and_scenario(found):
    assert found.robot == ROBOT.replace(
        mass=found.parameters["mass"], inertia=found.parameters["inertia"]
    )
    scenario = found.scenario
    assert isinstance(scenario, Scenario)
    assert scenario.robot == found.robot
    assert scenario.delay == 3
    assert scenario.coulomb_friction == found.parameters["coulomb_friction"]
    assert scenario.viscous_friction == found.parameters["viscous_friction"]
    assert scenario.pose_noise == found.noise


def test_residuals_of_the_right_model_are_white_and_validation_agrees(found):
    assert all(test.white for test in found.whiteness.values())
    assert found.train_error == pytest.approx(1, abs=0.1)
    assert found.validation_error == pytest.approx(1, abs=0.15)
    assert 0.15 < found.validation.mean() < 0.35


def test_residuals_of_a_wrong_model_are_not_white(log):
    wrong = identify(log, robot=ROBOT, free=["mass", "inertia"], delay=3)
    assert not all(test.white for test in wrong.whiteness.values())
    assert "not white" in str(wrong)


def test_known_parameters_stay(log):
    result = identify(
        log,
        robot=ROBOT,
        free=["mass", "inertia", "viscous_friction"],
        known={"coulomb_friction": COULOMB},
        delay=3,
    )
    near(result)
    assert result.parameters["coulomb_friction"] == COULOMB
    assert "coulomb_friction" not in result.standard_errors


def test_signs_of_a_real_robot(log, found):
    real = {**log, "tau_left": log["tau_right"], "tau_right": log["tau_left"]}
    same = identify(real, robot=ROBOT, signs="rep103")
    assert same.parameters == found.parameters
    with pytest.raises(ValueError, match=r"inertia -.*signs says"):
        identify(real, robot=ROBOT)


def test_a_fraction_of_a_sample(driven):
    torque, rows = driven
    log = log_of(torque, rows)
    late = {"t": log["t"] - 0.4 * DT, "tau_left": torque[:, 0], "tau_right": torque[:, 1]}
    poses = {name: log[name] for name in ("t", "x", "y", "theta")}
    result = identify(poses, robot=ROBOT, commands=late, delay="fractional")
    assert result.delay == pytest.approx(3.4, abs=0.05)
    near(result)


def test_two_clocks_are_one_delay(log):
    poses = {name: log[name] for name in ("t", "x", "y", "theta")}
    commands = {name: log[name] for name in ("tau_left", "tau_right")} | {"t": log["t"] + 5 * DT}
    result = identify(poses, robot=ROBOT, commands=commands)
    assert result.delay == -2
    near(result)
    assert any("clocks' difference" in note for note in result.notes)


def test_a_log_of_formats_with_commands(log, found):
    states = formats.Log(
        x=log["x"], y=log["y"], theta=log["theta"], t=log["t"], start=100.0, source="bag"
    )
    commands = {"t": log["t"] + 100.0, "tau_left": log["tau_left"], "tau_right": log["tau_right"]}
    same = identify(states, robot=ROBOT, commands=commands)
    assert same.delay == 3
    assert same.parameters == pytest.approx(found.parameters, rel=1e-3)
    with pytest.raises(ValueError, match="commands is None"):
        identify(states, robot=ROBOT)


def test_uneven_and_repeated_stamps(driven):
    torque, rows = driven
    log = log_of(torque, rows, noise=0)
    rng = np.random.default_rng(5)
    t = np.sort(log["t"] + rng.uniform(-0.4, 0.4, len(rows)) * DT)
    t[0] = 0
    pose = {n: np.interp(t, log["t"], log[n]) + rng.normal(0, 0.01, len(t)) for n in "xy"}
    pose["theta"] = np.interp(t, log["t"], log["theta"]) + rng.normal(0, 0.01, len(t))
    doubled = np.sort(np.append(np.arange(len(t)), [50, 60, 70]))
    poses = {"t": t[doubled], **{n: column[doubled] for n, column in pose.items()}}
    commands = {"t": log["t"], "tau_left": torque[:, 0], "tau_right": torque[:, 1]}
    result = identify(poses, robot=ROBOT, commands=commands, delay=3)
    near(result, 0.03)
    notes = " ".join(result.notes)
    assert "3 rows repeat a stamp of t" in notes
    assert "stamps of t are uneven" in notes


def test_outliers_do_little_and_are_named(log):
    bad = {name: column.copy() for name, column in log.items()}
    rows = np.arange(100, 700, 60)
    bad["x"][rows] += 1.5
    bad["theta"][rows + 7] -= 2
    result = identify(bad, robot=ROBOT, delay=3)
    near(result)
    assert set(result.outliers) == {*rows, *(rows + 7)}
    squares = identify(bad, robot=ROBOT, loss="squares", delay=3)
    off = [abs(r.parameters["coulomb_friction"] / COULOMB - 1) for r in (result, squares)]
    assert off[0] < off[1]


def test_drift_does_not_add_up(driven):
    torque, rows = driven
    log = log_of(torque, rows)
    turn = 0.001 * log["t"]  # of odometry that turns away
    x, y = log["x"].copy(), log["y"].copy()
    log["x"] = np.cos(turn) * x - np.sin(turn) * y + 0.002 * log["t"]
    log["y"] = np.sin(turn) * x + np.cos(turn) * y
    log["theta"] = log["theta"] + turn
    near(identify(log, robot=ROBOT, delay=3), 0.03)


def test_counts_of_encoders_go_round(driven):
    torque, rows = driven
    v, omega = rows[:, 3], rows[:, 4]
    distance = np.concatenate([[0], np.cumsum(0.5 * (v[1:] + v[:-1]) * DT)])
    half = ROBOT.track_width / 2
    counts = [
        np.floor((distance + side * half * rows[:, 2]) / ROBOT.wheel_radius / (2 * np.pi) * 4096)
        for side in (1, -1)
    ]
    assert np.ptp(v) > 0.5
    assert np.ptp(omega) > 0.5
    log = log_of(torque, rows)
    log = {name: log[name] for name in ("t", "tau_left", "tau_right")}
    log |= {"counts_left": counts[0] % 4096, "counts_right": counts[1] % 4096}
    result = identify(log, robot=ROBOT, counts_per_turn=4096, counter_range=4096)
    near(result, 0.03)
    assert any("goes round" in note for note in result.notes)


def test_the_scale_of_torques_cannot_be_had(log):
    with pytest.warns(UserWarning, match=r"torque_scale is 1 .*weigh the robot"):
        result = identify(log, robot=ROBOT, free=[*TRUTH, "torque_scale"], delay=3)
    assert result.indistinguishable == ((*TRUTH, "torque_scale"),)
    assert result.standard_errors["torque_scale"] == np.inf
    assert result.singular_values[-1] < 1e-3
    near(result)


def test_without_turns_there_is_no_inertia():
    torque = steps(601, swing=0)
    log = log_of(torque, drive(torque))
    with pytest.warns(UserWarning, match=r"inertia is 0.5873 as given.*change the turn rate"):
        result = identify(log, robot=ROBOT)
    near(result, 0.03, but=["inertia"])
    assert result.parameters["inertia"] == ROBOT.inertia
    assert list(result.undetermined) == ["inertia"]


def test_voltages_behind_a_motor(driven):
    torque, rows = driven
    motor = Motor(resistance=2.0, torque_constant=0.02, back_emf_constant=0.0, gear_ratio=20)
    volts = torque / (20 * 0.02 / 2.0)
    log = log_of(torque, rows)
    log |= {"voltage_left": volts[:, 0], "voltage_right": volts[:, 1]}
    near(identify(log, "voltage", robot=ROBOT, motor=motor, delay=3))
    # Back EMF is viscous friction: what the motor has the robot has not.
    emf = 0.02 / (20**2 * 0.02 / 2.0)
    motor = motor.replace(back_emf_constant=emf)
    geared = identify(log, "voltage", robot=ROBOT, motor=motor, delay=3)
    assert geared.parameters["viscous_friction"] == pytest.approx(VISCOUS - 0.02, rel=0.05)


def test_speeds_behind_their_commands():
    rng = np.random.default_rng(3)
    fine, count = 50, 801
    command = np.column_stack(
        [np.repeat(rng.uniform(-0.3, 0.6, 41), 20), np.repeat(rng.uniform(-1.5, 1.5, 41), 20)]
    )[:count]
    state, speed, rows = np.zeros(3), np.zeros(2), [np.zeros(3)]
    late = np.vstack([np.zeros((2, 2)), command])
    for goal in late[: count - 1]:
        for _ in range(fine):
            h = DT / fine
            before = speed
            speed = speed + (1 - np.exp(-h / 0.12)) * (goal * [1.02, 0.95] - speed)
            v, omega = 0.5 * (speed + before)
            middle = state[2] + h * omega / 2
            state = state + h * np.array([v * np.cos(middle), v * np.sin(middle), omega])
        rows.append(state)
    pose = np.array(rows) + rng.normal(0, 0.005, (count, 3))
    log = dict(zip(("x", "y", "theta"), pose.T, strict=True))
    log |= {"t": DT * np.arange(count), "v_command": command[:, 0], "omega_command": command[:, 1]}
    result = identify(log, "velocity", robot=ROBOT)
    assert result.delay == 2
    assert result.parameters["gain"] == pytest.approx(1.02, rel=0.005)
    assert result.parameters["turn_gain"] == pytest.approx(0.95, rel=0.005)
    assert result.parameters["lag"] == pytest.approx(0.12, rel=0.02)
    assert result.robot.wheel_radius == pytest.approx(1.02 * ROBOT.wheel_radius, rel=0.005)
    assert result.robot.track_width == pytest.approx(1.02 / 0.95 * ROBOT.track_width, rel=0.005)
    with pytest.raises(ValueError, match="no plant"):
        _ = result.scenario
    with pytest.raises(ValueError, match="no robot"):
        _ = identify(log, "velocity", delay=2).robot


def rolled(rows, radii, track):
    """Angles of the wheels (n, 2), the first turning the robot counter-clockwise."""
    v = 0.5 * (rows[1:, 3] + rows[:-1, 3])
    distance = np.concatenate([[0], np.cumsum(v * DT)])
    return np.column_stack(
        [
            (distance + side * track / 2 * rows[:, 2]) / radius
            for side, radius in zip((1, -1), radii, strict=True)
        ]
    )


@pytest.mark.parametrize("signs", ["paper", "rep103"])
def test_wheels_of_counts_and_poses(driven, signs):
    angles = rolled(driven[1], (0.0745, 0.0775), 0.47)
    counts = np.round(angles / (2 * np.pi) * 4096) % 65536
    log = {name: column for name, column in log_of(*driven).items() if "tau" not in name}
    sides = ("left", "right") if signs == "paper" else ("right", "left")
    log |= {f"counts_{side}": counts[:, i] for i, side in enumerate(sides)}
    given = {"counts_per_turn": 4096, "counter_range": 65536, "delay": 0}
    result = identify(log, "odometry", robot=ROBOT, signs=signs, **given)
    for side, radius in zip(sides, (0.0745, 0.0775), strict=True):
        assert result.parameters[f"wheel_radius_{side}"] == pytest.approx(radius, rel=0.004)
    assert result.parameters["track_width"] == pytest.approx(0.47, rel=0.004)
    assert result.robot.wheel_radius == pytest.approx(0.076, rel=0.004)
    other = "rep103" if signs == "paper" else "paper"
    with pytest.raises(ValueError, match=r"track_width -.*signs says"):
        identify(log, "odometry", robot=ROBOT, signs=other, **given)


def test_json_has_all_but_the_rows(found, tmp_path):
    text = found.to_json(tmp_path / "result.json")
    assert (tmp_path / "result.json").read_text() == text
    content = json.loads(text)
    assert content["parameters"] == dict(found.parameters)
    assert content["covariance"]["rows"] == found.covariance.tolist()
    assert content["robot"]["mass"] == found.parameters["mass"]


@pytest.mark.parametrize("dark", [False, True])
def test_figure(found, dark):
    axes = found.plot(dark=dark)
    assert len(axes) == 5
    measured = axes[0].lines[0].get_ydata()
    np.testing.assert_array_equal(measured, found.measured[:, 0])
    ground = axes[0].get_facecolor()[:3]
    assert (sum(ground) < 1) == dark


def test_same_log_same_bits(log, found):
    assert identify(log, robot=ROBOT).parameters == found.parameters


def changed(**columns):
    return lambda log: {**log, **columns}


REFUSED = {
    "no log": (lambda _: 3, {}, "log is a int"),
    "no column": (lambda log: {k: log[k] for k in ("t", "x", "y")}, {}, "no column theta"),
    "no command": (lambda log: {k: log[k] for k in ("t", "x", "y", "theta")}, {}, "tau_left"),
    "not finite": (changed(x=np.full(801, np.nan)), {}, r"log\['x'\]\[0\] is nan"),
    "length": (changed(x=np.zeros(3)), {}, "has 3 numbers; must have as many"),
    "matrix": (changed(x=np.zeros((801, 2))), {}, r"has the shape \(801, 2\)"),
    "falls": (changed(t=-DT * np.arange(801.0)), {}, "falls: .* in row 1"),
    "short": (lambda log: {k: v[:20] for k, v in log.items()}, {}, "has 20 rows"),
    "few windows": (lambda log: {k: v[:200] for k, v in log.items()}, {}, "windows of 4 s"),
    "still": (
        lambda log: {**log, "tau_left": np.zeros(801), "tau_right": np.zeros(801)},
        {},
        "commands never change; for mass: speed up",
    ),
    "model": (lambda log: log, {"model": "torques"}, "model is 'torques'.*did you mean 'torque'"),
    "robot": (lambda log: log, {"robot": None}, "robot is None; model='torque' needs"),
    "robot's type": (lambda log: log, {"robot": 3}, "robot is 3; must be a Robot"),
    "motor": (lambda log: log, {"motor": Motor()}, "motor is .*must be a Motor with"),
    "no motor": (lambda log: log, {"model": "voltage"}, "motor is None"),
    "signs": (lambda log: log, {"signs": "ros"}, "signs is 'ros'; must be one of paper, rep103"),
    "free": (lambda log: log, {"free": ["mas"]}, "free is 'mas'.*did you mean 'mass'"),
    "none free": (lambda log: log, {"free": []}, "free is empty"),
    "known": (lambda log: log, {"known": {"mass": 3}}, "known has 'mass', which is free"),
    "delay": (lambda log: log, {"delay": "some"}, "delay is 'some'"),
    "long delay": (lambda log: log, {"delay": 65}, r"delay is 65; must be .*\[0, 64\]"),
    "max_delay": (lambda log: log, {"max_delay": -1}, r"max_delay is -1; must be .*\[0, 64\]"),
    "window": (lambda log: log, {"window": 0.1}, r"window is 0.1; must be in \[0.5, 1000\] s"),
    "loss": (lambda log: log, {"loss": "l1"}, "loss is 'l1'"),
    "validation": (lambda log: log, {"validation": 0.9}, r"validation is 0.9; must be in \[0, 0.5"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_bad_input_is_refused(name, log):
    change, arguments, message = REFUSED[name]
    with pytest.raises(ValueError, match=message):
        identify(change(log), **{"robot": ROBOT, **arguments})


def test_counts_need_to_be_known(log):
    counts = {**{k: log[k] for k in ("t", "tau_left", "tau_right")}}
    counts |= {"counts_left": np.arange(801.0), "counts_right": np.arange(801.0)}
    with pytest.raises(ValueError, match="counts_per_turn is None"):
        identify(counts, robot=ROBOT)
    counts["counts_left"] = np.where(np.arange(801) < 400, counts["counts_left"], -6e4)
    with pytest.raises(ValueError, match=r"jumps by 60399.0 counts in row 400.*counter_range"):
        identify(counts, robot=ROBOT, counts_per_turn=100)
