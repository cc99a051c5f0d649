"""Common notation of text, LaTeX and MathML, and a formula as text for a terminal: products without signs, powers with ^."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain
from typing import Any

import sympy
from sympy.core.relational import Relational
from sympy.logic.boolalg import BooleanAtom
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.str import StrPrinter

from .closed_form import ClosedForm
from .printing_layout import LAST, Derivative, Part, Term, laid_out, readable, signed, value_at_start


class Notation:
    """A printer of sympy becomes one of formulas: roots of one product joined, t in front of the offset of a delay.

    Args:
        form: the formula, whose parameters, time and values at 0- have names; None where symbols are called as they are.
    """

    times, equal, unequal, greater = " ", " = ", " is not ", " > "
    zero, minus, enclosed, at_start = "0", "-", "({})", "(0-)"

    doprint: Callable[..., Any]  # of sympy's printer

    def __init__(self, form: ClosedForm | None = None):
        super().__init__()
        self.form, self.names, self.starts = form, {}, {}
        if form is not None:
            self.names = {LAST: form.time.name, **{p.symbol: p.name for p in form.parameters}}
            conditions = set().union(*(each.free_symbols for each in (*form.admissible, *form.continuous))) - set(self.names)
            self.starts = {symbol: start for symbol in conditions if (start := value_at_start(symbol.name))}

    def _name(self, name: str) -> str:
        """A name, as it stands alone."""
        return name

    def _factor(self, name: str) -> str:
        """A name in a product: a word keeps its distance."""
        return self._name(name)

    def _derivative(self, name: str, order: int) -> str:
        """A coordinate with the marks of its derivative."""
        raise NotImplementedError

    def _words(self, text: str) -> str:
        return text

    def _function(self, function: sympy.Expr) -> str:
        return self.doprint(function)

    def _infix(self, sign: str) -> str:
        """ "+" or "-" in front of a further term."""
        return f" {sign} "

    def term(self, term: Term) -> str:
        """The coefficient and the function, each where it is not 1."""
        coefficient, function = term.coefficient, term.function
        if function == 1:
            return self.doprint(coefficient)
        if coefficient == 1:
            return self._function(function)
        first = self.doprint(coefficient)
        return f"{self.enclosed.format(first) if coefficient.is_Add else first}{self.times}{self._function(function)}"

    def terms(self, terms: list[Term]) -> tuple[str, list[str]]:
        """The first term, and the others, each with its sign; zero where there is none."""
        parts = [(sign, self.term(term)) for sign, term in map(signed, terms)] or [("+", self.zero)]
        first = (self.minus if parts[0][0] == "-" else "") + parts[0][1]
        return first, [self._infix(sign) + text for sign, text in parts[1:]]

    def part(self, part: Part) -> str:
        """A part of a statement."""
        if isinstance(part, str):
            return self._words(part)
        if isinstance(part, Derivative):
            return self._derivative(part.name, part.order)
        if isinstance(part, Term):
            return self.term(part)
        if isinstance(part, BooleanAtom):
            return self._words("always" if part else "never")
        if not isinstance(part, Relational):
            return self.doprint(part)
        relation = {"==": self.equal, "!=": self.unequal, ">": self.greater}[part.rel_op]
        return f"{self.doprint(part.lhs)}{relation}{self.doprint(readable(part.rhs))}"

    def statement(self, parts: list[Part]) -> str:
        """A statement about the formula."""
        return "".join(map(self.part, parts))

    def _print_Symbol(self, symbol, style="plain"):
        if symbol in self.starts:
            return self._derivative(*self.starts[symbol]) + self.at_start
        return self._factor(self.names.get(symbol, symbol.name))

    def _print_Mul(self, expr):
        joined = joined_roots(expr)
        if joined.is_Mul or joined is expr:  # sympy prints a reciprocal by this, too
            return super()._print_Mul(joined)
        return self._print(joined)

    def _as_ordered_terms(self, expr, order=None) -> list[sympy.Expr]:
        """t - T instead of -T + t, as what functions are of."""
        return sorted(super()._as_ordered_terms(expr, order), key=lambda term: not term.has(LAST))


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


def short_decimal(number: sympy.Float) -> str:
    """A decimal without zeros at its end.

    >>> short_decimal(sympy.Float("0.2500")), short_decimal(sympy.Float("1.5e-12", 4)), short_decimal(sympy.Float(120, 3))
    ('0.25', '1.5e-12', '120')
    """
    mantissa, e, exponent = str(number).partition("e")
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
