"""Exact answers over the rationals: floats count as exact numbers, and nothing is rounded.

First numbers and polynomials of FLINT, then a polynomial matrix: determinant, minors and the numerators of A(s)^-1 b(s) by
interpolation, since at a whole number s, A(s) is a matrix of whole numbers, where FLINT's determinant and its p-adic solver are
fast, and by Cramer's rule the degrees of the results are known before; and its root polynomials from minors.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, reduce
from itertools import count
from math import comb, gcd, lcm, prod
from numbers import Integral, Rational
from threading import RLock
from weakref import WeakKeyDictionary

import flint
import numpy as np
from scipy.linalg import block_diag

from ..ground.checks import whole_number
from ..ground.errors import SingularPolynomialMatrix
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


@Rational.register
class _InLowestTerms:
    """A rational number that Fraction accepts without computing a greatest common divisor, which is slow for long numbers."""

    def __init__(self, number: flint.fmpq):
        self.numerator, self.denominator = int(number.p), int(number.q)


def fraction(number: flint.fmpq) -> Fraction:
    return Fraction(_InLowestTerms(flint.fmpq(number)))


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


def whole_numbers() -> Iterator[int]:
    """0, 1, -1, 2, -2, ..."""
    yield 0
    for number in count(1):
        yield number
        yield -number


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
    """The nearest float64 numbers to the real roots of an irreducible p and to those above the real axis.

    A part that is zero is so exactly; one beyond the range of float64 is infinite.
    """
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
    """A(s) = A_0 + A_1 s + ... + A_q s^q with rational coefficients, r x r.

    Computations take W(s) = diag(factors) A(s), whose rows have whole coefficients without a common divisor.

    Args:
        coefficients: A_0 ... A_q as nested lists of ints, floats (the exact numbers that they are) or Fractions.
    """

    ring = RATIONALS

    def __init__(self, coefficients: Sequence):
        self.coefficients = tuple(flint.fmpq_mat([[rational(entry) for entry in row] for row in matrix]) for matrix in coefficients)
        self._minors: dict[tuple, Minor] = {}

    def __repr__(self) -> str:
        return f"RationalMatrix(degree={self.degree}, size={self.size})"

    @classmethod
    def of(cls, A: PolynomialMatrix) -> RationalMatrix:
        """The entries of A(s) as exact numbers; for a matrix given by its elements those of the elements."""
        return cls([matrix.tolist() for matrix in A.exact_coefficients])

    @property
    def size(self) -> int:
        return self.coefficients[0].nrows()

    @property
    def degree(self) -> int:
        return len(self.coefficients) - 1

    @cached_property
    def entries(self) -> list[list[flint.fmpq_poly]]:
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

    def root_polynomials(self, p: flint.fmpq_poly, multiplicity: int) -> list[RootPolynomials]:
        """Root polynomials at the zeros of p from minors, instead of the elimination of the engine.

        Elimination needs all r^2 entries of adj A modulo p^k: of random quadratic matrices of float64 the right vectors take 16 ms by minors
        and 0.21 s by elimination for r = 10, 0.07 s and 3.8 s for r = 16. The lengths are certain: root polynomials that are
        independent modulo p have exactly these orders, and the orders add up to the multiplicity.
        """
        if multiplicity == 0:
            return []
        for prime, root in rooted_primes(p.numer()):
            stages = pivots(self.whole, root, prime, multiplicity)
            terms = None if stages is None else _terms(self, p, stages)
            if terms is not None:
                return terms
        raise AssertionError("there are infinitely many primes")

    def infinite_root_polynomials(self) -> list[RootPolynomials]:
        """Root polynomials of s^max(q, 1) A(1/s) at s = 0 (Moysis et al., Eq. 11)."""
        zero = [flint.fmpq_mat(self.size, self.size)] if self.degree == 0 else []
        dual = RationalMatrix([matrix.tolist() for matrix in (*zero, *self.coefficients[::-1])])
        return dual.root_polynomials(X, self.size * dual.degree - self.determinant.degree())

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
        rows = [[p * factor for p in row] for row, factor in zip(self.entries, self.factors)]
        return [flint.fmpz_mat([[p[power].p for p in row] for row in rows]) for power in range(self.degree + 1)]

    @cached_property
    def row_degrees(self) -> list[int]:
        """The degrees of the rows, 0 for a row of zeros."""
        return [max(0, *(p.degree() for p in row)) for row in self.entries]

    def minor(self, rows: Sequence[int], columns: Sequence[int]) -> Minor:
        """A square part of W(s), created once."""
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
    """The square part P(s) of W(s) in some rows and columns, given by their ascending indices."""

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
        if not self.rows:
            return flint.fmpq_poly([1])
        samples = self._sampled(self.degree_bound + 1)
        if not samples:
            return flint.fmpq_poly([0])
        points, _, _, determinants = zip(*samples)
        return interpolated(points, flint.fmpz_mat([determinants]))[0]

    def right(self, columns: Sequence[int]) -> list[list[flint.fmpq_poly]]:
        """adj P(s) W(s)[rows, column] for each of these columns of W(s), vectors of polynomials."""
        if missing := [column for column in columns if column not in self._right]:
            solutions = self._solved(self.degree_bound + 1, len(missing), lambda _, W, P: (P, _part(W, self.rows, missing)))
            self._right.update(zip(missing, solutions))
        return [self._right[column] for column in columns]

    def left(self, columns: Sequence[int]) -> list[list[flint.fmpq_poly]]:
        """The rows of adj P(s) that belong to these columns of P(s)."""
        if missing := [column for column in columns if column not in self._left]:
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
        """adj M b for each column b, with M and b at a point from W and P there."""
        if not self.rows:
            return [[] for _ in range(count)]
        samples, values = self._sampled(points), []
        for point, W, P, determinant in samples:
            matrix, right = system(point, W, P)
            values.append([entry.p for entry in (matrix.solve(right) * determinant).entries()])
        polynomials = interpolated([sample[0] for sample in samples], flint.fmpz_mat(values).transpose())
        return [polynomials[column::count] for column in range(count)]

    def _sampled(self, count: int) -> list[tuple]:
        """(point, W there, P there, det P there) at as many points with regular P as required; none where P is always singular."""
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


def _part(matrix: flint.fmpz_mat, rows, columns) -> flint.fmpz_mat:
    if list(rows) == list(range(matrix.nrows())) and list(columns) == list(range(matrix.ncols())):
        return matrix
    return flint.fmpz_mat([[matrix[i, j] for j in columns] for i in rows])


# The equations and coordinates that make a polynomial matrix singular, decided exactly.


def regular_matrix(A: PolynomialMatrix) -> RationalMatrix:
    """The regular matrix A(s) with its entries as exact numbers."""
    if A not in _KNOWN:
        _KNOWN[A] = RationalMatrix.of(A)
    return regular(_KNOWN[A], A.equations, A.coordinates)


def regular(matrix: RationalMatrix, equations: Sequence[str], coordinates: Sequence[str]) -> RationalMatrix:
    """The matrix itself, with names of rows and columns for the error."""
    if not matrix.determinant:
        values = [matrix.whole_at(point) for point in POINTS]
        rank = max(value.rank() for value in values)
        generic = [value for value in values if value.rank() == rank]
        rows, columns = _support([value.transpose() for value in generic]), _support(generic)
        text = singular_sentence([equations[i] for i in rows], [coordinates[j] for j in columns])
        raise SingularPolynomialMatrix(text, rows, columns)
    return matrix


def _support(values: list[flint.fmpz_mat]) -> tuple[int, ...]:
    """The columns in vectors of the null spaces."""
    spaces = [value.nullspace() for value in values]
    return tuple(i for i in range(values[0].ncols()) if any(basis[i, j] for basis, nullity in spaces for j in range(nullity)))


# Root polynomials over the rationals at the zeros of an irreducible polynomial p, from minors of W(s).
#
# Over the localization of Q[s] at p, pivots of least valuation first, W(s) becomes block diagonal (block LDU): with the pivots of all
# smaller exponents in rows I and columns J, those of the exponent k add Phi S^-1 Psi to W(s)^-1,
#
#     Phi = [-W[I, J]^-1 W[I, own columns]; 1],    S^-1 Psi = the own rows of the inverse of W in I and the own rows,
#
# and all of W(s)^-1 is the sum of these. Entries are quotients of minors of W(s), so they never grow beyond those; p^k divides W Phi.

#: Root polynomials of so few coefficients are divided by one of their entries, so that chains are as simple as they can be:
#: v_0 without a polynomial in z in this place, the other vectors with a zero there. In long ones this would multiply the digits.
SHORT = 8


def _terms(W: RationalMatrix, p: flint.fmpq_poly, stages: Sequence[Pivots]) -> list[RootPolynomials] | None:
    """The terms; None for an unlucky prime number."""
    terms: list[RootPolynomials] = []
    rows: tuple[int, ...] = ()
    columns: tuple[int, ...] = ()
    order = 0
    for own in stages:
        earlier = W.minor(rows, columns)
        vectors = _right_vectors(W, p, own, earlier, order)
        if vectors is None:
            return None
        rows, columns = rows + own.rows, columns + own.columns
        following = order + own.exponent * len(own.rows)
        if own.exponent:
            block = _Block(W, p, own, earlier, W.minor(rows, columns), order, following)
            terms += [block.term(column, vector) for column, vector in zip(own.columns, vectors)]
        order = following
    return terms


def _right_vectors(W, p, own: Pivots, earlier: Minor, order: int) -> list[list[flint.fmpq_poly]] | None:
    """The columns of det(earlier minor) Phi / p^order, if p^k divides W times them and they are independent modulo p."""
    power, modulus = p**order, p**own.exponent
    unit = _quotient(earlier.determinant, power)
    if unit is None or not unit % p:
        return None
    vectors = []
    for column, solution in zip(own.columns, earlier.right(own.columns)):
        entries = [_quotient(-entry, power) for entry in solution]
        if None in entries:
            return None
        vector = _placed([*entries, unit], [*earlier.columns, column], W.size)
        if own.exponent:
            reduced = [entry % modulus for entry in vector]
            products = (sum((a * b for a, b in zip(row, reduced) if a and b), flint.fmpq_poly([0])) for row in W.entries)
            if any(product % modulus for product in products):
                return None
        vectors.append(vector)
    return vectors


@dataclass(frozen=True, eq=False)
class _Block:
    """All elementary divisors p^k of one exponent k: they contribute right @ left / (p^k unit) to W(s)^-1.

    Attributes:
        earlier, upto: the minors in the pivots of smaller exponents, and in those and the own ones; their determinants are
            divided by p^order and p^following.
    """

    W: RationalMatrix
    p: flint.fmpq_poly
    own: Pivots
    earlier: Minor
    upto: Minor
    order: int
    following: int

    def term(self, column: int, vector: Sequence[flint.fmpq_poly]) -> RootPolynomials:
        """The right vector reduced modulo p^k, its digits to the base p whole numbers without a common divisor."""
        k = self.own.exponent
        modulus, scale = self.p**k, flint.fmpq_poly([1])
        if modulus.degree() <= SHORT:
            scale = RATIONALS.inverse(vector[column], modulus)
        right = [entry * scale % modulus for entry in vector]
        content = _content([digits(RATIONALS, entry, self.p, k) for entry in right])

        def left() -> tuple[flint.fmpq_poly, ...]:
            unit = self.earlier.determinant // self.p**self.order * (self.upto.determinant // self.p**self.following)
            inverse = RATIONALS.inverse(unit * scale, modulus) * content
            power = self.p ** (self.following - k)
            row = _placed([entry // power for entry in self.upto.left([column])[0]], self.upto.rows, self.W.size)
            return tuple(entry * inverse * factor % modulus for entry, factor in zip(row, self.W.factors))

        return RootPolynomials(RATIONALS, self.p, k, tuple(entry / content for entry in right), left)


def _content(rows: Sequence[Sequence[flint.fmpq]]) -> flint.fmpq:
    """The divisor that makes entries whole numbers without a common divisor, the first one of the first column positive."""
    numbers = [number for column in zip(*rows) for number in column if number]
    denominator = lcm(*(int(number.q) for number in numbers))
    divisor = gcd(*(int((number * denominator).p) for number in numbers))
    return flint.fmpq(divisor if numbers[0] > 0 else -divisor, denominator)


def _quotient(dividend, divisor) -> flint.fmpq_poly | None:
    """The quotient; None for a nonzero remainder."""
    quotient, rest = divmod(dividend, divisor)
    return None if rest else quotient


def _placed(entries, places, size: int) -> list[flint.fmpq_poly]:
    """A vector with these entries at these indices and zeros elsewhere."""
    vector = [flint.fmpq_poly([0])] * size
    for place, entry in zip(places, entries):
        vector[place] = entry
    return vector


# The places of the pivots, by an elimination modulo a prime number.
#
# Modulo a prime at which the irreducible polynomial p has a root a, the localization of Q[s] at p becomes the power series in s - a
# over the field of that prime, and A(s) a matrix of such series. Only the places of the pivots come from here; what is
# computed with them is exact, and shows whether the prime was a lucky one.

#: Primes are tried from here on. Arithmetic modulo numbers of this size takes one word; few of them divide anything that matters.
FIRST_NUMBER = 2**61 + 1


@dataclass(frozen=True)
class Pivots:
    """Rows and columns of the pivots of one exponent: p^exponent divides all that is left, no higher power the minor of these."""

    exponent: int
    rows: tuple[int, ...]
    columns: tuple[int, ...]


def rooted_primes(p: flint.fmpz_poly) -> Iterator[tuple[int, int]]:
    """Primes with a root of p modulo each of them: by Chebotarev's theorem at least every (deg p)-th prime has one."""
    for number in count(FIRST_NUMBER, 2):
        if flint.fmpz(number).is_prime():
            reduced = flint.nmod_poly([int(c) % number for c in p.coeffs()], number)
            if reduced.degree() == p.degree() and (roots := reduced.roots()):
                yield number, min(int(root) for root, _ in roots)


def pivots(whole, root: int, prime: int, multiplicity: int) -> list[Pivots] | None:
    """The pivots by ascending exponents, least row and column indices first; None where these do not add up to the multiplicity."""
    series, missing = _taylor(whole, root, prime), multiplicity  # missing: the sum of the exponents above the present one
    rows, columns = list(range(whole[0].nrows())), list(range(whole[0].nrows()))
    stages, exponent = [], 0
    while rows:
        leading = next((k for k, matrix in enumerate(series) if matrix.rank()), missing + 1)
        exponent, series, missing = exponent + leading, series[leading:], missing - leading * len(rows)
        if missing < 0:
            return None
        own_rows, own_columns = _independent(series[0].transpose()), _independent(series[0])
        stages.append(Pivots(exponent, tuple(rows[i] for i in own_rows), tuple(columns[j] for j in own_columns)))
        other_rows, other_columns = _others(rows, own_rows), _others(columns, own_columns)
        if other_rows:
            series = _schur(series, (own_rows, other_rows), (own_columns, other_columns), missing + 1)
        rows, columns = [rows[i] for i in other_rows], [columns[j] for j in other_columns]
    return stages if missing == 0 else None


def _taylor(whole, root: int, prime: int) -> list[flint.nmod_mat]:
    """The coefficients of A(root + e) in powers of e."""
    reduced = [flint.nmod_mat(matrix, prime) for matrix in whole]
    series = []
    for order in range(len(reduced)):
        terms = [reduced[k] * flint.nmod(comb(k, order) * pow(root, k - order, prime), prime) for k in range(order, len(reduced))]
        series.append(sum(terms[1:], terms[0]))
    return series


def _independent(matrix: flint.nmod_mat) -> list[int]:
    """The columns that are independent of those before them."""
    reduced, rank = matrix.rref()
    return [next(j for j in range(reduced.ncols()) if int(reduced[i, j])) for i in range(rank)]


def _others(indices, chosen) -> list[int]:
    return [i for i in range(len(indices)) if i not in chosen]


def _schur(series, rows, columns, precision: int) -> list[flint.nmod_mat]:
    """d - c a^-1 b of the power series [[a, b], [c, d]], a invertible, up to the precision."""
    prime = series[0].modulus()

    def part(matrix, rows, columns) -> flint.nmod_mat:
        return flint.nmod_mat(len(rows), len(columns), [int(matrix[i, j]) for i in rows for j in columns], prime)

    (a, b), (c, d) = [[[part(matrix, i, j) for matrix in series] for j in columns] for i in rows]
    inverse, quotient, difference = a[0].inv(), [], []
    for order in range(precision):
        rest = _difference(b, [(a[i], quotient[order - i]) for i in range(1, min(order + 1, len(a)))], order)
        quotient.append(inverse * rest)
        difference.append(_difference(d, [(c[i], quotient[order - i]) for i in range(min(order + 1, len(c)))], order))
    return difference


def _difference(given, products, order: int) -> flint.nmod_mat:
    """The difference of the coefficient of that order and the products."""
    total = given[order] if order < len(given) else given[0] - given[0]
    for left, right in products:
        total = total - left * right
    return total
