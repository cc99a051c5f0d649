"""The [drawing] table: bodies that move with the coordinates, and links between them."""

from __future__ import annotations

import re
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from ..errors import InputError
from .fields import Name, Number, Table, Text, Vector
from .units import shown

Shape = Literal["box", "sphere", "disc", "gear", "ring", "mark", "rail", "ground", "base"]
LinkKind = Literal["spring", "damper", "strut", "rod", "bushing", "loop", "torsion spring", "torsion damper", "belt"]
PlainVector = Annotated[list[Number], Field(min_length=3, max_length=3)]


def _color(value):
    if not isinstance(value, str) or not re.fullmatch(r"#[0-9a-fA-F]{6}", value):
        raise InputError(f'found {shown(value)}; expected a colour such as "#1f77b4"')
    return value


class BodyTable(Table):
    """A body at rest + the sum of moves times coordinate, turned by the sum of turns times coordinate."""

    name: Name = Field(description="The name that links refer to; it is shown beside the body.")
    shape: Shape = Field(description="box: a mass; sphere: a joint; disc, gear, ring: an inertia; mark: a point; ground: a wall.")
    rest: Vector = Field([0.0, 0.0, 0.0], description="Where it is while all coordinates are 0: x right, y back, z up.")
    moves: dict[Name, PlainVector] = Field({}, description="Displacement by unit of a coordinate, e.g. { x1 = [1, 0, 0] }.")
    turns: dict[Name, PlainVector] = Field({}, description="Rotation vector by rad; [0, -1, 0] is counter-clockwise.")
    size: Vector | None = Field(None, description="Extent along x, y, z.")
    color: Annotated[str, BeforeValidator(_color)] | None = Field(None, description='Its colour, e.g. "#1f77b4".')
    teeth: int | None = Field(None, ge=3, le=400, description="Number of teeth of a gear.")


class LinkTable(Table):
    """Something stretched between two bodies."""

    name: Name | None = Field(None, description="A name for messages; made from kind and ends when left out.")
    kind: LinkKind = Field(description="What it looks like.")
    start: Name = Field(description="The body it starts at.")
    end: Name = Field(description="The body it ends at.")
    offset: Vector = Field([0.0, 0.0, 0.0], description="Moves it aside, so that parallel links can be told apart.")
    over: Name | None = Field(None, description="The wheel that a belt runs over.")


class DrawingTable(Table):
    """How the model is drawn."""

    body: list[BodyTable] = Field([], description="Bodies.")
    link: list[LinkTable] = Field([], description="Links.")
    scale: Number = Field(1.0, description="By how much displacements are magnified; of a robot all motion in a run.")
    turn_scale: Number = Field(1.0, description="By how much angles are magnified.")
    note: Text = Field("", description="A sentence under the drawing.")
