"""A start that does not fit the equations: which row it breaks, by how much, and what will happen at t = 0."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..mechanics.units import force_unit
from ..notices import Notice
from ..response import admissible
from .happenings import impulses_of, jumps_of, sentences
from .values import Coordinates

if TYPE_CHECKING:
    from ..mechanics import MechanicalSystem
    from ..response import Response
    from .equations import Equations

MOST_TOLD = 12


def start_notices(equations: Equations) -> tuple[Notice, ...]:
    """The causes first, then the jumps and impulses; none where the start fits."""
    if equations.start_fits:
        return ()
    motion, coordinates = equations.solve(), equations.coordinates
    told = [*_causes(equations, motion), *sentences(jumps_of(motion, coordinates), motion.impulses, coordinates, "t = 0")]
    if equations.system is not None:
        told += _in_constraint_forces(equations.system, motion)
    return tuple(told[:MOST_TOLD]) + ((Notice("jump", f"and {len(told) - MOST_TOLD} more"),) if len(told) > MOST_TOLD else ())


def _causes(equations: Equations, motion: Response) -> Iterator[Notice]:
    """Constraint rows that do not hold, or else the equations."""
    rows = [notice for notice in motion.notices if notice.kind == "jump" and notice.text.startswith("constraint ")]
    yield from rows
    if not rows:
        found = admissible(equations.polynomial_matrix, initial=equations.initial, force=equations.right_hand_side)
        for violation in found.violations:
            _, _, text = violation.text.partition(": ")
            yield Notice("jump", f"the start does not fit: {text}")


def _in_constraint_forces(system: MechanicalSystem, motion: Response) -> list[Notice]:
    names = tuple(f'constraint "{row.name}"' for row in system.rows)
    rows = Coordinates(names, tuple(force_unit(row.unit) for row in system.rows))
    return [
        Notice("impulse", f"{impulse.name}: its force contains {impulse.delta} of {impulse.size} at t = 0")
        for impulse in impulses_of(motion.constraint_impulses, rows.names, rows.units)
    ]
