"""One script for scipy.optimize.differential_evolution and for bfoa(): SciPy's is the reference."""

import multiprocessing
import warnings

import numpy as np
import pytest
from nfopidn import Forager, bfoa
from nfopidn.search.optimise import _convergence
from numpy.testing import assert_array_equal
from refusal import refused
from scipy.optimize import Bounds, OptimizeResult, differential_evolution

CENTRE = np.array([0.5, 0.25])
BOX = [(-2.0, 3.0), (0.0, 1.0)]


def bowl(x, *at):
    return float(((x - (at[0] if at else CENTRE)) ** 2).sum())


def bowls(columns):
    """Points (p, n), as SciPy gives them, and one point (p,) too."""
    return ((columns.T - CENTRE) ** 2).sum(axis=-1)


@pytest.fixture(params=["scipy", "bfoa+", "bfoa"])
def minimise(request):
    """Run a script with one of the three."""
    if request.param == "scipy":
        own = {"maxiter": 8, "popsize": 8, "polish": False, "tol": 0, "updating": "deferred"}
        return lambda *args, **words: differential_evolution(*args, **(seeded(words) | own | words))
    own = {"method": request.param, "maxfev": 600}
    return lambda *args, **words: bfoa(*args, **(seeded(words) | own | words))


def seeded(words):
    return {} if "seed" in words else {"rng": 1}


def test_the_budget_s_end_is_no_success(minimise):
    result = minimise(bowl, BOX)
    assert not result.success
    assert result.x.shape == (2,)
    assert bowl(result.x) == result.fun < 0.5
    assert result.nfev > 0
    assert isinstance(result.message, str)
    assert result.population.shape == (len(result.population_energies), 2)


def test_a_search_that_comes_to_its_own_end_is_a_success():
    assert bfoa(bowl, BOX, rng=1).success  # the default budget
    assert bfoa(bowl, BOX, rng=1, stopval=0.1).success
    assert bfoa(bowl, BOX, rng=1, method="bfoa").success  # a schedule
    assert not bfoa(bowl, BOX, rng=1, maxfev=10_000).success
    assert not bfoa(bowl, BOX, rng=1, maxtime=1e-9).success
    assert not bfoa(bowl, BOX, rng=1, method="bfoa", maxfev=100).success


def test_more_arguments_of_func(minimise):
    at = np.array([1.0, 0.75])
    result = minimise(bowl, BOX, (at,))
    assert bowl(result.x, at) == result.fun < 0.5
    assert minimise(bowl, BOX, args=(at,)).fun == result.fun


def test_bounds_of_scipy(minimise):
    one, other = minimise(bowl, Bounds([-2, 0], [3, 1])), minimise(bowl, BOX)
    assert_array_equal(one.x, other.x)


@pytest.mark.parametrize("start", [None, [0.1, 0.9]])
def test_equal_bounds_fix_a_number(minimise, start):
    result = minimise(bowl, [(0.1, 0.1), (0, 1)], x0=start)
    assert result.x[0] == 0.1
    assert result.fun == pytest.approx(0.16, abs=0.05)
    assert (result.population[:, 0] == 0.1).all()


def test_a_start(minimise):
    result = minimise(bowl, BOX, x0=CENTRE)
    assert result.fun == pytest.approx(0.0, abs=1e-20)
    with pytest.raises(ValueError, match="x0"):
        minimise(bowl, BOX, x0=[5.0, 0.5])


@pytest.mark.parametrize(
    "make",
    [
        lambda: np.random.default_rng(3),
        lambda: np.random.SeedSequence(3),
        lambda: np.random.PCG64(3),
        lambda: 3,
        lambda: np.int64(3),
    ],
)
def test_seeds(minimise, make):
    one, other = minimise(bowl, BOX, rng=make()), minimise(bowl, BOX, rng=make())
    assert_array_equal(one.x, other.x)
    assert not np.array_equal(one.x, minimise(bowl, BOX, rng=4).x)


@pytest.mark.parametrize("make", [lambda: np.random.RandomState(3), lambda: 3])
def test_the_older_name_of_a_seed(minimise, make):
    runs = [minimise(bowl, BOX, seed=make()) for _ in range(2)]
    assert_array_equal(runs[0].x, runs[1].x)


def test_a_seed_by_two_names_is_refused():
    with refused("rng is 1 and seed is 2"):
        bfoa(bowl, BOX, rng=1, seed=2)


@pytest.mark.parametrize("shape", [(), (1,), (1, 1)])
def test_a_cost_may_be_an_array_of_one(shape):
    given = bfoa(lambda x: np.full(shape, bowl(x)), BOX, rng=1, maxfev=100)
    assert given.fun == bfoa(bowl, BOX, rng=1, maxfev=100).fun


def test_a_cost_of_shape_1(minimise):
    one, other = minimise(lambda x: np.array([bowl(x)]), BOX), minimise(bowl, BOX)
    assert_array_equal(one.x, other.x)


@pytest.mark.parametrize(
    "reply", [np.zeros(2), "0.5", b"1", None, np.array([1j]), np.zeros(0), 10**400]
)
@pytest.mark.parametrize("workers", [1, map])
def test_what_is_no_cost_is_refused(reply, workers):
    with pytest.raises((TypeError, ValueError)):
        bfoa(lambda x: reply, BOX, rng=1, maxfev=10, workers=workers)


def test_vectorized(minimise):
    shapes = []

    def func(x):
        shapes.append(x.shape)
        return bowls(x)

    result = minimise(func, BOX, vectorized=True)
    assert {shape[0] for shape in shapes} == {2}
    assert all(len(shape) == 2 for shape in shapes)
    assert max(shape[1] for shape in shapes) > 1
    assert result.fun == pytest.approx(bowl(result.x))


def test_workers_override_vectorized_with_a_warning(minimise):
    with pytest.warns(UserWarning, match="'workers' keyword overrides the 'vectorized' keyword"):
        result = minimise(bowls, BOX, vectorized=True, workers=map)
    assert bowl(result.x) == pytest.approx(result.fun)


@pytest.mark.parametrize("workers", [-1, 2])
def test_workers_are_processes(minimise, workers):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # SciPy's, on forks
        result = minimise(bowl, BOX, workers=workers)
    assert bowl(result.x) == result.fun == minimise(bowl, BOX).fun


def test_a_pool_s_map(minimise):
    with multiprocessing.Pool(2) as pool:
        results = [minimise(bowl, BOX, workers=workers) for workers in (pool.map, pool.imap)]
    assert results[0].fun == results[1].fun == minimise(bowl, BOX).fun


def test_a_map_out_of_order_changes_nothing():
    """Answers know their points: imap_unordered would else give them to others."""

    def backwards(func, points):
        return [func(x) for x in list(points)[::-1]]

    one = bfoa(bowl, BOX, rng=1, maxfev=600)
    assert_array_equal(bfoa(bowl, BOX, rng=1, maxfev=600, workers=backwards).x, one.x)
    with multiprocessing.Pool(2) as pool:
        result = bfoa(bowl, BOX, rng=1, maxfev=600, workers=pool.imap_unordered)
    assert_array_equal(result.history.tolist(), one.history.tolist())
    assert bowl(result.x) == result.fun


def test_what_a_map_out_of_order_answered_before_an_error_is_kept():
    calls = []

    def func(x):
        calls.append(x)
        if len(calls) == 25:
            raise ZeroDivisionError
        return bowl(x)

    def backwards(func, points):
        return (func(x) for x in list(points)[::-1])

    with pytest.raises(ZeroDivisionError) as caught:
        bfoa(func, BOX, rng=1, maxfev=600, method="bfoa", workers=backwards)
    best = caught.value.best
    assert best.nfev <= 24
    assert best.fun == bowl(best.x)


@pytest.mark.parametrize(
    ("mapping", "words"),
    [
        (lambda func, points: [func(x) for x in points][1:], "answers to"),
        (lambda func, points: [func(x) for x in [*points, *points]], "more than"),
        (lambda func, points: [func(x + 1) for x in points], "not asked for"),
        (lambda func, points: [func(points[0]) for _ in points], "not asked for"),
        (lambda func, points: [0.5] * (len(points) + 1), "more than"),
    ],
)
def test_a_map_that_mixes_points_up_is_refused(mapping, words):
    with pytest.raises(ValueError, match=words):
        bfoa(bowl, BOX, rng=1, maxfev=100, workers=mapping)


def test_a_map_may_give_numbers_of_its_own():
    result = bfoa(bowl, BOX, rng=1, maxfev=300, workers=lambda _, points: bowls(np.array(points).T))
    assert result.fun == pytest.approx(bfoa(bowl, BOX, rng=1, maxfev=300).fun, rel=1e-12)


# Callbacks


def test_a_callback_of_x_and_convergence(minimise):
    seen = []

    def callback(x, convergence):
        seen.append((x.shape, float(convergence)))

    minimise(bowl, BOX, callback=callback)
    assert {shape for shape, _ in seen} == {(2,)}
    assert all(value >= 0 for _, value in seen)


def test_a_callback_of_an_intermediate_result(minimise):
    seen = []

    def callback(*, intermediate_result):
        seen.append(intermediate_result)

    minimise(bowl, BOX, callback=callback)
    for one in seen:
        assert bowl(one.x) == pytest.approx(one.fun)
        assert one.nfev > 0
        assert one.convergence >= 0
        assert one.population.shape == (len(one.population_energies), 2)


def test_a_callback_of_x_alone_gets_x():
    seen = []

    def callback(xk):
        seen.append(xk.copy())

    result = bfoa(bowl, BOX, rng=1, maxfev=600, callback=callback)
    bfoa(bowl, BOX, rng=1, maxfev=600, callback=seen.append)
    assert all(x.shape == (2,) for x in seen)
    assert bowl(seen[-1]) == result.history["best"][-2]


def by_result(intermediate_result):
    return intermediate_result.nfev > 0


def by_name(result):
    return result.nfev > 0


def by_x(x, convergence=None):
    return x.shape == (2,)


def by_numpy(x, convergence=None):
    return np.bool_(True)


def by_exception(intermediate_result):
    raise StopIteration


@pytest.mark.parametrize("callback", [by_result, by_x, by_numpy, by_exception])
def test_a_callback_stops(minimise, callback):
    result = minimise(bowl, BOX, callback=callback)
    assert not result.success
    assert result.nit <= 1
    assert "allback" in result.message


def test_a_callback_of_a_result_stops_a_forager_too():
    forager = Forager(BOX, rng=1, callback=by_name)
    while (points := forager.ask()) is not None:
        forager.tell(bowls(points.T))
    assert (forager.result.nit, forager.result.success) == (1, False)


def test_convergence_is_scipy_s():
    energies = np.array([1.0, 2.0, 4.0])
    spread = np.std(energies) / abs(np.mean(energies))
    assert _convergence(energies) == pytest.approx(0.01 / spread)
    assert _convergence(np.array([1.0, np.inf])) == 0
    assert _convergence(np.ones(3)) > 1


def test_results_have_scipy_s_fields():
    own = bfoa(bowl, BOX, rng=1, maxfev=100)
    other = differential_evolution(bowl, BOX, rng=1, maxiter=2, polish=False)
    assert isinstance(other, OptimizeResult)
    assert set(other) - {"convergence"} <= set(own)


def test_a_start_is_part_of_what_a_checkpoint_is_of(tmp_path):
    path = tmp_path / "search"
    bfoa(bowl, BOX, rng=1, maxfev=100, x0=[0.1, 0.2], checkpoint=path)
    with refused("checkpoint"):
        bfoa(bowl, BOX, rng=1, maxfev=100, checkpoint=path)
    bfoa(bowl, BOX, rng=1, maxfev=100, x0=[0.1, 0.2], checkpoint=path)


def test_a_forager_starts_from_x0():
    with Forager(BOX, rng=1, maxfev=100, x0=CENTRE) as forager:
        points = forager.ask()
        assert min(bowl(x) for x in points) < 1e-20
    with refused("x0 has the shape (1,); must be (2,)"):
        bfoa(bowl, BOX, x0=[0.5])
    with refused("x0 must be real numbers"):
        bfoa(bowl, BOX, x0=["0.5", "0.5"])
    with refused("x0 of coordinate 0 is 5; must be in [-2, 3]"):
        Forager(BOX, x0=[5, 0.5])
