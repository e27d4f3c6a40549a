"""Builds the firmware, runs it in the emulator, compares its torques and counts its instructions.

    python examples/firmware/run.py [--build DIRECTORY] [--json FILE]

Exit code 0: every bar is met; 1: one is missed; 2: a tool is missing or failed. The bars are those
of bench/firmware.md.
"""

from __future__ import annotations

import argparse
import csv
import json
import re
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
MEMORY = 5
TICK = 40  # instructions: SysTick runs at 25 MHz, an instruction takes 1 ns with shift=0
VARIANTS = ("firmware", "firmware_any", "firmware_tap", "firmware_linear")
FORBIDDEN = re.compile(
    r"malloc|calloc|realloc|\bfree\b|_Zn[wa]|_Zd[la]|__cxa|__gxx|_Unwind|__aeabi_unwind|__aeabi_d"
    r"|__aeabi_[a-z0-9]*2d\b|__gnu_d|_ZTI|_ZSt"
)
# Name in the report, bar, unit.
BARS = (
    ("instructions_worst", 280, "instructions, worst control step at M = 5"),
    ("flash_step", 1200, "bytes of flash for the step"),
    ("ram_memory", 192, "bytes of RAM for taps, errors and torques"),
    ("ram_all", 240, "bytes of RAM in all"),
    ("error_run", 1e-4, "N m, float from double over the whole run"),
    ("error_step", 1e-6, "N m, float from double for the same inputs"),
    ("bits_differ", 0, "torques whose bits differ between board and host"),
    ("symbols", 0, "forbidden symbols in the control object"),
)


def output(*words: object) -> str:
    """Run a command, which must succeed; returns its standard output."""
    done = subprocess.run(
        [str(word) for word in words], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        sys.stderr.write(done.stdout + done.stderr)
        raise RuntimeError(f"{words[0]} failed")
    return done.stdout


def build(directory: Path) -> None:
    """Host program first: it makes the recording that the board's programs contain."""
    common = ["-S", HERE, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release"]
    host, board = directory / "host", directory / "board"
    output("cmake", *common, "-B", host)
    output("cmake", "--build", host, "--target", "record")
    recording = directory / "recording"
    recording.mkdir(exist_ok=True)
    output(host / "record", recording)
    output(
        *("cmake", *common, "-B", board, f"-DNFOPIDN_RECORDING={recording}"),
        f"-DCMAKE_TOOLCHAIN_FILE={HERE / 'cortex-m4f.cmake'}",
    )
    output("cmake", "--build", board)


def emulate(program: Path, *options: object) -> list[str]:
    """Lines that the program prints."""
    return output(
        *("qemu-system-arm", "-M", "mps2-an386", "-nographic", "-monitor", "none"),
        *("-serial", "none", "-chardev", "stdio,id=out"),
        *("-semihosting-config", "enable=on,target=native,chardev=out"),
        *("-kernel", program, *options),
    ).splitlines()


def control_object(board: Path, variant: str) -> Path:
    """Object file of the control step alone."""
    return next((board / "CMakeFiles" / f"{variant}_control.dir").glob("control.cpp.o*"))


def symbols(path: Path) -> dict[str, tuple[int, int]]:
    """Address and size by demangled name up to its parameters."""
    found = {}
    for line in output("arm-none-eabi-nm", "-SC", path).splitlines():
        match = re.match(r"([0-9a-f]+) ([0-9a-f]+) \w ([^(]+|\(.*)", line)
        if match:
            found[match[3].strip()] = (int(match[1], 16), int(match[2], 16))
    return found


def count_instructions(program: Path, scratch: Path) -> list[int]:
    """Instructions of each control step, first to last: one translated block each, each logged."""
    begin, size = symbols(program)["control_step"]
    emulate(
        *(program, "-singlestep", "-d", "exec,nochain", "-D", scratch),
        *("-dfilter", f"{begin & ~1:#x}+{size:#x}"),
    )
    counts: list[int] = []
    with scratch.open() as lines:
        for line in lines:
            match = re.search(r"\[[0-9a-f]+/([0-9a-f]+)/", line)
            if not match:
                continue
            if int(match[1], 16) == begin & ~1:
                counts.append(0)
            counts[-1] += 1
    scratch.unlink()
    return counts


def number(bits: str) -> float:
    """Float of a bit pattern in hexadecimal."""
    return float(struct.unpack(">f", bytes.fromhex(bits))[0])


def compare_torques(lines: list[str], expected: list[dict[str, str]]) -> dict[str, Any]:
    """Bits against the host's; values of the recorded run against the double controller's."""
    if len(lines) != len(expected):
        raise RuntimeError(f"the program printed {len(lines)} torques, not {len(expected)}")
    differ, error_run, error_step = 0, 0.0, 0.0
    for line, row in zip(lines, expected, strict=True):
        for bits, side in zip(line.split(), ("left", "right"), strict=True):
            differ += bits != row[side]
            if row["run"] == "recorded":
                value = number(bits)
                error_run = max(error_run, abs(value - float(row[f"run_{side}"])))
                error_step = max(error_step, abs(value - float(row[f"same_{side}"])))
    return {
        "torques": 2 * len(lines),
        "bits_differ": differ,
        "error_run": error_run,
        "error_step": error_step,
    }


def measure(directory: Path) -> dict[str, Any]:
    """Every figure of the report."""
    board = directory / "board"
    with (directory / "recording" / "torques.csv").open() as rows:
        expected = list(csv.DictReader(rows))
    recorded = sum(row["run"] == "recorded" for row in expected)

    *lines, last = emulate(board / "firmware.elf", "-icount", "shift=0")
    report = compare_torques(lines, expected)
    ticks, samples = (int(word, 16) for word in last.split()[1:])
    report["instructions_by_icount"] = ticks * TICK / samples  # with the call and the loop

    counts = {
        name: count_instructions(board / f"{name}.elf", directory / "trace.log")
        for name in VARIANTS
    }
    main = counts["firmware"]
    report["steps_counted"] = len(main)
    report["instructions_worst"] = max(main)
    report["instructions_worst_recorded"] = max(main[:recorded])
    report["instructions_mean_recorded"] = sum(main[:recorded]) / recorded
    report["instructions_any_structure"] = max(counts["firmware_any"])
    # Of the step's longest path each, so that they differ by the tap or the neuron alone.
    tap = (max(counts["firmware_tap"]) - max(main)) / 3
    neuron = (max(main) - max(counts["firmware_linear"])) / 3
    report["instructions_a_tap"] = tap
    report["instructions_a_neuron"] = neuron
    report["instructions_a_channel"] = (MEMORY + 2) * tap + neuron

    step, law = {}, {}
    for name in VARIANTS:
        table = symbols(control_object(board, name))
        step[name] = table["control_step"][1]
        law[name] = table["(anonymous namespace)::law"][1]
    report["flash_step"] = step["firmware"]
    report["flash_any_structure"] = step["firmware_any"]
    report["flash_a_tap"] = (step["firmware_tap"] - step["firmware"]) / 3
    report["ram_all"] = law["firmware"]
    report["ram_any_structure"] = law["firmware_any"]
    report["ram_a_tap"] = (law["firmware_tap"] - law["firmware"]) / 3
    report["ram_memory"] = 4 * (3 * (MEMORY + 2) + 3 * (MEMORY + 1) + 2)

    unit = control_object(board, "firmware")
    undefined = output("arm-none-eabi-nm", "-u", unit).split()[1::2]
    report["undefined"] = undefined
    report["symbols"] = sum(bool(FORBIDDEN.search(name)) for name in undefined)
    report["size"] = output("arm-none-eabi-size", unit).splitlines()[-1].split()[:3]
    usage = next(unit.parent.glob("control.cpp*.su")).read_text()
    report["stack"] = {
        re.sub(r".*?(control_\w+).*", r"\1", line.split("\t")[0]): int(line.split("\t")[1])
        for line in usage.splitlines()
    }
    return report


def show(report: dict[str, Any]) -> bool:
    """Print the figures; whether every bar is met."""
    met = True
    for name, bar, text in BARS:
        good = report[name] <= bar
        met = met and good
        print(f"{report[name]:>12.4g} <= {bar:<8g} {'' if good else 'MISSED  '}{text}")
    print()
    for name, value in report.items():
        if name not in {bar[0] for bar in BARS}:
            text = f"{value:.4g}" if isinstance(value, float) else json.dumps(value)
            print(f"{name:28} {text}")
    return met


def main() -> int:
    """Build, run, report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--build", type=Path, default=ROOT / "build" / "firmware")
    parser.add_argument("--json", type=Path, help="write the figures here")
    arguments = parser.parse_args()
    arguments.build.mkdir(parents=True, exist_ok=True)
    try:
        build(arguments.build)
        report = measure(arguments.build)
    except (OSError, RuntimeError) as error:
        print(f"run.py: {error}", file=sys.stderr)
        return 2
    if arguments.json:
        arguments.json.write_text(json.dumps(report, indent=1))
    return 0 if show(report) else 1


if __name__ == "__main__":
    sys.exit(main())
