"""How near identification comes to the truth on logs that the package simulates.

python bench/identification.py [--seeds 10]

The truth: 12.7 kg, 0.41 kg m^2, Coulomb friction 0.12 N m, viscous friction 0.02 N m s/rad, two
samples of delay. 60 s at 20 Hz, noise of 10 mm and 10 mrad. Two logs of it: "steps" has torques
that change in steps, their sum and their difference each by itself; "lap" is a controller that
drives an eight. What is identified sees torques and noisy poses alone.
"""

import argparse
import time

import numpy as np
from nfopidn import Controller, Robot, Scenario, Trajectory, _core, identify, simulate

ROBOT = Robot(mass=12.7, inertia=0.41)
TRUTH = {"mass": 12.7, "inertia": 0.41, "coulomb_friction": 0.12, "viscous_friction": 0.02}
PLANT = {"coulomb_friction": 0.12, "viscous_friction": 0.02, "delay": 2, "integrator": "exact"}
DT, SAMPLES = 0.05, 1201


def steps(rng: np.random.Generator) -> np.ndarray:
    """Torques (SAMPLES, 2) that push, coast, brake and turn, both ways, for 0.6 to 1.6 s each."""
    torque = np.zeros((SAMPLES, 2))
    for strength, sides in ((1.0, [1, 1]), (0.45, [1, -1])):
        k, way = 0, 1
        wave = np.zeros(SAMPLES)
        while k < SAMPLES:
            length = int(rng.integers(12, 32))
            wave[k : k + length] = way * rng.uniform(0.3, 1.0) * strength
            wave[k + length : k + 2 * length] = -way * rng.uniform(0.0, 0.8) * strength
            k += 2 * length
            way = -way if rng.random() < 0.5 else way
        torque += np.outer(wave, sides)
    return torque


def log_of(kind: str, seed: int) -> dict[str, np.ndarray]:
    """Return a log: columns t, x, y, theta, tau_left, tau_right."""
    rng = np.random.default_rng(seed)
    if kind == "steps":
        line = np.linspace(0, 1, SAMPLES)
        still = np.zeros(SAMPLES)
        trajectory = Trajectory.from_samples(line, still, DT, theta=still)
        scenario = Scenario(
            trajectory, ROBOT, torque_limit=10, divergence_distance=1e6, rng=seed, **PLANT
        )
        result = _core.play(scenario, steps(rng))
    else:
        trajectory = Trajectory.eight(period=60, dt=DT)
        scenario = Scenario(trajectory, ROBOT, pose_noise=(0.01, 0.01), rng=seed, **PLANT)
        result = simulate(scenario, Controller.recommended(ROBOT, DT))
    columns = result.columns
    log = {name: columns[name] for name in ("t", "x", "y", "theta", "tau_left", "tau_right")}
    for name in ("x", "y", "theta"):
        log[name] = log[name] + rng.normal(0, 0.01, len(log[name]))
    return log


def main() -> None:
    """Print a row a log."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seeds", type=int, default=10, help="logs of each kind (%(default)s)")
    seeds = parser.parse_args().seeds
    print(f"{'log':6}{'seed':>5}" + "".join(f"{name:>18}" for name in TRUTH), "  delay  CPU [s]")
    for kind in ("steps", "lap"):
        for seed in range(seeds):
            log = log_of(kind, seed)
            begin = time.process_time()
            found = identify(log, robot=Robot())
            used = time.process_time() - begin
            errors = [found.parameters[n] / TRUTH[n] - 1 for n in TRUTH]
            row = "".join(f"{100 * e:+17.2f}%" for e in errors)
            print(f"{kind:6}{seed:5}{row}  {found.delay:5g}  {used:7.2f}", flush=True)


if __name__ == "__main__":
    main()
