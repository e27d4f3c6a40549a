"""The readings of the paper where it is silent: what the published gains do under each."""

from __future__ import annotations

from itertools import product
from typing import Literal

from nfopidn._core import Controller, Scenario, simulate
from nfopidn.study.cases import Cases
from nfopidn.study.files import Cell, Folder

_Heading = Literal["forward", "continuous"]
_Lateral = Literal["plain", "direction"]

_LAPS = (150.0, 25.0)
_FRAMES: tuple[Literal["robot", "world"], ...] = ("robot", "world")
_FORMS: tuple[Literal["positional", "incremental"], ...] = ("positional", "incremental")
#: With forward heading nothing reverses, and what the lateral channel is fed does not matter.
_HEADINGS: tuple[tuple[_Heading, _Lateral], ...] = (
    ("forward", "direction"),
    ("continuous", "plain"),
    ("continuous", "direction"),
)


def readings(cases: Cases, folder: Folder) -> None:
    """Write the published gains' cost for every frame, form, heading and lap time."""
    rows: list[dict[str, Cell]] = []
    for lap, frame, form, (heading, lateral) in product(_LAPS, _FRAMES, _FORMS, _HEADINGS):
        scenario = Scenario.published(rng=0, period=lap, heading=heading)
        controller = Controller.published(frame=frame, form=form, lateral=lateral)
        run = simulate(scenario, controller)
        rows.append(
            {
                "lap": lap,
                "frame": frame,
                "form": form,
                "heading": heading,
                "lateral": "any" if heading == "forward" else lateral,
                "outcome": "completes" if run.diverged_at is None else "diverges",
                "cost": run.cost,
                "diverged_at": run.diverged_at,
                "peak_reference_speed": scenario.trajectory.peak_speed,
            }
        )
    units = {"lap": "s", "diverged_at": "s", "peak_reference_speed": "m/s"}
    title = "Readings where the paper is silent, published gains and allocation"
    folder.table("readings", title, {key: [row[key] for row in rows] for key in rows[0]}, units)
    cases.report("readings")
