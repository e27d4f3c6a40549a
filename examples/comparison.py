"""
NFOPIDN and its rivals
======================

Every controller on the published scenario, each tuned by the same search with the same budget.

``python examples/comparison.py [comparison.png]``
"""

import sys

import matplotlib.pyplot as plt
import nfopidn
from nfopidn import Scenario

SHOWN = (
    "free taps",
    "takagi-sugeno",
    "samson",
    "incremental",
    "NPID neural",
    "ramsete",
    "published",
)

# %%
# `nfopidn.tune_contenders` tunes each, `nfopidn.compare` runs them all.
scenario = Scenario.published(rng=0)
controllers = nfopidn.tune_contenders(["all"], scenario, seeds=1, progress=sys.stderr.isatty())
result = nfopidn.compare(controllers, {"published": scenario})
result.print()

# %%
# Some of them: the distance from the reference, and the path's start.
order = [name for name in result.ranking("published").names if name in SHOWN]
runs = {name: result.first_runs[name, "published"] for name in order}
figure, (far, start) = plt.subplots(1, 2, figsize=(9.6, 4.6), layout="constrained")
nfopidn.plot.distances(runs, ax=far)
nfopidn.plot.paths(runs, ax=start)
start.set(xlim=(2.6, 4.25), ylim=(-0.55, 1.1), title=None)
handles, _ = start.get_legend_handles_labels()
for ax in (far, start):
    ax.get_legend().remove()
labels = [f"{name}, E = {run.cost:.4f}" for name, run in runs.items()]
figure.legend(handles, ["reference", *labels], loc="outside upper center", ncols=4, fontsize=8)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "comparison.png", dpi=130)
