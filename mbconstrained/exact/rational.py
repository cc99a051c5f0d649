"""Exact answers over the rationals: floats count as exact numbers, and nothing is rounded.

First numbers and polynomials of FLINT, then a polynomial matrix: determinant and numerators of A(s)^-1 b(s) by
interpolation, since at a whole number s, A(s) is a matrix of whole numbers, where FLINT's determinant and its p-adic solver are
fast, and by Cramer's rule the degrees of the results are known before.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from fractions import Fraction
from functools import cached_property, reduce
from itertools import count
from math import gcd, lcm, prod
from numbers import Integral, Rational
from threading import RLock
from weakref import WeakKeyDictionary

import flint
import numpy as np

from ..ground.checks import whole_number
from ..ground.errors import SingularPolynomialMatrix
from ..linalg.arrays import block_diag
from ..polynomial.jordan_pairs import in_order
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..polynomial.structure import FiniteZero, polynomial_text, singular_sentence
from .engine import ExactMatrix, JordanChain, RootPolynomials, digits

#: The working precision of FLINT belongs to the whole process.
_PRECISION = RLock()

#: In bits: where roots are computed first, and where a real or imaginary part that still cannot be distinguished from the middle of
#: two float64 neighbours counts as this middle.
FIRST_PRECISION, LAST_PRECISION = 64, 2**14


@contextmanager
def working_precision(bits: int) -> Iterator[None]:
    """A context with a precision of balls, for one thread at a time; afterwards the previous precision is restored."""
    with _PRECISION, flint.ctx.workprec(bits):
        yield


def rational(number) -> flint.fmpq:
    """The exact value of an int, a float, a Fraction, a Decimal or a number of FLINT."""
    if isinstance(number, (flint.fmpq, flint.fmpz)):
        return flint.fmpq(number)
    if isinstance(number, float):
        return flint.fmpq(*number.as_integer_ratio())
    exact = Fraction(int(number)) if isinstance(number, Integral) else Fraction(number)
    return flint.fmpq(exact.numerator, exact.denominator)


def rational_matrix(array: np.ndarray) -> flint.fmpq_mat:
    """The exact numbers of a matrix."""
    return flint.fmpq_mat(*array.shape, [rational(entry) for entry in array.ravel().tolist()])


def pivots(reduced: flint.fmpq_mat | flint.fmpz_mat, rank: int) -> list[int]:
    """The pivot columns of a reduced row echelon form."""
    return [next(column for column in range(reduced.ncols()) if reduced[row, column]) for row in range(rank)]


@Rational.register
class _InLowestTerms:
    """A rational number that Fraction accepts without computing a greatest common divisor, which is slow for long numbers."""

    def __init__(self, number: flint.fmpq):
        self.numerator, self.denominator = int(number.p), int(number.q)


def fraction(number: flint.fmpq) -> Fraction:
    return Fraction(_InLowestTerms(flint.fmpq(number)))


def value_at(matrices: Sequence, s):
    """A_0 + A_1 s + ... by Horner's rule."""
    *lower, value = matrices
    for matrix in reversed(lower):
        value = value * s + matrix
    return value


def polynomial(coefficients: Iterable) -> flint.fmpq_poly:
    """The polynomial with these coefficients, the lowest power first."""
    return flint.fmpq_poly([rational(number) for number in coefficients])


def fractions_of(p: flint.fmpq_poly) -> tuple[Fraction, ...]:
    """The coefficients of a polynomial, the lowest power first; () for zero."""
    return tuple(fraction(number) for number in p.coeffs())


def common_denominator(polynomials: Iterable[flint.fmpq_poly]) -> flint.fmpz:
    """The least whole number that makes all coefficients whole."""
    return flint.fmpz(reduce(lcm, (int(p.denom()) for p in polynomials), 1))


def exact_value(number: flint.arb) -> Fraction:
    """The value of a ball without a radius."""
    mantissa, exponent = number.man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def interpolated(points: Sequence[int], values: flint.fmpz_mat) -> list[flint.fmpq_poly]:
    """The polynomials that take the values in the rows at the points (Lagrange)."""
    vanishing = flint.fmpz_poly([1])
    for point in points:
        vanishing *= flint.fmpz_poly([-point, 1])
    basis, weights = [], []
    for point in points:
        others = vanishing // flint.fmpz_poly([-point, 1])
        basis.append([others[k] for k in range(len(points))])
        weights.append(others(point))
    denominator = reduce(lcm, map(int, weights), 1)
    scaled = [[entry * (denominator // weight) for entry in row] for row, weight in zip(basis, weights)]
    return [flint.fmpq_poly(row, denominator) for row in (values * flint.fmpz_mat(scaled)).tolist()]


def rounded_roots(p: flint.fmpz_poly) -> tuple[complex, ...]:
    """The nearest float64 numbers to the real roots of an irreducible p and to those above the real axis; a zero part is exact, one too large infinite."""
    if p.degree() == 1:
        return (complex(_float(-fraction(flint.fmpq(p[0], p[1])))),)
    precision = FIRST_PRECISION
    while True:
        parts = [(_rounded(z.real, precision), _rounded(z.imag, precision)) for z in enclosed_roots(p, precision)]
        if all(part is not None for pair in parts for part in pair):
            return tuple(complex(*pair) for pair in parts if pair[1] >= 0)
        precision *= 2


def enclosed_roots(p: flint.fmpz_poly, precision: int) -> list[flint.acb]:
    """Balls around all roots of an irreducible p; real and imaginary parts that are zero are exactly so."""
    even = p.degree() > 1 and not any(p[k] for k in range(1, p.degree() + 1, 2))
    with working_precision(precision):
        if not even:
            return [root for root, _ in p.complex_roots()]  # type: ignore[has-type]
        squares = [root for root, _ in flint.fmpz_poly(p.coeffs()[::2]).complex_roots()]  # type: ignore[has-type]
        return [root for half in (square.sqrt() for square in squares) for root in (half, -half)]  # exactly imaginary where it is


def _rounded(ball: flint.arb, precision: int) -> float | None:
    """The float64 number nearest to every number in the ball; None where there are two."""
    middle, radius = exact_value(ball.mid()), exact_value(ball.rad())
    if 2 * precision > LAST_PRECISION:
        return _float(middle)
    low, high = _float(middle - radius), _float(middle + radius)
    return low if low == high else None


def _float(number: Fraction) -> float:
    try:
        return float(number)
    except OverflowError:
        return float("inf") if number > 0 else float("-inf")


# The polynomials over the rationals as the engine takes them, shown to users as Fractions.

#: A longer polynomial is not written out in a representation.
LONGEST_TEXT = 60

#: Bits for a decimal digit.
BITS_PER_DIGIT = 3.33

#: The polynomial s.
X = flint.fmpq_poly([0, 1])


class RationalChain(JordanChain):
    """A ``JordanChain`` with its values at the zeros enclosed in balls."""

    def at(self, digits: int = 15) -> tuple[tuple[flint.acb, np.ndarray], ...]:
        """Pairs of a zero and its v_0 ... v_(k-1), shape (k, r), for all zeros of p: balls that contain the true values.

        ``complex`` turns a ball into a number.
        """
        target, precision = flint.arb(10) ** -whole_number(digits, "digits", minimum=1), int(BITS_PER_DIGIT * digits) + 32

        def is_narrow(balls) -> bool:
            largest = max((abs(ball).abs_lower() for ball in balls), default=flint.arb(0))
            return all(ball.rad() <= target * largest for ball in balls)

        while True:
            roots = enclosed_roots(self.term.divisor.numer(), precision)
            with working_precision(precision):
                vectors = [[flint.acb_poly(p) for p in vector] for vector in self.right]
                values = tuple((z, np.array([[p(z) for p in vector] for vector in vectors], dtype=object)) for z in roots)
            if all(is_narrow([root]) and all(map(is_narrow, vectors)) for root, vectors in values):
                return values
            precision *= 2


class RationalRing:
    """Q[s]: ``fmpq_poly`` for polynomials and arrays of Fractions for matrices."""

    zero, one = flint.fmpq(0), flint.fmpq(1)
    exported, chain = staticmethod(fractions_of), RationalChain

    def polynomial(self, coefficients: Sequence) -> flint.fmpq_poly:
        return flint.fmpq_poly(list(coefficients))

    def coefficients(self, p: flint.fmpq_poly, count: int) -> list[flint.fmpq]:
        return [p[k] for k in range(count)]

    def inverse(self, p: flint.fmpq_poly, modulus: flint.fmpq_poly) -> flint.fmpq_poly:
        _, inverse, _ = (p % modulus).xgcd(modulus)
        return inverse

    def factors(self, p: flint.fmpq_poly) -> list[tuple[flint.fmpq_poly, int]]:
        monic = [(flint.fmpq_poly(q) / q[q.degree()], multiplicity) for q, multiplicity in p.numer().factor()[1]]
        return sorted(monic, key=lambda factor: (factor[0].degree(), fractions_of(factor[0])))

    def weight(self, p: flint.fmpq_poly) -> int:
        return p.numer().height_bits()

    def text(self, p: flint.fmpq_poly) -> str:
        text = polynomial_text(fractions_of(p))
        return text if len(text) <= LONGEST_TEXT else f"degree {p.degree()}"

    def matrix(self, rows: Sequence[Sequence]) -> np.ndarray:
        entries = [[fraction(entry) for entry in row] for row in rows]
        return np.array(entries, dtype=object).reshape(len(rows), len(rows[0]) if rows else 0)

    def joined(self, matrices: Sequence[np.ndarray], axis: int) -> np.ndarray:
        return np.concatenate(matrices, axis)

    def diagonal(self, matrices: Sequence[np.ndarray]) -> np.ndarray:
        return block_diag(*matrices) + Fraction(0)

    def finite_zeros(self, divisors) -> tuple[FiniteZero, ...]:
        """The nearest float64 numbers, in the order of the numeric engine."""
        return in_order([FiniteZero(z, m, exponents) for p, m, exponents in divisors for z in rounded_roots(p.numer())])


RATIONALS = RationalRing()

#: Whole numbers s at which the rank of A(s) is, but for a coincidence, the rank over the rational functions; the larger of the two decides.
POINTS = (2**31 - 1, 2**61 - 1)

#: The exact matrices of those for which they were computed.
_KNOWN: WeakKeyDictionary[PolynomialMatrix, RationalMatrix] = WeakKeyDictionary()


class RationalMatrix(ExactMatrix):
    """A(s) = A_0 + A_1 s + ... + A_q s^q with rational coefficients, r x r; other shapes have kernels only (``exact.kernels``).

    Computations take W(s) = diag(factors) A(s), whose rows have whole coefficients without a common divisor.

    Args:
        coefficients: A_0 ... A_q as matrices of FLINT, or as arrays or nested lists of ints, floats (the exact numbers that they are) or
            Fractions.
    """

    ring = RATIONALS

    def __init__(self, coefficients: Sequence | np.ndarray):
        self.coefficients = tuple(
            matrix if isinstance(matrix, flint.fmpq_mat) else rational_matrix(np.array(matrix, dtype=object))
            for matrix in coefficients
        )
        self.size = self.coefficients[0].nrows()
        self._points = (sign * number for number in count() for sign in (1, -1)[: number + 1])  # 0, 1, -1, 2, -2, ...
        self._samples, self._singular = [], 0

    def __repr__(self) -> str:
        return f"RationalMatrix(degree={self.degree}, size={self.size})"

    @cached_property
    def entries(self) -> list[list[flint.fmpq_poly]]:
        columns = range(self.coefficients[0].ncols())
        return [[flint.fmpq_poly([matrix[i, j] for matrix in self.coefficients]) for j in columns] for i in range(self.size)]

    @cached_property
    def determinant(self) -> flint.fmpq_poly:
        """det A(s); zero where the matrix is singular for every s."""
        samples = self._sampled(sum(self.row_degrees) + 1)
        if not samples:
            return flint.fmpq_poly([0])
        points, _, determinants = zip(*samples)
        return interpolated(points, flint.fmpz_mat([determinants]))[0] / prod(self.factors)

    @cached_property
    def adjugate(self) -> list[list[flint.fmpq_poly]]:
        """adj A(s), so that A(s)^-1 = adj A(s) / det A(s)."""
        columns = self._solved([self._unit(j) for j in range(self.size)])
        return [[column[i] for column in columns] for i in range(self.size)]

    @cached_property
    def transposed(self) -> RationalMatrix:
        return RationalMatrix([matrix.transpose() for matrix in self.coefficients])

    def numerators(self, b: Sequence[flint.fmpq_poly]) -> list[flint.fmpq_poly]:
        """N(s) with A(s) N(s) = det A(s) b(s), shape (r,), for a regular A(s)."""
        return self._solved([b])[0]

    def _solved(self, columns: Sequence[Sequence[flint.fmpq_poly]]) -> list[list[flint.fmpq_poly]]:
        """adj A(s) b(s) for columns b, interpolated from its values; by Cramer's rule its degree is known before."""
        right = [[p * factor for p, factor in zip(b, self.factors)] for b in columns]
        total = sum(self.row_degrees)
        highest = max((total - own + p.degree() for b in right for own, p in zip(self.row_degrees, b) if p), default=-1)
        if highest < 0:
            return [[flint.fmpq_poly([0])] * self.size for _ in columns]
        scale, values = common_denominator([p for b in right for p in b]), []
        whole, samples = [[p * scale for p in b] for b in right], self._sampled(highest + 1)
        for point, W, determinant in samples:
            there = flint.fmpz_mat([[b[i](flint.fmpq(point)).p for b in whole] for i in range(self.size)])
            values.append([entry.p for entry in (W.solve(there) * determinant).entries()])
        divisor = scale * prod(self.factors)
        solved = [p / divisor for p in interpolated([point for point, *_ in samples], flint.fmpz_mat(values).transpose())]
        return [solved[place :: len(columns)] for place in range(len(columns))]

    def _unit(self, place: int) -> list[flint.fmpq_poly]:
        return [flint.fmpq_poly([int(i == place)]) for i in range(self.size)]

    def root_polynomials(self, p: flint.fmpq_poly, multiplicity: int) -> list[RootPolynomials]:
        """Root polynomials at the zeros of p, the digits of each right vector to the base p whole numbers without a common divisor.

        Modulo a simple factor p, adj A has the rank 1: one column and one row of it serve, which of random quadratic matrices of
        float64 take 0.04 s for r = 16, and the whole adjugate 0.2 s.
        """
        terms = [self._of_simple(p)] if multiplicity == 1 else super().root_polynomials(p, multiplicity)
        return [_whole(term) for term in terms]

    def _of_simple(self, p: flint.fmpq_poly) -> RootPolynomials:
        columns = ([entry % p for entry in self.numerators(self._unit(j))] for j in reversed(range(self.size)))
        right = next(filter(any, columns))
        place = next(i for i in reversed(range(self.size)) if right[i])
        pivot, is_short = right[place], p.degree() <= SHORT
        if is_short:
            right = [entry * RATIONALS.inverse(pivot, p) % p for entry in right]

        def left() -> tuple[flint.fmpq_poly, ...]:
            others = self.determinant // p * (flint.fmpq_poly([1]) if is_short else pivot) % p
            inverse = RATIONALS.inverse(others, p)
            return tuple(entry * inverse % p for entry in self.transposed.numerators(self._unit(place)))

        return RootPolynomials(RATIONALS, p, 1, tuple(right), left)

    @cached_property
    def factors(self) -> list[flint.fmpq]:
        """Factor of each row that makes its coefficients whole numbers without a common divisor."""
        factors = []
        for row in self.entries:
            denominator = common_denominator(row)
            content = reduce(gcd, (int((c * denominator).p) for p in row for c in p.coeffs()), 0)
            factors.append(flint.fmpq(denominator, content or 1))
        return factors

    @cached_property
    def whole(self) -> list[flint.fmpz_mat]:
        """W_0 ... W_q, the coefficients of W(s)."""
        entries = [p * factor for row, factor in zip(self.entries, self.factors) for p in row]
        shape = self.size, self.coefficients[0].ncols()
        return [flint.fmpz_mat(*shape, [p[power].p for p in entries]) for power in range(self.degree + 1)]

    @cached_property
    def row_degrees(self) -> list[int]:
        """The degrees of the rows, 0 for a row of zeros."""
        return [max([0, *(p.degree() for p in row)]) for row in self.entries]

    @cached_property
    def rank(self) -> int:
        """The rank of A(s) at all s but its zeros, that at some large whole numbers."""
        return max(self.whole_at(point).rank() for point in POINTS)

    def whole_at(self, point: int) -> flint.fmpz_mat:
        """W at a whole number."""
        return value_at(self.whole, point)

    def _sampled(self, count: int) -> list[tuple]:
        """(point, W there, det W there) at as many points with a regular W as required; none where W is always singular."""
        while len(self._samples) < count:
            if self._singular > sum(self.row_degrees):
                return []
            W = self.whole_at(point := next(self._points))
            if determinant := W.det():
                self._samples.append((point, W, determinant))
            else:
                self._singular += 1
        return self._samples[:count]


# The equations and coordinates that make a polynomial matrix singular, decided exactly.


def regular_matrix(A: PolynomialMatrix) -> RationalMatrix:
    """The regular matrix A(s) with its entries as exact numbers."""
    A.check_square()
    return regular(known_matrix(A), A.equations, A.coordinates)


def known_matrix(A: PolynomialMatrix) -> RationalMatrix:
    """A(s) with its entries as exact numbers, for a matrix given by its elements those of the elements; converted once."""
    if A not in _KNOWN:
        _KNOWN[A] = RationalMatrix(A.exact_coefficients)
    return _KNOWN[A]


def regular(matrix: RationalMatrix, equations: Sequence[str], coordinates: Sequence[str]) -> RationalMatrix:
    """The matrix itself, with names of rows and columns for the error."""
    if not matrix.determinant:
        values = [matrix.whole_at(point) for point in POINTS]
        generic = [value for value in values if value.rank() == matrix.rank]
        rows, columns = _support([value.transpose() for value in generic]), _support(generic)
        text = singular_sentence([equations[i] for i in rows], [coordinates[j] for j in columns])
        raise SingularPolynomialMatrix(text, rows, columns)
    return matrix


def _support(values: list[flint.fmpz_mat]) -> tuple[int, ...]:
    """The columns in vectors of the null spaces."""
    spaces = [value.nullspace() for value in values]
    return tuple(i for i in range(values[0].ncols()) if any(basis[i, j] for basis, nullity in spaces for j in range(nullity)))


# Root polynomials with short coefficients.

#: Root polynomials of so few coefficients are divided by one of their entries, so that chains are as simple as they can be:
#: v_0 without a polynomial in z in this place, the other vectors with a zero there. In long ones this would multiply the digits.
SHORT = 8


def _whole(term: RootPolynomials) -> RootPolynomials:
    """The term with digits of the right vector that are whole numbers without a common divisor, the first one positive."""
    rows = [digits(RATIONALS, entry, term.divisor, term.length) for entry in term.right]
    numbers = [number for column in zip(*rows) for number in column if number]
    denominator = lcm(*(int(number.q) for number in numbers))
    whole = gcd(*(int((number * denominator).p) for number in numbers))
    content = flint.fmpq(whole if numbers[0] > 0 else -whole, denominator)
    right = tuple(entry / content for entry in term.right)
    return replace(term, right=right, compute_left=lambda: tuple(entry * content for entry in term.left))
