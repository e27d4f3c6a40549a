"""nfopidn.stability.margins against python-control, the map's eigenvalues and simulations."""

import control
import numpy as np
import pytest
from nfopidn import Controller, Robot, Scenario, Trajectory, simulate, stability
from nfopidn.stability import loop_roots
from nfopidn.stability.closed_loop import jacobians
from nfopidn.stability.loop_margins import _Linear, _one_loop
from refusal import refused

DT = 0.2
PUBLISHED = Controller.published()
TUNED = Controller.tuned_nominal()
HALF = PUBLISHED.gains / 2
DECOUPLED = Controller.published(allocation="decoupled")
CASES = [
    pytest.param(PUBLISHED, 0.335, id="published"),
    pytest.param(PUBLISHED, 0.05, id="slow"),
    pytest.param(
        PUBLISHED.replace(activation="linear", gains=PUBLISHED.gains / 2), 0.3, id="plain"
    ),
    pytest.param(DECOUPLED, 0.2, id="decoupled"),
    pytest.param(TUNED, 0.2, id="incremental"),
    pytest.param(TUNED, -0.2, id="backwards"),
]


def gain(matrix):
    return control.ss([], [], [], np.array(matrix), DT)


def at_wheels(controller, speed):
    """The loop at the wheels' torques as python-control's system, from textbook formulas."""
    robot = Robot()
    drive = DT / (robot.mass * robot.wheel_radius)
    steer = DT * robot.track_width / (2 * robot.inertia * robot.wheel_radius)
    state = np.eye(5)  # x, y, theta, v, omega: v and omega first, then the pose with them
    state[0, 3] = state[2, 4] = DT
    state[1, 2] = DT * speed
    torque = np.array([[DT * drive] * 2, [0, 0], [DT * steer, -DT * steer], [drive] * 2])
    torque = np.vstack([torque, [steer, -steer]])
    robot_loop = control.ss(state, torque, np.eye(3, 5), np.zeros((3, 2)), DT)
    slope = 1 if controller.activation == "linear" else 0.5
    z = control.tf([1, 0], [1], DT)
    laws = []
    for channel, taps in enumerate(controller.taps * slope):
        sign = np.sign(speed) if channel == 1 else 1
        law = control.tf(sign * taps, [1] + [0] * (len(taps) - 1), DT)
        laws.append(control.ss(law * z / (z - 1) if controller.form == "incremental" else law))
    named = {"paper": [[0, 1, 1], [1, 1, 0]], "decoupled": [[1, 1, 1], [1, -1, -1]]}
    return gain(named[controller.allocation]) * control.append(*laws) * robot_loop


def one_loop(wheels, index):
    """Drive (0) or steering (1), broken with the other loop closed."""
    to_loops = np.array([[1, 1], [1, -1]])
    both = gain(to_loops) * wheels * gain(np.linalg.inv(to_loops))
    other = 1 - index
    closed = both.A - both.B[:, [other]] @ both.C[[other]]
    return control.ss(closed, both.B[:, [index]], both.C[[index]], 0, DT)


@pytest.mark.parametrize(("controller", "speed"), CASES)
def test_margins_are_python_controls(controller, speed):
    found = stability.margins(controller, speed=speed)
    assert found.stable
    wheels = at_wheels(controller, speed)
    frequency = np.geomspace(1e-3, np.pi / DT, 4000)
    for index, own in enumerate((found.drive, found.steering)):
        response = one_loop(wheels, index)(np.exp(1j * frequency * DT))
        data = control.frd(response, frequency, smooth=True)
        gains, phases, _, _, at_unit, _ = control.stability_margins(data, returnall=True)
        # Where the grid ends, at half the sampling rate, python-control looks for no crossing.
        gains = np.append(gains, -1 / response[-1].real)
        lower, upper = gains[(gains > 0) & (gains < 1)], gains[gains > 1]
        assert own.gain[0] == pytest.approx(max(lower, default=0), rel=1e-3)
        assert own.gain[1] == pytest.approx(min(upper, default=np.inf), rel=1e-3)
        assert own.phase == pytest.approx(np.deg2rad(np.min(np.abs(phases))), rel=1e-3)
        lag = np.deg2rad(np.mod(phases, 360)) / at_unit
        assert own.delay == pytest.approx(lag.min(), rel=1e-3)
        assert own.peak_sensitivity == pytest.approx(np.max(1 / np.abs(1 + response)), rel=1e-4)


@pytest.mark.parametrize(("controller", "speed"), CASES)
def test_disk_margins_are_python_controls(controller, speed):
    found = stability.margins(controller, speed=speed)
    wheels = at_wheels(controller, speed)
    frequency = np.geomspace(0.1, np.pi / DT, 400)
    for index, own in enumerate((found.drive, found.steering)):
        margin, _, _ = control.disk_margins(one_loop(wheels, index), frequency)
        assert own.disk == pytest.approx(margin, rel=2e-3)
    margin, gain, phase = control.disk_margins(wheels, frequency)
    assert found.wheels.disk == pytest.approx(margin, rel=2e-3)
    assert 20 * np.log10(found.wheels.gain[1]) == pytest.approx(gain, rel=2e-3)
    assert found.wheels.gain[0] == pytest.approx(1 / found.wheels.gain[1])
    assert np.rad2deg(found.wheels.phase) == pytest.approx(phase, rel=2e-3)


@pytest.mark.parametrize("delay", [0, 1, 3])
@pytest.mark.parametrize("controller", [PUBLISHED, TUNED])
def test_poles_are_the_eigenvalues_of_the_loop_on_a_line(controller, delay):
    scenario = Scenario(
        Trajectory.line(period=30), delay=delay, viscous_friction=0.01, feedforward=False
    )
    # The friction is small: the line is followed with nearly no error, but not with none.
    found = stability.margins(controller, scenario, speed=0.2)
    at_rest = stability.loop(scenario.replace(viscous_friction=0.0), controller)
    free = stability.margins(controller, scenario.replace(viscous_friction=0.0), speed=0.2)
    step = jacobians(scenario.replace(viscous_friction=0.0), controller, at_rest)[0]
    expected = np.poly(np.linalg.eigvals(step))
    np.testing.assert_allclose(np.poly(free.poles), expected, atol=1e-8)
    assert free.stable == (at_rest.verdict == "stable")
    assert not np.allclose(np.poly(found.poles), expected, atol=1e-6)


def test_a_loop_at_its_delay_margin_has_a_pole_on_the_circle():
    # One sample is more than the published gains bear, and less than the tuned ones do.
    for controller, most in ((PUBLISHED, 0), (TUNED, 1)):
        margin = min(
            getattr(stability.margins(controller, speed=0.3), name).delay
            for name in ("drive", "steering")
        )
        assert int(margin / DT) == most
        for delay in (most, most + 1):
            scenario = Scenario.published(delay=delay)
            assert stability.margins(controller, scenario, speed=0.3).stable == (delay == most)


@pytest.mark.parametrize("controller", [DECOUPLED, TUNED])
def test_the_gain_margin_is_where_the_loop_becomes_unstable(controller):
    upper = stability.margins(controller, speed=0.3).steering.gain[1]
    for factor, stable in ((0.99 * upper, True), (1.01 * upper, False)):
        taps = controller.taps.copy()
        taps[1:] *= factor
        settings = {"form": controller.form, "allocation": controller.allocation}
        changed = Controller.from_taps(taps, **settings)
        assert stability.margins(changed, speed=0.3).stable == stable
        # And so does the simulation.
        path = Trajectory.line(period=20, laps=20)
        start = {"initial_pose": (0, 1e-3, 0), "initial_velocity": "reference"}
        run = simulate(Scenario(path, **start), changed)
        end = np.abs(run.columns["e_theta"][-100:]).max()
        assert (run.diverged_at is None and end < 1e-3) == stable


def test_friction_integrator_and_substeps_enter():
    base = stability.margins(speed=0.3)
    for settings in (
        {"viscous_friction": 0.05},
        {"integrator": "exact"},
        {"substeps": 4},
        {"robot": Robot(mass=13)},
        {"delay": 0, "trajectory": Trajectory.line(dt=0.1)},
    ):
        changed = stability.margins(PUBLISHED, Scenario.published(**settings), speed=0.3)
        assert changed.drive.phase != base.drive.phase


def test_the_lateral_choice_enters():
    plain = stability.margins(PUBLISHED.replace(lateral="plain"), speed=-0.3)
    assert not plain.stable  # steers the wrong way
    assert np.isnan(plain.steering.phase)
    assert np.isnan(plain.wheels.disk)
    scaled = stability.margins(PUBLISHED.replace(lateral="speed"), speed=0.1)
    given = PUBLISHED.replace(
        lateral="speed", speed_scale=Scenario.published().trajectory.peak_speed
    )
    assert scaled.steering == stability.margins(given, speed=0.1).steering
    assert scaled.steering != stability.margins(speed=0.1).steering


def test_the_default_speed_is_the_paths_peak():
    found = stability.margins()
    assert found.speed == Scenario.published().trajectory.peak_speed
    assert "steering: gain" in str(found)


@pytest.mark.parametrize("speed", [0, 1001, -1001, np.nan, np.inf])
def test_a_speed_out_of_range_is_refused(speed):
    with refused(f"speed is {speed}", "in [-1000, 1000] m/s"):
        stability.margins(speed=speed)


LONG = [
    pytest.param(PUBLISHED.replace(memory=80), {}, id="published"),
    pytest.param(PUBLISHED.replace(memory=80), {"delay": 2, "viscous_friction": 0.05}, id="late"),
    pytest.param(DECOUPLED.replace(memory=80), {"integrator": "exact"}, id="decoupled"),
    pytest.param(TUNED.replace(memory=80, generator="gl"), {}, id="incremental"),
    pytest.param(TUNED.replace(memory=80, generator="gl"), {"delay": 2}, id="incremental, late"),
    pytest.param(PUBLISHED.replace(gains=PUBLISHED.gains * [[0], [1], [1]], memory=80), {}, id="x"),
]


@pytest.mark.parametrize(("controller", "settings"), LONG)
def test_poles_with_long_memory_are_the_maps_eigenvalues(controller, settings):
    linear = _Linear(Scenario.published(**settings), controller, 0.3)
    poles = linear.poles()
    memory = linear.taps.shape[1] - 1
    eigenvalues = np.linalg.eigvals(linear._map(memory, poles.size))
    eigenvalues = eigenvalues[np.argsort(-np.abs(eigenvalues))]
    assert np.all(np.diff(np.abs(poles)) <= 0)
    assert np.count_nonzero(poles == 0) >= memory
    # Those nearer to 0 the eigenvalues do not tell from the many that are there.
    far, own_far = eigenvalues[np.abs(eigenvalues) > 0.8], poles[np.abs(poles) > 0.8]
    assert far.size == own_far.size > memory
    apart = np.abs(far[:, None] - own_far)
    assert np.max(np.min(apart, axis=0)) < 1e-11
    assert np.max(np.min(apart, axis=1)) < 1e-11
    assert np.sum(poles).real == pytest.approx(np.trace(linear._map(memory, poles.size)), abs=1e-9)


def test_poles_that_do_not_arrive_are_the_maps_eigenvalues(monkeypatch):
    linear = _Linear(Scenario.published(), PUBLISHED.replace(memory=80), 0.3)
    found = linear.poles()
    monkeypatch.setattr(loop_roots, "_MOST_SWEEPS", 3)
    assert linear._roots(found.size) is None
    np.testing.assert_allclose(np.abs(linear.poles()[:6]), np.abs(found[:6]), atol=1e-10)


@pytest.mark.parametrize("controller", [PUBLISHED, TUNED.replace(generator="gl")])
def test_margins_with_the_longest_memory(controller):
    """Against sums of powers at more frequencies than the filter ripples."""
    controller = controller.replace(memory=1024)
    found = stability.margins(controller, speed=0.3)
    assert found.stable
    assert found.poles.size == 5 + 3 * 1025 + 2 * (controller.form == "incremental")
    wheels_loop = _Linear(Scenario.published(), controller, 0.3)
    frequency = np.linspace(1e-3, 1, 12_000) * np.pi / DT
    z = np.exp(1j * frequency * DT)
    filters = np.array([np.polyval(taps[::-1], 1 / z) for taps in wheels_loop.taps])
    if controller.form == "incremental":
        filters *= z / (z - 1)
    plant = np.linalg.solve(
        z[:, None, None] * np.eye(5) - wheels_loop.state, wheels_loop.input + 0j * z[:, None, None]
    )
    wheels = (wheels_loop.allocation * filters.T[:, None, :]) @ plant[:, :3]
    np.testing.assert_allclose(wheels_loop.at_wheels(frequency), wheels, rtol=1e-9, atol=1e-12)
    inverse = np.linalg.inv(np.eye(2) + wheels)
    for index, own in enumerate((found.drive, found.steering)):
        # Sensitivity of the sum or the difference of the torques, the other loop closed.
        row = np.array([[1, 1], [1, -1]])[index]
        peak = np.abs(np.einsum("i,nij,j->n", row, inverse, row / 2)).max()
        assert own.peak_sensitivity == pytest.approx(peak, rel=1e-4)
        assert own.peak_sensitivity >= peak * (1 - 1e-12)


@pytest.mark.parametrize("memory", [500, 1024])
def test_roots_that_are_thrown_far_inside_return(memory):
    """The map's eigenvalues, which would be taken otherwise, cost half a minute."""
    linear = _Linear(Scenario.published(), TUNED.replace(memory=memory), 0.3)
    size = 5 + 3 * (memory + 1) + 2 * linear.sums + 2 * linear.delay
    poles = linear._roots(size)
    assert poles is not None
    assert np.sum(poles != 0) > memory
    trace = np.trace(linear._map(memory + 1, size))
    assert np.sum(poles).real == pytest.approx(trace, abs=1e-8)


def test_a_narrow_ripple_is_seen():
    """A last tap far back makes the loop ripple faster than an even grid in the logarithm shows."""
    taps = np.zeros((3, 1026))
    taps[:, :7] = DECOUPLED.taps
    taps[2, -1] = 0.01
    controller = Controller.from_taps(taps, allocation="decoupled")
    own = stability.margins(controller, speed=0.3)
    assert own.stable
    frequency = np.linspace(1e-3, 1, 40_000) * np.pi / DT
    loop = _one_loop(_Linear(Scenario.published(), controller, 0.3).at_wheels(frequency), 1)
    assert own.steering.peak_sensitivity >= np.max(1 / np.abs(1 + loop)) * (1 - 1e-6)


def test_power_sums_are_polynomials():
    taps = np.random.default_rng(1).normal(size=(2, 37))
    w = np.exp(1j * np.linspace(0, 3, 53)) * 0.98
    wanted = [np.polyval(row[::-1], w) for row in taps]
    np.testing.assert_allclose(loop_roots.power_sums(taps, w), wanted, rtol=1e-12, atol=1e-12)


def test_a_speed_beyond_every_float_is_refused():
    for speed in (10**400, 10**5000):
        with refused("speed is a whole number of about", "in [-1000, 1000] m/s"):
            stability.margins(speed=speed)
    assert stability.margins(speed=np.longdouble(0.5)).speed == 0.5
    with refused("memory is a whole number of about 401 digits", "in [0, 1024]"):
        stability.operator(0.5, 10**400)


TRACKING = [
    pytest.param(Controller.recommended(), id="recommended"),
    pytest.param(
        Controller.recommended().replace(
            pole_x=-0.3, pole_theta=0.5, integral_x=0.1, integral_theta=0.05, memory=9
        ),
        id="every part",
    ),
    pytest.param(Controller.recommended().replace(lateral="direction"), id="direction"),
    pytest.param(
        Controller.published(
            net="whole", allocation="decoupled", amplitude_x=0.3, integral_y=0.02, pole_theta=0.2
        ),
        id="whole",
    ),
    pytest.param(Controller.published(net="whole", amplitude_y=0.3), id="paper's allocation"),
    pytest.param(
        Controller.recommended().replace(
            **dict.fromkeys(("pole_x", "pole_theta"), 0.0),
            **dict.fromkeys(("integral_x", "integral_y", "integral_theta"), 0.0),
            form="incremental",
        ),
        id="incremental",
    ),
]


@pytest.mark.parametrize("delay", [0, 2])
@pytest.mark.parametrize("controller", TRACKING)
def test_the_tracking_laws_poles_are_those_of_the_laws_own_map(controller, delay):
    """The map differentiates the law itself. Its last pose repeats what the past errors know."""
    scenario = Scenario(Trajectory.line(period=30), delay=delay, feedforward=False)
    at_rest = stability.loop(scenario, controller)
    step = jacobians(scenario, controller, at_rest)[0]
    expected = np.linalg.eigvals(step)
    found = stability.margins(controller, scenario, speed=scenario.trajectory.peak_speed).poles
    # Those at 0, of what is only remembered, are as many as there are states for it, and a pole of
    # a high multiplicity has few digits.
    for pole in found[np.abs(found) > 0.35]:
        assert np.abs(expected - pole).min() < 1e-5
    for pole in expected[np.abs(expected) > 0.35]:
        assert np.abs(found - pole).min() < 1e-5
    assert (np.abs(found) > 0.35).sum() == (np.abs(expected) > 0.35).sum()


@pytest.mark.parametrize("index", [0, 1])
@pytest.mark.parametrize("controller", TRACKING[:2])
def test_the_tracking_laws_gain_margin_is_where_a_pole_is_on_the_circle(controller, index):
    """Every gain of the loop times the margin, the amplitudes too."""
    found = stability.margins(controller, speed=0.3)
    upper = (found.drive, found.steering)[index].gain[1]
    assert 1 < upper < 100
    names = [
        ("speed_gain_x", "amplitude_x", "integral_x"),
        ("speed_gain_theta", "amplitude_y", "amplitude_theta", "integral_y", "integral_theta"),
    ][index]
    for factor, stable in ((0.99 * upper, True), (1.01 * upper, False)):
        gains = controller.gains.copy()
        gains[[0] if index == 0 else [1, 2]] *= factor
        changes = {name: factor * getattr(controller, name) for name in names}
        changed = controller.replace(gains=gains, **changes)
        assert stability.margins(changed, speed=0.3).stable == stable


def test_the_tracking_law_bears_the_delay_of_its_margin():
    controller = Controller.recommended()
    delay = min(
        getattr(stability.margins(controller, speed=0.3), name).delay
        for name in ("drive", "steering")
    )
    assert delay > DT  # it was found for a delay of one sample
    most = int(delay / DT)
    for samples in (most, most + 1):
        scenario = Scenario.published(delay=samples)
        assert stability.margins(controller, scenario, speed=0.3).stable == (samples == most)
