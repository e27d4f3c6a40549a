"""`nfopidn physics`."""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from typing import Any

import nfopidn
from nfopidn.files import check_outputs, load_controller
from nfopidn.mujoco import run
from nfopidn.mujoco.parts import WHEEL_KINDS
from nfopidn.mujoco.run import STEP

EXIT_DIVERGED = 3


def _physics(arguments: argparse.Namespace) -> int:
    """Run, tell and write; a run that diverges is told with time and reason."""
    controller = load_controller(arguments.controller)
    scenario = nfopidn.Scenario.load(arguments.scenario) if arguments.scenario else None
    outputs = {"--csv": arguments.csv, "--render": arguments.render}
    inputs = [arguments.controller, *([arguments.scenario] if arguments.scenario else [])]
    check_outputs(outputs, inputs=inputs)
    if arguments.counts is not None and not arguments.odometry:
        raise ValueError("--counts are the encoders'; give --odometry too")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", UserWarning)
        try:
            result = run(
                scenario,
                controller,
                arguments.wheels,
                arguments.joint_friction,
                step=arguments.step,
                odometry=arguments.odometry,
                counts=arguments.counts,
                slope=arguments.slope,
                floor=arguments.floor,
            )
        except ImportError as error:
            raise ValueError(str(error)) from None
    for warning in told:
        print(f"nfopidn: {warning.message}", file=sys.stderr)
    if arguments.csv:
        result.to_csv(arguments.csv)
    if arguments.render:
        _render(result, arguments.render, arguments.speed)
    simulated = nfopidn.simulate(scenario, _quiet(controller))
    _tell(result, simulated, arguments.json)
    return EXIT_DIVERGED if result.diverged_at is not None else 0


def _quiet(controller: Any) -> Any:
    """Give the controller without its robot, of which a warning has been printed already."""
    if isinstance(controller, nfopidn.Controller):
        return controller.replace(robot=None)
    return controller


def _render(result: Any, path: str, speed: float) -> None:
    """Write the animation.

    Raises
    ------
    ValueError
        Nothing renders here.
    """
    from nfopidn.mujoco import NoRendererError, render

    try:
        render(result, path, speed=speed)
    except NoRendererError as error:
        raise ValueError(f"--render {path}: {error}") from None


def _tell(result: Any, simulated: Any, as_json: bool) -> None:
    """Print the metrics, in the engine and as simulated."""
    if as_json:
        shown = {"mujoco": result.metrics, "simulated": simulated.metrics}
        print(json.dumps(shown | {"diverged_at": result.diverged_at}, allow_nan=False))
        return
    units = nfopidn._core.metric_fields()
    print(f"{'':20} {'MuJoCo':>12} {'simulated':>12}")
    for name, value in result.metrics.items():
        unit = units[name][0]
        print(f"{name:20} {value:12.6g} {simulated.metrics[name]:12.6g} {unit}".rstrip())


def add_physics(commands: Any) -> None:
    """Add the command to the others."""
    parser = commands.add_parser(
        "physics",
        help="run a controller in a physics engine, MuJoCo",
        description="Runs a scenario under a controller in MuJoCo and prints the metrics of eq. 41 "
        "beside those of the simulation. Needs the extra physics: pip install "
        '"nfopidn[physics]". Exit code: 0 done, 2 bad usage or bad file, 3 the run in the engine '
        "diverges.",
    )
    add = parser.add_argument
    add("controller", metavar="CONTROLLER", help="controller file or rival file")
    add("--scenario", metavar="FILE", help="scenario file; default: the published scenario")
    add("--wheels", default="ellipsoid", help=", ".join(WHEEL_KINDS) + " (%(default)s)")
    add(
        "--joint-friction",
        type=float,
        default=0.0,
        metavar="TORQUE",
        help="Coulomb friction of each wheel's joint [N m], besides the scenario's (%(default)s)",
    )
    add("--step", type=float, default=STEP, help="of the engine [s] (%(default)s)")
    add("--odometry", action="store_true", help="show the controller the encoders' pose")
    add("--counts", type=int, help="of an encoder in a revolution of the wheel; default: exact")
    add("--floor", type=float, default=1.0, help="coefficient of sliding friction (%(default)s)")
    add("--slope", type=float, default=0.0, help="of the floor along x [rad] (%(default)s)")
    add("--csv", metavar="FILE", help="write the run table")
    add("--render", metavar="FILE", help="write an animation: .gif, or .mp4 by ffmpeg")
    add("--speed", type=float, default=5.0, help="of the animation, times the run's (%(default)s)")
    add("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_physics)
