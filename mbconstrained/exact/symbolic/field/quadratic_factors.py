"""Quartics as products of two quadratics over the field and one square root (Ferrari)."""

from __future__ import annotations

import sympy

from .signs import sign, square_root
from .surds import Surd

#: Which square root is taken first: a real one, one that is imaginary for certain, one that depends on the symbols.
ORDER = {1: 0, -1: 1, None: 2}


def quadratic_factors(q: sympy.Poly) -> tuple[Surd, Surd] | None:
    """(a, b) with q = (s^2 + a s + b) times its conjugate, real where it can be; None where there is none.

    They are there for s^4 + b s^2 + c, and with damping in proportion to mass and stiffness.

    Args:
        q: monic, irreducible over its field, of degree 4.

    >>> s = sympy.Symbol("s")
    >>> a, b = quadratic_factors(sympy.Poly(s**4 + 3 * s**2 + 1, s, domain="QQ"))
    >>> a.expression(), b.expression()
    (0, sqrt(5)/2 + 3/2)
    """
    field = q.domain
    h = q.rep.to_list()[1] / field.convert(4)
    moved = q.compose(sympy.Poly([field.one, -h], q.gen, domain=field)).rep.to_list()
    p, linear, last = moved[2:]
    resolvent = sympy.Poly([field.one, 2 * p, p * p - 4 * last, -linear * linear], q.gen, domain=field)
    lines = [factor.rep.to_list() for factor, _ in resolvent.factor_list()[1] if factor.degree() == 1]
    found = [_quadratic(field, h, p, linear, last, -zeroth / first) for first, zeroth in lines]
    return min(found, key=lambda parts: (ORDER[sign(field, parts[1].g)], bool(parts[0].v)), default=None)


def _quadratic(field, h, p, linear, last, z) -> tuple[Surd, Surd]:
    """s^2 + a s + b of the root z of the resolvent: its root is that of z, or of p^2 - 4 last where z = 0."""
    half = field.one / field.convert(2)
    outside, g = square_root(field, z if z else p * p - 4 * last)
    root = Surd(field, field.zero, outside, g)
    if not z:
        return root.of(2 * h), root.of(h * h + p * half) + root * root.of(half)
    return root.of(2 * h) + root, root.of(h * h + (p + z) * half) + root * root.of(h - linear * half / z)
