"""From lists of numbers to problems: chains of bodies, matrices."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....mechanics import ElementMatrix, MechanicalSystem
from ....polynomial import PolynomialMatrix
from ....signals import ImpulsiveSmooth, zero
from ...problem import Problem, mechanical_problem

#: A spring or damper: its two ends, bodies by number from 1, the ground is 0; its constant.
Link = tuple[int, int, float]


def spaced(first: float, last: float, count: int = 10) -> np.ndarray:
    """Times from the first to the last, each the same factor later."""
    return np.array([first * (last / first) ** (place / (count - 1)) for place in range(count)])


def elements(size: int, links: Sequence[Link]) -> ElementMatrix:
    """B^T diag(k) B of springs or dampers."""
    directions = np.zeros((len(links), size + 1))
    for row, (start, end, _) in zip(directions, links):
        row[start], row[end] = -1.0, 1.0
    return ElementMatrix(directions[:, 1:], [constant for *_, constant in links])


def bodies(masses: Sequence[float], springs: Sequence[Link], dampers: Sequence[Link] = (), constraints=()) -> MechanicalSystem:
    """Bodies along one axis, by their elements: none is lost beside stiffer ones."""
    n = len(masses)
    damping = elements(n, dampers) if dampers else None
    return MechanicalSystem(ElementMatrix(np.eye(n), masses), damping, elements(n, springs), constraints)


def assembled(system: MechanicalSystem) -> MechanicalSystem:
    """The same as plain float64 matrices."""
    return MechanicalSystem(system.mass, system.damping, system.stiffness, system.constraints)


def chain(*constants: float) -> list[Link]:
    """Links from the ground to body 1, to body 2, and so on."""
    return [(place, place + 1, constant) for place, constant in enumerate(constants)]


def moving(title: str, system: MechanicalSystem, times, start, force: ImpulsiveSmooth | None = None) -> Problem:
    """A mechanical problem from x(0-), x'(0-) as rows."""
    return mechanical_problem(title, system, times, *start, force=force)


def equations(title: str, coefficients, start, times, force: ImpulsiveSmooth | None = None) -> Problem:
    """A(d/dt) x = f from x(0-), x'(0-), ... as rows."""
    A = PolynomialMatrix([np.asarray(matrix, dtype=float) for matrix in coefficients])
    initial = np.asarray(start, dtype=float).reshape(A.degree, A.size)
    return Problem(title, A, initial, zero(A.size) if force is None else force, np.asarray(times, dtype=float))
