"""Figures for the paper's claims: limits, smoothness, speeds, steady state, power."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Controller, Scenario, SimulationResult, simulate
from nfopidn.plot.runs import wheel_speeds
from nfopidn.study.cases import Cases, distance
from nfopidn.study.files import Cell, Folder

Array = NDArray[np.float64]
Peak = tuple[float, float | None]  # value, time [s]

#: Within an arc: away from the start and from the cusps at 0, 50, 100 and 150 s.
ARC = (30.0, 45.0)
#: The same after two cusps, and all before the first.
LAST_ARC = (130.0, 145.0)
FIRST_ARC = (0.0, 45.0)


def _peak(t: Array, *values: Array) -> Peak:
    """Return the largest modulus of all, and its time."""
    size = np.max(np.abs(values), axis=0)
    at = int(np.argmax(size))
    return float(size[at]), float(t[at])


def _within(run: SimulationResult, window: tuple[float, float] = ARC) -> NDArray[np.bool_]:
    return (run.t >= window[0]) & (run.t <= window[1])


def figures_of(run: SimulationResult) -> dict[str, tuple[str, float, float | None]]:
    """Return unit, value and time [s] (None: of the whole run) of what the claims are about."""
    t, torque, columns = run.t, run.torque, run.columns
    steps = np.abs(np.diff(torque, axis=0))
    left, right = wheel_speeds(run)
    powers = (torque[:, 0] * left, torque[:, 1] * right)
    metrics = run.metrics
    mean = metrics["energy"] / (len(run) * run.scenario.trajectory.dt)
    peaks: dict[str, tuple[str, Peak]] = {
        "largest torque": ("N m", _peak(t, *torque.T)),
        "largest step of a torque in one sample": ("N m", _peak(t[1:], *steps.T)),
        "largest speed": ("m/s", _peak(t, columns["v"])),
        "largest turn rate": ("rad/s", _peak(t, columns["omega"])),
        "largest wheel speed": ("rad/s", _peak(t, left, right)),
        "largest power of a wheel": ("W", _peak(t, *powers)),
        "largest position error": ("m", _peak(t, distance(run))),
    }
    arc, last_arc, first_arc = (_within(run, window) for window in (ARC, LAST_ARC, FIRST_ARC))
    whole = {
        "cost E": ("", run.cost),
        "share of samples at the torque limit": ("", metrics["share_at_limit"]),
        "total variation of the torques": ("N m", metrics["torque_variation"]),
        "mean power of both wheels": ("W", mean),
        "position error, RMS": ("m", metrics["position_rms"]),
        "position error, RMS, 30 to 45 s": ("m", _rms(distance(run)[arc])),
        "position error, RMS, 130 to 145 s": ("m", _rms(distance(run)[last_arc])),
        "heading error, RMS": ("rad", metrics["heading_rms"]),
        "heading error, RMS, 30 to 45 s": ("rad", _rms(columns["e_theta"][arc])),
        "largest speed, 0 to 45 s": ("m/s", float(np.abs(columns["v"][first_arc]).max())),
        "largest turn rate, 0 to 45 s": ("rad/s", float(np.abs(columns["omega"][first_arc]).max())),
        "largest turn rate, 30 to 45 s": ("rad/s", float(np.abs(columns["omega"][arc]).max())),
    }
    found = {name: (unit, value, time) for name, (unit, (value, time)) in peaks.items()}
    return {name: (unit, value, None) for name, (unit, value) in whole.items()} | found


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _reference_figures(scenario: Scenario) -> dict[str, tuple[str, float, float | None]]:
    reference, t = scenario.reference, np.asarray(scenario.trajectory.t)
    arc = (t >= ARC[0]) & (t <= ARC[1])
    speed, turn = _peak(t, reference[:, 3]), _peak(t, reference[:, 4])
    variation = float(np.abs(np.diff(reference[:, 5:7], axis=0)).sum())
    return {
        "largest feedforward torque": ("N m", *_peak(t, *reference[:, 5:7].T)),
        "total variation of the feedforward torques": ("N m", variation, None),
        "largest reference speed": ("m/s", *speed),
        "largest reference turn rate": ("rad/s", *turn),
        "largest reference turn rate, 30 to 45 s": (
            "rad/s",
            float(np.abs(reference[arc, 4]).max()),
            None,
        ),
    }


def claims(cases: Cases, folder: Folder) -> None:
    """Write the figures behind the paper's claims, of both runs."""
    own = {name: figures_of(run) for name, run in cases.runs.items()}
    reference = _reference_figures(cases.scenario)
    columns: dict[str, list[Cell]] = {"figure": [*own["published"], *reference], "unit": []}
    columns["unit"] = [unit for unit, _, _ in (*own["published"].values(), *reference.values())]
    for name, table in own.items():
        rows = [*table.values(), *reference.values()]
        columns[name] = [value for _, value, _ in rows]
        columns[f"{name}_at"] = [time for _, _, time in rows]
    units = {"published_at": "s", "tuned_at": "s"}
    folder.table("claims", "Figures behind the paper's claims", columns, units)
    cases.report("claims")


def steady_state(cases: Cases, folder: Folder) -> None:
    """Write the position error within an arc: by feedforward alone, with feedback, disturbed.

    All start on the reference and with its velocity.
    """
    on_path: dict[str, Any] = {"initial_pose": None, "initial_velocity": "reference"}
    scenario = cases.scenario.replace(**on_path)
    published = Controller.published()
    alone = published.replace(gains=np.zeros((3, 3)))
    rows: list[dict[str, Cell]] = []
    for name, changes, controller in (
        ("feedforward alone", {}, alone),
        ("feedforward and feedback", {}, published),
        ("feedback alone", {"feedforward": False}, published),
        ("both, held back by 1 N", {"disturbance": (-1.0, 0.0)}, published),
        ("both, viscous friction 0.01 N m s/rad", {"viscous_friction": 0.01}, published),
    ):
        settings: dict[str, Any] = changes
        run = simulate(scenario.replace(**settings), controller)
        error = distance(run)[_within(run)]
        rows.append(
            {
                "case": name,
                "mean_error": float(error.mean()),
                "largest_error": float(error.max()),
                "cost": run.cost,
            }
        )
    units = {"mean_error": "m", "largest_error": "m"}
    title = "Position error 30 to 45 s after a start on the reference, published gains"
    folder.table("steady_state", title, {key: [row[key] for row in rows] for key in rows[0]}, units)
    cases.report("steady state")
