"""Zeros that have no closed form, as decimals."""

from __future__ import annotations

import sympy

#: Of zeros, and of what polynomials are there.
DIGITS = 30


def numerical_roots(p: sympy.Poly) -> list[tuple[sympy.Expr, sympy.Expr]]:
    """Real and imaginary parts of the zeros of a polynomial with numbers, twice ``DIGITS`` digits, of each pair the one above."""
    if not p.domain.is_QQ:
        p = sympy.Poly([c.evalf(3 * DIGITS) for c in p.all_coeffs()], p.gen)
    found = [root.as_real_imag() for root in p.nroots(n=2 * DIGITS, maxsteps=500)]
    return [(real, imaginary) for real, imaginary in found if imaginary >= 0]


def value_at(root: tuple[sympy.Expr, sympy.Expr], e: sympy.Poly) -> tuple[sympy.Expr, sympy.Expr]:
    """Real and imaginary part of e(root), rounded to ``DIGITS`` digits."""
    real, imaginary = root
    above, beside = sympy.S.Zero, sympy.S.Zero
    for c in e.all_coeffs():
        number = sympy.N(c, 2 * DIGITS)
        above, beside = above * real - beside * imaginary + number, above * imaginary + beside * real
    return rounded(above), rounded(beside)


def rounded(number: sympy.Expr) -> sympy.Expr:
    """To ``DIGITS`` digits; zero stays exact."""
    return sympy.N(number, DIGITS) if number != 0 else sympy.S.Zero
