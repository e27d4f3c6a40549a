"""The law in C99."""

from __future__ import annotations

import numpy as np

from nfopidn._core import Controller, Scenario, __version__
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


def _errors(controller: Controller, design: Design) -> str:
    lines = []
    if controller.frame == "robot":
        lines += ["  float error_x, error_y, lateral;"]
        lines += [
            "  rotate_into_robot(measured->theta, world_x, world_y, &error_x, &error_y);",
        ]
    else:
        lines += ["  const float error_x = world_x;", "  const float error_y = world_y;"]
        lines += ["  float lateral;"]
    if controller.lateral == "speed":
        inverse = literal(np.float32(1.0) / design.speed_scale)
        lines += [f"  lateral = error_y * (reference->v * {inverse});"]
    elif controller.lateral == "direction":
        lines += ["  lateral = reference->reverse ? -error_y : error_y;"]
    else:
        lines += ["  lateral = error_y;"]
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


def _functions(controller: Controller) -> str:
    """Texts of the functions that the law calls."""
    robot, sigmoid = controller.frame == "robot", controller.activation == "sigmoid"
    parts = ["angle"]
    if robot or sigmoid:
        parts.append("bits")
    if robot:
        parts += ["heading", "rotate"]
    if sigmoid:
        parts.append("sigmoid")
    if controller.form == "incremental":
        parts.append(f"feedback_{controller.anti_windup}")
    return "\n" + "\n".join(fragment(f"{part}.c") for part in parts)


def law_texts(
    controller: Controller, scenario: Scenario | None, design: Design, name: str, *, repeats: bool
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
        "origin": origin_of(controller, scenario, " * "),
        "count": str(design.taps.shape[1]),
        "limit": literal(design.limit),
        "speed_note": "" if controller.lateral == "speed" else "; not read",
        "reverse_note": "" if controller.lateral == "direction" else "; not read",
        "stdint": "\n#include <stdint.h>\n" if robot or sigmoid else "",
        "taps": table(design.taps).removesuffix(","),
        "compiler": template("compiler.c").substitute(name=name),
        "functions": _functions(controller),
        "errors": _errors(controller, design),
        "neuron": "neuron" if sigmoid else "",
        "allocation": f"  torques.left = {left};\n  torques.right = {right};",
        "form": _form(controller),
    }
    words["self_test"] = self_test_text(
        words,
        function=f"{name}_self_test",
        before=f"{name.upper()}_SELF_TEST_OK",
        heading=robot,
        neuron=sigmoid,
        guard=False,
    )
    texts = {}
    for kind in ("h", "c"):
        repeat = template(f"repeat.{kind}").substitute(words) if repeats else ""
        text = template(f"law.{kind}").substitute(words, repeat=repeat)
        texts[f"{name}.{kind}"] = text
    return texts
