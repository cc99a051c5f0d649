"""The roots of an irreducible polynomial as real functions of time: e^{a t} cos(w t) and e^{a t} sin(w t).

A pair of roots a +- i w with w^2 > 0 oscillates, one with w^2 < 0 is a pair of real exponents. Where the sign of w^2 depends on
the values of the symbols, as that of 4 k m - c^2 does, the oscillating form is given: cos(w t) and w sin(w t) are even in w, so that it
holds for w^2 < 0 as well, with the root of a negative number, and for w^2 = 0 as a limit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sympy

from ....errors import InputError
from ..field.radicals import Root, roots


@dataclass(frozen=True)
class Mode:
    """One real root, or a pair of roots rate +- i frequency.

    Attributes:
        rate, frequency: in 1/s and rad/s; frequency 0 for a real root.
        weights: of a polynomial c(x) over the field: the factors of cos(frequency t) and of sin(frequency t) in the
            sum of c(x) e^{x t} over the roots, without e^{rate t}.
    """

    rate: sympy.Expr
    frequency: sympy.Expr
    weights: Callable[[sympy.Poly], tuple[sympy.Expr, sympy.Expr]]


def modes(q: sympy.Poly) -> list[Mode]:
    """The roots of an irreducible polynomial over a field, symbols taken as positive, those of ``radicals.roots``.

    Raises:
        InputError: no closed form, and symbols.
    """
    found, field = roots(q.monic(), split=False), q.domain
    if found is None:
        raise InputError(
            f"the factor {q.as_expr()} of the determinant has no roots in closed form; give some of its symbols "
            f"({', '.join(map(str, field.symbols))}) as numbers, or use numbers throughout (mb.solve)"
        )
    return [_mode(root) for root in found]


def _mode(root: Root) -> Mode:
    def weights(c: sympy.Poly) -> tuple[sympy.Expr, sympy.Expr]:
        real, imaginary = root.at(c)
        return (2 * real, -2 * imaginary) if root.is_pair else (real, sympy.S.Zero)

    return Mode(root.real, root.imaginary, weights)
