"""LumpedModel from the tables of a lumped scene."""

from __future__ import annotations

from typing import Any

from ...ground.errors import InputError
from ...ground.quantities import quantity
from ...models.lumped import LumpedModel
from ..file.messages import at
from ..quantities.coordinates import Coordinates, constraint_row


def lumped_model(table, file_name: str) -> LumpedModel:
    """The model: bodies first, in the order of the file, then the elements between them."""
    model = LumpedModel()
    for key, number, entry in table.elements:
        owner = f' (of "{entry.name}")' if entry.name else ""
        with at(file_name, f"model.{key}[{number}]{owner}"):
            add = model.constrain if key == "constraint" else getattr(model, key)
            add(**element_fields(key, entry, model.units))
    joined = {name for element in model.elements for name in element.ends}
    for number, node in enumerate(table.node, 1):
        if node.name not in joined:
            with at(file_name, f'model.node[{number}] (of "{node.name}")'):
                raise InputError(
                    "nothing is attached to this joint, which has no mass, so that its position is undetermined; join it by a spring, "
                    "a damper or a constraint, or take it out"
                )
    if table.gravity is not None:
        with at(file_name, "model.gravity"):
            model.gravity(table.gravity)
    return model


def element_fields(key: str, entry, units: dict[str, str]) -> dict[str, Any]:
    """The fields of the element of an entry."""
    fields = {name: value for name, value in entry if value is not None}
    if key == "constraint":
        row = constraint_row(entry, Coordinates(tuple(units), tuple(units.values())))
        del fields["rows"]
        fields |= {"coefficients": row.factors, "value": row.value}
    if "between" in fields:
        fields["start"], fields["end"] = fields.pop("between")
    if key == "lever":
        fields["start_arm"], fields["end_arm"] = fields.pop("arms")
    elif key == "gear":
        fields = {name: value for name, value in fields.items() if name not in ("radii", "teeth")}
        fields["start_radius"], fields["end_radius"] = entry.sizes
    elif key == "rigid_tie":
        unit = next((units[name] for name in entry.between if name in units), "m")
        fields["distance"] = quantity(entry.distance, unit)
    elif key == "rack" and units.get(entry.gear) == "m" and units.get(entry.rack) == "rad":
        raise InputError(f'gear is what turns, here "{entry.rack}", and rack what moves, "{entry.gear}"; they are swapped')
    return fields
