"""Matrices of the form A(s) = A_q s^q - A_0, solved by the formulas that Moysis et al. give for them (section 4.2).

F x^(q) = G x with F = A_q and G = A_0, each of them singular or not; numbers and symbols. A view for comparison: ``solve`` and
``solve_symbolically`` handle these matrices like all others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import sympy

from mbconstrained.exact.symbolic.fields import TIME
from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix, checked_matrix
from mbconstrained.ground.checks import real_array
from mbconstrained.ground.errors import InputError
from mbconstrained.polynomial.polynomial_matrix import PolynomialMatrix
from mbconstrained.response.problem import checked_matrix as checked_numeric_matrix
from mbconstrained.signals.bohl import BohlFunction
from tests.oracles.papers.corollaries import checked_start, closed_blocks, motion_of_blocks


@dataclass(frozen=True, eq=False)
class ApostolKolodner:
    """The solution of A_q x^(q) = A_0 x from values at 0-, arrays or matrices of expressions.

    Attributes:
        finite_start: x_s(0), shape (n,) or (n, 1), Eq. (75).
        infinite_start: x_f(0), shape (mu,) or (mu, 1), Eq. (76), corrected.
        function: x(t) = C e^{J t} x_s(0) for t > 0, Eq. (65): a ``BohlFunction``, or expressions in the time, shape (r, 1).
        impulses: shapes (r,) or (r, 1), the k-th multiplies delta^(k): -C_inf J_inf^(k + 1) x_f(0), Eq. (42).
    """

    finite_start: np.ndarray | sympy.ImmutableMatrix
    infinite_start: np.ndarray | sympy.ImmutableMatrix
    function: BohlFunction | sympy.ImmutableMatrix
    impulses: tuple


def apostol_kolodner(A: PolynomialMatrix | SymbolicPolynomialMatrix, initial, time: sympy.Symbol = TIME) -> ApostolKolodner:
    """The free motion of A(s) = A_q s^q - A_0 by Eqs. (73)-(76) of Moysis et al.

    In (76) the printed sign is wrong: with (74), the values enter as x_f(0) = -(B_inf A_0 ... J_inf^(q-1) B_inf A_0) X_0.
    (75) is right. The paper's A_0 = G is minus the coefficient of s^0 that a polynomial matrix holds.

    >>> x = apostol_kolodner(PolynomialMatrix([[[4.0]], [[0.0]], [[1.0]]]), [[1.0], [0.0]])  # x'' = -4 x
    >>> bool(np.isclose(x.function(0.5)[0], np.cos(1.0)))
    True
    >>> k, m = sympy.symbols("k m", positive=True)
    >>> apostol_kolodner(SymbolicPolynomialMatrix([[[k]], [[0]], [[m]]]), [[1], [0]]).function
    Matrix([[cos(sqrt(k)*t/sqrt(m))]])
    """
    if isinstance(A, SymbolicPolynomialMatrix):
        _check_form(checked_matrix(A).degree, [not matrix.is_zero_matrix for matrix in A.coefficients])
        return _in_symbols(A, initial, time)
    q, r = checked_numeric_matrix(A).degree, A.size
    _check_form(q, [bool(matrix.any()) for matrix in A.coefficients])
    X = real_array(initial, "initial", shape=(q, r))
    pairs = A.jordan_pairs()
    finite, infinite, Aq, A0, power = pairs.finite, pairs.infinite, A.coefficients[-1], -A.coefficients[0], np.linalg.matrix_power
    finite_start = sum((power(finite.J, q - 1 - i) @ (finite.B @ (Aq @ X[i])) for i in range(q)), np.zeros(len(finite.J)))
    infinite_start = -sum((power(infinite.J, i) @ (infinite.B @ (A0 @ X[i])) for i in range(q)), np.zeros(len(infinite.J)))
    highest = pairs.structure.highest_impulse
    impulses = tuple(-infinite.C @ power(infinite.J, k + 1) @ infinite_start for k in range(highest))
    return ApostolKolodner(finite_start, infinite_start, BohlFunction(finite.C, finite.blocks, finite_start), impulses)


def _in_symbols(A: SymbolicPolynomialMatrix, initial, time) -> ApostolKolodner:
    X0, time = checked_start(A, initial, time)
    q, blocks, infinite = A.degree, closed_blocks(A), A.jordan_pairs().infinite
    values, Aq, A0 = [X0[i, :].T for i in range(q)], A.coefficients[-1], -A.coefficients[0]
    starts = [_sum([block.J ** (q - 1 - i) * block.B * Aq * x for i, x in enumerate(values)], block.J.rows) for block in blocks]
    infinite_start = -_sum([infinite.J**i * infinite.B * A0 * x for i, x in enumerate(values)], infinite.J.rows)
    highest = A.structure().highest_impulse
    impulses = [(-infinite.C * infinite.J ** (k + 1) * infinite_start).applyfunc(sympy.factor) for k in range(highest)]
    while impulses and impulses[-1].is_zero_matrix:
        impulses.pop()
    return ApostolKolodner(
        finite_start=sympy.Matrix.vstack(sympy.zeros(0, 1), *starts).as_immutable(),
        infinite_start=infinite_start.as_immutable(),
        function=motion_of_blocks(A, blocks, starts, time),
        impulses=tuple(impulse.as_immutable() for impulse in impulses),
    )


def _check_form(degree: int, nonzero: list[bool]) -> None:
    """Check that there is one flag for each coefficient."""
    between = [power for power in range(1, degree) if nonzero[power]]
    if degree < 1 or between:
        detail = f"terms in s^{', s^'.join(map(str, between))}" if between else "degree 0"
        raise InputError(f"A: found {detail}; expected A_q s^q - A_0 with q >= 1 and nothing between (any other form: solve)")


def _sum(parts, size) -> sympy.Matrix:
    return sum(parts, sympy.zeros(size, 1))
