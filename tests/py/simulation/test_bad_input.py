"""Every setting refuses what is out of range, and says which, what and what is allowed."""

import numpy as np
import pytest
from nfopidn import Robot, Scenario, Trajectory
from refusal import controller, from_samples, refused, scenario

NAN, INF = float("nan"), float("inf")
GAINS = np.ones((3, 3))

# Whoever takes the argument, its name, its range and unit, and how a message writes the range.
NUMBERS = [
    (Robot, "mass", 1e-6, 1e6, "in [1e-06, 1e+06] kg"),
    (Robot, "inertia", 1e-9, 1e9, "in [1e-09, 1e+09] kg m^2"),
    (Robot, "track_width", 1e-4, 1e3, "in [1e-04, 1000] m"),
    (Robot, "wheel_radius", 1e-4, 1e3, "in [1e-04, 1000] m"),
    (Trajectory.ranunculoid, "period", 1e-3, 1e9, "in [0.001, 1e+09] s"),
    (Trajectory.circle, "dt", 1e-6, 1e3, "in [1e-06, 1000] s"),
    (Trajectory.sine, "scale", 1e-3, 1e6, "in [0.001, 1e+06]"),
    (from_samples, "dt", 1e-6, 1e3, "in [1e-06, 1000] s"),
    (scenario, "torque_limit", 1e-6, 1e6, "in [1e-06, 1e+06] N m"),
    (scenario, "viscous_friction", 0, 1e3, "in [0, 1000] N m s/rad"),
    (scenario, "coulomb_friction", 0, 1e3, "in [0, 1000] N m"),
    (scenario, "divergence_distance", 1e-3, 1e6, "in [0.001, 1e+06] m"),
    (controller, "alpha", -2, 2, "in [-2, 2]"),
    (controller, "sigma", -2, 2, "in [-2, 2]"),
    (controller, "speed_scale", 0, 1e6, "in [0, 1e+06] m/s"),
    (controller, "amplitude_x", 1e-6, 1e6, "in [1e-06, 1e+06] N m"),
    (controller, "lateral_power", -10, 10, "in [-10, 10]"),
]
WHOLE_NUMBERS = [
    (Trajectory.ranunculoid, "cusps", 1, 50, "in [1, 50]"),
    (Trajectory.eight, "laps", 1, 10**6, "in [1, 1e+06]"),
    (from_samples, "laps", 1, 10**6, "in [1, 1e+06]"),
    (scenario, "substeps", 1, 10**4, "in [1, 10000]"),
    (scenario, "delay", 0, 64, "in [0, 64] samples"),
    (scenario, "rng", 0, 2**53, "in [0, 9007199254740992]"),
    (controller, "memory", 0, 1_000_000, "in [0, 1e+06] samples, or"),
]
# The same for lists: a good value, the path of an element in it, and the element's range.
LISTS = [
    (scenario, "initial_velocity", [0, 0], (0,), "in [-1000, 1000] m/s, rad/s"),
    (scenario, "pose_noise", [0, 0], (1,), "in [0, 1000] m, rad"),
    (scenario, "disturbance", [0, 0], (1,), "in [-1e+06, 1e+06] N, N m"),
    (scenario, "disturbance", np.zeros((11, 2)), (7, 1), "in [-1e+06, 1e+06] N, N m"),
    (controller, "gains", GAINS, (1, 2), "in [-1e+06, 1e+06] N m"),
    (controller, "allocation", np.ones((2, 3)), (1, 0), "in [-1000, 1000]"),
    (controller, "alpha", [0, 0, 0], (2,), "in [-2, 2]"),
]
CHOICES = [
    (Trajectory.ranunculoid, "heading", ["forward", "continuous"]),
    (Trajectory.ranunculoid, "derivatives", ["sampled", "analytic"]),
    (from_samples, "heading", ["forward", "continuous"]),
    (scenario, "integrator", ["semi-implicit-euler", "exact"]),
    (controller, "form", ["positional", "incremental"]),
    (controller, "activation", ["sigmoid", "linear"]),
    (controller, "frame", ["robot", "world"]),
    (controller, "generator", ["tustin", "gl"]),
    (controller, "lateral", ["plain", "direction", "speed", "scheduled"]),
    (controller, "anti_windup", ["none", "hold", "clamp"]),
    (controller, "allocation", ["paper", "decoupled"]),
]


def ids(rows):
    return [f"{row[0].__name__}-{row[1]}" for row in rows]


@pytest.mark.parametrize(("call", "name", "low", "high", "allowed"), NUMBERS, ids=ids(NUMBERS))
def test_numbers(call, name, low, high, allowed):
    for value in (NAN, INF, -INF, np.nextafter(low, -INF), np.nextafter(high, INF), -(10**30)):
        with refused(f"{name} is {float(value)!r}", allowed):
            call(**{name: value})


@pytest.mark.parametrize(("call", "name", "low", "high", "allowed"), NUMBERS, ids=ids(NUMBERS))
def test_what_is_no_number(call, name, low, high, allowed):
    for value, text in [("fast", '"fast"'), (None, "null"), (True, "true")]:
        with refused(f"{name} is {text}", "a number"):
            call(**{name: value})


@pytest.mark.parametrize(
    ("call", "name", "low", "high", "allowed"), WHOLE_NUMBERS, ids=ids(WHOLE_NUMBERS)
)
def test_whole_numbers(call, name, low, high, allowed):
    for value in (low - 1, high + 1, -(2**63), 2**64, 10**30):
        with refused(f"{name} is ", allowed):
            call(**{name: value})
    for value, text in [(low + 0.5, f"{low}.5"), ("7", '"7"'), (True, "true")]:
        with refused(f"{name} is {text}", "a whole number"):
            call(**{name: value})
    with refused(f"{name} is nan", allowed):
        call(**{name: NAN})


@pytest.mark.parametrize(
    ("call", "name", "low", "high"),
    [row[:4] for row in NUMBERS + WHOLE_NUMBERS if row[0] in (Robot, scenario, controller)],
)
def test_both_ends_of_a_range_are_allowed(call, name, low, high):
    for value in (low, high):
        made = call(**{name: value})
        assert getattr(made, "seed" if name == "rng" else name) == value


@pytest.mark.parametrize(("call", "name", "good", "place", "allowed"), LISTS, ids=ids(LISTS))
def test_lists_of_numbers(call, name, good, place, allowed):
    path = name + "".join(f"[{index}]" for index in place)
    call(**{name: good})
    for value, text, rule in [
        (NAN, "nan", allowed),
        (-INF, "-inf", allowed),
        (1e7, "1e+07", allowed),
        ("text", '"text"', "a number"),
        (None, "null", "a number"),
    ]:
        bad = np.array(good, dtype=object)
        bad[place] = value
        with refused(f"{path} is {text}", rule):
            call(**{name: bad})
    for wrong_shape in (np.array(good)[..., :-1], [], [good, good]):
        with refused(f"{name}"):
            call(**{name: wrong_shape})


def test_a_start_may_lie_as_far_as_paths_may():
    """Coordinates of a map: positions reach to 1e9 m, an angle to 1e6 rad."""
    end = 1e9
    path = Trajectory.from_samples(end - 0.1 * np.arange(5), -end + np.zeros(5), 0.1)
    for pose in ((end, -end, 1e6), (end - 9.0, -end, -1e6)):
        assert Scenario(path, initial_pose=pose).initial_pose == pose
    range_text = "must be in [-1e+09, 1e+09] m"
    with refused("initial_pose[0] is 1000000001", range_text):
        Scenario(path, initial_pose=(end + 1.0, -end, 0.0))
    with refused("x[0] is 1000000001", range_text):
        Trajectory.from_samples(path.x + 1.0, path.y, 0.1)
    with refused("initial_pose[2] is 1000001; must be in [-1e+06, 1e+06] rad"):
        Scenario(path, initial_pose=(end, -end, 1e6 + 1.0))
    with refused("initial_pose is 10.5 m from the reference's start", "divergence_distance, 10 m"):
        Scenario(path, initial_pose=(end - 10.5, -end, 0.0))


@pytest.mark.parametrize(("call", "name", "choices"), CHOICES, ids=ids(CHOICES))
def test_choices(call, name, choices):
    for choice in choices:
        call(**{name: choice})
    upper = choices[0].upper()
    for value, text in [
        ("sideways", '"sideways"'),
        (upper, f'"{upper}"'),
        ("", '""'),
        (None, "null"),
        (1, "1"),
    ]:
        with refused(f"{name} is {text}", *(f'"{choice}"' for choice in choices)):
            call(**{name: value})


@pytest.mark.parametrize("call", [scenario, lambda **s: scenario().replace(**s)])
def test_a_truth_value_is_true_or_false(call):
    for value, text in [(1, "1"), ("yes", '"yes"'), (None, "null"), (0.0, "0.0")]:
        with refused(f"feedforward is {text}; must be true or false"):
            call(feedforward=value)
