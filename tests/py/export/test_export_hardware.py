"""Exported C beside the law: hardware and reference, bit for bit what the library's C++ does."""

import re
import shutil
import subprocess
import warnings

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Robot, Scenario
from nfopidn.commands.entry import main
from test_export import COMPILERS, CONTROLLERS, STRICT, compiled, compiler

SUBJECTS = {"held", "repeated", "start", "wheels", "velocities", "reference", "torques"}
ROBOT = {"mass": 9.5, "inertia": 0.41, "track_width": 0.39, "wheel_radius": 0.081}
FILES = [f"eddie{part}.{kind}" for part in ("", "_hardware", "_reference") for kind in ("h", "c")]


@pytest.fixture(scope="module")
def lap():
    """A lap with cusps in 15 s, that goes forwards and backwards, of another robot than Eddie."""
    return Scenario.published(
        robot=Robot(**ROBOT), period=15.0, dt=0.05, heading="continuous", torque_limit=1.25
    )


def of_any_time(name):
    """Give the taps, which are no others at another sample time: here they are only compared."""
    return CONTROLLERS[name].replace(sample_time=None)


def export(controller, folder, scenario):
    paths = nfopidn.export_c(
        controller,
        folder,
        scenario=scenario,
        name="eddie",
        hardware=True,
        reference=True,
        longest_step=6.0,
    )
    assert [path.name for path in paths] == FILES
    return paths


@pytest.mark.parametrize(
    "name",
    [
        *("published", "tuned", "clamp", "speed", "plain in the world"),
        *("tracking", "speed errors, other allocation", "whole", "whole in the world"),
    ],
)
def test_every_bit_is_the_librarys(name, lap, tmp_path, repository):
    friction = (0.013, 0.11, 0.45) if name == "tuned" else (0.0, 0.0, 0.5)
    lap = lap.replace(friction_feedforward=friction[:2], friction_feedforward_speed=friction[2])
    sources = [path for path in export(of_any_time(name), tmp_path, lap) if path.suffix == ".c"]
    nfopidn.export_cpp(of_any_time(name), tmp_path, scenario=lap, name="law", reference=True)
    for source in sources:
        compiled([compiler("gcc"), *STRICT, "-O2", "-c", source, "-o", source.with_suffix(".o")])
    names = {"mass": "MASS", "inertia": "INERTIA", "track_width": "TRACK", "wheel_radius": "RADIUS"}
    program = tmp_path / "compare"
    compiled(
        [
            *(compiler("g++"), "-std=c++17", "-Wall", "-Wextra", "-Wconversion", "-Wshadow"),
            *("-Werror", "-O1", "-ffp-contract=off", "-I", repository / "cpp/include"),
            *("-I", tmp_path, f"-DSAMPLE_TIME={lap.trajectory.dt}F"),
            *(["-DREADS_TURN_RATE"] if CONTROLLERS[name].net == "speed-errors" else []),
            *(f"-DROBOT_{names[field]}={value}F" for field, value in ROBOT.items()),
            "-DFRICTION=" + ",".join(f"{number}F" for number in friction),
            *(repository / "tests/py/compare_hardware.cpp", *tmp_path.glob("*.o"), "-o", program),
        ]
    )
    done = subprocess.run([program], capture_output=True, text=True, check=True, timeout=60)
    lines = [line.split() for line in done.stdout.splitlines()]
    assert {line[0] for line in lines} == SUBJECTS
    for subject, compared, differ in lines:
        assert int(compared) > 2000, subject
        assert int(differ) == 0, subject


@pytest.mark.parametrize("program", COMPILERS)
@pytest.mark.parametrize("name", CONTROLLERS)
def test_it_compiles_without_a_warning(name, program, lap, tmp_path):
    for source in export(of_any_time(name), tmp_path, lap):
        if source.suffix == ".c":
            target = source.with_suffix(".o")
            command = [compiler(program), *STRICT, *COMPILERS[program], "-Os", "-c", source]
            compiled([*command, "-o", target])
    nm = "arm-none-eabi-nm" if program.startswith("arm") else "nm"
    own = {"eddie_reset", "eddie_reset_in_motion", "eddie_step", "eddie_repeat"}
    own.add("eddie_self_test")
    for file in tmp_path.glob("*.o"):
        undefined = subprocess.run([nm, "-u", file], capture_output=True, text=True, check=True)
        words = set(undefined.stdout.split()[1::2])
        assert words - own <= {"memset", "memcpy", "memmove", "_GLOBAL_OFFSET_TABLE_"}


def test_the_law_alone_is_as_it_was(tmp_path):
    plain = nfopidn.export_c(Controller.published(), tmp_path)
    assert len(plain) == 2
    assert "repeat" not in plain[0].read_text() + plain[1].read_text()


def test_the_table_is_the_scenarios_reference(lap, tmp_path):
    export(Controller.published(), tmp_path, lap)
    rows = [
        [float(word.rstrip("F")) for word in line.strip(" {},").split(", ")]
        for line in (tmp_path / "eddie_reference.c").read_text().splitlines()
        if line.startswith("    {")
    ]
    np.testing.assert_array_equal(
        np.array(rows, np.float32), lap.reference[:, [0, 1, 2, 3, 5, 6, 7]].astype(np.float32)
    )
    assert set(np.array(rows)[:, 6]) == {0.0, 1.0}
    header = (tmp_path / "eddie_reference.h").read_text()
    assert f"EDDIE_REFERENCE_COUNT {len(rows)}\n" in header
    assert f"EDDIE_REFERENCE_LAP {len(rows)} " in header  # it looks the other way then


def test_a_scenario_without_feedforward_has_none_in_its_table(tmp_path):
    scenario = Scenario.published(feedforward=False, period=15.0)
    nfopidn.export_c(Controller.published(), tmp_path, scenario=scenario, reference=True)
    rows = [
        line.strip(" {},").split(", ")
        for line in (tmp_path / "nfopidn_reference.c").read_text().splitlines()
        if line.startswith("    {")
    ]
    assert {tuple(row[4:6]) for row in rows} == {("0.0F", "0.0F")}


@pytest.mark.parametrize("away", [(5e6, -4e6), (9e5, 0.0), (0.0, -8200.0)])
def test_a_far_path_is_counted_from_its_first_sample(away, tmp_path):
    """In single precision its samples would lie on a grid of 1 mm, 6 cm or half a metre."""
    t = np.arange(50) * 0.1
    x, y = away[0] + 0.3 * np.sin(t), away[1] + t
    near = Scenario(nfopidn.Trajectory.from_samples(x - x[0], y - y[0], 0.1))
    far = Scenario(nfopidn.Trajectory.from_samples(x, y, 0.1))
    tables = []
    for scenario, name in ((near, "near"), (far, "far")):
        for exporting, law in ((nfopidn.export_c, name), (nfopidn.export_cpp, f"{name}_law")):
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                exporting(
                    Controller.published(), tmp_path, scenario=scenario, name=law, reference=True
                )
            said = [str(warning.message) for warning in caught]
            assert [__file__] * len(said) == [warning.filename for warning in caught]
            assert len(said) == (name == "far")
            assert all("counted from its first sample" in words for words in said)
        text = (tmp_path / f"{name}_reference.c").read_text()
        rows = re.findall(r"^    \{(.*)\},?$", text, re.MULTILINE)
        tables.append([[float(word.rstrip("F")) for word in row.split(", ")] for row in rows])
    np.testing.assert_allclose(tables[1], tables[0], atol=2e-6)
    assert np.ptp(np.array(tables[1])[:, 1]) == pytest.approx(4.9)
    header = (tmp_path / "far_reference.h").read_text()
    assert f"FAR_REFERENCE_ORIGIN_X {away[0]!r} " in header
    assert "in double precision" in header
    assert "NEAR_REFERENCE_ORIGIN_Y 0.0 " in (tmp_path / "near_reference.h").read_text()
    assert f"reference_origin_y = {away[1]!r};" in (tmp_path / "far_law.hpp").read_text()


@pytest.mark.parametrize(("speed", "far"), [(3e5, "1.47e\\+06"), (1700.0, "8330")])
def test_a_path_too_large_for_floats_is_refused(speed, far, tmp_path):
    t = np.arange(50) * 0.1
    scenario = Scenario(nfopidn.Trajectory.from_samples(speed * t, t, 0.1))
    for export_it in (nfopidn.export_c, nfopidn.export_cpp):
        with pytest.raises(ValueError, match=f"{far} m away from its first sample"):
            export_it(
                Controller.published(), tmp_path, scenario=scenario, name="law", reference=True
            )
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("laps", [2, 400])
def test_many_turns_are_taken_off(laps, tmp_path):
    """Of an angle of thousands of radians a float would tell a thousandth."""
    path = nfopidn.Trajectory.circle(period=4.0, dt=0.1, heading="continuous", laps=laps)
    scenario = Scenario(path)
    nfopidn.export_c(Controller.published(), tmp_path, scenario=scenario, reference=True)
    text = (tmp_path / "nfopidn_reference.c").read_text()
    rows = re.findall(r"^    \{(.*)\},?$", text, re.MULTILINE)
    theta = np.array([float(row.split(", ")[2].rstrip("F")) for row in rows])
    assert theta.max() < 1024
    np.testing.assert_allclose(np.exp(1j * theta), np.exp(1j * path.theta), atol=1e-6)
    header = (tmp_path / "nfopidn_reference.h").read_text()
    assert f"NFOPIDN_REFERENCE_LAP {40 * laps} " in header
    assert "not closed" not in header


def test_an_open_path_says_so(tmp_path):
    t = np.arange(50) * 0.1
    scenario = Scenario(nfopidn.Trajectory.from_samples(t, 0.1 * t**2, 0.1))
    nfopidn.export_c(Controller.published(), tmp_path, scenario=scenario, reference=True)
    header = (tmp_path / "nfopidn_reference.h").read_text()
    assert "NFOPIDN_REFERENCE_LAP 50 " in header
    assert "not closed" in header


@pytest.mark.parametrize(("laps", "closes"), [(1, False), (2, True)])
def test_a_lap_ends_where_the_heading_is_the_first_again(laps, closes, tmp_path):
    """Five half turns of three cusps: after one lap the robot looks the other way."""
    path = nfopidn.Trajectory.ranunculoid(heading="continuous", laps=laps)
    scenario = Scenario(path)
    nfopidn.export_c(Controller.published(), tmp_path, scenario=scenario, reference=True)
    header = (tmp_path / "nfopidn_reference.h").read_text()
    count = len(scenario.reference)
    assert f"NFOPIDN_REFERENCE_LAP {count - closes} " in header
    assert ("not closed" in header) is not closes


def test_the_longest_step_is_ten_times_the_references(lap, tmp_path):
    """And the run of the published gains, which starts beside its path, stays far below it."""
    nfopidn.export_c(Controller.published(), tmp_path, scenario=lap, hardware=True)
    header = (tmp_path / "nfopidn_hardware.h").read_text()
    (line,) = (line for line in header.splitlines() if "define NFOPIDN_LONGEST_STEP" in line)
    found = float(line.split()[2].rstrip("F"))
    v, omega = lap.reference[:, 3], lap.reference[:, 4]
    half = ROBOT["track_width"] / 2
    wheels = np.abs([v - omega * half, v + omega * half])
    assert found == pytest.approx(10 * lap.trajectory.dt * wheels.max(), rel=1e-6)
    published = Scenario.published()
    columns = nfopidn.simulate(published, Controller.published()).columns
    half = published.robot.track_width / 2
    fastest = (np.abs(columns["v"]) + np.abs(columns["omega"]) * half).max()
    v, omega = np.abs(published.reference[:, 3:5]).T
    assert fastest < 5 * (v + omega * half).max()


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan"), float("inf"), 2e6])
def test_a_longest_step_out_of_range_is_refused(bad, lap, tmp_path):
    with pytest.raises(ValueError, match="longest_step"):
        nfopidn.export_c(
            Controller.published(), tmp_path, scenario=lap, hardware=True, longest_step=bad
        )
    with pytest.raises(ValueError, match="without hardware"):
        nfopidn.export_c(Controller.published(), tmp_path, longest_step=1.0)
    assert not list(tmp_path.iterdir())


LIMITS = ("v", "omega", "acceleration", "angular_acceleration")


@pytest.mark.parametrize("place", range(4))
@pytest.mark.parametrize("bad", [-0.6, float("nan"), "1", True, None, -(10**400)])
def test_a_velocity_limit_that_is_none_is_refused(bad, place, lap, tmp_path):
    limits = [0.6, 2.0, 1.0, 6.0]
    limits[place] = bad
    with pytest.raises(ValueError, match=f"velocity_limits has {LIMITS[place]} ") as caught:
        nfopidn.export_c(
            Controller.published(), tmp_path, scenario=lap, hardware=True, velocity_limits=limits
        )
    assert "0 (the base does not move) or more" in str(caught.value)
    for wrong in ([0.6, 2.0, 1.0], 0.6, "0621"):
        with pytest.raises(ValueError, match="must be 4 numbers"):
            nfopidn.export_c(
                Controller.published(), tmp_path, scenario=lap, hardware=True, velocity_limits=wrong
            )
    with pytest.raises(ValueError, match="without hardware"):
        nfopidn.export_c(Controller.published(), tmp_path, velocity_limits=[1, 1, 1, 1])
    assert not list(tmp_path.iterdir())


def test_velocity_limits_are_the_exported_ones(lap, tmp_path, capsys):
    """A limit of 0 lets the base not turn, infinity limits nothing; without any nothing does."""
    files = tmp_path / "controller.json", tmp_path / "scenario.json"
    Controller.published().save(files[0])
    lap.save(files[1])
    command = ["export", str(files[0]), "-o", str(tmp_path / "out"), "--scenario", str(files[1])]
    limits = ["--velocity-limits", "0.5", "0", "inf", "3"]
    assert main([*command, *limits]) == 2
    assert "give --hardware too" in capsys.readouterr().err
    assert main([*command, "--hardware", "--velocity-limits", "-0.5", "0", "1", "1"]) == 2
    assert "velocity_limits has v -0.5; must be" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert main([*command, "--hardware", *limits]) == 0
    (tmp_path / "main.c").write_text(
        """
        #include <stdio.h>
        #include "nfopidn_hardware.h"
        int main(void)
        {
          const nfopidn_velocity_limits limits = NFOPIDN_VELOCITY_LIMITS;
          const nfopidn_torques torques = {3.0F, 1.0F};
          nfopidn_velocity_output output;
          int k;
          printf("%d", nfopidn_velocity_init(&output, &limits));
          for (k = 0; k < 100; ++k) (void)nfopidn_velocity_step(&output, &torques);
          printf(" %g %g", (double)output.velocity.v, (double)output.velocity.omega);
          return 0;
        }
        """
    )
    sources = [tmp_path / "main.c", *(tmp_path / "out").glob("*.c")]
    build = [compiler("gcc"), *STRICT, "-I", tmp_path / "out", *sources, "-o", tmp_path / "program"]
    compiled(build)
    done = subprocess.run([tmp_path / "program"], capture_output=True, text=True, check=True)
    assert done.stdout == "1 0.5 0"
    assert main([*command, "--hardware"]) == 0
    compiled(build)
    done = subprocess.run([tmp_path / "program"], capture_output=True, text=True, check=True)
    ready, v, omega = map(float, done.stdout.split())
    assert ready == 1
    assert v > 1
    assert omega > 1


def test_a_reference_at_rest_does_not_tell_the_longest_step(tmp_path):
    scenario = Scenario(nfopidn.Trajectory.from_samples(np.zeros(9), np.zeros(9), 0.1))
    with pytest.raises(ValueError, match="stands still"):
        nfopidn.export_c(Controller.published(), tmp_path, scenario=scenario, hardware=True)
    nfopidn.export_c(
        Controller.published(), tmp_path, scenario=scenario, hardware=True, longest_step=0.25
    )
    assert "LONGEST_STEP 0.25F " in (tmp_path / "nfopidn_hardware.h").read_text()


def test_hardware_needs_a_scenario(tmp_path, capsys):
    """Whose robot and sample time would it be?"""
    with pytest.raises(ValueError, match=r"robot, sample time\) without a scenario"):
        nfopidn.export_c(Controller.published(), tmp_path / "out", hardware=True)
    file = tmp_path / "controller.json"
    Controller.published().save(file)
    assert main(["export", str(file), "--hardware", "-o", str(tmp_path / "out")]) == 2
    assert "give a scenario" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("exporting", [nfopidn.export_c, nfopidn.export_cpp])
def test_a_reference_needs_a_scenario(exporting, tmp_path):
    with pytest.raises(ValueError, match="give a scenario"):
        exporting(Controller.published(), tmp_path, name="law", reference=True)
    assert not list(tmp_path.iterdir())


def test_command(tmp_path, lap, capsys):
    controller, scenario = tmp_path / "controller.json", tmp_path / "scenario.json"
    Controller.published().save(controller)
    lap.save(scenario)
    out = tmp_path / "out"
    arguments = ["export", str(controller), "-o", str(out), "--name", "eddie"]
    assert main([*arguments, "--hardware", "--reference", "--scenario", str(scenario)]) == 0
    assert {path.name for path in out.iterdir()} == set(FILES)
    shutil.rmtree(out)
    assert main([*arguments, "--cpp", "--reference", "--scenario", str(scenario)]) == 0
    assert "ReferenceTable<float> laps" in (out / "eddie.hpp").read_text()
    assert main([*arguments, "--reference"]) == 2
    assert "give a scenario" in capsys.readouterr().err
    assert main([*arguments, "--cpp", "--hardware"]) == 2
    assert "give --c" in capsys.readouterr().err


def test_comments_fit_a_line(tmp_path, lap):
    for path in export(Controller.published(), tmp_path, lap):
        assert max(map(len, path.read_text().splitlines())) <= 100, path.name
