"""Numbers u + v sqrt(g) and their square roots written down in few terms, what both parts share in front."""

from __future__ import annotations

import sympy
from sympy.polys.domains import Domain
from sympy.polys.polyerrors import CoercionFailed

from .fields import expression_of
from .signs import root_expression
from .surds import Surd


def element_of(field: Domain, expression: sympy.Expr) -> object | None:
    """The expression as an element of the field; None where it is none."""
    try:
        return field.from_sympy(expression)
    except (CoercionFailed, ValueError, NotImplementedError):
        return None


def in_one_form(field: Domain, value):
    """The same element with 1 in front of its denominator: fractions over algebraic numbers are not reduced that far by themselves."""
    if not field.is_FractionField or not field.domain.is_Algebraic:
        return value
    factor = field.domain.one / value.denom.LC
    return field.field.raw_new(value.numer.mul_ground(factor), value.denom.mul_ground(factor))


def factored(field: Domain, value) -> sympy.Expr:
    """An element as an expression in factors."""
    return expression_of(field, in_one_form(field, value))


def compact_expression(number: Surd) -> sympy.Expr:
    """u + v sqrt(g) with what u and v share in front, sqrt(g) too where g divides u.

    >>> k, m = sympy.symbols("k m")
    >>> K = sympy.ZZ.frac_field(k, m)
    >>> compact_expression(Surd(K, K.from_sympy(3 * k / m), K.from_sympy(k / m), K(5)))
    k*(sqrt(5) + 3)/m
    """
    field = number.field
    if not number.v:
        return factored(field, number.u)
    shared, u, v = _parted(number)
    if field.is_FractionField and not number.g.numer.is_ground and not u.numer.rem(number.g.numer):
        root = root_expression(field, number.g)
        return factored(field, shared * number.g) / root * _sum(number, v, u / number.g)  # u + v r = g/r (v + u/g r), r^2 = g
    return factored(field, shared) * _sum(number, u, v)


def compact_root(number: Surd) -> sympy.Expr:
    """A square root of u + v sqrt(g), the positive one where the number is positive.

    >>> k, m = sympy.symbols("k m")
    >>> K = sympy.ZZ.frac_field(k, m)
    >>> compact_root(Surd(K, K.from_sympy(3 * k / m / 2), K.from_sympy(k / m / 2), K(5)))
    sqrt(k/m)*(1/2 + sqrt(5)/2)
    """
    field = number.field
    if not number.v:
        return _denested(root_expression(field, in_one_form(field, number.u)))
    shared, u, v = _parted(number)
    inner = _sum(number, u, v)
    if not inner.is_number or not field.is_FractionField:
        return root_expression(field, shared) * sympy.sqrtdenest(sympy.sqrt(inner))
    front = (
        sympy.Rational(*(field.domain.to_sympy(part.content()) for part in (shared.numer, shared.denom)))
        if field.domain.is_ZZ
        else 1
    )
    denested = sympy.expand(
        sympy.sqrtdenest(sympy.sqrt(sympy.expand(front * inner)))
    )  # (3 + sqrt(5))/2 is a square, 3 + sqrt(5) is none
    return root_expression(field, shared / field.from_sympy(sympy.S(front))) * denested


def _denested(root: sympy.Expr) -> sympy.Expr:
    nested = [power for power in root.atoms(sympy.Pow) if power.is_number and not power.exp.is_Integer]
    return root.xreplace({power: sympy.expand(sympy.sqrtdenest(power)) for power in nested})


def _parted(number: Surd) -> tuple:
    """A common factor of u and v, and both without it."""
    field, u, v = number.field, number.u, number.v
    if not field.is_FractionField:
        return field.one, u, v
    shared = field((u.numer * v.denom).gcd(v.numer * u.denom)) / field(u.denom * v.denom)
    return shared, u / shared, v / shared


def _sum(number: Surd, u, v) -> sympy.Expr:
    field = number.field
    return field.to_sympy(u) + field.to_sympy(v) * root_expression(field, number.g)
