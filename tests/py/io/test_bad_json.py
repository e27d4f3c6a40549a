"""Documents that are refused, by Python and by the executable alike, in the same words."""

import copy
import json
import subprocess
import sys

import numpy as np
import pytest
from nfopidn import Controller, Scenario, Trajectory

CLASSES = {"controller": Controller, "scenario": Scenario}
SQUARE = Trajectory.from_samples([0, 1, 1], [0, 0, 1], 0.5)
REMOVED = object()
CURVES = ["ranunculoid", "circle", "lemniscate", "eight", "line", "sine", "rounded_square"]


def documents(tmp_path):
    values = {
        "controller": Controller.published(),
        "scenario": Scenario.published(rng=0),
        "samples": Scenario(SQUARE, disturbance=np.ones((3, 2)), rng=0),
    }
    result = {}
    for name, value in values.items():
        value.save(tmp_path / "good.json")
        result[name] = json.loads((tmp_path / "good.json").read_text())
    return result


@pytest.fixture(params=["python", "executable"])
def complaint(request, tmp_path, sim):
    """What a reader says of a file; None when it takes it."""

    def of_python(kind, path):
        try:
            CLASSES[kind].load(path)
        except Exception as error:
            return f"{type(error).__name__}: {error}"
        return None

    def of_the_executable(kind, path):
        run = sim(f"--{kind}", path, "--quiet")
        assert run.stdout == ""
        if run.returncode in (0, 3):
            return None
        assert run.returncode == 2
        assert run.stderr.endswith("\n")
        return run.stderr[:-1]

    return of_python if request.param == "python" else of_the_executable


def check(complaint, kind, path, parts):
    text = complaint(kind, path)
    assert text is not None, "the file was taken"
    assert text.startswith(("ValueError: ", "nfopidn_sim: ")), text
    assert "\n" not in text
    for part in [f"{path}: ", *parts]:
        assert part in text, text


# Document, path of the key, new value, what the message says.
CHANGES = [
    ("controller", ["foo"], 1, ["foo is unknown", "gains", "anti_windup"]),
    ("scenario", ["foo"], 1, ["foo is unknown", "trajectory", "robot", "initial_pose", "seed"]),
    ("scenario", ["robot", "foo"], 1, ["robot.foo is unknown", "mass", "wheel_radius"]),
    ("scenario", ["trajectory", "foo"], 1, ["trajectory.foo is unknown", "period", "derivatives"]),
    ("samples", ["trajectory", "foo"], 1, ["trajectory.foo is unknown"]),
    ("samples", ["trajectory", "cusps"], 3, ["trajectory.cusps is unknown"]),
    ("scenario", ["trajectory", "x"], [1], ["trajectory.x is unknown"]),
    ("controller", ["a\nb"], 1, ["is unknown"]),
    ("controller", ["memory"], "5", ['memory is "5"', "a whole number"]),
    ("controller", ["memory"], [5], ["memory is [5]", "a whole number"]),
    ("controller", ["memory"], {"M": 5}, ['memory is {"M":5}', "a whole number"]),
    ("controller", ["memory"], 2.5, ["memory is 2.5", "a whole number"]),
    ("controller", ["memory"], 1e20, ["memory is 1e+20", "in [0, 1e+06] samples, or"]),
    ("controller", ["memory"], -1, ["memory is -1", "in [0, 1e+06] samples, or"]),
    ("controller", ["gains", 1, 2], "a", ['gains[1][2] is "a"', "a number"]),
    ("controller", ["gains", 2, 0], 1e7, ["gains[2][0] is 1e+07", "in [-1e+06, 1e+06] N m"]),
    ("controller", ["gains"], [[1, 2, 3]], ["gains is [[1,2,3]]", "3 lists of 3 numbers"]),
    ("controller", ["gains", 1], [1, 2], ["gains", "3"]),
    ("controller", ["alpha"], 2.5, ["alpha is 2.5", "in [-2, 2]"]),
    ("controller", ["sigma"], [1, -3, 1], ["sigma[1] is -3", "in [-2, 2]"]),
    ("controller", ["form"], "Positional", ['form is "Positional"', '"positional"']),
    ("controller", ["allocation"], "all", ['allocation is "all"', '"paper"', '"decoupled"']),
    ("controller", ["format"], "nfopidn-scenario", ["format", '"nfopidn-controller"']),
    ("controller", ["format"], REMOVED, ["format", '"nfopidn-controller"']),
    ("scenario", ["format"], 3, ["format", '"nfopidn-scenario"']),
    ("controller", ["version"], REMOVED, ["version is missing", "1"]),
    ("controller", ["version"], 3, ["version is 3", "reads version 1 to 2"]),
    ("controller", ["version"], 0, ["version is 0", "reads version 1 to 2"]),
    ("controller", ["version"], 1, ["sample_time is known from version 2 on", "version is 1"]),
    ("controller", ["sample_time"], 0, ["sample_time is 0", "greater than 0 s"]),
    ("controller", ["sample_time"], -0.2, ["sample_time is -0.2", "greater than 0 s"]),
    ("controller", ["sample_time"], "0.2", ['sample_time is "0.2"', "a number"]),
    ("scenario", ["version"], 2, ["version is 2", "reads version 1"]),
    ("scenario", ["version"], 0, ["version is 0", "reads version 1"]),
    ("scenario", ["version"], "1", ['version is "1"', "reads version 1"]),
    ("scenario", ["version"], True, ["version is true", "reads version 1"]),
    ("scenario", ["robot", "mass"], -1, ["robot.mass is -1", "in [1e-06, 1e+06] kg"]),
    ("scenario", ["robot", "mass"], None, ["robot.mass is null", "a number"]),
    ("scenario", ["robot"], [1, 2], ["robot must be an object"]),
    ("scenario", ["trajectory"], "line", ["trajectory must be an object"]),
    ("scenario", ["trajectory", "dt"], 0, ["trajectory.dt is 0", "in [1e-06, 1000] s"]),
    ("scenario", ["trajectory", "period"], 0.3, ["trajectory.samples is 2", "in [3, 1e+07]"]),
    ("scenario", ["trajectory", "name"], "curve", ['trajectory.name is "curve"', *CURVES]),
    ("scenario", ["trajectory", "heading"], "back", ['trajectory.heading is "back"', "forward"]),
    ("samples", ["trajectory", "x"], [1, 2], ["trajectory.y has 3", "as many as x, 2"]),
    ("samples", ["trajectory", "x"], REMOVED, ["trajectory.x", "a list of numbers"]),
    ("samples", ["trajectory", "y", 1], "a", ['trajectory.y[1] is "a"', "a number"]),
    ("samples", ["trajectory", "y", 1], 2e9, ["trajectory.y[1] is 2e+09", "[-1e+09, 1e+09] m"]),
    ("samples", ["trajectory", "laps"], 2, ["trajectory.laps is 2", "must be 1"]),
    ("scenario", ["disturbance"], [], ["disturbance is []", "a list of 2 numbers"]),
    ("scenario", ["disturbance"], 3, ["disturbance is 3", "a list of 2 numbers"]),
    ("samples", ["disturbance", 2], 3, ["disturbance[2] is 3", "a list of 2 numbers"]),
    ("samples", ["disturbance", 2, 1], None, ["disturbance[2][1] is null", "a number"]),
    ("samples", ["disturbance", 2], REMOVED, ["disturbance has 2", "3"]),
    ("scenario", ["initial_pose"], [100, 0, 0], ["initial_pose is 97 m", "10 m"]),
    ("scenario", ["initial_pose"], [1, 0], ["initial_pose is [1,0]", "a list of 3 numbers"]),
    ("scenario", ["initial_velocity"], "none", ['initial_velocity is "none"', '"reference"']),
    ("scenario", ["feedforward"], 1, ["feedforward is 1", "true or false"]),
    ("scenario", ["feedforward_limit"], 0, ["feedforward_limit is 0", "[1e-06, 1e+06] N m"]),
    ("scenario", ["feedforward_limit"], "no", ['feedforward_limit is "no"', "a number"]),
    ("scenario", ["friction_feedforward"], [0, -1], ["friction_feedforward[1] is -1", "N m"]),
    ("scenario", ["viscous_scrub"], -1, ["viscous_scrub is -1", "[0, 1000] N m s/rad"]),
    ("scenario", ["coulomb_scrub"], 1001, ["coulomb_scrub is 1001", "[0, 1000] N m"]),
    ("scenario", ["friction_feedforward_speed"], 0, ["friction_feedforward_speed is 0", "rad/s"]),
    ("scenario", ["encoder_counts"], -1, ["encoder_counts is -1", "[0, 1e+06]"]),
    ("scenario", ["encoder_counts"], 1.5, ["encoder_counts is 1.5", "whole"]),
    ("scenario", ["odometry_errors"], [0, 0, 1], ["odometry_errors[2] is 1", "[-0.5, 0.5]"]),
    ("scenario", ["motor"], {"resistance": 1}, ["motor.torque_constant is missing"]),
    ("scenario", ["cost_weights"], [1, 0, 1], ["cost_weights[1] is 0", "[1e-06, 1e+06]"]),
    ("scenario", ["cost_weights"], [1, 1], ["cost_weights is [1,1]", "a list of 3 numbers"]),
    ("scenario", ["model"], [1, 2], ["model must be an object"]),
    ("scenario", ["model"], {"mass": 3}, ["model.inertia is missing", "mass, inertia"]),
    ("scenario", ["model"], {"mass": -1}, ["model.mass is -1", "in [1e-06, 1e+06] kg"]),
    ("scenario", ["model"], {"weight": 1}, ["model.weight is unknown", "track_width"]),
    ("scenario", ["seed"], -1, ["seed is -1", "in [0, 9007199254740992]"]),
    ("scenario", ["seed"], 2**53 + 1, ["seed is 9007199254740993", "in [0, 9007199254740992]"]),
    ("scenario", ["seed"], 2**64, ["seed is 1", "in [0, 9007199254740992]"]),
]


def changed(document, path, value):
    result = copy.deepcopy(document)
    place = result
    for key in path[:-1]:
        place = place[key]
    if value is REMOVED:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return result


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: ".".join(map(str, change[1])))
def test_documents(change, complaint, tmp_path):
    name, path, value, parts = change
    kind = "controller" if name == "controller" else "scenario"
    file = tmp_path / "document.json"
    document = documents(tmp_path)[name]
    file.write_text(json.dumps(document))
    assert complaint(kind, file) is None
    file.write_text(json.dumps(changed(document, path, value)))
    check(complaint, kind, file, parts)


START = '{"format": "nfopidn-controller", "version": 2, '
TEXTS = {
    "empty": ("", ["not valid JSON", "line 1"]),
    "a list": ("[]", ["must be an object"]),
    "a number": ("3", ["must be an object"]),
    "truncated": (START + '"memory": 3', ["not valid JSON", "line 1"]),
    "text behind": (START + '"memory": 3} x', ["not valid JSON", "line 1"]),
    "NaN": (START + '\n"alpha": NaN}', ["not valid JSON", "line 2"]),
    "Infinity": (START + '\n\n"alpha": -Infinity}', ["not valid JSON", "line 3"]),
    "beyond every float": (START + '"alpha": 1e400}', ["1e400"]),
    "comment": (START + '"memory": 3} // M', ["not valid JSON"]),
    "a key twice": (START + '"memory": 3, "memory": 4}', ["memory"]),
    "a nested key twice": (
        '{"format": "nfopidn-scenario", "version": 1, "trajectory": {"name": "line"}, '
        '"robot": {"mass": 3, "mass": 4}}',
        ["mass"],
    ),
    "bad UTF-8": (START.encode() + b'"form": "\xff"}', ["not valid JSON"]),
    "a name of bad UTF-8": (START.encode() + b'"\xff": 1}', ["not valid JSON"]),
    "NUL in a name": (START + '"a\\u0000b": 1}', ["is unknown", "gains"]),
}


@pytest.mark.parametrize(("content", "parts"), TEXTS.values(), ids=TEXTS.keys())
def test_texts(content, parts, complaint, tmp_path):
    file = tmp_path / "document.json"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    kind = "scenario" if b"scenario" in file.read_bytes() else "controller"
    check(complaint, kind, file, parts)


def test_a_byte_order_mark_is_no_fault(complaint, tmp_path):
    file = tmp_path / "document.json"
    file.write_bytes(b"\xef\xbb\xbf" + (START[:-2] + "}").encode())
    assert complaint("controller", file) is None


def test_missing_files_and_directories(complaint, tmp_path):
    check(complaint, "controller", tmp_path / "none.json", ["cannot be read", "No such file"])
    check(complaint, "scenario", tmp_path, ["cannot be read", "directory"])


@pytest.mark.parametrize(
    "text",
    [
        '{"a":' * 200_000 + "1" + "}" * 200_000,
        START + '"memory": ' + "[" * 200_000 + "]" * 200_000 + "}",
        START + '"memory": ' + '{"a":' * 200_000 + "1" + "}" * 200_001,
        "[" * 200_000,
    ],
    ids=["objects", "lists in a value", "objects in a value", "unclosed"],
)
def test_deep_nesting(text, sim, tmp_path):
    """In processes of their own, since what overflows a stack cannot be caught."""
    file = tmp_path / "deep.json"
    file.write_text(text)
    assert sim("--controller", file).returncode == 2
    code = "import sys, nfopidn; nfopidn.Controller.load(sys.argv[1])"
    run = subprocess.run(
        [sys.executable, "-c", code, file], capture_output=True, text=True, check=False
    )
    assert run.returncode == 1
    assert "\nValueError: " in run.stderr


@pytest.mark.parametrize(
    "make", ["deep = []; deep.append(deep)", "deep = 0\nfor _ in range(200_000): deep = [deep]"]
)
def test_deep_lists_as_arguments(make):
    code = f"import nfopidn\n{make}\nnfopidn.Robot(mass=deep)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.returncode == 1
    assert "Error: " in run.stderr


VERSIONS = {"scenario": 1, "controller": 2}


@pytest.mark.parametrize("kind", CLASSES)
def test_missing_keys_mean_the_same_to_both(kind, sim, tmp_path):
    """A document of nothing but its header: what the executable runs is what Python reads."""
    file, copied = tmp_path / "document.json", tmp_path / "copy.json"
    file.write_text(json.dumps({"format": f"nfopidn-{kind}", "version": VERSIONS[kind]}))
    run = sim(f"--{kind}", file, f"--save-{kind}", copied, "--quiet")
    if run.returncode == 2:
        with pytest.raises(ValueError, match="trajectory"):
            CLASSES[kind].load(file)
    else:
        assert CLASSES[kind].load(file) == CLASSES[kind].load(copied)
