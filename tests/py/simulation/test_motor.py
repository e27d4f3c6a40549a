"""Scenario.motor: torques by DC motors, from a supply that cannot give all of them."""

import json
import pickle

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Motor, Scenario, simulate
from scipy.integrate import solve_ivp

# A motor for Eddie: 7.2 V give 2.4 N m at standstill, and a free wheel 12 rad/s.
MOTOR = Motor(
    resistance=1.5,
    torque_constant=0.0125,
    back_emf_constant=0.0125,
    gear_ratio=40.0,
    rotor_inertia=5e-6,
    viscous_friction=0.01,
    supply_voltage=7.2,
    dead_band=0.15,
)


def scenario(**changes):
    """Give a lap in 30 s, whose cusps ask for more than the supply has."""
    settings = {
        "period": 30.0,
        "dt": 0.05,
        "motor": MOTOR,
        "viscous_friction": 0.003,
        "integrator": "exact",
        "rng": 0,
    }
    return Scenario.published(**(settings | changes))


def voltages(torque, v, omega, robot, motor=MOTOR):
    """Give the motors' voltages for a sample's torques: the textbook's equation."""
    speeds = (v + np.array([1, -1]) * omega * robot.track_width / 2) / robot.wheel_radius
    per_volt = motor.gear_ratio * motor.torque_constant / motor.resistance
    wanted = np.asarray(torque) / per_volt + motor.gear_ratio * motor.back_emf_constant * speeds
    return np.clip(wanted, -motor.supply_voltage, motor.supply_voltage), wanted


def slopes(_time, state, volts, friction, robot, motor=MOTOR):
    """Give the motion's slopes: windings, gears, rotors and bearings."""
    _, _, theta, v, omega = state
    speeds = (v + np.array([1, -1]) * omega * robot.track_width / 2) / robot.wheel_radius
    behind = volts - np.clip(volts, -motor.dead_band, motor.dead_band)
    induced = motor.gear_ratio * motor.back_emf_constant * speeds
    current = (behind - induced) / motor.resistance
    torque = motor.gear_ratio * motor.torque_constant * current
    torque -= (friction + motor.viscous_friction) * speeds
    rotor = motor.gear_ratio**2 * motor.rotor_inertia  # at the wheel
    mass = robot.mass + 2 * rotor / robot.wheel_radius**2
    inertia = robot.inertia + rotor * robot.track_width**2 / (2 * robot.wheel_radius**2)
    push = torque / robot.wheel_radius
    turn = (push[0] - push[1]) * robot.track_width / 2
    return [v * np.cos(theta), v * np.sin(theta), omega, push.sum() / mass, turn / inertia]


def test_a_run_agrees_with_an_independent_solution():
    given = scenario()
    run = simulate(given, Controller.published(sample_time=None))
    columns, clipped = run.columns, 0
    states = np.column_stack([columns[name] for name in ("x", "y", "theta", "v", "omega")])
    for k in range(0, 200):
        volts, wanted = voltages(run.torque[k], *states[k, 3:], given.robot)
        clipped += int(np.any(volts != wanted))
        solution = solve_ivp(
            slopes,
            (0.0, given.trajectory.dt),
            states[k],
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
            args=(volts, given.viscous_friction, given.robot),
        )
        assert np.allclose(solution.y[:, -1], states[k + 1], rtol=0, atol=1e-9), k
    assert 5 < clipped < 195


def test_a_motor_that_can_do_anything_is_none():
    ideal = Motor(back_emf_constant=0.0, supply_voltage=1e6)
    plain = scenario(motor=None)
    expected, run = simulate(plain), simulate(plain.replace(motor=ideal))
    assert np.allclose(run.pose, expected.pose, rtol=0, atol=1e-9)
    assert run.cost == pytest.approx(expected.cost, rel=1e-9)


def test_back_emf_takes_what_the_supply_can_give():
    stall = MOTOR.supply_voltage * MOTOR.gear_ratio * MOTOR.torque_constant / MOTOR.resistance
    free = MOTOR.supply_voltage / (MOTOR.gear_ratio * MOTOR.back_emf_constant)
    assert MOTOR.available(9.0, 0.0) == pytest.approx(stall)
    assert MOTOR.available(9.0, free) == pytest.approx(0.0, abs=1e-12)
    assert MOTOR.available(-9.0, free) == pytest.approx(-2 * stall)
    assert MOTOR.available(0.3, 1.0) == 0.3
    assert MOTOR.voltage(0.0, free / 2) == pytest.approx(MOTOR.supply_voltage / 2)
    assert MOTOR.voltage(9.0, 1.0) == MOTOR.supply_voltage
    counts = [MOTOR.pulse_width(volts, 255) for volts in (0.0, 7.2, -99.0, 3.6, -0.02)]
    assert counts == [0, 255, -255, 128, -1]
    with pytest.raises(ValueError, match="full_scale is 0; must be 1 or more"):
        MOTOR.pulse_width(1.0, 0)
    with pytest.raises(ValueError, match=r"voltage is .*; must be finite"):
        MOTOR.pulse_width(np.nan, 255)


@pytest.mark.parametrize("integrator", ["semi-implicit-euler", "exact"])
def test_lanes_and_gradients_have_it_too(integrator):
    given = scenario(integrator=integrator, coulomb_friction=0.02)
    objective = nfopidn.Objective(given, structure="decoupled")
    controller = Controller.published(allocation="decoupled", sample_time=None)
    x = objective.parameters_of(controller)
    expected = simulate(given, controller).cost
    assert expected != simulate(given.replace(motor=None), controller).cost
    assert objective.costs(np.tile(x, (9, 1))) == pytest.approx(np.full(9, expected), rel=1e-9)
    cost, gradient = objective.gradient(x)
    assert cost == pytest.approx(expected, rel=1e-9)
    step = 1e-6 * np.eye(len(x))
    rise = objective.costs(x + step) - objective.costs(x - step)
    assert np.allclose(rise / 2e-6, gradient, rtol=1e-3, atol=1e-4 * np.abs(gradient).max())


def test_monte_carlo_runs_replay():
    given = scenario(coulomb_friction=0.02)
    result = nfopidn.monte_carlo(
        given,
        Controller.published(sample_time=None),
        40,
        rng=1,
        distributions={"mass": nfopidn.montecarlo.Uniform(10.0, 13.0)},
    )
    for run in (0, 17, 39):
        replayed = simulate(result.replay(run), Controller.published(sample_time=None))
        assert replayed.cost == result.costs[run]


def test_anti_windup_knows_what_the_supply_cannot_give():
    weak = scenario(motor=MOTOR.replace(supply_voltage=2.0), integrator="semi-implicit-euler")
    sums = {}
    for rule in ("none", "clamp"):
        law = Controller.published(form="incremental", anti_windup=rule, sample_time=None)
        columns = simulate(weak, law).columns
        sums[rule] = max(np.abs(columns[f"tau_fb_{side}"]).max() for side in ("left", "right"))
    assert sums["none"] > 2 * sums["clamp"]


def test_it_stands_in_the_file_and_is_whole_there():
    given = scenario()
    document = json.loads(given.to_json())
    assert document["motor"]["gear_ratio"] == 40.0
    assert Scenario.from_json(given.to_json()) == given
    assert pickle.loads(pickle.dumps(MOTOR)) == MOTOR
    assert "motor=Motor(resistance=1.5" in repr(given)
    assert "motor" not in json.loads(given.replace(motor=None).to_json())
    del document["motor"]["supply_voltage"]
    with pytest.raises(ValueError, match=r"motor\.supply_voltage is missing; must be given"):
        Scenario.from_json(json.dumps(document))


@pytest.mark.parametrize(
    ("field", "bad"),
    [
        ("resistance", 0),
        ("torque_constant", -1),
        ("gear_ratio", 0),
        ("supply_voltage", 0),
        ("dead_band", -0.1),
        ("rotor_inertia", np.nan),
    ],
)
def test_a_motor_out_of_range_is_refused(field, bad):
    with pytest.raises(ValueError, match=rf"{field} is .*; must be"):
        MOTOR.replace(**{field: bad})
    with pytest.raises(TypeError, match="motor must be a Motor"):
        scenario(motor=12.0)


def test_the_executable_takes_its_numbers_in_order(sim):
    numbers = "1.5,0.0125,0.0125,40,5e-6,0.01,0,7.2,0.15"
    run = sim("--integrator", "exact", "--motor", numbers, "--json")
    assert run.returncode == 0, run.stderr
    expected = simulate(Scenario.published(motor=MOTOR, integrator="exact", rng=0)).cost
    assert json.loads(run.stdout)["cost"] == expected
    assert "motor" in sim("--motor", "1.5,0.0125").stderr
