"""What the settings and metrics are called, their units, and what they mean."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class Words(NamedTuple):
    """A name for people, the unit (one a number, by commas), a line on the meaning."""

    label: str
    unit: str
    meaning: str


#: By group and by key of the scenario's document; a dot enters trajectory or robot.
SCENARIO: Mapping[str, Mapping[str, Words]] = {
    "Path": {
        "trajectory.name": Words("Path", "", ""),
        "trajectory.period": Words("Lap time", "s", "of one lap of the reference"),
        "trajectory.dt": Words("Sample time", "s", "T; the gains hold for it alone"),
        "trajectory.cusps": Words("Cusps", "", "of the epicycloid"),
        "trajectory.heading": Words("Heading", "", "how the reference's heading is read"),
        "trajectory.scale": Words("Scale", "", "factor on the size of the path"),
        "trajectory.laps": Words("Laps", "", "in the run"),
        "trajectory.derivatives": Words("Derivatives", "", "where the reference's rates come from"),
        "trajectory.standstill_speed": Words(
            "Standstill speed", "m/s", "slower, the heading of the motion holds"
        ),
        "trajectory.theta": Words("Headings", "rad", "given, not taken from the motion"),
        "trajectory.reverse": Words("Reversing", "", "where the robot drives backwards"),
        "trajectory.x": Words("Positions x", "m", "samples of the path"),
        "trajectory.y": Words("Positions y", "m", "samples of the path"),
    },
    "Robot": {
        "robot.mass": Words("Mass", "kg", ""),
        "robot.inertia": Words("Inertia", "kg m²", "about the vertical axis"),
        "robot.track_width": Words("Track width", "m", "distance between the wheels"),
        "robot.wheel_radius": Words("Wheel radius", "m", ""),
        "torque_limit": Words("Torque limit", "N m", "of each wheel's total torque"),
        "viscous_friction": Words("Viscous friction", "N m s/rad", "at each wheel"),
        "coulomb_friction": Words("Coulomb friction", "N m", "at each wheel"),
        "viscous_scrub": Words("Viscous scrub", "N m s/rad", "moment that opposes turning"),
        "coulomb_scrub": Words("Coulomb scrub", "N m", "moment that opposes turning"),
        "motor.resistance": Words("Motor resistance", "ohm", "of the winding"),
        "motor.torque_constant": Words("Motor torque constant", "N m/A", ""),
        "motor.back_emf_constant": Words("Motor back-EMF constant", "V s/rad", ""),
        "motor.gear_ratio": Words("Gear ratio", "", "turns of the motor per turn of the wheel"),
        "motor.rotor_inertia": Words("Rotor inertia", "kg m²", ""),
        "motor.viscous_friction": Words("Motor viscous friction", "N m s/rad", "at the wheel"),
        "motor.coulomb_friction": Words("Motor Coulomb friction", "N m", "at the wheel"),
        "motor.supply_voltage": Words("Supply voltage", "V", "in either direction"),
        "motor.dead_band": Words("Dead band", "V", "that drive and gear swallow"),
    },
    "Run": {
        "initial_pose": Words("Initial pose", "m,m,rad", "x, y, heading at the start"),
        "initial_velocity": Words("Initial velocity", "m/s,rad/s", "speed and turn rate"),
        "feedforward": Words("Feedforward", "", "the reference's torques are added"),
        "cost_weights": Words("Cost weights", "", "of position, heading and torque errors"),
        "noise_source": Words("Noise source", "", "of the draws"),
        "feedforward_limit": Words("Feedforward limit", "N m", "of a wheel's reference torque"),
        "friction_feedforward": Words(
            "Friction feedforward", "N m s/rad,N m", "viscous and Coulomb, of each wheel"
        ),
        "friction_feedforward_speed": Words(
            "Friction feedforward speed", "rad/s", "wheel speed that smooths the Coulomb part"
        ),
        "disturbance": Words("Disturbance", "N,N m", "forward force and moment"),
        "pose_noise": Words("Noise", "m,rad", "standard deviation of measured position, heading"),
        "encoder_counts": Words("Encoder counts", "", "a revolution; 0: the pose is measured"),
        "odometry_errors": Words("Odometry errors", "", "of left, right radius and track"),
        "delay": Words("Delay", "samples", "from measurement to applied torque"),
        "integrator": Words("Integrator", "", "of the robot's motion"),
        "substeps": Words("Integration steps", "", "in a sample"),
        "divergence_distance": Words(
            "Divergence distance", "m", "a run farther than this from its reference has diverged"
        ),
        "seed": Words("Seed", "", "of the noise"),
    },
}

CONTROLLER: Mapping[str, Words] = {
    "memory": Words("Memory M", "samples", "terms of the fractional operators' power series"),
    "form": Words("Output", "", ""),
    "allocation": Words("Allocation", "", "which neuron drives which wheel"),
    "activation": Words("Activation", "", "the neuron's function"),
    "frame": Words("Frame", "", "of the position errors"),
    "generator": Words(
        "Generator", "", "power series that stands for s^\N{GREEK SMALL LETTER ALPHA}"
    ),
    "lateral": Words("Lateral error", "", "what the y channel is fed"),
    "anti_windup": Words("Anti-windup", "", "what the incremental form does at the torque limit"),
    "speed_scale": Words("Speed scale", "m/s", "divisor of the speed in the lateral error"),
    "net": Words("Net", "", "what the sums of eq. 34 run over"),
    "speed_gain_x": Words("Speed gain, x", "N m/m", "of the forward speed error"),
    "speed_gain_theta": Words("Speed gain, θ", "N m/rad", "of the turn-rate error"),
    "speed_order_x": Words("Speed order, x", "", "of the derivative, counted from the position"),
    "speed_order_theta": Words("Speed order, θ", "", "of the derivative, counted from the angle"),
    "amplitude_x": Words("Amplitude, x", "N m", "of the neuron"),
    "amplitude_y": Words("Amplitude, y", "N m", "of the neuron"),
    "amplitude_theta": Words("Amplitude, θ", "N m", "of the neuron"),
    "pole_x": Words("Pole, drive", "", "phase lead against delay"),
    "pole_theta": Words("Pole, steering", "", "phase lead against delay"),
    "integral_x": Words("Integral gain, x", "N m/m", "of the drive's integral state"),
    "integral_y": Words("Integral gain, y", "N m/m", "of the steering's integral state"),
    "integral_theta": Words("Integral gain, θ", "N m/rad", "of the steering's integral state"),
    "integral_retention": Words("Integral retention", "", "share left after a sample"),
    "integral_limit": Words("Integral limit", "N m", "of each integral state"),
    "lateral_speed": Words("Lateral speed", "m/s", "v0 of the scheduled lateral error"),
    "lateral_power": Words("Lateral power", "", "p of the scheduled lateral error"),
    "sample_time": Words("Sample time", "s", "that the gains are made for"),
}


def _robot(meaning: str) -> dict[str, Words]:
    """Give the words of a robot's settings, which mean a robot of one's own."""
    return {
        key.removeprefix("robot."): Words(words.label, words.unit, meaning)
        for key, words in SCENARIO["Robot"].items()
        if key.startswith("robot.")
    }


RIVAL: Mapping[str, Words] = {
    "law": Words("Law", "", ""),
    "speeds": Words("Speeds", "", "that the law is given"),
    **_robot("of the law's own model"),
}

#: Of the robot that a controller is made for.
MADE_FOR: Mapping[str, Words] = _robot("of the robot that the gains are made for")

#: Label and meaning; the units are the core's.
METRICS: Mapping[str, tuple[str, str]] = {
    "cost": ("Cost E", "mean square of pose and torque errors (eq. 41)"),
    "pose_mse": ("Pose error, mean square", "m² and rad² added"),
    "position_rms": ("Position error, r.m.s.", "distance to the reference point"),
    "position_max": ("Position error, largest", "the start included"),
    "heading_rms": ("Heading error, r.m.s.", ""),
    "iae": ("IAE", "integral of the position error's size"),
    "ise": ("ISE", "integral of its square"),
    "itae": ("ITAE", "integral of its size times time"),
    "torque_peak": ("Torque, largest", "of either wheel"),
    "torque_variation": ("Torque, total variation", "of both wheels together"),
    "share_at_limit": ("Share at the limit", "samples with a wheel's torque at its limit"),
    "energy": ("Energy", "integral of |torque times wheel speed|, both wheels"),
    "lateral_force_peak": ("Lateral force, largest", "that keeps the wheels from slipping"),
}

#: What a word or a missing value stands for, by the last part of its key.
CHOICES: Mapping[tuple[str, str], str] = {
    ("name", "ranunculoid"): "epicycloid (“ranunculoid”)",
    ("name", "rounded_square"): "rounded square",
    ("name", "samples"): "sampled points",
    ("heading", "forward"): "forward, along the motion",
    ("heading", "continuous"): "continuous, reversing at cusps",
    ("derivatives", "sampled"): "central differences of the samples",
    ("derivatives", "analytic"): "closed forms",
    ("integrator", "semi-implicit-euler"): "semi-implicit Euler",
    ("initial_pose", "none"): "the reference's own",
    ("initial_velocity", "reference"): "the reference's own",
    ("form", "positional"): "positional: the neurons' output is the torque",
    ("form", "incremental"): "incremental: the neurons' output is added to the last torque",
    ("activation", "sigmoid"): "sigmoid, O = tanh(net/2)",
    ("activation", "linear"): "linear, O = net",
    ("frame", "robot"): "the robot's",
    ("frame", "world"): "the world's",
    ("generator", "tustin"): "Tustin, pre-warped",
    ("generator", "gl"): "Grünwald-Letnikov",
    ("lateral", "plain"): "the lateral error itself",
    ("lateral", "direction"): "with its sign turned where the reference drives in reverse",
    ("lateral", "speed"): "times the reference's speed over the speed scale",
    ("lateral", "scheduled"): "times a function of the reference's speed",
    ("speed_scale", "0"): "the trajectory's peak speed",
    ("net", "increment"): "differences of the error, as eq. 34",
    ("net", "whole"): "the error itself",
    ("net", "speed-errors"): "the error itself; its derivative is the speed error's",
}
