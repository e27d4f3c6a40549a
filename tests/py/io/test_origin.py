"""What was taken off a path's positions, in documents."""

import json

import pytest
from nfopidn import Scenario, Trajectory

FAR = Trajectory.from_samples([0, 1, 2, 3], [0, 0, 0, 0], 1.0, origin=(4e6, -3.5))


def test_documents_keep_it(sim, tmp_path):
    path, again = tmp_path / "far.json", tmp_path / "again.json"
    Scenario(FAR, rng=0).save(path)
    assert json.loads(path.read_text())["trajectory"]["origin"] == [4e6, -3.5]
    assert sim("--scenario", path, "--save-scenario", again, "--quiet").returncode in (0, 3)
    assert Scenario.load(again).trajectory == FAR
    assert Scenario.load(again).trajectory.origin == (4e6, -3.5)
    near = Trajectory.from_samples([0, 1, 2, 3], [0, 0, 0, 0], 1.0)
    assert "origin" not in json.loads(Scenario(near, rng=0).to_json())["trajectory"]


@pytest.mark.parametrize(
    ("origin", "message"),
    [
        ([1], "trajectory.origin must be a list of 2 numbers"),
        (3, "trajectory.origin must be a list of numbers"),
        ([0, 2e9], r"trajectory.origin\[1\] is 2e\+09"),
        ([0, "a"], r"trajectory.origin\[1\]"),
    ],
)
def test_bad_ones_are_refused(origin, message):
    document = json.loads(Scenario(FAR, rng=0).to_json())
    document["trajectory"]["origin"] = origin
    with pytest.raises(ValueError, match=message):
        Scenario.from_json(json.dumps(document))


def test_named_paths_have_none():
    document = json.loads(Scenario(Trajectory.circle(), rng=0).to_json())
    document["trajectory"]["origin"] = [1, 2]
    with pytest.raises(ValueError, match=r"trajectory.origin"):
        Scenario.from_json(json.dumps(document))
