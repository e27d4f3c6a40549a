"""nfopidn.fractional against closed forms, mpmath, SciPy and python-control."""

import copy
import itertools
import math
import pickle
import sys
from concurrent.futures import ThreadPoolExecutor

import control
import matplotlib.pyplot as plt
import mpmath
import nfopidn
import nominal
import numpy as np
import pytest
import scipy.signal
import scipy.special
from nfopidn.fractional import (
    METHODS,
    FractionalFilter,
    discretise,
    retune,
    to_continuous,
    to_discrete,
    truncation_report,
)
from nfopidn.fractional.conversion import controller_response

RULES = {"tustin": 1.0, "gl": 0.0, "al-alaoui": 1 / 7}
DT = 0.1


def exact_weights(rule, order, memory):
    """Power series of ((1 - w)/(1 + pole w))^order with 50 digits: two binomials."""
    mpmath.mp.dps = 50
    pole = mpmath.mpf(1) / 7 if rule == "al-alaoui" else mpmath.mpf(RULES[rule])
    up = [(-1) ** k * mpmath.binomial(order, k) for k in range(memory + 1)]
    down = [pole**k * mpmath.binomial(-order, k) for k in range(memory + 1)]
    sums = [sum(up[i] * down[k - i] for i in range(k + 1)) for k in range(memory + 1)]
    return np.array([float(value) for value in sums])


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("order", [0.5, -0.5, 0.13, 1.7, -1.99])
def test_taps_are_the_binomial_series(rule, order):
    model = discretise(order, DT, rule, memory=60)
    wanted = exact_weights(rule, order, 60)
    np.testing.assert_allclose(model.taps, wanted, rtol=1e-12, atol=1e-14 * abs(wanted).max())


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("order", [1, 0, -1])
def test_whole_orders_are_the_rule_itself(method, order):
    model = discretise(order, DT, method)
    omega = np.array([0.3, 2.0, 9.0])
    z = np.exp(1j * omega * DT)
    rule = method.removesuffix("-cf")
    pole = RULES.get(rule, 1.0)
    wanted = ((1 + pole) / DT * (z - 1) / (z + pole)) ** order
    np.testing.assert_allclose(model.response(omega), wanted, rtol=1e-13)


@pytest.mark.parametrize(
    ("method", "order"),
    # A series of an order beyond 1 does not converge.
    [*itertools.product(METHODS, (0.5, -0.5)), *itertools.product(METHODS[3:], (1.5, -1.3))],
)
def test_response_is_near_the_power_of_its_rule_in_the_middle_of_the_band(method, order):
    model = discretise(order, DT, method, memory=20000, sections=15)
    middle = np.pi / DT / 30
    ideal = 1j * middle
    if method != "oustaloup":
        ideal = discretise(1, DT, method.removesuffix("-cf")).response(middle)
    assert abs(model.response(middle) / ideal**order - 1) < 0.05


@pytest.mark.parametrize("method", ["tustin-cf", "al-alaoui-cf"])
def test_more_sections_come_nearer(method):
    omega = np.pi / DT / 100
    rule = discretise(1, DT, method.removesuffix("-cf")).response(omega) ** 0.5
    errors = [
        abs(discretise(0.5, DT, method, sections=n).response(omega) / rule - 1) for n in (3, 9, 30)
    ]
    assert errors[0] > 5 * errors[1] > 25 * errors[2]


@pytest.mark.parametrize("order", [0.5, -0.5])
def test_hard_truncation_is_a_poor_power(order):
    """At omega T = 0.1 with 100 samples the paper's series is off by a fifth."""
    ratio = discretise(order, 1.0, "tustin", memory=100).response(0.1) / 0.1j**order
    assert 0.1 < abs(ratio - 1) < 0.3


def test_the_default_is_not_the_papers_series():
    """Which amplifies noise at half the sampling rate without bound."""
    assert discretise(0.5, DT).method == "gl"
    model = FractionalFilter(0.5, DT)
    assert "method='gl'" in repr(model)
    alternating = (-1.0) ** np.arange(20_000)
    out = model.stream(alternating)
    assert abs(out[-1]) == pytest.approx((2 / DT) ** 0.5, rel=1e-2)
    assert max(discretise(0.9, DT).errors()) < max(discretise(0.9, DT, "tustin").errors()) / 10


def test_prewarping_makes_the_magnitude_exact_there():
    for method in ("tustin-cf", "al-alaoui-cf"):
        model = discretise(0.5, DT, method, sections=40, prewarp=12.0)
        assert abs(model.response(12.0)) == pytest.approx(12**0.5, rel=1e-6)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("order", [0.5, -1.5, 1, 0])
def test_conversions_have_the_same_response(method, order):
    model = discretise(order, DT, method, memory=30, sections=5)
    omega = np.array([0.5, 3.0, 20.0])
    wanted = model.response(omega)
    system = model.to_dlti()
    if model.taps is None:
        _, found = scipy.signal.freqz_zpk(system.zeros, system.poles, system.gain, omega * DT)
        np.testing.assert_allclose(found, wanted, rtol=1e-9)
        _, found = scipy.signal.freqz_sos(model.sections, omega * DT)
        np.testing.assert_allclose(found, wanted, rtol=1e-9)
    else:
        _, found = system.freqresp(omega * DT)
        np.testing.assert_allclose(found, wanted, rtol=1e-9)
        with pytest.raises(ValueError, match="has taps"):
            _ = model.sections
    np.testing.assert_allclose(model.to_control()(np.exp(1j * omega * DT)), wanted, rtol=1e-8)
    data = model.to_control(omega)
    np.testing.assert_allclose(data(1j * omega), wanted, rtol=1e-12)


def exact_response(model, angle):
    """With 50 digits, of the zeros, poles and gain as they are stored."""
    mpmath.mp.dps = 50
    found = []
    for theta in angle:
        z = mpmath.exp(1j * mpmath.mpf(theta))
        value = mpmath.mpf(model.gain)
        for zero, pole in zip(model.zeros.real, model.poles.real, strict=True):
            value *= (z - mpmath.mpf(zero)) / (z - mpmath.mpf(pole))
        found.append(complex(value))
    return np.array(found)


LOW_ANGLES = np.geomspace(np.pi * 1e-4, 3.0, 60)


def test_stable_zeros_and_poles_stay_stable_in_control():
    """Multiplied out, 15 sections have a pole outside the unit circle."""
    model = discretise(0.5, 0.2, "oustaloup", sections=15)
    assert abs(model.poles).max() == pytest.approx(0.9956, abs=5e-5)
    system = model.to_control()
    assert isinstance(system, control.StateSpace)
    assert system.dt == 0.2
    assert abs(system.poles()).max() == pytest.approx(abs(model.poles).max(), rel=1e-12)
    wanted = exact_response(model, LOW_ANGLES)
    np.testing.assert_allclose(system(np.exp(1j * LOW_ANGLES)), wanted, rtol=5e-12)
    multiplied_out = control.zpk(model.zeros, model.poles, model.gain, dt=0.2)
    assert abs(multiplied_out.poles()).max() > 1.01


@pytest.mark.parametrize("method", METHODS[3:])
@pytest.mark.parametrize("order", [0.5, -0.5, 0.9, -0.9, 1, 0, -1, 1.5, -1.5, 1.9, -1.9])
@pytest.mark.parametrize("sections", [1, 9, 40])
def test_sections_in_series_have_their_response(method, order, sections):
    """To 5e-12, and to what rounding leaves of a response that is small beside the gain."""
    model = discretise(order, DT, method, sections=sections)
    wanted = exact_response(model, LOW_ANGLES)
    rounding = 2e-16 * len(model.poles) * abs(model.gain)
    for system in (model.to_control(), model.to_dlti().to_ss()):
        a, b, c, d = system.A, system.B, system.C, system.D
        eye = np.eye(len(a))
        found = [
            (c @ np.linalg.solve(np.exp(1j * theta) * eye - a, b) + d).item()
            for theta in LOW_ANGLES
        ]
        assert (abs(found - wanted) <= 5e-12 * abs(wanted) + rounding).all()
    _, found = scipy.signal.freqz_sos(model.sections, LOW_ANGLES)
    np.testing.assert_allclose(found, wanted, rtol=1e-9)


def test_second_order_sections_tell_their_lowest_poles():
    """Two of them in one section did not: the response was off by 2e-5."""
    model = discretise(0.5, 0.2, "oustaloup", sections=40, band=(1e-5, np.pi / 0.2))
    angle = np.geomspace(1e-6, 3, 60)
    _, found = scipy.signal.freqz_sos(model.sections, angle)
    np.testing.assert_allclose(found, exact_response(model, angle), rtol=1e-8)
    assert len(model.sections) == 20
    assert len(discretise(1.5, DT, "oustaloup", sections=2).sections) == 2


def test_a_loop_of_three_operators_has_its_margin():
    """2 + 1.2 I + 0.3 D; of polynomials |L| is some 0.01 at the crossing."""
    dt = 0.01
    integral, derivative = (discretise(o, dt, "oustaloup", sections=9) for o in (-0.8, 0.4))
    plant = control.c2d(control.tf([1], [0.1, 1, 0]), dt)
    loop = (2 + 1.2 * integral.to_control() + 0.3 * derivative.to_control()) * plant
    omega = np.linspace(2.4, 2.7, 301)
    z = np.exp(1j * omega * dt)
    sides = (exact_response(model, omega * dt) for model in (integral, derivative))
    wanted = (2 + 1.2 * next(sides) + 0.3 * next(sides)) * plant(z)
    crossing = abs(abs(wanted) - 1).argmin()
    assert 0 < crossing < 300
    found = loop(z)
    assert abs(found[crossing]) == pytest.approx(1, abs=1e-3)
    assert 180 + np.angle(found[crossing], deg=True) == pytest.approx(69, abs=0.5)
    np.testing.assert_allclose(found, wanted, rtol=1e-9)
    polynomials = [
        control.zpk(model.zeros, model.poles, model.gain, dt=dt) for model in (integral, derivative)
    ]
    wrong = (2 + 1.2 * polynomials[0] + 0.3 * polynomials[1]) * plant
    assert abs(wrong(z[crossing])) < 0.5


def test_polynomials_are_given_where_they_are_the_filter():
    model = discretise(0.5, DT, "tustin-cf", sections=5)
    system = model.to_control(form="transfer_function")
    assert isinstance(system, control.TransferFunction)
    wanted = exact_response(model, LOW_ANGLES)
    np.testing.assert_allclose(system(np.exp(1j * LOW_ANGLES)), wanted, rtol=1e-6)
    numerator = model.to_dlti().to_tf().num
    np.testing.assert_allclose(numerator, np.poly(model.zeros) * model.gain)


@pytest.mark.parametrize(
    ("order", "sections", "message"),
    [
        (
            0.5,
            15,
            r"15 zeros and 15 poles are another filter: its response is off by .* Nyquist's "
            r"frequency, its largest pole is 1\.0\d* for 0\.99557",
        ),
        (1.5, 9, "10 zeros and 10 poles are another filter: its response is off by 0"),
        (-1.5, 9, "10 zeros and 10 poles are another filter"),
    ],
)
def test_polynomials_that_are_another_filter_are_refused(order, sections, message):
    model = discretise(order, 0.2, "oustaloup", sections=sections)
    with pytest.raises(ValueError, match=f"form is 'transfer_function'; .*{message}"):
        model.to_control(form="transfer_function")
    system = model.to_dlti()
    assert isinstance(system, scipy.signal.dlti)
    with pytest.warns(UserWarning, match=f"to_tf: .*{message}.*; to_ss"):
        system.to_tf()
    again = pickle.loads(pickle.dumps(copy.deepcopy(system)))
    np.testing.assert_array_equal(again.poles, model.poles)
    assert again.dt == 0.2


def test_scipys_simulation_runs_the_sections():
    """SciPy's own way to state space is by polynomials: the step's response was 1e40."""
    model = discretise(0.5, 0.2, "oustaloup", sections=15)
    steps = np.ones(5000)
    wanted = scipy.signal.sosfilt(model.sections, steps)
    _, (found,) = scipy.signal.dstep(model.to_dlti(), n=5000)
    np.testing.assert_allclose(found[:, 0], wanted, rtol=1e-10)


def test_taps_are_polynomials_as_they_stand():
    model = discretise(0.5, DT, memory=200)
    z = np.exp(1j * LOW_ANGLES)
    wanted = model.response(LOW_ANGLES / DT)
    for form, kind in (
        (None, control.TransferFunction),
        ("transfer_function", control.TransferFunction),
        ("state_space", control.StateSpace),
    ):
        system = model.to_control(form=form)
        assert isinstance(system, kind)
        np.testing.assert_allclose(system(z), wanted, rtol=1e-11)
    constant = discretise(0.5, DT, memory=0)
    assert constant.to_control(form="state_space")(1j) == pytest.approx(constant.gain)
    with pytest.raises(ValueError, match=r"memory is 1001; must be in \[0, 1000\] for a chain"):
        discretise(0.5, DT, memory=1001).to_control(form="state_space")


def test_forms_are_named():
    model = discretise(0.5, DT, "tustin-cf")
    with pytest.raises(ValueError, match="form is 'tf'; must be one of state_space, transfer_fun"):
        model.to_control(form="tf")
    with pytest.raises(ValueError, match="form is 'state_space' beside a frequency"):
        model.to_control([1.0], form="state_space")


def test_a_missing_extra_names_the_command(monkeypatch):
    monkeypatch.setitem(sys.modules, "control", None)
    model = discretise(0.5, DT, "tustin-cf")
    with pytest.raises(ImportError, match=r"pip install 'nfopidn\[control\]'"):
        model.to_control()


def test_a_step_does_not_ring():
    """By Tustin's rule the half derivative of a step is 0.0504, 0, 0.0504, 0, ... for 0.0252."""
    steps = np.ones(502)
    truth = 1 / np.sqrt(np.pi * 501)
    assert truth == pytest.approx(0.0252, abs=5e-5)
    for model in (FractionalFilter(0.5, 1.0), FractionalFilter(0.5, 1.0, method="al-alaoui")):
        np.testing.assert_allclose(model.stream(steps)[-2:], truth, rtol=2e-3)
    ringing = FractionalFilter(0.5, 1.0, method="tustin")
    np.testing.assert_allclose(sorted(ringing.stream(steps)[-2:]), [0, 2 * truth], atol=1e-4)
    assert ringing.certificate < 1e-12  # of the kernel, which is Tustin's


@pytest.mark.parametrize("method", RULES)
@pytest.mark.parametrize("order", [0.5, -0.5, 1.4, -1.4, 1, -1])
@pytest.mark.parametrize("memory", [30, 20_000, math.inf])
def test_a_filter_has_the_response_of_its_impulses(method, order, memory):
    model = FractionalFilter(order, DT, memory, method)
    omega = np.array([[0.5, 3.0], [12.0, 25.0]])
    found = model.response(omega)
    assert found.shape == omega.shape
    whole = int(order)
    length = 20_000 if math.isinf(memory) else memory
    # Weights that decay slowly are summed with a taper, which the limit does not depend on.
    taper = np.cos(np.linspace(0, np.pi / 2, length + 1)) ** 2 if math.isinf(memory) else 1.0
    w = np.exp(-1j * omega * DT)
    pole = RULES[method]
    taps = nfopidn._core.series_weights(pole, order - whole, length) * taper
    if order == whole:
        taps = [1.0]
    wanted = np.polyval(taps[::-1], w) * ((1 - w) / (1 + pole * w)) ** whole
    np.testing.assert_allclose(found, wanted * ((1 + pole) / DT) ** order, rtol=1e-5)
    assert np.isinf(FractionalFilter(-0.5, DT, memory).response(0.0)) == math.isinf(memory)
    assert np.isinf(FractionalFilter(-1.5, DT, memory).response(0.0))


def test_who_asks_for_a_band_is_told_where_the_operator_is_none():
    asked = (0.1, 1.0)
    words = r"is not s\^0.5 from 0.1 to 1 rad/s: magnitude off by up to 42.5 %, phase by 18.8 deg"
    calls = [
        lambda: discretise(0.5, 0.2, "tustin", check_band=asked),
        lambda: discretise(0.5, 0.2, "tustin").errors(asked),
        lambda: FractionalFilter(0.5, 0.2, 100, "tustin", check_band=asked),
        lambda: FractionalFilter(0.5, 0.2, 100, "tustin").errors(asked),
    ]
    for call in calls:
        with pytest.warns(UserWarning, match=f"tustin with a memory of 100 {words}") as caught:
            call()
        assert caught[0].filename == __file__
    with pytest.warns(UserWarning, match="oustaloup with 9 zeros and poles is not"):
        discretise(0.5, 0.2, "oustaloup", check_band=(1.0, 15.0))
    ringing = FractionalFilter(0.5, 1.0, method="tustin")
    with pytest.warns(UserWarning, match=r"tustin with a memory of inf is not s\^0.5"):
        ringing.errors((0.1, math.pi))
    assert ringing.errors()[0] < 0.01  # far below Nyquist's frequency it is
    with pytest.warns(UserWarning, match=r"the controller's s\^-sigma is not s\^-0.8161"):
        truncation_report(nfopidn.Controller.published(), 0.2, asked)
    # None of these is far, or asked for a band.
    discretise(0.5, 0.2, check_band=asked)
    FractionalFilter(0.5, 0.2, check_band=asked)
    discretise(0.5, 0.2, "tustin").errors()
    truncation_report(nfopidn.Controller.published(), 0.2)
    with pytest.raises(ValueError, match="check_band has 1 numbers"):
        discretise(0.5, 0.2, check_band=(1,))
    with pytest.raises(ValueError, match=r"check_band is \(1, 40\) rad/s; must rise"):
        FractionalFilter(0.5, 0.2, check_band=(1, 40))


def test_the_certificate_says_what_it_is_of():
    words = str(FractionalFilter(0.5, 1.0, method="tustin"))
    assert "the rule's kernel to 1.9e-13 over 1000000 samples" in words
    assert "as s^0.5, from 0.0314 to 0.314 rad/s, magnitude off by up to 0.414 %" in words
    assert "not how near that is to s^order" in FractionalFilter.certificate.__doc__


@pytest.mark.filterwarnings("ignore:.*is not s:UserWarning")
def test_errors_are_the_worst_of_the_band():
    model = discretise(0.5, DT, memory=50)
    omega = np.geomspace(1, 10, 400)
    ratio = model.response(omega) / (1j * omega) ** 0.5
    magnitude, phase = model.errors((1, 10))
    assert magnitude == pytest.approx(abs(abs(ratio) - 1).max(), rel=1e-9)
    assert phase == pytest.approx(abs(np.angle(ratio, deg=True)).max(), rel=1e-9)


def test_picture_of_the_methods_has_their_curves():
    panels = nfopidn.plot.discretisation(0.5, DT, memory=20, methods=("gl", "oustaloup"))
    magnitude, phase, error = panels
    assert [text.get_text() for text in magnitude.get_legend().get_texts()] == [
        "ideal",
        "gl",
        "oustaloup",
    ]
    omega, decibel = magnitude.lines[1].get_data()
    wanted = 20 * np.log10(abs(discretise(0.5, DT, "gl", memory=20).response(omega)))
    np.testing.assert_allclose(decibel, wanted, atol=1e-9)
    np.testing.assert_allclose(phase.lines[0].get_ydata(), 45)
    ideal = (1j * omega) ** 0.5
    ratio = discretise(0.5, DT, "oustaloup").response(omega) / ideal
    np.testing.assert_allclose(error.lines[1].get_ydata(), abs(ratio - 1), rtol=1e-9)
    assert [panel.get_ylabel() for panel in panels] == [
        "magnitude [dB]",
        "phase [degree]",
        "relative error [-]",
    ]
    plt.close(magnitude.figure)


# --- sample by sample ---------------------------------------------------------------------------


@pytest.mark.parametrize("memory", [20, 150, math.inf])
def test_threads_take_turns_at_one_filter(memory):
    """Each call's samples stay together, whichever comes first."""
    samples = np.random.default_rng(4).normal(size=(2, 100_000))
    model = FractionalFilter(0.5, DT, memory)
    shared = model.copy()
    with ThreadPoolExecutor(2) as pool:
        found = [tuple(part) for part in pool.map(shared.stream, samples)]
    serial = []
    for order in (0, 1), (1, 0):
        alone = model.copy()
        parts = {i: tuple(alone.stream(samples[i])) for i in order}
        serial.append([parts[0], parts[1]])
    assert found in serial


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("order", [0.5, -0.25])
@pytest.mark.parametrize("memory", [7, 1000, math.inf])
def test_stream_equals_scipys_convolution(rule, order, memory):
    samples = np.random.default_rng(1).normal(size=5000)
    model = FractionalFilter(order, DT, memory, rule)
    length = samples.size if math.isinf(memory) else memory + 1
    weights = nfopidn._core.series_weights(RULES[rule], order, length - 1)
    gain = ((1 + RULES[rule]) / DT) ** order
    wanted = np.convolve(samples, weights)[: samples.size] * gain
    scale = abs(weights).sum() * abs(samples).max() * gain
    np.testing.assert_allclose(model.stream(samples), wanted, rtol=0, atol=1e-12 * scale)
    again = FractionalFilter(order, DT, memory, rule)
    np.testing.assert_array_equal([again.step(u) for u in samples[:50]], again.filter(samples)[:50])


@pytest.mark.parametrize("order", [0.5, -0.5, 1.4, -1.4, 1.0])
def test_long_signals_by_fft_equal_the_steps(order):
    samples = np.random.default_rng(2).normal(size=30_000)
    model = FractionalFilter(order, 1.0, 5000)
    by_steps = model.copy().stream(samples)
    scale = abs(by_steps).max()
    np.testing.assert_allclose(model.filter(samples), by_steps, rtol=0, atol=1e-11 * scale)


def test_fft_keeps_fourteen_digits_of_the_weights_sum():
    samples = np.random.default_rng(3).normal(size=40_000)
    weights = nfopidn._core.series_weights(1.0, 0.5, 10_000)
    out = FractionalFilter(0.5, 2.0, 10_000, "tustin").filter(samples)
    scale = abs(weights).sum() * abs(samples).max()
    for k in (0, 9_999, 10_000, 10_001, 39_999):
        window = samples[max(0, k - 10_000) : k + 1][::-1]
        exact = math.fsum(weights[: window.size] * window)
        assert abs(out[k] - exact) <= 1e-14 * scale


@pytest.mark.parametrize("order", [0.3, 0.5, -0.5])
def test_power_of_time_has_the_closed_form(order):
    """s^a of t^2 is Gamma(3)/Gamma(3 - a) t^(2 - a)."""
    t = DT / 10 * np.arange(4000)
    out = FractionalFilter(order, DT / 10).stream(t**2)
    wanted = 2 / scipy.special.gamma(3 - order) * t ** (2 - order)
    np.testing.assert_allclose(out[1000:], wanted[1000:], rtol=1e-3)


@pytest.mark.parametrize("order", [0.02, 0.5, 0.98, -0.7])
@pytest.mark.parametrize("memory", [100_000, math.inf])
def test_the_certificate_holds_for_the_impulse_response(order, memory):
    model = FractionalFilter(order, 2.0, memory, "tustin")
    assert model.modes <= 160
    assert model.certificate <= 1e-12
    impulse = np.zeros(60_000)
    impulse[0] = 1
    weights = nfopidn._core.series_weights(1.0, order, impulse.size - 1)
    error = abs(model.stream(impulse) / model._filter.gain - weights).sum() / abs(weights).sum()
    assert error <= 2e-12


def test_a_finite_memory_is_good_to_its_end_whatever_the_horizon():
    model = FractionalFilter(-0.5, 1.0, 200_000, "gl", horizon=1000)
    weights = nfopidn._core.series_weights(0.0, -0.5, 200_000)
    out = model.stream(np.ones(300_000))
    np.testing.assert_allclose(out[[150_000, 200_000]], weights.cumsum()[[150_000, 200_000]])
    np.testing.assert_allclose(out[-1], weights.sum())


def test_weights_of_opposite_orders_differ_by_alternating_signs():
    up = nfopidn._core.series_weights(1.0, 0.37, 1000)
    down = nfopidn._core.series_weights(1.0, -0.37, 1000)
    np.testing.assert_allclose(down, up * (-1.0) ** np.arange(1001), rtol=1e-14)


def test_copy_goes_on_alone():
    model = FractionalFilter(0.5, DT)
    model.stream(np.ones(300))
    twin, other = model.copy(), copy.copy(model)
    first = model.step(1.0)
    model.step(5.0)
    assert twin.step(1.0) == first == other.step(1.0)
    model.reset()
    assert model.step(1.0) == FractionalFilter(0.5, DT).step(1.0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_leaves_the_state(bad):
    model, twin = FractionalFilter(0.5, DT), FractionalFilter(0.5, DT)
    for one in (model, twin):
        one.stream(np.arange(500.0))
    with pytest.raises(ValueError, match="must be finite"):
        model.step(bad)
    with pytest.raises(ValueError, match=r"samples\[2\]"):
        model.stream([1.0, 2.0, bad])
    with pytest.raises(ValueError, match=r"samples\[0\]"):
        model.filter([bad])
    assert model.step(1.0) == twin.step(1.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: discretise(2, DT), r"order is 2; must be in \(-2, 2\)"),
        (lambda: discretise(math.nan, DT), "order is nan"),
        (lambda: discretise("a", DT), "order is 'a'"),
        (lambda: discretise(0.5, 0), r"dt is 0; must be in \(1e-40, 1e\+40\) s"),
        (lambda: discretise(0.5, -1), "dt is -1"),
        (lambda: discretise(0.5, DT, "euler"), "method is 'euler'; must be one of tustin"),
        (lambda: discretise(0.5, DT, memory=-1), r"memory is -1; must be in \[0, 10000000\]"),
        (lambda: discretise(0.5, DT, memory=2.5), "memory is 2.5; must be a whole number"),
        (lambda: discretise(0.5, DT, "tustin-cf", sections=0), "sections is 0"),
        (lambda: discretise(0.5, DT, prewarp=40.0), "prewarp is 40"),
        (lambda: discretise(0.5, DT).errors((1, 40)), "Nyquist's frequency 31.4159"),
        (lambda: discretise(0.5, DT).errors((2, 1)), "must rise"),
        (lambda: discretise(0.5, DT).errors((1,)), "band has 1 numbers"),
        (lambda: discretise(0.5, DT, "oustaloup", band="x"), "band is 'x'"),
        (lambda: discretise(0.5, DT, band=(1, 2)), "does not apply to 'gl'"),
        (lambda: discretise(0.5, DT, []), "method is"),
        (lambda: FractionalFilter(-2, DT), "order is -2"),
        (lambda: FractionalFilter(0.5, DT, -1), "memory is -1"),
        (lambda: FractionalFilter(0.5, DT, 1.5), "memory is 1.5"),
        (lambda: FractionalFilter(0.5, DT, -math.inf), "memory is -inf"),
        (lambda: FractionalFilter(0.5, DT, method="oustaloup"), "method is 'oustaloup'"),
        (lambda: FractionalFilter(0.5, DT, horizon=10), "horizon is 10"),
        (lambda: FractionalFilter(0.5, DT).filter([[1.0]]), "samples has 2 dimensions"),
    ],
)
def test_bad_arguments_are_named(call, message):
    with pytest.raises(ValueError, match=message):
        call()


HUGE = 10**400
LONGER_THAN_PYTHON_PRINTS = 10**5000


@pytest.mark.parametrize(
    "huge", [HUGE, -HUGE, LONGER_THAN_PYTHON_PRINTS], ids=["huge", "-huge", "longest"]
)
@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda huge: discretise(huge, DT), r"order is a whole.* digits; must be in \(-2, 2\)"),
        (lambda huge: discretise(0.5, huge), "dt is a whole number .* s"),
        (lambda huge: discretise(0.5, DT, memory=huge), "memory is a whole number .* 10000000"),
        (lambda huge: discretise(0.5, DT, prewarp=huge), "prewarp is a whole number .* rad/s"),
        (lambda huge: discretise(0.5, DT).errors((1, huge)), "band is .* low and high"),
        (lambda huge: discretise(0.5, DT).response([huge]), "frequency must be real numbers"),
        (lambda huge: FractionalFilter(huge, DT), "order is a whole number"),
        (lambda huge: FractionalFilter(0.5, DT, huge), "memory is a whole number"),
        (lambda huge: FractionalFilter(0.5, DT).step(huge), "sample is a whole number"),
        (lambda huge: FractionalFilter(0.5, DT).stream([huge]), "samples must be real numbers"),
        (lambda huge: FractionalFilter(0.5, DT).filter([huge]), "samples must be real numbers"),
        (lambda huge: to_discrete([[huge] * 3] * 3, 0.5, 0.5, DT), "gains must be real numbers"),
        (lambda huge: to_discrete(np.eye(3), huge, 0.5, DT), "alpha must be real numbers"),
        (lambda huge: to_continuous(np.eye(3), 0.5, 0.5, huge), "dt is a whole number"),
        (lambda huge: retune(nfopidn.Controller.published(), huge), "dt is a whole number"),
        (
            lambda huge: retune(nfopidn.Controller.published(), 0.2, new_dt=huge),
            "new_dt is a whole number .* s",
        ),
        (
            lambda huge: retune(nfopidn.Controller.published(), 0.2, memory=huge),
            r"memory is a whole number .* in \[0, 1000000\]",
        ),
        (
            lambda huge: truncation_report(nfopidn.Controller.published(), huge),
            "dt is a whole number",
        ),
    ],
)
def test_whole_numbers_beyond_every_float_are_named(call, message, huge):
    with pytest.raises(ValueError, match=message):
        call(huge)


@pytest.mark.parametrize("text", ["0.5", b"1", None, 1j])
@pytest.mark.parametrize(
    "call",
    [
        lambda text: FractionalFilter(0.5, DT).step(text),
        lambda text: FractionalFilter(0.5, DT).stream([text]),
        lambda text: FractionalFilter(0.5, DT).filter([text]),
        lambda text: discretise(0.5, DT).response([text]),
        lambda text: discretise(0.5, DT).errors((text, 4)),
        lambda text: discretise(0.5, DT).to_control([text]),
        lambda text: to_discrete([[text] * 3] * 3, 0.5, 0.5, DT),
        lambda text: to_discrete(np.eye(3), text, 0.5, DT),
        lambda text: to_continuous(np.eye(3), 0.5, [text] * 3, DT),
    ],
)
def test_what_is_no_number_is_not_read_as_one(call, text):
    with pytest.raises(ValueError, match=r"must be (a number|real numbers|low and high)"):
        call(text)


def test_long_doubles_are_numbers():
    half, five = np.longdouble(0.5), np.longdouble(5)
    assert FractionalFilter(half, DT).step(half) == FractionalFilter(0.5, DT).step(0.5)
    assert math.isinf(FractionalFilter(0.5, DT, np.longdouble(math.inf)).memory)
    published = nfopidn.Controller.published()
    assert retune(published, np.longdouble(0.2)) == retune(published, 0.2)
    assert retune(published, 0.2).controller == published.replace(sample_time=0.2)
    with pytest.raises(ValueError, match=r"memory is np.longdouble\('5.0'\); must be a whole"):
        retune(published, 0.2, memory=five)
    with pytest.raises(ValueError, match="order is inf"):
        discretise(np.longdouble(10) ** 400, DT)


def test_samples_that_would_overflow_are_refused():
    """They left infinity in the filter, for good."""
    model = FractionalFilter(0.5, DT)
    with pytest.raises(ValueError, match=r"sample is 1e\+101; must be a number in \[-1e\+100"):
        model.step(1e101)
    with pytest.raises(ValueError, match=r"samples\[1\] is -1e\+200; must be a number in"):
        model.stream([0.0, -1e200])
    assert math.isfinite(model.step(1e100))
    for dt in (1e-41, 1e41):
        with pytest.raises(ValueError, match=f"dt is {dt:g}".replace("+", r"\+")):
            FractionalFilter(1.9, dt)
    assert math.isfinite(FractionalFilter(-1.9, 1e39).step(1e100))


@pytest.mark.parametrize(
    ("method", "order"), [*((m, -1) for m in METHODS), ("tustin-cf", -1.5), ("oustaloup", -1.5)]
)
def test_at_a_pole_the_response_is_infinite(method, order):
    found = discretise(order, DT, method).response([0.0, 1.0])
    assert np.isinf(found[0].real)
    assert np.isfinite(found[1])
    with pytest.raises(ValueError, match="not finite"):
        discretise(order, DT, method).response(math.inf)


# --- controllers --------------------------------------------------------------------------------


def test_long_memory_in_the_closed_loop():
    costs = [
        nfopidn.simulate(controller=nfopidn.Controller.published(memory=memory)).cost
        for memory in (900, 1024, 1025, 100_000, math.inf, "inf")
    ]
    np.testing.assert_allclose(costs, costs[0], rtol=1e-12)


def test_long_memory_step_by_step_equals_short():
    short = nfopidn.Controller.published(memory=1024)
    long = nfopidn.Controller.published(memory=math.inf)
    rows = nfopidn.Scenario.published(rng=0).reference
    rng = np.random.default_rng(4)
    for row in rows[:600]:
        pose = row[:3] + rng.normal(size=3) * 0.05
        np.testing.assert_allclose(long.step(pose, row), short.step(pose, row), atol=1e-13)
    np.testing.assert_allclose(long.feedback(), short.feedback(), atol=1e-13)
    long.reset()
    short.reset()
    np.testing.assert_allclose(long.step(rows[3, :3], rows[0]), short.step(rows[3, :3], rows[0]))


def test_infinite_memory_is_kept_by_documents(tmp_path):
    controller = nfopidn.Controller.published(memory=math.inf)
    controller.save(tmp_path / "c.json")
    assert '"memory": "inf"' in (tmp_path / "c.json").read_text()
    again = nfopidn.Controller.load(tmp_path / "c.json")
    assert again == controller
    assert math.isinf(again.memory)
    assert eval(repr(controller), {"Controller": nfopidn.Controller}) == controller


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"memory": 1_000_001}, "memory is 1000001"),
        ({"memory": -math.inf}, "memory is -inf"),
        ({"memory": 2000, "alpha": 1.5}, r"alpha is 1.5; must be in \(-1, 1\) with a memory"),
        ({"memory": math.inf, "sigma": 0.0}, r"sigma is 0; must be in \(0, 2\) with a memory"),
    ],
)
def test_long_memory_is_refused_where_it_cannot_be(changes, message):
    with pytest.raises(ValueError, match=message):
        nfopidn.Controller.published(**changes)


def test_what_needs_taps_refuses_long_memory():
    with pytest.raises(ValueError, match="memory is inf; has no end of taps"):
        _ = nfopidn.Controller.published(memory=math.inf).taps
    for memory in (2000, math.inf):
        with pytest.raises(ValueError, match=rf"memory is {memory}; must be in .* for firmware"):
            nfopidn.export_c(nfopidn.Controller.published(memory=memory), "nowhere")
    with pytest.raises(ValueError, match=r"memory is 2000; must be in \[0, 1024\] samples to tune"):
        nominal.tune(structure={"memory": 2000}, maxfev=10)


def test_gains_go_to_discrete_and_back():
    published = nfopidn.Controller.published()
    gains, alpha, sigma = published.gains, published.alpha, published.sigma
    continuous = to_continuous(gains, alpha, sigma, 0.2)
    scale = 15 / math.tan(1.5)
    np.testing.assert_allclose(continuous, gains * [1, scale**sigma, scale**-alpha], rtol=1e-14)
    np.testing.assert_allclose(to_discrete(continuous, alpha, sigma, 0.2), gains, rtol=1e-14)
    made = nfopidn.Controller.from_continuous(continuous, alpha, sigma, 0.2, memory=7)
    np.testing.assert_allclose(made.gains, gains, rtol=1e-14)
    assert made.memory == 7


@pytest.mark.parametrize(("dt", "prewarp", "generator"), [(0.05, None, "tustin"), (0.3, 15, "gl")])
def test_continuous_gains_by_other_rules(dt, prewarp, generator):
    gains = np.arange(9.0).reshape(3, 3)
    made = nfopidn.Controller.from_continuous(
        gains, [0.5, 0.6, 0.7], 0.9, dt, prewarp, generator=generator
    )
    wanted = to_discrete(gains, [0.5, 0.6, 0.7], 0.9, dt, prewarp=prewarp, generator=generator)
    np.testing.assert_allclose(made.gains, wanted, rtol=1e-14)
    scale = 1 / dt if generator == "gl" else 2 / dt
    np.testing.assert_allclose(wanted[:, 2], gains[:, 2] * scale ** np.array([0.5, 0.6, 0.7]))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.eye(3), 0.5, 0.5, 0.0), "dt is 0; must be"),
        ((np.eye(3), 0.5, 0.5, 0.2, 16.0), "prewarp is 16"),
        ((np.eye(3), 0.5, 0.5, 0.2, "x"), "prewarp is 'x'; must be a number"),
        ((np.eye(2), 0.5, 0.5, 0.2), "gains"),
        ((np.eye(3), 3.0, 0.5, 0.2), "alpha"),
        ((np.full((3, 3), 1000.0), 1.0, 1.0, 1e-3), "gains.* is 19999.*must be in"),
    ],
)
def test_bad_continuous_gains_are_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        nfopidn.Controller.from_continuous(*arguments)


@pytest.mark.parametrize("form", ["positional", "incremental"])
@pytest.mark.parametrize("generator", ["tustin", "gl"])
def test_retune_keeps_the_frequency_response(form, generator):
    """In torque for an error: of a filter run on a sine, not of retune's own report."""
    base = nfopidn.Controller.published(form=form, generator=generator, memory=300)
    omega, time = 0.5, 400 * np.pi
    amplitudes = []
    for controller, dt in (
        (base, 0.2),
        (retune(base, 0.2, new_dt=0.1, memory=600).controller, 0.1),
        (retune(base, 0.2, new_dt=0.05, memory=1000).controller, 0.05),
    ):
        t = np.arange(0, time, dt)
        net = scipy.signal.lfilter(controller.taps[2], [1.0], np.sin(omega * t))
        torque = np.cumsum(net) if form == "incremental" else net
        last = slice(-round(8 * np.pi / dt), None)
        wave = np.column_stack([np.sin(omega * t), np.cos(omega * t), np.ones_like(t)])[last]
        amplitudes.append(np.linalg.lstsq(wave, torque[last])[0][:2])
    for changed in amplitudes[1:]:
        miss = np.linalg.norm(changed - amplitudes[0]) / np.linalg.norm(amplitudes[0])
        assert miss < 0.05


def test_retune_keeps_the_continuous_gains():
    controller = nfopidn.Controller.published(form="incremental")
    orders = controller.alpha, controller.sigma
    for prewarp in (None, 3.0):
        report = retune(controller, 0.2, new_dt=0.1, prewarp=prewarp, memory=10)
        assert report.controller.memory == 10
        continuous = to_continuous(controller.gains, *orders, 0.2, prewarp=prewarp)
        again = to_continuous(report.controller.gains, *orders, 0.1, prewarp=prewarp)
        np.testing.assert_allclose(again, continuous, rtol=1e-13)
        assert all(0.001 < change < 0.2 for change in report.change)
        assert "%" in str(report)


def test_retune_to_the_same_is_the_same():
    controller = nfopidn.Controller.published()
    same = retune(controller, 0.2)
    assert same.controller == controller.replace(sample_time=0.2)
    assert max(same.change) < 1e-14
    longer = retune(controller.replace(memory=1000), 0.2, memory=math.inf)
    assert math.isinf(longer.controller.memory)
    assert max(longer.change) < 0.02
    alone = controller.replace(gains=controller.gains * [[1], [0], [1]])
    assert retune(alone, 0.2).change[1] == 0


def test_retune_warns_of_another_response():
    with pytest.warns(UserWarning, match=r"retune: largest change .* x 78.* %"):
        report = retune(nfopidn.Controller.published(), 0.2, new_dt=0.1, prewarp=15.0)
    assert report.change[0] > 0.2
    with pytest.warns(UserWarning, match="retune"):
        retune(nfopidn.Controller.published(), 0.2, memory=math.inf)


@pytest.mark.parametrize("generator", ["tustin", "gl"])
def test_of_infinite_memory_the_response_is_that_of_the_whole_series(generator):
    """Weights that never decay are summed with a taper, which the limit does not depend on."""
    settings = {"alpha": 0.9, "sigma": 1.3, "generator": generator}
    controller = nfopidn.Controller.published(memory=math.inf, **settings)
    dt, omega, count = 0.2, np.array([0.4, 2.0]), 20_000
    found = controller_response(controller, dt, omega)
    w = np.exp(-1j * omega * dt)
    taper = np.cos(np.linspace(0, np.pi / 2, count)) ** 2
    pole = RULES[generator]
    derivative, integral = (
        np.polynomial.polynomial.polyval(
            w, taper * nfopidn._core.series_weights(pole, order, count - 1)
        )
        for order in (0.9, -0.3)
    )
    for channel, (kp, ki, kd) in enumerate(controller.gains):
        wanted = (1 - w) * (kp + kd * derivative) + ki * (1 + pole * w) * integral
        np.testing.assert_allclose(found[channel], wanted, rtol=1e-6)


def test_report_tells_how_far_the_operators_are():
    short = truncation_report(nfopidn.Controller.published(), 0.2)
    long = truncation_report(nfopidn.Controller.published(memory=math.inf), 0.2)
    assert [entry.operator for entry in short.errors] == ["s^alpha", "s^-sigma"]
    for poor, good in zip(short.errors, long.errors, strict=True):
        assert poor.magnitude > 5 * good.magnitude
        assert good.magnitude < 0.01
    assert "not the fractional operator" in str(short) or "roughly" in str(short)
    wanted = discretise(0.1078, 0.2, "tustin", memory=5).errors(short.band)
    assert (short.errors[0].magnitude, short.errors[0].phase) == pytest.approx(wanted, rel=1e-12)
    by_channel = nfopidn.Controller.published(alpha=[0.1, 0.2, 0.3])
    assert len(truncation_report(by_channel, 0.2).errors) == 6
    with pytest.raises(ValueError, match="free taps"):
        truncation_report(nfopidn.Controller.from_taps(np.ones((3, 4))), 0.2)
    with pytest.raises(ValueError, match="Nyquist"):
        truncation_report(nfopidn.Controller.published(), 0.2, (1, 20))


@pytest.mark.filterwarnings("ignore:.*is not s:UserWarning")
@pytest.mark.parametrize(("generator", "alpha"), [("tustin", 1.0), ("gl", 1.0), ("tustin", -1.0)])
def test_whole_orders_of_a_controller_are_truncated_too(generator, alpha):
    """The differentiator by Tustin's rule is no finite sum: 1 - 2w + 2w^2 - ..."""
    controller = nfopidn.Controller.published(alpha=alpha, generator=generator, memory=7)
    entry = truncation_report(controller, DT, (1.0, 10.0)).errors[0]
    omega = np.geomspace(1, 10, 400)
    weights = exact_weights(generator, alpha, 7)
    w = np.exp(-1j * omega * DT)
    scale = (1 if generator == "gl" else 2) / DT
    ratio = scale**alpha * sum(c * w**j for j, c in enumerate(weights)) / (1j * omega) ** alpha
    assert entry.magnitude == pytest.approx(abs(abs(ratio) - 1).max(), rel=1e-9)
    assert entry.phase == pytest.approx(abs(np.angle(ratio, deg=True)).max(), rel=1e-9)
    assert (entry.magnitude > 0.5) == (generator == "tustin")


def test_infinite_memory_is_not_truncated_in_the_report():
    """At 1e-6 rad/s, where 100,000 samples of 0.2 s are a small part of a period."""
    controller = nfopidn.Controller.published(memory=math.inf)
    for entry in truncation_report(controller, 0.2, (1e-6, 1e-3)).errors:
        assert entry.magnitude < 1e-6
        assert entry.phase < 1e-4
