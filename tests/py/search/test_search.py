"""bfoa() and Forager: their arguments, how they end, and that only the seed decides the course."""

import contextlib
import functools
import gc
import math
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
import traceback

import nfopidn
import nominal
import numpy as np
import pytest
from nfopidn import Forager, OptimizeResult, _core, bfoa
from nfopidn.engines import processes as _workers
from nfopidn.search.optimise import MESSAGES
from numpy.testing import assert_allclose, assert_array_equal
from refusal import refused
from results import same, watcher

METHODS = ("bfoa+", "bfoa", "cma")
BOX = [(-2.0, 3.0), (0.0, 1.0), (-5.0, -1.0)]
CENTRE = np.array([0.5, 0.25, -4.0])
SHORT = {"reproductions": 2, "dispersals": 2, "chemotactic_steps": 4}


def bowl(x):
    return float(((x - CENTRE) ** 2).sum())


def bowls(points):
    return ((points - CENTRE) ** 2).sum(axis=1)


def half_infinite(x):
    return math.inf if x[0] < 0.6 else bowl(x)


class Counted:
    """A function that counts its calls, and may act at one of them."""

    def __init__(self, at=None, act=None):
        self.calls, self.at, self.act = 0, at, act
        self.costs = []

    def __call__(self, x):
        self.calls += 1
        if self.calls == self.at:
            value = self.act()
            if value is not None:
                return value
        self.costs.append(bowl(x))
        return self.costs[-1]


def throw(error):
    def act():
        raise error

    return act


def search(func=bowl, bounds=BOX, **arguments):
    return bfoa(func, bounds, **({"rng": 1, "maxfev": 400} | arguments))


# Results


@pytest.mark.parametrize("method", METHODS)
def test_the_fields_of_a_result(method):
    func = Counted()
    result = search(func, method=method, maxfev=700)
    assert isinstance(result, OptimizeResult)
    assert isinstance(result, dict)
    cells = {"bfoa+": 20, "bfoa": 10, "cma": 7}[method]
    assert result.x.shape == (3,)
    assert result.population.shape == (cells, 3)
    assert result.population_energies.shape == (cells,)
    assert bowl(result.x) == result.fun == min(func.costs) == result["fun"]
    assert_array_equal([bowl(x) for x in result.population], result.population_energies)
    assert result.nfev == func.calls == 700
    assert result.nit == len(result.history) > 3
    assert result.history.dtype.names == ("l", "k", "j", "nfev", "best", "mean", "step")
    assert (np.diff(result.history["nfev"]) >= 0).all()
    assert (np.diff(result.history["best"]) <= 0).all()
    assert result.history["best"][-1] == result.fun
    assert result.history["mean"][-1] == pytest.approx(result.population_energies.mean())
    assert (result.history["best"] <= result.history["mean"]).all()
    assert result.seed == 1
    assert (result.success, result.status) == (False, 1)
    assert result.message == "The budget of evaluations is used up."
    assert result.elapsed > 0
    assert set(dir(result)) > {"x", "history", "plot"}
    assert repr(result).startswith(f"OptimizeResult(fun={result.fun:.6g}, nfev=700, 'The budget")
    with pytest.raises(AttributeError, match="cost"):
        _ = result.cost


@pytest.mark.parametrize("method", METHODS)
def test_points_are_within_bounds(method):
    low, high = np.array(BOX).T
    points = []

    def slope(x):  # drives cells into a corner
        points.append(x.copy())
        return float(x.sum())

    result = search(slope, method=method)
    assert (np.array(points) >= low).all()
    assert (np.array(points) <= high).all()
    assert result.fun == pytest.approx(low.sum(), abs=0.2)


@pytest.mark.parametrize("method", METHODS)
def test_numbers_at_a_bound_are_marked_and_printed(method):
    """Of -x0, x1 and a bowl within the box: the first ends above, the second below."""
    box = [(0.0, 2.0), (-1.0, 1.0), (-1.0, 1.0)]
    result = bfoa(
        lambda x: -x[0] + x[1] + x[2] ** 2, box, rng=1, method=method, maxfev=4000, workers=1
    )
    low, high = np.array(box).T
    near = 1e-4 * (high - low)
    sides = (result.x >= high - near).astype(int) - (result.x <= low + near)
    assert_array_equal(result.active_mask, sides)
    assert result.active_mask.tolist() == [1, -1, 0]
    assert result.at_bounds() == {"x[0]": "upper", "x[1]": "lower"}
    lines = str(result).splitlines()
    assert lines[0] == f"OptimizeResult: {result.message}"
    assert lines[1].split() == ["cost", f"{result.fun:.8g}"]
    assert lines[2].split() == ["evaluations", "4000"]
    assert lines[3].split() == ["time", f"{result.elapsed:.2f}", "s"]
    assert lines[4].split() == ["seed", "1"]
    # cma comes as near as its last steps are small; the others end on the bound itself.
    assert_allclose(result.x[:2], [2, -1], rtol=0, atol=1e-6 if method == "cma" else 0)
    # What is printed is what x has, near the bound too.
    assert lines[5:] == [
        f"  x[0]         {result.x[0]:.10g}  (at its upper bound)",
        f"  x[1]         {result.x[1]:.10g}  (at its lower bound)",
        f"  x[2]         {result.x[2]:.10g}",
    ]


def test_a_long_result_is_printed_in_part():
    text = str(bfoa(lambda x: float((x**2).sum()), [(-1, 2)] * 100, rng=1, maxfev=200))
    assert text.splitlines()[-1].split() == ["...", "and", "64", "more"]
    assert len(text.splitlines()) == 42
    assert str(OptimizeResult(fun=1.0, nfev=2)) == "OptimizeResult(fun=1, nfev=2)"


def test_the_improved_method_finds_the_least():
    result = search(maxfev=3000)
    assert result.fun < 1e-10
    assert np.abs(result.x - CENTRE).max() < 1e-5


def test_defaults_of_the_budget():
    func = Counted()
    assert bfoa(func, BOX, rng=1).nfev == func.calls == 10_000
    result = bfoa(bowl, BOX, rng=1, method="bfoa", options=SHORT)
    assert result.message == "The schedule is complete."
    assert (result.success, result.status, result.nit) == (True, 0, 2 * 2 * 4)


# Arguments


@pytest.mark.parametrize(
    ("bounds", "parts"),
    [
        ([(0, 1), (1, 0)], ["bounds of coordinate 1", "(1.0, 0.0)", "smaller"]),
        ([(0, 1), (0, 1), (math.nan, 1)], ["coordinate 2", "nan", "finite"]),
        ([(0, math.inf)], ["coordinate 0", "inf", "finite"]),
        ([(-math.inf, 0)], ["coordinate 0", "-inf", "finite"]),
        ([(0, 1), (-1e308, 1e308)], ["bounds of coordinate 1", "1e+308"]),
        ([0, 1], ["bounds", "(2,)", "(p, 2)"]),
        ([(0, 1, 2)], ["bounds", "(1, 3)", "(p, 2)"]),
        ([("0", "1")], ["bounds are", "must be numbers (p, 2)"]),
        ([(0, 1j)], ["bounds are", "must be numbers (p, 2)"]),
        (np.zeros((0, 2)), ["bounds", "(0, 2)", "(p, 2)"]),
        ([[(0, 1)]], ["bounds", "(1, 1, 2)", "(p, 2)"]),
    ],
)
@pytest.mark.parametrize("make", [lambda b: search(bounds=b), Forager], ids=["bfoa", "Forager"])
def test_bad_bounds_are_refused(make, bounds, parts):
    with refused(*parts):
        make(bounds)


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        ({"method": "pso"}, ["method is 'pso'", "'bfoa+'", "'bfoa'"]),
        ({"maxfev": 0}, ["maxfev is 0", "[1, 2**62)"]),
        ({"maxfev": math.nan}, ["maxfev is nan", "whole number"]),
        ({"maxfev": math.inf}, ["maxfev is inf", "whole number"]),
        ({"maxfev": 2.5}, ["maxfev is 2.5", "whole number"]),
        ({"maxfev": True}, ["maxfev is True", "whole number"]),
        ({"maxfev": 2**63}, ["maxfev is", "[1, 2**62)"]),
        ({"maxtime": 0}, ["maxtime is 0", "greater than 0 s"]),
        ({"maxtime": math.nan}, ["maxtime is nan", "greater than 0 s"]),
        ({"stopval": math.nan}, ["stopval is nan"]),
        ({"checkpoint": ""}, ["checkpoint", "name of a file"]),
        ({"rng": -1}, ["rng is -1", "[0, 2**53]"]),
        ({"rng": 2**53 + 1}, ["rng is", "[0, 2**53]"]),
        ({"rng": 1.5}, ["rng is 1.5", "whole number"]),
        ({"rng": math.inf}, ["rng is inf", "whole number"]),
        ({"rng": True}, ["rng is True", "whole number"]),
        ({"rng": "seed"}, ["rng is seed", "whole number"]),
        ({"workers": 0}, ["workers is 0", "[1, 1024]"]),
        ({"workers": 1.5}, ["workers is 1.5", "whole number"]),
        ({"workers": True}, ["workers is True", "whole number"]),
    ],
)
def test_bad_arguments_are_refused(arguments, parts):
    func = Counted()
    with refused(*parts):
        search(func, **arguments)
    assert func.calls == 0


@pytest.mark.parametrize(
    ("method", "options", "parts"),
    [
        ("bfoa", {"cells": 11}, ["cells is 11", "even"]),
        ("bfoa", {"cells": 0}, ["cells is 0", "[2, 10000]"]),
        ("bfoa", {"cells": 2.5}, ["cells is 2.5", "whole number"]),
        ("bfoa", {"step": -0.1}, ["step is -0.1", "[0, 2]"]),
        ("bfoa", {"step": math.nan}, ["step is nan"]),
        ("bfoa", {"swims": -1}, ["swims is -1", "[0, 1000]"]),
        ("bfoa", {"chemotactic_steps": 0}, ["chemotactic_steps is 0"]),
        ("bfoa", {"reproductions": 0}, ["reproductions is 0"]),
        ("bfoa", {"dispersals": 0}, ["dispersals is 0"]),
        ("bfoa", {"dispersal_probability": 1.01}, ["dispersal_probability is 1.01", "[0, 1]"]),
        ("bfoa", {"dispersal_probability": -0.01}, ["dispersal_probability is -0.01", "[0, 1]"]),
        ("bfoa", {"attractant_width": -1}, ["attractant_width is -1"]),
        ("bfoa", {"attractant_depth": -1}, ["attractant_depth is -1"]),
        ("bfoa", {"repellent_width": -1}, ["repellent_width is -1"]),
        ("bfoa", {"repellent_height": -1}, ["repellent_height is -1"]),
        ("bfoa", {"finishers": 4}, ["finishers", "known: cells, "]),
        ("bfoa", {"step": "long"}, ["step", "long", "number"]),
        ("bfoa+", {"cells": 3}, ["cells is 3", "[4, 10000]"]),
        ("bfoa+", {"blind_cells": 3}, ["blind_cells is 3", "[4, 10000]"]),
        ("bfoa+", {"colonies": 0}, ["colonies is 0", "[1, 1000]"]),
        ("bfoa+", {"first_points": 3}, ["first_points is 3"]),
        ("bfoa+", {"differential_share": 1.5}, ["differential_share is 1.5", "[0, 1]"]),
        ("bfoa+", {"step": 0}, ["step is 0"]),
        ("bfoa+", {"foraging_share": -1}, ["foraging_share is -1", "[0, 1]"]),
        ("bfoa+", {"blind_foraging_share": 2}, ["blind_foraging_share is 2", "[0, 1]"]),
        ("bfoa+", {"finishers": 0}, ["finishers is 0"]),
        ("bfoa+", {"swims": 4}, ["swims", "known: cells, "]),
        ("cma", {"population": 1}, ["population is 1", "0 or at least 2"]),
        ("cma", {"population": -1}, ["population is -1", "[0, 1e+06]"]),
        ("cma", {"step": 0}, ["step is 0", "[1e-09, 10]"]),
        ("cma", {"start_step": 11}, ["start_step is 11"]),
        ("cma", {"growth": 0.5}, ["growth is 0.5", "[1, 100]"]),
        ("cma", {"tolerance": 2}, ["tolerance is 2", "[0, 1]"]),
        ("cma", {"cells": 4}, ["cells", "known: population, "]),
    ],
)
def test_bad_options_are_refused(method, options, parts):
    func = Counted()
    with refused("options", *parts):
        search(func, method=method, options=options)
    assert func.calls == 0


def test_options_may_be_numpy_s_numbers():
    numbers = {"cells": np.int64(8), "step": np.float64(0.2)}
    one = search(method="bfoa", options=numbers)
    same(one, search(method="bfoa", options={"cells": 8, "step": 0.2}))


# Another value for every option, and what else must be set for it to matter.
KNOBS = {
    "bfoa": {
        "cells": (12, {}),
        "chemotactic_steps": (5, {}),
        "swims": (2, {}),
        "reproductions": (1, {}),
        "dispersals": (1, {}),
        "dispersal_probability": (0.5, {}),
        "step": (0.07, {}),
        "attractant_depth": (5, {"attractant_width": 5}),
        "attractant_width": (5, {}),
        "repellent_height": (0.4, {}),
        "repellent_width": (2, {}),
    },
    "bfoa+": {
        "blind_cells": (30, {}),
        "first_points": (30, {}),
        "blind_differential_share": (0.2, {}),
        "step": (0.3, {}),
        "blind_foraging_share": (0.5, {}),
        "scan_points": (0, {}),
    },
    "cma": {
        "population": (12, {}),
        "step": (0.2, {}),
        "growth": (1.5, {"tolerance": 1e-3}),
        "tolerance": (1e-3, {}),
    },
}


@pytest.mark.parametrize(("method", "name"), [(m, name) for m in METHODS for name in KNOBS[m]])
def test_every_option_changes_the_history(method, name):
    value, context = KNOBS[method][name]
    settings = {"method": method, "maxfev": 2000}
    if method == "bfoa":
        context = SHORT | context

    def ripples(x):
        return bowl(x) + float(np.cos(8 * x).sum())

    one = search(ripples, options=context, **settings)
    other = search(ripples, options=context | {name: value}, **settings)
    assert one.history.tolist() != other.history.tolist()


WITH_GRADIENTS = {
    "foraging_share": 0.8,
    "cells": 30,
    "evaluations_per_cell": 400,
    "colonies": 2,
    "differential_share": 0.2,
    "finishers": 1,
    "restart_points": 0,
    "patience": 0,
}


def test_every_option_is_covered_here():
    assert set(_core.default_options("bfoa")) == set(KNOBS["bfoa"])
    assert set(_core.default_options("cma")) == set(KNOBS["cma"]) | {"start_step"}
    assert set(_core.default_options("bfoa+")) == set(KNOBS["bfoa+"]) | set(WITH_GRADIENTS)


@pytest.mark.parametrize("name", WITH_GRADIENTS)
def test_some_options_are_for_costs_with_gradients(name):
    options = {name: WITH_GRADIENTS[name]}
    one, other = (nominal.tune(rng=1, options=o).history for o in ({}, options))
    assert one.tolist() != other.tolist()
    same(search(), search(options=options))


@pytest.mark.parametrize("method", METHODS)
def test_defaults_are_the_defaults(method):
    same(search(method=method), search(method=method, options=_core.default_options(method)))


@pytest.mark.parametrize("shift_seed", [99, 5])
def test_every_seed_finds_the_deepest_of_many_pits(shift_seed):
    """Rastrigin's function, 11 dimensions, off the centre: a pit at each whole number."""
    shift = np.random.default_rng(shift_seed).uniform(-0.3, 0.3, 11) * 5.12

    def rastrigin(points):  # (p, n), as SciPy has them
        z = points - shift[:, None]
        return (z**2 - 10 * np.cos(2 * np.pi * z) + 10).sum(0)

    box = np.tile([-5.12, 5.12], (11, 1))
    for seed in range(1, 26):
        found = nfopidn.bfoa(rastrigin, box, rng=seed, maxfev=10_000, vectorized=True)
        assert found.fun < 1e-9, seed
        np.testing.assert_allclose(found.x, shift, atol=1e-6)


# Costs


@pytest.mark.parametrize("method", METHODS)
def test_infinity_is_a_cost(method):
    result = search(half_infinite, method=method, maxfev=2000)
    assert result.status == 1
    assert result.fun == bowl(result.x) < 0.1
    assert result.x[0] >= 0.6


@pytest.mark.parametrize("method", METHODS)
def test_all_costs_may_be_infinite(method):
    result = search(lambda x: math.inf, method=method)
    assert (result.success, result.status) == (False, 7)
    assert result.message == (
        "No point that was tried has a finite cost. The budget of evaluations is used up."
    )
    assert result.fun == math.inf
    assert result.x.shape == (3,)


@pytest.mark.parametrize("method", METHODS)
def test_minus_infinity_ends_nothing_but_is_the_least(method):
    result = search(Counted(50, lambda: -math.inf), method=method)
    assert result.fun == -math.inf


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("at", [1, 2, 250])
def test_nan_is_refused_with_the_best_so_far(method, at):
    func = Counted(at, lambda: math.nan)
    with pytest.raises(ValueError, match="func returned NaN") as caught:
        search(func, method=method)
    best = caught.value.best
    assert not best.success
    assert best.nfev == at
    if at > 1:
        assert best.fun == min(func.costs[: at - 1]) == bowl(best.x)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("error", [ZeroDivisionError("no"), SystemExit(3), StopIteration()])
def test_what_func_raises_reaches_the_caller(method, error):
    func = Counted(250, throw(error))
    with pytest.raises(type(error)) as caught:
        search(func, method=method)
    assert caught.value is error
    assert func.calls == 250
    best = caught.value.best
    assert math.isfinite(best.fun)
    assert best.fun == bowl(best.x)
    assert best.nfev <= 250
    assert not best.success
    assert len(best.history) == best.nit > 0


@pytest.mark.parametrize("vectorized", [False, True])
def test_what_func_raises_tells_where(vectorized):
    def culprit(x):
        return x / 0

    def func(x):
        return culprit(1)

    with pytest.raises(ZeroDivisionError) as caught:
        nfopidn.bfoa(func, [(0, 1)] * 2, vectorized=vectorized)
    assert [line.name for line in traceback.extract_tb(caught.value.__traceback__)][-2:] == [
        "func",
        "culprit",
    ]


def test_what_func_raises_at_once_reaches_the_caller():
    with pytest.raises(ZeroDivisionError) as caught:
        search(Counted(1, throw(ZeroDivisionError())))
    best = caught.value.best
    assert (best.nit, best.nfev, best.fun) == (0, 0, math.inf)
    assert best.message == "ZeroDivisionError was raised; nothing was answered before."


@pytest.mark.parametrize("method", METHODS)
def test_ctrl_c_in_func_gives_the_best_so_far(method):
    func = Counted(250, throw(KeyboardInterrupt()))
    result = search(func, method=method)
    assert func.calls == 250
    assert (result.success, result.status) == (False, 5)
    assert result.message == "The search was interrupted; this is the best so far."
    assert math.isfinite(result.fun)
    assert result.fun == bowl(result.x)


def test_a_signal_gives_the_best_so_far():
    """Ctrl-C while the core is at work, not Python."""
    func = Counted(250, lambda: signal.raise_signal(signal.SIGINT))
    result = search(func)
    assert result.message == "The search was interrupted; this is the best so far."
    assert func.calls < 400
    assert result.fun == bowl(result.x)


@pytest.mark.parametrize(
    ("reply", "message"),
    [
        (lambda n: np.zeros(n + 1), r"as many points, shape \(\d+,\)"),
        (lambda n: np.zeros(n - 1), r"as many points, shape \(\d+,\)"),
        (lambda n: np.zeros((n, 1)), r"as many points, shape \(\d+,\)"),
        (lambda n: 0.0, r"as many points, shape \(\d+,\)"),
        (lambda n: None, "func must return"),
        (lambda n: ["a"] * n, "."),
    ],
)
@pytest.mark.parametrize("at", [1, 4])
def test_costs_of_the_wrong_shape_are_refused(reply, message, at):
    calls = []

    def block(columns):
        calls.append(columns.shape[1])
        return reply(columns.shape[1]) if len(calls) == at else bowls(columns.T)

    with pytest.raises((ValueError, TypeError), match=message) as caught:
        search(block, vectorized=True)
    assert len(calls) == at
    assert math.isfinite(caught.value.best.fun) == (at > 1)


def test_a_point_s_cost_must_be_one_number():
    with pytest.raises((TypeError, ValueError)):
        search(lambda x: x)


# Ends


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("maxfev", [1, 2, 9, 10, 11, 299, 300, 301, 987])
@pytest.mark.parametrize("vectorized", [False, True])
def test_evaluations_are_exactly_as_many_as_allowed(method, maxfev, vectorized):
    calls = []

    def block(columns):
        calls.append(columns.shape[1])
        return bowls(columns.T)

    def one(x):
        calls.append(1)
        return bowl(x)

    func = block if vectorized else one
    result = search(func, method=method, maxfev=maxfev, vectorized=vectorized)
    assert sum(calls) == result.nfev == maxfev
    assert result.message == "The budget of evaluations is used up."
    assert result.x.shape == (3,)


@pytest.mark.parametrize("method", METHODS)
def test_a_wanted_cost_ends_the_search(method):
    func = Counted()
    result = search(func, method=method, stopval=0.5, maxfev=5000)
    assert result.message == "The wanted cost is reached."
    assert result.success
    assert result.fun <= 0.5
    assert result.nfev <= func.calls < 5000
    assert next(n for n, cost in enumerate(func.costs, 1) if cost <= 0.5) == result.nfev


def test_the_wanted_cost_itself_is_enough():
    assert search(lambda x: 7.0, stopval=7).message == "The wanted cost is reached."
    assert search(lambda x: 7.0, stopval=6.999).nfev == 400


@pytest.mark.parametrize("method", METHODS)
def test_the_time_ends_the_search(method):
    result = search(method=method, maxtime=1e-9)
    assert result.message == "The time is up."
    assert not result.success
    assert result.nfev < 400
    assert result.x.shape == (3,)


@pytest.mark.parametrize("method", METHODS)
def test_a_callback_sees_every_step(method):
    seen = []
    result = search(method=method, callback=watcher(seen))
    whole = result.history[:-1]  # the budget cuts the last step short
    assert [step.nfev for step in seen] == whole["nfev"].tolist()
    assert [step.fun for step in seen] == whole["best"].tolist()
    assert [step["mean"] for step in seen] == whole["mean"].tolist()
    assert [step.step for step in seen] == whole["step"].tolist()
    assert [bowl(step.x) for step in seen] == [step.fun for step in seen]
    assert repr(seen[0]).startswith("OptimizeResult(fun=")
    same(result, search(method=method))


def test_a_callback_sees_the_last_step_of_a_schedule():
    seen = []
    result = bfoa(bowl, BOX, rng=1, method="bfoa", options=SHORT, callback=watcher(seen))
    assert [step.nfev for step in seen] == result.history["nfev"].tolist()


class At:
    """A callback that raises at its third call."""

    def __init__(self, error):
        self.error, self.calls = error, 0

    def __call__(self, result):
        self.calls += 1
        if self.calls == 3:
            raise self.error


@pytest.mark.parametrize("method", METHODS)
def test_a_callback_ends_the_search(method):
    callback = At(StopIteration())
    result = search(method=method, callback=callback)
    assert callback.calls == result.nit == 3
    assert result.message == "The callback asked to stop."
    assert (result.success, result.status) == (False, 4)
    same_start = search(method=method).history[:3]
    assert_array_equal(result.history, same_start)


def test_what_a_callback_raises_reaches_the_caller():
    callback = At(ZeroDivisionError("no"))
    with pytest.raises(ZeroDivisionError) as caught:
        search(callback=callback)
    assert caught.value is callback.error
    assert callback.calls == caught.value.best.nit == 3
    assert math.isfinite(caught.value.best.fun)


def test_ctrl_c_in_a_callback_gives_the_best_so_far():
    result = search(callback=At(KeyboardInterrupt()))
    assert result.message == "The search was interrupted; this is the best so far."
    assert (result.success, result.nit) == (False, 3)


# One course for one seed


@pytest.mark.parametrize("method", METHODS)
def test_a_block_gives_the_same_as_its_points(method):
    one = search(method=method)
    same(one, search(lambda x: bowls(x.T), method=method, vectorized=True))
    same(one, search(lambda x: bowls(x.T).tolist(), method=method, vectorized=True))


@pytest.mark.parametrize("method", METHODS)
def test_workers_change_nothing(method):
    one = search(method=method)
    same(one, search(method=method, workers=2))
    same(one, search(method=method, workers=map))
    same(one, search(method=method, workers=lambda func, points: [func(x) for x in points]))


class Unpicklable:
    """A cost with a part that no other process can be sent."""

    def __init__(self):
        self.lock = threading.Lock()

    def __call__(self, x):
        return bowl(x)


@pytest.mark.parametrize(
    ("func", "parts"),
    [
        (lambda x: float(x[0]), ["<lambda>", "2 workers"]),
        (Unpicklable(), ["Unpicklable", "cannot pickle '_thread.lock' object"]),
        (functools.partial(bowl, Unpicklable().lock), ["partial", "'_thread.lock'"]),
    ],
    ids=["lambda", "object", "partial"],
)
def test_what_cannot_be_pickled_is_named_before_there_are_processes(func, parts, monkeypatch):
    """Within a pool it was noticed late, and every third such search never ended."""
    monkeypatch.setattr(_workers, "ProcessPoolExecutor", None)  # would fail
    with refused("func is", "must be such that it can be pickled", "workers=1", *parts):
        search(func, workers=2)


def test_workers_are_other_processes():
    result = search(in_the_main_process, workers=2, maxfev=40)
    assert result.fun == 0


def in_the_main_process(x):
    return float(multiprocessing.parent_process() is None)


def test_what_a_worker_raises_reaches_the_caller():
    with pytest.raises(ZeroDivisionError):
        search(divide_by_zero, workers=2)


def divide_by_zero(x):
    return 1 / 0


@pytest.mark.parametrize("method", METHODS)
def test_the_seed_decides_the_course(method):
    same(search(method=method, rng=2), search(method=method, rng=2))
    same(search(method=method, rng=2), search(method=method, rng=np.int64(2)))
    same(search(method=method, rng=2), search(method=method, rng=2.0))
    assert search(method=method, rng=2).history.tolist() != search(method=method).history.tolist()


def test_a_drawn_seed_is_recorded():
    one, other = search(rng=None), search(rng=None)
    assert one.seed != other.seed
    same(one, search(rng=one.seed))


def test_a_generator_gives_the_seed():
    one = search(rng=np.random.default_rng(4))
    same(one, search(rng=np.random.default_rng(4)))
    same(one, search(rng=one.seed))
    generator = np.random.default_rng(4)
    assert search(rng=generator).seed == one.seed
    assert search(rng=generator).seed != one.seed


def test_a_search_within_a_search():
    inner = []

    def func(x):
        inner.append(search(maxfev=20).fun)
        return bowl(x)

    same(search(func, maxfev=50), search(maxfev=50))
    assert set(inner) == {search(maxfev=20).fun}


# Ask and tell


def forage(forager):
    while (points := forager.ask()) is not None:
        forager.tell(bowls(points))
    return forager.result


@pytest.mark.parametrize("method", METHODS)
def test_a_forager_gives_the_same_result(method):
    seen = []
    arguments = {"method": method, "rng": 1, "maxfev": 500, "stopval": 1e-9}
    forager = Forager(BOX, callback=watcher(seen), **arguments)
    assert forager.result is None
    result = forage(forager)
    same(result, bfoa(bowl, BOX, **arguments))
    assert len(seen) == result.nit - 1
    assert forager.ask() is None
    with refused("tell() comes after ask()"):
        forager.tell([1.0])
    forager.close()
    assert forager.result is result


def test_a_wrong_tell_is_refused_and_the_points_stay():
    forager = Forager(BOX, rng=1, maxfev=400)
    with refused("tell() comes after ask()"):
        forager.tell([1.0])
    points = forager.ask()
    assert forager.ask() is points
    good = bowls(points)
    for costs, words in (
        (good[1:], "shape"),
        ([*good, 1.0], "shape"),
        (good[:, None], "shape"),
        (7.0, "shape"),
        ([math.nan, *good[1:]], "NaN"),
    ):
        with refused(words):
            forager.tell(costs)
        assert forager.ask() is points
    forager.tell(good)
    same(forage(forager), search())


def test_a_forager_may_be_told_infinity():
    forager = Forager(BOX, rng=1, maxfev=60)
    while (points := forager.ask()) is not None:
        forager.tell([half_infinite(x) for x in points])
    same(forager.result, search(half_infinite, maxfev=60))


@pytest.mark.parametrize("asked", [0, 1, 4])
def test_a_forager_may_be_closed_early(asked):
    forager = Forager(BOX, rng=1, maxfev=400)
    told = 0
    for _ in range(asked):
        points = forager.ask()
        told += len(points)
        forager.tell(bowls(points))
    forager.close()
    forager.close()
    assert forager.ask() is None
    assert forager.result.nfev == told
    assert not forager.result.success
    assert forager.result.status == list(MESSAGES).index("callback")
    if asked:
        assert forager.result.fun == bowl(forager.result.x)
    with refused("tell() comes after ask()"):
        forager.tell([1.0])


def test_what_a_foragers_callback_raises_comes_from_ask_once():
    forager = Forager(BOX, rng=1, maxfev=400, callback=lambda _: 1 / 0)

    def go_on():
        while True:
            forager.tell(bowls(forager.ask()))

    with pytest.raises(ZeroDivisionError):
        go_on()
    assert forager.ask() is None
    assert forager.result.fun == bowl(forager.result.x)


def test_costs_of_another_type_are_refused():
    forager = Forager([(0, 1)], rng=1, maxfev=40)
    points = forager.ask()
    for costs in ([object()] * len(points), 10**400, "abc", ["1"] * len(points), [1j], None):
        with refused("costs must be real numbers"):
            forager.tell(costs)
    assert forager.ask() is points
    forager.close()


def test_a_search_has_the_seed_of_its_own_checkpoint(tmp_path):
    """Not that of another one, whose name is longer by what the stages of tune() append."""
    for seed, suffix in ((5, ""), (9, ".speed"), (7, ".gains")):
        bfoa(bowl, BOX, rng=seed, maxfev=300, checkpoint=str(tmp_path / f"run{suffix}"))
    assert bfoa(bowl, BOX, maxfev=300, checkpoint=str(tmp_path / "run")).seed == 5
    (tmp_path / "run").unlink()
    seeds = {bfoa(bowl, BOX, maxfev=30, checkpoint=str(tmp_path / f"run{i}")).seed for i in "ab"}
    assert not seeds & {5, 7, 9}
    assert bfoa(bowl, BOX, maxfev=30, checkpoint=str(tmp_path / "run")).seed not in (5, 7, 9)


def test_a_forager_may_be_closed_with_points_asked():
    forager = Forager(BOX, rng=1, maxfev=400)
    told = len(forager.ask())
    forager.tell(bowls(forager.ask()))
    forager.ask()
    forager.close()
    assert forager.result.fun == bowl(forager.result.x)
    assert forager.result.nfev == told
    assert (forager.result.history["nfev"] <= told).all()


def test_a_forager_has_the_arguments_of_bfoa():
    for name in ("func", "args", "vectorized", "workers"):
        with refused(f"no argument '{name}'", exception=TypeError):
            Forager(BOX, **{name: 1})
    with contextlib.closing(Forager(BOX, rng=1, method="bfoa", options={"cells": 6})) as forager:
        assert forager.ask().shape == (6, 3)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"method": "pso"}, "method is 'pso'"),
        ({"maxfev": 0}, "maxfev is 0"),
        ({"options": {"cells": 1}}, "cells is 1"),
    ],
)
def test_a_forager_refuses_what_bfoa_refuses(arguments, words):
    with pytest.raises(ValueError, match=words):
        Forager(BOX, **arguments).ask()


@pytest.mark.parametrize("workers", [1, map])
def test_what_func_answered_before_it_raised_is_not_lost(workers):
    calls = []

    def func(x):
        calls.append(x)
        if len(calls) == 250:
            raise RuntimeError("enough")
        return float(((x - 0.3) ** 2).sum())

    with pytest.raises(RuntimeError, match="enough") as caught:
        nfopidn.bfoa(func, [(0, 1)] * 3, rng=1, workers=workers)
    best = caught.value.best
    assert best.nfev == 249
    assert best.fun == min(((x - 0.3) ** 2).sum() for x in calls[:249])


def test_time_is_looked_at_between_slow_evaluations():
    def func(x):
        until = time.perf_counter() + 0.01
        while time.perf_counter() < until:
            pass
        return float((x**2).sum())

    result = nfopidn.bfoa(func, [(-1, 1)] * 3, rng=1, maxtime=0.1)
    assert result.message == "The time is up."
    assert 1 <= result.nfev <= 11


def test_what_a_signal_s_handler_raises_reaches_the_caller():
    def handler(*_):
        raise TimeoutError("too long")

    before = signal.signal(signal.SIGALRM, handler)
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    try:
        with pytest.raises(TimeoutError, match="too long") as caught:
            nominal.tune(rng=1, maxfev=10**7)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert caught.value.best.nfev > 0


def test_an_unfinished_forager_does_not_bring_the_interpreter_down():
    program = """
import nfopidn
for tells in range(3):
    forager = nfopidn.Forager([(0, 1)] * 50, rng=1)
    for _ in range(tells):
        forager.tell(((forager.ask() - 0.3) ** 2).sum(1))
raise SystemExit(7)
"""
    run = subprocess.run(
        [sys.executable, "-c", program], check=False, capture_output=True, timeout=60
    )
    assert (run.returncode, run.stderr) == (7, b"")


def test_a_forager_closes_at_the_end_of_with():
    with Forager(BOX, rng=1, maxfev=400) as forager:
        forager.tell(bowls(forager.ask()))
        thread = forager._course.thread
        assert thread.is_alive()
    assert not thread.is_alive()
    assert forager.ask() is None
    assert "closed" in forager.result.message
    with pytest.raises(ZeroDivisionError), Forager(BOX, rng=1) as forager:
        raise ZeroDivisionError
    assert not forager._course.thread.is_alive()


@pytest.mark.parametrize("asked", [0, 1, 2])
def test_a_forager_that_nobody_has_ends_its_thread(asked):
    forager = Forager(BOX, rng=1, maxfev=10**6, callback=lambda _: None)
    for _ in range(asked):
        forager.tell(bowls(forager.ask()))
    thread = forager._course.thread
    del forager
    gc.collect()
    thread.join()  # for ever if it was kept
    assert not thread.is_alive()


def test_a_forager_refuses_at_once():
    with refused("maxfev is 0"):
        Forager(BOX, maxfev=0)
    with refused("callback is 5"):
        Forager(BOX, callback=5)
    with pytest.raises(TypeError, match="maxfevs"):
        Forager(BOX, maxfevs=10)


def test_a_closed_forager_says_so():
    forager = Forager(BOX, rng=1, maxfev=600)
    forager.tell([bowl(x) for x in forager.ask()])
    forager.close()
    assert forager.result.message == "The search was closed; this is the best so far."
    assert forager.result.fun < np.inf


def test_a_field_of_a_result_can_be_set_as_an_attribute():
    result = OptimizeResult(fun=1.0, nfev=2)
    result.fun = 3.0
    assert result["fun"] == 3.0
    assert repr(OptimizeResult()) == "OptimizeResult({})"


def test_a_forager_may_be_closed_by_its_callback():
    forager = Forager([(0, 1)] * 2, rng=1, callback=lambda _: forager.close())
    while (points := forager.ask()) is not None:
        forager.tell(((points - 0.3) ** 2).sum(axis=1))
    assert "closed" in forager.result.message
    assert forager.result.fun < 0.01
    errors = []

    def ask(_):
        try:
            asking.ask()
        except ValueError as error:
            errors.append(str(error))

    asking = Forager([(0, 1)] * 2, rng=1, maxfev=400, callback=ask)
    while (points := asking.ask()) is not None:
        asking.tell(((points - 0.3) ** 2).sum(axis=1))
    assert errors
    assert "not for a callback" in errors[0]


@pytest.mark.parametrize(
    "words",
    [
        {"rng": -1},
        {"options": {"foo": 1}},
        {"options": {"\udcff": 1}},
        {"checkpoint": "\udcff"},
        {"method": "bfoa", "options": {"cells": 7}},
        {"checkpoint": "/none/x"},
        {"checkpoint": "/"},
    ],
)
def test_a_forager_refuses_what_the_core_would(words):
    with pytest.raises(ValueError, match=next(iter(set(words) - {"method"}))):
        Forager([(0, 1)], **words)


def test_a_forked_process_ends_without_the_search():
    forager = Forager([(0, 1)] * 2, rng=1, maxfev=400)
    forager.tell(((forager.ask() - 0.3) ** 2).sum(axis=1))
    child = os.fork()
    if child == 0:
        forager.close()
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
    forager.close()


def test_workers_are_looked_at_beside_vectorized():
    with refused("workers is -3"):
        bfoa(lambda points: points.sum(1), [(0, 1)], vectorized=True, workers=-3)
