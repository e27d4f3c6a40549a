"""Smooth curves through or near points: quintic splines, four times differentiable."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]

_DEGREE = 5
#: Solutions of the search for the smoothest curve within a tolerance.
_TOLERANCE_STEPS = 24
#: Weight of the points against the curve's bending, the parameter running over one per point.
_STRONGEST, _WEAKEST = 1e9, 1e-6
#: Weight of |p''|^2 beside |p'''|^2.
_STRAIGHTNESS = 1e-6


@dataclass(frozen=True)
class Curve:
    """A curve p(u), u in [u[0], u[-1]] at its N points, by its spline."""

    u: _Array
    spline: Any  # of SciPy

    def __call__(self, u: _Array, order: int = 0) -> _Array:
        """Return p or a derivative of it, (K, 2)."""
        return np.asarray(self.spline(u, nu=order), dtype=float)


def chord_parameters(points: _Array) -> _Array:
    """Return a parameter (N,) that grows by the distance between neighbours: |p'| is near 1."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _knots(u: _Array) -> _Array:
    """Return knots at the points and half-way between, which leaves room for given tangents."""
    inner = np.sort(np.concatenate([u, 0.5 * (u[1:] + u[:-1])]))
    return np.concatenate([[u[0]] * _DEGREE, inner, [u[-1]] * _DEGREE])


def _derivative_rows(knots: _Array, sites: _Array, order: int) -> Any:
    """Return the sparse matrix (sites, coefficients) of a derivative at places of the curve."""
    from scipy.interpolate import BSpline
    from scipy.sparse import diags_array

    # A spline's derivative is a spline of differences of its coefficients.
    degree = _DEGREE
    count = len(knots) - degree - 1
    reduce: Any = None
    inner = knots
    for _ in range(order):
        size = len(inner) - degree - 1
        scale = degree / (inner[degree + 1 : degree + size] - inner[1:size])
        step = diags_array([-scale, scale], offsets=[0, 1], shape=(size - 1, size)).tocsr()
        reduce = step if reduce is None else step @ reduce
        inner, degree = inner[1:-1], degree - 1
    rows = BSpline.design_matrix(np.asarray(sites), inner, degree)
    assert rows.shape[1] == count - order
    return rows if reduce is None else rows @ reduce


def _roughness(knots: _Array, order: int) -> Any:
    """Return the sparse matrix of the integral of a derivative's square, by Gauss's points."""
    from scipy.sparse import diags_array

    ends = np.unique(knots)
    nodes, weights = np.polynomial.legendre.leggauss(4)
    half = 0.5 * np.diff(ends)
    sites = (0.5 * (ends[1:] + ends[:-1])[:, None] + half[:, None] * nodes).ravel()
    weight = (half[:, None] * weights).ravel()
    rows = _derivative_rows(knots, sites, order)
    return (rows.T @ diags_array(weight) @ rows).tocsc()


def _solve(cost: Any, right: _Array, held: Any, values: _Array) -> _Array:
    """Return the coefficients of least cost under equations: c' cost c / 2 - right' c."""
    from scipy.sparse import bmat
    from scipy.sparse.linalg import splu

    size = cost.shape[0]
    matrix = bmat([[cost, held.T], [held, None]], format="csc")
    both = np.vstack([right, values])
    factors = splu(matrix)
    found = factors.solve(both)
    found += factors.solve(both - matrix @ found)  # one step of refinement
    return np.asarray(found[:size])


def fit_curve(
    points: _Array,
    tangents: _Array | None = None,
    *,
    closed: bool = False,
    tolerance: float = 0.0,
) -> Curve:
    """Return the curve of least integral of |p'''|^2 through points, or within a tolerance of them.

    Parameters
    ----------
    points
        (N, 2) [m], N >= 2, no two neighbours at one place. Of a closed curve the last is the first.
    tangents
        (N, 2), directions of unit length where they are given, nan elsewhere.
    closed
        The end joins the start with all four derivatives.
    tolerance
        How far the curve may pass a point that is not an end [m]; 0: through it.
    """
    from scipy.interpolate import BSpline
    from scipy.sparse import vstack

    u = chord_parameters(points)
    scale = u[-1] / (len(u) - 1)
    u = u / scale  # about one a point, which keeps the matrices' numbers near each other
    knots = _knots(u)
    cost = _roughness(knots, 3)
    cost = cost / cost.diagonal().mean()
    # Two points have parabolas of no third derivative at all between them; the straight is wanted.
    straight = _roughness(knots, 2)
    cost = (cost + _STRAIGHTNESS / straight.diagonal().mean() * straight).tocsc()
    at_points = _derivative_rows(knots, u, 0)
    inner = np.arange(1, len(u) - 1)
    loose = inner if tolerance > 0 else inner[:0]
    fixed = np.setdiff1d(np.arange(len(u)), loose)
    if closed:  # the end is the start by the equations below
        fixed = fixed[fixed != len(u) - 1]
    blocks, values = [at_points[fixed]], [points[fixed]]
    if tangents is not None:
        given = np.flatnonzero(np.isfinite(tangents).all(axis=1))
        if closed:
            given = given[given != len(u) - 1]
        if given.size:
            blocks.append(_derivative_rows(knots, u[given], 1))
            values.append(tangents[given] * scale)
    if closed:
        for order in range(5):
            ends = _derivative_rows(knots, u[[0, -1]], order)
            blocks.append(ends[[0]] - ends[[1]])
            values.append(np.zeros((1, 2)))
    held, wanted = vstack(blocks).tocsr(), np.vstack(values)

    def curve(weight: float) -> Curve:
        matrix, right = cost, np.zeros((cost.shape[0], 2))
        if loose.size:
            near = at_points[loose]
            matrix = (cost + weight * (near.T @ near)).tocsc()
            right = weight * (near.T @ points[loose])
        coefficients = _solve(matrix, right, held, wanted)
        return Curve(u, BSpline(knots, coefficients, _DEGREE))

    if not loose.size:
        return curve(0.0)
    low, high = np.log(_WEAKEST), np.log(_STRONGEST)
    best = curve(float(np.exp(high)))
    for _ in range(_TOLERANCE_STEPS):
        middle = 0.5 * (low + high)
        tried = curve(float(np.exp(middle)))
        off = np.hypot(*(tried(u[loose]) - points[loose]).T).max()
        if off <= tolerance:
            best, high = tried, middle
        else:
            low = middle
    return best
