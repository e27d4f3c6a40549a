"""The tracking law's loop: margins on a line against the map's eigenvalues, and against runs."""

import json

import numpy as np
import pytest
from nfopidn import Controller, Scenario, Trajectory, stability

LAW = {
    "allocation": "decoupled",
    "lateral": "scheduled",
    "net": "speed-errors",
    "speed_gain_x": 12.4,
    "speed_gain_theta": 2.8,
    "speed_order_x": 1.14,
    "speed_order_theta": 1.26,
    "amplitude_x": 0.65,
    "amplitude_y": 7.9,
    "amplitude_theta": 0.233,
    "pole_x": 0.083,
    "pole_theta": 0.24,
    "integral_x": 0.0223,
    "integral_y": 0.0017,
    "integral_theta": 0.001,
    "integral_retention": 0.9925,
    "integral_limit": 0.155,
    "lateral_speed": 0.223,
    "lateral_power": 1.55,
}
GAINS = [[1.97, 0, 0], [0.317, 0, 0], [0.881, 0, 0]]
LINE = Trajectory.line(period=60, dt=0.2)


def controller(**changes):
    return Controller(GAINS, 0.5, 0.5, **{**LAW, **changes})


CASES = [
    ({}, {}),
    ({}, {"delay": 2, "integrator": "exact"}),
    ({"integral_x": 0.0, "integral_y": 0.0, "integral_theta": 0.0}, {"substeps": 2}),
    ({"integral_retention": 1.0, "memory": 3, "pole_x": -0.3}, {"delay": 1, "substeps": 3}),
    (
        {"activation": "linear", "speed_gain_x": 7.0}
        | {f"amplitude_{channel}": 1.0 for channel in ("x", "y", "theta")},
        {},
    ),
    ({"lateral": "direction", "integral_y": 0.0}, {"delay": 1}),
]


@pytest.mark.parametrize(("law", "plant"), CASES)
def test_poles_on_a_line_are_the_map_s_eigenvalues(law, plant):
    """The map is exact: its Jacobian is the code of the law in dual numbers."""
    scenario = Scenario(LINE, rng=0, initial_velocity="reference", **plant)
    own = controller(**law)
    found = stability.margins(own, scenario)
    exact = stability.loop(scenario, own)
    assert exact.period == 1
    moduli = np.sort(np.abs(exact.multipliers))[::-1]
    count = int((moduli > 0.3).sum())
    # The map has the integral states of channels that none enters, too.
    moduli = moduli[:count]
    if law.get("integral_x") == 0.0:
        moduli = moduli[~np.isclose(moduli, LAW["integral_retention"], atol=1e-12)]
    assert np.abs(found.poles[: len(moduli)]) == pytest.approx(moduli, abs=1e-7)
    assert found.stable == (exact.verdict == "stable")


@pytest.mark.parametrize(("loop", "rows"), [("drive", [0]), ("steering", [1, 2])])
def test_the_gain_margin_is_where_a_pole_leaves_the_circle(loop, rows):
    scenario = Scenario(LINE, rng=0)
    margin = getattr(stability.margins(controller(), scenario), loop).gain[1]
    for factor, stable in ((0.999 * margin, True), (1.001 * margin, False)):
        gains = np.array(GAINS)
        gains[rows] *= factor
        names = ["integral_x", "speed_gain_x"]
        if loop == "steering":
            names = ["integral_y", "integral_theta", "speed_gain_theta"]
        changed = controller(**{name: LAW[name] * factor for name in names})
        document = json.loads(changed.to_json())
        document["gains"] = gains.tolist()
        louder = Controller.from_json(json.dumps(document))
        assert stability.margins(louder, scenario).stable == stable


def test_the_delay_margin_is_between_whole_samples_of_delay():
    margin = stability.margins(controller(), Scenario(LINE, rng=0))
    samples = min(margin.drive.delay, margin.steering.delay) / LINE.dt
    stable = [
        stability.margins(controller(), Scenario(LINE, rng=0, delay=delay)).stable
        for delay in range(6)
    ]
    assert 1 < samples < 5
    assert stable == [delay < samples for delay in range(6)]


def test_states_of_the_tracking_law_have_names():
    found = stability.loop(Scenario.published(rng=0, delay=1), controller())
    assert found.verdict == "stable"
    assert len(found.state_names) == found.orbit.shape[1] == 32
