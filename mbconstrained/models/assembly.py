"""From the elements of a lumped model to M, C, K, constant forces and constraint rows with names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..errors import InputError
from ..mechanics.constraint import Constraint
from ..mechanics.element_matrix import ElementMatrix
from ..mechanics.energy_parts import EnergyParts
from ..mechanics.system import MechanicalSystem
from ..signals.inputs import ImpulsiveSmooth, zero
from .elements import Body, Element, Mass, Tie
from .incidence import Incidence, coordinate_row, incidence_of


def assembled(
    elements: Sequence[Element], gravity: float = 0.0, forces: Mapping[str, ImpulsiveSmooth] | None = None
) -> MechanicalSystem:
    """M x'' + C x' + K x = f with one constraint row per tie; C and K are exactly symmetric.

    Args:
        elements: bodies, springs, dampers and ties; every end is the ground or the name of a body.
        gravity: acceleration of free fall along the axis, m/s^2.
        forces: signals with one row, by coordinate.

    Raises:
        InputError: there is no body among the elements.
        ContradictoryConstraints: ties that ask for different values.
    """
    units = {element.name: element.unit for element in elements if isinstance(element, Body)}
    if not units:
        raise InputError("the model has no body; add a mass, an inertia or a node")
    names = tuple(units)
    factors = incidence_of(elements)
    weights = {element.name: gravity * element.mass for element in elements if isinstance(element, Mass)}
    return MechanicalSystem(
        mass=ElementMatrix(np.eye(len(names)), factors.masses),
        damping=factors.dampers.matrix,
        stiffness=factors.springs.matrix,
        constraints=[_constraint(element, names) for element in elements if isinstance(element, Tie)],
        names=names,
        force=_drive(forces or {}, names),
        static_force=factors.springs.rest_force() + coordinate_row(weights, names),
        units=units,
        energy_parts=_energy_parts(factors, names),
    )


def _energy_parts(factors: Incidence, names: Sequence[str]) -> EnergyParts:
    """Every mass and every spring by its name; joints without mass are none."""
    unit_rows, springs = np.eye(len(names)), factors.springs
    masses = {name: ElementMatrix(row[None], [mass]) for name, row, mass in zip(names, unit_rows, factors.masses) if mass}
    by_spring = zip(springs.names, springs.incidence, springs.constants)
    return EnergyParts(masses, {name: ElementMatrix(row[None], [constant]) for name, row, constant in by_spring})


def _constraint(tie: Tie, names: Sequence[str]) -> Constraint:
    return Constraint(coordinate_row(tie.row, names), level=tie.level, value=tie.row_value, names=tie.name)


def _drive(forces: Mapping[str, ImpulsiveSmooth], names: Sequence[str]) -> ImpulsiveSmooth | None:
    if not forces:
        return None
    total = zero(len(names))
    for name, signal in forces.items():
        total = total + signal.mapped(coordinate_row({name: 1.0}, names)[:, None])
    return total
