"""Minors of A(s) as polynomials: A(s)^-1 of a square part of A, with its determinant for the denominator.

Everything is found by interpolation, see ``matrix``: at a whole number the part is a matrix of whole numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, reduce
from math import gcd

import flint

from .arithmetic import common_denominator
from .matrix import RationalMatrix, interpolated, whole_numbers


class WholeMatrix:
    """W(s) = diag(factors) A(s), its rows made whole and primitive; A(s)^-1 = W(s)^-1 diag(factors).

    Attributes:
        coefficients: W_0 ... W_q, matrices of whole numbers.
        factors: r rational numbers.
        row_degrees: the degrees of the rows of W(s).
    """

    def __init__(self, coefficients: Sequence[flint.fmpz_mat], factors: Sequence[flint.fmpq]):
        self.coefficients, self.factors = list(coefficients), factors
        self.row_degrees = [_degree_of_row(coefficients, row) for row in range(self.size)]
        self._parts: dict[tuple, Part] = {}

    @classmethod
    def of(cls, R: RationalMatrix) -> WholeMatrix:
        """Without a row of zeros."""
        factors = [_primitive_factor(row) for row in R.entries]
        rows = [[p * factor for p in row] for row, factor in zip(R.entries, factors)]
        return cls([flint.fmpz_mat([[p[power].p for p in row] for row in rows]) for power in range(R.degree + 1)], factors)

    @property
    def dual(self) -> WholeMatrix:
        """s^q W(1/s)."""
        return WholeMatrix(self.coefficients[::-1], self.factors)

    @property
    def size(self) -> int:
        """r."""
        return self.coefficients[0].nrows()

    def part(self, rows: Sequence[int], columns: Sequence[int]) -> Part:
        """The part of W(s) in these rows and columns; one for all who ask."""
        key = tuple(sorted(rows)), tuple(sorted(columns))
        if key not in self._parts:
            self._parts[key] = Part(self, *key)
        return self._parts[key]


class Part:
    """The regular part P(s) of W(s) in some rows and columns, as many of the one as of the other.

    Attributes:
        rows, columns: indices, ascending.
    """

    def __init__(self, W: WholeMatrix, rows: tuple[int, ...], columns: tuple[int, ...]):
        self.whole, self.rows, self.columns = W, rows, columns
        self._right: dict[int, list[flint.fmpq_poly]] = {}
        self._left: dict[int, list[flint.fmpq_poly]] = {}

    @cached_property
    def determinant(self) -> flint.fmpq_poly:
        """det P(s)."""
        if not self.rows:
            return flint.fmpq_poly([1])
        return interpolated(self._points, flint.fmpz_mat([self._determinants]))[0]

    def right(self, columns: Sequence[int]) -> list[list[flint.fmpq_poly]]:
        """adj P(s) W(s)[rows, column] for every one of these columns of W(s), vectors of polynomials."""
        missing = [column for column in columns if column not in self._right]
        if missing:
            given = [_taken(value, self.rows, missing) for value in self._values]
            self._right.update(zip(missing, self._solved(self._matrices, given, len(missing))))
        return [self._right[column] for column in columns]

    def left(self, columns: Sequence[int]) -> list[list[flint.fmpq_poly]]:
        """The rows of adj P(s) that belong to these columns of P(s)."""
        missing = [column for column in columns if column not in self._left]
        if missing:
            places = [self.columns.index(column) for column in missing]
            unit = flint.fmpz_mat([[int(i == place) for place in places] for i in range(len(self.rows))])
            transposed = [matrix.transpose() for matrix in self._matrices]
            self._left.update(zip(missing, self._solved(transposed, [unit] * len(transposed), len(missing))))
        return [self._left[column] for column in columns]

    def _solved(self, matrices, right, count: int) -> list[list[flint.fmpq_poly]]:
        """adj P(s) b(s) of every column b of what stands on the right at the points."""
        if not self.rows:
            return [[] for _ in range(count)]
        values = [(matrix.solve(b) * value).entries() for matrix, b, value in zip(matrices, right, self._determinants)]
        table = flint.fmpz_mat([[entry.p for entry in row] for row in values]).transpose()
        polynomials = interpolated(self._points, table)
        return [polynomials[column::count] for column in range(count)]

    @cached_property
    def _samples(self) -> list[tuple]:
        """(point, W there, P there, det P there) at as many points as Cramer's rule needs, where P is not singular."""
        found, enough = [], sum(self.whole.row_degrees[i] for i in self.rows) + 1
        for point in whole_numbers():
            value = _at(self.whole.coefficients, point)
            matrix = _taken(value, self.rows, self.columns)
            if determinant := matrix.det():
                found.append((point, value, matrix, determinant))
            if len(found) == enough:
                return found

    @property
    def _points(self):
        return [sample[0] for sample in self._samples]

    @property
    def _values(self):
        return [sample[1] for sample in self._samples] if self.rows else []

    @property
    def _matrices(self):
        return [sample[2] for sample in self._samples] if self.rows else []

    @property
    def _determinants(self):
        return [sample[3] for sample in self._samples]


def _primitive_factor(row) -> flint.fmpq:
    """What makes the coefficients of a row of polynomials whole numbers without a common divisor."""
    denominator = common_denominator(row)
    content = reduce(gcd, (int((c * denominator).p) for p in row for c in p.coeffs()), 0)
    return flint.fmpq(denominator, content)


def _degree_of_row(coefficients, row: int) -> int:
    return max(power for power, matrix in enumerate(coefficients) if any(matrix[row, j] for j in range(matrix.ncols())))


def _at(coefficients, point: int) -> flint.fmpz_mat:
    """The matrix at a whole number, by Horner's rule."""
    value = coefficients[-1]
    for matrix in coefficients[-2::-1]:
        value = value * point + matrix
    return value


def _taken(matrix, rows, columns) -> flint.fmpz_mat:
    return flint.fmpz_mat([[matrix[i, j] for j in columns] for i in rows])
