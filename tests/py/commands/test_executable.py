"""The executable: its summary, its JSON, its files, and that it runs what Python runs."""

import json
import re

import every_field
import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Scenario, Trajectory

DIVERGING = ["--frame", "world"]


def as_json(result):
    return result.metrics | {"samples": len(result), "diverged_at": result.diverged_at}


def test_published_summary(sim, golden_costs):
    run = sim("--traj", "ranunculoid")
    assert (run.returncode, run.stderr) == (0, "")
    lines = run.stdout.splitlines()
    assert lines[0] == "ranunculoid, 751 samples, 0.2 s apart, heading forward"
    figures = {line.split()[0]: line.split()[1:] for line in lines[2 : lines.index("", 2)]}
    cost = golden_costs["E_published_M5"]
    assert float(figures["cost"][0]) == pytest.approx(cost, rel=1e-5)
    assert float(figures["pose_mse"][0]) == pytest.approx(0.0796848, rel=1e-5)
    assert figures["torque_peak"][1:3] == ["N", "m"]
    assert set(figures) == set(nfopidn.simulate().metrics)
    assert sim().stdout == run.stdout


def test_version(sim):
    run = sim("--version")
    assert (run.returncode, run.stdout) == (0, f"nfopidn_sim {nfopidn.__version__}\n")


def test_json_is_the_metrics_to_the_last_bit(sim, published):
    run = sim("--json")
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.count("\n") == 1
    assert json.loads(run.stdout) == as_json(published)
    assert repr(published.cost) in run.stdout


@pytest.mark.parametrize("arguments", [[], DIVERGING], ids=["published", "diverging"])
def test_out_is_python_s_csv_byte_for_byte(arguments, sim, tmp_path):
    run = sim(*arguments, "--quiet", "--out", tmp_path / "run.csv")
    assert (run.returncode, run.stdout, run.stderr) == (3 if arguments else 0, "", "")
    frame = "world" if arguments else "robot"
    result = nfopidn.simulate(controller=Controller.published(frame=frame))
    result.to_csv(tmp_path / "python.csv")
    written = (tmp_path / "run.csv").read_bytes()
    assert written == (tmp_path / "python.csv").read_bytes()
    assert written.count(b"\n") == len(result) + 1
    assert sorted(file.name for file in tmp_path.iterdir()) == ["python.csv", "run.csv"]


def test_out_is_the_golden_run(sim, golden_run, tmp_path):
    sim("--quiet", "--out", tmp_path / "run.csv")
    table = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1).T
    for column, (name, expected) in zip(table, golden_run.items(), strict=True):
        np.testing.assert_allclose(column, expected, rtol=0, atol=1e-9, err_msg=name)


def test_every_field_goes_through_files_both_ways(sim, tmp_path):
    names = [tmp_path / name for name in ("s.json", "c.json", "s2.json", "c2.json")]
    every_field.SCENARIO.save(names[0])
    every_field.CONTROLLER.save(names[1])
    run = sim(
        *["--scenario", names[0], "--controller", names[1], "--json"],
        *["--save-scenario", names[2], "--save-controller", names[3]],
    )
    result = nfopidn.simulate(every_field.SCENARIO, every_field.CONTROLLER)
    assert len(result) == 60
    assert json.loads(run.stdout) == as_json(result)
    assert names[2].read_bytes() == names[0].read_bytes()
    assert names[3].read_bytes() == names[1].read_bytes()
    assert Scenario.load(names[2]) == every_field.SCENARIO
    assert Controller.load(names[3]) == every_field.CONTROLLER


def test_saved_defaults_are_the_published_ones(sim, tmp_path):
    files = [tmp_path / "scenario.json", tmp_path / "controller.json"]
    sim("--save-scenario", files[0], "--save-controller", files[1], "--quiet")
    assert Scenario.load(files[0]) == Scenario.published(rng=0)
    assert Controller.load(files[1]) == Controller.published()


@pytest.mark.parametrize("heading", ["forward", "continuous"])
def test_a_trajectory_from_a_table(heading, sim, tmp_path):
    path = tmp_path / "path.csv"
    x, y = np.linspace(0, 1, 40), np.linspace(0, 0.5, 40) ** 2
    rows = [f"{a!r},{b!r}" for a, b in zip(x.tolist(), y.tolist(), strict=True)]
    path.write_text("\n".join(["x,y", *rows]))
    expected = Scenario(Trajectory.from_samples(x, y, 0.25, heading=heading), rng=0)
    run = sim("--traj", path, "--dt", "0.25", "--heading", heading, "--json")
    assert json.loads(run.stdout) == as_json(nfopidn.simulate(expected))
    summary = sim("--traj", path, "--dt", "0.25", "--heading", heading).stdout
    assert summary.startswith(f"samples, 40 samples, 0.25 s apart, heading {heading}\n")


def test_a_named_path_starts_at_its_reference(sim):
    run = sim("--traj", "lemniscate", "--json")
    expected = nfopidn.simulate(Scenario(Trajectory.lemniscate(), rng=0))
    assert json.loads(run.stdout) == as_json(expected)


def test_a_disturbance_from_a_table(sim, tmp_path):
    pairs = np.random.default_rng(1).normal(size=(751, 2)) / 3
    path = tmp_path / "wind.csv"
    np.savetxt(path, pairs[:, ::-1], delimiter=",", header="moment,force", comments="", fmt="%.17g")
    run = sim("--disturbance", path, "--json")
    expected = nfopidn.simulate(Scenario.published(disturbance=pairs, rng=0))
    assert json.loads(run.stdout) == as_json(expected)


def test_a_diverging_run(sim, tmp_path):
    out = tmp_path / "run.csv"
    run = sim(*DIVERGING, "--out", out)
    assert run.returncode == 3
    assert "The run diverged at 37.4 s" in run.stdout
    times = np.loadtxt(out, delimiter=",", skiprows=1)[:, 0]
    assert len(times) == 187
    assert times[-1] == pytest.approx(37.2)
    run = sim(*DIVERGING, "--json")
    assert run.returncode == 3
    figures = json.loads(run.stdout)
    assert (figures["diverged_at"], figures["samples"]) == (pytest.approx(37.4), 187)


def test_quiet_and_json(sim):
    assert sim("--quiet").stdout == ""
    assert sim("--quiet", *DIVERGING).stdout == ""
    assert sim("--quiet", "--json").stdout == sim("--json").stdout


@pytest.mark.parametrize("option", ["--out", "--save-scenario", "--save-controller"])
def test_devices_can_be_written(option, sim, tmp_path):
    plain = tmp_path / "plain"
    assert sim(option, plain, "--quiet").returncode == 0
    run = sim(option, "/dev/stdout", "--quiet")
    assert (run.returncode, run.stdout) == (0, plain.read_text())
    run = sim(option, "/dev/null", "--quiet")
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    both = sim(option, "/dev/stdout", "--json")
    assert both.stdout == plain.read_text() + sim("--json").stdout


@pytest.mark.parametrize("name", ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1", "link"])
@pytest.mark.parametrize("mode", ["a", "w"])
def test_an_open_file_is_written_on(name, mode, sim, tmp_path):
    """As by a shell's >> and >."""
    log = tmp_path / "log"
    log.write_text("before\n")
    (tmp_path / "link").symlink_to("/dev/stdout")
    with log.open(mode) as stream:
        run = sim("--out", name, "--json", capture_output=False, stdout=stream, cwd=tmp_path)
    assert run.returncode == 0
    assert sim("--out", tmp_path / "plain", "--quiet").returncode == 0
    kept = "before\n" if mode == "a" else ""
    assert log.read_text() == kept + (tmp_path / "plain").read_text() + sim("--json").stdout
    assert sorted(path.name for path in tmp_path.iterdir()) == ["link", "log", "plain"]


def test_scenarios_and_tables_can_be_read_from_a_pipe(sim, tmp_path):
    Controller.published(3).save(tmp_path / "controller.json")
    document = (tmp_path / "controller.json").read_text()
    run = sim("--controller", "/dev/stdin", "--json", input=document)
    assert json.loads(run.stdout) == as_json(nfopidn.simulate(controller=Controller.published(3)))


def test_an_old_file_is_replaced(sim, tmp_path):
    out = tmp_path / "run.csv"
    out.write_text("old\n" * 1_000_000)
    sim("--out", out, "--quiet")
    assert re.match(r"t,x_ref,", out.read_text())
    assert "old" not in out.read_text()
