"""
A path and a robot of your own
==============================

From positions and a robot's data to a tuned controller, its verdict and its file.

python examples/own_path.py [own_path.png]
"""

import sys

import matplotlib.pyplot as plt
import nfopidn
import numpy as np
from nfopidn import Controller, Robot, Scenario, Trajectory

# %%
# A path is a row of positions, one each sample. This one is closed and takes 40 s a lap.
dt = 0.05
phase = 2 * np.pi * np.arange(0, 40 + dt / 2, dt) / 40
x = 1.5 * np.sin(phase) + 0.4 * np.sin(2 * phase)
y = 1.2 * np.cos(phase) - 0.3 * np.cos(3 * phase)
trajectory = Trajectory.from_samples(x, y, dt)

# %%
# The robot's mass [kg], moment of inertia [kg m²], distance between the wheels [m] and wheels'
# radius [m]; friction [N m], what the wheels can give [N m], and noise of the measured pose.
robot = Robot(mass=6, inertia=0.12, track_width=0.3, wheel_radius=0.05)
scenario = Scenario(
    trajectory,
    robot=robot,
    torque_limit=0.8,
    coulomb_friction=0.02,
    pose_noise=(0.002, 0.002),
    rng=0,
)

# %%
# Search for gains. The incremental form has integral action, which friction asks for.
found = nfopidn.tune(scenario, structure="incremental", rng=1)
print(f"cost {found.fun:.5f} after {found.nfev} evaluations")
print(nfopidn.stability.loop(scenario, found.controller))

# %%
# The run under the gains that were found, beside the same structure with the paper's.
paper = Controller.published(form="incremental", allocation="decoupled")
runs = {
    "tuned": nfopidn.simulate(scenario, found.controller),
    "the paper's gains": nfopidn.simulate(scenario, paper),
}
figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.4), layout="constrained")
nfopidn.plot.paths(runs, ax=left)
nfopidn.plot.distances(runs, ax=right)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "own_path.png", dpi=120)

# %%
# The file is read by `nfopidn_sim --controller`, by `nfopidn export` and by `Controller.load`.
found.controller.save("controller.json")
