"""What the studies share: the published scenario, its two controllers, and their runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Controller, Scenario, SimulationResult, simulate
from nfopidn.search.optimise import MESSAGES
from nfopidn.tuning.result import TuneResult
from nfopidn.tuning.tuner import tune

#: Gains tuned here are those of this seed.
SEED = 1
MEMORIES = range(1, 9)


class InterruptedSearchError(Exception):
    """Ctrl-C during a search, which ends it, and with it the study."""


def tuned(scenario: Scenario, structure: Any, rng: int) -> TuneResult:
    """Tune, and hand an interruption on.

    Raises
    ------
    InterruptedSearchError
        After Ctrl-C.
    """
    found = tune(scenario, structure=structure, robustness=None, rng=rng)
    if found.message == MESSAGES["interrupted"]:
        raise InterruptedSearchError
    return found


@dataclass
class Cases:
    """The published scenario with the published gains and with those tuned here."""

    report: Callable[[str], None]  # called after each step of the work, with a word on it

    @cached_property
    def scenario(self) -> Scenario:
        """The published one."""
        return Scenario.published(rng=0)

    @cached_property
    def controllers(self) -> dict[str, Controller]:
        """By name: `published` and `tuned`."""
        found = tuned(self.scenario, "paper", SEED)
        return {"published": Controller.published(), "tuned": found.controller}

    @cached_property
    def runs(self) -> dict[str, SimulationResult]:
        """By name, on the published scenario."""
        return {name: simulate(self.scenario, one) for name, one in self.controllers.items()}


def distance(run: SimulationResult) -> NDArray[np.float64]:
    """Return the distance from the reference point (N,) [m]."""
    return np.hypot(run.columns["e_x"], run.columns["e_y"])


#: What the figures call the two.
TITLES = {"published": "published gains", "tuned": f"tuned here (seed {SEED})"}

#: Units of the run table's columns.
RUN_UNITS = {
    "t": "s",
    **dict.fromkeys(("x_ref", "y_ref", "x", "y", "e_x", "e_y"), "m"),
    **dict.fromkeys(("theta_ref", "theta", "e_theta"), "rad"),
    "v": "m/s",
    "omega": "rad/s",
    **dict.fromkeys(("tau_ref_left", "tau_ref_right", "tau_fb_left", "tau_fb_right"), "N m"),
    **dict.fromkeys(("tau_left", "tau_right"), "N m"),
}
#: Digits of its numbers in the files.
RUN_DIGITS = 8
