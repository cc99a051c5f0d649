"""A polynomial matrix with rational coefficients: determinant, minors and the numerators of A(s)^-1 b(s), exactly.

All are computed by interpolation: at a whole number s, A(s) is a matrix of whole numbers, where FLINT's determinant and its p-adic
solver are fast. By Cramer's rule the results are polynomials whose degrees are known before.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, reduce
from math import gcd, prod
from weakref import WeakKeyDictionary

import flint

from ...ground.errors import SingularPolynomialMatrix
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...polynomial.structure import singular_sentence
from ..core.jordan_blocks import RootPolynomials
from .flint_numbers import common_denominator, interpolated, rational, whole_numbers
from .rational_ring import RATIONALS, X
from .rational_smith import root_polynomials

#: Whole numbers s at which the rank of A(s) is, but for a coincidence, the rank over the rational functions; the larger of the two decides.
POINTS = (2**31 - 1, 2**61 - 1)

#: The exact matrices of those for which they were computed.
_KNOWN: WeakKeyDictionary[PolynomialMatrix, RationalMatrix] = WeakKeyDictionary()


class RationalMatrix:
    """A(s) = A_0 + A_1 s + ... + A_q s^q with rational coefficients, r x r.

    Computations take W(s) = diag(factors) A(s), whose rows have whole coefficients without a common divisor.

    Args:
        coefficients: A_0 ... A_q as nested lists of ints, floats (the exact numbers that they are) or Fractions.

    >>> R = RationalMatrix([[[2, 0], [0, 1]], [[1, 0], [0, 0]]])  # diag(s + 2, 1)
    >>> R.determinant, R.numerators([flint.fmpq_poly([1]), flint.fmpq_poly([0, 1])])
    (x + 2, [1, x^2 + 2*x])
    """

    ring = RATIONALS

    def __init__(self, coefficients: Sequence):
        self.coefficients = tuple(flint.fmpq_mat([[rational(entry) for entry in row] for row in matrix]) for matrix in coefficients)
        self._minors: dict[tuple, Minor] = {}

    def __repr__(self) -> str:
        return f"RationalMatrix(degree={self.degree}, size={self.size})"

    @classmethod
    def of(cls, A: PolynomialMatrix) -> RationalMatrix:
        """The entries of A(s) as the exact numbers that they are; of a matrix given by its elements, those of the elements."""
        return cls([matrix.tolist() for matrix in A.exact_coefficients])

    @property
    def size(self) -> int:
        """r."""
        return self.coefficients[0].nrows()

    @property
    def degree(self) -> int:
        """q, as declared."""
        return len(self.coefficients) - 1

    @cached_property
    def entries(self) -> list[list[flint.fmpq_poly]]:
        """A(s) as a matrix of polynomials."""
        r = self.size
        return [[flint.fmpq_poly([matrix[i, j] for matrix in self.coefficients]) for j in range(r)] for i in range(r)]

    @cached_property
    def determinant(self) -> flint.fmpq_poly:
        """det A(s); zero where the matrix is singular for every s."""
        return self.minor(range(self.size), range(self.size)).determinant / prod(self.factors)

    @property
    def adjugate(self) -> list[list[flint.fmpq_poly]]:
        """adj A(s), so that A(s)^-1 = adj A(s) / det A(s)."""
        columns, total = range(self.size), prod(self.factors)
        rows = self.minor(columns, columns).left(columns)
        return [[p * (factor / total) for p, factor in zip(row, self.factors)] for row in rows]

    def numerators(self, b: Sequence[flint.fmpq_poly]) -> list[flint.fmpq_poly]:
        """N(s) with A(s) N(s) = det A(s) b(s), shape (r,), for a regular A(s)."""
        right = [p * factor for p, factor in zip(b, self.factors)]
        highest = max((sum(self.row_degrees) - own + p.degree() for own, p in zip(self.row_degrees, right) if p), default=-1)
        if highest < 0:
            return [flint.fmpq_poly([0])] * self.size
        scale = common_denominator(right)
        columns = [[p * scale for p in right]]
        return [p / (scale * prod(self.factors)) for p in self.minor(range(self.size), range(self.size)).solve(columns, highest)[0]]

    def root_polynomials(self, factor: tuple[flint.fmpq_poly, int]) -> list[RootPolynomials]:
        """Those at the zeros of an irreducible monic polynomial, given with its multiplicity in det A(s)."""
        return root_polynomials(self, *factor)

    def infinite_root_polynomials(self) -> list[RootPolynomials]:
        """Those of s^max(q, 1) A(1/s) at s = 0 (Moysis et al., Eq. 11)."""
        zero = [flint.fmpq_mat(self.size, self.size)] if self.degree == 0 else []
        dual = RationalMatrix([matrix.tolist() for matrix in (*zero, *self.coefficients[::-1])])
        return root_polynomials(dual, X, self.size * dual.degree - self.determinant.degree())

    @cached_property
    def factors(self) -> list[flint.fmpq]:
        """Of each row: what makes its coefficients whole numbers without a common divisor."""
        return [_primitive_factor(row) for row in self.entries]

    @cached_property
    def whole(self) -> list[flint.fmpz_mat]:
        """W_0 ... W_q, the coefficients of W(s)."""
        rows = [[p * factor for p in row] for row, factor in zip(self.entries, self.factors)]
        return [flint.fmpz_mat([[p[power].p for p in row] for row in rows]) for power in range(self.degree + 1)]

    @cached_property
    def row_degrees(self) -> list[int]:
        """The degrees of the rows, 0 for a row of zeros."""
        return [max(0, *(p.degree() for p in row)) for row in self.entries]

    def minor(self, rows: Sequence[int], columns: Sequence[int]) -> Minor:
        """A square part of W(s); each is one object."""
        key = tuple(sorted(rows)), tuple(sorted(columns))
        if key not in self._minors:
            self._minors[key] = Minor(self, *key)
        return self._minors[key]

    def whole_at(self, point: int) -> flint.fmpz_mat:
        """W at a whole number, by Horner's rule."""
        value = self.whole[-1]
        for matrix in self.whole[-2::-1]:
            value = value * point + matrix
        return value


class Minor:
    """The square part P(s) of W(s) in some rows and columns.

    Attributes:
        rows, columns: indices, ascending.
    """

    def __init__(self, W: RationalMatrix, rows: tuple[int, ...], columns: tuple[int, ...]):
        self.whole, self.rows, self.columns = W, rows, columns
        self._points, self._samples, self._singular = whole_numbers(), [], 0
        self._right: dict[int, list[flint.fmpq_poly]] = {}
        self._left: dict[int, list[flint.fmpq_poly]] = {}

    @property
    def degree_bound(self) -> int:
        """The degree that det P(s) cannot exceed."""
        return sum(self.whole.row_degrees[i] for i in self.rows)

    @cached_property
    def determinant(self) -> flint.fmpq_poly:
        """det P(s)."""
        if not self.rows:
            return flint.fmpq_poly([1])
        samples = self._sampled(self.degree_bound + 1)
        if not samples:
            return flint.fmpq_poly([0])
        points, _, _, determinants = zip(*samples)
        return interpolated(points, flint.fmpz_mat([determinants]))[0]

    def right(self, columns: Sequence[int]) -> list[list[flint.fmpq_poly]]:
        """adj P(s) W(s)[rows, column] for each of these columns of W(s), vectors of polynomials."""
        missing = [column for column in columns if column not in self._right]
        if missing:
            solutions = self._solved(self.degree_bound + 1, len(missing), lambda _, W, P: (P, _part(W, self.rows, missing)))
            self._right.update(zip(missing, solutions))
        return [self._right[column] for column in columns]

    def left(self, columns: Sequence[int]) -> list[list[flint.fmpq_poly]]:
        """The rows of adj P(s) that belong to these columns of P(s)."""
        missing = [column for column in columns if column not in self._left]
        if missing:
            places = [self.columns.index(column) for column in missing]
            unit = flint.fmpz_mat([[int(i == place) for place in places] for i in range(len(self.rows))])
            solutions = self._solved(self.degree_bound + 1, len(missing), lambda _, W, P: (P.transpose(), unit))
            self._left.update(zip(missing, solutions))
        return [self._left[column] for column in columns]

    def solve(self, columns: Sequence[Sequence[flint.fmpq_poly]], degree: int) -> list[list[flint.fmpq_poly]]:
        """adj P(s) b(s) for columns b of polynomials with whole coefficients, entries of the solution up to this degree."""

        def system(point, _, P):
            return P, flint.fmpz_mat([[b[i](flint.fmpq(point)).p for b in columns] for i in range(len(self.rows))])

        return self._solved(degree + 1, len(columns), system)

    def _solved(self, points: int, count: int, system) -> list[list[flint.fmpq_poly]]:
        """adj M b for each column b, where the system gives M and b at a point from the point, W and P there."""
        if not self.rows:
            return [[] for _ in range(count)]
        samples, values = self._sampled(points), []
        for point, W, P, determinant in samples:
            matrix, right = system(point, W, P)
            values.append([entry.p for entry in (matrix.solve(right) * determinant).entries()])
        polynomials = interpolated([sample[0] for sample in samples], flint.fmpz_mat(values).transpose())
        return [polynomials[column::count] for column in range(count)]

    def _sampled(self, count: int) -> list[tuple]:
        """(point, W there, P there, det P there) at as many points where P is regular; none where P is singular everywhere."""
        while len(self._samples) < count:
            if self._singular > self.degree_bound:
                return []
            point = next(self._points)
            W = self.whole.whole_at(point)
            P = _part(W, self.rows, self.columns)
            if determinant := P.det():
                self._samples.append((point, W, P, determinant))
            else:
                self._singular += 1
        return self._samples[:count]


def _primitive_factor(row) -> flint.fmpq:
    denominator = common_denominator(row)
    content = reduce(gcd, (int((c * denominator).p) for p in row for c in p.coeffs()), 0)
    return flint.fmpq(denominator, content or 1)


def _part(matrix: flint.fmpz_mat, rows, columns) -> flint.fmpz_mat:
    if list(rows) == list(range(matrix.nrows())) and list(columns) == list(range(matrix.ncols())):
        return matrix
    return flint.fmpz_mat([[matrix[i, j] for j in columns] for i in rows])


# The equations and coordinates that make a polynomial matrix singular, decided exactly.


def regular_matrix(A: PolynomialMatrix) -> RationalMatrix:
    """The entries of A(s) as the exact numbers that they are."""
    if A not in _KNOWN:
        _KNOWN[A] = RationalMatrix.of(A)
    return regular(_KNOWN[A], A.equations, A.coordinates)


def regular(matrix: RationalMatrix, equations: Sequence[str], coordinates: Sequence[str]) -> RationalMatrix:
    """The matrix itself, whose rows and columns have these names."""
    if not matrix.determinant:
        rows, columns = _involved(matrix)
        text = singular_sentence([equations[i] for i in rows], [coordinates[j] for j in columns])
        raise SingularPolynomialMatrix(text, rows, columns)
    return matrix


def _involved(matrix: RationalMatrix) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """The rows and columns that take part in vectors of the null spaces."""
    values = [matrix.whole_at(point) for point in POINTS]
    rank = max(value.rank() for value in values)
    generic = [value for value in values if value.rank() == rank]
    return _support([value.transpose() for value in generic]), _support(generic)


def _support(values: list[flint.fmpz_mat]) -> tuple[int, ...]:
    spaces = [value.nullspace() for value in values]
    return tuple(i for i in range(values[0].ncols()) if any(basis[i, j] for basis, nullity in spaces for j in range(nullity)))
