"""The structure of A(s) over its field: Smith form, elementary divisors, zeros, and what happens at infinity."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from math import prod
from typing import TYPE_CHECKING

import sympy

from ....polynomial.structure import Structure
from ..field.factoring import constant, described, factors_of, resultant
from ..field.radicals import Root, roots
from .assumptions import must_not_vanish
from .local_smith import AtInfinity, at_infinity, root_polynomials

if TYPE_CHECKING:
    from .decomposition import RootPolynomials
    from .matrix import SymbolicPolynomialMatrix


@dataclass(frozen=True, repr=False)
class ElementaryDivisor:
    """The elementary divisors p^k of A(s) that belong to one irreducible polynomial p.

    Attributes:
        polynomial: p, a monic Poly in s, irreducible over the field.
        exponents: the k > 0, ascending.
    """

    polynomial: sympy.Poly
    exponents: tuple[int, ...]

    def __repr__(self) -> str:
        return f"ElementaryDivisor({described(self.polynomial)}, exponents {self.exponents})"

    @property
    def multiplicity(self) -> int:
        """How often p divides det A(s)."""
        return sum(self.exponents)


@dataclass(frozen=True)
class SymbolicZero:
    """A zero of A(s).

    Attributes:
        value: in 1/s, in radicals, or with 30 digits where there are no symbols; of a complex pair the one above the real axis stands for both.
        multiplicity, partial_multiplicities: as of ``FiniteZero``.
        is_pair: True where it stands for two.
    """

    value: sympy.Expr
    multiplicity: int
    partial_multiplicities: tuple[int, ...]
    is_pair: bool = False

    @property
    def count(self) -> int:
        """How many roots of det A(s) this entry stands for."""
        return self.multiplicity * (2 if self.is_pair else 1)


@dataclass(frozen=True)
class SymbolicStructure(Structure):
    """Zeros of A(s), finite and infinite, for generic positive values of the symbols (Moysis et al., Eqs. 5-15).

    Has the attributes of ``Structure``, and

    Attributes:
        finite_zeros: those of ``radicals.roots``: with symbols, of factors of degree 1, 2 and s^4 + b s^2 + c; of numbers all.
        elementary_divisors: all of the finite ones.
        invariant_polynomials: f_1 ... f_r, monic Polys in s, each divides the next (Eq. 5).
        assumptions: expressions in the symbols that must not vanish: the leading coefficient of det A(s), pivots, differences of
            zeros. What has one sign for all positive symbols is left out, and so is whether zeros that have no closed form
            are distinct.
    """

    elementary_divisors: tuple[ElementaryDivisor, ...] = ()
    invariant_polynomials: tuple[sympy.Poly, ...] = field(default=(), repr=False)
    assumptions: tuple[sympy.Expr, ...] = ()

    @property
    def notices(self) -> tuple:
        """None: nothing is rounded."""
        return ()


class Local:
    """The local Smith forms of A(s) at all its zeros and at infinity, each computed when it is asked for first."""

    def __init__(self, A: SymbolicPolynomialMatrix):
        self.A = A
        self._terms: dict[sympy.Poly, list[RootPolynomials]] = {}
        self._roots: dict[sympy.Poly, tuple[Root, ...] | None] = {}

    @cached_property
    def divisors(self) -> list[tuple[sympy.Poly, int]]:
        """The irreducible factors of det A(s) with their multiplicities."""
        return factors_of(self.A.determinant)

    def terms(self, p: sympy.Poly, multiplicity: int) -> list[RootPolynomials]:
        """The root polynomials at the zeros of p, the longest first."""
        if p not in self._terms:
            self._terms[p] = root_polynomials(self.A, p, multiplicity)
        return self._terms[p]

    def roots(self, p: sympy.Poly) -> tuple[Root, ...] | None:
        """The zeros of p; None where there are symbols and no closed form."""
        if p not in self._roots:
            self._roots[p] = roots(p)
        return self._roots[p]

    @cached_property
    def infinity(self) -> AtInfinity:
        """The root polynomials at infinity."""
        return at_infinity(self.A)


def structure_of(local: Local) -> SymbolicStructure:
    """The structure of A(s); multiplicity one needs no elimination."""
    A = local.A
    divisors = tuple(
        ElementaryDivisor(p, (1,) if count == 1 else tuple(t.length for t in reversed(local.terms(p, count))))
        for p, count in local.divisors
    )
    orders = (*local.infinity.orders, *(A.degree,) * (A.size - len(local.infinity.orders)))
    return SymbolicStructure(
        size=A.size,
        degree=A.degree,
        finite_zeros=tuple(_zeros(local, divisors)),
        infinite_divisors=tuple(sorted(A.degree - order for order in orders)),
        elementary_divisors=divisors,
        invariant_polynomials=tuple(_invariant_polynomials(A, divisors)),
        assumptions=must_not_vanish(A.field, divided_by(local)),
    )


def _zeros(local, divisors) -> Iterable[SymbolicZero]:
    for divisor in divisors:
        for root in local.roots(divisor.polynomial) or ():
            yield SymbolicZero(root.value, divisor.multiplicity, divisor.exponents, root.is_pair)


def _invariant_polynomials(A, divisors) -> Iterable[sympy.Poly]:
    one = constant(A.determinant, A.field.one)
    for index in range(A.size, 0, -1):
        powers = (d.polynomial ** d.exponents[-index] for d in divisors if len(d.exponents) >= index)
        yield prod(powers, start=one)


def divided_by(local: Local) -> Iterable:
    """What the structure rests on: the degree of det A, distinct zeros, and the pivots of multiple and infinite ones."""
    A, several = local.A, local.divisors
    yield from (A.field.convert(A.field.denom(c), A.field.get_ring()) for matrix in A.elements for row in matrix for c in row)
    yield A.determinant.rep.LC()
    for index, (p, count) in enumerate(several):
        yield from (resultant(p, other) for other, _ in several[:index])
        if p.degree() > 1 and local.roots(p) is not None:
            yield resultant(p, p.diff())
        if count > 1:
            yield from (resultant(p, term.pivot) for term in local.terms(p, count))
    yield from (term.pivot.rep.LC() for term in local.infinity.terms)
