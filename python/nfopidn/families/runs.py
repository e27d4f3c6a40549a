"""A controller on every scenario of a family."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import Controller, Rival, Scenario, StopIf
from nfopidn.arguments import check_sample_time, whole_number
from nfopidn.console import progress as progress_bar
from nfopidn.families.family import Family

Array = NDArray[np.float64]


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

    Runs are measured one by one and not kept: a family may be large.

    Parameters
    ----------
    scenarios
        A Family, scenarios by name, or a list of them.
    controller
        A Controller or a Rival.
    workers
        Runs at a time. The result does not depend on it.
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
    ended = threading.Event()

    def measure(scenario: Scenario) -> tuple[dict[str, float], float]:
        with StopIf(ended.is_set):
            run = _core.simulate(scenario, controller)
        return run.metrics, np.nan if run.diverged_at is None else run.diverged_at

    rows = []
    with progress_bar("simulating", len(family), progress) as report:
        pool = ThreadPoolExecutor(workers)
        try:
            for done, row in enumerate(pool.map(measure, family.scenarios)):
                rows.append(row)
                report(done + 1, family.names[done])
        except BaseException:
            ended.set()  # the pool waits for what it has begun
            raise
        finally:
            pool.shutdown(cancel_futures=True)
    measured = [metrics for metrics, _ in rows]
    return FamilyRuns(
        family.names,
        np.array([metrics["cost"] for metrics in measured]),
        {name: np.array([metrics[name] for metrics in measured]) for name in measured[0]},
        np.array([at for _, at in rows]),
    )
