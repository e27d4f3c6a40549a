"""Another rounding, left on by another library, changes no result and is still there afterwards."""

# ruff: noqa: PLW0108 - the work is to be done whole when it is called

import ctypes
import ctypes.util
import pickle
import platform

import nfopidn
import nominal
import numpy as np
import pytest
from nfopidn import (
    Controller,
    Objective,
    Rival,
    Scenario,
    Trajectory,
    _core,
    fractional,
    stability,
)

LIBM = ctypes.CDLL(ctypes.util.find_library("m"))
X86 = platform.machine() in ("x86_64", "AMD64")
#: What <fenv.h> calls them.
MODES = (
    {"upward": 0x800, "downward": 0x400, "toward zero": 0xC00}
    if X86
    else {"upward": 0x400000, "downward": 0x800000, "toward zero": 0xC00000}
)


#: The caller's own arithmetic is the caller's, and is done before.
SAMPLES = np.linspace(0, 1, 300)
POINTS = np.full((30, 11), 0.2)


def tuned(**arguments):
    return nominal.tune(rng=1, maxfev=400, **arguments).x.tolist()


def stepped():
    controller = Controller.published(memory=40)
    row = Scenario.published(rng=0).reference[3]
    return [controller.step((3.9, 0.1, 1.0), row) for _ in range(5)]


def filtered():
    long = fractional.FractionalFilter(0.37, 0.01, memory=5000)
    return [*long.stream(SAMPLES), long.step(0.1)]


def numbers_read():
    gains, rest = Controller.published().to_json().split(',"alpha"')
    gains = gains.replace("0.", "0.1234567890123456789")
    return Controller.from_json(f'{gains},"alpha"{rest}').gains.tolist()


def noisy():
    scenario = Scenario.published(pose_noise=(0.01, 0.01), rng=3, integrator="exact")
    return nfopidn.simulate(scenario).cost


def circled():
    scenario = Scenario(Trajectory.circle(), rng=0)
    loop = stability.loop(scenario, Controller.tuned_nominal())
    return [loop.log_radius, *loop.multipliers.tolist()]


def minimised():
    """With a function of Python's own arithmetic, whose many digits are rounded."""
    found = nfopidn.bfoa(
        lambda x: float(((x - 0.3) ** 2).sum() / 7), [(-1, 1)] * 3, rng=1, maxfev=300
    )
    return [found.fun, *found.x.tolist(), *found.history["mean"].tolist()]


def compared():
    """Of a noisy scenario, whose metrics differ from run to run."""
    scenario = Scenario.published(pose_noise=(0.01, 0.01), rng=3)
    members = {"one": Controller.published(), "two": Controller.published(memory=7)}
    found = nfopidn.compare(members, {"noisy": scenario}, seeds=8)
    ranking = found.ranking("noisy")
    return [*(np.ravel(table).tolist() for table in found.values.values()), ranking]


def discretised():
    many = fractional.discretise(0.37, 0.01, memory=50)
    few = fractional.discretise(0.37, 0.01, "oustaloup")
    responses = [model.response([0.3, 2.0, 50.0]) for model in (many, few)]
    return [*many.zeros, *np.ravel(responses).tolist(), *many.errors(), *few.errors()]


def retuned():
    report = fractional.retune(Controller.tuned_nominal(), new_dt=0.19)
    return [*report.change, *np.ravel(report.controller.gains)]


def margins_of(controller):
    found = stability.margins(controller, Scenario.published(rng=0))
    return [*found.poles, *found.drive.gain, found.steering.phase, found.wheels.disk]


WORK = {
    "simulate": lambda: nfopidn.simulate().columns["x"].tolist(),
    "simulate with noise": noisy,
    "simulate a rival": lambda: nfopidn.simulate(controller=Rival("lqr")).cost,
    "read": lambda: Scenario.from_json(Scenario.published(rng=0).to_json()).reference.tolist(),
    "a number read": numbers_read,
    "trajectory": lambda: Trajectory.lemniscate().theta.tolist(),
    "reference": lambda: Scenario.published(rng=0).reference.tolist(),
    "costs": lambda: Objective(workers=2).costs(POINTS).tolist(),
    "gradient": lambda: Objective().gradient(POINTS[0])[1].tolist(),
    "tune": tuned,
    "tune bfoa": lambda: tuned(method="bfoa"),
    "tune a rival": lambda: tuned(structure="samson"),
    "step": stepped,
    "taps": lambda: Controller.published().taps.tolist(),
    "filter": filtered,
    "approximate": lambda: _core.oustaloup(0.37, 0.01, 3.0, 7, 0.1, 50.0),
    "expand": lambda: _core.series_weights(1 / 7, 0.37, 50).tolist(),
    "stability": circled,
    "bfoa": minimised,
    "compare": compared,
    "discretise": discretised,
    "retune": retuned,
    "truncation": lambda: [
        (error.magnitude, error.phase)
        for error in fractional.truncation_report(Controller.tuned_nominal()).errors
    ],
    "margins": lambda: margins_of(Controller.published()),
    "margins of long memory": lambda: margins_of(Controller.published(memory=200)),
    "z plane": lambda: pickle.dumps(
        (stability.controller(Controller.published(memory=20)), stability.operator(0.37, 20))
    ),
}


@pytest.fixture(params=MODES.values(), ids=MODES.keys())
def other_rounding(request):
    """Set a rounding; a function that tells whether it is still that one."""

    def set_mode():
        assert LIBM.fesetround(request.param) == 0
        return lambda: LIBM.fegetround() == request.param

    yield set_mode
    LIBM.fesetround(0)


@pytest.mark.parametrize("work", WORK.values(), ids=WORK.keys())
def test_results_and_rounding_are_as_before(work, other_rounding):
    right = work()
    is_set = other_rounding()
    found = work()
    kept = is_set()
    LIBM.fesetround(0)
    assert found == right
    assert kept
