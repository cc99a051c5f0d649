"""A polynomial matrix with rational coefficients: its determinant and the numerators of A(s)^-1 b(s), exactly.

Both are found by interpolation: A(s) is a matrix of whole numbers at whole numbers s, where FLINT's determinant and its p-adic
solver are fast. By Cramer's rule the numerators are polynomials whose degrees are known before.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import count, islice

import flint

from ...polynomial.matrix import PolynomialMatrix
from .arithmetic import common_denominator, polynomial, rational


class RationalMatrix:
    """A(s) = A_0 + A_1 s + ... + A_q s^q with rational coefficients, r x r.

    Args:
        coefficients: A_0 ... A_q as nested lists of ints, floats (taken as they are) or Fractions.

    >>> R = RationalMatrix([[[2, 0], [0, 1]], [[1, 0], [0, 0]]])  # diag(s + 2, 1)
    >>> R.determinant, R.numerators([flint.fmpq_poly([1]), flint.fmpq_poly([0, 1])])
    (x + 2, [1, x^2 + 2*x])
    """

    def __init__(self, coefficients: Sequence):
        self.coefficients = tuple(flint.fmpq_mat([[rational(entry) for entry in row] for row in matrix]) for matrix in coefficients)

    @classmethod
    def of(cls, A: PolynomialMatrix) -> RationalMatrix:
        """The entries of A(s) taken as the exact numbers that they are; of a matrix given by its elements, of the elements."""
        return cls([matrix.tolist() for matrix in A.exact_coefficients])

    @property
    def size(self) -> int:
        """r."""
        return self.coefficients[0].nrows()

    @property
    def degree(self) -> int:
        """q, as declared."""
        return len(self.coefficients) - 1

    @property
    def dual(self) -> RationalMatrix:
        """s^q A(1/s) (Moysis et al., Eq. 11)."""
        return RationalMatrix([matrix.tolist() for matrix in self.coefficients[::-1]])

    @cached_property
    def entries(self) -> list[list[flint.fmpq_poly]]:
        """A(s) as a matrix of polynomials."""
        r = self.size
        return [[flint.fmpq_poly([matrix[i, j] for matrix in self.coefficients]) for j in range(r)] for i in range(r)]

    @cached_property
    def determinant(self) -> flint.fmpq_poly:
        """det A(s); zero where the matrix is singular for every s."""
        bound = sum(degree for degree in self._row_degrees if degree > 0)
        points = list(islice(whole_numbers(), bound + 1))
        values = flint.fmpz_mat([[self._at(point).det() for point in points]])
        return interpolated(points, values)[0] / self._factor

    def numerators(self, b: Sequence[flint.fmpq_poly]) -> list[flint.fmpq_poly]:
        """N(s) with A(s) N(s) = det A(s) b(s), shape (r,), for a regular A(s).

        Args:
            b: r polynomials.
        """
        highest = self._numerator_degree(b)
        if highest < 0:
            return [flint.fmpq_poly([0])] * self.size
        right = [p * factor for p, factor in zip(b, self._row_factors)]
        denominator = common_denominator(right)
        right, points, values = [p * denominator for p in right], [], []
        scale = self.determinant * self._factor
        for point in whole_numbers():
            value = scale(flint.fmpq(point))
            if value:
                column = flint.fmpq_mat([[p(flint.fmpq(point))] for p in right]).numer_denom()[0]
                points.append(point)
                values.append([entry * value for entry in self._at(point).solve(column).entries()])
            if len(points) == highest + 1:
                break
        total = denominator * self._factor
        table = flint.fmpq_mat(values).transpose().numer_denom()
        return [p / (total * table[1]) for p in interpolated(points, table[0])]

    @cached_property
    def _factor(self) -> flint.fmpz:
        """By how much the determinant grows where all rows are made whole."""
        total = flint.fmpz(1)
        for factor in self._row_factors:
            total *= factor
        return total

    @cached_property
    def _row_factors(self) -> list[flint.fmpz]:
        """What makes the entries of each row whole."""
        return [common_denominator(row) for row in self.entries]

    @cached_property
    def _whole(self) -> list[flint.fmpz_mat]:
        """The coefficients with rows made whole."""
        found = []
        for matrix in self.coefficients:
            rows = [[matrix[i, j] * factor for j in range(self.size)] for i, factor in enumerate(self._row_factors)]
            found.append(flint.fmpq_mat(rows).numer_denom()[0])
        return found

    @property
    def _row_degrees(self) -> list[int]:
        return [max(p.degree() for p in row) for row in self.entries]

    def _numerator_degree(self, b) -> int:
        """The largest degree that Cramer's rule allows, below 0 where all numerators vanish."""
        degrees = self._row_degrees
        return max((sum(degrees) - own + p.degree() for own, p in zip(degrees, b) if p), default=-1)

    def _at(self, point: int) -> flint.fmpz_mat:
        """The whole matrix at a whole number, by Horner's rule."""
        value = self._whole[-1]
        for matrix in self._whole[-2::-1]:
            value = value * point + matrix
        return value


def whole_numbers() -> Iterator[int]:
    """0, 1, -1, 2, -2, ..."""
    yield 0
    for number in count(1):
        yield number
        yield -number


def interpolated(points: Sequence[int], values: flint.fmpz_mat) -> list[flint.fmpq_poly]:
    """The polynomials that take the values in the rows at the points (Lagrange)."""
    everything = flint.fmpz_poly([1])
    for point in points:
        everything *= flint.fmpz_poly([-point, 1])
    basis, weights = [], []
    for point in points:
        others = everything // flint.fmpz_poly([-point, 1])
        basis.append([others[k] for k in range(len(points))])
        weights.append(others(point))
    denominator = common_denominator([polynomial([flint.fmpq(1, weight)]) for weight in weights])
    scaled = [[entry * (denominator // weight) for entry in row] for row, weight in zip(basis, weights)]
    rows = values * flint.fmpz_mat(scaled)
    return [flint.fmpq_poly(row, denominator) for row in rows.tolist()]
