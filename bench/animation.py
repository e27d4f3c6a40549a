"""Make docs/images/physics.gif: the tracking law in MuJoCo on an eight, on wheels that scrub.

Usage: python bench/animation.py [-o docs/images/physics.gif]
"""

import argparse

from nfopidn import Controller, Scenario, Trajectory
from nfopidn.mujoco import render, run


def main():
    """Run and render."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", default="docs/images/physics.gif")
    arguments = parser.parse_args()
    path = Trajectory.eight(period=60.0, dt=0.2, scale=0.4, derivatives="analytic")
    start = (path.x[0] + 0.2, path.y[0] - 0.3, path.theta[0] + 0.6)
    scenario = Scenario(path, initial_pose=start, rng=0)
    result = run(scenario, Controller.recommended(peak_speed=path.peak_speed), "cylinder")
    render(result, arguments.output, speed=6.0, frames_a_second=10.0, width=440, height=330)
    print(f"{arguments.output}: E = {result.cost:.4f}")


if __name__ == "__main__":
    main()
