"""Sources of the motion as vectors in s: the values at 0- as X_in(s), and the terms of the force as F(s)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import sympy

from ....ground.errors import InputError
from ..field.fields import check_start_names
from ..symbolic_matrix import SymbolicPolynomialMatrix, checked_matrix
from .transform import TimeTerm, terms_of, transform_of


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
