"""The condition number of a problem, measured with exact arithmetic.

The data are perturbed by a relative amount h that is far above the accuracy of the exact answers and so small that only the
first order matters: condition = max |change of x| / (h max |x|). Float64 data, exact to half a unit in the last place,
determine no more than -log10(condition eps) digits for any method.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from ...exact.enclosure.exact_response import ExactResponse
from ...exact.enclosure.exact_sources import ExactSource, S, Shape
from ...exact.rational.flint_numbers import rational
from ...exact.rational.rational_matrix import RationalMatrix
from ...mechanics.element_matrix import ElementMatrix
from ...mechanics.exact_motion import with_multipliers
from ...polynomial.coefficients import Factors
from ..study_problem import StudyProblem, fractions_of, given_of, values_of

#: Number of random perturbations.
DRAWS = 8

#: Perturbations in units of h: different ones, so that ratios of data change (as in ``response.estimate``).
MOVES = (-1.0, -0.5, 0.5, 1.0)

#: h. Larger conditions than its inverse are not resolved; those of meaningful float64 data are below 1e40.
STEP = Fraction(1, 2**160)

#: Digits of the exact answers: those of h (48) and of the change where values cancel.
DIGITS = 75


def condition_of(problem: StudyProblem, exact: ExactResponse, draws: int = DRAWS) -> float:
    """max |dx| / (h max |x|) over the times, dx the largest change of x over some relative perturbations of the data by h.

    The data are the constants of the elements where a matrix is given by its elements, else its entries that are not zero
    (both of a symmetric pair alike), the entries of the constraint rows, the values at 0-, and the force: its size in each row,
    its frequencies and rates. Zeros stay; so do the values of constraint rows, and matrices whose perturbation changes the number
    of finite zeros.

    >>> from mbconstrained import PolynomialMatrix
    >>> from mbconstrained import zero
    >>> decay = StudyProblem("decay", PolynomialMatrix([[[1.0]], [[1.0]]]), np.ones((1, 1)), zero(1), np.array([8.0]))
    >>> 4 <= condition_of(decay, decay.solve().exact) <= 17  # of e^(-a t) x0: 1 + 2 a t for two entries and a start
    True
    """
    truth = values_of(exact.enclose(problem.times, DIGITS))
    largest = np.abs(truth).max(initial=Fraction(0))
    changes = [_largest_change(problem, exact, truth, seed) for seed in range(draws)]
    change = max(changes, default=Fraction(0))
    if largest == 0:
        return 0.0 if change == 0 else math.inf
    return float(change / (STEP * largest))


def _largest_change(problem, exact, truth, seed) -> Fraction:
    perturbed = _moved(problem, exact, np.random.default_rng(seed)).enclose(problem.times, DIGITS)
    return np.abs(values_of(perturbed) - truth).max(initial=Fraction(0))


def _moved(problem: StudyProblem, exact: ExactResponse, random) -> ExactResponse:
    initial = [[entry * _factor(random) for entry in row] for row in exact.initial]
    sources = _moved_sources(exact.sources, len(exact.rows), random)
    return ExactResponse(_moved_matrix(exact.matrix, _directions(problem, random)), initial, sources, exact.rows)


def _moved_matrix(matrix: RationalMatrix, directions: Sequence[np.ndarray]) -> RationalMatrix:
    """A(s) + h dA(s); coefficients that would change the number of finite zeros stay."""
    zeros = matrix.determinant.degree()
    given = [coefficient.tolist() for coefficient in matrix.coefficients]
    changed = [_sum(coefficient, direction) for coefficient, direction in zip(given, directions)]
    whole = RationalMatrix(changed)
    if whole.determinant.degree() == zeros:
        return whole
    kept = list(given)
    for power, coefficient in enumerate(changed):
        trial = [*kept[:power], coefficient, *kept[power + 1 :]]
        if RationalMatrix(trial).determinant.degree() == zeros:
            kept = trial
    return RationalMatrix(kept)


def _sum(coefficient: list[list], direction: np.ndarray) -> list[list]:
    """The perturbed coefficient."""
    entries = [list(row) for row in coefficient]
    for i, j in zip(*np.nonzero(direction)):
        entries[i][j] = entries[i][j] + rational(STEP * Fraction(direction[i, j]))
    return entries


def _directions(problem: StudyProblem, random) -> list[np.ndarray]:
    """dA_0 ... dA_q as Fractions: the coefficients with each of their data perturbed."""
    if problem.system is None:
        return [_direction(matrix, random) for matrix in given_of(problem.polynomial_matrix)]
    directions = [_direction(matrix, random) for matrix in problem.system.given]
    A = problem.system.constraint_matrix
    if not len(A):
        return directions
    moved = fractions_of(A * _moves(random, A.shape))  # rows and their forces, which are in their directions, alike
    return with_multipliers(directions, moved, [row.order for row in problem.system.rows])


def _direction(matrix, random) -> np.ndarray:
    if isinstance(matrix, ElementMatrix):
        matrix = Factors(matrix.directions.T, matrix.constants, matrix.directions)
    if isinstance(matrix, Factors):
        return replace(matrix, values=matrix.values * _moves(random, matrix.values.shape)).exact
    moves = _moves(random, matrix.shape)
    if np.array_equal(matrix, matrix.T):
        moves = np.triu(moves) + np.triu(moves, 1).T
    return fractions_of(matrix * moves)


def _moved_sources(sources: Sequence[ExactSource], rows: int, random) -> list[ExactSource]:
    """Sources with each row scaled and each function accelerated by a factor; values of constraint rows stay."""
    factors, clocks, moved = {}, {}, []
    for source in sources:
        clock = clocks.setdefault(source.shape.key[1], _factor(random))
        sizes = factors.setdefault(source.shape.key, [_factor(random) for _ in range(rows)])
        vector = (*(entry * size for entry, size in zip(source.vector, sizes)), *source.vector[rows:])
        moved.append(replace(source, vector=vector, shape=_faster(source.shape, clock)))
    return moved


def _faster(shape: Shape, clock) -> Shape:
    """g(c t), whose transform is G(s / c) / c, with scaled frequencies and rates."""
    return Shape(shape.numerator(S / clock) / clock, shape.denominator(S / clock))


def _factor(random):
    return rational(1 + STEP * Fraction(float(random.choice(MOVES))))


def _moves(random, shape) -> np.ndarray:
    return random.choice(MOVES, size=shape)
