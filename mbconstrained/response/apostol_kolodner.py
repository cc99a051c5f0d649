"""Matrices of the form A(s) = A_q s^q - A_0, solved by the formulas that Moysis et al. give for them (section 4.2).

F x^(q) = G x with F = A_q and G = A_0, each of them singular or not. A view for comparison: ``solve`` handles these
matrices like all others and is the way to compute.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..checks import real_array
from ..errors import InputError
from ..polynomial.matrix import PolynomialMatrix
from ..signals.bohl import BohlFunction
from .solve import checked_matrix


@dataclass(frozen=True)
class ApostolKolodner:
    """The solution of A_q x^(q) = A_0 x from values at 0-.

    Attributes:
        finite_start: x_s(0), shape (n,), Eq. (75).
        infinite_start: x_f(0), shape (mu,), Eq. (76), corrected.
        function: x(t) = C e^{J t} x_s(0) for t > 0, Eq. (65).
        impulses: arrays (r,), the k-th multiplies delta^(k): -C_inf J_inf^(k + 1) x_f(0), Eq. (42).
    """

    finite_start: np.ndarray
    infinite_start: np.ndarray
    function: BohlFunction
    impulses: tuple[np.ndarray, ...]

    def __call__(self, times) -> np.ndarray:
        """x at a time (-> (r,)) or at times (T,) (-> (r, T))."""
        return self.function(times)


def apostol_kolodner(A: PolynomialMatrix, initial) -> ApostolKolodner:
    """The free motion of A(s) = A_q s^q - A_0 by Eqs. (73)-(76) of Moysis et al.

    In (76) the printed sign is wrong: with (74), the values enter as x_f(0) = -(B_inf A_0 ... J_inf^(q-1) B_inf A_0) X_0.
    (75) is right. The paper's A_0 = G is minus the coefficient of s^0 that a ``PolynomialMatrix`` holds.

    Args:
        A: with every coefficient between the first and the last zero, degree q >= 1, size r.
        initial: x^(i)(0-) as row i, shape (q, r).

    Raises:
        InputError: A(s) is not of this form.
        SingularPolynomialMatrix: det A(s) = 0 for every s.

    >>> A = PolynomialMatrix([[[4.0]], [[0.0]], [[1.0]]])  # x'' = -4 x
    >>> x = apostol_kolodner(A, [[1.0], [0.0]])
    >>> bool(np.isclose(x(0.5)[0], np.cos(1.0)))
    True
    """
    q, r = checked_matrix(A).degree, A.size
    if q < 1 or A.coefficients[1:-1].any():
        found = [power for power in range(1, q) if A.coefficients[power].any()]
        detail = f"terms in s^{', s^'.join(map(str, found))}" if found else "degree 0"
        raise InputError(f"A: found {detail}; expected A_q s^q - A_0 with q >= 1 and nothing between (any other form: mb.solve)")
    X = real_array(initial, "initial", shape=(q, r))
    pairs = A.jordan_pairs()
    finite, infinite, Aq, A0 = pairs.finite, pairs.infinite, A.coefficients[-1], -A.coefficients[0]
    finite_start = sum((_power(finite.J, q - 1 - i) @ (finite.B @ (Aq @ X[i])) for i in range(q)), np.zeros(len(finite.J)))
    infinite_start = -sum((_power(infinite.J, i) @ (infinite.B @ (A0 @ X[i])) for i in range(q)), np.zeros(len(infinite.J)))
    highest = pairs.structure.highest_impulse
    impulses = tuple(-infinite.C @ _power(infinite.J, k + 1) @ infinite_start for k in range(highest))
    return ApostolKolodner(finite_start, infinite_start, BohlFunction(finite.C, finite.blocks, finite_start), impulses)


def _power(J, exponent) -> np.ndarray:
    return np.linalg.matrix_power(J, exponent)
