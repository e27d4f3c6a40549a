"""What every exported language needs of a controller and its scenario, and how it is written."""

from __future__ import annotations

import json
import keyword
import os
import re
from pathlib import Path
from string import Template
from typing import NamedTuple

import numpy as np

from nfopidn._core import LEAST_SPEED_SCALE, Controller, Scenario, __version__
from nfopidn.arguments import check_sample_time, scenario_or_published
from nfopidn.robustness.verdict import Verdict, digest

PAPER = [[0.0, 1.0, 1.0], [1.0, 1.0, 0.0]]
DECOUPLED = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0]]
_NAMED = {"paper": PAPER, "decoupled": DECOUPLED}
_LONGEST_SCENARIO = 2000  # characters in the header's comment
_LINE = 96

# Words that a name must not be: it becomes a file, a prefix in C and a namespace in C++.
_RESERVED_TEXT = """
alignas alignof and_eq asm bitand bitor char8_t char16_t char32_t co_await co_return co_yield compl
concept consteval constexpr constinit const_cast decltype dynamic_cast explicit linux mutable
noexcept not_eq nullptr or_eq reinterpret_cast requires static_assert static_cast thread_local
typeid typeof typeof_unqual unix wchar_t xor xor_eq
auto break case char class const continue default delete do double else enum extern float for friend
goto if inline int long namespace new operator private protected public register restrict return
short signed sizeof static struct switch template this throw try typedef typename union unsigned
using virtual void volatile while std export bool true false
"""
_RESERVED = frozenset(_RESERVED_TEXT.split())

_LONGEST_MEMORY = 1024  # samples


class Design(NamedTuple):
    """What both languages need of a controller, in single precision."""

    taps: np.ndarray[tuple[int, ...], np.dtype[np.float32]]
    allocation: list[list[float]]
    limit: np.float32
    speed_scale: np.float32
    law: dict[str, np.float32]  # Controller.law_parameters
    sample_time: np.float32  # [s], of the tracking law's speed errors; 0: it has none


def literal(number: float | np.float32) -> str:
    """Shortest decimal that reads back as the same float, as C and C++ write it."""
    text = np.format_float_scientific(np.float32(number), trim="-")
    value, exponent = text.split("e")
    if -4 <= int(exponent) < 7:
        text = np.format_float_positional(np.float32(number), trim="0")
    elif "." not in value:
        text = f"{value}.0e{exponent}"
    return f"{text}F"


def check_name(name: str) -> None:
    """Refuse what is no identifier of C and C++."""
    identifier = re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name, re.ASCII) is not None
    if not identifier or name in _RESERVED or keyword.iskeyword(name) or "__" in name:
        raise ValueError(f"name is {name!r}; must be an identifier of C and C++, as 'nfopidn'")


def design_of(controller: Controller, scenario: Scenario | None) -> Design:
    """Round to single precision; refuse what a float cannot hold."""
    if scenario is not None:
        check_sample_time(controller, scenario_or_published(scenario))
    if controller.memory > _LONGEST_MEMORY:
        raise ValueError(
            f"memory is {controller.memory:g}; must be in [0, {_LONGEST_MEMORY}] for firmware, "
            "which runs taps alone"
        )
    taps = np.asarray(controller.taps)
    with np.errstate(over="ignore"):
        single = taps.astype(np.float32)
    if not np.isfinite(single).all():
        worst = float(taps.ravel()[np.abs(taps).argmax()])
        raise ValueError(f"a tap is {worst:g}; must be a number that a float can hold")
    scale = controller.speed_scale
    if scale == 0.0 and scenario is not None:
        scale = scenario.trajectory.peak_speed
    if controller.lateral == "speed" and not scale > 0.0:
        raise ValueError(
            'lateral is "speed" and speed_scale is 0, that is the peak speed of a trajectory; '
            "give the scenario, or set speed_scale"
        )
    allocation = controller.allocation
    matrix = _NAMED[allocation] if isinstance(allocation, str) else np.asarray(allocation).tolist()
    limit = np.float32(3.078 if scenario is None else scenario.torque_limit)
    # As the law in the core: a lesser scale has no inverse in single precision.
    scale = max(scale, LEAST_SPEED_SCALE) if scale > 0.0 else 1.0
    law = {name: np.float32(number) for name, number in controller.law_parameters.items()}
    dt = _sample_time(controller, scenario)
    return Design(single, matrix, limit, np.float32(scale), law, np.float32(dt))


def _sample_time(controller: Controller, scenario: Scenario | None) -> float:
    if controller.net != "speed-errors":
        return 0.0
    if controller.sample_time is not None:
        return controller.sample_time
    if scenario is None:
        raise ValueError(
            'sample_time is unknown, and with net "speed-errors" the law needs it; give the '
            "scenario, or set sample_time"
        )
    return scenario.trajectory.dt


def origin_of(
    controller: Controller, scenario: Scenario | None, verdict: Verdict | None, prefix: str
) -> str:
    """Lines that tell where the code comes from."""
    settings = json.loads(controller.to_json())
    lines = [f"Library: nfopidn {__version__}", f"Controller: {controller!r}", "Settings:"]
    lines += [f"  {key}: {json.dumps(value)}" for key, value in settings.items() if key != "taps"]
    if scenario is None:
        lines.append("Scenario: none given; torque limit 3.078 N m")
        if controller.sample_time is not None:
            lines.append(_sample_time_line(controller.sample_time))
        else:
            lines.append("Sample time: not known. The gains hold for one alone.")
    else:
        text = scenario.to_json()
        if len(text) > _LONGEST_SCENARIO:
            trajectory = scenario.trajectory
            text = f"{len(trajectory)} samples every {trajectory.dt:g} s of {trajectory.name}"
        lines += [
            f"Scenario: {text}",
            _sample_time_line(scenario.trajectory.dt),
        ]
    lines.append(_verdict_line(controller, scenario, verdict))
    return folded(lines, prefix)


def _verdict_line(
    controller: Controller, scenario: Scenario | None, verdict: Verdict | None
) -> str:
    if verdict is None or verdict.controller_digest != digest(controller):
        return "Verdict: not verified. nfopidn.verdict() judges a controller on a scenario."
    own = f"on scenario {verdict.scenario_digest}, {verdict.line}"
    if not verdict.is_of(controller, scenario):
        return f"Verdict: not verified on this scenario; {own}"
    return f"On scenario {verdict.scenario_digest}, {verdict.line}"


def _sample_time_line(dt: float) -> str:
    return f"Sample time: {dt:g} s. The gains hold for it alone."


def folded(lines: list[str], prefix: str) -> str:
    """Lines of a comment, none too long and none that would end it."""
    result = []
    for line in lines:
        rest = line.replace("*/", "* /").replace("\\", "/")
        while len(rest) > _LINE - len(prefix):
            cut = rest.rfind(" ", 1, _LINE - len(prefix))
            comma = rest.rfind(",", 1, _LINE - len(prefix)) + 1
            cut = max(cut, comma) if max(cut, comma) > 8 else _LINE - len(prefix)
            result.append(rest[:cut].rstrip())
            rest = "    " + rest[cut:].lstrip()
        result.append(rest)
    return "\n".join(f"{prefix}{line}".rstrip() for line in result)


def table(taps: np.ndarray[tuple[int, ...], np.dtype[np.float32]]) -> str:
    """Rows of an initialiser."""
    rows = []
    for row in taps:
        lines = [""]
        for tap in row:
            word = literal(tap) + ","
            if len(lines[-1]) + len(word) + 1 > _LINE - 8:
                lines.append("")
            lines[-1] = f"{lines[-1]} {word}".strip()
        rows.append("    {" + "\n     ".join(lines).rstrip(",") + "},")
    return "\n".join(rows)


def write(directory: str | os.PathLike[str], texts: dict[str, str]) -> list[Path]:
    """Write every file under a temporary name, then rename: the old file or the new one stands."""
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for file, text in texts.items():
        path = folder / file
        partial = folder / f".{file}.{os.getpid()}"
        try:
            partial.write_text(text, encoding="utf-8")
            partial.replace(path)
        finally:
            partial.unlink(missing_ok=True)
        paths.append(path)
    return paths


def template(file: str) -> Template:
    """Read one of the texts in the folder templates."""
    return Template(fragment(file))


def fragment(file: str) -> str:
    """Read one of which nothing is replaced."""
    return (Path(__file__).parent / "templates" / f"{file}.in").read_text(encoding="utf-8")
