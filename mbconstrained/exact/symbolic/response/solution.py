"""From X(s) = A(s)^-1 b(s) to functions of time, impulses and values at 0+, all of it linear in the amplitudes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import sympy
from sympy.polys.domains import Domain

from ....errors import InputError
from ..algebra.assumptions import must_not_vanish
from ..algebra.laurent import series_at_infinity
from ..algebra.matrix import SymbolicPolynomialMatrix
from ..field.compact import factored
from ..field.factoring import Factors, factors_of
from ..field.fields import element, field_of
from .modes import Mode, modes
from .principal_parts import principal_parts
from .sources import Source, amplitudes

#: A linear combination of amplitudes.
Combination = dict[sympy.Expr, object]


@dataclass(frozen=True)
class Solution:
    """The response to sources that start together, in the time since then.

    Attributes:
        regular: matrix (r, 1).  impulses: matrices (r, 1).  start: x^(i)(0+), shape (q, r).
    """

    regular: sympy.ImmutableMatrix
    impulses: tuple[sympy.ImmutableMatrix, ...]
    start: sympy.ImmutableMatrix


@dataclass(frozen=True)
class Quotient:
    """X(s) of the sources that share a denominator: generator -> r numerators, over the product of the factors."""

    numerators: dict[sympy.Expr, list[sympy.Poly]]
    factors: Factors


def solution_of(A: SymbolicPolynomialMatrix, sources: Iterable[Source], field: Domain, time: sympy.Symbol) -> Solution:
    """The response to sources that start together."""
    found = quotients(A, sources, field)
    series = laurent_of(A, found, field)
    highest = max((power for power, row in series.items() if power >= 0 and any(row)), default=-1)
    impulses = [sympy.Matrix([combined(field, c) for c in series[power]]) for power in range(highest + 1)]
    start = [[combined(field, c) for c in series[-1 - i]] for i in range(A.degree)]
    return Solution(
        regular=sympy.Matrix(_regular(A.size, found, time)).as_immutable(),
        impulses=tuple(impulse.as_immutable() for impulse in impulses),
        start=sympy.Matrix(A.degree, A.size, [c for row in start for c in row]).as_immutable(),
    )


def quotients(A: SymbolicPolynomialMatrix, sources: Iterable[Source], field: Domain) -> list[Quotient]:
    """A(s)^-1 b(s), the sources taken together that share a denominator."""
    groups: dict[tuple, dict[sympy.Expr, list[sympy.Poly]]] = {}
    for source in sources:
        group = groups.setdefault((source.denominator, source.power), {})
        vector = [_polynomial(field, entry, A.variable) for entry in source.numerator]
        for generator, factor in amplitudes(field, source.amplitude).items():
            before = group.setdefault(generator, [0 * p for p in vector])
            group[generator] = [b + p * _constant(p, factor) for b, p in zip(before, vector, strict=True)]
    determinant = A.determinant.set_domain(field)
    adjugate = [[p.set_domain(field) for p in row] for row in A.adjugate]
    scale = _constant(determinant, field.one / determinant.rep.to_list()[0])
    of_det = factors_of(determinant)
    return [
        Quotient(
            {generator: _product(adjugate, b, scale) for generator, b in group.items()},
            _merged(of_det, factors_of(_polynomial(field, below, A.variable)) if power else [], power),
        )
        for (below, power), group in groups.items()
    ]


def laurent_of(A: SymbolicPolynomialMatrix, found: list[Quotient], field: Domain) -> dict[int, list[Combination]]:
    """The coefficients of s^p of X near infinity, p >= -q, one combination for each coordinate."""
    series: dict[int, list[Combination]] = {-1 - i: [{} for _ in range(A.size)] for i in range(A.degree)}
    for quotient in found:
        below = sympy.prod((q**k for q, k in quotient.factors), sympy.Poly(1, A.variable, domain=field))
        for generator, numerators in quotient.numerators.items():
            for i, numerator in enumerate(numerators):
                for power, c in series_at_infinity(numerator, below, -A.degree).items():
                    row = series.setdefault(power, [{} for _ in range(A.size)])
                    row[i][generator] = row[i].get(generator, field.zero) + c
    for power in range(max(series, default=-1) + 1):
        series.setdefault(power, [{} for _ in range(A.size)])
    return {power: [{g: c for g, c in entry.items() if c} for entry in row] for power, row in series.items()}


def combined(field: Domain, combination: Combination) -> sympy.Expr:
    """The sum of amplitudes and their factors."""
    return sympy.Add(*(generator * factored(field, factor) for generator, factor in combination.items()))


def assumptions_of(
    A: SymbolicPolynomialMatrix, sources: Iterable[Source], field: Domain, divisors: Iterable[sympy.Expr] = ()
) -> tuple[sympy.Expr, ...]:
    """What must not vanish so that the factors stay what they are: leading coefficient, discriminants, resultants; and divisors."""
    determinant = A.determinant.set_domain(field)
    below = {source.denominator for source in sources if source.power}
    factors = {q for q, _ in factors_of(determinant)}.union(
        q for p in below for q, _ in factors_of(_polynomial(field, p, A.variable))
    )
    factors = sorted(factors, key=lambda q: (q.degree(), str(q.as_expr())))
    values = [determinant.rep.to_list()[0]]
    values += [q.rep.discriminant() for q in factors if q.degree() > 1]
    values += [p.rep.resultant(q.rep) for p, q in combinations(factors, 2)]
    found = {each: None for each in must_not_vanish(field, values)}
    for each in (part for divisor in divisors for part in _vanishing(divisor)):
        if sympy.expand(-each) not in map(sympy.expand, found):
            found[each] = None
    return tuple(sorted(found, key=lambda e: (sympy.count_ops(e), str(e))))


def divisors_of(expressions: Iterable[sympy.Expr], time: sympy.Symbol) -> list[sympy.Expr]:
    """What is divided by in what the user gave.

    >>> a, b, t = sympy.symbols("a b t")
    >>> divisors_of([b * sympy.exp(-t / (a - b))], t)
    [a - b]
    """
    powers = set().union(*(expression.atoms(sympy.Pow) for expression in expressions))
    below = {power.base for power in powers if power.exp.could_extract_minus_sign() and not power.base.has(time)}
    return sorted((base for base in below if base.free_symbols), key=sympy.default_sort_key)


def _vanishing(divisor: sympy.Expr) -> tuple[sympy.Expr, ...]:
    """The factors of it that positive symbols can make zero; itself where it is not rational in them."""
    try:
        field = field_of([divisor])
        return must_not_vanish(field, [element(field, divisor, "divisor")])
    except InputError:
        return (divisor,)


def _polynomial(field, expression, s) -> sympy.Poly:
    coefficients = sympy.Poly(expression, s).all_coeffs()
    return sympy.Poly([element(field, sympy.expand(c), "force") for c in coefficients], s, domain=field)


def _constant(like: sympy.Poly, value) -> sympy.Poly:
    return sympy.Poly([value], like.gen, domain=like.domain)


def _product(adjugate, b, scale) -> list[sympy.Poly]:
    return [sum((p * e for p, e in zip(row, b, strict=True) if not e.is_zero), scale * 0) * scale for row in adjugate]


def _merged(factors: Factors, others: Factors, power: int) -> Factors:
    """Both lists as one, equal factors together."""
    total = dict(factors)
    for q, k in others:
        total[q] = total.get(q, 0) + k * power
    return list(total.items())


def _regular(size, found, time) -> list[sympy.Expr]:
    """The sum over factors, modes and powers of t."""
    roots = {q: modes(q) for quotient in found for q, _ in quotient.factors}  # before the long part: not all have a closed form
    principal: dict[tuple[sympy.Poly, int], list[dict]] = {}
    for quotient in found:
        flat = [(g, i, p) for g, numerators in quotient.numerators.items() for i, p in enumerate(numerators) if not p.is_zero]
        for (q, _), parts in zip(quotient.factors, principal_parts([p for _, _, p in flat], quotient.factors), strict=True):
            for (generator, i, _), coefficients in zip(flat, parts, strict=True):
                for j, c in enumerate(coefficients):
                    row = principal.setdefault((q, j), [{} for _ in range(size)])
                    row[i][generator] = row[i].get(generator, 0 * c) + c
    total = [sympy.S.Zero] * size
    for (q, j), rows in principal.items():
        nonzero = [{g: c for g, c in row.items() if not c.is_zero} for row in rows]
        if any(nonzero):
            total = [before + part for before, part in zip(total, functions_of(roots[q], j, nonzero, time), strict=True)]
    return total


def functions_of(
    roots: Iterable[Mode], j: int, rows: Sequence[Mapping[sympy.Expr, sympy.Poly]], time: sympy.Expr
) -> list[sympy.Expr]:
    """The sum over the roots x of c(x) t^j/j! e^{x t}, for each coordinate, c as generator -> polynomial."""
    found = [sympy.S.Zero] * len(rows)
    for mode in roots:
        power = time**j / sympy.factorial(j) * sympy.exp(mode.rate * time)
        cosine, sine = sympy.cos(mode.frequency * time), sympy.sin(mode.frequency * time)
        for i, row in enumerate(rows):
            weights = [(generator, mode.weights(c)) for generator, c in row.items()]
            above = sympy.Add(*(generator * weight[0] for generator, weight in weights))
            beside = sympy.Add(*(generator * weight[1] for generator, weight in weights))
            found[i] += power * (above * cosine + beside * sine)
    return found
