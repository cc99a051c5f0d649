"""A(s) = A_0 + A_1 s + ... + A_q s^q with entries that are rational functions of symbols."""

from __future__ import annotations

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
from ...polynomial.structure import singular_sentence
from ..engine import ExactMatrix, ExactStructure, RootPolynomials
from .fields import (
    VARIABLE,
    as_positive,
    common_denominator,
    element,
    exact_expression,
    exact_rows,
    expression_of,
    field_of,
    integers,
    symbols_of,
)
from .symbolic_pairs import SymbolicJordanPairs, SymbolicRing

#: The variable of every A(s).
S = sympy.Symbol(VARIABLE)


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
