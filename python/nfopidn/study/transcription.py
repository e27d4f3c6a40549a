"""The open-loop problem as a sparse nonlinear programme: states and torques are its variables."""

from __future__ import annotations

from dataclasses import dataclass
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

#: Solutions after which the branch of the heading is chosen anew, at most.
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
    """What the solver made of a guess: `status` in its words, and the run, if it converged."""

    status: str
    run: SimulationResult | None = None

    @property
    def cost(self) -> float | None:
        """Eq. 41 of the run."""
        return None if self.run is None else self.run.cost


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


def _residuals(ca: Any, scenario: Scenario, state: Any, torque: Any) -> Any:
    """Return by how much each sample's state misses the motion from the sample before."""
    step = scenario.trajectory.dt / scenario.substeps
    by_sum, by_difference = accelerations(scenario.robot)
    drive, turn = (1 + step * rate for rate in friction_rates(scenario))
    pushes = ca.DM(disturbances(scenario)[:-1].T)
    x, y, theta, v, omega = (state[row, :-1] for row in range(STATES))
    left, right = torque[0, :-1], torque[1, :-1]
    v_rate = by_sum * (left + right) + pushes[0, :]
    omega_rate = by_difference * (left - right) + pushes[1, :]
    for _ in range(scenario.substeps):
        v = (v + step * v_rate) / drive
        omega = (omega + step * omega_rate) / turn
        x = x + step * v * ca.cos(theta)
        y = y + step * v * ca.sin(theta)
        theta = theta + step * omega
    return ca.vec(state[:, 1:] - ca.vertcat(x, y, theta, v, omega))


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

    On a fixed branch of the heading, whole turns for each sample, the wrapped error is smooth. The
    branches are the programme's parameter, so that one programme serves every guess.
    """

    def __init__(self, scenario: Scenario, max_iter: int, stop: Event) -> None:
        """Take the scenario, the solver's most iterations, and what ends it earlier when set."""
        ca = casadi()
        self.scenario = scenario
        count = len(scenario.trajectory)
        reference = ca.DM(scenario.reference[:, :7].T)
        state, torque = ca.SX.sym("state", STATES, count), ca.SX.sym("torque", 2, count)
        turns = ca.SX.sym("turns", 1, count)
        position, heading, effort = scenario.cost_weights
        total = (
            position * ca.sumsqr(state[:2, :] - reference[:2, :])
            + heading * ca.sumsqr(reference[2, :] + turns - state[2, :])
            + effort * ca.sumsqr(torque - reference[5:7, :])
        )
        programme = {
            "x": ca.vertcat(ca.vec(state), ca.vec(torque)),
            "f": total,
            "g": _residuals(ca, scenario, state, torque),
            "p": turns.T,
        }
        ipopt = {"print_level": 0, "sb": "yes", "max_iter": max_iter, "tol": _TOLERANCE}
        self._watch = _watch(ca, {name: programme[name].numel() for name in "xgp"}, stop)
        options = {"ipopt": ipopt, "print_time": 0, "iteration_callback": self._watch}
        self._solver = ca.nlpsol("optimum", "ipopt", programme, options)
        bound = np.concatenate(
            [np.full(STATES * count, np.inf), np.full(2 * count, scenario.torque_limit)]
        )
        self._low, self._high = -bound, bound.copy()
        self._low[:STATES] = self._high[:STATES] = start(scenario)

    def solve(self, guess: Motion) -> Solution:
        """Descend from a guess; its own heading chooses the branch."""
        turns = branches(self.scenario, guess.states[:, 2])
        for _ in range(_REBRANCHINGS):
            guess, status = self._descend(guess, turns)
            if status != _SOLVED:
                return Solution(status)
            before, turns = turns, branches(self.scenario, guess.states[:, 2])
            if np.array_equal(before, turns):
                break
        return self._run(guess, status)

    def _descend(self, guess: Motion, turns: Array) -> tuple[Motion, str]:
        first = np.concatenate([guess.states.ravel(), guess.torque.ravel()])
        answer = self._solver(x0=first, p=turns, lbx=self._low, ubx=self._high, lbg=0, ubg=0)
        variables = np.array(answer["x"]).ravel()
        end = guess.states.size
        motion = Motion(variables[:end].reshape(-1, STATES), variables[end:].reshape(-1, 2))
        return motion, str(self._solver.stats()["return_status"])

    def _run(self, found: Motion, status: str) -> Solution:
        """Simulate the torques found, which keeps limit and motion to the last bit."""
        limit = self.scenario.torque_limit
        run = _core.play(self.scenario, np.clip(found.torque, -limit, limit))
        return (
            Solution("its run diverges") if run.diverged_at is not None else Solution(status, run)
        )
