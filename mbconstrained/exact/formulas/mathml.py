"""A formula as MathML, which browsers show as it is; all names are escaped."""

from __future__ import annotations

import html
import re
from collections.abc import Mapping, Sequence

import sympy
from sympy.printing.mathml import MathMLPresentationPrinter

from .closed_form import ClosedForm
from .identifiers import LETTERS, index_of
from .layout import Layout, is_long, laid_out, readable, signed, value_at_start
from .terms import LAST, Term
from .text_printer import ReadableProducts, in_reading_order, joined_roots, short_decimal


class MarkupPrinter(ReadableProducts, MathMLPresentationPrinter):
    """sympy's printer with the names of parameters, escaped.

    Args:
        names: what symbols are called, those of values at 0- with the order of the derivative.

    >>> MarkupPrinter().doprint(sympy.Symbol("k<1"))
    '<mrow><mspace width="0.17em"></mspace><mi mathvariant="normal">k&lt;1</mi><mspace width="0.17em"></mspace></mrow>'
    """

    def __init__(
        self, names: Mapping[sympy.Symbol, str] | None = None, starts: Mapping[sympy.Symbol, tuple[str, int]] | None = None
    ):
        super().__init__()
        self.names, self.starts = names or {}, starts or {}

    def _print_Symbol(self, symbol, style="plain"):
        if symbol in self.starts:
            return self._raw(f"{derivative_markup(*self.starts[symbol])}{_START}")
        markup = name_markup(self.names.get(symbol, symbol.name))
        return self._raw(f"<mrow>{_GAP}{markup}{_GAP}</mrow>" if markup.startswith("<mi mathvariant") else markup)

    def _print_Float(self, expr):
        mantissa, e, exponent = short_decimal(expr).partition("e")
        power = f"<mo>&#xB7;</mo><msup><mn>10</mn><mn>{exponent}</mn></msup>"
        return self._raw(f"<mrow><mn>{mantissa}</mn>{power}</mrow>" if e else f"<mn>{mantissa}</mn>")

    def _print_Heaviside(self, e):
        return self._raw(f"<mrow><mi>H</mi><mo>(</mo>{self.doprint(e.args[0])}<mo>)</mo></mrow>")

    def _print_Exp1(self, e):
        return self._raw("<mi>e</mi>")

    def parenthesize(self, item, level, strict=False):
        """Roots need none, also those that sympy has as a product."""
        joined = joined_roots(item)
        if joined.is_Pow and joined.exp == sympy.S.Half:
            return self._print(joined)
        return super().parenthesize(item, level, strict)

    def _raw(self, markup: str):
        """A node with this markup in it: the text nodes of sympy's printer are written as they are."""
        return self.dom.createTextNode(markup)


_TIMES = "<mo>&InvisibleTimes;</mo>"
_GAP = '<mspace width="0.17em"></mspace>'  # by which a word keeps its distance in a product
_DOTS = ("&#729;", "&#168;", "&#8411;")
_START = "<mo>(</mo><msup><mn>0</mn><mo>-</mo></msup><mo>)</mo>"


def mathml(x, names: Sequence[str] | None = None, digits: int | None = None) -> tuple[str, ...]:
    """x(t) as elements <math>: one for each coordinate, then one for each abbreviation, jump, impulse, condition and assumption.

    Args:
        x: a ``SymbolicResponse`` or a ``ClosedForm``.
        names: of the coordinates, where they are not to be called as in x.
        digits: None for exact numbers and symbols; else the default values are put in and decimals have so many digits.

    >>> t = sympy.Symbol("t")
    >>> mathml(ClosedForm(("x1",), (t,), t))[0].startswith('<math display="block"><mtable displaystyle="true"><mtr>')
    True
    """
    form = ClosedForm.of(x, names)
    layout, printer = laid_out(form, digits), markup_printer(form)
    rows = [_coordinate(name, row, printer, form) for name, row in zip(form.names, layout.rows)]
    rows += [_math([_line(name_markup(each.symbol.name), "=", printer.doprint(each.value))]) for each in layout.shorthands]
    return tuple(rows + _happenings(layout, printer))


def markup_printer(form: ClosedForm) -> MarkupPrinter:
    """Prints with the names of parameters and values at 0-."""
    names = {LAST: form.time.name, **{p.symbol: p.name for p in form.parameters}}
    unnamed = set().union(*(equation.free_symbols for equation in (*form.admissible, *form.continuous))) - set(names)
    return MarkupPrinter(names, {symbol: found for symbol in unnamed if (found := value_at_start(symbol.name))})


def name_markup(name: str) -> str:
    """A name: its letter, a number behind it as an index, Greek letters by their names; anything else upright.

    >>> name_markup("k1"), name_markup("left <b>")
    ('<msub><mi>k</mi><mn>1</mn></msub>', '<mi mathvariant="normal">left &lt;b&gt;</mi>')
    """
    letter, index = index_of(name)
    if index:
        kind = "mn" if index.isdigit() else "mi"
        return f"<msub>{name_markup(letter)}<{kind}>{index}</{kind}></msub>"
    if letter in LETTERS:
        return f"<mi>{LETTERS[letter]}</mi>"
    if len(name) == 1:
        return f"<mi>{html.escape(name)}</mi>"
    return f'<mi mathvariant="normal">{html.escape(name)}</mi>'


def derivative_markup(name: str, order: int) -> str:
    """A coordinate with dots above."""
    if order == 0:
        return name_markup(name)
    if order > 3:
        return f"<msup>{name_markup(name)}<mrow><mo>(</mo><mn>{order}</mn><mo>)</mo></mrow></msup>"
    letter, index = index_of(name)
    dotted = f"<mover>{name_markup(letter)}<mo>{_DOTS[order - 1]}</mo></mover>"
    return f"<msub>{dotted}<mi>{index}</mi></msub>" if index else dotted


def term_markup(term: Term, printer: MarkupPrinter) -> str:
    """coefficient function."""
    coefficient, function = term.coefficient, term.function
    if function == 1:
        return printer.doprint(coefficient)
    if coefficient == 1:
        return _function(function, printer)
    first = printer.doprint(coefficient)
    if coefficient.is_Add:
        first = f"<mrow><mo>(</mo>{first}<mo>)</mo></mrow>"
    return f"{first}{_TIMES}{_function(function, printer)}"


def _function(function: sympy.Expr, printer: MarkupPrinter) -> str:
    """Its factors one by one: sympy's printer would put e^{-a t} below a line."""
    return _TIMES.join(printer.doprint(factor) for factor in in_reading_order(sympy.Mul.make_args(function)))


def _coordinate(name: str, terms: list[Term], printer: MarkupPrinter, form: ClosedForm) -> str:
    head = f"{name_markup(name)}<mo>(</mo>{printer.doprint(form.time)}<mo>)</mo>"
    parts = [(sign, term_markup(term, printer)) for sign, term in map(signed, terms)] or [("+", "<mn>0</mn>")]
    first = ("<mo>&#x2212;</mo>" if parts[0][0] == "-" else "") + parts[0][1]
    rest = [f'<mo form="infix">{"&#x2212;" if sign == "-" else "+"}</mo>{text}' for sign, text in parts[1:]]
    if is_long(terms):
        return _math([_line(head, "=", first), *(_line("", "", text) for text in rest)])
    return _math([_line(head, "=", first + "".join(rest))])


def _line(left: str, sign: str, right: str) -> str:
    middle = f"<mo>{sign}</mo>" if sign else ""
    return f"<mtr><mtd>{left}</mtd><mtd>{middle}</mtd><mtd>{right}</mtd></mtr>"


def _math(lines: list[str]) -> str:
    return _markup(f'<mtable displaystyle="true">{"".join(lines)}</mtable>')


def _markup(inside: str) -> str:
    """The element, with true minus signs."""
    return f'<math display="block">{inside.replace("<mo>-</mo>", "<mo>&#x2212;</mo>")}</math>'


def _happenings(layout: Layout, printer: MarkupPrinter) -> list[str]:
    form, tell = layout.form, lambda expression: printer.doprint(layout.number(expression))
    rows = [(f"{derivative_markup(each.name, each.order)}{_words(' jumps at t = 0 by ')}{tell(each.size)}") for each in form.jumps]
    rows += [f"{name_markup(each.name)}{_words(' has the impulse ')}{_impulse(each, layout, tell)}" for each in form.impulses]
    rows += [_words("no impulses if ") + _equation(each, printer) for each in form.admissible]
    rows += [_words("no jumps if ") + _equation(each, printer) for each in form.continuous]
    rows += [f"{_words('holds where ')}{printer.doprint(each)}<mo>&#x2260;</mo><mn>0</mn>" for each in layout.assumptions]
    rows += [f"{_words('real in this form where ')}{printer.doprint(each)}<mo>&gt;</mo><mn>0</mn>" for each in layout.positive]
    return [_markup(f"<mrow>{row}</mrow>") for row in rows]


def _words(text: str) -> str:
    spaced = re.sub(r"^ | $", "&#xA0;", html.escape(text))
    return f"<mtext>{spaced}</mtext>"


def _equation(equation, printer: MarkupPrinter) -> str:
    if equation in (True, False):
        return _words("always" if equation else "never")
    return f"{printer.doprint(equation.lhs)}<mo>=</mo>{printer.doprint(readable(equation.rhs))}"


def _impulse(impulse, layout: Layout, tell) -> str:
    time, factor = layout.number(impulse.time), tell(impulse.factor)
    factor = f"<mrow><mo>(</mo>{factor}<mo>)</mo></mrow>" if impulse.factor.is_Add else factor
    primes = f"<mo>{'&#x2032;' * impulse.order}</mo>"
    if impulse.order > 3:
        primes = f"<mrow><mo>(</mo><mn>{impulse.order}</mn><mo>)</mo></mrow>"
    delta = f"<msup><mi>&#x3B4;</mi>{primes}</msup>" if impulse.order else "<mi>&#x3B4;</mi>"
    when = name_markup(layout.form.time.name) + (f"<mo>&#x2212;</mo>{tell(time)}" if time != 0 else "")
    return f"{factor}<mo>&InvisibleTimes;</mo>{delta}<mo>(</mo>{when}<mo>)</mo>"
