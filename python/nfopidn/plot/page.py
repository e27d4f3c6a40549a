"""A run on one page."""

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nfopidn._core import Rival, SimulationResult
from nfopidn.plot import runs, style

_METRICS = (
    ("position_rms", "position error, RMS", "m"),
    ("position_max", "position error, largest", "m"),
    ("heading_rms", "heading error, RMS", "rad"),
    ("iae", "IAE of position", "m s"),
    ("itae", "ITAE of position", "m s²"),
    ("torque_peak", "torque, largest", "N m"),
    ("torque_variation", "torque, total variation", "N m"),
    ("energy", "energy at the wheels", "J"),
    ("lateral_force_peak", "lateral force, largest", "N"),
)


def _metric_rows(result: SimulationResult) -> list[tuple[str, str, str]]:
    metrics = result.metrics
    rows = [("cost E (eq. 41)", f"{result.cost:.6g}", "")]
    rows += [(text, f"{metrics[name]:#.4g}".rstrip("."), unit) for name, text, unit in _METRICS]
    rows.append(("samples at the torque limit", f"{100 * metrics['share_at_limit']:.3g}", "%"))
    return rows


def _setting_rows(result: SimulationResult) -> list[tuple[str, str]]:
    controller, trajectory = result.controller, result.scenario.trajectory
    if isinstance(controller, Rival):
        own = [(name.replace("_", " "), f"{x:.4g}") for name, x in controller.parameters.items()]
        return [("heading", trajectory.heading), ("speeds", controller.speeds), *own]
    allocation = controller.allocation
    return [
        ("heading", trajectory.heading),
        ("form", controller.form),
        ("allocation", allocation if isinstance(allocation, str) else "own matrix"),
        ("activation", controller.activation),
        ("generator", controller.generator),
        ("lateral", controller.lateral),
        ("anti-windup", controller.anti_windup),
        ("frame", controller.frame),
        ("memory $M$", f"{controller.memory}"),
        (r"order $\alpha$", _orders(controller.alpha)),
        (r"order $\sigma$", _orders(controller.sigma)),
    ]


def _orders(value: float | Sequence[float] | None) -> str:
    if value is None:
        return "free taps"
    numbers = [value] if isinstance(value, float) else value
    return ", ".join(f"{number:.4g}" for number in numbers)


def _table(ax: Axes, result: SimulationResult) -> None:
    """Write metrics with units at the left, and the controller's settings at the right."""
    ax.set_axis_off()
    metrics, settings = _metric_rows(result), _setting_rows(result)
    count = max(len(metrics), len(settings))
    ax.set(xlim=(0, 1), ylim=(count, -1))
    for row, (text, number, unit) in enumerate(metrics):
        weight = "bold" if row == 0 else "normal"
        _cell(ax, (0.0, row), text, fontweight=weight)
        _cell(ax, (0.46, row), number, fontweight=weight, ha="right")
        _cell(ax, (0.48, row), unit)
    for row, (text, choice) in enumerate(settings):
        _cell(ax, (0.64, row), text)
        _cell(ax, (1.0, row), choice, ha="right")
    for left, right in ((0.0, 0.56), (0.64, 1.0)):
        for y in (-0.5, count - 0.5):
            ax.plot([left, right], [y, y], color="0.3", linewidth=0.8, clip_on=False)


def _cell(ax: Axes, at: tuple[float, float], text: str, **options: Any) -> None:
    ax.text(*at, text, va="center", fontsize=style.TICK_SIZE, **options)


def overview(result: SimulationResult, fig: Figure | None = None) -> Figure:
    """Draw a run on one page: path, heading, torques, speeds, errors, metrics and settings.

    Parameters
    ----------
    result
        a run
    fig
        an empty figure to draw in; None makes one of A4 size, landscape

    Returns
    -------
    matplotlib.figure.Figure
        the page
    """
    if fig is None:
        fig = plt.figure(figsize=(11.69, 8.27))
    if fig.get_layout_engine() is None:
        fig.set_layout_engine("constrained", w_pad=0.08, h_pad=0.08)
    trajectory = result.scenario.trajectory
    path_name = "a path" if trajectory.name == "samples" else trajectory.name.replace("_", " ")
    controller = result.controller
    name = controller.law if isinstance(controller, Rival) else "NFOPIDN"
    title = (
        f"{name} on {path_name}, {len(trajectory)} samples of "
        f"{trajectory.dt:.4g} s:  E = {result.cost:.6g}"
    )
    if result.diverged_at is not None:
        title += f",  {runs.divergence_text(result)}"
    fig.suptitle(title, fontsize=12, fontweight="bold")

    halves = fig.add_gridspec(1, 2, width_ratios=(1, 1.25))
    stack = halves[0].subgridspec(2, 1, height_ratios=(2.1, 1))
    runs.path(result, ax=fig.add_subplot(stack[0]))
    _table(fig.add_subplot(stack[1]), result)

    panels = halves[1].subgridspec(3, 2).subplots(sharex=True, squeeze=False)
    runs.orientation(result, ax=panels[0, 0])
    runs.total_torque(result, ax=panels[0, 1])
    runs.velocities(result, axes=panels[1:, 0])
    runs.errors(result, axes=panels[1:, 1])
    for ax in panels[0]:
        ax.set_xlabel("")
    for column in panels.T:
        fig.align_ylabels(list(column))
    return fig
