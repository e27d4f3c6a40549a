"""Exported C and C++: compiled by every compiler, compared with the library sample by sample."""

import ctypes
import shutil
import subprocess

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Scenario
from nfopidn.commands.entry import main

STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]
CORTEX = ["-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"]
COMPILERS = {"gcc": [], "clang": [], "arm-none-eabi-gcc": [*CORTEX, "-Wdouble-promotion"]}

# With every part in action, and in pieces.
TRACKING = {
    "net": "speed-errors",
    "allocation": "decoupled",
    "lateral": "scheduled",
    **{"speed_gain_x": 12.4, "speed_gain_theta": 2.8},
    **{"speed_order_x": 1.14, "speed_order_theta": 1.26},
    **{"amplitude_x": 0.65, "amplitude_y": 7.9, "amplitude_theta": 0.233},
    **{"pole_x": 0.083, "pole_theta": 0.24},
    **{"integral_x": 0.0223, "integral_y": 0.0017, "integral_theta": 0.001},
    **{"integral_retention": 0.9925, "integral_limit": 0.155},
    **{"lateral_speed": 0.223, "lateral_power": 1.55, "sample_time": 0.2},
}
GAINS = [[1.97, 0, 0], [0.317, 0, 0], [0.88, 0, 0]]
FREE_TAPS = [[0.9, -0.4, 0.2], [1.5, -0.3, 0.01], [1.1, 0.25, -1.25e-5]]
CONTROLLERS = {
    "published": Controller.published(),
    "tuned": Controller.tuned_nominal(),
    "memory 0": Controller.published(memory=0),
    "memory 40": Controller.published(memory=40),
    "hold": Controller.tuned_nominal().replace(anti_windup="hold"),
    "clamp": Controller.tuned_nominal().replace(anti_windup="clamp"),
    "speed": Controller.published(lateral="speed", speed_scale=0.3),
    "tiny speed scale": Controller.published(lateral="speed", speed_scale=1e-310),
    "plain in the world": Controller.published(lateral="plain", frame="world"),
    "linear": Controller.published(activation="linear"),
    "linear in the world": Controller.published(activation="linear", frame="world"),
    "matrix": Controller.published(allocation=[[0.5, 1, -0.25], [1, 0.1, 1]]),
    "free taps": Controller.from_taps(FREE_TAPS, allocation="decoupled"),
    "tracking": Controller(GAINS, 1, 1, **TRACKING),
    "tracking, memory 40": Controller(GAINS, 1, 1, memory=40, **TRACKING),
    "tracking, linear": Controller(
        GAINS,
        1,
        1,
        **TRACKING | dict.fromkeys(("amplitude_x", "amplitude_y", "amplitude_theta"), 1.0),
        activation="linear",
    ),
    "speed errors, other allocation": Controller(
        [[2, 0, 0], [1, 0.1, 0.3], [1, 0, 0]],
        *(0.5, 0.5),
        net="speed-errors",
        **{"speed_gain_x": 3.0, "speed_order_x": 0.4, "sample_time": 0.2},
        **{"lateral": "speed", "speed_scale": 0.3, "anti_windup": "clamp"},
        **{"form": "incremental", "amplitude_theta": 0.01},
    ),
    "whole": Controller.published(net="whole", allocation="decoupled", integral_y=0.01, pole_x=0.2),
    "whole in the world": Controller.published(net="whole", frame="world", amplitude_y=0.5),
    "scheduled": Controller.published(lateral="scheduled", lateral_power=-0.4),
    "amplitudes in a matrix": Controller.published(
        allocation=[[0.5, 1, -0.25], [1, 0.1, 1]], amplitude_x=0.25, net="whole"
    ),
}


class Triple(ctypes.Structure):
    _fields_ = [(name, ctypes.c_float) for name in ("x", "y", "theta")]


class Reference(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_float) for name in ("x", "y", "theta", "v", "left", "right")),
        ("reverse", ctypes.c_int),
    ]


class TurningReference(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_float) for name in ("x", "y", "theta", "v", "omega", "left", "right")),
        ("reverse", ctypes.c_int),
    ]


class Torques(ctypes.Structure):
    _fields_ = [(name, ctypes.c_float) for name in ("left", "right")]


def compiler(name):
    if shutil.which(name) is None:
        pytest.fail(f"no {name}: ./dev build installs what the tests need")
    return name


def compiled(command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def samples(count=800):
    """Measurements and references: all sizes, several turns, both directions."""
    random = np.random.default_rng(5)
    size = np.array([0.02, 0.5, 6.0])[np.arange(count) % 3, None]
    measured = random.uniform(-1, 1, (count, 3)) * size
    reference = random.uniform(-1, 1, (count, 8)) * size
    measured[:, 2] *= 2
    reference[:, 3] = random.uniform(-1, 1, count)
    reference[:, 7] = random.integers(0, 2, count)
    return measured.astype(np.float32), reference.astype(np.float32)


class Exported:
    """Torques of exported C, through ctypes."""

    def __init__(self, directory, controller, name="nfopidn", **options):
        header, source = nfopidn.export_c(controller, directory, name=name, **options)
        library = directory / "law.so"
        compiled([compiler("gcc"), *STRICT, "-O2", "-shared", "-fPIC", "-o", library, source])
        self.header = header.read_text()
        self.source = source.read_text()
        self._library = ctypes.CDLL(str(library))
        self._name = name
        self._step = self._library[f"{name}_step"]
        self._step.restype = Torques
        self._turns = controller.net == "speed-errors"
        tracking = 13 if controller.uses_tracking_law else 0
        self._state = (ctypes.c_float * (3 * controller.taps.shape[1] + 2 + tracking))()
        self.call("init")

    def call(self, function):
        self._library[f"{self._name}_{function}"](ctypes.byref(self._state))

    def step(self, measured, reference):
        # omega, the fifth number of a library's reference, is the C code's with speed errors alone.
        x, y, theta, v, omega, left, right, reverse = reference
        if self._turns:
            wanted = TurningReference(x, y, theta, v, omega, left, right, int(reverse))
        else:
            wanted = Reference(x, y, theta, v, left, right, int(reverse))
        torques = self._step(
            ctypes.byref(self._state), ctypes.byref(Triple(*measured)), ctypes.byref(wanted)
        )
        return torques.left, torques.right


@pytest.mark.parametrize("name", CONTROLLERS)
def test_c_computes_what_the_library_computes(name, tmp_path):
    controller = CONTROLLERS[name]
    exported = Exported(tmp_path, controller)
    positional = controller.form == "positional"
    for k, (measured, reference) in enumerate(zip(*samples(), strict=True)):
        expected = controller.step(measured, reference)
        torques = exported.step(measured, reference)
        # Sums of errors of metres, in single precision; what integrates, adds up its roundings.
        bound = 2e-5 if positional else 1e-6 * (k + 10)
        np.testing.assert_allclose(torques, expected, rtol=0, atol=bound, err_msg=f"sample {k}")
    controller.reset()


def test_c_runs_the_published_scenario(tmp_path, published):
    exported = Exported(tmp_path, Controller.published())
    columns, reference = published.columns, published.scenario.reference
    for k, row in enumerate(reference):
        pose = columns["x"][k], columns["y"][k], columns["theta"][k]
        torques = exported.step(pose, row)
        expected = columns["tau_left"][k], columns["tau_right"][k]
        np.testing.assert_allclose(torques, expected, rtol=0, atol=1e-5, err_msg=f"sample {k}")


def test_speed_errors_start_at_rest_or_in_motion(tmp_path):
    """On its path at 0.3 m/s: a kick after a reset, which takes it to be at rest, and none else."""
    exported = Exported(tmp_path, CONTROLLERS["tracking"])
    on_path = ((1, 2, 0), (1, 2, 0, 0.3, 0, 0, 0, 0))
    for _ in range(2):
        left, right = exported.step(*on_path)
        assert left == right > 0.3
        exported.call("reset")
    exported.call("reset_in_motion")
    assert exported.step(*on_path) == (0, 0)


@pytest.mark.parametrize("name", ["tuned", "tracking"])
def test_reset_forgets(name, tmp_path):
    exported = Exported(tmp_path, CONTROLLERS[name])
    measured, reference = samples(40)
    first = [exported.step(*pair) for pair in zip(measured, reference, strict=True)]
    second = [exported.step(*pair) for pair in zip(measured, reference, strict=True)]
    assert first != second
    exported.call("reset")
    assert [exported.step(*pair) for pair in zip(measured, reference, strict=True)] == first


def test_extreme_nets_saturate(tmp_path):
    exported = Exported(tmp_path, Controller.published(frame="world"))
    far = (0, 0, 0, 0, 0, 0, 0, 0)
    for x, y, expected in [(-1e6, 1e30, (1, 2)), (3e38, -3e38, (-1, -1.0))]:
        exported.call("reset")
        left, right = exported.step((-x, -y, 0), far)
        assert abs(left) <= 3.078
        assert abs(right) <= 3.078
        assert np.sign(left) == np.sign(expected[0])
    left, right = exported.step((float("nan"), 0, 0), far)
    assert np.isnan(right)


@pytest.mark.parametrize("program", COMPILERS)
@pytest.mark.parametrize("name", CONTROLLERS)
def test_c_compiles_without_a_warning(name, program, tmp_path):
    _, source = nfopidn.export_c(CONTROLLERS[name], tmp_path)
    target = tmp_path / "law.o"
    command = [compiler(program), *STRICT, *COMPILERS[program], "-Os", "-c", source, "-o", target]
    compiled(command)
    nm = "arm-none-eabi-nm" if program.startswith("arm") else "nm"
    undefined = subprocess.run([nm, "-u", target], capture_output=True, text=True, check=True)
    words = undefined.stdout.split()[1::2]
    assert set(words) <= {"memset", "memcpy", "memmove", "_GLOBAL_OFFSET_TABLE_"}


def test_c_header_serves_cpp(tmp_path):
    header, _ = nfopidn.export_c(Controller.published(), tmp_path)
    user = tmp_path / "user.cpp"
    user.write_text(f'#include "{header.name}"\nint taps = NFOPIDN_TAPS;\n')
    compiled([compiler("g++"), "-std=c++17", "-Wall", "-Werror", "-fsyntax-only", user])


# The C++ header's program prints the torques' bits for samples from its standard input.
PROGRAM = """
#include <cstdio>
#include "law.hpp"
int main() {
  law::Law running = law::controller;
  nfopidn::Measurement<float> m = {};
  nfopidn::ReferenceSample<float> r = {};
  int reverse = 0;
  while (std::scanf("%f %f %f %f %f %f %f %f %f %f %d", &m.x, &m.y, &m.theta, &r.x, &r.y, &r.theta,
                    &r.v, &r.omega, &r.tau_left, &r.tau_right, &reverse) == 11) {
    r.reverse = reverse != 0;
    const auto torques = running.step(m, r);
    std::printf("%a %a\\n", torques.left, torques.right);
  }
}
"""


@pytest.mark.parametrize("name", CONTROLLERS)
def test_cpp_and_c_have_the_same_bits(name, tmp_path, repository):
    controller = CONTROLLERS[name]
    exported = Exported(tmp_path, controller)
    nfopidn.export_cpp(controller, tmp_path, name="law")
    (tmp_path / "main.cpp").write_text(PROGRAM)
    program = tmp_path / "program"
    compiled(
        [
            *(compiler("g++"), "-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion"),
            *("-Wshadow", "-Werror", "-O1", "-ffp-contract=off", "-I", repository / "cpp/include"),
            *(tmp_path / "main.cpp", "-o", program),
        ]
    )
    measured, reference = samples()
    rows = np.hstack([measured, reference]).tolist()
    words = "\n".join(" ".join(float(n).hex() for n in r[:-1]) + f" {int(r[-1])}" for r in rows)
    done = subprocess.run([program], input=words, capture_output=True, text=True, check=True)
    pairs = [tuple(map(float.fromhex, line.split())) for line in done.stdout.splitlines()]
    assert len(pairs) == len(rows)
    assert pairs == [exported.step(*pair) for pair in zip(measured, reference, strict=True)]


@pytest.mark.parametrize("name", CONTROLLERS)
def test_cpp_compiles_for_the_board(name, tmp_path, repository):
    (header,) = nfopidn.export_cpp(CONTROLLERS[name], tmp_path, name="law")
    command = [compiler("arm-none-eabi-g++"), *CORTEX, "-std=c++17", "-fno-exceptions", "-fno-rtti"]
    command += ["-Wall", "-Wextra", "-Wdouble-promotion", "-Werror", "-fsyntax-only"]
    compiled(
        [*command, "-I", repository / "cpp/include", "-x", "c++", "-include", header, "/dev/null"]
    )


def test_header_says_where_it_comes_from(tmp_path, scenario):
    controller = Controller.published(memory=3)
    header, source = nfopidn.export_c(controller, tmp_path, scenario=scenario, name="eddie_law")
    text = header.read_text()
    assert header.name == "eddie_law.h"
    assert source.name == "eddie_law.c"
    assert f"nfopidn {nfopidn.__version__}" in text
    assert repr(controller) in text
    assert "memory: 3" in text
    assert "ranunculoid" in text
    assert "eddie_law_step" in text
    assert "#define EDDIE_LAW_TAPS 5" in text
    assert max(map(len, text.splitlines())) <= 100


def test_scenario_gives_limit_and_speed(tmp_path):
    scenario = Scenario.published(torque_limit=0.75)
    controller = Controller.published(lateral="speed")
    exported = Exported(tmp_path, controller, scenario=scenario)
    assert exported.step((0, 0, 0), (1, 1, 1, 0.3, 0, 9, -9, 0)) == (0.75, -0.75)
    exported.call("reset")
    scaled = controller.replace(speed_scale=scenario.trajectory.peak_speed)
    for measured, reference in zip(*samples(50), strict=True):
        expected = scaled.step(measured, reference, torque_limit=0.75)
    exported.call("reset")
    for measured, reference in zip(*samples(50), strict=True):
        torques = exported.step(measured, reference)
    np.testing.assert_allclose(torques, expected, atol=2e-5)


def test_long_scenario_is_named_not_copied(tmp_path):
    t = np.arange(400) * 0.1
    trajectory = nfopidn.Trajectory.from_samples(np.cos(t), np.sin(t), 0.1)
    header, _ = nfopidn.export_c(Controller.published(), tmp_path, scenario=Scenario(trajectory))
    assert "400 samples every 0.1 s" in header.read_text()


@pytest.mark.parametrize("export", [nfopidn.export_c, nfopidn.export_cpp])
@pytest.mark.parametrize(
    "name", ["", "1x", "a-b", "a b", "int", "class", "a__b", "_x", "../x", "asm", "explicit"]
)
def test_bad_names_are_refused(export, name, tmp_path):
    with pytest.raises(ValueError, match="must be an identifier"):
        export(Controller.published(), tmp_path, name=name)
    assert not list(tmp_path.iterdir())


def test_other_refusals(tmp_path):
    with pytest.raises(ValueError, match="own namespace"):
        nfopidn.export_cpp(Controller.published(), tmp_path, name="nfopidn")
    for export in (nfopidn.export_c, nfopidn.export_cpp):
        with pytest.raises(ValueError, match="speed_scale is 0"):
            export(Controller.published(lateral="speed"), tmp_path)
        with pytest.raises(ValueError, match="sample_time is unknown, and with net"):
            export(CONTROLLERS["tracking"].replace(sample_time=None), tmp_path)
    assert not list(tmp_path.iterdir())


def test_command(tmp_path, capsys):
    file = tmp_path / "controller.json"
    Controller.published().save(file)
    out = tmp_path / "out"
    assert main(["export", "--c", str(file), "-o", str(out)]) == 0
    assert {path.name for path in out.iterdir()} == {"nfopidn.h", "nfopidn.c"}
    assert main(["export", "--cpp", str(file), "-o", str(out), "--name", "law"]) == 0
    assert (out / "law.hpp").exists()
    assert str(out / "law.hpp") in capsys.readouterr().out
    assert main(["export", "--c", str(tmp_path / "none.json"), "-o", str(out)]) == 2
    assert main(["export", "--c", str(file), "-o", str(out), "--name", "int"]) == 2
    assert "identifier" in capsys.readouterr().err


def test_command_takes_a_scenario(tmp_path):
    file, scenario = tmp_path / "controller.json", tmp_path / "scenario.json"
    Controller.published(lateral="speed").save(file)
    Scenario.published(torque_limit=1.5).save(scenario)
    arguments = ["export", str(file), "-o", str(tmp_path), "--scenario", str(scenario)]
    assert main(arguments) == 0
    assert "TORQUE_LIMIT 1.5F" in (tmp_path / "nfopidn.h").read_text()
