"""Whether residuals are white: what a model leaves that it should not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LAGS = 20
CHANNELS = ("x", "y", "theta")
OUTLIER = 6.0  # standard deviations
_WITHIN_THREE = 0.98658  # deviation of a standard normal's part within three


@dataclass(frozen=True)
class Whiteness:
    """Correlations of the residuals of a channel with themselves, later.

    Attributes
    ----------
    correlations
        (lags,) at 1, 2, ... rows.
    bound
        half width of the 95 % interval of a white sequence's.
    p_value
        of the test by Ljung and Box: how often white residuals would be correlated as much.
    """

    correlations: Array
    bound: float
    p_value: float

    @property
    def white(self) -> bool:
        """Whether no dependence shows at 1 %."""
        return self.p_value >= 0.01

    @property
    def strongest(self) -> int:
        """Lag of the largest correlation [rows]."""
        return int(np.argmax(np.abs(self.correlations))) + 1


def whiteness(residuals: Sequence[Array], estimated: float = 0.0) -> Whiteness:
    """Test the residuals of a channel: sequences (n,), each of its own window.

    The windows' own first states, `estimated` numbers of the channel in each, take something out of
    the residuals, which correlates them a little, negatively; that is allowed for.
    """
    from scipy.stats import chi2

    lags = max(1, min(LAGS, min(len(r) for r in residuals) // 2))
    centred = [
        np.clip(r, *(np.array([-1, 1]) * OUTLIER * _deviation(residuals))) for r in residuals
    ]
    power = sum(float(r @ r) for r in centred)
    count = sum(len(r) for r in centred)
    if power <= 0:
        return Whiteness(np.zeros(lags), 0.0, 1.0)
    found = np.array([sum(float(r[k:] @ r[:-k]) for r in centred) for k in range(1, lags + 1)])
    correlations = found / power
    # An estimate of `estimated` numbers from n rows leaves correlations of about -estimated / n.
    usual = estimated * len(residuals) / count
    pairs = np.array([sum(len(r) - k for r in centred) for k in range(1, lags + 1)])
    allowed = correlations + usual * pairs / count
    statistic = float(np.sum(allowed**2 * count**2 / np.maximum(pairs, 1)))
    return Whiteness(correlations, 1.96 / np.sqrt(count) + usual, float(chi2.sf(statistic, lags)))


def _deviation(residuals: Sequence[Array]) -> float:
    """Return the standard deviation, of the middle half."""
    return max(1.4826 * float(np.median(np.abs(np.concatenate(residuals)))), 1e-12)


def noise_of(residuals: Sequence[Array], estimated: float) -> tuple[float, float]:
    """Return standard deviations of position [m] and heading [rad] of residuals (n, 3).

    Rows within three deviations tell them, first counted from the median, so that outliers do not;
    `estimated` numbers were taken out of all.
    """
    rows = np.concatenate(residuals)
    freedom = np.sqrt(max(1 - estimated / rows.size, 0.1))
    return _inner(rows[:, :2]) / freedom, _inner(rows[:, 2]) / freedom


def _inner(values: Array) -> float:
    """Return the standard deviation of a normal distribution by its part within three of them."""
    size = np.abs(values)
    # Where more than half are alike, as those of coarse counters, the median tells nothing.
    deviation = max(1.4826 * float(np.median(size)), 0.2 * float(np.percentile(size, 99)), 1e-9)
    inner = size[size <= 3 * deviation]
    return max(float(np.sqrt(np.mean(inner**2))) / _WITHIN_THREE, 1e-6)
