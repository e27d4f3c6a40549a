"""monte_carlo(): runs against simulate() one by one, draws against their distributions."""

import signal
import subprocess
import sys

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Family, Rival, Robot, Scenario, monte_carlo, simulate
from nfopidn.montecarlo import Choice, LogNormal, Normal, Uniform, runs, sobol_indices
from nfopidn.montecarlo.draws import Draws
from pyarrow import parquet
from scipy import stats

SCENARIO = Scenario.published(pose_noise=(0.005, 0.005), rng=0)
CALM = Scenario.published(rng=0)
CONTROLLER = Controller.recommended()
ROBOT = {
    "mass": Normal(11.5, 0.5),
    "inertia": Normal(0.5873, 0.05),
    "track_width": Uniform(0.43, 0.47),
    "wheel_radius": LogNormal(0.076, 0.01),
}
ALL = {
    **ROBOT,
    "viscous_friction": Uniform(0, 0.01),
    "coulomb_friction": Uniform(0, 0.1),
    "viscous_scrub": Uniform(0, 0.05),
    "coulomb_scrub": Uniform(0, 0.1),
    "disturbance_force": Normal(0, 1),
    "disturbance_moment": Normal(0, 0.1),
    "position_noise": Uniform(0, 0.01),
    "heading_noise": Uniform(0, 0.01),
    "delay": Choice([0, 1], weights=[3, 1]),
    "start_x": Normal(4, 0.05),
    "start_y": Normal(0, 0.05),
    "start_theta": Normal(1.0472, 0.05),
    "path_scale": Uniform(0.95, 1.05),
}


@pytest.fixture(scope="module")
def result():
    return monte_carlo(SCENARIO, CONTROLLER, 2000, rng=5, distributions=ROBOT)


# Runs.


def test_calm_runs_are_those_of_simulate_one_by_one():
    result = monte_carlo(CALM, CONTROLLER, 50, rng=1, distributions=ROBOT)
    drawn = result.parameters
    for i in range(50):
        robot = Robot(**{name: drawn[name][i] for name in ROBOT})
        alone = simulate(CALM.replace(robot=robot, model=CALM.robot), CONTROLLER)
        assert result.costs[i] == pytest.approx(alone.cost, rel=1e-12)


def test_a_replayed_run_costs_the_same_to_the_bit(result):
    for i in [*range(20), *result.worst(5)]:
        assert simulate(result.replay(int(i)), CONTROLLER).cost == result.costs[i]


def test_so_does_one_that_is_lost():
    wide = {"mass": Normal(11.5, 2), "inertia": Uniform(0.2, 0.8), "delay": Choice([0, 2, 3])}
    result = monte_carlo(SCENARIO, CONTROLLER, 200, rng=1, distributions=wide)
    worst = result.worst(10)
    assert result.costs[worst].min() > 1
    for i in worst:
        assert simulate(result.replay(int(i)), CONTROLLER).cost == result.costs[i]


def test_everything_may_be_drawn():
    names = set(ALL)
    assert names == set(nfopidn._core.drawn_parameters())
    result = monte_carlo(SCENARIO, CONTROLLER, 8, rng=2, distributions=ALL)
    drawn = result.parameters
    for i in range(8):
        scenario = result.replay(i)
        assert scenario.robot.mass == drawn["mass"][i]
        assert scenario.robot.inertia == drawn["inertia"][i]
        assert scenario.robot.track_width == drawn["track_width"][i]
        assert scenario.robot.wheel_radius == drawn["wheel_radius"][i]
        assert scenario.viscous_friction == drawn["viscous_friction"][i]
        assert scenario.coulomb_friction == drawn["coulomb_friction"][i]
        assert scenario.viscous_scrub == drawn["viscous_scrub"][i]
        assert scenario.coulomb_scrub == drawn["coulomb_scrub"][i]
        moved = (drawn["disturbance_force"][i], drawn["disturbance_moment"][i])
        assert np.ravel(scenario.disturbance).tolist() == list(moved)
        assert scenario.pose_noise == (drawn["position_noise"][i], drawn["heading_noise"][i])
        assert scenario.delay == drawn["delay"][i]
        start = tuple(drawn[f"start_{name}"][i] for name in ("x", "y", "theta"))
        assert scenario.initial_pose == start
        assert scenario.trajectory.scale == drawn["path_scale"][i]
        assert scenario.model == SCENARIO.robot
        assert scenario.noise_source == "counter"
        assert simulate(scenario, CONTROLLER).cost == result.costs[i]


def test_rivals_and_long_memories_run_one_by_one():
    for controller in (Rival("samson"), Controller.published(memory=9)):
        result = monte_carlo(SCENARIO, controller, 5, rng=3, distributions=ROBOT)
        for i in range(5):
            assert simulate(result.replay(i), controller).cost == result.costs[i]


def test_columns_are_the_metrics_of_each_run(result):
    kept = monte_carlo(
        SCENARIO,
        CONTROLLER,
        20,
        rng=5,
        distributions=ROBOT,
        columns=("position_rms", "energy", "cost"),
    )
    assert list(kept.metrics) == ["cost", "position_rms", "energy"]
    assert (kept.costs == result.costs[:20]).all()
    for i in range(20):
        metrics = simulate(kept.replay(i), CONTROLLER).metrics
        assert kept.metrics["position_rms"][i] == metrics["position_rms"]
        assert kept.metrics["energy"][i] == metrics["energy"]


def test_of_a_family_run_i_is_on_member_i_modulo_its_size():
    family = Family.of([("a", CALM, ""), ("b", CALM.replace(delay=1), "one sample")])
    result = monte_carlo(family, CONTROLLER, 7, rng=5, distributions=ROBOT)
    assert result.parameters["member"].tolist() == [0, 1, 0, 1, 0, 1, 0]
    for i in range(7):
        assert result.replay(i).delay == i % 2
        assert simulate(result.replay(i), CONTROLLER).cost == result.costs[i]


def test_noise_is_each_run_s_own(result):
    alone = monte_carlo(SCENARIO, CONTROLLER, 50, rng=5)
    assert len(np.unique(alone.costs)) == 50
    seeds = {result.replay(i).seed for i in range(50)}
    assert len(seeds) == 50


def test_the_result_depends_on_the_seed_alone(result):
    again = monte_carlo(SCENARIO, CONTROLLER, 2000, rng=5, distributions=ROBOT, workers=3)
    assert (again.costs == result.costs).all()
    other = monte_carlo(SCENARIO, CONTROLLER, 10, rng=6, distributions=ROBOT)
    assert not (other.costs == result.costs[:10]).any()
    drawn = monte_carlo(SCENARIO, CONTROLLER, 2, distributions=ROBOT)
    assert (
        monte_carlo(SCENARIO, CONTROLLER, 2, rng=drawn.seed, distributions=ROBOT).costs
        == drawn.costs
    ).all()
    generator = monte_carlo(SCENARIO, CONTROLLER, 2, rng=np.random.default_rng(1))
    assert generator.seed == np.random.default_rng(1).integers(2**53)


def test_independent_runs_depend_on_no_other_run_and_parameter(result):
    few = monte_carlo(SCENARIO, CONTROLLER, 7, rng=5, distributions={**ROBOT, "delay": Choice([0])})
    assert (few.costs == result.costs[:7]).all()
    for name in ROBOT:
        assert (few.parameters[name] == result.parameters[name][:7]).all()


# Draws.


@pytest.mark.parametrize("method", ["independent", "latin-hypercube", "sobol"])
def test_draws_have_their_distributions(method):
    distributions = {**ROBOT, "start_y": stats.laplace(0, 0.02)}
    result = monte_carlo(CALM, CONTROLLER, 4096, rng=7, distributions=distributions, method=method)
    drawn = result.parameters
    expected = {
        "mass": stats.norm(11.5, 0.5),
        "inertia": stats.norm(0.5873, 0.05),
        "track_width": stats.uniform(0.43, 0.04),
        "wheel_radius": stats.lognorm(0.01, scale=0.076),
        "start_y": stats.laplace(0, 0.02),
    }
    for name, one in expected.items():
        assert stats.kstest(drawn[name], one.cdf).pvalue > 1e-3
    table = np.array([drawn[name] for name in expected])
    related = np.corrcoef(table) - np.eye(len(table))
    assert np.abs(related).max() < 5 / np.sqrt(4096)
    if method == "latin-hypercube":  # one run in each of n strata
        strata = np.floor(4096 * expected["mass"].cdf(drawn["mass"]))
        assert sorted(strata.astype(int)) == list(range(4096))


def test_a_choice_has_its_weights():
    choice = Choice([0, 1, 2], weights=[1, 0, 3])
    drawn = monte_carlo(CALM, CONTROLLER, 4000, rng=1, distributions={"delay": choice})
    counts = [(drawn.parameters["delay"] == delay).sum() for delay in (0, 1, 2)]
    assert counts[1] == 0
    assert counts[0] == pytest.approx(1000, abs=5 * np.sqrt(750))


@pytest.mark.parametrize("method", ["independent", "latin-hypercube", "sobol"])
def test_a_covariance_is_that_of_the_draws(method):
    # In another order than the core has.
    distributions = {
        "inertia": Normal(0.5873, 0.05),
        "track_width": Uniform(0.44, 0.46),
        "mass": Normal(11.5, 0.5),
    }
    covariance = np.array([[0.05**2, 0.8 * 0.05 * 0.5], [0.8 * 0.05 * 0.5, 0.5**2]])
    result = monte_carlo(
        CALM,
        CONTROLLER,
        8192,
        rng=1,
        distributions=distributions,
        covariance=covariance,
        method=method,
    )
    drawn = result.parameters
    found = np.cov(drawn["inertia"], drawn["mass"])
    assert found / np.sqrt(np.outer(np.diag(covariance), np.diag(covariance))) == pytest.approx(
        np.array([[1, 0.8], [0.8, 1]]), abs=0.06
    )
    assert abs(np.corrcoef(drawn["track_width"], drawn["mass"])[0, 1]) < 0.05


# What the result tells.


def test_yield_has_the_textbooks_intervals(result):
    limit = float(np.quantile(result.costs, 0.97))
    found = result.yield_({"cost": limit})
    n, k = 2000, int((result.costs <= limit).sum())
    assert (found.successes, found.n, found.share) == (k, n, k / n)
    z = stats.norm.ppf(0.975)
    middle = (k + z**2 / 2) / (n + z**2)
    half = z / (n + z**2) * np.sqrt(k * (n - k) / n + z**2 / 4)
    assert (found.low, found.high) == pytest.approx((middle - half, middle + half), rel=1e-12)
    exact = result.yield_({"cost": limit}, confidence=0.9, interval="clopper-pearson")
    ends = stats.beta.ppf(0.05, k, n - k + 1), stats.beta.ppf(0.95, k + 1, n - k)
    assert (exact.low, exact.high) == pytest.approx(ends, rel=1e-9)
    assert "0.9 clopper-pearson" in str(exact)
    both = result.yield_({"cost": (limit, np.inf)})
    assert both.successes == (result.costs >= limit).sum()


def test_quantiles_and_worst(result):
    assert result.quantiles((0.1, 0.9)).tolist() == np.quantile(result.costs, (0.1, 0.9)).tolist()
    worst = result.worst(3)
    assert result.costs[worst].tolist() == sorted(result.costs)[:-4:-1]
    assert str(worst[0]) in str(result)


def test_sensitivity_is_spearman_s(result):
    found = result.sensitivity()
    drawn = result.parameters
    for name, value in zip(found.names, found.correlations, strict=True):
        assert value == pytest.approx(stats.spearmanr(drawn[name], result.costs)[0], abs=1e-12)
    assert np.abs(found.correlations).tolist() == sorted(np.abs(found.correlations))[::-1]
    assert found.names[0] in str(found)
    failing = result.sensitivity(limits={"cost": float(np.median(result.costs))})
    assert failing.metric == "failure"
    assert failing.names[0] == found.names[0]


def test_sobol_indices_share_out_the_variance():
    names = {"inertia": Normal(0.5873, 0.05), "mass": Normal(11.5, 0.01)}
    found = sobol_indices(CALM, CONTROLLER, 256, rng=1, distributions=names)
    assert found.runs == 256 * 4
    place = found.names.index("inertia")
    assert found.first_order[place] == pytest.approx(1, abs=0.1)
    assert found.total_order[1 - place] == pytest.approx(0, abs=0.05)
    assert "inertia" in str(found)


def test_sobol_indices_are_those_of_the_metric_asked_for():
    names = {"mass": Normal(11.5, 1.0), "inertia": Normal(0.5873, 0.02)}
    of_cost, of_energy = (
        sobol_indices(CALM, CONTROLLER, 64, rng=1, distributions=names, metric=metric)
        for metric in ("cost", "energy")
    )
    place = of_cost.names.index("mass")
    assert abs(of_energy.first_order[place] - of_cost.first_order[place]) > 0.2


def test_a_diverged_run_is_within_no_limit_of_a_metric():
    """Its metrics would be those of the samples before."""
    lost = monte_carlo(
        CALM, Controller.published(form="incremental"), 4, rng=1, columns=("cost", "iae")
    )
    assert (lost.costs > 10).all()
    assert np.isinf(lost.metrics["iae"]).all()
    assert np.isfinite(lost.costs).all()
    assert not lost.within({"iae": 1e9}).any()


def test_position_errors_are_those_of_the_runs(result):
    t, errors = result.position_errors(3)
    run = simulate(result.replay(2), CONTROLLER)
    assert t.tolist() == run.t.tolist()
    columns = run.columns
    assert errors[2].tolist() == np.hypot(columns["e_x"], columns["e_y"]).tolist()


# Checkpoints and interruption.


class EndsError(Exception):
    """Ends the runs after some blocks."""


@pytest.fixture
def small_blocks(monkeypatch):
    monkeypatch.setattr(runs, "BLOCK", 64)
    monkeypatch.setattr(runs, "CHECKPOINT_EVERY", -1.0)


def ends_at(monkeypatch, first, error):
    block = runs.Analysis.block

    def ending(self, at, count, workers):
        if at >= first:
            raise error
        return block(self, at, count, workers)

    monkeypatch.setattr(runs.Analysis, "block", ending)


@pytest.mark.usefixtures("small_blocks")
def test_ctrl_c_keeps_what_is_done(monkeypatch, result):
    ends_at(monkeypatch, 128, KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt) as caught:
        monte_carlo(SCENARIO, CONTROLLER, 2000, rng=5, distributions=ROBOT)
    kept = caught.value.best
    assert len(kept) == 128
    assert (kept.costs == result.costs[:128]).all()
    assert (kept.parameters["mass"] == result.parameters["mass"][:128]).all()


@pytest.mark.usefixtures("small_blocks")
def test_a_checkpoint_goes_on_to_the_same_bits(monkeypatch, tmp_path, result):
    path = tmp_path / "runs.npz"
    request = {"rng": 5, "distributions": ROBOT, "checkpoint": path}
    with monkeypatch.context() as patch:
        ends_at(patch, 192, EndsError())
        with pytest.raises(EndsError):
            monte_carlo(SCENARIO, CONTROLLER, 400, **request)
    made = []
    block = runs.Analysis.block
    monkeypatch.setattr(
        runs.Analysis, "block", lambda self, at, *rest: made.append(at) or block(self, at, *rest)
    )
    again = monte_carlo(SCENARIO, CONTROLLER, 400, **request)
    assert made[0] == 192
    assert (again.costs == result.costs[:400]).all()
    with pytest.raises(ValueError, match="is of other runs"):
        monte_carlo(SCENARIO, CONTROLLER, 400, **{**request, "rng": 6})
    with pytest.raises(ValueError, match="is of other runs"):
        monte_carlo(CALM, CONTROLLER, 400, **request)
    path.write_bytes(path.read_bytes()[:-900])
    with pytest.raises(ValueError, match="is no checkpoint"):
        monte_carlo(SCENARIO, CONTROLLER, 400, **request)


KILLED = """
import os, signal, sys
from nfopidn import Controller, Scenario, monte_carlo
from nfopidn.montecarlo import Normal, runs
runs.BLOCK, runs.CHECKPOINT_EVERY = 64, -1.0
block = runs.Analysis.block
def ending(self, at, count, workers):
    if at == 256:
        os.kill(os.getpid(), signal.SIGKILL)
    return block(self, at, count, workers)
runs.Analysis.block = ending
monte_carlo(Scenario.published(pose_noise=(0.005, 0.005), rng=0), Controller.recommended(), 400,
            rng=5, distributions={"mass": Normal(11.5, 0.5)}, checkpoint=sys.argv[1])
"""


@pytest.mark.usefixtures("small_blocks")
def test_so_it_does_after_a_kill(tmp_path):
    path = str(tmp_path / "runs.npz")
    done = subprocess.run([sys.executable, "-c", KILLED, path], check=False, timeout=120)
    assert done.returncode == -signal.SIGKILL
    mass = {"mass": ROBOT["mass"]}
    with np.load(path) as stored:
        assert len(stored["rows"]) == 256
    whole = monte_carlo(SCENARIO, CONTROLLER, 400, rng=5, distributions=mass, checkpoint=path)
    assert (
        whole.costs == monte_carlo(SCENARIO, CONTROLLER, 400, rng=5, distributions=mass).costs
    ).all()


# Arrow and Parquet.


def test_columns_have_all(result):
    columns = result.to_columns()
    assert list(columns) == [*ROBOT, "cost"]
    assert all(len(column) == 2000 for column in columns.values())


def test_parquet_without_pyarrow_is_refused(result, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ImportError, match=r"pip install nfopidn\[arrow\]"):
        result.to_parquet(tmp_path / "runs.parquet")
    with pytest.raises(ImportError, match="pyarrow"):
        result.to_arrow()


def test_parquet_has_the_columns(result, tmp_path):
    result.to_parquet(tmp_path / "runs.parquet")
    table = parquet.read_table(tmp_path / "runs.parquet")
    assert table.equals(result.to_arrow())
    for name, column in result.to_columns().items():
        assert (table[name].to_numpy() == column).all()


# Bad input.

MASS = {"mass": Normal(11.5, 0.5)}


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"n": 0}, r"n is 0; must be a whole number in \[1, 1e9\]"),
        ({"n": 2.5}, "n is 2.5"),
        ({"scenario": 3}, "scenarios is 3; must be a Family or Scenarios"),
        ({"controller": "lqr"}, "controller is 'lqr'; must be a Controller or a Rival"),
        ({"controller": CONTROLLER.replace(sample_time=0.1)}, "sample_time"),
        ({"rng": -1}, "rng is -1"),
        ({"rng": 2**53}, "rng is 9007199254740992"),
        ({"workers": 0}, "workers is 0"),
        ({"workers": "all"}, "workers is 'all'; must be a whole number"),
        ({"method": "sobl"}, r"method is 'sobl' \(did you mean 'sobol'\?\)"),
        ({"method": "sobol", "n": 100, "distributions": MASS}, "n is 100; must be a power of 2"),
        ({"method": "sobol", "n": 64}, "distributions is empty"),
        ({"columns": ["energi"]}, r"columns has 'energi' \(did you mean 'energy'\?\)"),
        ({"checkpoint": "no/such/folder/runs.npz"}, "checkpoint no/such/.* cannot be written"),
        ({"columns": "cost"}, "columns is 'cost'; must be a list of names"),
        ({"distributions": [1]}, r"distributions is \[1\]; must be a mapping"),
        (
            {"distributions": {"mas": Normal(1, 1)}},
            r"distributions has 'mas' \(did you mean 'mass'",
        ),
        ({"distributions": {"mass": 11.5}}, r"distributions\['mass'\] is 11.5; must be a Normal"),
        ({"distributions": {"mass": Normal}}, "must be a Normal"),
        ({"distributions": {"mass": Uniform(-1, 1)}}, r"distributions\['mass'\] gives -0.99"),
        ({"distributions": {"delay": Uniform(0, 2)}}, "must be a whole number of samples"),
        ({"distributions": MASS, "covariance": [[1, 0]]}, r"must have a row and a column for each"),
        ({"distributions": MASS, "covariance": [[1.0]]}, "must be the variance of"),
        ({"distributions": MASS, "covariance": "x"}, "covariance must be real numbers"),
    ],
)
def test_bad_arguments_are_refused(arguments, says):
    request = {"scenario": CALM, "controller": CONTROLLER, "n": 10, "rng": 1, **arguments}
    with pytest.raises(ValueError, match=says):
        monte_carlo(**request)


def test_a_covariance_that_is_none_is_refused():
    two = {"mass": Normal(1, 0.1), "inertia": Normal(1, 0.1)}
    for matrix, says in (
        ([[0.01, 0.02], [0.02, 0.01]], "not positive definite"),
        ([[0.01, 0.005], [0.002, 0.01]], "not symmetric"),
        ([[0.01, np.nan], [np.nan, 0.01]], "must be finite"),
    ):
        with pytest.raises(ValueError, match=says):
            monte_carlo(CALM, CONTROLLER, 4, distributions=two, covariance=matrix)


def test_a_draw_out_of_range_names_its_run():
    rare = {"mass": stats.norm(1, 0.3)}
    with pytest.raises(
        ValueError, match=r"distributions\['mass'\] gives -.* in run \d+; must be in"
    ):
        monte_carlo(CALM, Controller.published(), 30000, rng=1, distributions=rare)


def test_what_a_scenario_has_not_is_refused():
    t = np.linspace(0, 6, 60)
    sampled = nfopidn.Trajectory.from_samples(t, np.sin(t), dt=0.2)
    with pytest.raises(ValueError, match="has no scale"):
        monte_carlo(
            Scenario(sampled, rng=0),
            Controller.published(),
            3,
            distributions={"path_scale": Uniform(0.9, 1)},
        )
    pushed = CALM.replace(disturbance=np.zeros((len(CALM.trajectory.t), 2)))
    with pytest.raises(ValueError, match="given by the sample"):
        monte_carlo(pushed, CONTROLLER, 3, distributions={"disturbance_force": Normal(0, 1)})


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Normal(1, 0), "std is 0; must be greater than 0"),
        (lambda: Normal(np.nan, 1), "mean is nan; must be a finite number"),
        (lambda: Uniform(2, 1), "low is 2 and high 1; low must be less than high"),
        (lambda: LogNormal(-1, 1), "median is -1; must be greater than 0"),
        (lambda: LogNormal(1, 0), "sigma is 0"),
        (lambda: Choice([]), "must have at least one value"),
        (lambda: Choice([1, np.inf]), "values must be finite"),
        (lambda: Choice([1, 2], weights=[1]), "must have that of values"),
        (lambda: Choice([1, 2], weights=[0, 0]), "not all 0"),
        (lambda: Choice([1, 2], weights=[2, -1]), "must not be negative"),
    ],
)
def test_bad_distributions_are_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()


@pytest.mark.parametrize(
    ("ask", "says"),
    [
        (lambda r: r.replay(2000), r"run is 2000; must be a whole number in \[0, 1999\]"),
        (lambda r: r.quantiles(2), "shares is 2"),
        (lambda r: r.quantiles(0.5, "energy"), "metric is 'energy'; known here: cost"),
        (lambda r: r.worst(0), "k is 0"),
        (lambda r: r.yield_({}), "at least one metric"),
        (lambda r: r.yield_({"energy": 1}), "limits has 'energy'"),
        (lambda r: r.yield_({"cost": "x"}), r"limits\['cost'\] is 'x'"),
        (lambda r: r.yield_({"cost": (2, 1)}), "low must not be above high"),
        (lambda r: r.yield_({"cost": 1}, confidence=1), "confidence is 1"),
        (lambda r: r.yield_({"cost": 1}, interval="wald"), "interval is 'wald'"),
    ],
)
def test_bad_questions_are_refused(result, ask, says):
    with pytest.raises(ValueError, match=says):
        ask(result)


def test_sensitivity_needs_draws():
    with pytest.raises(ValueError, match="nothing was drawn"):
        monte_carlo(SCENARIO, CONTROLLER, 3, rng=1).sensitivity()
    with pytest.raises(ValueError, match="must be a power of 2"):
        sobol_indices(CALM, CONTROLLER, 100, distributions=MASS)


def test_sobol_points_from_anywhere_are_those_of_the_whole_sequence():
    """SciPy's own way to skip points fails where they have more than 32 bits."""
    draws = Draws(
        {"mass": Normal(11.5, 0.5), "inertia": Normal(0.6, 0.05), "start_x": Uniform(0, 1)},
        **{"n": 512, "seed": 4, "method": "sobol", "covariance": None},
    )
    engine = stats.qmc.Sobol(3, bits=53, rng=np.random.default_rng(4))
    shares = engine.random(512)
    whole = np.column_stack(
        [
            stats.norm(11.5, 0.5).ppf(shares[:, 0]),
            stats.norm(0.6, 0.05).ppf(shares[:, 1]),
            shares[:, 2],
        ]
    )
    for first, count in ((0, 512), (0, 3), (1, 1), (2, 5), (3, 64), (255, 3), (256, 256), (511, 1)):
        own = draws.values(first, count)
        np.testing.assert_allclose(own, whole[first : first + count], rtol=1e-12)
        assert (own == draws.values(0, 512)[first : first + count]).all()


def test_sobol_runs_go_beyond_a_block(monkeypatch):
    request = {"rng": 5, "distributions": ROBOT, "method": "sobol"}
    one = monte_carlo(SCENARIO, CONTROLLER, 256, **request)
    monkeypatch.setattr(runs, "BLOCK", 100)
    assert (monte_carlo(SCENARIO, CONTROLLER, 256, **request).costs == one.costs).all()
