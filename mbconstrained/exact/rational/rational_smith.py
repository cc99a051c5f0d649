"""Root polynomials over the rationals at the zeros of an irreducible polynomial p, from minors of W(s).

Over the localization of Q[s] at p, pivots of least valuation first, W(s) becomes block diagonal (block LDU): with the pivots of all
smaller exponents in rows I and columns J, those of the exponent k add Phi S^-1 Psi to W(s)^-1,

    Phi = [-W[I, J]^-1 W[I, own columns]; 1],    S^-1 Psi = the own rows of the inverse of W in I and the own rows,

and all of W(s)^-1 is the sum of these. Entries are quotients of minors of W(s), so they never grow beyond those; p^k divides W Phi.
Elimination modulo p^k as over symbolic fields (``symbolic.symbolic_smith``) would need all r^2 entries of adj A modulo p^k:
of a random 10 x 10 quadratic matrix of float64 structure and C take 14 ms by minors and 2.9 s by that elimination.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import comb, gcd, lcm
from typing import TYPE_CHECKING

import flint

from ..core.jordan_blocks import RootPolynomials, digits
from .rational_ring import RATIONALS

if TYPE_CHECKING:
    from .rational_matrix import Minor, RationalMatrix

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
    """None where the prime number was an unlucky one."""
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
    """All elementary divisors p^k of one exponent k: they add right @ left / (p^k unit) to W(s)^-1.

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
    """The divisor that makes them whole numbers without a common divisor, the first one of the first column positive."""
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
    """None where something is left over."""
    quotient, rest = divmod(dividend, divisor)
    return None if rest else quotient


def _placed(entries, places, size: int) -> list[flint.fmpq_poly]:
    """A vector with these entries in these places and zeros elsewhere."""
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
    """The columns that do not depend on those before them."""
    reduced, rank = matrix.rref()
    return [next(j for j in range(reduced.ncols()) if int(reduced[i, j])) for i in range(rank)]


def _others(indices, chosen) -> list[int]:
    return [i for i in range(len(indices)) if i not in chosen]


def _schur(series, rows, columns, precision: int) -> list[flint.nmod_mat]:
    """d - c a^-1 b of the power series [[a, b], [c, d]], a invertible, up to the precision."""
    prime = series[0].modulus()
    (a, b), (c, d) = [[[_part(matrix, i, j, prime) for matrix in series] for j in columns] for i in rows]
    inverse, quotient, difference = a[0].inv(), [], []
    for order in range(precision):
        rest = _difference(b, [(a[i], quotient[order - i]) for i in range(1, min(order + 1, len(a)))], order)
        quotient.append(inverse * rest)
        difference.append(_difference(d, [(c[i], quotient[order - i]) for i in range(min(order + 1, len(c)))], order))
    return difference


def _difference(given, products, order: int) -> flint.nmod_mat:
    """The coefficient of that order, less the products."""
    total = given[order] if order < len(given) else given[0] - given[0]
    for left, right in products:
        total = total - left * right
    return total


def _part(matrix, rows, columns, prime: int):
    entries = [int(matrix[i, j]) for i in rows for j in columns]
    return flint.nmod_mat(len(rows), len(columns), entries, prime)
