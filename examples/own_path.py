"""
A path and a robot of your own
==============================

From positions and a robot's data to a tuned controller, its verdict and its file.

``python examples/own_path.py [own_path.png]``
"""

import sys

import matplotlib.pyplot as plt
import nfopidn
import numpy as np
from nfopidn import Robot, Scenario, Trajectory

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
# Search for gains, in two structures. The incremental form has integral action, which friction
# asks for; "extended" has an order pair for each channel.
found = {
    structure: nfopidn.tune(scenario, structure=structure, robustness=None, rng=1)
    for structure in ("incremental", "extended")
}
for structure, result in found.items():
    print(f"{structure}: cost {result.fun:.5f} after {result.nfev} evaluations")

# %%
# A low cost of one run says little about a loop. Does it stay on the path?
for structure, result in found.items():
    print(f"{structure}: {nfopidn.stability.loop(scenario, result.controller)}\n")

# %%
# The runs: the path, and the distance from the reference.
runs = {name: nfopidn.simulate(scenario, result.controller) for name, result in found.items()}
figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.4), layout="constrained")
nfopidn.plot.paths(runs, ax=left)
nfopidn.plot.distances(runs, ax=right)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "own_path.png", dpi=120)

# %%
# The file is read by `nfopidn_sim --controller`, by `nfopidn export` and by `Controller.load`.
found["incremental"].controller.save("controller.json")
