import os
from collections.abc import Callable, Sequence
from typing import Any, Literal, TypeAlias, TypedDict, Unpack, final, overload

import numpy as np
from numpy.typing import NDArray

__version__: str
START_SHARE: float

_Array: TypeAlias = NDArray[np.float64]
_Numbers: TypeAlias = Sequence[float] | NDArray[np.floating[Any] | np.integer[Any]]
_Rows: TypeAlias = Sequence[Sequence[float]] | NDArray[np.floating[Any] | np.integer[Any]]
_Path: TypeAlias = str | os.PathLike[str]
_Pair: TypeAlias = tuple[float, float]
_Triple: TypeAlias = tuple[float, float, float]
_Seed: TypeAlias = int | np.integer[Any] | np.random.Generator | None

_Curve: TypeAlias = Literal[
    "ranunculoid", "circle", "lemniscate", "eight", "line", "sine", "rounded_square", "samples"
]
_Heading: TypeAlias = Literal["forward", "continuous"]
_Derivatives: TypeAlias = Literal["sampled", "analytic"]
_Integrator: TypeAlias = Literal["semi-implicit-euler", "exact"]
_Form: TypeAlias = Literal["positional", "incremental"]
_Allocation: TypeAlias = Literal["paper", "decoupled"]
_Activation: TypeAlias = Literal["sigmoid", "linear"]
_Frame: TypeAlias = Literal["robot", "world"]
_Generator: TypeAlias = Literal["tustin", "gl"]
_Lateral: TypeAlias = Literal["plain", "direction", "speed"]
_AntiWindup: TypeAlias = Literal["none", "hold", "clamp"]

class _RobotChanges(TypedDict, total=False):
    mass: float
    inertia: float
    track_width: float
    wheel_radius: float

class _ScenarioChanges(TypedDict, total=False):
    trajectory: Trajectory
    robot: Robot
    initial_pose: _Numbers | None
    initial_velocity: _Numbers | Literal["reference"]
    torque_limit: float
    feedforward: bool
    integrator: _Integrator
    substeps: int
    disturbance: _Numbers | _Rows
    viscous_friction: float
    coulomb_friction: float
    pose_noise: _Numbers
    delay: int
    divergence_distance: float
    rng: _Seed

class _PublishedScenarioChanges(_ScenarioChanges, total=False):
    period: float
    dt: float
    cusps: int
    heading: _Heading
    scale: float
    laps: int
    derivatives: _Derivatives

class _TapsStructure(TypedDict, total=False):
    form: _Form
    allocation: _Allocation | _Rows
    activation: _Activation
    frame: _Frame
    lateral: _Lateral
    anti_windup: _AntiWindup
    speed_scale: float

class _Law(_TapsStructure, total=False):
    generator: _Generator

class _Structure(_Law, total=False):
    memory: float | str

class _PublishedControllerChanges(_Law, total=False):
    gains: _Rows
    alpha: float | _Numbers
    sigma: float | _Numbers

class _ControllerChanges(_Structure, _PublishedControllerChanges, total=False): ...

@final
class Robot:
    def __init__(
        self,
        mass: float = 11.5,
        inertia: float = 0.5873,
        track_width: float = 0.452,
        wheel_radius: float = 0.076,
    ) -> None: ...
    @staticmethod
    def eddie() -> Robot: ...
    @staticmethod
    def eddie_datasheet() -> Robot: ...
    @property
    def mass(self) -> float: ...
    @property
    def inertia(self) -> float: ...
    @property
    def track_width(self) -> float: ...
    @property
    def wheel_radius(self) -> float: ...
    def replace(self, **changes: Unpack[_RobotChanges]) -> Robot: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __copy__(self) -> Robot: ...
    def __deepcopy__(self, memo: dict[int, Any], /) -> Robot: ...

@final
class Trajectory:
    @staticmethod
    def ranunculoid(
        period: float = 150.0,
        dt: float = 0.2,
        cusps: int = 3,
        heading: _Heading = "forward",
        scale: float = 1.0,
        laps: int = 1,
        derivatives: _Derivatives = "sampled",
    ) -> Trajectory: ...
    @staticmethod
    def circle(
        period: float = 150.0,
        dt: float = 0.2,
        heading: _Heading = "forward",
        scale: float = 1.0,
        laps: int = 1,
        derivatives: _Derivatives = "sampled",
    ) -> Trajectory: ...
    @staticmethod
    def lemniscate(
        period: float = 150.0,
        dt: float = 0.2,
        heading: _Heading = "forward",
        scale: float = 1.0,
        laps: int = 1,
        derivatives: _Derivatives = "sampled",
    ) -> Trajectory: ...
    @staticmethod
    def eight(
        period: float = 150.0,
        dt: float = 0.2,
        heading: _Heading = "forward",
        scale: float = 1.0,
        laps: int = 1,
        derivatives: _Derivatives = "sampled",
    ) -> Trajectory: ...
    @staticmethod
    def line(
        period: float = 150.0,
        dt: float = 0.2,
        heading: _Heading = "forward",
        scale: float = 1.0,
        laps: int = 1,
        derivatives: _Derivatives = "sampled",
    ) -> Trajectory: ...
    @staticmethod
    def sine(
        period: float = 150.0,
        dt: float = 0.2,
        heading: _Heading = "forward",
        scale: float = 1.0,
        laps: int = 1,
        derivatives: _Derivatives = "sampled",
    ) -> Trajectory: ...
    @staticmethod
    def rounded_square(
        period: float = 150.0,
        dt: float = 0.2,
        heading: _Heading = "forward",
        scale: float = 1.0,
        laps: int = 1,
        derivatives: _Derivatives = "sampled",
    ) -> Trajectory: ...
    @staticmethod
    def from_samples(
        x: _Numbers, y: _Numbers, dt: float, heading: _Heading = "forward", laps: int = 1
    ) -> Trajectory: ...
    @staticmethod
    def from_csv(
        path: _Path, heading: _Heading = "forward", laps: int = 1, dt: float = 0.2
    ) -> Trajectory: ...
    @property
    def name(self) -> _Curve: ...
    @property
    def period(self) -> float: ...
    @property
    def dt(self) -> float: ...
    @property
    def cusps(self) -> int: ...
    @property
    def heading(self) -> _Heading: ...
    @property
    def scale(self) -> float: ...
    @property
    def laps(self) -> int: ...
    @property
    def derivatives(self) -> _Derivatives: ...
    @property
    def t(self) -> _Array: ...
    @property
    def x(self) -> _Array: ...
    @property
    def y(self) -> _Array: ...
    @property
    def theta(self) -> _Array: ...
    @property
    def v(self) -> _Array: ...
    @property
    def omega(self) -> _Array: ...
    @property
    def acceleration(self) -> _Array: ...
    @property
    def turn_acceleration(self) -> _Array: ...
    @property
    def reverse(self) -> NDArray[np.bool_]: ...
    @property
    def peak_speed(self) -> float: ...
    def __len__(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __copy__(self) -> Trajectory: ...
    def __deepcopy__(self, memo: dict[int, Any], /) -> Trajectory: ...

@final
class Scenario:
    def __init__(
        self,
        trajectory: Trajectory,
        robot: Robot = ...,
        initial_pose: _Numbers | None = None,
        initial_velocity: _Numbers | Literal["reference"] = (0.0, 0.0),
        torque_limit: float = 3.078,
        feedforward: bool = True,
        integrator: _Integrator = "semi-implicit-euler",
        substeps: int = 1,
        disturbance: _Numbers | _Rows = (0.0, 0.0),
        viscous_friction: float = 0.0,
        coulomb_friction: float = 0.0,
        pose_noise: _Numbers = (0.0, 0.0),
        delay: int = 0,
        divergence_distance: float = 10.0,
        rng: _Seed = None,
    ) -> None: ...
    @staticmethod
    def published(**changes: Unpack[_PublishedScenarioChanges]) -> Scenario: ...
    def to_json(self) -> str: ...
    @staticmethod
    def from_json(text: str) -> Scenario: ...
    @staticmethod
    def load(path: _Path) -> Scenario: ...
    def save(self, path: _Path) -> None: ...
    def replace(self, **changes: Unpack[_ScenarioChanges]) -> Scenario: ...
    @property
    def trajectory(self) -> Trajectory: ...
    @property
    def robot(self) -> Robot: ...
    @property
    def initial_pose(self) -> _Triple | None: ...
    @property
    def initial_velocity(self) -> _Pair | Literal["reference"]: ...
    @property
    def torque_limit(self) -> float: ...
    @property
    def feedforward(self) -> bool: ...
    @property
    def integrator(self) -> _Integrator: ...
    @property
    def substeps(self) -> int: ...
    @property
    def disturbance(self) -> _Pair | _Array: ...
    @property
    def viscous_friction(self) -> float: ...
    @property
    def coulomb_friction(self) -> float: ...
    @property
    def pose_noise(self) -> _Pair: ...
    @property
    def delay(self) -> int: ...
    @property
    def divergence_distance(self) -> float: ...
    @property
    def seed(self) -> int: ...
    @property
    def reference(self) -> _Array: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __copy__(self) -> Scenario: ...
    def __deepcopy__(self, memo: dict[int, Any], /) -> Scenario: ...

@final
class Controller:
    def __init__(
        self,
        gains: _Rows,
        alpha: float | _Numbers,
        sigma: float | _Numbers,
        memory: float | str = 5,
        form: _Form = "positional",
        allocation: _Allocation | _Rows = "paper",
        activation: _Activation = "sigmoid",
        frame: _Frame = "robot",
        generator: _Generator = "tustin",
        lateral: _Lateral = "direction",
        anti_windup: _AntiWindup = "none",
        speed_scale: float = 0.0,
    ) -> None: ...
    @staticmethod
    def published(
        memory: float | str = 5, **changes: Unpack[_PublishedControllerChanges]
    ) -> Controller: ...
    @staticmethod
    def from_vector(x: _Numbers, **structure: Unpack[_Structure]) -> Controller: ...
    def to_vector(self) -> _Array: ...
    @staticmethod
    def from_continuous(
        gains: _Rows,
        alpha: float | _Numbers,
        sigma: float | _Numbers,
        dt: float,
        prewarp: float | None = 15.0,
        **structure: Unpack[_Structure],
    ) -> Controller: ...
    @staticmethod
    def from_taps(taps: _Rows, **structure: Unpack[_TapsStructure]) -> Controller: ...
    @staticmethod
    def tuned_nominal() -> Controller: ...
    def to_json(self) -> str: ...
    @staticmethod
    def from_json(text: str) -> Controller: ...
    @staticmethod
    def load(path: _Path) -> Controller: ...
    def save(self, path: _Path) -> None: ...
    def replace(self, **changes: Unpack[_ControllerChanges]) -> Controller: ...
    @property
    def gains(self) -> _Array | None: ...
    @property
    def alpha(self) -> float | _Triple | None: ...
    @property
    def sigma(self) -> float | _Triple | None: ...
    @property
    def memory(self) -> int | float: ...
    @property
    def form(self) -> _Form: ...
    @property
    def allocation(self) -> _Allocation | _Array: ...
    @property
    def activation(self) -> _Activation: ...
    @property
    def frame(self) -> _Frame: ...
    @property
    def generator(self) -> _Generator: ...
    @property
    def lateral(self) -> _Lateral: ...
    @property
    def anti_windup(self) -> _AntiWindup: ...
    @property
    def speed_scale(self) -> float: ...
    @property
    def taps(self) -> _Array: ...
    def step(
        self, measurement: _Numbers, reference: _Numbers, torque_limit: float = 3.078
    ) -> _Pair: ...
    def reset(self) -> None: ...
    def feedback(self) -> _Pair: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __copy__(self) -> Controller: ...
    def __deepcopy__(self, memo: dict[int, Any], /) -> Controller: ...

@final
class SimulationResult:
    @property
    def cost(self) -> float: ...
    @property
    def metrics(self) -> dict[str, float]: ...
    @property
    def columns(self) -> dict[str, _Array]: ...
    @property
    def pose(self) -> _Array: ...
    @property
    def torque(self) -> _Array: ...
    @property
    def t(self) -> _Array: ...
    @property
    def diverged_at(self) -> float | None: ...
    @property
    def scenario(self) -> Scenario: ...
    @property
    def controller(self) -> Controller: ...
    def to_csv(self, path: _Path) -> None: ...
    def __len__(self) -> int: ...
    def __copy__(self) -> SimulationResult: ...
    def __deepcopy__(self, memo: dict[int, Any], /) -> SimulationResult: ...

def simulate(
    scenario: Scenario | None = None, controller: Controller | None = None
) -> SimulationResult: ...

@final
class CostFunction:
    def __init__(
        self,
        scenarios: Sequence[Scenario],
        controller: Controller,
        parameters: str,
        source: Sequence[int],
        fixed: Sequence[float],
        dimension: int,
        risk: float,
        threads: int,
    ) -> None: ...
    def costs(self, points: _Rows) -> _Array: ...
    def gradient(self, x: _Numbers) -> tuple[float, _Array]: ...

def search_function(function: Callable[..., Any], request: dict[str, Any]) -> dict[str, Any]: ...
def search_controller(
    scenarios: Sequence[Scenario],
    controller: Controller,
    parameters: str,
    source: Sequence[int],
    fixed: Sequence[float],
    risk: float,
    threads: int,
    request: dict[str, Any],
) -> dict[str, Any]: ...
def structure(name: str) -> tuple[dict[str, Any], str]: ...
def parameter_bounds(controller: Controller, parameters: str) -> list[tuple[str, float, float]]: ...
def design(
    controller: Controller,
    parameters: str,
    source: Sequence[int],
    fixed: Sequence[float],
    x: Sequence[float],
) -> Controller: ...
def parameters(controller: Controller, parameters: str, design: Controller) -> list[float]: ...
def series_weights(pole: float, order: float, memory: int) -> _Array: ...
def rule_scale(pole: float, dt: float, prewarp: float) -> float: ...
def gain_factors(
    generator: str, alpha: float, sigma: float, dt: float, prewarp: float
) -> tuple[float, float, float]: ...
def continued_fraction(
    order: float, pole: float, dt: float, prewarp: float, sections: int
) -> tuple[list[float], list[float], float]: ...
def oustaloup(
    order: float, dt: float, prewarp: float, sections: int, low: float, high: float
) -> tuple[list[float], list[float], float]: ...

@final
class SampleFilter:
    @overload
    def __init__(
        self,
        order: float,
        pole: float,
        dt: float,
        prewarp: float,
        memory: float,
        horizon: int,
    ) -> None: ...
    @overload
    def __init__(self, other: SampleFilter, /) -> None: ...
    def step(self, sample: float) -> float: ...
    def process(self, samples: _Numbers) -> _Array: ...
    def reset(self) -> None: ...
    @property
    def gain(self) -> float: ...
    @property
    def modes(self) -> int: ...
    @property
    def certificate(self) -> float: ...

def default_options(method: str) -> dict[str, Any]: ...
def analyse_loop(scenario: Scenario, controller: Controller) -> dict[str, Any]: ...
def loop_jacobians(scenario: Scenario, controller: Controller, orbit: _Array) -> _Array: ...
def final_errors(
    scenario: Scenario, controller: Controller, poses: _Array, last_samples: int, threads: int
) -> _Array: ...
def linear_plant(scenario: Scenario, speed: float) -> tuple[_Array, _Array]: ...
