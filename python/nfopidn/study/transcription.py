"""The open-loop problem as a sparse nonlinear programme: states and torques are its variables."""

from __future__ import annotations

from dataclasses import dataclass, replace
from threading import Event
from typing import Any

import numpy as np

from nfopidn import _core
from nfopidn._core import Scenario, SimulationResult
from nfopidn.study.motion import (
    STATES,
    Array,
    accelerations,
    branches,
    disturbances,
    friction_rates,
    start,
)

#: Widths [rad/s] of the wheel speeds over which Coulomb friction turns round, one after another.
_WIDTHS = tuple(10.0 ** (-power / 2) for power in range(11))
#: So many of them tell one first guess from another.
_COARSE = 3
#: A narrower width that changes the run's cost by a smaller share is the last one.
_REFINED = 1e-4
#: Solutions after which the branch of the heading is chosen again, at most.
_REBRANCHINGS = 10
_TOLERANCE = 1e-9
_SOLVED = "Solve_Succeeded"


@dataclass(frozen=True)
class Motion:
    """States (N, 5) and torques (N, 2) [N m]: a guess, which may be no motion at all, or a run."""

    states: Array
    torque: Array


def motion_of(run: SimulationResult) -> Motion:
    """Return a run's states and torques."""
    names = ("x", "y", "theta", "v", "omega")
    return Motion(np.column_stack([run.columns[name] for name in names]), np.array(run.torque))


@dataclass(frozen=True)
class Solution:
    """What the solver made of a guess: `status` in its words, and what it found, if it converged.

    Attributes
    ----------
    cost
        eq. 41; with Coulomb friction that of the smoothed problem, until it is refined
    run
        the simulation of the torques; with Coulomb friction once the solution is refined
    motion
        the programme's own
    rubbing
        the friction [N m] that belongs to it
    settled
        whether smoothing Coulomb friction less changes the cost by less than 1e-4 of it
    """

    status: str
    cost: float | None = None
    run: SimulationResult | None = None
    motion: Motion | None = None
    rubbing: Array | None = None
    settled: bool = True


def casadi() -> Any:
    """Return the module casadi.

    Raises
    ------
    ImportError
        If it is not installed.
    """
    try:
        import casadi
    except ImportError:
        text = "open_loop_optimum needs CasADi: pip install 'nfopidn[optimum]'"
        raise ImportError(text) from None
    return casadi


def _residuals(ca: Any, scenario: Scenario, state: Any, torque: Any, rubbing: Any) -> list[Any]:
    """Return by how much each sample's state misses the motion from the sample before.

    `rubbing` has the Coulomb friction [N m] of both wheels in each substep, a row each, and with
    them come the wheel speeds after each substep; None, and none, without Coulomb friction.
    """
    step = scenario.trajectory.dt / scenario.substeps
    robot = scenario.robot
    by_sum, by_difference = accelerations(robot)
    drive, turn = (1 + step * rate for rate in friction_rates(scenario))
    pushes = ca.DM(disturbances(scenario)[:-1].T)
    x, y, theta, v, omega = (state[row, :-1] for row in range(STATES))
    left, right = _applied(ca, scenario, torque)
    v_rate = by_sum * (left + right) + pushes[0, :]
    omega_rate = by_difference * (left - right) + pushes[1, :]
    speeds = []
    for substep in range(scenario.substeps):
        v = (v + step * v_rate) / drive
        omega = (omega + step * omega_rate) / turn
        if rubbing is not None:
            of_left, of_right = rubbing[2 * substep, :], rubbing[2 * substep + 1, :]
            v = v + step * by_sum * (of_left + of_right)
            omega = omega + step * by_difference * (of_left - of_right)
            sideways = omega * robot.track_width / 2
            speeds += [(v + sideways) / robot.wheel_radius, (v - sideways) / robot.wheel_radius]
        x = x + step * v * ca.cos(theta)
        y = y + step * v * ca.sin(theta)
        theta = theta + step * omega
    missed = ca.vec(state[:, 1:] - ca.vertcat(x, y, theta, v, omega))
    return [missed, ca.vertcat(*speeds) if speeds else None]


def _applied(ca: Any, scenario: Scenario, torque: Any) -> tuple[Any, Any]:
    """Return the torques that reach the wheels: those commanded `delay` samples before."""
    delay = min(scenario.delay, torque.shape[1] - 1)
    arriving = ca.horzcat(ca.SX.zeros(2, delay), torque[:, : torque.shape[1] - 1 - delay])
    return arriving[0, :], arriving[1, :]


def _watch(ca: Any, sizes: dict[str, int], stop: Event) -> Any:
    """Return what IPOPT asks after each iteration: 1 ends it."""
    outputs = [ca.nlpsol_out(place) for place in range(ca.nlpsol_n_out())]

    class Watch(ca.Callback):  # type: ignore[misc]  # casadi has no types
        def get_n_in(self) -> int:
            return len(outputs)

        def get_n_out(self) -> int:
            return 1

        def get_sparsity_in(self, place: int) -> Any:
            size = sizes.get(outputs[place].removeprefix("lam_"), 1)
            return ca.Sparsity.dense(size, 1)

        def eval(self, _: Any) -> list[int]:
            return [int(stop.is_set())]

    watch = Watch()
    watch.construct("watch", {})
    return watch


class Programme:
    """Eq. 41 over all torques within the limit, for one scenario.

    On a fixed branch of the heading, whole turns for each sample, the wrapped error is smooth.
    Coulomb friction is smoothed: c w / sqrt(w^2 + width^2) at the wheel speed w after each step, in
    which the simulation's own friction is implicit too. Branches and width are the programme's
    parameters, so that one programme serves every guess.
    """

    def __init__(self, scenario: Scenario, max_iter: int, stop: Event) -> None:
        """Take the scenario, the solver's most iterations, and what ends it earlier when set."""
        ca = casadi()
        self.scenario = scenario
        self._stop = stop
        count = len(scenario.trajectory)
        rubs = scenario.coulomb_friction > 0 and count > 1
        rows = 2 * scenario.substeps if rubs else 0
        reference = ca.DM(scenario.reference[:, :7].T)
        state, torque = ca.SX.sym("state", STATES, count), ca.SX.sym("torque", 2, count)
        rubbing = ca.SX.sym("rubbing", rows, count - 1) if rubs else ca.SX(0, 0)
        turns, width = ca.SX.sym("turns", 1, count), ca.SX.sym("width")
        missed, speeds = _residuals(ca, scenario, state, torque, rubbing if rubs else None)
        constraints = [missed]
        if rubs:
            opposing = scenario.coulomb_friction * speeds / ca.sqrt(speeds**2 + width**2)
            constraints.append(ca.vec(rubbing + opposing))
        position, heading, effort = scenario.cost_weights
        total = (
            position * ca.sumsqr(state[:2, :] - reference[:2, :])
            + heading * ca.sumsqr(reference[2, :] + turns - state[2, :])
            + effort * ca.sumsqr(torque - reference[5:7, :])
        )
        programme = {
            "x": ca.vertcat(ca.vec(state), ca.vec(torque), ca.vec(rubbing)),
            "f": total,
            "g": ca.vertcat(*constraints),
            "p": ca.vertcat(turns.T, width),
        }
        ipopt = {"print_level": 0, "sb": "yes", "max_iter": max_iter, "tol": _TOLERANCE}
        self._watch = _watch(ca, {name: programme[name].numel() for name in "xgp"}, stop)
        options = {"ipopt": ipopt, "print_time": 0, "iteration_callback": self._watch}
        self._solver = ca.nlpsol("optimum", "ipopt", programme, options)
        bound = np.concatenate(
            [
                np.full(STATES * count, np.inf),
                np.full(2 * count, scenario.torque_limit),
                np.full(rubbing.numel(), np.inf),
            ]
        )
        self._low, self._high = -bound, bound.copy()
        self._low[:STATES] = self._high[:STATES] = start(scenario)
        self._rubbing = np.zeros(rubbing.numel())

    def solve(self, guess: Motion) -> Solution:
        """Descend from a guess; its own heading chooses the branch.

        With Coulomb friction only as far as tells one guess from another; refine() goes on.
        """
        self._rubbing = np.zeros_like(self._rubbing)
        widths = _WIDTHS[:_COARSE] if self._rubbing.size else _WIDTHS[:1]
        found, status, smooth = guess, "", None
        for width in widths:
            found, status, smooth = self._on_its_branch(found, width)
            if status != _SOLVED:
                return Solution(status)
        if self._rubbing.size:
            return Solution(status, smooth, None, found, self._rubbing)
        return self._run(found, status)

    def refine(self, found: Solution) -> Solution:
        """Smooth Coulomb friction ever less, until that changes the cost by less than 1e-4 of it.

        The solution is the best run on the way; without Coulomb friction it is the given one.
        """
        if found.run is not None or found.motion is None or found.rubbing is None:
            return found
        best = replace(self._run(found.motion, found.status), settled=False)
        last: float | None = None
        guess, self._rubbing = found.motion, found.rubbing
        for width in _WIDTHS[_COARSE:]:
            if self._stop.is_set():
                break
            guess, status, _ = self._on_its_branch(guess, width)
            if status != _SOLVED:
                break
            narrow = self._run(guess, status)
            if narrow.cost is None:
                continue
            if best.cost is None or narrow.cost < best.cost:
                best = replace(narrow, settled=False)
            if last is not None and abs(narrow.cost - last) < _REFINED * last:
                return replace(best, settled=True)
            last = narrow.cost
        return best

    def _on_its_branch(self, guess: Motion, width: float) -> tuple[Motion, str, float]:
        turns = branches(self.scenario, guess.states[:, 2])
        status, cost = "", np.inf
        for _ in range(_REBRANCHINGS):
            guess, status, cost = self._descend(guess, turns, width)
            if status != _SOLVED:
                break
            before, turns = turns, branches(self.scenario, guess.states[:, 2])
            if np.array_equal(before, turns):
                break
        return guess, status, cost

    def _descend(self, guess: Motion, turns: Array, width: float) -> tuple[Motion, str, float]:
        first = np.concatenate([guess.states.ravel(), guess.torque.ravel(), self._rubbing])
        answer = self._solver(
            x0=first, p=np.append(turns, width), lbx=self._low, ubx=self._high, lbg=0, ubg=0
        )
        variables = np.array(answer["x"]).ravel()
        states, end = guess.states.size, guess.states.size + guess.torque.size
        self._rubbing = variables[end:]
        torque = variables[states:end].reshape(-1, 2)
        motion = Motion(variables[:states].reshape(-1, STATES), torque)
        cost = float(answer["f"]) / len(torque)
        return motion, str(self._solver.stats()["return_status"]), cost

    def _run(self, found: Motion, status: str) -> Solution:
        """Simulate the torques found, which keeps limit and motion to the last bit."""
        limit = self.scenario.torque_limit
        run = _core.play(self.scenario, np.clip(found.torque, -limit, limit))
        if run.diverged_at is not None:
            return Solution("its run diverges")
        return Solution(status, run.cost, run, found)
