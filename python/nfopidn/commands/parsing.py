"""The command line's words, with the nearest known word where one is unknown."""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping, Sequence

from nfopidn.arguments import suggestion


def parse(
    parser: argparse.ArgumentParser,
    commands: Mapping[str, argparse.ArgumentParser],
    words: Sequence[str],
) -> argparse.Namespace:
    """Return what parser.parse_args() returns; it exits with 2 likewise, after a better message."""
    first = words[0] if words else ""
    if first and not first.startswith("-") and first not in commands:
        hint = suggestion(first, commands)
        parser.error(f"{first!r} is no command{hint}; known: {', '.join(commands)}")
    arguments, unknown = parser.parse_known_args(words)
    if unknown:
        used = commands.get(first, parser)
        option = next((word for word in unknown if word.startswith("--")), "").partition("=")[0]
        known = set(re.findall(r"--[\w-]+", used.format_usage()))
        used.error(
            f"unrecognized arguments: {' '.join(unknown)}{suggestion(option, sorted(known))}"
        )
    return arguments
