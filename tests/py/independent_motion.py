"""The robot's motion between two samples by SciPy's DOP853, for comparison.

Equations 1 to 4 of the paper as differential equations in (x, y, theta, v, omega). Coulomb friction
makes them switch: each wheel slides forwards, slides backwards or sticks, and each switch is an
event of the solver. Coulomb scrub does the same to the turning rate, as if it were a third wheel.
"""

import itertools

import numpy as np
from scipy.integrate import solve_ivp

SLIPS, STICKS = (1, -1), 0
STILL = 1e-11  # [rad/s]: a wheel at rest
ROUNDING = 1e-9


class Motion:
    """A scenario's robot under constant torques, disturbance and friction."""

    def __init__(self, scenario):
        robot = scenario.robot
        r, half = robot.wheel_radius, robot.track_width / 2
        self.viscous, self.coulomb = scenario.viscous_friction, scenario.coulomb_friction
        self.wheels_of = np.array([[1, half], [1, -half]]) / r
        self.speeds_of = np.linalg.inv(self.wheels_of)
        self.inverse_mass = np.array([1 / robot.mass, 1 / robot.inertia])
        self.per_torque = self.inverse_mass[:, None] * np.array([[1, 1], [half, -half]]) / r
        # What may stick: the wheels, and with scrub the turning. How fast each moves, what a torque
        # of friction does to v and omega, and how much of it there may be.
        self.contacts_of, self.per_friction = self.wheels_of, self.per_torque
        self.limits = [self.coulomb, self.coulomb]
        self.viscous_scrub = scenario.viscous_scrub
        if scenario.coulomb_scrub:
            self.contacts_of = np.vstack([self.wheels_of, [0, 1]])
            self.per_friction = np.column_stack([self.per_torque, [0, self.inverse_mass[1]]])
            self.limits.append(scenario.coulomb_scrub)

    def acceleration(self, speeds, friction):
        """Of v and omega; friction is the Coulomb torque at each wheel, and scrub if any."""
        torque = self.torque - self.viscous * (self.wheels_of @ speeds)
        outside = self.outside - np.array([0, self.viscous_scrub]) * speeds
        return self.per_torque @ torque + self.per_friction @ friction + self.inverse_mass * outside

    def friction(self, mode, speeds):
        """The Coulomb torques: fixed where a wheel slides, what holds it where it sticks."""
        torque = -np.array(self.limits) * np.array(mode, dtype=float)
        stuck = [contact for contact, way in enumerate(mode) if way == STICKS]
        if len(stuck) == 3:  # more than are needed: scrub takes what it can, the wheels the rest
            moment = self.acceleration(speeds, np.zeros(3))[1] / self.inverse_mass[1]
            torque[2] = np.clip(-moment, -self.limits[2], self.limits[2])
            stuck = [0, 1]
        if stuck:
            free = self.contacts_of @ self.acceleration(speeds, torque)
            coupling = (self.contacts_of @ self.per_friction)[np.ix_(stuck, stuck)]
            torque[stuck] = np.linalg.solve(coupling, -free[stuck])
        return torque

    def mode(self, speeds):
        """The one way to slide or stick that contradicts neither friction's limit nor its sign."""
        wheels = self.contacts_of @ speeds
        ways = [
            (int(np.sign(speed)),) if abs(speed) > STILL else (*SLIPS, STICKS) for speed in wheels
        ]
        for mode in itertools.product(*ways):
            if len(mode) == 3 and mode.count(STICKS) == 2:
                continue  # two that stick hold the third
            friction = self.friction(mode, speeds)
            pull = self.contacts_of @ self.acceleration(speeds, friction)
            slack = [
                self.limits[i] * (1 - ROUNDING) - abs(friction[i])
                if mode[i] == STICKS
                # Where it is just breaking loose the pull is zero at first.
                else pull[i] * mode[i] + ROUNDING
                for i in range(len(mode))
                if abs(wheels[i]) <= STILL
            ]
            held = mode.count(STICKS) == 3 and abs(friction[:2]).max() <= self.coulomb
            if held or all(value > 0 for value in slack):
                return mode
        raise AssertionError(f"no way to move from wheel speeds {wheels}")

    def events(self, mode):
        """A sliding wheel stops; a stuck one breaks loose."""
        for wheel, way in enumerate(mode):
            if way != STICKS:
                yield lambda _, y, i=wheel, s=way: s * (self.contacts_of @ y[3:])[i]
            else:
                for sign in SLIPS:
                    yield (
                        lambda _, y, i=wheel, s=sign: (
                            self.limits[i] - s * self.friction(mode, y[3:])[i]
                        )
                    )

    def advance(self, state, torque, outside, duration):
        """The state after a time, and the modes it went through."""
        self.torque, self.outside = np.array(torque), np.array(outside)
        state, time, modes = np.array(state), 0.0, []
        while time < duration:
            mode = self.mode(state[3:]) if any(self.limits) else (1, 1)
            modes.append(mode)
            if mode[:2] == (STICKS, STICKS):
                return state, modes
            events = list(self.events(mode)) if any(self.limits) else []
            for event in events:
                event.terminal, event.direction = True, -1

            def slope(_, y, mode=mode):
                drive = self.acceleration(y[3:], self.friction(mode, y[3:]))
                return [y[3] * np.cos(y[2]), y[3] * np.sin(y[2]), y[4], *drive]

            solution = solve_ivp(
                slope,
                (time, duration),
                state,
                method="DOP853",
                events=events or None,
                rtol=1e-13,
                atol=1e-14,
                max_step=duration / 8 if any(self.limits) else np.inf,
            )
            time, state = solution.t[-1], solution.y[:, -1]
            wheels = self.wheels_of @ state[3:]
            wheels[(np.abs(wheels) < STILL) | (np.array(mode[:2]) == STICKS)] = 0
            state[3:] = self.speeds_of @ wheels
            if len(mode) == 3 and (mode[2] == STICKS or abs(state[4]) < STILL):
                state[4] = 0
        return state, modes
