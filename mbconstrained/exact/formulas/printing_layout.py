"""Common layout of all printers of formulas: terms with signs, abbreviations, conditions and assumptions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import sympy
from sympy.functions.elementary.hyperbolic import HyperbolicFunction
from sympy.functions.elementary.trigonometric import TrigonometricFunction

from ..symbolic.response.transform import delta
from .closed_form import DIGITS, VANISHING, ClosedForm, Impulse

#: Stands for the time in terms: by its name it comes last in products, w t instead of t w.
LAST = sympy.Symbol("zzzz", real=True)

#: A rate of more operations gets a name of its own, and what is under a root.
SHORT, LONG = 2, 8


@dataclass(frozen=True)
class Term:
    """coefficient, free of t, times a product of powers of t, exponentials, cosines and the like."""

    coefficient: sympy.Expr
    function: sympy.Expr

    @property
    def expression(self) -> sympy.Expr:
        """Product of coefficient and function."""
        return self.coefficient * self.function


@dataclass(frozen=True)
class Shorthand:
    """A name for a rate, an angular frequency or what is under a root."""

    symbol: sympy.Symbol
    value: sympy.Expr
    full: sympy.Expr | None = None


def terms_of(expression: sympy.Expr, t: sympy.Symbol) -> list[Term]:
    """The terms of a sum of products, those with the same function of time together, in order of appearance.

    >>> t, k = sympy.symbols("t k")
    >>> [(each.coefficient, each.function) for each in terms_of((k + 1) * (t + sympy.cos(k * t)) + 2 * t, t)]
    [(k + 3, t), (k + 1, cos(k*t))]
    """
    terms = [Term(coefficient, function) for function, coefficient in _split(expression, t).items() if coefficient != 0]
    return [Term(part, each.function) for each in terms for part in _parts(each)]


def _parts(term: Term) -> tuple[sympy.Expr, ...]:
    """A sum that stands for itself is as many terms."""
    return sympy.Add.make_args(term.coefficient) if term.function == 1 else (term.coefficient,)


def in_order(terms: list[Term], form: ClosedForm) -> list[Term]:
    """Powers of t first, then by ascending frequency and rate with the default values, cosines before sines."""
    return sorted(terms, key=lambda term: _rank(term.function, form))


def _rank(function: sympy.Expr, form: ClosedForm) -> tuple:
    parts = sorted(function.atoms(TrigonometricFunction, HyperbolicFunction, sympy.exp), key=sympy.default_sort_key)
    turning = [part for part in parts if not isinstance(part, sympy.exp)]
    sizes = [_size(form.at_defaults(_rate(part, LAST)[1])) for part in (*turning, *parts)]
    steps = [_size(form.at_defaults(LAST - step.args[0])) for step in function.atoms(sympy.Heaviside)]
    return (steps[:1], bool(parts), sizes[:1], any(isinstance(part, (sympy.sin, sympy.sinh)) for part in turning), _power(function))


def _power(function: sympy.Expr) -> int:
    """Exponent of t as a factor."""
    return int(sum(sympy.degree(factor, LAST) for factor in sympy.Mul.make_args(function) if factor.is_polynomial(LAST)))


def _split(expression: sympy.Expr, t: sympy.Symbol) -> dict[sympy.Expr, sympy.Expr]:
    """Coefficients by functions of time."""
    if not expression.has(t):
        return {sympy.S.One: expression}
    if expression.is_Add:
        return _sum(pair for part in expression.args for pair in _split(part, t).items())
    if expression.is_Mul:
        parts_by_function = {sympy.S.One: sympy.S.One}
        for part in expression.args:
            parts_by_function = _product(parts_by_function, _split(part, t))
        return parts_by_function
    if expression.is_Pow and expression.exp.is_Integer and expression.exp > 1 and expression.base.is_Add:
        return _product(_split(expression.base, t), _split(expression.base ** (expression.exp - 1), t))
    return {expression: sympy.S.One}


def _product(one: dict, two: dict) -> dict:
    return _sum((f * g, a * b) for f, a in one.items() for g, b in two.items())


def _sum(pairs: Iterable[tuple[sympy.Expr, sympy.Expr]]) -> dict:
    groups: dict[sympy.Expr, list[sympy.Expr]] = {}
    for function, coefficient in pairs:
        groups.setdefault(function, []).append(coefficient)
    return {function: sympy.Add(*parts) for function, parts in groups.items()}


def in_numbers(terms: list[Term], form: ClosedForm, digits: int) -> list[Term]:
    """The terms with default values put in and all numbers as decimals, without those that cancel."""
    decimals = []
    for term in terms:
        constant, function = _split_exponentials(form.at_defaults(term.function), LAST)
        coefficient = decimal(form.at_defaults(term.coefficient) * constant, digits)
        if coefficient != 0:
            decimals.append(Term(coefficient, _decimal_arguments(function, LAST, digits)))
    return decimals


def _split_exponentials(function: sympy.Expr, t: sympy.Symbol) -> tuple[sympy.Expr, sympy.Expr]:
    """e^(r (t - T)) as e^(-r T), which belongs to the coefficient, and e^(r t)."""
    constant, factors = sympy.S.One, []
    for factor in sympy.Mul.make_args(function):
        if isinstance(factor, sympy.exp) and (line := _linear(factor.args[0], t)):
            slope, shift, offset = line
            constant, factor = constant * sympy.exp(offset - slope * shift), sympy.exp(slope * t)
        factors.append(factor)
    return constant, sympy.Mul(*factors)


def decimal(expression: sympy.Expr, digits: int) -> sympy.Expr:
    """A number as a decimal of so many digits, a whole one as it is.

    >>> decimal(sympy.sqrt(2), 5), decimal(sympy.Rational(1, 4), 5), decimal(sympy.sqrt(2) - sympy.sqrt(2), 5)
    (1.4142, 0.25000, 0)
    """
    if not expression.is_number or expression.is_Integer:
        return expression
    value = expression.evalf(DIGITS)
    if abs(value) < VANISHING:
        size = sum(abs(part.evalf(DIGITS)) for part in sympy.Add.make_args(sympy.expand(expression)))
        if abs(value) <= VANISHING * size or size == 0:
            return sympy.S.Zero
    return sympy.Float(value, digits)


def _decimal_arguments(function: sympy.Expr, t: sympy.Symbol, digits: int) -> sympy.Expr:
    """cos(sqrt(2) t) with sqrt(2) as a decimal; powers of t stay."""
    inner = {part: _decimal_argument(part, t, digits) for part in function.atoms(sympy.Function, sympy.exp) if part.has(t)}
    return function.xreplace(inner)


def _decimal_argument(part: sympy.Expr, t: sympy.Symbol, digits: int) -> sympy.Expr:
    line = _linear(part.args[0], t)
    if not line:
        return part
    slope, shift, offset = line
    return part.func(decimal(slope, digits) * t + decimal(offset - slope * shift, digits), *part.args[1:])


def _linear(argument: sympy.Expr, t: sympy.Symbol) -> tuple[sympy.Expr, sympy.Expr, sympy.Expr] | None:
    """r, T and c of r (t - T) + c, T where the argument is such a product, else c; None where it is not linear in t.

    >>> w, T, t = sympy.symbols("w T t")
    >>> _linear(w * (t - T), t), _linear(w * t - 1, t), _linear(t**2, t)
    ((w, T, 0), (w, 0, -1), None)
    """
    factor, rest = argument.as_independent(t, as_Add=False) if argument.is_Mul else (sympy.S.One, argument)
    total = sympy.expand_mul(rest)
    slope = total.coeff(t)
    offset = total - slope * t
    if offset.has(t) or slope.has(t) or slope == 0:
        return None
    return (factor * slope, -offset / slope, sympy.S.Zero) if argument.is_Mul else (slope, sympy.S.Zero, offset)


def with_shorthands(rows: list[list[Term]], form: ClosedForm) -> tuple[list[list[Term]], list[Shorthand]]:
    """The terms with names for what is long: w1, … in cosines and sines, a1, … in exponentials, d1, … under roots."""
    reserved = {p.name for p in form.parameters} | {p.symbol.name for p in form.parameters} | set(form.names)
    used = [sympy.Symbol(name, positive=True) for name in reserved]
    names = {letter: sympy.numbered_symbols(letter, start=1, exclude=used, positive=True) for letter in "wad"}
    radicands = _radicands(rows, names)
    short = {base: each.symbol for base, each in radicands.items()}
    rows = [[Term(_put(term.coefficient, short), _put(term.function, short)) for term in row] for row in rows]
    rows = [[Term(_shared(term.coefficient), term.function) for term in row] for row in rows]
    long = {symbol: base for base, symbol in short.items()}
    rates: dict[sympy.Expr, str] = {}
    for part in (part for row in rows for term in row for part in sympy.preorder_traversal(term.function)):
        kind, rate = _rate(part, LAST)
        if kind and rate.count_ops() > SHORT:
            rates.setdefault(rate, kind)
    ordered = sorted(rates.items(), key=lambda item: _size(form.at_defaults(item[0].xreplace(long))))
    named = {rate: Shorthand(next(names[kind]), rate) for rate, kind in ordered}
    rows = [[Term(_put(term.coefficient, named), _in_function(term.function, named, LAST)) for term in row] for row in rows]
    return rows, [*named.values(), *radicands.values()]


def _shared(coefficient: sympy.Expr) -> sympy.Expr:
    """A long sum with what its parts share in front."""
    return sympy.factor_terms(coefficient) if coefficient.is_Add and coefficient.count_ops() > LONG else coefficient


def _radicands(rows: list[list[Term]], names: dict) -> dict[sympy.Expr, Shorthand]:
    """Long expressions under square roots, as separate shorthands."""
    parts = [part for row in rows for term in row for part in (term.coefficient, term.function)]
    roots = sorted(set().union(*(part.atoms(sympy.Pow) for part in parts)), key=sympy.default_sort_key)
    bases = [root.base for root in roots if root.exp.is_Rational and root.exp.q == 2 and not root.base.has(LAST)]
    short: dict[sympy.Expr, sympy.Symbol] = {}
    shorthands: dict[sympy.Expr, Shorthand] = {}
    for base in sorted(dict.fromkeys(bases), key=lambda base: base.count_ops()):  # those inside others first
        if base.free_symbols and base.is_Add and _weight(base, parts) > LONG:
            symbol = next(names["d"])
            shorthands[base] = Shorthand(symbol, base.xreplace(short), base)
            short[base] = symbol
    return shorthands


def _weight(base: sympy.Expr, parts: list[sympy.Expr]) -> int:
    """Operations that are written for it, and again each time but the first two."""
    often = sum(part.count(lambda each: each.is_Pow and each.base == base) for part in parts)
    return base.count_ops() * max(1, often - 2)


def _rate(part: sympy.Expr, t: sympy.Symbol) -> tuple[str, sympy.Expr]:
    """Whether a function of rate times t, and which: "w" or "a", or an empty text."""
    if not isinstance(part, (sympy.exp, TrigonometricFunction, HyperbolicFunction)) or not part.has(t):
        return "", sympy.S.Zero
    line = _linear(part.args[0], t)
    if not line:
        return "", sympy.S.Zero
    rate = -line[0] if line[0].could_extract_minus_sign() else line[0]
    return "a" if isinstance(part, sympy.exp) else "w", rate


def _in_function(function: sympy.Expr, named: dict, t: sympy.Symbol) -> sympy.Expr:
    inner = {}
    for part in sympy.preorder_traversal(function):
        kind, rate = _rate(part, t)
        if kind and rate in named:
            slope, shift, offset = _linear(part.args[0], t)
            symbol = named[rate].symbol if slope == rate else -named[rate].symbol
            inner[part] = part.func(symbol * (t - shift) + offset)
    return function.xreplace(inner)


def _put(expression: sympy.Expr, named: dict) -> sympy.Expr:
    """An expression with names for what has one."""
    return expression.xreplace({value: getattr(each, "symbol", each) for value, each in named.items()})


def _size(value: sympy.Expr) -> float:
    try:
        return float(abs(sympy.N(value, 15)))
    except TypeError:
        return 0.0


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
