"""The constrained form [V^T (M s^2 + C s + K); A s^level] x = [V^T f; b] with symbols, as ``mechanics`` has it in numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import sympy
from sympy.polys.matrices import DomainMatrix

from ...errors import ContradictoryConstraints
from ..symbolic import SymbolicPolynomialMatrix
from .text_printer import TextPrinter


@dataclass(frozen=True)
class Row:
    """A constraint row: the sum of coefficient times coordinate, in the derivative of this order, equals the value."""

    name: str
    coefficients: np.ndarray
    order: int
    value: sympy.Expr


@dataclass(frozen=True)
class ExactForm:
    """The constrained equations, exactly.

    Attributes:
        polynomial_matrix: [V^T (M s^2 + C s + K); A s^level].
        null_space: V, an array (n, n - k) of expressions.
        rows: the independent rows, those of position level first.
    """

    polynomial_matrix: SymbolicPolynomialMatrix
    null_space: np.ndarray
    rows: tuple[Row, ...]

    def force(self, applied: Sequence[sympy.Expr]) -> list[sympy.Expr]:
        """[V^T f; b]."""
        return [*(self.null_space.T @ np.array(applied, dtype=object)), *(row.value for row in self.rows)]


def exact_form(matrices: Sequence[np.ndarray], rows: Sequence[Row], names: Sequence[str]) -> ExactForm:
    """The constrained form of M x'' + C x' + K x = f.

    Args:
        matrices: K, C, M, arrays (n, n) of expressions.
        rows: any number, dependent ones too.
        names: of the n coordinates.

    Raises:
        ContradictoryConstraints: dependent rows that ask for different values.

    >>> k, m = sympy.symbols("k m", positive=True)
    >>> K, C, M = np.diag([k, 0]), np.zeros((2, 2), dtype=int), np.diag([m, m])
    >>> form = exact_form([K, C, M], [Row("link", np.array([1, -1]), 0, sympy.S.Zero)], ["a", "b"])
    >>> form.polynomial_matrix.determinant.as_expr()
    -k - 2*m*s**2
    """
    kept = _independent(sorted(rows, key=lambda row: row.order))
    size = len(names)
    A = np.array([row.coefficients for row in kept], dtype=object).reshape(len(kept), size)
    V = _null_space(A, size)
    coefficients = []
    for order, matrix in enumerate(matrices):
        held = [row.coefficients if row.order == order else np.zeros(size, dtype=int) for row in kept]
        coefficients.append([*(V.T @ matrix).tolist(), *(list(row) for row in held)])
    return ExactForm(SymbolicPolynomialMatrix(coefficients, names), V, tuple(kept))


def _independent(rows: Sequence[Row]) -> list[Row]:
    """The rows that are no combination of those before them."""
    kept: list[Row] = []
    for row in rows:
        combination = _combination([each.coefficients for each in kept], row.coefficients)
        if combination is None:
            kept.append(row)
            continue
        implied = sum((c * each.value for c, each in zip(combination, kept) if each.order == row.order), sympy.S.Zero)
        if sympy.simplify(row.value - implied) != 0:
            tell = TextPrinter().doprint
            raise ContradictoryConstraints(
                f'constraint "{row.name}" asks for {tell(row.value)}, but it follows from the rows before it with the value '
                f"{tell(sympy.simplify(implied))}; make the values agree or take one of the rows out"
            )
    return kept


def _combination(rows, wanted) -> list[sympy.Expr] | None:
    """The factors with which the independent rows make up another one, or None."""
    if not rows:
        return None if any(entry != 0 for entry in wanted) else []
    null = _null_space(np.array([*rows, wanted], dtype=object).T, len(rows) + 1)
    if null.shape[1] == 0:
        return None
    return [-entry / null[-1, 0] for entry in null[:-1, 0]]


def _null_space(A: np.ndarray, size: int) -> np.ndarray:
    """A basis of null(A), as columns."""
    if not A.size:
        return np.array(sympy.eye(size).tolist(), dtype=object)
    matrix = DomainMatrix.from_Matrix(sympy.Matrix(A.tolist())).to_field()
    basis = matrix.nullspace(divide_last=True).to_Matrix().tolist()
    return np.array(basis, dtype=object).reshape(len(basis), size).T


def followed(given: np.ndarray, known: np.ndarray, rows: Sequence[Row], order: int) -> np.ndarray:
    """Values of one order at 0-, those that are not known chosen so that the rows hold.

    Args:
        given: values (n,), zero where not known.
        known: which of them were given, (n,).
        rows: of the constrained form.
        order: of the derivative that these are values of.
    """
    chosen = [row for row in rows if row.order <= order]
    rest = [sympy.expand((row.value if row.order == order else 0) - row.coefficients @ given) for row in chosen]
    if not any(rest):
        return given
    free = [i for i in range(len(given)) if not known[i] and any(row.coefficients[i] != 0 for row in chosen)]
    A = sympy.Matrix([[row.coefficients[i] for i in free] for row in chosen])
    solution, _ = A.gauss_jordan_solve(sympy.Matrix(rest))
    found = given.copy()
    for i, value in zip(free, solution):
        found[i] = sympy.factor(value)
    return found
