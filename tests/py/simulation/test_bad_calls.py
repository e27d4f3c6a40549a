"""Calls that no setting's range can refuse: wrong types, names, shapes and combinations."""

import numpy as np
import pytest
from nfopidn import Controller, Robot, Scenario, Trajectory, simulate
from refusal import LINE, controller, from_samples, refused, scenario

NAN, INF = float("nan"), float("inf")
GAINS = np.ones((3, 3))


@pytest.mark.parametrize("value", [10**400, -(10**400)], ids=["", "-"])
@pytest.mark.parametrize(
    ("call", "name"), [(Robot, "mass"), (controller, "memory"), (from_samples, "dt")]
)
def test_integers_beyond_every_float(call, name, value):
    with refused(name, "in ["):
        call(**{name: value})


@pytest.mark.parametrize(
    ("call", "name"), [(Robot, "mass"), (controller, "form"), (from_samples, "heading")]
)
def test_text_that_is_no_unicode(call, name):
    with refused(name):
        call(**{name: "\ud800"})


@pytest.mark.parametrize("value", [object(), 1j, b"1", {1}, {"a": 1}, np.datetime64("now")])
@pytest.mark.parametrize(("call", "name"), [(Robot, "mass"), (controller, "gains")])
def test_objects_that_mean_nothing_here(call, name, value):
    with refused(name, exception=TypeError):
        call(**{name: value})


CALLABLES = [
    Robot,
    Robot().replace,
    controller,
    controller().replace,
    Controller.published,
    lambda **settings: Controller.from_vector(np.zeros(11), **settings),
    scenario,
    scenario().replace,
    Scenario.published,
    Trajectory.ranunculoid,
    Trajectory.circle,
]


@pytest.mark.parametrize("call", CALLABLES)
def test_unknown_keywords(call):
    with refused("mas", exception=TypeError):
        call(mas=1)
    with refused("kp_x", exception=TypeError):
        call(**{"kp_x": 1})


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: Robot(1, mass=2), "mass"),
        (lambda: Scenario(LINE, trajectory=LINE), "trajectory"),
        (lambda: Controller.published(3, memory=4), "memory"),
        (lambda: Controller.from_vector(np.zeros(11), gains=GAINS), "gains"),
        (lambda: Controller.from_vector(np.zeros(11), alpha=1), "alpha"),
        (lambda: Robot(1, 2, 3, 4, 5), "4"),
        (lambda: Trajectory.circle(150, 0.2, 3, "forward", 1, 1, "sampled", 0), "6"),
        (Controller, "gains"),
        (lambda: Controller(GAINS), "alpha"),
        (lambda: Controller(GAINS, 1), "sigma"),
        (Scenario, "trajectory"),
        (lambda: Scenario(None), "trajectory"),
        (lambda: Scenario(LINE, 3), "robot"),
        (lambda: scenario().replace(trajectory="line"), "trajectory"),
    ],
)
def test_arguments_given_twice_or_not_at_all(call, name):
    with refused(name, exception=TypeError):
        call()


@pytest.mark.parametrize(
    "call", [lambda: simulate(1), lambda: simulate(controller()), lambda: simulate(seed=1)]
)
def test_simulate_takes_a_scenario_and_a_controller(call):
    with pytest.raises(TypeError, match="Scenario"):
        call()


@pytest.mark.parametrize(
    ("settings", "parts"),
    [
        ({"x": [0, 1, NAN]}, ["x[2] is nan", "finite"]),
        ({"y": [INF, 1, 2]}, ["y[0] is inf", "finite"]),
        ({"x": [0, 2e9, 1]}, ["x[1] is 2e+09", "in [-1e+09, 1e+09] m"]),
        ({"x": [0, 1]}, ["y has 3", "as many as x, 2"]),
        ({"x": [0, 1], "y": [1, 2]}, ["samples is 2", "in [3, 1e+07]"]),
        ({"x": [], "y": []}, ["samples is 0", "in [3, 1e+07]"]),
        ({"x": [[0, 1, 2]]}, ["x has 2 dimensions", "must have 1"]),
        ({"y": 3.0}, ["y has 0 dimensions", "must have 1"]),
        ({"laps": 2}, ["laps is 2", "must be 1"]),
        ({"origin": (0, 2e9)}, ["origin[1] is 2e+09", "in [-1e+09, 1e+09] m"]),
        ({"origin": (0,)}, ["origin must have 2 numbers"]),
    ],
)
def test_samples_of_a_trajectory(settings, parts):
    with refused(*parts):
        from_samples(**settings)


@pytest.mark.parametrize(
    "settings", [{"x": "abc"}, {"x": None}, {"y": [0, "a", 1]}, {"y": object()}]
)
def test_samples_that_are_no_numbers(settings):
    with pytest.raises((TypeError, ValueError), match=rf"\b{next(iter(settings))}\b"):
        from_samples(**settings)


@pytest.mark.parametrize(
    ("call", "parts"),
    [
        (lambda: Trajectory.line(period=0.3), ["samples is 2", "in [3, 1e+07]"]),
        (lambda: Trajectory.line(1e9, 1e-3), ["samples is 1000000000001", "in [3, 1e+07]"]),
        (lambda: scenario(disturbance=np.zeros((10, 2))), ["disturbance has 10", "11"]),
        (lambda: scenario(disturbance=np.zeros((12, 2))), ["disturbance has 12", "11"]),
        (lambda: scenario(initial_pose=(0, 11, 0)), ["initial_pose is 11 m", "10 m"]),
        (
            lambda: scenario(initial_pose=(0, 2, 0), divergence_distance=1),
            ["initial_pose is 2 m", "divergence_distance", "1 m"],
        ),
        (lambda: Controller.from_vector(np.zeros(12)), ["x has 12", "11", "15"]),
        (lambda: Controller.from_vector([NAN] * 11), ["gains[0][0] is nan"]),
        (lambda: Controller.from_vector([0] * 9 + [2.5, 0]), ["alpha is 2.5", "in [-2, 2]"]),
        (lambda: Controller.from_vector([0] * 14 + [-3]), ["sigma[2] is -3", "in [-2, 2]"]),
        (lambda: Controller.from_vector(np.zeros((1, 11))), ["x has 2 dimensions"]),
    ],
)
def test_what_does_not_fit_together(call, parts):
    with refused(*parts):
        call()


POSE, SAMPLE = [0, 0, 0], [0, 0, 0, 0, 0, 0, 0, 0]


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (([0, NAN, 0], SAMPLE), ["measurement[1] is nan", "finite"]),
        ((POSE, [*SAMPLE[:7], INF]), ["reference[7] is inf", "finite"]),
        ((POSE[:2], SAMPLE), ["measurement has 2", "3 to 5"]),
        (([0] * 6, SAMPLE), ["measurement has 6", "3 to 5"]),
        ((POSE, SAMPLE[:7]), ["reference has 7", "8"]),
        ((POSE, [SAMPLE, SAMPLE]), ["reference has", "8"]),
        ((POSE, SAMPLE, 0), ["torque_limit is 0", "greater than 0 N m"]),
        ((POSE, SAMPLE, -1), ["torque_limit is -1", "greater than 0 N m"]),
        ((POSE, SAMPLE, INF), ["torque_limit is inf", "finite"]),
    ],
)
def test_step(arguments, parts):
    with refused(*parts):
        controller().step(*arguments)


def test_lateral_speed_needs_its_scale_outside_a_simulation():
    with refused("speed_scale is 0", "greater than 0"):
        controller(lateral="speed").step(POSE, SAMPLE)


@pytest.mark.parametrize(
    ("value", "changes"),
    [
        (Robot(), {"inertia": 2.0, "mass": -1}),
        (controller(), {"memory": 7, "form": "none"}),
        (scenario(rng=1), {"delay": 3, "disturbance": np.zeros((5, 2))}),
        (scenario(rng=1), {"delay": 3, "robot": None}),
    ],
)
def test_a_refused_change_changes_nothing(value, changes):
    before, state = repr(value), hash(value)
    with pytest.raises((TypeError, ValueError)):
        value.replace(**changes)
    assert (repr(value), hash(value)) == (before, state)
