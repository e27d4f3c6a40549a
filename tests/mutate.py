"""Breaks the core on purpose, one place at a time, and sees whether the C++ tests notice.

Each mutant is one change of one token in a header: a sign, an operator, a comparison, an index,
true or false, the lesser or the greater. The tests that cover the header are compiled against it,
the cheapest first, and run; one of an index or a loop that none of them kills is compiled again
with sanitizers. A mutant that does not compile is not counted, except where a static_assert of a
test refuses it. Those that tests/mutants.txt explains are listed apart. Exits with 1 when fewer
than 90 % are killed.
"""

import argparse
import collections
import concurrent.futures
import os
import queue
import random
import re
import resource
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import explained

REPOSITORY = Path(__file__).resolve().parents[1]
INCLUDE = Path("cpp/include/nfopidn")
WORK = REPOSITORY / "build" / "mutate"
EXPLAINED = REPOSITORY / "tests" / "mutants.txt"
LEAST_SHARE = 0.9

# The tests that cover a header, the cheapest to compile first.
TESTS = {
    "control/operator_weights.hpp": ["control/weights"],
    "control/tap_filter.hpp": [
        "control/fir",
        "control/controller_law",
        "control/controller_configure",
    ],
    "plant/robot.hpp": ["plant/robot", "plant/plant"],
    "plant/differential_drive.hpp": ["plant/plant", "plant/coulomb", "loop/loop"],
    "control/controller.hpp": [
        "control/structure",
        "control/controller_configure",
        "control/controller_anti_windup",
        "control/controller_law",
        "simulation/simulate",
        "tuning/lanes",
    ],
    "control/torque_limit.hpp": [
        "control/controller_anti_windup",
        "control/controller_law",
        "tuning/lanes",
    ],
    "loop/closed_loop.hpp": ["loop/loop", "simulation/simulate", "simulation/golden_run"],
    "loop/cost.hpp": ["loop/loop", "simulation/simulate", "tuning/lanes"],
    "loop/delay_line.hpp": ["loop/loop", "simulation/simulate"],
    "loop/heading.hpp": ["loop/loop", "simulation/simulate", "tuning/lanes"],
    "search/bfoa.hpp": ["search/bfoa", "search/search"],
    "simulation/simulate.hpp": ["simulation/simulate", "simulation/golden_run"],
}
COMPILER = os.environ.get("CXX", "clang++")  # compiles these in half of g++'s time
FLAGS = ["-std=gnu++17", "-O0", "-ffp-contract=off", "-D_GLIBCXX_ASSERTIONS", "-w"]
STATIC_ASSERTION = re.compile("static assertion failed|static_assert failed")  # GCC, Clang
SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
PRECOMPILED = ["gtest/gtest.h", "Eigen/Core", "fstream", "functional", "map", "random", "sstream"]

# What stands in a line, and what else could. Operators have spaces around them, which those of
# templates, pointers and references have not.
CHANGES = [
    (r"(?<= )\+(?= )", ["-"]),
    (r"(?<= )-(?= )", ["+"]),
    (r"(?<= )\*(?= )", ["/"]),
    (r"(?<= )/(?= )", ["*"]),
    (r"\+=", ["-="]),
    (r"-=", ["+="]),
    (r"(?<=[(,{=?:] )-(?=[\w(])|(?<=[({\[])-(?=[\w(])|(?<=return )-(?=[\w(])", [""]),
    (r"(?<= )<(?= )", ["<=", ">"]),
    (r"(?<= )>(?= )", [">=", "<"]),
    (r"(?<= )<=(?= )", ["<", ">"]),
    (r"(?<= )>=(?= )", [">", "<"]),
    (r"==", ["!="]),
    (r"!=", ["=="]),
    (r"&&(?= )", ["||"]),
    (r"(?<= )\|\|(?= )", ["&&"]),
    (r"(?<= )&(?= )", ["|"]),
    (r"(?<= )\|(?= )", ["&"]),
    (r"(?<=[(! ])!(?=[\w(])", [""]),
    (r"\btrue\b", ["false"]),
    (r"\bfalse\b", ["true"]),
    (r"\bminimum\b", ["maximum"]),
    (r"\bmaximum\b(?!_)", ["minimum"]),
    (r"\bmin\b", ["max"]),
    (r"\bmax\b", ["min"]),
    (r"\bleft\b(?!\()", ["right"]),
    (r"\bright\b(?!\()", ["left"]),
    (r"\bcosine\b", ["sine"]),
    (r"\bsine\b", ["cosine"]),
    (r"(?<![\w.])\d+(?![\w.])", ["next"]),
]


@dataclass(frozen=True)
class Mutant:
    header: str
    line: int
    before: str
    after: str

    @property
    def key(self):
        return f"{self.header}: {self.before.strip()} -> {self.after.strip()}"

    @property
    def may_leave_an_array(self):
        return "[" in self.before or "for (" in self.before


def code_lines(text):
    """Give the lines that compute: number and text, without comments.

    Left out are directives, templates' heads, static assertions and the tables of fields, whose
    words and ranges have tests of their own.
    """
    in_fields = False
    for number, line in enumerate(text.splitlines()):
        code = line.split("//")[0]
        in_fields = in_fields or "fields(Visitor&& visit)" in code
        skipped = in_fields or '"' in code
        skipped = skipped or code.lstrip().startswith(("#", "template", "static_assert", "case "))
        if in_fields and code.rstrip() == "  }":
            in_fields = False
        if not skipped:
            yield number, code


def mutants_of(header):
    text = (REPOSITORY / INCLUDE / header).read_text()
    lines = text.splitlines()
    for number, code in code_lines(text):
        for pattern, others in CHANGES:
            for found in re.finditer(pattern, code):
                for other in others:
                    new = str(int(found[0]) + 1) if other == "next" else other
                    after = lines[number][: found.start()] + new + lines[number][found.end() :]
                    yield Mutant(header, number, lines[number], after)


def limit_memory():
    """An endless loop that fills memory ends by itself."""
    resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))


def run(command, timeout, **options):
    """Give the exit status and the output; a run that hangs counts as failed."""
    try:
        done = subprocess.run(
            command,
            check=False,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=timeout,
            **options,
        )
    except subprocess.TimeoutExpired:
        return -1, "timeout"
    return done.returncode, done.stdout + done.stderr


class Tree:
    """A copy of headers and tests in which one mutant at a time is built."""

    def __init__(self, place):
        self.place = WORK / f"tree-{place}"
        shutil.rmtree(self.place, ignore_errors=True)
        for part in ("cpp/include", "cpp/src/batch", "tests/cpp", "tests/golden"):
            shutil.copytree(REPOSITORY / part, self.place / part)

    def compile(self, test, sanitize):
        folder, name = test.split("/")
        program = self.place / name
        flags = FLAGS + (
            SANITIZE if sanitize else ["-include-pch", str(WORK / "precompiled.hpp.pch")]
        )
        command = [COMPILER, *flags, f"-I{self.place}/cpp/include", "-isystem", eigen()]
        command += [f"-I{self.place}/cpp/src", f"-I{self.place}/tests/cpp"]  # the lanes; support
        command += [f'-DNFOPIDN_GOLDEN="{self.place}/tests/golden"']
        command += [f"{self.place}/tests/cpp/{folder}/test_{name}.cpp", "-o", str(program)]
        return program, *run([*command, "-lgtest_main", "-lgtest", "-lpthread"], 300)

    def passes(self, test, sanitize=False):
        """Say "passes", "killed", or "refused" where the compiler would have none of it."""
        program, status, output = self.compile(test, sanitize)
        if status != 0:
            return "killed" if STATIC_ASSERTION.search(output) else "refused"
        options = ["--gtest_brief=1", "--gtest_fail_fast"]
        # AddressSanitizer reserves more address space than any limit.
        status, _ = run([program, *options], 60, preexec_fn=None if sanitize else limit_memory)
        return "passes" if status == 0 else "killed"

    def judge(self, mutant):
        """Say "killed", "survived" or "refused"."""
        header = self.place / INCLUDE / mutant.header
        original = (REPOSITORY / INCLUDE / mutant.header).read_text()
        lines = original.split("\n")
        lines[mutant.line] = mutant.after
        header.write_text("\n".join(lines))
        try:
            for sanitize in (False, True) if mutant.may_leave_an_array else (False,):
                for test in TESTS[mutant.header]:
                    verdict = self.passes(test, sanitize)
                    if verdict != "passes":
                        return verdict
            return "survived"
        finally:
            header.write_text(original)


def eigen():
    return os.environ.get("EIGEN", "/usr/include/eigen3")


def precompile():
    WORK.mkdir(parents=True, exist_ok=True)
    header = WORK / "precompiled.hpp"
    header.write_text("".join(f"#include <{name}>\n" for name in PRECOMPILED))
    command = [COMPILER, *FLAGS, "-isystem", eigen(), "-x", "c++-header", str(header)]
    subprocess.run([*command, "-o", f"{header}.pch"], check=True)


def judge_all(mutants, count, jobs):
    """Judge mutants in their order until `count` of them have compiled."""
    trees = queue.SimpleQueue()
    for place in range(jobs):
        trees.put(Tree(place))
    begun = time.monotonic()
    verdicts = {}

    def judge(mutant):
        if sum(verdict != "refused" for verdict in verdicts.values()) >= count:
            return
        tree = trees.get()
        verdicts[mutant] = tree.judge(mutant)
        trees.put(tree)
        seconds = time.monotonic() - begun
        print(f"{seconds:6.0f} s  {verdicts[mutant]:8}  {mutant.key}", flush=True)

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        list(pool.map(judge, mutants))
    return verdicts


def check_unchanged():
    """Make sure that the tests pass as long as nothing is broken."""
    tree = Tree("unchanged")
    tests = dict.fromkeys(test for tests in TESTS.values() for test in tests)
    failing = [test for test in tests if tree.passes(test) != "passes"]
    if failing:
        sys.exit(f"mutate.py: these fail without a mutant: {', '.join(failing)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=110, help="mutants that compile (110)")
    parser.add_argument("--seed", type=int, default=1, help="of the sample (1)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--header", choices=TESTS, action="append", help="of these alone")
    parser.add_argument("--line", help="mutants of lines that contain this alone")
    arguments = parser.parse_args()
    headers = arguments.header or list(TESTS)
    mutants = [mutant for header in headers for mutant in mutants_of(header)]
    if arguments.line:
        mutants = [mutant for mutant in mutants if arguments.line in mutant.before]
    random.Random(arguments.seed).shuffle(mutants)
    print(f"{len(mutants)} mutants possible, {arguments.count} wanted")
    precompile()
    check_unchanged()
    verdicts = judge_all(mutants, arguments.count, arguments.jobs)
    return report(verdicts)


def report(verdicts):
    reasons = explained.read(EXPLAINED)
    survivors = [mutant for mutant, verdict in verdicts.items() if verdict == "survived"]
    excused = [mutant for mutant in survivors if mutant.key in reasons]
    missed = [mutant for mutant in survivors if mutant.key not in reasons]
    killed = collections.Counter(m.header for m, verdict in verdicts.items() if verdict == "killed")
    print()
    for header in TESTS:
        alive = sum(mutant.header == header for mutant in survivors)
        print(f"{header:16} {killed[header]:4} killed {alive:4} survived")
    for mutant in excused:
        print(f"explained: {mutant.key}\n    {reasons[mutant.key]}")
    for mutant in missed:
        print(
            f"survived: {mutant.header}:{mutant.line + 1}\n  - {mutant.before}\n  + {mutant.after}"
        )
    total = killed.total() + len(survivors)
    share = killed.total() / max(total, 1)
    print(
        f"{killed.total()} of {total} mutants killed, {100 * share:.1f} %; "
        f"{len(excused)} survivors explained, {len(missed)} not"
    )
    return int(share < LEAST_SHARE)


if __name__ == "__main__":
    sys.exit(main())
