"""Waypoints cut at the stops into pieces of smooth path, and the turns on the spot between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from nfopidn.trajectories.path import Curve, fit_curve
from nfopidn.trajectories.smoothing import Event
from nfopidn.trajectories.timing import Motion

_Array = NDArray[np.float64]

#: Places of a piece: per point, and in all at least and at most (or four a point, if that is more).
_PLACES_PER_POINT, _LEAST_PLACES, _MOST_PLACES = 40, 200, 4000
_PLACES_OF_A_TURN = 200
#: The most that the tangent turns between two places [rad], where that does not make too many.
_TURN_OF_A_STEP = 0.1
#: Points of Gauss's rule, and intervals a place, of the path's length.
_GAUSS, _FINE = 3, 4
#: A curve that bends within this part of the shorter leg beside it is a corner to stop at.
SHARPEST = 0.05
#: Less than this is not turned on the spot [rad].
_LEAST_TURN = 1e-7


@dataclass
class Points:
    """Waypoints, N, and the legs from each to the next, with the way they are driven."""

    xy: _Array  # (N, 2)
    theta: _Array  # (N,), nan where free
    speed: _Array  # (N,), infinity where free
    dwell: _Array  # (N,) [s]
    reverse: NDArray[np.bool_]  # (N - 1,)
    stop: NDArray[np.bool_]  # (N,), both ends included
    number: NDArray[np.int64]  # (N,) of each in what was given
    #: Ends of pieces whose given heading is turned to on the spot, as (point, side), side 0 where
    #: the piece begins and 1 where it ends.
    on_the_spot: set[tuple[int, int]]
    #: Why each stop is one.
    why: dict[int, str]


def wrap(angle: _Array | float) -> _Array:
    """Return an angle in [-pi, pi)."""
    return np.mod(np.asarray(angle) + np.pi, 2 * np.pi) - np.pi


def legs(points: Points) -> tuple[_Array, _Array]:
    """Return the legs' lengths [m] and the robot's headings along them [rad], each (N - 1,)."""
    step = np.diff(points.xy, axis=0)
    direction = np.arctan2(step[:, 1], step[:, 0]) + np.pi * points.reverse
    return np.hypot(step[:, 0], step[:, 1]), wrap(direction)


def choose_stops(points: Points, corner: float) -> None:
    """Mark where the robot must stop: corners, changes of direction, dwells, headings off the path.

    A stop that the robot passes without a sharp turn gets one heading for both sides, so that it
    need not turn on the spot.
    """
    _, heading = legs(points)
    for k in range(1, len(points.xy) - 1):
        turn = abs(float(wrap(heading[k] - heading[k - 1])))
        changes = points.reverse[k] != points.reverse[k - 1]
        given = points.theta[k]
        if changes:
            why = "change of direction"
        elif points.dwell[k] > 0:
            why = "dwell"
        elif points.speed[k] == 0:
            why = "speed 0"
        elif turn > corner:
            why = f"corner of {turn:.3g} rad"
        elif np.isfinite(given) and _off(given, heading[k - 1 : k + 1]) > corner / 2:
            why = "heading off the path"
        else:
            continue
        points.stop[k] = True
        points.why[k] = why
        if not np.isfinite(given) and turn <= corner:
            middle = heading[k - 1] + 0.5 * wrap(heading[k] - heading[k - 1])
            points.theta[k] = float(wrap(middle))
    for k in map(int, np.flatnonzero(np.isfinite(points.theta) & points.stop)):
        if k > 0 and _off(points.theta[k], heading[k - 1 : k]) > corner / 2:
            points.on_the_spot.add((k, 1))
        if k < len(heading) and _off(points.theta[k], heading[k : k + 1]) > corner / 2:
            points.on_the_spot.add((k, 0))


def _off(given: float, headings: _Array) -> float:
    return float(np.abs(wrap(headings - given)).max())


def _tangents(points: Points, first: int, last: int) -> _Array:
    """Return the directions of travel (K, 2) that the points of a piece give; nan where free."""
    backwards = np.pi if points.reverse[first] else 0.0
    angle = points.theta[first : last + 1] + backwards
    if (first, 0) in points.on_the_spot:
        angle[0] = np.nan
    if (last, 1) in points.on_the_spot:
        angle[-1] = np.nan
    return np.column_stack([np.cos(angle), np.sin(angle)])


@dataclass(frozen=True)
class Piece:
    """A curve between two stops, by its length."""

    curve: Curve
    length: float
    parameter: Callable[[_Array], _Array]  # u of s
    reverse: bool
    #: s at the curve's points.
    at_points: _Array

    @classmethod
    def of(cls, curve: Curve, reverse: bool, places: int) -> Piece:
        """Measure a curve."""
        from scipy.interpolate import CubicHermiteSpline

        count = len(curve.u) - 1
        fine = np.unique(
            np.concatenate([np.linspace(curve.u[0], curve.u[-1], _FINE * places), curve.u])
        )
        nodes, weights = np.polynomial.legendre.leggauss(_GAUSS)
        half = 0.5 * np.diff(fine)
        inner = (0.5 * (fine[1:] + fine[:-1])[:, None] + half[:, None] * nodes).ravel()
        rate = np.hypot(*curve(inner, 1).T).reshape(-1, _GAUSS)
        s = np.concatenate([[0.0], np.cumsum(half * (rate @ weights))])
        slope = np.hypot(*curve(fine, 1).T)
        back = CubicHermiteSpline(s, fine, 1.0 / np.maximum(slope, 1e-9 * slope.max()))
        at_points = s[np.searchsorted(fine, curve.u)]
        assert len(at_points) == count + 1
        return cls(curve, float(s[-1]), back, reverse, at_points)

    def pose(self, s: _Array) -> _Array:
        """Return x, y and heading (K, 3) at places of the curve."""
        u = np.clip(self.parameter(s), self.curve.u[0], self.curve.u[-1])
        p, d = self.curve(u), self.curve(u, 1)
        theta = np.unwrap(np.arctan2(d[:, 1], d[:, 0])) + (np.pi if self.reverse else 0.0)
        return np.column_stack([p, theta])

    def curvature(self, s: _Array) -> tuple[_Array, _Array]:
        """Return the curvature [1/m] of the curve at places and its derivative by length."""
        u = np.clip(self.parameter(s), self.curve.u[0], self.curve.u[-1])
        d1, d2, d3 = (self.curve(u, order).T for order in (1, 2, 3))
        rate = np.hypot(d1[0], d1[1])
        cross = d1[0] * d2[1] - d1[1] * d2[0]
        kappa = cross / rate**3
        change = (d1[0] * d3[1] - d1[1] * d3[0]) / rate**3
        change -= 3.0 * kappa * (d1[0] * d2[0] + d1[1] * d2[1]) / rate**2
        return kappa, change / rate


def _places(points: int, length: float, step: float) -> int:
    most = max(_MOST_PLACES, 4 * points)
    wanted = max(_PLACES_PER_POINT * points, length / step)
    return int(np.clip(wanted, _LEAST_PLACES, most))


def measure(
    curve: Curve, reverse: bool, step: float = np.inf
) -> tuple[Piece, _Array, _Array, _Array]:
    """Return a piece, places equally far apart, the curvature there and its derivative.

    They are no more than `step` [m] apart, unless that makes too many.
    """
    points = len(curve.u) - 1
    chords = float(np.hypot(*np.diff(curve(curve.u), axis=0).T).sum())
    places = _places(points, chords, step)
    while True:
        piece = Piece.of(curve, reverse, places)
        s = np.linspace(0.0, piece.length, places + 1)
        kappa, change = piece.curvature(s)
        bend = float(np.nan_to_num(np.abs(kappa), nan=0.0).max())
        finer = _places(points, chords, min(step, _TURN_OF_A_STEP / max(bend, 1e-9)))
        if finer <= places:
            return piece, s, kappa, change
        places = finer


def event_of_piece(piece: Piece, s: _Array, kappa: _Array, change: _Array, speed: _Array) -> Event:
    """Return the motion along a piece, `speed` being the largest at its points."""
    between = np.full(len(s), np.inf)
    given = np.isfinite(speed) & (speed > 0)
    if given.any():
        known = np.flatnonzero(given)
        for a, b in pairwise(known):
            if b == a + 1:
                here = (s >= piece.at_points[a]) & (s <= piece.at_points[b])
                between[here] = np.interp(s[here], piece.at_points[[a, b]], speed[[a, b]])
        nearest = np.searchsorted(s, piece.at_points[known]).clip(0, len(s) - 1)
        between[nearest] = np.minimum(between[nearest], speed[known])
    # Driving backwards, v = -ds/dt; the tangent turns as ever, and the heading with it.
    drive = np.full(len(s), -1.0 if piece.reverse else 1.0)
    return Event(Motion(s, drive, kappa, change, between), piece.pose)


def event_of_turn(pose: _Array, angle: float) -> Event | None:
    """Return a turn on the spot from a pose (3,); None where there is nothing to turn."""
    if abs(angle) < _LEAST_TURN:
        return None
    s = np.linspace(0.0, abs(angle), _PLACES_OF_A_TURN + 1)
    zero = np.zeros(len(s))
    sign = float(np.copysign(1.0, angle))
    start = pose.copy()

    def at(places: _Array) -> _Array:
        found = np.tile(start, (len(places), 1))
        found[:, 2] += sign * places
        return found

    return Event(Motion(s, zero, np.full(len(s), sign), zero, np.full(len(s), np.inf)), at)


def fit_pieces(
    points: Points, closed: bool, tolerance: float, step: float
) -> list[tuple[int, int, Piece, _Array, _Array, _Array]]:
    """Return each piece with its first and last point, places, curvature and its derivative.

    Where the curve bends sharper than a corner its point becomes a stop, or the tangent that was
    given there is turned to on the spot, until no curve does.
    """
    length, _ = legs(points)
    pending = _stretches(points)
    done = []
    while pending:
        first, last = pending.pop()
        curve = fit_curve(
            points.xy[first : last + 1],
            _tangents(points, first, last),
            closed=closed,
            tolerance=tolerance,
        )
        measured = measure(curve, bool(points.reverse[first]), step)
        piece, s, kappa, _ = measured
        sharp = _sharpest(piece, s, kappa, length[first:last])
        if sharp is None:
            done.append((first, last, *measured))
            continue
        k = first + sharp
        ends = [
            (end, side)
            for end, side in ((first, 0), (last, 1))
            if np.isfinite(points.theta[end]) and (end, side) not in points.on_the_spot
        ]
        if k in (first, last) and last - first > 1 and (k, int(k == last)) not in ends:
            k += 1 if k == first else -1
        if first < k < last:
            points.stop[k] = True
            points.why[k] = "the curve bends too sharply"
            if np.isfinite(points.theta[k]):
                points.on_the_spot |= {(k, 0), (k, 1)}
            pending += [(first, k), (k, last)]
            closed = False
        elif ends:
            # The nearer end's tangent, or the only one.
            points.on_the_spot.add(min(ends, key=lambda one: abs(one[0] - k)))
            pending.append((first, last))
        else:  # a straight line
            done.append((first, last, *measured))
    return sorted(done, key=lambda one: one[0])


def _stretches(points: Points) -> list[tuple[int, int]]:
    stops = [int(k) for k in np.flatnonzero(points.stop)]
    return list(pairwise(stops))


def _sharpest(piece: Piece, s: _Array, kappa: _Array, length: _Array) -> int | None:
    """Return the point of a piece nearest to where its curve bends too sharply, if it does."""
    leg = np.clip(np.searchsorted(piece.at_points, s, side="right") - 1, 0, len(length) - 1)
    before, after = np.maximum(leg - 1, 0), np.minimum(leg + 1, len(length) - 1)
    shorter = np.minimum(length[leg], np.minimum(length[before], length[after]))
    with np.errstate(invalid="ignore"):
        sharpness = np.nan_to_num(np.abs(kappa) * shorter * SHARPEST, nan=np.inf)
    worst = int(np.argmax(sharpness))
    if sharpness[worst] <= 1.0:
        return None
    if len(length) == 1:
        return 0 if worst < len(s) // 2 else 1
    near = int(np.argmin(np.abs(piece.at_points - s[worst])))
    return near
