"""
Fractional operators
====================

How good each method of discretisation is, and what long memory costs.

``python examples/fractional.py [discretisation.png]``
"""

import math
import sys

import matplotlib as mpl
import nfopidn
from nfopidn.fractional import METHODS, FractionalFilter, discretise, truncation_report

mpl.use("Agg")

DT = 0.2
ORDERS = (0.1078, 0.5, 0.9, -0.5, 1.5)

# %%
# Errors of the methods for several orders.
print("worst magnitude [%] and phase [degree] error over the decade up to a tenth of Nyquist's")
print(f"{'memory 100, 9 sections':24}" + "".join(f"{f's^{order:g}':>18}" for order in ORDERS))
for method in METHODS:
    cells = []
    for order in ORDERS:
        magnitude, phase = discretise(order, DT, method).errors()
        cells.append(f"{100 * magnitude:10.3g} {phase:7.3g}")
    print(f"{method:24}" + "".join(cells))

# %%
# A memory of any length costs a few modes, not one term a sample.
print("\nlong memory, s^0.5 by Tustin's rule")
print(f"{'memory':>10} {'modes':>6} {'certificate':>12}")
for memory in (100, 1_000, 10_000, 100_000, 1_000_000, math.inf):
    model = FractionalFilter(0.5, DT, memory, "tustin")
    print(f"{memory:10g} {model.modes:6d} {model.certificate:12.2g}")

# %%
# How far the controller's operators are from the fractional ones, at the paper's memory and beyond.
for memory in (5, 100, math.inf):
    print()
    print(truncation_report(nfopidn.Controller.published(memory=memory), DT))

# %%
# Magnitude, phase and their errors for a half derivative.
panels = nfopidn.plot.discretisation(0.5, DT)
panels[0].figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "discretisation.png", dpi=150)
