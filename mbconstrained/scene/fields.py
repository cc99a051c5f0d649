"""The kinds of entries a scene file has: tables that know their keys, quantities, names, texts, matrices."""

from __future__ import annotations

import re
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PlainValidator, WithJsonSchema, model_validator

from ..checks import nearest
from ..errors import InputError
from .dimensions import KINDS
from .units import quantity, quoted, shown, unit_name

LONGEST_TEXT = 2000
_NAME = re.compile(r"[^\W\d][\w .'()-]{0,39}")


class Table(BaseModel):
    """A table of the scene file: it refuses keys it does not know and names the nearest one it does."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, arbitrary_types_allowed=True)

    @model_validator(mode="before")
    @classmethod
    def _only_known_keys(cls, data):
        if not isinstance(data, dict):
            raise InputError(f"found {shown(data)}; expected a table with the keys {', '.join(cls.model_fields)}")
        unknown = [key for key in data if key not in cls.model_fields]
        if unknown:
            known = ", ".join(cls.model_fields)
            hint = nearest(unknown[0], cls.model_fields)
            raise InputError(f"unknown key {shown(unknown[0])}{hint}; known here are {known}")
        return data


def quantity_field(unit: str):
    """The type of a key that holds a number in the SI unit or a text with a unit of the same kind."""
    name, example = KINDS[unit]
    schema = {
        "title": f'{name} in {unit}, a text with a unit such as {example}, or an expression of parameters such as "=2*k"',
        "anyOf": [{"type": "number"}, {"type": "string"}],
    }
    # plain: what quantity gives is the value, an expression of parameters included, which pydantic would make a float
    return Annotated[float, PlainValidator(lambda value: quantity(value, unit)), WithJsonSchema(schema)]


Number = quantity_field("1")
Mass = quantity_field("kg")
Inertia = quantity_field("kg*m^2")
Length = quantity_field("m")
Acceleration = quantity_field("m/s^2")
Angle = quantity_field("rad")
AngularVelocity = quantity_field("rad/s")
Stiffness = quantity_field("N/m")
TorsionStiffness = quantity_field("N*m/rad")
Damping = quantity_field("N*s/m")
TorsionDamping = quantity_field("N*m*s/rad")
Time = quantity_field("s")
Frequency = quantity_field("Hz")
Rate = quantity_field("1/s")


def _number_or_text(value):
    """A quantity whose unit depends on the coordinate it belongs to: checked further once that is known."""
    if isinstance(value, str):
        return value
    return quantity(value, "1")


def _name(value):
    if not isinstance(value, str) or not _NAME.fullmatch(value):
        raise InputError(
            f"found {shown(value)}; expected a name: a letter first, then at most 39 letters, digits, spaces or _ . ' ( ) -"
        )
    return value


def _text(value):
    if not isinstance(value, str):
        raise InputError(f"found {shown(value)}; expected a text in quotes")
    if len(value) > LONGEST_TEXT:
        raise InputError(f"found a text of {len(value)} characters; expected at most {LONGEST_TEXT}")
    bad = next((c for c in value if not (c.isprintable() or c == "\n")), None)
    if bad:
        raise InputError(f"found the character {quoted(bad)}, which cannot be printed; leave it out")
    return value


Quantity = Annotated[
    Any,
    BeforeValidator(_number_or_text),
    WithJsonSchema(
        {
            "title": 'a number in SI, a text with a unit, or "=" and an expression of parameters',
            "anyOf": [{"type": "number"}, {"type": "string"}],
        }
    ),
]
Name = Annotated[str, BeforeValidator(_name)]
Unit = Annotated[str, BeforeValidator(unit_name)]
Text = Annotated[str, BeforeValidator(_text)]
Pair = Annotated[list[Name], Field(min_length=2, max_length=2)]
Vector = Annotated[list[Length], Field(min_length=3, max_length=3)]
