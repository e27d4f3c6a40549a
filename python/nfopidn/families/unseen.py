"""Paths and plants that no search has seen: what gains that were found elsewhere are worth."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Robot, Scenario, Trajectory
from nfopidn.arguments import whole_number
from nfopidn.families.family import Family

Array = NDArray[np.float64]
Draw = np.random.Generator
#: Makes a path that takes so many seconds a lap, and so many laps.
Maker = Callable[[float, int], Trajectory]

_EDDIE = Robot.eddie()
_DT = 0.2  # [s], the benchmarks'

#: The plants, with the change in words; benchmark() has others.
_PLANTS: dict[str, tuple[dict[str, Any], str]] = {
    "nominal": ({}, ""),
    "coulomb-0.15,mass-13.8": (
        {"coulomb_friction": 0.15, "robot": _EDDIE.replace(mass=13.8)},
        "Coulomb friction 0.15 N m a wheel, mass 13.8 kg",
    ),
    "delay,substeps-4": (
        {"delay": 1, "substeps": 4},
        "1 sample of delay, 4 integration steps a sample",
    ),
    "delay,substeps-20,inertia-0.294": (
        {"delay": 1, "substeps": 20, "robot": _EDDIE.replace(inertia=0.294)},
        "1 sample of delay, 20 integration steps a sample, inertia 0.294 kg m^2",
    ),
    "noise,coulomb-0.1": (
        {"pose_noise": (0.005, 0.005), "coulomb_friction": 0.1},
        "pose noise 5 mm and 5 mrad, Coulomb friction 0.1 N m a wheel",
    ),
    "disturbance": ({"disturbance": (-2.0, -0.2)}, "disturbance -2 N and -0.2 N m"),
    "viscous": ({"viscous_friction": 0.03}, "viscous friction 0.03 N m s/rad a wheel"),
}

#: The kinds of paths, which take turns.
_KINDS = ("spline", "cusps", "spline", "curve")
_CURVES = ("circle", "eight", "lemniscate", "rounded_square", "sine")
_CUSPS = (2, 4, 6, 7)  # the benchmarks have 3 and 5
_SPEEDS = 0.2, 0.8  # [m/s], of the peak
_LEAST_SECONDS = 20.0  # of a run: shorter laps are driven several times
_BESIDE = 0.1, 0.3  # [m], of the start
_SHARE = 0.9  # of the torque limit that reference and friction may take
_TURN = 1.25, 1.5  # [rad/s, rad/s^2], the benchmarks' fastest where the path has no cusp
_SLOWER = 1.1


def periodic_spline(x: Array, y: Array, count: int) -> tuple[Array, Array]:
    """Give points on the closed cubic spline through knots, evenly by the spline's parameter.

    The parameter is the chord's length, so that the points are nearly as far from one another.

    Parameters
    ----------
    x, y
        (n,): of the knots [m], n >= 3, the first not repeated.
    count
        Of points, the first at the first knot.

    Returns
    -------
    x, y
        (count,) [m]. Two derivatives are continuous everywhere, at the first knot too.
    """
    knots = np.column_stack([x, y])
    chord = np.roll(knots, -1, axis=0) - knots
    step = np.hypot(chord[:, 0], chord[:, 1])
    n = len(step)
    # Second derivatives: h_(i-1) m_(i-1) + 2 (h_(i-1) + h_i) m_i + h_i m_(i+1) = 6 (s_i - s_(i-1))
    # with slopes s of the chords and indices modulo n.
    before = np.roll(step, 1)
    matrix = np.diag(2 * (before + step))
    place = np.arange(n)
    np.add.at(matrix, (place, (place - 1) % n), before)
    np.add.at(matrix, (place, (place + 1) % n), step)
    slope = chord / step[:, None]
    second = np.linalg.solve(matrix, 6 * (slope - np.roll(slope, 1, axis=0)))
    end = np.cumsum(step)
    at = np.arange(count) * (end[-1] / count)
    piece = np.minimum(np.searchsorted(end, at, side="right"), n - 1)
    h = step[piece, None]
    u = at[:, None] - (end - step)[piece, None]
    m, following = second[piece], second[(piece + 1) % n]
    first = slope[piece] - h * (2 * m + following) / 6
    points = knots[piece] + u * (first + u * (m / 2 + u * (following - m) / (6 * h)))
    return points[:, 0], points[:, 1]


def _spline(draw: Draw) -> tuple[Maker, str]:
    count = int(draw.integers(5, 10))
    size = float(draw.uniform(0.8, 2.0))
    angle = 2 * np.pi * (np.arange(count) + draw.uniform(-0.25, 0.25, count)) / count
    radius = size * draw.uniform(0.5, 1.0, count)
    sense = float(draw.choice((-1.0, 1.0)))
    x, y = radius * np.cos(angle), sense * radius * np.sin(angle)

    def make(lap: float, laps: int) -> Trajectory:
        there_x, there_y = periodic_spline(x, y, round(lap / _DT))
        return Trajectory.from_samples(there_x, there_y, dt=_DT, laps=laps, closed=True)

    return make, f"closed spline through {count} knots up to {size:.2g} m from its middle"


def _named(curve: str, scale: float, **arguments: Any) -> Maker:
    def make(lap: float, laps: int) -> Trajectory:
        named = getattr(Trajectory, curve)
        made: Trajectory = named(period=lap, dt=_DT, laps=laps, scale=scale, **arguments)
        return made

    return make


def _cusps(draw: Draw) -> tuple[Maker, str]:
    cusps = int(draw.choice(_CUSPS))
    heading = str(draw.choice(("forward", "continuous")))
    scale = float(draw.uniform(0.6, 1.4))
    words = f"ranunculoid with {cusps} cusps, {heading} heading, scale {scale:.2g}"
    return _named("ranunculoid", scale, cusps=cusps, heading=heading), words


def _curve(draw: Draw) -> tuple[Maker, str]:
    curve = str(draw.choice(_CURVES))
    scale = float(draw.uniform(0.6, 1.8))
    return _named(curve, scale), f"{curve.replace('_', ' ')}, scale {scale:.2g}"


def _turns_slowly(path: Trajectory) -> bool:
    """Whether the turn rate and its change are none that a sample of delay makes impossible."""
    rate, change = np.abs(path.omega).max(), np.abs(path.turn_acceleration).max()
    return bool(rate <= _TURN[0] and change <= _TURN[1])


def _is_drivable(scenario: Scenario) -> bool:
    """Whether reference torques and friction leave a tenth of the torque limit."""
    path, robot = scenario.trajectory, scenario.robot
    turn = 0.5 * robot.track_width * np.abs(path.omega)
    wheel = (np.abs(path.v) + turn) / robot.wheel_radius
    torque = np.abs(scenario.reference[:, 5:7]).max(axis=1)
    needed = torque + scenario.coulomb_friction + scenario.viscous_friction * wheel
    return bool(needed.max() <= _SHARE * scenario.torque_limit)


def _scenario(path: Trajectory, beside: float) -> Scenario:
    """Start at rest, beside the path at its heading."""
    heading = path.theta[0]
    x, y = path.x[0] - beside * np.sin(heading), path.y[0] + beside * np.cos(heading)
    return Scenario(path, initial_pose=(float(x), float(y), float(heading)), rng=0)


def _members(kind: str, draw: Draw) -> list[tuple[str, Scenario, str]]:
    """Draw a path of a kind that every plant can drive, and give it with each plant."""
    make, words = {"spline": _spline, "cusps": _cusps, "curve": _curve}[kind](draw)
    low, high = _SPEEDS
    speed = math.exp(float(draw.uniform(math.log(low), math.log(high))))
    beside = float(draw.uniform(*_BESIDE)) * float(draw.choice((-1.0, 1.0)))
    lap = 100.0
    lap *= make(lap, 1).peak_speed / speed
    while True:
        whole = max(round(lap / _DT), 10) * _DT
        path = make(whole, math.ceil(_LEAST_SECONDS / whole))
        start = _scenario(path, beside)
        scenarios = {name: start.replace(**change) for name, (change, _) in _PLANTS.items()}
        slow = kind == "cusps" or _turns_slowly(path)  # at a cusp a robot may turn on the spot
        if slow and all(map(_is_drivable, scenarios.values())):
            break
        lap *= _SLOWER
    words += f", {len(path) * _DT:.4g} s, up to {path.peak_speed:.2g} m/s"
    return [
        (name, scenario, ", ".join(filter(None, (words, _PLANTS[name][1]))))
        for name, scenario in scenarios.items()
    ]


def unseen(count: int = 12, rng: int = 0) -> Family:
    """Give a family on which no gains should be tuned: it tells how far they carry over.

    Closed splines through random knots make half of the paths, ranunculoids with 2, 4, 6 or 7
    cusps and other curves a quarter each, at random scales and peak speeds from 0.2 to 0.8 m/s.
    Each is driven by the paper's robot, which rests up to 0.3 m beside the start, as seven plants:
    nominal; Coulomb friction 0.15 N m a wheel and mass 13.8 kg; delay and 4 integration steps a
    sample; delay, 20 steps and inertia 0.294 kg m^2; noise and Coulomb friction 0.1 N m; the
    opposite of benchmark("R")'s disturbance; and viscous friction 0.03 N m s/rad. As in benchmark()
    the reference torques are those of the scenario's own robot and the integrator is the
    semi-implicit Euler's. Each path is slow enough that its reference torques and friction together
    leave a tenth of the torque limit with every plant, and that, cusps apart, it turns no faster
    than benchmark("G")'s fastest: 1.25 rad/s, changing by 1.5 rad/s^2.

    Parameters
    ----------
    count
        Of paths, [1, 1000]; the family has seven times as many scenarios, named
        "spline 1/nominal", "spline 1/viscous", "cusps 2/nominal", ...
    rng
        A seed: the same seed gives the same family, and a larger count begins with the smaller's.

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed.

    Examples
    --------
    >>> import nfopidn
    >>> family = nfopidn.families.unseen(2)
    >>> len(family), family.names[-1]
    (14, 'cusps 2/viscous')
    """
    whole_number("count", count, 1, 1000)
    whole_number("rng", rng, 0, 2**53)
    members = []
    for place in range(count):
        kind = _KINDS[place % len(_KINDS)]
        for name, scenario, words in _members(kind, np.random.default_rng([rng, place])):
            members.append((f"{kind} {place + 1}/{name}", scenario, words))
    return Family.of(members)
