"""The formula of an answer: an expression in t for each coordinate, with what the symbols in it stand for, and the layout common to all printers:
terms with signs, abbreviations, conditions and assumptions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import sympy
from sympy.functions.elementary.hyperbolic import HyperbolicFunction
from sympy.functions.elementary.trigonometric import TrigonometricFunction

from ..ground.errors import InputError
from .symbolic.symbolic_response import delta

#: Digits that values are computed with where a decision or an output needs numbers.
DIGITS = 40

#: Of the sum of its terms, a coefficient this small is the zero that exact arithmetic would have given.
VANISHING = sympy.Float(10) ** -30


@dataclass(frozen=True)
class FormulaParameter:
    """A symbol with the name that the user wrote, its default value, an exact number or None, and its unit of SI."""

    symbol: sympy.Symbol
    name: str
    value: sympy.Expr | None = None
    unit: str = ""


@dataclass(frozen=True)
class Jump:
    """Jump of the derivative of this order of a coordinate at t = 0."""

    name: str
    order: int
    size: sympy.Expr


@dataclass(frozen=True)
class Impulse(Jump):
    """size times the derivative of this order of Dirac's delta at a time, in a coordinate."""

    time: sympy.Expr = sympy.S.Zero


@dataclass(frozen=True)
class ClosedForm:
    """x(t) for t > 0, one expression for each coordinate."""

    names: tuple[str, ...]  # names of the r coordinates, as the user wrote them
    values: tuple[sympy.Expr, ...]  # r expressions in the time
    time: sympy.Symbol  # the symbol t
    parameters: tuple[FormulaParameter, ...] = ()  # the other symbols; those that are not given have their own names and no values
    # jumps and impulses at t = 0, and later impulses
    impulses: tuple[Impulse, ...] = ()
    jumps: tuple[Jump, ...] = ()
    # equations in the values at 0- without which there are impulses, or jumps
    admissible: tuple[sympy.Eq, ...] = ()
    continuous: tuple[sympy.Eq, ...] = ()
    assumptions: tuple[sympy.Expr, ...] = ()  # expressions that must not vanish for the formula to hold
    positive: tuple[sympy.Expr, ...] = ()  # expressions that must be positive for the formula to be real in this form
    title: str = ""  # a line about where it comes from

    def __post_init__(self):
        known = {p.symbol for p in self.parameters}
        others = sorted(self.symbols - known, key=lambda symbol: symbol.name)
        object.__setattr__(self, "parameters", (*self.parameters, *(FormulaParameter(s, s.name) for s in others)))

    @classmethod
    def of(cls, x) -> ClosedForm:
        """The formula of a symbolic response with its impulses, jumps and conditions."""
        names = tuple(x.coordinates)
        return cls(
            names,
            tuple(x.regular),
            x.time,
            impulses=tuple(
                Impulse(name, order, factor, time)
                for time, rows in ((sympy.S.Zero, x.impulses), *x.later_impulses)
                for order, row in enumerate(rows)
                for name, factor in zip(names, row)
                if factor != 0
            ),
            jumps=tuple(
                Jump(name, order, size) for order in range(x.jump.rows) for name, size in zip(names, x.jump.row(order)) if size != 0
            ),
            admissible=tuple(x.admissible_conditions),
            continuous=tuple(x.continuity_conditions),
            assumptions=tuple(x.assumptions),
        )

    @property
    def symbols(self) -> set[sympy.Symbol]:
        """All symbols except the time."""
        return set().union(*(value.free_symbols for value in self.values)) - {self.time}

    @property
    def quantities(self) -> list[sympy.Expr]:
        """The expressions of the coordinates, their impulses and their jumps."""
        parts = [*self.values, *(each.size for each in (*self.impulses, *self.jumps)), *(each.time for each in self.impulses)]
        return [sympy.sympify(part) for part in parts]

    def mapped(self, change: Callable[[sympy.Expr], sympy.Expr]) -> ClosedForm:
        """The formula with another expression for each coordinate, factor of an impulse and jump."""
        impulses, jumps = ([replace(each, size=change(each.size)) for each in kind] for kind in (self.impulses, self.jumps))
        return replace(self, values=tuple(map(change, self.values)), impulses=tuple(impulses), jumps=tuple(jumps))

    @property
    def step_note(self) -> str:
        """Definition of H, where it is used."""
        return "H(t) is the unit step: 0 before t = 0, 1 after." if any(v.has(sympy.Heaviside) for v in self.values) else ""

    @property
    def defaults(self) -> dict[sympy.Symbol, sympy.Expr]:
        """Default values by symbol, of those that have one."""
        return {p.symbol: p.value for p in self.parameters if p.value is not None}

    def at_defaults(self, expression: sympy.Expr) -> sympy.Expr:
        """An expression with the default values put in, exactly."""
        return expression.xreplace(self.defaults)

    def only(self, names: Sequence[str]) -> ClosedForm:
        """The formula of some of the coordinates, in this order; an InputError for one that it does not have."""
        if unknown := [name for name in names if name not in self.names]:
            raise InputError(f'there is no coordinate "{unknown[0]}"; the coordinates are {", ".join(self.names)}')
        values = tuple(self.values[self.names.index(name)] for name in names)
        kept = {kind: tuple(each for each in getattr(self, kind) if each.name in names) for kind in ("impulses", "jumps")}
        return replace(self, names=tuple(names), values=values, **kept)


# Terms: sums of products, those with the same function of time together, in order.

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
        return self.coefficient * self.function


@dataclass(frozen=True)
class Shorthand:
    """A name for a rate, an angular frequency or what is under a root; full is the latter without other shorthands in it."""

    symbol: sympy.Symbol
    value: sympy.Expr
    full: sympy.Expr | None = None


def terms_of(expression: sympy.Expr, t: sympy.Symbol) -> list[Term]:
    """The terms of a sum of products, those with the same function of time together, in order of appearance."""
    groups = [(function, coefficient) for function, coefficient in _split(expression, t).items() if coefficient != 0]
    return [  # a sum that stands for itself is as many terms
        Term(part, function)
        for function, coefficient in groups
        for part in (sympy.Add.make_args(coefficient) if function == 1 else (coefficient,))
    ]


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


def _rank(function: sympy.Expr, form: ClosedForm) -> tuple:
    """Powers of t first, then by ascending frequency and rate with the default values, cosines before sines."""
    parts = sorted(function.atoms(TrigonometricFunction, HyperbolicFunction, sympy.exp), key=sympy.default_sort_key)
    turning = [part for part in parts if not isinstance(part, sympy.exp)]
    sizes = [_size(form.at_defaults(_rate(part, LAST)[1])) for part in (*turning, *parts)]
    steps = [_size(form.at_defaults(LAST - step.args[0])) for step in function.atoms(sympy.Heaviside)]
    power = int(sum(sympy.degree(factor, LAST) for factor in sympy.Mul.make_args(function) if factor.is_polynomial(LAST)))
    return (steps[:1], bool(parts), sizes[:1], any(isinstance(part, (sympy.sin, sympy.sinh)) for part in turning), power)


def in_numbers(terms: list[Term], form: ClosedForm, digits: int) -> list[Term]:
    """The terms with default values put in and all numbers as decimals, without those that cancel."""
    decimals = []
    for term in terms:
        constant, function = _split_exponentials(form.at_defaults(term.function), LAST)
        coefficient = decimal(form.at_defaults(term.coefficient) * constant, digits)
        if coefficient != 0:  # cos(sqrt(2) t) with sqrt(2) as a decimal; powers of t stay
            inner = [part for part in function.atoms(sympy.Function, sympy.exp) if part.has(LAST)]
            decimals.append(Term(coefficient, function.xreplace({part: _decimal_argument(part, LAST, digits) for part in inner})))
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
    """A number as a decimal of so many digits, a whole one as it is."""
    if not expression.is_number or expression.is_Integer:
        return expression
    value = expression.evalf(DIGITS)
    if abs(value) < VANISHING:
        size = sum(abs(part.evalf(DIGITS)) for part in sympy.Add.make_args(sympy.expand(expression)))
        if abs(value) <= VANISHING * size or size == 0:
            return sympy.S.Zero
    return sympy.Float(value, digits)


def _decimal_argument(part: sympy.Expr, t: sympy.Symbol, digits: int) -> sympy.Expr:
    line = _linear(part.args[0], t)
    if not line:
        return part
    slope, shift, offset = line
    return part.func(decimal(slope, digits) * t + decimal(offset - slope * shift, digits), *part.args[1:])


def _linear(argument: sympy.Expr, t: sympy.Symbol) -> tuple[sympy.Expr, sympy.Expr, sympy.Expr] | None:
    """r, T and c of r (t - T) + c, T where the argument is such a product, else c; None where it is not linear in t."""
    factor, rest = argument.as_independent(t, as_Add=False) if argument.is_Mul else (sympy.S.One, argument)
    total = sympy.expand_mul(rest)
    slope = total.coeff(t)
    offset = total - slope * t
    if offset.has(t) or slope.has(t) or slope == 0:
        return None
    return (factor * slope, -offset / slope, sympy.S.Zero) if argument.is_Mul else (slope, sympy.S.Zero, offset)


# Shorthands for what is long.


def with_shorthands(rows: list[list[Term]], form: ClosedForm) -> tuple[list[list[Term]], list[Shorthand]]:
    """The terms with names for what is long: w1, … in cosines and sines, a1, … in exponentials, d1, … under roots."""
    reserved = {p.name for p in form.parameters} | {p.symbol.name for p in form.parameters} | set(form.names)
    used = [sympy.Symbol(name, positive=True) for name in reserved]
    names = {letter: sympy.numbered_symbols(letter, start=1, exclude=used, positive=True) for letter in "wad"}
    radicands = _radicands(rows, names)
    short = {base: each.symbol for base, each in radicands.items()}
    rows = [[Term(term.coefficient.xreplace(short), term.function.xreplace(short)) for term in row] for row in rows]
    rows = [  # a long sum with what its parts share in front
        [
            replace(term, coefficient=sympy.factor_terms(c)) if (c := term.coefficient).is_Add and c.count_ops() > LONG else term
            for term in row
        ]
        for row in rows
    ]
    long = {symbol: base for base, symbol in short.items()}
    rates: dict[sympy.Expr, str] = {}
    for part in (part for row in rows for term in row for part in sympy.preorder_traversal(term.function)):
        kind, rate = _rate(part, LAST)
        if kind and rate.count_ops() > SHORT:
            rates.setdefault(rate, kind)
    ordered = sorted(rates.items(), key=lambda item: _size(form.at_defaults(item[0].xreplace(long))))
    named = {rate: next(names[kind]) for rate, kind in ordered}
    rows = [[Term(term.coefficient.xreplace(named), _in_function(term.function, named, LAST)) for term in row] for row in rows]
    return rows, [*(Shorthand(symbol, rate) for rate, symbol in named.items()), *radicands.values()]


def _radicands(rows: list[list[Term]], names: dict) -> dict[sympy.Expr, Shorthand]:
    """Long expressions under square roots, as separate shorthands."""
    parts = [part for row in rows for term in row for part in (term.coefficient, term.function)]
    roots = sorted(set().union(*(part.atoms(sympy.Pow) for part in parts)), key=sympy.default_sort_key)
    bases = [root.base for root in roots if root.exp.is_Rational and root.exp.q == 2 and not root.base.has(LAST)]
    short: dict[sympy.Expr, sympy.Symbol] = {}
    shorthands: dict[sympy.Expr, Shorthand] = {}
    for base in sorted(dict.fromkeys(bases), key=lambda base: base.count_ops()):  # those inside others first
        often = sum(part.count(lambda each, base=base: each.is_Pow and each.base == base) for part in parts)
        weight = base.count_ops() * max(1, often - 2)  # operations that are written for it, and again each time but the first two
        if base.free_symbols and base.is_Add and weight > LONG:
            symbol = next(names["d"])
            shorthands[base] = Shorthand(symbol, base.xreplace(short), base)
            short[base] = symbol
    return shorthands


def _rate(part: sympy.Expr, t: sympy.Symbol) -> tuple[str, sympy.Expr]:
    """Whether a function of rate times t, and which: "w" or "a", or an empty text."""
    moves = isinstance(part, (sympy.exp, TrigonometricFunction, HyperbolicFunction)) and part.has(t)
    line = _linear(part.args[0], t) if moves else None
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
            inner[part] = part.func((named[rate] if slope == rate else -named[rate]) * (t - shift) + offset)
    return function.xreplace(inner)


def _size(value: sympy.Expr) -> float:
    try:
        return float(abs(sympy.N(value, 15)))
    except TypeError:
        return 0.0


# The layout, and statements about the formula.

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
    """The terms of every coordinate, and what the names in them stand for."""

    form: ClosedForm  # source of the terms
    rows: list[list[Term]]  # terms by coordinate
    shorthands: list[Shorthand]  # names for long rates and frequencies
    digits: int | None  # digits of decimals, or None where numbers are exact

    def short(self, expression: sympy.Expr) -> sympy.Expr:
        """An expression with the abbreviation for it, or for minus it."""
        names = {each.full: each.symbol for each in self.shorthands if each.full is not None}
        return names.get(expression) or (-names[-expression] if -expression in names else expression)

    @property
    def statements(self) -> dict[str, list[list[Part]]]:
        """Jumps, impulses, conditions on the start and assumptions by kind, each in parts; without assumptions that follow from a sign."""
        form = self.form
        known = {other for each in form.positive for other in (each, -each, sympy.expand(-each))}
        assumptions = [each for each in form.assumptions if each not in known and sympy.expand(each) not in known]
        impulses = [(each.name, each.order, self.number(each.size), self.number(each.time)) for each in form.impulses]
        return {
            "jumps": [[Derivative(each.name, each.order), " jumps at t = 0 by ", self.number(each.size)] for each in form.jumps],
            "impulses": [
                [Derivative(name, 0), " has the impulse ", Term(factor, delta(LAST - time, order))]
                for name, order, factor, time in impulses
            ],
            "admissible": [["no impulses if ", each] for each in form.admissible],
            "continuous": [["no jumps if ", each] for each in form.continuous],
            "assumptions": [["holds where ", sympy.Ne(self.short(each), 0, evaluate=False)] for each in assumptions],
            "positive": [["real in this form where ", sympy.Gt(self.short(each), 0, evaluate=False)] for each in form.positive],
        }

    def number(self, expression: sympy.Expr) -> sympy.Expr:
        """Any other expression, in decimals where those are wanted."""
        return readable(expression) if self.digits is None else decimal(self.form.at_defaults(expression), self.digits)


def laid_out(form: ClosedForm, digits: int | None = None) -> Layout:
    """The terms of a formula: exact, long rates named; or with default values and decimals of so many digits."""
    rows = [terms_of(value.xreplace({form.time: LAST}), LAST) for value in form.values]
    rows = [sorted(row, key=lambda term: _rank(term.function, form)) for row in rows]
    if digits is not None:
        return Layout(form, [in_numbers(row, form, digits) for row in rows], [], digits)
    rows, shorthands = with_shorthands(rows, form)
    rows = [[Term(readable(term.coefficient), readable(term.function)) for term in row] for row in rows]
    return Layout(form, rows, [Shorthand(each.symbol, readable(each.value), each.full) for each in shorthands], None)


def is_long(terms: list[Term]) -> bool:
    """Whether each term gets a line of its own."""
    return len(terms) > MOST_TERMS_IN_A_LINE or sum(term.expression.count_ops() for term in terms) > MOST_IN_A_LINE


def readable(expression: sympy.Basic) -> sympy.Basic:
    """An expression with what has too many digits rounded to those of a double."""
    numbers = expression.atoms(sympy.Rational, sympy.Float)
    long = {q: sympy.Float(q, DOUBLE_DIGITS) for q in numbers if q.is_Float or max(abs(q.p), q.q) > MOST_IN_FRACTION}
    return expression.xreplace(long) if long else expression
