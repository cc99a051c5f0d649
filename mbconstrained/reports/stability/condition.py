"""How well the data determine the answer: its condition, measured with exact arithmetic.

The data are moved by a relative amount h that is far above the digits of the exact answers and far below all that curves, so
that what is seen is the first order: condition = max |change of x| / (h max |x|). Float64 data, right to half a unit in the
last place, cannot determine more than -log10(condition eps) digits, whoever computes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

import numpy as np

from ...exact.enclosure import Enclosure, ExactResponse, Source
from ...exact.enclosure.shapes import S, Shape
from ...exact.rational import RationalMatrix
from ...exact.rational.arithmetic import rational
from ...mechanics import ElementMatrix
from ...mechanics.exact_motion import with_multipliers
from ...polynomial.factors import Factors
from ..problem import Problem, given_of

#: How often the data are moved, each time in another direction.
DRAWS = 8

#: In units of h: not all alike, or ratios of data would stay as they are (as in ``response.estimate``).
MOVES = (-1.0, -0.5, 0.5, 1.0)

#: h. Conditions beyond its inverse are not seen; those of float64 data that mean anything are below 1e40.
STEP = Fraction(1, 2**160)

#: Digits of the exact answers: those of h (48) and as many again as the change is wanted to, where values cancel.
DIGITS = 75


def condition_of(problem: Problem, exact: ExactResponse, draws: int = DRAWS) -> float:
    """max |dx| / (h max |x|) over the times, dx the largest change of x over a few moves of the data by h, relative to themselves.

    The data are the constants of the elements where a matrix is given by its elements, else its entries that are not zero
    (both of a symmetric pair alike), the entries of the constraint rows, the values at 0-, and the force: its size in each row,
    its frequencies and rates. Zeros stay; so do the values of constraint rows, and matrices that have another number of finite
    zeros when moved.

    Args:
        problem: with its times.
        exact: its exact answer.
        draws: how often the data are moved.

    >>> from ...polynomial import PolynomialMatrix
    >>> from ...signals import zero
    >>> decay = Problem("decay", PolynomialMatrix([[[1.0]], [[1.0]]]), np.ones((1, 1)), zero(1), np.array([8.0]))
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


def values_of(box: Enclosure) -> np.ndarray:
    """The middles of the intervals as Fractions, of the shape of x."""
    ends = (_fractions_of(bounds) for bounds in (box.lower, box.upper))
    return sum(ends) / 2


def _largest_change(problem, exact, truth, seed) -> Fraction:
    found = _moved(problem, exact, np.random.default_rng(seed)).enclose(problem.times, DIGITS)
    return np.abs(values_of(found) - truth).max(initial=Fraction(0))


def _moved(problem: Problem, exact: ExactResponse, random) -> ExactResponse:
    initial = [[entry * _factor(random) for entry in row] for row in exact.initial]
    sources = _moved_sources(exact.sources, len(exact.rows), random)
    return ExactResponse(_moved_matrix(exact.matrix, _directions(problem, random)), initial, sources, exact.rows)


def _moved_matrix(matrix: RationalMatrix, directions: Sequence[np.ndarray]) -> RationalMatrix:
    """A(s) + h dA(s); where that has another number of finite zeros, of each coefficient only if it has not."""
    zeros = matrix.determinant.degree()
    given = [coefficient.tolist() for coefficient in matrix.coefficients]
    changed = [_sum(coefficient, direction) for coefficient, direction in zip(given, directions)]
    whole = RationalMatrix(changed)
    if whole.determinant.degree() == zeros:
        return whole
    found = list(given)
    for power, coefficient in enumerate(changed):
        trial = [*found[:power], coefficient, *found[power + 1 :]]
        if RationalMatrix(trial).determinant.degree() == zeros:
            found = trial
    return RationalMatrix(found)


def _sum(coefficient: list[list], direction: np.ndarray) -> list[list]:
    """The coefficient, moved."""
    found = [list(row) for row in coefficient]
    for i, j in zip(*np.nonzero(direction)):
        found[i][j] = found[i][j] + rational(STEP * Fraction(direction[i, j]))
    return found


def _directions(problem: Problem, random) -> list[np.ndarray]:
    """dA_0 ... dA_q as Fractions: the coefficients, each of their data times its move."""
    if problem.system is None:
        return [_direction(matrix, random) for matrix in given_of(problem.polynomial_matrix)]
    found = [_direction(matrix, random) for matrix in problem.system.given]
    A = problem.system.constraint_matrix
    if not len(A):
        return found
    moved = _fractions_of(A * _moves(random, A.shape))  # rows and their forces, which are in their directions, alike
    return with_multipliers(found, moved, [row.order for row in problem.system.rows])


def _direction(matrix, random) -> np.ndarray:
    if isinstance(matrix, ElementMatrix):
        matrix = Factors(matrix.directions.T, matrix.constants, matrix.directions)
    if isinstance(matrix, Factors):
        return replace(matrix, values=matrix.values * _moves(random, matrix.values.shape)).exact
    moves = _moves(random, matrix.shape)
    if np.array_equal(matrix, matrix.T):
        moves = np.triu(moves) + np.triu(moves, 1).T
    return _fractions_of(matrix * moves)


def _moved_sources(sources: Sequence[Source], rows: int, random) -> list[Source]:
    """Each row of each function of time by a factor, and each function faster by a factor; values of constraint rows stay."""
    factors, clocks, found = {}, {}, []
    for source in sources:
        clock = clocks.setdefault(source.shape.key[1], _factor(random))
        sizes = factors.setdefault(source.shape.key, [_factor(random) for _ in range(rows)])
        vector = (*(entry * size for entry, size in zip(source.vector, sizes)), *source.vector[rows:])
        found.append(replace(source, vector=vector, shape=_faster(source.shape, clock)))
    return found


def _faster(shape: Shape, clock) -> Shape:
    """g(c t), whose transform is G(s / c) / c: what has a frequency or a rate has another one."""
    return Shape(shape.numerator(S / clock) / clock, shape.denominator(S / clock))


def _factor(random):
    return rational(1 + STEP * Fraction(float(random.choice(MOVES))))


def _moves(random, shape) -> np.ndarray:
    return random.choice(MOVES, size=shape)


def _fractions_of(array: np.ndarray) -> np.ndarray:
    """Floats, or decimal strings, as the exact numbers that they are."""
    found = np.empty(array.shape, dtype=object)
    for place, value in np.ndenumerate(array):
        found[place] = Fraction(Decimal(value)) if isinstance(value, str) else Fraction(float(value))
    return found
