"""Laplace transforms with symbols and their inverse: forces and values at 0- as sources in s, and functions of time, impulses and values at
0+ from X(s) = A(s)^-1 b(s), linear in the amplitudes.

A force is a sum of terms c t^k e^{a t} cos(w t + p) from a time t_0 on, or c delta^(l)(t - t_0). Sums, products and powers of constants,
t, exp, cos, sin, cosh, sinh, Heaviside and DiracDelta are sums of such terms; nothing else is.
"""

from __future__ import annotations

import numbers
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, reduce
from itertools import combinations
from math import prod

import sympy
from sympy.polys.domains import Domain
from sympy.polys.polyerrors import CoercionFailed

from ...ground.errors import InputError
from ..engine import series_at_infinity, slopes, taylor
from .fields import (
    as_positive,
    check_one_each,
    check_positive,
    check_start_names,
    checked_time,
    element,
    exact_expression,
    expression_of,
    field_of,
    symbols_of,
)
from .symbolic_matrix import S, SymbolicPolynomialMatrix, checked_matrix
from .symbolic_pairs import Factors, SymbolicRing, factors_of, modes, must_not_vanish

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
        return self.impulse is None and not self.power and self.rate == self.frequency == self.start == 0

    def scaled(self, factor: sympy.Expr) -> TimeTerm:
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
    return sympy.DiracDelta(t, order) if order else sympy.DiracDelta(t)


def terms_of(expression: sympy.Expr, t: sympy.Symbol) -> list[TimeTerm]:
    """An expression in t as a sum of terms."""
    if not expression.has(t):
        if odd := expression.atoms(sympy.Heaviside, sympy.DiracDelta):
            function = min(odd, key=sympy.default_sort_key)
            raise InputError(
                f"force: found {function}, in which there is no {t}; if the time is called otherwise, pass time=... to say so"
            )
        return [TimeTerm(expression)]
    if expression == t:
        return [TimeTerm(power=1)]
    if expression.is_Add:
        return [term for part in expression.args for term in terms_of(part, t)]
    if expression.is_Mul:
        return reduce(_product, (terms_of(part, t) for part in expression.args))
    if expression.is_Pow and expression.exp.is_Integer and expression.exp > 0:
        return reduce(_product, [terms_of(expression.base, t)] * int(expression.exp))
    return _function(expression, t)


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
        slope, time = _place(expression, t)
        later = [TimeTerm(start=time)] if _sign(time) > 0 else [TimeTerm()]
        if slope.is_positive:
            return later
        return [TimeTerm(), *(term.scaled(sympy.S.NegativeOne) for term in later)] if _sign(time) > 0 else []
    if isinstance(expression, sympy.DiracDelta):
        slope, time = _place(expression, t)
        order = int(expression.args[1]) if len(expression.args) > 1 else 0
        return [TimeTerm(1 / (abs(slope) * slope**order), start=time, impulse=order)] if _sign(time) >= 0 else []
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
    difference = _sign(sympy.expand(one.start - other.start))
    if difference is None:
        raise InputError(
            f"force: found a product of steps at {one.start} and {other.start}; expected it to be known which one is later"
        )
    both = replace(
        one,
        coefficient=one.coefficient * other.coefficient,
        power=one.power + other.power,
        rate=one.rate + other.rate,
        start=one.start if difference > 0 else other.start,
    )
    if not (one.frequency or one.phase) or not (other.frequency or other.phase):
        return [replace(both, frequency=one.frequency + other.frequency, phase=one.phase + other.phase)]
    half = both.scaled(sympy.Rational(1, 2))
    return [
        replace(half, frequency=one.frequency - other.frequency, phase=one.phase - other.phase),
        replace(half, frequency=one.frequency + other.frequency, phase=one.phase + other.phase),
    ]


def transform_of(term: TimeTerm, s: sympy.Symbol) -> tuple[list[tuple[sympy.Expr, sympy.Expr]], sympy.Expr, int]:
    """Amplitudes with numerators, the denominator and its power of the Laplace transform of a term that starts at 0.

    With n = k + 1: k!/(s - a - i w)^n = k! ((s - a) + i w)^n / ((s - a)^2 + w^2)^n, so that w enters the denominator squared: the
    frequency sqrt(k/m) meets the factor m s^2 + k of a determinant there. A rate a + r with r^2 rational is treated in the same manner.
    """
    if term.impulse is not None:
        return [(term.coefficient, s**term.impulse)], sympy.S.One, 0
    n, factor = term.power + 1, term.coefficient * sympy.factorial(term.power)
    rate, root = _rational_and_root(term.rate)
    if root != 0 and term.frequency != 0:
        raise InputError(
            f"force: found the rate {term.rate} with the frequency {term.frequency}; expected one without square roots"
        )
    cosine = factor * sympy.cos(term.phase)
    if root == 0 and term.frequency == 0:
        return [(cosine, sympy.S.One)], s - rate, n
    square = sympy.expand(term.frequency**2 - root**2)
    binomial = [sympy.binomial(n, j) * (s - rate) ** (n - j) * (-square) ** (j // 2) for j in range(n + 1)]
    turned = cosine * root if root != 0 else -factor * sympy.sin(term.phase) * term.frequency
    return [(cosine, sympy.Add(*binomial[::2])), (turned, sympy.Add(*binomial[1::2]))], (s - rate) ** 2 + square, n


def _rational_and_root(rate) -> tuple[sympy.Expr, sympy.Expr]:
    rational, roots = [], []
    for part in sympy.Add.make_args(sympy.expand(rate)):
        has_roots = any(not power.exp.is_Integer for power in part.atoms(sympy.Pow) if power.free_symbols)
        (rational if part.is_rational_function() and part.is_algebraic_expr() and not has_roots else roots).append(part)
    return sympy.Add(*rational), sympy.Add(*roots)


# Sources of the motion as vectors in s: the values at 0- as X_in(s), and the terms of the force as F(s).


@dataclass(frozen=True)
class SymbolicSource:
    """amplitude numerator(s) / denominator(s)^power, from a time onwards."""

    start: sympy.Expr  # the time
    amplitude: sympy.Expr  # any expression without s and t
    numerator: tuple[sympy.Expr, ...]  # r expressions, polynomials in s with coefficients rational in symbols
    # as an expression in s with coefficients rational in symbols, and a whole number
    denominator: sympy.Expr = sympy.S.One
    power: int = 0
    is_impulse: bool = False  # of a Dirac impulse in the force


def initial_symbols(A: SymbolicPolynomialMatrix) -> sympy.ImmutableMatrix:
    """Symbols for the values at 0-, shape (q, r): row i holds x^(i)(0-), named x1_0, x1_1, ... after the coordinates."""
    check_start_names(checked_matrix(A).coordinates, A.degree, A.symbols)
    return sympy.ImmutableMatrix(A.degree, A.size, lambda i, j: sympy.Symbol(f"{A.coordinates[j]}_{i}", real=True))


def initial_sources(A: SymbolicPolynomialMatrix, initial: sympy.Matrix) -> list[SymbolicSource]:
    """X_in(s) of the values at 0- (Moysis et al., Eq. 47)."""
    sources = []
    for j in range(A.degree):
        for column in range(A.size):
            above = [matrix[:, column] * S ** (i - 1 - j) for i, matrix in enumerate(A.coefficients) if i > j]
            vector = sum(above[1:], above[0])
            if initial[j, column] != 0 and any(vector):
                sources.append(SymbolicSource(sympy.S.Zero, initial[j, column], tuple(vector)))
    return sources


def force_sources(A: SymbolicPolynomialMatrix, force: Iterable[sympy.Expr], time: sympy.Symbol) -> list[SymbolicSource]:
    """F(s) of a force."""
    sources = []
    for row, expression in enumerate(force):
        for power in expression.atoms(sympy.Pow):
            if power.exp.has(time) and not power.base.has(time):
                raise InputError(
                    f"force: found {power}; expected exp(a*{time}) with a rational in the symbols: write a symbol a for "
                    f"log({power.base}) and put in its value afterwards"
                )
        for term in (moved for given in terms_of(expression, time) for moved in given.from_its_start()):
            parts, denominator, power = transform_of(term, S)
            for amplitude, numerator in parts:
                if amplitude != 0:
                    vector = tuple(numerator if i == row else sympy.S.Zero for i in range(A.size))
                    sources.append(SymbolicSource(term.start, amplitude, vector, denominator, power, term.impulse is not None))
    return sources


# X(s) = A(s)^-1 b(s), and its parts.

#: A linear combination of amplitudes.
Combination = dict[sympy.Expr, object]


@dataclass(frozen=True, eq=False)
class Quotient:
    """X(s) of the sources that share a denominator: generator -> r numerators, over the product of the factors."""

    numerators: dict[sympy.Expr, list[sympy.Poly]]
    factors: Factors


class ResponseTransform:
    """X(s) = A(s)^-1 b(s) of sources with one start, over the field of A and of the sources, or of others where they are needed."""

    def __init__(self, A: SymbolicPolynomialMatrix, sources: Iterable[SymbolicSource], field: Domain | None = None):
        self.A, self.sources = A, list(sources)
        self.field = field_of(entries_with(A, self.sources)) if field is None else field

    @cached_property
    def quotients(self) -> list[Quotient]:
        """One quotient for the sources that share a denominator."""
        A, field = self.A, self.field
        groups: dict[tuple, dict[sympy.Expr, list[sympy.Poly]]] = {}
        for source in self.sources:
            group = groups.setdefault((source.denominator, source.power), {})
            vector = [self._polynomial(entry) for entry in source.numerator]
            for generator, factor in _amplitudes(field, source.amplitude).items():
                before = group.setdefault(generator, [0 * p for p in vector])
                group[generator] = [b + p * _constant(p, factor) for b, p in zip(before, vector, strict=True)]
        determinant = A.determinant.set_domain(field)
        adjugate = [[p.set_domain(field) for p in row] for row in A.adjugate]
        scale = _constant(determinant, field.one / determinant.rep.to_list()[0])
        of_det = factors_of(determinant)
        quotients = []
        for (below, power), group in groups.items():
            factors = dict(of_det)
            for q, k in factors_of(self._polynomial(below)) if power else []:
                factors[q] = factors.get(q, 0) + k * power
            numerators = {
                generator: [
                    sum((p * e for p, e in zip(row, b, strict=True) if not e.is_zero), scale * 0) * scale for row in adjugate
                ]
                for generator, b in group.items()
            }
            quotients.append(Quotient(numerators, list(factors.items())))
        return quotients

    @cached_property
    def laurent(self) -> dict[int, list[Combination]]:
        """The coefficients of s^p of X near infinity, p >= -q, one combination for each coordinate."""
        A, field = self.A, self.field
        series: dict[int, list[Combination]] = {-1 - i: [{} for _ in range(A.size)] for i in range(A.degree)}
        for quotient in self.quotients:
            below = sympy.prod((q**k for q, k in quotient.factors), sympy.Poly(1, A.variable, domain=field))
            ring = SymbolicRing.of(below)
            for generator, numerators in quotient.numerators.items():
                for i, numerator in enumerate(numerators):
                    if numerator.is_zero:
                        continue
                    highest = numerator.degree() - below.degree()
                    powers = range(highest, -A.degree - 1, -1)
                    for power, c in zip(powers, series_at_infinity(ring, numerator, below, highest), strict=False):
                        row = series.setdefault(power, [{} for _ in range(A.size)])
                        row[i][generator] = row[i].get(generator, field.zero) + c
        for power in range(max(series, default=-1) + 1):
            series.setdefault(power, [{} for _ in range(A.size)])
        return {power: [{g: c for g, c in entry.items() if c} for entry in row] for power, row in series.items()}

    def combined(self, combination: Combination) -> sympy.Expr:
        """The sum of amplitudes and their factors."""
        return sympy.Add(*(generator * expression_of(self.field, factor) for generator, factor in combination.items()))

    def regular(self, time: sympy.Symbol) -> sympy.ImmutableMatrix:
        """The response without impulses, shape (r, 1), in the time since the start of the sources."""
        return sympy.ImmutableMatrix(regular_parts(self.A.size, self.quotients, time))

    @property
    def impulses(self) -> tuple[sympy.ImmutableMatrix, ...]:
        """The factors of Dirac's delta and of its derivatives, shapes (r, 1)."""
        highest = max((power for power, row in self.laurent.items() if power >= 0 and any(row)), default=-1)
        return tuple(sympy.ImmutableMatrix([self.combined(c) for c in self.laurent[power]]) for power in range(highest + 1))

    @property
    def start(self) -> sympy.ImmutableMatrix:
        """x^(i)(0+), shape (q, r)."""
        return sympy.ImmutableMatrix(self.A.degree, self.A.size, lambda i, j: self.combined(self.laurent[-1 - i][j]))

    def assumptions(self, divisors: Iterable[sympy.Expr]) -> tuple[sympy.Expr, ...]:
        """Nonzero conditions for the form of the factors: leading coefficient, discriminants, resultants; and divisors."""
        determinant = self.A.determinant.set_domain(self.field)
        below = [self._polynomial(p) for p in {source.denominator for source in self.sources if source.power}]
        factors = sorted({q for p in (determinant, *below) for q, _ in factors_of(p)}, key=lambda q: (q.degree(), str(q.as_expr())))
        values = [determinant.rep.to_list()[0]]
        values += [q.rep.discriminant() for q in factors if q.degree() > 1]
        values += [p.rep.resultant(q.rep) for p, q in combinations(factors, 2)]
        assumptions = dict.fromkeys(must_not_vanish(self.field, values))
        for each in (part for divisor in divisors for part in _vanishing(divisor)):
            if sympy.expand(-each) not in map(sympy.expand, assumptions):
                assumptions[each] = None
        return tuple(sorted(assumptions, key=lambda e: (sympy.count_ops(e), str(e))))

    def _polynomial(self, expression: sympy.Expr) -> sympy.Poly:
        s = self.A.variable
        coefficients = sympy.Poly(expression, s).all_coeffs()
        return sympy.Poly([element(self.field, sympy.expand(c), "force") for c in coefficients], s, domain=self.field)


def entries_with(A: SymbolicPolynomialMatrix, sources: Iterable[SymbolicSource]) -> list[sympy.Expr]:
    """The entries of A, and the coefficients of the rates and frequencies of the sources."""
    polynomials = {p for source in sources for p in (source.denominator, *source.numerator)}
    coefficients = [c for p in polynomials for c in sympy.Poly(p, A.variable).all_coeffs()]
    return [*(entry for matrix in A.coefficients for entry in matrix), *coefficients]


def divisors_of(expressions: Iterable[sympy.Expr], time: sympy.Symbol) -> list[sympy.Expr]:
    powers = set().union(*(expression.atoms(sympy.Pow) for expression in expressions))
    below = {power.base for power in powers if power.exp.could_extract_minus_sign() and not power.base.has(time)}
    return sorted((base for base in below if base.free_symbols), key=sympy.default_sort_key)


def _vanishing(divisor: sympy.Expr) -> tuple[sympy.Expr, ...]:
    """The factors that vanish for some positive symbols; the expression itself where it is not rational in them."""
    try:
        field = field_of([divisor])
        return must_not_vanish(field, [element(field, divisor, "divisor")])
    except InputError:
        return (divisor,)


def _amplitudes(field: Domain, expression: sympy.Expr) -> dict[sympy.Expr, object]:
    """An amplitude as a sum of generators, expressions that are not rational in the symbols of the field, with factors in the field."""
    factors: dict[sympy.Expr, object] = {}
    for part in sympy.Add.make_args(sympy.expand(expression)):
        outside, inside = [], field.one
        for factor in sympy.Mul.make_args(part):
            try:
                inside *= field.from_sympy(factor)
            except (CoercionFailed, ValueError, NotImplementedError):
                outside.append(factor)
        generator = sympy.Mul(*outside)
        factors[generator] = factors.get(generator, field.zero) + inside
    return {generator: factor for generator, factor in factors.items() if factor}


def _constant(like: sympy.Poly, value) -> sympy.Poly:
    return sympy.Poly([value], like.gen, domain=like.domain)


def regular_parts(size: int, transform: Sequence[Quotient], time: sympy.Expr) -> list[sympy.Expr]:
    """The functions of time whose transforms are the strictly proper parts of quotients: sums over factors, modes and powers of t.

    At a root x of a factor q^k a quotient is the sum of c_j(x) / (s - x)^j, j = 1 ... k, and more. The c_j are the same polynomials for
    all roots of q, with coefficients in K, computed in K[x]/q; no root is.
    """
    roots = {q: modes(q) for quotient in transform for q, _ in quotient.factors}  # before the long part: not all have a closed form
    principal: dict[tuple[sympy.Poly, int], dict[tuple[int, sympy.Expr], sympy.Poly]] = {}
    for quotient in transform:
        flat = [(i, g, p) for g, numerators in quotient.numerators.items() for i, p in enumerate(numerators) if not p.is_zero]
        for q, k in quotient.factors:
            ring = SymbolicRing.of(q)
            others = (taylor(ring, other, q, k) ** multiplicity for other, multiplicity in quotient.factors if other != q)
            weight = prod(others, start=slopes(ring, q, k) ** k).inverse
            for i, generator, numerator in flat:
                for j, c in enumerate((taylor(ring, numerator, q, k) * weight).coefficients[::-1]):
                    parts = principal.setdefault((q, j), {})
                    parts[i, generator] = parts.get((i, generator), 0 * c) + c
    total = [sympy.S.Zero] * size
    for (q, j), parts in principal.items():
        for root in roots[q]:
            factor = time**j / sympy.factorial(j) * sympy.exp(root.real * time)
            cosine, sine = sympy.cos(root.imaginary * time), sympy.sin(root.imaginary * time)
            for row in {i for (i, _), c in parts.items() if not c.is_zero}:
                weights = [(g, *root.weights(c)) for (i, g), c in parts.items() if i == row and not c.is_zero]
                above = sympy.Add(*(generator * weight for generator, weight, _ in weights))
                below = sympy.Add(*(generator * weight for generator, _, weight in weights))
                total[row] += factor * (above * cosine + below * sine)
    return total


# The inverse Laplace transform of b(s) / (a(s) s^gamma) as an expression in t.
#
# a(s) s^gamma is factored over the field of its coefficients: the rational numbers, or the rational functions of symbols.


def time_expression(
    numerator: Sequence[Fraction | sympy.Expr],
    denominator: Sequence[Fraction | sympy.Expr],
    gamma: int,
    t: sympy.Symbol | None = None,
) -> sympy.Expr:
    """y(t), t >= 0, whose transform is b(s) / (a(s) s^gamma), its polynomial part as derivatives of Dirac's delta.

    Symbols in the coefficients are positive and generic: the result holds where no two roots of different
    factors meet and no root of a factor is double, and everywhere else as a limit. Where the sign of w^2 in a factor
    (s + d)^2 + w^2 depends on the values of the symbols, the result is written with cos(w t) and sin(w t) and holds for
    w^2 < 0 as well; w^2 = 0 is a limit. Roots of degree 1 and 2 and quartics over one square root are in radicals.

    >>> time_expression([Fraction(2)], [Fraction(2), Fraction(2), Fraction(1)], 0)
    2*exp(-t)*sin(t)
    >>> k, m = sympy.symbols("k m", positive=True)
    >>> time_expression([Fraction(1)], [k, Fraction(0), m], 0)
    sin(sqrt(k)*t/sqrt(m))/(sqrt(k)*sqrt(m))
    """
    if isinstance(gamma, bool) or not isinstance(gamma, numbers.Integral):
        raise InputError(f"gamma: found {gamma!r}; expected a whole number")
    given = [_exact(numerator, "numerator"), _exact(denominator, "denominator")]
    symbols = symbols_of(given[0] + given[1])
    t = checked_time(t, symbols, "the coefficients'", "t")
    check_one_each([*symbols, t])
    names = as_positive(symbols)
    given = [[c.xreplace(names) for c in p] for p in given]
    field = field_of(given[0] + given[1])
    elements = [[element(field, c, "coefficients") for c in reversed(p)] for p in given]
    b, a = (sympy.Poly(p or [field.zero], S, domain=field) for p in elements)
    if a.is_zero:
        raise InputError("denominator: found a(s) = 0; expected a polynomial that is not zero")
    power = sympy.Poly(S ** abs(int(gamma)), S, domain=field)
    b, a = (b, a * power) if gamma > 0 else (b * power, a)
    common = a.gcd(b)
    b, a = b.quo(common), a.quo(common)
    impulses, rest = (p * _constant(p, field.one / a.rep.to_list()[0]) for p in b.div(a.monic()))
    coefficients = reversed(impulses.rep.to_list())
    total = [expression_of(field, c) * delta(t, k) for k, c in enumerate(coefficients) if c]
    expression = sympy.Add(*total, *regular_parts(1, [Quotient({sympy.S.One: [rest]}, factors_of(a))], t))
    return expression.xreplace({positive: symbol for symbol, positive in names.items()})


def _exact(coefficients, what: str) -> list[sympy.Expr]:
    if isinstance(coefficients, str) or not isinstance(coefficients, Iterable):
        raise InputError(f"{what}: found {coefficients!r}; expected a list of coefficients, the lowest power first")
    return [exact_expression(c, what) for c in coefficients]
