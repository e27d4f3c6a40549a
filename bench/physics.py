"""Cost of controllers in MuJoCo, on wheels and floors that the simulation does not have.

Usage: python bench/physics.py [--seeds 1 2 3] [--rivals samson takagi-sugeno lqr]
                               [--step 0.002] [--soft-casters] [--contact-time 0.02]
                               [--cone pyramidal] [--convergence]

E of eq. 41 on P, C and F (nfopidn.families.benchmark, the paper's path), at 0.2 s, for one set of
gains each: Controller.recommended, and the tracking law, and rivals, tuned here on the family R.
Medians over the seeds. Rows: wheels that touch at one point (ellipsoids), the same with 0.1 N m of
Coulomb friction at each joint that nothing makes up for, cylinders 30 mm wide, cylinders with that
friction; before them the simulation itself, with 20 substeps. A run that is lost counts as 1.
With --convergence, instead: how cost and pose on F go to those of the exact integrator as the step
is halved.
"""

import argparse
import warnings

import mujoco
import nfopidn
import numpy as np
from nfopidn import Controller, Scenario
from nfopidn.families import benchmark
from nfopidn.mujoco import Caster, build_model, run

ROWS = {
    "one contact": {"wheels": "ellipsoid"},
    "one contact, friction": {"wheels": "ellipsoid", "joint_friction": 0.1},
    "cylinder": {"wheels": "cylinder"},
    "cylinder, friction": {"wheels": "cylinder", "joint_friction": 0.1},
}


def scenarios():
    """Give P, C and F."""
    published = Scenario.published(rng=0)
    steady = Scenario.published(heading="continuous", rng=0)
    fast = Scenario.published(heading="continuous", period=50.0, rng=0)
    return published, steady, fast


def tuned(structure, seed):
    """Give what a search over the family R finds."""
    found = nfopidn.tune(
        benchmark("R"), structure=structure, robustness=None, maxfev=10_000, rng=seed
    )
    return found.controller


def costs(controller, settings):
    """Give min(E, 1) of P, C and F in the engine."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # a run that is lost shows in its cost
        return [min(run(one, controller, **settings).cost, 1.0) for one in scenarios()]


def simulated(controller):
    """Give the same of the simulation."""
    runs = (nfopidn.simulate(one.replace(substeps=20), controller) for one in scenarios())
    return [min(result.cost, 1.0) for result in runs]


def convergence():
    """Print the errors against the exact integrator."""
    law = Controller.recommended()
    scenario = scenarios()[2].replace(integrator="exact")
    exact = nfopidn.simulate(scenario, law)
    for step in (0.004, 0.002, 0.001, 0.0005):
        model = build_model(contact_time=4 * step, wheel_mass=11.5e-5, armature=0.0)
        result = run(scenario, law, model=model, step=step)
        pose = 1000 * np.abs(result.pose - exact.pose).max()
        print(
            f"{1000 * step:4g} ms  E {100 * (result.cost / exact.cost - 1):+.4f} %  pose {pose:.2f}"
        )


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    parser.add_argument("--rivals", nargs="*", default=["samson", "takagi-sugeno", "lqr"])
    parser.add_argument("--step", type=float, default=0.002)
    parser.add_argument("--contact-time", type=float, default=0.02)
    parser.add_argument("--cone", default="pyramidal", help="or elliptic")
    parser.add_argument("--soft-casters", action="store_true", help="wheels have the weight")
    parser.add_argument("--convergence", action="store_true")
    arguments = parser.parse_args()
    if arguments.convergence:
        convergence()
        return
    common = {"step": arguments.step, "contact_time": arguments.contact_time}
    common["cone"] = arguments.cone
    if arguments.soft_casters:
        soft = 10 * arguments.contact_time
        common["casters"] = [Caster(x, contact_time=soft) for x in (0.17, -0.17)]
    drivers = {"recommended": [Controller.recommended()]}
    for structure in ["tracking", *arguments.rivals]:
        drivers[f"{structure}, R"] = [tuned(structure, seed) for seed in arguments.seeds]
    print(f"MuJoCo {mujoco.__version__}, step {arguments.step:g} s; medians of {arguments.seeds}")
    print(f"{'controller':18} {'model':22} {'P':>7} {'C':>7} {'F':>7}")
    for name, found in drivers.items():
        rows = {"simulated": [simulated(one) for one in found]}
        for row, settings in ROWS.items():
            rows[row] = [costs(one, settings | common) for one in found]
        for row, values in rows.items():
            shown = " ".join(f"{value:7.4f}" for value in np.median(values, axis=0))
            print(f"{name:18} {row:22} {shown}", flush=True)


if __name__ == "__main__":
    main()
