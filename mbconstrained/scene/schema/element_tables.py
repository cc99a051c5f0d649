"""The tables of the elements of lumped models, derived from the classes of these, and of the models."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import MISSING
from functools import cache, partial
from typing import Annotated, Any, ClassVar, Literal, get_origin

from pydantic import BeforeValidator, Field, PrivateAttr, create_model, model_validator

from ...ground.errors import InputError, shown
from ...models.elements import Element, Entry, Joins, Numeric, Relation, fields_of
from .entry_types import (
    LINEAR_PHASE,
    SPEED,
    Acceleration,
    AngularVelocity,
    DampedTable,
    LinearPhase,
    Name,
    Quantity,
    Table,
    Teeth,
    in_planes,
    quantity_field,
)

#: What a table by names is expected to be, by its key.
EXAMPLES = {
    "points": 'points with their distances, e.g. { rear = "-1.5 m", front = "1.2 m" }',
    "coefficients": "coordinates with their factors, e.g. { x1 = 1, q1 = -1 }",
}


class ElementTable(Table):
    """An entry of an element; its keys are the fields of the class, and further spellings of them."""

    element: ClassVar[type[Element]]

    def _check(self) -> None:
        entries, spellings = fields_of(self.element).entries, self.element.spellings
        for targets in dict.fromkeys(spellings.values()):
            keys = [key for key, own in spellings.items() if own == targets]
            used, given = (
                [key for key in keys if getattr(self, key) is not None],
                [name for name in targets if name in self.model_fields_set],
            )
            if len(used) > 1 or (used and given):
                raise InputError(f"{' and '.join(used + given)} say the same thing; give one of them")
            if not used and any(entries[name].is_required and name not in given for name in targets):
                raise InputError(f"give either {', '.join(keys)}, or {' and '.join(targets)}")
            for key in used:
                value = getattr(self, key)
                for name, one in zip(targets, value if len(targets) > 1 else [value]):
                    object.__setattr__(self, name, one)

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema, handler):
        """The schema, in which a key may stand for fields that are required."""
        schema = handler.resolve_ref_schema(handler(core_schema))
        entries, spellings = fields_of(cls.element).entries, cls.element.spellings
        for targets in dict.fromkeys(spellings.values()):
            if any(entries[name].is_required for name in targets):
                forms = [[key] for key, own in spellings.items() if own == targets] + [list(targets)]
                schema.setdefault("allOf", []).append({"anyOf": [{"required": form} for form in forms]})
        return schema

    @property
    def given(self) -> dict[str, Any]:
        """The fields of the element; expressions of parameters as such, and texts whose unit depends on the model unchanged."""
        values = {name: getattr(self, name) for name in fields_of(self.element).entries}
        return {name: value for name, value in values.items() if value is not None}


def _mapping(example: str, value):
    if not isinstance(value, dict) or not value:
        raise InputError(f"found {shown(value)}; expected {example}")
    return value


def _type_of(name: str, entry: Entry) -> Any:
    about = entry.about
    if isinstance(about, Joins) or name == "name":
        return Name
    if not isinstance(about, Numeric):
        return entry.type
    if entry.type is Any:  # of both planes of a rotor
        return in_planes(about.unit)
    one = Teeth if about.range == "whole" else Quantity if about.unit is None else quantity_field(about.unit)
    if get_origin(entry.type) is not Mapping:
        return one if entry.is_number else Annotated[list[one], Field(min_length=2)]  # type: ignore[valid-type]
    numbers = dict[Name, one]  # type: ignore[valid-type]
    return Annotated[numbers, BeforeValidator(partial(_mapping, EXAMPLES[name]))] if entry.is_required else numbers


@cache
def table_of(key: str, element: Any) -> Any:
    """The table of a class of elements."""
    entries, spellings = fields_of(element).entries, element.spellings
    replaced = {
        name for targets in spellings.values() for name in targets
    }  # required ones that further keys may stand for are left out
    keys: dict[str, Any] = {}
    for name, entry in sorted(entries.items(), key=lambda item: item[0] != "name"):
        own, default = _type_of(name, entry), {} if entry.default is MISSING else None if entry.default == "" else entry.default
        if entry.is_required:
            default = None if name in replaced else ...
        keys[name] = (own | None if default is None else own, Field(default, description=getattr(entry.about, "text", entry.about)))
    for spelling, targets in spellings.items():
        own = Teeth if spelling == "teeth" else _type_of(targets[0], entries[targets[0]])
        several = len(targets) > 1
        text = f"{' and '.join(targets)} in one array." if several else f"Another name of {targets[0]}."
        own = Annotated[list[own], Field(min_length=2, max_length=2)] if several else own  # type: ignore[valid-type]
        keys[spelling] = (own | None, Field(None, description=text))
    base = type("_Base", (ElementTable,), {"element": element, "__module__": __name__, "__annotations__": {"element": "ClassVar"}})
    title = "".join(word.title() for word in key.split("_")) + "Table"
    return create_model(title, __base__=base, __doc__=inspect.cleandoc(element.__doc__).split("\n\n")[0], **keys)


class _Lumped(DampedTable):
    """Masses, inertias and massless joints along one axis, and what joins them."""

    kind: Literal["lumped"] = Field(description='"lumped": bodies along one axis, springs, dampers, gears ….')
    gravity: Acceleration | None = Field(None, description="Acceleration of free fall along the axis, negative for downwards.")
    speed: AngularVelocity | None = SPEED
    linear_phase: LinearPhase = LINEAR_PHASE
    _order: tuple[str, ...] = PrivateAttr(default=())

    @model_validator(mode="wrap")
    @classmethod
    def _keep_order(cls, data, handler):
        """Coordinates are numbered in the order of the file, which the fields above lose."""
        table = handler(data)
        table._order = tuple(key for key in data if key in cls.model_fields)
        return table

    @property
    def elements(self) -> list[tuple[str, int, ElementTable]]:
        """(key, number, table) of all elements: bodies first, otherwise in the order of the file."""
        from ...models.lumped import ELEMENTS

        keys = sorted((key for key in self._order if key in ELEMENTS), key=lambda key: not ELEMENTS[key].has_coordinates)
        return [(key, number, table) for key in keys for number, table in enumerate(getattr(self, key), 1)]


@cache
def lumped_table() -> Any:
    """The table of lumped models, with a list of each class of elements."""
    from ...models.lumped import ELEMENTS

    elements: dict[str, Any] = {**ELEMENTS}
    lists: dict[str, Any] = {
        key: (list[table_of(key, element)], Field([], description=(element.__doc__ or "").split("\n")[0]))
        for key, element in elements.items()
    }
    return create_model("LumpedTable", __base__=_Lumped, __doc__=_Lumped.__doc__, **lists)


ConstraintTable = table_of("constraint", Relation)
