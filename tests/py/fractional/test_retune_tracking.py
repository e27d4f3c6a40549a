"""retune of the tracking law, against the law itself run on sines, and against the loop."""

import warnings

import numpy as np
import pytest
from nfopidn import Controller, Scenario, Trajectory, simulate
from nfopidn.fractional import retune, truncation_report

BASE = Controller.recommended()
ALONG, ASIDE, TURNED = range(3)


def torque_of_sine(controller, channel, omega):
    """Amplitude and phase of drive or steering for a small error of a robot that moves along x."""
    dt, size, speed = controller.sample_time, 1e-4, 0.3
    count = round(16 * 2 * np.pi / omega / dt)
    t = dt * np.arange(count)
    error = np.zeros((count, 3))
    error[:, channel] = size * np.sin(omega * t)
    running = controller.copy()
    torque = []
    for now, (along, aside, turned) in zip(t, error, strict=True):
        pose = (speed * now - along, -aside, -turned)
        torque.append(running.step(pose, (speed * now, 0, 0, speed, 0, 0, 0, 0)))
    left, right = np.array(torque).T
    wanted = (left + right if channel == ALONG else left - right) / 2
    last = slice(count // 2, None)
    wave = np.column_stack([np.sin(omega * t), np.cos(omega * t), np.ones_like(t)])[last]
    sine, cosine, _ = np.linalg.lstsq(wave, wanted[last], rcond=None)[0]
    return complex(sine, cosine) / size


@pytest.mark.parametrize("channel", [ALONG, ASIDE, TURNED])
@pytest.mark.parametrize(("new", "bound"), [(0.4, 0.12), (0.15, 0.03), (0.1, 0.08)])
def test_it_keeps_the_torque_of_an_error(channel, new, bound):
    changed = retune(BASE, new_dt=new).controller
    assert changed.sample_time == new
    assert changed.robot == BASE.robot
    for omega in (0.15, 0.4, 0.7):
        before = torque_of_sine(BASE, channel, omega)
        after = torque_of_sine(changed, channel, omega)
        assert abs(after / before - 1) < bound, omega


def test_with_the_same_span_of_memory_it_keeps_the_fractional_derivative():
    """Then the gain goes with T^-alpha."""
    base = BASE.replace(memory=200, pole_x=0, pole_theta=0, sample_time=0.2)
    changed = retune(base, new_dt=0.1, memory=401).controller
    for channel in ("x", "theta"):
        order = getattr(base, f"speed_order_{channel}")
        ratio = getattr(changed, f"speed_gain_{channel}") / getattr(base, f"speed_gain_{channel}")
        assert ratio == pytest.approx(2**order, rel=0.01)
    one = BASE.replace(speed_order_x=1, pole_x=0, pole_theta=0)
    changed = retune(one, new_dt=0.02).controller
    assert changed.speed_gain_x == pytest.approx(10 * one.speed_gain_x, rel=1e-2)


def test_the_loop_answers_alike():
    """The way back to a line after a start aside, at one sample time and at half of it."""
    ways = []
    for controller in (BASE, retune(BASE, new_dt=0.1).controller):
        dt = controller.sample_time
        path = Trajectory.line(period=60, dt=dt, scale=6)
        scenario = Scenario(
            path,
            initial_pose=(path.x[0] - 0.03, path.y[0] + 0.05, path.theta[0] + 0.05),
            initial_velocity="reference",
            integrator="exact",
            rng=0,
        )
        pose = simulate(scenario, controller).pose
        ways.append(pose[:: round(0.2 / dt), 1] - path.y[0])
    ways = [way[:280] for way in ways]
    assert np.abs(ways[0]).max() > 0.04
    assert np.abs(ways[1] - ways[0]).max() < 0.1 * np.abs(ways[0]).max()


def test_there_and_back_is_the_same():
    back = retune(retune(BASE, new_dt=0.15).controller, new_dt=0.2).controller
    for name in ("speed_gain_x", "pole_theta", "amplitude_theta", "integral_y"):
        assert getattr(back, name) == pytest.approx(getattr(BASE, name), rel=1e-12)
    assert back.gains == pytest.approx(BASE.gains, rel=1e-12)
    assert back.integral_retention == pytest.approx(BASE.integral_retention, rel=1e-14)
    assert retune(BASE).controller == BASE
    assert max(retune(BASE).change) < 1e-14


def test_a_lead_that_a_pole_cannot_have_is_said():
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        changed = retune(BASE, new_dt=0.02).controller
    text = "\n".join(str(warning.message) for warning in said)
    assert "retune: pole_x would have to lead by 0.766 samples, more than a pole can" in text
    assert "retune: pole_theta would have to lead by 1.93 samples" in text
    assert {warning.filename for warning in said} == {__file__}
    assert changed.pole_theta == 0.9
    ratio = 1.9 / (1 + BASE.pole_theta)
    assert changed.amplitude_theta == pytest.approx(BASE.amplitude_theta * ratio)
    assert changed.gains[1, 0] == pytest.approx(BASE.gains[1, 0] * ratio)


@pytest.mark.filterwarnings("ignore:retune")  # of what sums over samples add at high frequencies
@pytest.mark.parametrize("form", ["positional", "incremental"])
@pytest.mark.parametrize("net", ["whole", "increment"])
def test_other_forms_keep_their_torque(form, net):
    base = Controller.published(
        net=net,
        form=form,
        memory=300,
        generator="gl",
        allocation="decoupled",
        amplitude_y=0.5,
        sample_time=0.2,
    )
    changed = retune(base, new_dt=0.1, memory=600).controller
    before, after = (torque_of_sine(one, ASIDE, 0.2) for one in (base, changed))
    assert abs(after / before - 1) < 0.06
    assert changed.amplitude_y == (0.25 if form == "incremental" else 0.5)


def test_the_truncation_report_knows_the_speed_errors():
    """Of a filter run on a sine, at both ends of a band."""
    dt, band = 0.2, (0.3, 1.2)
    controller = BASE.replace(memory=30)
    report = truncation_report(controller, band=band)
    assert [(error.channel, error.order) for error in report.errors] == [
        ("x", pytest.approx(BASE.speed_order_x - 1)),
        ("theta", pytest.approx(BASE.speed_order_theta - 1)),
    ]
    assert "gl s^(alpha - 1) of the speed error" in str(report)
    for error, channel in zip(report.errors, (0, 2), strict=True):
        taps = controller.taps[channel] / controller.taps[channel, 0]
        ratios = [
            np.polynomial.polynomial.polyval(np.exp(-1j * omega * dt), taps)
            / (1j * omega * dt) ** error.order
            for omega in np.geomspace(*band, 400)
        ]
        assert error.magnitude == pytest.approx(np.abs(np.abs(ratios) - 1).max(), rel=1e-6)
        assert error.phase == pytest.approx(np.abs(np.angle(ratios, deg=True)).max(), rel=1e-6)
    lateral = Controller.published(net="whole", memory=200, generator="gl", sample_time=dt)
    gains = lateral.gains.copy()
    gains[0, 1] = gains[2, 2] = 0
    names = [
        (error.channel, error.operator)
        for error in truncation_report(lateral.replace(gains=gains)).errors
    ]
    both = ("s^alpha", "s^-sigma")
    assert names == [("x", both[0]), ("y", both[0]), ("y", both[1]), ("theta", both[1])]
