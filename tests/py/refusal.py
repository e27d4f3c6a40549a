"""Good calls to spoil, and how the tests state that something is refused, and with what words."""

from contextlib import contextmanager

import pytest
from nfopidn import Controller, Scenario, Trajectory

LINE = Trajectory.line(period=2)


def controller(**settings):
    return Controller(**({"gains": [[1.0] * 3] * 3, "alpha": 0.1, "sigma": 0.8} | settings))


def scenario(**settings):
    return Scenario(LINE, **settings)


def from_samples(**settings):
    return Trajectory.from_samples(**({"x": [0, 1, 2], "y": [0, 1, 3], "dt": 0.1} | settings))


@contextmanager
def refused(*parts, exception=ValueError):
    """Expect exactly this exception, in one line that contains all the parts."""
    with pytest.raises(exception) as caught:
        yield
    message = str(caught.value)
    assert caught.type is exception
    assert all(part in message for part in parts), message
    assert "\n" not in message
