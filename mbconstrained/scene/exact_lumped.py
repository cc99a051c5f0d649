"""A lumped model with its parameters as symbols: the same elements, their constants exact expressions."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..models.elements import Element, Mass, Tie
from ..models.incidence import coordinate_row, incidence_of
from .lumped import entries
from .units import quantity
from .values import Coordinates, constraint_value

if TYPE_CHECKING:
    from ..exact.formulas.constrained import Row
    from ..exact.formulas.symbols import Symbols
    from .scene import Scene


def exact_lumped(scene: Scene, symbols: Symbols) -> tuple[list[np.ndarray], list[Row], np.ndarray]:
    """K, C, M as arrays of expressions, the constraint rows, and the static force of rest lengths and weights."""
    from ..exact.formulas.constrained import Row

    table, coordinates = scene.table.model, scene.equations.coordinates
    elements = _exact_elements(scene, symbols)
    factors = incidence_of(elements)
    K, C = (_integers(b.incidence).T @ (b.constants[:, None] * _integers(b.incidence)) for b in (factors.springs, factors.dampers))
    gravity = symbols.of(0 if table.gravity is None else table.gravity)  # 0 may be the default of a parameter
    weights = {element.name: gravity * element.mass for element in elements if isinstance(element, Mass)}
    rest = _integers(factors.springs.incidence).T @ (factors.springs.constants * factors.springs.rest)
    static = rest + coordinate_row({name: weights.get(name, 0) for name in coordinates.names}, coordinates.names)
    rows = [_row(element, coordinates, symbols, Row) for element in elements if isinstance(element, Tie)]
    return [_expressions(matrix, symbols) for matrix in (K, C, np.diag(factors.masses))], rows, _expressions(static, symbols)


def _expressions(array: np.ndarray, symbols: Symbols) -> np.ndarray:
    """Sums of nothing are numbers, not expressions."""
    return symbols.all_of(array)


def _integers(incidence: np.ndarray) -> np.ndarray:
    return incidence.astype(int).astype(object)


def _row(tie: Tie, coordinates: Coordinates, symbols: Symbols, make: Callable) -> Row:
    from ..mechanics.constraint import LEVELS

    coefficients = [symbols.of(tie.row.get(name, 0)) for name in coordinates.names]
    return make(tie.name, np.array(coefficients, dtype=object), LEVELS.index(tie.level), symbols.of(tie.row_value))


def _exact_elements(scene: Scene, symbols: Symbols) -> list[Element]:
    """Copies of the elements, with expressions for numbers; they come in the order in which they were added."""
    coordinates = scene.equations.coordinates
    found = []
    for element, (key, _, entry) in zip(scene.equations.model.elements, entries(scene.table.model)):
        twin = copy.copy(element)
        for name, value in _CONSTANTS.get(key, _none)(entry, coordinates).items():
            exact = {k: symbols.of(v) for k, v in value.items()} if isinstance(value, dict) else symbols.of(value)
            object.__setattr__(twin, name, exact)
        found.append(twin)
    return found


def _none(entry: Any, coordinates: Coordinates) -> dict:
    return {}


def _tie(entry, coordinates) -> dict:
    units = dict(zip(coordinates.names, coordinates.units))
    unit = next((units[name] for name in entry.between if name in units), "m")
    return {"distance": quantity(entry.distance, unit)}


_CONSTANTS: dict[str, Callable[[Any, Coordinates], dict]] = {  # of each kind of element: its numbers by the names of its fields
    "mass": lambda e, _: {"mass": e.mass},
    "inertia": lambda e, _: {"inertia": e.inertia},
    "spring": lambda e, _: {"stiffness": e.stiffness, "rest_length": e.rest_length},
    "damper": lambda e, _: {"damping": e.damping},
    "torsion_spring": lambda e, _: {"stiffness": e.stiffness, "rest_angle": e.rest_angle},
    "torsion_damper": lambda e, _: {"damping": e.damping},
    "rigid_tie": _tie,
    "lever": lambda e, _: {"start_arm": e.arms[0], "end_arm": e.arms[1]},
    "gear": lambda e, _: {"start_radius": e.sizes[0], "end_radius": e.sizes[1]},
    "rack": lambda e, _: {"radius": e.radius},
    "pulley": lambda e, _: {} if e.length is None else {"length": e.length},
    "constraint": lambda e, coordinates: {"coefficients": dict(e.rows), "value": constraint_value(e, coordinates)},
}
