"""Controllers side by side on the same plant, limits and sampling: docs/comparison.md."""

from nfopidn.comparison.comparison import METRICS, Comparison, compare, settling_time
from nfopidn.comparison.contenders import CONTENDERS, GROUPS, tune_contenders
from nfopidn.comparison.suite import CONDITIONS, path_names, scenario_suite, suite_names

__all__ = [
    "CONDITIONS",
    "CONTENDERS",
    "GROUPS",
    "METRICS",
    "Comparison",
    "compare",
    "path_names",
    "scenario_suite",
    "settling_time",
    "suite_names",
    "tune_contenders",
]
