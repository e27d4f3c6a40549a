"""What a search must keep to besides its cost: limits of metrics, margins and delay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nfopidn import _core
from nfopidn._core import Controller, Rival, Scenario
from nfopidn.arguments import is_number, shown, suggestion
from nfopidn.robustness.limits import MOST_DELAY, bearable_delay, find_margin
from nfopidn.robustness.long_runs import OnPath
from nfopidn.search.optimise import Array

#: What the runs of a candidate tell, in one block with those of the others; unit and text of each.
RUN_CONSTRAINTS: dict[str, tuple[str, str]] = {
    **_core.metric_fields(),
    "settling_time": ("s", "last time at which the position error exceeds 0.05 m"),
    "diverged": ("", "scenarios searched on which the run diverges"),
}
#: What takes an analysis of a controller, as its verdict has it; unit and text of each.
LOOP_CONSTRAINTS: dict[str, tuple[str, str]] = {
    "gain_margin": ("dB", "the smaller of the loop's two gain margins"),
    "phase_margin": ("rad", "of the loop linearised on a straight line"),
    "delay_margin": ("samples", "of the same; where it is not known the delay that is borne"),
    "delay_bearable": ("samples", "more delay with which the run stays on its path"),
}
CONSTRAINTS = {**RUN_CONSTRAINTS, **LOOP_CONSTRAINTS}

_PLACES = {name: place for place, name in enumerate(_core.FIGURES)}

Pair = tuple[float | None, float | None]


@dataclass(frozen=True)
class Limit:
    """What one constraint allows: low to high, either of which may be infinite."""

    name: str
    low: float
    high: float

    def is_met(self, value: float) -> bool:
        """Whether a value is allowed: never one that is not known, or of a run that diverges."""
        return not self.violation(np.array([value])).any()

    def violation(self, values: Array) -> Array:
        """By how much values (n,) are beyond it, as a share of the limit, at most 1; 0: not.

        An infinite metric is of a run that diverges, or never settles. An infinite margin is one.
        """
        known = ~np.isnan(values) if self.name in LOOP_CONSTRAINTS else np.isfinite(values)
        share = np.zeros(len(values))
        for limit, side in ((self.high, 1.0), (self.low, -1.0)):
            if np.isfinite(limit):
                beyond = side * (values[known] - limit) / (abs(limit) or 1.0)
                share[known] = np.maximum(share[known], beyond)
        return np.where(known, share / (1.0 + share), 1.0)

    def worst_of(self, values: Array) -> Array:
        """Give of each row (n, scenarios) the value that is farthest beyond, or else nearest."""
        far = np.stack([self.violation(column) for column in values.T], axis=1)
        near = np.full(values.shape, -np.inf)
        if np.isfinite(self.high):
            near = np.maximum(near, values - self.high)
        if np.isfinite(self.low):
            near = np.maximum(near, self.low - values)
        order = np.where(far.any(axis=1, keepdims=True), far, near)
        return np.asarray(values[np.arange(len(values)), np.argmax(order, axis=1)])

    @property
    def words(self) -> str:
        """What is allowed, with its unit."""
        unit = CONSTRAINTS[self.name][0]
        ends = [f"at least {self.low:g}"] if np.isfinite(self.low) else []
        ends += [f"at most {self.high:g}"] if np.isfinite(self.high) else []
        return " and ".join(ends) + (f" {unit}" if unit else "")


def check_constraints(given: Any) -> list[Limit]:
    """Return the limits.

    Raises
    ------
    ValueError
        No mapping, a name that is none, with the nearest one, no pair of numbers or None, both
        None, or reversed.
    """
    if not isinstance(given, Mapping) or not given:
        raise ValueError(f"constraints is {shown(given)}; must be a mapping by name, of at least 1")
    limits = []
    for name, pair in given.items():
        if name not in CONSTRAINTS:
            hint = suggestion(name, CONSTRAINTS)
            known = ", ".join(CONSTRAINTS)
            raise ValueError(f"constraints has {name!r}{hint}; known: {known}")
        ends = pair if isinstance(pair, tuple | list) and len(pair) == 2 else ("", "")
        if not all(end is None or is_number(end) for end in ends):
            raise ValueError(
                f"constraints[{name!r}] is {shown(pair)}; must be (low, high), either may be None"
            )
        low = -np.inf if ends[0] is None else float(ends[0])
        high = np.inf if ends[1] is None else float(ends[1])
        if not low <= high or low == np.inf or high == -np.inf:
            raise ValueError(
                f"constraints[{name!r}] is {shown(pair)}; low must not be above high, and allow "
                "some value"
            )
        if low == -np.inf and high == np.inf:
            raise ValueError(f"constraints[{name!r}] is {shown(pair)}; must limit something")
        limits.append(Limit(name, low, high))
    return limits


class Judge:
    """The constraints' values for candidates.

    Metrics are those of the scenarios that were given, of several the one that is farthest beyond
    its limit; `diverged` counts the scenarios that are searched.
    """

    def __init__(
        self,
        limits: Sequence[Limit],
        given: Sequence[Scenario],
        searched: Sequence[Scenario],
        workers: int,
    ) -> None:
        self.of_runs = [one for one in limits if one.name in RUN_CONSTRAINTS]
        self.of_loop = [one for one in limits if one.name in LOOP_CONSTRAINTS]
        self.given = list(given)
        self.searched = list(searched)
        self.workers = workers
        names = [one.name for one in self.of_runs]
        self._counts = "diverged" in names
        self._measures = any(name != "diverged" for name in names)

    def run_values(self, controllers: Sequence[Controller | Rival]) -> dict[str, Array]:
        """Give (n,) for each constraint of runs; infinite where a run diverges."""
        found: dict[str, Array] = {}
        if self._measures:
            rows = _core.measure_runs(self.given, controllers, self.workers, warns=False)
            lost = np.isfinite(rows[:, :, _PLACES["diverged_at"]])
            for limit in self.of_runs:
                if limit.name == "diverged":
                    continue
                values = rows[:, :, _PLACES[limit.name]]
                if limit.name != "cost":  # the samples before a divergence are no whole run
                    values = np.where(lost, np.inf, values)
                found[limit.name] = limit.worst_of(values)
        if self._counts:
            rows = _core.measure_runs(self.searched, controllers, self.workers, warns=False)
            lost = np.isfinite(rows[:, :, _PLACES["diverged_at"]])
            found["diverged"] = lost.sum(axis=1).astype(float)
        return found

    def run_violation(self, controllers: Sequence[Controller | Rival]) -> Array:
        """Give the sum of violations (n,) of the constraints of runs."""
        values = self.run_values(controllers)
        total = np.zeros(len(controllers))
        for limit in self.of_runs:
            total += limit.violation(values[limit.name])
        return total

    def loop_values(self, controller: Controller | Rival) -> dict[str, float]:
        """Give each constraint of the loop: the worst of the scenarios that were given."""
        if not self.of_loop:
            return {}
        names = {limit.name for limit in self.of_loop}
        rows = [Loop.of(controller, scenario, names) for scenario in self.given]
        return {
            limit.name: float(
                limit.worst_of(np.array([[row.values[limit.name] for row in rows]]))[0]
            )
            for limit in self.of_loop
        }

    def loop_violation(self, controller: Controller | Rival) -> float:
        """Give the sum of violations of the constraints of the loop over the scenarios."""
        names = {limit.name for limit in self.of_loop}
        total = 0.0
        for scenario in self.given if names else []:
            row = Loop.of(controller, scenario, names)
            total += sum(row.violation(limit) for limit in self.of_loop)
        return total

    def table(self, controller: Controller | Rival) -> dict[str, dict[str, Any]]:
        """Give for each constraint its value, limits, unit, and whether it is met."""
        values = {name: float(row[0]) for name, row in self.run_values([controller]).items()}
        values |= self.loop_values(controller)
        return {
            limit.name: {
                "value": values[limit.name],
                "low": None if np.isinf(limit.low) else limit.low,
                "high": None if np.isinf(limit.high) else limit.high,
                "unit": CONSTRAINTS[limit.name][0],
                "met": limit.is_met(values[limit.name]),
            }
            for limit in (*self.of_runs, *self.of_loop)
        }

    def complaint(self, table: Mapping[str, Mapping[str, Any]]) -> str:
        """Say in words what of a table is not met; empty if all is."""
        texts = []
        for limit in (*self.of_runs, *self.of_loop):
            row = table[limit.name]
            if not row["met"]:
                value = "not known" if np.isnan(row["value"]) else f"{row['value']:.6g}"
                texts.append(f"{limit.name} is {value}; must be {limit.words}")
        return "; ".join(texts)


@dataclass(frozen=True)
class Loop:
    """What the verdict on one scenario would say of a loop; 0 of one that is off its path."""

    values: dict[str, float]
    #: In [0, 1]: how far the first run that does not stay on the path is from it, which is that of
    #: the scenario itself, or the one with a sample more than the delay that is borne.
    shortfall: float

    @classmethod
    def of(cls, controller: Controller | Rival, scenario: Scenario, names: set[str]) -> Loop:
        """Analyse a loop; `names` are the values that are wanted."""
        # It runs on robots that it is not made for, which are not to be warned about.
        is_rival = isinstance(controller, Rival)
        anyones = controller if is_rival else controller.replace(robot=None)
        on_path = OnPath(scenario, anyones)
        base = on_path.scenario
        if not on_path.stays_nominal:
            return cls(dict.fromkeys(names, 0.0), 1.0)
        # Where the margins are found by simulation, the delay that is borne is that of the delay.
        delay = bearable_delay(on_path)
        found = {"delay_bearable": float(delay)}
        shortfall = 0.0
        if "delay_bearable" in names and base.delay + delay < MOST_DELAY:
            shortfall = on_path.shortfall(base.replace(delay=base.delay + delay + 1))
        if names - {"delay_bearable"}:
            margin = find_margin(on_path, scenario, delay)
            found["gain_margin"] = margin.decibels
            found["phase_margin"] = margin.phase
            found["delay_margin"] = margin.delay
        return cls({name: found[name] for name in names}, shortfall)

    def violation(self, limit: Limit) -> float:
        """Give by how much a limit is broken: of the delay without the steps of whole samples."""
        value = self.values[limit.name]
        found = float(limit.violation(np.array([value]))[0])
        if found > 0 and limit.name == "delay_bearable" and value < limit.low:
            share = (limit.low - value - 1.0 + self.shortfall) / limit.low
            return max(share, 1e-9) / (1.0 + max(share, 1e-9))
        return found
