"""The arithmetic that results are defined in, for what NumPy computes.

Another library may have left another rounding, or "flush to zero", on in the thread. The core looks
at each call; the functions here do for what they compute in Python.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from nfopidn._core import StandardArithmetic

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def in_standard_arithmetic(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Make a function one that rounds to nearest, whatever was left on, which it leaves on again.

    It is one call more between the function and its caller, for warnings that name the line.
    """

    @wraps(function)
    def called(*arguments: Arguments.args, **words: Arguments.kwargs) -> Result:
        with StandardArithmetic():
            return function(*arguments, **words)

    return called
