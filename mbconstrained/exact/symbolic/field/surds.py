"""Numbers u + v sqrt(g) over the field of the entries."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy.polys.domains.domain import Domain

from .fields import expression_of
from .signs import root_expression, sign, sign_with_root


@dataclass(frozen=True)
class Surd:
    """u + v sqrt(g), elements of the field, g no square in it.

    >>> golden = Surd(sympy.QQ, sympy.QQ(1, 2), sympy.QQ(1, 2), sympy.QQ(5))
    >>> (golden * golden - golden).expression(), golden.sign()
    (1, 1)
    """

    field: Domain
    u: object
    v: object
    g: object

    def __add__(self, other: Surd) -> Surd:
        return Surd(self.field, self.u + other.u, self.v + other.v, self.g)

    def __sub__(self, other: Surd) -> Surd:
        return Surd(self.field, self.u - other.u, self.v - other.v, self.g)

    def __mul__(self, other: Surd) -> Surd:
        return Surd(self.field, self.u * other.u + self.v * other.v * self.g, self.u * other.v + self.v * other.u, self.g)

    def __neg__(self) -> Surd:
        return Surd(self.field, -self.u, -self.v, self.g)

    @property
    def conjugate(self) -> Surd:
        """u - v sqrt(g)."""
        return Surd(self.field, self.u, -self.v, self.g)

    def times(self, factor) -> Surd:
        """The product with an element of the field."""
        return Surd(self.field, self.u * factor, self.v * factor, self.g)

    def of(self, u) -> Surd:
        """An element of the field as one of these numbers."""
        return Surd(self.field, u, self.field.zero, self.g)

    def sign(self) -> int | None:
        """Its sign for all positive values of the symbols, None where it is not seen, or where the number may be complex."""
        if not self.v:
            return sign(self.field, self.u)
        return sign_with_root(self.field, self.u, self.v, self.g) if sign(self.field, self.g) == 1 else None

    def expression(self) -> sympy.Expr:
        """As an expression."""
        rational = expression_of(self.field, self.u)
        return rational + expression_of(self.field, self.v) * root_expression(self.field, self.g) if self.v else rational
