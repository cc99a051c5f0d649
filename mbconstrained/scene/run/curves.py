"""Trajectories at the times of a scene, with names and units."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...exchange.trajectories import Curves
from ...ground.coordinate_units import derivative_name, force_unit, rate_unit
from ...ground.tolerances import NOT_DRAWN

if TYPE_CHECKING:
    from .result import Result

ORDERS = {"displacement": 0, "velocity": 1, "acceleration": 2}
PARTS = {  # curves that are made of others
    "energy": ("displacement", "velocity"),
    "output": ("displacement",),
    "phase": ("displacement", "velocity"),
}
ENERGIES = ("kinetic", "strain", "static", "total")


def curves_of(result: Result, kind: str) -> Curves:
    """The trajectories of a kind at the times of a scene.

    Args:
        result: of the scene.
        kind: a key of ORDERS, "reaction" (forces of the constraint rows), "energy", or "output" (of a robot as deviations from its
            posture, of a transfer function or state space as they are).

    Returns:
        The curves with names and units.
    """
    equations, motion, times = result.scene.equations, result.motion, result.times
    if kind in ORDERS:
        order, coordinates = ORDERS[kind], equations.coordinates
        values = motion.derivative(order)(times) if order else motion(times)
        titles = tuple(derivative_name(unit, order) for unit in coordinates.units)
        return Curves(kind, coordinates.names, titles, tuple(rate_unit(unit, order) for unit in coordinates.units), values)
    if kind == "reaction":
        rows, values = equations.system.rows, motion.reaction(times)
        names, units = tuple(row.name for row in rows), tuple(force_unit(row.unit) for row in rows)
    elif kind == "output":
        names, units = equations.outputs.names, equations.outputs.units
        values = equations.output_values(times, result.values)
    else:
        energy = motion.energy(times)
        names, units = ENERGIES, ("J",) * len(ENERGIES)
        values = np.array([getattr(energy, name) for name in ENERGIES])
    return Curves(kind, names, (kind,) * len(names), units, values)


def visible(values: np.ndarray, units: tuple[str, ...]) -> np.ndarray:
    """How far the coordinates of each unit move, which decides what is visible next to it.

    Args:
        values: of the coordinates, shape (r, T).
        units: of the coordinates.

    Returns:
        Half of the largest span of a coordinate of the same unit, shape (r, 1).
    """
    reach = np.ptp(values, axis=1)
    furthest = {unit: max(own for own, other in zip(reach, units) if other == unit) for unit in units}
    return np.array([max(furthest[unit] / 2, NOT_DRAWN * np.abs(values).max()) for unit in units])[:, None]
