"""Which equations and coordinates make a polynomial matrix singular, decided exactly."""

from __future__ import annotations

from collections.abc import Sequence

import flint

from ...errors import SingularPolynomialMatrix
from ...polynomial.matrix import PolynomialMatrix
from ...polynomial.regularity import singular_sentence
from .matrix import RationalMatrix

#: Whole numbers s at which the rank of A(s) is the generic one but by chance; the larger of the two ranks is taken.
POINTS = (2**31 - 1, 2**61 - 1)


def regular_matrix(A: PolynomialMatrix) -> RationalMatrix:
    """The entries of A(s) taken as the exact numbers that they are.

    Raises:
        SingularPolynomialMatrix: det A(s) = 0 for every s, exactly; names the dependent equations and free coordinates.
    """
    return regular(RationalMatrix.of(A), A.equations, A.coordinates)


def regular(matrix: RationalMatrix, equations: Sequence[str], coordinates: Sequence[str]) -> RationalMatrix:
    """The matrix itself, whose rows and columns have these names.

    Raises:
        SingularPolynomialMatrix: as ``regular_matrix``.
    """
    if not matrix.determinant:
        rows, columns = _involved(matrix)
        text = singular_sentence([equations[i] for i in rows], [coordinates[j] for j in columns])
        raise SingularPolynomialMatrix(text, rows, columns)
    return matrix


def _involved(matrix: RationalMatrix) -> tuple[tuple[int, ...], tuple[int, ...]]:
    values = [_value(matrix, point) for point in POINTS]
    rank = max(value.rank() for value in values)
    generic = [value for value in values if value.rank() == rank]
    return tuple(tuple(sorted(set().union(*map(_support, side)))) for side in ([v.transpose() for v in generic], generic))


def _value(matrix: RationalMatrix, point: int) -> flint.fmpq_mat:
    total = matrix.coefficients[-1]
    for coefficient in matrix.coefficients[-2::-1]:
        total = total * point + coefficient
    return total


def _support(value: flint.fmpq_mat) -> set[int]:
    """The columns that take part in a vector of the null space."""
    reduced, rank = value.rref()
    size = value.ncols()
    pivots = [next(j for j in range(size) if reduced[i, j]) for i in range(rank)]
    free = [j for j in range(size) if j not in pivots]
    return {*free, *(pivot for i, pivot in enumerate(pivots) if any(reduced[i, j] for j in free))}
