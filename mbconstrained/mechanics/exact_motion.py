"""The exact motion of a mechanical system, in multiplier form: [M s^2 + C s + K, -A^T; A s^level, 0] [x; lambda] = [f; b].

It has the motions of the constrained form and needs no null space, whose entries are rounded: masses, springs and rows enter
as they are, and the multipliers are part of the answer.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..ground.tolerances import EPS
from ..linalg.arrays import full
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
    from ..exact.enclosure.exact_response import ExactResponse
    from ..exact.enclosure.exact_sources import sources_of
    from ..exact.rational import RationalMatrix, regular

    n, k = system.size, len(system.rows)
    start = np.hstack([initial, np.zeros((len(initial), k))])
    force = with_right_sides(applied, system.rows)
    equations = [*(f"motion of {name}" for name in system.names), *(f"constraint {row.name}" for row in system.rows)]
    coordinates = [*system.names, *(f"force of {row.name}" for row in system.rows)]
    exact, rows = PolynomialMatrix(system.given).exact_coefficients, system.constraint_matrix.astype(object)
    matrices = [matrix.tolist() for matrix in with_multipliers(exact, rows, [row.order for row in system.rows])]
    if system.delayed:
        from ..exact.enclosure.delayed_response import ExactDelayedResponse

        terms = tuple(replace(term, coefficients=np.pad(term.coefficients, ((0, 0), (0, k), (0, k)))) for term in system.delayed)
        matrix = regular(RationalMatrix(matrices), equations, coordinates)
        return ExactDelayedResponse(matrix, terms, start, force, range(n))
    return ExactResponse(regular(RationalMatrix(matrices), equations, coordinates), start, sources_of(force), range(n))


def rounding_of_form(system: EquationsOfMotion, applied: ImpulsiveSmooth) -> Rounding | None:
    """Rounding errors of the constrained form of a motion, with respect to its masses, springs, dampers, rows and forces.

    V^T K was rounded, and so was V: where A V is not zero, constraint forces enter, lambda = G (K x + ... - f) with G A^T = I.
    """
    form = system.constrained_form()
    given, V, A = system.given, form.null_space.astype(Extended), form.rows
    elements = tuple(matrix.factors if isinstance(matrix, ElementMatrix) else None for matrix in given)
    if not len(A) and not any(elements):
        return None
    unit = UNIT * (len(V) + 4)
    forces = np.abs(V.T @ A.T) + unit * (np.abs(V.T) @ np.abs(A.T))
    through = (forces @ np.abs(system._independent.left_inverse)).astype(float)
    coefficients, own = [], V.shape[1]
    for matrix, projected in zip(given, form.polynomial_matrix.coefficients):
        whole, size = _extended(matrix)
        lost = np.zeros(projected.shape)
        lost[:own] = np.abs(V.T @ whole - projected[:own]) + unit * (np.abs(V.T) @ size) + through @ size
        coefficients.append(lost)
    load = np.abs(applied.smooth.coefficients).max(axis=1, initial=0.0)
    mixed = ~(((V != 0).sum(axis=0) == 1) & (V.max(axis=0, initial=0.0) == 1.0))
    force = np.zeros(len(V))
    force[:own] = through @ load + mixed * EPS * len(V) * (np.abs(V.T).astype(float) @ load)
    if not len(A):
        return Rounding(tuple(coefficients), force, elements)
    basis, uncertain = _null_space(form.null_space, A, system)
    parts = [_projected(matrix, basis, whole[own:]) for matrix, whole in zip(given, form.polynomial_matrix.coefficients)]
    unresolved = [np.concatenate([uncertain @ _extended(matrix)[1], 0 * A]) for matrix in given]
    return Rounding(tuple(coefficients), force, tuple(parts), tuple(unresolved))


def _null_space(V: np.ndarray, A: np.ndarray, system: EquationsOfMotion) -> tuple[DoubleDouble, np.ndarray]:
    """V with twice the digits, and bounds of the constraint forces in V^T (K x + ... - f), relative to each term."""
    inverse, basis = system._independent.left_inverse, DoubleDouble.of(V)
    if (left := (A @ basis).high).any():
        basis = basis - inverse.T @ left
    forces = np.abs((A @ basis).high) + (len(V) + 4) * DOUBLED_EPS * (np.abs(A) @ np.abs(V))
    return basis, forces.T @ np.abs(inverse)


def _projected(matrix: np.ndarray | ElementMatrix, V: DoubleDouble, rows: np.ndarray) -> Factors:
    """[V^T matrix; rows] by its elements."""
    factors = matrix.factors if isinstance(matrix, ElementMatrix) else None
    elements = factors or Factors(np.eye(len(matrix)), np.ones(len(matrix)), full(matrix))
    left = elements.left.T @ V
    numbers = [left.high, left.low] if left.low.any() else [left.high]
    parts, count, own = np.concatenate(numbers), len(numbers), V.shape[1]
    through = np.zeros((own + len(rows), len(parts) + len(rows)))
    through[:own, : len(parts)], through[own:, len(parts) :] = parts.T, np.eye(len(rows))
    values = np.concatenate([*[elements.values] * count, np.ones(len(rows))])
    return Factors(through, values, np.concatenate([*[elements.right] * count, rows]))


def _extended(matrix: np.ndarray | ElementMatrix) -> tuple[np.ndarray, np.ndarray]:
    """A matrix in extended precision, and the sizes of the terms of its entries."""
    if not isinstance(matrix, ElementMatrix):
        return matrix.astype(Extended), np.abs(matrix)
    B, k = matrix.directions.astype(Extended), matrix.constants
    return (B.T * k) @ B, (np.abs(matrix.directions.T) * np.abs(k)) @ np.abs(matrix.directions)
