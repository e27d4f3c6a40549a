"""Margins of the drive and steering loops, linearised on a straight line."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import Controller, Scenario
from nfopidn.arguments import (
    controller_or_published,
    real_number,
    scenario_or_published,
)
from nfopidn.arithmetic import in_standard_arithmetic
from nfopidn.fractional.tracking import has_drive_and_steering, net_taps, schedule
from nfopidn.stability.loop_roots import Characteristic, power_sums, resolvent
from nfopidn.stability.pole_map import short_memory

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Response = Callable[[Array], Complex]

_GRID = 4000
_LOWEST = 1e-5  # of the grid's frequencies, as part of the highest, pi / dt
#: A filter of n taps ripples n / 2 times up to the highest frequency. With more taps than this the
#: grid, even in the logarithm, would see less than eight points of the last ripple.
_RIPPLES, _POINTS_A_RIPPLE = 87, 8
#: Up to here the poles are the map's eigenvalues, whose cost grows with the states' cube.
_FEW_STATES = 200
_NARROWEST = 1e-12  # interval around a peak, as part of its frequency


@dataclass(frozen=True)
class LoopMargins:
    """Margins of one loop, the other one closed.

    Attributes
    ----------
    gain
        factors (lower, upper) between which the loop's gain may lie; 0 and inf where nothing bounds
    phase
        lag or lead that the loop bears [rad]; inf if its gain never is 1
    delay
        lag in time that it bears [s]
    peak_sensitivity
        largest |1 / (1 + L)|
    disk
        diameter of the largest disk margin, of symmetric gain and phase changes at once
    """

    gain: tuple[float, float]
    phase: float
    delay: float
    peak_sensitivity: float
    disk: float

    def __str__(self) -> str:
        return (
            f"gain {self.gain[0]:.4g} to {self.gain[1]:.4g}, phase {self.phase:.4g} rad, "
            f"delay {self.delay:.4g} s, peak sensitivity {self.peak_sensitivity:.4g}, "
            f"disk {self.disk:.4g}"
        )


@dataclass(frozen=True)
class DiskMargin:
    """Margin against changes of both wheels' torques at once, each its own.

    Attributes
    ----------
    disk
        diameter alpha: each torque may be multiplied by any (1 + d/2)/(1 - d/2), |d| < alpha
    gain
        the real factors among them (lower, upper)
    phase
        the lags and leads among them [rad]
    frequency
        where the margin is least [rad/s]
    """

    disk: float
    gain: tuple[float, float]
    phase: float
    frequency: float

    def __str__(self) -> str:
        return (
            f"disk {self.disk:.4g} at {self.frequency:.4g} rad/s: gain {self.gain[0]:.4g} to "
            f"{self.gain[1]:.4g}, phase {self.phase:.4g} rad"
        )


@dataclass(frozen=True)
class Margins:
    """Margins at one speed.

    Attributes
    ----------
    speed
        [m/s]
    poles
        of the closed loop, largest modulus first
    drive, steering
        loops of the sum and of the difference of the torques, each broken with the other closed
    wheels
        both wheels' torques at once
    """

    speed: float
    poles: Complex
    drive: LoopMargins
    steering: LoopMargins
    wheels: DiskMargin

    @property
    def stable(self) -> bool:
        """Whether the closed loop is. The margins of one that is not are nan."""
        return bool(abs(self.poles[0]) < 1)

    def __str__(self) -> str:
        state = "stable" if self.stable else "unstable"
        return (
            f"at {self.speed:g} m/s {state}, largest pole {abs(self.poles[0]):.6f}\n"
            f"drive: {self.drive}\nsteering: {self.steering}\nwheels: {self.wheels}"
        )


class _Linear:
    """The loop on a straight line: state x, y, theta, v, omega, inputs the wheels' torques."""

    ERRORS = -np.eye(3, 5)

    def __init__(self, scenario: Scenario, controller: Controller, speed: float) -> None:
        self.dt = scenario.trajectory.dt
        self.delay = scenario.delay
        self.sums = controller.form == "incremental"
        self.state, self.input = _core.linear_plant(scenario, speed)
        # The neuron's slope at 0 (eq. 33).
        slope = 1.0 if controller.activation == "linear" else 0.5
        scale = controller.speed_scale or max(scenario.trajectory.peak_speed, 1e-9)
        lateral = {"plain": 1.0, "direction": np.sign(speed), "speed": speed / scale}
        lateral["scheduled"] = schedule(controller, speed)
        self.taps = net_taps(controller) * slope
        self.taps[1] *= lateral[controller.lateral]
        self.tracks = has_drive_and_steering(controller)
        self.poles_of_law = np.array([controller.pole_x, controller.pole_theta])
        self.integrals = np.array(
            [controller.integral_x, controller.integral_y, controller.integral_theta]
        )
        self.integrals[1] *= lateral[controller.lateral]
        self.retention = controller.integral_retention
        named = {"paper": [[0, 1, 1], [1, 1, 0]], "decoupled": [[1, 1, 1], [1, -1, -1]]}
        allocation = controller.allocation
        rows = named[allocation] if isinstance(allocation, str) else allocation
        self.allocation = np.asarray(rows, dtype=float)
        self.robot = resolvent(self.state, self.input, self.ERRORS)

    def at_wheels(self, frequency: Array) -> Complex:
        """Return the loop broken at the wheels' torques, (N, 2, 2)."""
        angle = np.atleast_1d(frequency) * self.dt
        w = np.exp(-1j * angle)
        y = np.expm1(1j * angle)  # z - 1, to all digits also at low frequencies
        determinant, motion = self.robot
        plant = polynomial.polyval(y, np.moveaxis(motion, 2, 0)) / polynomial.polyval(
            y, determinant
        )
        filters = power_sums(self.taps, w)
        if self.tracks:
            filters = filters / (1 + self.poles_of_law[_LOOP_OF, None] * w)
            # 1 - retention / z, to all digits where it is 1 and the frequency low.
            leak = (1 - self.retention) + self.retention * w * y
            filters = filters + np.divide(
                self.integrals[:, None],
                leak,
                where=self.integrals[:, None] != 0,
                out=np.zeros_like(filters),
            )
        filters = filters * w**self.delay
        if self.sums:
            filters = filters / (w * y)  # z / (z - 1)
        law = self.allocation * filters.T[:, None, :]
        return np.asarray(-law @ np.moveaxis(plant, 2, 0))

    def one_loop(self, index: int) -> Response:
        """Return the response of drive (0) or steering (1) with the other loop closed."""
        return lambda frequency: _one_loop(self.at_wheels(frequency), index)

    def poles(self) -> Complex:
        """Return the closed loop's poles: eigenvalues of the whole map at rest."""
        memory = self.taps.shape[1] - 1
        size = 5 + 3 * memory + 2 * self.sums + 4 * self.tracks + 2 * self.delay
        poles = self._roots(size) if size > _FEW_STATES and not self.tracks else None
        if poles is None:
            poles = np.linalg.eigvals(self._map(memory, size)).astype(np.complex128)
        return poles[np.argsort(-np.abs(poles))]

    def _roots(self, size: int) -> Complex | None:
        """Return the same from the characteristic function; None if that does not converge."""
        function = Characteristic.of_loop(
            self.robot, self.allocation, self.taps, sums=self.sums, delay=self.delay
        )
        found = function.roots()
        # The channels' past errors outnumber what two torques can make of them: the rest is at 0.
        return None if found is None else np.append(found, np.zeros(size - found.size))

    def _map(self, memory: int, size: int) -> Array:
        """Return the whole map at rest: robot, past errors, last torques, torques on their way."""
        past, sums = 5, 5 + 3 * memory
        line = sums + 2 * self.sums + 4 * self.tracks
        outputs = np.zeros((3, size))  # of the neurons
        outputs[:, :5] = self.taps[:, :1] * self.ERRORS
        for channel in range(3):
            columns = past + channel * memory + np.arange(memory)
            outputs[channel, columns] = self.taps[channel, 1:]
        step = np.zeros((size, size))
        if self.tracks:
            torque = self._drive_and_steering(outputs, step, sums)
        else:
            torque = self.allocation @ outputs
        for channel in range(3):
            first = past + channel * memory
            step[first, :5] = self.ERRORS[channel]
            step[first + 1 : first + memory, first : first + memory - 1] = np.eye(memory - 1)
        if self.sums:
            torque[:, sums : sums + 2] += np.eye(2)
            step[sums : sums + 2] = torque
        applied = torque
        if self.delay:
            applied = np.zeros((2, size))
            applied[:, line : line + 2] = np.eye(2)
            step[line : size - 2, line + 2 :] = np.eye(2 * self.delay - 2)
            step[size - 2 :] = torque
        step[:5, :5] += self.state
        step[:5] += self.input @ applied
        return step

    def _drive_and_steering(self, outputs: Array, step: Array, first: int) -> Array:
        """Write the rows of drive, steering and their integrals; return the torques'."""
        states = np.zeros((4, outputs.shape[1]))
        np.add.at(states, _LOOP_OF, outputs)
        sums = np.zeros((3, outputs.shape[1]))
        sums[:, :5] = self.integrals[:, None] * self.ERRORS
        np.add.at(states, 2 + _LOOP_OF, sums)
        used = [self.integrals[0] != 0, np.any(self.integrals[1:] != 0)]
        keeps = np.append(-self.poles_of_law, self.retention * np.array(used))
        states[:, first : first + 4] += np.diag(keeps)
        step[first : first + 4] = states
        drive, steering = states[0] + states[2], states[1] + states[3]
        return np.array([drive + steering, drive - steering])


#: Which loop a channel belongs to with the tracking law's pole: y and theta steer.
_LOOP_OF = np.array([0, 1, 1])
#: The torques' sum and difference.
_TO_LOOPS = np.array([[1.0, 1.0], [1.0, -1.0]])


def _one_loop(wheels: Complex, index: int) -> Complex:
    """Return drive (0) or steering (1) of loops broken at the wheels, the other loop closed."""
    other = 1 - index
    loops = _TO_LOOPS @ wheels @ np.linalg.inv(_TO_LOOPS)
    through = loops[:, index, other] * loops[:, other, index]
    return np.asarray(loops[:, index, index] - through / (1 + loops[:, other, other]))


def _roots(function: Callable[[Array], Array], grid: Array, values: Array) -> Array:
    """Return the roots between points of the grid where the function has other signs."""
    from scipy.optimize.elementwise import find_root

    places = np.flatnonzero(values[:-1] * values[1:] < 0)
    if not places.size:
        return np.empty(0)
    return np.asarray(find_root(function, (grid[places], grid[places + 1])).x, dtype=np.float64)


def _peak(function: Callable[[Array], Array], grid: Array, values: Array) -> tuple[float, float]:
    """Return the largest value on the frequencies of the grid and between, and where it is."""
    from scipy.optimize import minimize_scalar

    best = int(np.argmax(values))
    bounds = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, len(grid) - 1)])
    found = minimize_scalar(
        lambda frequency: -float(function(np.array([frequency]))[0]),
        bounds=bounds,
        method="bounded",
        options={"xatol": _NARROWEST * bounds[1]},
    )
    return max((-float(found.fun), float(found.x)), (float(values[best]), float(grid[best])))


def _off_circle(loop: Complex) -> Array:
    return np.abs(loop) - 1


def _off_axis(loop: Complex) -> Array:
    return loop.imag


def _sensitivity(loop: Complex) -> Array:
    return np.asarray(1 / np.abs(1 + loop))


def _skewed(loop: Complex) -> Array:
    return np.asarray(np.abs(0.5 * (1 - loop) / (1 + loop)))


def _loop_margins(response: Response, grid: Array, on_grid: Complex) -> LoopMargins:
    def roots(of_loop: Callable[[Complex], Array]) -> Array:
        return _roots(lambda frequency: of_loop(response(frequency)), grid, of_loop(on_grid))

    def peak(of_loop: Callable[[Complex], Array]) -> float:
        found = _peak(lambda frequency: of_loop(response(frequency)), grid, of_loop(on_grid))
        return found[0]

    crossings = np.append(roots(_off_axis), grid[-1])
    on_axis = response(crossings).real
    factors = -1 / on_axis[on_axis < 0]
    gain = (
        float(np.max(factors[factors < 1], initial=0.0)),
        float(np.min(factors[factors > 1], initial=np.inf)),
    )
    unit = roots(_off_circle)
    angle = np.angle(-response(unit)) if unit.size else np.empty(0)
    lag = np.mod(angle, 2 * np.pi) / unit if unit.size else np.empty(0)
    return LoopMargins(
        gain=gain,
        phase=float(np.min(np.abs(angle), initial=np.inf)),
        delay=float(np.min(lag, initial=np.inf)),
        peak_sensitivity=peak(_sensitivity),
        disk=1 / peak(_skewed),
    )


def _structured_value(matrix: Complex) -> Array:
    """Return the structured singular values of (N, 2, 2) matrices for two complex scalars.

    For two blocks the upper bound min over d of the largest singular value of D M D^-1,
    D = diag(d, 1), is the value itself (Packard and Doyle 1993). With |m12| d = |m21| / d the sum
    of squares is least, and with it that singular value, since the determinant does not depend
    on d.
    """
    squares = (
        np.abs(matrix[:, 0, 0]) ** 2
        + np.abs(matrix[:, 1, 1]) ** 2
        + 2 * np.abs(matrix[:, 0, 1] * matrix[:, 1, 0])
    )
    determinant = np.abs(np.linalg.det(matrix))
    return np.asarray(
        np.sqrt(0.5 * (squares + np.sqrt(np.maximum(squares**2 - 4 * determinant**2, 0))))
    )


def _disk_margin(response: Response, grid: Array, on_grid: Complex) -> DiskMargin:
    def skewed(wheels: Complex) -> Array:
        sensitivity = np.linalg.inv(np.eye(2) + wheels)
        return _structured_value(np.asarray(sensitivity - 0.5 * np.eye(2), dtype=np.complex128))

    value, frequency = _peak(lambda frequency: skewed(response(frequency)), grid, skewed(on_grid))
    disk = 1 / value
    upper = (2 + disk) / (2 - disk) if disk < 2 else np.inf
    lower = max((2 - disk) / (2 + disk), 0.0)
    return DiskMargin(
        disk=disk,
        gain=(float(lower), float(upper)),
        phase=float(2 * np.arctan(disk / 2)),
        frequency=frequency,
    )


def _grid(taps: int) -> Array:
    """Return frequencies as parts of the highest: even in the logarithm, and see each ripple."""
    grid = np.geomspace(_LOWEST, 1, _GRID)
    if taps > _RIPPLES:
        ripples = np.linspace(0, 1, _POINTS_A_RIPPLE * taps // 2 + 1)[1:]
        grid = np.union1d(grid, ripples)
    return grid


_NAN = float("nan")


@in_standard_arithmetic
def margins(
    controller: Controller | None = None,
    scenario: Scenario | None = None,
    *,
    speed: float | None = None,
) -> Margins:
    """Return the margins of the loop that drives straight on at a speed.

    The robot's motion over one sample is linearised with the scenario's integrator, friction and
    delay; the controller is its taps, the neuron's slope (1/2 of a sigmoid) and the allocation, and
    with the tracking law speed errors, schedule, poles and integral states within their limit. On
    a straight line the torques' sum drives and their difference steers. Torque limits, noise,
    disturbance and Coulomb scrub are left out.

    Parameters
    ----------
    controller
        None: the published one
    scenario
        None: the published one; its path gives the sample time and, for lateral "speed", the scale
    speed
        [m/s], in [-1e3, 1e3] but not 0, where the lateral error cannot be steered; None: the
        path's peak speed

    Returns
    -------
    Margins
        of the drive loop, the steering loop, and both wheels at once

    Raises
    ------
    ValueError
        If the speed is out of range, or the controller's memory beyond 1024 samples.

    Examples
    --------
    >>> import nfopidn
    >>> found = nfopidn.stability.margins(nfopidn.Controller.tuned_nominal(), speed=0.2)
    >>> found.stable
    True
    """
    scenario = scenario_or_published(scenario)
    controller = controller_or_published(controller, scenario)
    short_memory(controller)
    speed = real_number(
        "speed", scenario.trajectory.peak_speed if speed is None else speed, -1e3, 1e3, " m/s"
    )
    if speed == 0:
        raise ValueError("speed is 0.0; must be in [-1000, 1000] m/s and not 0")
    linear = _Linear(scenario, controller, speed)
    poles = linear.poles()
    if not abs(poles[0]) < 1:
        none = LoopMargins((_NAN, _NAN), _NAN, _NAN, _NAN, _NAN)
        wheels = DiskMargin(_NAN, (_NAN, _NAN), _NAN, _NAN)
        return Margins(speed, poles, none, none, wheels)
    grid = _grid(linear.taps.shape[1]) * (np.pi / linear.dt)
    on_grid = linear.at_wheels(grid)
    return Margins(
        speed=speed,
        poles=poles,
        drive=_loop_margins(linear.one_loop(0), grid, _one_loop(on_grid, 0)),
        steering=_loop_margins(linear.one_loop(1), grid, _one_loop(on_grid, 1)),
        wheels=_disk_margin(linear.at_wheels, grid, on_grid),
    )
