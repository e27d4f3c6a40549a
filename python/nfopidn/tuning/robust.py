"""What a robust search is over, and what its members that diverge are called."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nfopidn._core import Scenario, simulate
from nfopidn.arguments import shown
from nfopidn.families.family import Family
from nfopidn.families.runs import simulate_many
from nfopidn.search.optimise import Array
from nfopidn.tuning.parameters import Search

#: Controllers of the last population that a member must lose to be called hopeless.
_WITNESSES = 16


def check_robustness(robustness: Any) -> None:
    """Refuse a robustness that is neither "standard" nor None."""
    if robustness is not None and not (isinstance(robustness, str) and robustness == "standard"):
        raise ValueError(f"robustness is {shown(robustness)}; must be 'standard' or None")


#: Standard variations that a coarse integrator makes unstable first: the fastest loops, and delay.
_EULER_SENSITIVE = ("nominal", "mass x0.8", "inertia x0.5", "delay +1")


def _searched(scenario: Scenario) -> Family:
    """Give what a robust search of one scenario is over.

    Its standard variations, with the accurate integrator: one Euler step a sample is another robot,
    and a search must not be led by it alone. But who asks for that integrator is judged on it, so
    that of its own variations those are added that it makes unstable first.
    """
    family = scenario.replace(integrator="exact", substeps=1).variations("standard")
    if scenario.integrator == "exact":
        return family
    own = scenario.variations("standard")
    rows = zip(own.names, own.scenarios, own.changes, strict=True)
    words = f"integrator {scenario.integrator}"
    return family + Family.of(
        (f"{name}, {words}", one, f"{change}, {words}" if change else words)
        for name, one, change in rows
        if name in _EULER_SENSITIVE
    )


def standard_family(scenarios: Sequence[Scenario]) -> Family:
    """Give what a robust search is over: the standard variations of scenarios.

    They have the accurate integrator; a scenario with another one adds some with its own.
    """
    families = [_searched(scenario) for scenario in scenarios]
    if len(families) == 1:
        return families[0]
    first, *others = (
        family.renamed(f"scenario {place + 1}") for place, family in enumerate(families)
    )
    for family in others:
        first += family
    return first


def diverging(family: Family, controller: Any) -> dict[str, float]:
    """Give the times [s] at which a controller's runs diverge, by the members' names."""
    runs = simulate_many(family, controller)
    return {
        name: float(at)
        for name, at in zip(runs.names, runs.diverged_at, strict=True)
        if np.isfinite(at)
    }


def hopeless(family: Family, names: Sequence[str], search: Search, population: Array) -> list[str]:
    """Give those of the named members that diverge under every controller of a population."""
    controllers = [search.controller(x) for x in population[:_WITNESSES]]
    return [
        name
        for name in names
        if all(simulate(family[name], one).diverged_at is not None for one in controllers)
    ]
