"""The motion of A(d/dt) x = f with symbols in A, in the values at 0- and in the force, in closed form.

Laplace transforms with symbols and their inverse: forces and values at 0- as sources in s, and functions of time, impulses and values at
0+ from X(s) = A(s)^-1 b(s), linear in the amplitudes.

A force is a sum of terms c t^k e^{a t} cos(w t + p) from a time t_0 on, or c delta^(l)(t - t_0). Sums, products and powers of constants,
t, exp, cos, sin, cosh, sinh, Heaviside and DiracDelta are sums of such terms; nothing else is.
"""

from __future__ import annotations

import numbers
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, reduce
from itertools import combinations
from math import prod
from typing import Any

import sympy
from sympy.polys.domains import Domain
from sympy.polys.matrices import DomainMatrix
from sympy.polys.polyerrors import CoercionFailed

from ...ground.checks import counted, whole_number
from ...ground.display import Displayed
from ...ground.errors import InputError
from ..engine import series_at_infinity, slopes, taylor
from .fields import (
    TIME,
    as_positive,
    check_one_each,
    check_positive,
    check_start_names,
    checked_time,
    element,
    exact_expression,
    expression_of,
    field_of,
    generators_of,
    symbols_of,
)
from .radicals import modes
from .symbolic_matrix import Factors, S, SymbolicPolynomialMatrix, SymbolicRing, checked_matrix, factors_of, must_not_vanish

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
        return self.impulse is None and not self.power and self.rate == self.frequency == self.phase == self.start == 0

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
    if one.is_constant:
        return [other.scaled(one.coefficient)]
    if other.is_constant:
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
                group[generator] = [b + p.mul_ground(factor) for b, p in zip(before, vector, strict=True)]
        determinant = A.determinant.set_domain(field)
        adjugate = [[p.set_domain(field) for p in row] for row in A.adjugate]
        zero, scale = 0 * determinant, field.one / determinant.rep.to_list()[0]
        of_det = factors_of(determinant)
        quotients = []
        for (below, power), group in groups.items():
            factors = dict(of_det)
            for q, k in factors_of(self._polynomial(below)) if power else []:
                factors[q] = factors.get(q, 0) + k * power
            numerators = {
                generator: [
                    sum((p * e for p, e in zip(row, b, strict=True) if not e.is_zero), zero).mul_ground(scale) for row in adjugate
                ]
                for generator, b in group.items()
            }
            quotients.append(Quotient(numerators, list(factors.items())))
        return quotients

    @cached_property
    def laurent(self) -> dict[int, list[Combination]]:
        """The coefficients of s^p of X near infinity, p >= -q, one combination for each coordinate."""
        size, degree, terms = self.A.size, self.A.degree, []
        for quotient in self.quotients:
            below = sympy.prod((q**k for q, k in quotient.factors), sympy.Poly(1, self.A.variable, domain=self.field))
            for generator, numerators in quotient.numerators.items():
                for i, numerator in enumerate(numerators):
                    if not numerator.is_zero:
                        first = numerator.degree() - below.degree()
                        terms.append((i, generator, first, series_at_infinity(SymbolicRing.of(below), numerator, below, first)))
        total: dict[int, list[Combination]] = {}
        for power in range(max([-1, *(first for _, _, first, _ in terms)]), -degree - 1, -1):
            row: list[Combination] = [{} for _ in range(size)]
            for i, generator, first, series in terms:
                if power <= first:
                    row[i][generator] = row[i].get(generator, self.field.zero) + next(series)
            total[power] = [{g: c for g, c in entry.items() if c} for entry in row]
        return total

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


# At a root x of a factor q^k a quotient is the sum of c_j(x) / (s - x)^j, j = 1 ... k, and more. The c_j are the same polynomials for
# all roots of q, with coefficients in K, computed in K[x]/q; no root is.


def regular_parts(size: int, transform: Sequence[Quotient], time: sympy.Expr) -> list[sympy.Expr]:
    """The functions of time whose transforms are the strictly proper parts of quotients: sums over factors, modes and powers of t."""
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
    """y(t), t >= 0, whose transform is b(s) / (a(s) s^gamma), its polynomial part as derivatives of Dirac's delta; symbols as in ``solve_symbolically``."""
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
    impulses, rest = (p.mul_ground(field.one / a.rep.to_list()[0]) for p in b.div(a.monic()))
    coefficients = reversed(impulses.rep.to_list())
    total = [expression_of(field, c) * delta(t, k) for k, c in enumerate(coefficients) if c]
    expression = sympy.Add(*total, *regular_parts(1, [Quotient({sympy.S.One: [rest]}, factors_of(a))], t))
    return expression.xreplace({positive: symbol for symbol, positive in names.items()})


def _exact(coefficients, what: str) -> list[sympy.Expr]:
    if isinstance(coefficients, str) or not isinstance(coefficients, Iterable):
        raise InputError(f"{what}: found {coefficients!r}; expected a list of coefficients, the lowest power first")
    return [exact_expression(c, what) for c in coefficients]


# The response.


@dataclass(frozen=True, repr=False, eq=False)
class SymbolicResponse(Displayed):
    """x(t), t > 0, and its impulses, as expressions.

    Where the sign of a discriminant such as 4 k m - c^2 is open, cos(w t) and sin(w t)/w hold for both, but w may be the root of
    a negative number (a function that ``sympy.lambdify`` makes of it needs complex numbers then: c=10+0j), and w = 0 is a limit
    that putting in values gives as nan. ``at`` puts in values by solving again.

    Attributes:
        regular: x(t) for t > 0, without impulses, a matrix (r, 1); what starts later is in it with Heaviside(t - t0).
        impulses: matrices (r, 1), the k-th multiplies the k-th derivative of Dirac's delta at 0.
        later_impulses: (t0, matrices (r, 1)) for each later time at which the force makes impulses.
        start: x^(i)(0+) as row i, shape (q, r).
        initial: the values at 0-, shape (q, r).
        force: f as a matrix (r, 1).
        time: the symbol t.
        assumptions: expressions that must not vanish: where one vanishes, two zeros meet (resonance is one case), and x(t) is
            the limit of the expression; where the leading coefficient of det A vanishes, A has another structure. With what
            the given expressions are divided by, and with start times of which it is not declared that they are positive.
        polynomial_matrix: A(s).
    """

    polynomial_matrix: SymbolicPolynomialMatrix
    initial: sympy.ImmutableMatrix
    force: sympy.ImmutableMatrix
    time: sympy.Symbol
    regular: sympy.ImmutableMatrix
    impulses: tuple[sympy.ImmutableMatrix, ...]
    later_impulses: tuple[tuple[sympy.Expr, tuple[sympy.ImmutableMatrix, ...]], ...]
    start: sympy.ImmutableMatrix
    assumptions: tuple[sympy.Expr, ...]
    force_sources: tuple[SymbolicSource, ...] = field(repr=False)

    def _summary(self) -> str:
        free = ", ".join(sorted(map(str, self.regular.free_symbols)))
        return f"{counted(len(self.coordinates), 'coordinate')} in {free or 'no symbols'}"

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the coordinates."""
        return tuple(self.polynomial_matrix.coordinates)

    @cached_property
    def expression(self) -> sympy.ImmutableMatrix:
        """x with its impulses as DiracDelta terms, a matrix (r, 1)."""
        total = sympy.Matrix(self.regular)
        for t0, impulses in ((sympy.S.Zero, self.impulses), *self.later_impulses):
            for k, impulse in enumerate(impulses):
                total += impulse * delta(self.time - t0, k)
        return total.as_immutable()

    @property
    def jump(self) -> sympy.ImmutableMatrix:
        """x^(i)(0+) - x^(i)(0-), shape (q, r)."""
        return (self.start - self.initial).applyfunc(sympy.expand).as_immutable()

    def derivative(self, order: int = 1) -> sympy.ImmutableMatrix:
        """The derivative of x for t > 0 (away from later steps), a matrix (r, 1)."""
        order = whole_number(order, "order", minimum=0)
        return self.regular.diff(self.time, order).replace(sympy.DiracDelta, lambda *_: sympy.S.Zero) if order else self.regular

    def at(self, values: Mapping[sympy.Symbol, object]) -> SymbolicResponse:
        """Return the response for values of some or all symbols, solved again with these in A, start and force.

        So it holds where zeros meet (the critical damping, resonance) and where A has another structure, too.

        Args:
            values: numbers of any sign, or expressions, by symbol.

        Raises:
            InputError: a key is none of the symbols, a value no number, or an entry infinite for it; as ``solve_symbolically``.
            SingularPolynomialMatrix: det A(s) = 0 for every s with these values.

        >>> m, c, k = sympy.symbols("m c k", positive=True)
        >>> x = solve_symbolically(SymbolicPolynomialMatrix([[[k]], [[c]], [[m]]]), [[1], [0]])
        >>> x.at({m: 1, c: 2, k: 1}).regular
        Matrix([[t*exp(-t) + exp(-t)]])
        """
        A = self.polynomial_matrix
        known = {*A.symbols, *self.initial.free_symbols, *self.force.free_symbols} - {self.time}
        if not isinstance(values, Mapping) or not set(values) <= known:
            names = ", ".join(sorted(symbol.name for symbol in known))
            raise InputError(f"values: found {values!r}; expected a dictionary with values by symbol, of {names or 'none here'}")
        put = {symbol: exact_expression(value, str(symbol)) for symbol, value in values.items()}
        matrices = [matrix.xreplace(put) for matrix in A.coefficients]
        changed = SymbolicPolynomialMatrix(matrices, A.coordinates, A.equations)
        return solve_symbolically(changed, self.initial.xreplace(put), self.force.xreplace(put), self.time)

    @cached_property
    def admissible_conditions(self) -> tuple[sympy.Eq, ...]:
        """Equations in ``initial_symbols(A)`` that hold where there are no impulses at 0 (Moysis et al., Eq. 58, with f^(j)(0+))."""
        return impulse_equations(self.polynomial_matrix, self.force_sources)

    @cached_property
    def continuity_conditions(self) -> tuple[sympy.Eq, ...]:
        """Equations in ``initial_symbols(A)`` that hold where x, ..., x^(q-1) are continuous at 0 (Eq. 60, corrected)."""
        return continuity_equations(self.polynomial_matrix, self.force_sources)


def solve_symbolically(
    A: SymbolicPolynomialMatrix, initial=None, force: Sequence | None = None, time: sympy.Symbol | None = None
) -> SymbolicResponse:
    """Solve X(s) = A(s)^-1 (X_in(s) + F(s)) in closed form (Moysis et al., Eqs. 46-48; one-sided from 0-).

    The exact principal part of X at every root of det A and of the force's denominators, transformed back term by term, gives
    the regular part; the Laurent coefficients of X at infinity give impulses and values at 0+. Nothing is a limit, and nothing
    is simplified by trial. Symbols are positive and generic (``assumptions`` of the result); where the sign of a discriminant
    such as c^2 - 4 k m is not decided by that, the oscillating form is given: it holds for both signs, and for 0 as a limit.

    Args:
        A: degree q, size r.
        initial: x^(i)(0-) as row i, shape (q, r), expressions or numbers; "symbols" for ``initial_symbols(A)``; None for zeros.
        force: r expressions in the time: sums and products of constants, t^k, exp, cos, sin, cosh, sinh,
            Heaviside(t - t0) and DiracDelta(t - t0, k), with symbols as rates, frequencies, phases and times, all
            positive; None for zeros.
        time: its symbol; None for the one called t in the force, or a real one.

    Returns:
        The response: regular part, impulses, values at 0+, and the assumptions under which they hold.

    Raises:
        InputError: shapes; a force of other functions, or of functions without the time; a parameter called like the time or
            like a value at 0- (x1_0); det A has a factor without roots in closed form.
        SingularPolynomialMatrix: det A(s) = 0 for every s.

    >>> m, k, x0, v0 = sympy.symbols("m k x0 v0", positive=True)
    >>> x = solve_symbolically(SymbolicPolynomialMatrix([[[k]], [[0]], [[m]]]), [[x0], [v0]])
    >>> x.regular[0]
    x0*cos(sqrt(k)*t/sqrt(m)) + sqrt(m)*v0*sin(sqrt(k)*t/sqrt(m))/sqrt(k)
    """
    X0, f = checked_initial(checked_matrix(A), initial), _checked_force(A, force)
    time = _time_of(A, X0, f, time)
    sources = tuple(force_sources(A, f, time))
    names = as_positive(generators_of(entries_with(A, sources)))
    solution = _solution(A.with_positive_symbols, X0.xreplace(names), f.xreplace(names), time)
    own = {positive: symbol for symbol, positive in names.items()}
    later = [start for start in {source.start for source in sources} if not (start.is_positive or start == 0)]
    return SymbolicResponse(
        polynomial_matrix=A,
        initial=X0,
        force=f,
        time=time,
        force_sources=sources,
        assumptions=(*(each.xreplace(own) for each in solution.pop("assumptions")), *later),
        **{name: _renamed(value, own) for name, value in solution.items()},
    )


def _solution(A, X0, f, time) -> dict[str, Any]:
    """The fields of the response; roots of symbols are short only where these are declared positive."""
    sources = initial_sources(A, X0) + force_sources(A, f, time)
    whole = ResponseTransform(A, sources)
    parts: dict[sympy.Expr, list[SymbolicSource]] = {sympy.S.Zero: []}
    for source in sources:
        parts.setdefault(source.start, []).append(source)
    later = {start: ResponseTransform(A, group, whole.field) for start, group in parts.items()}
    now = later.pop(sympy.S.Zero)
    regular = sympy.Matrix(now.regular(time))
    for t0, transform in later.items():
        regular += transform.regular(time).xreplace({time: time - t0}) * sympy.Heaviside(time - t0)
    divisors = divisors_of([*X0, *f, *(entry for matrix in A.coefficients for entry in matrix)], time)
    return {
        "regular": regular.as_immutable(),
        "impulses": now.impulses,
        "later_impulses": tuple((t0, transform.impulses) for t0, transform in later.items() if transform.impulses),
        "start": now.start,
        "assumptions": whole.assumptions(divisors),
    }


def _renamed(value, names: Mapping):
    """Matrices in tuples with other symbols."""
    return tuple(_renamed(each, names) for each in value) if isinstance(value, tuple) else value.xreplace(names)


# Validation of the values at 0-, the force and the symbol of the time.

#: Functions of time, the argument of which must be known to be time or not.
FUNCTIONS = (sympy.sin, sympy.cos, sympy.sinh, sympy.cosh, sympy.exp, sympy.Heaviside, sympy.DiracDelta)


def checked_initial(A: SymbolicPolynomialMatrix, initial) -> sympy.ImmutableMatrix:
    """The values at 0- as exact expressions."""
    if isinstance(initial, str):
        if initial != "symbols":
            raise InputError(f'initial: found {initial!r}; expected rows of values, "symbols" or None')
        return initial_symbols(A)
    if initial is None:
        return sympy.zeros(A.degree, A.size).as_immutable()
    rows = [_listed(row) for row in _listed(initial) or ()]
    if len(rows) != A.degree or any(row is None or len(row) != A.size for row in rows):
        wanted = f"expected {A.degree} rows of {A.size} values, row i the i-th derivatives at 0-"
        raise InputError(f"initial: {wanted}, [[x(0-), ...], [x'(0-), ...], ...]; found {initial!r}")
    return sympy.Matrix(A.degree, A.size, [exact_expression(value, "initial") for row in rows for value in row]).as_immutable()


def _checked_force(A: SymbolicPolynomialMatrix, force) -> sympy.ImmutableMatrix:
    """The force as exact expressions, shape (r, 1)."""
    if force is None:
        return sympy.zeros(A.size, 1).as_immutable()
    rows = _listed(force)
    if rows is None:
        raise InputError(
            f"force: found {force!r}; expected a list of {counted(A.size, 'sympy expression')} in the time, such as F*sin(w*t), "
            "exp(-a*t), Heaviside(t - t0) (mb.step and others like it are forces of mb.solve)"
        )
    rows = [row[0] if isinstance(row, list) and len(row) == 1 else row for row in rows]
    if len(rows) != A.size:
        raise InputError(f"force: found {len(rows)} entries; expected {A.size}, one expression in the time for each equation")
    return sympy.Matrix([exact_expression(value, "force") for value in rows]).as_immutable()


def _listed(value) -> list | None:
    """A list or a matrix as a list; None for anything else."""
    rows = value.tolist() if hasattr(value, "tolist") else value
    return list(rows) if isinstance(rows, Sequence) and not isinstance(rows, str) else None


def _time_of(A: SymbolicPolynomialMatrix, initial: sympy.Matrix, force: sympy.Matrix, time) -> sympy.Symbol:
    """The symbol of the time, which may occur in the force only."""
    if time is None:
        named = [symbol for symbol in force.free_symbols if symbol.name == TIME.name]
        odd = {function for function in force.atoms(*FUNCTIONS) if function.free_symbols}
        if odd and not named:
            function = min(odd, key=sympy.default_sort_key)
            symbol = min(function.free_symbols, key=str)
            raise InputError(
                f"force: found {function}, but no time t; if {symbol} is the time, pass time={symbol}; if the force is constant, pass "
                "time=sympy.Symbol('t', real=True)"
            )
        time = named[0] if named else TIME
    others = {*A.symbols, *initial.free_symbols}
    time = checked_time(time, others, "A or of the values at 0-")
    check_one_each([*others, *force.free_symbols, time])
    started = {value for value, own in zip(initial, initial_symbols(A)) if value == own}
    check_start_names(A.coordinates, A.degree, force.free_symbols - started)
    return time


# Conditions on the values at 0-, as row-reduced linear equations: without impulses, and without jumps.


def impulse_equations(A: SymbolicPolynomialMatrix, force: Iterable[SymbolicSource] = ()) -> tuple[sympy.Eq, ...]:
    """Equations in ``initial_symbols(A)`` equivalent to the absence of impulses (Moysis et al., Eq. 58).

    Corrected: the force enters by f^(j)(0+), not by f^(j)(0-); Dirac impulses of the force itself act whatever the start is and
    are left out. The equations are the polynomial part of X(s), row reduced: each gives one value in terms of later ones.
    """
    general = _general(A, force)
    return _reduced(general, [entry for power, row in general.laurent.items() if power >= 0 for entry in row])


def continuity_equations(A: SymbolicPolynomialMatrix, force: Iterable[SymbolicSource] = ()) -> tuple[sympy.Eq, ...]:
    """Equations in ``initial_symbols(A)`` equivalent to x^(i)(0+) = x^(i)(0-), i < q (Eq. 60).

    Corrected: the right-hand side of (60) is block Toeplitz, its block (k, c) is H_{c-k} with the H of negative index too,
    which are what the derivatives of the convolution leave at 0+. They imply that there are no impulses.
    """
    general, symbols, rows = _general(A, force), initial_symbols(A), []
    for i in range(A.degree):
        for j, entry in enumerate(general.laurent[-1 - i]):
            before = symbols[i, j]
            rows.append({**entry, before: entry.get(before, general.field.zero) - general.field.one})
    return _reduced(general, rows)


def _general(A: SymbolicPolynomialMatrix, force: Iterable[SymbolicSource]) -> ResponseTransform:
    """X for general values at 0-."""
    smooth = [source for source in force if source.start == 0 and not source.is_impulse]
    return ResponseTransform(A, initial_sources(A, initial_symbols(A)) + smooth)


def _reduced(general: ResponseTransform, rows: list[Combination]) -> tuple[sympy.Eq, ...]:
    """The equations rows = 0 solved for their earliest values."""
    field, values = general.field, list(initial_symbols(general.A))
    others = sorted({g for row in rows for g in row} - set(values), key=sympy.default_sort_key)
    columns = [*values, *others]
    if not rows or not columns:
        return ()
    matrix = DomainMatrix([[row.get(g, field.zero) for g in columns] for row in rows], (len(rows), len(columns)), field)
    reduced, pivots = matrix.rref()
    equations = []
    for row, pivot in zip(reduced.to_list(), pivots):
        rest = {generator: -factor for place, (generator, factor) in enumerate(zip(columns, row)) if factor and place != pivot}
        equations.append(sympy.Eq(columns[pivot], general.combined(rest), evaluate=False))
    return tuple(equations)
