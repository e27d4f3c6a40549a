"""Tune for an ordinary robot by default settings; print what its position errors are then.

Usage: python bench/ordinary_robot.py [--seeds 1 2 3 4 5] [--moving] [--room 3.2]

A robot of 5 kg at 50 Hz with friction, on an eight of 1.2 m in 18 s. For each seed: the root mean
square of the distance to the reference [mm] over the lap, as tuned, with one and with two samples
of delay, and from 0.1 m beside the start; the seconds that the search took; and the verdict. With
--room the search's upper bounds are for loops so many times as fast: speed gains, which are rates,
may be so many times as high, proportional gains its square and integral gains its cube.

With --friction the friction is not what it was taken for: of each seed's gains the root mean square
of the distance [mm] and the share that the pose has in the cost, with 70 and with 130 % of the
friction, without and with friction feedforward, once with the gains above and once with gains that
were tuned with it.
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


def pose_share(run):
    """Give the share that errors of position and heading have in the cost (eq. 41)."""
    error = run.columns
    pose = sum(np.mean(error[name] ** 2) for name in ("e_x", "e_y", "e_theta"))
    return pose / run.cost


def print_friction(scenario, seeds):
    """Print what friction feedforward is worth where the friction is another than was taken."""
    compensated = scenario.replace(friction_feedforward=(0.0, scenario.coulomb_friction))
    print("seed  tuned    fed forward  70 % [mm]  share  130 % [mm]  share  worse [mm]")
    for tuned, given in (("without", scenario), ("with", compensated)):
        worse = {}
        for seed in seeds:
            controller = nfopidn.tune(given, rng=seed).controller
            for fed, one in (("no", scenario), ("yes", compensated)):
                row = ""
                errors = []
                for factor in (0.7, 1.3):
                    rubbing = one.replace(coulomb_friction=factor * scenario.coulomb_friction)
                    run = nfopidn.simulate(rubbing, controller)
                    errors.append(1e3 * run.metrics["position_rms"])
                    row += f"  {errors[-1]:9.2f}  {pose_share(run):5.3f}"
                worse.setdefault(fed, []).append(max(errors))
                print(f"{seed:4}  {tuned:7}  {fed:11}{row}  {max(errors):9.2f}", flush=True)
        medians = {fed: np.median(values) for fed, values in worse.items()}
        ratio = medians["yes"] / medians["no"]
        print(f"mid   {tuned:7}  worse {medians['no']:.2f} -> {medians['yes']:.2f} mm, {ratio:.3f}")


def main():
    """Run the searches that the arguments ask for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3, 4, 5])
    parser.add_argument("--moving", action="store_true", help="start at the reference's speed")
    parser.add_argument("--room", type=float, default=1.0, help="for loops so many times as fast")
    parser.add_argument(
        "--friction", action="store_true", help="what friction feedforward is worth"
    )
    arguments = parser.parse_args()
    scenario = ordinary(moving=arguments.moving)
    bounds = None if arguments.room == 1 else wider_bounds(scenario, arguments.room)
    if arguments.friction:
        return print_friction(scenario, arguments.seeds)
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
