"""Trajectories at the times of a scene, with names and units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..mechanics.units import force_unit, rate_unit
from .equations import Equations
from .values import derivative_name

ORDERS = {"displacement": 0, "velocity": 1, "acceleration": 2}
PARTS = {  # curves that are made of others
    "energy": ("displacement", "velocity"),
    "output": ("displacement",),
    "phase": ("displacement", "velocity"),
}
ENERGIES = ("kinetic", "strain", "static", "total")


@dataclass(frozen=True)
class Curves:
    """Values of one kind over time.

    Attributes:
        kind: "displacement", "velocity", "acceleration", "reaction", "energy" or "output".
        names, titles, units: of the rows; a title says what the row is, e.g. "angle".
        values: shape (rows, T).
    """

    kind: str
    names: tuple[str, ...]
    titles: tuple[str, ...]
    units: tuple[str, ...]
    values: np.ndarray


def coordinate_curves(equations: Equations, motion, times: np.ndarray, kind: str) -> Curves:
    """The coordinates or one of their derivatives."""
    order = ORDERS[kind]
    values = motion.derivative(order)(times) if order else motion(times)
    titles = tuple(derivative_name(unit, order) for unit in equations.coordinates.units)
    units = tuple(rate_unit(unit, order) for unit in equations.coordinates.units)
    return Curves(kind, equations.coordinates.names, titles, units, values)


def reaction_curves(equations: Equations, motion, times: np.ndarray) -> Curves:
    """The forces of the constraint rows."""
    rows = equations.system.rows
    titles = ("reaction",) * len(rows)
    units = tuple(force_unit(row.unit) for row in rows)
    return Curves("reaction", tuple(row.name for row in rows), titles, units, motion.reaction(times))


def output_curves(equations: Equations, times: np.ndarray, displacement: np.ndarray) -> Curves:
    """The named outputs: of a robot as deviations from its posture, of a transfer function or state space as they are."""
    outputs, values = equations.outputs, equations.output_values(times, displacement)
    return Curves("output", outputs.names, ("output",) * len(outputs.names), outputs.units, values)


def energy_curves(motion, times: np.ndarray) -> Curves:
    """Kinetic, strain, static and total energy."""
    energy = motion.energy(times)
    values = np.array([getattr(energy, name) for name in ENERGIES])
    return Curves("energy", ENERGIES, ("energy",) * len(values), ("J",) * len(values), values)
