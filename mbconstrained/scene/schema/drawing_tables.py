"""The [drawing] table: bodies that move with the coordinates, and links between them."""

from __future__ import annotations

import math
import re
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from ...ground.checks import nearest
from ...ground.errors import InputError, shown
from ..file.messages import EntryError
from .entry_types import Angle, Name, Number, Table, Teeth, Text, Vector

Shape = Literal["box", "sphere", "disc", "gear", "ring", "mark", "rail", "ground", "base"]
LinkKind = Literal["spring", "damper", "strut", "rod", "bushing", "loop", "torsion spring", "torsion damper", "belt"]
PlainVector = Annotated[list[Number], Field(min_length=3, max_length=3)]


def _color(value):
    if not isinstance(value, str) or not re.fullmatch(r"#[0-9a-fA-F]{6}", value):
        raise InputError(f'found {shown(value)}; expected a colour such as "#1f77b4"')
    return value


VIEWS = {
    "front": (0.0, 0.0),
    "back": (math.pi, 0.0),
    "right": (math.pi / 2, 0.0),
    "left": (-math.pi / 2, 0.0),
    "top": (0.0, math.pi / 2),
}


class ViewTable(Table):
    """The view of the model."""

    yaw: Angle = Field(0.0, description='How far round to the right, e.g. "30 deg"; 0 is in front.')
    pitch: Angle = Field(0.0, description='How far up, e.g. "20 deg"; 0 is level.')
    zoom: Number = Field(1.0, gt=0, description="Magnification relative to the view of the whole motion.")

    @model_validator(mode="after")
    def _no_degrees(self):
        if max(abs(self.yaw), abs(self.pitch)) > 2 * math.pi:
            raise InputError(
                f'found yaw {self.yaw:g} rad and pitch {self.pitch:g} rad, more than once round; write degrees as "30 deg"'
            )
        return self


def _view(value):
    if isinstance(value, str):
        if value not in VIEWS:
            known = f"""{", ".join(VIEWS)} or e.g. {{ yaw = "30 deg", pitch = "20 deg" }}"""
            raise InputError(f"found {shown(value)}; expected {known}{nearest(value, VIEWS)}")
        return dict(zip(("yaw", "pitch"), VIEWS[value]))
    return value


class BodyTable(Table):
    """A body at rest + the sum of moves times coordinate, turned by the sum of turns times coordinate."""

    name: Name = Field(description="The name that links refer to; it is shown next to the body.")
    shape: Shape | None = Field(
        None, description="box: a mass; sphere: a joint; disc, gear, ring: an inertia; mark: a point; ground: a wall."
    )
    rest: Vector | None = Field(None, description="Position with all coordinates 0: x right, y back, z up.")
    moves: dict[Name, PlainVector] | None = Field(
        None, description="Displacement by unit of a coordinate, e.g. { x1 = [1, 0, 0] }."
    )
    turns: dict[Name, PlainVector] | None = Field(None, description="Rotation vector by rad; [0, -1, 0] is counter-clockwise.")
    along: PlainVector | None = Field(
        None,
        description="Direction of positive displacements in the automatic drawing, e.g. [1, 1, 0]; [0, 0, 1] is up.",
    )
    about: PlainVector | None = Field(
        None, description="About what positive angles of this body turn counter-clockwise in the automatic drawing."
    )
    label: Text | None = Field(None, description="Label next to it; by default its name.")
    size: Vector | None = Field(None, description="Extent along x, y, z.")
    color: Annotated[str, BeforeValidator(_color)] | None = Field(None, description='Its colour, e.g. "#1f77b4".')
    teeth: Teeth | None = Field(None, ge=3, le=400, description="Number of teeth of a gear.")

    @model_validator(mode="after")
    def _one_motion(self):
        _check_axes(self)
        for name in ("along", "about"):
            if getattr(self, name) is not None and (self.moves or self.turns):
                raise InputError(f"{name}, and moves or turns, say the same thing; leave out one of them")
        if self.along and self.about:
            raise InputError("along is for a body that is displaced, about for one that turns; leave out one of them")
        return self


class LinkTable(Table):
    """Something stretched between two bodies."""

    name: Name | None = Field(None, description="A name for messages; by default of kind and ends.")
    kind: LinkKind = Field(description="Kind of symbol.")
    start: Name = Field(description="The body it starts at.")
    end: Name = Field(description="The body it ends at.")
    offset: Vector = Field([0.0, 0.0, 0.0], description="Moves it aside, so that parallel links are distinct.")
    over: Name | None = Field(None, description="The wheel that a belt runs over.")


class DrawingTable(Table):
    """The drawing of the model: bodies with shapes, or changes of the automatic drawing."""

    body: list[BodyTable] = Field([], description="Bodies; one without a shape is that of the automatic drawing, changed.")
    link: list[LinkTable] = Field([], description="Links.")
    automatic: bool | None = Field(None, description="true: these bodies and links are added to the automatic drawing.")
    view: Annotated[ViewTable, BeforeValidator(_view)] | None = Field(
        None, description='From where it is looked at: front, back, left, right, top, or { yaw = "30 deg", pitch = "20 deg" }.'
    )
    along: PlainVector | None = Field(
        None, description="Direction of positive displacements in the automatic drawing; [0, 0, 1] is up."
    )
    about: PlainVector | None = Field(
        None, description="About what positive angles turn counter-clockwise in the automatic drawing."
    )
    stack: Literal["vertical", "horizontal"] | None = Field(
        None,
        description="vertical: displacements are those of the storeys of a building, upwards; horizontal: in a row. Left out: by names.",
    )
    scale: Number = Field(1.0, description="By how much displacements are magnified, 1 is true; of a robot all motion in a run.")
    turn_scale: Number = Field(1.0, description="By how much angles are magnified, 1 is true.")
    note: Text = Field("", description="A sentence under the drawing.")
    full_meshes: bool = Field(
        False, description="true: meshes of a robot with more than 20 000 triangles are drawn with all of them."
    )

    @property
    def is_own(self) -> bool:
        """Whether it is complete, so that nothing is drawn automatically."""
        if self.automatic is not None:
            return not self.automatic
        return bool(self.body or self.link) and all(body.shape is not None for body in self.body)

    @model_validator(mode="after")
    def _axes(self):
        _check_axes(self)
        if self.along and self.about:
            product = sum(a * b for a, b in zip(self.along, self.about))
            if abs(product) > 1e-9 * math.hypot(*self.along) * math.hypot(*self.about):
                raise EntryError("along and about are not at right angles; leave out one of them", "about", "along")
        if self.is_own and self.stack:
            raise EntryError("stack is for the automatic drawing; here the bodies have places of their own, rest", "stack")
        if self.is_own and any(table.along or table.about for table in (self, *self.body)):
            raise InputError("along and about turn the automatic drawing; here moves and turns of the bodies say where they go")
        return self


def _check_axes(table: BodyTable | DrawingTable) -> None:
    for name in ("along", "about"):
        if getattr(table, name) is not None and not any(getattr(table, name)):
            raise InputError(f"{name} is [0, 0, 0]; give a direction, e.g. [0, 0, 1]")
