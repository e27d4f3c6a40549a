"""Families of scenarios: what a controller must bear, not only what it is tuned on.

=================== ====================================================================
`variations`        a scenario and its plant a little other: Scenario.variations()
`random_variations` the same, drawn at random from a seed
`over_paths`        a scenario's robot and start on other paths
`benchmark`         the families R, G, J and J++ of docs/theory.md
`unseen`            random paths and other plants, to try gains on that were found elsewhere
`simulate_many`     a controller on every scenario of a family
=================== ====================================================================
"""

from nfopidn.families.benchmarks import benchmark
from nfopidn.families.family import Family as Family  # its page is that of nfopidn.Family
from nfopidn.families.paths import over_paths
from nfopidn.families.runs import FamilyRuns, simulate_many
from nfopidn.families.unseen import unseen
from nfopidn.families.variations import random_variations, variations

__all__ = [
    "FamilyRuns",
    "benchmark",
    "over_paths",
    "random_variations",
    "simulate_many",
    "unseen",
    "variations",
]
