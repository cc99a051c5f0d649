"""Expressions in the symbols that must not vanish."""

from __future__ import annotations

from collections.abc import Iterable

import sympy
from sympy.polys.domains.domain import Domain

from ..field.signs import definite


def must_not_vanish(field: Domain, values: Iterable) -> tuple[sympy.Expr, ...]:
    """The irreducible factors of all numerators and denominators that positive symbols can make zero, the short ones first.

    >>> a, b = sympy.symbols("a b")
    >>> K = sympy.ZZ.frac_field(a, b)
    >>> must_not_vanish(K, [K.from_sympy(a**2 * (a - b) / (a + b)), K.from_sympy(2 * b - 2 * a)])
    (a - b,)
    """
    if not field.is_FractionField:
        return ()
    ring, found = field.get_ring(), {}
    for value in values:
        for part in (field.numer(value), field.denom(value)):
            for factor, _ in part.factor_list()[1]:
                if factor not in found:
                    found[factor] = definite(field, field.convert(factor, ring))
    doubtful = [ring.to_sympy(factor) for factor, sure in found.items() if not sure]
    return tuple(sorted(doubtful, key=lambda e: (sympy.count_ops(e), str(e))))
