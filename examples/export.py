"""
A controller as C source
========================

The control step as C99 that needs neither heap nor a mathematics library.

``python examples/export.py [folder]``
"""

import sys

import nfopidn

# %%
# Tune for the path that the board will drive.
scenario = nfopidn.Scenario.published(period=100, rng=0)
controller = nfopidn.tune(scenario, structure="extended", robustness=None, rng=1).controller
nfopidn.plot.total_torque(nfopidn.simulate(scenario, controller))

# %%
# The law itself, what a real robot needs beside it (faults, odometry, signs), and the path as a
# table.
folder = sys.argv[1] if len(sys.argv) > 1 else "firmware"
files = nfopidn.export_c(controller, folder, scenario=scenario, hardware=True, reference=True)
for file in files:
    print(f"{file.name:22}{file.stat().st_size:7} bytes")

# %%
# The interface.
print(files[0].read_text())
