"""s^order sample by sample."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nfopidn import _core
from nfopidn.arithmetic import in_standard_arithmetic
from nfopidn.fractional import orders as checks
from nfopidn.fractional.discretisation import rule_power, truncated_power
from nfopidn.fractional.errors import PowerOfS, operator_errors, warn_if_far, worded

# Below these the filter's own steps are sooner done than SciPy's convolution by FFT.
_SHORT_SIGNAL: Final = 20_000
_SHORT_MEMORY: Final = 64


class FractionalFilter(PowerOfS):
    """s^order of a sampled signal: ((1 - w)/(1 + pole w))^order times the rule's scale, w = 1/z.

    Up to 192 samples of memory every tap is exact. Beyond, 33 taps are, and the rest of the
    memory runs as decaying modes at constant cost (docs/fractional.md). Of an order beyond 1 in
    size the whole part runs as a recursion, marginally stable at z = -pole or z = 1; memory and
    certificate belong to what is left of the order. Whole orders are the recursion alone.

    Parameters
    ----------
    order
        in (-2, 2)
    dt
        sample time [s]
    memory
        last power M of 1/z, a whole number up to 10,000,000, or math.inf
    method
        the rule: "gl", "al-alaoui" or "tustin". The paper's Tustin has no phase error of its own
        and suits infinite memory, but its weights alternate and decay slowly or, from order 1 on,
        not at all: a finite memory of it is a poor operator, and noise at half the sampling rate is
        amplified without bound
    prewarp
        frequency [rad/s] at which the rule's magnitude is exact; None: at 0
    horizon
        samples over which infinite memory is certified, 1000 to 10,000,000. It fades out beyond:
        ten times as far the sum of the weights of s^-0.9 is off by 1e-6, a hundred times by 0.1. A
        finite memory is good to its end
    check_band
        (low, high) [rad/s], up to pi/dt, where it is to be s^order; None: it is not looked at, and
        `errors` tells

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed.

    Warns
    -----
    UserWarning
        If over `check_band` the filter is not s^order: off by a fifth or by 10 degrees.

    Examples
    --------
    >>> half = FractionalFilter(0.5, dt=0.01, memory=math.inf)
    >>> slope = [half.step(0.01 * k) for k in range(100)]  # of t: 2 sqrt(t/pi)
    """

    def __init__(
        self,
        order: float,
        dt: float,
        memory: float = math.inf,
        method: str = "gl",
        *,
        prewarp: float | None = None,
        horizon: int = 1_000_000,
        check_band: Sequence[float] | None = None,
    ) -> None:
        self._order = checks.order("order", order)
        self._dt = checks.sample_time(dt)
        if not isinstance(method, str) or method not in checks.POLES:
            raise ValueError(f"method is {method!r}; must be one of {', '.join(checks.POLES)}")
        self._method = method
        self._memory = (
            math.inf
            if checks.is_infinite(memory)
            else checks.whole("memory", memory, 0, checks.LONGEST_MEMORY)
        )
        self._horizon = checks.whole("horizon", horizon, 1000, checks.LONGEST_HORIZON)
        self._prewarp = checks.prewarp_frequency(prewarp, self._dt)
        self._filter = _core.SampleFilter(
            self._order,
            checks.POLES[method],
            self._dt,
            self._prewarp,
            self._memory,
            self._horizon,
        )
        if check_band is not None:
            edges = checks.band(check_band, self._dt, "check_band")
            errors = operator_errors(self.response, self._order, edges)
            warn_if_far(self._described(), self._order, edges, errors, 2)

    @property
    def order(self) -> float:
        """The order."""
        return self._order

    @property
    def dt(self) -> float:
        """Sample time [s]."""
        return self._dt

    @property
    def memory(self) -> float:
        """Last power of 1/z [samples], math.inf for all."""
        return self._memory

    @property
    def method(self) -> str:
        """The rule."""
        return self._method

    @property
    def modes(self) -> int:
        """Number of decaying modes; 0 when every tap is exact."""
        return int(self._filter.modes)

    @property
    def certificate(self) -> float:
        """How well the modes make the rule's own kernel; not how near that is to s^order.

        The sum of the impulse response's errors, against the rule's weights, over the sum of the
        weights' sizes. Of a rule that rings or a memory too short for s^order it is small, too:
        `errors` tells how far from s^order the filter is.

        Up to the memory, or the horizon of an infinite one: computed when first asked for, against
        the weights' recursion in long double, which takes about 0.2 s for a million.
        """
        return float(self._filter.certificate)

    @in_standard_arithmetic
    def response(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the frequency response of the rule's kernel, of infinite memory in closed form.

        Parameters
        ----------
        frequency
            [rad/s], any shape

        Returns
        -------
        array
            complex, of the same shape; infinite at a pole, as 0 is of an integral

        Raises
        ------
        ValueError
            For frequencies that are no finite numbers.
        """
        angle = checks.frequency(frequency) * self._dt
        rest = self._filter.rest
        with np.errstate(divide="ignore", invalid="ignore"):
            if math.isinf(self._memory):
                result = rule_power(self._method, self._order, angle)
            else:
                memory = 0 if rest == 0 else int(self._memory)
                result = truncated_power(self._method, rest, angle, memory)
                result = result * rule_power(self._method, self._order - rest, angle)
        finite = np.isfinite(result)
        gain = self._filter.gain
        return np.asarray(np.where(finite, np.where(finite, result, 0) * gain, np.inf))

    def _described(self) -> str:
        return f"{self._method} with a memory of {self._memory:g}"

    def step(self, sample: float) -> float:
        """Return the next output.

        Raises
        ------
        ValueError
            For a sample that is no number in [-1e100, 1e100]; the state is then as before.
        """
        return float(self._filter.step(checks.sample(sample)))

    def stream(self, samples: ArrayLike) -> NDArray[np.float64]:
        """Return the outputs of the next samples, (n,), as step() of each would.

        Raises
        ------
        ValueError
            For samples that are no numbers in [-1e100, 1e100] or not a row; the state is then as
            before.
        """
        return np.asarray(self._filter.process(checks.samples(samples)))

    def filter(self, samples: ArrayLike) -> NDArray[np.float64]:
        """Return the outputs to a whole signal, (n,), from rest; the filter's own state stays.

        Long signals are convolved by FFT: to 1e-14 of the weights' sum times the
        largest sample.

        Raises
        ------
        ValueError
            For samples that are no numbers in [-1e100, 1e100] or not a row.
        """
        row = checks.samples(samples)
        length = row.size if math.isinf(self._memory) else min(row.size, int(self._memory) + 1)
        if self._filter.rest != 0 and row.size >= _SHORT_SIGNAL and length >= _SHORT_MEMORY:
            return self._by_fft(row, length)
        fresh = self.copy()
        fresh.reset()
        return fresh.stream(row)

    def _by_fft(self, row: NDArray[np.float64], length: int) -> NDArray[np.float64]:
        from scipy.signal import oaconvolve

        rest = self._filter.rest
        weights = _core.series_weights(checks.POLES[self._method], rest, length - 1)
        out = oaconvolve(row, weights)[: row.size] * self._filter.gain
        if rest == self._order:
            return np.asarray(out)
        whole = _core.SampleFilter(
            math.copysign(1.0, self._order), checks.POLES[self._method], self._dt, 0.0, 0, 1000
        )
        return np.asarray(whole.process(out)) / whole.gain

    def reset(self) -> None:
        """Forget all samples."""
        self._filter.reset()

    def copy(self) -> FractionalFilter:
        """Return a filter that goes on from the same state."""
        twin = object.__new__(FractionalFilter)
        twin.__dict__.update(self.__dict__)
        twin._filter = self._filter.copy()
        return twin

    __copy__ = copy

    def __str__(self) -> str:
        """Tell what the certificate holds for, and how far from s^order the filter is."""
        low, high = checks.band(None, self._dt)
        reach = self._horizon if math.isinf(self._memory) else int(self._memory)
        return (
            f"{self!r}: the rule's kernel to {self.certificate:.2g} over {reach} samples; as "
            f"s^{self._order:g}, from {low:.3g} to {high:.3g} rad/s, {worded(self.errors())}"
        )

    def __repr__(self) -> str:
        memory = "inf" if math.isinf(self._memory) else str(self._memory)
        return (
            f"FractionalFilter(order={self._order:g}, dt={self._dt:g}, memory={memory}, "
            f"method={self._method!r})"
        )
