"""Output error: the parameters and first states with which simulated poses meet measured ones.

The parameters are those of all windows, the first state is each window's own. Levenberg-Marquardt
steps solve the normal equations with the first states eliminated window by window (Gauss-Newton on
an arrow matrix), so that the work is in proportion to the log's length.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from nfopidn.identification.windows import Window

Array = NDArray[np.float64]

#: Values of the free parameters, commands (n, 2) of the cells, speeds v and omega at the start ->
#: x, y, theta, v, omega (n + 1, 5) at the nodes, from the pose 0.
Simulator = Callable[[Array, Array, Array], Array]
#: R and right side of a window's first state, by the parameters, and which of its numbers matter.
_Inner = tuple[Array, Array, Array, NDArray[np.bool_]]
HUBER = 3.0  # standard deviations beyond which a residual counts by its size, not its square
_STEP = 1e-4  # of central differences, of a parameter's scale
_MOST_STEPS = 40
_LEAST_GAIN = 1e-3  # of half a sum of squares of standard deviations
_MOST_SLOW = 3  # steps that gain next to nothing


@dataclass(frozen=True)
class Problem:
    """What is fitted to what.

    Attributes
    ----------
    simulate
        the model.
    dt
        length of a cell [s].
    t, pose
        the log's poses.
    windows, cells
        the windows, and (n, 2) commands of the cells of each.
    noise
        standard deviations of position [m] and heading [rad].
    low
        (q,) least values of the parameters; one that is positive makes its parameter logarithmic.
    scale
        (q,) typical values of the parameters.
    robust
        whether residuals beyond HUBER standard deviations count by their size.
    """

    simulate: Simulator
    dt: float
    pose: Array
    windows: Sequence[Window]
    cells: Sequence[Array]
    noise: tuple[float, float]
    low: Array
    scale: Array
    robust: bool = True

    def only(self, places: Sequence[int]) -> Problem:
        """Return the problem of some of the windows."""
        return replace(
            self,
            windows=[self.windows[i] for i in places],
            cells=[self.cells[i] for i in places],
        )


@dataclass(frozen=True)
class Fit:
    """Where the steps ended.

    Attributes
    ----------
    values
        (q,) parameters.
    states
        (windows, 5) first states.
    cost
        half the sum of squares, of large residuals less.
    jacobian
        (q, q) R of the residuals' Jacobian by relative changes of the parameters (by `scale` where
        they are not logarithmic), the first states eliminated.
    residuals
        (n, 3) of each window [m, m, rad], measured less simulated.
    """

    values: Array
    states: Array
    cost: float
    jacobian: Array
    residuals: list[Array] = field(default_factory=list)


def simulated(problem: Problem, i: int, values: Array, state: Array) -> Array:
    """Return the poses (n, 3) of a window's rows."""
    return _placed(_local(problem, i, values, state[3:]), state)


def fit(problem: Problem, values: Array, states: Array, most: int = _MOST_STEPS) -> Fit:
    """Minimise from `values` (q,) and `states` (windows, 5)."""
    damping, slow = 1e-3, 0
    cost = _cost(problem, values, states)
    system = _System(problem, values, states)
    for _ in range(most):
        moved_values, moved_states = system.step(damping)
        moved_cost = _cost(problem, moved_values, moved_states)
        if np.isfinite(moved_cost) and moved_cost <= cost:
            gained = cost - moved_cost
            values, states, cost = moved_values, moved_states, moved_cost
            system = _System(problem, values, states)
            damping = max(damping * 0.2, 1e-9)
            slow = slow + 1 if gained <= 1e-6 * (1 + cost) else 0
            # A damped step may gain little where an undamped one would more.
            if slow and (system.expected <= _LEAST_GAIN or slow >= _MOST_SLOW):
                break
        else:
            damping *= 8
            if damping > 1e8:
                break
    residuals = [
        problem.pose[window.rows] - simulated(problem, i, values, states[i])
        for i, window in enumerate(problem.windows)
    ]
    return Fit(values, states, cost, system.triangle, residuals)


def fit_states(problem: Problem, values: Array, states: Array) -> Fit:
    """Minimise over the first states alone."""
    none = np.zeros(0)
    fixed = replace(problem, simulate=_Fixed(problem.simulate, values), low=none, scale=none)
    found = fit(fixed, none, states)
    return replace(found, values=values)


@dataclass(frozen=True)
class _Fixed:
    """A model with given parameters."""

    simulate: Simulator
    values: Array

    def __call__(self, _: Array, cells: Array, speed: Array) -> Array:
        return self.simulate(self.values, cells, speed)


def _local(problem: Problem, i: int, values: Array, speed: Array) -> Array:
    """Return the poses of a window's rows in the frame of its first: cubics between the nodes."""
    window = problem.windows[i]
    nodes = problem.simulate(values, problem.cells[i], speed)
    pose, v, theta = nodes[:, :3], nodes[:, 3], nodes[:, 2]
    rate = np.column_stack([v * np.cos(theta), v * np.sin(theta), nodes[:, 4]]) * problem.dt
    s = window.place[:, None]
    a = window.cell
    b = a + 1
    keep = (1 + 2 * s) * (1 - s) ** 2
    result: Array = (
        keep * pose[a]
        + (1 - keep) * pose[b]
        + s * (1 - s) ** 2 * rate[a]
        - s**2 * (1 - s) * rate[b]
    )
    return result


def _placed(local: Array, state: Array) -> Array:
    c, s = np.cos(state[2]), np.sin(state[2])
    x, y, theta = local.T
    return np.column_stack([state[0] + c * x - s * y, state[1] + s * x + c * y, state[2] + theta])


def _weights(problem: Problem, residual: Array) -> Array:
    """Return the roots of the weights by which squares become Huber's loss (n, 3)."""
    if not problem.robust:
        return np.ones_like(residual)
    weights: Array = np.sqrt(np.minimum(1.0, HUBER / np.maximum(np.abs(residual), 1e-300)))
    return weights


def _deviations(problem: Problem) -> Array:
    return np.array([problem.noise[0], problem.noise[0], problem.noise[1]])


def _cost(problem: Problem, values: Array, states: Array) -> float:
    total = 0.0
    for i, window in enumerate(problem.windows):
        error = problem.pose[window.rows] - simulated(problem, i, values, states[i])
        size = np.abs(error / _deviations(problem))
        square = 0.5 * size**2
        if problem.robust:
            square = np.where(size <= HUBER, square, HUBER * (size - 0.5 * HUBER))
        total += float(square.sum())
    return total


def _shifted(problem: Problem, values: Array, place: int, by: float) -> Array:
    moved = values.copy()
    if problem.low[place] > 0:
        moved[place] *= np.exp(by)
    else:
        moved[place] += by * problem.scale[place]
    return moved


def _triangle(matrix: Array) -> Array:
    """Return R of the QR decomposition."""
    return np.asarray(np.linalg.qr(matrix, mode="r"), dtype=float)


class _System:
    """Residuals and Jacobian at a point, the first states of the windows eliminated."""

    def __init__(self, problem: Problem, values: Array, states: Array) -> None:
        self._problem, self._values, self._states = problem, values, states
        self._parts = [self._window(i) for i in range(len(problem.windows))]
        self.triangle, self._right, inner = self._eliminated(0.0)
        self.expected = 0.5 * float(self._right @ self._right)
        self.expected += 0.5 * sum(float(right @ right) for _, right, _, _ in inner)

    def _eliminated(self, damping: float) -> tuple[Array, Array, list[_Inner]]:
        """Return R and right side of the parameters, and what gives each window's first state."""
        count = len(self._values)
        inner: list[_Inner] = []
        rows: list[Array] = []
        for residual, of_values, of_state in self._parts:
            both = np.column_stack([of_values, residual])
            size = np.linalg.norm(of_state, axis=0)
            seen = size > 0  # a model of odometry has no first speeds
            matrix = of_state[:, seen]
            if damping > 0:
                matrix = np.vstack([matrix, np.sqrt(damping) * np.diag(size[seen])])
                both = np.vstack([both, np.zeros((int(seen.sum()), count + 1))])
            q, r = np.linalg.qr(matrix)
            inside = q.T @ both
            inner.append((r, inside[:, count], inside[:, :count], seen))
            rows.append(_triangle(both - q @ inside))
        stacked = _triangle(np.vstack(rows))
        return stacked[:count, :count], stacked[:count, count], inner

    def _window(self, i: int) -> tuple[Array, Array, Array]:
        """Return weighted residuals (3 n,) and their derivatives by values and first state."""
        problem, values, state = self._problem, self._values, self._states[i]
        local = _local(problem, i, values, state[3:])
        placed = _placed(local, state)
        error = (problem.pose[problem.windows[i].rows] - placed) / _deviations(problem)
        weight = _weights(problem, error) / _deviations(problem)
        turned = np.zeros((*placed.shape, 5))  # of poses by the first state
        turned[:, 0, 0] = turned[:, 1, 1] = turned[:, 2, 2] = 1
        turned[:, 0, 2] = -(placed[:, 1] - state[1])
        turned[:, 1, 2] = placed[:, 0] - state[0]
        for k in (3, 4):
            changed = [state[3:].copy() for _ in range(2)]
            changed[0][k - 3] += _STEP
            changed[1][k - 3] -= _STEP
            turned[:, :, k] = self._difference(i, [values, values], changed)
        by_values = np.zeros((*placed.shape, len(values)))
        for k in range(len(values)):
            pair = [_shifted(problem, values, k, sign * _STEP) for sign in (1, -1)]
            by_values[:, :, k] = self._difference(i, pair, [state[3:], state[3:]])
        size = placed.size
        return (
            (error * _weights(problem, error)).reshape(size),
            -(weight[:, :, None] * by_values).reshape(size, -1),
            -(weight[:, :, None] * turned).reshape(size, -1),
        )

    def _difference(self, i: int, values: Sequence[Array], speeds: Sequence[Array]) -> Array:
        state = self._states[i]
        ends = [
            _placed(_local(self._problem, i, v, s), state)
            for v, s in zip(values, speeds, strict=True)
        ]
        difference: Array = (ends[0] - ends[1]) / (2 * _STEP)
        return difference

    def step(self, damping: float) -> tuple[Array, Array]:
        """Return the damped step's parameters and states."""
        problem, count = self._problem, len(self._values)
        triangle, right, inner = self._eliminated(damping)
        move = self._move(triangle, right, damping, np.ones(count, dtype=bool))
        outward = (self._values <= problem.low) & (move < 0)
        if outward.any():
            move = self._move(triangle, right, damping, ~outward)
        values = self._values.copy()
        for k in range(count):
            if problem.low[k] > 0:
                move[k] = np.clip(move[k], -1.0, 1.0)
                values[k] = max(values[k] * np.exp(move[k]), problem.low[k])
            else:
                values[k] = max(values[k] + move[k] * problem.scale[k], problem.low[k])
                move[k] = (values[k] - self._values[k]) / problem.scale[k]
        states = self._states.copy()
        for i, (r, right_of_state, by_values, seen) in enumerate(inner):
            moved = np.linalg.lstsq(r, right_of_state + by_values @ move, rcond=None)[0]
            states[i, seen] -= moved
        return values, states

    def _move(
        self, triangle: Array, right: Array, damping: float, free: NDArray[np.bool_]
    ) -> Array:
        """Return the damped step of the parameters that may move."""
        move = np.zeros(len(self._values))
        if free.any():
            size = np.linalg.norm(triangle[:, free], axis=0)
            size = np.where(size > 0, size, 1.0)
            matrix = np.vstack([triangle[:, free], np.sqrt(damping) * np.diag(size)])
            both = np.concatenate([-right, np.zeros(len(size))])
            move[free] = np.linalg.lstsq(matrix, both, rcond=None)[0]
        return move
