"""The [[output.quantity]] tables: forces and elongations of springs and dampers, and motions of one body relative to another."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...ground.checks import nearest
from ...ground.coordinate_units import GROUND, force_unit, rate_unit
from ...ground.errors import InputError
from ..file.messages import shown

if TYPE_CHECKING:
    from .model import Equations

RELATIVE = ("displacement", "velocity", "acceleration")


@dataclass(frozen=True, eq=False)
class ElementQuantity:
    """constant + sum over i of rows[i] @ x^(i)(t).

    Attributes:
        name, title, unit: name, title and unit of the curve; the title is the quantity.
        rows: rows of x, x' and x'', shape (3, n).
        constant: in the unit.
    """

    name: str
    title: str
    unit: str
    rows: np.ndarray
    constant: float = 0.0

    def values(self, motion, times: np.ndarray) -> np.ndarray:
        """Over times (T,), of a motion."""
        orders = [order for order, row in enumerate(self.rows) if row.any()]
        parts = (self.rows[order] @ (motion.derivative(order)(times) if order else motion(times)) for order in orders)
        return self.constant + sum(parts, np.zeros(len(times)))


def element_quantities(tables, equations: Equations) -> Iterator[ElementQuantity]:
    """The quantities of the tables."""
    for table in tables:
        yield _between(table, equations) if table.between else _of_element(table, equations)


def _between(table, equations: Equations) -> ElementQuantity:
    """The motion of the second coordinate relative to the first."""
    coordinates = equations.coordinates
    row, units = np.zeros(len(coordinates.names)), set()
    for name, sign in zip(table.between, (-1.0, 1.0)):
        if name != GROUND:
            place = coordinates.number(name, GROUND)
            row[place] += sign
            units.add(coordinates.units[place])
    if not row.any() or len(units) != 1:
        raise InputError(
            f"between: found {shown(table.between[0])} and {shown(table.between[1])}; expected two coordinates of one unit"
        )
    quantity = table.quantity or "displacement"
    if quantity not in RELATIVE:
        raise InputError(f"quantity: found {shown(quantity)}; between two coordinates expected {', '.join(RELATIVE)}")
    order = RELATIVE.index(quantity)
    rows = np.zeros((3, len(row)))
    rows[order] = row
    name = table.name or f"{table.between[1]} relative to {table.between[0]}"
    return ElementQuantity(name, f"relative {quantity}", rate_unit(units.pop(), order), rows)


def _of_element(table, equations: Equations) -> ElementQuantity:
    elements = equations.system.elements if equations.system is not None else {}
    if table.of not in elements:
        there = f"; there are {', '.join(elements)}" if elements else "; the model has no springs and dampers with names"
        raise InputError(f"of: there is no spring or damper {shown(table.of)}{nearest(table.of, elements)}{there}")
    elongation, rest, stiffness, damping, unit = elements[table.of]
    quantity, rows = table.quantity or "force", np.zeros((3, len(elongation)))
    if quantity == "force":
        rows[0], rows[1] = stiffness * elongation, damping * elongation
        return ElementQuantity(
            table.name or table.of, "force" if unit == "m" else "torque", force_unit(unit), rows, stiffness * rest
        )
    if quantity not in ("elongation", "rate"):
        raise InputError(f"quantity: found {shown(quantity)}; expected force, elongation or rate of a spring or damper")
    rows[int(quantity == "rate")] = elongation
    constant = rest if quantity == "elongation" else 0.0
    return ElementQuantity(
        table.name or table.of,
        quantity if quantity == "elongation" else "elongation rate",
        rate_unit(unit, int(quantity == "rate")),
        rows,
        constant,
    )
