"""The same robot in Drake: its recorded figures, and where there is one, Drake itself."""

import importlib.util
import json
import os
import sys

import pytest
from conftest import GOLDEN, REPOSITORY
from nfopidn import Controller, Scenario
from nfopidn.mujoco import run

RECORDED = json.loads((GOLDEN / "drake.json").read_text())
PATHS = {
    "P": Scenario.published(rng=0),
    "C": Scenario.published(heading="continuous", rng=0),
    "F": Scenario.published(heading="continuous", period=50.0, rng=0),
}


@pytest.fixture(scope="module")
def engines():
    """The script that recorded the figures, with its robot."""
    place = REPOSITORY / "bench" / "drake_engine.py"
    spec = importlib.util.spec_from_file_location("drake_engine", place)
    module = importlib.util.module_from_spec(spec)
    sys.modules["drake_engine"] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", PATHS)
def test_wheels_of_one_contact_cost_the_same(engines, name):
    """Within 1 %, from contact models that have nothing in common."""
    cost = run(
        PATHS[name], Controller.recommended(), model=engines.model("sphere"), step=RECORDED["step"]
    ).cost
    assert cost == pytest.approx(RECORDED["cost"][f"sphere {name}"]["drake"], rel=0.01)


def test_cylinders_scrub_in_mujoco_alone(engines):
    """Drake's cylinder touches the floor at one point, MuJoCo's at both rims."""
    drake = RECORDED["cost"]["cylinder F"]["drake"]
    assert drake == pytest.approx(RECORDED["cost"]["sphere F"]["drake"], rel=0.01)
    cost = run(
        PATHS["F"], Controller.recommended(), model=engines.model("cylinder"), step=0.002
    ).cost
    assert cost > 3 * drake
    turning = RECORDED["yaw_acceleration"]["cylinder 0.1 N m"]
    assert turning["mujoco"] < 0.8 * turning["drake"]
    # In closed form: the moment of both wheels over the yaw inertia with the wheels' spin.
    spin = engines.WHEEL_MASS * 0.076**2 / 2 + engines.ARMATURE
    inertia = 0.5873 + spin * 0.452**2 / (2 * 0.076**2)
    assert turning["drake"] == pytest.approx(0.1 * 0.452 / 0.076 / inertia, rel=5e-3)


@pytest.mark.skipif(
    "NFOPIDN_DRAKE_PYTHON" not in os.environ, reason="names no interpreter that has pydrake"
)
def test_drake_gives_what_was_recorded(engines):
    python = os.environ["NFOPIDN_DRAKE_PYTHON"]
    result = engines.run_drake(
        python, PATHS["F"], Controller.recommended(), "sphere", RECORDED["step"]
    )
    assert result.cost == pytest.approx(RECORDED["cost"]["sphere F"]["drake"], rel=1e-3)
