"""
Robustness, drawn
=================

What a controller does when the robot is not the one that its gains were found on.

``python examples/robustness.py [FOLDER]``
"""

import sys
from pathlib import Path

import nfopidn
from nfopidn import Controller, Rival, Scenario, plot

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
scenario = Scenario.published(rng=0)
family = scenario.variations("standard")
print(family)

# %%
# The gains that the library recommends for this robot, those of a nominal search, and a rival with
# its default gains. Their verdicts say what may be trusted with a robot.
nominal = nfopidn.tune(scenario, structure="incremental", robustness=None, rng=1)
controllers = {
    "recommended": Controller.recommended(robot=scenario.robot, sample_time=0.2),
    "nominal search": nominal.controller,
    "LQR": Rival("lqr"),
}
verdicts = {name: nfopidn.verdict(one, scenario) for name, one in controllers.items()}
for name, verdict in verdicts.items():
    print(f"{name}: {verdict.line}")

# %%
# What each variation costs.
ax = plot.variation_costs({name: verdict.runs for name, verdict in verdicts.items()})
ax.figure.savefig(folder / "robustness_costs.png", dpi=130)

# %%
# Gain, phase and delay margin.
panels = plot.margin_bars(verdicts)
panels[0].figure.savefig(folder / "robustness_margins.png", dpi=130)

# %%
# The paths that two of them drive over the family.
for name, file in (("recommended", "recommended"), ("nominal search", "nominal")):
    ax = plot.path_bundle(family, controllers[name])
    ax.figure.savefig(folder / f"robustness_paths_{file}.png", dpi=130)
