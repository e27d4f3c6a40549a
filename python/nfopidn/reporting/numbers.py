"""Numbers as a page has them: short ones for figures, readable ones for tables."""

from __future__ import annotations

from collections.abc import Iterable
from math import floor, isfinite, log

Short = list[float | int | None]

_TIMES_TEN = "\u202f\N{MULTIPLICATION SIGN}\u202f10"
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _short(number: float, digits: int) -> float | int | None:
    if not isfinite(number):
        return None
    rounded = float(f"{number:.{digits}g}")
    return int(rounded) if rounded.is_integer() and abs(rounded) < 1e9 else rounded


def short(numbers: Iterable[float], digits: int = 6) -> Short:
    """Round to some significant digits; what is not finite becomes None."""
    return [_short(float(number), digits) for number in numbers]


def readable(number: float, digits: int = 4) -> str:
    """Write a number for people: a true minus, powers of ten raised."""
    if not isfinite(number):
        return "not finite"
    mantissa, _, exponent = f"{number:.{digits}g}".partition("e")
    text = mantissa.replace("-", "\N{MINUS SIGN}")
    return text if not exponent else f"{text}{_TIMES_TEN}{_raised(int(exponent))}"


def readable_power(logarithm: float, digits: int = 4) -> str:
    """Write e to the power of a logarithm, which may lie beyond every float."""
    if not isfinite(logarithm):
        return "0" if logarithm < 0 else "not finite"
    decades = logarithm / log(10)
    if abs(decades) < 300:
        return readable(10**decades, digits)
    exponent = floor(decades)
    return f"{10 ** (decades - exponent):.{digits}g}{_TIMES_TEN}{_raised(exponent)}"


def _raised(exponent: int) -> str:
    return str(exponent).translate(_SUPERSCRIPTS)
