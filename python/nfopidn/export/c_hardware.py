"""What stands between the law and a real robot, in C99."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nfopidn._core import Controller, Scenario, __version__
from nfopidn.arguments import is_number, real_number, shown
from nfopidn.export import c_tracking
from nfopidn.export.design import folded, fragment, literal, template
from nfopidn.export.self_test import self_test_text

_LONGEST_STEP = 1e6  # [m]
_NO_LIMIT = 1e30  # as VelocityLimits of the core has it
_LIMITS = ("v", "omega", "acceleration", "angular_acceleration")
_MARGIN = 10.0  # of the longest step over what a wheel rolls in a sample of the reference


def _longest_step(scenario: Scenario, asked: float | None) -> np.float32:
    """In metres: `asked`, or by the reference's fastest wheel."""
    if asked is not None:
        return np.float32(real_number("longest_step", asked, 1e-6, _LONGEST_STEP, " m"))
    rows = np.asarray(scenario.reference)
    turn = np.abs(rows[:, 4]) * (0.5 * scenario.robot.track_width)
    rolled = float((np.abs(rows[:, 3]) + turn).max()) * scenario.trajectory.dt
    if rolled == 0.0:
        raise ValueError(
            "the reference stands still and does not tell how far a wheel may roll in a sample; "
            "give longest_step"
        )
    return np.float32(min(_MARGIN * rolled, _LONGEST_STEP))


def _velocity_limits(asked: Sequence[float] | None) -> list[np.float32]:
    """Give v [m/s], omega [rad/s] and their rates, each 0 or more; none of them without `asked`."""
    if asked is None:
        return [np.float32(_NO_LIMIT)] * len(_LIMITS)
    if isinstance(asked, str | bytes) or not hasattr(asked, "__len__") or len(asked) != 4:
        raise ValueError(f"velocity_limits is {asked!r}; must be 4 numbers, {', '.join(_LIMITS)}")
    numbers = []
    for limit, value in zip(_LIMITS, asked, strict=True):
        if not is_number(value) or not value >= 0:
            raise ValueError(
                f"velocity_limits has {limit} {shown(value)}; must be a number of 0 (the base does "
                "not move) or more; inf: no limit"
            )
        numbers.append(np.float32(min(value, _NO_LIMIT)))
    return numbers


def _reference_torques(name: str, scenario: Scenario) -> dict[str, str]:
    """Write what gives the torques of a reference made on board, like reference_torques()."""
    robot = scenario.robot if scenario.model is None else scenario.model
    mass, inertia = np.float32(robot.mass), np.float32(robot.inertia)
    track, radius = np.float32(robot.track_width), np.float32(robot.wheel_radius)
    two, half = np.float32(2), np.float32(0.5)
    words = {
        "name": name,
        "linear": literal(mass * radius),
        "angular": literal(two * inertia * radius / track),
        "functions": "",
        "speeds": "",
        "friction_left": "",
        "friction_right": "",
        "unused": "  (void)v;\n  (void)omega;\n",
    }
    friction = [np.float32(number) for number in scenario.friction_feedforward]
    if any(friction):
        speed = literal(np.float32(scenario.friction_feedforward_speed))
        of_wheels = template("friction.c").substitute(
            viscous=literal(friction[0]), coulomb=literal(friction[1]), speed=speed
        )
        words |= {
            "functions": f"{fragment('sigmoid.c')}\n{of_wheels}",
            "speeds": f"  const float turn = omega * {literal(half * track)};\n"
            f"  const float per_radius = {literal(np.float32(1) / radius)};\n",
            "friction_left": " + friction_of((v + turn) * per_radius)",
            "friction_right": " + friction_of((v - turn) * per_radius)",
            "unused": "",
        }
    return {
        "reference_torques": template("reference_torques.c").substitute(words),
        "friction_words": " and the\n   friction of its wheels" if any(friction) else "",
    }


def hardware_texts(
    controller: Controller,
    scenario: Scenario,
    name: str,
    longest_step: float | None = None,
    velocity_limits: Sequence[float] | None = None,
) -> dict[str, str]:
    """Header and source by file."""
    robot, dt = scenario.robot, np.float32(scenario.trajectory.dt)
    mass, inertia = np.float32(robot.mass), np.float32(robot.inertia)
    track, radius = np.float32(robot.track_width), np.float32(robot.wheel_radius)
    one, two = np.float32(1), np.float32(2)
    words = {
        **c_tracking.hardware_words(controller),
        **_reference_torques(name, scenario),
        "name": name,
        "name_reset": f"{name}_reset",
        "guard": name.upper(),
        "version": __version__,
        "origin": folded([f"Robot: {robot!r}"], " * "),
        "sample_time": literal(dt),
        "track_width": literal(track),
        "wheel_radius": literal(radius),
        "longest_step": literal(_longest_step(scenario, longest_step)),
        "velocity_limits": ", ".join(map(literal, _velocity_limits(velocity_limits))),
        "compiler": template("compiler.c").substitute(name=name),
        "functions": "\n".join(fragment(f"{part}.c") for part in ("angle", "bits", "heading")),
        # As Acceleration and VelocityOutput compute them in float.
        "drive": literal(dt * (one / (mass * radius))),
        "steer": literal(dt * (track / (two * inertia * radius))),
    }
    words["self_test"] = self_test_text(
        words,
        function=f"{name}_hardware_self_test",
        before=f"{name}_self_test()",
        heading=True,
        neuron=False,
        guard=True,
    )
    return {
        f"{name}_hardware.{kind}": template(f"hardware.{kind}").substitute(words)
        for kind in ("h", "c")
    }
