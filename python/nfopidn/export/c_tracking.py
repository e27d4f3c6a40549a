"""What the tracking law has in C99 beside its filters and neurons (docs/theory.md)."""

from __future__ import annotations

from nfopidn._core import Controller
from nfopidn.export.design import Design, literal, template
from nfopidn.fractional.tracking import has_drive_and_steering

_ROTATION = """  float cosine, sine;
  cosine_and_sine(measured->theta, &cosine, &sine);
  state->error.x = cosine * world_x + sine * world_y;
  state->error.y = cosine * world_y - sine * world_x;"""

_DRIVE = ("drive", "steering", "drive_integral", "steering_integral")


def has_speed_errors(controller: Controller) -> bool:
    """Whether the law differences poses."""
    return controller.net == "speed-errors"


def functions(controller: Controller) -> list[str]:
    """Fragments besides those of the neuron and of the rotation."""
    return ["schedule"] if controller.lateral == "scheduled" else []


def _numbers(design: Design) -> dict[str, str]:
    return {name: literal(number) for name, number in design.law.items()}


def lateral_schedule(design: Design) -> str:
    """Line that scales the lateral error."""
    numbers = _numbers(design)
    return (
        "  lateral = error_y *\n      lateral_schedule(reference->v, "
        f"{numbers['lateral_speed_square']}, {numbers['minus_half_lateral_power']});"
    )


def _at_rest(controller: Controller, begin: str) -> str:
    if not has_drive_and_steering(controller):
        return ""
    return "".join(f"  {begin}{name} = 0.0F;\n" for name in _DRIVE)


def law_words(controller: Controller, name: str) -> dict[str, str]:
    """Give what the law's texts say of the state; empty words without the tracking law."""
    words = {"turn_rate": "", "memory": "", "forget": "", "past": "errors x, y, theta"}
    if not controller.uses_tracking_law:
        return words
    memory = [f"  {name}_pose error;      /* the last, x and y in the frame of the filters */"]
    forget = [f"  state->error.{name} = 0.0F;" for name in ("x", "y", "theta")]
    if has_drive_and_steering(controller):
        memory += [
            "  float drive;             /* of both wheels, after the pole [N m] */",
            "  float steering;          /* of the wheels' difference [N m] */",
            "  float drive_integral;    /* beside the neurons [N m] */",
            "  float steering_integral; /* [N m] */",
        ]
        forget += _at_rest(controller, "state->").splitlines()
    if has_speed_errors(controller):
        words["turn_rate"] = "  float omega;     /* counter-clockwise [rad/s] */\n"
        words["past"] = "speed error x, error y, speed error theta"
        memory += [
            f"  {name}_pose last;       /* the last measured pose */",
            "  float intervals;         /* samples since then */",
            "  int first;               /* there is none yet */",
            "  int in_motion;           /* the first pose only primes the differences */",
        ]
        forget += [
            *(f"  state->last.{name} = 0.0F;" for name in ("x", "y", "theta")),
            "  state->intervals = 1.0F;",
            "  state->first = 1;",
            "  state->in_motion = 0;",
        ]
    words["memory"] = "\n".join(memory) + "\n"
    words["forget"] = "\n".join(forget) + "\n"
    return words


def step_text(controller: Controller, design: Design, words: dict[str, str]) -> str:
    """Write the functions from the measured pose to the torques."""
    numbers = _numbers(design)
    speeds, name = has_speed_errors(controller), words["name"]
    own = {"speed_errors": "", "proportional_x": "", "proportional_theta": ""}
    if speeds:
        own["speed_errors"] = template("speed_errors.c").substitute(
            name=name, sample_time=literal(design.sample_time)
        )
        for channel in ("x", "theta"):
            gain = numbers[f"proportional_{channel}"]
            own[f"proportional_{channel}"] = f" + {gain} * state->error.{channel}"
        own["errors"] = (
            _ROTATION + f"\n  {name}_pose world;\n  float forward, turning;\n"
            "  world.x = world_x;\n  world.y = world_y;\n  world.theta = error_theta;"
        )
        own["respond"] = (
            "  speed_errors(state, &world, cosine, sine, reference, &forward, &turning);\n"
            "  return respond(state, forward, turning, reference);"
        )
    else:
        own["errors"] = (
            "  rotate_into_robot(measured->theta, world_x, world_y, &state->error.x, "
            "&state->error.y);"
            if controller.frame == "robot"
            else "  state->error.x = world_x;\n  state->error.y = world_y;"
        )
        own["respond"] = "  return respond(state, state->error.x, error_theta, reference);"
    if has_drive_and_steering(controller):
        output = template("drive_and_steering.c").substitute(numbers).rstrip("\n")
    else:
        output = f"{words['allocation']}\n{words['form']}"
    return template("tracking_step.c").substitute(words | numbers | own, output=output)


def repeat_text(controller: Controller, name: str) -> str:
    """Write the function of a sample without a measurement."""
    if has_speed_errors(controller):
        return template("tracking_repeat.c").substitute(
            name=name,
            miss="  state->intervals += 1.0F;\n",
            x="state->past[0][0]",
            theta="state->past[2][0]",
        )
    return template("tracking_repeat.c").substitute(
        name=name, miss="", x="state->error.x", theta="state->error.theta"
    )


def in_motion_text(controller: Controller, kind: str, name: str) -> str:
    """Write the reset for a robot that moves; nothing without speed errors."""
    if not has_speed_errors(controller):
        return ""
    return template(f"in_motion.{kind}").substitute(name=name)


def hardware_words(controller: Controller) -> dict[str, str]:
    """Give what the hardware's texts say of the law."""
    words = {"in_motion": "", "forget": "", "turn_rate": "", "miss_step": "", "miss_repeat": ""}
    if not controller.uses_tracking_law:
        return words
    words["forget"] = _at_rest(controller, "state->")
    if has_speed_errors(controller):
        words["in_motion"] = "_in_motion"
        words["forget"] += "  state->first = 1;\n"
        words["turn_rate"] = " &&\n      within(reference->omega)"
        line = "guarded->law.intervals += 1.0F;"
        words["miss_step"] = f" else {{\n      {line}\n    }}"
        words["miss_repeat"] = f" else {{\n    {line}\n  }}"
    return words


def reference_words(turn_rate: bool) -> dict[str, str]:
    """Give what the table's texts say of the turn rate, which the tracking law alone reads."""
    if not turn_rate:
        return {"turn_rate": "", "no_turn_rate": ""}
    return {"turn_rate": "omega, ", "no_turn_rate": "    sample.omega = 0.0F;\n"}
