"""Common layout of all printers of formulas: terms with signs, abbreviations, conditions and assumptions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import sympy

from ..symbolic.response.transform import delta
from .closed_form import ClosedForm, Impulse
from .terms import LAST, Shorthand, Term, decimal, in_numbers, in_order, terms_of, with_shorthands

#: Terms, and operations, that a line of a typeset formula has at most.
MOST_TERMS_IN_A_LINE, MOST_IN_A_LINE = 4, 30

#: Digits that are shown of numbers that have no short form.
DOUBLE_DIGITS = 15

#: Fractions of larger whole numbers are shown as decimals.
MOST_IN_FRACTION = 10**9


class Derivative(NamedTuple):
    """The derivative of this order of a coordinate."""

    name: str
    order: int


#: A part of a statement: words, a coordinate or its derivative, a term, an expression or an equation.
Part: TypeAlias = str | Derivative | Term | sympy.Basic


@dataclass(frozen=True, eq=False)
class Layout:
    """The terms of every coordinate, and what the names in them stand for.

    Attributes:
        form: source of the terms.
        rows: terms by coordinate.
        shorthands: names for long rates and frequencies.
        digits: digits of decimals, or None where numbers are exact.
    """

    form: ClosedForm
    rows: list[list[Term]]
    shorthands: list[Shorthand]
    digits: int | None

    def short(self, expression: sympy.Expr) -> sympy.Expr:
        """An expression with the abbreviation for it, or for minus it."""
        names = {each.full: each.symbol for each in self.shorthands if each.full is not None}
        return names.get(expression) or (-names[-expression] if -expression in names else expression)

    @property
    def statements(self) -> dict[str, list[list[Part]]]:
        """Jumps, impulses, conditions on the start and assumptions by kind, each in parts.

        An assumption that follows from one about a sign is left out.
        """
        form = self.form
        known = {other for each in form.positive for other in (each, -each, sympy.expand(-each))}
        assumptions = [each for each in form.assumptions if each not in known and sympy.expand(each) not in known]
        return {
            "jumps": [[Derivative(each.name, each.order), " jumps at t = 0 by ", self.number(each.size)] for each in form.jumps],
            "impulses": [[Derivative(each.name, 0), " has the impulse ", self._impulse(each)] for each in form.impulses],
            "admissible": [["no impulses if ", each] for each in form.admissible],
            "continuous": [["no jumps if ", each] for each in form.continuous],
            "assumptions": [["holds where ", sympy.Ne(self.short(each), 0, evaluate=False)] for each in assumptions],
            "positive": [["real in this form where ", sympy.Gt(self.short(each), 0, evaluate=False)] for each in form.positive],
        }

    def _impulse(self, impulse: Impulse) -> Term:
        return Term(self.number(impulse.factor), delta(LAST - self.number(impulse.time), impulse.order))

    def number(self, expression: sympy.Expr) -> sympy.Expr:
        """Any other expression, in decimals where those are wanted."""
        return readable(expression) if self.digits is None else decimal(self.form.at_defaults(expression), self.digits)


def laid_out(form: ClosedForm, digits: int | None = None) -> Layout:
    """The terms of a formula: exact, long rates named; or with default values and decimals of so many digits."""
    rows = [in_order(terms_of(value.xreplace({form.time: LAST}), LAST), form) for value in form.values]
    if digits is not None:
        return Layout(form, [in_numbers(row, form, digits) for row in rows], [], digits)
    rows, shorthands = with_shorthands(rows, form)
    rows = [[Term(readable(term.coefficient), readable(term.function)) for term in row] for row in rows]
    return Layout(form, rows, [Shorthand(each.symbol, readable(each.value), each.full) for each in shorthands], None)


def is_long(terms: list[Term]) -> bool:
    """Whether each term gets a line of its own."""
    return len(terms) > MOST_TERMS_IN_A_LINE or sum(term.expression.count_ops() for term in terms) > MOST_IN_A_LINE


def readable(expression: sympy.Basic) -> sympy.Basic:
    """An expression with what has too many digits rounded to those of a double.

    >>> readable(sympy.Rational(1, 3) + sympy.Rational(10**12, 3**30) * sympy.Symbol("k"))
    0.00485693574961886*k + 1/3
    """
    numbers = expression.atoms(sympy.Rational, sympy.Float)
    long = {q: sympy.Float(q, DOUBLE_DIGITS) for q in numbers if q.is_Float or max(abs(q.p), q.q) > MOST_IN_FRACTION}
    return expression.xreplace(long) if long else expression


def signed(term: Term) -> tuple[str, Term]:
    """ "-" or "+", and the term without it.

    >>> k = sympy.Symbol("k")
    >>> signed(Term(-2 * k, k))
    ('-', Term(coefficient=2*k, function=k))
    """
    minus = term.coefficient.could_extract_minus_sign()
    return ("-", Term(-term.coefficient, term.function)) if minus else ("+", term)


def value_at_start(name: str) -> tuple[str, int] | None:
    """The coordinate and the order of the derivative that a symbol for a value at 0- stands for: x1_0, x1_1, ….

    >>> value_at_start("left joint_2"), value_at_start("k")
    (('left joint', 2), None)
    """
    coordinate, line, order = name.rpartition("_")
    return (coordinate, int(order)) if line and order.isascii() and order.isdigit() else None
