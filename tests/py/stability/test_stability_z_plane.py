"""nfopidn.stability.controller and operator: zeros, poles, the three-way verdict."""

import mpmath
import numpy as np
import pytest
import scipy.signal
from nfopidn import Controller, stability
from refusal import refused


def test_zeros_are_those_of_the_taps():
    controller = Controller.published()
    for taps, plane in zip(
        controller.taps, stability.controller(controller).channels.values(), strict=True
    ):
        assert len(plane.zeros) == len(plane.poles) == 6
        np.testing.assert_allclose(np.polyval(taps, plane.zeros), 0, atol=1e-12)
        assert np.all(plane.poles == 0)
        assert np.all(np.diff(np.abs(plane.zeros)) <= 0)
        assert plane.verdict == "stable"


@pytest.mark.parametrize("controller", [Controller.published(), Controller.tuned_nominal()])
def test_incremental_form_sums_up(controller):
    controller = controller.replace(form="incremental")
    found = stability.controller(controller)
    assert found.verdict == "critically stable"
    point = 0.3 + 0.8j
    for taps, plane in zip(controller.taps, found.channels.values(), strict=True):
        response = np.sum(taps * point ** -np.arange(len(taps))) * point / (point - 1)
        first = taps[np.flatnonzero(taps)[0]]
        of_roots = first * np.prod(point - plane.zeros) / np.prod(point - plane.poles)
        assert of_roots == pytest.approx(response, rel=1e-9)
        assert plane.poles_place == "on"


def test_a_difference_cancels_the_sum():
    taps = [[1.0, -1.0], [1.0, 0.5], [0.0, 0.0]]
    found = stability.controller(Controller.from_taps(taps, form="incremental"))
    assert found.x.poles.size == found.x.zeros.size == 0
    assert found.x.verdict == "stable"
    np.testing.assert_allclose(found.y.poles, [1])
    np.testing.assert_allclose(found.y.zeros, [-0.5])
    assert found.theta.zeros.size == 0
    assert found.verdict == "critically stable"
    assert str(found).splitlines()[1].startswith("y: critically stable: 1 pole on the unit circle")


@pytest.mark.parametrize(
    ("order", "memory", "generator", "zeros", "place"),
    [
        (0.5, 2, "tustin", [0.5 + 0.5j, 0.5 - 0.5j], "inside"),  # z^2 - z + 1/2
        (1, 1, "gl", [1], "on"),  # z - 1
        (1, 4, "gl", [1, 0, 0, 0], "on"),
        (1, 1, "tustin", [2], "outside"),  # z - 2
        (-1, 1, "gl", [-1], "on"),  # z + 1
        (0, 3, "tustin", [0, 0, 0], "inside"),
        (0.7, 0, "gl", [], "inside"),
    ],
)
def test_the_operators_zeros_in_closed_form(order, memory, generator, zeros, place):
    plane = stability.operator(order, memory, generator)
    np.testing.assert_allclose(np.sort_complex(plane.zeros), np.sort_complex(zeros), atol=1e-9)
    assert plane.zeros_place == place
    assert plane.poles_place == "inside"
    assert len(plane.poles) == len(plane.zeros)


@pytest.mark.parametrize("order", [0.1078, -0.8161, 1.7])
def test_the_operators_series_is_that_of_its_generating_function(order):
    plane = stability.operator(order, 6)
    expected = mpmath.taylor(lambda w: ((1 - w) / (1 + w)) ** order, 0, 6)
    np.testing.assert_allclose(np.poly(plane.zeros), np.array(expected, dtype=float), atol=1e-9)


def test_a_memory_beyond_the_matrices_is_refused():
    for memory in (1025, 100_000, "inf"):
        controller = Controller.published(memory=memory)
        for use in (stability.controller, stability.margins):
            with refused("controller has memory", "[0, 1024] samples"):
                use(controller)
    for use in (stability.controller, stability.margins):
        with refused("controller is 'a'", "must be a Controller"):
            use("a")


def test_arguments_out_of_range_are_refused():
    with refused("order is 2.5", "in [-2, 2]"):
        stability.operator(2.5)
    with refused("order is nan", "in [-2, 2]"):
        stability.operator(np.nan)
    for memory in (-1, 1025, 2.5):
        with refused(f"memory is {memory}", "whole number in [0, 1024]"):
            stability.operator(0.5, memory)
    with refused("generator is 'oustaloup'", "'tustin', 'gl'"):
        stability.operator(0.5, 5, "oustaloup")


def test_the_tracking_law_has_its_poles_and_integrals():
    """Zeros and poles make the filter's own answer to a pulse, run sample by sample."""
    controller = Controller.recommended().replace(
        **dict.fromkeys(("amplitude_x", "amplitude_y", "amplitude_theta"), 1),
        activation="linear",
        pole_x=0.3,
    )
    planes = stability.controller(controller).channels
    for name, pole in (("x", "pole_x"), ("y", "pole_theta"), ("theta", "pole_theta")):
        poles = planes[name].poles
        for own in (-getattr(controller, pole), controller.integral_retention):
            assert np.abs(poles - own).min() < 1e-12
        assert planes[name].verdict == "stable"
    speed, dt, drive = 0.3, controller.sample_time, []
    for size in (0.01, 0):
        running = controller.copy()
        for k in range(26):
            reference = (speed * dt * k, 0, 0, speed, 0, 0, 0, 0)
            pose = (speed * dt * k - (size if k == 1 else 0), 0, 0)
            drive.append(sum(running.step(pose, reference, 1e3)))
    # Without what the first sample's speed error adds, which is that of a robot at rest.
    found = np.subtract(drive[1:26], drive[27:])
    _, expected = scipy.signal.dimpulse(
        (planes["x"].zeros, planes["x"].poles, 1.0, dt), n=len(found)
    )
    answer = expected[0].ravel()
    np.testing.assert_allclose(found / found[0], answer / answer[0], atol=1e-9)
    without = controller.replace(integral_x=0, pole_x=0)
    assert np.all(stability.controller(without).x.poles == 0)
