"""The cost and the metrics of a run that took place elsewhere."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import Controller, Rival, Scenario, SimulationResult
from nfopidn.arguments import real_numbers

Array = NDArray[np.float64]

NEEDED = ("t", "x", "y", "theta", "tau_left", "tau_right")
_LONGEST_GAP = 5.0  # sample times
_ON_GRID = 1e-6  # sample times


def score(
    log: Mapping[str, Any],
    scenario: Scenario,
    *,
    controller: Controller | Rival | None = None,
    rep103: bool = False,
    lost: bool = False,
) -> SimulationResult:
    """Give eq. 41 and all metrics of a run that was recorded elsewhere.

    Rows whose times are not the scenario's samples are resampled, which a warning says: positions
    and headings on straight lines between the rows, torques as held since the last one.

    Parameters
    ----------
    log
        Columns by name, (n,) each, such as a dict or a data frame: t [s] from the scenario's start,
        rising; x, y [m], theta [rad], the true pose; tau_left, tau_right [N m], the total torques
        after the limit. Where v [m/s] and omega [rad/s] are not in it they come from differences of
        the poses, which a warning says; energy and lateral_force_peak rest on them. The columns
        tau_fb_left and tau_fb_right are recorded where they are given; other columns are ignored.
    scenario
        What was driven: its reference, torque limit, robot and weights of the cost.
    controller
        What drove, to stand in the result.
    rep103
        Whether left and right are a real robot's: the paper's are the other way round.
    lost
        Whether the log ends because the robot was lost: its missing samples then cost the
        divergence distance squared each, as those of a run that diverges. Otherwise a log that ends
        before the scenario is refused.

    Returns
    -------
    SimulationResult
        A row a sample.

    Raises
    ------
    ValueError
        A column is missing, of another length, not finite; times do not rise, leave a gap of more
        than five sample times, or do not cover the scenario.
    """
    if not isinstance(scenario, Scenario):
        raise ValueError(f"scenario is {scenario!r}; must be a Scenario")
    if controller is not None and not isinstance(controller, Controller | Rival):
        raise ValueError(f"controller is {controller!r}; must be a Controller, a Rival or None")
    columns = _columns(log)
    if rep103:
        for name in ("tau_{}", "tau_fb_{}"):
            left, right = name.format("left"), name.format("right")
            if left in columns:
                columns[left], columns[right] = columns[right], columns[left]
    columns = _resampled(columns, scenario, lost)
    count = len(columns["t"])
    torque = np.column_stack([columns["tau_left"], columns["tau_right"]])
    if "tau_fb_left" in columns:
        feedback = np.column_stack([columns["tau_fb_left"], columns["tau_fb_right"]])
    else:
        given = scenario.reference[:count, 5:7] if scenario.feedforward else 0.0
        feedback = torque - given
    state = np.column_stack([columns[name] for name in ("x", "y", "theta", "v", "omega")])
    return _core.score_rows(scenario, controller, state, torque, feedback)


def _columns(log: Any) -> dict[str, Array]:
    """Give the columns that are used, checked one by one."""
    if not hasattr(log, "keys") or not hasattr(log, "__getitem__"):
        raise ValueError(f"log is a {type(log).__name__}; must be a mapping of columns by name")
    names = set(log.keys())
    missing = [name for name in NEEDED if name not in names]
    if missing:
        raise ValueError(f"log has no column {', '.join(missing)}; it needs {', '.join(NEEDED)}")
    used = list(NEEDED)
    for pair in (("v", "omega"), ("tau_fb_left", "tau_fb_right")):
        present = [name for name in pair if name in names]
        if len(present) == 1:
            raise ValueError(f"log has {present[0]} and not the other of {' and '.join(pair)}")
        used += present
    columns = {name: real_numbers(f"log[{name!r}]", log[name]) for name in used}
    rows = columns["t"].shape
    for name, column in columns.items():
        if column.ndim != 1 or column.shape != rows:
            raise ValueError(
                f"log[{name!r}] has the shape {column.shape}; must be that of t, {rows}"
            )
        bad = np.flatnonzero(~np.isfinite(column))
        if len(bad):
            raise ValueError(f"log[{name!r}][{bad[0]}] is {column[bad[0]]}; must be finite")
    if len(columns["t"]) < 2:
        raise ValueError(f"log has {len(columns['t'])} rows; needs 2 at least")
    steps = np.diff(columns["t"])
    if not np.all(steps > 0):
        place = int(np.argmin(steps > 0))
        raise ValueError(
            f"log['t'] does not rise: {columns['t'][place]:g} s is followed by "
            f"{columns['t'][place + 1]:g} s in row {place + 1}"
        )
    return columns


def _resampled(columns: dict[str, Array], scenario: Scenario, lost: bool) -> dict[str, Array]:
    """Give the columns at the scenario's samples, with v and omega."""
    grid = scenario.trajectory.t
    dt = scenario.trajectory.dt
    t = columns["t"]
    slack = _ON_GRID * dt
    if t[0] > slack or t[0] < -1e9 * dt:
        raise ValueError(f"log starts at t = {t[0]:g} s; must at 0 s, where the scenario does")
    if t[-1] < grid[-1] - slack:
        if not lost:
            raise ValueError(
                f"log ends at t = {t[-1]:g} s and the scenario at {grid[-1]:g} s; lost=True if the "
                "robot was lost there"
            )
        grid = grid[: int(np.searchsorted(grid, t[-1] + slack, side="right"))]
    _say_speeds(columns)
    if len(t) >= len(grid) and np.all(np.abs(t[: len(grid)] - grid) <= slack):
        return {name: column[: len(grid)] for name, column in columns.items()}
    gaps = np.diff(t)
    longest = int(np.argmax(gaps))
    if gaps[longest] > _LONGEST_GAP * dt:
        raise ValueError(
            f"log has nothing between {t[longest]:g} and {t[longest + 1]:g} s: a gap of "
            f"{gaps[longest] / dt:.3g} sample times; at most {_LONGEST_GAP:g} are bridged"
        )
    nearest = np.abs(t[np.clip(np.searchsorted(t, grid), 1, len(t) - 1)] - grid)
    nearest = np.minimum(nearest, np.abs(t[np.searchsorted(t, grid + slack) - 1] - grid))
    warnings.warn(
        f"score: the log's {len(t)} rows are not at the scenario's samples (up to "
        f"{nearest.max():.3g} s beside them) and are resampled to {len(grid)}; the longest gap is "
        f"{gaps[longest]:.3g} s",
        UserWarning,
        stacklevel=4,
    )
    columns["theta"] = np.unwrap(columns["theta"])
    held = np.clip(np.searchsorted(t, grid + slack, side="right") - 1, 0, len(t) - 1)
    return {
        name: column[held] if name.startswith("tau_") else np.interp(grid, t, column)
        for name, column in columns.items()
    }


def _say_speeds(columns: dict[str, Array]) -> None:
    """Add v and omega where the log has none, from differences of the poses."""
    if "v" in columns:
        return
    warnings.warn(
        "score: the log has no v and omega; they come from differences of the poses, and energy "
        "and lateral_force_peak rest on them",
        UserWarning,
        stacklevel=5,
    )
    t, theta = columns["t"], np.unwrap(columns["theta"])
    rates = [np.gradient(columns[name], t) for name in ("x", "y")]
    columns["v"] = rates[0] * np.cos(theta) + rates[1] * np.sin(theta)
    columns["omega"] = np.gradient(theta, t)
