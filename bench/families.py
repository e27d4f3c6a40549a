"""Tune the tracking law over families of scenarios; print the mean and the worst cost of each seed.

Usage: python bench/families.py [--families R G J J++] [--seeds 1 2 3 4 5] [--method bfoa+]
                                [--structure tracking]

The families are those of nfopidn.families.benchmark, and two for the time that a search takes: P12,
the published scenario and eleven variations of it, and P12-exact, the same with the exact
integrator. Means and worst costs are of min(E, 1). With J++ its parts on R and G are printed too,
and what its gains cost on paths and plants that no search has seen (nfopidn.families.unseen). A
structure may also be the name of a rival:

    python bench/families.py --families P12 --structure samson
"""

import argparse
import time

import nfopidn
import numpy as np
from nfopidn import Controller
from nfopidn.families import benchmark, simulate_many, unseen

UNSEEN_PATHS = 48


def family_named(name):
    """Give a family of nfopidn.families.benchmark, or the variations whose search is timed."""
    if name not in ("P12", "P12-exact"):
        return benchmark(name)
    integrator = "exact" if name == "P12-exact" else "semi-implicit-euler"
    small_turner = {"inertia": 0.5, "track_width": 0.863}
    return nfopidn.Scenario.published(rng=0, integrator=integrator).variations(
        mass=(1.2, 0.8),
        **small_turner,
        coulomb_friction=(0.03, 0.06),
        disturbance=0.02,
        pose_noise=0.005,
        delay=1,
        corners=({"delay": 1, **small_turner}, {"delay": 1, "coulomb_friction": 0.06}),
    )


def costs(family, controller):
    """Give min(E, 1) of every scenario."""
    if isinstance(controller, Controller):
        controller = controller.replace(robot=None)  # no warning that the family has other robots
    return np.minimum(simulate_many(family, controller).costs, 1.0)


def main():
    """Run the searches that the arguments ask for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--families", nargs="+", default=["R", "G", "J", "J++"])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3, 4, 5])
    parser.add_argument("--method", default="bfoa+")
    parser.add_argument("--structure", default="tracking", help="or a rival, such as lqr")
    parser.add_argument("--maxfev", type=int, default=10_000)
    parser.add_argument("--save", help="write the controllers to SAVE-FAMILY-SEED.json")
    arguments = parser.parse_args()
    others = {"R": benchmark("R"), "G": benchmark("G"), "unseen": unseen(UNSEEN_PATHS)}
    print(f"{'family':6}  {'seed':4}  {'mean E':7}  {'worst E':7}  {'parts':47}  seconds")
    for name in arguments.families:
        family = family_named(name)
        for seed in arguments.seeds:
            begun = time.perf_counter()
            result = nfopidn.tune(
                family,
                structure=arguments.structure,
                robustness=None,
                method=arguments.method,
                maxfev=arguments.maxfev,
                rng=seed,
            )
            seconds = time.perf_counter() - begun
            found = costs(family, result.controller)
            parts = ""
            if name == "J++":
                for part, members in others.items():
                    of_part = costs(members, result.controller)
                    parts += f"{part} {of_part.mean():.4f}/{of_part.max():.3f} "
            print(
                f"{name:6}  {seed:4}  {found.mean():.5f}  {found.max():.4f}   {parts:47}"
                f"  {seconds:.1f}",
                flush=True,
            )
            if arguments.save:
                result.controller.save(f"{arguments.save}-{name}-{seed}.json")


if __name__ == "__main__":
    main()
