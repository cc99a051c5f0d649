"""A formula as text for a terminal: products without signs, powers with ^."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import sympy
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.str import StrPrinter

from .closed_form import ClosedForm
from .notation import Notation, in_reading_order, joined_roots, short_decimal
from .printing_layout import laid_out
from .terms import Term

#: Formulas of more characters have a line for every term.
LONGEST_LINE = 100


class TextPrinter(Notation, StrPrinter):
    """2 sqrt(5) cos(w t)/3 instead of 2*sqrt(5)*cos(w*t)/3.

    >>> k, m, t = sympy.symbols("k m t")
    >>> TextPrinter().doprint(-2 * k * sympy.sqrt(k / m) * sympy.exp(-t / 2) / (3 * m**2 * (k + 1)))
    '-2 k sqrt(k/m) exp(-t/2)/(3 m^2 (k + 1))'
    """

    def _derivative(self, name: str, order: int) -> str:
        """x, x', x'', x''', x^(4)."""
        return name + ("'" * order if order < 4 else f"^({order})")

    def term(self, term: Term) -> str:
        """A term as in ``Notation``, with the divisor of the coefficient at the end: k cos(w t)/3."""
        coefficient = term.coefficient
        if coefficient.is_Add or coefficient.is_number or term.function == 1:
            return super().term(term)
        return self.doprint(sympy.Mul(coefficient, term.function))

    def _print_Mul(self, expr) -> str:
        joined = joined_roots(expr)
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
        return f"δ{'′' * order if order < 4 else f'^({order})'}({self._print(delta.args[0])})"


def formula_text(x, names: Sequence[str] | None = None, digits: int | None = None) -> str:
    """x(t) as text: a line for each coordinate, or for each term of a long one, then what else belongs to it.

    >>> t, k = sympy.symbols("t k", positive=True)
    >>> print(formula_text(ClosedForm(("x1",), (2 * sympy.cos(sympy.sqrt(k) * t) / 3,), t)))
    x1(t) = 2/3 cos(sqrt(k) t)
    """
    form = ClosedForm.of(x, names)
    layout, printer = laid_out(form, digits), TextPrinter(form)
    blocks = [[_row(name, row, printer) for name, row in zip(form.names, layout.rows)]]
    blocks.append([f"{each.symbol.name} = {printer.doprint(each.value)}" for each in layout.shorthands])
    blocks.append([printer.statement(parts) for parts in chain(*layout.statements.values())])
    return "\n\n".join("\n".join(lines) for lines in blocks if lines)


def _row(name: str, terms: list[Term], printer: TextPrinter) -> str:
    head = f"{name}({printer.form.time.name}) ="
    first, others = printer.terms(terms)
    line = f"{head} {first}{''.join(others)}"
    return line if len(line) <= LONGEST_LINE or not others else "\n   ".join([f"{head} {first}", *others])
