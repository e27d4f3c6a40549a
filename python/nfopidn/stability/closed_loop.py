"""The closed loop's orbit on a periodic reference, and its stability."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import Controller, Scenario, Trajectory
from nfopidn.arguments import controller_or_published, scenario_or_published

Array = NDArray[np.float64]
Verdict = Literal["stable", "unstable", "marginal", "no_orbit"]

#: A simulation is as long as the slowest deviation needs to shrink or grow by this, but for the
#: shortest and longest [periods, samples].
_SIMULATED_CHANGE = 1e4
_FEWEST_PERIODS = 4
_MOST_SAMPLES = 200_000
#: How far from its orbit [m] a simulation may end and still have come to it, as part of how far
#: from the reference the orbit runs.
_ARRIVED = 0.05


@dataclass(frozen=True)
class Switch:
    """How near the orbit passes to a corner of the map, beyond which the linearisation ends.

    Attributes
    ----------
    distance
        [rad] or [N m]
    sample
        of the period, where the orbit is nearest
    """

    distance: float
    sample: int


@dataclass(frozen=True)
class Simulated:
    """What a simulation from the scenario's initial pose does, without noise.

    Attributes
    ----------
    periods
        simulated
    diverged_at
        time [s], or None
    distance
        largest distance [m] in the last period from the orbit or, where there is none, from the
        period before; infinite for a run that diverges
    arrived
        whether that counts as the orbit (as a period that repeats)
    """

    periods: int
    diverged_at: float | None
    distance: float
    arrived: bool

    def __str__(self) -> str:
        if self.diverged_at is not None:
            return f"diverges at {self.diverged_at:g} s"
        where = "on" if self.arrived else "off"
        return f"after {self.periods} periods {self.distance:.3g} m {where} the orbit"


@dataclass(frozen=True)
class LoopStability:
    """The stability of a loop on its reference.

    Attributes
    ----------
    verdict
        "stable", "unstable", "marginal" (a period's spectral radius within 1e-6 of 1), "no_orbit"
    multipliers
        (n,) complex: Floquet multipliers of a period, largest first; empty without an orbit. On a
        line or circle the period is one sample, and they are the eigenvalues.
    log_radius
        natural logarithm of the largest one's modulus; nan without an orbit
    period
        [samples]
    laps
        of the reference in a period; 0 where the period is one sample
    dt
        sample time [s]
    orbit
        (period, n): the state at each sample, columns as `state_names`; without an orbit where the
        search ended
    state_names
        the state's n numbers: error x, y [m], theta [rad] in the reference's frame, v [m/s],
        omega [rad/s], the channels' past errors newest first, the last feedback torques [N m]
        (incremental form), the last measured pose's error, drive and steering after the pole and
        the integral states [N m] (tracking law), the torques on their way [N m] (delay)
    reference
        (period, 8): rows as in Scenario.reference
    heading_wrap, torque_left, torque_right
        distance of the orbit from pi [rad] and from the limits [N m]; None without an orbit
    limited_samples
        at which a wheel is at its limit
    residual
        largest miss of a step of the orbit
    iterations
        of Newton's method
    start
        "reference" or "simulation": from where the orbit was found, or looked for last
    simulated
        evidence
    """

    verdict: Verdict
    multipliers: NDArray[np.complex128]
    log_radius: float
    period: int
    laps: int
    dt: float
    orbit: Array
    state_names: tuple[str, ...]
    reference: Array
    heading_wrap: Switch | None
    torque_left: Switch | None
    torque_right: Switch | None
    limited_samples: int
    residual: float
    iterations: int
    start: Literal["reference", "simulation"]
    simulated: Simulated

    @property
    def spectral_radius(self) -> float:
        """Spectral radius of the map over one period; infinite beyond 1.8e308."""
        with np.errstate(over="ignore"):
            return float(np.exp(self.log_radius))

    @property
    def spectral_radius_per_sample(self) -> float:
        """The same spread evenly over the period's samples."""
        return float(np.exp(self.log_radius / self.period))

    @property
    def agrees(self) -> bool:
        """Whether the simulation does what the verdict says: arrives if stable, and not else.

        A start outside the basin of attraction disagrees with "stable", and rightly so.
        """
        return self.simulated.arrived == (self.verdict == "stable")

    def __str__(self) -> str:
        lines = [f"{self.verdict}; simulation {self.simulated}"]
        lap = {0: "every sample alike", 1: "1 lap"}.get(self.laps, f"{self.laps} laps")
        lines.append(f"period {self.period} samples ({lap}), {self.orbit.shape[1]} states")
        if self.verdict == "no_orbit":
            lines.append(f"no orbit found: steps miss by {self.residual:.2g}")
            return "\n".join(lines)
        lines.append(
            f"spectral radius {_power_text(self.log_radius)} a period, "
            f"{self.spectral_radius_per_sample:.6f} a sample"
        )
        for name, switch, unit in (
            ("heading error from pi", self.heading_wrap, "rad"),
            ("left torque from its limit", self.torque_left, "N m"),
            ("right torque from its limit", self.torque_right, "N m"),
        ):
            assert switch is not None
            lines.append(f"{name} at least {switch.distance:.4g} {unit}, at sample {switch.sample}")
        lines.append(f"{self.limited_samples} samples at the torque limit")
        return "\n".join(lines)


def _power_text(log_radius: float) -> str:
    if abs(log_radius) < 600:
        return f"{np.exp(log_radius):.4g}"
    decades = log_radius / np.log(10)
    exponent = int(np.floor(decades))
    return f"{10 ** (decades - exponent):.4g}e{exponent:+d}"


# The last pose as an error in the reference's present frame; what the pole and the integral states
# remember.
_TRACKING_STATES = (
    *("e_x(k-1)", "e_y(k-1)", "e_theta(k-1)"),
    *("drive", "steering", "drive_integral", "steering_integral"),
)


def _state_names(size: int, past: int, controller: Controller, delay: int) -> tuple[str, ...]:
    adds = 2 if controller.form == "incremental" else 0
    tracking = list(_TRACKING_STATES) if controller.uses_tracking_law else []
    of_channel = (size - 5 - adds - len(tracking) - 2 * delay) // 3
    names = ["e_x", "e_y", "e_theta", "v", "omega"]
    for channel in ("x", "y", "theta"):
        names += [f"e_{channel}(k-{age})" for age in range(1, past + 1)]
        names += [f"mode_{channel}({i})" for i in range(1, of_channel - past + 1)]
    if controller.form == "incremental":
        names += ["tau_fb_left(k-1)", "tau_fb_right(k-1)"]
    names += tracking
    names += [f"tau_{side}(k-{age})" for age in range(delay, 0, -1) for side in ("left", "right")]
    assert len(names) == size
    return tuple(names)


def repeated(trajectory: Trajectory, laps: int) -> Trajectory:
    """Return the same path with another number of laps."""
    if trajectory.name == "samples":
        lap = (len(trajectory) - 1) // trajectory.laps + 1
        x, y = trajectory.x[:lap], trajectory.y[:lap]
        return Trajectory.from_samples(x, y, trajectory.dt, trajectory.heading, laps)
    settings: dict[str, Any] = {
        name: getattr(trajectory, name)
        for name in ("period", "dt", "heading", "scale", "derivatives")
    }
    if trajectory.name == "ranunculoid":
        settings["cusps"] = trajectory.cusps
    make = getattr(Trajectory, trajectory.name)
    return make(laps=laps, **settings)  # type: ignore[no-any-return]


def _simulated_scenario(scenario: Scenario, found: dict[str, Any]) -> tuple[Scenario, int]:
    """Return the scenario without noise for as many periods as tell, and their number."""
    rate = abs(found["log_radius"]) if found["verdict"] != "no_orbit" else 0.0
    wanted = np.log(_SIMULATED_CHANGE) / rate if rate > 0 else np.inf
    trajectory = scenario.trajectory
    lap = trajectory.period / trajectory.dt if found["laps"] == 0 else found["period"]
    period = max(found["period"], 1)
    most = max(_MOST_SAMPLES // period, _FEWEST_PERIODS)
    periods = int(np.clip(wanted, _FEWEST_PERIODS, most))
    if found["laps"] == 0:
        if trajectory.name == "samples":
            return scenario.replace(pose_noise=(0, 0)), len(trajectory) - 1
        laps = int(np.ceil(periods / lap)) + 1
    else:
        laps = periods * int(found["laps"])
    longer = repeated(trajectory, laps)
    return scenario.replace(trajectory=longer, pose_noise=(0, 0)), periods


def _errors_in_reference_frame(columns: dict[str, Array]) -> Array:
    """Return (N, 2) position errors, from those in the robot's frame."""
    cosine, sine = np.cos(columns["e_theta"]), np.sin(columns["e_theta"])
    x, y = columns["e_x"], columns["e_y"]
    return np.column_stack([cosine * x + sine * y, cosine * y - sine * x])


def _simulate(scenario: Scenario, controller: Controller, found: dict[str, Any]) -> Simulated:
    longer, periods = _simulated_scenario(scenario, found)
    run = _core.simulate(longer, controller)
    if run.diverged_at is not None:
        return Simulated(periods, run.diverged_at, float("inf"), arrived=False)
    errors = _errors_in_reference_frame(run.columns)
    # The last samples' rates are one-sided differences, which a loop on an endless path never has.
    end, period = len(errors) - 3, found["period"]
    first = end - period
    phase = np.arange(first, end) % period
    if found["verdict"] == "no_orbit":
        other = errors[first - period : end - period] if first >= period else errors[:0]
        scale = float(np.max(np.hypot(*errors[first:end].T)))
    else:
        other = found["orbit"][phase, :2]
        scale = float(np.max(np.hypot(*found["orbit"][:, :2].T)))
    distance = float(np.max(np.hypot(*(errors[first:end] - other).T)))
    return Simulated(periods, None, distance, distance <= max(_ARRIVED * scale, 1e-3))


def loop(scenario: Scenario | None = None, controller: Controller | None = None) -> LoopStability:
    """Find the loop's orbit on its periodic reference, and whether it is stable.

    The loop is a map from one sample to the next. Its orbit is found by Newton's method with every
    sample of the period as an unknown, so that unstable orbits are found as well; its Jacobians are
    exact (dual numbers). Noise is left out. docs/stability.md has the method.

    Parameters
    ----------
    scenario
        None: the published one. Its path is taken without ends, its initial pose for the simulated
        evidence only.
    controller
        None: the published one

    Returns
    -------
    LoopStability
        verdict, orbit, Floquet multipliers

    Raises
    ------
    ValueError
        If the reference is not periodic, its period is no whole number of samples or beyond 10000,
        the loop has more than 200 states, or the disturbance is not constant. States are 5 + 3
        (memory + 1), 2 in incremental form, 2 a sample of delay; beyond 200 memory runs as modes
        good to 1e-6, if -1 < alpha < 1 and 0 < sigma < 2, and then goes on where a finite one ends.

    Examples
    --------
    >>> import nfopidn
    >>> print(nfopidn.stability.loop().verdict)
    stable
    >>> incremental = nfopidn.Controller.published(form="incremental")
    >>> print(nfopidn.stability.loop(controller=incremental).verdict)
    unstable
    """
    scenario = scenario_or_published(scenario)
    controller = controller_or_published(controller, scenario)
    found = _core.analyse_loop(scenario, controller)
    lost = found["verdict"] == "no_orbit"
    switches = {
        name: None if lost else Switch(*found[name])
        for name in ("heading_wrap", "torque_left", "torque_right")
    }
    return LoopStability(
        verdict=found["verdict"],
        multipliers=found["multipliers"],
        log_radius=float("nan") if lost else found["log_radius"],
        period=found["period"],
        laps=found["laps"],
        dt=scenario.trajectory.dt,
        orbit=found["orbit"],
        state_names=_state_names(
            found["orbit"].shape[1], found["past_errors"], controller, scenario.delay
        ),
        reference=found["reference"],
        limited_samples=found["limited_samples"],
        residual=found["residual"],
        iterations=found["iterations"],
        start=found["start"],
        simulated=_simulate(scenario, controller, found),
        **switches,
    )


def jacobians(scenario: Scenario, controller: Controller, stability: LoopStability) -> Array:
    """Return the map's Jacobians along the orbit.

    Parameters
    ----------
    scenario, controller, stability
        the arguments and the result of `loop`

    Returns
    -------
    ndarray
        (period, n, n): of the state at k + 1 with respect to that at k
    """
    return _core.loop_jacobians(scenario, controller, stability.orbit)
