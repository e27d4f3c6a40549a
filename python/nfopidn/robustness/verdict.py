"""The verdict on a controller, as an object, a table and a document."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from nfopidn._core import Controller, Rival, Scenario
from nfopidn.families.runs import FamilyRuns
from nfopidn.robustness.limits import Limits, LoopMargin

Colour = Literal["green", "amber", "red"]
COLOURS: tuple[Colour, ...] = ("green", "amber", "red")


def digest(thing: Scenario | Controller | Rival) -> str:
    """Give 16 hexadecimal digits that tell scenarios or controllers apart.

    They are the first of the SHA-256 of the document that to_json() gives.
    """
    return hashlib.sha256(thing.to_json().encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Verdict:
    """A verdict on a controller on a scenario; prints as a short table.

    Attributes
    ----------
    colour
        "red": unstable, off its path, a variation diverges, or less than one sample of delay is
        borne. "amber": a parameter on a bound, a reference beyond the robot's limits, or a gain
        margin under 6 dB. "green": none of these.
    reasons
        for the colour, in words; empty if it is green
    runs
        of the variations: costs and what diverged
    stable
        on its path
    stability
        how that is known, in words
    spectral_radius
        a sample, of the loop linearised on its orbit; nan where a long simulation is the evidence
    margin
        of the loop's gain (lower and upper factor, the smaller in ``decibels``), ``phase`` [rad]
        and ``delay`` [samples], and their ``source``: "linearised" on a straight line, or
        "simulated", where the phase is nan; None if the loop is not stable or off its path
    limits
        up to what the loop stays on its path, each alone: ``extra_delay`` [samples], ``mass``
        (lower and upper factor), ``friction`` (share of the torque limit a wheel), ``start`` [m]
        beside the path; None if it does not stay there as it is
    at_bound
        parameters that the search left on a bound, in words
    beyond
        what the reference asks that the robot does not have, in words
    controller_digest, scenario_digest
        of what is judged, and on what: digest()
    dt
        the scenario's sample time [s]
    """

    colour: Colour
    reasons: tuple[str, ...]
    runs: FamilyRuns
    stable: bool
    stability: str
    spectral_radius: float
    margin: LoopMargin | None
    limits: Limits | None
    at_bound: tuple[str, ...]
    beyond: tuple[str, ...]
    controller_digest: str
    scenario_digest: str
    dt: float = field(repr=False)

    def is_of(self, controller: Controller | Rival, scenario: Scenario | None) -> bool:
        """Whether it is on this controller, to the last bit, and on this scenario."""
        return (
            scenario is not None
            and self.controller_digest == digest(controller)
            and self.scenario_digest == digest(scenario)
        )

    @property
    def diverged(self) -> tuple[str, ...]:
        """The names of the variations that diverge."""
        lost = self.runs.diverged
        return tuple(name for name, gone in zip(self.runs.names, lost, strict=True) if gone)

    @property
    def line(self) -> str:
        """Colour and reasons on one line."""
        if self.reasons:
            return f"verdict: {self.colour}: {'; '.join(self.reasons)}"
        worst = f"worst variation {self.runs.worst!r}, cost {self.runs.worst_cost:.3g}"
        text = f"verdict: {self.colour}: {worst}"
        if self.margin is not None and self.limits is not None:
            text += (
                f", gain margin {self.margin.decibels:.3g} dB, "
                f"extra delay borne {_samples(self.limits.extra_delay)}"
            )
        return text

    def rows(self) -> list[tuple[str, str]]:
        """Give what is behind it, each with its name: stability, margins, what the loop bears."""
        rows = [("stable" if self.stable else "not stable", self.stability)]
        if self.margin is not None:
            rows += self._margin_rows(self.margin)
        if self.limits is not None:
            rows += self._limit_rows(self.limits)
        if self.at_bound:
            rows.append(("on a bound", ", ".join(self.at_bound)))
        return rows

    def __str__(self) -> str:
        rows = self.rows()
        width = max(len(name) for name, _ in rows)
        lines = [self.line, *(f"  {name:{width}}  {text}" for name, text in rows)]
        return "\n".join([*lines, *("  " + line for line in str(self.runs).splitlines())])

    def _margin_rows(self, margin: LoopMargin) -> list[tuple[str, str]]:
        low, high = margin.gain
        rows = [
            (
                "gain margin",
                f"{margin.decibels:.3g} dB, factors {low:.3g} to {high:.3g} ({margin.source})",
            )
        ]
        if not math.isnan(margin.phase):
            rows.append(("phase margin", f"{math.degrees(margin.phase):.3g} degrees"))
            delay = f"{margin.delay:.3g} samples, {1e3 * margin.delay * self.dt:.4g} ms"
            rows.append(("delay margin", delay))
        return rows

    def _limit_rows(self, limits: Limits) -> list[tuple[str, str]]:
        milliseconds = 1e3 * limits.extra_delay * self.dt
        return [
            ("extra delay", f"up to {_samples(limits.extra_delay)}, {milliseconds:.4g} ms"),
            ("mass", f"from x{limits.mass[0]:.3g} to x{limits.mass[1]:.3g}"),
            ("friction", f"up to {100 * limits.friction:.3g} % of the torque limit a wheel"),
            ("start", f"up to {limits.start:.3g} m beside the path"),
        ]

    def to_dict(self) -> dict[str, Any]:
        """Give what a file holds: plain numbers and texts, null for what is not known."""
        limits = self.limits
        margin = self.margin
        return {
            "colour": self.colour,
            "reasons": list(self.reasons),
            "variations": [
                {"name": name, "cost": _number(cost), "diverged_at": _number(at)}
                for name, cost, at in zip(
                    self.runs.names, self.runs.costs, self.runs.diverged_at, strict=True
                )
            ],
            "stable": self.stable,
            "stability": self.stability,
            "spectral_radius": _number(self.spectral_radius),
            "margin": None
            if margin is None
            else {
                "gain": [_number(one) for one in margin.gain],
                "gain_db": _number(margin.decibels),
                "phase": _number(margin.phase),
                "delay": _number(margin.delay),
                "source": margin.source,
            },
            "limits": None
            if limits is None
            else {
                "extra_delay": limits.extra_delay,
                "mass": list(limits.mass),
                "friction": limits.friction,
                "start": limits.start,
            },
            "at_bound": list(self.at_bound),
            "beyond": list(self.beyond),
            "controller_digest": self.controller_digest,
            "scenario_digest": self.scenario_digest,
            "dt": self.dt,
        }

    @classmethod
    def from_dict(cls, given: Any) -> Verdict:
        """Make one of what to_dict() gives.

        Raises
        ------
        ValueError
            Something else.
        """
        try:
            if not isinstance(given, Mapping) or given["colour"] not in COLOURS:
                raise ValueError(f"colour must be one of {', '.join(COLOURS)}")
            rows, margin, limits = given["variations"], given["margin"], given["limits"]
            costs = np.array([_read(row["cost"], np.inf) for row in rows])
            return cls(
                given["colour"],
                _texts(given["reasons"]),
                FamilyRuns(
                    _texts([row["name"] for row in rows]),
                    costs,
                    {"cost": costs},
                    np.array([_read(row["diverged_at"], np.nan) for row in rows]),
                ),
                bool(given["stable"]),
                str(given["stability"]),
                _read(given["spectral_radius"], np.nan),
                None
                if margin is None
                else LoopMargin(
                    (_read(margin["gain"][0], 0.0), _read(margin["gain"][1], np.inf)),
                    _read(margin["phase"], np.nan),
                    _read(margin["delay"], np.nan),
                    str(margin["source"]),
                ),
                None
                if limits is None
                else Limits(
                    int(limits["extra_delay"]),
                    (float(limits["mass"][0]), float(limits["mass"][1])),
                    float(limits["friction"]),
                    float(limits["start"]),
                ),
                _texts(given["at_bound"]),
                _texts(given["beyond"]),
                str(given["controller_digest"]),
                str(given["scenario_digest"]),
                float(given["dt"]),
            )
        except (KeyError, TypeError, IndexError, ValueError) as error:
            raise ValueError(f"verdict: not as Verdict.to_dict() gives it: {error}") from None


def _samples(count: int) -> str:
    return "1 sample" if count == 1 else f"{count} samples"


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _read(value: Any, absent: float) -> float:
    return absent if value is None else float(value)


def _texts(given: Any) -> tuple[str, ...]:
    if not isinstance(given, list) or not all(isinstance(one, str) for one in given):
        raise ValueError("a list of texts is needed")
    return tuple(given)
