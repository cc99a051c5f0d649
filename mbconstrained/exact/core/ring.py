"""The ring K[s] of polynomials over a field K: power series over K[x]/q, and series at infinity.

Two rings offer the same names: ``rational.rational_ring.RationalRing`` (FLINT's polynomials over the rationals) and
``symbolic.symbolic_ring.SymbolicRing`` (sympy's over rational functions of symbols).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from itertools import count
from math import comb, prod
from typing import Any, Protocol

#: An element of K, a polynomial over K (with +, -, *, **, //, %, divmod and degree(); false where it is zero), and a matrix as users
#: read it: an array of Fractions or a matrix of sympy.
Element = Any
Polynomial = Any
Matrix = Any


class PolynomialRing(Protocol):
    """K[s]: the names that both rings offer; users read exported polynomials and matrices."""

    zero: Element
    one: Element

    def polynomial(self, coefficients: Sequence[Element]) -> Polynomial: ...

    def coefficients(self, p: Polynomial, count: int) -> list[Element]: ...

    def inverse(self, p: Polynomial, modulus: Polynomial) -> Polynomial: ...

    def text(self, p: Polynomial) -> str: ...

    def exported(self, p: Polynomial) -> Any: ...

    def matrix(self, rows: Sequence[Sequence[Element]]) -> Matrix: ...

    def side_by_side(self, blocks: Sequence[Matrix]) -> Matrix: ...

    def diagonal(self, blocks: Sequence[Matrix]) -> Matrix: ...

    def below(self, blocks: Sequence[Matrix]) -> Matrix: ...


class PowerSeries:
    """A power series in h with coefficients in K[x]/q, truncated to the given coefficients.

    Args:
        ring: K[s].
        q: irreducible.
        coefficients: coefficients of 1, h, h^2, ..., polynomials modulo q.
    """

    def __init__(self, ring: PolynomialRing, q: Polynomial, coefficients: Sequence[Polynomial]):
        self.ring, self.q, self.coefficients = ring, q, list(coefficients)

    def __mul__(self, other: PowerSeries) -> PowerSeries:
        one, two, zero = self.coefficients, other.coefficients, self.ring.polynomial([])
        terms = [sum((one[i] * two[j - i] for i in range(j + 1)), zero) % self.q for j in range(len(one))]
        return PowerSeries(self.ring, self.q, terms)

    def __pow__(self, exponent: int) -> PowerSeries:
        zeros = [self.ring.polynomial([])] * (len(self.coefficients) - 1)
        return prod([self] * exponent, start=PowerSeries(self.ring, self.q, [self.ring.polynomial([self.ring.one]), *zeros]))

    @property
    def inverse(self) -> PowerSeries:
        """The reciprocal series; the first coefficient is not zero modulo q."""
        first = self.ring.inverse(self.coefficients[0], self.q)
        total = [first]
        for j in range(1, len(self.coefficients)):
            known = sum((self.coefficients[i] * total[j - i] for i in range(1, j + 1)), self.ring.polynomial([]))
            total.append(-known * first % self.q)
        return PowerSeries(self.ring, self.q, total)


def taylor(ring: PolynomialRing, e: Polynomial, q: Polynomial, length: int) -> PowerSeries:
    """e(x + h) at a zero x of an irreducible polynomial q."""
    c = ring.coefficients(e, e.degree() + 1) if e and length > 1 else []
    further = (ring.polynomial([c[n] * comb(n, j) for n in range(j, len(c))]) % q for j in range(1, length))
    return PowerSeries(ring, q, [e % q, *further])


def slopes(ring: PolynomialRing, q: Polynomial, length: int) -> PowerSeries:
    """q(x + h) / h at a zero x of an irreducible polynomial q: q'(x) + q''(x) h / 2 + ..."""
    return PowerSeries(ring, q, taylor(ring, q, q, length + 1).coefficients[1:])


def series_at_infinity(ring: PolynomialRing, numerator: Polynomial, denominator: Polynomial, highest: int) -> Iterator[Element]:
    """h_highest, h_(highest - 1), ... of numerator / denominator = sum of h_i s^i near infinity, by long division.

    d_n h_i = b_(n+i) - sum over j < n of d_j h_(n+i-j), where h_i = 0 above ``highest``.
    """
    n = denominator.degree()
    *lower, leading = ring.coefficients(denominator, n + 1)
    above = ring.coefficients(numerator, numerator.degree() + 1) if numerator else []
    known: deque = deque(maxlen=n)  # h_(i+n), ..., h_(i+1), as far as they are not zero by definition
    for i in count(highest, -1):
        total = above[n + i] if 0 <= n + i < len(above) else ring.zero
        for d, h in zip(reversed(lower), reversed(known)):
            if d and h:
                total = total - d * h
        h = total / leading
        known.append(h)
        yield h
