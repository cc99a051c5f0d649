"""The companion pencil decoupled into s I - T (finite, T in real Schur form) and s N - I (infinite).

With P (s E - F) Q = diag(s I - T, s N - I) the inverse of A(s) is read off the first r rows of Q and the last
r columns of P (Moysis et al., Theorem 2.8):  A(s)^-1 = C (s I - T)^-1 B - C2 (I + s N + s^2 N^2 + ...) B2,
all in the scaled units of the companion pencil. Values z0 at 0- enter the finite part as P_1 E z0 and the
infinite one as P_2 F z0 (Eqs. 43-44).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..linalg.staircase import SplitPencil
from ..linalg.triangular import triangular_form
from ..polynomial.companion import ScaledCompanion
from ..tolerances import EPS, NOISE_SAFETY


@dataclass(frozen=True)
class WeierstrassForm:
    """The decoupled pencil, in scaled units.

    Attributes:
        companion: the pencil it came from.
        split: the staircase result, with its rank decisions.
        T: real Schur form of the finite part, shape (n, n).
        finite_columns: Q_1, shape (g r, n).   finite_rows: P_1, shape (n, g r).
        nilpotent: N, shape (m, m).
        infinite_columns: Q_2, shape (g r, m). infinite_rows: P_2, shape (m, g r).
    """

    companion: ScaledCompanion
    split: SplitPencil
    T: np.ndarray
    finite_columns: np.ndarray
    finite_rows: np.ndarray
    nilpotent: np.ndarray
    infinite_columns: np.ndarray
    infinite_rows: np.ndarray

    @property
    def C(self) -> np.ndarray:
        """Shape (r, n)."""
        return self.finite_columns[: self.companion.size]

    @property
    def B(self) -> np.ndarray:
        """Shape (n, r)."""
        return self.finite_rows[:, -self.companion.size :] if self.companion.size else self.finite_rows

    @property
    def C2(self) -> np.ndarray:
        """Shape (r, m)."""
        return self.infinite_columns[: self.companion.size]

    @property
    def B2(self) -> np.ndarray:
        """Shape (m, r)."""
        return self.infinite_rows[:, -self.companion.size :] if self.companion.size else self.infinite_rows

    @property
    def highest_impulse(self) -> int:
        """q_hat_r, the highest order of an infinite zero of A(s): H_i = 0 beyond it."""
        return max([0, *(degree - self.companion.grade for degree in self.split.infinite_divisors)])

    def laurent(self, index: int) -> np.ndarray:
        """Scaled H_i of A(s)^-1 near infinity, shape (r, r)."""
        if index > self.highest_impulse:
            return np.zeros((self.companion.size,) * 2)
        if index >= 0:
            return -self.C2 @ np.linalg.matrix_power(self.nilpotent, index) @ self.B2
        return self.C @ np.linalg.matrix_power(self.T, -index - 1) @ self.B


def weierstrass_form(companion: ScaledCompanion) -> WeierstrassForm:
    """Decouple the finite from the infinite part.

    The coupling R solves R = T R N + G; N is nilpotent, so the fixed point is reached in as many steps as there
    are blocks in the staircase, row by row in the Schur basis of the finite part.
    """
    split = companion.split
    n = len(split.E11)
    finite = triangular_form(split.E11, split.F11)
    E12, F12 = finite.left @ split.E12, finite.left @ split.F12
    R = _fixed_point(finite.T, split.nilpotent, F12 @ split.nilpotent - E12, len(split.deficiencies))
    finite_columns = split.right[:, :n] @ finite.right
    correction = finite_columns @ R
    infinite_columns = split.right[:, n:] + correction
    noise = split.right_noise[:, n:] + EPS * np.where(correction != 0, np.abs(finite_columns) @ np.abs(R), 0.0)
    return WeierstrassForm(
        companion=companion,
        split=split,
        T=finite.T,
        finite_columns=finite_columns,
        finite_rows=finite.left @ split.left[:n] - (finite.T @ R + F12) @ split.left[n:],
        nilpotent=split.nilpotent,
        infinite_columns=np.where(np.abs(infinite_columns) <= NOISE_SAFETY * noise, 0.0, infinite_columns),
        infinite_rows=split.left[n:],
    )


def _fixed_point(T, nilpotent, G, steps):
    R = G
    for _ in range(steps):
        R = T @ R @ nilpotent + G
    return R
