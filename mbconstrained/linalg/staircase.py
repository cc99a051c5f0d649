"""A regular pencil s E - F split into its finite and its infinite part.

The infinite part is deflated step by step: rows of E that vanish are found by a rank decision, the same rows
of F are compressed to the right, and what is left is a smaller pencil with the same finite zeros (Van Dooren
1979, the algorithm for the zero at infinity). Rounding noise is carried through every step, entry by entry.
The number of vanishing rows in step i is the number of infinite elementary divisors of degree at least i.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ..tolerances import EPS
from .rank import RankDecision, RowCompression, compress_columns, compress_rows


class SingularPencil(ArithmeticError):
    """det(s E - F) = 0 for every s."""


@dataclass(frozen=True)
class SplitPencil:
    """W (s E - F) Z = [[s E11 - F11, s E12 - F12], [0, s N - I]], N strictly upper triangular, hence nilpotent.

    Attributes:
        left, right: W and Z, shape (N, N).
        E11, F11: finite part, shape (n, n), E11 regular.
        E12, F12: coupling, shape (n, m).
        nilpotent: N, shape (m, m).
        deficiencies: number of infinite elementary divisors of degree at least 1, 2, ...
        decisions: the rank decisions taken, in order.
    """

    left: np.ndarray
    right: np.ndarray
    E11: np.ndarray
    F11: np.ndarray
    E12: np.ndarray
    F12: np.ndarray
    nilpotent: np.ndarray
    deficiencies: tuple[int, ...]
    decisions: tuple[RankDecision, ...]

    @property
    def infinite_divisors(self) -> tuple[int, ...]:
        """Degrees of the infinite elementary divisors of the pencil, ascending (no zeros listed)."""
        degrees: list[int] = []
        for step, count in enumerate(self.deficiencies):
            following = self.deficiencies[step + 1] if step + 1 < len(self.deficiencies) else 0
            degrees += [step + 1] * (count - following)
        return tuple(sorted(degrees))


@dataclass
class _Work:
    """The pencil being transformed, with the noise of its entries; the active part is the leading m x m."""

    E: np.ndarray
    F: np.ndarray
    noise_E: np.ndarray
    noise_F: np.ndarray
    left: np.ndarray
    right: np.ndarray

    def rows(self, count: int, matrix: np.ndarray) -> None:
        """Replace the first count rows by matrix times them."""
        size = np.abs(matrix)
        smear = EPS * _mixes(matrix, axis=1)[:, None]
        for data, noise in ((self.E, self.noise_E), (self.F, self.noise_F)):
            noise[:count] = size @ noise[:count] + smear * (size @ np.abs(data[:count]))
            data[:count] = matrix @ data[:count]
        self.left[:count] = matrix @ self.left[:count]

    def columns(self, count: int, matrix: np.ndarray) -> None:
        """Replace the first count columns by them times matrix."""
        size = np.abs(matrix)
        smear = EPS * _mixes(matrix, axis=0)
        for data, noise in ((self.E, self.noise_E), (self.F, self.noise_F)):
            noise[:, :count] = noise[:, :count] @ size + smear * (np.abs(data[:, :count]) @ size)
            data[:, :count] = data[:, :count] @ matrix
        self.right[:, :count] = self.right[:, :count] @ matrix


def split_pencil(E: np.ndarray, F: np.ndarray) -> SplitPencil:
    """Split s E - F (square, real, each entry known to half a unit in the last place).

    Raises:
        SingularPencil: det(s E - F) vanishes identically, to within the noise of the data.
    """
    size = len(E)
    work = _Work(E.copy(), F.copy(), EPS * np.abs(E), EPS * np.abs(F), np.eye(size), np.eye(size))
    active, deficiencies, decisions = size, [], []
    while True:
        found = compress_rows(work.E[:active, :active], work.noise_E[:active, :active])
        decisions.append(found.decision)
        missing = active - found.decision.rank
        if missing == 0:
            break
        decisions.append(_deflate(work, active, found))
        deficiencies.append(missing)
        active -= missing
    return _finished(work, active, tuple(deficiencies), tuple(decisions))


def _deflate(work: _Work, active: int, found: RowCompression) -> RankDecision:
    """Move the vanishing rows of E to the end, and the columns that they determine through F with them."""
    rank = found.decision.rank
    work.rows(active, found.left)
    work.E[rank:active, :active] = 0.0
    work.noise_E[rank:active, :active] = 0.0
    turned = compress_columns(work.F[rank:active, :active], work.noise_F[rank:active, :active])
    if turned.decision.rank < active - rank:
        raise SingularPencil("the pencil is singular")
    keep = active - rank
    work.columns(active, np.hstack([turned.right[:, keep:], turned.right[:, :keep]]))
    bottom = slice(rank, active)
    for data in (work.E, work.F, work.left):  # no decision looks at these rows again: their noise may stay behind
        data[bottom] = turned.left @ data[bottom]
    work.F[bottom, :rank] = 0.0
    work.F[bottom, rank:active] = np.diag(turned.values)
    return turned.decision


def _finished(work: _Work, n: int, deficiencies, decisions) -> SplitPencil:
    """Normalize the infinite part's F, upper triangular and regular, to the identity."""
    size = len(work.E)
    if n < size:
        F22 = work.F[n:, n:].copy()
        for block in (work.E, work.F, work.left):
            block[n:] = scipy.linalg.solve_triangular(F22, block[n:])
    return SplitPencil(
        left=work.left,
        right=work.right,
        E11=work.E[:n, :n],
        F11=work.F[:n, :n],
        E12=work.E[:n, n:],
        F12=work.F[:n, n:],
        nilpotent=np.triu(work.E[n:, n:], 1),
        deficiencies=deficiencies,
        decisions=decisions,
    )


def _mixes(matrix, axis):
    """1 where a row (or column) sums more than one term and so rounds, 0 where it only copies or scales."""
    return (np.count_nonzero(matrix, axis=axis) > 1).astype(float)
