"""The tables of a model of kind "lumped": bodies and the elements between them, one [[model.…]] entry each."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, PrivateAttr, model_validator

from ...ground.errors import InputError, shown
from .entry_types import (
    SPEED,
    Acceleration,
    Angle,
    AngularVelocity,
    DampedTable,
    Damping,
    Eccentric,
    Inertia,
    Length,
    Level,
    Mass,
    Name,
    Pair,
    PlaneDamping,
    PlaneStiffness,
    Quantity,
    Stiffness,
    Table,
    Teeth,
    TorsionDamping,
    TorsionStiffness,
)

BODIES = ("mass", "inertia", "node", "rigid_bar", "rotor")


class MassTable(Table):
    """A mass that moves along the axis."""

    name: Name = Field(description="The name of the mass and of its coordinate.")
    mass: Mass = Field(description="Its mass.")
    position: Length | None = Field(None, description="Position in the drawing, without effect on the motion.")


class NodeTable(Table):
    """A joint without mass."""

    name: Name = Field(description="The name of the joint and of its coordinate.")
    rotational: bool = Field(False, description="true: its coordinate is an angle in rad; false: a position in m.")


class InertiaTable(Table):
    """A body that turns."""

    name: Name = Field(description="The name of the body and of its angle.")
    inertia: Inertia = Field(description="Its moment of inertia about the axis it turns about.")


def _points(value):
    if not isinstance(value, dict) or not value:
        raise InputError(f'found {shown(value)}; expected points with their distances, e.g. {{ rear = "-1.5 m", front = "1.2 m" }}')
    return value


class RigidBarTable(Table):
    """A rigid bar that is displaced across its length and turns by a small angle, with points that elements are attached to."""

    name: Name = Field(description='The name of the bar and of the displacement of its centre of mass; its angle is "NAME angle".')
    mass: Mass = Field(description="Its mass.")
    inertia: Inertia = Field(description="Its moment of inertia about the centre of mass.")
    points: Annotated[dict[Name, Length], BeforeValidator(_points)] = Field(
        description="Points with their distances from the centre of mass along the bar; each is a coordinate, tied to the bar."
    )


class RotorTable(Table):
    """A rigid rotor that moves across its shaft in the planes y and z and tilts; the shaft turns from y to z."""

    name: Name = Field(
        description='Its centre of mass has the coordinates "NAME y", "NAME z", its tilts "NAME y angle", "NAME z angle".'
    )
    mass: Mass = Field(description="Its mass.")
    diametral_inertia: Inertia | None = Field(None, description="About an axis across the shaft; left out: it does not tilt.")
    polar_inertia: Inertia = Field(0.0, description="About the shaft, at most twice the diametral one.")
    points: dict[Name, Length] = Field(
        {}, description='Points with their distances from the centre of mass along the shaft; each has "POINT y" and "POINT z".'
    )


class ElementTable(Table):
    """An element between two bodies, nodes or the ground."""

    name: Name | None = Field(None, description="A name for messages and the drawing; by default of the ends.")
    between: Pair = Field(description='The two ends by name, e.g. ["ground", "cart"]; "ground" does not move.')


class SpringTable(ElementTable):
    """A linear spring along the axis: force -stiffness (end - start - rest_length) on the end."""

    stiffness: Stiffness = Field(description="Force by elongation.")
    rest_length: Length = Field(0.0, description="end - start at which the spring is without force.")


class DamperTable(ElementTable):
    """A linear damper along the axis."""

    damping: Damping = Field(description="Force by velocity.")


class TorsionSpringTable(ElementTable):
    """A linear torsion spring."""

    stiffness: TorsionStiffness = Field(description="Torque by angle.")
    rest_angle: Angle = Field(0.0, description="end - start at which the spring is without torque.")


class TorsionDamperTable(ElementTable):
    """A linear torsion damper."""

    damping: TorsionDamping = Field(description="Torque by angular velocity.")


class RigidTieTable(ElementTable):
    """A rigid link: end - start = distance."""

    distance: Quantity = Field(0.0, description="end - start, kept by the link; a length, or an angle between bodies that turn.")


class LeverTable(ElementTable):
    """A massless lever on a fixed pivot that joins two positions."""

    arms: Annotated[list[Length], Field(min_length=2, max_length=2)] = Field(
        description="The two arms from the pivot, in the order of between; the ends move in opposite directions."
    )


class GearTable(ElementTable):
    """Two gear wheels in mesh: the products of radius and angle are opposite (equal for an internal gear)."""

    radii: Annotated[list[Length], Field(min_length=2, max_length=2)] | None = Field(
        None, description="The two pitch radii, in the order of between; give these or the teeth."
    )
    teeth: Annotated[list[Teeth], Field(min_length=2, max_length=2)] | None = Field(
        None, description='The two numbers of teeth, in the order of between, e.g. [20, 60] or ["=z1", "=z2"].'
    )
    internal: bool = Field(False, description="true where one wheel runs inside the other.")

    @model_validator(mode="after")
    def _radii_or_teeth(self):
        if (self.radii is None) == (self.teeth is None):
            raise InputError('give either radii, e.g. ["20 mm", "60 mm"], or teeth, e.g. [20, 60]')
        return self

    @property
    def sizes(self) -> list[float]:
        """Radii, or numbers of teeth, which are proportional to them."""
        return self.radii if self.radii is not None else self.teeth


class RackTable(Table):
    """A rack and pinion: rack = radius times angle."""

    name: Name | None = Field(None, description="A name for messages and the drawing.")
    gear: Name = Field(description="The pinion, a coordinate in rad.")
    rack: Name = Field(description="The rack, a coordinate in m.")
    radius: Length = Field(description="The pitch radius of the pinion.")


class PulleyTable(ElementTable):
    """An inextensible rope over a pulley."""

    over: Name = Field("ground", description="The body that carries the pulley.")
    length: Length | None = Field(None, description="The length of rope; left out: the rope is just taut at the start.")


class BearingTable(ElementTable):
    """A bearing, seal or elastic shaft between points of rotors, or a point and the ground: force -K r - C r' in both planes."""

    stiffness: PlaneStiffness = Field(0.0, description="K: one stiffness, [K_yy, K_zz], or [[K_yy, K_yz], [K_zy, K_zz]].")
    damping: PlaneDamping = Field(0.0, description="C, likewise.")
    speeds: Annotated[list[AngularVelocity], Field(min_length=2)] | None = Field(
        None, description="Speeds of a table, ascending; stiffness and damping then have an entry for each, linear in between."
    )


class UnbalanceTable(Table):
    """An eccentric mass: the force moment W^2, which turns with the shaft."""

    name: Name | None = Field(None, description="A name for messages.")
    on: Name = Field(description="The rotor, or a point of it.")
    moment: Eccentric = Field(description='Mass times eccentricity, e.g. "20 g*mm".')
    angle: Angle = Field(0.0, description="From y towards z at t = 0.")


def _rows_by_name(value):
    if not isinstance(value, dict) or not value:
        raise InputError(f"found {shown(value)}; expected coordinates with their factors, e.g. {{ x1 = 1, q1 = -1 }}")
    return value


class ConstraintTable(Table):
    """One constraint row: the sum of factor times coordinate, or its derivative, equals the value."""

    name: Name | None = Field(None, description="A name for messages and reactions.")
    rows: Annotated[dict[Name, Quantity], BeforeValidator(_rows_by_name)] = Field(
        description='Coordinates with their factors, e.g. { x1 = 1, q1 = -1 } or { heave = 1, pitch = "1.01 m" }.'
    )
    level: Level = Field("position", description="Level of the row: positions, velocities or accelerations.")
    value: Quantity = Field(0.0, description="The right hand side, constant in time.")


class LumpedTable(DampedTable):
    """Masses, inertias and massless joints along one axis, and what joins them."""

    kind: Literal["lumped"] = Field(description='"lumped": bodies along one axis, springs, dampers, gears ….')
    gravity: Acceleration | None = Field(None, description="Acceleration of free fall along the axis, negative for downwards.")
    speed: AngularVelocity | None = SPEED
    mass: list[MassTable] = Field([], description="Masses.")
    inertia: list[InertiaTable] = Field([], description="Bodies that turn.")
    node: list[NodeTable] = Field([], description="Joints without mass.")
    rigid_bar: list[RigidBarTable] = Field([], description="Rigid bars, which are displaced and turn.")
    spring: list[SpringTable] = Field([], description="Springs.")
    damper: list[DamperTable] = Field([], description="Dampers.")
    torsion_spring: list[TorsionSpringTable] = Field([], description="Torsion springs.")
    torsion_damper: list[TorsionDamperTable] = Field([], description="Torsion dampers.")
    rigid_tie: list[RigidTieTable] = Field([], description="Rigid links.")
    lever: list[LeverTable] = Field([], description="Levers.")
    gear: list[GearTable] = Field([], description="Gear pairs.")
    rack: list[RackTable] = Field([], description="Racks with their pinions.")
    pulley: list[PulleyTable] = Field([], description="Ropes over pulleys.")
    rotor: list[RotorTable] = Field([], description="Rigid rotors, in two planes.")
    bearing: list[BearingTable] = Field([], description="Bearings, seals and shafts of rotors.")
    unbalance: list[UnbalanceTable] = Field([], description="Eccentric masses of rotors.")
    constraint: list[ConstraintTable] = Field([], description="Further constraint rows.")
    _order: tuple[str, ...] = PrivateAttr(default=())

    @model_validator(mode="wrap")
    @classmethod
    def _keep_order(cls, data, handler):
        """Coordinates are numbered in the order of the file, which the fields above lose."""
        table = handler(data)
        table._order = tuple(key for key in data if key in cls.model_fields)
        return table

    @property
    def elements(self) -> list[tuple[str, int, Table]]:
        """(key, number, table) of all elements: bodies first, otherwise in the order of the file."""
        keys = sorted(
            (key for key in self._order if key not in DampedTable.model_fields and isinstance(getattr(self, key), list)),
            key=lambda key: key not in BODIES,
        )
        return [(key, number, table) for key in keys for number, table in enumerate(getattr(self, key), 1)]
