"""Tune for an ordinary robot by default settings; print what its position errors are then.

Usage: python bench/ordinary_robot.py [--seeds 1 2 3 4 5] [--moving] [--room 3.2]

A robot of 5 kg at 50 Hz with friction, on an eight of 1.2 m in 18 s. For each seed: the root mean
square of the distance to the reference [mm] over the lap, as tuned, with one and with two samples
of delay, and from 0.1 m beside the start; the seconds that the search took; and the verdict. With
--room the search's upper bounds are for loops so many times as fast: speed gains, which are rates,
may be so many times as high, proportional gains its square and integral gains its cube.
"""

import argparse
import time

import nfopidn
import numpy as np
from nfopidn import Robot, Scenario, Trajectory


def ordinary(*, moving=False):
    """Make the scenario; `moving`: the robot starts at the reference's speed, not at rest."""
    return Scenario(
        Trajectory.eight(period=18.0, dt=0.02, scale=0.3, derivatives="analytic"),
        Robot(mass=5.0, inertia=0.08, track_width=0.30, wheel_radius=0.033),
        torque_limit=0.6,
        coulomb_friction=0.03,
        integrator="exact",
        initial_velocity="reference" if moving else (0.0, 0.0),
        rng=0,
    )


def wider_bounds(scenario, room):
    """Give the bounds of the gains with room for loops so many times as fast."""
    powers = {"speed_gain": 1, "kp": 2}
    powers |= dict.fromkeys(("integral_x", "integral_y", "integral_theta"), 3)
    return {
        name: (low, high * room**power)
        for name, (low, high) in nfopidn.default_bounds("tracking", scenario).items()
        for start, power in powers.items()
        if name.startswith(start)
    }


def conditions(scenario):
    """Give what the gains are tried on."""
    path = scenario.trajectory
    x, y, theta = path.x[0], path.y[0], path.theta[0]
    beside = (x - 0.1 * np.sin(theta), y + 0.1 * np.cos(theta), theta)
    return [
        scenario,
        scenario.replace(delay=1),
        scenario.replace(delay=2),
        scenario.replace(initial_pose=beside),
    ]


def errors(scenario, controller):
    """Give the root mean squares [mm] of the distance to the reference."""
    runs = [nfopidn.simulate(one, controller) for one in conditions(scenario)]
    return np.array([1e3 * run.metrics["position_rms"] for run in runs])


def main():
    """Run the searches that the arguments ask for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3, 4, 5])
    parser.add_argument("--moving", action="store_true", help="start at the reference's speed")
    parser.add_argument("--room", type=float, default=1.0, help="for loops so many times as fast")
    arguments = parser.parse_args()
    scenario = ordinary(moving=arguments.moving)
    bounds = None if arguments.room == 1 else wider_bounds(scenario, arguments.room)
    print("seed  nominal  delay 1  delay 2  beside [mm]  seconds  verdict")
    found = []
    for seed in arguments.seeds:
        begun = time.perf_counter()
        result = nfopidn.tune(scenario, rng=seed, bounds=bounds)
        seconds = time.perf_counter() - begun
        found.append(errors(scenario, result.controller))
        row = "  ".join(f"{error:7.1f}" for error in found[-1])
        print(f"{seed:4}  {row}      {seconds:7.1f}  {result.verdict.line}", flush=True)
    row = "  ".join(f"{error:7.1f}" for error in np.median(found, axis=0))
    print(f"mid   {row}")


if __name__ == "__main__":
    main()
