"""Functions of time, impulses and values at 0+ from X(s) = A(s)^-1 b(s), linear in the amplitudes."""

from __future__ import annotations

import numbers
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations

import sympy
from sympy.polys.domains import Domain
from sympy.polys.polyerrors import CoercionFailed

from ....ground.errors import InputError
from ...core.ring import series_at_infinity, slopes, taylor
from ..field.fields import as_positive, check_one_each, checked_time, element, exact_expression, expression_of, field_of, symbols_of
from ..field.radicals import Root, modes
from ..symbolic_matrix import S, SymbolicPolynomialMatrix
from ..symbolic_pairs import must_not_vanish
from ..symbolic_ring import Factors, SymbolicRing, factors_of
from .transform import SymbolicSource, delta

#: A linear combination of amplitudes.
Combination = dict[sympy.Expr, object]


@dataclass(frozen=True, eq=False)
class Quotient:
    """X(s) of the sources that share a denominator: generator -> r numerators, over the product of the factors."""

    numerators: dict[sympy.Expr, list[sympy.Poly]]
    factors: Factors


class ResponseTransform:
    """X(s) = A(s)^-1 b(s) of several sources, over the field with the symbols and numbers of A and of the sources.

    Args:
        A: degree q, size r.
        sources: with one start.
        field: field of A and of the sources, and of others where they are needed.
    """

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
        return [
            Quotient(
                {generator: _product(adjugate, b, scale) for generator, b in group.items()},
                _merged(of_det, factors_of(self._polynomial(below)) if power else [], power),
            )
            for (below, power), group in groups.items()
        ]

    @cached_property
    def laurent(self) -> dict[int, list[Combination]]:
        """The coefficients of s^p of X near infinity, p >= -q, one combination for each coordinate."""
        A, field = self.A, self.field
        series: dict[int, list[Combination]] = {-1 - i: [{} for _ in range(A.size)] for i in range(A.degree)}
        for quotient in self.quotients:
            below = sympy.prod((q**k for q, k in quotient.factors), sympy.Poly(1, A.variable, domain=field))
            for generator, numerators in quotient.numerators.items():
                for i, numerator in enumerate(numerators):
                    if numerator.is_zero:
                        continue
                    highest = numerator.degree() - below.degree()
                    powers = range(highest, -A.degree - 1, -1)
                    for power, c in zip(
                        powers, series_at_infinity(SymbolicRing.of(below), numerator, below, highest), strict=False
                    ):
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
    """The divisors in the given expressions.

    >>> a, b, t = sympy.symbols("a b t")
    >>> divisors_of([b * sympy.exp(-t / (a - b))], t)
    [a - b]
    """
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


def _product(adjugate, b, scale) -> list[sympy.Poly]:
    return [sum((p * e for p, e in zip(row, b, strict=True) if not e.is_zero), scale * 0) * scale for row in adjugate]


def _merged(factors: Factors, others: Factors, power: int) -> Factors:
    """Both lists as one, with equal factors combined."""
    total = dict(factors)
    for q, k in others:
        total[q] = total.get(q, 0) + k * power
    return list(total.items())


def regular_parts(size: int, transform: Sequence[Quotient], time: sympy.Expr) -> list[sympy.Expr]:
    """The functions of time whose transforms are the strictly proper parts of quotients: sums over factors, modes and powers of t."""
    roots = {q: modes(q) for quotient in transform for q, _ in quotient.factors}  # before the long part: not all have a closed form
    principal: dict[tuple[sympy.Poly, int], list[dict]] = {}
    for quotient in transform:
        flat = [(g, i, p) for g, numerators in quotient.numerators.items() for i, p in enumerate(numerators) if not p.is_zero]
        for (q, _), parts in zip(quotient.factors, _principal_parts([p for _, _, p in flat], quotient.factors), strict=True):
            for (generator, i, _), coefficients in zip(flat, parts, strict=True):
                for j, c in enumerate(coefficients):
                    row = principal.setdefault((q, j), [{} for _ in range(size)])
                    row[i][generator] = row[i].get(generator, 0 * c) + c
    total = [sympy.S.Zero] * size
    for (q, j), rows in principal.items():
        nonzero = [{g: c for g, c in row.items() if not c.is_zero} for row in rows]
        if any(nonzero):
            total = [before + part for before, part in zip(total, _functions(roots[q], j, nonzero, time), strict=True)]
    return total


def _functions(roots: Iterable[Root], j: int, rows: Sequence[Mapping], time: sympy.Expr) -> list[sympy.Expr]:
    """The sum over the roots x of c(x) t^j/j! e^{x t}, for each coordinate, c as generator -> polynomial."""
    total = [sympy.S.Zero] * len(rows)
    for root in roots:
        factor = time**j / sympy.factorial(j) * sympy.exp(root.real * time)
        cosine, sine = sympy.cos(root.imaginary * time), sympy.sin(root.imaginary * time)
        for i, row in enumerate(rows):
            weights = [(generator, *root.weights(c)) for generator, c in row.items()]
            above = sympy.Add(*(generator * weight for generator, weight, _ in weights))
            below = sympy.Add(*(generator * weight for generator, _, weight in weights))
            total[i] += factor * (above * cosine + below * sine)
    return total


# Partial fractions over a field K: exact, the roots of irreducible factors never computed.
#
# At a root x of an irreducible factor q of the denominator, of multiplicity k, the coefficients of the principal part are the
# same polynomials in x for all roots of q, with coefficients in K: they are computed in K[x]/q.


def _principal_parts(numerators: Sequence[sympy.Poly], factors: Factors) -> list[list[list[sympy.Poly]]]:
    """For each factor q, for each numerator b: c_1 ... c_k of b / product = sum of c_j / (s - x)^j + ... at a root x of q."""
    return [_at_factor(numerators, factors, q, k) for q, k in factors]


def _at_factor(numerators, factors, q, k) -> list[list[sympy.Poly]]:
    ring = SymbolicRing.of(q)
    below = slopes(ring, q, k) ** k
    for other, multiplicity in factors:
        if other != q:
            below *= taylor(ring, other, q, k) ** multiplicity
    weight = below.inverse
    return [(taylor(ring, b, q, k) * weight).coefficients[::-1] for b in numerators]


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
    expression = _inverse(*_polynomials([[c.xreplace(names) for c in p] for p in given]), int(gamma), t)
    return expression.xreplace({positive: symbol for symbol, positive in names.items()})


def _inverse(b: sympy.Poly, a: sympy.Poly, gamma: int, t: sympy.Symbol) -> sympy.Expr:
    """The inverse transform of b(s) / (a(s) s^gamma)."""
    if a.is_zero:
        raise InputError("denominator: found a(s) = 0; expected a polynomial that is not zero")
    power = sympy.Poly(S ** abs(gamma), S, domain=a.domain)
    b, a = (b, a * power) if gamma > 0 else (b * power, a)
    factors, b = _cancelled(b, factors_of(a) if not b.is_zero else [], a.rep.to_list()[0])
    product = sympy.prod((q**k for q, k in factors), sympy.Poly(1, S, domain=a.domain))
    impulses, rest = b.div(product)
    coefficients = reversed(impulses.rep.to_list())
    total = [expression_of(a.domain, c) * delta(t, k) for k, c in enumerate(coefficients) if c]
    return sympy.Add(*total, *regular_parts(1, [Quotient({sympy.S.One: [rest]}, factors)], t))


def _exact(coefficients, what: str) -> list[sympy.Expr]:
    if isinstance(coefficients, str) or not isinstance(coefficients, Iterable):
        raise InputError(f"{what}: found {coefficients!r}; expected a list of coefficients, the lowest power first")
    return [exact_expression(c, what) for c in coefficients]


def _polynomials(given: list[list[sympy.Expr]]) -> list[sympy.Poly]:
    """b and a over the smallest field with their coefficients."""
    field = field_of(given[0] + given[1])
    elements = [[element(field, c, "coefficients") for c in reversed(p)] for p in given]
    return [sympy.Poly(p or [field.zero], S, domain=field) for p in elements]


def _cancelled(b, factors, leading):
    """The factors and b / leading without common factors."""
    left = []
    b = b * sympy.Poly([b.domain.one / leading], S, domain=b.domain)
    for q, k in factors:
        while k:
            quotient, rest = b.div(q)
            if not rest.is_zero:
                break
            b, k = quotient, k - 1
        left += [(q, k)] if k else []
    return left, b
