"""Exported C under options that make arithmetic wrong: refused, or right all the same.

Before this was looked after, ``-ffast-math`` and its like gave torques 0 0 at a heading error of
0.5 rad.
"""

import subprocess

import nfopidn
import pytest
from nfopidn import Controller, Scenario
from test_export import CONTROLLERS, STRICT, compiled, compiler

PROGRAM = """
#include <stdio.h>
#include "nfopidn_hardware.h"
int main(void)
{
  static nfopidn_guarded guarded;
  static const nfopidn_reference still;
  volatile float input = -0.5F;
  nfopidn_pose pose = {0.0F, 0.0F, 0.0F};
  nfopidn_torques torques;
  pose.theta = input;
  nfopidn_guarded_init(&guarded, 0, NFOPIDN_BRIDGE_HOLD);
  torques = nfopidn_guarded_step(&guarded, &pose, &still);
  printf("%d %d ", (int)nfopidn_self_test(), (int)nfopidn_hardware_self_test());
  printf("%.3f %.3f ", (double)torques.left, (double)torques.right);
  input = 0.0F;
  pose.x = input / input;
  torques = nfopidn_guarded_step(&guarded, &pose, &still);
  printf("%.3f %.3f %d", (double)torques.left, (double)torques.right, (int)guarded.fault);
  return 0;
}
"""
OK, WRONG, NAN, OTHER_BITS = range(4)
ASSOCIATIVE = ["-fassociative-math", "-fno-signed-zeros", "-fno-trapping-math"]
UNSAFE = ["-funsafe-math-optimizations"]
SSE = ["-m32", "-msse2", "-mfpmath=sse"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    target = tmp_path_factory.mktemp("export")
    scenario = Scenario.published(rng=0)
    nfopidn.export_c(Controller.published(), target, scenario=scenario, hardware=True)
    (target / "main.c").write_text(PROGRAM)
    return target


def run(folder, command):
    compiled([*command, *folder.glob("*.c"), "-I", folder, "-o", folder / "program"])
    done = subprocess.run([folder / "program"], capture_output=True, text=True, check=True)
    law, hardware, *torques = done.stdout.split()
    return int(law), int(hardware), torques


RIGHT = ["0.576", "0.000", "0.000", "0.000", "2"]  # and no torque at a pose that is NaN


@pytest.mark.parametrize(
    ("program", "options", "bits"),
    [
        ("gcc", [], True),
        ("gcc-11", [], True),
        ("clang", [], True),
        ("clang", ["-mfma"], True),  # told by the pragma in the files
        ("gcc-12", SSE, True),
        ("gcc", ["-mfma", "-ffp-contract=fast"], False),
        ("gcc-11", ["-O3", *UNSAFE], False),
        ("gcc-11", ["-O3", *ASSOCIATIVE], False),
        ("clang", UNSAFE, None),
        ("clang", ASSOCIATIVE, None),
    ],
)
def test_what_is_not_reported_stays_right(program, options, bits, folder):
    law, hardware, torques = run(folder, [compiler(program), *STRICT, "-O2", *options])
    assert torques == RIGHT
    allowed = {OK, OTHER_BITS} if bits is None else {OK} if bits else {OTHER_BITS}
    assert {law, hardware} <= allowed


@pytest.mark.parametrize(
    ("program", "options", "message"),
    [
        ("gcc", ["-ffast-math"], "rounds by adding"),
        ("gcc", ["-Ofast"], "rounds by adding"),
        ("gcc", UNSAFE, "rounds by adding"),
        ("gcc", ASSOCIATIVE, "rounds by adding"),
        ("gcc", ["-freciprocal-math"], "rounds by adding"),
        ("clang", ["-ffast-math"], "rounds by adding"),
        ("gcc", ["-ffinite-math-only"], "looks for NaN"),
        ("clang", ["-ffinite-math-only"], "looks for NaN"),
        ("gcc-12", ["-m32", "-mfpmath=387"], "float is computed as float"),
    ],
)
def test_what_is_reported_is_refused(program, options, message, folder):
    for source in ("nfopidn.c", "nfopidn_hardware.c"):
        command = [compiler(program), "-std=c99", *options, "-fsyntax-only", folder / source]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode != 0
        assert message in done.stderr


@pytest.mark.parametrize(
    ("options", "verdict"), [(UNSAFE, WRONG), (["-ffinite-math-only"], NAN), ([], OK)]
)
def test_the_self_test_finds_what_is_wrong(options, verdict, folder, tmp_path):
    """With the refusals taken out of the files."""
    for file in folder.glob("*.[ch]"):
        (tmp_path / file.name).write_text(file.read_text().replace("#error", "#pragma refused"))
    law, hardware, _ = run(tmp_path, [compiler("gcc"), "-std=c99", "-w", "-O2", *options])
    assert (law, hardware) == (verdict, verdict)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_every_law_passes_its_self_test(name, tmp_path):
    scenario = Scenario.published(rng=0)
    nfopidn.export_c(CONTROLLERS[name], tmp_path, scenario=scenario, hardware=True)
    (tmp_path / "main.c").write_text(PROGRAM)
    law, hardware, _ = run(tmp_path, [compiler("gcc"), *STRICT, "-O2"])
    assert (law, hardware) == (OK, OK)
