"""tune(): what it finds, what may be fixed, and that nothing but its arguments decides it."""

import copy
import json
import math
import os
import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from types import MappingProxyType

import numpy as np
import pytest
from matplotlib.axes import Axes
from nfopidn import (
    Controller,
    Objective,
    Robot,
    Scenario,
    Trajectory,
    TuneResult,
    default_bounds,
    plot,
    simulate,
)
from nfopidn.search import optimise as _search
from nfopidn.search.optimise import MESSAGES
from nominal import tune
from numpy.testing import assert_array_equal
from refusal import refused
from results import same, watcher

STRUCTURES = {  # and the most that they cost after 2000 evaluations; published: 0.0921
    "paper": 0.05,
    "decoupled": 0.019,
    "incremental": 0.02,
    "extended": 0.0165,
    "taps": 0.016,
}
GAINS = [f"{term}_{channel}" for channel in ("x", "y", "theta") for term in ("kp", "ki", "kd")]
TAPS = np.arange(21.0).reshape(3, 7) / 100 - 0.05


def short(scenario=None, **arguments):
    return tune(scenario, **({"rng": 1, "maxfev": 400} | arguments))


def scenarios():
    return [
        Scenario.published(rng=0),
        Scenario.published(rng=0, robot=Robot(mass=15)),
        Scenario.published(rng=3, pose_noise=(0.01, 0.01)),
        Scenario.published(rng=0, delay=1),
    ]


# What is found


@pytest.mark.parametrize("structure", STRUCTURES)
def test_a_structure_is_tuned(structure, golden_costs):
    result = tune(structure=structure, rng=2, maxfev=2000)
    assert result.fun < STRUCTURES[structure]
    run = simulate(result.scenario, result.controller)
    assert run.diverged_at is None
    assert run.cost == pytest.approx(result.fun, rel=1e-9)
    assert result.nfev == 2000
    assert result.success
    assert result.structure == structure
    assert result.parameters == list(default_bounds(structure))
    assert result.x.shape == (len(result.parameters),)
    assert (result.method, result.options) == ("bfoa+", {})
    assert result.scenario == Scenario.published(rng=0)
    low, high = np.array(list(default_bounds(structure).values())).T
    assert (low <= result.x).all()
    assert (result.x <= high).all()
    if structure == "taps":
        assert_array_equal(result.controller.taps.ravel(), result.x)
    else:
        assert_array_equal(result.controller.to_vector(), result.x)


@pytest.mark.parametrize(
    ("structure", "settings"),
    [
        ("paper", {}),
        ("decoupled", {"allocation": "decoupled"}),
        ("incremental", {"allocation": "decoupled", "form": "incremental"}),
        ("extended", {"allocation": "decoupled", "lateral": "speed"}),
    ],
)
def test_what_a_structure_stands_for(structure, settings):
    parameters = "orders-by-channel" if structure == "extended" else "shared-orders"
    published = Controller.published(**settings)
    result = short(structure=structure, maxfev=60)
    assert result.controller.allocation == published.allocation
    assert result.controller.form == published.form
    assert result.controller.lateral == published.lateral
    whole = short(structure={**settings, "parameters": parameters}, maxfev=60)
    assert_array_equal(result.x, whole.x)
    assert result.controller == whole.controller


@pytest.mark.parametrize(
    ("heading", "lateral"), [("forward", "direction"), ("continuous", "speed")]
)
def test_free_taps_are_tried_with_the_lateral_error_fed_either_way(heading, lateral):
    scenario = Scenario.published(heading=heading, rng=0)
    result = tune(scenario, structure="taps", rng=2)
    assert (result.controller.lateral, result.structure) == (lateral, "taps")
    assert simulate(scenario, result.controller).cost == pytest.approx(result.fun, rel=1e-9)
    assert result.nfev == result.history["nfev"][-1] == 10000
    assert (np.diff(result.history["nfev"]) >= 0).all()
    assert (np.diff(result.history["best"]) <= 0).all()
    assert result.history["best"][-1] == result.fun
    start = Controller.published(allocation="decoupled", lateral="speed")
    either = tune(scenario, structure="taps", rng=1, maxfev=1000, start=start)
    settings = {"allocation": "decoupled", "parameters": "taps"}
    alone = [
        tune(scenario, structure={**settings, "lateral": one}, rng=1, maxfev=500, start=start)
        for one in ("speed", "direction")
    ]
    best = min(alone, key=lambda result: result.fun)
    assert (either.nfev, either.fun, either.controller) == (1000, best.fun, best.controller)


def test_what_a_callback_raises_in_a_later_stage_has_the_best_of_all():
    def fail(intermediate_result):
        if seen and intermediate_result.fun > seen[-1][1]:  # of the next stage alone
            raise RuntimeError("enough")
        seen.append((intermediate_result.nfev, intermediate_result.fun))

    seen = []
    start = tune(structure="extended", rng=1, maxfev=2000).controller
    with pytest.raises(RuntimeError, match="enough") as caught:
        tune(structure="taps", start=start, rng=1, maxfev=400, callback=fail)
    assert caught.value.best.fun <= min(fun for _, fun in seen)
    assert caught.value.best.controller.lateral == "speed"
    assert caught.value.best.nfev > seen[-1][0]


def test_no_structure_is_the_paper_s():
    same(short(), short(structure="paper"))
    same(short(), short(Scenario.published(rng=0)))
    same(short(), short([Scenario.published(rng=0)]))
    assert default_bounds() == default_bounds("paper") == default_bounds({})


def test_settings_as_a_structure():
    settings = {"memory": 2, "generator": "gl", "activation": "linear"}
    result = short(structure=settings)
    assert result.controller.replace(gains=[[0] * 3] * 3, alpha=0, sigma=0) == Controller(
        [[0] * 3] * 3, 0, 0, **settings, sample_time=0.2
    )
    assert settings == {"memory": 2, "generator": "gl", "activation": "linear"}
    assert len(default_bounds({"memory": 2, "parameters": "taps"})) == 3 * 4


def test_default_bounds():
    orders = ["alpha", "sigma"]
    shared = default_bounds("paper")
    assert list(shared) == GAINS + orders
    assert set(list(shared.values())[:9]) == {(0, 3)}
    assert {shared[name] for name in orders} == {(0.01, 1)}
    assert default_bounds("decoupled") == shared
    incremental = default_bounds("incremental")
    assert {name for name in shared if shared[name] != incremental[name]} == {
        "ki_x",
        "ki_y",
        "ki_theta",
    }
    assert incremental["ki_x"] == incremental["ki_y"] == incremental["ki_theta"] == (0, 0.3)
    extended = default_bounds("extended")
    assert list(extended) == GAINS + [f"{o}_{c}" for c in ("x", "y", "theta") for o in orders]
    assert set(list(extended.values())[:9]) == {(0, 6)}
    assert set(list(extended.values())[9:]) == {(0.01, 2)}
    taps = default_bounds("taps")
    assert list(taps) == [f"tap_{c}_{j}" for c in ("x", "y", "theta") for j in range(7)]
    assert set(taps.values()) == {(-60, 60)}


@pytest.mark.parametrize("method", ["bfoa+", "bfoa"])
def test_passino_s_method_tunes_too(method):
    options = {"cells": 8}
    result = short(method=method, options=options, maxfev=1500)
    assert result.fun < 0.09
    assert simulate(result.scenario, result.controller).cost == pytest.approx(result.fun, rel=1e-9)
    assert (result.method, result.options, result.population.shape) == (method, options, (8, 11))


def test_cma_tunes_too():
    result = short(method="cma", options={"population": 10}, maxfev=2000)
    assert result.fun < 0.09
    assert simulate(result.scenario, result.controller).cost == pytest.approx(result.fun, rel=1e-9)
    assert (result.method, result.options) == ("cma", {"population": 10})
    assert result.population.shape == (10, 11)
    assert result.nit == 200
    known = Controller.tuned_nominal()
    best = simulate(result.scenario, known).cost
    found = tune(structure="incremental", start=known, method="cma", rng=1, maxfev=12)
    assert found.fun <= best * (1 + 1e-9)


def test_one_schedule_of_passino_s_method():
    result = tune(method="bfoa", rng=1)
    assert result.message == "The schedule is complete."
    assert result.nit == 3 * 4 * 14
    assert 10 * 3 * 4 * 14 < result.nfev < 6 * 10 * 3 * 4 * 14 + 40


def test_the_tuned_controller_of_the_published_scenario(scenario):
    run = simulate(scenario, Controller.tuned_nominal())
    assert 0.0172 < run.cost < 0.01723
    assert Controller.tuned_nominal().form == "incremental"


# What decides it


@pytest.mark.parametrize("structure", STRUCTURES)
def test_workers_change_nothing(structure):
    one = short(structure=structure, workers=1)
    for workers in (2, 3):
        same(one, short(structure=structure, workers=workers))


def test_workers_change_nothing_over_several_scenarios():
    same(short(scenarios(), worst_share=0.5), short(scenarios(), worst_share=0.5, workers=2))


def test_one_objective_serves_threads_and_forked_processes():
    objective = Objective(workers=2)
    points = objective.bounds[:, 0] + np.linspace(0, 0.3, 40)[:, None]
    wanted = Objective().costs(points)
    assert_array_equal(objective.costs(points), wanted)
    with ThreadPoolExecutor(4) as pool:
        # Each thread asks for other points, and another number of them.
        parts = [points[first : first + 1 + 3 * first] for first in range(10)] * 4
        for part, costs in zip(parts, pool.map(objective.costs, parts), strict=True):
            assert_array_equal(costs, wanted[[points.tolist().index(x) for x in part.tolist()]])
        alone = [Objective().gradient(x) for x in points[:10]]
        for (cost, slopes), (own, own_slopes) in zip(
            alone * 4, pool.map(objective.gradient, list(points[:10]) * 4), strict=True
        ):
            assert own == cost
            assert_array_equal(own_slopes, slopes)
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        os.write(write, objective.costs(points).tobytes())
        os._exit(0)
    os.close(write)
    with os.fdopen(read, "rb") as pipe:
        assert_array_equal(np.frombuffer(pipe.read()), wanted)
    assert os.waitpid(child, 0)[1] == 0
    assert_array_equal(objective.costs(points), wanted)


def test_the_seed_decides_the_course():
    same(short(rng=7), short(rng=7))
    assert short(rng=7).history.tolist() != short(rng=8).history.tolist()
    drawn = short(rng=None)
    same(drawn, short(rng=drawn.seed))


@pytest.mark.parametrize("maxfev", [1, 3, 5, 299, 1001])
@pytest.mark.parametrize("structure", ["paper", "taps"])
def test_evaluations_are_exactly_as_many_as_allowed(structure, maxfev):
    result = short(structure=structure, maxfev=maxfev)
    assert result.nfev == maxfev
    assert result.x.shape == (len(default_bounds(structure)),)


def test_a_wanted_cost_ends_the_search():
    result = short(stopval=0.09, maxfev=5000)
    assert result.message == "The wanted cost is reached."
    assert result.fun <= 0.09
    assert result.nfev < 5000


def test_a_wanted_cost_ends_the_search_for_gains_before_taps():
    assert short(structure="taps", stopval=0.09, maxfev=5000).nfev < 2000


@pytest.mark.parametrize("structure", ["paper", "taps"])
def test_the_time_ends_the_search_with_a_controller(structure):
    """As a program of its own, so that a crash is a failure and not the end of the tests."""
    program = (
        "import nfopidn\n"
        f"result = nfopidn.tune(robustness=None, structure={structure!r}, rng=1, maxfev=20000,"
        " maxtime=1e-9)\n"
        "nfopidn.simulate(controller=result.controller)\n"
        "print(result.nfev < 1000, result.message)\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", program], check=False, capture_output=True, text=True, timeout=60
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout == "True The time is up.\n"


# Frozen, tied, bounds, start


def test_a_frozen_parameter_keeps_its_value():
    frozen = {"ki_x": 0.0078125, "sigma": 1.25, "kd_x": 3.5}  # bounds do not concern it
    result = short(structure="incremental", frozen=frozen)
    assert result.parameters == [name for name in default_bounds() if name not in frozen]
    assert result.x.shape == (8,)
    assert result.population.shape[1] == 8
    controller = result.controller
    assert controller.gains[0][1] == 0.0078125
    assert controller.gains[0][2] == 3.5
    assert controller.sigma == 1.25
    assert result.fun < 0.1  # a run that diverges is another one after any rounding
    assert simulate(result.scenario, controller).cost == pytest.approx(result.fun, rel=1e-9)
    free = dict(zip(result.parameters, result.x, strict=True))
    every = dict(zip(default_bounds(), controller.to_vector(), strict=True))
    assert every == free | frozen


def test_a_tied_parameter_equals_its_leader():
    tied = {"kp_y": "kp_x", "kd_theta": "kp_x", "sigma": "alpha"}
    result = short(tied=tied)
    assert result.parameters == [name for name in default_bounds() if name not in tied]
    gains = result.controller.gains
    assert gains[0][0] == gains[1][0] == gains[2][2] == result.x[0] > 0
    assert_array_equal(result.controller.alpha, result.controller.sigma)
    assert simulate(result.scenario, result.controller).cost == pytest.approx(result.fun, rel=1e-9)


def test_orders_of_channels_may_be_frozen_and_tied():
    result = short(structure="extended", frozen={"alpha_y": 0.75}, tied={"sigma_theta": "sigma_x"})
    controller = result.controller
    assert controller.alpha[1] == 0.75
    assert controller.sigma[0] == controller.sigma[2] != controller.sigma[1]
    assert len(result.x) == 13


def test_taps_may_be_frozen_and_tied():
    frozen = {f"tap_x_{j}": 0.0 for j in range(3, 7)}
    result = short(structure="taps", frozen=frozen, tied={"tap_y_6": "tap_y_5"})
    assert_array_equal(result.controller.taps[0, 3:], 0)
    assert result.controller.taps[1, 6] == result.controller.taps[1, 5]
    assert simulate(result.scenario, result.controller).cost == pytest.approx(result.fun, rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        ({"frozen": {"kp": 1}}, ["frozen names 'kp'", "kp_x, ki_x", "sigma"]),
        ({"frozen": {"alpha_x": 1}}, ["frozen names 'alpha_x'"]),
        ({"frozen": {"alpha": 5}}, ["alpha is 5", "[-2, 2]"]),
        ({"frozen": {"ki_x": math.nan}}, ["ki_x", "nan"]),
        ({"frozen": dict.fromkeys(default_bounds(), 0.5)}, ["frozen", "no parameter free"]),
        ({"tied": {"kp": "kp_x"}}, ["tied names 'kp'", "known: kp_x"]),
        ({"tied": {"kp_x": "kp"}}, ["tied names 'kp'", "known: kp_x"]),
        ({"tied": {"kp_x": "kp_y", "kp_y": "kp_theta"}}, ["tied leads 'kp_y'", "'kp_theta'"]),
        ({"tied": {"kp_y": "kp_theta", "kp_x": "kp_y"}}, ["tied leads 'kp_x'", "not free"]),
        ({"tied": {"kp_x": "kp_y", "kp_y": "kp_x"}}, ["tied leads 'kp_y'", "'kp_x'"]),
        ({"tied": {"kp_x": "kp_y"}, "frozen": {"kp_y": 1}}, ["tied leads 'kp_x'", "not free"]),
        ({"tied": {"kp_x": "kp_y"}, "frozen": {"kp_x": 1}}, ["tied names 'kp_x'", "frozen"]),
        ({"bounds": {"kp": (0, 1)}}, ["bounds names 'kp'", "known: kp_x"]),
        ({"bounds": {"kp_x": (0, 1)}, "frozen": {"kp_x": 1}}, ["bounds names 'kp_x'"]),
        ({"bounds": {"kp_x": (0, 1)}, "tied": {"kp_x": "kp_y"}}, ["bounds names 'kp_x'"]),
        ({"bounds": {"kp_x": (1, 0)}}, ["bounds of kp_x", "(1.0, 0.0)", "smaller"]),
        ({"bounds": {"kp_x": (1, 1)}}, ["bounds of kp_x", "smaller"]),
        ({"bounds": {"kp_x": (0, math.inf)}}, ["bounds of kp_x", "finite"]),
        ({"bounds": {"kp_x": (math.nan, 1)}}, ["bounds of kp_x", "finite"]),
        ({"bounds": {"kp_x": 1}}, ["bounds of kp_x", "(low, high)"]),
        ({"bounds": {"kp_x": "ab"}}, ["bounds of kp_x", "(low, high)"]),
        ({"bounds": {"alpha": (-3, 1)}}, ["alpha is -3", "[-2, 2]"]),
        ({"bounds": {"alpha": (0, 3)}}, ["alpha is 3", "[-2, 2]"]),
        ({"bounds": [(0, 1)] * 10}, ["bounds", "(10, 2)", "(11, 2)", "kp_x"]),
        ({"bounds": [(0, 1)] * 10 + [(1, 0)]}, ["bounds of sigma", "(1.0, 0.0)"]),
        ({"structure": "pid"}, ['structure is "pid"', '"paper"', '"taps"']),
        ({"structure": {"form": "pid"}}, ['form is "pid"', "incremental"]),
        ({"structure": {"parameters": "all"}}, ['"all"', '"orders-by-channel"']),
        ({"scenario": []}, ["scenario", "at least one"]),
        ({"scenario": [1]}, ["scenario", "Scenario"]),
        ({"scenario": "published"}, ["scenario", "Scenario"]),
        ({"worst_share": -0.1}, ["worst_share is -0.1", "[0, 1]"]),
        ({"worst_share": 1.1}, ["worst_share is 1.1", "[0, 1]"]),
        ({"worst_share": math.nan}, ["worst_share is nan", "[0, 1]"]),
        ({"workers": 0}, ["workers is 0", "[1, 1024]"]),
        ({"workers": 1.5}, ["workers is 1.5", "whole number"]),
        ({"workers": True}, ["workers is True", "whole number"]),
        ({"start": 3}, ["start", "Controller"]),
        ({"start": Controller.published(memory=3)}, ["start has memory 3", "5"]),
        ({"start": Controller.from_taps(TAPS)}, ["start", "taps"]),
        ({"method": "pso"}, ["method is 'pso'"]),
        ({"options": {"cellz": 3}}, ["options", "cellz"]),
        ({"maxfev": 0}, ["maxfev is 0"]),
        ({"rng": -1}, ["rng is -1"]),
    ],
)
def test_bad_arguments_are_refused(arguments, parts):
    with refused(*parts):
        short(**arguments)


def test_bounds_by_name_and_by_vector():
    by_name = short(bounds={"ki_x": (0.5, 0.6), "alpha": (-0.5, -0.25)})
    named = default_bounds() | {"ki_x": (0.5, 0.6), "alpha": (-0.5, -0.25)}
    assert 0.5 <= by_name.controller.gains[0][1] <= 0.6
    assert -0.5 <= by_name.controller.alpha <= -0.25
    assert ((by_name.population[:, 1] >= 0.5) & (by_name.population[:, 1] <= 0.6)).all()
    same(by_name, short(bounds=list(named.values())))
    same(by_name, short(bounds=np.array(list(named.values()))))


def test_a_vector_of_bounds_is_for_the_free_parameters():
    result = short(bounds=[(0.1, 0.2)] * 9, frozen={"alpha": 0.5}, tied={"kp_y": "kp_x"})
    assert ((result.x >= 0.1) & (result.x <= 0.2)).all()


def test_a_start_is_a_point_of_the_search():
    start = Controller.tuned_nominal()
    cost = simulate(Scenario.published(rng=0), start).cost
    result = short(structure="incremental", start=start, maxfev=20)
    assert result.fun <= cost * (1 + 1e-9)
    assert short(structure="incremental", maxfev=20).fun > cost


def test_a_start_for_taps_is_given_by_gains_or_taps():
    structure = {"form": "incremental", "allocation": "decoupled", "parameters": "taps"}
    start = Controller.tuned_nominal()
    cost = simulate(Scenario.published(rng=0), start).cost
    one = short(structure=structure, start=start, maxfev=20)
    assert one.fun <= cost * (1 + 1e-9)
    assert one.nfev == 20
    fused = Controller.from_taps(start.taps, form="incremental", allocation="decoupled")
    same(one, short(structure=structure, start=fused, maxfev=20))


def test_a_start_gives_its_free_parameters_only():
    start = Controller.tuned_nominal()
    frozen = {"alpha": 0.3}
    tied = {"kp_y": "kp_theta"}
    result = short(structure="incremental", start=start, frozen=frozen, tied=tied, maxfev=4)
    assert result.controller.alpha == 0.3
    assert result.controller.gains[1][0] == result.controller.gains[2][0]


# Several scenarios


@pytest.mark.parametrize(
    ("worst_share", "worst"), [(1, 4), (0.75, 3), (0.5, 2), (0.25, 1), (0.1, 1), (0, 1)]
)
def test_the_cost_is_the_mean_of_the_worst(worst_share, worst):
    result = short(scenarios(), structure="decoupled", worst_share=worst_share)
    assert result.scenario == scenarios()
    costs = sorted(simulate(one, result.controller).cost for one in result.scenario)
    assert result.fun == pytest.approx(np.mean(costs[-worst:]), rel=1e-9)
    assert len(set(costs)) == 4


def test_a_share_between_two_numbers_of_scenarios():
    result = short(scenarios(), worst_share=0.375)
    costs = sorted(simulate(one, result.controller).cost for one in result.scenario)
    assert result.fun == pytest.approx((costs[-1] + 0.5 * costs[-2]) / 1.5, rel=1e-9)


# Results


@pytest.mark.parametrize("structure", STRUCTURES)
@pytest.mark.parametrize("several", [False, True])
def test_a_result_is_written_and_read(structure, several, tmp_path):
    path = tmp_path / "result.json"
    result = short(scenarios()[:2] if several else None, structure=structure, options={"cells": 20})
    result.to_json(path)
    again = TuneResult.from_json(path)
    assert isinstance(again, TuneResult)
    same(result, again)
    assert again.elapsed == result.elapsed
    assert again.history.dtype == result.history.dtype
    again.to_json(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_text() == path.read_text()
    document = json.loads(path.read_text())
    assert (document["format"], document["version"]) == ("nfopidn-tuning", 1)
    assert Controller.from_json(json.dumps(document["controller"])) == result.controller


@pytest.mark.parametrize("maxfev", [1, 3])
def test_a_result_of_few_evaluations_is_written_and_read(maxfev, tmp_path):
    result = short(maxfev=maxfev)
    result.to_json(tmp_path / "result.json")
    same(result, TuneResult.from_json(tmp_path / "result.json"))
    with pytest.raises(OSError, match=r"No space left.*/dev/full"):
        result.to_json("/dev/full")


def test_a_structure_of_settings_is_written_and_read(tmp_path):
    structure = {"allocation": np.array([[1, 0.5, 1], [1, -0.5, -1]]), "memory": np.int64(3)}
    short(structure=structure).to_json(tmp_path / "result.json")
    again = TuneResult.from_json(tmp_path / "result.json")
    assert again.structure == {"allocation": [[1, 0.5, 1], [1, -0.5, -1]], "memory": 3}


def broken(spoil):
    def text(document):
        spoil(document)
        return json.dumps(document)

    return text


@pytest.mark.parametrize(
    "text",
    [
        lambda document: "",
        lambda document: "[]",
        lambda document: "3",
        lambda document: json.dumps(document)[:-20],
        broken(lambda d: d.update(format="nfopidn-controller")),
        broken(lambda d: d.update(version=2)),
        broken(lambda d: d.pop("format")),
        broken(lambda d: d.pop("x")),
        broken(lambda d: d.pop("controller")),
        broken(lambda d: d.pop("history")),
        broken(lambda d: d.update(x=["a"])),
        broken(lambda d: d.update(history=[[1, 2]])),
        broken(lambda d: d.update(history=3)),
        broken(lambda d: d.update(scenario=[])),
        broken(lambda d: d.update(scenario=[{}])),
        broken(lambda d: d["controller"].update(alpha=7)),
    ],
)
def test_a_broken_result_is_refused(text, tmp_path):
    path = tmp_path / "result.json"
    short(maxfev=60).to_json(path)
    path.write_text(text(json.loads(path.read_text())))
    with pytest.raises(ValueError, match="not a tuning result") as caught:
        TuneResult.from_json(path)
    assert "result.json" in str(caught.value)


def test_a_missing_result_is_an_os_error(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"none\.json"):
        TuneResult.from_json(tmp_path / "none.json")


def test_a_result_is_a_text_in_short():
    result = short()
    assert repr(result).startswith(f"TuneResult(fun={result.fun:.6g}, nfev=400, ")
    same(result, pickle.loads(pickle.dumps(result)))
    same(result, copy.deepcopy(result))


def test_parameters_at_their_bounds_are_marked(tmp_path):
    bounds = {"kp_x": (0, 0.05), "kd_theta": (0.8, 1.0)}
    result = short(bounds=bounds, maxfev=3000)
    assert result.at_bounds()["kd_theta"] == "lower"
    mask = dict(zip(result.parameters, result.active_mask, strict=True))
    assert mask["kd_theta"] == -1
    assert {name for name, side in mask.items() if side} == set(result.at_bounds())
    text = str(result)
    assert "  kd_theta     0.8  (at its lower bound)" in text.splitlines()
    for name, value in zip(result.parameters, result.x, strict=True):
        assert [name, f"{value:.10g}"] in [line.split()[:2] for line in text.splitlines()]
    result.to_json(tmp_path / "r.json")
    same(TuneResult.from_json(tmp_path / "r.json"), result)
    document = json.loads((tmp_path / "r.json").read_text())
    for wrong in ([0], [2] * 11, "abc", [[0] * 11]):
        (tmp_path / "r.json").write_text(json.dumps(document | {"active_mask": wrong}))
        with refused("not a tuning result"):
            TuneResult.from_json(tmp_path / "r.json")
    del document["active_mask"]  # as earlier versions have written it
    (tmp_path / "r.json").write_text(json.dumps(document))
    assert TuneResult.from_json(tmp_path / "r.json").at_bounds() == {}


# Searches in which every controller diverges


def hopeless(**settings):
    """A path at 7.8 m/s from its first sample on: a start from rest is soon too far behind."""
    path = Trajectory.circle(period=8, dt=0.2, scale=5)
    return Scenario(path, rng=0, divergence_distance=0.5, **settings)


@pytest.mark.parametrize("structure", ["paper", "taps", "lqr"])
def test_a_search_in_which_all_diverges_is_no_success(structure):
    result = short(hopeless(), structure=structure)
    assert (result.success, result.status) == (False, list(MESSAGES).index("diverged"))
    assert result.message == (
        "The best controller that was found diverges at 0.2 s. The robot starts from rest where "
        "the reference moves at 7.85 m/s and 0.393 rad/s: "
        'initial_velocity="reference" starts it with these. The budget of evaluations is used up.'
    )
    assert simulate(result.scenario, result.controller).diverged_at == 0.2
    assert result.nfev == 400


def test_a_search_that_finds_a_start_from_the_reference_is_a_success():
    assert short(hopeless(initial_velocity="reference")).success


def test_advice_on_the_start_is_for_starts_from_rest_alone():
    result = short(hopeless(initial_velocity=(0.1, 0.0)))
    assert not result.success
    assert "diverges at 0.2 s. The budget" in result.message


@pytest.mark.parametrize("worst_share", [0.0, 0.5, 1.0])
def test_the_scenario_that_diverges_is_named(worst_share):
    result = short([*scenarios()[:3], hopeless()], maxfev=300, worst_share=worst_share)
    assert not result.success
    assert "diverges on scenario 3 at 0.2 s" in result.message


# Controllers of free taps


@pytest.fixture
def of_taps():
    return Controller.from_taps(TAPS, form="incremental", allocation="decoupled")


def test_taps_are_in_the_place_of_gains(of_taps, scenario):
    assert (of_taps.gains, of_taps.alpha, of_taps.sigma) == (None, None, None)
    assert_array_equal(of_taps.taps, TAPS)
    assert_array_equal(of_taps.to_vector(), TAPS.ravel())
    assert of_taps.memory == 5
    assert (of_taps.form, of_taps.lateral) == ("incremental", "direction")
    assert "from_taps" in repr(of_taps)
    assert Controller.from_taps(np.ones((3, 2))).memory == 0
    published = Controller.published()
    fused = Controller.from_taps(published.taps)
    assert fused != published
    assert_array_equal(simulate(scenario, fused).pose, simulate(scenario, published).pose)


def test_free_taps_are_kept(of_taps, tmp_path):
    path = tmp_path / "controller.json"
    of_taps.save(path)
    for again in (
        Controller.load(path),
        Controller.from_json(of_taps.to_json()),
        pickle.loads(pickle.dumps(of_taps)),
        copy.copy(of_taps),
        copy.deepcopy(of_taps),
        of_taps.replace(),
    ):
        assert again == of_taps
        assert hash(again) == hash(of_taps)
        assert_array_equal(again.taps, TAPS)
        assert again.gains is None
    assert of_taps != Controller.from_taps(TAPS)
    assert of_taps != Controller.from_taps(TAPS + 1e-12, form="incremental", allocation="decoupled")


def test_other_settings_of_free_taps_may_be_replaced(of_taps):
    changed = of_taps.replace(lateral="speed", form="positional")
    assert (changed.lateral, changed.form) == ("speed", "positional")
    assert_array_equal(changed.taps, TAPS)


@pytest.mark.parametrize(
    "change",
    [
        {"memory": 3},
        {"memory": 5},
        {"alpha": 0.1},
        {"sigma": 0.1},
        {"gains": [[1] * 3] * 3},
        {"generator": "gl"},
    ],
)
def test_what_free_taps_do_not_have_may_not_be_replaced(of_taps, change):
    with refused(*change, "does not apply", "free taps"):
        of_taps.replace(**change)


@pytest.mark.parametrize(
    ("taps", "parts"),
    [
        (np.ones((2, 7)), ["taps"]),
        (np.ones((3, 1)), ["taps"]),
        (np.ones(21), ["taps"]),
        (np.full((3, 7), np.nan), ["taps"]),
        (np.full((3, 7), np.inf), ["taps"]),
        ([[1, 2, 3], [1, 2, 3], [1, 2]], ["taps"]),
        ("taps", ["taps"]),
        (np.ones((3, 1027)), ["taps"]),
    ],
)
def test_bad_taps_are_refused(taps, parts):
    with refused(*parts):
        Controller.from_taps(taps)


@pytest.mark.parametrize("name", ["memory", "alpha", "gains", "generator", "shape"])
def test_taps_leave_no_room_for_other_arguments(name):
    with refused(name, exception=TypeError):
        Controller.from_taps(TAPS, **{name: 1})


def test_free_taps_step_as_simulated(of_taps, published):
    reference = published.scenario.reference
    twin = Controller.from_taps(TAPS, form="incremental", allocation="decoupled")
    run = simulate(published.scenario, of_taps)
    torques = [
        twin.step(pose, row) for pose, row in zip(run.pose[:50], reference[:50], strict=True)
    ]
    assert_array_equal(torques, run.torque[:50])


# Callback, progress, figure


def test_a_callback_sees_the_search():
    seen = []
    result = short(callback=watcher(seen), maxfev=1500)
    assert [step.nfev for step in seen] == result.history["nfev"][: len(seen)].tolist()
    assert len(seen) >= result.nit - 1 > 5
    assert all(step.x.shape == (11,) for step in seen)
    assert [step.fun for step in seen] == result.history["best"][: len(seen)].tolist()
    same(result, short(maxfev=1500))


@pytest.mark.parametrize("structure", ["paper", "taps"])
def test_a_callback_ends_the_search(structure):
    def stop(result):
        raise StopIteration

    result = short(structure=structure, callback=stop, maxfev=4000)
    assert result.message == "The callback asked to stop."
    assert result.nit == 1
    assert result.nfev < 1000
    assert result.controller is not None


def test_what_a_callback_raises_reaches_the_caller():
    def fail(result):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError) as caught:
        short(callback=fail)
    best = caught.value.best
    assert isinstance(best, TuneResult)
    assert simulate(best.scenario, best.controller).cost == pytest.approx(best.fun, rel=1e-9)


@pytest.mark.parametrize("structure", ["extended", "taps"])
def test_ctrl_c_gives_the_best_so_far(structure):
    """As a program of its own, which interrupts itself while the core is at work."""
    program = (
        "import os, signal, threading, nfopidn\n"
        "timer = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))\n"
        "timer.start()\n"
        f"result = nfopidn.tune(robustness=None, structure={structure!r}, rng=1, maxfev=500000)\n"
        "print(result.nfev < 500000, result.success, result.message)\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", program], check=False, capture_output=True, text=True, timeout=120
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout == "True False The search was interrupted; this is the best so far.\n"


def test_progress_prints_nothing_without_a_terminal(capfd):
    result = short(progress=True)
    assert capfd.readouterr() == ("", "")
    same(result, short())


@pytest.mark.parametrize("structure", ["paper", "taps"])
def test_the_history_ends_with_the_result(structure):
    result = short(structure=structure, maxfev=1000)
    last = result.history[-1]
    assert last["best"] == pytest.approx(result.fun, rel=1e-4)
    assert result.nfev - 40 <= last["nfev"] <= result.nfev


@pytest.mark.parametrize("draw", [plot.convergence, TuneResult.plot])
def test_the_convergence_is_drawn(draw):
    result = short()
    axes = draw(result)
    assert isinstance(axes, Axes)
    assert axes.get_xlabel() == "evaluations"
    assert axes.get_ylabel() == "cost E"
    assert axes.get_yscale() == "log"
    lines = {line.get_label(): line.get_xydata().T for line in axes.get_lines()}
    assert set(lines) == {"best so far", "mean of the cells"}
    history = result.history
    assert_array_equal(lines["best so far"], [history["nfev"], history["best"]])
    assert_array_equal(lines["mean of the cells"], [history["nfev"], history["mean"]])
    assert draw(result, ax=axes) is axes
    result.history["best"][-1] = -1
    assert draw(result).get_yscale() == "linear"


def test_a_start_beyond_the_bounds_is_refused():
    start = Controller.published(gains=[[5.0] * 3] * 3)
    with refused("start has kp_x 5", "[0, 3]"):
        tune(start=start, rng=1, maxfev=20)


def test_printed_foraging_starts_from_a_known_point():
    start = Controller.tuned_nominal()
    known = tune(structure="incremental", method="bfoa", rng=1, maxfev=30, start=start)
    assert known.fun <= simulate(controller=start).cost * (1 + 1e-9)


def test_free_taps_stay_within_their_bounds():
    structure = {"allocation": "decoupled", "lateral": "speed", "parameters": "taps"}
    for given in ("taps", structure):
        for maxfev in (1, 400):
            result = tune(structure=given, rng=1, maxfev=maxfev, bounds=[(-0.5, 0.5)] * 21)
            assert np.abs(result.x).max() <= 0.5
            assert result.nfev == maxfev


def test_a_callback_is_told_the_evaluations_of_all_stages():
    seen = []
    result = tune(structure="taps", rng=1, maxfev=1500, callback=watcher(seen))
    seen = [step.nfev for step in seen]
    assert seen == sorted(seen)
    assert 1000 < max(seen) <= result.nfev == 1500


@pytest.mark.parametrize(
    "structure",
    ["taps", {"allocation": "decoupled", "lateral": "direction", "parameters": "taps"}],
)
def test_a_time_limit_leaves_time_for_free_taps(structure):
    result = tune(structure=structure, rng=1, maxfev=10**7, maxtime=3.0)  # a third of it would do
    assert result.controller.gains is None
    assert result.fun < 0.0152  # gains and orders come to 0.01568
    assert result.message == "The time is up."


def test_many_first_points_do_not_outlast_the_time():
    result = tune(options={"first_points": 10**6}, maxfev=10**7, maxtime=0.2, rng=1)
    assert result.message == "The time is up."
    assert result.nfev < 10**6


def test_an_objective_refuses_points_of_another_size():
    objective = Objective()
    for x in ([], [1.0], [0.5] * 20, 5.0, np.zeros((2, 11))):
        for use in (objective, objective.gradient, objective.controller):
            with refused("x has the shape", "must be (11,)"):
                use(x)
    with refused("points have the shape"):
        objective.costs([0.5] * 11)
    with refused("gains[0][0] is 9e+09"):
        objective.controller([9e9] * 11)


def test_a_structure_s_robot_is_written(tmp_path):
    structure = {"law": "samson", "robot": Robot(mass=3)}
    result = tune(structure=structure, rng=1, maxfev=50)
    result.to_json(tmp_path / "r.json")
    document = json.loads((tmp_path / "r.json").read_text())
    assert document["structure"]["robot"]["mass"] == 3


def test_a_result_without_a_finite_cost_is_json(tmp_path):
    result = tune(rng=1, maxfev=3)
    result["population_energies"][:] = np.inf
    result.to_json(tmp_path / "r.json")
    text = (tmp_path / "r.json").read_text()
    assert "Infinity" not in text
    assert np.isinf(TuneResult.from_json(tmp_path / "r.json").population_energies).all()


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        ({"maxfev": "100"}, "maxfev is 100"),
        ({"maxfev": [50]}, "maxfev is [50]"),
        ({"maxfev": np.True_}, "maxfev is True"),
        ({"maxtime": "5"}, "maxtime is 5"),
        ({"maxtime": True}, "maxtime is True"),
        ({"stopval": "5"}, "stopval is 5"),
        ({"worst_share": "1"}, "worst_share is 1"),
        ({"worst_share": None}, "worst_share is None"),
        ({"workers": np.nan}, "workers is nan"),
        ({"workers": 2**31}, "workers is 2147483648; must be a whole number in [1, 1024]"),
        ({"workers": None}, "workers is None"),
        ({"bounds": "ab"}, "bounds are 'ab'"),
        ({"bounds": {"kp_x": "03"}}, "bounds of kp_x are '03'"),
        ({"frozen": 5}, "frozen is 5"),
        ({"frozen": {"kp_x": "1"}}, "frozen: kp_x is 1"),
        ({"tied": 5}, "tied is 5"),
        ({"options": 5}, "options is 5"),
        ({"options": {1: 2}}, "options: 1 is no name"),
        ({"options": {"cells": "8"}}, "options: cells is 8"),
        ({"structure": 5}, "structure is 5"),
        ({"callback": 5}, "callback is 5"),
        ({"checkpoint": 5}, "checkpoint is 5"),
        ({"checkpoint": b"x"}, "checkpoint is b'x'"),
        ({"checkpoint": "a\0b"}, "with a NUL"),
    ],
)
def test_a_wrong_type_is_refused_by_name(arguments, part):
    with refused(part):
        tune(**({"rng": 1, "maxfev": 20} | arguments))


# Free taps whose gains do not become taps


def frozen_x():
    return {f"tap_x_{i}": 0.0 for i in range(7)}


@pytest.mark.parametrize("named", [True, False])
def test_a_wanted_cost_is_one_of_taps(named):
    structure = "taps" if named else {"lateral": "speed", "parameters": "taps"}
    result = tune(structure=structure, frozen=frozen_x(), stopval=0.03, rng=1, maxfev=3000)
    assert (result.status == list(MESSAGES).index("target")) == (result.fun <= 0.03)
    assert result.history["best"][-1] == result.fun
    assert np.all(np.diff(result.history["best"]) <= 0)
    assert result.nfev == 3000


@pytest.mark.parametrize("named", [True, False])
def test_what_a_callback_raises_in_the_first_stage_has_taps(named):
    structure = "taps" if named else {"lateral": "speed", "parameters": "taps"}

    def fail(_):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError) as caught:
        tune(structure=structure, rng=1, callback=fail)
    best = caught.value.best
    assert len(best.x) == len(best.parameters) == 21
    assert best.structure == structure
    assert Objective(structure=structure)(best.x) == best.fun


@pytest.mark.parametrize("structure", ["taps", {"lateral": "speed", "parameters": "taps"}])
def test_more_time_goes_on_with_free_taps(structure, tmp_path):
    arguments = {"structure": structure, "rng": 4, "checkpoint": tmp_path / "search"}
    first = tune(**arguments, maxfev=60_000, maxtime=0.1)
    assert first.status == list(MESSAGES).index("time")
    then = tune(**arguments, maxfev=60_000, maxtime=first.elapsed + 0.5)
    assert then.nfev > first.nfev
    assert then.fun <= first.fun
    # The same course, up to the step in which the time of a stage was up that now has more.
    rows = min(len(first.history), len(then.history))
    differs = first.history[:rows] != then.history[:rows]
    common = int(np.argmax(differs)) if differs.any() else rows
    assert common >= (len(first.history) // 2 if structure == "taps" else len(first.history) - 1)


@pytest.mark.parametrize("method", ["bfoa", "bfoa+", "cma"])
def test_free_taps_are_never_worse_than_the_gains_they_start_from(method):
    for seed in range(5):  # 3 ends above its start
        arguments = {"rng": seed, "maxfev": 100, "method": method}
        found = tune(structure={"parameters": "taps"}, **arguments)
        assert found.fun == found.history["best"].min() == found.history["best"][-1]
        assert found.structure == {"parameters": "taps"}
        assert Objective(structure=found.structure)(found.x) == found.fun
        assert (found.history["best"][1:] <= found.history["best"][:-1]).all()
        assert found.nfev == 100


@pytest.mark.parametrize(
    ("structure", "suffix"),
    [
        *[("taps", suffix) for suffix in ("", ".speed", ".gains")],
        *[({"parameters": "taps"}, suffix) for suffix in ("", ".gains")],
    ],
)
@pytest.mark.parametrize("words", [{}, {"method": "bfoa"}, {"options": {"cells": 8}}])
def test_a_stage_s_checkpoint_of_another_search_is_refused_at_once(
    structure, suffix, words, tmp_path
):
    path = tmp_path / "search"
    tune(rng=5, maxfev=20, checkpoint=f"{path}{suffix}")
    arguments = {"structure": structure, "rng": 5, "checkpoint": path, **words}
    with refused(f"search{suffix}: is the checkpoint of another search"):
        tune(**arguments, maxfev=10**12)
    (tmp_path / f"search{suffix}").write_text("no checkpoint")
    with refused(f"search{suffix}: is damaged, or no checkpoint"):
        tune(**arguments, maxfev=10**12)
    assert len(list(tmp_path.iterdir())) == 1
    (tmp_path / f"search{suffix}").unlink()
    whole = tune(**arguments, maxfev=400)
    same(tune(**arguments, maxfev=400), whole)
    assert whole.method == words.get("method", "bfoa+")
    assert whole.options == words.get("options", {})
    with refused("is the checkpoint of another search"):
        tune(**arguments | {"rng": 6}, maxfev=400)


class OwnObjective(Objective):
    pass


class NotedObjective(Objective):
    def __init__(self, note):
        super().__init__(structure={"memory": 2})
        self.note = note


def test_a_copied_objective_is_what_it_was_when_it_was_made():
    class_with_a_note = NotedObjective("short")
    for again in (copy.copy(class_with_a_note), pickle.loads(pickle.dumps(class_with_a_note))):
        assert (type(again), again.note) == (NotedObjective, "short")
        assert again.parameters == class_with_a_note.parameters
    frozen, tied, paths = {"kp_x": 1.0}, {"kp_y": "kp_theta"}, [Scenario.published(rng=0)]
    bounds = np.array([[0.0, 3.0]] * 7 + [[0.0, 1.0]] * 2)
    structure = {"memory": 3}
    objective = OwnObjective(paths, structure=structure, bounds=bounds, frozen=frozen, tied=tied)
    x = objective.bounds.mean(axis=1) / 10
    cost, box = objective(x), objective.bounds.copy()
    frozen["ki_x"] = 1.0
    tied.clear()
    structure["memory"] = 5
    paths.append(Scenario.published(rng=0, delay=1))
    bounds[:7, 1] = 2
    for again in (copy.copy(objective), pickle.loads(pickle.dumps(objective))):
        assert type(again) is OwnObjective
        assert again(x) == cost
        assert_array_equal(again.bounds, box)
    mapped = Objective(frozen=MappingProxyType({"kp_x": 1.0}))
    assert pickle.loads(pickle.dumps(mapped)).parameters == mapped.parameters


def test_unlimited_is_no_number_of_evaluations():
    with refused("maxfev is 4611686018427387904", "[1, 2**62)"):
        tune(maxfev=2**62)


def test_options_are_refused_before_any_stage(tmp_path):
    for words in ({"options": {"foo": 1}}, {"method": "bfoa", "options": {"cells": 7}}):
        with refused("options"):
            tune(structure="taps", checkpoint=tmp_path / "search", rng=1, **words)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_an_objective_is_pickled(protocol):
    objective = Objective(structure="decoupled", frozen={"kp_x": 1.0}, worst_share=0.5)
    again = pickle.loads(pickle.dumps(objective, protocol))
    assert again.parameters == objective.parameters
    x = objective.bounds.mean(axis=1) / 10
    assert again(x) == objective(x)
    with pytest.raises(TypeError, match="cannot pickle"):
        pickle.dumps(objective._function, protocol)


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ([np.full(11, np.nan)], "finite"),
        *[(bad, "real numbers") for bad in ("abc", ["1"] * 11, None, [np.full(11, 1j)])],
    ],
)
def test_an_objective_refuses_points_that_are_none(points, words):
    with refused("points", words):
        Objective().costs(points)


@pytest.mark.parametrize(
    ("structure", "words"),
    [
        ({"parameters": 5}, "parameters is 5"),
        ({"law": None}, "law is None"),
        ({1: 1}, "1 is no name"),
        ("\udcff", "is not UTF-8"),
        ({"\udcff": 1}, "is not UTF-8"),
        ({"parameters": "\udcff"}, "is not UTF-8"),
        (np.array(["paper", "x"]), "must be a name"),
    ],
)
def test_a_structure_of_other_types_is_refused(structure, words):
    with refused("structure", words):
        tune(structure=structure)


def test_an_interruption_while_the_bar_is_drawn_keeps_the_best(monkeypatch):
    @contextmanager
    def bar(*_):
        def report(done, note):
            if done > 600:
                raise KeyboardInterrupt

        yield report

    monkeypatch.setattr(_search, "progress", bar)
    result = tune(rng=1, maxfev=5000, progress=True)
    assert (result.success, result.message) == (False, MESSAGES["interrupted"])
    assert 600 < result.nfev < 5000

    @contextmanager
    def late(*_):
        yield lambda done, note: None
        raise KeyboardInterrupt

    monkeypatch.setattr(_search, "progress", late)
    result = tune(rng=1, maxfev=700, progress=True)
    assert (result.nfev, result.message) == (700, MESSAGES["interrupted"])


@pytest.mark.parametrize("field", ["structure", "options", "method", "elapsed", "nit", "status"])
def test_a_result_without_a_field_is_refused(field, tmp_path):
    short().to_json(tmp_path / "result.json")
    document = json.loads((tmp_path / "result.json").read_text())
    del document[field]
    (tmp_path / "result.json").write_text(json.dumps(document))
    with refused("result.json", field):
        TuneResult.from_json(tmp_path / "result.json")


def test_a_result_of_another_length_is_refused(tmp_path):
    short().to_json(tmp_path / "result.json")
    document = json.loads((tmp_path / "result.json").read_text())
    document["parameters"].pop()
    (tmp_path / "result.json").write_text(json.dumps(document))
    with refused("result.json", "x must have 10 numbers"):
        TuneResult.from_json(tmp_path / "result.json")


def test_a_rivals_robot_comes_back(tmp_path):
    result = short(structure={"law": "lqr", "robot": Robot(mass=12)})
    result.to_json(tmp_path / "result.json")
    again = TuneResult.from_json(tmp_path / "result.json")
    assert again.structure["robot"] == Robot(mass=12)
    assert short(structure=again.structure).fun == result.fun


def test_a_start_of_more_orders_than_the_structure_is_refused():
    for words in ({"alpha": (0.1, 0.9, 0.3)}, {"sigma": (0.8, 0.8, 0.9)}):
        with refused(f"start has a {next(iter(words))} for each channel"):
            short(start=Controller.published(**words))
        short(structure="extended", start=Controller.published(**words), maxfev=20)
