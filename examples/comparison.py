"""NFOPIDN and its rivals on the published scenario, each tuned alike: costs and paths."""

import sys

import matplotlib.pyplot as plt
import nfopidn
from nfopidn import Scenario

scenario = Scenario.published(rng=0)
controllers = nfopidn.tune_contenders(["all"], scenario, seeds=1, progress=sys.stderr.isatty())
result = nfopidn.compare(controllers, {"published": scenario})
result.print()

order = result.ranking("published").names
runs = {name: result.first_runs[name, "published"] for name in order}
figure, (whole, start) = plt.subplots(1, 2, figsize=(9.6, 5.2), layout="constrained")
nfopidn.plot.paths(runs, ax=whole)
whole.get_legend().remove()
nfopidn.plot.paths(runs, ax=start)
start.set(xlim=(2.5, 4.25), ylim=(-0.55, 1.2), title=None)
start.get_legend().remove()
handles, _ = start.get_legend_handles_labels()
labels = [f"{name}  {run.cost:.4f}" for name, run in runs.items()]
figure.legend(handles, ["reference", *labels], loc="outside upper center", ncols=5, fontsize=8)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "comparison.png", dpi=130)
