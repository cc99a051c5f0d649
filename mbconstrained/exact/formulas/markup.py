"""A formula as LaTeX and as MathML, with sympy's printers, and as plain data."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain

import sympy
from sympy.printing.latex import LatexPrinter
from sympy.printing.mathml import MathMLPresentationPrinter

from .closed_form import ClosedForm
from .formula_text import Notation, TextPrinter, formula_text, in_reading_order, joined_roots, short_decimal
from .identifiers import LETTERS, index_of, latex_name
from .printing_layout import Derivative, Term, is_long, laid_out


class FormulaPrinter(Notation, LatexPrinter):
    """LaTeX with the names of parameters and without zeros at the end of decimals."""

    unequal, enclosed, at_start = r" \neq ", r"\left({}\right)", "(0^-)"

    def _name(self, name: str) -> str:
        return latex_name(name)

    def _factor(self, name: str) -> str:
        symbol = latex_name(name)
        return symbol.replace("\\mathrm{", "\\operatorname{", 1) if symbol.startswith("\\mathrm") else symbol

    def _derivative(self, name: str, order: int) -> str:
        symbol = latex_name(name)
        if order == 0:
            return symbol
        if order > 3:
            return f"{symbol}^{{({order})}}"
        letter, line, index = symbol.partition("_{") if not symbol.startswith("\\mathrm") else (symbol, "", "")
        return f"\\{'d' * order}ot{{{letter}}}{line}{index}"

    def _words(self, text: str) -> str:
        return rf"\text{{{text}}} "

    def _print_Float(self, number) -> str:
        mantissa, e, exponent = short_decimal(number).partition("e")
        return rf"{mantissa} \cdot 10^{{{exponent}}}" if e else mantissa

    def _print_Heaviside(self, step, exp=None) -> str:
        return rf"H\left({self._print(step.args[0])}\right)"

    def _print_DiracDelta(self, delta, exp=None) -> str:
        order = int(delta.args[1]) if len(delta.args) > 1 else 0
        primes = "'" * order if order < 4 else f"^{{({order})}}"
        return rf"\delta{primes}({self._print(delta.args[0])})"


def latex(x, names: Sequence[str] | None = None, digits: int | None = None) -> str:
    r"""x(t) as an align* environment, for which a document needs the package amsmath.

    >>> import sympy
    >>> t, k = sympy.symbols("t k", positive=True)
    >>> print(latex(ClosedForm(("x1",), (2 * sympy.cos(sympy.sqrt(k) * t) / 3,), t)))
    \begin{align*}
    x_{1}(t) &= \frac{2}{3} \cos{\left(\sqrt{k} t \right)}
    \end{align*}
    """
    form = ClosedForm.of(x, names)
    layout, printer = laid_out(form, digits), FormulaPrinter(form)
    lines = []
    for name, row in zip(form.names, layout.rows):
        first, others = printer.terms(row)
        between = " \\\\\n&\\quad {}" if is_long(row) else " "
        lines.append(f"{latex_name(name)}({form.time.name}) &= " + between.join([first, *(each.lstrip() for each in others)]))
    lines += [f"{printer.doprint(each.symbol)} &= {printer.doprint(each.value)}" for each in layout.shorthands]
    statements = layout.statements
    jumps = [map(printer.part, (name, name, size)) for name, _, size in statements.pop("jumps")]
    lines += ["{}(0^+) - {}(0^-) &= {}".format(*jump) for jump in jumps]
    lines += [f"&{printer.statement(parts)}" for parts in chain(*statements.values())]
    return "\\begin{align*}\n" + " \\\\\n".join(lines) + "\n\\end{align*}"


_DOTS = ("&#729;", "&#168;", "&#8411;")


class MarkupPrinter(Notation, MathMLPresentationPrinter):
    """MathML, which browsers show as it is; all names are escaped.

    >>> MarkupPrinter().doprint(sympy.Symbol("k<1"))
    '<mrow><mspace width="0.17em"></mspace><mi mathvariant="normal">k&lt;1</mi><mspace width="0.17em"></mspace></mrow>'
    """

    times, zero, minus = "<mo>&InvisibleTimes;</mo>", "<mn>0</mn>", "<mo>&#x2212;</mo>"
    enclosed, at_start = "<mrow><mo>(</mo>{}<mo>)</mo></mrow>", "<mo>(</mo><msup><mn>0</mn><mo>-</mo></msup><mo>)</mo>"
    equal, unequal, greater = "<mo>=</mo>", "<mo>&#x2260;</mo>", "<mo>&gt;</mo>"

    def _name(self, name: str) -> str:
        letter, index = index_of(name)
        if index:
            kind = "mn" if index.isdigit() else "mi"
            return f"<msub>{self._name(letter)}<{kind}>{index}</{kind}></msub>"
        if letter in LETTERS:
            return f"<mi>{LETTERS[letter]}</mi>"
        upright = "" if len(name) == 1 else ' mathvariant="normal"'
        return f"<mi{upright}>{html.escape(name)}</mi>"

    def _factor(self, name: str) -> str:
        markup, gap = self._name(name), '<mspace width="0.17em"></mspace>'
        return f"<mrow>{gap}{markup}{gap}</mrow>" if markup.startswith("<mi mathvariant") else markup

    def _derivative(self, name: str, order: int) -> str:
        if order == 0:
            return self._name(name)
        if order > 3:
            return f"<msup>{self._name(name)}<mrow><mo>(</mo><mn>{order}</mn><mo>)</mo></mrow></msup>"
        letter, index = index_of(name)
        dotted = f"<mover>{self._name(letter)}<mo>{_DOTS[order - 1]}</mo></mover>"
        return f"<msub>{dotted}<mi>{index}</mi></msub>" if index else dotted

    def _words(self, text: str) -> str:
        spaced = re.sub(r"^ | $", "&#xA0;", html.escape(text))
        return f"<mtext>{spaced}</mtext>"

    def _function(self, function: sympy.Expr) -> str:
        """Factors of a function, printed one by one: sympy's printer would put e^{-a t} below a line."""
        return self.times.join(self.doprint(factor) for factor in in_reading_order(sympy.Mul.make_args(function)))

    def _infix(self, sign: str) -> str:
        return f'<mo form="infix">{"&#x2212;" if sign == "-" else "+"}</mo>'

    def parenthesize(self, item, level, strict=False):
        """Parenthesize as sympy's printer does, except roots, also those that sympy represents as a product."""
        joined = joined_roots(item)
        if joined.is_Pow and joined.exp == sympy.S.Half:
            return self._print(joined)
        return super().parenthesize(item, level, strict)

    def _print_Symbol(self, symbol, style="plain"):
        return self._raw(super()._print_Symbol(symbol))

    def _print_Float(self, expr):
        mantissa, e, exponent = short_decimal(expr).partition("e")
        power = f"<mo>&#xB7;</mo><msup><mn>10</mn><mn>{exponent}</mn></msup>"
        return self._raw(f"<mrow><mn>{mantissa}</mn>{power}</mrow>" if e else f"<mn>{mantissa}</mn>")

    def _print_Heaviside(self, e):
        return self._raw(f"<mrow><mi>H</mi><mo>(</mo>{self.doprint(e.args[0])}<mo>)</mo></mrow>")

    def _print_DiracDelta(self, e):
        order, symbol = int(e.args[1]) if len(e.args) > 1 else 0, "<mi>&#x3B4;</mi>"
        primes = f"<mo>{'&#x2032;' * order}</mo>" if order < 4 else f"<mrow><mo>(</mo><mn>{order}</mn><mo>)</mo></mrow>"
        symbol = f"<msup>{symbol}{primes}</msup>" if order else symbol
        return self._raw(f"{symbol}<mo>(</mo>{self.doprint(e.args[0])}<mo>)</mo>")

    def _print_Exp1(self, e):
        return self._raw("<mi>e</mi>")

    def _raw(self, markup: str):
        """A node with this markup in it: the text nodes of sympy's printer are written as they are."""
        return self.dom.createTextNode(markup)


def mathml(x, names: Sequence[str] | None = None, digits: int | None = None) -> tuple[str, ...]:
    """x(t) as elements <math>: one for each coordinate, then one for each abbreviation, jump, impulse, condition and assumption.

    >>> t = sympy.Symbol("t")
    >>> mathml(ClosedForm(("x1",), (t,), t))[0].startswith('<math display="block"><mtable displaystyle="true"><mtr>')
    True
    """
    form = ClosedForm.of(x, names)
    layout, printer = laid_out(form, digits), MarkupPrinter(form)
    rows = [_coordinate(name, row, printer) for name, row in zip(form.names, layout.rows)]
    rows += [_table([(printer._name(each.symbol.name), "=", printer.doprint(each.value))]) for each in layout.shorthands]
    rows += [f"<mrow>{printer.statement(parts)}</mrow>" for parts in chain(*layout.statements.values())]
    minus = ("<mo>-</mo>", "<mo>&#x2212;</mo>")  # a true minus sign
    return tuple(f'<math display="block">{row.replace(*minus)}</math>' for row in rows)


def _coordinate(name: str, terms: list[Term], printer: MarkupPrinter) -> str:
    head = f"{printer._name(name)}<mo>(</mo>{printer.doprint(printer.form.time)}<mo>)</mo>"
    first, others = printer.terms(terms)
    if is_long(terms):
        return _table([(head, "=", first), *(("", "", text) for text in others)])
    return _table([(head, "=", first + "".join(others))])


def _table(lines: list[tuple[str, str, str]]) -> str:
    rows = [
        f"<mtr><mtd>{left}</mtd><mtd>{f'<mo>{sign}</mo>' if sign else ''}</mtd><mtd>{right}</mtd></mtr>"
        for left, sign, right in lines
    ]
    return f'<mtable displaystyle="true">{"".join(rows)}</mtable>'


# A formula as texts, lists and numbers.


def records(form: ClosedForm, digits: int | None = None) -> dict:
    """Texts, lists and numbers only.

    >>> import sympy
    >>> t = sympy.Symbol("t")
    >>> records(ClosedForm(("x1",), (2 * t,), t))["formulas"]["x1"]["text"]
    'x1(t) = 2 t'
    """
    layout, printer = laid_out(form, digits), TextPrinter(form)
    bare = replace(form, impulses=(), jumps=(), admissible=(), continuous=(), assumptions=(), positive=())

    def text_of(expression) -> str:
        return printer.doprint(layout.number(expression))

    return {
        "title": form.title,
        "parameters": {p.name: {"value": None if p.value is None else float(p.value), "unit": p.unit} for p in form.parameters},
        "formulas": {
            name: {"text": formula_text(bare.only([name]), digits=digits), "latex": latex(bare.only([name]), digits=digits)}
            for name in form.names
        },
        "impulses": [
            {"of": each.name, "order": each.order, "time": text_of(each.time), "factor": text_of(each.factor)}
            for each in form.impulses
        ],
        "jumps": [{"of": printer.part(Derivative(each.name, each.order)), "size": text_of(each.size)} for each in form.jumps],
        "no_impulses_if": [printer.part(each) for each in form.admissible],
        "no_jumps_if": [printer.part(each) for each in form.continuous],
        "not_zero": [printer.doprint(each) for each in form.assumptions],
        "positive": [printer.doprint(each) for each in form.positive],
    }
