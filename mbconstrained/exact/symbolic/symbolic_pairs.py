"""Zeros in radicals, the polynomials over the field of the entries as the engine takes them, and the Jordan pairs with symbols."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial, reduce
from typing import Any, Protocol

import sympy
from sympy.polys.domains.domain import Domain
from sympy.polys.matrices import DomainMatrix

from ...ground.errors import InputError
from ..engine import ExactJordanPairs, ExactMatrix, ExactPair, HypercompanionBlock, JordanChain
from .fields import (
    Surd,
    coefficients,
    common_denominator,
    compact_expression,
    compact_root,
    expression_of,
    in_one_form,
    integers,
    root_expression,
    sign,
    sign_with_root,
    square_root,
)

# Zeros of irreducible polynomials, and values of polynomials there, in the form of responses and Jordan forms.
#
# In radicals over the field K of the entries: degrees 1 and 2, s^4 + b s^2 + c (undamped systems of two degrees of freedom) and
# other products of two quadratics over K(sqrt(g)). Values are computed in K(sqrt(g)) exactly and written down once: nothing is
# simplified afterwards. Other polynomials with numbers have zeros of 30 digits, others with symbols none.

#: Real and imaginary part of the value of a polynomial.
Parts = tuple[sympy.Expr, sympy.Expr]


@dataclass(frozen=True)
class Root:
    """A zero of an irreducible polynomial p.

    Attributes:
        real, imaginary: its parts; the imaginary one is 0 for a real zero, and of a complex pair this is the zero with the
            positive one, where the sign is seen. Where it depends on the symbols whether two zeros are real (under- or
            overdamped), a square root in them may be one of a negative number, as in Moysis et al., Eq. 95.
        at: the parts of e(root) for a Poly e over the field.
    """

    real: sympy.Expr
    imaginary: sympy.Expr
    at: Callable[[sympy.Poly], Parts]

    @property
    def value(self) -> sympy.Expr:
        return self.real + sympy.I * self.imaginary

    @property
    def is_pair(self) -> bool:
        return self.imaginary != 0

    def weights(self, c: sympy.Poly) -> Parts:
        """The factors of cos(w t) and sin(w t) in the sum of c(x) e^{(x - rate) t} over the zero or the pair, w the imaginary part."""
        real, imaginary = self.at(c)
        return (2 * real, -2 * imaginary) if self.is_pair else (real, sympy.S.Zero)


def roots(p: sympy.Poly, split: bool = True) -> tuple[Root, ...] | None:
    """The zeros of an irreducible monic p over the field, one of each complex pair; None for symbols without a short closed form."""
    field = p.domain
    if p.degree() == 1:
        return (_root(p, lambda e: (expression_of(field, coefficients(e, 1)[0]), sympy.S.Zero)),)
    if p.degree() == 2:
        b, a = (Surd(field, c, field.zero, field.one) for c in coefficients(p, 2))
        return _of_quadratic(p, Quadratic(a, b), split)
    factors = quadratic_factors(p) if p.degree() == 4 else None
    if factors is not None:
        one = Quadratic(*factors)
        if sign(field, one.b.g) == -1:
            return tuple(_of_complex_quadratic(p, one, branch) for branch in (1, -1))
        return (*_of_quadratic(p, one, split), *_of_quadratic(p, one.conjugate, split))
    if p.free_symbols_in_domain:  # pi is none
        return None
    numerical = p if p.domain.is_QQ else sympy.Poly([c.evalf(3 * DIGITS) for c in p.all_coeffs()], p.gen)
    parts = [root.as_real_imag() for root in numerical.nroots(n=2 * DIGITS, maxsteps=500)]
    above = [(real, imaginary) for real, imaginary in parts if imaginary >= 0]
    return tuple(Root(*map(_rounded, root), lambda e, root=root: _value_at(root, e.rem(p))) for root in above)


def modes(q: sympy.Poly) -> tuple[Root, ...]:
    """The zeros of an irreducible polynomial as exponents of functions of time: e^{a t} cos(w t) and e^{a t} sin(w t).

    Where the sign of w^2 depends on the values of the symbols, as that of 4 k m - c^2 does, the pair a +- i w is given: cos(w t) and
    w sin(w t) are even in w, so that they hold for w^2 < 0 as well, with the root of a negative number, and for w^2 = 0 as a limit.
    """
    zeros = roots(q.monic(), split=False)
    if zeros is None:
        raise InputError(
            f"the factor {q.as_expr()} of the determinant has no roots in closed form; give some of its symbols "
            f"({', '.join(map(str, q.domain.symbols))}) as numbers, or use numbers throughout (mb.solve)"
        )
    return zeros


def _root(p: sympy.Poly, parts: Callable[[sympy.Poly], Parts]) -> Root:
    """The root at which polynomials modulo p have these parts."""
    x = sympy.Poly([p.domain.one, p.domain.zero], p.gen, domain=p.domain)
    return Root(*parts(x.rem(p)), lambda e: parts(e.rem(p)))


def _of_quadratic(p, quadratic: Quadratic, split: bool) -> tuple[Root, ...]:
    """A complex pair where b - a^2/4 is positive, -a/2 +- sqrt(a^2/4 - b) elsewhere."""
    known = quadratic.square.sign()
    if known == 1 or (known is None and not split):
        frequency = _root_of_difference(quadratic, 1)

        def parts(e) -> Parts:
            even, *odd = quadratic.value(e)
            return compact_expression(even), _multiple(*odd, frequency)

        return (Root(compact_expression(quadratic.middle), frequency, lambda e: parts(e.rem(p))),)
    middle, distance = compact_expression(quadratic.middle), _root_of_difference(quadratic, -1)

    def part(branch: int, e) -> Parts:
        even, odd, turned = quadratic.value(e.rem(p))
        return compact_expression(even) + branch * _multiple(odd, -turned, distance), sympy.S.Zero

    return tuple(Root(middle + branch * distance, sympy.S.Zero, partial(part, branch)) for branch in (-1, 1))


def _root_of_difference(quadratic: Quadratic, branch: int) -> sympy.Expr:
    """The root of b - middle^2 (branch 1) or of middle^2 - b (branch -1), with a difference of factors under it where that is shorter."""
    b, middle, field = quadratic.b, quadratic.middle, quadratic.b.field
    direct = _number_in_front(compact_root(quadratic.square if branch == 1 else -quadratic.square))
    if b.v or middle.v or not field.is_FractionField:
        return direct
    below = field.convert(field.denom(middle.u), field.get_ring())
    inside = branch * (expression_of(field, b.u * below**2) - expression_of(field, (middle.u * below) ** 2))
    return min(direct, sympy.sqrt(inside) / expression_of(field, below), key=sympy.count_ops)


def _multiple(number: Surd, turned: Surd, root: sympy.Expr) -> sympy.Expr:
    """number times the root, or turned / root where that is shorter: turned is number times the square of the root."""
    if not number.u and not number.v:
        return sympy.S.Zero
    forms = compact_expression(number) * root, compact_expression(turned) / root
    return min(map(_number_in_front, forms), key=sympy.count_ops)


def _number_in_front(product: sympy.Expr) -> sympy.Expr:
    """The product without roots in the denominator of its leading number."""
    number, rest = product.as_independent(*product.free_symbols, as_Add=False) if product.free_symbols else (product, sympy.S.One)
    return sympy.expand(sympy.radsimp(number)) * rest


def _of_complex_quadratic(p, quadratic: Quadratic, branch: int) -> Root:
    """x = middle + branch (alpha + i beta), with sqrt(g) = i r and (alpha + i beta)^2 = -square; the conjugates are the other zeros."""
    field, middle, square = p.domain, quadratic.middle, -quadratic.square
    norm, r = square.u**2 - square.v**2 * square.g, root_expression(field, -square.g)
    twice = 2 * root_expression(field, norm)
    alpha = branch * sympy.sqrt(twice + expression_of(field, square.u + square.u)) / 2
    side = sign(field, square.v)
    beta = expression_of(field, square.v) * r / (2 * alpha)
    if side:
        beta = branch * side * sympy.sqrt(twice - expression_of(field, square.u + square.u)) / 2
    longer = sign_with_root(field, 2 * middle.v**2 * middle.g - square.u, field.one, norm)  # of beta^2 - (middle.v r)^2
    up = {1: branch * side if side else 1, -1: sign(field, middle.v)}.get(longer) or 1

    def parts(e) -> Parts:
        even, odd, _ = quadratic.value(e)
        (e0, e1), (o0, o1) = ((expression_of(field, part.u), expression_of(field, part.v) * r) for part in (even, odd))
        return e0 + o0 * alpha - o1 * beta, up * (e1 + o1 * alpha + o0 * beta)

    return _root(p, parts)


#: Digits of zeros that have no closed form, and of values of polynomials there.
DIGITS = 30


def _value_at(root: tuple[sympy.Expr, sympy.Expr], e: sympy.Poly) -> Parts:
    """Real and imaginary part of e(root), rounded to ``DIGITS`` digits."""
    real, imaginary = root
    above, below = sympy.S.Zero, sympy.S.Zero
    for c in e.all_coeffs():
        number = sympy.N(c, 2 * DIGITS)
        above, below = above * real - below * imaginary + number, above * imaginary + below * real
    return _rounded(above), _rounded(below)


def _rounded(number: sympy.Expr) -> sympy.Expr:
    """A number rounded to ``DIGITS`` digits; zero stays exact."""
    return sympy.N(number, DIGITS) if number != 0 else sympy.S.Zero


#: The order of preference of square roots: a real one, one that is imaginary for certain, one that depends on the symbols.
ORDER = {1: 0, -1: 1, None: 2}


def quadratic_factors(q: sympy.Poly) -> tuple[Surd, Surd] | None:
    """(a, b) with the quartic q = (s^2 + a s + b) times its conjugate (Ferrari), real where it can be; None where there is none.

    They are there for s^4 + b s^2 + c, and with Rayleigh damping.
    """
    field = q.domain
    h = q.rep.to_list()[1] / field.convert(4)
    moved = q.compose(sympy.Poly([field.one, -h], q.gen, domain=field)).rep.to_list()
    p, linear, last = moved[2:]
    resolvent = sympy.Poly([field.one, 2 * p, p * p - 4 * last, -linear * linear], q.gen, domain=field)
    lines = [factor.rep.to_list() for factor, _ in resolvent.factor_list()[1] if factor.degree() == 1]
    candidates = [_quadratic(field, h, p, linear, last, -zeroth / first) for first, zeroth in lines]
    return min(candidates, key=lambda parts: (ORDER[sign(field, parts[1].g)], bool(parts[0].v)), default=None)


def _quadratic(field, h, p, linear, last, z) -> tuple[Surd, Surd]:
    """s^2 + a s + b of the root z of the resolvent: its root is that of z, or of p^2 - 4 last where z = 0."""
    half = field.one / field.convert(2)
    outside, g = square_root(field, z if z else p * p - 4 * last)
    root = Surd(field, field.zero, outside, g)
    if not z:
        return root.of(2 * h), root.of(h * h + p * half) + root * root.of(half)
    return root.of(2 * h) + root, root.of(h * h + (p + z) * half) + root * root.of(h - linear * half / z)


class Quadratic:
    """s^2 + a s + b over K(sqrt(g)), and values of polynomials at its zeros x = middle + y, y^2 = -square = a^2/4 - b: linear in y."""

    def __init__(self, a: Surd, b: Surd):
        one = a.field.one
        self.b, self.middle = b, a * a.of(-one / (one + one))
        self.square = b - self.middle * self.middle
        self._powers = [(a.of(one), a.of(a.field.zero), a.of(a.field.zero))]
        self._values: dict[sympy.Poly, tuple[Surd, Surd, Surd]] = {}

    @cached_property
    def conjugate(self) -> Quadratic:
        """The conjugate with -sqrt(g) for sqrt(g); both share the known values."""
        other = Quadratic(-(self.middle + self.middle).conjugate, self.b.conjugate)
        other.value = lambda c: tuple(part.conjugate for part in self.value(c))
        return other

    def value(self, c: sympy.Poly) -> tuple[Surd, Surd, Surd]:
        """e, o and o square with c(x) = e + o y, by the powers of x, each computed once; c is linear in them."""
        if c not in self._values:
            field, factors = self.middle.field, coefficients(c, max(1, len(c.rep.to_list())))
            while len(self._powers) < len(factors):
                even, odd, turned = self._powers[-1]
                following = even + odd * self.middle
                self._powers.append((even * self.middle - turned, following, following * self.square))
            self._values[c] = tuple(
                Surd(field, *(combination(field, factors, [getattr(part, name) for part in parts]) for name in "uv"), self.middle.g)
                for parts in zip(*self._powers[: len(factors)])
            )
        return self._values[c]


def combination(field: Domain, ones: Sequence, others: Sequence):
    """The sum of the products of elements; fractions are brought over one denominator and cancelled once, at the end."""
    pairs = [(one, other) for one, other in zip(ones, others, strict=True) if one and other]
    if not field.is_FractionField:
        return sum((one * other for one, other in pairs), field.zero)
    ring = field.get_ring()
    first, second = (reduce(ring.lcm, {pair[which].denom for pair in pairs}, ring.one) for which in (0, 1))
    above = ((one.numer * first.exquo(one.denom)) * (other.numer * second.exquo(other.denom)) for one, other in pairs)
    return field.field.new(sum(above, ring.zero), first * second)


# The ring K[s] as the engine takes it.

#: (q, k): an irreducible monic factor and its multiplicity.
Factors = list[tuple[sympy.Poly, int]]

#: Characters of a polynomial in a representation.
LONGEST_TEXT = 60


@dataclass(frozen=True)
class SymbolicZero:
    """A zero of A(s).

    Attributes:
        value: in 1/s, in radicals, or with 30 digits where there are no symbols; of a complex pair the one above the real axis
            stands for both.
        multiplicity, partial_multiplicities: as in ``FiniteZero``.
        is_pair: True where it stands for two.
    """

    value: sympy.Expr
    multiplicity: int
    partial_multiplicities: tuple[int, ...]
    is_pair: bool = False

    @property
    def count(self) -> int:
        """Number of roots of det A(s) for this entry."""
        return self.multiplicity * (2 if self.is_pair else 1)


def factors_of(p: sympy.Poly) -> Factors:
    """The monic irreducible factors of p over its field with their powers, those of low degree first.

    Over rational functions of symbols, p times its denominators is factored as a polynomial in s and the symbols (Gauss).
    """
    order = min((power for (power,), _ in p.terms()), default=0)
    rest = sympy.Poly(p.rep.to_list()[: p.degree() - order + 1], p.gen, domain=p.domain) if order else p  # factoring is slow
    factors = [(sympy.Poly([p.domain.one, p.domain.zero], p.gen, domain=p.domain), order)] if order else []
    if p.domain.is_FractionField:
        rest = rest.clear_denoms(convert=True)[1]
    for factor, power in rest.factor_list()[1]:
        if factor.degree() > 0:  # equal coefficients for equal polynomials
            monic = [in_one_form(p.domain, c) for c in factor.set_domain(p.domain).monic().rep.to_list()]
            factors.append((sympy.Poly(monic, p.gen, domain=p.domain), power))
    return sorted(factors, key=lambda pair: (pair[0].degree(), len(pair[0].terms()), pair[1], str(pair[0])))


def inverse_modulo(unit: sympy.Poly, modulus: sympy.Poly) -> sympy.Poly:
    """1 / unit modulo a polynomial: the first column of the inverse of the matrix of v -> unit v.

    By elimination without fractions: those of Euclid's algorithm grow. Modulo s^k it is a power series.
    """
    unit, field, degree, ring = unit.rem(modulus), unit.domain, modulus.degree(), integers(unit.domain)
    if len(modulus.terms()) == 1:
        first, *others = coefficients(unit, degree)
        series = [field.one / first]
        for j in range(1, degree):
            known = sum((c * series[j - i] for i, c in enumerate(others[:j], 1)), field.zero)
            series.append(-known * series[0])
        return sympy.Poly(series[::-1], unit.gen, domain=field)
    columns = [coefficients((unit * sympy.Poly(unit.gen**i, unit.gen, domain=field)).rem(modulus), degree) for i in range(degree)]
    scale = common_denominator(field, itertools.chain(*columns))
    rows = [[ring.convert_from(column[i] * scale, field) for column in columns] for i in range(degree)]
    one = DomainMatrix([[ring.one if i == 0 else ring.zero] for i in range(degree)], (degree, 1), ring)
    numerators, denominator = DomainMatrix(rows, (degree, degree), ring).solve_den(one, method="rref")
    factor = scale / field.convert_from(denominator, ring)
    first_column = [field.convert_from(row[0], ring) * factor for row in numerators.to_list()]
    return sympy.Poly(first_column[::-1], unit.gen, domain=field)


class SymbolicRing:
    """K[s] over a field of sympy: Polys for polynomials and matrices of expressions."""

    coefficients, inverse, factors = staticmethod(coefficients), staticmethod(inverse_modulo), staticmethod(factors_of)
    chain = JordanChain

    def __init__(self, domain: Domain, variable: sympy.Symbol):
        self.domain, self.variable = domain, variable
        self.zero, self.one = domain.zero, domain.one
        self._roots: dict[sympy.Poly, tuple[Root, ...] | None] = {}

    @classmethod
    def of(cls, p: sympy.Poly) -> SymbolicRing:
        return cls(p.domain, p.gen)

    def polynomial(self, coefficients: Sequence) -> sympy.Poly:
        return sympy.Poly(list(coefficients)[::-1] or [self.zero], self.variable, domain=self.domain)

    def weight(self, p: sympy.Poly) -> int:
        """Number of terms in s and in the symbols."""
        if not self.domain.is_FractionField:
            return len(p.terms())
        return sum(len(self.domain.numer(c)) + len(self.domain.denom(c)) for c in p.rep.to_list())

    def exported(self, p: sympy.Poly) -> sympy.Poly:
        return p

    def text(self, p: sympy.Poly) -> str:
        text = str(p.as_expr())
        return text if len(text) <= LONGEST_TEXT else f"of degree {p.degree()} in {p.gen}"

    def matrix(self, rows: Sequence[Sequence]) -> sympy.ImmutableMatrix:
        entries = [expression_of(self.domain, entry) for row in rows for entry in row]
        return sympy.ImmutableMatrix(len(rows), len(rows[0]) if rows else 0, entries)

    def joined(self, matrices: Sequence[sympy.MatrixBase], axis: int) -> sympy.ImmutableMatrix:
        return (sympy.Matrix.vstack, sympy.Matrix.hstack)[axis](*matrices).as_immutable()

    def diagonal(self, matrices: Sequence[sympy.MatrixBase]) -> sympy.ImmutableMatrix:
        return sympy.diag(*matrices).as_immutable()

    def finite_zeros(self, divisors) -> tuple[SymbolicZero, ...]:
        """Finite zeros: with symbols those of factors of degree 1, 2 and s^4 + b s^2 + c (``roots``); for numbers all."""
        return tuple(
            SymbolicZero(root.value, multiplicity, exponents, root.is_pair)
            for p, multiplicity, exponents in divisors
            for root in self.roots(p) or ()
        )

    def roots(self, p: sympy.Poly) -> tuple[Root, ...] | None:
        """The zeros of an irreducible p, computed once; None for symbols without a closed form."""
        if p not in self._roots:
            self._roots[p] = roots(p)
        return self._roots[p]


# Jordan blocks in radicals, the assumptions, and the projector onto consistent values.


class SymbolicMatrix(ExactMatrix, Protocol):
    """A(s) with its field, and A_0 ... A_q as rows of elements of it."""

    field: Domain
    elements: list[Any]


class SymbolicJordanPairs(ExactJordanPairs):
    """Finite and infinite Jordan pair of a regular A(s) for generic positive symbols, computed on demand.

    >>> m, k = sympy.symbols("m k", positive=True)
    >>> from mbconstrained import SymbolicPolynomialMatrix
    >>> pairs = SymbolicPolynomialMatrix([[[k]], [[0]], [[m]]]).jordan_pairs()
    >>> pairs.finite.J, pairs.finite.C, pairs.finite.B
    (Matrix([
    [               0, sqrt(k)/sqrt(m)],
    [-sqrt(k)/sqrt(m),                0]]), Matrix([[1, 0]]), Matrix([
    [                  0],
    [1/(sqrt(k)*sqrt(m))]]))
    """

    matrix: SymbolicMatrix
    ring: SymbolicRing

    @cached_property
    def finite(self) -> ExactPair:
        """(C, J, B) with J in Jordan form where the zeros have a closed form (degrees 1, 2, and s^4 + b s^2 + c), or are numbers.

        Complex pairs have real blocks (Moysis et al., Eq. 38). Where it depends on the symbols whether two zeros are real, they
        have one column each, and their square root may be one of a negative number (Eq. 95). Elsewhere blocks have entries in the
        field: a block companion matrix where all zeros belong to one factor of multiplicity one, hypercompanion blocks otherwise.
        """
        if self._is_one_companion:
            return ExactPair(self.ring, self.matrix.size, [_companion_block(self.matrix, self.factors[0][0])])
        blocks: list = []
        for place, (p, _) in enumerate(self.factors):
            terms, zeros = self.root_polynomials(place), self.ring.roots(p)
            if zeros is None:
                blocks += [HypercompanionBlock(term) for term in terms]
            else:
                blocks += [_jordan_block(JordanChain(term), zero) for zero in zeros for term in terms]
        return ExactPair(self.ring, self.matrix.size, blocks)

    @cached_property
    def jump_projector(self) -> sympy.ImmutableMatrix:
        """P = col(C, CJ, ..., CJ^(q-1)) [J^(q-1)B ... B] M1, shape (q r, q r) (Moysis et al., Eq. 98).

        The values of a free motion at 0+ are P times those at 0-. For every pair the first two factors have the blocks
        H_(c-a-q), and M1 has A_(q-c+b) at (c, b), c >= b.
        """
        A, shape = self.matrix, (self.matrix.size, self.matrix.size)
        q, r = A.degree, A.size
        matrices = [DomainMatrix(rows, shape, A.field) for rows in A.elements]
        total = sympy.zeros(q * r, q * r)
        for a, b in itertools.product(range(q), repeat=2):
            block = DomainMatrix.zeros(shape, A.field).to_dense()
            for c in range(b, q):
                block += DomainMatrix(self.laurent.elements(c - a - q), shape, A.field) * matrices[q - c + b]
            total[a * r : (a + 1) * r, b * r : (b + 1) * r] = self.ring.matrix(block.to_list())
        return total.as_immutable()

    @cached_property
    def assumptions(self) -> tuple[sympy.Expr, ...]:
        """Expressions in the symbols that must not vanish for both pairs: those of the structure, and every pivot."""
        terms = () if self._is_one_companion else self.terms
        pivots = (_resultant(term.divisor, term.pivot) for term in terms)
        return must_not_vanish(self.matrix.field, itertools.chain(self._divided_by(), pivots))

    def structure_assumptions(self) -> tuple[sympy.Expr, ...]:
        """The degree of det A, distinct zeros, and the pivots of multiple and infinite ones; zeros without closed form left out."""
        return must_not_vanish(self.matrix.field, self._divided_by())

    def _divided_by(self) -> Iterable:
        A, field = self.matrix, self.matrix.field
        yield from (field.convert(field.denom(c), field.get_ring()) for matrix in A.elements for row in matrix for c in row)
        yield A.determinant.rep.LC()
        for place, (p, multiplicity) in enumerate(self.factors):
            yield from (_resultant(p, other) for other, _ in self.factors[:place])
            if p.degree() > 1 and self.ring.roots(p) is not None:
                yield _resultant(p, p.diff())
            if multiplicity > 1:
                yield from (_resultant(p, term.pivot) for term in self.root_polynomials(place))
        yield from (term.pivot.rep.LC() for term in self.infinity)

    @property
    def _is_one_companion(self) -> bool:
        """True where A_q is invertible and det A is irreducible, with zeros that have no closed form."""
        if len(self.factors) != 1:
            return False
        A, (p, multiplicity) = self.matrix, self.factors[0]
        return multiplicity == 1 and p.degree() == A.size * A.degree and self.ring.roots(p) is None


@dataclass(frozen=True, repr=False, eq=False)
class Block:
    """The part of the finite pair that belongs to one elementary divisor p^k and one of its zeros.

    Attributes:
        kind: "jordan"; "real jordan", of a complex pair a +- i b, with [[a, b], [-b, a]] on the diagonal (Moysis et al., Eq. 38);
            "companion", the block companion matrix of all of A(s).
        polynomial, length: p and k.
        zero: in radicals, or with 30 digits where there are no symbols, of a pair the one above the real axis; None of a
            companion matrix.
        C, J, B: its columns, square and rows.
    """

    kind: str
    polynomial: sympy.Poly
    length: int
    zero: sympy.Expr | None
    C: sympy.ImmutableMatrix
    J: sympy.ImmutableMatrix
    B: sympy.ImmutableMatrix

    def __repr__(self) -> str:
        return f"Block({self.kind}, length={self.length}, degree {self.polynomial.degree()})"


def _jordan_block(chain: JordanChain, root: Root) -> Block:
    """The Jordan block of a chain at a zero, real for a complex pair."""
    right = [[root.at(entry) for entry in vector] for vector in chain.right]
    if root.is_pair:
        columns = [[parts[which] for parts in vector] for vector in right for which in (0, 1)]
        rows = [[root.at(sign * entry)[which] for entry in vector] for vector in chain.left for which, sign in ((0, 2), (1, -2))]
        diagonal = sympy.Matrix([[root.real, root.imaginary], [-root.imaginary, root.real]])
    else:
        columns = [[real for real, _ in vector] for vector in right]
        rows = [[root.at(entry)[0] for entry in vector] for vector in chain.left]
        diagonal = sympy.Matrix([[root.real]])
    J = sympy.diag(*[diagonal] * chain.length) + _shift(len(columns), diagonal.rows)
    kind = "real jordan" if root.is_pair else "jordan"
    C, B = sympy.Matrix(columns).T, sympy.Matrix(rows)
    return Block(kind, chain.polynomial, chain.length, root.value, *(matrix.as_immutable() for matrix in (C, J, B)))


def _companion_block(A: SymbolicMatrix, p: sympy.Poly) -> Block:
    """C = [I 0 ... 0], J = [0 I; -A_q^-1 A_0 ... -A_q^-1 A_(q-1)] and B = [0; A_q^-1], where A_q is invertible and det A ~ p.

    C (s I - J)^-1 B = A(s)^-1. No entry is longer than A_q^-1 makes it, while the chains of such a p are long.
    """
    q, r, shape = A.degree, A.size, (A.size, A.size)
    *lower, leading = (DomainMatrix(rows, shape, A.field) for rows in A.elements)
    inverse = leading.inv()
    J = _shift(q * r, r)
    J[(q - 1) * r :, :] = sympy.Matrix.hstack(*(A.ring.matrix((-(inverse * matrix)).to_list()) for matrix in lower))
    C, B = sympy.eye(r, q * r), sympy.Matrix.vstack(sympy.zeros((q - 1) * r, r), A.ring.matrix(inverse.to_list()))
    return Block("companion", p, 1, None, *(matrix.as_immutable() for matrix in (C, J, B)))


def _shift(size: int, by: int) -> sympy.Matrix:
    """Ones next to the diagonal blocks."""
    return sympy.Matrix(size, size, lambda i, j: int(j == i + by))


def must_not_vanish(field: Domain, values: Iterable) -> tuple[sympy.Expr, ...]:
    """The irreducible factors of all numerators and denominators that vanish for some positive symbols, in order of length."""
    if not field.is_FractionField:
        return ()
    ring, is_definite = field.get_ring(), {}
    for value in values:
        for part in (field.numer(value), field.denom(value)):
            for factor, _ in part.factor_list()[1]:
                if factor not in is_definite:
                    is_definite[factor] = sign(field, field.convert(factor, ring)) in (1, -1)
    doubtful = [ring.to_sympy(factor) for factor, definite_sign in is_definite.items() if not definite_sign]
    return tuple(sorted(doubtful, key=lambda e: (sympy.count_ops(e), str(e))))


def _resultant(p: sympy.Poly, other: sympy.Poly):
    """Resultant of two Polys over the field, an element of it: zero where they have a common zero."""
    return p.domain.from_sympy(p.resultant(other))
