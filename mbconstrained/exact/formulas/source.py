"""What the sources in Python and C share: identifiers, numbers that both languages hold, and common subexpressions taken out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import sympy

from .closed_form import ClosedForm
from .divisors import divisors
from .identifiers import identifiers
from .layout import Layout
from .plain_text import impulse_text, jump_text, text_printer
from .squares import with_square

#: Whole numbers up to this are exact in a double.
LARGEST_WHOLE = 2**53

#: Digits of decimals in a source: three more than a double holds, so that it is rounded once.
SOURCE_DIGITS = 20


@dataclass(frozen=True)
class Source:
    """Expressions ready to be printed as a program.

    Attributes:
        form: what is computed.
        parameters: identifiers of the parameters, in their order.
        steps: (identifier, expression) one after the other.
        values: expressions for the coordinates.
    """

    form: ClosedForm
    parameters: dict[str, str]
    steps: tuple[tuple[sympy.Symbol, sympy.Expr], ...]
    values: tuple[sympy.Expr, ...]


def source_of(form: ClosedForm) -> Source:
    """Identifiers for symbols, short numbers, common subexpressions."""
    named = identifiers([p.name for p in form.parameters])
    symbols = {p.symbol: sympy.Symbol(named[p.name], real=True) for p in form.parameters}
    time = {form.time: sympy.Symbol("t", real=True)}
    stable = {below: with_square(below) for below in divisors(form) if below.is_Add}
    values = [_short(value.xreplace(stable)).xreplace({**symbols, **time}) for value in form.values]
    steps, reduced = sympy.cse(values, symbols=_fresh(set(named.values())), optimizations="basic", order="none")
    return Source(form, named, tuple(steps), tuple(reduced))


def _short(value: sympy.Expr) -> sympy.Expr:
    """Fractions of long numbers as decimals, which is what a double makes of them anyway."""
    long = {q: sympy.Float(q, SOURCE_DIGITS) for q in value.atoms(sympy.Rational) if max(abs(q.p), q.q) > LARGEST_WHOLE}
    floats = {f: sympy.Float(f, SOURCE_DIGITS) for f in value.atoms(sympy.Float)}
    return value.xreplace({**long, **floats})


def _fresh(taken: set[str]) -> Iterator[sympy.Symbol]:
    number = 0
    while True:
        if f"c{number}" not in taken:
            yield sympy.Symbol(f"c{number}", real=True)
        number += 1


def default_text(value: sympy.Expr) -> str:
    """A default value as a decimal that a double is read from.

    >>> default_text(sympy.Rational(1, 10)), default_text(sympy.Integer(10))
    ('0.1', '10.0')
    """
    return repr(float(value))


def told(form: ClosedForm) -> list[str]:
    """What a user of the source has to know beside the values, a line each: impulses, jumps, assumptions."""
    layout, printer = Layout(form, [], [], None), text_printer(form)
    lines = [jump_text(each, layout, printer) for each in form.jumps]
    lines += [f"{impulse_text(each, layout, printer)}, which is not in the values" for each in form.impulses]
    lines += [f"holds where {printer.doprint(each)} is not 0" for each in layout.assumptions]
    return lines + [f"real in this form where {printer.doprint(each)} > 0" for each in form.positive]
