"""The runs of a Monte Carlo analysis, block by block."""

from __future__ import annotations

import json
import os
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from io import BytesIO
from os import PathLike
from pathlib import Path
from time import monotonic
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import Controller, Rival, Scenario
from nfopidn.arguments import check_sample_time, names_in, shown, suggestion, whole_number
from nfopidn.console import progress as progress_bar
from nfopidn.engines import Engine, Work, read_workers
from nfopidn.families import Family
from nfopidn.families.runs import family_of
from nfopidn.files import replace_file
from nfopidn.montecarlo.distributions import Distribution
from nfopidn.montecarlo.draws import SEEDS, Draws
from nfopidn.montecarlo.result import MonteCarloResult

Array = NDArray[np.float64]

#: Runs between two looks at Ctrl-C, at progress and at the checkpoint.
BLOCK = 2**15
#: Runs of an engine's first blocks, by which it is measured what a run takes.
_FIRST_BLOCK = 64
#: [s] between two checkpoints.
CHECKPOINT_EVERY = 5.0
#: What a run may be measured by besides its cost.
METRICS = tuple(name for name in _core.metric_fields() if name != "cost")
_PLACES = {name: place for place, name in enumerate(_core.metric_fields())}


def seed_of(rng: Any) -> int:
    """Return the seed that `rng` stands for; None: a new one.

    Raises
    ------
    ValueError
        Neither a seed nor a generator.
    """
    if rng is None:
        return int.from_bytes(os.urandom(8), "little") % SEEDS
    if hasattr(rng, "integers"):
        return int(rng.integers(SEEDS))
    return whole_number("rng", rng, 0, SEEDS - 1)


def check_columns(columns: Any) -> tuple[str, ...]:
    """Return the names of metrics to keep besides the cost.

    Raises
    ------
    ValueError
        A name that is none, with the one that is near.
    """
    names = names_in("columns", columns)
    for name in names:
        if name not in _PLACES:
            raise ValueError(
                f"columns has {name!r}{suggestion(name, _PLACES)}; known: {', '.join(_PLACES)}"
            )
    return tuple(name for name in METRICS if name in names)


def _check_member(name: str, scenario: Scenario, draws: Draws) -> None:
    """Refuse a scenario that has not what is drawn."""
    if "path_scale" in draws.names and scenario.trajectory.name == "samples":
        raise ValueError(f"{name}: a path of samples has no scale, which distributions draws")
    disturbed = {"disturbance_force", "disturbance_moment"} & set(draws.names)
    if disturbed and np.ndim(scenario.disturbance) > 1 and len(scenario.disturbance) > 1:
        raise ValueError(
            f"{name}: distributions draws {min(disturbed)}, a constant, but the scenario's "
            "disturbance is given by the sample"
        )


class Analysis:
    """What the runs of an analysis are made of, and where they stand."""

    def __init__(
        self, family: Family, controller: Controller | Rival, draws: Draws, columns: Sequence[str]
    ) -> None:
        self.family = family
        self.controller = controller
        self.draws = draws
        self.columns = tuple(columns)
        self.members = [
            _core.DrawnRuns(scenario, controller, draws.names) for scenario in family.scenarios
        ]

    def member(self, run: int) -> int:
        """Give the place in the family of a run's scenario."""
        return run % len(self.members)

    def scenario(self, run: int) -> Scenario:
        """Give the scenario of a run."""
        values = self.draws.values(run, 1)[0]
        return self.members[self.member(run)].scenario(values, self.draws.run_seed(run))

    def block(self, first: int, count: int, workers: int) -> Array:
        """Run the runs first .. first + count - 1: (count, 1 + columns), the cost first."""
        values = self.draws.values(first, count)
        result = np.empty((count, 1 + len(self.columns)))
        step = len(self.members)
        for offset in range(min(step, count)):
            own = np.ascontiguousarray(values[offset::step])
            seed = self.draws.run_seed(first + offset)
            member = self.member(first + offset)
            result[offset::step] = self.measure(own, seed, step, workers, member)
        return result

    def measure(
        self, values: Array, first_seed: int, step: int, workers: int, member: int = 0
    ) -> Array:
        """Run one scenario with parameters, (m, p), and seeds `step` apart: (m, 1 + columns)."""
        runs = self.members[member]
        if not self.columns:
            return np.asarray(runs.costs(values, first_seed, step, workers)[:, np.newaxis])
        kept = [_PLACES[name] for name in ("cost", *self.columns)]
        return np.asarray(runs.metrics(values, first_seed, step, workers)[:, kept])

    def __reduce__(self) -> tuple[Any, ...]:
        """Tell pickle what it is made of: the core's runs are made again."""
        return Analysis, (self.family, self.controller, self.draws, self.columns)

    def __call__(self, span: tuple[int, int]) -> Array:
        """Run the runs of (first, count) on one thread, as an engine's worker does."""
        return self.block(*span, workers=1)

    def identity(self) -> str:
        """Give in words all that the runs depend on."""
        return json.dumps(
            {
                "format": "nfopidn-monte-carlo",
                "version": 1,
                "scenarios": [one.to_json() for one in self.family.scenarios],
                "controller": self.controller.to_json(),
                "columns": self.columns,
                **self.draws.words(),
            },
            sort_keys=True,
        )


def _check_writable(path: str | PathLike[str]) -> None:
    try:
        _core.check_writable(path)
    except OSError as error:
        raise ValueError(f"checkpoint {path}: cannot be written: {error.strerror}") from None


def _write_checkpoint(path: str | PathLike[str], identity: str, rows: Array) -> None:
    content = BytesIO()
    np.savez(content, identity=np.array(identity), rows=rows, sum=np.array(crc32(rows.tobytes())))
    replace_file(path, content.getvalue())


def _read_checkpoint(path: str | PathLike[str], identity: str, n: int) -> Array | None:
    """Return the rows of the runs that are done; None where there is no file.

    Raises
    ------
    ValueError
        A file that is no checkpoint, is damaged, or is of other runs.
    """
    try:
        content = BytesIO(Path(path).read_bytes())
    except FileNotFoundError:
        return None
    try:
        with np.load(content, allow_pickle=False) as stored:
            found, rows, check = str(stored["identity"]), stored["rows"], int(stored["sum"])
    except Exception as error:
        raise ValueError(f"checkpoint {path}: is no checkpoint of monte_carlo: {error}") from None
    if crc32(rows.tobytes()) != check:
        raise ValueError(f"checkpoint {path}: is damaged")
    if found != identity:
        raise ValueError(
            f"checkpoint {path}: is of other runs: scenario, controller, distributions, method, "
            "seed and columns must be those that it was begun with"
        )
    return np.asarray(rows[:n])


def monte_carlo(
    scenario: Scenario | Family | Mapping[str, Scenario] | Sequence[Scenario],
    controller: Controller | Rival,
    n: int,
    *,
    rng: Any = None,
    distributions: Mapping[str, Distribution] | None = None,
    method: str = "independent",
    covariance: Any = None,
    columns: Sequence[str] = ("cost",),
    workers: Any = 1,
    checkpoint: str | PathLike[str] | None = None,
    progress: bool = False,
) -> MonteCarloResult:
    """Run a controller on n scenarios whose parameters are drawn.

    Each run has a robot, a start and noise of its own. The reference torques are still computed
    for the scenario's model, by default its robot: the controller does not know what is drawn.
    docs/monte-carlo.md tells how to, and which runs go in lanes.

    Parameters
    ----------
    scenario
        What the parameters that are not drawn come from. Of a family of k, run i is on scenario
        i modulo k.
    controller
        A Controller, or a Rival, whose runs go one by one.
    n
        Runs, [1, 1e9]; of Sobol's points a power of 2.
    rng
        A seed in [0, 2**53), a numpy.random.Generator, or None to draw one, which the result's
        `seed` records.
    distributions
        By name: a Normal, Uniform, LogNormal or Choice of nfopidn.montecarlo, or a frozen
        distribution of scipy.stats. Names: mass, inertia, track_width, wheel_radius,
        coulomb_friction, viscous_friction, coulomb_scrub, viscous_scrub, disturbance_force,
        disturbance_moment, position_noise, heading_noise, delay, start_x, start_y, start_theta,
        path_scale; values in SI units.
        None: noise alone differs.
    method
        "independent": run i depends on the seed and on i alone, and each of its parameters on
        its own name besides; "latin-hypercube" and "sobol": SciPy's points, which depend on n too
        and fill the space more evenly.
    covariance
        (m, m): of the m Normal distributions, in the order of `distributions`; its diagonal must
        be their variances. None: independent.
    columns
        Names of SimulationResult.metrics to keep, besides the cost. With any but "cost" a run takes
        some four times as long: its samples are gone through again.
    workers
        Threads, -1 for as many as there are processors; or an Executor as of concurrent.futures, a
        dask.distributed.Client or a function like map, whose workers do the runs: what is drawn
        is not sent, each worker draws its own. The result is the same with each.
    checkpoint
        A file in which finished blocks are kept, and from which a later call goes on, to the same
        bits.
    progress
        Whether to show a bar.

    Returns
    -------
    MonteCarloResult
        Ctrl-C raises KeyboardInterrupt, whose `best` is the result of the runs that are done, if
        there are any.

    Raises
    ------
    ValueError
        Names the argument, its value and what it must be.
    EngineError
        The workers keep dying, or were closed meanwhile; its `best` is as that
        of KeyboardInterrupt, and the checkpoint has the same.

    Examples
    --------
    >>> import nfopidn
    >>> from nfopidn.montecarlo import Normal
    >>> scenario = nfopidn.Scenario.published(pose_noise=(0.005, 0.005), rng=0)
    >>> runs = nfopidn.monte_carlo(
    ...     scenario, nfopidn.Controller.recommended(), 1000, rng=1,
    ...     distributions={"mass": Normal(11.5, 0.5), "inertia": Normal(0.5873, 0.05)})
    >>> len(runs), runs.yield_({"cost": 0.2}).successes
    (1000, 1000)
    """
    n = whole_number("n", n, 1)
    family = family_of(scenario)
    if not isinstance(controller, Controller | Rival):
        raise ValueError(f"controller is {shown(controller)}; must be a Controller or a Rival")
    crew = read_workers(workers)
    kept = check_columns(columns)
    draws = Draws(
        {} if distributions is None else distributions,
        n=n,
        seed=seed_of(rng),
        method=method,
        covariance=covariance,
    )
    for name, one in family.items():
        _check_member(name, one, draws)
        check_sample_time(controller, one)
    analysis = Analysis(family, controller, draws, kept)
    return _run(analysis, n, crew, checkpoint, progress)


def _run(
    analysis: Analysis,
    n: int,
    workers: int | Engine,
    checkpoint: str | PathLike[str] | None,
    progress: bool,
) -> MonteCarloResult:
    kept = _Kept(analysis, n, checkpoint)
    blocks = _on_threads if isinstance(workers, int) else _on_engine
    with progress_bar("runs", n, progress) as report:
        try:
            report(kept.done, f"{kept.done} of {n}")
            with closing(blocks(analysis, kept.done, n, workers)) as finished:
                for first, rows in finished:
                    kept.add(first, rows)
                    report(kept.done, f"{kept.done} of {n}")
            report(n, "")
        except (KeyboardInterrupt, Exception) as error:
            if kept.done:
                error.best = MonteCarloResult(analysis, kept.rows[: kept.done].copy())  # type: ignore[union-attr]
            raise
        finally:
            kept.save()
    return MonteCarloResult(analysis, kept.rows)


def _on_threads(
    analysis: Analysis, done: int, n: int, threads: Any
) -> Generator[tuple[int, Array], None, None]:
    """Run the blocks one after another, each on the threads of the core."""
    while done < n:
        count = min(BLOCK - done % BLOCK, n - done)
        yield done, analysis.block(done, count, threads)
        done += count


def _on_engine(
    analysis: Analysis, done: int, n: int, engine: Any
) -> Generator[tuple[int, Array], None, None]:
    """Have an engine's workers run the blocks; they come in any order."""
    with (
        engine,
        Work(engine, analysis, "distributions", "runs", first=_FIRST_BLOCK) as work,
        closing(work.blocks(n - done, lambda first, size: (done + first, size))) as blocks,
    ):
        for block in blocks:
            yield done + block.first, block.answer


class _Kept:
    """The rows of the runs that are done, here and in the checkpoint.

    Blocks come in any order; what counts as done are the runs before the first that is missing.
    """

    def __init__(self, analysis: Analysis, n: int, checkpoint: str | PathLike[str] | None) -> None:
        self.rows = np.empty((n, 1 + len(analysis.columns)))
        self.done = 0
        self._later: dict[int, int] = {}  # blocks beyond: where they end, by their beginning
        self._path = checkpoint
        self._identity = ""
        if checkpoint is not None:
            self._identity = analysis.identity()
            _check_writable(checkpoint)
            stored = _read_checkpoint(checkpoint, self._identity, n)
            if stored is not None:
                self.done = len(stored)
                self.rows[: self.done] = stored
        self._saved, self._saved_at = self.done, monotonic()
        self._saving = 0.0  # [s] that the last one took

    def add(self, first: int, rows: Array) -> None:
        """Take a block in, and save now and then."""
        self.rows[first : first + len(rows)] = rows
        self._later[first] = first + len(rows)
        while self.done in self._later:
            self.done = self._later.pop(self.done)
        # All rows are written: for many runs not so often that it takes a twentieth of the time.
        if monotonic() - self._saved_at > CHECKPOINT_EVERY * max(1.0, 4.0 * self._saving):
            self.save()

    def save(self) -> None:
        """Write the checkpoint, if there is one and it is behind."""
        if self._path is not None and self._saved < self.done:
            begun = monotonic()
            _write_checkpoint(self._path, self._identity, self.rows[: self.done])
            self._saved, self._saved_at = self.done, monotonic()
            self._saving = self._saved_at - begun
