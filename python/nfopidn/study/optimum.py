"""The smallest cost that any controller could reach: eq. 41 over all torques."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from threading import Event

import numpy as np

from nfopidn._core import Controller, Scenario, SimulationResult
from nfopidn.arguments import check_sample_time, whole_number
from nfopidn.console import Report
from nfopidn.console import progress as progress_bar
from nfopidn.search.interrupts import wish_to_stop
from nfopidn.study.guesses import Guess, guesses, other_turns
from nfopidn.study.motion import Array
from nfopidn.study.transcription import Motion, Programme, Solution

#: An improvement smaller than this share of the cost is rounding.
_GAIN = 1e-9


@dataclass(frozen=True)
class GuessResult:
    """What became of one first guess.

    Attributes
    ----------
    name
        of the guess
    cost
        that the solver ended at; None unless it converged
    status
        the solver's word
    """

    name: str
    cost: float | None
    status: str


@dataclass(frozen=True)
class OpenLoopOptimum:
    """The best torques found, and their run.

    Attributes
    ----------
    scenario
        the one asked for
    success
        whether a guess converged, and nothing interrupted the search
    interrupted
        whether Ctrl-C ended the search
    message
        the same in words
    run
        the simulation of the best torques; None without a cost. Its tau_fb is the deviation from
        the reference torques.
    guesses
        every guess tried, in order
    """

    scenario: Scenario
    success: bool
    interrupted: bool
    message: str
    run: SimulationResult | None = field(repr=False)
    guesses: tuple[GuessResult, ...] = field(repr=False)

    @property
    def cost(self) -> float | None:
        """Eq. 41 of the run; None if no guess converged."""
        return None if self.run is None else self.run.cost

    @property
    def torque(self) -> Array:
        """(N, 2) [N m], left and right; (0, 2) without a run."""
        return np.empty((0, 2)) if self.run is None else self.run.torque

    @property
    def pose(self) -> Array:
        """(N, 3): x, y [m], theta [rad]; (0, 3) without a run."""
        return np.empty((0, 3)) if self.run is None else self.run.pose


def open_loop_optimum(
    scenario: Scenario | None = None,
    *,
    controllers: Sequence[Controller] = (),
    maxfev: int = 2000,
    max_iter: int = 500,
    rng: int = 1,
    progress: bool = False,
) -> OpenLoopOptimum:
    """Find the smallest cost (eq. 41) over all torque sequences within the limit.

    The problem is the simulation's own, sample by sample, with the torques free. No controller
    can do better than its global minimum. IPOPT is a local solver: what is returned is the best of
    several guesses, and not proven to be that minimum. Coulomb friction is smoothed, ever less
    until that changes the cost by less than 1e-4 of it; the cost is that of the simulation, in
    which the friction is as it is. The result is no lower bound.

    Parameters
    ----------
    scenario
        None: the published one. Its noise has no meaning here and is ignored.
    controllers
        further controllers whose runs are first guesses, beside the published gains,
        `Controller.tuned_nominal()` and those tuned here
    maxfev
        evaluations for tuning each of "decoupled", "extended" and "incremental" on this
        scenario; 0: none is tuned
    max_iter
        iterations of IPOPT for each guess
    rng
        seed of the tuning
    progress
        show a bar

    Returns
    -------
    OpenLoopOptimum
        Ctrl-C ends the search and returns the best so far.

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed; or what of the scenario has no smooth
        form: the integrator "exact", a motor, or Coulomb scrub.
    ImportError
        If CasADi is not installed.
    """
    scenario = Scenario.published(rng=0) if scenario is None else scenario
    _check(scenario, controllers, maxfev, max_iter, rng)
    with progress_bar("optimum", None, progress) as report, wish_to_stop() as stop:
        search = _Search(Programme(scenario, max_iter, stop), stop, report)
        search.descend(guesses(scenario, controllers, maxfev, rng, stop))
        search.turn_otherwise()
        search.refine()
        return search.result()


def _check(
    scenario: Scenario, controllers: Sequence[Controller], maxfev: int, max_iter: int, rng: int
) -> None:
    if not isinstance(scenario, Scenario):
        raise ValueError(f"scenario is a {type(scenario).__name__}; must be a Scenario")
    if not isinstance(controllers, Sequence):
        raise ValueError(f"controllers is a {type(controllers).__name__}; must be a list")
    for k, controller in enumerate(controllers):
        if not isinstance(controller, Controller):
            raise ValueError(
                f"controllers[{k}] is a {type(controller).__name__}; must be a Controller"
            )
        try:
            check_sample_time(controller, scenario)
        except ValueError as error:
            raise ValueError(f"controllers[{k}]: {error}") from None
    whole_number("maxfev", maxfev, 0)
    whole_number("max_iter", max_iter, 1)
    whole_number("rng", rng, 0)
    if scenario.integrator != "semi-implicit-euler":
        raise ValueError(
            f"scenario has integrator {scenario.integrator!r}; must be 'semi-implicit-euler'"
        )
    if scenario.motor is not None:
        raise ValueError(
            "scenario has a motor, whose supply is no part of this problem; must be None"
        )
    if scenario.coulomb_scrub:
        raise ValueError(
            f"scenario has coulomb_scrub {scenario.coulomb_scrub:g} N m, which is no part of this "
            "problem; must be 0"
        )


def _given(motion: Motion) -> Motion:
    return motion


class _Search:
    """Solves from one guess after another and keeps the best."""

    def __init__(self, programme: Programme, stop: Event, report: Report) -> None:
        self.programme = programme
        self.stop = stop
        self.report = report
        self.rows: list[GuessResult] = []
        self.best: Solution | None = None

    def descend(self, first: Sequence[Guess]) -> None:
        """Solve from each first guess."""
        for name, make in first:
            self._solve(name, make)

    def turn_otherwise(self) -> None:
        """Solve from the best with other turns, as long as one of them is better."""
        seen: Solution | None = None
        while self.best is not None and self.best is not seen:
            seen = self.best
            assert seen.motion is not None
            for name, motion in other_turns(self.programme.scenario, seen.motion):
                self._solve(name, partial(_given, motion))

    def refine(self) -> None:
        """Solve the best one's problem as closely as it can be."""
        if self.best is not None:
            self.report(len(self.rows), f"refining, cost {self.best.cost:.6g}")
            self.best = self.programme.refine(self.best)

    def _solve(self, name: str, make: Callable[[], Motion | None]) -> None:
        if self.stop.is_set():
            return
        best = None if self.best is None else self.best.cost
        self.report(len(self.rows), name if best is None else f"{name}, cost {best:.6g}")
        guess = make()
        if self.stop.is_set():
            return
        if guess is None:
            self.rows.append(GuessResult(name, None, "its run diverges"))
            return
        found = self.programme.solve(guess)
        self.rows.append(GuessResult(name, found.cost, found.status))
        if found.cost is not None and (best is None or found.cost < best * (1 - _GAIN)):
            self.best = found

    def result(self) -> OpenLoopOptimum:
        """Return the best, or that there is none."""
        best = self.best
        message = "The best of the guesses that converged."
        if best is None:
            message = "No guess converged."
        elif best.run is None:
            message = "The torques of the best guess lose the path with the friction as it is."
        elif not best.settled:
            message += " Smoothing its friction less did not settle the cost to 1e-4 of it."
        interrupted = self.stop.is_set()
        if interrupted:
            message = f"The search was interrupted. {message}"
        return OpenLoopOptimum(
            scenario=self.programme.scenario,
            success=best is not None and best.run is not None and best.settled and not interrupted,
            interrupted=interrupted,
            message=message,
            run=None if best is None else best.run,
            guesses=tuple(self.rows),
        )
