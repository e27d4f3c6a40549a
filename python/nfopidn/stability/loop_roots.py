"""The characteristic function of a loop with long filters, and all of its roots at once.

The loop's map has three states for each sample of memory, and its eigenvalues cost the cube of
that. The characteristic function costs a sum over the taps at each place z, and the iteration of
Ehrlich and Aberth brings all roots to their places in some ten sweeps.
"""

from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_EPSILON = float(np.finfo(float).eps)
#: Weights of alternating signs, as Tustin's, throw roots far inside: those take hundreds to return.
_MOST_SWEEPS = 1000
#: Of a product: few enough that linear algebra libraries do not share it out among threads.
_COLUMNS = 16
#: Relative size of a step under which a root has arrived, or has if its steps no longer shrink.
_ARRIVED, _SLOW = 1e-14, 1e-5


def power_sums(taps: Array, w: Complex) -> Complex:
    """Return sum_j taps[i, j] w^j, (rows, N).

    In blocks of about sqrt(count) taps: a block is a product with the same few powers of w, and the
    blocks are the coefficients of a polynomial in w^block.
    """
    rows, count = taps.shape
    block = max(1, int(np.sqrt(count)))
    blocks = -(-count // block)
    padded = np.zeros((rows, blocks * block))
    padded[:, :count] = taps
    table = padded.reshape(rows * blocks, block)
    powers = np.empty((block, w.size), dtype=np.complex128)
    powers[0] = 1
    for j in range(1, block):
        powers[j] = powers[j - 1] * w
    parts = np.empty((rows, blocks, w.size), dtype=np.complex128)
    for first in range(0, w.size, _COLUMNS):
        some = slice(first, first + _COLUMNS)
        # Real and imaginary parts side by side: as complex numbers the taps would cost twice.
        columns = np.ascontiguousarray(powers[:, some]).view(float)
        parts[:, :, some] = (table @ columns).view(np.complex128).reshape(rows, blocks, -1)
    step = powers[-1] * w
    total = parts[:, -1].copy()
    for j in range(blocks - 2, -1, -1):
        total *= step
        total += parts[:, j]
    return total


def resolvent(state: Array, torque: Array, errors: Array) -> tuple[Array, Array]:
    """Return det(y - A) and errors adj(y - A) torque with A = state - 1 and y = z - 1.

    Polynomials in y, lowest power first, (n + 1,) and (3, 2, n). The robot's own poles are at or
    near z = 1, where sums of powers of z would cancel. By Leverrier's recursion.
    """
    size = len(state)
    shifted = state - np.eye(size)
    determinant = np.zeros(size + 1)
    determinant[size] = 1
    adjugate = np.eye(size)
    motion = np.zeros((len(errors), torque.shape[1], size))
    for power in range(size - 1, -1, -1):
        motion[:, :, power] = errors @ adjugate @ torque
        turned = shifted @ adjugate
        determinant[power] = -np.trace(turned) / (size - power)
        adjugate = turned + determinant[power] * np.eye(size)
    return determinant, motion


@dataclass(frozen=True)
class Characteristic:
    """d(y) + z^lead sum_i t_i(y) F_i(z) + z^(2 lead) sum_{i<j} u_ij(y) F_i(z) F_j(z), y = z - 1.

    F_i are the filters of the errors x, y, theta; d, t, u are polynomials of the robot's motion and
    the allocation. Where the torques are summed up, the whole is multiplied by y^2.

    Attributes
    ----------
    taps
        (3, n) of the filters
    alone, single, pairs
        d, the three t_i, and u_ij by (i, j); lowest power first
    lead
        1 where the torques are summed up, less the delay [samples]
    """

    taps: Array
    alone: Array
    single: list[Array]
    pairs: dict[tuple[int, int], Array]
    lead: int

    @classmethod
    def of_loop(
        cls,
        robot: tuple[Array, Array],
        allocation: Array,
        taps: Array,
        *,
        sums: bool,
        delay: int,
    ) -> "Characteristic":
        """Return it for a robot's resolvent() and torques allocation F(z) errors."""
        alone, motion = robot
        # det(d - law M) of 2 x 2: its linear part is a trace, the rest a sum over pairs of minors.
        single = [-(allocation[:, i] @ motion[i]) for i in range(3)]
        pairs = {}
        for i, j in combinations(range(3), 2):
            plus = polynomial.polymul(motion[i, 0], motion[j, 1])
            minus = polynomial.polymul(motion[i, 1], motion[j, 0])
            minor = polynomial.polysub(plus, minus)
            noise = 32 * _EPSILON * max(np.abs(plus).max(), np.abs(minus).max())
            # Minors of an adjugate are multiples of the determinant (Jacobi).
            quotient, _ = polynomial.polydiv(np.where(np.abs(minor) > noise, minor, 0.0), alone)
            pairs[i, j] = quotient * np.linalg.det(allocation[:, [i, j]])
        if sums:
            single = [np.append(0.0, row) for row in single]
            alone = np.append([0.0, 0.0], alone)
        return cls(taps, alone, single, pairs, int(sums) - delay)

    def coefficients(self) -> tuple[Array, int]:
        """Return a polynomial in z, highest power first, and how many roots at 0 it is without.

        Multiplied by z^(2 (n - 1 - lead)) the function is one, or with z^(2 (n - 1)) if the lead is
        positive.
        """
        past, late = self.taps.shape[1] - 1, max(-self.lead, 0)
        early = max(self.lead, 0)
        terms = [(self.alone, np.ones(1), 2 * past + 2 * late)]
        terms += [
            (row, taps, past + late + early)
            for row, taps in zip(self.single, self.taps, strict=True)
        ]
        terms += [
            (row, np.convolve(self.taps[i], self.taps[j]), 2 * early)
            for (i, j), row in self.pairs.items()
        ]
        length = len(self.alone) + 2 * past + 2 * late
        result, sizes = np.zeros(length), np.zeros(length)
        for row, taps, zeros in terms:
            in_z = _shifted(row)[::-1]
            both = np.append(np.convolve(in_z, taps), np.zeros(zeros))
            result[length - len(both) :] += both
            sizes[length - len(both) :] += np.append(
                np.convolve(np.abs(in_z), np.abs(taps)), np.zeros(zeros)
            )
        significant = np.flatnonzero(np.abs(result) > 64 * _EPSILON * sizes)
        end = int(significant[-1]) + 1
        return result[:end], length - end

    def log_derivative(self, z: Complex, at_zero: int) -> Complex:
        """Return P'(z)/P(z) of the polynomial of coefficients()."""
        result = np.empty(z.size, dtype=np.complex128)
        outside = np.abs(z) >= 1
        for part, backwards in ((outside, False), (~outside, True)):
            if part.any():
                result[part] = self._log_derivative(z[part], backwards)
        return result + (2 * max(-self.lead, 0) - at_zero) / z

    def _log_derivative(self, z: Complex, backwards: bool) -> Complex:
        """Return it without the poles at 0; backwards in powers of z instead of 1/z."""
        past = self.taps.shape[1] - 1
        ages = np.arange(past + 1)
        w = 1 / z
        if backwards:
            taps = self.taps[:, ::-1]
            sums = power_sums(np.vstack([taps, taps * ages]), z)
            filters, slopes = sums[:3], sums[3:] * w
            scale, scale_slope = z**past, past * z ** (past - 1)
        else:
            sums = power_sums(np.vstack([self.taps, self.taps * ages]), w)
            filters, slopes = sums[:3], -sums[3:] * w
            scale, scale_slope = np.ones_like(z), np.zeros_like(z)
        factor = z ** float(self.lead)
        filters, slopes = filters * factor, (slopes + self.lead * w * filters) * factor
        y = z - 1

        def term(row: Array, product: Complex, slope: Complex) -> tuple[Complex, Complex]:
            value = polynomial.polyval(y, row)
            derivative = polynomial.polyval(y, polynomial.polyder(row))
            return value * product, derivative * product + value * slope

        parts = [term(self.alone, scale**2, 2 * scale * scale_slope)]
        for i, row in enumerate(self.single):
            slope = slopes[i] * scale + filters[i] * scale_slope
            parts.append(term(row, filters[i] * scale, slope))
        for (i, j), row in self.pairs.items():
            slope = slopes[i] * filters[j] + filters[i] * slopes[j]
            parts.append(term(row, filters[i] * filters[j], slope))
        total = sum(part[0] for part in parts)
        change = sum(part[1] for part in parts)
        result = np.asarray(change / total, dtype=np.complex128)
        return result if backwards else result + 2 * past * w

    def roots(self) -> Complex | None:
        """Return all roots, or None if some have not arrived."""
        coefficients, at_zero = self.coefficients()
        z = _first_places(coefficients)
        before = np.full(z.size, np.inf)
        moving = np.arange(z.size)
        for _ in range(_MOST_SWEEPS):
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                step = 1 / (self.log_derivative(z[moving], at_zero) - _repulsion(z, moving))
            # At a root itself the derivative's quotient is infinite or no number.
            step[~np.isfinite(step)] = 0
            z[moving] -= step
            size = np.abs(step) / np.abs(z[moving])
            there = (size <= _ARRIVED) | ((size < _SLOW) & (size > 0.9 * before[moving]))
            before[moving] = size
            moving = moving[~there]
            if not moving.size:
                break
        if np.any(before > _SLOW):
            return None
        z[np.abs(z.imag) <= 8 * _EPSILON * np.abs(z)].imag = 0
        return np.append(z, np.zeros(at_zero, dtype=np.complex128))


def _shifted(row: Array) -> Array:
    """Return the powers of z of a polynomial in z - 1, lowest first; 0 where nothing but noise."""

    def with_root(root: float, coefficients: Array) -> Array:
        result = np.zeros(len(row))
        for coefficient in coefficients[::-1]:
            result = np.append(0.0, result[:-1]) - root * result
            result[0] += coefficient
        return result

    result = with_root(1.0, row)
    sizes = with_root(-1.0, np.abs(row))
    return np.where(np.abs(result) > 16 * _EPSILON * sizes, result, 0.0)


def _first_places(coefficients: Array) -> Complex:
    """Return where roots are looked for first: on circles by the coefficients (Bini 1996)."""
    degree = len(coefficients) - 1
    with np.errstate(divide="ignore"):
        heights = np.log(np.abs(coefficients[::-1]))
    corners: list[int] = []
    for k in np.flatnonzero(np.isfinite(heights)):
        while len(corners) > 1 and (heights[corners[-1]] - heights[corners[-2]]) * (
            k - corners[-2]
        ) <= (heights[k] - heights[corners[-2]]) * (corners[-1] - corners[-2]):
            corners.pop()
        corners.append(int(k))
    places = []
    for low, high in pairwise(corners):
        count = high - low
        radius = np.exp((heights[low] - heights[high]) / count)
        # An angle that no root has for symmetry's sake.
        angles = 2 * np.pi * (np.arange(count) / count + low / degree) + 0.7
        places.append(radius * np.exp(1j * angles))
    return np.concatenate(places)


def _repulsion(z: Complex, moving: NDArray[np.intp]) -> Complex:
    """Return sum_{j != i} 1 / (z_i - z_j) for the moving i; in rows that stay in the cache."""
    result = np.empty(moving.size, dtype=np.complex128)
    rows = 32
    for first in range(0, moving.size, rows):
        own = moving[first : first + rows]
        across = z.real[own, None] - z.real
        along = z.imag[own, None] - z.imag
        squares = across * across + along * along
        squares[np.arange(own.size), own] = np.inf
        inverse = 1 / squares
        result[first : first + rows] = np.einsum("ij,ij->i", across, inverse) - 1j * np.einsum(
            "ij,ij->i", along, inverse
        )
    return result
