"""Values of polynomials at the zeros of a quadratic over K(sqrt(g)): linear in one square root, and in sqrt(g)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, reduce

import sympy
from sympy.polys.domains import Domain

from .factoring import coefficients
from .surds import Surd


class Quadratic:
    """s^2 + a s + b, with zeros x = middle + y, y^2 = -square.

    Attributes:
        b: its last coefficient.
        middle, square: -a/2 and b - a^2/4.
    """

    def __init__(self, a: Surd, b: Surd):
        one = a.field.one
        self.b, self.middle = b, a * a.of(-one / (one + one))
        self.square = b - self.middle * self.middle
        self._powers = [(a.of(one), a.of(a.field.zero), a.of(a.field.zero))]
        self._values: dict[sympy.Poly, tuple[Surd, Surd, Surd]] = {}

    @cached_property
    def conjugate(self) -> Quadratic:
        """The same with -sqrt(g) for sqrt(g); what one has found, the other knows."""
        other = Quadratic(-(self.middle + self.middle).conjugate, self.b.conjugate)
        other.value = lambda c: tuple(part.conjugate for part in self.value(c))
        return other

    def value(self, c: sympy.Poly) -> tuple[Surd, Surd, Surd]:
        """e, o and o square with c(x) = e + o y, by the powers of x: each is found once, and c is linear in them."""
        if c not in self._values:
            factors = coefficients(c, max(1, len(c.rep.to_list())))
            self._values[c] = tuple(self._combined(factors, powers) for powers in zip(*self._powers_below(len(factors))))
        return self._values[c]

    def _powers_below(self, count: int) -> list[tuple[Surd, Surd, Surd]]:
        """1, x, x^2, ... as such sums."""
        while len(self._powers) < count:
            even, odd, turned = self._powers[-1]
            following = even + odd * self.middle
            self._powers.append((even * self.middle - turned, following, following * self.square))
        return self._powers[:count]

    def _combined(self, factors, powers) -> Surd:
        field = self.middle.field
        parts = (combination(field, factors, [getattr(power, name) for power in powers]) for name in "uv")
        return Surd(field, *parts, self.middle.g)


def combination(field: Domain, ones: Sequence, others: Sequence):
    """The sum of the products of elements; fractions are brought over one denominator and cancelled once, at the end.

    >>> k = sympy.Symbol("k")
    >>> K = sympy.ZZ.frac_field(k)
    >>> combination(K, [K(1), K(2)], [1 / K(k), K(k)])
    (2*k**2 + 1)/k
    """
    pairs = [(one, other) for one, other in zip(ones, others, strict=True) if one and other]
    if not field.is_FractionField:
        return sum((one * other for one, other in pairs), field.zero)
    ring = field.get_ring()
    first, second = (reduce(ring.lcm, {pair[which].denom for pair in pairs}, ring.one) for which in (0, 1))
    above = ((one.numer * first.exquo(one.denom)) * (other.numer * second.exquo(other.denom)) for one, other in pairs)
    return field.field.new(sum(above, ring.zero), first * second)
