"""Scenario.model: the robot that the feedforward torques are reckoned with."""

import json

import numpy as np
import pytest
from nfopidn import Controller, Robot, Scenario, simulate
from nominal import tune

MODEL = Robot(9.0, 0.4, 0.4, 0.07)


def test_the_reference_torques_are_the_model_s():
    scenario = Scenario.published(model=MODEL, rng=0)
    path = scenario.trajectory
    drive = MODEL.mass * MODEL.wheel_radius * path.acceleration
    steer = 2 * MODEL.inertia * MODEL.wheel_radius / MODEL.track_width * path.turn_acceleration
    assert np.allclose(scenario.reference[:, 5], (drive + steer) / 2, rtol=1e-14, atol=1e-15)
    assert np.allclose(scenario.reference[:, 6], (drive - steer) / 2, rtol=1e-14, atol=1e-15)


def test_the_robot_moves_as_itself():
    still = {"feedforward": False, "initial_pose": (4, 0.2, 1)}
    with_model = simulate(Scenario.published(model=MODEL, rng=0, **still))
    without = simulate(Scenario.published(rng=0, **still))
    assert np.array_equal(with_model.pose, without.pose)
    assert with_model.cost != without.cost  # whose torque errors are from other references


def test_the_true_robot_as_model_is_none_to_the_bit():
    for robot in (Robot.eddie(), MODEL):
        scenario = Scenario.published(robot=robot, rng=0)
        named = scenario.replace(model=robot)
        assert simulate(named, Controller.published()).cost == simulate(scenario).cost
        assert named.replace(model=None) == scenario
        assert (named.model, scenario.model) == (robot, None)


def test_documents_without_a_model_are_as_they_were():
    document = json.loads(Scenario.published(rng=0).to_json())
    assert "model" not in document
    assert json.loads(Scenario.published(model=MODEL, rng=0).to_json())["model"] == {
        "mass": 9.0,
        "inertia": 0.4,
        "track_width": 0.4,
        "wheel_radius": 0.07,
    }
    assert Scenario.from_json(json.dumps({**document, "model": None})).model is None


def test_a_model_is_a_robot():
    with pytest.raises(TypeError, match="model must be a Robot"):
        Scenario.published(model=3)
    assert "model=Robot(mass=9.0, inertia=0.4" in repr(Scenario.published(model=MODEL, rng=0))


def test_a_rival_is_tuned_with_the_model():
    result = tune(Scenario.published(model=MODEL, rng=0), structure="samson", rng=0, maxfev=30)
    assert result.controller.robot == MODEL
