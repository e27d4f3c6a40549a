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
from collections.abc import Iterable
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
MEMORY = 5
TICK = 40  # instructions: SysTick runs at 25 MHz, an instruction takes 1 ns with shift=0
VARIANTS = ("firmware", "firmware_any", "firmware_tap", "firmware_linear", "firmware_tracking")
LAWS = {"paper": "firmware", "tracking": "firmware_tracking"}
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
    ("tracking_instructions_worst", 520, "instructions, worst step of the tracking law"),
    ("tracking_flash_step", 2300, "bytes of flash for it"),
    ("tracking_ram_all", 320, "bytes of RAM for it in all"),
    ("tracking_error_run", 1e-4, "N m, float from double over the whole run"),
    ("tracking_error_step", 1e-6, "N m, float from double for the same inputs"),
    ("tracking_bits_differ", 0, "torques whose bits differ between board and host"),
    ("tracking_symbols", 0, "forbidden symbols in its control object"),
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
    output("cmake", "--build", host, "--target", *(f"record_{law}" for law in LAWS))
    recording = directory / "recording"
    for law in LAWS:
        (recording / law).mkdir(parents=True, exist_ok=True)
        output(host / f"record_{law}", recording / law)
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


def step_functions(unit: Path) -> dict[str, int]:
    """Sizes of the control step and of what of its object it calls."""
    code = re.findall(r"\w+ (\w+) [TtW] ([^(\n]+)", output("arm-none-eabi-nm", "-SC", unit))
    return {name: int(size, 16) for size, name in code if name != "control_reset"}


def count_instructions(program: Path, functions: Iterable[str], scratch: Path) -> list[int]:
    """Instructions of each control step, first to last: one translated block each, each logged."""
    table = symbols(program)
    begin, _ = table["control_step"]
    ranges = (f"{table[name][0] & ~1:#x}+{table[name][1]:#x}" for name in functions)
    emulate(
        *(program, "-singlestep", "-d", "exec,nochain", "-D", scratch),
        *("-dfilter", ",".join(ranges)),
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


def run_law(directory: Path, law: str) -> tuple[dict[str, Any], int]:
    """Torques of a law's program against the host's, and how many steps the recorded run has."""
    with (directory / "recording" / law / "torques.csv").open() as rows:
        expected = list(csv.DictReader(rows))
    program = directory / "board" / f"{LAWS[law]}.elf"
    *lines, last = emulate(program, "-icount", "shift=0")
    report = compare_torques(lines, expected)
    ticks, samples = (int(word, 16) for word in last.split()[1:])
    report["instructions_by_icount"] = ticks * TICK / samples  # with the call and the loop
    return report, sum(row["run"] == "recorded" for row in expected)


def undefined_symbols(unit: Path) -> list[str]:
    """Names that an object file takes from elsewhere."""
    return output("arm-none-eabi-nm", "-u", unit).split()[1::2]


def forbidden(names: list[str]) -> int:
    """How many of them a control step must not need."""
    return sum(bool(FORBIDDEN.search(name)) for name in names)


def stack_of(unit: Path) -> dict[str, int]:
    """Stack of each control function [bytes]."""
    usage = next(unit.parent.glob("control.cpp*.su")).read_text()
    rows = [line.split("\t") for line in usage.splitlines()]
    name = re.compile(r".*?(control_\w+|(?<=:)log)\(.*")
    return {name.sub(r"\1", function): int(size) for function, size, *_ in rows}


def measure(directory: Path) -> dict[str, Any]:
    """Every figure of the report."""
    board = directory / "board"
    report, recorded = run_law(directory, "paper")
    tracking, _ = run_law(directory, "tracking")

    code = {name: step_functions(control_object(board, name)) for name in VARIANTS}
    counts = {
        name: count_instructions(board / f"{name}.elf", code[name], directory / "trace.log")
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
        step[name] = sum(code[name].values())
        law[name] = table["(anonymous namespace)::law"][1]
    report["flash_step"] = step["firmware"]
    report["flash_any_structure"] = step["firmware_any"]
    report["flash_a_tap"] = (step["firmware_tap"] - step["firmware"]) / 3
    report["ram_all"] = law["firmware"]
    report["ram_any_structure"] = law["firmware_any"]
    report["ram_a_tap"] = (law["firmware_tap"] - law["firmware"]) / 3
    report["ram_memory"] = 4 * (3 * (MEMORY + 2) + 3 * (MEMORY + 1) + 2)

    unit = control_object(board, "firmware")
    report["undefined"] = undefined_symbols(unit)
    report["symbols"] = forbidden(report["undefined"])
    report["size"] = output("arm-none-eabi-size", unit).splitlines()[-1].split()[:3]
    report["stack"] = stack_of(unit)

    counted = counts["firmware_tracking"]
    tracking["instructions_worst"] = max(counted)
    tracking["instructions_worst_recorded"] = max(counted[:recorded])
    tracking["instructions_mean_recorded"] = sum(counted[:recorded]) / recorded
    tracking["flash_step"] = step["firmware_tracking"]
    tracking["ram_all"] = law["firmware_tracking"]
    unit = control_object(board, "firmware_tracking")
    tracking["undefined"] = undefined_symbols(unit)
    tracking["symbols"] = forbidden(tracking["undefined"])
    tracking["stack"] = stack_of(unit)
    return report | {f"tracking_{name}": value for name, value in tracking.items()}


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
