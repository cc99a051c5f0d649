"""The companion pencil decoupled into s I - T (finite, T in real Schur form) and s N - I (infinite).

With P (s E - F) Q = diag(s I - T, s N - I) the inverse of A(s) is read off the first r rows of Q and the last
r columns of P (Moysis et al., Theorem 2.8):  A(s)^-1 = C (s I - T)^-1 B - C2 (I + s N + s^2 N^2 + ...) B2,
all in the scaled units of the companion pencil. Values z0 at 0- enter the finite part as P_1 E z0 and the
infinite one as P_2 F z0 (Eqs. 43-44).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from ..ground.tolerances import EPS, PRECISE_DECOUPLING
from ..linalg.blocks import coupled_rows
from ..linalg.precise import floats, magnitude, precise, precise_arithmetic, product
from ..linalg.rank import RankDecision
from ..linalg.rounding import Noisy, columnwise
from ..linalg.staircase import SplitPencil, split_pencil
from ..linalg.triangular import triangular_form
from .companion import ScaledCompanion


@dataclass(frozen=True, eq=False)
class WeierstrassForm:
    """The decoupled pencil, in scaled units.

    Attributes:
        companion: the pencil it came from.
        split: the staircase result.
        decisions: the rank decisions taken, at infinity and at s = 0.
        T: real Schur form of the finite part, shape (n, n), the zeros at s = 0 last.
        nonzero_count: number of rows of T for the other zeros.
        zero_divisors: degrees of the elementary divisors at s = 0, ascending.
        finite_columns: Q_1, shape (g r, n).   finite_rows: P_1, shape (n, g r).   finite_start: P_1 E, likewise.
        nilpotent: N, shape (m, m).
        infinite_columns: Q_2, shape (g r, m). infinite_rows: P_2, shape (m, g r). infinite_start: P_2 F, likewise.
        The infinite part is small and read for zeros, so it carries its rounding noise.
        exact_pair: C, T and B before they were rounded, where the arithmetic was precise.
    """

    companion: ScaledCompanion
    split: SplitPencil
    decisions: tuple[RankDecision, ...]
    T: np.ndarray
    nonzero_count: int
    zero_divisors: tuple[int, ...]
    finite_columns: np.ndarray
    finite_rows: np.ndarray
    finite_start: np.ndarray
    nilpotent: Noisy
    infinite_columns: Noisy
    infinite_rows: Noisy
    infinite_start: Noisy
    exact_pair: tuple[np.ndarray, np.ndarray, np.ndarray] | None

    @property
    def C(self) -> np.ndarray:
        """Shape (r, n)."""
        return self.finite_columns[: self.companion.size]

    @property
    def B(self) -> np.ndarray:
        """Shape (n, r)."""
        return _of_equations(self.finite_rows, self.companion)

    @property
    def noisy_B(self) -> Noisy:
        """B with its rounding errors: those of an eigenvalue algorithm, or of each entry where it was precise."""
        by_rows = columnwise(self.B.T).T
        if not self.companion.is_precise:
            return by_rows
        return Noisy(self.B, EPS * np.abs(self.B) + PRECISE_DECOUPLING / EPS * by_rows.noise)

    @property
    def C2(self) -> Noisy:
        """Shape (r, m)."""
        return self.infinite_columns[: self.companion.size]

    @property
    def B2(self) -> Noisy:
        """Shape (m, r)."""
        return _of_equations(self.infinite_rows, self.companion)

    @property
    def highest_impulse(self) -> int:
        """q_hat_r, the highest order of an infinite zero of A(s): H_i = 0 beyond it."""
        return max([0, *(degree - self.companion.grade for degree in self.split.infinite_divisors)])

    def laurent(self, index: int) -> Noisy:
        """Scaled H_i of A(s)^-1 near infinity, shape (r, r)."""
        r = self.companion.size
        if index > self.highest_impulse:
            return Noisy.exact(np.zeros((r, r)))
        if index < 0:
            return self._precise_laurent(index) if self.exact_pair else self._rounded_laurent(index)
        value = -self.B2
        for _ in range(index):
            value = self.nilpotent @ value
        return self.C2 @ value

    def _rounded_laurent(self, index: int) -> Noisy:
        """C T^(-i-1) B; T is known to rounding errors of its norm, as is what orthogonal transformations make, part by part."""
        size = np.abs(self.T)
        uncertain = size.copy()
        for at in coupled_rows(self.T):
            own = np.ix_(at, at)
            uncertain[own] = np.maximum(size[own], size[own].max() / len(at))
        value, largest = self.B, np.abs(self.B).max(axis=0, keepdims=True, initial=0.0)
        noise = np.maximum(EPS * largest, self.noisy_B.noise)
        for _ in range(-index - 1):
            value, noise = self.T @ value, size @ noise + EPS * uncertain @ np.abs(value)
        return Noisy(self.C @ value, np.abs(self.C) @ noise)

    def _precise_laurent(self, index: int) -> Noisy:
        """C T^(-i-1) B from unrounded matrices: where fast zeros cancel, slow ones keep their digits."""
        C, T, value = self.exact_pair
        with precise_arithmetic():
            size = magnitude(value)
            for _ in range(-index - 1):
                value, size = product(T, value), magnitude(T) @ size
            H = floats(product(C, value))
            return Noisy(H, EPS * np.abs(H) + PRECISE_DECOUPLING * magnitude(C) @ size)


def weierstrass_form(companion: ScaledCompanion, decided: Sequence[RankDecision] | None = None) -> WeierstrassForm:
    """Decouple the finite from the infinite part.

    The coupling R solves R = T R N + G; N is nilpotent, so the fixed point is reached in as many steps as there
    are blocks in the staircase, row by row in the Schur basis of the finite part.
    """
    (E, F), decisions = companion.pencil, iter(decided or ())
    split = companion.split if decided is None else split_pencil(E, F, decisions)
    n = len(split.E11.data)
    at_zero = tuple(decisions)
    finite = triangular_form(split.E11, split.F11, iter(at_zero) if at_zero else None)
    left = columnwise(finite.left.T).T
    exact_T = product(finite.left, split.F11.data, finite.right) if companion.is_precise else finite.T
    E12, F12 = left @ split.E12, left @ split.F12
    R = _fixed_point(Noisy.rounded(exact_T), split.nilpotent, F12 @ split.nilpotent + -E12, len(split.deficiencies))
    finite_columns = product(split.right.data[:, :n], finite.right)
    finite_rows = product(finite.left, split.left.data[:n]) - product(product(exact_T, R.data) + F12.data, split.left.data[n:])
    infinite_columns = split.right[:, n:] + columnwise(finite_columns) @ R
    T, exact_pair = finite.T.astype(float), None
    if companion.is_precise:
        turn = aligning_rotation(T, _of_equations(finite_rows, companion))
        finite_columns, finite_rows = product(finite_columns, turn.T), product(turn, finite_rows)
        T[:, finite.nonzero_count :] = floats(product(turn, finite.T[:, finite.nonzero_count :]))  # pairs stay what they are
        exact_pair = finite_columns[: companion.size], product(turn, exact_T, turn.T), _of_equations(finite_rows, companion)
    return WeierstrassForm(
        companion=companion,
        split=split.rounded_to_float(),
        decisions=split.decisions + finite.decisions,
        T=T,
        nonzero_count=finite.nonzero_count,
        zero_divisors=finite.zero_divisors,
        finite_columns=floats(finite_columns),
        finite_rows=floats(finite_rows),
        finite_start=floats(product(finite_rows, E.data)),
        nilpotent=split.nilpotent.rounded_to_float(),
        infinite_columns=infinite_columns.rounded_to_float(),
        infinite_rows=split.left[n:].rounded_to_float(),
        infinite_start=(split.left[n:] @ F).rounded_to_float(),
        exact_pair=exact_pair,
    )


def _of_equations(rows, companion: ScaledCompanion):
    """The last r columns, those of the equations A(d/dt) x = f themselves."""
    return rows[:, companion.state_count - companion.size :]


def _fixed_point(T, nilpotent, G, steps):
    R = G
    for _ in range(steps):
        R = T @ R @ nilpotent + G
    return R


# Complex pairs in the basis in which a force enters at one of the two states.
#
# A pair [[a, w], [-w, a]] is the same in every rotated basis, but not what is made of its rounded entries: of a mode that is
# at rest before an impulse, C B = 0, the displacement does not jump. In the basis in which B has one row only, so has C one
# column, the other one, and C B = 0 holds exactly; in any other it is the difference of products, and next to a force much
# faster than the mode its rounding error would be all that is left.


def aligning_rotation(T: np.ndarray, B: np.ndarray) -> np.ndarray:
    """The precise orthogonal matrix G, block diagonal as T is, for which the first row of G B is least for every pair."""
    blocks, at = [], 0
    while at < len(T):
        pair = at + 1 < len(T) and T[at + 1, at] != 0 and T[at + 1, at] == -T[at, at + 1] and T[at, at] == T[at + 1, at + 1]
        blocks.append(_rotation(B[at : at + 2]) if pair else np.eye(1))
        at += len(blocks[-1])
    return precise(np.array(block_diag(*blocks), dtype=object)) if blocks else precise(np.zeros((0, 0)))


def _rotation(B) -> np.ndarray:
    """The rotation by the direction of the column of B (2, r) that is largest."""
    column = B[:, magnitude(B).max(axis=0).argmax()] if B.size else precise(np.array([0.0, 1.0]))
    length = (column[0] * column[0] + column[1] * column[1]).sqrt()
    if length == 0:
        return precise(np.eye(2))
    sine, cosine = column / length
    return np.array([[cosine, -sine], [sine, cosine]])
