"""Scenario.friction_feedforward: reference torques that make up for the friction of the wheels."""

import json
import re

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Robot, Scenario, Trajectory, simulate

VISCOUS, COULOMB, SPEED = 0.02, 0.15, 0.4
FRICTION = {"friction_feedforward": (VISCOUS, COULOMB), "friction_feedforward_speed": SPEED}
MODEL = Robot(mass=9.0, inertia=0.4, track_width=0.4, wheel_radius=0.08)


def friction_of_wheels(scenario, robot):
    """Give what the friction takes of each wheel's torque (N, 2), by the textbook."""
    path = scenario.trajectory
    turn = path.omega * robot.track_width / 2
    speeds = np.column_stack([path.v + turn, path.v - turn]) / robot.wheel_radius
    return VISCOUS * speeds + COULOMB * np.tanh(speeds / SPEED)


def test_none_is_the_default_and_changes_no_bit():
    scenario = Scenario.published(rng=0)
    assert scenario.friction_feedforward == (0, 0)
    assert not {"friction_feedforward", "friction_feedforward_speed"} & set(
        json.loads(scenario.to_json())
    )
    smoothed = scenario.replace(friction_feedforward_speed=3.0)
    assert np.array_equal(smoothed.reference, scenario.reference)
    assert simulate(smoothed).cost == simulate(scenario).cost


@pytest.mark.parametrize("model", [None, MODEL])
def test_the_reference_torques_have_the_friction_of_the_model(model):
    scenario = Scenario.published(rng=0, model=model)
    before, after = scenario.reference, scenario.replace(**FRICTION).reference
    expected = before[:, 5:7] + friction_of_wheels(scenario, model or scenario.robot)
    assert np.allclose(after[:, 5:7], expected, rtol=0, atol=1e-14)
    rest = [0, 1, 2, 3, 4, 7]
    assert np.array_equal(after[:, rest], before[:, rest])


def test_the_limit_holds_for_the_whole_torque():
    whole = Scenario.published(rng=0, **FRICTION)
    limited = whole.replace(feedforward_limit=0.3).reference[:, 5:7]
    assert np.array_equal(limited, np.clip(whole.reference[:, 5:7], -0.3, 0.3))


def test_a_robot_with_that_friction_stays_on_its_path_by_feedforward_alone():
    circle = Scenario(
        Trajectory.circle(period=40.0, dt=0.02, derivatives="analytic"),
        viscous_friction=VISCOUS,
        coulomb_friction=COULOMB,
        initial_velocity="reference",
        integrator="exact",
        rng=0,
    )
    silent = Controller(np.zeros((3, 3)), (1, 1, 1), (1, 1, 1))
    assert simulate(circle, silent).metrics["position_rms"] > 0.5
    # The wheels never come near standstill: tanh is 1 but for 1e-6.
    made_up = circle.replace(friction_feedforward=(VISCOUS, COULOMB))
    run = simulate(made_up, silent)
    assert run.metrics["position_rms"] < 1e-3
    # Eq. 41 compares the torques with those that the path really takes.
    assert run.cost < 1e-5
    assert simulate(circle, Controller.recommended(sample_time=circle.trajectory.dt)).cost > 0.01


def test_lanes_and_gradients_have_it_too():
    scenario = Scenario.published(rng=0, coulomb_friction=0.1, **FRICTION)
    objective = nfopidn.Objective(scenario, structure="decoupled")
    x = objective.parameters_of(Controller.published())
    expected = simulate(scenario, Controller.published(allocation="decoupled")).cost
    assert objective.costs(np.tile(x, (9, 1))) == pytest.approx(np.full(9, expected), rel=1e-9)
    cost, _ = objective.gradient(x)
    assert cost == pytest.approx(expected, rel=1e-9)


def test_it_stands_in_the_file_and_is_refused_out_of_range():
    scenario = Scenario.published(rng=0, **FRICTION)
    document = json.loads(scenario.to_json())
    assert document["friction_feedforward"] == [VISCOUS, COULOMB]
    assert document["friction_feedforward_speed"] == SPEED
    assert Scenario.from_json(scenario.to_json()) == scenario
    for bad in ((-1, 0), (0, np.nan), (0, 2e3)):
        with pytest.raises(ValueError, match=r"friction_feedforward\[\d\] is .*; must be"):
            scenario.replace(friction_feedforward=bad)
    with pytest.raises(ValueError, match=r"friction_feedforward is .*; must be a list of 2"):
        scenario.replace(friction_feedforward=(1,))
    for bad in (0, -1, np.inf):
        with pytest.raises(ValueError, match=r"friction_feedforward_speed is .*; must be"):
            scenario.replace(friction_feedforward_speed=bad)


def test_an_exported_table_holds_it(tmp_path):
    scenario = Scenario.published(rng=0, **FRICTION)
    nfopidn.export_c(Controller.recommended(), tmp_path, scenario=scenario, reference=True)
    text = next(tmp_path.glob("*_reference.c")).read_text()
    rows = re.findall(r"^    {(.*)}", text, re.MULTILINE)
    table = np.array([[float(n.strip("F")) for n in row.split(", ")] for row in rows])
    assert np.array_equal(
        table[:, -3:-1].astype(np.float32), scenario.reference[:, 5:7].astype(np.float32)
    )
