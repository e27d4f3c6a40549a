"""A scenario and its plant a little other, whose controller and model stay as they are."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nfopidn._core import Scenario
from nfopidn.arguments import is_number, shown, whole_number
from nfopidn.families.family import Family

_GRAVITY = 9.81  # [m/s^2]

Changes = dict[str, Any]


@dataclass(frozen=True)
class Quantity:
    """What variations may change, by how much, and how that is said.

    Attributes
    ----------
    low, high
        what a variation may be, the ends included; of a factor, low itself is refused if it is 0
    neutral
        what would change nothing
    whole
        whether it must be a whole number
    rule
        what the number is, in words with units
    apply
        changes of a scenario, given what is changed already
    words
        a short name and the change with units
    """

    low: float
    high: float
    neutral: float
    whole: bool
    rule: str
    apply: Callable[[Scenario, float, Changes], Changes]
    words: Callable[[Scenario, float], tuple[str, str]]


def _robot_factor(field: str, name: str, unit: str) -> Quantity:
    def apply(scenario: Scenario, factor: float, done: Changes) -> Changes:
        robot = done.get("robot", scenario.robot)
        return {"robot": robot.replace(**{field: getattr(robot, field) * factor})}

    def words(scenario: Scenario, factor: float) -> tuple[str, str]:
        value = getattr(scenario.robot, field) * factor
        return f"{name} x{factor:g}", f"{name} {value:.4g} {unit}"

    return Quantity(0.01, 100, 1, False, f"a factor of the robot's {name}", apply, words)


def _coulomb(scenario: Scenario, share: float, _: Changes) -> Changes:
    friction = scenario.coulomb_friction + share * scenario.torque_limit
    if friction >= scenario.torque_limit:
        raise ValueError(
            f"Coulomb friction is {friction:g} N m a wheel; must be under the torque limit, "
            f"{scenario.torque_limit:g} N m, or the robot cannot move"
        )
    return {"coulomb_friction": friction}


def _coulomb_words(scenario: Scenario, share: float) -> tuple[str, str]:
    friction = scenario.coulomb_friction + share * scenario.torque_limit
    return f"friction {100 * share:g} %", f"Coulomb friction {friction:.4g} N m a wheel"


def _scrub_of(scenario: Scenario, share: float) -> tuple[float, float]:
    """Give the Coulomb scrub [N m], and the moment of both torques at their limits.

    One wheel forwards and one backwards, each with the torque t, turn the robot by t L / r.
    """
    robot = scenario.robot
    most = scenario.torque_limit * robot.track_width / robot.wheel_radius
    return scenario.coulomb_scrub + share * most, most


def _scrub(scenario: Scenario, share: float, _: Changes) -> Changes:
    scrub, most = _scrub_of(scenario, share)
    if scrub >= most:
        raise ValueError(
            f"Coulomb scrub is {scrub:g} N m; must be under the moment of both torques at their "
            f"limits, {most:g} N m, or the robot cannot turn"
        )
    return {"coulomb_scrub": scrub}


def _scrub_words(scenario: Scenario, share: float) -> tuple[str, str]:
    return f"scrub {100 * share:g} %", f"Coulomb scrub {_scrub_of(scenario, share)[0]:.4g} N m"


def _disturbance_of(scenario: Scenario, share: float) -> tuple[float, float]:
    """Give the force [N] of a share of the weight, and the moment [N m] that takes as much torque.

    A force F takes F r of both wheels together; so does the moment F L / 2.
    """
    force = share * scenario.robot.mass * _GRAVITY
    return force, force * scenario.robot.track_width / 2


def _disturbance(scenario: Scenario, share: float, _: Changes) -> Changes:
    own = np.asarray(scenario.disturbance) + np.array(_disturbance_of(scenario, share))
    return {"disturbance": own.tolist()}


def _disturbance_words(scenario: Scenario, share: float) -> tuple[str, str]:
    force, moment = _disturbance_of(scenario, share)
    text = f"disturbance of {force:.4g} N and {moment:.4g} N m"
    return f"disturbance {100 * share:g} %", text


def _noise(scenario: Scenario, deviation: float, _: Changes) -> Changes:
    # Independent noises add by their squares.
    return {"pose_noise": [float(np.hypot(own, deviation)) for own in scenario.pose_noise]}


def _noise_words(_: Scenario, deviation: float) -> tuple[str, str]:
    milli = 1e3 * deviation
    return f"noise {milli:g} mm", f"pose noise {milli:g} mm and {milli:g} mrad"


def _delay_words(scenario: Scenario, samples: float) -> tuple[str, str]:
    milliseconds = 1e3 * samples * scenario.trajectory.dt
    plural = "sample" if samples == 1 else "samples"
    return f"delay +{samples:g}", f"{samples:g} {plural} ({milliseconds:.4g} ms) of delay"


def _substeps(scenario: Scenario, factor: float, _: Changes) -> Changes:
    if scenario.integrator == "exact":
        raise ValueError("contradicts the integrator 'exact', which needs no substeps")
    return {"substeps": scenario.substeps * int(factor)}


def _start(scenario: Scenario, tracks: float, _: Changes) -> Changes:
    path = scenario.trajectory
    x, y, theta = scenario.initial_pose or (path.x[0], path.y[0], path.theta[0])
    heading, distance = path.theta[0], tracks * scenario.robot.track_width
    pose = (x - distance * np.sin(heading), y + distance * np.cos(heading), theta)
    return {"initial_pose": [float(one) for one in pose]}


def _starts_within(scenario: Scenario, combination: Mapping[str, float]) -> bool:
    """Whether a variation's run does not begin as one that has diverged."""
    x, y, _ = _start(scenario, combination.get("start", 0.0), {})["initial_pose"]
    path = scenario.trajectory
    return float(np.hypot(x - path.x[0], y - path.y[0])) < scenario.divergence_distance


def _start_words(scenario: Scenario, tracks: float) -> tuple[str, str]:
    distance = abs(tracks) * scenario.robot.track_width
    side = "left" if tracks > 0 else "right"
    return f"start {tracks:+g} track", f"starts {distance:.4g} m further to the {side}"


#: What variations() may be given, by keyword.
QUANTITIES: dict[str, Quantity] = {
    "mass": _robot_factor("mass", "mass", "kg"),
    "inertia": _robot_factor("inertia", "inertia", "kg m^2"),
    "track_width": _robot_factor("track_width", "track", "m"),
    "wheel_radius": _robot_factor("wheel_radius", "wheel radius", "m"),
    "coulomb_friction": Quantity(
        *(0, 1, 0, False, "a share of the torque limit, a wheel"), _coulomb, _coulomb_words
    ),
    "viscous_friction": Quantity(
        *(0, 1e3, 0, False, "N m s/rad a wheel"),
        lambda scenario, value, _: {"viscous_friction": scenario.viscous_friction + value},
        lambda _, value: (f"viscous {value:g}", f"viscous friction {value:g} N m s/rad a wheel"),
    ),
    "scrub": Quantity(
        *(0, 1, 0, False, "a share of the moment of both torques at their limits"),
        _scrub,
        _scrub_words,
    ),
    "disturbance": Quantity(
        *(-1, 1, 0, False, "a share of the weight"), _disturbance, _disturbance_words
    ),
    "pose_noise": Quantity(
        *(0, 10, 0, False, "m and rad, a standard deviation"), _noise, _noise_words
    ),
    "delay": Quantity(
        *(1, 64, 0, True, "samples"),
        lambda scenario, samples, _: {"delay": scenario.delay + int(samples)},
        _delay_words,
    ),
    "substeps": Quantity(
        *(2, 10000, 1, True, "a factor of the integration steps"),
        _substeps,
        lambda _, factor: (f"substeps x{factor:g}", f"{factor:g} times as many integration steps"),
    ),
    "start": Quantity(
        *(-100, 100, 0, False, "track widths to the left of the start"), _start, _start_words
    ),
}

_SMALL_TURNER = {"inertia": 0.5, "track_width": 0.863}
#: What Scenario.variations("standard") changes, one at a time, and the corners where two meet.
STANDARD: dict[str, Any] = {
    "mass": (1.2, 0.8),
    "inertia": 0.5,
    "track_width": 0.863,
    "coulomb_friction": (0.03, 0.06),
    "disturbance": 0.02,
    "pose_noise": 0.005,
    "delay": 1,
    "corners": (
        {"delay": 1, **_SMALL_TURNER},
        {"delay": 1, "coulomb_friction": 0.06},
    ),
    "start": (0.45, -0.45),
}
#: What is standard besides where the integrator is the semi-implicit Euler's.
_EULER: dict[str, Any] = {"substeps": (4, 20), "corners": ({"delay": 1, "substeps": 4},)}


def variations(scenario: Scenario, which: str | None = None, **changes: Any) -> Family:
    """Give a family: a scenario as it is, and with its plant a little other.

    The plant and the start alone change: the feedforward still assumes the scenario's
    model, by default the robot as it was. Changes come on top of what the scenario has.

    Parameters
    ----------
    scenario
        Named "nominal" in the family.
    which
        "standard": mass x1.2 and x0.8, inertia x0.5, track x0.863, Coulomb friction of 3 % and 6 %
        of the torque limit a wheel, a disturbance of 2 % of the weight and the moment that takes
        as much torque, noise of 5 mm and 5 mrad, one sample of delay; a start 0.45 tracks further
        to the left, and to the right, unless that is beyond the divergence distance; and the
        corners delay with inertia x0.5 and track x0.863, and delay with 6 % friction. With the
        semi-implicit Euler integrator also 4 and 20 times the substeps, and delay with 4 times.
        None: `changes` alone.
    mass, inertia, track_width, wheel_radius
        Factors of the robot's, one number or several, a variation each; [0.01, 100].
    coulomb_friction
        Shares of the torque limit, a wheel; [0, 1].
    viscous_friction
        [N m s/rad] a wheel; [0, 1000].
    scrub
        Coulomb scrub: shares of the moment that turns the robot when one torque is at its limit
        forwards and the other backwards, torque_limit L / r; [0, 1].
    disturbance
        Shares of the weight; [-1, 1].
    pose_noise
        Standard deviations [m] and [rad]; [0, 10].
    delay
        Samples; [1, 64].
    substeps
        Factors of the integration steps; [2, 10000].
    start
        Track widths by which the robot starts further to the left, seen along the path at its
        start, or to the right if negative; [-100, 100]. The reference stays.
    corners
        Mappings of the names above to one number each, which act together.

    Returns
    -------
    Family
        Names, scenarios and changes in words with units.

    Raises
    ------
    ValueError
        No variation, one out of its range or beyond what a scenario may have, one that stands
        twice or changes nothing, or one that contradicts the scenario.

    Examples
    --------
    >>> import nfopidn
    >>> scenario = nfopidn.Scenario.published(rng=0)
    >>> print(scenario.variations(mass=(0.8, 1.2), corners=[{"mass": 1.2, "delay": 1}]))
    nominal
    mass x0.8            mass 9.2 kg
    mass x1.2            mass 13.8 kg
    mass x1.2, delay +1  mass 13.8 kg, 1 sample (200 ms) of delay
    """
    if not isinstance(scenario, Scenario):
        raise ValueError(f"scenario is {scenario!r}; must be a Scenario")
    wanted = _combinations(changes)
    if which is not None:
        if which != "standard":
            raise ValueError(f"variations: which is {shown(which)}; must be 'standard' or None")
        euler = scenario.integrator == "semi-implicit-euler"
        standard = [one for one in _combinations(STANDARD) if _starts_within(scenario, one)]
        wanted = [*standard, *(_combinations(_EULER) if euler else []), *wanted]
    if not wanted:
        raise ValueError(
            "variations: the family is empty; give 'standard' or one of "
            f"{', '.join([*QUANTITIES, 'corners'])}"
        )
    members = [("nominal", scenario, "")]
    members += [_member(scenario, combination) for combination in wanted]
    return Family.of(members)


def _combinations(changes: Mapping[str, Any]) -> list[dict[str, float]]:
    """Give the variations that are asked for, each as numbers by name."""
    single: list[dict[str, float]] = []
    for name, given in changes.items():
        if name == "corners":
            continue
        values = given if _is_sequence(given) else [given]
        if len(values) == 0:
            raise ValueError(f"variations: {name} is empty; must have at least one number")
        single += [{name: _checked(name, value)} for value in values]
    corners = changes.get("corners", ())
    if not _is_sequence(corners):
        raise ValueError(f"variations: corners is {shown(corners)}; must be a list of mappings")
    return single + [_corner(place, corner) for place, corner in enumerate(corners)]


def _corner(place: int, corner: Any) -> dict[str, float]:
    if not isinstance(corner, Mapping) or not corner:
        raise ValueError(
            f"variations: corners[{place}] is {shown(corner)}; must map names to one number each"
        )
    return {name: _checked(name, value) for name, value in corner.items()}


def _is_sequence(value: Any) -> bool:
    return isinstance(value, Sequence | np.ndarray) and not isinstance(value, str)


def _checked(name: Any, value: Any) -> float:
    """Give a variation's number, or refuse it."""
    if name not in QUANTITIES:
        known = ", ".join([*QUANTITIES, "corners"])
        raise ValueError(f"variations: {name!r} is unknown; known: {known}")
    quantity = QUANTITIES[name]
    if not is_number(value) or not quantity.low <= float(value) <= quantity.high:
        raise ValueError(
            f"variations: {name} is {shown(value)}; must be in "
            f"[{quantity.low:g}, {quantity.high:g}] ({quantity.rule})"
        )
    if quantity.whole and float(value) != int(value):
        raise ValueError(f"variations: {name} is {shown(value)}; must be a whole number")
    if float(value) == quantity.neutral:
        raise ValueError(f"variations: {name} is {shown(value)}, which changes nothing")
    return float(value)


def _member(scenario: Scenario, combination: Mapping[str, float]) -> tuple[str, Scenario, str]:
    """Give a variation's name, its scenario, and its change in words."""
    words = [QUANTITIES[name].words(scenario, value) for name, value in combination.items()]
    name = ", ".join(short for short, _ in words)
    changes: Changes = {}
    try:
        for quantity, value in combination.items():
            changes.update(QUANTITIES[quantity].apply(scenario, value, changes))
        if "robot" in changes:
            changes["model"] = scenario.model or scenario.robot
        return name, scenario.replace(**changes), ", ".join(long for _, long in words)
    except ValueError as error:
        raise ValueError(f"variations: {name}: {error}") from None


#: Between what random_variations() draws.
RANDOM: dict[str, tuple[float, float]] = {
    "mass": (0.8, 1.2),
    "inertia": (0.5, 1.5),
    "track_width": (0.863, 1.1),
    "coulomb_friction": (0.0, 0.06),
    "disturbance": (-0.02, 0.02),
    "pose_noise": (0.0, 0.005),
    "delay": (0, 1),
}


def random_variations(
    scenario: Scenario, count: int, rng: int = 0, **ranges: tuple[float, float]
) -> Family:
    """Give a family: a scenario as it is, and `count` times with all its plant drawn at random.

    Parameters
    ----------
    scenario
        Named "nominal" in the family; see variations().
    count
        Of scenarios besides, [1, 10000]; named "random 1", "random 2", ...
    rng
        A seed: the same seed gives the same family.
    **ranges
        Low and high for names of variations(), in the place of the default ones, which are those
        of the standard variations. Factors, shares and deviations are drawn uniformly, delay and
        substeps as whole numbers.

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed.
    """
    whole_number("count", count, 1, 10_000)
    whole_number("rng", rng, 0, 2**53)
    between = {**RANDOM, **{name: _range(name, pair) for name, pair in ranges.items()}}
    draw = np.random.default_rng(rng)
    members = [("nominal", scenario, "")]
    for place in range(count):
        combination = {}
        for name, (low, high) in between.items():
            quantity = QUANTITIES[name]
            value = (
                float(draw.integers(int(low), int(high) + 1))
                if quantity.whole
                else float(draw.uniform(low, high))
            )
            if value != quantity.neutral:
                combination[name] = value
        _, drawn, words = _member(scenario, combination)
        members.append((f"random {place + 1}", drawn, words))
    return Family.of(members)


def _range(name: str, pair: Any) -> tuple[float, float]:
    if name not in QUANTITIES:
        raise ValueError(f"variations: {name!r} is unknown; known: {', '.join(QUANTITIES)}")
    quantity = QUANTITIES[name]
    least = min(quantity.low, quantity.neutral)
    try:
        low, high = pair
        if not (is_number(low) and is_number(high) and least <= low <= high <= quantity.high):
            raise TypeError
    except (TypeError, ValueError):
        raise ValueError(
            f"variations: {name} is {shown(pair)}; must be (low, high) in "
            f"[{least:g}, {quantity.high:g}] ({quantity.rule})"
        ) from None
    return float(low), float(high)
