"""A scenario and a controller with no field at its default."""

import numpy as np
from nfopidn import Controller, Motor, Robot, Scenario, Trajectory

_TIME = np.arange(60)

SCENARIO = Scenario(
    Trajectory.from_samples(_TIME / 50, 0.2 * np.sin(_TIME / 9), 0.1, heading="continuous"),
    Robot.eddie_datasheet(),
    initial_pose=(0.1, 1 / 3, -0.2),
    initial_velocity="reference",
    torque_limit=1.7,
    feedforward=False,
    integrator="exact",
    substeps=3,
    disturbance=np.random.default_rng(0).normal(size=(60, 2)) / 7,
    viscous_friction=0.01,
    coulomb_friction=0.02,
    pose_noise=(0.003, 0.004),
    delay=2,
    divergence_distance=5.5,
    rng=2**53 - 1,
    model=Robot(9.5, 0.4, 0.4, 0.07),
    motor=Motor(2.1, 0.02, 0.021, 31.0, 1e-6, 0.001, 0.002, 11.5, 0.3),
    feedforward_limit=0.9,
    encoder_counts=1024,
    odometry_errors=(0.01, -0.005, 0.02),
    friction_feedforward=(0.011, 0.021),
    friction_feedforward_speed=0.3,
    viscous_scrub=0.03,
    coulomb_scrub=0.04,
    cost_weights=(2.0, 0.5, 1 / 3),
    noise_source="counter",
)
CONTROLLER = Controller(
    np.arange(9).reshape(3, 3) / 70,
    (0.1, 0.2, 1 / 3),
    (1.0, -1.5, 2.0),
    memory=40,
    form="incremental",
    allocation=[[1, 0.5, 0.25], [1, -0.5, -0.25]],
    activation="linear",
    frame="world",
    generator="gl",
    lateral="speed",
    speed_scale=0.4,
    anti_windup="clamp",
    sample_time=0.1,
)
