"""Matrices of the form A(s) = A_q s^q - A_0 with symbols, solved by the formulas that Moysis et al. give for them (section 4.2).

F x^(q) = G x with F = A_q and G = A_0, each of them singular or not. A view for comparison, as ``response.apostol_kolodner`` is
one in numbers; ``solve_symbolically`` handles these matrices like all others.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from ....errors import InputError
from ..algebra.matrix import SymbolicPolynomialMatrix, checked_matrix
from ..field.names import TIME
from .corollaries import checked_start, closed_blocks, motion_of_blocks


@dataclass(frozen=True)
class SymbolicApostolKolodner:
    """The solution of A_q x^(q) = A_0 x from values at 0-.

    Attributes:
        finite_start: x_s(0), shape (n, 1), Eq. (75).
        infinite_start: x_f(0), shape (mu, 1), Eq. (76), corrected.
        regular: x(t) = C e^{J t} x_s(0) for t > 0, Eq. (65), shape (r, 1).
        impulses: matrices (r, 1), the k-th multiplies delta^(k): -C_inf J_inf^(k + 1) x_f(0), Eq. (42); without zeros at the end.
    """

    finite_start: sympy.ImmutableMatrix
    infinite_start: sympy.ImmutableMatrix
    regular: sympy.ImmutableMatrix
    impulses: tuple[sympy.ImmutableMatrix, ...]


def apostol_kolodner_symbolically(A: SymbolicPolynomialMatrix, initial, time: sympy.Symbol = TIME) -> SymbolicApostolKolodner:
    """The free motion of A(s) = A_q s^q - A_0 by Eqs. (73)-(76) of Moysis et al.

    In (76) the printed sign is wrong: with (74), the values enter as x_f(0) = -(B_inf A_0 ... J_inf^(q-1) B_inf A_0) X_0.
    (75) is right. The paper's A_0 = G is minus the coefficient of s^0 that a ``SymbolicPolynomialMatrix`` holds.

    Args:
        A: with every coefficient between the first and the last zero, degree q >= 1, size r, its zeros in closed form.
        initial: x^(i)(0-) as row i, shape (q, r), or "symbols".
        time: the symbol t.

    Raises:
        InputError: A(s) is not of this form; a factor of its determinant has no roots in closed form; the time is called like
            another symbol.
        SingularPolynomialMatrix: det A(s) = 0 for every s.

    >>> k, m = sympy.symbols("k m", positive=True)
    >>> x = apostol_kolodner_symbolically(SymbolicPolynomialMatrix([[[k]], [[0]], [[m]]]), [[1], [0]])
    >>> x.regular
    Matrix([[cos(sqrt(k)*t/sqrt(m))]])
    """
    q = checked_matrix(A).degree
    if q < 1 or any(not matrix.is_zero_matrix for matrix in A.coefficients[1:-1]):
        raise InputError("A: expected A_q s^q - A_0 with q >= 1 and nothing between (any other form: solve_symbolically)")
    X0, time = checked_start(A, initial, time)
    blocks, infinite = closed_blocks(A), A.jordan_pairs().infinite
    values, Aq, A0 = [X0[i, :].T for i in range(q)], A.coefficients[-1], -A.coefficients[0]
    starts = [_sum([block.J ** (q - 1 - i) * block.B * Aq * x for i, x in enumerate(values)], block.J.rows) for block in blocks]
    infinite_start = -_sum([infinite.J**i * infinite.B * A0 * x for i, x in enumerate(values)], infinite.J.rows)
    impulses = [(-infinite.C * infinite.J ** (k + 1) * infinite_start).applyfunc(sympy.factor) for k in range(infinite.J.rows)]
    while impulses and impulses[-1].is_zero_matrix:
        impulses.pop()
    return SymbolicApostolKolodner(
        finite_start=sympy.Matrix.vstack(sympy.zeros(0, 1), *starts).as_immutable(),
        infinite_start=infinite_start.as_immutable(),
        regular=motion_of_blocks(A, blocks, starts, time),
        impulses=tuple(impulse.as_immutable() for impulse in impulses),
    )


def _sum(parts, size) -> sympy.Matrix:
    return sum(parts, sympy.zeros(size, 1))
