"""How fast trajectories through random waypoints are, against TOPP-RA, and that limits hold.

python bench/trajectory_timing.py [--sets 1000] [--compared 400]

Needs toppra (the extra `bench`) unless --compared is 0. Exit code 1 where a sample exceeds a limit
or the fastest motion is more than 3 % slower than TOPP-RA's on the same path and constraints.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from nfopidn import Robot
from nfopidn.trajectories import Limits, plan_waypoints
from nfopidn.trajectories.path import fit_curve
from nfopidn.trajectories.pieces import measure
from nfopidn.trajectories.timing import Motion, fastest, times

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "py"))

EDDIE = Robot()
LIMITS = Limits(
    speed=1.0,
    acceleration=0.8,
    lateral_acceleration=0.6,
    turn_rate=1.5,
    turn_acceleration=4.0,
    wheel_speed=20.0,
    wheel_torque=0.6,
)


def points_of(seed: int) -> np.ndarray:
    """Return 2 to 12 random waypoints."""
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.normal(size=(int(rng.integers(2, 13)), 2)), axis=0)


def limits_hold(sets: int) -> bool:
    """Plan through random waypoints; say how much of the limits is used and the time it takes."""
    worst, ratios, took = 0.0, [], []
    for seed in range(sets):
        begun = time.perf_counter()
        plan = plan_waypoints(
            points_of(seed), LIMITS, 0.02, EDDIE, closed=seed % 3 == 2 and len(points_of(seed)) > 2
        )
        took.append(time.perf_counter() - begun)
        worst = max(worst, *plan.use.values())
        ratios.append(plan.trajectory.t[-1] / plan.fastest)
    print(f"{sets} sets of waypoints: the most that a sample uses of a limit is {worst:.9f} of it")
    print(
        f"time with smoothing over 0.1 s and samples of 0.02 s over the fastest: median "
        f"{np.median(ratios):.3f}, largest {np.max(ratios):.3f}"
    )
    print(f"planning: median {np.median(took):.2f} s, largest {np.max(took):.2f} s")
    return worst <= 1 + 1e-9


def as_fast_as_toppra(count: int) -> bool:
    """Compare the times along smooth curves without stops."""
    import toppra
    from toppra_yardstick import duration

    toppra.setup_logging("ERROR")
    ratios, own_time, other_time = [], 0.0, 0.0
    for seed in range(count):
        if plan_waypoints(points_of(seed), LIMITS, 0.02, EDDIE).stops:
            continue
        _, s, kappa, change = measure(fit_curve(points_of(seed)), False)
        motion = Motion(s, np.ones(len(s)), kappa, change, np.full(len(s), np.inf))
        begun = time.perf_counter()
        own = times(motion, fastest(motion, LIMITS, EDDIE))[-1]
        own_time += time.perf_counter() - begun
        begun = time.perf_counter()
        ratios.append(own / duration(motion, LIMITS, EDDIE))
        other_time += time.perf_counter() - begun
    print(
        f"{len(ratios)} curves without stops, time over TOPP-RA's: {np.min(ratios):.4f} to "
        f"{np.max(ratios):.4f}, median {np.median(ratios):.4f}; computed in {own_time:.1f} s, "
        f"TOPP-RA {other_time:.1f} s"
    )
    return max(ratios) <= 1.03


def main() -> int:
    """Run both."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sets", type=int, default=1000)
    parser.add_argument("--compared", type=int, default=400)
    given = parser.parse_args()
    held = limits_hold(given.sets) if given.sets else True
    fast = as_fast_as_toppra(given.compared) if given.compared else True
    return 0 if held and fast else 1


if __name__ == "__main__":
    sys.exit(main())
