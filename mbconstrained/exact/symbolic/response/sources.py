"""What drives the motion, as vectors in s: the values at 0- as X_in(s), and the terms of the force as F(s)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import sympy
from sympy.polys.domains import Domain

from ....errors import InputError
from ..algebra.matrix import SymbolicPolynomialMatrix, checked_matrix
from ..field.compact import element_of
from ..field.fields import field_of
from ..field.names import check_start_names, start_name
from .transform import Term, terms_of, transform_of


@dataclass(frozen=True)
class Source:
    """amplitude numerator(s) / denominator(s)^power, from a time on.

    Attributes:
        start: the time.
        amplitude: any expression without s and t.
        numerator: r expressions, polynomials in s with coefficients rational in symbols.
        denominator, power: as of ``Transform``.
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

    Raises:
        InputError: a symbol of A is called like one of them.

    >>> initial_symbols(SymbolicPolynomialMatrix([[[1]], [[0]], [[1]]], coordinates=["u"]))
    Matrix([
    [u_0],
    [u_1]])
    """
    check_start_names(checked_matrix(A).coordinates, A.degree, A.symbols)
    names = [[start_name(name, i) for name in A.coordinates] for i in range(A.degree)]
    return sympy.Matrix(A.degree, A.size, lambda i, j: sympy.Symbol(names[i][j], real=True)).as_immutable()


def initial_sources(A: SymbolicPolynomialMatrix, initial: sympy.Matrix) -> list[Source]:
    """X_in(s) of the values at 0- as rows of a matrix (q, r) (Moysis et al., Eq. 47), one source for each value."""
    s, found = A.variable, []
    for j in range(A.degree):
        for column in range(A.size):
            above = [matrix[:, column] * s ** (i - 1 - j) for i, matrix in enumerate(A.coefficients) if i > j]
            vector = sum(above[1:], above[0])
            if initial[j, column] != 0 and any(vector):
                found.append(Source(sympy.S.Zero, initial[j, column], tuple(vector)))
    return found


def force_sources(A: SymbolicPolynomialMatrix, force: Iterable[sympy.Expr], time: sympy.Symbol) -> list[Source]:
    """F(s) of a force, r expressions in time, one source for each amplitude of each term.

    Raises:
        InputError: a function of another kind, or a power of a constant, the rate of which is its logarithm.
    """
    found = []
    for row, expression in enumerate(force):
        _check_rates(expression, time)
        for given in terms_of(expression, time):
            for term in given.from_its_start():
                found += _sources_of_term(A, row, term)
    return found


def _check_rates(expression: sympy.Expr, time: sympy.Symbol) -> None:
    for power in expression.atoms(sympy.Pow):
        if power.exp.has(time) and not power.base.has(time):
            raise InputError(
                f"force: found {power}; expected exp(a*{time}) with a rational in the symbols: write a symbol a for "
                f"log({power.base}) and put in its value afterwards"
            )


def _sources_of_term(A, row: int, term: Term) -> list[Source]:
    transform = transform_of(term, A.variable)
    unit = [sympy.S.One if i == row else sympy.S.Zero for i in range(A.size)]
    return [
        Source(
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


def field_with(A: SymbolicPolynomialMatrix, sources: Iterable[Source]) -> Domain:
    """The field of A with the symbols and numbers of the rates and frequencies of the sources."""
    return field_of(entries_with(A, sources))


def entries_with(A: SymbolicPolynomialMatrix, sources: Iterable[Source]) -> list[sympy.Expr]:
    """The entries of A, and the coefficients that the rates and frequencies of the sources make."""
    polynomials = {p for source in sources for p in (source.denominator, *source.numerator)}
    coefficients = [c for p in polynomials for c in sympy.Poly(p, A.variable).all_coeffs()]
    return [*(entry for matrix in A.coefficients for entry in matrix), *coefficients]


def amplitudes(field: Domain, expression: sympy.Expr) -> dict[sympy.Expr, object]:
    """An amplitude as a sum of generators, what is not rational in the field's symbols, with factors in the field."""
    found: dict[sympy.Expr, object] = {}
    for part in sympy.Add.make_args(sympy.expand(expression)):
        outside, inside = [], field.one
        for factor in sympy.Mul.make_args(part):
            element = element_of(field, factor)
            if element is None:
                outside.append(factor)
            else:
                inside *= element
        generator = sympy.Mul(*outside)
        found[generator] = found.get(generator, field.zero) + inside
    return {generator: factor for generator, factor in found.items() if factor}
