"""The figures: what they draw equals what was run, and they leave nothing behind."""

import csv
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch
from nfopidn import Controller, Scenario, Trajectory, plot, simulate
from numpy.testing import assert_allclose, assert_array_equal
from scipy.special import binom

GOLDEN_WEIGHTS = Path(__file__).parents[2] / "golden" / "weights.csv"

SINGLE = {
    "path": ("x [m]", "y [m]"),
    "orientation": ("time [s]", "[rad]"),
    "feedforward_torque": ("time [s]", "[N m]"),
    "feedback_torque": ("time [s]", "[N m]"),
    "total_torque": ("time [s]", "[N m]"),
}
STACKED = {
    "wheel_action": ("[N m]", "[rad/s]", "[W]"),
    "velocities": ("[m/s]", "[rad/s]"),
    "errors": ("[m]", "[rad]"),
}
OF_CONTROLLER = ("weights", "z_plane")
SCHEMATICS = ("robot_schematic", "control_system_schematic", "controller_schematic")
ALL = (*SINGLE, *STACKED, *OF_CONTROLLER, *SCHEMATICS, "overview")


def without_rows(result):
    """Return the result of a run that diverged at once."""
    return SimpleNamespace(
        columns={name: column[:0] for name, column in result.columns.items()},
        pose=result.pose[:0],
        t=result.t[:0],
        metrics=dict.fromkeys(result.metrics, 0.0),
        cost=100.0,
        diverged_at=0.0,
        scenario=result.scenario,
        controller=result.controller,
    )


RUNS = {
    "published": simulate,
    "circle": lambda: simulate(Scenario(Trajectory.circle(), initial_pose=(1.5, -0.5, 0.3))),
    "continuous": lambda: simulate(Scenario.published(heading="continuous")),
    "short": lambda: simulate(
        Scenario(Trajectory.from_samples([0, 0.1, 0.2], [0, 0, 0.1], 0.2), torque_limit=0.5)
    ),
    "diverged": lambda: simulate(controller=Controller.published(form="incremental")),
    "empty": lambda: without_rows(simulate()),
}


@pytest.fixture(scope="module", params=RUNS)
def run(request):
    return RUNS[request.param]()


@pytest.fixture(scope="module")
def diverged():
    return RUNS["diverged"]()


def arguments(name, result):
    if name in SCHEMATICS:
        return ()
    return (result.controller,) if name in OF_CONTROLLER else (result,)


def line(ax, label):
    (found,) = (one for one in ax.get_lines() if one.get_label() == label)
    return found


def data(ax, label):
    x, y = line(ax, label).get_data()
    return np.asarray(x), np.asarray(y)


def texts(artist):
    return [one.get_text() for one in artist.findobj(mpl.text.Text) if one.get_text()]


def run_python(code):
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120
    )
    return done.stdout.strip()


# The module.


def test_matplotlib_is_loaded_by_the_first_figure_only():
    loaded = "print('matplotlib' in sys.modules)"
    assert run_python(f"import sys, nfopidn; nfopidn.plot; {loaded}") == "False"
    assert run_python(f"import sys, nfopidn; nfopidn.plot.path; {loaded}") == "True"


def test_module_lists_its_functions_and_no_others():
    # Drawn in test_tune.py, test_compare.py, test_fractional.py, test_stability_plots.py,
    # test_robustness_plots.py, test_monte_carlo_plots.py, test_pareto_plots.py and
    # test_identify.py.
    elsewhere = ["convergence", "discretisation", "basin", "multipliers", "operator_z_plane"]
    elsewhere += ["comparison", "distances", "paths"]
    elsewhere += ["margin_bars", "path_bundle", "variation_costs"]
    elsewhere += ["cost_histogram", "failures", "quantile_bands", "tornado"]
    elsewhere += ["hypervolume", "pareto_front", "identification"]
    assert sorted(plot.__all__) == sorted([*ALL, *elsewhere])
    assert set(plot.__all__) <= set(dir(plot))
    for name in plot.__all__:
        assert callable(getattr(plot, name))
        assert f"`{name}`" in plot.__doc__
    with pytest.raises(AttributeError, match="no attribute 'pie'"):
        plot.pie  # noqa: B018


# What every figure does.


@pytest.mark.parametrize("name", [*SINGLE, *OF_CONTROLLER, *SCHEMATICS])
def test_figure_is_drawn_into_the_given_axes(published, name):
    ax = Figure().add_subplot()
    before = plt.get_fignums()
    assert getattr(plot, name)(*arguments(name, published), ax=ax) is ax
    assert plt.get_fignums() == before
    assert len(ax.get_lines()) + len(ax.patches) >= 2


@pytest.mark.parametrize("name", STACKED)
def test_panels_are_drawn_into_the_given_axes(published, name):
    axes = Figure().subplots(1, len(STACKED[name]))
    before = plt.get_fignums()
    drawn = getattr(plot, name)(published, axes=list(axes))
    assert list(drawn) == list(axes)
    assert plt.get_fignums() == before
    assert all(len(ax.get_lines()) > 0 for ax in axes)
    # Beside each other, each needs its own label.
    assert all(ax.get_xlabel() == "time [s]" for ax in axes)
    with pytest.raises(ValueError, match=f"axes has 1 Axes; must have {len(STACKED[name])}"):
        getattr(plot, name)(published, axes=[Figure().add_subplot()])


@pytest.mark.parametrize("name", ALL)
def test_without_axes_one_figure_is_made(published, name):
    drawn = getattr(plot, name)(*arguments(name, published))
    assert len(plt.get_fignums()) == 1
    figure = drawn if name == "overview" else np.ravel(drawn)[0].figure
    assert figure is plt.gcf()
    assert isinstance(
        drawn, {"overview": Figure}.get(name, np.ndarray if name in STACKED else Axes)
    )


@pytest.mark.parametrize("name", ALL)
def test_settings_of_matplotlib_stay(published, name):
    before = mpl.rcParams.copy()
    getattr(plot, name)(*arguments(name, published))
    assert mpl.rcParams == before


@pytest.mark.parametrize("name", SINGLE)
def test_labels_carry_units(run, name):
    ax = getattr(plot, name)(run)
    assert ax.get_xlabel() == SINGLE[name][0]
    assert SINGLE[name][1] in ax.get_ylabel()


@pytest.mark.parametrize("name", STACKED)
def test_labels_of_panels_carry_units(run, name):
    axes = getattr(plot, name)(run)
    for ax, unit in zip(axes, STACKED[name], strict=True):
        assert ax.get_ylabel().endswith(unit)
    assert [ax.get_xlabel() for ax in axes] == [""] * (len(axes) - 1) + ["time [s]"]


@pytest.mark.parametrize("name", [*SINGLE, *STACKED, *OF_CONTROLLER])
def test_legends_lie_above_the_data(run, name):
    axes = np.ravel(getattr(plot, name)(*arguments(name, run)))
    axes[0].figure.canvas.draw()
    page = axes[0].figure.bbox
    for ax in axes:
        legend = ax.get_legend().get_window_extent()
        assert legend.y0 >= ax.get_window_extent().y1
        assert legend.x1 <= page.x1
        assert legend.y1 <= page.y1


@pytest.mark.parametrize("name", ["total_torque", "velocities", "errors", "path", "weights"])
def test_lines_differ_in_grey(published, name):
    def luminance(one):
        return float(np.dot(to_rgb(one.get_color()), (0.2126, 0.7152, 0.0722)))

    ax = np.ravel(getattr(plot, name)(*arguments(name, published)))[0]
    first, second = ax.get_lines()[:2]
    assert abs(luminance(first) - luminance(second)) > 0.2


# What is drawn.


def test_path_is_that_of_the_run(run):
    ax = plot.path(run)
    reference = run.scenario.reference
    assert_array_equal(data(ax, "reference"), (reference[:, 0], reference[:, 1]))
    assert_array_equal(data(ax, "robot"), (run.columns["x"], run.columns["y"]))
    ax.figure.canvas.draw()
    scale = ax.transData.transform([(0, 0), (1, 0), (0, 1)])
    assert_allclose(scale[1, 0] - scale[0, 0], scale[2, 1] - scale[0, 1])


def test_path_shows_the_heading_along_it(run):
    ax = plot.path(run)
    arrows = ax.findobj(mpl.quiver.Quiver)
    if len(run.columns["x"]) == 0:
        assert arrows == []
        return
    (quiver,) = arrows
    x, y, theta = (run.columns[name] for name in ("x", "y", "theta"))
    assert 1 <= quiver.N <= 24
    for start, u, v in zip(quiver.XY, quiver.U, quiver.V, strict=True):
        (row,) = np.nonzero((x == start[0]) & (y == start[1]))[0][:1]
        assert_allclose((u, v), (np.cos(theta[row]), np.sin(theta[row])))


def test_arrows_are_evenly_apart_though_the_speed_is_not(published):
    (quiver,) = plot.path(published).findobj(mpl.quiver.Quiver)
    x, y = published.columns["x"], published.columns["y"]
    way = np.concatenate(([0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
    at = [way[np.flatnonzero(x == start[0])[0]] for start in quiver.XY]
    assert_allclose(np.diff(at), way[-1] / 24, atol=0.2)


@pytest.mark.parametrize(
    ("result", "pose"),
    [
        (RUNS["published"], (4, 0, 1.0472)),
        (RUNS["empty"], (4, 0, 1.0472)),
        (lambda: without_rows(simulate(Scenario(Trajectory.circle()))), None),
    ],
)
def test_outline_stands_at_the_start(result, pose):
    made = result()
    x, y, theta = made.scenario.reference[0, :3] if pose is None else pose
    ax = plot.path(made)
    (body,) = (patch for patch in ax.patches if isinstance(patch, Circle))
    to_data = body.get_transform() - ax.transData
    assert_allclose(to_data.transform(body.get_path().vertices).mean(axis=0), (x, y), atol=0.2)
    front = np.transpose(ax.get_lines()[-1].get_data())
    assert_allclose(front[0], (x, y))
    assert_allclose(np.arctan2(*(front[1] - front[0])[::-1]), theta)


@pytest.mark.parametrize("scale", [0.02, 5.0])
def test_outline_is_neither_too_small_nor_too_large(scale):
    result = simulate(Scenario(Trajectory.circle(scale=scale)))
    ax = plot.path(result)
    (body,) = (patch for patch in ax.patches if isinstance(patch, Circle))
    reach = np.ptp(np.concatenate((result.scenario.reference[:, :2], result.pose[:, :2])), axis=0)
    assert 2 * body.radius / reach.max() == pytest.approx(0.12 if scale < 1 else 0.05)


def test_outline_has_the_robots_size_where_that_fits():
    result = simulate(Scenario(Trajectory.circle()))
    (body,) = (patch for patch in plot.path(result).patches if isinstance(patch, Circle))
    assert body.radius == pytest.approx(0.226)


@pytest.mark.parametrize("turns", [-2, 0, 3])
def test_orientation_brings_whole_turns_together(turns):
    pose = (4, 0, 1.0472 + 2 * np.pi * turns)
    result = simulate(Scenario.published(initial_pose=pose))
    ax = plot.orientation(result)
    assert_array_equal(data(ax, "reference")[1], result.columns["theta_ref"])
    t, theta = data(ax, "robot")
    assert_array_equal(t, result.columns["t"])
    assert_allclose(theta, result.columns["theta"] - 2 * np.pi * turns, atol=1e-12)
    assert theta[0] == pytest.approx(1.0472)


@pytest.mark.parametrize(
    ("name", "columns"),
    [
        ("feedforward_torque", "tau_ref"),
        ("feedback_torque", "tau_fb"),
        ("total_torque", "tau"),
    ],
)
def test_torques_are_those_of_the_run(published, name, columns):
    ax = getattr(plot, name)(published)
    for wheel in ("left", "right"):
        t, torque = data(ax, wheel)
        assert_array_equal(t, published.columns["t"])
        assert_array_equal(torque, published.columns[f"{columns}_{wheel}"])
        assert line(ax, wheel).get_drawstyle() == "steps-post"


@pytest.mark.parametrize("limit", [3.078, 0.5])
def test_limit_is_drawn_at_both_signs(limit):
    ax = plot.total_torque(simulate(Scenario.published(torque_limit=limit)))
    flat = [one.get_ydata() for one in ax.get_lines() if len(set(one.get_ydata())) == 1]
    assert sorted(y[0] for y in flat) == [-limit, limit]
    assert any(f"limit {limit} N m" in text for text in texts(ax))
    low, high = ax.get_ylim()
    assert low < -limit < limit < high


def test_wheel_action_is_torque_speed_and_power(published):
    torque, speed, power = plot.wheel_action(published)
    columns, robot = published.columns, published.scenario.robot
    energy = 0.0
    for wheel, sign in (("left", 1), ("right", -1)):
        turning = sign * columns["omega"] * robot.track_width / 2
        wheel_speed = (columns["v"] + turning) / robot.wheel_radius
        assert_array_equal(data(torque, wheel)[1], columns[f"tau_{wheel}"])
        assert_allclose(data(speed, wheel)[1], wheel_speed, rtol=1e-12)
        assert_allclose(data(power, wheel)[1], columns[f"tau_{wheel}"] * wheel_speed, rtol=1e-12)
        energy += float(np.abs(data(power, wheel)[1]).sum()) * 0.2
    assert energy == pytest.approx(published.metrics["energy"])


def test_velocities_are_those_of_run_and_reference(published):
    trajectory = published.scenario.trajectory
    for ax, name in zip(plot.velocities(published), ("v", "omega"), strict=True):
        assert_array_equal(data(ax, "reference"), (trajectory.t, getattr(trajectory, name)))
        assert_array_equal(data(ax, "robot"), (published.columns["t"], published.columns[name]))


def test_errors_are_those_of_the_run(run):
    position, heading = plot.errors(run)
    for ax, label, name in (
        (position, "$e_x$", "e_x"),
        (position, "$e_y$", "e_y"),
        (heading, r"$e_\theta$", "e_theta"),
    ):
        assert_array_equal(data(ax, label), (run.columns["t"], run.columns[name]))


# Runs that diverged.


@pytest.mark.parametrize("name", [*SINGLE, *STACKED])
def test_time_of_divergence_is_told_once(diverged, published, name):
    told = f"diverged at t = {diverged.diverged_at:.4g} s"
    axes = np.ravel(getattr(plot, name)(diverged))
    assert [texts(ax).count(told) for ax in axes] == [1] + [0] * (len(axes) - 1)
    if name != "path":
        for ax in axes:
            upright = [list(one.get_xdata()) for one in ax.get_lines()]
            assert [diverged.diverged_at] * 2 in upright
            assert 1.2 * diverged.diverged_at < ax.get_xlim()[1] < 10
    for ax in np.ravel(getattr(plot, name)(published)):
        assert not any("diverged" in text for text in texts(ax))


@pytest.mark.parametrize("name", ["orientation", "velocities", "feedforward_torque"])
def test_reference_goes_on_after_the_divergence(diverged, name):
    ax = np.ravel(getattr(plot, name)(diverged))[0]
    t, _ = data(ax, "left" if name == "feedforward_torque" else "reference")
    assert diverged.diverged_at < t[-1] < 2 * diverged.diverged_at


@pytest.mark.parametrize("name", ["orientation", "velocities", "feedforward_torque"])
def test_without_rows_the_whole_reference_is_drawn(name):
    result = RUNS["empty"]()
    ax = np.ravel(getattr(plot, name)(result))[0]
    t, _ = data(ax, "left" if name == "feedforward_torque" else "reference")
    assert_array_equal(t, result.scenario.trajectory.t)
    assert "diverged at t = 0 s" in texts(ax)


# Controllers.


def golden_weights(order):
    with GOLDEN_WEIGHTS.open() as file:
        rows = [row for row in csv.DictReader(file) if row["order"] == order]
    assert [int(row["j"]) for row in rows] == list(range(len(rows)))
    return np.array([float(row["f_j"]) for row in rows])


@pytest.mark.parametrize("memory", [0, 1, 5, 60])
def test_weights_are_the_golden_ones(memory):
    ax = plot.weights(Controller.published(memory=memory))
    assert len(ax.get_legend().get_lines()) == 2
    for one, order in zip(ax.get_lines()[:2], ("0.1078", "0.1839"), strict=True):
        assert_array_equal(one.get_xdata(), np.arange(memory + 1))
        assert_allclose(one.get_ydata(), golden_weights(order)[: memory + 1], rtol=1e-12)
        assert order in one.get_label()
    assert "[-]" in ax.get_ylabel()
    assert "[samples]" in ax.get_xlabel()


def test_weights_of_gruenwald_and_letnikov_are_binomial():
    ax = plot.weights(Controller.published(generator="gl", memory=20, alpha=0.3, sigma=0.6))
    j = np.arange(21)
    for one, order in zip(ax.get_lines()[:2], (0.3, 0.4), strict=True):
        assert_allclose(one.get_ydata(), (-1.0) ** j * binom(order, j), rtol=1e-12, atol=1e-15)
    assert "g_j" in ax.get_ylabel()


def test_weights_of_channels_with_their_own_orders():
    controller = Controller.published(alpha=(0.1, 0.2, 0.3), sigma=(0.9, 0.8, 0.8))
    lines = plot.weights(controller).get_lines()[:6]
    orders = [-one.get_ydata()[1] / 2 for one in lines]
    assert_allclose(orders, [0.1, 0.1, 0.2, 0.2, 0.3, 0.2])
    assert len({(one.get_color(), one.get_linestyle()) for one in lines}) == 6


@pytest.mark.parametrize("channel", ["x", "y", "theta"])
@pytest.mark.parametrize("memory", [0, 5, 8])
def test_zeros_are_the_roots_of_the_taps(channel, memory):
    controller = Controller.published(memory=memory)
    taps = controller.taps[["x", "y", "theta"].index(channel)]
    ax = plot.z_plane(controller, channel)
    x, y = data(ax, "zeros")
    zeros = x + 1j * y
    assert_allclose(np.sort_complex(zeros), np.sort_complex(np.roots(taps)), atol=1e-12)
    assert_allclose(np.polyval(taps, zeros), 0, atol=1e-12)
    assert_array_equal(data(ax, "poles"), np.zeros((2, memory + 1)))
    assert f"{memory + 1} pole{'s' if memory > 0 else ''}" in texts(ax)
    (circle,) = (patch for patch in ax.patches if isinstance(patch, Circle))
    assert (circle.center, circle.radius) == ((0, 0), 1)
    assert ax.get_aspect() == 1
    assert "[-]" in ax.get_xlabel()
    assert "[-]" in ax.get_ylabel()


def test_zeros_at_the_origin_are_counted():
    # The textbook PID needs three taps: the other four of memory 5 are zero.
    ax = plot.z_plane(Controller.published(generator="gl", alpha=1, sigma=1))
    assert "4 zeros" in texts(ax)
    other = texts(plot.z_plane(Controller.published()))
    assert not any(text.endswith(" zeros") for text in other)


def test_z_plane_refuses_a_channel_that_is_none():
    with pytest.raises(ValueError, match="channel is 'z'; must be one of x, y, theta"):
        plot.z_plane(Controller.published(), "z")
    assert plt.get_fignums() == []


# Schematics and the page.


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("robot_schematic", [r"$\tau_L$", r"$\tau_R$", "$v$", r"$\omega$", r"$\theta$", "$L$"]),
        ("control_system_schematic", ["NFOPIDN", "feedforward", "trajectory", "robot", "limit"]),
        ("controller_schematic", ["FIR", "rotation", "neurons", "allocation", "z^{-1}", "dashed"]),
    ],
)
def test_schematic_is_complete_and_nothing_overlaps(name, words):
    ax = getattr(plot, name)()
    ax.figure.canvas.draw()
    for word in words:
        assert any(word in text for text in texts(ax)), word
    boxes = [one.get_window_extent() for one in ax.texts if one.get_text()]
    for i, box in enumerate(boxes):
        assert ax.figure.bbox.x0 <= box.x0 <= box.x1 <= ax.figure.bbox.x1
        assert ax.figure.bbox.y0 <= box.y0 <= box.y1 <= ax.figure.bbox.y1
        assert not any(box.overlaps(other) for other in boxes[:i]), ax.texts[i].get_text()
    blocks = [one.get_window_extent() for one in ax.patches if isinstance(one, FancyBboxPatch)]
    for i, block in enumerate(blocks):
        assert ax.bbox.x0 <= block.x0 <= block.x1 <= ax.bbox.x1
        assert not any(block.overlaps(other) for other in blocks[:i])
    assert list(ax.get_xticks()) == []


def test_what_only_the_incremental_form_has_is_dashed():
    ax = plot.controller_schematic()
    dashed = [
        patch
        for patch in ax.patches
        if isinstance(patch, FancyBboxPatch) and patch.get_linestyle() not in {"-", "solid"}
    ]
    assert len(dashed) == 2


def test_overview_tells_cost_and_metrics(run):
    figure = plot.overview(run)
    assert isinstance(figure, Figure)
    assert_allclose(figure.get_size_inches(), (11.69, 8.27))
    told = texts(figure)
    units = {
        "position_rms": "m",
        "position_max": "m",
        "heading_rms": "rad",
        "iae": "m s",
        "itae": "m s²",
        "torque_peak": "N m",
        "torque_variation": "N m",
        "energy": "J",
        "lateral_force_peak": "N",
    }
    first = told.index("cost E (eq. 41)")
    assert told[first + 1] == f"{run.cost:.6g}"
    for row, (name, unit) in enumerate(units.items()):
        number = f"{run.metrics[name]:#.4g}".rstrip(".")
        assert told[first + 3 + 3 * row : first + 5 + 3 * row] == [number, unit]
    (title,) = (text for text in told if f"E = {run.cost:.6g}" in text)
    at = run.diverged_at
    assert title.endswith(f"E = {run.cost:.6g}" if at is None else f"diverged at t = {at:.4g} s")


def test_overview_has_every_panel_within_the_page(run):
    figure = plot.overview(run)
    figure.canvas.draw()
    labels = [ax.get_ylabel() for ax in figure.axes]
    for unit in ("[m]", "[rad]", "[N m]", "[m/s]", "[rad/s]"):
        assert any(unit in label for label in labels)
    # From points of the figure's own page: nothing is cut off.
    box = figure.get_tightbbox()
    width, height = figure.get_size_inches()
    assert box.x0 >= 0
    assert box.y0 >= 0
    assert box.x1 <= width
    assert box.y1 <= height
    boxes = [ax.get_tightbbox() for ax in figure.axes]
    for i, one in enumerate(boxes):
        assert not any(one.padded(-1).overlaps(other.padded(-1)) for other in boxes[:i])


def test_overview_is_drawn_into_the_given_figure(published):
    figure = Figure(figsize=(14, 10))
    assert plot.overview(published, fig=figure) is figure
    assert len(figure.axes) == 8
    assert plt.get_fignums() == []


def test_overview_names_the_settings():
    controller = Controller.published(
        allocation=[[1, 1, 0], [1, 0, 1]], activation="linear", alpha=(0.1, 0.2, 0.3), memory=7
    )
    told = texts(plot.overview(simulate(controller=controller)))
    for text in ("own matrix", "linear", "0.1, 0.2, 0.3", "7"):
        assert text in told
