"""Tune for Eddie as it is built: 12 V motors and coarse encoders; print how far it is off its path.

Usage: python bench/eddie_motors.py [--seeds 1 2 3] [--maxfev 10000]

Motors with gears and back EMF from a supply of 12 V (constants of the kind, not of a datasheet), a
pose by odometry from encoders of 144 counts a revolution, control at 10 Hz, and a Gerono eight of
60 s. For each seed: the root mean square of the true distance to the reference [mm], the highest
peak in the spectrum of the wheel torques' errors over the median of its surroundings in the last
half of the run (a limit cycle has a high one), the seconds that the search took, and the verdict.
"""

import argparse
import time

import nfopidn
import numpy as np
from nfopidn import Motor, Robot, Scenario, Trajectory

# At the wheel: 12 V give 4.8 N m at standstill and 12 rad/s, 0.9 m/s, without load.
MOTOR = Motor(
    resistance=2.4,
    torque_constant=0.025,
    back_emf_constant=0.025,
    gear_ratio=38.3,
    rotor_inertia=5e-6,
    viscous_friction=0.01,
    coulomb_friction=0.05,
    supply_voltage=12.0,
)


def eddie():
    """Make the scenario."""
    return Scenario(
        Trajectory.eight(period=60.0, dt=0.1, derivatives="analytic"),
        Robot.eddie_datasheet(),
        motor=MOTOR,
        encoder_counts=144,
        integrator="exact",
        rng=0,
    )


def peak_over_surroundings(run, width=12):
    """Give the highest ratio of a line of the torques' spectrum to the median around it."""
    columns = run.columns
    worst = 0.0
    for side in ("left", "right"):
        error = columns[f"tau_{side}"] - columns[f"tau_ref_{side}"]
        half = error[len(error) // 2 :]
        lines = np.abs(np.fft.rfft((half - half.mean()) * np.hanning(len(half))))
        # What follows the path itself is below 0.5 Hz.
        first = int(np.ceil(0.5 * len(half) * run.scenario.trajectory.dt))
        for k in range(first, len(lines)):
            around = np.r_[lines[max(first, k - width) : max(k - 2, 0)], lines[k + 3 : k + width]]
            if len(around) >= width // 2:
                worst = max(worst, lines[k] / np.median(around))
    return worst


def main():
    """Tune and run once a seed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    parser.add_argument("--maxfev", type=int, default=10000)
    arguments = parser.parse_args()
    scenario = eddie()
    print("seed  true rms [mm]  peak  seconds  verdict")
    for seed in arguments.seeds:
        begun = time.perf_counter()
        result = nfopidn.tune(scenario, rng=seed, maxfev=arguments.maxfev)
        seconds = time.perf_counter() - begun
        run = nfopidn.simulate(scenario, result.controller)
        error = 1e3 * run.metrics["position_rms"]
        peak = peak_over_surroundings(run)
        print(
            f"{seed:4}  {error:13.1f}  {peak:4.1f}  {seconds:7.1f}  {result.verdict.line}",
            flush=True,
        )


if __name__ == "__main__":
    main()
