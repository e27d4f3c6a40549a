"""Names, arguments in order and defaults, as section 5 of the design fixes them."""

import inspect
import re

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Robot, Scenario, SimulationResult, Trajectory, simulate

PAPER_GAINS = [[0.2797, 0.7614, 0.8477], [0.7177, 0.2782, 0.3294], [1.0707, 1.3720, 0.1827]]
PATH = {
    "period": 150.0,
    "dt": 0.2,
    "heading": "forward",
    "scale": 1.0,
    "laps": 1,
    "derivatives": "sampled",
}
RANUNCULOID = {"period": 150.0, "dt": 0.2, "cusps": 3} | {
    key: PATH[key] for key in ("heading", "scale", "laps", "derivatives")
}
ROBOT = {"mass": 11.5, "inertia": 0.5873, "track_width": 0.452, "wheel_radius": 0.076}
STRUCTURE = {
    "memory": 5,
    "form": "positional",
    "allocation": "paper",
    "activation": "sigmoid",
    "frame": "robot",
    "generator": "tustin",
    "lateral": "direction",
    "anti_windup": "none",
    "speed_scale": 0.0,
    "sample_time": None,
}
SCENARIO = {
    "initial_pose": None,
    "initial_velocity": (0.0, 0.0),
    "torque_limit": 3.078,
    "feedforward": True,
    "integrator": "semi-implicit-euler",
    "substeps": 1,
    "disturbance": (0.0, 0.0),
    "viscous_friction": 0.0,
    "coulomb_friction": 0.0,
    "pose_noise": (0.0, 0.0),
    "delay": 0,
    "divergence_distance": 10.0,
}
NAMED_PATHS = ["circle", "lemniscate", "eight", "line", "sine", "rounded_square"]
LINE = Trajectory.line()


def make_controller(*arguments, **settings):
    return Controller(PAPER_GAINS, 0.1078, 0.8161, *arguments, **settings)


def make_scenario(*arguments, **settings):
    if arguments:
        return Scenario(LINE, Robot.eddie(), *arguments, 7)
    return Scenario(LINE, rng=7, **settings)


CALLS = [
    pytest.param(Trajectory.ranunculoid, RANUNCULOID, id="ranunculoid"),
    *[pytest.param(getattr(Trajectory, name), PATH, id=name) for name in NAMED_PATHS],
    pytest.param(Robot, ROBOT, id="Robot"),
    pytest.param(make_controller, STRUCTURE, id="Controller"),
    pytest.param(make_scenario, SCENARIO, id="Scenario"),
]


@pytest.mark.parametrize(("make", "defaults"), CALLS)
def test_defaults(make, defaults):
    made = make()
    assert {name: getattr(made, name) for name in defaults} == defaults


@pytest.mark.parametrize(("make", "defaults"), CALLS)
def test_arguments_by_name_and_in_order(make, defaults):
    assert make(**defaults) == make()
    assert make(*defaults.values()) == make()


def test_the_paper_s_values_are_the_defaults():
    assert Robot() == Robot.eddie()
    assert Robot.eddie_datasheet() == Robot(11.5, 0.294, 0.390, 0.076)
    assert Controller.published() == make_controller()
    assert np.array_equal(Controller.published().gains, PAPER_GAINS)
    assert Scenario.published(rng=0) == Scenario(
        Trajectory.ranunculoid(), Robot.eddie(), (4, 0, 1.0472), rng=0
    )


def test_published_takes_changes_of_scenario_and_trajectory():
    changed = Scenario.published(period=100, cusps=5, torque_limit=2, rng=1)
    assert changed == Scenario(
        Trajectory.ranunculoid(100, cusps=5), initial_pose=(4, 0, 1.0472), torque_limit=2, rng=1
    )
    other_path = Scenario.published(trajectory=LINE, initial_pose=None, rng=1)
    assert other_path == Scenario(LINE, rng=1)
    with pytest.raises(TypeError, match="period"):
        Scenario.published(trajectory=LINE, period=100)


def test_published_controller_takes_memory_and_changes():
    assert Controller.published(7, form="incremental") == make_controller(
        memory=7, form="incremental"
    )


@pytest.mark.parametrize("name", NAMED_PATHS)
def test_a_path_knows_its_settings(name):
    path = getattr(Trajectory, name)(period=40, dt=0.5, heading="continuous", scale=2, laps=3)
    assert (path.name, path.period, path.dt) == (name, 40, 0.5)
    assert (path.heading, path.scale, path.laps) == ("continuous", 2, 3)
    assert len(path) == 241


def test_version_and_exports():
    assert re.fullmatch(r"\d+\.\d+\.\d+", nfopidn.__version__)
    assert nfopidn.__all__ == sorted(nfopidn.__all__)
    for name in nfopidn.__all__:
        assert hasattr(nfopidn, name)


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (Robot, ["Robot", "mass=11.5", "wheel_radius=0.076"]),
        (lambda: Trajectory.eight(dt=0.5), ["Trajectory", "eight", "301", "0.5", "forward"]),
        (lambda: make_controller(7, "incremental"), ["Controller", "memory=7", "incremental"]),
        (lambda: Scenario(LINE, delay=2), ["Scenario", "line", "751", "delay=2"]),
        (lambda: Scenario(LINE, disturbance=np.zeros((751, 2))), ["Scenario", "disturbance"]),
        (simulate, ["SimulationResult", "0.0920", "751"]),
        (lambda: simulate(Scenario.published(period=25)), ["SimulationResult", "diverged_at="]),
    ],
)
def test_repr_says_something_short(make, expected):
    text = repr(make())
    assert all(part in text for part in expected)
    assert len(text) < 400


def classes_and_functions():
    for owner in (Robot, Trajectory, Scenario, Controller, SimulationResult):
        yield owner.__name__, owner
        for name, member in inspect.getmembers(owner):
            if not name.startswith("_"):
                yield f"{owner.__name__}.{name}", member
    yield "simulate", simulate


@pytest.mark.parametrize(
    "member",
    [pytest.param(member, id=name) for name, member in classes_and_functions()],
)
def test_everything_has_a_docstring(member):
    assert member.__doc__
    assert len(member.__doc__) > 2


@pytest.mark.parametrize(
    "callable_",
    [Robot, Scenario, Controller]
    + [getattr(Trajectory, name) for name in ["ranunculoid", *NAMED_PATHS]],
    ids=lambda callable_: callable_.__name__,
)
def test_documented_parameters_are_the_arguments(callable_):
    signature = callable_.__text_signature__
    arguments = set(re.findall(r"(?:^\(|, )(\w+)", signature))
    parameters = callable_.__doc__.split("Parameters\n----------\n")[1]
    documented = set(re.findall(r"^(\w+)$", parameters, flags=re.MULTILINE))
    assert documented == arguments


@pytest.mark.parametrize(
    ("method", "names"),
    [
        (Controller.step, ["self", "measurement", "reference", "torque_limit"]),
        (Controller.save, ["self", "path"]),
        (Scenario.replace, ["self", "changes"]),
        (SimulationResult.to_csv, ["self", "path"]),
        (Controller.from_vector, ["x", "structure"]),
        (simulate, ["scenario", "controller"]),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_inspect_sees_the_arguments(method, names):
    assert list(inspect.signature(method).parameters) == names


@pytest.mark.parametrize("value", [Robot(), LINE, Scenario(LINE), Controller.published()])
def test_settings_cannot_be_assigned(value):
    name = next(name for name in dir(value) if not name.startswith("_"))
    with pytest.raises(AttributeError):
        setattr(value, name, None)
    with pytest.raises(AttributeError):
        value.no_such_setting = 1
