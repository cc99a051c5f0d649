"""The schema of robots/<name>/robot.toml, which completes a URDF, and of scenes with a robot."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeVar

from pydantic import BeforeValidator, Field, WithJsonSchema, field_validator

from ...ground.errors import InputError, shown
from ...ground.quantities import quantity
from .entry_types import (
    LINEAR_PHASE,
    Angle,
    DampedTable,
    Damping,
    Inertia,
    Length,
    Level,
    LinearPhase,
    Mass,
    Name,
    Number,
    Quantity,
    Stiffness,
    Table,
    Text,
    Time,
    TorsionDamping,
    TorsionStiffness,
    Vector,
)

Entry = TypeVar("Entry")
Three = Annotated[list[Entry], Field(min_length=3, max_length=3)]


def _gravity(value):
    if isinstance(value, list) and len(value) != 3:
        raise InputError(f"found {shown(value)}; expected one number for downwards along z, or a vector of three")
    return [quantity(entry, "m/s^2") for entry in value] if isinstance(value, list) else quantity(value, "m/s^2")


Gravity = Annotated[
    Any,
    BeforeValidator(_gravity),
    WithJsonSchema(
        {"title": "m/s^2 downwards along z, or a vector", "anyOf": [{"type": "number"}, {"type": "string"}, {"type": "array"}]}
    ),
]
JointValues = dict[Text, Quantity]


class ConnectionTable(Table):
    """Two frames, each fixed in a link of the URDF or in the ground."""

    name: Name | None = Field(None, description="A name for messages and results; by default of the bodies.")
    body1: Text = Field(description='A link of the URDF, or "ground".')
    point1: Vector | None = Field(None, description="Point of body1; by default where point2 lies at the guess.")
    body2: Text = Field(description='Another link, or "ground".')
    point2: Vector | None = Field(None, description="Point of body2; by default where point1 lies at the guess.")


class FramesTable(ConnectionTable):
    """A connection of which the directions of the frames matter."""

    rotation1: Three[Angle] = Field([0.0, 0.0, 0.0], description="Roll, pitch, yaw of the frame in body1.")
    rotation2: Three[Angle] = Field([0.0, 0.0, 0.0], description="Roll, pitch, yaw of the frame in body2.")


class SupportTable(FramesTable):
    """A connection that may be a foot on the ground."""

    friction: Number | None = Field(
        None, description="Coefficient of friction of a foot on the ground; its force at rest is checked."
    )
    normal: Three[Number] = Field([0.0, 0.0, 1.0], description="Normal of the contact, in the directions of the ground.")
    patch: Annotated[list[Length], Field(min_length=2, max_length=2)] | None = Field(
        None,
        description="Extents of the sole of a foot with friction that cannot turn freely, along x and y of the frame on body1.",
    )


class LoopTable(SupportTable):
    """A joint that closes a loop."""

    kind: Literal["point", "rigid", "hinge", "prismatic", "cylindrical", "universal", "rod"] = Field(
        "point", description="Which of the six directions are constrained."
    )
    axis: Three[Number] = Field([0.0, 0.0, 1.0], description="Axis of a hinge or prismatic loop, in the frame on body1.")
    axis2: Three[Number] = Field(
        [1.0, 0.0, 0.0], description="Second axis of a universal loop, in the frame on body2; axis is in that on body1."
    )
    length: Length | None = Field(None, description="Length of a rod; by default that at the guess.")


class BodySpringTable(ConnectionTable):
    """A spring and a damper along the line between two points."""

    stiffness: Stiffness = Field(0.0, description="Force by extension.")
    rest_length: Length | None = Field(None, description="Its length without force.")
    preload: Annotated[Any, BeforeValidator(lambda value: quantity(value, "N"))] = Field(
        None, description="Tension at the guess, instead of rest_length; negative in compression."
    )
    damping: Damping = Field(0.0, description="Force by rate of extension.")


class BushingTable(SupportTable):
    """Springs and dampers in all directions between two frames; a foot on compliant ground: body1 = "ground" without point1."""

    stiffness: Three[Stiffness] = Field([0.0, 0.0, 0.0], description="Along the axes of the frame on body1.")
    turning_stiffness: Three[TorsionStiffness] = Field([0.0, 0.0, 0.0], description="About them.")
    damping: Three[Damping] = Field([0.0, 0.0, 0.0], description="Along them.")
    turning_damping: Three[TorsionDamping] = Field([0.0, 0.0, 0.0], description="About them.")


class FlexibleJointTable(Table):
    """A motor behind an elastic gear."""

    stiffness: Quantity = Field(description="Stiffness of the gear, at the joint's side.")
    damping: Quantity = Field(0.0, description="Damping of the gear, at the joint's side.")
    motor_inertia: Inertia = Field(description="Inertia of the rotor, in front of the gear.")
    gear_ratio: Number = Field(1.0, description="Turns of the motor for one of the joint.")
    proportional_gain: Quantity = Field(0.0, description="Proportional gain of the motor's position control, at the joint's side.")
    derivative_gain: Quantity = Field(0.0, description="Derivative gain of the motor's position control, at the joint's side.")


class MotorTable(Table):
    """A motor with a rigid gear."""

    armature: Quantity = Field(0.0, description="Inertia at the joint's side.")
    rotor_inertia: Inertia = Field(0.0, description="Inertia of the rotor, in front of the gear.")
    gear_ratio: Number = Field(1.0, description="Turns of the motor for one of the joint.")
    position_gain: Quantity = Field(
        0.0, description="Proportional gain of the position control, at the joint's side; it carries the load."
    )
    velocity_gain: Quantity = Field(0.0, description="Derivative gain of the motor's position control, at the joint's side.")


class JointGearTable(Table):
    """A gear or rack between two joints."""

    joint: Text = Field(description="The joint that follows.")
    leader: Text = Field(description="The joint that it follows; in a train of gears it may follow another.")
    ratio: Quantity = Field(description="Its value for one rad (m) of the leader; the radius of the pinion of a rack.")
    offset: Quantity = Field(0.0, description="Its value where that of the leader is 0.")


class PayloadTable(Table):
    """A body fixed to a link."""

    body: Text = Field(description="The link.")
    mass: Mass = Field(description="Mass of the body.")
    centre: Vector = Field([0.0, 0.0, 0.0], description="Centre of mass, in the link's frame.")
    inertia: list[Inertia] = Field(
        [0.0, 0.0, 0.0], description="About the centre of mass: three principal moments, or ixx, ixy, ixz, iyy, iyz, izz."
    )


class PointTable(Table):
    """A point of a body and a direction that is fixed in space."""

    body: Text = Field(description="A link of the URDF.")
    point: Vector = Field([0.0, 0.0, 0.0], description="In the link's frame.")
    along: Three[Number] = Field([1.0, 0.0, 0.0], description="The direction, of any length.")
    turn: bool = Field(False, description="true: the torque or rotation about the direction.")


class JointStopTable(Table):
    """Stops of a joint, rigid or elastic; those of the URDF's limits where neither lower nor upper is given."""

    name: Name | None = Field(None, description="A name for messages and results; by default of the joint.")
    joint: Text = Field(description="A joint with one degree of freedom.")
    lower: Quantity | None = Field(None, description="Value of the joint at the lower stop.")
    upper: Quantity | None = Field(None, description="Value of the joint at the upper stop.")
    restitution: Number = Field(0.0, description="Velocity after an impact by that before it, 0 to 1.")
    stiffness: Quantity | None = Field(None, description="Of elastic stops; rigid when left out.")
    damping: Quantity = Field(0.0, description="Of elastic stops.")


class PointContactTable(Table):
    """A point of a body that meets a plane."""

    name: Name | None = Field(None, description="A name for messages and results; by default of the body.")
    body: Text = Field(description="A link of the URDF.")
    point: Vector = Field([0.0, 0.0, 0.0], description="In the link's frame.")
    normal: Three[Number] = Field([0.0, 0.0, 1.0], description="Of the plane, towards the point, in the directions of the ground.")
    gap: Length = Field(0.0, description="Distance of the point from the plane at the posture.")
    restitution: Number = Field(0.0, description="Velocity after an impact by that before it, 0 to 1.")
    stiffness: Stiffness | None = Field(None, description="Of an elastic contact; rigid when left out.")
    damping: Damping = Field(0.0, description="Of an elastic contact.")
    sticks: bool = Field(False, description="true: the point does not slide while it touches; false: it slides without friction.")
    friction: Number | None = Field(None, description="Coefficient of friction by which forces of a point that sticks are checked.")
    other: Text = Field("ground", description='The body with the plane, a link or "ground".')


class LiftingFootTable(Table):
    """A foot that lifts off where it would have to pull, and lands again."""

    loop: Text = Field(description='A loop of the robot, of kind "point" or "rigid", on the ground.')


class ClosingLoopTable(LoopTable):
    """A loop that closes at a time, or where a gap is closed, as a gripper that grasps."""

    at: Time | None = Field(None, description="The time at which it closes.")
    gap: Length | None = Field(None, description="How far body2 must come nearer against the normal.")
    released: Time | None = Field(None, description="The time at which it opens again.")


class ReleaseTable(Table):
    """The end of a loop of the robot."""

    target: Text = Field(description="A loop of the robot, closed at the posture.")
    at: Time = Field(description="The time at which it opens.")


class BodyForceTable(PointTable):
    """A force or torque on a body that acts while the equilibrium is found."""

    value: Quantity = Field(description="Its size.")


class Posing(Table):
    """Posture of a robot, or a different one in a scene."""

    state: Text | None = Field(
        None, description="A group state of the SRDF or key frame of the MJCF; the values of guess come on top."
    )
    guess: dict[Text, Any] = Field({}, description="Joints near the equilibrium; base = [x, y, z, roll, pitch, yaw] if it is free.")
    forces: JointValues = Field({}, description="Forces and torques of joints that act all the time.")
    body_force: list[BodyForceTable] = Field([], description="Forces and torques on bodies that act all the time.")
    hold: Any = Field((), description='Joints that keep their guess, ["j1", …] or "all"; the torques needed are found.')

    @field_validator("hold")
    @classmethod
    def _joints(cls, value):
        if value != "all" and not (isinstance(value, (list, tuple)) and all(isinstance(name, str) for name in value)):
            raise InputError(f'found {shown(value)}; expected "all" or names of joints, e.g. ["j1", "j2"]')
        return value


class RobotFile(Table):
    """A robot: its URDF and what that does not say."""

    title: Text = Field("", description="Title of the robot.")
    source: Text = Field("", description="Source of the robot.")
    licence: Text = Field("", description='Under which licence, e.g. "MIT".')
    urdf: Text = Field(description="The URDF, or MJCF (.xml), a file in the robot's folder.")
    srdf: Text | None = Field(None, description="An SRDF, a file in the robot's folder: postures by name, rotors of motors.")
    package_dirs: list[Text] = Field(
        [], description="Folders in which package://NAME/… are looked up: paths, or relative to the robot's."
    )
    base: Literal["fixed", "free", "moving"] = Field(
        "fixed", description="Whether the root link is fixed to the ground, moves freely, or has a prescribed motion."
    )
    gravity: Gravity = Field([0.0, 0.0, -9.81], description="A number for downwards along z, or a vector.")
    joint_stiffness: JointValues = Field({}, description="Springs of joints, by name.")
    joint_rest: JointValues = Field(
        {}, description="Rest positions of these springs; an omitted one carries the load at the guess."
    )
    joint_damping: JointValues = Field({}, description="Dampers of joints, in addition to those of the URDF.")
    locked: JointValues = Field({}, description="Joints that are frozen at a value.")
    flexible_joints: dict[Text, FlexibleJointTable] = Field({}, description="Joints driven by a motor behind an elastic gear.")
    motors: dict[Text, MotorTable] = Field({}, description="Motors of joints with a rigid gear.")
    gear: list[JointGearTable] = Field([], description="Gears and racks between joints.")
    payload: list[PayloadTable] = Field([], description="Bodies fixed to links.")
    masses: dict[Text, Mass] = Field({}, description="Other masses of links; the inertia changes in the same ratio.")
    inertias: dict[Text, list[Inertia]] = Field({}, description="Other inertias of links, as of a payload.")
    loop: list[LoopTable] = Field([], description="Joints that close loops.")
    spring: list[BodySpringTable] = Field([], description="Springs between bodies.")
    bushing: list[BushingTable] = Field([], description="Bushings between bodies.")
    posture: Posing = Field(Posing(), description="Default posture of the robot.")


class RobotChanges(RobotFile):
    """Changes of the robot.toml for one scene: entries replace those of the file, and arrays of tables grow."""

    urdf: Text = Field("", description="Another URDF, a file in the robot's folder.")


class SpotTable(Table):
    """A named motion: that of a joint, or of a point of a body along a direction."""

    name: Name = Field(description="Name of the motion.")
    joint: Text | None = Field(None, description="A joint; or else body, with point, along and turn.")
    body: Text | None = Field(None, description="A link of the URDF.")
    point: Vector = Field([0.0, 0.0, 0.0], description="In the link's frame.")
    along: Three[Number] = Field([1.0, 0.0, 0.0], description="The direction, fixed in space, of any length.")
    turn: bool = Field(False, description="true: the rotation or torque about the direction.")

    def _check(self) -> None:
        if (self.joint is None) == (self.body is None):
            raise InputError('give either joint, or body with the direction along, e.g. body = "tool", along = [0, 0, 1]')
        if self.joint is not None and (extra := {"point", "along", "turn"} & self.model_fields_set):
            raise InputError(f"{min(extra)} belongs to a body; leave it out with joint")


class RobotTable(DampedTable, Posing):
    """A robot about an equilibrium, in small deviations from it."""

    kind: Literal["robot"] = Field(description='"robot": a URDF with its robot.toml, linearized about an equilibrium.')
    robot: Text = Field(description='The folder of the robot, relative to the scene, e.g. "../robots/four_bar".')
    level: Level = Field("position", description="Level of the rows of its loops: positions, velocities or accelerations.")
    locked: JointValues = Field({}, description="Joints that are frozen at a value, in addition to those of the robot.")
    input: list[SpotTable] = Field([], description="Named inputs of [[force]] tables.")
    output: list[SpotTable] = Field([], description='What [output] plots as "output", by name.')
    linear_phase: LinearPhase = LINEAR_PHASE
    joint_stop: list[JointStopTable] = Field([], description="Stops of joints.")
    contact: list[PointContactTable] = Field([], description="Points of bodies that meet a plane.")
    lifting_foot: list[LiftingFootTable] = Field([], description="Feet that lift off.")
    closing_loop: list[ClosingLoopTable] = Field([], description="Loops that close, such as grasps.")
    release: list[ReleaseTable] = Field([], description="Loops of the robot that open.")
