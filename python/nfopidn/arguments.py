"""Refusals that several modules share."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import Controller, Rival, Scenario

_MOST = 10**9


def is_number(value: Any) -> bool:
    """Whether a value is a real number, infinity included, and no bool."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real):
        return False
    try:
        return not np.isnan(float(value))
    except (OverflowError, TypeError):
        return False


def shown(value: Any) -> str:
    """Return a value as a message shows it: whole numbers of many digits by their number."""
    if isinstance(value, int) and abs(value) >= 10**40:
        # Not by their text, which Python refuses to make of the longest.
        digits = int(value.bit_length() * 0.30103) + 1
        return f"a whole number of about {digits} digits"
    try:
        return repr(value)
    except ValueError:  # of a list with such a number
        return f"a {type(value).__name__} with a number of too many digits"


def suggestion(word: Any, known: Iterable[str]) -> str:
    """Return " (did you mean 'mass'?)", to stand behind the refused word; empty if none is near.

    Case does not count.
    """
    if not isinstance(word, str):
        return ""
    by_lower = {name.lower(): name for name in known}
    near = get_close_matches(word.lower(), by_lower, n=1)
    return f" (did you mean {by_lower[near[0]]!r}?)" if near else ""


def check_encoding(what: str, text: str) -> None:
    """Refuse a text that no file and no core can hold.

    Raises
    ------
    ValueError
        It has halves of surrogate pairs, as Python makes of names that are not UTF-8.
    """
    try:
        text.encode()
    except UnicodeEncodeError:
        raise ValueError(f"{what}{text!r} is not UTF-8") from None


def real_numbers(name: str, given: Any) -> NDArray[np.float64]:
    """Return an array of numbers, a new one.

    Raises
    ------
    ValueError
        Texts, objects, complex numbers, or a whole number beyond every double.
    """
    try:
        kind = np.asarray(given).dtype.kind
        if kind in "biuf" or (kind == "O" and all(map(is_number, np.ravel(given)))):
            return np.array(given, dtype=float)
    except (TypeError, ValueError, OverflowError):
        pass
    raise ValueError(f"{name} must be real numbers")


def whole_number(name: str, value: Any, least: int, most: int = _MOST) -> int:
    """Return a whole number in [least, most], 1e9 if not given.

    Raises
    ------
    ValueError
        Names the argument, its value and the range.
    """
    whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not whole or not least <= int(value) <= most:
        end = "1e9" if most == _MOST else most
        raise ValueError(f"{name} is {shown(value)}; must be a whole number in [{least}, {end}]")
    return int(value)


def names_in(what: str, names: Any) -> list[str]:
    """Return a list of names.

    Raises
    ------
    ValueError
        One text, which would be read letter by letter, or no texts.
    """
    if isinstance(names, str) or not isinstance(names, Iterable):
        raise ValueError(f"{what} is {names!r}; must be a list of names")
    listed = list(names)
    for name in listed:
        if not isinstance(name, str):
            raise ValueError(f"{what} has {name!r}; must be a list of names")
    return listed


def real_number(name: str, value: Any, least: float, most: float, unit: str = "") -> float:
    """Return a number in [least, most].

    Raises
    ------
    ValueError
        Names the argument, its value and the range.
    """
    if not is_number(value) or not least <= float(value) <= most:
        raise ValueError(f"{name} is {shown(value)}; must be in [{least:g}, {most:g}]{unit}")
    return float(value)


def scenario_or_published(scenario: Any) -> Scenario:
    """Return the scenario, for None the published one.

    Raises
    ------
    ValueError
        No scenario.
    """
    if scenario is None:
        return Scenario.published(rng=0)
    if not isinstance(scenario, Scenario):
        raise ValueError(f"scenario is {scenario!r}; must be a Scenario")
    return scenario


def controller_or_published(controller: Any, scenario: Scenario) -> Controller:
    """Return the controller, for None the published one.

    Raises
    ------
    ValueError
        A rival, no controller, or one made for another sample time than the scenario's.
    """
    if controller is None:
        return Controller.published()
    check_sample_time(no_rival(controller), scenario)
    return no_rival(controller)


def check_sample_time(controller: Any, scenario: Scenario) -> None:
    """Refuse a controller made for another sample time than the scenario's.

    One that does not know its own fits any, and so does a rival: its parameters are of continuous
    time, and what it needs of the sample time it takes from the scenario.

    Raises
    ------
    ValueError
        Names both sample times.
    """
    if isinstance(controller, Controller):
        _core.check_sample_time(controller, scenario.trajectory.dt)


def no_rival(controller: Any) -> Controller:
    """Return an NFOPIDN controller.

    Raises
    ------
    ValueError
        A rival, which has neither taps nor orders, or no controller at all.
    """
    if isinstance(controller, Rival):
        raise ValueError(f"controller is the rival {controller.law!r}; must be a Controller")
    if not isinstance(controller, Controller):
        raise ValueError(f"controller is {controller!r}; must be a Controller")
    return controller
