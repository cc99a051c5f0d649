"""Expressions as plain text that people read: products without signs, powers with ^, one line."""

from __future__ import annotations

from collections.abc import Mapping

import sympy
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.str import StrPrinter

#: Stands for the time in terms: by its name it comes last in products, w t instead of t w.
LAST = sympy.Symbol("zzzz", real=True)


class TextPrinter(StrPrinter):
    """2 sqrt(5) cos(w t)/3 instead of 2*sqrt(5)*cos(w*t)/3.

    Args:
        names: what symbols are called.

    >>> k, m, t = sympy.symbols("k m t")
    >>> TextPrinter().doprint(-2 * k * sympy.sqrt(k / m) * sympy.exp(-t / 2) / (3 * m**2 * (k + 1)))
    '-2 k sqrt(k/m) exp(-t/2)/(3 m^2 (k + 1))'
    """

    def __init__(self, names: Mapping[sympy.Symbol, str] | None = None):
        super().__init__()
        self.names = names or {}

    def _print_Symbol(self, symbol) -> str:
        return self.names.get(symbol, symbol.name)

    def _as_ordered_terms(self, expr, order=None) -> list[sympy.Expr]:
        return time_first(super()._as_ordered_terms(expr, order))

    def _print_Mul(self, product) -> str:
        joined = joined_roots(product)
        if not joined.is_Mul:
            return self._print(joined)
        numbers = [part for part in joined.args if part.is_Rational or part.is_Float]
        number, rest = sympy.Mul(*numbers), [part for part in joined.args if part not in numbers]
        sign, number = ("-", -number) if number.could_extract_minus_sign() else ("", number)
        above, below = [], []
        for factor in in_reading_order(rest):
            inverse = factor.is_Pow and factor.exp.is_number and factor.exp.could_extract_minus_sign()
            (below if inverse else above).append(1 / factor if inverse else factor)
        if number.is_Rational and number.q != 1:
            above, below = [sympy.Integer(number.p)] * (number.p != 1) + above, [sympy.Integer(number.q), *below]
        elif number != 1:
            above = [number, *above]
        top = self._factors(above) if above else "1"
        return f"{sign}{top}/{self._below(below)}" if below else f"{sign}{top}"

    def _factors(self, factors) -> str:
        return " ".join(self.parenthesize(factor, PRECEDENCE["Mul"]) for factor in factors)

    def _below(self, factors) -> str:
        text = self._factors(factors)
        return f"({text})" if len(factors) > 1 else text

    def _print_Pow(self, power, rational=False) -> str:
        if power.exp == sympy.S.Half:
            return f"sqrt({self._print(power.base)})"
        if power.exp.is_number and power.exp.could_extract_minus_sign():
            return f"1/{self._below([1 / power])}"
        exponent = self._print(power.exp)
        base = self.parenthesize(power.base, PRECEDENCE["Pow"] + 1)
        return f"{base}^{exponent}" if power.exp.is_Integer or power.exp.is_Symbol else f"{base}^({exponent})"

    def _print_Float(self, number) -> str:
        return short_decimal(number)

    def _print_Heaviside(self, step) -> str:
        return f"H({self._print(step.args[0])})"

    def _print_DiracDelta(self, delta) -> str:
        order = int(delta.args[1]) if len(delta.args) > 1 else 0
        return f"{delta_name(order)}({self._print(delta.args[0])})"


def joined_roots(product: sympy.Expr) -> sympy.Expr:
    """sqrt(k)/sqrt(m), as sympy has it, as sqrt(k/m), not evaluated.

    >>> k, m = sympy.symbols("k m", positive=True)
    >>> joined_roots(2 * sympy.sqrt(k / m)).args
    (2, sqrt(k/m))
    """
    roots = [part for part in product.args if part.is_Pow and abs(part.exp) == sympy.S.Half and not part.is_number]
    above = [part.base for part in roots if part.exp > 0]
    below = [part.base for part in roots if part.exp < 0]
    if not (product.is_Mul and above and below):
        return product
    root = sympy.Pow(sympy.Mul(*above) / sympy.Mul(*below), sympy.S.Half, evaluate=False)
    rest = [part for part in product.args if part not in roots]
    return sympy.Mul(*rest, root, evaluate=False) if rest else root


class ReadableProducts:
    """For a printer of sympy: roots of one product joined, t before the offset of a delay."""

    def _print_Mul(self, expr):
        joined = joined_roots(expr)
        if joined.is_Mul or joined is expr:  # sympy prints a reciprocal by this, too
            return super()._print_Mul(joined)
        return self._print(joined)

    def _as_ordered_terms(self, expr, order=None) -> list:
        return time_first(super()._as_ordered_terms(expr, order))


def time_first(terms) -> list[sympy.Expr]:
    """t - T instead of -T + t, as what functions are of."""
    return sorted(terms, key=lambda term: not term.has(LAST))


def delta_name(order: int) -> str:
    """Dirac's delta or a derivative of it."""
    return "δ" + ("′" * order if order < 4 else f"^({order})")


def short_decimal(number: sympy.Float) -> str:
    """A decimal without zeros at its end.

    >>> short_decimal(sympy.Float("0.2500")), short_decimal(sympy.Float("1.5e-12", 4)), short_decimal(sympy.Float(120, 3))
    ('0.25', '1.5e-12', '120')
    """
    text = str(number)
    mantissa, e, exponent = text.partition("e")
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    return f"{mantissa}e{int(exponent)}" if e else mantissa


def in_reading_order(factors) -> list[sympy.Expr]:
    """Numbers, symbols, sums and roots, the time, and functions last."""

    def rank(factor):
        base = factor.base if factor.is_Pow else factor
        if factor.is_number:
            return 0, ""
        if isinstance(base, sympy.Symbol) and base.name == LAST.name:
            return 3, ""
        if isinstance(base, sympy.Symbol) and not (factor.is_Pow and not factor.exp.is_Integer):
            return 1, base.name
        if isinstance(factor, sympy.exp):
            return 4, ""
        return (5 if isinstance(factor, sympy.Function) else 2), ""

    return sorted(factors, key=rank)
