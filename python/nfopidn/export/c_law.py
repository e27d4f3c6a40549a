"""The law in C99."""

from __future__ import annotations

import numpy as np

from nfopidn._core import Controller, Scenario, __version__
from nfopidn.export import c_tracking
from nfopidn.export.design import (
    DECOUPLED,
    PAPER,
    Design,
    fragment,
    literal,
    origin_of,
    table,
    template,
)
from nfopidn.export.self_test import self_test_text
from nfopidn.robustness.verdict import Verdict


def _lateral(controller: Controller, design: Design) -> str:
    if controller.lateral == "scheduled":
        return c_tracking.lateral_schedule(design)
    if controller.lateral == "speed":
        inverse = literal(np.float32(1.0) / design.speed_scale)
        return f"  lateral = error_y * (reference->v * {inverse});"
    if controller.lateral == "direction":
        return "  lateral = reference->reverse ? -error_y : error_y;"
    return "  lateral = error_y;"


def _errors(controller: Controller) -> str:
    lines = []
    if controller.frame == "robot":
        lines += ["  float error_x, error_y, lateral;"]
        lines += [
            "  rotate_into_robot(measured->theta, world_x, world_y, &error_x, &error_y);",
        ]
    else:
        lines += ["  const float error_x = world_x;", "  const float error_y = world_y;"]
        lines += ["  float lateral;"]
    return "\n".join(lines)


def _allocation(matrix: list[list[float]]) -> tuple[str, str]:
    if matrix == PAPER:
        return "y + theta", "x + y"
    if matrix == DECOUPLED:
        return "x + (y + theta)", "x - (y + theta)"
    rows = [[literal(share) for share in row] for row in matrix]
    left, right = (f"x * {a} + (y * {b} + theta * {c})" for a, b, c in rows)
    return left, right


def _form(controller: Controller) -> str:
    lines = []
    for side in ("left", "right"):
        value = f"torques.{side}"
        if controller.form == "incremental":
            value = f"next_feedback(state->feedback.{side}, {value}, reference->tau_{side})"
        lines.append(f"  state->feedback.{side} = {value};")
    return "\n".join(lines)


def _reads_speed(controller: Controller) -> bool:
    return controller.lateral in {"speed", "scheduled"} or c_tracking.has_speed_errors(controller)


def _functions(controller: Controller) -> str:
    """Texts of the functions that the law calls."""
    robot, sigmoid = controller.frame == "robot", controller.activation == "sigmoid"
    parts = ["angle"]
    if robot or sigmoid:
        parts.append("bits")
    if robot:
        parts.append("heading")
        if not c_tracking.has_speed_errors(controller):
            parts.append("rotate")
    if sigmoid:
        parts.append("sigmoid")
    parts += c_tracking.functions(controller)
    if controller.form == "incremental":
        parts.append(f"feedback_{controller.anti_windup}")
    return "\n" + "\n".join(fragment(f"{part}.c") for part in parts)


def law_texts(
    controller: Controller,
    scenario: Scenario | None,
    design: Design,
    name: str,
    *,
    verdict: Verdict | None,
    repeats: bool,
) -> dict[str, str]:
    """Header and source by file; `repeats` adds the function that hardware needs."""
    left, right = _allocation(design.allocation)
    robot, sigmoid = controller.frame == "robot", controller.activation == "sigmoid"
    words = {
        "name": name,
        "name_init": f"{name}_init",
        "name_step": f"{name}_step",
        "guard": name.upper(),
        "version": __version__,
        "origin": origin_of(controller, scenario, verdict, " * "),
        "count": str(design.taps.shape[1]),
        "limit": literal(design.limit),
        "speed_note": "" if _reads_speed(controller) else "; not read",
        "reverse_note": "" if controller.lateral == "direction" else "; not read",
        "stdint": "\n#include <stdint.h>\n" if robot or sigmoid else "",
        "taps": table(design.taps).removesuffix(","),
        "compiler": template("compiler.c").substitute(name=name),
        "functions": _functions(controller),
        "lateral": _lateral(controller, design),
        "neuron": "neuron" if sigmoid else "",
        "allocation": f"  torques.left = {left};\n  torques.right = {right};",
        "form": _form(controller),
    }
    words |= c_tracking.law_words(controller, name)
    tracks = controller.uses_tracking_law
    words["body"] = (
        c_tracking.step_text(controller, design, words)
        if tracks
        else template("step.c").substitute(
            words, errors=f"{_errors(controller)}\n{words['lateral']}"
        )
    )
    words["self_test"] = self_test_text(
        words,
        function=f"{name}_self_test",
        before=f"{name.upper()}_SELF_TEST_OK",
        heading=robot,
        neuron=sigmoid,
        guard=False,
        schedule=controller.lateral == "scheduled",
    )
    texts = {}
    for kind in ("h", "c"):
        repeat = template(f"repeat.{kind}").substitute(words) if repeats else ""
        if repeats and tracks and kind == "c":
            repeat = c_tracking.repeat_text(controller, name)
        in_motion = c_tracking.in_motion_text(controller, kind, name)
        text = template(f"law.{kind}").substitute(words, repeat=repeat, in_motion=in_motion)
        texts[f"{name}.{kind}"] = text
    return texts
