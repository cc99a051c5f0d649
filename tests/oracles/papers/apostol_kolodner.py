"""Matrices of the form A(s) = A_q s^q - A_0, solved by the formulas that Moysis et al. give for them (section 4.2), in numbers and symbols.

Corrected: the printed sign of (76) is wrong: with (74), the values enter as x_f(0) = -(B_inf A_0 ... J_inf^(q-1) B_inf A_0) X_0.
(75) is right. The paper's A_0 = G is minus the coefficient of s^0 that a polynomial matrix holds.
"""

from __future__ import annotations

import numpy as np
import sympy

from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
from mbconstrained.polynomial.polynomial_matrix import PolynomialMatrix
from mbconstrained.signals.bohl import BohlFunction
from tests.oracles.papers.corollaries import motion_of_blocks


def apostol_kolodner(A: PolynomialMatrix, X: np.ndarray) -> tuple[BohlFunction, list[np.ndarray]]:
    """x(t) = C e^{J t} x_s(0) for t > 0 with (75), and the factors -C_inf J_inf^(k + 1) x_f(0) of delta^(k) with (76), Eq. (42)."""
    pairs, q, power = A.jordan_pairs(), A.degree, np.linalg.matrix_power
    finite, infinite, Aq, A0 = pairs.finite, pairs.infinite, A.coefficients[-1], -A.coefficients[0]
    start = sum((power(finite.J, q - 1 - i) @ finite.B @ Aq @ X[i] for i in range(q)), np.zeros(len(finite.J)))
    fast = -sum((power(infinite.J, i) @ infinite.B @ A0 @ X[i] for i in range(q)), np.zeros(len(infinite.J)))
    impulses = [-infinite.C @ power(infinite.J, k + 1) @ fast for k in range(pairs.structure.highest_impulse)]
    return BohlFunction(finite.C, finite.blocks, start), impulses


def apostol_kolodner_in_symbols(
    A: SymbolicPolynomialMatrix, X0: sympy.Matrix, time: sympy.Symbol
) -> tuple[sympy.Matrix, list[sympy.Matrix]]:
    """The same as expressions, without impulses that vanish at the end."""
    q, blocks, infinite = A.degree, A.jordan_pairs().finite.blocks, A.jordan_pairs().infinite
    values, Aq, A0 = [X0[i, :].T for i in range(q)], A.coefficients[-1], -A.coefficients[0]
    starts = [sum((b.J ** (q - 1 - i) * b.B * Aq * x for i, x in enumerate(values)), sympy.zeros(b.J.rows, 1)) for b in blocks]
    fast = -sum((infinite.J**i * infinite.B * A0 * x for i, x in enumerate(values)), sympy.zeros(infinite.J.rows, 1))
    impulses = [-infinite.C * infinite.J ** (k + 1) * fast for k in range(A.structure().highest_impulse)]
    while impulses and not any(impulses[-1].expand()):
        impulses.pop()
    return motion_of_blocks(A, blocks, starts, time), impulses
