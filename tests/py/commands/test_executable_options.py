"""Every option of --help says what it is in what unit with what default, and does something."""

import json
import re

import pytest
from nfopidn import Controller, Scenario

NOISY = ["--pose-noise", "0.01,0.02"]
INCREMENTAL = ["--form", "incremental", "--torque-limit", "0.3"]
CONTINUOUS = ["--heading", "continuous"]
DECOUPLED = ["--allocation", "decoupled"]
INTEGRAL = [*DECOUPLED, "--integral-x", "0.05"]
SPEED_ERRORS = ["--net", "speed-errors", "--gains", "0.3,0,0,0.7,0.3,0.3,1,0,0"]
DRIVE_SPEED = [*SPEED_ERRORS, "--speed-gain-x", "0.5"]
TURN_SPEED = [*SPEED_ERRORS, "--speed-gain-theta", "0.2"]
SCHEDULED = ["--lateral", "scheduled"]
MOTOR_UNITS = "ohm, N m/A, V s/rad, , kg m^2, N m s/rad, N m, V, V"

# Option: a value that changes the published run, its unit and default as --help has them, and what
# else must be set for it to matter.
SETTINGS = {
    "--trajectory": ("circle", "", "ranunculoid", []),
    "--period": ("100", "s", "150.0", []),
    "--dt": ("0.1", "s", "0.2", []),
    "--cusps": ("5", "", "3", []),
    "--heading": ("continuous", "", "forward", []),
    "--scale": ("0.9", "", "1.0", []),
    "--laps": ("2", "", "1", []),
    "--derivatives": ("analytic", "", "sampled", []),
    "--standstill-speed": ("0.05", "m/s", "resolution", []),
    "--mass": ("10", "kg", "11.5", []),
    "--inertia": ("0.3", "kg m^2", "0.5873", []),
    "--track-width": ("0.39", "m", "0.452", []),
    "--wheel-radius": ("0.07", "m", "0.076", []),
    "--initial-pose": ("-3.5,0.5,1", "m, m, rad", "4.0,0.0,1.0472", []),
    "--initial-velocity": ("0.1,-0.2", "m/s, rad/s", "0.0,0.0", []),
    "--torque-limit": ("0.5", "N m", "3.078", []),
    "--feedforward": (None, "", "true", ["--scenario", "without-feedforward.json"]),
    "--no-feedforward": (None, "", None, []),
    "--integrator": ("exact", "", "semi-implicit-euler", []),
    "--substeps": ("4", "", "1", []),
    "--disturbance": ("0.5,-0.1", "N, N m", "0.0,0.0", []),
    "--viscous-friction": ("0.01", "N m s/rad", "0.0", []),
    "--coulomb-friction": ("0.05", "N m", "0.0", []),
    "--viscous-scrub": ("0.05", "N m s/rad", "0.0", []),
    "--coulomb-scrub": ("0.02", "N m", "0.0", []),
    "--pose-noise": ("0.01,0", "m, rad", "0.0,0.0", []),
    "--delay": ("1", "samples", "0", []),
    "--divergence-distance": ("3", "m", "10.0", ["--frame", "world"]),
    "--model": ("10,0.5,0.4,0.07", "kg, kg m^2, m, m", "robot", []),
    "--motor": ("2.4,0.01,0.01,30,1e-5,0.01,0.05,6,0.1", MOTOR_UNITS, "none", []),
    "--encoder-counts": ("100", "", "0", []),
    "--odometry-errors": ("0.01,0,0", "", "0.0,0.0,0.0", ["--encoder-counts", "100"]),
    "--feedforward-limit": ("0.5", "N m", "none", []),
    "--friction-feedforward": ("0.01,0.05", "N m s/rad, N m", "0.0,0.0", []),
    "--friction-feedforward-speed": ("2", "rad/s", "0.5", ["--friction-feedforward", "0,0.05"]),
    "--cost-weights": ("2,1,0.5", "", "1.0,1.0,1.0", []),
    "--noise-source": ("counter", "", "mersenne", NOISY),
    "--seed": ("5", "", "0", NOISY),
    "--gains": ("0.2,0.7,0.8,0.7,0.2,0.3,1,1.3,0.1", "N m", "0.2797,", []),
    "--alpha": ("0.2", "", "0.1078", []),
    "--sigma": ("0.8,0.7,0.9", "", "0.8161", []),
    "--memory": ("6", "samples", "5", []),
    "--form": ("incremental", "", "positional", []),
    "--allocation": ("decoupled", "", "paper", []),
    "--activation": ("linear", "", "sigmoid", []),
    "--frame": ("world", "", "robot", []),
    "--generator": ("gl", "", "tustin", []),
    "--lateral": ("plain", "", "direction", CONTINUOUS),
    "--speed-scale": ("0.5", "m/s", "0.0", ["--lateral", "speed"]),
    "--anti-windup": ("hold", "", "none", INCREMENTAL),
    "--sample-time": ("0.1", "s", "unknown", []),
    "--net": ("whole", "", "increment", []),
    "--speed-gain-x": ("0.5", "N m/m", "0.0", SPEED_ERRORS),
    "--speed-gain-theta": ("0.2", "N m/rad", "0.0", SPEED_ERRORS),
    "--speed-order-x": ("1.1", "", "1.0", DRIVE_SPEED),
    "--speed-order-theta": ("1.1", "", "1.0", TURN_SPEED),
    "--amplitude-x": ("1.2", "N m", "1.0", []),
    "--amplitude-y": ("0.6", "N m", "1.0", []),
    "--amplitude-theta": ("1.2", "N m", "1.0", []),
    "--pole-x": ("0.1", "", "0.0", DECOUPLED),
    "--pole-theta": ("0.1", "", "0.0", DECOUPLED),
    "--integral-x": ("0.05", "N m/m", "0.0", DECOUPLED),
    "--integral-y": ("0.02", "N m/m", "0.0", DECOUPLED),
    "--integral-theta": ("0.02", "N m/rad", "0.0", DECOUPLED),
    "--integral-retention": ("0.95", "", "1.0", INTEGRAL),
    "--integral-limit": ("0.01", "N m", "1.0", INTEGRAL),
    "--lateral-speed": ("0.5", "m/s", "0.25", SCHEDULED),
    "--lateral-power": ("1", "", "1.5", SCHEDULED),
}
# Short names, which are older.
ALIASES = {
    "--trajectory": "--traj",
    "--initial-pose": "--pose",
    "--initial-velocity": "--velocity",
    "--viscous-friction": "--viscous",
    "--coulomb-friction": "--coulomb",
    "--pose-noise": "--noise",
}
FILES = {"--scenario", "--controller", "--closed"}
OUTPUTS = {"--out", "--save-scenario", "--save-controller", "--json", "--quiet"}
# test_tuning_commands.py
TUNING = {"--tune", "--structure", "--method", "--option", "--maxfev", "--tune-seed"}
PROGRAM = {"--help", "--version"}


@pytest.fixture(scope="module")
def help_text(sim):
    run = sim("--help")
    assert (run.returncode, run.stderr) == (0, "")
    return run.stdout


@pytest.fixture(scope="module")
def options(help_text):
    """The description of each option that --help lists."""
    line = r"^ +(?:-\w,)?(--[\w-]+)(?:,(--[\w-]+))?(?: +[A-Z]+)? +(.*)$"
    found = re.findall(line, help_text, re.MULTILINE)
    texts = {name: text for name, _, text in found}
    assert len(texts) == len(found)
    assert {name: alias for name, alias, _ in found if alias} == ALIASES
    return texts


@pytest.fixture
def metrics(sim, tmp_path):
    Scenario.published(feedforward=False).save(tmp_path / "without-feedforward.json")

    def of(*arguments):
        run = sim(*arguments, "--json", cwd=tmp_path)
        assert run.returncode in (0, 3), run.stderr
        return json.loads(run.stdout)

    return of


def test_every_option_is_covered_here(options):
    assert set(options) == set(SETTINGS) | FILES | OUTPUTS | PROGRAM | TUNING


def test_an_option_has_the_name_of_its_key_in_json(options, sim, tmp_path):
    files = [tmp_path / "scenario.json", tmp_path / "controller.json"]
    run = sim("--quiet", "--save-scenario", files[0], "--save-controller", files[1])
    assert run.returncode == 0
    scenario, controller = (json.loads(file.read_text()) for file in files)
    keys = {*scenario, *scenario["robot"], *scenario["trajectory"], *controller}
    keys -= {"format", "version", "robot", "name"}  # of a path, which is --trajectory
    named = {"--" + key.replace("_", "-") for key in keys}
    # These have a key where they are not at their defaults.
    named |= {"--standstill-speed", "--model", "--feedforward-limit", "--cost-weights"}
    named |= {"--noise-source", "--motor", "--encoder-counts", "--odometry-errors"}
    named |= {"--friction-feedforward", "--friction-feedforward-speed"}
    named |= {"--viscous-scrub", "--coulomb-scrub"}
    assert named == set(SETTINGS) - {"--no-feedforward"}


@pytest.mark.parametrize("option", ALIASES)
def test_a_short_name_does_what_the_whole_one_does(option, metrics, sim):
    value, _, _, context = SETTINGS[option]
    assert metrics(*context, ALIASES[option], value) == metrics(*context, option, value)
    run = sim(option, value, f"{ALIASES[option]}={value}")
    assert (run.returncode, run.stdout) == (2, "")
    assert f"{option}: " in run.stderr


@pytest.mark.parametrize("option", SETTINGS)
def test_every_setting_changes_the_metrics(option, metrics):
    value, _, _, context = SETTINGS[option]
    knob = [option] if value is None else [option, value]
    if option == "--sample-time":  # refuses the run: test_sample_time.py
        return
    assert metrics(*context, *knob) != metrics(*context)
    if value is not None:
        assert metrics(*context, f"{option}={value}") == metrics(*context, *knob)


@pytest.mark.parametrize("option", SETTINGS)
def test_help_gives_unit_and_default(option, options):
    _, unit, default, _ = SETTINGS[option]
    assert (f" [{unit}] " in options[option]) == bool(unit)
    if default is None:
        assert options[option] == "the opposite of --feedforward"
    else:
        assert f" (default {default}" in options[option]


@pytest.mark.parametrize("option", SETTINGS)
def test_the_default_is_what_runs(option, options, metrics):
    """The default as --help prints it, given by hand, changes nothing."""
    value, _, default, context = SETTINGS[option]
    if value is None or option in context:
        return
    printed = re.search(r"\(default (.*?)\)", options[option])[1]
    assert printed.startswith(default)
    assert metrics(*context, option, printed) == metrics(*context)


def test_of_two_opposites_the_last_counts(metrics):
    with_it, without = metrics(), metrics("--no-feedforward")
    assert metrics("--feedforward", "--no-feedforward") == without
    assert metrics("--no-feedforward", "--feedforward") == with_it


def test_help_explains_signs_and_exit_codes(help_text):
    assert "counter-clockwise" in help_text
    assert "0 done, 2 bad usage or bad file, 3 the run diverged" in help_text


@pytest.mark.parametrize(
    ("option", "word", "make"),
    [
        ("--traj", "rounded_square", None),
        ("--pose", "reference", {"initial_pose": None}),
        ("--velocity", "reference", {"initial_velocity": "reference"}),
        ("--period", "1e2", {"period": 100}),
        ("--mass", "+12", {"robot": "mass"}),
        ("--alpha", "0.1, 0.2, 0.3", {"alpha": (0.1, 0.2, 0.3)}),
        ("--allocation", "1,0.5,1,1,-0.5,-1", {"allocation": [[1, 0.5, 1], [1, -0.5, -1]]}),
        ("--memory", "7.0", {"memory": 7}),
    ],
)
def test_how_values_may_be_written(option, word, make, sim, tmp_path):
    files = [tmp_path / "scenario.json", tmp_path / "controller.json"]
    run = sim(option, word, "--quiet", "--save-scenario", files[0], "--save-controller", files[1])
    assert run.returncode in (0, 3)
    scenario, controller = Scenario.load(files[0]), Controller.load(files[1])
    if make is None:
        assert scenario.trajectory.name == word
        assert scenario.initial_pose is None
    elif make == {"robot": "mass"}:
        assert scenario.robot.mass == 12
    elif set(make) & {"alpha", "allocation", "memory"}:
        assert controller == Controller.published().replace(**make)
    else:
        assert scenario == Scenario.published(rng=0, **make)


def test_options_go_over_the_files(sim, tmp_path):
    scenario = Scenario.published(delay=1, period=100, robot=Scenario.published().robot, rng=3)
    scenario = scenario.replace(robot=scenario.robot.replace(mass=10))
    controller = Controller.published(7, form="incremental")
    names = [tmp_path / f"{name}.json" for name in ("s", "c", "s2", "c2")]
    scenario.save(names[0])
    controller.save(names[1])
    run = sim(
        *["--scenario", names[0], "--controller", names[1], "--quiet"],
        *["--save-scenario", names[2], "--save-controller", names[3]],
        *["--dt", "0.1", "--inertia", "0.5", "--substeps", "2", "--alpha", "0.3"],
    )
    assert run.returncode in (0, 3)
    assert Controller.load(names[3]) == controller.replace(alpha=0.3)
    expected = Scenario.published(period=100, dt=0.1, rng=3, delay=1, substeps=2)
    robot = scenario.robot.replace(inertia=0.5)
    assert Scenario.load(names[2]) == expected.replace(robot=robot)


@pytest.mark.parametrize("kind", ["scenario", "controller"])
def test_a_file_changes_the_metrics(kind, metrics, tmp_path):
    path = tmp_path / "document.json"
    values = {"scenario": Scenario.published(delay=1), "controller": Controller.published(3)}
    values[kind].save(path)
    assert metrics(f"--{kind}", path) != metrics()
