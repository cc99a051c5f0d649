"""A formula as text for a terminal, as LaTeX and as MathML, with sympy's printers, and as plain data.

Common to all three: roots of one product are joined, t comes in front of the offset of a delay, and parameters have the names that the
user wrote, which are never more than names.
"""

from __future__ import annotations

import html
import re
import unicodedata
from collections.abc import Callable
from dataclasses import replace
from itertools import chain
from typing import Any

import sympy
from sympy.core.relational import Relational
from sympy.logic.boolalg import BooleanAtom
from sympy.printing.latex import LatexPrinter
from sympy.printing.mathml import MathMLPresentationPrinter
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.pretty.pretty_symbology import greek_letters, greek_unicode
from sympy.printing.str import StrPrinter

from .closed_form import LAST, ClosedForm, Derivative, Part, Term, is_long, laid_out, readable


class Notation:
    """A printer of sympy becomes one of formulas: of the given one, whose parameters, time and values at 0- have names."""

    times, equal, unequal, greater = " ", " = ", " is not ", " > "
    zero, minus, enclosed, at_start, step = "0", "-", "({})", "(0-)", "H({})"

    doprint: Callable[..., Any]  # of sympy's printer

    def __init__(self, form: ClosedForm | None = None):
        super().__init__()
        self.form, self.names, self.starts = form, {}, {}
        if form is not None:
            self.names = {LAST: form.time.name, **{p.symbol: p.name for p in form.parameters}}
            conditions = set().union(*(each.free_symbols for each in (*form.admissible, *form.continuous))) - set(self.names)
            starts = {symbol: re.fullmatch(r"(.*)_([0-9]+)", symbol.name) for symbol in conditions}  # x1_0, x1_1, ...
            self.starts = {symbol: (start[1], int(start[2])) for symbol, start in starts.items() if start}

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
        parts = []
        for term in terms:
            minus = term.coefficient.could_extract_minus_sign()
            parts.append(("-", self.term(Term(-term.coefficient, term.function))) if minus else ("+", self.term(term)))
        (sign, first), *others = parts or [("+", self.zero)]
        return (self.minus if sign == "-" else "") + first, [self._infix(sign) + text for sign, text in others]

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
        return "".join(map(self.part, parts))

    def _print_Symbol(self, symbol, style="plain"):
        if symbol in self.starts:
            return self._raw(self._derivative(*self.starts[symbol]) + self.at_start)
        return self._raw(self._factor(self.names.get(symbol, symbol.name)))

    def _print_Mul(self, expr):
        joined = joined_roots(expr)
        if joined.is_Mul or joined is expr:  # sympy prints a reciprocal by this, too
            return super()._print_Mul(joined)
        return self._print(joined)

    def _decimal(self, mantissa: str, exponent: str) -> str:
        """A decimal, with an exponent or an empty text."""
        return f"{mantissa}e{exponent}" if exponent else mantissa

    def _impulse(self, order: int, argument: str) -> str:
        raise NotImplementedError

    def _raw(self, text: str) -> Any:
        """A text as what the methods of sympy's printer return."""
        return text

    def _print_Float(self, number):
        mantissa, e, exponent = str(number).partition("e")  # without zeros at its end
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        return self._raw(self._decimal(mantissa, str(int(exponent)) if e else ""))

    def _print_Heaviside(self, step, exp=None):
        return self._raw(self.step.format(self.doprint(step.args[0])))

    def _print_DiracDelta(self, delta, exp=None):
        order = int(delta.args[1]) if len(delta.args) > 1 else 0
        return self._raw(self._impulse(order, self.doprint(delta.args[0])))

    def _as_ordered_terms(self, expr, order=None) -> list[sympy.Expr]:
        """t - T instead of -T + t, as what functions are of."""
        return sorted(super()._as_ordered_terms(expr, order), key=lambda term: not term.has(LAST))


def joined_roots(product: sympy.Expr) -> sympy.Expr:
    """sqrt(k)/sqrt(m), as sympy has it, as sqrt(k/m), not evaluated."""
    roots = [part for part in product.args if part.is_Pow and abs(part.exp) == sympy.S.Half and not part.is_number]
    above = [part.base for part in roots if part.exp > 0]
    below = [part.base for part in roots if part.exp < 0]
    if not (product.is_Mul and above and below):
        return product
    root = sympy.Pow(sympy.Mul(*above) / sympy.Mul(*below), sympy.S.Half, evaluate=False)
    rest = [part for part in product.args if part not in roots]
    return sympy.Mul(*rest, root, evaluate=False) if rest else root


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
        return (4 if isinstance(factor, sympy.exp) else 5 if isinstance(factor, sympy.Function) else 2), ""

    return sorted(factors, key=rank)


# Text: products without signs, powers with ^.

#: Formulas of more characters have a line for every term.
LONGEST_LINE = 100


class TextPrinter(Notation, StrPrinter):
    """2 sqrt(5) cos(w t)/3 instead of 2*sqrt(5)*cos(w*t)/3."""

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

    def _impulse(self, order: int, argument: str) -> str:
        return f"δ{'′' * order if order < 4 else f'^({order})'}({argument})"


def formula_text(form: ClosedForm, digits: int | None = None) -> str:
    """x(t) as text: a line for each coordinate, or for each term of a long one, then what else belongs to it."""
    layout, printer, lines = laid_out(form, digits), TextPrinter(form), []
    for name, row in zip(form.names, layout.rows):
        first, others = printer.terms(row)
        head = f"{name}({form.time.name}) = {first}"
        line = head + "".join(others)
        lines.append(line if len(line) <= LONGEST_LINE or not others else "\n   ".join([head, *others]))
    blocks = [lines, [f"{each.symbol.name} = {printer.doprint(each.value)}" for each in layout.shorthands]]
    blocks.append([printer.statement(parts) for parts in chain(*layout.statements.values())])
    return "\n\n".join("\n".join(lines) for lines in blocks if lines)


# LaTeX. Names are a letter or a Greek letter with an index, or a word.

_GREEK = ["lambda" if letter == "lamda" else letter for letter in greek_letters]
_LATEX_GREEK = frozenset([*_GREEK, "Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi", "Omega"]) - {
    "omicron"
}
_INDEXED = re.compile(rf"([A-Za-z]|{'|'.join(sorted(_LATEX_GREEK))})_?([0-9]+|(?<=_)[A-Za-z0-9]+)")
LETTERS = {name: greek_unicode[name] for name in _LATEX_GREEK}  # by the names that are written for them
_LATEX_SPECIAL = {
    "\\": r"\backslash{}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#", "_": r"\_", "%": r"\%",
    "^": r"\hat{}", "~": r"\sim{}", " ": r"\ ", "-": r"\text{-}", "'": "'",
}  # fmt: skip


def ascii_letters(letter: str) -> str:
    """ASCII for a letter: Greek ones by their names, accents left out, others by their numbers."""
    if letter.isascii():
        return letter
    words = unicodedata.name(letter, "").lower().split()
    if words[:1] == ["greek"] and words[3:4] and words[3] in (*_GREEK, "lamda"):
        word = "lambda" if words[3] == "lamda" else words[3]
        return word.capitalize() if words[1] == "capital" else word
    stripped = unicodedata.normalize("NFKD", letter).encode("ascii", "ignore").decode()
    return stripped or (f"u{ord(letter):x}" if letter.isalpha() else "_")


def index_of(name: str) -> tuple[str, str]:
    """A letter, or the name of a Greek one, and the index behind it; the name and an empty text otherwise."""
    word = ascii_letters(name[:1]) if name and not name[0].isascii() else ""
    if word in LETTERS and re.fullmatch(r"[0-9_]*", name[1:]):
        name = word + name[1:]
    parts = _INDEXED.fullmatch(name)
    return (parts[1], parts[2]) if parts else (name, "")


def latex_name(name: str) -> str:
    r"""A name as LaTeX: its letter, a Greek letter, a number behind it as an index, anything else upright."""
    letter, index = index_of(name)
    if index:
        shown = index if index.isdigit() else rf"\mathrm{{{index}}}"
        return f"{latex_name(letter)}_{{{shown}}}"
    if letter in _LATEX_GREEK:
        return f"\\{letter}"
    if len(name) == 1 and name.isascii() and name.isalpha():
        return name

    def written(letter: str) -> str:  # Greek letters by their names, others beyond ASCII as text, which is what LaTeX knows them in
        word = ascii_letters(letter)
        if letter.isascii():
            return _LATEX_SPECIAL.get(letter, letter)
        return rf"\{word}{{}}" if word in _LATEX_GREEK else rf"\text{{{letter}}}"

    return rf"\mathrm{{{''.join(map(written, name))}}}"


class FormulaPrinter(Notation, LatexPrinter):
    """LaTeX with the names of parameters and without zeros at the end of decimals."""

    unequal, enclosed, at_start, step = r" \neq ", r"\left({}\right)", "(0^-)", r"H\left({}\right)"

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

    def _decimal(self, mantissa: str, exponent: str) -> str:
        return rf"{mantissa} \cdot 10^{{{exponent}}}" if exponent else mantissa

    def _impulse(self, order: int, argument: str) -> str:
        primes = "'" * order if order < 4 else f"^{{({order})}}"
        return rf"\delta{primes}({argument})"


def latex(form: ClosedForm, digits: int | None = None) -> str:
    """x(t) as an align* environment, for which a document needs the package amsmath."""
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


# MathML.

_DOTS = ("&#729;", "&#168;", "&#8411;")


class MarkupPrinter(Notation, MathMLPresentationPrinter):
    """MathML, which browsers show as it is; all names are escaped."""

    times, zero, minus = "<mo>&InvisibleTimes;</mo>", "<mn>0</mn>", "<mo>&#x2212;</mo>"
    enclosed, at_start = "<mrow><mo>(</mo>{}<mo>)</mo></mrow>", "<mo>(</mo><msup><mn>0</mn><mo>-</mo></msup><mo>)</mo>"
    equal, unequal, greater = "<mo>=</mo>", "<mo>&#x2260;</mo>", "<mo>&gt;</mo>"
    step = "<mrow><mi>H</mi><mo>(</mo>{}<mo>)</mo></mrow>"

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
        return f"<mtext>{re.sub(r'^ | $', '&#xA0;', html.escape(text))}</mtext>"

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

    def _decimal(self, mantissa: str, exponent: str) -> str:
        power = f"<mo>&#xB7;</mo><msup><mn>10</mn><mn>{exponent}</mn></msup>"
        return f"<mrow><mn>{mantissa}</mn>{power}</mrow>" if exponent else f"<mn>{mantissa}</mn>"

    def _impulse(self, order: int, argument: str) -> str:
        primes = f"<mo>{'&#x2032;' * order}</mo>" if order < 4 else f"<mrow><mo>(</mo><mn>{order}</mn><mo>)</mo></mrow>"
        symbol = f"<msup><mi>&#x3B4;</mi>{primes}</msup>" if order else "<mi>&#x3B4;</mi>"
        return f"{symbol}<mo>(</mo>{argument}<mo>)</mo>"

    def _print_Exp1(self, e):
        return self._raw("<mi>e</mi>")

    def _raw(self, markup: str):
        """A node with this markup in it: the text nodes of sympy's printer are written as they are."""
        return self.dom.createTextNode(markup)


def mathml(form: ClosedForm, digits: int | None = None) -> tuple[str, ...]:
    """x(t) as elements <math>: one for each coordinate, then one for each abbreviation, jump, impulse, condition and assumption."""
    layout, printer, rows = laid_out(form, digits), MarkupPrinter(form), []
    for name, terms in zip(form.names, layout.rows):
        head = f"{printer._name(name)}<mo>(</mo>{printer.doprint(form.time)}<mo>)</mo>"
        first, others = printer.terms(terms)
        lines = (
            [(head, "=", first), *(("", "", text) for text in others)] if is_long(terms) else [(head, "=", first + "".join(others))]
        )
        rows.append(_table(lines))
    rows += [_table([(printer._name(each.symbol.name), "=", printer.doprint(each.value))]) for each in layout.shorthands]
    rows += [f"<mrow>{printer.statement(parts)}</mrow>" for parts in chain(*layout.statements.values())]
    minus = ("<mo>-</mo>", "<mo>&#x2212;</mo>")  # a true minus sign
    return tuple(f'<math display="block">{row.replace(*minus)}</math>' for row in rows)


def _table(lines: list[tuple[str, str, str]]) -> str:
    rows = [
        f"<mtr><mtd>{left}</mtd><mtd>{f'<mo>{sign}</mo>' if sign else ''}</mtd><mtd>{right}</mtd></mtr>"
        for left, sign, right in lines
    ]
    return f'<mtable displaystyle="true">{"".join(rows)}</mtable>'


def records(form: ClosedForm, digits: int | None = None) -> dict:
    """A formula as texts, lists and numbers only."""
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
            {"of": each.name, "order": each.order, "time": text_of(each.time), "factor": text_of(each.size)}
            for each in form.impulses
        ],
        "jumps": [{"of": printer.part(Derivative(each.name, each.order)), "size": text_of(each.size)} for each in form.jumps],
        "no_impulses_if": [printer.part(each) for each in form.admissible],
        "no_jumps_if": [printer.part(each) for each in form.continuous],
        "not_zero": [printer.doprint(each) for each in form.assumptions],
        "positive": [printer.doprint(each) for each in form.positive],
    }
