"""compare(): what it measures, how it ranks, what it prints and writes."""

import copy
import csv
import sys
import threading
from contextlib import nullcontext

import nfopidn
import nominal
import numpy as np
import pytest
from nfopidn import Controller, Rival, Scenario, commands
from nfopidn.comparison import (
    CONDITIONS,
    CONTENDERS,
    GROUPS,
    METRICS,
    contenders,
    path_names,
    suite_names,
)
from nfopidn.comparison.ranking import _holm, fewest_runs, rank
from nfopidn.files import save_picture
from scipy.stats import wilcoxon

SHORT = {"period": 100.0}


@pytest.fixture(scope="module")
def small():
    """Two controllers, one of them as three, on two scenarios."""
    samson = [Rival("samson"), Rival("samson", k_x=0.9), Rival("samson", k_x=0.5)]
    scenarios = {
        "calm": Scenario.published(rng=0, **SHORT),
        "noisy": Scenario.published(rng=0, pose_noise=(0.01, 0.01), **SHORT),
    }
    controllers = {"samson": samson, "ours": Controller.tuned_nominal()}
    return samson, scenarios, nfopidn.compare(controllers, scenarios, seeds=2)


def test_every_figure_is_that_of_a_run(small):
    samson, scenarios, result = small
    assert result.controllers == ("samson", "ours")
    assert result.scenarios == ("calm", "noisy")
    assert result.values["cost"].shape == (2, 2, 6)
    for member, rival in enumerate(samson):
        for seed in range(2):
            run = nfopidn.simulate(scenarios["noisy"].replace(rng=seed), rival)
            place = (0, 1, 2 * member + seed)
            for name in ("cost", "position_rms", "position_max", "heading_rms", "torque_peak"):
                assert result.values[name][place] == run.metrics[name]
            assert result.values["torque_variation"][place] == run.metrics["torque_variation"]
            assert result.values["share_at_limit"][place] == run.metrics["share_at_limit"]
    # Without noise the draws are one.
    calm = result.values["cost"][0, 0]
    np.testing.assert_array_equal(calm[::2], calm[1::2])
    assert len(set(calm)) == 3
    assert len(set(result.values["cost"][1, 1])) == 2
    assert result.first_runs["samson", "noisy"].controller == samson[0]


def test_settling_and_torque_deviation_are_what_they_say(small):
    _, _, result = small
    run = result.first_runs["samson", "calm"]
    c = run.columns
    distance = np.hypot(c["x_ref"] - c["x"], c["y_ref"] - c["y"])
    settled = result.values["settling_time"][0, 0, 0]
    if np.isfinite(settled):
        assert (distance[run.t > settled] <= 0.05).all()
        assert distance[run.t == settled][0] > 0.05
    else:
        assert distance[-1] > 0.05
    squares = (c["tau_ref_left"] - c["tau_left"]) ** 2 + (c["tau_ref_right"] - c["tau_right"]) ** 2
    expected = np.sqrt(np.mean(squares))
    assert result.values["torque_deviation"][0, 0, 0] == pytest.approx(expected, rel=1e-12)


def test_a_run_that_diverges_never_settles_and_is_told(tmp_path):
    result = nfopidn.compare(
        {"fast": Controller.published()}, {"25 s": Scenario.published(period=25.0)}
    )
    assert result.values["diverged"][0, 0, 0] == 1
    assert np.isinf(result.values["settling_time"][0, 0, 0])
    assert "diverges" in result.to_markdown()


def test_the_result_does_not_depend_on_threads(small):
    samson, scenarios, result = small
    controllers = {"samson": samson, "ours": Controller.tuned_nominal()}
    again = nfopidn.compare(controllers, scenarios, seeds=2, workers=2)
    for name in METRICS:
        np.testing.assert_array_equal(again.values[name], result.values[name])


def test_a_list_names_itself():
    result = nfopidn.compare(
        [Controller.published(), Rival("lqr")], {"short": Scenario.published(**SHORT)}
    )
    assert result.controllers == ("1 NFOPIDN", "2 lqr")


def test_holms_correction_keeps_the_order_and_stays_a_probability():
    # By hand: 0.005 x 4, 0.01 x 3, 0.03 x 2, and 0.04 x 1, which is less than the one before.
    found = _holm([0.01, 0.04, 0.03, 0.005])
    assert found == pytest.approx([0.03, 0.06, 0.06, 0.02], rel=1e-14)
    assert _holm([0.9, 0.6]) == [1.0, 1.0]
    assert _holm([]) == []


def test_the_ranking_is_wilcoxons_with_holms_correction():
    rng = np.random.default_rng(0)
    base = rng.uniform(1, 2, 12)
    costs = np.array([base + 0.3, base, base + rng.normal(0.01, 0.1, 12)])
    ranking = rank(["behind", "best", "level"], costs)
    assert set(ranking.names[:2]) == {"best", "level"}
    order = ["behind", "best", "level"]
    first = costs[order.index(ranking.names[0])]
    raw = {name: wilcoxon(costs[order.index(name)], first).pvalue for name in ranking.names[1:]}
    found = dict(zip(ranking.names, ranking.p, strict=True))
    assert found["behind"] == pytest.approx(2 * raw["behind"])
    assert found[ranking.names[1]] == pytest.approx(max(raw[ranking.names[1]], 2 * raw["behind"]))
    assert ranking.winner is None
    assert ranking.level() == list(ranking.names[:2])
    clear = rank(["a", "b"], np.array([base, base + 0.1]))
    assert clear.winner == "a"
    assert clear.level() == ["a"]
    assert rank(["a", "b"], np.array([base, base])).winner is None


def test_the_same_two_runs_are_not_two_draws():
    costs = np.array([np.full(12, 1.0), np.full(12, 2.0)])
    once = rank(["a", "b"], costs, np.zeros((2, 12), dtype=np.int64))
    assert once.winner is None
    assert "1 runs of a pair" in once.reason
    assert rank(["a", "b"], costs, np.array([np.zeros(12), np.arange(12)], dtype=int)).winner == "a"


def test_too_few_runs_have_no_winner():
    costs = np.arange(10.0).reshape(2, 5)
    ranking = rank(["a", "b"], costs)
    assert ranking.winner is None
    assert "at least 6" in ranking.reason
    assert fewest_runs(2) == 6
    assert fewest_runs(17) == 10
    for controllers in (2, 5, 17):
        runs = fewest_runs(controllers)
        assert 2 * 0.5**runs * (controllers - 1) < 0.05 <= 4 * 0.5**runs * (controllers - 1)


def test_every_scenario_of_the_suite_runs():
    suite = nfopidn.scenario_suite()
    assert list(suite) == suite_names()
    assert len(suite) == len(path_names()) + len(CONDITIONS)
    base = nfopidn.simulate(suite["published"], Rival("lqr")).cost
    assert base == nfopidn.simulate(None, Rival("lqr")).cost
    for name in CONDITIONS:
        assert nfopidn.simulate(suite[f"published/{name}"], Rival("lqr")).cost != base, name
    for name in path_names():
        peak = np.abs(suite[name].trajectory.v).max()
        assert 0.15 < peak < (1.1 if name.endswith("fast") else 0.5), (name, peak)
        assert nfopidn.simulate(suite[name], Rival("lqr")).diverged_at is None, name


def test_conditions_are_what_they_are_called():
    suite = nfopidn.scenario_suite([f"published/{name}" for name in CONDITIONS])
    robots = {name: scenario.robot for name, scenario in suite.items()}
    assert robots["published/mass+20%"].mass == pytest.approx(13.8)
    assert robots["published/mass-20%"].mass == pytest.approx(9.2)
    assert robots["published/track-0.39"].track_width == pytest.approx(0.39)
    assert robots["published/inertia-0.294"].inertia == pytest.approx(0.294)
    assert suite["published/delay"].delay == 1
    assert suite["published/coulomb"].coulomb_friction > 0
    assert nfopidn.scenario_suite(["eight/delay"])["eight/delay"].delay == 1


@pytest.mark.parametrize("name", CONTENDERS)
def test_every_contender_can_be_tuned(name):
    scenario = Scenario.published(**SHORT)
    found = nfopidn.tune_contenders([name], scenario, seeds=2, maxfev=40)[name]
    assert len(found) == (1 if CONTENDERS[name].fixed else 2)
    again = nfopidn.tune_contenders([name], scenario, seeds=2, maxfev=40, workers=2)[name]
    assert again == found
    if name in ("PID", "NPID neural"):
        assert (found[0].alpha, found[0].sigma, found[0].generator) == (1, 1, "gl")
        assert found[0].form == "incremental"
    if name.endswith("pose only"):
        assert found[0].speeds == "differenced"


def test_groups_have_members_that_exist():
    for members in GROUPS.values():
        assert set(members) <= set(CONTENDERS)


REFUSED = [
    (lambda: nfopidn.compare({}), "controllers is empty"),
    (lambda: nfopidn.compare({"a": 3.0}), "'a' must be"),
    (lambda: nfopidn.compare({"a": []}), "'a' must be"),
    (lambda: nfopidn.compare({"a": [Rival("lqr")] * 2, "b": [Rival("lqr")] * 3}), "one length"),
    (lambda: nfopidn.compare([Rival("lqr")], ["nowhere"]), "unknown path; known: published"),
    (lambda: nfopidn.compare([Rival("lqr")], ["eight/fog"]), "unknown condition; known: mass"),
    (lambda: nfopidn.compare([Rival("lqr")], {}), "at least one"),
    (lambda: nfopidn.compare([Rival("lqr")], "eight"), "scenarios is 'eight'; must be a list"),
    (lambda: nfopidn.compare([Rival("lqr")], Scenario.published()), "must be a list of names"),
    (lambda: nfopidn.compare([Rival("lqr")], [Scenario.published()]), "scenarios has .*Scenario"),
    (lambda: nfopidn.tune_contenders("all", Scenario.published()), "controllers is 'all'"),
    (lambda: nfopidn.compare([Rival("lqr")], ["eight"], seeds=0), "seeds is 0"),
    (lambda: nfopidn.compare([Rival("lqr")], ["eight"], workers=0), "workers is 0"),
    (lambda: nfopidn.tune_contenders(["bang-bang"], Scenario.published()), "'bang-bang'"),
    (lambda: nfopidn.tune_contenders(["PID"], Scenario.published(), maxfev=0), "maxfev is 0"),
]


@pytest.mark.parametrize(("call", "text"), REFUSED)
def test_bad_input_is_named(call, text):
    with pytest.raises(ValueError, match=text):
        call()


def test_unknown_metric_and_scenario_of_a_result(small):
    _, _, result = small
    with pytest.raises(ValueError, match="metric is 'speed'"):
        result.median("speed")
    with pytest.raises(ValueError, match="metric is 'speed'"):
        result.plot("speed")
    with pytest.raises(ValueError, match="scenario is 'x'"):
        result.ranking("x")


def test_tables_and_file_hold_the_figures(small, tmp_path):
    _, _, result = small
    result.to_csv(tmp_path / "all.csv")
    with (tmp_path / "all.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    assert len(rows) == 2 * 2 * 6
    assert float(rows[7]["cost"]) == result.values["cost"][0, 1, 1]
    assert rows[7]["scenario"] == "noisy"
    text = result.to_markdown("position_rms")
    assert f"{result.median('position_rms')[1, 0]:.4g}" in text
    details = result.details("calm")
    assert "No winner: no test: 3 runs of a pair, at least 6 are needed." in details
    assert all(metric in details for metric in METRICS)


def test_names_stay_within_their_cells(monkeypatch, capsys):
    names = {"a | b": Controller.published(), "c\nd": Controller.tuned_nominal()}
    result = nfopidn.compare(names, {"x|y": Scenario.published(rng=0)})
    for table in (result.to_markdown(), result.details("x|y")):
        lines = [line for line in table.splitlines() if line.startswith("|")]
        assert len(lines) == 4
        assert len({line.count("|") - line.count("\\|") for line in lines}) == 1
        assert "x\\|y" in lines[0]
        assert "a \\| b" in table
        assert "c d" in table
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    result = nfopidn.compare({"[b]": Controller.published()}, {"[red]": Scenario.published(rng=0)})
    result.print()
    printed = capsys.readouterr().out
    assert "[b]" in printed
    assert "[red]" in printed


def test_costs_are_told_as_multiples_of_the_optimum(small):
    _, _, result = small
    with_one = result.with_optima({"calm": 0.02, "noisy": None})
    lines = with_one.to_markdown().splitlines()
    assert [cell.strip() for cell in lines[2].split("|")[1:4]] == [
        "best open loop found",
        "0.02",
        "-",
    ]
    ratio = result.median()[0, 0] / 0.02
    assert f" = {ratio:.3g} x" in lines[3]
    assert " x" not in result.to_markdown()
    assert " x" not in with_one.to_markdown("position_rms")
    for optima, text in (
        ({"elsewhere": 1.0}, "names 'elsewhere'; must be one of calm, noisy"),
        ({"calm": 0.0}, r"optima\['calm'\] is 0.0; must be greater than 0"),
    ):
        with pytest.raises(ValueError, match=text):
            result.with_optima(optima)


def test_the_command_finds_optima_where_there_are_any(tmp_path, monkeypatch, capsys):
    short = Scenario.published(period=15.0, torque_limit=20)
    short.save(tmp_path / "short.json")
    short.replace(integrator="exact").save(tmp_path / "rough.json")
    words = ["--controllers", "samson", "--scenarios", "short.json", "rough.json", "--optimum"]
    words += ["--tune-on", "short.json", "--seeds", "1", "--maxfev", "60"]
    code, out, err = command(tmp_path, monkeypatch, capsys, *words)
    assert code == 0
    cells = [cell.strip() for cell in out.splitlines()[2].split("|")]
    best = nfopidn.study.open_loop_optimum(short).cost
    assert cells[1:4] == ["best open loop found", f"{best:.4g}", "-"]
    assert err.startswith("rough.json: no optimum: ")
    assert "integrator" in err


def test_figures_are_drawn(small):
    _, _, result = small
    ax = result.plot()
    assert [label.get_text() for label in ax.get_yticklabels()]
    assert ax.get_xscale() == "log"
    runs = {name: result.first_runs[name, "calm"] for name in result.controllers}
    ax = nfopidn.plot.paths(runs)
    lines = {line.get_label(): line for line in ax.get_lines()}
    np.testing.assert_array_equal(lines["ours"].get_xdata(), runs["ours"].columns["x"])
    assert ax.get_aspect() == 1
    ax = nfopidn.plot.distances(runs)
    lines = {line.get_label(): line for line in ax.get_lines()}
    columns = runs["ours"].columns
    far = [np.hypot(x, y) for x, y in zip(columns["e_x"], columns["e_y"], strict=True)]
    np.testing.assert_array_equal(lines["ours"].get_ydata(), far)
    assert ax.get_yscale() == "log"


def test_a_pair_that_diverges_is_marked_at_the_edge(small):
    _, _, result = small
    before = len(result.plot().get_lines())
    edge = [line for line in result.plot().get_lines() if line.get_fillstyle() == "none"]
    assert sum(len(line.get_xdata()) for line in edge) == 0
    result = copy.deepcopy(result)
    result.values["diverged"][0, 0] = 1.0
    lines = result.plot().get_lines()
    assert len(lines) == before
    edge = [line for line in lines if line.get_fillstyle() == "none"]
    assert sum(len(line.get_xdata()) for line in edge) == 1
    assert edge[0].get_xdata()[0] == 1.0


def test_runs_that_all_diverge_are_drawn_too(small):
    result = copy.deepcopy(small[2])
    result.values["diverged"][:] = 1.0
    result.values["cost"][:] = np.inf
    lines = result.plot().get_lines()
    edge = [line for line in lines if line.get_fillstyle() == "none"]
    assert sum(len(line.get_xdata()) for line in edge) == 4


def command(tmp_path, monkeypatch, capsys, *words):
    monkeypatch.chdir(tmp_path)
    try:
        code = commands.main(["compare", *words])
    except SystemExit as stop:
        code = stop.code
    printed = capsys.readouterr()
    return code, printed.out, printed.err


def test_the_command_prints_and_writes(tmp_path, monkeypatch, capsys):
    Rival("lqr").save(tmp_path / "own.json")
    Scenario.published(**SHORT).save(tmp_path / "short.json")
    words = ["--controllers", "samson", "published", "own.json", "--scenarios", "short.json"]
    words += ["eight", "--tune-on", "short.json", "--seeds", "2", "--maxfev", "40"]
    words += ["--csv", "all.csv", "--markdown", "all.md", "--plot", "all.png", "--details"]
    code, out, err = command(tmp_path, monkeypatch, capsys, *words)
    assert (code, err) == (0, "")
    assert "| samson" in out
    assert "No winner: no test: 1 runs of a pair, at least 7 are needed." in out
    written = (tmp_path / "all.md").read_text()
    assert [line for line in written.splitlines() if line] == [
        line for line in out.splitlines() if line
    ]
    assert (tmp_path / "all.png").stat().st_size > 5000
    assert len((tmp_path / "all.csv").read_text().splitlines()) == 1 + 3 * 2 * 2


def test_tuning_anew_for_each_scenario(tmp_path, monkeypatch, capsys):
    words = ["--controllers", "samson", "--scenarios", "eight", "line", "--tune-each"]
    words += ["--seeds", "1", "--maxfev", "60", "--csv", "each.csv"]
    assert command(tmp_path, monkeypatch, capsys, *words)[0] == 0
    with (tmp_path / "each.csv").open() as lines:
        costs = {row["scenario"]: float(row["cost"]) for row in csv.DictReader(lines)}
    for name, scenario in nfopidn.scenario_suite(["eight", "line"]).items():
        found = nominal.tune(scenario, structure="samson", rng=0, maxfev=60)
        assert costs[name] == pytest.approx(found.fun, rel=1e-12)  # lanes round otherwise


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--controllers", "nobody"], "controller 'nobody' is not known"),
        (["--scenarios", "nowhere"], "unknown path"),
        (["--scenarios", "missing.json"], "missing.json"),
        (["--controllers", "missing.json"], "missing.json"),
        (["--plot", "all.nothing"], "must end in one of"),
        (["--seeds", "0"], "seeds is 0"),
        (["--tune-each", "--tune-on", "eight"], "--tune-on eight: does not apply"),
    ],
)
def test_the_command_refuses_in_one_line(words, text, tmp_path, monkeypatch, capsys):
    code, out, err = command(tmp_path, monkeypatch, capsys, *words)
    assert (code, out) == (2, "")
    assert text in err
    assert err.count("\n") == 1


@pytest.fixture
def interrupted_at(monkeypatch):
    """Let Ctrl-C come while the search of that number runs."""

    def arm(number):
        event, calls = threading.Event(), []

        def tune(*arguments, callback, **options):
            calls.append(options["structure"])
            if len(calls) == number:
                event.set()
            return nominal.tune(*arguments, callback=callback, **options)

        monkeypatch.setattr(contenders, "wish_to_stop", lambda: nullcontext(event))
        monkeypatch.setattr(contenders, "tune", tune)
        return calls

    return arm


def test_what_was_complete_outlives_an_interruption(interrupted_at, tmp_path, monkeypatch, capsys):
    calls = interrupted_at(4)
    names = ["samson", "lqr", "published", "ramsete"]
    found = nfopidn.tune_contenders(names, Scenario.published(**SHORT), seeds=2, maxfev=60)
    assert list(found) == ["samson", "published"]
    assert len(calls) == 4
    interrupted_at(3)
    words = ["--controllers", "samson", "lqr", "--scenarios", "eight", "line", "--tune-each"]
    words += ["--seeds", "2", "--maxfev", "60"]
    code, out, err = command(tmp_path, monkeypatch, capsys, *words)
    assert code == 130
    assert "| samson" in out
    assert "lqr" not in out
    assert "line" not in out
    assert "interrupted" in err
    interrupted_at(1)
    code, out, err = command(tmp_path, monkeypatch, capsys, *words)
    assert (code, out) == (130, "")


def test_what_can_be_written_is_written(tmp_path, monkeypatch, capsys):
    Rival("samson").save(tmp_path / "samson.json")
    words = ["--controllers", "samson.json", "--scenarios", "published", "--csv", "/dev/full"]
    code, out, err = command(
        tmp_path, monkeypatch, capsys, *words, "--markdown", "t.md", "--plot", "p.png"
    )
    assert (code, err.count("\n")) == (2, 1)
    assert "No space left" in err
    assert "samson" in out
    assert "samson" in (tmp_path / "t.md").read_text()
    assert (tmp_path / "p.png").stat().st_size > 1000
    words = [*words, "--markdown", "/dev/full", "--plot", "p.png"]
    code, out, err = command(tmp_path, monkeypatch, capsys, *words)
    assert (code, err.count("\n"), err.count("/dev/full")) == (2, 1, 2)


def test_an_optimum_without_casadi_is_refused_before_any_work(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "casadi", None)
    words = ["--maxfev", str(10**9), "--optimum", "--csv", "t.csv"]
    code, out, err = command(tmp_path, monkeypatch, capsys, *words)
    assert (code, out) == (2, "")
    assert "pip install 'nfopidn[optimum]'" in err
    assert not list(tmp_path.iterdir())


def test_the_command_refuses_to_write_over_what_it_reads(tmp_path, monkeypatch, capsys):
    Rival("lqr").save(tmp_path / "own.json")
    text = (tmp_path / "own.json").read_text()
    words = ["--controllers", "own.json", "--scenarios", "published", "--seeds", "1"]
    for option in ("--csv", "--markdown"):
        code, out, err = command(tmp_path, monkeypatch, capsys, *words, option, "./own.json")
        assert (code, out) == (2, "")
        assert f"{option} ./own.json: is the file of the input too" in err
    code, _, err = command(tmp_path, monkeypatch, capsys, *words, "--csv", "y", "--markdown", "y")
    assert code == 2
    assert "--markdown y: is the file of --csv too" in err
    assert (tmp_path / "own.json").read_text() == text
    Scenario.published().save(tmp_path / "lap.json")
    words = ["--controllers", "samson", "--tune-on", "lap.json", "--csv", "lap.json"]
    code, _, err = command(tmp_path, monkeypatch, capsys, *words)
    assert code == 2
    assert "--csv lap.json: is the file of the input too" in err


def test_a_picture_is_written_whole_or_not_at_all(small, tmp_path, monkeypatch):
    def fail(self, file, **_):
        file.write(b"half")
        raise OSError("full")

    target = tmp_path / "all.png"
    target.write_text("old")
    figure = small[2].plot().figure
    with monkeypatch.context() as patch:
        patch.setattr(type(figure), "savefig", fail)
        with pytest.raises(OSError, match="full"):
            save_picture(figure, str(target))
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["all.png"]
    target.chmod(0o600)
    save_picture(figure, str(target))
    assert target.read_bytes().startswith(b"\x89PNG")
    assert target.stat().st_mode & 0o777 == 0o600
