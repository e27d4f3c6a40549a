"""The parameters of the runs: each a function of the seed, the run's number and its own name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn.arguments import real_numbers, shown, suggestion
from nfopidn.montecarlo.distributions import Distribution, Normal

Array = NDArray[np.float64]

METHODS = ("independent", "latin-hypercube", "sobol")
#: Seeds are whole numbers under it.
SEEDS = 2**53
#: Parameters by name: unit, lowest and highest value, and what they are.
PARAMETERS: dict[str, tuple[str, float, float, str]] = _core.drawn_parameters()
_PLACES = {name: place for place, name in enumerate(PARAMETERS)}
_BITS = 53  # of the numbers of Sobol's points
_STRIDE = 64  # numbers of a run, of which each parameter has one
_GOLDEN = 0x9E3779B97F4A7C15
_MASK = 2**64 - 1


def _mixed(state: NDArray[np.uint64], between: int = 0) -> NDArray[np.uint64]:
    """SplitMix64's output for a state, as in the core's counter_noise.hpp."""
    z = (state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9) + np.uint64(between)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


def _word(seed: int, number: int) -> int:
    return int(_mixed(np.array([(seed + number * _GOLDEN) & _MASK], dtype=np.uint64))[0])


def _uniforms(seed: int, name: str, first: int, count: int) -> Array:
    """Numbers in (0, 1), multiples of 2**-53 and a half, of the runs from `first` on."""
    runs = np.arange(first, first + count, dtype=np.uint64)
    numbers = runs * np.uint64(_STRIDE) + np.uint64(_PLACES[name] + 1)
    states = numbers * np.uint64(_GOLDEN) + np.uint64(_word(seed, 1))
    bits = _mixed(states, _word(seed, 2)) >> np.uint64(11)
    return np.asarray((bits.astype(np.float64) + 0.5) * 2.0**-53)


def check_distributions(given: Any) -> dict[str, Distribution]:
    """Return distributions by name, in the order in which the core sets parameters.

    Raises
    ------
    ValueError
        Names the argument: no distribution, a name that is none, or what is no distribution.
    """
    if not isinstance(given, Mapping):
        raise ValueError(f"distributions is {shown(given)}; must be a mapping of names")
    for name, one in given.items():
        if name not in PARAMETERS:
            raise ValueError(
                f"distributions has {name!r}{suggestion(name, PARAMETERS)}; known: "
                + ", ".join(PARAMETERS)
            )
        if isinstance(one, type) or not isinstance(one, Distribution):
            raise ValueError(
                f"distributions[{name!r}] is {shown(one)}; must be a Normal, Uniform, LogNormal or "
                "Choice, or a frozen distribution of scipy.stats"
            )
    ordered = {name: given[name] for name in PARAMETERS if name in given}
    for name, one in ordered.items():
        _check_values(name, _quantiles(name, one, np.array([1e-3, 0.5, 1 - 1e-3])), None)
    return ordered


def _quantiles(name: str, one: Distribution, shares: Array) -> Array:
    values = np.asarray(one.ppf(shares), dtype=float)
    if values.shape != shares.shape:
        raise ValueError(
            f"distributions[{name!r}] gives quantiles of the shape {values.shape}; must be that of "
            f"one number a share, {shares.shape}"
        )
    return values


def _check_values(name: str, values: Array, first: int | None) -> None:
    """Refuse what the parameter cannot be; `first` is the number of the first run."""
    unit, low, high, _ = PARAMETERS[name]
    good = np.isfinite(values) & (values >= low) & (values <= high)
    rule = f"must be in [{low:g}, {high:g}] {unit}".rstrip()
    if good.all() and name == "delay":
        good = values == np.floor(values)
        rule = "must be a whole number of samples: draw it from a Choice"
    if good.all():
        return
    place = int(np.argmin(good))
    where = "" if first is None else f" in run {first + place}"
    raise ValueError(f"distributions[{name!r}] gives {float(values[place])!r}{where}; {rule}")


def check_covariance(given: Any, distributions: Mapping[str, Distribution]) -> Array | None:
    """Return the lower Cholesky factor of the Normal parameters' correlations.

    Raises
    ------
    ValueError
        A matrix of another shape, not symmetric, not positive definite, or whose diagonal is not
        the variances.
    """
    if given is None:
        return None
    names = [name for name, one in distributions.items() if isinstance(one, Normal)]
    matrix = real_numbers("covariance", given)
    if matrix.shape != (len(names), len(names)) or not names:
        raise ValueError(
            f"covariance has the shape {matrix.shape}; must have a row and a column for each "
            f"Normal of distributions, ({len(names)}, {len(names)})"
        )
    if not np.isfinite(matrix).all():
        raise ValueError("covariance must be finite")
    if not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0):
        raise ValueError("covariance is not symmetric")
    return matrix


def _sobol_points(engine: Any, first: int, count: int) -> Array:
    """Give the points first .. first + count - 1 of one of SciPy's Sobol sequences.

    Its own fast_forward() fails for points of more than 32 bits, and takes a step a point. Point
    i + 1 is the one before with the direction of the lowest 0 bit of i, so that i steps leave those
    of the Gray code of i.
    """
    if first == 0:  # alone, as SciPy warns of first points whose number is no power of 2
        return np.concatenate([engine.random(1), engine.random(count - 1)])
    code = (first - 1) ^ ((first - 1) >> 1)
    for place in range(_BITS):
        if code >> place & 1:
            engine._quasi ^= engine._sv[:, place]
    engine.num_generated = first
    return np.asarray(engine.random(count))


class Draws:
    """The parameters of n runs, to be made again at any time."""

    def __init__(
        self,
        distributions: Mapping[str, Distribution],
        *,
        n: int,
        seed: int,
        method: str,
        covariance: Any,
    ) -> None:
        """Check what is given.

        Raises
        ------
        ValueError
            Names the argument, its value and what it must be.
        """
        if method not in METHODS:
            raise ValueError(
                f"method is {shown(method)}{suggestion(method, METHODS)}; must be one of "
                + ", ".join(METHODS)
            )
        self.distributions = check_distributions(distributions)
        self.names = list(self.distributions)
        self.n = n
        self.seed = seed
        self.method = method
        if method != "independent" and not self.names:
            raise ValueError(f"distributions is empty; method {method!r} must have at least one")
        if method == "sobol" and n & (n - 1):
            raise ValueError(f"n is {n}; must be a power of 2 for Sobol's points to be balanced")
        self._factor = self._factor_of(covariance, list(distributions))
        self._design: Array | None = None

    def _factor_of(self, covariance: Any, given: list[str]) -> Array | None:
        """Return the Cholesky factor of the correlations, in the order of `names`."""
        in_given_order = {name: self.distributions[name] for name in given}
        matrix = check_covariance(covariance, in_given_order)
        if matrix is None:
            return None
        normal = [name for name in given if isinstance(self.distributions[name], Normal)]
        for place, name in enumerate(normal):
            std = self.distributions[name].std  # type: ignore[attr-defined]
            if not np.isclose(matrix[place, place], std**2, rtol=1e-9, atol=0):
                raise ValueError(
                    f"covariance[{place}, {place}] is {matrix[place, place]!r}; must be the "
                    f"variance of distributions[{name!r}], {std**2!r}"
                )
        order = [normal.index(name) for name in self.names if name in normal]
        deviations = np.sqrt(np.diag(matrix))
        correlations = (matrix / np.outer(deviations, deviations))[np.ix_(order, order)]
        try:
            return np.asarray(np.linalg.cholesky(correlations))
        except np.linalg.LinAlgError:
            least = float(np.linalg.eigvalsh(correlations)[0])
            raise ValueError(
                f"covariance is not positive definite: its correlations' least eigenvalue is "
                f"{least:.3g}"
            ) from None

    def __getstate__(self) -> dict[str, Any]:
        """Leave out the design, which whoever needs it makes again."""
        return {**vars(self), "_design": None}

    @property
    def first_seed(self) -> int:
        """The noise seed of run 0; those of the others follow, modulo 2**53."""
        return _word(self.seed, 3) % SEEDS

    def run_seed(self, run: int) -> int:
        """Give the noise seed of a run."""
        return (self.first_seed + run) % SEEDS

    def _shares(self, first: int, count: int) -> Array:
        """(count, p): what quantiles are taken."""
        from scipy.stats import qmc

        if self.method == "independent":
            columns = [_uniforms(self.seed, name, first, count) for name in self.names]
            return np.stack(columns, axis=1) if columns else np.empty((count, 0))
        dimensions = len(self.names)
        if self.method == "sobol":
            engine = qmc.Sobol(dimensions, bits=_BITS, rng=np.random.default_rng(self.seed))
            points = _sobol_points(engine, first, count)
        else:
            if self._design is None:
                rng = np.random.default_rng(self.seed)
                self._design = qmc.LatinHypercube(dimensions, rng=rng).random(self.n)
            points = self._design[first : first + count]
        return np.asarray(np.clip(points, 2.0**-54, 1 - 2.0**-53))

    def values(self, first: int, count: int) -> Array:
        """Give the parameters of the runs from `first` on, (count, p) in the order of `names`.

        Raises
        ------
        ValueError
            A drawn value that the parameter cannot be, with the run's number.
        """
        from scipy.special import ndtr, ndtri

        shares = self._shares(first, count)
        if self._factor is not None:
            normal = [
                place
                for place, name in enumerate(self.names)
                if isinstance(self.distributions[name], Normal)
            ]
            shares[:, normal] = ndtr(ndtri(shares[:, normal]) @ self._factor.T)
        result = np.empty((count, len(self.names)))
        for place, name in enumerate(self.names):
            result[:, place] = _quantiles(name, self.distributions[name], shares[:, place])
            _check_values(name, result[:, place], first)
        return result

    def check(self, values: Array) -> None:
        """Refuse values, (m, p), that their parameters cannot be.

        Raises
        ------
        ValueError
            Names the parameter, the value and its range.
        """
        for place, name in enumerate(self.names):
            _check_values(name, values[:, place], None)

    def words(self) -> dict[str, Any]:
        """Give what the draws depend on, as a checkpoint's identity."""
        return {
            "distributions": {name: _text(one) for name, one in self.distributions.items()},
            "method": self.method,
            "seed": self.seed,
            "n": None if self.method == "independent" else self.n,
            "correlations": None if self._factor is None else self._factor.tolist(),
        }


def _text(one: Any) -> str:
    """Give a distribution in words: of scipy.stats its name and arguments."""
    if hasattr(one, "dist") and hasattr(one, "args"):
        return f"{one.dist.name}({one.args!r}, {one.kwds!r})"
    return repr(one)
