"""A polynomial matrix with rational coefficients: determinant, minors and the numerators of A(s)^-1 b(s), exactly.

All are computed by interpolation: at a whole number s, A(s) is a matrix of whole numbers, where FLINT's determinant and its p-adic
solver are fast. By Cramer's rule the results are polynomials whose degrees are known before.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from math import comb, gcd, lcm, prod
from weakref import WeakKeyDictionary

import flint

from ...ground.errors import SingularPolynomialMatrix
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...polynomial.structure import singular_sentence
from ..core.jordan_blocks import RootPolynomials, digits
from .flint_numbers import common_denominator, interpolated, rational, whole_numbers
from .rational_ring import RATIONALS, X

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
        """The entries of A(s) as exact numbers; for a matrix given by its elements those of the elements."""
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
        """Root polynomials at the zeros of an irreducible monic polynomial, given with its multiplicity in det A(s)."""
        return root_polynomials(self, *factor)

    def infinite_root_polynomials(self) -> list[RootPolynomials]:
        """Root polynomials of s^max(q, 1) A(1/s) at s = 0 (Moysis et al., Eq. 11)."""
        zero = [flint.fmpq_mat(self.size, self.size)] if self.degree == 0 else []
        dual = RationalMatrix([matrix.tolist() for matrix in (*zero, *self.coefficients[::-1])])
        return root_polynomials(dual, X, self.size * dual.degree - self.determinant.degree())

    @cached_property
    def factors(self) -> list[flint.fmpq]:
        """Factor of each row that makes its coefficients whole numbers without a common divisor."""
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
    """The regular matrix A(s) with its entries as exact numbers."""
    if A not in _KNOWN:
        _KNOWN[A] = RationalMatrix.of(A)
    return regular(_KNOWN[A], A.equations, A.coordinates)


def regular(matrix: RationalMatrix, equations: Sequence[str], coordinates: Sequence[str]) -> RationalMatrix:
    """The matrix itself, with names of rows and columns for the error."""
    if not matrix.determinant:
        rows, columns = _involved(matrix)
        text = singular_sentence([equations[i] for i in rows], [coordinates[j] for j in columns])
        raise SingularPolynomialMatrix(text, rows, columns)
    return matrix


def _involved(matrix: RationalMatrix) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """The rows and columns in vectors of the null spaces."""
    values = [matrix.whole_at(point) for point in POINTS]
    rank = max(value.rank() for value in values)
    generic = [value for value in values if value.rank() == rank]
    return _support([value.transpose() for value in generic]), _support(generic)


def _support(values: list[flint.fmpz_mat]) -> tuple[int, ...]:
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
# Elimination modulo p^k as over symbolic fields (``symbolic.symbolic_matrix``) would need all r^2 entries of adj A modulo p^k:
# of a random 10 x 10 quadratic matrix of float64 structure and C take 14 ms by minors and 2.9 s by that elimination.

#: Root polynomials of so few coefficients are divided by one of their entries, so that chains are as simple as they can be:
#: v_0 without a polynomial in z in this place, the other vectors with a zero there. In long ones this would multiply the digits.
SHORT = 8


def root_polynomials(W: RationalMatrix, p: flint.fmpq_poly, multiplicity: int) -> list[RootPolynomials]:
    """The root polynomials at the zeros of p, ascending lengths.

    The lengths are certain: root polynomials that are independent modulo p have exactly these orders, and the
    orders add up to the multiplicity.
    """
    if multiplicity == 0:
        return []
    for prime, root in rooted_primes(p.numer()):
        stages = pivots(W.whole, root, prime, multiplicity)
        terms = None if stages is None else _terms(W, p, stages)
        if terms is not None:
            return terms
    raise AssertionError("there are infinitely many primes")


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
    power = p**order
    unit = _quotient(earlier.determinant, power)
    if unit is None or not unit % p:
        return None
    vectors = []
    for column, solution in zip(own.columns, earlier.right(own.columns)):
        entries = [_quotient(-entry, power) for entry in solution]
        if None in entries:
            return None
        vector = _placed([*entries, unit], [*earlier.columns, column], W.size)
        if not _is_root_polynomial(W, vector, p**own.exponent):
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


def _is_root_polynomial(W: RationalMatrix, vector, modulus) -> bool:
    """True where p^k divides W(s) times the vector."""
    if modulus.degree() < 1:
        return True
    reduced = [entry % modulus for entry in vector]
    zero = flint.fmpq_poly([0])
    return not any(sum((a * b for a, b in zip(row, reduced) if a and b), zero) % modulus for row in W.entries)


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
    """The pivots of one exponent: p^exponent divides all that is left, and no higher power divides the minor of these.

    Attributes:
        exponent: k.
        rows, columns: indices, as many of the one as of the other.
    """

    exponent: int
    rows: tuple[int, ...]
    columns: tuple[int, ...]


def rooted_primes(p: flint.fmpz_poly) -> Iterator[tuple[int, int]]:
    """Primes with a root of p modulo each of them: by Chebotarev's theorem at least every (deg p)-th prime has one."""
    number = FIRST_NUMBER
    while True:
        if flint.fmpz(number).is_prime():
            reduced = flint.nmod_poly([int(c) % number for c in p.coeffs()], number)
            if reduced.degree() == p.degree() and (roots := reduced.roots()):
                yield number, min(int(root) for root, _ in roots)
        number += 2


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
    (a, b), (c, d) = [[[_modular_part(matrix, i, j, prime) for matrix in series] for j in columns] for i in rows]
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


def _modular_part(matrix, rows, columns, prime: int):
    entries = [int(matrix[i, j]) for i in rows for j in columns]
    return flint.nmod_mat(len(rows), len(columns), entries, prime)
