"""The polynomials over the field of the entries for the core of the exact answers: sympy's Polys, and their factors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import sympy
from sympy.polys.domains.domain import Domain
from sympy.polys.matrices import DomainMatrix

from ..core.jordan_blocks import JordanChain
from .field.fields import coefficients, expression_of, in_one_form
from .field.radicals import Root, roots

#: (q, k): an irreducible monic factor and its multiplicity.
Factors = list[tuple[sympy.Poly, int]]

#: Characters of a polynomial in a representation.
LONGEST_TEXT = 60


@dataclass(frozen=True)
class SymbolicZero:
    """A zero of A(s).

    Attributes:
        value: in 1/s, in radicals, or with 30 digits where there are no symbols; of a complex pair the one above the real axis
            stands for both.
        multiplicity, partial_multiplicities: as in ``FiniteZero``.
        is_pair: True where it stands for two.
    """

    value: sympy.Expr
    multiplicity: int
    partial_multiplicities: tuple[int, ...]
    is_pair: bool = False

    @property
    def count(self) -> int:
        """Number of roots of det A(s) for this entry."""
        return self.multiplicity * (2 if self.is_pair else 1)


def integers(field: Domain) -> Domain:
    """The ring whose fractions are the field; the field itself without one."""
    return field.get_ring() if field.has_assoc_Ring else field


def factors_of(p: sympy.Poly) -> Factors:
    """The monic irreducible factors of p over its field with their powers, those of low degree first.

    Over rational functions of symbols, p times its denominators is factored as a polynomial in s and the symbols (Gauss).

    >>> s, k, m = sympy.symbols("s k m")
    >>> factors_of(sympy.Poly(m * s**3 + k * s, s, domain=sympy.ZZ.frac_field(k, m)))
    [(Poly(s, s, domain='ZZ(k,m)'), 1), (Poly(s**2 + k/m, s, domain='ZZ(k,m)'), 1)]
    """
    order = min((power for (power,), _ in p.terms()), default=0)
    rest = sympy.Poly(p.rep.to_list()[: p.degree() - order + 1], p.gen, domain=p.domain) if order else p  # factoring is slow
    factors = [(sympy.Poly([p.domain.one, p.domain.zero], p.gen, domain=p.domain), order)] if order else []
    if p.domain.is_FractionField:
        rest = rest.clear_denoms(convert=True)[1]
    factors += [(_monic(factor, p.domain), power) for factor, power in rest.factor_list()[1] if factor.degree() > 0]
    return sorted(factors, key=lambda pair: (pair[0].degree(), len(pair[0].terms()), pair[1], str(pair[0])))


def _monic(factor: sympy.Poly, field: Domain) -> sympy.Poly:
    """The monic factor with equal coefficients for equal polynomials."""
    monic = factor.set_domain(field).monic()
    return sympy.Poly([in_one_form(field, c) for c in monic.rep.to_list()], monic.gen, domain=field)


def inverse_modulo(unit: sympy.Poly, modulus: sympy.Poly) -> sympy.Poly:
    """1 / unit modulo a polynomial: the first column of the inverse of the matrix of v -> unit v.

    By elimination without fractions: those of Euclid's algorithm grow. Modulo s^k it is a power series.

    >>> s = sympy.Symbol("s")
    >>> inverse_modulo(sympy.Poly(s**2 - 1, s, domain="QQ"), sympy.Poly(s**3, s, domain="QQ"))
    Poly(-s**2 - 1, s, domain='QQ')
    """
    unit, field, degree, ring = unit.rem(modulus), unit.domain, modulus.degree(), integers(unit.domain)
    if len(modulus.terms()) == 1:
        return _inverse_series(unit, degree)
    columns = [coefficients((unit * sympy.Poly(unit.gen**i, unit.gen, domain=field)).rem(modulus), degree) for i in range(degree)]
    scale = field.one
    if field.has_assoc_Ring:
        scale = field.convert_from(reduce(ring.lcm, (field.denom(c) for column in columns for c in column)), ring)
    rows = [[ring.convert_from(column[i] * scale, field) for column in columns] for i in range(degree)]
    one = DomainMatrix([[ring.one if i == 0 else ring.zero] for i in range(degree)], (degree, 1), ring)
    numerators, denominator = DomainMatrix(rows, (degree, degree), ring).solve_den(one, method="rref")
    factor = scale / field.convert_from(denominator, ring)
    first = [field.convert_from(row[0], ring) * factor for row in numerators.to_list()]
    return sympy.Poly(first[::-1], unit.gen, domain=field)


def _inverse_series(unit: sympy.Poly, count: int) -> sympy.Poly:
    """1 / unit modulo s^count."""
    first, *others = coefficients(unit, count)
    series = [unit.domain.one / first]
    for j in range(1, count):
        known = sum((c * series[j - i] for i, c in enumerate(others[:j], 1)), unit.domain.zero)
        series.append(-known * series[0])
    return sympy.Poly(series[::-1], unit.gen, domain=unit.domain)


class SymbolicRing:
    """K[s] over a field of sympy: Polys for polynomials and matrices of expressions.

    Args:
        domain: the field K.
        variable: the symbol s.
    """

    def __init__(self, domain: Domain, variable: sympy.Symbol):
        self.domain, self.variable = domain, variable
        self.zero, self.one = domain.zero, domain.one
        self._roots: dict[sympy.Poly, tuple[Root, ...] | None] = {}

    @classmethod
    def of(cls, p: sympy.Poly) -> SymbolicRing:
        """The ring of a Poly."""
        return cls(p.domain, p.gen)

    def polynomial(self, coefficients: Sequence) -> sympy.Poly:
        """The polynomial with these coefficients, the lowest power first."""
        return sympy.Poly(list(coefficients)[::-1] or [self.zero], self.variable, domain=self.domain)

    coefficients, inverse, factors = staticmethod(coefficients), staticmethod(inverse_modulo), staticmethod(factors_of)
    chain = JordanChain

    def exported(self, p: sympy.Poly) -> sympy.Poly:
        """The Poly itself."""
        return p

    def text(self, p: sympy.Poly) -> str:
        """The polynomial in short, for representations."""
        text = str(p.as_expr())
        return text if len(text) <= LONGEST_TEXT else f"of degree {p.degree()} in {p.gen}"

    def matrix(self, rows: Sequence[Sequence]) -> sympy.ImmutableMatrix:
        """The matrix with these rows."""
        entries = [expression_of(self.domain, entry) for row in rows for entry in row]
        return sympy.ImmutableMatrix(len(rows), len(rows[0]) if rows else 0, entries)

    def side_by_side(self, matrices: Sequence[sympy.MatrixBase]) -> sympy.ImmutableMatrix:
        """Matrices side by side."""
        return sympy.Matrix.hstack(*matrices).as_immutable()

    def below(self, matrices: Sequence[sympy.MatrixBase]) -> sympy.ImmutableMatrix:
        """Matrices below each other."""
        return sympy.Matrix.vstack(*matrices).as_immutable()

    def diagonal(self, matrices: Sequence[sympy.MatrixBase]) -> sympy.ImmutableMatrix:
        """The block diagonal matrix."""
        return sympy.diag(*matrices).as_immutable()

    def finite_zeros(self, divisors) -> tuple[SymbolicZero, ...]:
        """Finite zeros: with symbols those of factors of degree 1, 2 and s^4 + b s^2 + c (``radicals.roots``); for numbers all."""
        return tuple(
            SymbolicZero(root.value, multiplicity, exponents, root.is_pair)
            for p, multiplicity, exponents in divisors
            for root in self.roots(p) or ()
        )

    def roots(self, p: sympy.Poly) -> tuple[Root, ...] | None:
        """The zeros of an irreducible p, computed once; None for symbols without a closed form."""
        if p not in self._roots:
            self._roots[p] = roots(p)
        return self._roots[p]
