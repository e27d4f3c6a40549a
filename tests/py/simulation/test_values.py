"""The objects as values: equality, hash, pickle, copies, changed copies, files."""

import copy
import pickle

import every_field
import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Robot, Scenario, Trajectory

X = np.array([0.0, 0.3, 0.5, 0.4])
Y = np.array([0.0, 0.1, 0.3, 0.7])
SAMPLES = Trajectory.from_samples(X, Y, 0.1)
CLOSED = Trajectory.from_samples([0, 1, 1, 0], [0, 0, 1, 0], 0.5, heading="continuous", laps=2)

VALUES = {
    "robot": Robot(3.3, 0.1, 0.2, 0.05),
    "named path": Trajectory.ranunculoid(40, 0.1, 5, "continuous", 0.7, 2, "analytic"),
    "samples": SAMPLES,
    "closed samples": CLOSED,
    "scenario": Scenario.published(rng=3),
    "every field": every_field.SCENARIO,
    "controller": Controller.published(),
    "every setting": every_field.CONTROLLER,
}
values = pytest.mark.parametrize("value", VALUES.values(), ids=VALUES.keys())
COPIES = [copy.copy, copy.deepcopy] + [
    lambda value, protocol=protocol: pickle.loads(pickle.dumps(value, protocol))
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1)
]


@values
@pytest.mark.parametrize("duplicate", COPIES)
def test_a_copy_is_equal(value, duplicate):
    twin = duplicate(value)
    assert twin is not value
    assert type(twin) is type(value)
    assert twin == value
    assert (twin != value) is False
    assert hash(twin) == hash(value)
    assert repr(twin) == repr(value)


@pytest.mark.parametrize("name", VALUES)
def test_different_values_are_not_equal(name):
    assert [other for other, value in VALUES.items() if value == VALUES[name]] == [name]
    assert VALUES[name] != name
    assert len({hash(value) for value in VALUES.values()}) == len(VALUES)


@pytest.mark.parametrize("name", ["x", "y"])
def test_samples_differ_in_a_single_bit(name):
    changed = {"x": X.copy(), "y": Y.copy()}
    changed[name][2] = np.nextafter(changed[name][2], 1)
    assert Trajectory.from_samples(**changed, dt=0.1) != SAMPLES


def test_what_is_equal_has_one_hash():
    plus = Scenario(SAMPLES, initial_velocity=(0.0, 0.0), rng=0)
    minus = Scenario(SAMPLES, initial_velocity=(0.0, -0.0), rng=0)
    assert plus != minus or hash(plus) == hash(minus)


@pytest.mark.parametrize("duplicate", COPIES)
def test_a_copied_controller_starts_afresh(duplicate, published):
    controller = Controller.published()
    reference = published.scenario.reference
    first = controller.step(published.pose[0], reference[0])
    controller.step(published.pose[1], reference[1])
    assert duplicate(controller).step(published.pose[0], reference[0]) == first


@pytest.mark.parametrize("period", [150, 25], ids=["published", "diverging"])
@pytest.mark.parametrize("duplicate", COPIES)
def test_a_copied_result_is_the_same_run(duplicate, period):
    result = nfopidn.simulate(Scenario.published(period=period, rng=1))
    twin = duplicate(result)
    assert (twin.metrics, twin.diverged_at) == (result.metrics, result.diverged_at)
    assert (twin.scenario, twin.controller) == (result.scenario, result.controller)
    for name, column in result.columns.items():
        assert np.array_equal(twin.columns[name], column)
    assert repr(twin) == repr(result)


@pytest.mark.parametrize("name", ["scenario", "every field", "controller", "every setting"])
def test_files_keep_everything(name, tmp_path):
    value = VALUES[name]
    path = tmp_path / "document.json"
    value.save(path)
    assert type(value).load(path) == value
    assert type(value).load(str(path)) == value
    value.save(path)  # over the old one
    assert [entry.name for entry in tmp_path.iterdir()] == ["document.json"]


@pytest.mark.parametrize("method", ["save", "load", "to_csv", "from_csv"])
def test_a_path_may_be_bytes(method, tmp_path, published):
    csv = tmp_path / "run.csv"
    json = tmp_path / "controller.json"
    published.to_csv(csv)
    Controller.published().save(json)
    target = {"save": tmp_path / "new", "load": json, "to_csv": tmp_path / "new", "from_csv": csv}
    owners = {
        "save": Controller.published(),
        "load": Controller,
        "to_csv": published,
        "from_csv": Trajectory,
    }
    getattr(owners[method], method)(bytes(target[method]))
    assert target[method].exists()


def test_the_trajectory_of_a_loaded_scenario_has_the_same_arrays(tmp_path):
    scenario = Scenario(CLOSED)
    scenario.save(tmp_path / "scenario.json")
    loaded = Scenario.load(tmp_path / "scenario.json").trajectory
    for name in ("t", "x", "y", "theta", "v", "omega", "acceleration", "reverse"):
        assert np.array_equal(getattr(loaded, name), getattr(CLOSED, name))


@pytest.mark.parametrize(
    ("value", "changes"),
    [
        (VALUES["robot"], {"mass": 2.0}),
        (VALUES["every field"], {"delay": 3, "disturbance": (1.0, 2.0), "initial_pose": None}),
        (VALUES["every field"], {"robot": Robot(), "feedforward": True}),
        (VALUES["every setting"], {"memory": 3, "allocation": "paper", "alpha": 0.5}),
    ],
)
def test_replace_changes_only_what_it_names(value, changes):
    before = repr(value)
    changed = value.replace(**changes)
    for name in (name for name in dir(value) if isinstance(getattr(type(value), name), property)):
        expected = changes.get(name, getattr(value, name))
        if name not in ("taps", "reference"):
            assert np.array_equal(getattr(changed, name), expected), name
    assert repr(value) == before
    assert value.replace() == value


def test_replace_refuses_a_path_that_no_longer_fits():
    with pytest.raises(ValueError, match="disturbance"):
        VALUES["every field"].replace(trajectory=CLOSED)
    changed = VALUES["every field"].replace(trajectory=CLOSED, disturbance=(0, 0))
    assert changed.trajectory == CLOSED
