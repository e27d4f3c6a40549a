"""The time of TOPP-RA along a path that is given by its curvature."""

import numpy as np
import toppra
from nfopidn.trajectories.limits import wheel_torques
from toppra.algorithm import TOPPRA
from toppra.constraint import DiscretizationType, SecondOrderConstraint


class PathOfLength(toppra.interpolator.AbstractGeometricPath):
    """(length, heading): its velocities are v and omega, its accelerations those of both."""

    def __init__(self, motion):
        self.motion = motion
        heading = np.concatenate(
            [[0], np.cumsum(0.5 * (motion.turn[1:] + motion.turn[:-1]) * motion.step)]
        )
        self.columns = [
            np.stack([motion.s, heading]),
            np.stack([motion.drive, motion.turn]),
            np.stack([np.zeros_like(motion.s), motion.slope]),
        ]

    def __call__(self, places, order=0):
        found = [np.interp(places, self.motion.s, column) for column in self.columns[order]]
        return np.stack(found, axis=-1)

    @property
    def dof(self):
        return 2

    @property
    def path_interval(self):
        return np.array([0.0, self.motion.s[-1]])


def duration(motion, limits, robot):
    """Return the time [s] from rest to rest under speed, turn rate, accelerations and torques."""

    def demands(_, velocity, acceleration):
        del velocity
        torques = wheel_torques(robot, acceleration[0], acceleration[1])
        return np.array([acceleration[0], acceleration[1], *torques])

    bound = np.array([limits.acceleration, limits.turn_acceleration, *[limits.wheel_torque] * 2])
    second = SecondOrderConstraint(
        demands,
        lambda _: np.vstack([np.eye(4), -np.eye(4)]),
        lambda _: np.concatenate([bound, bound]),
        2,
        discretization_scheme=DiscretizationType.Interpolation,
    )
    with np.errstate(divide="ignore"):
        lateral = np.sqrt(limits.lateral_acceleration / np.abs(motion.turn))
        turning = limits.turn_rate / np.abs(motion.turn)
        most = np.minimum(limits.speed, np.minimum(lateral, turning))

    def speeds(place):
        fastest = np.interp(place, motion.s, most)
        return np.array([[-fastest, fastest], [-1e6, 1e6]])

    first = toppra.constraint.JointVelocityConstraintVarying(speeds)
    first.set_discretization_type(DiscretizationType.Collocation)
    algorithm = TOPPRA(
        [first, second],
        PathOfLength(motion),
        gridpoints=motion.s,
        parametrizer="ParametrizeConstAccel",
    )
    return float(algorithm.compute_trajectory(0, 0).duration)
