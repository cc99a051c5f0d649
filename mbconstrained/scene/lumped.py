"""From the tables of a lumped scene to a LumpedModel."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..errors import InputError
from ..models.lumped import LumpedModel
from .problems import at
from .units import quantity
from .values import Coordinates, constraint_value

BODIES = ("mass", "inertia", "node")


def lumped_model(table, file_name: str) -> LumpedModel:
    """The model: bodies first, in the order of the file, then what joins them.

    Raises:
        SceneError: a name used twice, an unknown end, a value out of range; names the file and the entry.
    """
    model = LumpedModel()
    for key, number, entry in entries(table):
        named = f' (of "{entry.name}")' if entry.name else ""
        with at(file_name, f"model.{key}[{number}]{named}"):
            _ADD[key](model, entry)
    _check_nodes(model, table, file_name)
    if table.gravity is not None:
        with at(file_name, "model.gravity"):
            model.gravity(table.gravity)
    return model


def entries(table) -> Iterator[tuple[str, int, Any]]:
    """(key, number, entry) of all elements in the order in which the model has them: bodies first."""
    keys = [key for key in table.order if key in _ADD]
    for key in sorted(keys, key=lambda key: key not in BODIES):
        for number, entry in enumerate(getattr(table, key), 1):
            yield key, number, entry


def _check_nodes(model: LumpedModel, table, file_name: str) -> None:
    """What has no mass must be joined to something."""
    joined = {name for element in model.elements for name in element.ends}
    for number, node in enumerate(table.node, 1):
        if node.name not in joined:
            with at(file_name, f'model.node[{number}] (of "{node.name}")'):
                raise InputError(
                    "nothing is attached to this joint, which has no mass, so that nothing tells where it is; join it by a spring, "
                    "a damper or a constraint, or take it out"
                )


def _gear(model, entry):
    start, end = entry.sizes
    model.gear(*entry.between, start_radius=start, end_radius=end, internal=entry.internal, name=entry.name)


def _lever(model, entry):
    start, end = entry.arms
    model.lever(*entry.between, start_arm=start, end_arm=end, name=entry.name)


def _rigid_tie(model, entry):
    unit = next((model.units[name] for name in entry.between if name in model.units), "m")
    model.rigid_tie(*entry.between, distance=quantity(entry.distance, unit), name=entry.name)


def _rack(model, entry):
    if model.units.get(entry.gear) == "m" and model.units.get(entry.rack) == "rad":
        raise InputError(f'gear is what turns, here "{entry.rack}", and rack what moves, "{entry.gear}"; they are swapped')
    model.rack(entry.gear, entry.rack, radius=entry.radius, name=entry.name)


def _constraint(model, entry):
    names = tuple(model.coordinates)
    value = constraint_value(entry, Coordinates(names, tuple(model.units[name] for name in names)))
    model.constrain(entry.rows, value=value, level=entry.level, name=entry.name)


_ADD = {
    "mass": lambda model, e: model.mass(e.name, e.mass, position=e.position),
    "inertia": lambda model, e: model.inertia(e.name, e.inertia),
    "node": lambda model, e: model.node(e.name, rotational=e.rotational),
    "spring": lambda model, e: model.spring(*e.between, stiffness=e.stiffness, rest_length=e.rest_length, name=e.name),
    "damper": lambda model, e: model.damper(*e.between, damping=e.damping, name=e.name),
    "torsion_spring": lambda model, e: model.torsion_spring(
        *e.between, stiffness=e.stiffness, rest_angle=e.rest_angle, name=e.name
    ),
    "torsion_damper": lambda model, e: model.torsion_damper(*e.between, damping=e.damping, name=e.name),
    "rigid_tie": _rigid_tie,
    "lever": _lever,
    "gear": _gear,
    "rack": _rack,
    "pulley": lambda model, e: model.pulley(*e.between, over=e.over, length=e.length, name=e.name),
    "constraint": _constraint,
}
