"""What a parameter of a run is drawn from: each by its quantile function."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from nfopidn.arguments import is_number, real_numbers, shown

Array = NDArray[np.float64]


@runtime_checkable
class Distribution(Protocol):
    """What monte_carlo() asks of a distribution; a frozen one of scipy.stats has it too."""

    def ppf(self, q: Array, /) -> Any:
        """Give the quantiles of shares in (0, 1)."""


def _finite(owner: str, name: str, value: Any) -> None:
    if not is_number(value) or not np.isfinite(float(value)):
        raise ValueError(f"{owner}: {name} is {shown(value)}; must be a finite number")


def _positive(owner: str, name: str, value: Any) -> None:
    _finite(owner, name, value)
    if not value > 0:
        raise ValueError(f"{owner}: {name} is {shown(value)}; must be greater than 0")


@dataclass(frozen=True)
class Normal:
    """A normal distribution.

    Attributes
    ----------
    mean, std
        in the unit of the parameter; `std` is greater than 0

    Raises
    ------
    ValueError
        A number that is not finite, or a `std` that is not positive.
    """

    mean: float
    std: float

    def __post_init__(self) -> None:
        """Refuse what is no normal distribution."""
        _finite("Normal", "mean", self.mean)
        _positive("Normal", "std", self.std)

    def ppf(self, q: Array, /) -> Array:
        """Give the quantiles of shares in (0, 1)."""
        from scipy.special import ndtri

        return np.asarray(self.mean + self.std * ndtri(q))


@dataclass(frozen=True)
class Uniform:
    """A uniform distribution.

    Attributes
    ----------
    low, high
        in the unit of the parameter; `low` is less than `high`

    Raises
    ------
    ValueError
        A bound that is not finite, or bounds that are equal or reversed.
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        """Refuse what is no interval."""
        _finite("Uniform", "low", self.low)
        _finite("Uniform", "high", self.high)
        if not self.low < self.high:
            raise ValueError(
                f"Uniform: low is {self.low!r} and high {self.high!r}; low must be less than high"
            )

    def ppf(self, q: Array, /) -> Array:
        """Give the quantiles of shares in (0, 1)."""
        return np.asarray(self.low + (self.high - self.low) * q)


@dataclass(frozen=True)
class LogNormal:
    """A distribution whose logarithm is normal.

    Attributes
    ----------
    median
        in the unit of the parameter; greater than 0
    sigma
        standard deviation of the natural logarithm; greater than 0

    Raises
    ------
    ValueError
        A number that is not finite or not positive.
    """

    median: float
    sigma: float

    def __post_init__(self) -> None:
        """Refuse what is no such distribution."""
        _positive("LogNormal", "median", self.median)
        _positive("LogNormal", "sigma", self.sigma)

    def ppf(self, q: Array, /) -> Array:
        """Give the quantiles of shares in (0, 1)."""
        from scipy.special import ndtri

        return np.asarray(self.median * np.exp(self.sigma * ndtri(q)))


class Choice:
    """One of some values.

    Attributes
    ----------
    values
        (m,): in the unit of the parameter, at least one
    weights
        (m,): how likely each is, relative to the others; None: all alike

    Raises
    ------
    ValueError
        No value, values that are not finite, or weights that are negative, sum to 0 or are not as
        many.
    """

    def __init__(
        self, values: Sequence[float] | Array, weights: Sequence[float] | Array | None = None
    ) -> None:
        self.values = real_numbers("Choice: values", values)
        if self.values.ndim != 1 or self.values.size == 0:
            raise ValueError(
                f"Choice: values has the shape {self.values.shape}; must have at least one value"
            )
        if not np.isfinite(self.values).all():
            raise ValueError("Choice: values must be finite")
        given = np.ones(self.values.size) if weights is None else weights
        self.weights = real_numbers("Choice: weights", given)
        if self.weights.shape != self.values.shape:
            raise ValueError(
                f"Choice: weights has the shape {self.weights.shape}; must have that of values, "
                f"{self.values.shape}"
            )
        if not (self.weights >= 0).all() or not 0 < self.weights.sum() < np.inf:
            raise ValueError("Choice: weights must not be negative, and not all 0")

    def ppf(self, q: Array, /) -> Array:
        """Give the quantiles of shares in (0, 1), in the order of `values`."""
        ends = np.cumsum(self.weights) / self.weights.sum()
        place = np.searchsorted(ends, q, side="right")
        return np.asarray(self.values[np.minimum(place, self.values.size - 1)])

    def __repr__(self) -> str:
        return f"Choice({self.values.tolist()}, weights={self.weights.tolist()})"
