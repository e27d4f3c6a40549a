"""The command line's words, with the nearest known word where one is unknown."""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

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


def pairs(words: Sequence[str], option: str, numbers: int) -> dict[str, Any]:
    """Read NAME=VALUE words; a value is a text, a number or two numbers with a colon."""
    result: dict[str, Any] = {}
    for word in words:
        name, equals, value = word.partition("=")
        parts = value.split(":")
        if not equals or (numbers and len(parts) != numbers):
            form = {0: "NAME=NAME", 1: "NAME=NUMBER", 2: "NAME=LOW:HIGH"}[numbers]
            raise ValueError(f"--{option} {word}: must be {form}")
        try:
            read = tuple(float(part) for part in parts) if numbers else value
        except ValueError:
            raise ValueError(f"--{option} {word}: {value} is no number") from None
        if numbers and not all(isfinite(float(number)) for number in read):
            raise ValueError(f"--{option} {word}: must be finite")
        if name in result:
            raise ValueError(f"--{option} {word}: {name} is given twice")
        result[name] = read[0] if numbers == 1 else read
    return result


def limits(words: Sequence[str], option: str) -> dict[str, tuple[float | None, float | None]]:
    """Read NAME=LOW:HIGH words of which either end may be left away; infinity is none."""
    result: dict[str, tuple[float | None, float | None]] = {}
    for word in words:
        name, equals, value = word.partition("=")
        parts = value.split(":")
        if not equals or len(parts) != 2:
            raise ValueError(f"--{option} {word}: must be NAME=LOW:HIGH, NAME=LOW: or NAME=:HIGH")
        try:
            low, high = (float(part) if part else None for part in parts)
        except ValueError:
            raise ValueError(f"--{option} {word}: {value} is no pair of numbers") from None
        if name in result:
            raise ValueError(f"--{option} {word}: {name} is given twice")
        result[name] = (low, high)
    return result
