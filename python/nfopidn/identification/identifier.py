"""From a log of commands and motion to a robot and its drive."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Motor, Robot
from nfopidn.arguments import names_in, real_number, shown, suggestion, whole_number
from nfopidn.identification.models import (
    DRIVES,
    FREE,
    PARAMETERS,
    DriveModel,
    OdometryModel,
    Parameter,
    VelocityModel,
)
from nfopidn.identification.motion import Motion, held, motion_of
from nfopidn.identification.output_error import Fit, Problem, Simulator, fit, fit_states, simulated
from nfopidn.identification.residuals import CHANNELS, OUTLIER, noise_of, whiteness
from nfopidn.identification.result import IdentificationResult
from nfopidn.identification.start import drive_start, odometry_start, velocity_start
from nfopidn.identification.windows import Smoothed, Window, smoothed, windows_of

Array = NDArray[np.float64]

MODELS = ("torque", "voltage", "velocity", "odometry")
SIGNS = ("paper", "rep103")
LOSSES = ("huber", "squares")
LEAST_WINDOWS = 4
_UNSURE = 0.3  # relative standard error beyond which a parameter counts as not told
_BESIDE = (0.93, 1.07)  # of the parameters: where the last fit begins again
_FEW_STEPS = 15  # from there
_SINGULAR = 1e-3  # of the normalised Jacobian


def identify(
    log: Any,
    model: str = "torque",
    *,
    robot: Robot | None = None,
    motor: Motor | None = None,
    commands: Any = None,
    signs: str = "paper",
    free: Sequence[str] | None = None,
    known: Mapping[str, float] | None = None,
    delay: str | int = "whole",
    max_delay: int = 10,
    window: float = 4.0,
    loss: str = "huber",
    validation: float = 0.25,
    counts_per_turn: float | None = None,
    counter_range: float | None = None,
) -> IdentificationResult:
    """Identify a robot and its drive from a log of commands and motion.

    Output error: the commands are replayed through the product's own plant with the exact
    integrator, and the parameters are those with which the simulated poses meet the measured ones,
    weighted by their noise. The log is cut into windows, each with a first state of its own, which
    is estimated with the parameters; so neither noise nor drift adds up. The start is linear least
    squares with the accelerations as dependent variables.

    Parameters
    ----------
    log
        Columns by name, (n,) each: t [s]; x, y [m], theta [rad], or counts_left, counts_right of
        the wheels' encoders; and of the model: tau_left, tau_right [N m]; voltage_left,
        voltage_right [V]; v_command [m/s], omega_command [rad/s]. A command holds until the next.
        With a column t_command the commands have these stamps, as many as they. Stamps may be
        uneven and repeat. Or a nfopidn.formats.Log, with the commands in `commands`.
    model
        "torque": mass, inertia, Coulomb and viscous friction. "voltage": the same behind `motor`.
        "velocity": gain, turn_gain and lag of the speeds behind their commands. "odometry": the
        wheels' radii and the track width, with which the encoders' counts give the poses; counts
        and poses both are columns.
    robot
        wheel_radius and track_width, which poses and torques do not tell, and what stands for mass
        and inertia where the log does not tell them. The model "velocity" needs none.
    motor
        of the model "voltage". Friction is what is found beyond the motor's own.
    commands
        columns t [s] and the model's, by their own clock: the delay then includes the difference of
        the clocks, and may be negative.
    signs
        "paper": left and right as in this package, a positive left torque turns counter-clockwise,
        as in logs of its simulations. "rep103": as on a real robot. The other than the log's is
        refused, as the inertia would be negative.
    free
        names of the parameters to identify; None: all of the model but torque_scale, the ratio of
        true torques to those in the log.
    known
        values of parameters that are not free, by name.
    delay
        "whole": in whole samples of the commands; "fractional": also in parts of them; or a whole
        number of samples that is known.
    max_delay
        longest delay tried [samples], in [0, 64].
    window
        length of the windows [s], in [0.5, 1000].
    loss
        "huber": residuals beyond 3 standard deviations count by their size, so that outliers do
        little; "squares".
    validation
        share of the windows that the first fit does not see, in [0, 0.5].
    counts_per_turn
        counts of a wheel's turn.
    counter_range
        where the counters go round, such as 65536.

    Returns
    -------
    IdentificationResult

    Raises
    ------
    ValueError
        Names the argument or column, its value and its range; the robot stands still; the signs
        are the other ones.

    Warns
    -----
    UserWarning
        The log does not tell a parameter, which then is as given; with what to drive instead.
    """
    asked = _Request(
        model=_one_of("model", model, MODELS),
        signs=_one_of("signs", signs, SIGNS),
        robot=_instance("robot", robot, Robot),
        motor=_instance("motor", motor, Motor),
        free=_free(model, free),
        known=_known(model, known, free),
        delay=delay if isinstance(delay, str) else whole_number("delay", delay, 0, 64),
        max_delay=whole_number("max_delay", max_delay, 0, 64),
        window=real_number("window", window, 0.5, 1000, " s"),
        robust=_one_of("loss", loss, LOSSES) == "huber",
        validation=real_number("validation", validation, 0, 0.5),
    )
    if isinstance(delay, str):
        _one_of("delay", delay, ("whole", "fractional"))
    if model != "velocity" and robot is None:
        raise ValueError(
            f"robot is None; model={model!r} needs a Robot with the wheel_radius and the "
            "track_width, which poses do not tell; its mass and inertia are not used where the log "
            "tells them"
        )
    if (model == "voltage") != (motor is not None):
        raise ValueError(f"motor is {motor}; must be a Motor with model='voltage', else None")
    motion = motion_of(log, commands, model, signs, robot, counts_per_turn, counter_range)
    return _Identification(asked, motion).result()


@dataclass(frozen=True)
class _Request:
    """The arguments, checked."""

    model: str
    signs: str
    robot: Robot | None
    motor: Motor | None
    free: tuple[str, ...]
    known: Mapping[str, float]
    delay: str | int
    max_delay: int
    window: float
    robust: bool
    validation: float


def _one_of(name: str, value: Any, known: Sequence[str]) -> str:
    if not isinstance(value, str) or value not in known:
        hint = suggestion(value, known)
        raise ValueError(f"{name} is {shown(value)}{hint}; must be one of {', '.join(known)}")
    return value


def _instance(name: str, value: Any, kind: type) -> Any:
    if value is not None and not isinstance(value, kind):
        raise ValueError(f"{name} is {shown(value)}; must be a {kind.__name__}")
    return value


def _free(model: str, free: Sequence[str] | None) -> tuple[str, ...]:
    if free is None:
        return FREE[model]
    given = names_in("free", free)
    for name in given:
        _one_of("free", name, tuple(PARAMETERS[model]))
    if not given:
        raise ValueError("free is empty; must name at least one parameter")
    return tuple(name for name in PARAMETERS[model] if name in given)


def _known(
    model: str, known: Mapping[str, float] | None, free: Sequence[str] | None
) -> dict[str, float]:
    found: dict[str, float] = {}
    for name, value in (known or {}).items():
        _one_of("known", name, tuple(PARAMETERS[model]))
        if name in _free(model, free):
            raise ValueError(f"known has {name!r}, which is free; leave it out of one of them")
        least = PARAMETERS[model][name].low
        found[name] = real_number(f"known[{name!r}]", value, least, 1e6)
    return found


@dataclass(frozen=True)
class _Found:
    """A fit with what it is of."""

    names: tuple[str, ...]
    problem: Problem
    fit: Fit


class _Identification:
    """The steps from a motion to a result."""

    def __init__(self, asked: _Request, motion: Motion) -> None:
        self._asked, self._motion = asked, motion
        self._dt = motion.dt
        self._notes = list(motion.notes)
        self._parameters: Mapping[str, Parameter] = PARAMETERS[asked.model]
        count = int(np.floor(motion.t[-1] / self._dt + 1e-6)) + 1
        self._nodes: Array = np.arange(count, dtype=float) * self._dt
        self._smooth: Smoothed = smoothed(motion, self._nodes)
        self._own_clock = any("own clock" in note for note in motion.notes)
        self._noise = self._smooth.noise
        self._undetermined: dict[str, str] = {}
        self._values = self._first_values()
        self._scale = self._scales()
        self._windows = self._cut()

    # The start.

    def _delays(self) -> list[int]:
        if not isinstance(self._asked.delay, str):
            return [self._asked.delay]
        most = self._asked.max_delay
        return list(range(-most if self._own_clock else 0, most + 1))

    def _commands(self, edges: NDArray[np.floating[Any]], delay: float) -> Array:
        return held(self._motion, np.asarray(edges, dtype=float), delay * self._dt)

    def _first_values(self) -> dict[str, float]:
        """Set the delay and return the values at which the search starts, of all parameters."""
        asked, robot = self._asked, self._asked.robot
        values = dict.fromkeys(self._parameters, 1.0)
        if asked.model == "velocity":
            values["lag"] = 2 * self._dt
        elif asked.model == "odometry":
            assert robot is not None
            values = dict.fromkeys(self._parameters, robot.wheel_radius)
            values["track_width"] = robot.track_width
        else:
            assert robot is not None
            values |= {"mass": robot.mass, "inertia": robot.inertia}
            values |= {"coulomb_friction": 0.0, "viscous_friction": 0.0}
        values |= asked.known
        half = max(2, round(0.5 / self._dt))
        around = np.append(self._nodes - self._dt / 2, self._nodes[-1] + self._dt / 2)
        best: tuple[float, int, Mapping[str, float]] = (np.inf, self._delays()[0], {})
        for delay in self._delays():
            found, left = self._started(self._commands(around, delay), values, half)
            if left < best[0] and found:
                best = (left, delay, found)
        self._delay: float = best[1]
        self._refuse_signs(best[2], best[0])
        plus = self._drive_model((), values).added() if asked.model in DRIVES else {}
        for name, value in best[2].items():
            if name in asked.free:
                own = max(value - plus.get(name, 0.0), 0.1 * value)
                values[name] = max(own, self._parameters[name].low)
        return values

    def _started(
        self, command: Array, values: Mapping[str, float], half: int
    ) -> tuple[dict[str, float], float]:
        """Return parameters by least squares, and what they leave."""
        if self._asked.model == "velocity":
            return velocity_start(self._smooth, command, self._dt, half)
        if self._asked.model == "odometry":
            return odometry_start(self._smooth, command, half)
        robot = self._asked.robot
        assert robot is not None
        torque = self._drive_model((), values).torque(command)
        return drive_start(self._smooth, torque, robot, half)

    def _refuse_signs(self, found: Mapping[str, float], left: float) -> None:
        if left > 0.5:  # not clear enough to say anything of signs
            return
        wrong = [name for name, value in found.items() if value < 0]
        if wrong in (["inertia"], ["track_width"]):
            other = "; signs says whose left and right they are: the log's look like the other ones"
        elif wrong:
            other = "; a column has the other sign than it should"
        else:
            return
        raise ValueError(
            f"log: the commands and the motion give the {' and the '.join(wrong)} "
            f"{', '.join(f'{found[name]:.3g}' for name in wrong)}, which must be positive{other}"
        )

    def _drive_model(self, names: tuple[str, ...], values: Mapping[str, float]) -> DriveModel:
        robot = self._asked.robot
        assert robot is not None
        return DriveModel(self._dt, robot, self._asked.motor, names, values)

    def _scales(self) -> dict[str, float]:
        """Return typical values: of friction, of which 0 may be the value, by the torques."""
        if self._asked.model not in DRIVES:
            return dict(self._values)
        robot = self._asked.robot
        assert robot is not None
        torque = self._drive_model((), self._values).torque(self._motion.command)
        size = max(float(np.sqrt(np.mean(torque**2))), 1e-6)
        speed = np.hypot(self._smooth.rate[:, 0], self._smooth.rate[:, 1]) / robot.wheel_radius
        typical = max(float(np.sqrt(np.mean(speed**2))), 1e-3)
        return {
            **self._values,
            "coulomb_friction": 0.3 * size,
            "viscous_friction": 0.3 * size / typical,
        }

    def _cut(self) -> list[Window]:
        length = max(8, round(self._asked.window / self._dt))
        delays = self._delays()
        longest = max(map(abs, delays)) * self._dt + self._dt
        windows = windows_of(self._motion, self._smooth, length, longest)
        if len(windows) < LEAST_WINDOWS:
            raise ValueError(
                f"log gives {len(windows)} windows of {length * self._dt:.3g} s; must give at "
                f"least {LEAST_WINDOWS}: a longer log, or a shorter window"
            )
        return windows

    # The fits.

    def _problem(self, names: tuple[str, ...], delay: float) -> Problem:
        simulate: Simulator
        if self._asked.model == "velocity":
            simulate = VelocityModel(self._dt, names, self._values)
        elif self._asked.model == "odometry":
            mirrored = self._asked.signs == "rep103"
            simulate = OdometryModel(self._dt, names, self._values, mirrored)
        else:
            simulate = self._drive_model(names, self._values)
        length = max(8, round(self._asked.window / self._dt))
        cells = [
            self._commands((w.first + np.arange(length + 1)) * self._dt, delay)
            for w in self._windows
        ]
        return Problem(
            simulate,
            self._dt,
            self._motion.pose,
            self._windows,
            cells,
            self._noise,
            np.array([self._parameters[name].low for name in names]),
            np.array([self._scale[name] for name in names]),
            self._asked.robust,
        )

    def _split(self) -> tuple[list[int], list[int]]:
        """Return the windows of training and of validation, evenly among them."""
        count = len(self._windows)
        kept = min(round(self._asked.validation * count), count - 2)
        if self._asked.validation > 0:
            kept = max(kept, 1)
        seen = np.linspace(0, count, kept, endpoint=False) + 0.5 * count / max(kept, 1)
        validation = sorted({int(place) for place in seen})
        return [i for i in range(count) if i not in validation], validation

    def _found(
        self, names: tuple[str, ...], delay: float, start: _Found | None, places: Sequence[int]
    ) -> _Found:
        problem = self._problem(names, delay).only(places)
        values = np.array([self._values[name] for name in names])
        states = np.array([w.start for w in problem.windows])
        if start is not None and len(start.fit.states) == len(states):
            states = start.fit.states
        if start is not None:
            before = dict(zip(start.names, start.fit.values.tolist(), strict=True))
            values = np.array([before.get(name, self._values[name]) for name in names])
        return _Found(names, problem, fit(problem, values, states))

    def _best_delay(self, names: tuple[str, ...], places: Sequence[int]) -> _Found:
        """Go from the linear start's delay to where neither neighbour is better."""
        tried = {self._delay: self._found(names, self._delay, None, places)}
        known = self._delays()
        while True:
            for side in (self._delay - 1, self._delay + 1):
                if side in known and side not in tried:
                    tried[side] = self._found(names, side, tried[self._delay], places)
            best = min(tried, key=lambda d: tried[d].fit.cost)
            if best == self._delay:
                break
            self._delay = best
        if len(known) > 1 and self._delay == known[-1]:
            self._notes.append(
                f"the delay is the longest that was tried, {known[-1]} samples: max_delay"
            )
        return tried[self._delay]

    def _fraction(self, start: _Found, places: Sequence[int]) -> _Found:
        """Move the delay by parts of a sample: golden sections between the neighbours."""
        from scipy.optimize import minimize_scalar

        fits: dict[float, _Found] = {}

        def cost(delay: float) -> float:
            fits[delay] = self._found(start.names, delay, start, places)
            return fits[delay].fit.cost

        around = (
            max(self._delay - 1, 0) if not self._own_clock else self._delay - 1,
            self._delay + 1,
        )
        found = minimize_scalar(cost, bounds=around, method="bounded", options={"xatol": 5e-3})
        if fits[found.x].fit.cost < start.fit.cost:
            self._delay = float(found.x)
            return fits[found.x]
        return start

    def _polished(self, found: _Found) -> _Found:
        """Fit again from parameters beside, and return the best.

        Where a wheel stops or breaks away the simulated motion has kinks, and the squares minima
        of no meaning.
        """
        best = found
        logarithmic = found.problem.low > 0
        for factor in _BESIDE:
            values = np.where(logarithmic, found.fit.values * factor, found.fit.values)
            beside = fit_states(found.problem, values, found.fit.states)
            tried = fit(found.problem, values, beside.states, _FEW_STEPS)
            if tried.cost < best.fit.cost:
                best = replace(found, fit=tried)
        return best

    def _renoised(self, found: _Found, places: Sequence[int]) -> _Found:
        """Weight by the noise that the residuals show, and fit again."""
        count = found.fit.values.size + found.fit.states.size
        self._noise = noise_of(found.fit.residuals, count)
        return self._found(found.names, self._delay, found, places)

    def _told(self, found: _Found) -> tuple[str, ...]:
        """Return the parameters that the log tells; of the others note what to drive."""
        names = list(found.names)
        triangle = found.fit.jacobian
        size = np.linalg.norm(triangle, axis=0)
        for name in _untold(names, triangle / np.where(size > 0, size, 1), size):
            self._undetermined[name] = "the log does not tell it apart from the others"
            names.remove(name)
        kept = [found.names.index(name) for name in names]
        errors = np.sqrt(np.diag(_inverse(triangle[:, kept])))
        for name, error in zip(list(names), errors.tolist(), strict=True):
            logarithmic = self._parameters[name].low > 0
            if error * (1.0 if logarithmic else 0.3) > _UNSURE:
                self._undetermined[name] = (
                    f"the log does not tell it (standard error {error * 100:.0f} %)"
                )
                names.remove(name)
        return tuple(names)

    def result(self) -> IdentificationResult:
        """Go all the steps."""
        self._refuse_rest()
        train, validation = self._split()
        found = self._best_delay(self._asked.free, train)
        found = self._renoised(found, train)
        self._singular = _singular(found.fit.jacobian)
        self._groups = _groups(found)
        told = self._told(found)
        if told != found.names:
            self._warn()
            if not told:
                raise ValueError("log tells no parameter: " + self._advice(self._asked.free))
            found = self._found(told, self._delay, found, train)
        if self._asked.delay == "fractional":
            found = self._fraction(found, train)
        errors = [_error(found.fit, self._deviation(), len(told)), np.nan]
        states = np.array([w.start for w in self._windows])
        states[train] = found.fit.states
        if validation:
            unseen = self._problem(told, self._delay).only(validation)
            judged = fit_states(unseen, found.fit.values, states[validation])
            errors[1] = _error(judged, self._deviation(), 0)
            states[validation] = judged.states
        whole = replace(found, fit=replace(found.fit, states=states))
        final = self._polished(self._found(told, self._delay, whole, range(len(self._windows))))
        return self._report(final, errors, validation)

    def _refuse_rest(self) -> None:
        """Refuse a log in which nothing moves."""
        speed = float(np.sqrt(np.mean(self._smooth.rate[self._smooth.good] ** 2)))
        noise = max(self._noise)
        if speed < noise or not np.ptp(self._motion.command, axis=0).any():
            what = "the robot stands" if speed < noise else "the commands never change"
            raise ValueError(f"log: {what}; {self._advice(self._asked.free)}")

    def _advice(self, names: Sequence[str]) -> str:
        return "; ".join(f"for {name}: {self._parameters[name].drive}" for name in names)

    def _warn(self) -> None:
        for name, why in list(self._undetermined.items()):
            self._undetermined[name] = f"{why}; {self._parameters[name].drive}"
            warnings.warn(
                f"identify: {name} is {self._values_given(name):.6g} as given or assumed, not "
                f"identified: {self._undetermined[name]}",
                UserWarning,
                stacklevel=4,
            )

    def _values_given(self, name: str) -> float:
        """Set a parameter back to what was given, and return it."""
        robot = self._asked.robot
        if name in ("mass", "inertia") and robot is not None:
            self._values[name] = float(getattr(robot, name))
        elif name in ("coulomb_friction", "viscous_friction"):
            self._values[name] = 0.0
        return self._values[name]

    def _deviation(self) -> Array:
        return np.array([self._noise[0], self._noise[0], self._noise[1]])

    # The report.

    def _report(
        self, final: _Found, errors: Sequence[float], validation: Sequence[int]
    ) -> IdentificationResult:
        names = final.names
        values = dict(self._values)
        values |= dict(zip(names, final.fit.values.tolist(), strict=True))
        unit = np.array(
            [values[n] if self._parameters[n].low > 0 else self._scale[n] for n in names]
        )
        covariance = _inverse(final.fit.jacobian) * np.outer(unit, unit)
        sure = dict(zip(names, np.sqrt(np.diag(covariance)).tolist(), strict=True))
        windows = self._windows
        rows = np.concatenate([w.rows for w in windows])
        number = np.concatenate([np.full(len(w.rows), i) for i, w in enumerate(windows)])
        model = np.vstack(
            [
                simulated(final.problem, i, final.fit.values, state)
                for i, state in enumerate(final.fit.states)
            ]
        )
        residual = self._motion.pose[rows] - model
        deviation = self._deviation()
        far = (np.abs(residual) > OUTLIER * deviation).any(axis=1)
        if far.any():
            self._notes.append(f"{int(far.sum())} of {len(rows)} rows are outliers")
        used = [
            name
            for name in values
            if name in names or name in FREE[self._asked.model] or name in self._asked.free
        ]
        units = {name: self._parameters[name].unit for name in used} | {"delay": "samples"}
        torque = 1.0
        if self._asked.model in DRIVES:
            given = self._drive_model((), self._values).torque(self._motion.command)
            torque = max(float(np.abs(given).max()) * values["torque_scale"], 1e-6)
        nodes = np.column_stack([self._nodes, self._smooth.pose])[self._smooth.good]
        return IdentificationResult(
            model=self._asked.model,
            parameters={**{name: values[name] for name in used}, "delay": self._delay},
            units=units,
            standard_errors={name: sure.get(name, np.inf) for name in self._asked.free},
            names=names,
            covariance=covariance,
            undetermined=self._undetermined,
            indistinguishable=self._groups,
            singular_values=self._singular,
            delay=self._delay,
            dt=self._dt,
            noise=self._noise,
            train_error=errors[0],
            validation_error=errors[1],
            whiteness={
                name: whiteness([r[:, i] for r in final.fit.residuals], 5 / 3)
                for i, name in enumerate(CHANNELS)
            },
            outliers=rows[far],
            t=self._motion.t[rows],
            measured=self._motion.pose[rows],
            simulated=model,
            window=number,
            validation=np.isin(number, validation),
            notes=tuple(self._notes),
            given_robot=self._asked.robot,
            motor=self._asked.motor,
            torque_limit=torque,
            nodes=nodes,
        )


def _error(found: Fit, deviation: Array, parameters: int) -> float:
    """Return the root mean square of residuals over noise; outliers count as their limit."""
    rows = np.concatenate(found.residuals) / deviation
    free = 1 - (found.states.size + parameters) / rows.size
    return float(np.sqrt(np.mean(np.minimum(rows**2, OUTLIER**2)) / max(free, 0.1)))


def _inverse(triangle: Array) -> Array:
    """Return (R' R)^-1."""
    if triangle.shape[1] == 0:
        return np.zeros((0, 0))
    return np.asarray(np.linalg.pinv(triangle.T @ triangle), dtype=float)


def _singular(triangle: Array) -> Array:
    size = np.linalg.norm(triangle, axis=0)
    return np.asarray(np.linalg.svd(triangle / np.where(size > 0, size, 1), compute_uv=False))


def _groups(found: _Found) -> tuple[tuple[str, ...], ...]:
    """Return which parameters have an effect each, of which some combination has none."""
    triangle = found.fit.jacobian
    size = np.linalg.norm(triangle, axis=0)
    seen = size > 1e-6 * max(float(size.max(initial=0.0)), 1e-300)
    names = [name for name, kept in zip(found.names, seen, strict=True) if kept]
    if not names:
        return ()
    _, values, rows = np.linalg.svd(triangle[:, seen] / size[seen])
    groups = []
    for value, row in zip(values, rows, strict=True):
        if value < _SINGULAR:
            strong = np.abs(row) > 0.05
            groups.append(tuple(n for n, kept in zip(names, strong, strict=True) if kept))
    return tuple(groups)


def _untold(names: Sequence[str], normal: Array, size: Array) -> list[str]:
    """Return the parameters to hold: of each combination that has no effect the last."""
    held_back: list[str] = []
    kept: list[int] = []
    for k, name in enumerate(names):
        if size[k] <= 1e-6 * max(float(size.max()), 1e-300):
            held_back.append(name)
            continue
        trial = [*kept, k]
        if np.linalg.svd(normal[:, trial], compute_uv=False)[-1] < _SINGULAR:
            held_back.append(name)
        else:
            kept.append(k)
    return held_back
