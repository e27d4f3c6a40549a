"""
Is the loop stable, and from where?
===================================

Verdicts on the published gains and on tuned ones, Floquet multipliers, and basins of attraction.

``python examples/stability.py [stability.png]``
"""

import sys

import matplotlib.pyplot as plt
from nfopidn import Controller, Scenario, plot, stability

# %%
# A verdict for each case, from the loop linearised about its periodic orbit.
published = Controller.published()
cases = {
    "published scenario": (Scenario.published(), published),
    "lap of 25 s": (Scenario.published(period=25), published),
    "incremental form": (Scenario.published(), Controller.published(form="incremental")),
    "tuned, incremental": (Scenario.published(), Controller.tuned_nominal()),
}
found = {name: stability.loop(*case) for name, case in cases.items()}
for name, result in found.items():
    print(f"{name}: {result}\n")
# %%
# How much gain, phase and delay the loops bear at a speed.
print(stability.margins(published, speed=0.3))

# %%
# Multipliers inside the unit circle, and the poses from which a run ends on its path.
figure, axes = plt.subplots(2, 2, figsize=(9.6, 9.2), layout="constrained")
plot.multipliers(found["published scenario"], axes[0, 0])
plot.multipliers(found["lap of 25 s"], axes[0, 1])
plot.basin(stability.basin(controller=published), axes[1, 0])
plot.basin(stability.basin(controller=Controller.tuned_nominal()), axes[1, 1])
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "stability.png", dpi=100)
