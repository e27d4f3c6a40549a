"""Controller.recommended, the rules by which it and the search scale, and the robot in files."""

import json
import math
import subprocess
import warnings

import numpy as np
import pytest
from nfopidn import (
    Controller,
    Robot,
    Scenario,
    Trajectory,
    default_bounds,
    simulate,
    stability,
    tune,
)

ORDINARY = Robot(mass=5.0, inertia=0.08, track_width=0.30, wheel_radius=0.033)
LIMIT = 0.6
# The search's names that are another setting's.
GAINS = {"kp_x": 0, "kp_y": 1, "kp_theta": 2}


def value(controller, name):
    return controller.gains[GAINS[name], 0] if name in GAINS else getattr(controller, name)


def ordinary(path, **changes):
    return Scenario(path, ORDINARY, torque_limit=LIMIT, rng=0, **changes)


def recommended_for(scenario):
    return Controller.recommended(
        scenario.robot,
        scenario.trajectory.dt,
        scenario.torque_limit,
        scenario.trajectory.peak_speed,
    )


def test_it_is_the_golden_controller(repository):
    golden = json.loads((repository / "tests/golden/tracking_costs.json").read_text())
    found = golden["parameters"]["recommended"]
    names = {"kd_x": "speed_gain_x", "kd_theta": "speed_gain_theta", "leak": "integral_retention"}
    names |= {"alpha_x": "speed_order_x", "alpha_theta": "speed_order_theta"}
    controller = Controller.recommended()
    for name, number in found.items():
        assert value(controller, names.get(name, name)) == number, name
    assert len(found) == len(default_bounds("tracking"))
    cost = simulate(Scenario.published(rng=0), controller).cost
    assert cost == pytest.approx(golden["costs"]["recommended"]["R:P/nom"], rel=1e-8)
    assert controller.sample_time == 0.2
    assert controller.robot == Robot.eddie()


def test_it_scales_with_robot_sample_time_limit_and_speed():
    """Each rule alone, as docs/theory.md has it."""
    eddie = Controller.recommended()
    drive = {"kp_x", "speed_gain_x", "integral_x"}
    steer = {"kp_y", "kp_theta", "speed_gain_theta", "integral_y", "integral_theta"}
    torque = {"amplitude_x", "amplitude_y", "amplitude_theta", "integral_limit"}
    half = {"speed_gain_x": 2, "speed_gain_theta": 2}
    half |= dict.fromkeys(("integral_x", "integral_y", "integral_theta"), 0.5)
    cases = [
        (Controller.recommended(Robot(mass=23.0)), dict.fromkeys(drive, 2)),
        (Controller.recommended(Robot(inertia=0.5873 / 2)), dict.fromkeys(steer, 0.5)),
        (Controller.recommended(Robot(track_width=0.904)), dict.fromkeys(steer, 0.5)),
        (Controller.recommended(Robot(wheel_radius=0.152)), dict.fromkeys(drive | steer, 2)),
        (Controller.recommended(sample_time=0.1), half),
        (Controller.recommended(torque_limit=6.156), dict.fromkeys(torque, 2)),
        (Controller.recommended(peak_speed=2 * 0.3350698998007755), {"lateral_speed": 2}),
    ]
    for controller, factors in cases:
        for name in default_bounds("tracking"):
            expected = value(eddie, name) * factors.get(name, 1)
            if name == "integral_retention":
                expected = value(eddie, name) ** (controller.sample_time / 0.2)
            assert value(controller, name) == pytest.approx(expected, rel=1e-12), name


def test_the_box_scales_with_the_scenario():
    published = default_bounds("tracking", Scenario.published())
    assert published == default_bounds("tracking")  # to the last bit
    assert published["speed_gain_x"] == (0, 25)
    assert published["lateral_speed"] == (0.02, 3)
    assert published["integral_retention"] == (0.8, 1)
    path = Trajectory.eight(period=18.0, dt=0.02, scale=0.3)
    scenario = ordinary(path)
    box = default_bounds("tracking", scenario)
    pace = 0.1
    drive = 5.0 * 0.033 / (11.5 * 0.076)
    steer = 0.08 * 0.033 / 0.30 / (0.5873 * 0.076 / 0.452)
    assert box["speed_gain_x"] == pytest.approx((0, 25 * drive / pace))
    assert box["kp_y"] == pytest.approx((0, 20 * steer))
    assert box["integral_theta"] == pytest.approx((0, steer * pace))
    assert box["amplitude_y"] == pytest.approx((0.05 * LIMIT / 3.078, 10 * LIMIT / 3.078))
    assert box["integral_retention"] == pytest.approx((0.8**pace, 1))
    speed = path.peak_speed / 0.3350698998007755
    assert box["lateral_speed"] == pytest.approx((0.02 * speed, 3 * speed))
    for name in ("pole_x", "speed_order_x", "lateral_power"):
        assert box[name] == published[name]
    # And what is searched lies in it, whose robot the result knows.
    result = tune(scenario, structure="tracking", maxfev=40, rng=0)
    for name, number in zip(result.parameters, result.x, strict=True):
        low, high = box[name]
        assert low <= number <= high
    assert result.controller.robot == ORDINARY
    assert default_bounds("extended", scenario) == default_bounds("extended")


@pytest.mark.parametrize("delay", [0, 1, 2])
def test_eddies_optimum_scaled_stabilises_an_ordinary_robot(delay):
    """A robot of 5 kg at 50 Hz, on a circle, by the orbit's multipliers and by simulation."""
    path = Trajectory.circle(period=12.0, dt=0.02, scale=0.3, laps=10)
    scenario = ordinary(path, delay=delay)
    controller = recommended_for(scenario)
    for name, (low, high) in default_bounds("tracking", scenario).items():
        assert low < value(controller, name) < high, name
    assert controller.speed_gain_x == pytest.approx(23.4, abs=0.1)
    assert np.abs(stability.loop(scenario, controller).multipliers).max() < 1
    aside = (path.x[0] + 0.05, path.y[0], path.theta[0])
    run = simulate(scenario.replace(initial_pose=aside, initial_velocity="reference"), controller)
    assert run.diverged_at is None
    error = np.hypot(run.columns["e_x"], run.columns["e_y"])
    assert error[-600:].max() < 0.1 * error[0]


def test_the_robot_stands_in_the_file(tmp_path):
    controller = Controller.recommended(ORDINARY, 0.02, LIMIT)
    file = tmp_path / "controller.json"
    controller.save(file)
    assert json.loads(file.read_text())["robot"]["mass"] == 5.0
    assert Controller.load(file) == controller
    assert Controller.load(file).robot == ORDINARY
    assert repr(controller).endswith(f").replace(robot={ORDINARY!r})")
    assert controller.replace(memory=7).robot == ORDINARY
    other = controller.replace(robot=None)
    assert other != controller
    assert other.robot is None
    assert "robot" not in json.loads(other.to_json())
    assert Controller.published().robot is None
    for text, message in (('"x"', "robot"), ('{"mass": -1}', "mass is -1")):
        document = controller.to_json().replace(
            json.dumps(json.loads(controller.to_json())["robot"], separators=(",", ":")), text
        )
        with pytest.raises(ValueError, match=message):
            Controller.from_json(document)
    with pytest.raises(TypeError, match="robot must be a Robot or None"):
        controller.replace(robot=3)


@pytest.mark.parametrize("field", ["mass", "inertia", "track_width", "wheel_radius"])
def test_another_robot_is_warned_about(field, scenario):
    controller = Controller.recommended()
    eddie = Robot.eddie()
    for factor in (1.2, 0.8):
        robot = eddie.replace(**{field: factor * getattr(eddie, field)})
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            simulate(scenario.replace(robot=robot), controller)
    for factor in (1.21, 0.79):
        robot = eddie.replace(**{field: factor * getattr(eddie, field)})
        with pytest.warns(UserWarning, match=f"simulate: .*another robot: its {field} is"):
            simulate(scenario.replace(robot=robot), controller)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            simulate(scenario.replace(robot=robot), controller.replace(robot=None))
            # The robot that it was made for is modelled: the true one is another on purpose.
            simulate(scenario.replace(robot=robot, model=eddie), controller)


@pytest.mark.parametrize("name", ["sample_time", "torque_limit", "peak_speed"])
@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf, 1e9])
def test_bad_numbers_are_refused(name, bad):
    with pytest.raises(ValueError, match=f"Controller.recommended: {name} is"):
        Controller.recommended(**{name: bad})


def test_gains_beyond_what_a_controller_has_are_refused():
    with pytest.raises(ValueError, match="must be in"):
        Controller.recommended(Robot(mass=1e6, wheel_radius=1e3))


def test_a_search_within_the_scaled_box_suits_the_ordinary_robot():
    """An eight of 1.2 m in 18 s, with friction: gains for 0.2 s are slow at 50 Hz, not its box."""
    path = Trajectory.eight(period=18.0, dt=0.02, scale=0.3)
    scenario = ordinary(path, coulomb_friction=0.03)
    slow = simulate(scenario, recommended_for(scenario))
    result = tune(scenario, structure="tracking", method="cma", rng=1, maxfev=1500)
    found = simulate(scenario, result.controller)
    position = [
        np.hypot(run.columns["x"] - path.x, run.columns["y"] - path.y) for run in (slow, found)
    ]
    root_mean_square = [np.sqrt(np.mean(error**2)) for error in position]
    assert slow.diverged_at is None
    assert root_mean_square[1] < 0.02 < 0.2 * root_mean_square[0]


def test_the_executable_says_so_too(executable, tmp_path):
    file = tmp_path / "controller.json"
    Controller.recommended().save(file)

    def words(*options):
        command = [executable, "--controller", file, "--traj", "circle", "--period", "10", *options]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        return done.stderr

    assert "another robot" not in words("--mass", "13.8")
    assert "made for another robot: its mass is 11.5 kg, the scenario's 20" in words("--mass", "20")
    assert words("--mass", "20", "--quiet") == ""
