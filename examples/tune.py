"""
A first tuning
==============

Both searches on the published scenario, and how they converge.

``python examples/tune.py [picture]``
"""

import sys

import nfopidn
from matplotlib import pyplot as plt


def main() -> None:
    """Tune, simulate, save, draw."""
    picture = sys.argv[1] if len(sys.argv) > 1 else "convergence.png"
    results = {
        "bfoa, the paper's schedule": nfopidn.tune(method="bfoa", robustness=None, rng=2),
        "bfoa+, 10,000 evaluations": nfopidn.tune(robustness=None, rng=2),
        "bfoa+, extended structure": nfopidn.tune(structure="extended", robustness=None, rng=2),
    }
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.4), sharey=True, layout="constrained")
    for ax, (title, result) in zip(axes, results.items(), strict=True):
        print(f"{title}: cost {result.fun:.6f} after {result.nfev} evaluations")
        result.plot(ax=ax)
        ax.set_title(f"{title}: E = {result.fun:.5f}", fontsize=9, pad=20)
    axes[0].set_ylim(0.01, 1)
    for ax in axes[1:]:
        ax.set_ylabel("")
    figure.savefig(picture, dpi=130)

    best = results["bfoa+, extended structure"]
    best.controller.save("controller.json")
    print("controller.json: cost", nfopidn.simulate(best.scenario, best.controller).cost)


if __name__ == "__main__":
    main()
