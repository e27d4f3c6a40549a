"""What stands in tests/mutants.txt and tests/uncovered.txt: names, each with a reason."""


def read(path):
    """Give the reason of each name. A reason is indented under the names it belongs to."""
    reasons = {}
    names = []
    ended = False
    for line in path.read_text().splitlines():
        if line.startswith("    "):
            for name in names:
                reasons[name] = f"{reasons[name]} {line.strip()}".strip()
            ended = True
        elif line and not line.startswith("#"):
            names = [line] if ended else [*names, line]
            reasons[line] = ""
            ended = False
    return reasons
