"""A controller on every scenario of a family."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import Controller, Rival, Scenario
from nfopidn.arguments import check_sample_time, whole_number
from nfopidn.console import progress as progress_bar
from nfopidn.families.family import Family

Array = NDArray[np.float64]

#: Runs a thread between two notes of progress.
_BLOCK = 64


@dataclass(frozen=True)
class FamilyRuns:
    """What a controller does on each of n scenarios; prints as a table.

    Attributes
    ----------
    names
        of the scenarios
    costs
        (n,): E of eq. 41, diverged runs included as they are
    metrics
        (n,) each: by the names of SimulationResult.metrics
    diverged_at
        (n,): time [s] at which a run diverged, nan where it did not
    """

    names: tuple[str, ...]
    costs: Array
    metrics: dict[str, Array]
    diverged_at: Array

    @property
    def diverged(self) -> NDArray[np.bool_]:
        """(n,): which runs diverged."""
        return np.isfinite(self.diverged_at)

    @property
    def mean_cost(self) -> float:
        """The mean of min(E, 1): a run that is lost counts as 1, however far it goes."""
        return float(np.minimum(self.costs, 1.0).mean())

    @property
    def worst_cost(self) -> float:
        """The largest min(E, 1)."""
        return float(min(self.costs.max(), 1.0))

    @property
    def worst(self) -> str:
        """The name of the scenario that costs most."""
        return self.names[int(np.argmax(self.costs))]

    def __len__(self) -> int:
        """Give the number of scenarios."""
        return len(self.names)

    def __str__(self) -> str:
        width = max(len(name) for name in self.names)
        lines = [f"{'':{width}}  {'cost':>8}"]
        for name, cost, at in zip(self.names, self.costs, self.diverged_at, strict=True):
            lost = f"  diverges at {at:.4g} s" if np.isfinite(at) else ""
            lines.append(f"{name:{width}}  {min(cost, 1.0):8.4f}{lost}")
        lines.append(f"{'mean':{width}}  {self.mean_cost:8.4f}")
        return "\n".join(lines)


def family_of(scenarios: Any) -> Family:
    """Give a family of whatever stands for one: itself, scenarios by name, or a list of them.

    Raises
    ------
    ValueError
        No scenario at all, or something that is none.
    """
    if isinstance(scenarios, Family):
        return scenarios
    if isinstance(scenarios, Scenario):
        return Family(("scenario",), (scenarios,), ("",))
    if isinstance(scenarios, Mapping):
        return Family(tuple(scenarios.keys()), tuple(scenarios.values()), ("",) * len(scenarios))
    if not isinstance(scenarios, Sequence) or isinstance(scenarios, str):
        raise ValueError(f"scenarios is {scenarios!r}; must be a Family or Scenarios")
    names = tuple(f"scenario {place + 1}" for place in range(len(scenarios)))
    return Family(names, tuple(scenarios), ("",) * len(scenarios))


def simulate_many(
    scenarios: Family | Mapping[str, Scenario] | Sequence[Scenario],
    controller: Controller | Rival,
    *,
    workers: int = 1,
    progress: bool = False,
) -> FamilyRuns:
    """Run a controller on every scenario of a family.

    Runs are measured and not kept: a family may be large. Neighbours whose noise_source is
    "counter" and that share path, model and settings, and differ in robot, friction, disturbance,
    noise or start alone, go in lanes; the figures of each are those of simulate() to the last bit.

    Parameters
    ----------
    scenarios
        A Family, scenarios by name, or a list of them.
    controller
        A Controller or a Rival.
    workers
        Threads. The result does not depend on it.
    progress
        Whether to show a bar.

    Returns
    -------
    FamilyRuns
        Ctrl-C ends the runs and raises KeyboardInterrupt.

    Raises
    ------
    ValueError
        No scenario, a controller that is none or is made for another sample time.
    """
    family = family_of(scenarios)
    whole_number("workers", workers, 1)
    if not isinstance(controller, Controller | Rival):
        raise ValueError(f"controller is {controller!r}; must be a Controller or a Rival")
    for name, scenario in family.items():
        try:
            check_sample_time(controller, scenario)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
    rows = np.empty((len(family), len(_core.FIGURES)))
    block = _BLOCK * workers
    with progress_bar("simulating", len(family), progress) as report:
        for done in range(0, len(family), block):
            some = family.scenarios[done : done + block]
            rows[done : done + block] = _core.measure_runs(some, [controller], workers)[0]
            report(done + len(some), family.names[done + len(some) - 1])
    columns = dict(zip(_core.FIGURES, rows.T.copy(), strict=True))
    return FamilyRuns(
        family.names,
        columns["cost"],
        {name: columns[name] for name in _core.metric_fields()},
        columns["diverged_at"],
    )
