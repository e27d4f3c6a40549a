"""bfoa+ and bfoa beside general optimisers, at the same number of evaluations and the same cost.

    python bench/optimisers.py                      our searches on every structure
    python bench/optimisers.py --rivals             and the general optimisers on the first
    python bench/optimisers.py --functions          the analytic test functions
    python bench/optimisers.py --functions --rivals and the general optimisers on them
    python bench/optimisers.py --ablation           what each ingredient of bfoa+ is worth
    python bench/optimisers.py --tuners             time beside NiaPy and mealpy, on a numba loop

Each rival runs in a virtual environment of its own, which is made when it is first asked for, under
build/peers (--environments), with numpy, the rival's packages from the package index, and this very
nfopidn: two of them in one environment may want different versions of what they share, and none
has to be installed beside nfopidn. A rival whose environment cannot be made is left out, and said
so. All get blocks of points or gradient-free calls of nfopidn.Objective, which costs them far less
than their own objective would.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
import venv
import warnings
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import nfopidn
import numpy as np

BUDGET = 10_000
PAPER = "positional, paper allocation"
CONTINUOUS = {"heading": "continuous"}
FAST = {"heading": "continuous", "period": 50.0}
WIDE = {f"ki_{channel}": (0.0, 3.0) for channel in ("x", "y", "theta")}

# Structure, changes of the published scenario, bounds, bar of the median, bar of the worst seed.
ROWS: dict[str, tuple[str, Mapping[str, Any], Mapping[str, Any] | None, float, float]] = {
    PAPER: ("paper", {}, None, 0.0230, 0.030),
    "incremental, integral gains to 0.3": ("incremental", {}, None, 0.01722, 0.0175),
    "incremental, gains to 3": ("incremental", {}, WIDE, 0.0180, np.inf),
    "positional, decoupled": ("decoupled", {}, None, 0.0178, np.inf),
    "extended": ("extended", {}, None, 0.01570, 0.0160),
    "extended, continuous heading": ("extended", CONTINUOUS, None, 0.01362, np.inf),
    "extended, 50 s a lap": ("extended", FAST, None, 0.0459, np.inf),
    "free taps": ("taps", {}, None, 0.0151, np.inf),
    "free taps, continuous heading": ("taps", CONTINUOUS, None, 0.0137, np.inf),
    "free taps, 50 s a lap": ("taps", FAST, None, 0.0461, np.inf),
}

Block = Callable[[np.ndarray], np.ndarray]


class Counted:
    """A block objective that keeps the best, and refuses more than the budget."""

    def __init__(self, block: Block) -> None:
        self.block = block
        self.left = BUDGET
        self.best = np.inf

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """Costs; of points beyond the budget infinity."""
        points = np.atleast_2d(points)
        costs = np.full(len(points), np.inf)
        if self.left > 0:
            costs[: self.left] = self.block(points[: self.left])
            self.best = min(self.best, costs.min())
            self.left -= len(points)
        return costs

    def one(self, x: np.ndarray) -> float:
        """The cost of a point."""
        if self.left <= 0:
            raise OutOfBudgetError
        return float(self(x)[0])


class OutOfBudgetError(Exception):
    """Ends an optimiser that counts its evaluations otherwise."""


def random_search(counted: Counted, box: np.ndarray, seed: int) -> None:
    """Uniform points."""
    rng = np.random.default_rng(seed)
    counted(rng.uniform(box[:, 0], box[:, 1], (BUDGET, len(box))))


def differential_evolution(counted: Counted, box: np.ndarray, seed: int, members: int = 15) -> None:
    """SciPy's, `members` times the dimension."""
    optimize = import_module("scipy.optimize")
    optimize.differential_evolution(
        counted.one, box, rng=seed, maxiter=10**6, popsize=members, tol=0, atol=0, polish=False
    )


def small_differential_evolution(counted: Counted, box: np.ndarray, seed: int) -> None:
    """SciPy's with about 50 members."""
    differential_evolution(counted, box, seed, round(50 / len(box)))


def dual_annealing(counted: Counted, box: np.ndarray, seed: int) -> None:
    """SciPy's."""
    import_module("scipy.optimize").dual_annealing(counted.one, box, rng=seed, maxiter=10**6)


def pycma(counted: Counted, box: np.ndarray, seed: int) -> None:
    """CMA-ES in the unit box, restarted with twice the population."""
    cma = import_module("cma")
    low, span = box[:, 0], box[:, 1] - box[:, 0]
    rng = np.random.default_rng(seed)
    members = 4 + int(3 * np.log(len(box)))
    while counted.left > 0:
        options = {"seed": int(rng.integers(1, 2**31)), "bounds": [0, 1], "verbose": -9}
        strategy = cma.CMAEvolutionStrategy(
            rng.uniform(size=len(box)), 0.3, {**options, "popsize": members}
        )
        while not strategy.stop() and counted.left > 0:
            points = np.array(strategy.ask())
            costs = counted(low + span * points)
            strategy.tell(list(points), list(np.where(np.isfinite(costs), costs, 1e9)))
        members *= 2


def pagmo(name: str, counted: Counted, box: np.ndarray, seed: int) -> None:
    """One of pygmo's algorithms."""
    pygmo = import_module("pygmo")

    class Problem:
        def fitness(self, x: np.ndarray) -> list[float]:
            return [counted.one(x)]

        def get_bounds(self) -> tuple[np.ndarray, np.ndarray]:
            return box[:, 0], box[:, 1]

    members = 20
    make = {"cmaes": pygmo.cmaes, "sade": pygmo.sade}[name]
    extra = {"force_bounds": True} if name == "cmaes" else {}
    algorithm = pygmo.algorithm(make(gen=BUDGET // members + 1, seed=seed, **extra))
    algorithm.evolve(pygmo.population(pygmo.problem(Problem()), members, seed=seed))


def pygmo_cmaes(counted: Counted, box: np.ndarray, seed: int) -> None:
    """Pygmo's CMA-ES."""
    pagmo("cmaes", counted, box, seed)


def pygmo_sade(counted: Counted, box: np.ndarray, seed: int) -> None:
    """Pygmo's self-adaptive differential evolution."""
    pagmo("sade", counted, box, seed)


def niapy_bfo(counted: Counted, box: np.ndarray, seed: int) -> None:
    """NiaPy's bacterial foraging."""
    algorithms = import_module("niapy.algorithms.basic")
    problems, task = import_module("niapy.problems"), import_module("niapy.task")

    class Problem(problems.Problem):
        def __init__(self) -> None:
            super().__init__(dimension=len(box), lower=box[:, 0], upper=box[:, 1])

        def _evaluate(self, x: np.ndarray) -> float:
            return counted.one(x)

    search = algorithms.BacterialForagingOptimization(seed=seed)
    search.run(task.Task(problem=Problem(), max_evals=BUDGET))


def mealpy_bfo(counted: Counted, box: np.ndarray, seed: int) -> None:
    """Mealpy's bacterial foraging."""
    space = import_module("mealpy").FloatVar(lb=box[:, 0], ub=box[:, 1])
    problem = {"obj_func": counted.one, "bounds": space, "minmax": "min", "log_to": None}
    bfo = import_module("mealpy.swarm_based.BFO").OriginalBFO(epoch=10**5)
    bfo.solve(problem, seed=seed)


# Each rival, and the packages of its environment.
RIVALS: dict[str, tuple[Callable[[Counted, np.ndarray, int], None], tuple[str, ...]]] = {
    "random search": (random_search, ()),
    "pycma with restarts": (pycma, ("cma",)),
    "pygmo cmaes": (pygmo_cmaes, ("pygmo",)),
    "pygmo sade": (pygmo_sade, ("pygmo",)),
    "SciPy differential evolution": (differential_evolution, ("scipy",)),
    "the same, about 50 members": (small_differential_evolution, ("scipy",)),
    "SciPy dual annealing": (dual_annealing, ("scipy",)),
    "NiaPy BFO": (niapy_bfo, ("niapy",)),
    "mealpy BFO": (mealpy_bfo, ("mealpy",)),
}
ROBOT, LOOP = "robot", "loop"  # problems of rivals, beside the names of FUNCTIONS
ENVIRONMENTS = Path(__file__).resolve().parent.parent / "build" / "peers"


def environment(packages: tuple[str, ...], folder: Path) -> Path:
    """The Python of the environment that has these packages; makes it if it is not there."""
    home = folder.resolve() / "-".join(("peer", *packages))
    python, ready = home / "bin" / "python", home / "ready"
    if not ready.exists():
        print(f"  making {home}", file=sys.stderr)
        venv.create(home, clear=True, with_pip=True)
        command = [python, "-m", "pip", "install", "--quiet", "numpy", *packages]
        subprocess.run(command, check=True, capture_output=True, text=True)
        ready.touch()
    return python


def problem(name: str) -> tuple[Block, np.ndarray]:
    """A cost of blocks of points, and its box, by name."""
    if name in FUNCTIONS:
        function, half, _ = FUNCTIONS[name]
        shift = np.random.default_rng(99).uniform(-0.3, 0.3, 11) * half
        return lambda points: function(points - shift), np.tile([-half, half], (11, 1))
    scenario = nfopidn.Scenario.published(rng=0)
    objective = nfopidn.Objective(scenario)
    if name == ROBOT:
        return objective.costs, objective.bounds
    loop = import_module("numba").njit(import_module("loops").compiled_loop)
    reference = scenario.reference

    def block(points: np.ndarray) -> np.ndarray:
        return np.array([loop(reference, objective.controller(x).taps) for x in points])

    block(objective.bounds.mean(1)[None, :])
    return block, objective.bounds


def search_as_peer(name: str, problem_name: str, seeds: int) -> None:
    """Print a rival's best cost of each seed, and the time of all, as JSON."""
    rival = RIVALS[name][0]
    block, box = problem(problem_name)
    costs = []
    start = time.perf_counter()
    for seed in range(1, seeds + 1):
        counted = Counted(block)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                rival(counted, box, seed)
        except OutOfBudgetError:
            pass
        costs.append(float(counted.best))
    print(json.dumps({"costs": costs, "seconds": time.perf_counter() - start}))


def rival_costs(
    name: str, problem_name: str, seeds: int, folder: Path
) -> tuple[list[float], float]:
    """The best cost of each seed and the time of all [s]; no costs if there is no environment."""
    packages = RIVALS[name][1] + (("numba",) if problem_name == LOOP else ())
    arguments = ["--peer", name, "--problem", problem_name, "--seeds", str(seeds)]
    with tempfile.TemporaryDirectory() as own:
        # nfopidn alone of all that is installed here.
        (Path(own) / "nfopidn").symlink_to(Path(nfopidn.__file__).resolve().parent)
        try:
            command = [environment(packages, folder), __file__, *arguments]
            done = subprocess.run(
                command,
                check=True,
                capture_output=True,
                text=True,
                env=os.environ | {"PYTHONPATH": own},
            )
        except (subprocess.CalledProcessError, OSError) as fault:
            said = (getattr(fault, "stderr", None) or str(fault)).strip().splitlines()
            print(f"  left out: {name}: {said[-1]}", file=sys.stderr)
            return [], 0.0
    # Some say other things before.
    found = json.loads(done.stdout.splitlines()[-1])
    return found["costs"], found["seconds"]


def show(name: str, costs: list[float], seconds: float, bar: str = "") -> None:
    """Print a row: median, quartiles, worst, time a search."""
    if not costs:
        return
    low, median, high = np.percentile(costs, [25, 50, 75])
    print(
        f"{name:36} {median:11.5g} {low:11.5g} {high:11.5g} {max(costs):11.5g}"
        f" {seconds / len(costs):8.3f}  {bar}",
        flush=True,
    )


def header(title: str) -> None:
    """Print the columns' names."""
    print(f"\n{title}\n")
    print(f"{'':36} {'median':>11} {'quartile':>11} {'quartile':>11} {'worst':>11} {'s each':>8}")


def tuned(row: str, seeds: int, **arguments: Any) -> list[float]:
    """Our costs on a row of the table."""
    structure, changes, bounds, _, _ = ROWS[row]
    scenario = nfopidn.Scenario.published(rng=0, **changes)
    return [
        nfopidn.tune(
            scenario, robustness=None, structure=structure, bounds=bounds, rng=seed, **arguments
        ).fun
        for seed in range(1, seeds + 1)
    ]


def structures(seeds: int) -> bool:
    """Our searches on every structure, against the bars; whether all are met."""
    header(f"bfoa+, {BUDGET} evaluations, {seeds} seeds")
    met = True
    for row, (_, _, _, bar, worst_bar) in ROWS.items():
        start = time.perf_counter()
        costs = tuned(row, seeds, maxfev=BUDGET)
        good = np.median(costs) <= bar and max(costs) <= worst_bar
        met &= bool(good)
        text = f"bar {bar:g}" + (f", worst {worst_bar:g}" if np.isfinite(worst_bar) else "")
        show(row, costs, time.perf_counter() - start, text + ("" if good else "  MISSED"))
    header(f"bfoa as printed, {PAPER}, {seeds} seeds")
    for name, limit in (("one schedule", None), (f"{BUDGET} evaluations", BUDGET)):
        options = {} if limit is None else {"dispersals": 100}
        start = time.perf_counter()
        costs = tuned(PAPER, seeds, method="bfoa", maxfev=limit, options=options)
        good = limit is not None or np.median(costs) <= 0.060
        met &= bool(good)
        show(name, costs, time.perf_counter() - start, "" if limit else "bar 0.06")
    return met


def rivals(seeds: int, folder: Path) -> None:
    """General optimisers on the first structure."""
    header(f"{PAPER}, {BUDGET} evaluations, {seeds} seeds")
    start = time.perf_counter()
    show("bfoa+", tuned(PAPER, seeds, maxfev=BUDGET), time.perf_counter() - start)
    for name in RIVALS:
        show(name, *rival_costs(name, ROBOT, seeds, folder))


def sphere(z: np.ndarray) -> np.ndarray:
    """0 at 0."""
    return (z**2).sum(1)


def rosenbrock(z: np.ndarray) -> np.ndarray:
    """0 at 0, at the end of a bent valley."""
    w = z + 1
    return (100 * (w[:, 1:] - w[:, :-1] ** 2) ** 2 + (1 - w[:, :-1]) ** 2).sum(1)


def rastrigin(z: np.ndarray) -> np.ndarray:
    """0 at 0, with a pit at all whole numbers."""
    return (z**2 - 10 * np.cos(2 * np.pi * z) + 10).sum(1)


def ackley(z: np.ndarray) -> np.ndarray:
    """0 at 0, nearly flat far away."""
    a = -20 * np.exp(-0.2 * np.sqrt((z**2).mean(1)))
    return a - np.exp(np.cos(2 * np.pi * z).mean(1)) + 20 + np.e


# Name to function, half the box's width, bar of the median.
FUNCTIONS = {
    "Sphere": (sphere, 5.12, 1e-12),
    "Rosenbrock": (rosenbrock, 2.048, 1e-6),
    "Rastrigin": (rastrigin, 5.12, 1e-6),
    "Ackley": (ackley, 32.0, 1e-10),
}
# Of the worst seed.
WORST = {"Rastrigin": 1e-6}


def functions(seeds: int, folder: Path | None) -> bool:
    """The analytic functions in 11 dimensions, shifted off the centre; whether all bars are met."""
    met = True
    for name, (_, _, bar) in FUNCTIONS.items():
        block, box = problem(name)

        def columns(points: np.ndarray, block: Any = block) -> np.ndarray:
            return block(points.T)

        header(f"{name}, 11 dimensions, {BUDGET} evaluations, {seeds} seeds")
        start = time.perf_counter()
        costs = [
            nfopidn.bfoa(columns, box, rng=seed, maxfev=BUDGET, vectorized=True).fun
            for seed in range(1, seeds + 1)
        ]
        worst = WORST.get(name, np.inf)
        good = np.median(costs) <= bar and max(costs) <= worst
        met &= bool(good)
        text = f"bar {bar:g}" + (f", worst {worst:g}" if np.isfinite(worst) else "")
        show("bfoa+", costs, time.perf_counter() - start, text + ("" if good else "  MISSED"))
        for rival in RIVALS if folder is not None else ():
            show(rival, *rival_costs(rival, name, seeds, folder))
    return met


ABLATION: dict[str, Mapping[str, Any]] = {
    "as shipped": {},
    "no differential tumbles": {"differential_share": 0.0},
    "no sparse tumbles": {"differential_share": 1.0},
    "no gradient finish": {"foraging_share": 1.0},
    "gradient finish alone": {"foraging_share": 0.03},
    "one descent, then new places": {"finishers": 1},
    "jumps, no new places": {"restart_points": 0},
    "every descent to its end": {"patience": 1e9},
    "one colony": {"colonies": 1},
    "two colonies": {"colonies": 2},
    "16 cells": {"cells": 16},
    "32 cells": {"cells": 32},
    "few first points": {"first_points": 40},
}


def ablation(seeds: int) -> None:
    """What each ingredient is worth."""
    for row in (PAPER, "incremental, gains to 3", "positional, decoupled", "extended"):
        header(f"ablation of bfoa+: {row}, {BUDGET} evaluations, {seeds} seeds")
        for name, options in ABLATION.items():
            start = time.perf_counter()
            costs = tuned(row, seeds, maxfev=BUDGET, options=options)
            show(name, costs, time.perf_counter() - start)


def tuners(folder: Path) -> None:
    """Time of the same tuning with NiaPy's and mealpy's BFO on a numba loop."""
    scenario = nfopidn.Scenario.published(rng=0)
    start = time.perf_counter()
    ours = nfopidn.tune(scenario, robustness=None, rng=1, maxfev=BUDGET)
    own = time.perf_counter() - start
    print(f"\n{'bfoa+':12} {own:8.3f} s, cost {ours.fun:.5f}")
    for name in ("NiaPy BFO", "mealpy BFO"):
        costs, taken = rival_costs(name, LOOP, 1, folder)
        if costs:
            print(f"{name:12} {taken:8.3f} s, cost {costs[0]:.5f}, {taken / own:.0f} times as long")


def main() -> int:
    """Run what is asked for; 1 if a bar is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=25)
    for option in ("rivals", "functions", "ablation", "tuners"):
        parser.add_argument(f"--{option}", action="store_true")
    parser.add_argument("--environments", type=Path, default=ENVIRONMENTS, metavar="DIR")
    # What a rival's own environment is asked for.
    parser.add_argument("--peer", choices=list(RIVALS), help=argparse.SUPPRESS)
    parser.add_argument("--problem", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    met = True
    if arguments.peer:
        search_as_peer(arguments.peer, arguments.problem, arguments.seeds)
    elif arguments.functions:
        met = functions(arguments.seeds, arguments.environments if arguments.rivals else None)
    elif arguments.rivals:
        rivals(arguments.seeds, arguments.environments)
    elif arguments.ablation:
        ablation(arguments.seeds)
    elif arguments.tuners:
        tuners(arguments.environments)
    else:
        met = structures(arguments.seeds)
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
