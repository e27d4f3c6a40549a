"""Where the search for the open-loop optimum starts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from threading import Event
from typing import Any

import numpy as np

from nfopidn._core import Controller, Scenario, simulate
from nfopidn.study.motion import TURN, Array
from nfopidn.study.transcription import Motion, motion_of
from nfopidn.tuning.tuner import tune

#: Structures that are tuned for the scenario, each with a small budget.
STRUCTURES = ("decoupled", "extended", "incremental")

#: A cusp: more than a quarter of a turn within so many samples.
_CUSP_SAMPLES = 3
_CUSP_TURN = np.pi / 2
_CUSPS = 8  # of a path, at most, at which the turn is tried the other way

Guess = tuple[str, Callable[[], Motion | None]]


def controller_run(scenario: Scenario, controller: Controller) -> Motion | None:
    """Return a controller's run, None if it diverges."""
    run = simulate(scenario, controller)
    return None if run.diverged_at is not None else motion_of(run)


def reference_motion(scenario: Scenario) -> Motion:
    """Return the reference's own states and torques, whatever the start."""
    return Motion(scenario.reference[:, :5].copy(), scenario.reference[:, 5:7].copy())


def _tuned_run(
    scenario: Scenario, structure: str, maxfev: int, rng: int, stop: Event
) -> Motion | None:
    def end(_: Any) -> None:
        if stop.is_set():
            raise StopIteration

    found = tune(
        scenario, structure=structure, robustness=None, rng=rng, maxfev=maxfev, callback=end
    )
    return controller_run(scenario, found.controller)


def guesses(
    scenario: Scenario, controllers: Sequence[Controller], maxfev: int, rng: int, stop: Event
) -> list[Guess]:
    """Return names of first guesses, and what makes each."""
    known = [("published gains", Controller.published())]
    # At another sample time it is a guess like any other.
    known += [("tuned_nominal", Controller.tuned_nominal().replace(sample_time=None))]
    known += [(f"controllers[{k}]", controller) for k, controller in enumerate(controllers)]
    made: list[Guess] = [("reference", partial(reference_motion, scenario))]
    made += [(name, partial(controller_run, scenario, one)) for name, one in known]
    for name in STRUCTURES if maxfev else ():
        made.append((f"tuned, {name}", partial(_tuned_run, scenario, name, maxfev, rng, stop)))
    return made


def _cusps(theta: Array) -> list[int]:
    """Return samples in the middle of sudden turns of a heading."""
    if len(theta) <= _CUSP_SAMPLES:
        return []
    sudden = np.abs(theta[_CUSP_SAMPLES:] - theta[:-_CUSP_SAMPLES]) > _CUSP_TURN
    edges = np.flatnonzero(np.diff(np.concatenate([[False], sudden, [False]]).astype(int)))
    places = [int(first + last + _CUSP_SAMPLES) // 2 for first, last in edges.reshape(-1, 2)]
    return places[:_CUSPS]


def other_turns(scenario: Scenario, motion: Motion) -> Iterator[tuple[str, Motion]]:
    """Turn the other way round, at the start and at each cusp: names and guesses."""
    for place in (1, *_cusps(scenario.reference[:, 2])):
        for turns in (1, -1):
            states = motion.states.copy()
            states[place:, 2] += turns * TURN
            when = "at the start" if place == 1 else f"at {place * scenario.trajectory.dt:.4g} s"
            yield f"{turns:+d} turn {when}", Motion(states, motion.torque)
