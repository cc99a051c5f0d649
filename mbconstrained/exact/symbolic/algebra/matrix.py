"""A(s) = A_0 + A_1 s + ... + A_q s^q with entries that are rational functions of symbols."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING

import sympy
from sympy.polys.domains.domain import Domain

from ....checks import names_of
from ....errors import InputError
from ....polynomial.matrix import PolynomialMatrix
from ..field.fields import (
    element,
    exact_expression,
    exact_rows,
    expression_of,
    field_of,
    generators_of,
    polynomial_expression,
    symbols_of,
)
from ..field.names import VARIABLE, as_positive
from .cofactors import adjugate_and_determinant
from .singular import raise_singular

if TYPE_CHECKING:
    from .local_smith import LocalSmithForm
    from .pairs import SymbolicJordanPairs
    from .structure import SymbolicStructure

#: The variable of every A(s).
S = sympy.Symbol(VARIABLE)


class SymbolicPolynomialMatrix:
    """A(s) = A_0 + A_1 s + ... + A_q s^q, square, over the field of rational functions of its symbols (Moysis et al., Eq. 4).

    The symbols are independent, generic and positive: masses, stiffnesses, dampings, lengths.

    Args:
        coefficients: A_0 ... A_q in ascending powers, each a square sympy matrix, array or nested lists; entries are
            expressions rational in symbols, ints, Fractions and floats, which are taken as the shortest decimals that they
            are written as. pi and square roots of rationals are numbers too, up to two of the latter.
        coordinates, equations: names as of ``PolynomialMatrix``.

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
        self.symbols = symbols_of(entries)
        self.field: Domain = field_of(entries)
        self.coordinates = names_of(coordinates, self.size, "coordinates", "x")
        self.equations = names_of(equations, self.size, "equations", "equation ")
        self.elements = [_elements(self.field, rows, f"A_{power}") for power, rows in enumerate(given)]

    @classmethod
    def of(cls, A: PolynomialMatrix) -> SymbolicPolynomialMatrix:
        """The same matrix in exact rational numbers: its float64 entries are the rationals that they are.

        Raises:
            InputError: A is no ``PolynomialMatrix``.
        """
        if not isinstance(A, PolynomialMatrix):
            raise InputError(
                f"A: found an object of type {type(A).__name__}; expected a PolynomialMatrix (of a MechanicalSystem: its "
                "polynomial_matrix(); lists of matrices: SymbolicPolynomialMatrix([A_0, A_1, ...]))"
            )
        ratios = [[[_ratio(entry) for entry in row] for row in rows] for rows in A.exact_coefficients]
        return cls(ratios, A.coordinates, A.equations)

    @property
    def size(self) -> int:
        """The number of rows and columns r."""
        return self.coefficients[0].rows

    @property
    def degree(self) -> int:
        """The declared degree q (the number of coefficients less one)."""
        return len(self.coefficients) - 1

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
    def with_positive_symbols(self) -> SymbolicPolynomialMatrix:
        """The same, all symbols declared to be positive, which roots are written shorter with; itself where they are."""
        names = as_positive(self.symbols)
        matrices = (matrix.xreplace(names) for matrix in self.coefficients)
        return SymbolicPolynomialMatrix(matrices, self.coordinates, self.equations) if names else self

    @cached_property
    def polynomials(self) -> list[list[sympy.Poly]]:
        """The entries of A(s), each a Poly in s over the field."""
        rows = range(self.size)
        return [[self.polynomial([matrix[i][j] for matrix in self.elements]) for j in rows] for i in rows]

    def polynomial(self, coefficients: Sequence) -> sympy.Poly:
        """The Poly in s over the field with these elements of it as coefficients, lowest power first."""
        return sympy.Poly(list(coefficients)[::-1] or [self.field.zero], S, domain=self.field)

    def expression(self, value) -> sympy.Expr:
        """An element of the field as an expression in factors."""
        return expression_of(self.field, value)

    @property
    def determinant(self) -> sympy.Poly:
        """det A(s), a Poly in s over the field.

        Raises:
            SingularPolynomialMatrix: it is zero for every s; names the dependent equations and free coordinates.
        """
        if self._inverse[1].is_zero:
            raise_singular(self)
        return self._inverse[1]

    @property
    def adjugate(self) -> list[list[sympy.Poly]]:
        """adj A(s), Polys in s over the field: A(s)^-1 = adj A(s) / det A(s)."""
        return self._inverse[0]

    @cached_property
    def _inverse(self) -> tuple[list[list[sympy.Poly]], sympy.Poly]:
        return adjugate_and_determinant(self.polynomials)

    def numerators(self, b: Sequence) -> list[sympy.Poly]:
        """N(s) = adj A(s) b(s), so that A(s) N(s) = det A(s) b(s).

        Args:
            b: r expressions or Polys in s, with coefficients rational in symbols, those of A or others.

        Returns:
            r Polys in s over the field of all the symbols together.

        Raises:
            InputError: not r of them, or one is no polynomial in s.
        """
        if isinstance(b, str) or not isinstance(b, Iterable):
            raise InputError(f"b: found {b!r}; expected {self.size} expressions or Polys in s")
        b = list(b)
        if len(b) != self.size:
            raise InputError(f"b: {len(b)} entries given, expected {self.size}")
        entries = [exact_expression(entry.as_expr() if isinstance(entry, sympy.Poly) else entry, "b") for entry in b]
        known = [entry for matrix in self.coefficients for entry in matrix]
        extra = [generator for generator in generators_of(entries) if generator != S]
        field = self.field if set(extra) <= set(generators_of(known)) else field_of([*known, *extra])
        column = [_polynomial_in(field, entry, f"b[{i}]") for i, entry in enumerate(entries)]
        zero = sympy.Poly(0, S, domain=field)
        return [sum((p.set_domain(field) * c for p, c in zip(row, column) if not c.is_zero), zero) for row in self.adjugate]

    def structure(self) -> SymbolicStructure:
        """Smith forms, elementary divisors and zeros, finite and infinite."""
        return self.jordan_pairs().structure

    def smith_form(self) -> sympy.ImmutableMatrix:
        """diag(f_1(s), ..., f_r(s)) over the complex numbers, monic, each divides the next (Moysis et al., Eq. 5)."""
        return sympy.diag(*(polynomial_expression(f) for f in self.structure().invariant_polynomials)).as_immutable()

    def smith_form_at_infinity(self) -> sympy.ImmutableMatrix:
        """diag(s^q_1, ..., s^q_r), q_1 >= ... >= q_r (Moysis et al., Eq. 10)."""
        return sympy.diag(*(S**order for order in self.structure().at_infinity)).as_immutable()

    def local_smith_form(self, zero) -> LocalSmithForm:
        """The local Smith form at a rational function of the symbols, or at one of ``structure().finite_zeros`` (Moysis et al., Eq. 9)."""
        from .local_smith import local_smith_form

        return local_smith_form(self, zero)

    def jordan_pairs(self) -> SymbolicJordanPairs:
        """The finite pair (C, J, B), the minimal infinite pair, and H_i."""
        return self._pairs

    @cached_property
    def _pairs(self) -> SymbolicJordanPairs:
        from .pairs import SymbolicJordanPairs

        return SymbolicJordanPairs(self)

    @property
    def assumptions(self) -> tuple[sympy.Expr, ...]:
        """Expressions in the symbols that must not vanish for the structure to be what is said (those of the pairs: theirs)."""
        return self.structure().assumptions


def checked_matrix(A) -> SymbolicPolynomialMatrix:
    """A, which is a ``SymbolicPolynomialMatrix``, or an InputError."""
    if not isinstance(A, SymbolicPolynomialMatrix):
        raise InputError(f"A: found an object of type {type(A).__name__}; expected a SymbolicPolynomialMatrix (or its .of(A))")
    return A


def _elements(field: Domain, rows, what: str) -> list[list]:
    return [[element(field, entry, f"{what} at ({i}, {j})") for j, entry in enumerate(row)] for i, row in enumerate(rows)]


def _polynomial_in(field: Domain, expression: sympy.Expr, what: str) -> sympy.Poly:
    """An expression, polynomial in s, as a Poly over a field."""
    terms = dict(element(field[S], expression, what).terms())
    return sympy.Poly.from_dict(terms, S, domain=field)


def _ratio(number) -> Fraction:
    return number if isinstance(number, Fraction) else Fraction(float(number))
