"""Runs in MuJoCo against the product's own plant, and what ends them."""

import copy
import os
import pickle
import sys
import types
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np
import pytest
from nfopidn import Controller, Rival, Robot, Scenario, Trajectory, score, simulate
from nfopidn.mujoco import Caster, build_model, run
from nfopidn.mujoco.machine import Machine

#: The paper's path with a steady heading, 50 s a lap.
FAST = Scenario.published(heading="continuous", period=50.0, rng=0, integrator="exact")
TRACKING = Controller.recommended()
SOFT = [Caster(0.17, contact_time=0.2), Caster(-0.17, contact_time=0.2)]


def point_contacts(step, *, contact_steps=4, **settings):
    """A model with next to no wheel mass whose contacts harden as the step shrinks."""
    settings = {"wheel_mass": 1e-5 * 11.5, "armature": 0.0} | settings
    return build_model(contact_time=contact_steps * step, **settings)


def test_the_engine_goes_to_the_exact_integrator():
    """Without friction, scrub and wheel mass, cost and pose: an error of first order in the step.

    The contacts' time constant shrinks with the step: what a turning wheel slips is as long as it.
    """
    exact = simulate(FAST, TRACKING)
    costs, poses = [], []
    for step in (0.004, 0.002, 0.001):
        result = run(FAST, TRACKING, model=point_contacts(step), step=step)
        costs.append(result.cost / exact.cost - 1)
        poses.append(np.abs(result.pose - exact.pose).max())
    assert abs(costs[-1]) < 2e-4
    assert poses[-1] < 1.5e-3
    for errors in (costs, poses):
        ratios = np.array(errors[:-1]) / np.array(errors[1:])
        np.testing.assert_allclose(ratios, 2.0, atol=0.3)


@pytest.mark.parametrize("wheels", ["ellipsoid", "sphere"])
def test_wheels_with_mass_are_a_robot_of_effective_mass(wheels):
    """The same engine beside simulate() with what the wheels' spin adds, in closed form."""
    mass, rotor = 0.4, 0.001
    result = run(FAST, TRACKING, wheels, wheel_mass=mass, armature=rotor, contact_time=0.008)
    added = 2 * (mass * 0.076**2 / 2 + rotor) / 0.076**2
    robot = FAST.robot.replace(mass=11.5 + added, inertia=0.5873 + added * (0.452 / 2) ** 2)
    effective = simulate(FAST.replace(robot=robot, model=FAST.robot), TRACKING)
    assert result.cost == pytest.approx(effective.cost, rel=2e-3)
    assert abs(simulate(FAST, TRACKING).cost / effective.cost - 1) > 0.01


def test_left_is_the_paper_s_left():
    """A positive left torque turns the robot counter-clockwise; it acts on the right wheel."""
    machine = Machine(build_model(), 0.002, "Euler", FAST.replace(initial_pose=(0, 0, 0)))
    acted = machine.move((0.2, 0.0), (0.0, 0.0), 50)
    assert machine.state[4] == pytest.approx(0.2 * 0.226 / 0.076 / 0.5873 * 0.1, rel=0.03)
    left, right = machine.wheel_angles
    assert right > abs(left)
    assert acted == pytest.approx((0.2, 0.0), abs=1e-12)


def test_wheels_roll_from_the_start():
    """A robot that is set in motion rolls on: its wheels, with a good deal of spin, do not skid."""
    v, omega = 0.3, 0.8
    scenario = FAST.replace(initial_pose=(0, 0, 0.4), initial_velocity=(v, omega))
    machine = Machine(build_model(wheel_mass=1.0, armature=0.01), 0.002, "Euler", scenario)
    machine.move((0.0, 0.0), (0.0, 0.0), 20)
    np.testing.assert_allclose(machine.state[3:], (v, omega), rtol=2e-3)
    left, right = (machine.data.qvel[dof] for dof in machine.dofs)
    assert left == pytest.approx((v - omega * 0.226) / 0.076, rel=5e-3)
    assert right == pytest.approx((v + omega * 0.226) / 0.076, rel=5e-3)


@pytest.mark.parametrize(
    "changes",
    [
        {"disturbance": (3.0, -0.3)},
        {"delay": 1},
        {"pose_noise": (0.004, 0.004), "rng": 3},
        {"feedforward": False},
        {"initial_velocity": "reference"},
        {"initial_pose": (4.6, 0.3, 0.2), "initial_velocity": (0.2, -0.1)},
        {"coulomb_friction": 0.05},
        {"viscous_friction": 0.02},
        {"torque_limit": 0.3},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_what_acts_in_a_scenario_acts_in_the_engine(changes):
    """Against simulate(); and the change must matter, or the test would show nothing."""
    scenario = FAST.replace(**changes)
    light = {"wheel_mass": 1e-3, "armature": 1e-5, "contact_time": 0.008}
    result = run(scenario, TRACKING, **light)
    expected = simulate(scenario, TRACKING)
    assert result.cost == pytest.approx(expected.cost, rel=0.02)
    assert abs(expected.cost / simulate(FAST, TRACKING).cost - 1) > 0.025
    np.testing.assert_allclose(result.pose[0], expected.pose[0], atol=1e-9)


def test_heavy_wheels_are_a_robot_with_wheels():
    """What Robot.with_wheels() adds is what the engine's wheels and rotors add by turning."""
    robot, armature, mass = FAST.robot, 0.01, 0.2
    result = run(FAST, TRACKING, armature=armature, wheel_mass=mass, contact_time=0.008)
    loaded = robot.with_wheels(0.5 * mass * robot.wheel_radius**2 + armature)
    expected = simulate(FAST.replace(robot=loaded, model=robot), TRACKING)
    assert result.cost == pytest.approx(expected.cost, rel=0.002)
    assert abs(expected.cost / simulate(FAST, TRACKING).cost - 1) > 0.1


def test_a_result_is_one_of_simulate_s():
    scenario = FAST.replace(delay=1)
    result = run(scenario, TRACKING)
    assert type(result) is type(simulate(scenario))
    assert result.controller == TRACKING
    assert run(Scenario.published(rng=0), Rival("samson")).controller == Rival("samson")
    assert result.scenario == scenario
    assert len(result) == 251
    assert result.diverged_at is None
    assert score(result.columns, scenario).metrics == result.metrics
    again = pickle.loads(pickle.dumps(result))
    assert copy.copy(again).cost == result.cost


def test_the_same_run_has_the_same_bits():
    one, other = (run(FAST, TRACKING, "cylinder", 0.05) for _ in range(2))
    np.testing.assert_array_equal(one.pose, other.pose)
    np.testing.assert_array_equal(one.torque, other.torque)


def test_torques_are_those_of_the_joints():
    """The motors' own limit is in the record, also where it is another than the controller's."""
    limited = run(FAST, TRACKING, torque_limit=0.05)
    assert np.abs(limited.torque).max() == 0.05
    assert limited.metrics["torque_peak"] == 0.05
    free = run(FAST, TRACKING)
    assert np.abs(free.torque).max() > 0.2


def test_a_torque_under_way_is_recorded_where_it_was_commanded():
    scenario = FAST.replace(delay=2)
    result = run(scenario, TRACKING)
    law = TRACKING.copy()
    law.start(scenario)
    for k in range(20):
        np.testing.assert_allclose(
            result.torque[k], law.step(result.pose[k], scenario.reference[k]), atol=1e-12
        )


def test_steps_are_counted(monkeypatch):
    """So many steps a sample, however the sum of their times is rounded."""
    counted = []
    real = mujoco.mj_step

    def count(model, data, nstep=1):
        counted.append(nstep)
        real(model, data, nstep=nstep)

    monkeypatch.setattr(mujoco, "mj_step", count)
    run(FAST, TRACKING, step=0.004)
    assert counted[0] == 250  # to come to rest
    assert counted[1:] == [50] * 251


def test_the_pose_is_not_a_step_old():
    """With steps as long as a sample a pose of before would be a whole sample of delay."""
    scenario = Scenario(
        Trajectory.circle(period=20.0, dt=0.02), initial_velocity="reference", rng=0
    )
    law = Controller.recommended(sample_time=0.02, peak_speed=scenario.trajectory.peak_speed)
    result = run(scenario, law, step=0.02, contact_time=0.04, wheel_mass=1e-3)
    expected = simulate(scenario, law)
    np.testing.assert_allclose(result.pose[:40], expected.pose[:40], atol=2e-3)
    delayed = simulate(scenario.replace(delay=1), law)
    assert np.abs(delayed.torque[2] - expected.torque[2]).max() > 1e-4


# --- the encoders ------------------------------------------------------------------------------


def test_odometry_on_wheels_that_grip_is_the_truth():
    gripping = {"casters": SOFT, "contact_time": 0.004, "floor": 5.0, "cone": "elliptic"}
    exact = run(FAST, TRACKING, **gripping)
    seen = run(FAST, TRACKING, odometry=True, **gripping)
    assert seen.cost == pytest.approx(exact.cost, rel=0.03)
    assert seen.cost != exact.cost


def test_odometry_believes_in_wheels_that_slip():
    """On a slippery floor the true pose leaves the estimate; the result has the true one."""
    with_truth = run(FAST, TRACKING, floor=0.2, cone="elliptic")
    blind = run(FAST, TRACKING, floor=0.2, cone="elliptic", odometry=True)
    assert with_truth.metrics["position_rms"] < 0.2
    assert blind.metrics["position_rms"] > 1.0


def test_counts_of_the_encoder_count():
    fine = run(FAST, TRACKING, odometry=True)
    coarse = run(FAST, TRACKING, odometry=True, counts=20)
    many = run(FAST, TRACKING, odometry=True, counts=10**6)
    assert coarse.cost > 1.05 * fine.cost
    assert many.cost == pytest.approx(fine.cost, rel=1e-3)


# --- wheels and friction -----------------------------------------------------------------------


def test_cylinders_scrub():
    costs = [run(FAST, TRACKING, wheels).cost for wheels in ("ellipsoid", "cylinder")]
    narrow = run(FAST, TRACKING, "cylinder", wheel_width=0.002).cost
    round_cone = run(FAST, TRACKING, "cylinder", cone="elliptic").cost
    assert round_cone > 2 * costs[1]
    assert costs[1] > 2 * costs[0]
    assert narrow < 1.5 * costs[0]


def test_joint_friction_is_the_scenario_s_and_the_argument_s():
    own = run(FAST.replace(coulomb_friction=0.1), TRACKING)
    given = run(FAST, TRACKING, joint_friction=0.1)
    both = run(FAST.replace(coulomb_friction=0.06), TRACKING, joint_friction=0.04)
    assert own.cost == given.cost
    assert both.cost == pytest.approx(own.cost, rel=1e-9)


@pytest.mark.parametrize("contact_time", [0.02, 0.01])
def test_a_wheel_slips_outward_in_a_turn_by_the_contact_time(contact_time):
    """By v omega times it, times half of the impedance's upper limit: what the docs say."""
    v, omega = 0.6, 0.5
    scenario = FAST.replace(initial_pose=(0, 0, 0), initial_velocity=(v, omega))
    model = build_model(contact_time=contact_time, cone="elliptic")
    machine = Machine(model, 0.002, "Euler", scenario)
    machine.move((0.0, 0.0), (0.0, 0.0), 250)
    speed = machine.data.qvel[machine.speed : machine.speed + 2]
    theta = machine.state[2]
    side = speed[1] * np.cos(theta) - speed[0] * np.sin(theta)
    assert side == pytest.approx(-v * omega * contact_time * 0.95 / 2, rel=0.2)


def test_why_implicit_integrators_are_refused():
    """Wheels on velocity servos skid under them."""
    slips = {}
    for word in ("mjINT_IMPLICITFAST", "mjINT_DISCRETE"):
        spec = build_model().spec
        spec.option.timestep = 0.002
        spec.option.integrator = getattr(mujoco.mjtIntegrator, word)
        for servo in spec.actuators:
            servo.set_to_velocity(kv=2.0)
        engine = spec.compile()
        data = mujoco.MjData(engine)
        mujoco.mj_step(engine, data, nstep=500)
        data.ctrl[:] = 5.0
        mujoco.mj_step(engine, data, nstep=200)
        slips[word] = abs(data.qvel[6] * 0.076 - data.qvel[0])
    assert slips["mjINT_IMPLICITFAST"] > 10 * slips["mjINT_DISCRETE"]


def test_discrete_rolls_as_euler():
    costs = [run(FAST, TRACKING, integrator=word).cost for word in ("Euler", "discrete")]
    assert costs[1] == pytest.approx(costs[0], rel=5e-3)


# --- runs that end early -----------------------------------------------------------------------


def test_a_run_that_diverges_is_told_with_time_and_reason(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scenario = Scenario.published(rng=0, delay=10, divergence_distance=2.0)
    with pytest.warns(UserWarning, match=r"diverges at .* s: the robot is .* m from its ref"):
        result = run(scenario, Controller.published())
    assert result.diverged_at is not None
    assert len(result) == round(result.diverged_at / 0.2)
    expected = score(result.columns, scenario, lost=True)
    assert result.cost == expected.cost
    assert os.listdir(tmp_path) == []


def test_an_unstable_engine_is_no_fresh_start(tmp_path, monkeypatch, capfd):
    """Without autoreset, with the warnings read: where MuJoCo would go on from the start pose."""
    monkeypatch.chdir(tmp_path)
    model = build_model()
    model.spec.joint("left").stiffness = [-1e9, 0, 0]
    seen = mujoco.get_mju_user_warning()
    with pytest.warns(UserWarning, match=r"diverges at .* s: MuJoCo counts mjWARN_BAD"):
        result = run(FAST, TRACKING, model=model)
    assert result.diverged_at is not None
    assert result.cost > 90
    assert os.listdir(tmp_path) == []
    assert capfd.readouterr() == ("", "")
    assert mujoco.get_mju_user_warning() is seen


def test_a_robot_that_falls_over_is_told():
    with pytest.warns(UserWarning, match="the robot has tipped over"):
        result = run(FAST, TRACKING, casters=[])
    assert result.diverged_at is not None


def test_another_s_warning_handler_comes_back():
    heard = []
    mujoco.set_mju_user_warning(heard.append)
    try:
        run(FAST, TRACKING)
        assert mujoco.get_mju_user_warning() == heard.append
        model = build_model()
        model.spec.joint("left").stiffness = [-1e9, 0, 0]
        with pytest.warns(UserWarning, match="diverges"):
            run(FAST, TRACKING, model=model)
        assert heard == []
    finally:
        mujoco.set_mju_user_warning(None)


# --- refusals ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scenario": 3}, "scenario is 3"),
        ({"controller": "mine"}, "controller is 'mine'; must be a Controller or a Rival"),
        (
            {"controller": Controller.recommended(sample_time=0.1)},
            "sample_time of the controller is 0.1 s",
        ),
        (
            {"step": 0.003},
            "step is 0.003 s: the sample time, 0.2 s, is 66.6667 of them; must be a whole number, "
            "as with step=0.0025",
        ),
        ({"step": 0.0}, "step is 0.0"),
        ({"step": 0.05}, r"step is 0.05 s and the shortest contact_time 0.02 s"),
        ({"integrator": "implicitfast"}, "'implicitfast': under it wheels on servos skid"),
        ({"integrator": "euler"}, "did you mean 'Euler'"),
        ({"odometry": 1}, "odometry is 1"),
        ({"counts": 144}, "counts is 144 without odometry"),
        ({"counts": 0.5, "odometry": True}, "counts is 0.5; must be a whole number"),
        ({"wheels": "square"}, "wheels is 'square'"),
        ({"joint_friction": -1.0}, "joint_friction is -1.0"),
        ({"model": "robot.xml"}, "model is 'robot.xml'; must be a Model"),
        ({"scenario": FAST.replace(viscous_scrub=0.1)}, "viscous_scrub is 0.1; must be 0 here"),
        ({"scenario": FAST.replace(coulomb_scrub=0.2)}, "coulomb_scrub is 0.2; must be 0 here"),
        ({"model": build_model(), "wheels": "sphere"}, "wheels cannot be given with a model"),
        ({"model": build_model(), "slope": 0.1}, "slope cannot be given with a model"),
        (
            {"model": build_model(), "scenario": FAST.replace(coulomb_friction=0.1)},
            "coulomb_friction is 0.1; with a model it must be 0",
        ),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        run(**arguments)


def test_unknown_settings_are_refused():
    with pytest.raises(TypeError, match="wheel_radius"):
        run(FAST, TRACKING, wheel_radius=0.1)


def test_a_missing_extra_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ImportError, match=r'pip install "nfopidn\[physics\]"'):
        build_model()
    old = types.SimpleNamespace(__version__="3.4.0")
    monkeypatch.setitem(sys.modules, "mujoco", old)
    with pytest.raises(ImportError, match=r"needs MuJoCo 4 and found 3.4.0"):
        run(FAST, TRACKING)


def test_a_model_of_another_robot_is_warned_of():
    heavy = FAST.replace(robot=Robot(mass=12.5))
    with pytest.warns(UserWarning, match="another robot than the scenario's: mass 11.5, the sc"):
        run(heavy, TRACKING, model=build_model())


def test_runs_at_a_time_are_those_one_by_one():
    """In threads; the handler of warnings, which is the process's, comes back after the last."""
    alone = [run(FAST, TRACKING, wheels) for wheels in ("ellipsoid", "cylinder")]
    with ThreadPoolExecutor(2) as pool:
        together = list(
            pool.map(lambda wheels: run(FAST, TRACKING, wheels), ("ellipsoid", "cylinder"))
        )
    for one, other in zip(alone, together, strict=True):
        np.testing.assert_array_equal(one.pose, other.pose)
    assert mujoco.get_mju_user_warning() is None


def test_a_robot_of_another_kind_is_warned_of():
    with pytest.warns(UserWarning, match="made for another robot"):
        run(FAST.replace(robot=Robot(mass=20.0)), TRACKING)
