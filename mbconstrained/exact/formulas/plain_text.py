"""A formula as text for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

import sympy

from .closed_form import ClosedForm
from .layout import Layout, laid_out, readable, signed, value_at_start
from .terms import LAST, Term
from .text_printer import TextPrinter, delta_name

#: Formulas of more characters have a line for every term.
LONGEST_LINE = 100


def plain_text(x, names: Sequence[str] | None = None, digits: int | None = None) -> str:
    """x(t) as text: a line for each coordinate, or for each term of a long one, then what else belongs to it.

    Args:
        x: a ``SymbolicResponse`` or a ``ClosedForm``.
        names: of the coordinates, where they are not to be called as in x.
        digits: None for exact numbers and symbols; else the default values are put in and decimals have so many digits.

    >>> t, k = sympy.symbols("t k", positive=True)
    >>> print(plain_text(ClosedForm(("x1",), (2 * sympy.cos(sympy.sqrt(k) * t) / 3,), t)))
    x1(t) = 2/3 cos(sqrt(k) t)
    """
    form = ClosedForm.of(x, names)
    layout, printer = laid_out(form, digits), text_printer(form)
    blocks = [[_row(name, row, printer, form) for name, row in zip(form.names, layout.rows)]]
    blocks.append([f"{each.symbol.name} = {printer.doprint(each.value)}" for each in layout.shorthands])
    blocks.append(_happenings(layout, printer))
    return "\n\n".join("\n".join(lines) for lines in blocks if lines)


def text_printer(form: ClosedForm) -> TextPrinter:
    """Prints with the names of the parameters, and values at 0- as x1(0-), x1'(0-), …."""
    names = {LAST: form.time.name, **{p.symbol: p.name for p in form.parameters}}
    for equation in (*form.admissible, *form.continuous):
        for symbol in equation.free_symbols - set(names):
            if found := value_at_start(symbol.name):
                names[symbol] = f"{derivative_name(*found)}(0-)"
    return TextPrinter(names)


def derivative_name(name: str, order: int) -> str:
    """x, x', x'', x''', x^(4)."""
    return name + ("'" * order if order < 4 else f"^({order})")


def equation_text(equation, printer: TextPrinter) -> str:
    """left = right; what cannot be fulfilled, or always is, in words."""
    if equation in (True, False):
        return "always" if equation else "never"
    return f"{printer.doprint(equation.lhs)} = {printer.doprint(readable(equation.rhs))}"


def term_text(term: Term, printer: TextPrinter) -> str:
    """coefficient function."""
    coefficient, function = term.coefficient, term.function
    if function == 1:
        return printer.doprint(coefficient)
    if coefficient == 1:
        return printer.doprint(function)
    if coefficient.is_Add:
        return f"({printer.doprint(coefficient)}) {printer.doprint(function)}"
    if coefficient.is_number:
        text = printer.doprint(coefficient)
        return f"{text} {printer.doprint(function)}"
    return printer.doprint(sympy.Mul(coefficient, function))


def _row(name: str, terms: list[Term], printer: TextPrinter, form: ClosedForm) -> str:
    head = f"{name}({form.time.name}) ="
    parts = [(sign, term_text(term, printer)) for sign, term in map(signed, terms)] or [("+", "0")]
    line = " ".join(f"{sign} {text}" for sign, text in parts)
    line = line.removeprefix("+ ") if parts[0][0] == "+" else f"-{line[2:]}"
    if len(head) + len(line) < LONGEST_LINE or len(parts) == 1:
        return f"{head} {line}"
    first, rest = parts[0], parts[1:]
    lines = [f"{head} {'-' if first[0] == '-' else ''}{first[1]}"]
    return "\n".join([*lines, *(f"    {sign} {text}" for sign, text in rest)])


def _happenings(layout: Layout, printer: TextPrinter) -> list[str]:
    form = layout.form
    lines = [f"{jump_text(each, layout, printer)}" for each in form.jumps]
    lines += [impulse_text(each, layout, printer) for each in form.impulses]
    lines += [f"no impulses if {equation_text(each, printer)}" for each in form.admissible]
    lines += [f"no jumps if {equation_text(each, printer)}" for each in form.continuous]
    lines += [f"holds where {printer.doprint(each)} is not 0" for each in layout.assumptions]
    return lines + [f"real in this form where {printer.doprint(each)} > 0" for each in layout.positive]


def jump_text(jump, layout: Layout, printer: TextPrinter) -> str:
    """By how much a coordinate or a derivative of it jumps."""
    return f"{derivative_name(jump.name, jump.order)} jumps at t = 0 by {printer.doprint(layout.number(jump.size))}"


def impulse_text(impulse, layout: Layout, printer: TextPrinter) -> str:
    """An impulse as an additional term."""
    factor = printer.doprint(layout.number(impulse.factor))
    factor = f"({factor})" if impulse.factor.is_Add and layout.digits is None else factor
    time = layout.number(impulse.time)
    when = layout.form.time.name if time == 0 else f"{layout.form.time.name} - {printer.parenthesize(time, 40)}"
    return f"{impulse.name} has the impulse {factor} {delta_name(impulse.order)}({when})"
