"""The equations as they are, of first order: E y' + F y = g, multipliers and singular masses included.

The unknowns are the coordinates, with rows of constraints their multipliers too, and of each as many derivatives as occur
in the equations, less one: nothing is reduced by hand.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...mechanics import MechanicalSystem
from ...mechanics.exact_motion import with_multipliers
from ...mechanics.reaction import reaction_function
from ...polynomial import PolynomialMatrix
from ...response import Response
from ...signals import BohlFunction, ImpulsiveSmooth, step, zero
from ..problem import Problem
from .reduced import once_for_each, reduced


@dataclass(frozen=True)
class Descriptor:
    """E y' + F y = g.

    Attributes:
        E, F: shapes (N, N).
        force: g, N rows.
        places: of each y which unknown it is, and which derivative of it.
        function: the unknowns, coordinates first, in closed form.
        index: how often the equations have to be differentiated to give y'.
        count: how many unknowns are coordinates.
    """

    E: np.ndarray
    F: np.ndarray
    force: ImpulsiveSmooth
    places: tuple[tuple[int, int], ...]
    function: BohlFunction
    index: int
    count: int

    @property
    def algebraic(self) -> np.ndarray:
        """Whether each y is without a derivative in the equations."""
        return ~self.E.any(axis=0)

    @property
    def tested(self) -> np.ndarray:
        """Whether each y is in the error test: what is asked for always is."""
        asked = np.array([unknown < self.count and not order for unknown, order in self.places])
        out = self.algebraic & (self.index > 1) | np.array([order > 0 and self.index > 2 for _, order in self.places])
        return asked | ~out

    @property
    def coordinates(self) -> list[int]:
        """Which y are the coordinates themselves."""
        return [self.places.index((unknown, 0)) for unknown in range(self.count)]

    def states(self, order: int) -> BohlFunction:
        """y, or its derivatives, in closed form."""
        return self._placed([self.function.derivative(k + order) for k in range(1 + max(k for _, k in self.places))])

    def _placed(self, derivatives: list[BohlFunction]) -> BohlFunction:
        rows = np.array([derivatives[order].coefficients[unknown] for unknown, order in self.places])
        return BohlFunction(rows, self.function.blocks, self.function.start)


def descriptor(coefficients: np.ndarray, force: ImpulsiveSmooth, function: BohlFunction, count: int) -> Descriptor:
    """First order of A_0 u + A_1 u' + ... = force, each unknown with as many derivatives as occur, less one.

    Args:
        coefficients: A_0, A_1, ..., each of shape (N, N).
        force: N rows.
        function: u in closed form.
        count: how many of the unknowns, the first, are coordinates.
    """
    size = len(coefficients[0])
    highest = [max(np.flatnonzero(coefficients[:, :, k].any(axis=1)), default=0) for k in range(size)]
    places = tuple((k, order) for order in range(len(coefficients)) for k in range(size) if order < max(highest[k], 1))
    at = {place: number for number, place in enumerate(places)}
    E, F = np.zeros((2, len(places), len(places)))
    for k in range(size):
        for order in range(highest[k] + 1):
            inside = (k, order) in at
            (F if inside else E)[:size, at[k, order] if inside else at[k, order - 1]] += coefficients[order][:, k]
    steps = [(at[k, order], at[k, order + 1]) for k, order in places if (k, order + 1) in at]
    for row, (lower, upper) in enumerate(steps, start=size):
        E[row, lower], F[row, upper] = 1.0, -1.0
    index = max(PolynomialMatrix([F, E]).structure().infinite_divisors, default=0)
    return Descriptor(E, F, force.mapped(np.eye(len(places), size)), places, function, index, count)


@once_for_each
def plain(problem: Problem) -> Descriptor:
    """A(d/dt) x = f itself, the unknowns being the coordinates."""
    response = reduced(problem).response
    return descriptor(problem.polynomial_matrix.coefficients, problem.force, response.function, problem.polynomial_matrix.size)


def _constrained(problem: Problem, index: int) -> Descriptor:
    """[M s^2 + C s + K, -A^T; A s^order, 0] with the rows differentiated as often as the index asks."""
    system, response = problem.system, reduced(problem).response
    n, k, order = system.size, len(system.rows), 3 - index
    matrices = (system.stiffness, system.damping, system.mass)
    coefficients = np.array(with_multipliers(matrices, system.constraint_matrix, [order] * k))
    applied = system.force if problem.applied is None else system.force + problem.applied
    held = np.array([row.value if row.order == order else 0.0 for row in system.rows])
    right = applied.mapped(np.eye(n + k, n)) + _constant(np.concatenate([np.zeros(n), held]))
    function = _together(response, system, applied)
    return descriptor(coefficients, right, function, n)


#: By index, the form for a mechanical system with rows of constraints.
CONSTRAINED = {index: once_for_each(lambda problem, index=index: _constrained(problem, index)) for index in (1, 2, 3)}


def _constant(values: np.ndarray) -> ImpulsiveSmooth:
    return step(values) if values.any() else zero(len(values))


def _together(response: Response, system: MechanicalSystem, applied: ImpulsiveSmooth) -> BohlFunction:
    """Coordinates and multipliers."""
    n, k = system.size, len(system.rows)
    multipliers = reaction_function(system, response, applied)
    return response.function.mapped(np.eye(n + k, n)) + multipliers.mapped(np.eye(n + k, k, -n))
