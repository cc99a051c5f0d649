"""A(s) = A_0 + A_1 s + ... + A_q s^q with entries that are rational functions of symbols: its ring K[s], A(s) itself, its Jordan pairs."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import prod
from typing import NoReturn

import sympy
from sympy.polys.domains.domain import Domain
from sympy.polys.matrices import DomainMatrix

from ...ground.by_name import Public
from ...ground.checks import names_of
from ...ground.errors import InputError, SingularPolynomialMatrix
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...polynomial.structure import FiniteZero, singular_sentence
from ..engine import ExactJordanPairs, ExactMatrix, ExactPair, ExactStructure, HypercompanionBlock, JordanChain, RootPolynomials
from .fields import (
    VARIABLE,
    as_positive,
    coefficients,
    common_denominator,
    element,
    exact_expression,
    exact_rows,
    expression_of,
    field_of,
    in_one_form,
    integers,
    sign,
    symbols_of,
)
from .radicals import Root, roots

#: The variable of every A(s).
S = sympy.Symbol(VARIABLE)

# The ring K[s] as the engine takes it.

#: (q, k): an irreducible monic factor and its multiplicity.
Factors = list[tuple[sympy.Poly, int]]

#: Characters of a polynomial in a representation.
LONGEST_TEXT = 60


@dataclass(frozen=True)
class SymbolicZero(FiniteZero):
    """A zero of A(s), its value in radicals, or with 30 digits where there are no symbols."""

    is_pair: bool = False  # True where the one above the real axis stands for both of a complex pair

    @property
    def count(self) -> int:
        """Number of roots of det A(s) for this entry."""
        return self.multiplicity * (2 if self.is_pair else 1)


def factors_of(p: sympy.Poly) -> Factors:
    """The monic irreducible factors of p over its field with their powers, those of low degree first (by Gauss those of a polynomial in s and the symbols)."""
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
    """1 / unit modulo a polynomial: the first column of the inverse of v -> unit v, by elimination without fractions, since those of Euclid's algorithm grow."""
    unit, field, degree, ring = unit.rem(modulus), unit.domain, modulus.degree(), integers(unit.domain)
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
            SymbolicZero(root.value, multiplicity, exponents, is_pair=root.is_pair)
            for p, multiplicity, exponents in divisors
            for root in self.roots(p) or ()
        )

    def roots(self, p: sympy.Poly) -> tuple[Root, ...] | None:
        """The zeros of an irreducible p, computed once; None for symbols without a closed form."""
        if p not in self._roots:
            self._roots[p] = roots(p)
        return self._roots[p]


# A(s).


@dataclass(frozen=True, eq=False)
class LocalSmithForm:
    """U_L(s) A(s) U_R(s) = diag((s - zero)^k_1, ..., (s - zero)^k_r), U_L and U_R regular at the zero (Moysis et al., Eq. 9)."""

    zero: sympy.Expr  # the zero of the local form
    exponents: tuple[int, ...]  # k_1 <= ... <= k_r
    matrix: sympy.ImmutableMatrix  # the form
    terms: tuple[RootPolynomials, ...]  # the root polynomials of every k_j > 0


class SymbolicPolynomialMatrix(ExactMatrix, Public):
    """A(s) = A_0 + A_1 s + ... + A_q s^q, square, over the field of rational functions of its symbols (Moysis et al., Eq. 4).

    The symbols are independent, generic and positive: masses, stiffnesses, dampings, lengths.

    Args:
        coefficients: A_0 ... A_q in ascending powers, each a square sympy matrix, array or nested lists; entries are
            expressions rational in symbols, ints, Fractions and floats, which stand for the shortest decimals that they
            are written as. pi and square roots of rationals are numbers too, up to two of the latter.
        coordinates, equations: names as in ``PolynomialMatrix``.

    Raises:
        InputError: an entry that is not of this kind (text, NaN, infinity, complex, sin(a), sqrt(k)), or not square.

    >>> m, k = sympy.symbols("m k", positive=True)
    >>> A = SymbolicPolynomialMatrix([[[k]], [[0]], [[m]]])
    >>> A.symbols, A.determinant.as_expr()
    ((k, m), k + m*s**2)
    """

    def __init__(self, coefficients: Iterable, coordinates: Sequence[str] | None = None, equations: Sequence[str] | None = None):
        if isinstance(coefficients, (str, sympy.MatrixBase)) or not isinstance(coefficients, Iterable):
            raise InputError(f"coefficients: found {coefficients!r}; expected a list of square matrices [A_0, A_1, ...]")
        given = [exact_rows(matrix, f"A_{power}") for power, matrix in enumerate(coefficients)]
        if not given:
            raise InputError("a polynomial matrix needs at least one coefficient, A_0; none was given")
        for power, rows in enumerate(given):
            if len(rows) != len(given[0]):
                raise InputError(f"A_{power} has {len(rows)} rows, but A_0 has {len(given[0])}; all must agree")
        entries = [entry for rows in given for row in rows for entry in row]
        if S.name in (symbol.name for symbol in symbols_of(entries)):
            raise InputError('the symbol "s" is the variable of A(s); give the entries A_0, A_1, ... and name parameters otherwise')
        self.coefficients = tuple(sympy.ImmutableMatrix(rows) for rows in given)
        self.size = len(given[0])
        self.symbols = symbols_of(entries)
        self.field: Domain = field_of(entries)
        self.coordinates = names_of(coordinates, self.size, "coordinates", "x")
        self.equations = names_of(equations, self.size, "equations", "equation ")
        self.elements = [
            [[element(self.field, e, f"A_{power} at ({i}, {j})") for j, e in enumerate(row)] for i, row in enumerate(rows)]
            for power, rows in enumerate(given)
        ]

    @classmethod
    def of(cls, A: PolynomialMatrix) -> SymbolicPolynomialMatrix:
        """Return the matrix in exact rational numbers, equal to its float64 entries.

        Raises:
            InputError: A is no ``PolynomialMatrix``.
        """
        if not isinstance(A, PolynomialMatrix):
            raise InputError(
                f"A: found an object of type {type(A).__name__}; expected a PolynomialMatrix (of a MechanicalSystem: its "
                "polynomial_matrix(); lists of matrices: SymbolicPolynomialMatrix([A_0, A_1, ...]))"
            )
        ratios = [
            [[entry if isinstance(entry, Fraction) else Fraction(float(entry)) for entry in row] for row in rows]
            for rows in A.exact_coefficients
        ]
        return cls(ratios, A.coordinates, A.equations)

    @property
    def variable(self) -> sympy.Symbol:
        """The symbol s."""
        return S

    @property
    def dual(self) -> SymbolicPolynomialMatrix:
        """s^q A(1/s), the coefficients in reverse (Moysis et al., Eq. 11): its zeros at 0 are those of A at infinity."""
        return SymbolicPolynomialMatrix(self.coefficients[::-1], self.coordinates, self.equations)

    def __call__(self, s) -> sympy.ImmutableMatrix:
        """A(s) at an expression or number s, by Horner's rule."""
        s = s if isinstance(s, sympy.Expr) else exact_expression(s, "s")
        value = sympy.zeros(self.size, self.size)
        for matrix in self.coefficients[::-1]:
            value = value * s + matrix
        return sympy.ImmutableMatrix(value)

    def __repr__(self) -> str:
        names = ", ".join(symbol.name for symbol in self.symbols)
        return f"SymbolicPolynomialMatrix(degree={self.degree}, size={self.size}, symbols=({names}))"

    @cached_property
    def ring(self) -> SymbolicRing:
        """K[s]."""
        return SymbolicRing(self.field, S)

    @cached_property
    def with_positive_symbols(self) -> SymbolicPolynomialMatrix:
        """Return the matrix with all symbols declared positive, which shortens roots; itself where they are."""
        names = as_positive(self.symbols)
        matrices = (matrix.xreplace(names) for matrix in self.coefficients)
        return SymbolicPolynomialMatrix(matrices, self.coordinates, self.equations) if names else self

    @cached_property
    def polynomials(self) -> list[list[sympy.Poly]]:
        """The entries of A(s), each a Poly in s over the field."""
        rows = range(self.size)
        return [[self.ring.polynomial([matrix[i][j] for matrix in self.elements]) for j in rows] for i in rows]

    @property
    def determinant(self) -> sympy.Poly:
        """det A(s), a Poly in s over the field.

        Raises:
            SingularPolynomialMatrix: it is zero for every s; names the dependent equations and free coordinates.
        """
        if self._inverse[1].is_zero:
            _raise_singular(self)
        return self._inverse[1]

    @property
    def adjugate(self) -> list[list[sympy.Poly]]:
        """adj A(s), Polys in s over the field: A(s)^-1 = adj A(s) / det A(s)."""
        return self._inverse[0]

    @cached_property
    def _inverse(self) -> tuple[list[list[sympy.Poly]], sympy.Poly]:
        return _adjugate_and_determinant(self.polynomials)

    def structure(self) -> ExactStructure:
        """Smith forms, elementary divisors and zeros, finite and infinite."""
        return self.jordan_pairs().structure

    def smith_form(self) -> sympy.ImmutableMatrix:
        """diag(f_1(s), ..., f_r(s)) over the complex numbers, monic, each divides the next (Moysis et al., Eq. 5)."""
        entries = []
        for f in self.structure().invariant_polynomials:
            terms = f.rep.to_dict().items()
            entries.append(sympy.Add(*(expression_of(f.domain, c) * f.gen**power for (power,), c in terms)))
        return sympy.diag(*entries).as_immutable()

    def smith_form_at_infinity(self) -> sympy.ImmutableMatrix:
        """diag(s^q_1, ..., s^q_r), q_1 >= ... >= q_r (Moysis et al., Eq. 10)."""
        return sympy.diag(*(S**order for order in self.structure().at_infinity)).as_immutable()

    def local_smith_form(self, zero) -> LocalSmithForm:
        """The local Smith form at a rational function of the symbols, or at one of ``structure().finite_zeros`` (Moysis et al., Eq. 9)."""
        zero, p = self._zero_of(zero)
        det, multiplicity = self.determinant, 0
        while det.rem(p).is_zero:
            det, multiplicity = det.quo(p), multiplicity + 1
        terms = self.root_polynomials(p, multiplicity)
        exponents = (0,) * (self.size - len(terms)) + tuple(term.length for term in terms)
        matrix = sympy.diag(*((S - zero) ** k for k in exponents)).as_immutable()
        return LocalSmithForm(zero, exponents, matrix, tuple(terms))

    def _zero_of(self, zero) -> tuple[sympy.Expr, sympy.Poly]:
        """The zero as an expression, and its irreducible polynomial over the field."""
        if isinstance(zero, sympy.Expr):
            for p, _ in self.jordan_pairs().factors:
                if any(zero in (root.value, root.real - sympy.I * root.imaginary) for root in self.ring.roots(p) or ()):
                    return zero, p
        zero = exact_expression(zero, "zero")
        if not zero.free_symbols <= set(self.symbols):
            raise InputError(f"zero: found {zero}; expected a rational function of the symbols of A(s) or one of its zeros")
        return zero, self.ring.polynomial([-element(self.field, zero, "zero"), self.field.one])

    def jordan_pairs(self) -> SymbolicJordanPairs:
        """The finite pair (C, J, B), the minimal infinite pair, and H_i."""
        return self._pairs

    @cached_property
    def _pairs(self) -> SymbolicJordanPairs:
        return SymbolicJordanPairs(self)

    @property
    def assumptions(self) -> tuple[sympy.Expr, ...]:
        """Expressions in the symbols that must not vanish for the structure to hold (the pairs have their own)."""
        return self.structure().assumptions


def checked_matrix(A) -> SymbolicPolynomialMatrix:
    """A ``SymbolicPolynomialMatrix``, or an InputError."""
    if not isinstance(A, SymbolicPolynomialMatrix):
        raise InputError(
            f"A: found an object of type {type(A).__name__}; expected a SymbolicPolynomialMatrix (of numbers: SymbolicPolynomialMatrix.of(A))"
        )
    return A


# adj A(s) and det A(s) without any division: in the ring of polynomials in s and the symbols.


def _adjugate_and_determinant(rows: list[list[sympy.Poly]]) -> tuple[list[list[sympy.Poly]], sympy.Poly]:
    """Adjugate and determinant of a square matrix of Polys in s over a field, as Polys over the field.

    Rows are multiplied by their denominators first; then the characteristic polynomial follows by Berkowitz's algorithm, and by Cayley
    and Hamilton +-adj M = M^(r-1) + c_1 M^(r-2) + ... + c_(r-1); sympy's adj_det fails where a c is zero.
    """
    field, variable, size = rows[0][0].domain, rows[0][0].gen, len(rows)
    scales = [common_denominator(field, (c for entry in row for c in entry.rep.to_list())) for row in rows]
    integral = integers(field)
    ring = integral[variable]

    def in_ring(p: sympy.Poly, scale):
        return ring.ring.from_dict({power: integral.convert(c * scale, field) for power, c in p.rep.to_dict().items()})

    def over_field(p, factor) -> sympy.Poly:
        terms = {power: field.convert(c, integral) * factor for power, c in p.terms()}
        return sympy.Poly.from_dict(terms, variable, domain=field)

    whole = [[in_ring(entry, scale) for entry in row] for row, scale in zip(rows, scales)]
    matrix = DomainMatrix(whole, (size, size), ring)
    identity = DomainMatrix.eye(size, ring).to_dense()
    _, *middle, last = matrix.charpoly()
    adjugate = identity
    for c in middle:
        adjugate = matrix * adjugate + identity * c
    adjugate, determinant = (-adjugate, last) if len(middle) % 2 else (adjugate, -last)
    total = field.one / prod(scales, start=field.one)
    entries = [[over_field(entry, total * scale) for entry, scale in zip(row, scales)] for row in adjugate.to_list()]
    return entries, over_field(determinant, total)


def _raise_singular(A: SymbolicPolynomialMatrix) -> NoReturn:
    """Raise an error with the dependent equations and the free coordinates, from the null spaces over the field."""
    matrix = A(A.variable)
    rows = DomainMatrix.from_list_sympy(A.size, A.size, matrix.tolist()).convert_to(field_of([*matrix, A.variable]))

    def involved(rows: DomainMatrix) -> tuple[int, ...]:
        null = rows.nullspace().to_Matrix()
        return tuple(j for j in range(null.cols) if any(entry != 0 for entry in null[:, j]))

    equations, coordinates = involved(rows.transpose()), involved(rows)
    text = singular_sentence([A.equations[i] for i in equations], [A.coordinates[i] for i in coordinates])
    raise SingularPolynomialMatrix(text, equations, coordinates)


# Jordan blocks in radicals, the assumptions, and the projector onto consistent values.


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

    matrix: SymbolicPolynomialMatrix
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
        pivots = (term.divisor.rep.resultant(term.pivot.rep) for term in terms)
        return must_not_vanish(self.matrix.field, itertools.chain(self._divided_by(), pivots))

    def structure_assumptions(self) -> tuple[sympy.Expr, ...]:
        """The degree of det A, distinct zeros, and the pivots of multiple and infinite ones; zeros without closed form left out."""
        return must_not_vanish(self.matrix.field, self._divided_by())

    def _divided_by(self) -> Iterable:
        A, field = self.matrix, self.matrix.field
        yield from (field.convert(field.denom(c), field.get_ring()) for matrix in A.elements for row in matrix for c in row)
        yield A.determinant.rep.LC()
        for place, (p, multiplicity) in enumerate(self.factors):
            yield from (p.rep.resultant(other.rep) for other, _ in self.factors[:place])
            if p.degree() > 1 and self.ring.roots(p) is not None:
                yield p.rep.resultant(p.diff().rep)
            if multiplicity > 1:
                yield from (p.rep.resultant(term.pivot.rep) for term in self.root_polynomials(place))
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
    """The part of the finite pair that belongs to one elementary divisor p^k and one of its zeros."""

    kind: str  # "jordan"; "real jordan", of a pair, [[a, b], [-b, a]] on the diagonal (Moysis et al., Eq. 38); "companion" of all A(s)
    polynomial: sympy.Poly  # p
    length: int  # k
    zero: sympy.Expr | None  # in radicals or with 30 digits, of a pair the one above the real axis; None of a companion matrix
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


def _companion_block(A: SymbolicPolynomialMatrix, p: sympy.Poly) -> Block:
    """C = [I 0 ... 0], J = [0 I; -A_q^-1 A_0 ... -A_q^-1 A_(q-1)], B = [0; A_q^-1], short where the chains of an irreducible det A are long."""
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
