"""What stands between the law and a real robot, in C99."""

from __future__ import annotations

import numpy as np

from nfopidn._core import Scenario, __version__
from nfopidn._export.design import folded, fragment, literal, template
from nfopidn._export.self_test import self_test_text


def hardware_texts(scenario: Scenario, name: str) -> dict[str, str]:
    """Header and source by file."""
    robot, dt = scenario.robot, np.float32(scenario.trajectory.dt)
    mass, inertia = np.float32(robot.mass), np.float32(robot.inertia)
    track, radius = np.float32(robot.track_width), np.float32(robot.wheel_radius)
    one, two = np.float32(1), np.float32(2)
    words = {
        "name": name,
        "name_reset": f"{name}_reset",
        "guard": name.upper(),
        "version": __version__,
        "origin": folded([f"Robot: {robot!r}"], " * "),
        "sample_time": literal(dt),
        "track_width": literal(track),
        "wheel_radius": literal(radius),
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
