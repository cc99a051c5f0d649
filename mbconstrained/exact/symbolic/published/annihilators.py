"""What the formulas for e^{J t} are given: a square J, its zeros, and exponents that make the product of (J - zero I)^exponent zero."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import mpmath
import sympy

from ....errors import InputError

#: With which it is checked that exponents are those of J; where they are, half of them at least are zero in the check.
DIGITS = 60


def checked_expression(value, what: str = "zeros", expected: str = "numbers or expressions") -> sympy.Expr:
    """A number or an expression as an expression, or an InputError."""
    try:
        return sympy.sympify(value, strict=True)
    except sympy.SympifyError:
        raise InputError(f"{what}: found {value!r}; expected {expected}") from None


def time_apart(t, constants: Iterable[sympy.Expr]) -> sympy.Expr:
    """The time, an expression that shares no name with what is constant."""
    t = checked_expression(t, "t", "a symbol or an expression, e.g. sympy.Symbol('t', real=True)")
    known = {symbol.name for constant in constants for symbol in constant.free_symbols}
    if shared := sorted(known & {symbol.name for symbol in t.free_symbols}):
        raise InputError(f"t: the symbol {shared[0]} is also one of J; name the time otherwise")
    return t


def square_matrix(J, what: str) -> sympy.ImmutableMatrix:
    """A square matrix of expressions."""
    try:
        matrix = sympy.ImmutableMatrix(J)
    except (TypeError, ValueError, sympy.SympifyError):
        raise InputError(f"{what}: found {J!r}; expected a square matrix of numbers or expressions") from None
    if matrix.rows != matrix.cols:
        raise InputError(f"{what}: found shape {matrix.shape}; expected a square matrix")
    return matrix


def check_annihilated(J: sympy.ImmutableMatrix, exponents: Mapping[sympy.Expr, int], what: str) -> None:
    """The product of (J - zero I)^exponent is 0, at one value of the symbols and in many digits: a product that is zero there is zero."""
    symbols = sorted(set().union(J.free_symbols, *(zero.free_symbols for zero in exponents)), key=str)
    values = {symbol: _generic(symbol, i) for i, symbol in enumerate(symbols)}
    with mpmath.workdps(DIGITS):
        matrix = mpmath.matrix(J.rows, J.rows)
        for place, entry in J.todok().items():
            matrix[place] = _number(entry, values)
        product, scale = mpmath.eye(J.rows), mpmath.mpf(1)
        for zero, exponent in exponents.items():
            factor = matrix - _number(zero, values) * mpmath.eye(J.rows)
            product, scale = product * factor**exponent, scale * mpmath.mnorm(factor, 1) ** exponent
        if J.rows and mpmath.mnorm(product, 1) > scale * mpmath.mpf(10) ** (-DIGITS // 2):
            factors = " ".join(f"({what} - ({zero}) I)^{exponent}" for zero, exponent in exponents.items())
            raise InputError(f"exponents: {factors} is not 0; expected every zero of {what}, with the length of its longest chain")


def _generic(symbol: sympy.Symbol, index: int) -> sympy.Rational:
    """A number between 1 and 2, or its negative, that no other symbol has."""
    value = 1 + sympy.Rational(sympy.prime(index + 4), sympy.prime(index + 6) + 13)
    return -value if symbol.is_negative else value


def _number(expression: sympy.Expr, values: Mapping[sympy.Symbol, sympy.Rational]):
    return mpmath.mpmathify(sympy.N(expression.subs(values), DIGITS))
