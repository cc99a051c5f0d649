"""A formula as LaTeX."""

from __future__ import annotations

from collections.abc import Sequence

from sympy.printing.latex import LatexPrinter

from .closed_form import ClosedForm
from .identifiers import latex_name
from .layout import Layout, is_long, laid_out, readable, signed, value_at_start
from .terms import LAST, Term
from .text_printer import ReadableProducts, short_decimal


class FormulaPrinter(ReadableProducts, LatexPrinter):
    """sympy's printer, with the names of parameters and without zeros at the end of decimals."""

    def _print_Float(self, number) -> str:
        mantissa, e, exponent = short_decimal(number).partition("e")
        return rf"{mantissa} \cdot 10^{{{exponent}}}" if e else mantissa

    def _print_Heaviside(self, step, exp=None) -> str:
        return rf"H\left({self._print(step.args[0])}\right)"


def latex(x, names: Sequence[str] | None = None, digits: int | None = None) -> str:
    r"""x(t) as an align* environment, for which a document needs the package amsmath.

    Args:
        x: a ``SymbolicResponse`` or a ``ClosedForm``.
        names: of the coordinates, where they are not to be called as in x.
        digits: None for exact numbers and symbols; else the default values are put in and decimals have so many digits.

    >>> import sympy
    >>> t, k = sympy.symbols("t k", positive=True)
    >>> print(latex(ClosedForm(("x1",), (2 * sympy.cos(sympy.sqrt(k) * t) / 3,), t)))
    \begin{align*}
    x_{1}(t) &= \frac{2}{3} \cos{\left(\sqrt{k} t \right)}
    \end{align*}
    """
    form = ClosedForm.of(x, names)
    layout, printer = laid_out(form, digits), latex_printer(form, digits)
    lines = [_row(name, row, printer, form) for name, row in zip(form.names, layout.rows)]
    lines += [f"{printer.doprint(each.symbol)} &= {printer.doprint(each.value)}" for each in layout.shorthands]
    lines += _happenings(layout, printer)
    return "\\begin{align*}\n" + " \\\\\n".join(lines) + "\n\\end{align*}"


def latex_printer(form: ClosedForm, digits: int | None = None) -> FormulaPrinter:
    """Prints with the names of parameters, shorthands and values at 0-."""
    names = {LAST: form.time.name, **{p.symbol: _factor(p.name) for p in form.parameters}}
    for equation in (*form.admissible, *form.continuous):
        for symbol in equation.free_symbols - set(names):
            if found := value_at_start(symbol.name):
                names[symbol] = f"{derivative_latex(*found)}(0^-)"
    names |= {symbol: _factor(symbol.name) for symbol in form.symbols - set(names)}
    return FormulaPrinter({"symbol_names": names, "mul_symbol": None, "fold_short_frac": False})


def _factor(name: str) -> str:
    """A name in a product: a word keeps its distance."""
    return (
        latex_name(name).replace("\\mathrm{", "\\operatorname{", 1) if latex_name(name).startswith("\\mathrm") else latex_name(name)
    )


def derivative_latex(name: str, order: int) -> str:
    r"""A coordinate with dots.

    >>> derivative_latex("x1", 2), derivative_latex("x1", 4)
    ('\\ddot{x}_{1}', 'x_{1}^{(4)}')
    """
    plain = latex_name(name)
    if order == 0:
        return plain
    if order > 3:
        return f"{plain}^{{({order})}}"
    letter, line, index = plain.partition("_{") if not plain.startswith("\\mathrm") else (plain, "", "")
    return f"\\{'d' * order}ot{{{letter}}}{line}{index}"


def term_latex(term: Term, printer: FormulaPrinter) -> str:
    """coefficient function."""
    coefficient, function = term.coefficient, term.function
    if function == 1:
        return printer.doprint(coefficient)
    if coefficient == 1:
        return printer.doprint(function)
    if coefficient.is_Add:
        return rf"\left({printer.doprint(coefficient)}\right) {printer.doprint(function)}"
    return f"{printer.doprint(coefficient)} {printer.doprint(function)}"


def _row(name: str, terms: list[Term], printer: FormulaPrinter, form: ClosedForm) -> str:
    parts = [(sign, term_latex(term, printer)) for sign, term in map(signed, terms)] or [("+", "0")]
    between = " \\\\\n&\\quad {}" if is_long(terms) else " "
    first = f"{'-' if parts[0][0] == '-' else ''}{parts[0][1]}"
    return f"{latex_name(name)}({form.time.name}) &= {first}" + "".join(f"{between}{sign} {text}" for sign, text in parts[1:])


def _happenings(layout: Layout, printer: FormulaPrinter) -> list[str]:
    form, tell = layout.form, lambda expression: printer.doprint(layout.number(expression))
    jumps = [(derivative_latex(each.name, each.order), tell(each.size)) for each in form.jumps]
    lines = [rf"{name}(0^+) - {name}(0^-) &= {size}" for name, size in jumps]
    lines += [_impulse(each, layout, tell) for each in form.impulses]
    lines += [_condition(each, printer, "no impulses if ") for each in form.admissible]
    lines += [_condition(each, printer, "no jumps if ") for each in form.continuous]
    lines += [rf"&\text{{holds where }} {printer.doprint(each)} \neq 0" for each in layout.assumptions]
    return lines + [rf"&\text{{real in this form where }} {printer.doprint(each)} > 0" for each in layout.positive]


def _impulse(impulse, layout: Layout, tell) -> str:
    time = layout.number(impulse.time)
    when = layout.form.time.name if time == 0 else f"{layout.form.time.name} - \\left({tell(time)}\\right)"
    factor = rf"\left({tell(impulse.factor)}\right)" if impulse.factor.is_Add else tell(impulse.factor)
    primes = "'" * impulse.order if impulse.order < 4 else f"^{{({impulse.order})}}"
    return rf"&{latex_name(impulse.name)}\text{{ has the impulse }} {factor}\, \delta{primes}({when})"


def _condition(equation, printer: FormulaPrinter, words: str) -> str:
    if equation in (True, False):
        return rf"&\text{{{words}{'always' if equation else 'never'}}}"
    return rf"&\text{{{words}}} {printer.doprint(equation.lhs)} = {printer.doprint(readable(equation.rhs))}"
