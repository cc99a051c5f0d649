"""What all printers of formulas share: terms with their signs, abbreviations, conditions and assumptions."""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from .closed_form import ClosedForm
from .terms import LAST, Shorthand, Term, decimal, in_numbers, in_order, terms_of, with_shorthands

#: Terms, and operations, that a line of a typeset formula has at most.
MOST_TERMS_IN_A_LINE, MOST_IN_A_LINE = 4, 30

#: Digits that are shown of numbers that have no short form.
DOUBLE_DIGITS = 15

#: Fractions of larger whole numbers are shown as decimals.
MOST_IN_FRACTION = 10**9


@dataclass(frozen=True)
class Layout:
    """The terms of every coordinate, and what the names in them stand for.

    Attributes:
        form: where they are from.
        rows: terms by coordinate.
        shorthands: names for long rates and frequencies.
        digits: of decimals, or None where numbers are exact.
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
    def assumptions(self) -> list[sympy.Expr]:
        """What must not vanish, as far as it need not be positive anyway."""
        known = {abs_of for each in self.form.positive for abs_of in (each, -each, sympy.expand(-each))}
        return [self.short(each) for each in self.form.assumptions if each not in known and sympy.expand(each) not in known]

    @property
    def positive(self) -> list[sympy.Expr]:
        """What must be positive."""
        return [self.short(each) for each in self.form.positive]

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
