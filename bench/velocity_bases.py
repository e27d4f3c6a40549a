"""How fast a base that takes velocities must follow them: the published scenario's cost (eq. 41).

    python bench/velocity_bases.py

The torques pass through the nominal model, as in VelocityOutput; the base follows v and omega with
a first-order lag. With and without going on from the base's velocity at every sample.
"""

from __future__ import annotations

from math import cos, exp, hypot, inf, pi, sin

from nfopidn import Controller, Scenario

SCENARIO = Scenario.published(rng=0)
PERIOD = SCENARIO.trajectory.dt
STEPS = 20  # of the base's motion in a sample
LAGS = (0.0, 0.02, 0.05, 0.1, 0.2)  # time constants [s]


def cost(controller: Controller, lag: float, synchronised: bool) -> float:
    """E of a run; infinite if it diverges."""
    robot = SCENARIO.robot
    drive = PERIOD / (robot.mass * robot.wheel_radius)
    steer = PERIOD * robot.track_width / (2 * robot.inertia * robot.wheel_radius)
    share = 1 - exp(-PERIOD / STEPS / lag) if lag > 0 else 1.0
    x, y, theta = SCENARIO.initial_pose
    v = omega = wanted_v = wanted_omega = total = 0.0
    controller.reset()
    for row in SCENARIO.reference:
        left, right = controller.step([x, y, theta], row)
        distance = hypot(row[0] - x, row[1] - y)
        turn = (row[2] - theta + pi) % (2 * pi) - pi
        total += distance**2 + turn**2 + (row[5] - left) ** 2 + (row[6] - right) ** 2
        if distance > SCENARIO.divergence_distance:
            return inf
        if synchronised:
            wanted_v, wanted_omega = v, omega
        wanted_v += (left + right) * drive
        wanted_omega += (left - right) * steer
        for _ in range(STEPS):
            v += (wanted_v - v) * share
            omega += (wanted_omega - omega) * share
            x += v * cos(theta) * PERIOD / STEPS
            y += v * sin(theta) * PERIOD / STEPS
            theta += omega * PERIOD / STEPS
    return float(total / len(SCENARIO.reference))


def main() -> None:
    """Print the table."""
    print(f"{'':12}{'':16}" + "".join(f"{f'lag {lag:g} s':>12}" for lag in LAGS))
    for name, gains in {
        "published": Controller.published(),
        "tuned": Controller.tuned_nominal(),
    }.items():
        for synchronised in (False, True):
            kind = "every sample" if synchronised else "never"
            cells = "".join(f"{cost(gains, lag, synchronised):12.4f}" for lag in LAGS)
            print(f"{name:12}{kind:16}{cells}")


if __name__ == "__main__":
    main()
