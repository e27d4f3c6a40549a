"""A scenario in MuJoCo under a controller."""

from __future__ import annotations

import math
import warnings
from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import Controller, Rival, Scenario, SimulationResult
from nfopidn.arguments import (
    check_sample_time,
    is_number,
    real_number,
    scenario_or_published,
    shown,
    suggestion,
    whole_number,
)
from nfopidn.mujoco.encoders import Encoders
from nfopidn.mujoco.engine import load, quiet_warnings
from nfopidn.mujoco.machine import INTEGRATORS, Machine
from nfopidn.mujoco.model import Model, build_model

Array = NDArray[np.float64]

STEP = 0.002  # [s]

_REFUSED = {"implicit", "implicitfast"}
_SAME_ROBOT = 0.01
_MOST_TILT = math.cos(math.radians(60))


def run(
    scenario: Scenario | None = None,
    controller: Controller | Rival | None = None,
    wheels: str | None = None,
    joint_friction: float | None = None,
    *,
    step: float = STEP,
    odometry: bool = False,
    counts: int | None = None,
    model: Model | None = None,
    integrator: str = "Euler",
    **settings: Any,
) -> SimulationResult:
    """Run a scenario in MuJoCo, with the controller in the loop.

    The robot settles on the floor for a second, is set to the scenario's start, and is then driven
    sample by sample: pose, torques, so many steps of the engine. The scenario's friction,
    disturbance, noise, delay and torque limit act as in `simulate`; its integrator and substeps do
    not, as the engine has its own.

    Parameters
    ----------
    scenario
        By default the published one.
    controller
        A Controller or a Rival, tuned for the scenario's sample time; by default the published
        Controller.
    wheels
        "ellipsoid" (the default), "cylinder" or "sphere": see `build_model`.
    joint_friction
        Coulomb friction of each wheel's joint [N m], 0 by default, besides the scenario's
        coulomb_friction.
    step
        The engine's [s]; the sample time must be a whole number of them.
    odometry
        Whether the controller is shown the pose that the wheels' encoders give, starting at the
        true one, in place of the true pose.
    counts
        Counts of an encoder in a revolution of the wheel; None: exact angles, or the scenario's
        encoder_counts, if it has some, which ask for odometry. Needs odometry.
    model
        A Model, with what wheels, joint_friction and the settings would say; its own joints have
        the friction then.
    integrator
        "Euler" or "discrete". The implicit ones are refused: under them wheels on servos, which a
        model of one's own may have, skid.
    **settings
        Of `build_model`: casters, floor, slope, bumps, wheel_width, wheel_mass, armature,
        contact_time,
        cone.

    Returns
    -------
    SimulationResult
        As `simulate` returns it: the true pose, the torques as the joints had them, the cost of
        eq. 41 from the same function. A run that diverges, tips over or makes the engine unstable
        keeps its rows so far, says when in diverged_at, and a warning says why.

    Raises
    ------
    ImportError
        MuJoCo is not installed.
    ValueError
        An argument out of its range, a sample time that is no whole number of steps, a controller
        that is made for another sample time, a scenario with motors, with scrub or with errors
        of odometry.
    """
    scenario = scenario_or_published(scenario)
    controller = Controller.published() if controller is None else controller
    if not isinstance(controller, Controller | Rival):
        raise ValueError(f"controller is {controller!r}; must be a Controller or a Rival")
    check_sample_time(controller, scenario)
    steps = steps_a_sample(scenario.trajectory.dt, step)
    odometry, encoder_counts = _encoders_of(scenario, odometry, counts)
    check_integrator(integrator)
    own = _model_of(scenario, model, wheels, joint_friction, settings)
    load()
    with quiet_warnings():
        machine = Machine(own, step, integrator, scenario)
        loop = _Loop(machine, scenario, controller, steps)
        encoders = None
        if odometry:
            encoders = Encoders(
                own.robot, loop.machine.pose, encoder_counts, scenario.trajectory.dt
            )
            encoders.start(*machine.wheel_angles)
        reason = loop.drive(encoders)
    result = loop.result()
    if result.diverged_at is not None:
        warnings.warn(
            f"mujoco.run: the run diverges at {result.diverged_at:g} s: {reason}",
            UserWarning,
            stacklevel=2,
        )
    return result


def steps_a_sample(dt: float, step: float) -> int:
    """Give how many steps of the engine a sample has.

    Raises
    ------
    ValueError
        The step is out of range, or the sample time no whole number of them.
    """
    real_number("step", step, 1e-6, 0.1, " s")
    count = round(dt / step)
    if count < 1 or abs(dt / step - count) > 1e-9 * max(1, count):
        raise ValueError(
            f"step is {step:g} s: the sample time, {dt:g} s, is {dt / step:.6g} of them; must be a "
            f"whole number, as with step={_near(dt, step)}"
        )
    return count


def _near(dt: float, step: float) -> str:
    """Give a step that is no longer than the one asked for and fits, with few digits if any has."""
    first = max(1, math.ceil(dt / step))
    for count in range(first, 2 * first + 1):
        text = f"{dt / count:.4g}"
        if abs(dt / float(text) - count) <= 1e-9 * count:
            return text
    return f"{dt:g}/{first}"


def check_integrator(integrator: Any) -> None:
    """Refuse MuJoCo's integrators under which wheels do not roll as they should.

    Raises
    ------
    ValueError
        Names those that there are.
    """
    if integrator in INTEGRATORS:
        return
    why = ": under it wheels on servos skid" if integrator in _REFUSED else ""
    near = "" if why else suggestion(integrator, INTEGRATORS)
    raise ValueError(
        f"integrator is {shown(integrator)}{why}; must be one of {', '.join(INTEGRATORS)}{near}"
    )


def _encoders_of(scenario: Scenario, odometry: Any, counts: Any) -> tuple[bool, int | None]:
    """Say whether the pose is by odometry, and of how many counts; refuse what is not modelled."""
    if scenario.motor is not None:
        raise ValueError(
            "the scenario has a motor, which the engine's model has not; "
            "Scenario.replace(motor=None) leaves it out"
        )
    for name in ("viscous_scrub", "coulomb_scrub"):
        if value := getattr(scenario, name):
            raise ValueError(
                f"the scenario's {name} is {value:g}; must be 0 here: the engine's wheels scrub by "
                "their own contacts"
            )
    if any(scenario.odometry_errors):
        raise ValueError(
            f"the scenario's odometry_errors are {scenario.odometry_errors}; must be 0 here: "
            "wheels of other radii are another robot's"
        )
    if scenario.encoder_counts and counts is None:
        return True, scenario.encoder_counts
    return bool(odometry), _checked_counts(counts, odometry)


def _checked_counts(counts: Any, odometry: Any) -> int | None:
    if not isinstance(odometry, bool):
        raise ValueError(f"odometry is {odometry!r}; must be True or False")
    if counts is None:
        return None
    if not odometry:
        raise ValueError(f"counts is {counts!r} without odometry; give odometry=True too")
    return whole_number("counts", counts, 1)


def _model_of(
    scenario: Scenario,
    model: Model | None,
    wheels: str | None,
    joint_friction: float | None,
    settings: dict[str, Any],
) -> Model:
    """Give the model that is asked for, the scenario's friction in its joints."""
    if model is not None:
        return _given_model(scenario, model, wheels, joint_friction, settings)
    friction = 0.0 if joint_friction is None else joint_friction
    if not is_number(friction) or not 0 <= friction <= 1e3:
        raise ValueError(f"joint_friction is {shown(friction)}; must be in [0, 1000] N m")
    return build_model(
        scenario.robot,
        "ellipsoid" if wheels is None else wheels,
        joint_friction=friction + scenario.coulomb_friction,
        joint_damping=scenario.viscous_friction,
        **settings,
    )


def _given_model(
    scenario: Scenario, model: Any, wheels: Any, joint_friction: Any, settings: dict[str, Any]
) -> Model:
    """Give a model of the caller's own, unless something else contradicts it."""
    if not isinstance(model, Model):
        raise ValueError(f"model is {model!r}; must be a Model, such as build_model() gives")
    given = {"wheels": wheels, "joint_friction": joint_friction, **settings}
    named = [name for name, value in given.items() if value is not None]
    if named:
        raise ValueError(f"{', '.join(named)} cannot be given with a model, which has its own")
    friction = {
        "coulomb_friction": scenario.coulomb_friction,
        "viscous_friction": scenario.viscous_friction,
    }
    for name, value in friction.items():
        if value:
            raise ValueError(
                f"the scenario's {name} is {value:g}; with a model it must be 0, as "
                "the model's joints have their own"
            )
    _compare_robots(scenario, model)
    return model


def _compare_robots(scenario: Scenario, model: Model) -> None:
    """Say that the reference torques are another robot's."""
    apart = []
    for name in ("mass", "inertia", "track_width", "wheel_radius"):
        own, other = getattr(model.robot, name), getattr(scenario.robot, name)
        if abs(own / other - 1) > _SAME_ROBOT:
            apart.append(f"{name} {own:.4g}, the scenario's {other:.4g}")
    if apart:
        warnings.warn(
            f"mujoco.run: the model is another robot than the scenario's: {'; '.join(apart)}; "
            "Scenario.replace(robot=model.robot) makes them one",
            UserWarning,
            stacklevel=4,
        )


class _Loop:
    """The closed loop: measure, act, record, move."""

    def __init__(
        self, machine: Machine, scenario: Scenario, controller: Controller | Rival, steps: int
    ) -> None:
        self.machine = machine
        self.scenario = scenario
        self.controller = controller
        self.law = controller.replace()  # at rest, and the caller's stays so
        self.law.start(scenario)
        self.steps = steps
        self.shown = np.array(scenario.reference)
        if not scenario.feedforward:
            self.shown[:, 5:7] = 0.0
        self.states: list[tuple[float, ...]] = []
        self.commands: list[tuple[float, float]] = []
        self.feedbacks: list[tuple[float, float]] = []
        self.acted: list[tuple[float, float]] = []

    def drive(self, encoders: Encoders | None) -> str:
        """Run to the end, or to where the run diverges; give the reason for that."""
        scenario = self.scenario
        noise = _core.noise_rows(scenario)
        noisy = bool(np.any(noise))
        disturbance = np.broadcast_to(
            np.asarray(scenario.disturbance, dtype=float), (len(self.shown), 2)
        )
        underway: deque[tuple[float, float]] = deque([(0.0, 0.0)] * scenario.delay)
        limit = scenario.divergence_distance
        for k, row in enumerate(self.shown):
            state = self.machine.state
            fault = self._fault(state, row, limit)
            if fault:
                return fault
            seen = state if encoders is None else encoders.read(*self.machine.wheel_angles)
            if noisy:
                seen = (*(np.array(seen[:3]) + noise[k]), *seen[3:])
            torque = self.law.step(seen, row)
            self.states.append(state)
            self.commands.append(torque)
            self.feedbacks.append(self.law.feedback())
            underway.append(torque)
            self.acted.append(self.machine.move(underway.popleft(), disturbance[k], self.steps))
            if self.machine.fault:
                return self.machine.fault
        return ""

    def _fault(self, state: tuple[float, ...], row: Array, limit: float) -> str:
        """Say what ends the run here, if anything does."""
        distance = math.hypot(row[0] - state[0], row[1] - state[1])
        if not distance <= limit:
            return (
                f"the robot is {distance:.3g} m from its reference, divergence_distance {limit:g}"
            )
        if self.machine.upright < _MOST_TILT:
            return "the robot has tipped over"
        return ""

    def result(self) -> SimulationResult:
        """Score what has been driven. A command counts as the joints had it, where it arrived."""
        torque = list(self.commands)
        for k, pair in enumerate(self.acted[self.scenario.delay :]):
            torque[k] = pair
        return _core.score_rows(
            self.scenario,
            self.controller,
            np.array(self.states).reshape(-1, 5),
            np.array(torque).reshape(-1, 2),
            np.array(self.feedbacks).reshape(-1, 2),
        )
