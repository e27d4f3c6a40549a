"""nfopidn.study.reproduce and `nfopidn study`: the files, and whose numbers they hold."""

import csv
import json
import sys
import xml.etree.ElementTree as Xml

import nfopidn
import numpy as np
import pytest
from matplotlib.figure import Figure
from nfopidn import Controller, Scenario, Trajectory, commands, simulate
from nfopidn.fractional import to_discrete
from nfopidn.study import cases, files, poses, reproduce, reproduction
from nfopidn.study.memory import _summary
from nominal import tune

SEEDS = 1
MEMORIES = range(1, 9)

FIGURES = {
    "fig03_z_plane",
    "fig05_path",
    "fig06_orientation",
    "fig07_feedforward_torque",
    "fig08_feedback_torque",
    "fig09_total_torque",
    "fig10_wheel_action",
    "fig11_velocities",
    "fig12_cost_by_memory",
    "fig13_orders_by_memory",
    "optimum",
    "poses",
}
TABLES = {
    "claims",
    "memory_published",
    "memory_tuned",
    "memory_tuned_seeds",
    "optima",
    "optima_guesses",
    "poses",
    "readings",
    "run_optimum",
    "run_published",
    "run_tuned",
    "steady_state",
    "table2_continuous_gains",
    "table3_discrete_gains",
}


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """The folder that one small study has written."""
    folder = tmp_path_factory.mktemp("work") / "made" / "study"
    files = reproduce(folder, seeds=SEEDS)
    assert sorted(folder.iterdir()) == sorted(files)
    return folder


@pytest.fixture(scope="module")
def gains():
    return {"published": Controller.published(), "tuned": tune(rng=1).controller}


def rows(study, name):
    with (study / f"{name}.csv").open() as lines:
        return list(csv.DictReader(lines))


def number(text):
    return float(text) if text else None


# The files


def test_every_file_is_there(study):
    names = {path.name for path in study.iterdir()}
    figures = {f"{name}.{kind}" for name in FIGURES for kind in ("png", "svg")}
    tables = {f"{name}.{kind}" for name in TABLES for kind in ("csv", "json")}
    assert names == figures | tables | {"README.md"}


def test_the_index_names_every_figure_and_table(study):
    text = (study / "README.md").read_text()
    for name in FIGURES:
        assert f"[{name}]({name}.png)" in text
    for name in TABLES:
        assert f"[{name}]({name}.csv)" in text


def test_pictures_are_pictures(study):
    for name in FIGURES:
        assert (study / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert Xml.parse(study / f"{name}.svg").getroot().tag.endswith("svg")


def test_the_folder_is_small(study):
    assert sum(path.stat().st_size for path in study.iterdir()) < 3.1e6


def test_json_and_csv_have_the_same_numbers(study):
    for name in TABLES:
        document = json.loads((study / f"{name}.json").read_text())
        table = rows(study, name)
        assert document["title"]
        assert list(document["columns"]) == list(table[0])
        assert set(document["units"]) <= set(table[0])
        for column, values in document["columns"].items():
            texts = ["" if value is None else str(value) for value in values]
            assert texts == [row[column] for row in table], (name, column)


def test_the_same_figure_gives_the_same_bytes(tmp_path):
    made = []
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        figure = Figure(figsize=(3, 2))
        figure.subplots().plot([0, 1], [1, 0], "o-", label="line")
        files.Folder(tmp_path / name).figure("figure", "a figure", figure)
        made.append([(tmp_path / name / f"figure.{kind}").read_bytes() for kind in ("png", "svg")])
    assert made[0] == made[1]
    assert b"dc:date" not in made[0][1]


def test_a_file_that_fails_leaves_the_old_one(tmp_path):
    folder = files.make_folder(tmp_path)
    (tmp_path / "figure.png").write_text("old")
    with pytest.raises(AttributeError):
        folder.figure("figure", "a figure", None)
    assert [path.name for path in tmp_path.iterdir()] == ["figure.png"]
    assert (tmp_path / "figure.png").read_text() == "old"


def test_a_folder_of_something_else_is_left_alone(tmp_path):
    (tmp_path / "README.md.test").write_text("mine")
    files.make_folder(tmp_path).index("a study")
    files.make_folder(tmp_path)  # once more
    (tmp_path / "README.md").write_text("mine")
    with pytest.raises(ValueError, match=r"README.md: is not of a study"):
        files.make_folder(tmp_path)
    assert [path.read_text() for path in tmp_path.iterdir()] == ["mine", "mine"]
    (tmp_path / "README.md").unlink()
    (tmp_path / "README.md").symlink_to("/dev/zero")  # has no end
    with pytest.raises(ValueError, match=r"README.md: is not of a study"):
        files.make_folder(tmp_path)


def test_numbers_that_are_not_finite_are_nothing(tmp_path):
    folder = files.make_folder(tmp_path)
    folder.table("t", "a table", {"a": [np.nan, 1.0, None], "b, c": ["x, y", np.int64(2), "z"]}, {})
    assert (tmp_path / "t.csv").read_text() == 'a,"b, c"\n,"x, y"\n1.0,2\n,z\n'
    assert json.loads((tmp_path / "t.json").read_text())["columns"]["a"] == [None, 1.0, None]
    with pytest.raises(TypeError, match="a cell is a list"):
        folder.table("t", "a table", {"a": [[1]]}, {})


# The numbers


@pytest.mark.parametrize("name", ["published", "tuned"])
def test_runs_are_those_of_simulate(study, gains, name):
    run = simulate(Scenario.published(rng=0), gains[name])
    table = rows(study, f"run_{name}")
    assert list(table[0]) == list(run.columns)
    for column, values in run.columns.items():
        written = [float(row[column]) for row in table]
        assert np.allclose(written, values, rtol=1e-7, atol=1e-12), column


def test_fixed_gains_have_the_golden_costs(study, golden_costs):
    costs = {row["memory"]: float(row["cost"]) for row in rows(study, "memory_published")}
    assert costs == pytest.approx(golden_costs["E_by_memory"], rel=1e-9)
    assert min(costs, key=costs.get) == "5"


def test_tuned_costs_are_those_of_tune(study):
    for row, memory in zip(rows(study, "memory_tuned_seeds"), MEMORIES, strict=True):
        found = tune(structure={"memory": memory}, rng=1)
        values = dict(zip(found.parameters, found.x, strict=True))
        assert (int(row["memory"]), int(row["seed"])) == (memory, 1)
        wanted = [found.fun, values["alpha"], values["sigma"]]
        assert [float(row[key]) for key in ("cost", "alpha", "sigma")] == wanted


def test_medians_are_those_of_the_seeds():
    costs = np.random.default_rng(3).random((8, 5))
    table = np.stack([costs, 10 * costs, 100 * costs], axis=2)
    summary = _summary(table)
    assert np.allclose(summary["median"], np.median(costs, axis=1))
    assert np.allclose(summary["alpha_of_median_run"], 10 * np.median(costs, axis=1))
    assert np.allclose(summary["sigma_of_median_run"], 100 * np.median(costs, axis=1))
    assert np.allclose(summary["lower_quartile"], np.quantile(costs, 0.25, axis=1))
    chosen = costs[np.arange(8), summary["seed_of_median_run"] - 1]
    assert np.allclose(chosen, summary["median"])


def test_table_2_leads_to_table_3_by_eq_25(study):
    table2, table3 = (
        rows(study, name) for name in ("table2_continuous_gains", "table3_discrete_gains")
    )
    continuous = [[float(row[key]) for key in ("Kp", "Ki", "Kd")] for row in table2]
    printed = [[float(row[key]) for key in ("kp", "ki", "kd")] for row in table3]
    assert np.array_equal(printed, Controller.published().gains)
    assert np.allclose(to_discrete(continuous, 0.1078, 0.8161, 0.2), printed, rtol=1e-12)
    assert "computed" in json.loads((study / "table2_continuous_gains.json").read_text())["title"]


def test_readings_are_those_of_simulate(study):
    table = rows(study, "readings")
    assert len(table) == 24
    for row in table:
        scenario = Scenario.published(rng=0, period=float(row["lap"]), heading=row["heading"])
        for lateral in ("plain", "direction") if row["lateral"] == "any" else (row["lateral"],):
            run = simulate(
                scenario,
                Controller.published(frame=row["frame"], form=row["form"], lateral=lateral),
            )
            assert run.cost == float(row["cost"])
            assert run.diverged_at == number(row["diverged_at"])
        assert row["outcome"] == ("completes" if run.diverged_at is None else "diverges")
    completes = [row for row in table if row["outcome"] == "completes"]
    assert {(row["lap"], row["frame"], row["form"]) for row in completes} == {
        ("150.0", "robot", "positional")
    }


def test_poses_are_those_of_simulate(study, gains):
    table = rows(study, "poses")
    assert len(table) == 2 * 17
    start = Scenario.published(rng=0).reference[0]
    for row in table:
        pose = [float(row[name]) for name in ("x", "y", "theta")]
        if row["direction"] == "paper":
            assert pose == [4.0, 0.0, 1.0472]
        else:
            away = np.hypot(pose[0] - start[0], pose[1] - start[1])
            assert away == pytest.approx(0.5)
        run = simulate(Scenario.published(rng=0, initial_pose=pose), gains[row["gains"]])
        assert run.cost == float(row["cost"])
        error = np.hypot(run.columns["e_x"], run.columns["e_y"])
        beyond = run.t[error > 0.05]
        settled = number(row["settled_at"])
        if row["outcome"] == "settles":
            assert settled == pytest.approx(beyond[-1])
            assert settled < 150
        elif row["outcome"] == "diverges":
            assert settled is None
            assert run.diverged_at is not None
        else:
            assert row["outcome"] == "never settles"
            assert settled is None
            assert error[-1] > 0.05


def test_a_run_on_its_path_settles_at_once_and_a_lost_one_diverges(scenario, controller):
    line = Scenario(Trajectory.line(period=60), initial_velocity="reference", rng=0)
    assert poses.settled_at(simulate(line, controller)) == 0.0
    lost = simulate(scenario, controller.replace(form="incremental"))
    assert poses.settled_at(lost) is None
    assert poses._outcome(lost) == "diverges"


def test_claims_are_those_of_the_run(study, published, golden_costs):
    table = {row["figure"]: row for row in rows(study, "claims")}
    value = {name: float(row["published"]) for name, row in table.items()}
    peak = golden_costs["peak"]
    assert value["cost E"] == pytest.approx(golden_costs["E_published_M5"], rel=1e-9)
    assert value["largest torque"] == pytest.approx(peak["abs_tau"], rel=1e-9)
    assert value["largest speed"] == pytest.approx(peak["abs_v"], rel=1e-9)
    assert value["largest turn rate"] == pytest.approx(peak["abs_omega"], rel=1e-9)
    assert value["largest reference speed"] == pytest.approx(peak["v_ref"], rel=1e-9)
    assert float(table["largest torque"]["published_at"]) == pytest.approx(50.2)
    energy = published.metrics["energy"]
    assert value["mean power of both wheels"] == pytest.approx(energy / 150.2)
    assert table["largest torque"]["unit"] == "N m"


def test_feedforward_alone_leaves_the_path(study):
    errors = {row["case"]: float(row["mean_error"]) for row in rows(study, "steady_state")}
    assert errors["feedforward alone"] > 0.3
    assert 0.05 < errors["feedforward and feedback"] < 0.1
    assert errors["both, held back by 1 N"] > 1.5 * errors["feedforward and feedback"]


def test_the_optima_are_below_every_run(study):
    table = rows(study, "optima")
    best = [float(row["optimum"]) for row in table]
    assert best == pytest.approx([0.014163, 0.013464, 0.045384], abs=1e-6)
    assert all(
        float(row["published_gains"]) > value for row, value in zip(table, best, strict=True)
    )
    (run,) = {row["t"] for row in rows(study, "run_optimum")[-1:]}
    assert run == "150.0"


# The command


@pytest.fixture
def command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    def run(*words):
        try:
            code = commands.main(["study", *map(str, words)])
        except SystemExit as end:  # of argparse
            code = end.code
        return (code, *capsys.readouterr())

    return run


def test_the_command_hands_its_options_on(command, monkeypatch, tmp_path):
    asked = []

    def instead(directory, **options):
        asked.append((directory, options))
        return [tmp_path / "one"]

    monkeypatch.setattr(reproduction, "reproduce", instead)
    assert command("-o", "docs", "--seeds", "3", "--workers", "-1") == (
        0,
        "1 files written: docs\n",
        "",
    )
    assert command("--quiet") == (0, "", "")
    assert asked == [
        ("docs", {"seeds": 3, "workers": -1, "progress": False}),
        ("study", {"seeds": 25, "workers": 1, "progress": False}),
    ]


@pytest.mark.parametrize("seeds", [0, -1])
def test_the_command_refuses_bad_seeds(command, tmp_path, seeds):
    code, out, error = command("--seeds", seeds)
    assert (code, out) == (2, "")
    assert error == f"nfopidn: seeds is {seeds}; must be a whole number in [1, 1e9]\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("seeds", [1.5, True, "3", np.nan])
def test_bad_seeds_are_refused(tmp_path, seeds):
    with pytest.raises(ValueError, match="seeds is"):
        reproduce(tmp_path, seeds=seeds)


def test_a_folder_that_cannot_be_made_is_refused(command, tmp_path):
    (tmp_path / "file").write_text("")
    code, _, error = command("-o", "file")
    assert code == 2
    assert "file" in error


def test_a_missing_extra_is_named_before_any_work(command, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "casadi", None)
    code, _, error = command("-o", "out")
    assert code == 2
    assert error.endswith("pip install 'nfopidn[optimum]'\n")
    assert error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_ctrl_c_during_a_search_ends_the_command(command, monkeypatch):
    def interrupted(*_, **options):
        return nfopidn.OptimizeResult(message=cases.MESSAGES["interrupted"])

    monkeypatch.setattr(cases, "tune", interrupted)
    code, out, error = command("-o", "out")
    assert (code, out, error) == (130, "", "nfopidn: interrupted\n")
