"""Prints which lines and branches of the core the tests have reached, by gcovr.

Exits with 1 when they are fewer than 95 % of the lines, or when an uncovered line has no reason in
tests/uncovered.txt.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import explained

REPOSITORY = Path(__file__).resolve().parents[1]
LEAST_SHARE = 0.95


def measure(build):
    """Print gcovr's tables of lines and of branches; give its counts."""
    command = ["gcovr", "--root", str(REPOSITORY), "--filter", "cpp/include/nfopidn/"]
    command += ["--exclude-throw-branches", "--exclude-unreachable-branches"]
    with tempfile.TemporaryDirectory() as folder:
        counts = Path(folder) / "counts.json"
        subprocess.run([*command, "--json", str(counts), build], cwd=REPOSITORY, check=True)
        again = [*command, "--add-tracefile", str(counts)]
        subprocess.run(again, cwd=REPOSITORY, check=True)
        subprocess.run([*again, "--branches"], cwd=REPOSITORY, check=True)
        return json.loads(counts.read_text())["files"]


def main():
    reasons = explained.read(REPOSITORY / "tests" / "uncovered.txt")
    total = reached = unexplained = 0
    print("\nLines that no test reaches:")
    for file in measure(sys.argv[1]):
        code = (REPOSITORY / file["file"]).read_text().splitlines()
        name = file["file"].removeprefix("cpp/include/nfopidn/")
        for line in file["lines"]:
            if line["gcovr/noncode"]:
                continue
            total += 1
            reached += line["count"] > 0
            if line["count"] > 0:
                continue
            text = code[line["line_number"] - 1].strip()
            reason = reasons.get(f"{name}: {text}", "")
            unexplained += not reason
            print(f"{name}:{line['line_number']}: {text}\n    {reason or 'NO REASON GIVEN'}")
    print(f"{reached} of {total} lines reached, {100 * reached / total:.2f} %")
    return int(reached < LEAST_SHARE * total or unexplained > 0)


if __name__ == "__main__":
    sys.exit(main())
