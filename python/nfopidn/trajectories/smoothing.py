"""From the fastest motion to samples: accelerations made continuous, limits held at each sample.

The fastest motion changes its acceleration at once. Its mean over a window of time changes it
steadily instead, at no more than the step over the window, and the feedforward torques with it,
since the path's curvature has a continuous derivative.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import ceil

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Robot, Trajectory
from nfopidn.trajectories.limits import Limits, Use, uses
from nfopidn.trajectories.timing import Motion, fastest, position, times

_Array = NDArray[np.float64]

#: Rounds in which limits are lowered where samples exceed them, and then the whole is slowed.
_LOCAL_ROUNDS, _SLOWER_ROUNDS = 12, 40
#: A limit counts as held up to rounding.
HELD = 1e-9
_MARGIN = 0.999


@dataclass
class Event:
    """A motion from rest to rest: along a piece of the path, or a turn on the spot."""

    motion: Motion
    #: x, y and heading (K, 3) at places s (K,).
    pose: Callable[[_Array], _Array]
    #: Lowers the limits at the motion's places.
    scale: _Array = field(init=False)
    #: Makes the whole slower.
    slower: float = 1.0

    def __post_init__(self) -> None:
        """Begin with the limits as they are."""
        self.scale = np.ones(len(self.motion.s))

    def plan(self, limits: Limits, robot: Robot | None) -> tuple[_Array, _Array]:
        """Return w and the time at the motion's places."""
        w = fastest(self.motion, limits, robot, self.scale)
        return w, times(self.motion, w)


def _places(event: Event, w: _Array, at: _Array, window: float, dt: float) -> _Array:
    """Return the places at samples dt apart, from the start to the end; both are at rest.

    The motion is slowed until it takes a whole number of samples.
    """
    motion, end = event.motion, float(at[-1])
    length = float(motion.s[-1])
    duration = (end + window) * event.slower
    steps = max(1, ceil(duration / dt - 1e-9))
    t = np.linspace(0.0, end + window, steps + 1)
    s = position(motion, w, at)
    if window > 0:
        whole = s.antiderivative()
        total = float(whole(end))

        def integral(until: _Array) -> _Array:
            inside = np.asarray(whole(np.clip(until, 0.0, end)))
            beyond = total + length * (until - end)
            return np.where(until <= 0.0, 0.0, np.where(until >= end, beyond, inside))

        found = (integral(t) - integral(t - window)) / window
    else:
        found = np.asarray(s(np.clip(t, 0.0, end)))
    found[0], found[-1] = 0.0, length
    return np.clip(found, 0.0, length)


@dataclass(frozen=True)
class Sampled:
    """Events as samples."""

    trajectory: Trajectory
    #: Time of the fastest motion, neither smoothed nor sampled, rests included [s].
    fastest: float
    #: First sample of each event, and its places at its samples.
    first: list[int]
    places: list[_Array]


def _joined(
    items: list[Event | int],
    dt: float,
    window: float,
    plans: list[tuple[_Array, _Array]],
    origin: tuple[float, float],
) -> Sampled:
    """Sample events and the rests between them, given as numbers of samples."""
    poses: list[_Array] = []
    first, places = [], []
    count, duration, number, before = 0, 0.0, 0, 1
    for item in items:
        if isinstance(item, int):
            duration += item * dt
            if not poses:
                before += item
            elif item:
                poses.append(np.repeat(poses[-1][-1:], item, axis=0))
                count += item
            continue
        w, at = plans[number]
        number += 1
        s = _places(item, w, at, window, dt)
        pose = item.pose(s)
        duration += float(at[-1])
        if poses:
            turn = np.round((poses[-1][-1, 2] - pose[0, 2]) / (2 * np.pi)) * 2 * np.pi
            pose = pose + np.array([0.0, 0.0, turn])
            first.append(count - 1)
            pose = pose[1:]
        else:
            # At rest for a sample at least, so that speeds by differences are 0 there.
            pose = np.vstack([np.repeat(pose[:1], before, axis=0), pose])
            first.append(before)
        places.append(s)
        poses.append(pose)
        count += len(pose)
    poses.append(poses[-1][-1:])
    x, y, theta = np.vstack(poses).T
    trajectory = Trajectory.from_samples(
        x, y, dt, theta=theta, standstill_speed=1e-9, origin=origin
    )
    return Sampled(trajectory, duration, first, places)


def _excess(found: list[Use]) -> tuple[_Array, int]:
    """Return the factor that squared speeds or accelerations exceed, a sample; the worst use."""
    ratios = np.stack([use.ratio**use.power for use in found])
    ratios[ratios <= 1.0 + HELD] = 1.0
    return np.minimum(ratios.max(axis=0), 1e6), int(np.argmax(ratios.max(axis=1)))


def _given_speed(sampled: Sampled, events: list[Event]) -> Use:
    """Return the speed that samples use of what points ask for."""
    trajectory = sampled.trajectory
    most = np.full(len(trajectory), np.inf)
    for event, first, s in zip(events, sampled.first, sampled.places, strict=True):
        motion = event.motion
        after = np.searchsorted(motion.s, s).clip(1, len(motion.s) - 1)
        own = np.minimum(motion.speed[after - 1], motion.speed[after])
        here = slice(first, first + len(s))
        most[here] = np.minimum(most[here], own)
    return Use("given speed", np.abs(trajectory.v), most, 2)


def _lower(sampled: Sampled, events: list[Event], excess: _Array, reach: int) -> list[bool]:
    """Lower the limits about the places of samples that exceed them; say of which events."""
    from scipy.ndimage import maximum_filter1d

    lowered = []
    for event, first, s in zip(events, sampled.first, sampled.places, strict=True):
        near = maximum_filter1d(excess[first : first + len(s)], 2 * reach + 1, mode="nearest")
        after = np.searchsorted(s, event.motion.s).clip(1, len(s) - 1)
        worst = np.maximum(near[after - 1], near[after])
        event.scale = np.where(worst > 1.0, event.scale / worst * _MARGIN, event.scale)
        lowered.append(bool((worst > 1.0).any()))
    return lowered


def _slow(sampled: Sampled, events: list[Event], excess: _Array, reach: int) -> None:
    """Slow events as a whole."""
    for event, first, s in zip(events, sampled.first, sampled.places, strict=True):
        own = excess[max(0, first - reach) : first + len(s) + reach].max()
        if own > 1.0:
            event.slower *= float(np.sqrt(own)) * 1.001


def sample_within(
    items: list[Event | int],
    limits: Limits,
    robot: Robot | None,
    dt: float,
    window: float,
    origin: tuple[float, float],
) -> Sampled:
    """Return the samples of events and rests, every limit held at each of them.

    Samples may exceed a limit that the motion itself holds, as the mean over a window of time is
    taken where the path was or will be. There the limits are lowered until none is exceeded.

    Raises
    ------
    ValueError
        Names the limit, its value and the sample that still exceeds it.
    """
    events = [item for item in items if isinstance(item, Event)]
    reach = ceil(window / dt / 2) + 2
    plans = [event.plan(limits, robot) for event in events]
    shortest = None
    for round_number in range(_LOCAL_ROUNDS + _SLOWER_ROUNDS):
        sampled = _joined(items, dt, window, plans, origin)
        if shortest is None:
            shortest = sampled.fastest
        found = uses(sampled.trajectory, limits, robot)
        found.append(_given_speed(sampled, events))
        excess, worst = _excess(found)
        if excess.max() <= 1.0:
            return Sampled(sampled.trajectory, shortest, sampled.first, sampled.places)
        if round_number < _LOCAL_ROUNDS:
            plans = [
                event.plan(limits, robot) if lowered else plan
                for event, plan, lowered in zip(
                    events, plans, _lower(sampled, events, excess, reach), strict=True
                )
            ]
        else:
            _slow(sampled, events, excess, reach)
    k = int(np.argmax(excess))
    use = found[worst]
    raise ValueError(
        f"cannot be driven: {use.name} is {use.value[k]:.4g} at {k * dt:.4g} s, where the limit is "
        f"{use.limit[k]:.4g}; a smaller dt ({dt:g} s) may follow the path"
    )
