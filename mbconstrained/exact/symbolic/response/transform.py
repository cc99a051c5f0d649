"""Forces as expressions in time, split into terms, the Laplace transforms of the terms, and those of the values at 0-.

A term is c t^k e^{a t} cos(w t + p) from a time t_0 on, or c delta^(l)(t - t_0). Sums, products and powers of constants, t,
exp, cos, sin, cosh, sinh, Heaviside and DiracDelta are sums of such terms; nothing else is.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import reduce

import sympy

from ....ground.errors import InputError
from ..field.fields import check_positive, check_start_names
from ..symbolic_matrix import SymbolicPolynomialMatrix, checked_matrix

#: The functions that a force may contain, for messages.
EXPECTED = "expected sums and products of constants, t, exp, cos, sin, cosh, sinh, Heaviside(t - t0) and DiracDelta(t - t0, k)"


@dataclass(frozen=True)
class TimeTerm:
    """coefficient t^power e^{rate t} cos(frequency t + phase) for t > start, or coefficient delta^(impulse)(t - start)."""

    coefficient: sympy.Expr = sympy.S.One
    power: int = 0
    rate: sympy.Expr = sympy.S.Zero
    frequency: sympy.Expr = sympy.S.Zero
    phase: sympy.Expr = sympy.S.Zero
    start: sympy.Expr = sympy.S.Zero
    impulse: int | None = None

    @property
    def is_constant(self) -> bool:
        """Whether the term is constant after t = 0."""
        return self.impulse is None and not self.power and self.rate == self.frequency == self.start == 0

    def scaled(self, factor: sympy.Expr) -> TimeTerm:
        """The term times a constant."""
        return replace(self, coefficient=self.coefficient * factor)

    def from_its_start(self) -> list[TimeTerm]:
        """The term as terms in the time since its start."""
        t0 = self.start
        if t0 == 0 or self.impulse is not None:
            return [self]
        moved = replace(self, coefficient=self.coefficient * sympy.exp(self.rate * t0), phase=self.phase + self.frequency * t0)
        return [
            replace(moved, coefficient=moved.coefficient * sympy.binomial(self.power, j) * t0 ** (self.power - j), power=j)
            for j in range(self.power + 1)
        ]


def delta(t: sympy.Expr, order: int) -> sympy.Expr:
    """A derivative of Dirac's delta."""
    return sympy.DiracDelta(t, order) if order else sympy.DiracDelta(t)


def terms_of(expression: sympy.Expr, t: sympy.Symbol) -> list[TimeTerm]:
    """An expression in t as a sum of terms.

    >>> t = sympy.Symbol("t")
    >>> [(term.coefficient, term.frequency) for term in terms_of(sympy.cos(t) ** 2, t)]
    [(1/2, 0), (1/2, 2)]
    """
    if not expression.has(t):
        return [TimeTerm(_constant(expression, t))]
    if expression == t:
        return [TimeTerm(power=1)]
    if expression.is_Add:
        return [term for part in expression.args for term in terms_of(part, t)]
    if expression.is_Mul:
        return reduce(_product, (terms_of(part, t) for part in expression.args))
    if expression.is_Pow and expression.exp.is_Integer and expression.exp > 0:
        return reduce(_product, [terms_of(expression.base, t)] * int(expression.exp))
    return _function(expression, t)


def _constant(expression, t) -> sympy.Expr:
    """An expression without the time, or a step or impulse that contains it."""
    if odd := expression.atoms(sympy.Heaviside, sympy.DiracDelta):
        function = min(odd, key=sympy.default_sort_key)
        raise InputError(
            f"force: found {function}, in which there is no {t}; if the time is called otherwise, pass time=... to say so"
        )
    return expression


def _function(expression, t) -> list[TimeTerm]:
    if isinstance(expression, sympy.exp) or (expression.is_Pow and not expression.base.has(t)):
        base, exponent = expression.as_base_exp()
        rate, constant = _linear(exponent * sympy.log(base), expression, t)
        return [TimeTerm(sympy.exp(constant), rate=rate)]
    if isinstance(expression, (sympy.cos, sympy.sin)):
        frequency, phase = _linear(expression.args[0], expression, t)
        return [TimeTerm(frequency=frequency, phase=phase - (sympy.pi / 2 if isinstance(expression, sympy.sin) else 0))]
    if isinstance(expression, (sympy.cosh, sympy.sinh)):
        return terms_of(sympy.expand(expression.rewrite(sympy.exp)), t)
    if isinstance(expression, sympy.Heaviside):
        return _step(expression, t)
    if isinstance(expression, sympy.DiracDelta):
        return _impulse(expression, t)
    raise InputError(f"force: found {expression}; {EXPECTED}. Another function: approximate it, and use mb.solve")


def _linear(argument, expression, t) -> tuple[sympy.Expr, sympy.Expr]:
    """(a, b) of a t + b, real."""
    slope = sympy.diff(argument, t)
    if slope.has(t) or slope.has(sympy.I):
        raise InputError(f"force: found {expression}; expected its argument to be a {t} + b with real a and b")
    return slope, sympy.expand(argument - slope * t)


def _place(expression, t) -> tuple[sympy.Expr, sympy.Expr]:
    """(slope, time) of the zero of the argument of a step or an impulse; slope a number, time comparable with 0."""
    slope, constant = _linear(expression.args[0], expression, t)
    time = sympy.together(-constant / slope) if slope.is_number else None
    check_positive(constant.free_symbols)
    if time is None or _sign(time) is None:
        raise InputError(
            f"force: found {expression}; expected its argument to be {t} - t0 with t0 >= 0, a number or a positive symbol"
        )
    return slope, time


def _sign(time) -> int | None:
    """Sign of an expression with positive symbols."""
    value = time.xreplace({symbol: sympy.Dummy(symbol.name, positive=True) for symbol in time.free_symbols})
    return 0 if value.is_zero else 1 if value.is_positive else -1 if value.is_negative else None


def _step(expression, t) -> list[TimeTerm]:
    slope, time = _place(expression, t)
    later = [TimeTerm(start=time)] if _sign(time) > 0 else [TimeTerm()]
    if slope.is_positive:
        return later
    return [TimeTerm(), *(term.scaled(sympy.S.NegativeOne) for term in later)] if _sign(time) > 0 else []


def _impulse(expression, t) -> list[TimeTerm]:
    slope, time = _place(expression, t)
    order = int(expression.args[1]) if len(expression.args) > 1 else 0
    return [TimeTerm(1 / (abs(slope) * slope**order), start=time, impulse=order)] if _sign(time) >= 0 else []


def _product(ones: list[TimeTerm], others: list[TimeTerm]) -> list[TimeTerm]:
    return [term for one in ones for other in others for term in _times(one, other)]


def _times(one: TimeTerm, other: TimeTerm) -> list[TimeTerm]:
    if one.is_constant and not one.phase:
        return [other.scaled(one.coefficient)]
    if other.is_constant and not other.phase:
        return [one.scaled(other.coefficient)]
    if one.impulse is not None or other.impulse is not None:
        raise InputError(
            "force: found a DiracDelta times a function of time; expected its factor to be constant: write the value there"
        )
    both = replace(
        one,
        coefficient=one.coefficient * other.coefficient,
        power=one.power + other.power,
        rate=one.rate + other.rate,
        start=_later(one.start, other.start),
    )
    if not (one.frequency or one.phase) or not (other.frequency or other.phase):
        return [replace(both, frequency=one.frequency + other.frequency, phase=one.phase + other.phase)]
    half = both.scaled(sympy.Rational(1, 2))
    return [
        replace(half, frequency=one.frequency - other.frequency, phase=one.phase - other.phase),
        replace(half, frequency=one.frequency + other.frequency, phase=one.phase + other.phase),
    ]


def _later(one, other) -> sympy.Expr:
    difference = _sign(sympy.expand(one - other))
    if difference is None:
        raise InputError(f"force: found a product of steps at {one} and {other}; expected it to be known which one is later")
    return one if difference > 0 else other


@dataclass(frozen=True)
class Transform:
    """The transform of a term from its start: sum of amplitude numerator(s) over ((s - rate)^2 + square)^power, or over (s - rate)^power.

    Attributes:
        parts: (amplitude, numerator as an expression in s) each.
        denominator, power: as an expression in s with coefficients rational in symbols.
    """

    parts: tuple[tuple[sympy.Expr, sympy.Expr], ...]
    denominator: sympy.Expr = sympy.S.One
    power: int = 0


def transform_of(term: TimeTerm, s: sympy.Symbol) -> Transform:
    """The Laplace transform of a term that starts at 0.

    With n = k + 1: k!/(s - a - i w)^n = k! ((s - a) + i w)^n / ((s - a)^2 + w^2)^n, so that w enters the denominator squared: the
    frequency sqrt(k/m) meets the factor m s^2 + k of a determinant there. A rate a + r with r^2 rational is treated in the same manner.
    """
    if term.impulse is not None:
        return Transform(((term.coefficient, s**term.impulse),))
    n, factor = term.power + 1, term.coefficient * sympy.factorial(term.power)
    rate, root = _rational_and_root(term.rate)
    if root != 0 and term.frequency != 0:
        raise InputError(
            f"force: found the rate {term.rate} with the frequency {term.frequency}; expected one without square roots"
        )
    cosine = factor * sympy.cos(term.phase)
    if root == 0 and term.frequency == 0:
        return Transform(((cosine, sympy.S.One),), s - rate, n)
    square = sympy.expand(term.frequency**2 - root**2)
    even, odd = _binomial(s - rate, -square, n)
    turned = cosine * root if root != 0 else -factor * sympy.sin(term.phase) * term.frequency
    return Transform(((cosine, even), (turned, odd)), (s - rate) ** 2 + square, n)


def _binomial(base, square, n) -> tuple[sympy.Expr, sympy.Expr]:
    """(E, O) with (base + root)^n = E + root O, root^2 = square."""
    parts = [sympy.binomial(n, j) * base ** (n - j) * square ** (j // 2) for j in range(n + 1)]
    return sympy.Add(*parts[::2]), sympy.Add(*parts[1::2])


def _rational_and_root(rate) -> tuple[sympy.Expr, sympy.Expr]:
    rational, roots = [], []
    for part in sympy.Add.make_args(sympy.expand(rate)):
        has_roots = any(not power.exp.is_Integer for power in part.atoms(sympy.Pow) if power.free_symbols)
        (rational if part.is_rational_function() and part.is_algebraic_expr() and not has_roots else roots).append(part)
    return sympy.Add(*rational), sympy.Add(*roots)


# Sources of the motion as vectors in s: the values at 0- as X_in(s), and the terms of the force as F(s).


@dataclass(frozen=True)
class SymbolicSource:
    """amplitude numerator(s) / denominator(s)^power, from a time onwards.

    Attributes:
        start: the time.
        amplitude: any expression without s and t.
        numerator: r expressions, polynomials in s with coefficients rational in symbols.
        denominator, power: as in ``Transform``.
        is_impulse: of a Dirac impulse in the force.
    """

    start: sympy.Expr
    amplitude: sympy.Expr
    numerator: tuple[sympy.Expr, ...]
    denominator: sympy.Expr = sympy.S.One
    power: int = 0
    is_impulse: bool = False


def initial_symbols(A: SymbolicPolynomialMatrix) -> sympy.ImmutableMatrix:
    """Symbols for the values at 0-, shape (q, r): row i holds x^(i)(0-), named x1_0, x1_1, ... after the coordinates.

    >>> initial_symbols(SymbolicPolynomialMatrix([[[1]], [[0]], [[1]]], coordinates=["u"]))
    Matrix([
    [u_0],
    [u_1]])
    """
    check_start_names(checked_matrix(A).coordinates, A.degree, A.symbols)
    return sympy.ImmutableMatrix(A.degree, A.size, lambda i, j: sympy.Symbol(f"{A.coordinates[j]}_{i}", real=True))


def initial_sources(A: SymbolicPolynomialMatrix, initial: sympy.Matrix) -> list[SymbolicSource]:
    """X_in(s) of the values at 0- (Moysis et al., Eq. 47)."""
    s, sources = A.variable, []
    for j in range(A.degree):
        for column in range(A.size):
            above = [matrix[:, column] * s ** (i - 1 - j) for i, matrix in enumerate(A.coefficients) if i > j]
            vector = sum(above[1:], above[0])
            if initial[j, column] != 0 and any(vector):
                sources.append(SymbolicSource(sympy.S.Zero, initial[j, column], tuple(vector)))
    return sources


def force_sources(A: SymbolicPolynomialMatrix, force: Iterable[sympy.Expr], time: sympy.Symbol) -> list[SymbolicSource]:
    """F(s) of a force."""
    sources = []
    for row, expression in enumerate(force):
        _check_rates(expression, time)
        for given in terms_of(expression, time):
            for term in given.from_its_start():
                sources += _sources_of_term(A, row, term)
    return sources


def _check_rates(expression: sympy.Expr, time: sympy.Symbol) -> None:
    for power in expression.atoms(sympy.Pow):
        if power.exp.has(time) and not power.base.has(time):
            raise InputError(
                f"force: found {power}; expected exp(a*{time}) with a rational in the symbols: write a symbol a for "
                f"log({power.base}) and put in its value afterwards"
            )


def _sources_of_term(A, row: int, term: TimeTerm) -> list[SymbolicSource]:
    transform = transform_of(term, A.variable)
    unit = [sympy.S.One if i == row else sympy.S.Zero for i in range(A.size)]
    return [
        SymbolicSource(
            term.start,
            amplitude,
            tuple(numerator * e for e in unit),
            transform.denominator,
            transform.power,
            term.impulse is not None,
        )
        for amplitude, numerator in transform.parts
        if amplitude != 0
    ]
