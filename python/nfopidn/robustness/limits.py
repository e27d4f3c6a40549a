"""How much a loop bears before it leaves its path, found by bisection in simulation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nfopidn._core import Controller, Scenario
from nfopidn.robustness.long_runs import OnPath, largest
from nfopidn.stability.loop_margins import margins

#: [samples]
MOST_DELAY = 64
_MASS = 10.0
_GAIN = 16.0
_FRICTION = 0.5


@dataclass(frozen=True)
class Limits:
    """Up to what the loop stays on its path, each alone; 0 and 1 where nothing more is borne.

    Attributes
    ----------
    extra_delay
        [samples], at most 64 altogether
    mass
        factors (lower, upper) of the robot's mass, in [0.1, 10]; inertia goes along, the model not
    friction
        extra Coulomb friction, a share of the torque limit a wheel, at most 0.5
    start
        distance beside the path [m] at which a run may start, on either side
    """

    extra_delay: int
    mass: tuple[float, float]
    friction: float
    start: float


@dataclass(frozen=True)
class LoopMargin:
    """Margins of the loop.

    Attributes
    ----------
    gain
        factors (lower, upper) of the loop's gain
    phase
        [rad]; nan where it is not known
    delay
        [samples]; nan where it is not known
    source
        "linearised" on a straight line at the path's peak speed, or "simulated" on its path
    """

    gain: tuple[float, float]
    phase: float
    delay: float
    source: str

    @property
    def decibels(self) -> float:
        """The smaller of both gain margins [dB]."""
        low, high = self.gain
        ups = [20 * np.log10(high)] if np.isfinite(high) else []
        downs = [-20 * np.log10(low)] if low > 0 else []
        return float(min([*ups, *downs], default=np.inf))


def _scaled(scenario: Scenario, factor: float) -> Scenario:
    """Give the scenario with a robot of other mass and inertia, and the model as it was."""
    own = scenario.robot
    return scenario.replace(
        robot=own.replace(mass=own.mass * factor, inertia=own.inertia * factor),
        model=scenario.model or own,
    )


def bearable_delay(on_path: OnPath) -> int:
    """Give how many samples of delay a loop bears that stays on its path as it is."""
    base = on_path.scenario
    delay = 0
    while base.delay + delay < MOST_DELAY and on_path.stays(
        base.replace(delay=base.delay + delay + 1)
    ):
        delay += 1
    return delay


def find_limits(on_path: OnPath) -> Limits:
    """Find the limits of a loop that stays on its path as it is."""
    base = on_path.scenario
    delay = bearable_delay(on_path)

    def bears_mass(logarithm: float) -> bool:
        return on_path.stays(_scaled(base, float(np.exp(logarithm))))

    def bears_friction(share: float) -> bool:
        friction = base.coulomb_friction + share * base.torque_limit
        return on_path.stays(base.replace(coulomb_friction=friction))

    path = base.trajectory
    x, y, theta = base.initial_pose or (path.x[0], path.y[0], path.theta[0])
    free = base.divergence_distance - float(np.hypot(x - path.x[0], y - path.y[0]))

    def bears_start(distance: float) -> bool:
        return all(
            on_path.stays(
                base.replace(
                    initial_pose=(
                        float(x - side * distance * np.sin(path.theta[0])),
                        float(y + side * distance * np.cos(path.theta[0])),
                        float(theta),
                    )
                )
            )
            for side in (1, -1)
        )

    return Limits(
        delay,
        (
            float(np.exp(largest(bears_mass, 0.0, -np.log(_MASS)))),
            float(np.exp(largest(bears_mass, 0.0, np.log(_MASS)))),
        ),
        largest(bears_friction, 0.0, _FRICTION),
        largest(bears_start, 0.0, 0.99 * max(free, 0.0)),
    )


def find_margin(on_path: OnPath, scenario: Scenario, extra_delay: int) -> LoopMargin:
    """Find the margins: of the linearised loop where it is known, else by simulation.

    The former is linearised with the accurate integrator, whatever the scenario's is: one Euler
    step a sample is another plant. In simulation a loop's gain is that of its robot: a lighter one,
    which its model knows, has a higher one.
    """
    controller = on_path.controller
    dt = scenario.trajectory.dt
    if isinstance(controller, Controller):
        try:
            found = margins(controller, scenario.replace(integrator="exact", substeps=1))
        except ValueError:
            found = None  # a law, a speed or a memory of which the linear analysis knows nothing
        if found is not None and found.stable:
            loops = (found.drive, found.steering)
            return LoopMargin(
                (max(loop.gain[0] for loop in loops), min(loop.gain[1] for loop in loops)),
                min(loop.phase for loop in loops),
                min(loop.delay for loop in loops) / dt,
                "linearised",
            )
    base = on_path.scenario

    def bears_gain(logarithm: float) -> bool:
        lighter = _scaled(base, float(np.exp(-logarithm)))
        return on_path.stays(lighter.replace(model=lighter.robot))

    low, high = (
        float(np.exp(largest(bears_gain, 0.0, end))) for end in (-np.log(_GAIN), np.log(_GAIN))
    )
    return LoopMargin(
        (low if low > 1.001 / _GAIN else 0.0, high if high < 0.999 * _GAIN else np.inf),
        float("nan"),
        float(extra_delay),
        "simulated",
    )
