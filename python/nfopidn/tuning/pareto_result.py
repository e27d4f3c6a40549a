"""What a search over several objectives finds: a Pareto front, and its file."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

import numpy as np

from nfopidn import _core
from nfopidn._core import Controller, Rival
from nfopidn.arguments import real_numbers, shown, whole_number
from nfopidn.arithmetic import in_standard_arithmetic
from nfopidn.files import replace_file
from nfopidn.robustness.verdict import Verdict
from nfopidn.search.optimise import HISTORY, MOST_LINES, Array, OptimizeResult, active_mask
from nfopidn.tuning.result import (
    TuneResult,
    check_names,
    family_in,
    family_rows,
    plain,
    scenario_list,
    scenarios_in,
)

PARETO_FORMAT = "nfopidn-pareto-front"
PARETO_VERSION = 1

#: Columns of the history, a row a generation.
FRONT_HISTORY = ("nfev", "points", "hypervolume")

_FIELDS = (
    *("objective_names", "parameters", "nfev", "nit", "seed", "message", "success", "status"),
    *("elapsed", "structure", "options", "method", "population", "reference_point"),
)


class ParetoResult(OptimizeResult):
    """The result of tune(objectives=...): controllers, none of which is better than another in all.

    Fields, as attributes and as keys: `objective_names` (m), `objectives` (n, m), in the order of
    the first objective, `controllers` (n), `x` (n, p) and `bounds` (p, 2) of the free parameters,
    which `parameters` names, `history` (a structured array, a row a generation: nfev, points of the
    front, hypervolume), `reference_point` (m,) of the hypervolume, seed, method, population, nfev,
    nit, success, status, message, elapsed [s], `scenario`, and `family`, if the search was robust.
    The hypervolume is the share of the box between the front's best values and `reference_point`
    that the front dominates, a tenth beyond its worst ones.
    """

    def __len__(self) -> int:
        """Give the number of points on the front."""
        return len(self["controllers"]) if "controllers" in self else 0

    def __bool__(self) -> bool:
        """Be true even of an empty front, as an object is."""
        return True

    def __repr__(self) -> str:
        """Tell how many points there are and how they were reached."""
        if "objectives" not in self or "nfev" not in self:
            return f"{type(self).__name__}({dict(self)})"
        names = ", ".join(self["objective_names"])
        return f"{type(self).__name__}({len(self)} points of {names}, nfev={self['nfev']})"

    @in_standard_arithmetic
    def __str__(self) -> str:
        """Give the front as a table, with the knee marked."""
        if not {"objectives", "message", "elapsed"} <= set(self):
            return repr(self)
        head = f"{type(self).__name__}: {self['message']}"
        head += f" {len(self)} points after {self['nfev']} evaluations, {self['elapsed']:.2f} s"
        if len(self) == 0:
            return head
        knee = self.choose()
        titles = [self._title(name) for name in self["objective_names"]]
        widths = [max(len(title), 12) for title in titles]
        lines = ["     " + "  ".join(f"{t:>{w}}" for t, w in zip(titles, widths, strict=True))]
        for place, row in enumerate(self["objectives"][:MOST_LINES]):
            cells = "  ".join(f"{v:{w}.6g}" for v, w in zip(row, widths, strict=True))
            lines.append(f"{place:4} {cells}" + ("  (knee)" if place == knee else ""))
        if len(self) > MOST_LINES:
            lines.append(f" ... and {len(self) - MOST_LINES} more; the knee is point {knee}")
        return "\n".join([head, *lines])

    def _title(self, name: str) -> str:
        unit = objective_unit(name)
        return f"{name} [{unit}]" if unit else name

    def _shares(self) -> Array:
        """(n, m): 0 is the best value of an objective on the front, 1 the worst."""
        if len(self) == 0:
            raise ValueError("the front is empty; there is no point to choose")
        rows = np.asarray(self["objectives"])
        low, high = rows.min(axis=0), rows.max(axis=0)
        return np.asarray((rows - low) / np.where(high > low, high - low, 1.0))

    @in_standard_arithmetic
    def choose(self, by: str | Mapping[str, float] | Sequence[float] = "knee") -> int:
        """Give the place on the front of one point.

        Parameters
        ----------
        by
            "knee": the point farthest under the hyperplane through the points that are best in one
            objective each (I. Das, On characterizing the "knee" of the Pareto curve, Structural
            Optimization 18, 1999), where a little of one objective costs much of another. Or
            weights, in the order of the objectives or by name (others 0): the point with the least
            weighted sum, each objective counted from 0 at its best to 1 at its worst on the front.

        Raises
        ------
        ValueError
            Another word, a name that is no objective, weights that are negative or all 0, or an
            empty front.
        """
        shares = self._shares()
        if isinstance(by, str):
            if by != "knee":
                raise ValueError(f"by is {shown(by)}; must be 'knee' or weights")
            return int(np.argmin(shares @ _knee_direction(shares)))
        names = self["objective_names"]
        if isinstance(by, Mapping):
            for name in by:
                if name not in names:
                    raise ValueError(f"by names {name!r}; must be of {', '.join(names)}")
            by = [by.get(name, 0.0) for name in names]
        weights = real_numbers("by", by)
        if weights.shape != (len(names),):
            raise ValueError(f"by has the shape {weights.shape}; must have {len(names)} weights")
        if not np.isfinite(weights).all() or (weights < 0).any() or not weights.any():
            raise ValueError(f"by is {weights.tolist()}; weights must be 0 or more, and not all 0")
        return int(np.argmin(shares @ weights))

    def at(self, place: int) -> TuneResult:
        """Give one point as a TuneResult, whose `fun` is its first objective.

        Raises
        ------
        ValueError
            No such place.
        """
        whole_number("place", place, 0, len(self) - 1)
        x = np.array(self["x"][place])
        low, high = np.asarray(self["bounds"]).T
        fields = (
            *("parameters", "seed", "structure", "options", "nfev", "nit", "elapsed"),
            *("scenario", "success", "status"),
        )
        result = TuneResult({name: self[name] for name in fields})
        if "family" in self:
            result["family"] = self["family"]
        result.update(
            x=x,
            fun=float(self["objectives"][place, 0]),
            controller=self["controllers"][place],
            method=self["method"],
            message=f"Point {place} of a Pareto front.",
            active_mask=active_mask(x, low, high),
            population=x[None, :],
            population_energies=np.array([self["objectives"][place, 0]]),
            history=np.zeros(0, dtype=[(name, float) for name in HISTORY]),
        )
        return result

    def verdict(self, place: int) -> Verdict:
        """Judge the controller at a place of the front, as TuneResult.verdict does.

        Raises
        ------
        ValueError
            No such place, or a reference that never moves.
        """
        known: dict[int, Verdict] = self.__dict__.setdefault("_verdicts", {})
        if place not in known:
            known[place] = self.at(place).verdict
        return known[place]

    def plot(self, ax: Any = None) -> Any:
        """Draw the front; returns the Axes, of more than two objectives an array of them."""
        from nfopidn import plot

        return plot.pareto_front(self, ax)

    def to_csv(self, path: str | PathLike[str]) -> None:
        """Write a row a point: its objectives and its parameters."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([*self["objective_names"], *self["parameters"]])
        for row, x in zip(self["objectives"], self["x"], strict=True):
            writer.writerow([repr(float(value)) for value in (*row, *x)])
        replace_file(path, text.getvalue())

    def to_json(self, path: str | PathLike[str]) -> None:
        """Write the result; each of `controllers` in it is a controller document of its own."""
        fields: dict[str, Any] = dict(self)
        fields["history"] = [list(row) for row in self["history"].tolist()]
        fields["controllers"] = [json.loads(one.to_json()) for one in self["controllers"]]
        fields["scenario"] = [json.loads(one.to_json()) for one in scenario_list(self.scenario)]
        if "family" in fields:
            fields["family"] = family_rows(self["family"])
        document = {"format": PARETO_FORMAT, "version": PARETO_VERSION, **plain(fields)}
        replace_file(path, json.dumps(document, indent=1, allow_nan=False) + "\n")

    @classmethod
    def from_json(cls, path: str | PathLike[str]) -> ParetoResult:
        """Read what to_json() has written.

        Raises
        ------
        ValueError
            Names the file, and what in it is not as it must be.
        """
        try:
            return cls(_fields_in(json.loads(_core.read_text(path))))
        except (
            *(ValueError, TypeError, LookupError, AttributeError, ArithmeticError),
            RecursionError,
        ) as error:
            raise ValueError(f"{path}: not a Pareto front: {error}") from None


def _fields_in(fields: dict[str, Any]) -> dict[str, Any]:
    if fields.pop("format") != PARETO_FORMAT or fields.pop("version") != PARETO_VERSION:
        raise ValueError(f"must be a document {PARETO_FORMAT!r} of version {PARETO_VERSION}")
    for key in _FIELDS:
        fields[key]
    names, count = fields["objective_names"], len(fields["controllers"])
    fields["objective_names"] = tuple(names)
    for key, width in (("objectives", len(names)), ("x", len(fields["parameters"]))):
        fields[key] = np.array(fields[key], dtype=float).reshape(count, width)
    fields["bounds"] = np.array(fields["bounds"], dtype=float)
    fields["reference_point"] = np.array(fields["reference_point"], dtype=float)
    check_names(fields["parameters"], fields["bounds"][:, 0])
    history = [tuple(row) for row in fields["history"]]
    fields["history"] = np.array(history, dtype=[(name, float) for name in FRONT_HISTORY])
    fields["controllers"] = [_controller(one) for one in fields["controllers"]]
    scenarios = scenarios_in(fields["scenario"])
    fields["scenario"] = scenarios[0] if len(scenarios) == 1 else scenarios
    if "family" in fields:
        fields["family"] = family_in(fields["family"])
    return fields


def _controller(document: Mapping[str, Any]) -> Controller | Rival:
    kind = Rival if document.get("format") == "nfopidn-rival" else Controller
    return kind.from_json(json.dumps(document))


def _knee_direction(shares: Array) -> Array:
    """(m,): what is least where a point is farthest under the hyperplane through the extremes.

    Equal weights where the extremes span no hyperplane.
    """
    extremes = shares[np.argmin(shares, axis=0)]
    ones = np.ones(shares.shape[1])
    if np.linalg.matrix_rank(extremes) < len(ones):
        return ones
    normal = np.linalg.solve(extremes, ones)
    return np.asarray(normal) if (normal > 0).all() else ones


def objective_unit(name: str) -> str:
    """Give the unit of an objective, an empty text where it has none."""
    unit, _ = _core.metric_fields().get(name, ("", ""))
    return str(unit)
