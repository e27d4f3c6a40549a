"""Hypothesis strategies: any valid robot, trajectory, scenario and controller."""

import math
import warnings

import numpy as np
from hypothesis import strategies as st
from nfopidn import Controller, Motor, Robot, Scenario, Trajectory

CURVES = ["circle", "lemniscate", "eight", "line", "sine", "rounded_square"]
headings = st.sampled_from(["forward", "continuous"])


def numbers(low, high):
    return st.floats(low, high, allow_nan=False)


def logarithmic(low, high):
    """Of every order of magnitude alike."""
    return numbers(math.log10(low), math.log10(high)).map(
        lambda exponent: min(max(10.0**exponent, low), high)
    )


def any_of(*choices):
    return st.sampled_from(choices)


robots = st.builds(
    Robot,
    mass=logarithmic(1e-6, 1e6),
    inertia=logarithmic(1e-9, 1e9),
    track_width=logarithmic(1e-4, 1e3),
    wheel_radius=logarithmic(1e-4, 1e3),
)
motors = st.builds(
    Motor,
    resistance=logarithmic(1e-3, 1e3),
    torque_constant=logarithmic(1e-4, 10),
    back_emf_constant=st.just(0.0) | logarithmic(1e-4, 10),
    gear_ratio=logarithmic(0.1, 1e3),
    rotor_inertia=st.just(0.0) | logarithmic(1e-9, 1),
    viscous_friction=st.just(0.0) | logarithmic(1e-6, 10),
    coulomb_friction=st.just(0.0) | logarithmic(1e-6, 10),
    supply_voltage=logarithmic(0.1, 1e3),
    dead_band=st.just(0.0) | logarithmic(1e-3, 10),
)
ordinary_robots = st.builds(
    Robot,
    mass=numbers(5, 20),
    inertia=numbers(0.2, 1),
    track_width=numbers(0.3, 0.6),
    wheel_radius=numbers(0.05, 0.1),
)


@st.composite
def named_trajectories(draw):
    settings = {
        "period": draw(logarithmic(1e-3, 1e6)),
        "heading": draw(headings),
        "scale": draw(logarithmic(1e-3, 1e6)),
        "laps": draw(st.integers(1, 3)),
        "derivatives": draw(any_of("sampled", "analytic")),
    }
    steps = draw(st.integers(3, 60))
    settings["dt"] = min(max(settings["period"] * settings["laps"] / steps, 1e-6), 1e3)
    if settings["dt"] == 1e3:
        settings["period"] = 1e3 * steps / settings["laps"]
    if draw(st.booleans()):
        return Trajectory.ranunculoid(**settings, cusps=draw(st.integers(1, 50)))
    return getattr(Trajectory, draw(any_of(*CURVES)))(**settings)


@st.composite
def sampled_trajectories(draw, reach=1e9):
    count = draw(st.integers(3, 40))
    positions = st.lists(numbers(-reach, reach), min_size=count, max_size=count)
    x, y = draw(positions), draw(positions)
    laps = draw(st.integers(1, 3))
    if laps > 1:
        x[-1], y[-1] = x[0], y[0]
    dt, heading = draw(logarithmic(1e-3, 1e3)), draw(headings)
    with warnings.catch_warnings():
        # Of a path that is slow where its positions do not tell the direction.
        warnings.simplefilter("ignore", UserWarning)
        return Trajectory.from_samples(x, y, dt, heading=heading, laps=laps)


@st.composite
def walks(draw):
    """A path that a robot can follow: steps of bounded length and turn."""
    count = draw(st.integers(3, 60))
    lengths = draw(st.lists(numbers(0.01, 0.1), min_size=count, max_size=count))
    turns = draw(st.lists(numbers(-0.2, 0.2), min_size=count, max_size=count))
    heading = np.cumsum(turns)
    return np.cumsum(lengths * np.cos(heading)), np.cumsum(lengths * np.sin(heading))


@st.composite
def scenarios(draw):
    trajectory = draw(named_trajectories() | sampled_trajectories() | sampled_trajectories(3.0))
    distance = draw(logarithmic(1e-3, 1e6))
    pose = None
    if draw(st.booleans()) and max(abs(trajectory.x[0]), abs(trajectory.y[0])) < 5e5:
        offset, angle = draw(numbers(0, 0.9)) * min(distance, 1e5), draw(numbers(-4, 4))
        pose = (
            trajectory.x[0] + offset * math.cos(angle),
            trajectory.y[0] + offset * math.sin(angle),
            draw(numbers(-1e6, 1e6) | numbers(-4, 4)),
        )
    pairs = st.tuples(numbers(-1e6, 1e6), numbers(-1e6, 1e6))
    mild = st.tuples(numbers(-3, 3), numbers(-1, 1))
    count = len(trajectory)
    return Scenario(
        trajectory,
        draw(robots | ordinary_robots),
        initial_pose=pose,
        initial_velocity=draw(
            st.just("reference") | st.tuples(numbers(-1e3, 1e3), numbers(-1e3, 1e3))
        ),
        torque_limit=draw(logarithmic(1e-6, 1e6)),
        feedforward=draw(st.booleans()),
        integrator=draw(any_of("semi-implicit-euler", "exact")),
        substeps=draw(st.integers(1, 10) | st.just(200)),
        disturbance=draw(pairs | mild | st.lists(mild, min_size=count, max_size=count)),
        viscous_friction=draw(st.just(0.0) | logarithmic(1e-6, 1e3)),
        coulomb_friction=draw(st.just(0.0) | logarithmic(1e-6, 1e3)),
        viscous_scrub=draw(st.just(0.0) | logarithmic(1e-6, 1e3)),
        coulomb_scrub=draw(st.just(0.0) | logarithmic(1e-6, 1e3)),
        pose_noise=draw(st.just((0.0, 0.0)) | st.tuples(numbers(0, 1e3), numbers(0, 1))),
        delay=draw(st.integers(0, 64)),
        divergence_distance=distance,
        rng=draw(st.integers(0, 2**53)),
        model=draw(st.none() | robots),
        motor=draw(st.none() | motors),
        feedforward_limit=draw(st.none() | logarithmic(1e-6, 1e6)),
        encoder_counts=draw(st.just(0) | st.integers(1, 10**6)),
        odometry_errors=draw(st.just((0.0, 0.0, 0.0)) | st.tuples(*[numbers(-0.5, 0.5)] * 3)),
        friction_feedforward=draw(st.just((0.0, 0.0)) | st.tuples(numbers(0, 1), numbers(0, 1))),
        friction_feedforward_speed=draw(st.just(0.5) | logarithmic(1e-6, 1e6)),
        cost_weights=draw(st.just((1.0, 1.0, 1.0)) | st.tuples(*[logarithmic(1e-3, 1e3)] * 3)),
        noise_source=draw(st.sampled_from(["mersenne", "counter"])),
    )


orders = numbers(-2, 2)


def matrices(rows, columns, reach):
    return st.lists(
        st.lists(numbers(-reach, reach), min_size=columns, max_size=columns),
        min_size=rows,
        max_size=rows,
    )


structures = {
    "memory": st.integers(0, 12) | st.just(1024),
    "form": any_of("positional", "incremental"),
    "activation": any_of("sigmoid", "linear"),
    "frame": any_of("robot", "world"),
    "generator": any_of("tustin", "gl"),
    "lateral": any_of("plain", "direction", "speed", "scheduled"),
    "speed_scale": st.just(0.0) | logarithmic(1e-6, 1e6),
    "anti_windup": any_of("none", "hold", "clamp"),
    "sample_time": st.none(),  # another than the scenario's is refused: test_sample_time.py
}
controllers = st.builds(
    Controller,
    gains=matrices(3, 3, 3.0) | matrices(3, 3, 1e6),
    alpha=orders | st.tuples(orders, orders, orders),
    sigma=orders | st.tuples(orders, orders, orders),
    allocation=any_of("paper", "decoupled") | matrices(2, 3, 1e3),
    **structures,
)
decoupled_controllers = st.builds(
    Controller,
    gains=matrices(3, 3, 3.0),
    alpha=orders,
    sigma=orders,
    allocation=st.just("decoupled"),
    **structures,
)
