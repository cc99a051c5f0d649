"""The exact motion of a mechanical system, in multiplier form: [M s^2 + C s + K, -A^T; A s^level, 0] [x; lambda] = [f; b].

It has the motions of the constrained form and needs no null space, whose entries are rounded: masses, springs and rows enter
as they are, and the multipliers are part of the answer.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..ground.tolerances import EPS
from ..linalg.division import vanish_exactly
from ..linalg.double_double import DOUBLED_EPS, DoubleDouble
from ..polynomial.coefficients import Factors
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..response.methods.defect import UNIT, Extended, Rounding
from ..signals.inputs import ImpulsiveSmooth
from .constraints import with_multipliers, with_right_sides
from .element_matrix import ElementMatrix
from .equations import EquationsOfMotion

if TYPE_CHECKING:
    from ..exact.enclosure.exact_response import ExactResponse


def exact_motion(system: EquationsOfMotion, initial: np.ndarray, applied: ImpulsiveSmooth) -> ExactResponse:
    """The exact motion x, n rows, followed by the rows of its k multipliers."""
    from ..exact.enclosure.exact_response import ExactDelayedResponse, ExactResponse
    from ..exact.enclosure.exact_sources import sources_of
    from ..exact.rational import RationalMatrix, regular

    n, k = system.size, len(system.rows)
    start = np.hstack([initial, np.zeros((len(initial), k))])
    force = with_right_sides(applied, system.rows)
    equations = [*(f"motion of {name}" for name in system.names), *(f"constraint {row.name}" for row in system.rows)]
    coordinates = [*system.names, *(f"force of {row.name}" for row in system.rows)]
    exact, rows = PolynomialMatrix(system.given).exact_coefficients, system.constraint_matrix.astype(object)
    matrices = [matrix.tolist() for matrix in with_multipliers(exact, rows, [row.order for row in system.rows])]
    data = regular(RationalMatrix(matrices), equations, coordinates), start, sources_of(force), range(n)
    if system.delayed:
        terms = tuple(replace(term, coefficients=np.pad(term.coefficients, ((0, 0), (0, k), (0, k)))) for term in system.delayed)
        return ExactDelayedResponse(*data, terms)
    return ExactResponse(*data)


class FormRounding(Rounding):
    """Rounding errors of the constrained form of a motion, with respect to its masses, springs, dampers, rows and forces.

    V^T K was rounded, and so was V: where A V is not zero, constraint forces enter, lambda = G (K x + ... - f) with G A^T = I.
    """

    system: EquationsOfMotion
    applied: ImpulsiveSmooth

    def __init__(self, system: EquationsOfMotion, applied: ImpulsiveSmooth):
        self.__dict__.update(system=system, applied=applied)

    @classmethod
    def of(cls, system: EquationsOfMotion, applied: ImpulsiveSmooth) -> FormRounding | None:
        """Rounding errors of a motion; None where its equations are the data."""
        given = system.given
        return cls(system, applied) if len(system.rows) or any(isinstance(matrix, ElementMatrix) for matrix in given) else None

    @cached_property
    def _terms(self) -> np.ndarray:
        """The sizes of the terms of [K, C, M], shape (3, n, n)."""
        return np.array([_sizes(matrix) for matrix in self.system.given])

    @cached_property
    def _through(self) -> np.ndarray:
        """Bounds of the constraint forces in the equations, relative to each term, shape (n - k, n); zero for whole numbers."""
        form = self.system.undelayed_form()
        V, A = form.null_space, form.rows
        if _is_exact(V, A):
            return np.zeros(V.T.shape)
        extended = V.astype(Extended)
        forces = np.abs(extended.T @ A.T) + UNIT * (len(V) + 4) * (np.abs(V.T) @ np.abs(A.T))
        return forces.astype(float) @ np.abs(self.system.multiplier_map)

    @cached_property
    def has_exact_zeros(self) -> bool:
        """Whether A V = 0 and the zeros of V^T [C, M] hold for the data taken as exact numbers."""
        form = self.system.undelayed_form()
        V, A, projected = form.null_space, form.rows, form.polynomial_matrix.coefficients
        if not vanish_exactly(A, V, np.zeros((len(A), V.shape[1]))):
            return False
        return all(_vanishes_exactly(V, matrix, whole[: V.shape[1]]) for matrix, whole in zip(self.system.given[1:], projected[1:]))

    @cached_property
    def coefficients(self) -> tuple[np.ndarray, ...]:
        """Bounds of the errors of A_0, A_1, A_2, shape (n, n) each."""
        form = self.system.undelayed_form()
        V, projected, sizes = form.null_space, form.polynomial_matrix.coefficients, self._terms
        own, turned, size = V.shape[1], V.T.astype(Extended), np.abs(V.T)
        lost = np.zeros(projected.shape)
        for power, matrix in enumerate(self.system.given):
            lost[power, :own] = np.abs(turned @ _extended(matrix) - projected[power, :own])
        lost[:, :own] += UNIT * (len(V) + 4) * (size @ sizes) + self._through @ sizes
        return tuple(lost)

    @cached_property
    def force(self) -> np.ndarray:
        """A bound of the errors of the coefficients of f, for each row, shape (n,)."""
        V, columns = self.system.undelayed_form().null_space, self.applied.smooth.coefficients
        force = np.zeros(len(V))
        if columns.any():
            load = np.abs(columns).max(axis=1, initial=0.0)
            mixed = ~(((V != 0).sum(axis=0) == 1) & (V.max(axis=0, initial=0.0) == 1.0))
            force[: V.shape[1]] = self._through @ load + mixed * EPS * len(V) * (np.abs(V.T) @ load)
        return force

    @property
    def elements(self) -> tuple[Factors | None, ...]:
        """The data that A_0, A_1, A_2 are assembled from, those of the constrained form with the digits of V."""
        return self._refined[0]

    @property
    def unresolved(self) -> tuple[np.ndarray, ...]:
        """Bounds of what the elements still lack of A_0, A_1, A_2."""
        return self._refined[1]

    @cached_property
    def _refined(self) -> tuple[tuple[Factors | None, ...], tuple[np.ndarray, ...]]:
        system = self.system
        form, given = system.undelayed_form(), system.given
        A, own = form.rows, form.null_space.shape[1]
        if not len(A):
            return tuple(matrix.factors if isinstance(matrix, ElementMatrix) else None for matrix in given), ()
        basis, uncertain = _null_space(form.null_space, A, system)
        parts = [_projected(matrix, basis, whole[own:]) for matrix, whole in zip(given, form.polynomial_matrix.coefficients)]
        return tuple(parts), tuple(np.concatenate([uncertain @ sizes, 0 * A]) for sizes in self._terms if uncertain.any())


def _null_space(V: np.ndarray, A: np.ndarray, system: EquationsOfMotion) -> tuple[DoubleDouble, np.ndarray]:
    """V with twice the digits, and bounds of the constraint forces in V^T (K x + ... - f), relative to each term."""
    if _is_exact(V, A):
        return DoubleDouble.of(V), np.zeros(V.T.shape)
    inverse, basis = system.multiplier_map, DoubleDouble.of(V)
    if (left := (A @ basis).high).any():
        basis = basis - inverse.T @ left
    forces = np.abs((A @ basis).high) + (len(V) + 4) * DOUBLED_EPS * (np.abs(A) @ np.abs(V))
    return basis, forces.T @ np.abs(inverse)


def _projected(matrix: np.ndarray | ElementMatrix, V: DoubleDouble, rows: np.ndarray) -> Factors:
    """[V^T matrix; rows] by its elements."""
    if isinstance(matrix, ElementMatrix):
        elements = matrix.factors
        left = elements.left.T @ V
    else:
        elements, left = Factors(np.eye(0), np.ones(len(matrix)), matrix), V
    numbers = [left.high, left.low] if left.low.any() else [left.high]
    parts, count, own = np.concatenate(numbers), len(numbers), V.shape[1]
    through = np.zeros((own + len(rows), len(parts) + len(rows)))
    through[:own, : len(parts)], through[own:, len(parts) :] = parts.T, np.eye(len(rows))
    values = np.concatenate([*[elements.values] * count, np.ones(len(rows))])
    return Factors(through, values, np.concatenate([*[elements.right] * count, rows]))


def _vanishes_exactly(V: np.ndarray, matrix: np.ndarray | ElementMatrix, projected: np.ndarray) -> bool:
    """Whether zeros of V^T matrix hold exactly; False for elements whose sums are rounded."""
    if not isinstance(matrix, ElementMatrix):
        return vanish_exactly(V.T, matrix, projected)
    left, right = V.T @ matrix.directions.T, matrix.directions
    if not ((np.abs(left) @ np.abs(right) > 0) & (projected == 0)).any():
        return True
    signs = all((np.abs(part) <= 1).all() and (part == np.rint(part)).all() for part in (V, left, right))
    return signs and vanish_exactly(left * matrix.constants, right, projected)


def _extended(matrix: np.ndarray | ElementMatrix) -> np.ndarray:
    """A matrix in extended precision."""
    if not isinstance(matrix, ElementMatrix):
        return matrix.astype(Extended)
    B = matrix.directions.astype(Extended)
    return (B.T * matrix.constants) @ B


def _sizes(matrix: np.ndarray | ElementMatrix) -> np.ndarray:
    """The sizes of the terms of the entries of a matrix."""
    if not isinstance(matrix, ElementMatrix):
        return np.abs(matrix)
    B = np.abs(matrix.directions)
    return (B.T * np.abs(matrix.constants)) @ B


def _is_exact(V: np.ndarray, A: np.ndarray) -> bool:
    """Whether A V = 0 exactly, of whole numbers of so few bits that their products are exact."""
    whole = all(bool((part == np.rint(part)).all()) and float(np.abs(part).max(initial=0.0)) <= 2.0**20 for part in (V, A))
    return whole and not (A @ V).any()
