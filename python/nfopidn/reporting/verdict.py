"""The loop's stability and its basin of attraction, in words and numbers."""

from __future__ import annotations

from math import log

import numpy as np

from nfopidn._core import Controller, Scenario
from nfopidn.reporting.numbers import readable, readable_power
from nfopidn.reporting.settings import Row
from nfopidn.stability import Basin, LoopStability, basin

_GRID = 41  # poses each way
_REACH = 3.0  # of the grid, from the path's start [m]
_LAST = 10.0  # end of a run that counts [s]

_VERDICTS = {
    "stable": "Stable. Close to its orbit the loop comes back to it: a small deviation is "
    "multiplied by {radius} in each period.",
    "unstable": "Unstable. Close to its orbit the loop runs away from it: a small deviation is "
    "multiplied by {radius} in each period.",
    "marginal": "Marginal. A small deviation neither shrinks nor grows: the spectral radius of a "
    "period is {radius}, within a millionth of 1.",
    "no_orbit": "No periodic orbit was found, so linear analysis gives no verdict; "
    "the simulation is the evidence.",
}


def verdict_text(found: LoopStability) -> str:
    """Return the verdict as a sentence or two."""
    text = _VERDICTS[found.verdict].format(radius=readable_power(found.log_radius))
    arrived = found.simulated.arrived
    if found.verdict == "stable" and not arrived:
        text += (
            " The simulation from the scenario's own start does otherwise, as a start outside the "
            "basin of attraction does."
        )
    elif found.verdict == "no_orbit" and arrived:
        text += " It settles on a period that repeats."
    elif found.verdict != "stable" and arrived:
        text += " The simulation from the scenario's own start ends on it all the same."
    return text


def _change(found: LoopStability) -> Row:
    """Return how long a deviation takes to halve, or to double."""
    duration = found.period * found.dt
    meaning = "a small deviation, on average"
    if found.log_radius == 0:
        return Row("Halves", "never", meaning)
    time = readable(duration * log(2) / abs(found.log_radius), 3)
    return Row("Halves in" if found.log_radius < 0 else "Doubles in", f"{time} s", meaning)


def stability_rows(found: LoopStability) -> list[Row]:
    """Return the numbers behind a verdict."""
    lap = {0: "every sample alike", 1: "1 lap"}.get(found.laps, f"{found.laps} laps")
    period = f"{found.period} samples, {readable(found.period * found.dt)} s"
    rows = [Row("Period", period, f"{lap}; {found.orbit.shape[1]} states")]
    simulated = Row("Simulation", str(found.simulated), "from the scenario's start, without noise")
    if found.verdict == "no_orbit":
        return [*rows, simulated]
    rows += [
        Row("Spectral radius", readable_power(found.log_radius), "of a period; stable below 1"),
        Row("Per sample", f"{found.spectral_radius_per_sample:.6f}", "the same, spread evenly"),
        _change(found),
    ]
    for label, switch, unit in (
        ("Heading error from π", found.heading_wrap, "rad"),
        ("Left torque from its limit", found.torque_left, "N m"),
        ("Right torque from its limit", found.torque_right, "N m"),
    ):
        if switch is not None:
            least = f"at least {readable(switch.distance)} {unit}"
            rows.append(Row(label, least, f"on the orbit; least at sample {switch.sample}"))
    rows.append(Row("At the torque limit", f"{found.limited_samples} samples", "of the period"))
    return [*rows, simulated]


def basin_of(scenario: Scenario, controller: Controller) -> Basin:
    """Return the basin of attraction on the page's grid."""
    path = scenario.trajectory
    steps = np.linspace(-_REACH, _REACH, _GRID)
    return basin(
        scenario,
        controller,
        x=float(path.x[0]) + steps,
        y=float(path.y[0]) + steps,
        last=min(_LAST, float(path.t[-1])),
    )


def basin_text(found: Basin) -> str:
    """Return what share of the poses converges, in a sentence or two."""
    diverged = float(np.mean(np.isinf(found.position_error)))
    return (
        f"Of {found.converged.size} initial positions, up to {readable(_REACH)} m either side of "
        f"the path's start and with the heading {readable(found.theta)} rad, {found.share:.1%} end "
        f"within {readable(found.tolerance)} m of the path (root mean square of the run's last "
        f"samples) and {diverged:.1%} diverge."
    )
