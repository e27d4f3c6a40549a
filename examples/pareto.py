"""
A Pareto front
==============

How near to the path, and how smooth the torques: a search over two objectives, what the extended
structure gives up of one for the other, and the knee between them.

Needs pymoo: ``pip install "nfopidn[pareto]"``

``python examples/pareto.py [picture]``
"""

import sys

import nfopidn
from matplotlib import pyplot as plt
from nfopidn import plot


def main() -> None:
    """Search, choose, draw."""
    picture = sys.argv[1] if len(sys.argv) > 1 else "pareto.png"
    front = nfopidn.tune(
        objectives=("position_rms", "torque_variation"),
        structure="extended",
        robustness=None,
        rng=1,
    )
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
    plot.pareto_front(front, left)
    plot.hypervolume(front, right)
    figure.savefig(picture, dpi=130)

    ends = {"nearest to the path": 0, "knee": front.choose(), "smoothest": len(front) - 1}
    for name, place in ends.items():
        off, variation = front.objectives[place]
        print(f"{name}: {1e3 * off:.1f} mm, {variation:.1f} N m")


if __name__ == "__main__":
    main()
