"""A compiled model at work: moved by torques in the paper's sign, read without delay."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nfopidn import _core
from nfopidn._core import Scenario
from nfopidn.mujoco.engine import load
from nfopidn.mujoco.model import Model

SETTLE = 1.0  # [s]
#: Those of MuJoCo under which wheels roll as they should.
INTEGRATORS = {"Euler": "mjINT_EULER", "discrete": "mjINT_DISCRETE"}
#: Warnings of MuJoCo after which its state is no longer a robot's, with what they mean.
_FATAL = {
    "mjWARN_BADQPOS": "a position is not finite or huge",
    "mjWARN_BADQVEL": "a speed is not finite or huge",
    "mjWARN_BADQACC": "an acceleration is not finite or huge",
    "mjWARN_BADCTRL": "a torque is not finite",
    "mjWARN_INERTIA": "the inertia matrix is close to singular",
}


class Machine:
    """A robot in MuJoCo, settled on the floor and set to a scenario's start."""

    def __init__(self, model: Model, step: float, integrator: str, scenario: Scenario) -> None:
        self.mujoco: Any = load()
        spec = model.spec.copy()
        spec.option.timestep = step
        spec.option.integrator = getattr(self.mujoco.mjtIntegrator, INTEGRATORS[integrator])
        self.dt = step
        self.radius = model.robot.wheel_radius
        self.track = model.robot.track_width
        _add_disturbance(self.mujoco, spec, model.body)
        self.model = spec.compile()
        _check_contacts(self.model, step)
        self.data = self.mujoco.MjData(self.model)
        self.fault = ""
        self._find(model)
        self._settle(scenario)

    def _find(self, model: Model) -> None:
        """Find the addresses of what is moved and read."""
        compiled = self.model
        wheels = (model.left, model.right)
        self.motors = [compiled.actuator(name).id for name in wheels]
        self.outside = [compiled.actuator(name).id for name in _OUTSIDE]
        self.dofs = [int(compiled.joint(name).dofadr[0]) for name in wheels]
        self.angles = [int(compiled.joint(name).qposadr[0]) for name in wheels]
        body = compiled.body(model.body)
        joint = compiled.jnt(int(body.jntadr[0]))
        self.place = int(joint.qposadr[0])
        self.speed = int(joint.dofadr[0])

    def _settle(self, scenario: Scenario) -> None:
        """Let the robot come to rest on the floor, then set it to the start."""
        data = self.data
        self.mujoco.mj_step(self.model, data, nstep=max(1, round(SETTLE / self.dt)))
        height, quaternion = data.qpos[self.place + 2], data.qpos[self.place + 3 : self.place + 7]
        first = scenario.reference[0]
        x, y, theta = first[:3] if scenario.initial_pose is None else scenario.initial_pose
        velocity = scenario.initial_velocity
        v, omega = first[3:5] if velocity == "reference" else velocity
        tilt = np.array(quaternion)
        turned = -_yaw(tilt)
        upright, out = np.zeros(4), np.zeros(4)
        self.mujoco.mju_axisAngle2Quat(upright, [0, 0, 1], turned + float(theta))
        self.mujoco.mju_mulQuat(out, upright, tilt)
        data.qpos[self.place : self.place + 7] = [x, y, height, *out]
        data.qvel[:] = 0.0
        data.qacc_warmstart[:] = 0.0
        cosine, sine = math.cos(theta), math.sin(theta)
        data.qvel[self.speed : self.speed + 2] = [v * cosine, v * sine]
        data.qvel[self.speed + 5] = omega
        for dof, sign in zip(self.dofs, (-1.0, 1.0), strict=True):
            data.qvel[dof] = (v + sign * omega * self.track / 2) / self.radius
        self.theta = float(theta)
        data.time = 0.0
        self.mujoco.mj_forward(self.model, data)
        self._look()

    @property
    def state(self) -> tuple[float, float, float, float, float]:
        """x, y [m], theta [rad] not wrapped, v [m/s], omega [rad/s]; of the free joint, not old."""
        x, y = (float(value) for value in self.data.qpos[self.place : self.place + 2])
        quaternion = self.data.qpos[self.place + 3 : self.place + 7]
        # theta is the last sample's turned by less than half a turn.
        turned = math.remainder(_yaw(quaternion) - self.theta, 2 * math.pi)
        self.theta += turned
        speed = self.data.qvel[self.speed : self.speed + 6]
        v = float(speed[0] * math.cos(self.theta) + speed[1] * math.sin(self.theta))
        return x, y, self.theta, v, float(speed[5])

    @property
    def pose(self) -> tuple[float, float, float]:
        """x, y [m], theta [rad]."""
        return self.state[:3]

    @property
    def upright(self) -> float:
        """The cosine of the angle between the robot's axis and the floor's."""
        _, x, y, _ = self.data.qpos[self.place + 3 : self.place + 7]
        return float(1 - 2 * (x * x + y * y))

    @property
    def wheel_angles(self) -> tuple[float, float]:
        """Of the left and the right wheel, REP-103 [rad]."""
        left, right = (float(self.data.qpos[address]) for address in self.angles)
        return left, right

    def move(self, torque: tuple[float, float], outside: Any, steps: int) -> tuple[float, float]:
        """Hold torques [N m] of the paper's sign for some steps; give those that the joints had.

        They are the joints' own (qfrc_actuator): the actuators' force is not yet limited.
        """
        data = self.data
        data.ctrl[self.motors] = _core.to_rep103(torque)
        data.ctrl[self.outside] = outside
        self.mujoco.mj_step(self.model, data, nstep=steps)
        self._look()
        left, right = (float(data.qfrc_actuator[dof]) for dof in self.dofs)
        if self.fault:
            return torque
        return _core.to_rep103((left, right))

    def _look(self) -> None:
        """Read the warnings, which MuJoCo counts in silence."""
        for name, meaning in _FATAL.items():
            warning = self.data.warning[int(getattr(self.mujoco.mjtWarning, name))]
            if warning.number and not self.fault:
                self.fault = f"MuJoCo counts {name}: {meaning}"
        if not np.all(np.isfinite(self.data.qpos)) and not self.fault:
            self.fault = "a position is not finite"


_OUTSIDE = ("nfopidn_force", "nfopidn_moment")


def _check_contacts(compiled: Any, step: float) -> None:
    """Refuse contacts that MuJoCo would make softer without a word.

    Raises
    ------
    ValueError
        A contact's time constant is under two steps.
    """
    shortest = min((float(time) for time in compiled.geom_solref[:, 0] if time > 0), default=1.0)
    if shortest < 2 * step * (1 - 1e-9):
        raise ValueError(
            f"step is {step:g} s and the shortest contact_time {shortest:g} s; it must be at least "
            "two steps"
        )


def _add_disturbance(mujoco: Any, spec: Any, body: str) -> None:
    """Add a force along the robot and a moment about its vertical axis, as two actuators."""
    spec.body(body).add_site(name="nfopidn_disturbance")
    for name, gear in zip(_OUTSIDE, ([1, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 1]), strict=True):
        actuator = spec.add_actuator(
            name=name, trntype=mujoco.mjtTrn.mjTRN_SITE, target="nfopidn_disturbance", gear=gear
        )
        actuator.set_to_motor()


def _yaw(quaternion: Any) -> float:
    """Give the heading of a quaternion w, x, y, z: the direction of the body's x axis."""
    w, x, y, z = (float(value) for value in quaternion)
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
