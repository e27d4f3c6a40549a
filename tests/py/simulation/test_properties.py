"""What holds for every scenario and every controller."""

import json
import math
import os
import pickle

import nfopidn
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from nfopidn import Controller, Scenario, Trajectory
from strategies import (
    controllers,
    decoupled_controllers,
    named_trajectories,
    numbers,
    ordinary_robots,
    robots,
    sampled_trajectories,
    scenarios,
    walks,
)

TIMES = int(os.environ.get("NFOPIDN_EXAMPLES", "1"))  # 100 for a long search


def examples(count):
    return settings(
        max_examples=count * TIMES,
        deadline=None,
        derandomize=TIMES == 1,
        database=None,
        suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    )


def columns(result):
    return np.column_stack(list(result.columns.values()))


@pytest.mark.filterwarnings("ignore:the heading holds")
@examples(150)
@given(scenarios(), controllers)
def test_every_run_has_a_finite_cost(scenario, controller):
    result = nfopidn.simulate(scenario, controller)
    assert math.isfinite(result.cost)
    assert result.cost >= 0
    samples = len(scenario.trajectory)
    assert len(result) <= samples
    assert (result.diverged_at is None) == (len(result) == samples)
    assert np.isfinite(result.pose).all()
    assert np.isfinite(result.torque).all()
    assert (np.abs(result.torque) <= scenario.torque_limit).all()
    distance = np.hypot(result.columns["e_x"], result.columns["e_y"])
    assert (distance <= scenario.divergence_distance * (1 + 1e-12)).all()
    assert (np.abs(result.columns["e_theta"]) <= math.pi).all()


@examples(60)
@given(scenarios(), controllers)
def test_a_run_depends_on_its_inputs_alone(scenario, controller):
    first = nfopidn.simulate(scenario, controller)
    nfopidn.simulate(Scenario.published(), controller)
    second = nfopidn.simulate(scenario, controller)
    assert np.array_equal(columns(first), columns(second))
    assert first.metrics == second.metrics
    again = pickle.loads(pickle.dumps(first))
    assert np.array_equal(columns(again), columns(first))
    assert again.metrics == first.metrics


@examples(100)
@given(value=st.one_of(scenarios(), controllers))
def test_a_document_is_the_value(value, tmp_path):
    path = tmp_path / "document.json"
    value.save(path)
    loaded = type(value).load(path)
    assert loaded == value
    assert hash(loaded) == hash(value)
    written = path.read_bytes()
    loaded.save(path)
    assert path.read_bytes() == written
    assert value.replace() == value


@pytest.mark.filterwarnings("ignore:the heading holds")
@examples(100)
@given(st.one_of(robots, named_trajectories(), sampled_trajectories()))
def test_a_pickle_is_the_value(value):
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        assert_twin(value, pickle.loads(pickle.dumps(value, protocol)))


def assert_twin(value, twin):
    assert twin == value
    assert hash(twin) == hash(value)


@pytest.mark.filterwarnings("ignore:the heading holds")
@examples(40)
@given(scenario=scenarios(), controller=controllers)
def test_the_executable_runs_the_same(sim, tmp_path, scenario, controller):
    files = [tmp_path / "scenario.json", tmp_path / "controller.json"]
    scenario.save(files[0])
    controller.save(files[1])
    run = sim("--scenario", files[0], "--controller", files[1], "--json")
    result = nfopidn.simulate(scenario, controller)
    assert run.returncode == (0 if result.diverged_at is None else 3), run.stderr
    expected = result.metrics | {"samples": len(result), "diverged_at": result.diverged_at}
    assert json.loads(run.stdout) == expected


@examples(60)
@given(st.one_of(named_trajectories(), sampled_trajectories(10.0)))
def test_a_trajectory_is_consistent(path):
    arrays = [path.x, path.y, path.theta, path.v, path.omega, path.acceleration]
    arrays += [path.turn_acceleration, path.reverse, path.t]
    assert {array.shape for array in arrays} == {(len(path),)}
    assert all(np.isfinite(array).all() for array in arrays)
    assert path.peak_speed == np.abs(path.v).max()
    if path.heading == "forward":
        assert (path.v >= 0).all()
        assert not path.reverse.any()
    moving = np.abs(path.v) > 1e-6
    assert np.array_equal(path.reverse[moving], path.v[moving] < 0)


@examples(60)
@given(controllers)
def test_vectors_and_taps(controller):
    vector = controller.to_vector()
    assert len(vector) in (11, 15)
    names = ["memory", "form", "allocation", "activation", "frame", "generator", "lateral"]
    names += ["speed_scale", "anti_windup", "sample_time"]
    structure = {name: getattr(controller, name) for name in names}
    assert Controller.from_vector(vector, **structure) == controller
    assert controller.taps.shape == (3, controller.memory + 2)
    assert np.isfinite(controller.taps).all()
    halved = controller.replace(gains=controller.gains / 2)
    np.testing.assert_allclose(halved.taps * 2, controller.taps, rtol=1e-12, atol=1e-300)


def on_a_path(x, y, **changes):
    base = {
        "initial_pose": (x[0] + 0.1, y[0] - 0.2, 0.3),
        "initial_velocity": (0.1, -0.2),
        "disturbance": (0.3, 0.05),
        "viscous_friction": 0.01,
        "divergence_distance": 5.0,
        "rng": 0,
    }
    heading = changes.pop("heading", "forward")
    return Scenario(Trajectory.from_samples(x, y, 0.2, heading=heading), **(base | changes))


surroundings = st.fixed_dictionaries(
    {
        "robot": ordinary_robots,
        "integrator": st.sampled_from(["semi-implicit-euler", "exact"]),
        "heading": st.sampled_from(["forward", "continuous"]),
        "delay": st.integers(0, 3),
        "feedforward": st.booleans(),
    }
)


@examples(60)
@given(walks(), decoupled_controllers, surroundings)
def test_mirrored_runs_agree(walk, controller, same):
    """Seen in a mirror along the x axis, a decoupled run is the run of the mirrored scenario."""
    x, y = walk
    original = on_a_path(x, y, **same)
    mirrored = on_a_path(
        x,
        -y,
        initial_pose=(x[0] + 0.1, -(y[0] - 0.2), -0.3),
        initial_velocity=(0.1, 0.2),
        disturbance=(0.3, -0.05),
        **same,
    )
    one = nfopidn.simulate(original, controller)
    other = nfopidn.simulate(mirrored, controller)
    assert len(one) == len(other)
    np.testing.assert_allclose(other.pose, one.pose * (1, -1, -1), rtol=0, atol=1e-12)
    np.testing.assert_allclose(other.torque, one.torque[:, ::-1], rtol=0, atol=1e-12)
    assert other.cost == pytest.approx(one.cost, rel=1e-12)


@examples(40)
@given(walks(), ordinary_robots, numbers(-3, 3), numbers(-3, 3), st.integers(-3, 3))
def test_a_run_does_not_depend_on_where_it_is(walk, robot, shift, turn, whole_turns):
    """Moved and turned as a whole, scenario and run agree, and whole turns do not count."""
    x, y = walk
    cosine, sine = math.cos(turn), math.sin(turn)

    def moved(px, py):
        return shift + cosine * px - sine * py, cosine * py + sine * px - shift

    controller = Controller.published(allocation="decoupled")
    one = nfopidn.simulate(on_a_path(x, y, robot=robot), controller)
    start = moved(x[0] + 0.1, y[0] - 0.2)
    pose = (*start, 0.3 + turn + 2 * math.pi * whole_turns)
    other = nfopidn.simulate(on_a_path(*moved(x, y), robot=robot, initial_pose=pose), controller)
    np.testing.assert_allclose(other.torque, one.torque, rtol=0, atol=1e-8)
    expected = np.column_stack(moved(one.pose[:, 0], one.pose[:, 1]))
    np.testing.assert_allclose(other.pose[:, :2], expected, rtol=0, atol=1e-8)


@examples(40)
@given(walks(), controllers, st.integers(0, 64), st.integers(1, 50))
def test_the_beginning_of_a_run_does_not_depend_on_its_end(walk, controller, delay, cut):
    """Causality: a disturbance from some sample on leaves everything before it as it was."""
    x, y = walk
    cut = min(cut, len(x) - 1)
    wind = np.zeros((len(x), 2))
    calm = nfopidn.simulate(on_a_path(x, y, disturbance=wind, delay=delay), controller)
    wind[cut:] = (5.0, 1.0)
    windy = nfopidn.simulate(on_a_path(x, y, disturbance=wind, delay=delay), controller)
    rows = min(cut + 1, len(calm))
    assert np.array_equal(columns(calm)[:rows], columns(windy)[:rows])
