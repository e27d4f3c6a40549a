"""Exported C on AVR, where constants lie in RAM unless they are told to stay in flash."""

import subprocess

import nfopidn
import pytest
from nfopidn import Controller, Scenario, Trajectory
from test_export import STRICT, compiled, compiler

MAIN = """
#include "nfopidn_hardware.h"
#include "nfopidn_reference.h"
volatile float out;
static nfopidn_guarded guarded;
int main(void)
{
  static const nfopidn_pose pose = {1.0F, 0.0F, 1.5F};
  unsigned long k;
  nfopidn_guarded_init(&guarded, 3, NFOPIDN_BRIDGE_HOLD);
  for (k = 0; k < 400; ++k) {
    const nfopidn_reference wanted = nfopidn_reference_lap(k);
    const nfopidn_reference other = nfopidn_reference_at(k);
    out = nfopidn_guarded_step(&guarded, &pose, &wanted).left + other.x;
  }
  return 0;
}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A controller and a table of 301 samples: 7.8 kB, nearly four times an ATmega328P's RAM."""
    target = tmp_path_factory.mktemp("avr")
    scenario = Scenario(Trajectory.circle(period=60, dt=0.2))
    assert len(scenario.reference) == 301
    nfopidn.export_c(
        Controller.published(), target, scenario=scenario, hardware=True, reference=True
    )
    (target / "main.c").write_text(MAIN)
    return target


def test_tables_stay_in_flash(folder):
    program = folder / "program.elf"
    options = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-Os", "-mmcu=atmega328p"]
    compiled([compiler("avr-gcc"), *options, *folder.glob("*.c"), "-o", program])
    done = subprocess.run(
        [compiler("avr-size"), "-A", program], capture_output=True, text=True, check=True
    )
    sizes = {words[0]: int(words[1]) for words in map(str.split, done.stdout.splitlines()[2:8])}
    assert sizes[".text"] > 301 * 26
    assert sizes[".data"] + sizes[".bss"] < 400


def test_every_number_is_read_from_flash(folder, tmp_path):
    """With memory whose address is off by an offset, as flash is on AVR."""
    (tmp_path / "avr").mkdir()
    (tmp_path / "avr" / "pgmspace.h").write_text(
        "#include <string.h>\n"
        "#define PROGMEM\n"
        "#define pgm_read_float(address) (*(address) + (float)FLASH_OFFSET)\n"
        "#define memcpy_P(to, from, size) "
        "(memcpy(to, from, size), ((to)->x += (float)FLASH_OFFSET, (void *)0))\n"
    )
    main = MAIN.replace("return 0;", 'printf("%a %a", out, nfopidn_reference_at(0).x); return 0;')
    (tmp_path / "main.c").write_text(f"#include <stdio.h>\n{main}")
    sources = list(folder.glob("nfopidn*.c"))

    def run(*options):
        program = tmp_path / "program"
        command = [compiler("gcc"), "-std=c99", "-O1", "-I", tmp_path, "-I", folder, *options]
        compiled([*command, tmp_path / "main.c", *sources, "-o", program])
        return subprocess.run([program], capture_output=True, text=True, check=True).stdout.split()

    plain = run()
    assert run("-D__AVR__", "-DFLASH_OFFSET=0") == plain
    moved = run("-D__AVR__", "-DFLASH_OFFSET=1")
    assert float.fromhex(moved[1]) == float.fromhex(plain[1]) + 1
    assert moved[0] != plain[0]


def test_the_files_compile_without_a_warning(folder):
    for source in folder.glob("nfopidn*.c"):
        compiled([compiler("avr-gcc"), *STRICT, "-mmcu=atmega2560", "-Os", "-fsyntax-only", source])
