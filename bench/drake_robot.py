"""A robot in Drake, moved by torques that come in line by line; drake_engine.py starts it.

It runs in a Python that has pydrake and needs nothing of nfopidn. The first line is the model and
the start as JSON, each further one the torques [N m] of the left and the right wheel (REP-103) for
a sample. The answers are x, y [m], theta [rad], v [m/s], omega [rad/s]: one before the first
torques, and one behind each pair.
The model is written here a second time, not read from MuJoCo's, so that a mistake in one shows.
"""

import json
import logging
import math
import sys

import numpy as np
from pydrake.geometry import AddContactMaterial, Cylinder, HalfSpace, ProximityProperties, Sphere
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    CoulombFriction,
    DiscreteContactApproximation,
)
from pydrake.multibody.tree import FixedOffsetFrame, RevoluteJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder


def material(friction, stiffness, relaxation):
    """Give the contact properties of a surface."""
    properties = ProximityProperties()
    AddContactMaterial(
        point_stiffness=stiffness,
        friction=CoulombFriction(friction, friction),
        properties=properties,
    )
    properties.AddProperty("material", "relaxation_time", relaxation)
    return properties


def inertia(mass, moments):
    """Give a body's inertia about its own frame."""
    return SpatialInertia(mass, [0, 0, 0], UnitInertia(*(moment / mass for moment in moments)))


def build(told):
    """Give plant, diagram, simulator and base of the model that was told."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=told["step"])
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    surface = (told["stiffness"], told["relaxation"])
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform(), HalfSpace(), "floor", material(1.0, *surface)
    )
    radius, half, wheel_mass = told["wheel_radius"], told["track_width"] / 2, told["wheel_mass"]
    width = told["wheel_width"]
    spin = wheel_mass * radius**2 / 2
    across = wheel_mass * (3 * radius**2 + width**2) / 12
    rest = told["inertia"] - 2 * (wheel_mass * half**2 + across)
    base = plant.AddRigidBody(
        "base", inertia(told["mass"] - 2 * wheel_mass, (0.6 * rest, 0.6 * rest, rest))
    )
    ball = 0.02
    for number, x in enumerate(told["casters"]):
        place = RigidTransform([x, 0, ball - radius])
        plant.RegisterCollisionGeometry(
            base, place, Sphere(ball), f"caster{number}", material(0.0, *surface)
        )
    upright = RigidTransform(RotationMatrix.MakeXRotation(math.pi / 2))
    shape = Sphere(radius) if told["wheels"] == "sphere" else Cylinder(radius, width)
    for side, y in (("left", half), ("right", -half)):
        wheel = plant.AddRigidBody(side, inertia(wheel_mass, (across, spin, across)))
        plant.RegisterCollisionGeometry(wheel, upright, shape, side, material(1.0, *surface))
        joint = plant.AddJoint(
            RevoluteJoint(
                side,
                plant.AddFrame(frame(side, base, y)),
                wheel.body_frame(),
                [0, 1, 0],
            )
        )
        actuator = plant.AddJointActuator(side, joint)
        actuator.set_default_rotor_inertia(told["armature"])
        actuator.set_default_gear_ratio(1.0)
    plant.Finalize()
    return plant, base, Simulator(builder.Build())


def frame(side, base, y):
    """Give the place of a wheel on the base."""
    return FixedOffsetFrame(f"{side}_axle", base.body_frame(), RigidTransform([0, y, 0]))


def state_of(plant, context, base, theta):
    """Give x, y, theta, v, omega; theta goes on from the last one."""
    pose = plant.EvalBodyPoseInWorld(context, base)
    speed = plant.EvalBodySpatialVelocityInWorld(context, base)
    yaw = RollPitchYaw(pose.rotation()).yaw_angle()
    theta += math.remainder(yaw - theta, 2 * math.pi)
    x, y, _ = pose.translation()
    forward = speed.translational() @ np.array([math.cos(theta), math.sin(theta), 0])
    return [float(x), float(y), float(theta), float(forward), float(speed.rotational()[2])]


def main():
    """Answer until the input ends."""
    logging.getLogger("drake").setLevel(logging.ERROR)  # half spaces and deformable bodies
    told = json.loads(sys.stdin.readline())
    plant, base, simulator = build(told)
    root = simulator.get_mutable_context()
    context = plant.GetMyMutableContextFromRoot(root)
    x, y, theta, v, omega = told["start"]
    plant.SetFreeBodyPose(context, base, RigidTransform([0, 0, told["wheel_radius"]]))
    torques = plant.get_actuation_input_port()
    torques.FixValue(context, [0.0, 0.0])
    simulator.Initialize()
    simulator.AdvanceTo(1.0)  # it comes to rest on the floor
    settled = plant.EvalBodyPoseInWorld(context, base)
    turned = RotationMatrix.MakeZRotation(theta) @ settled.rotation()
    height = settled.translation()[2]
    plant.SetFreeBodyPose(context, base, RigidTransform(turned, [x, y, height]))
    speeds = np.zeros(plant.num_velocities())
    plant.SetVelocities(context, speeds)
    linear = [v * math.cos(theta), v * math.sin(theta), 0]
    plant.SetFreeBodySpatialVelocity(context, base, SpatialVelocity([0, 0, omega], linear))
    half = told["track_width"] / 2
    for side, sign in (("left", -1), ("right", 1)):
        joint = plant.GetJointByName(side)
        joint.set_angular_rate(context, (v + sign * half * omega) / told["wheel_radius"])
    state = state_of(plant, context, base, theta)
    print(json.dumps(state), flush=True)
    for number, line in enumerate(sys.stdin):
        torques.FixValue(context, json.loads(line))
        simulator.AdvanceTo(1.0 + (number + 1) * told["sample_time"])
        state = state_of(plant, context, base, state[2])
        print(json.dumps(state), flush=True)


if __name__ == "__main__":
    main()
