"""How a verdict is come to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nfopidn._core import Controller, Rival, Scenario
from nfopidn.arguments import check_sample_time, whole_number
from nfopidn.families.family import Family
from nfopidn.families.runs import FamilyRuns, simulate_many
from nfopidn.robustness.limits import Limits, LoopMargin, find_limits, find_margin
from nfopidn.robustness.long_runs import AnyController, OnPath, long_run
from nfopidn.robustness.reference_limits import beyond_the_robot, check_moves
from nfopidn.robustness.verdict import Colour, Verdict, digest
from nfopidn.stability.closed_loop import loop

#: A gain margin under this is amber [dB].
LEAST_GAIN_MARGIN = 6.0
_MOST_LISTED = 3


def _stability(controller: AnyController, scenario: Scenario) -> tuple[bool, str, float]:
    """Give whether the loop is stable on its path, how that is known, and its radius a sample."""
    if isinstance(controller, Controller):
        try:
            found = loop(scenario, controller)
        except ValueError:
            found = None  # the path is open, or the loop too large: a long run tells
        if found is not None and found.verdict != "no_orbit":
            radius = found.spectral_radius_per_sample
            text = f"{found.verdict} on its orbit, spectral radius {radius:.6g} a sample"
            return found.verdict == "stable", text, radius
    run = long_run(scenario, controller)
    return run.stable, run.text, float("nan")


def _red(
    on_path: OnPath, runs: FamilyRuns, stable: bool, how: str, limits: Limits | None
) -> list[str]:
    reasons = []
    if not stable:
        reasons.append(f"not stable: {how}")
    if not on_path.stays_nominal:
        away = on_path.nominal
        where = f"{away:.3g} m away, in the root mean square" if np.isfinite(away) else "diverges"
        reasons.append(f"does not stay on its path from its own start: {where}")
    lost = [name for name, gone in zip(runs.names, runs.diverged, strict=True) if gone]
    if lost:
        more = len(lost) - _MOST_LISTED
        names = ", ".join(map(repr, lost[:_MOST_LISTED]))
        names += f" and {more} more" if more > 0 else ""
        reasons.append(f"{len(lost)} of {len(runs)} variations diverge: {names}")
    if limits is not None and limits.extra_delay < 1:
        reasons.append("less than one sample of delay is borne")
    return reasons


def _amber(margin: LoopMargin | None, at_bound: Sequence[str], beyond: Sequence[str]) -> list[str]:
    reasons = [f"the search ended on a bound: {', '.join(at_bound)}"] if at_bound else []
    reasons += beyond
    if margin is not None and margin.decibels < LEAST_GAIN_MARGIN:
        reasons.append(
            f"the gain margin is {margin.decibels:.3g} dB; must be at least "
            f"{LEAST_GAIN_MARGIN:g} dB"
        )
    return reasons


def verdict(
    controller: Controller | Rival,
    scenario: Scenario,
    *,
    family: Family | None = None,
    at_bound: Sequence[str] = (),
    workers: int = 1,
) -> Verdict:
    """Judge a controller on a scenario: whether it may be trusted with the robot.

    It runs on the scenario's variations, the loop's stability and margins are found, and how much
    delay, mass error, friction and distance at the start it bears before it leaves its path.

    Parameters
    ----------
    controller
        A Controller or a Rival.
    scenario
        Its path closes, or is judged as far as it goes.
    family
        The variations; None: scenario.variations("standard").
    at_bound
        Parameters that a search left on a bound, in words; TuneResult.verdict gives them.
    workers
        Runs at a time. The verdict does not depend on it.

    Returns
    -------
    Verdict
        Its colour, reasons and what is behind them.

    Raises
    ------
    ValueError
        A reference that never moves, a controller that is none or is made for another sample time.

    Examples
    --------
    >>> import nfopidn
    >>> found = nfopidn.verdict(nfopidn.Controller.published(), nfopidn.Scenario.published(rng=0))
    >>> found.colour
    'red'
    """
    if not isinstance(controller, Controller | Rival):
        raise ValueError(f"controller is {controller!r}; must be a Controller or a Rival")
    if not isinstance(scenario, Scenario):
        raise ValueError(f"scenario is {scenario!r}; must be a Scenario")
    whole_number("workers", workers, 1)
    check_sample_time(controller, scenario)
    check_moves(scenario)
    runs = simulate_many(family or scenario.variations("standard"), controller, workers=workers)
    stable, how, radius = _stability(controller, scenario)
    # The limits run it on robots that it is not made for, which are not to be warned about.
    anyones = controller.replace(robot=None) if isinstance(controller, Controller) else controller
    on_path = OnPath(scenario, anyones)
    limits: Limits | None = None
    margin: LoopMargin | None = None
    if on_path.stays_nominal:
        limits = find_limits(on_path)
        if stable:
            margin = find_margin(on_path, scenario, limits.extra_delay)
    beyond = beyond_the_robot(scenario)
    reasons = _red(on_path, runs, stable, how, limits)
    colour: Colour = "red" if reasons else "green"
    lesser = _amber(margin, at_bound, beyond)
    if lesser and not reasons:
        colour = "amber"
    return Verdict(
        colour,
        (*reasons, *lesser),
        runs,
        stable,
        how,
        radius,
        margin,
        limits,
        tuple(at_bound),
        beyond,
        digest(controller),
        digest(scenario),
        scenario.trajectory.dt,
    )
