"""What simulate() returns: views that are read-only and outlive the result, and its CSV file."""

import gc
import operator
import os
import subprocess
import sys

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Robot, Scenario, Trajectory

COLUMNS = [
    *["t", "x_ref", "y_ref", "theta_ref", "x", "y", "theta", "v", "omega", "e_x", "e_y", "e_theta"],
    *["tau_ref_left", "tau_ref_right", "tau_fb_left", "tau_fb_right", "tau_left", "tau_right"],
]
DIVERGING = Controller.published(frame="world")


TRAJECTORY = ["x", "y", "theta", "v", "omega", "acceleration", "turn_acceleration"]

# Every array that can be had from a result.
VIEWS = (
    {name: operator.attrgetter(name) for name in ("t", "pose", "torque")}
    | {f"columns {name}": lambda result, name=name: result.columns[name] for name in COLUMNS}
    | {
        f"trajectory {name}": operator.attrgetter(f"scenario.trajectory.{name}")
        for name in TRAJECTORY
    }
)
each_view = pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS.keys())


def test_columns_are_the_run_table_in_order(published):
    assert list(published.columns) == COLUMNS
    assert len(published) == 751
    assert {column.shape for column in published.columns.values()} == {(751,)}


def test_pose_and_torque_are_columns(published):
    columns = published.columns
    assert np.array_equal(published.t, columns["t"])
    assert np.array_equal(published.pose.T, [columns[name] for name in ("x", "y", "theta")])
    assert np.array_equal(published.torque.T, [columns[name] for name in COLUMNS[-2:]])


@each_view
def test_views_are_read_only(view, published):
    array = view(published)
    assert not array.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        array[...] = 0
    with pytest.raises(ValueError, match="WRITEABLE"):
        array.flags.writeable = True


@pytest.mark.parametrize(
    "array",
    [
        Controller.published().gains,
        Controller.published().taps,
        Controller.published(allocation=np.ones((2, 3))).allocation,
        Scenario.published().reference,
        Scenario(Trajectory.line(), disturbance=np.ones((751, 2))).disturbance,
        Trajectory.line().t,
        Trajectory.line().reverse,
    ],
)
def test_other_arrays_are_read_only_too(array):
    with pytest.raises(ValueError, match="read-only"):
        array[...] = 0


@each_view
def test_views_are_views(view, published):
    assert not view(published).flags.owndata
    assert np.shares_memory(view(published), view(published))


@each_view
def test_a_view_keeps_the_run_alive(view):
    scenario = Scenario.published(period=400, rng=0)
    array = view(nfopidn.simulate(scenario))
    gc.collect()
    for memory in (2, 3):  # what would be written over freed memory
        nfopidn.simulate(scenario, Controller.published(memory))
    assert np.array_equal(array, view(nfopidn.simulate(scenario)))
    assert array.base is not None


def test_parts_of_a_result_outlive_it():
    result = nfopidn.simulate(Scenario.published(rng=5, robot=Robot.eddie_datasheet()))
    scenario, robot, controller = result.scenario, result.scenario.robot, result.controller
    del result
    gc.collect()
    nfopidn.simulate()
    assert scenario == Scenario.published(rng=5, robot=Robot.eddie_datasheet())
    assert robot == Robot.eddie_datasheet()
    assert controller == Controller.published()


def test_metrics_are_numbers_by_name(published):
    assert published.cost == published.metrics["cost"]
    assert all(type(value) is float for value in published.metrics.values())
    assert list(published.metrics) == [
        *["cost", "pose_mse", "position_rms", "position_max", "heading_rms", "iae", "ise", "itae"],
        *["torque_peak", "torque_variation", "share_at_limit", "energy", "lateral_force_peak"],
    ]


@pytest.mark.parametrize("controller", [Controller.published(), DIVERGING])
def test_csv_reads_back_to_the_last_bit(controller, tmp_path):
    result = nfopidn.simulate(controller=controller)
    path = tmp_path / "run.csv"
    result.to_csv(path)
    lines = path.read_text().splitlines()
    assert lines[0].split(",") == COLUMNS
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
    assert np.array_equal(rows, np.column_stack(list(result.columns.values())))


def test_names_need_not_be_utf_8(tmp_path):
    path = os.path.join(os.fsencode(tmp_path), b"\xff")
    for name in (path, os.fsdecode(path)):
        Controller.published(memory=3).save(name)
        assert Controller.load(name).memory == 3
        nfopidn.simulate().to_csv(name)
        with pytest.raises(ValueError, match=r"\\xff: not valid JSON"):
            Controller.load(name)


def test_an_open_log_is_written_on(tmp_path):
    """As by a shell's >>: what the C++ and what the Python side of the package writes."""
    program = """
import nfopidn
from nfopidn.files import replace_file
print("first")
replace_file("/dev/stdout", "second\\n")
nfopidn.simulate().to_csv("/dev/stdout")
print("last")
"""
    log = tmp_path / "log"
    log.write_text("before\n")
    with log.open("a") as stream:
        subprocess.run([sys.executable, "-c", program], stdout=stream, check=True)
    lines = log.read_text().splitlines()
    assert lines[:3] == ["before", "first", "second"]
    assert lines[3].split(",") == COLUMNS
    assert (len(lines), lines[-1]) == (4 + 751 + 1, "last")


def test_a_diverging_run_keeps_its_rows_and_says_when(published):
    assert published.diverged_at is None
    result = nfopidn.simulate(Scenario.published(rng=0), DIVERGING)
    rows = len(result)
    assert 0 < rows < 751
    assert result.diverged_at == rows * 0.2
    distance = np.hypot(result.columns["e_x"], result.columns["e_y"])
    assert distance.max() == result.metrics["position_max"] <= 10
    further = result.scenario.replace(divergence_distance=1000)
    longer = nfopidn.simulate(further, DIVERGING)
    assert np.array_equal(longer.pose[:rows], result.pose)
    assert np.hypot(longer.columns["e_x"], longer.columns["e_y"])[rows] > 10


def test_missing_samples_cost_the_distance_squared():
    result = nfopidn.simulate(controller=DIVERGING)
    columns = result.columns
    terms = sum(columns[name] ** 2 for name in ("e_x", "e_y", "e_theta"))
    for side in ("left", "right"):
        terms = terms + (columns[f"tau_ref_{side}"] - columns[f"tau_{side}"]) ** 2
    expected = (terms.sum() + (751 - len(result)) * 10.0**2) / 751
    assert result.cost == pytest.approx(expected, rel=1e-12)


def test_a_run_may_diverge_before_it_starts_to_move():
    start_on_the_edge = Scenario(
        Trajectory.line(period=3, dt=1, scale=100),
        initial_pose=(0.0, 10.0, 0.0),
        initial_velocity=(0.0, 0.0),
    )
    result = nfopidn.simulate(start_on_the_edge)
    assert len(result) == 1
    assert result.diverged_at == 1.0
    assert result.metrics["torque_variation"] == 0
    assert result.pose.shape == (1, 3)
