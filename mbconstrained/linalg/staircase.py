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

from ..tolerances import EPS, NOISE_SAFETY
from .rank import RankDecision, RowCompression, compress_columns, compress_rows


class SingularPencil(ArithmeticError):
    """det(s E - F) = 0 for every s."""


@dataclass(frozen=True)
class SplitPencil:
    """W (s E - F) Z = [[s E11 - F11, s E12 - F12], [0, s N - I]], N strictly upper triangular, hence nilpotent.

    Entries of W, Z and N that are no larger than their carried rounding noise are exactly zero.

    Attributes:
        left, right: W and Z, shape (N, N).
        right_noise: bound of the rounding noise in Z.
        E11, F11: finite part, shape (n, n), E11 regular.
        E12, F12: coupling, shape (n, m).
        nilpotent: N, shape (m, m).
        deficiencies: number of infinite elementary divisors of degree at least 1, 2, ...
        decisions: the rank decisions taken, in order.
    """

    left: np.ndarray
    right: np.ndarray
    right_noise: np.ndarray
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
class Noisy:
    """A matrix with a bound of the rounding noise of each entry; row and column operations carry it along."""

    data: np.ndarray
    noise: np.ndarray

    def rows(self, at: slice, matrix: np.ndarray) -> None:
        """Replace the rows ``at`` by matrix times them."""
        size = np.abs(matrix)
        self.noise[at] = size @ self.noise[at] + EPS * _mixes(matrix, axis=1)[:, None] * (size @ np.abs(self.data[at]))
        self.data[at] = matrix @ self.data[at]

    def columns(self, at: slice, matrix: np.ndarray) -> None:
        """Replace the columns ``at`` by them times matrix."""
        size, part = np.abs(matrix), (slice(None), at)
        self.noise[part] = self.noise[part] @ size + EPS * _mixes(matrix, axis=0) * (np.abs(self.data[part]) @ size)
        self.data[part] = self.data[part] @ matrix

    def clear(self, rows: slice, columns: slice) -> None:
        """Set a part to exactly zero."""
        self.data[rows, columns] = 0.0
        self.noise[rows, columns] = 0.0

    def cleaned(self) -> np.ndarray:
        """The matrix, entries within their noise set to zero."""
        return np.where(np.abs(self.data) <= NOISE_SAFETY * self.noise, 0.0, self.data)


@dataclass
class _Work:
    """The pencil being transformed, left (s E_0 - F_0) right = s E - F; the active part is the leading one."""

    E: Noisy
    F: Noisy
    left: Noisy
    right: Noisy

    def rows(self, at: slice, matrix: np.ndarray) -> None:
        for part in (self.E, self.F, self.left):
            part.rows(at, matrix)

    def columns(self, at: slice, matrix: np.ndarray) -> None:
        for part in (self.E, self.F, self.right):
            part.columns(at, matrix)


def split_pencil(E: np.ndarray, F: np.ndarray) -> SplitPencil:
    """Split s E - F (square, real, each entry known to half a unit in the last place).

    Raises:
        SingularPencil: det(s E - F) vanishes identically, to within the noise of the data.
    """
    n = len(E)
    exact = np.zeros((n, n))
    work = _Work(
        E=Noisy(E.copy(), EPS * np.abs(E)),
        F=Noisy(F.copy(), EPS * np.abs(F)),
        left=Noisy(np.eye(n), exact.copy()),
        right=Noisy(np.eye(n), exact.copy()),
    )
    deficiencies, decisions = [], []
    while True:
        active = slice(n)
        found = compress_rows(work.E.data[active, active], work.E.noise[active, active])
        decisions.append(found.decision)
        if found.decision.rank == n:
            return _finished(work, n, tuple(deficiencies), tuple(decisions))
        deficiencies.append(n - found.decision.rank)
        decisions.append(_deflate(work, n, found))
        n = found.decision.rank


def _deflate(work: _Work, active: int, found: RowCompression) -> RankDecision:
    """Move the vanishing rows of E to the end, and the columns that they determine through F with them."""
    rank = found.decision.rank
    top, bottom, keep = slice(active), slice(rank, active), active - rank
    work.rows(top, found.left)
    work.E.clear(bottom, top)
    turned = compress_columns(work.F.data[bottom, top], work.F.noise[bottom, top])
    if turned.decision.rank < keep:
        raise SingularPencil("the pencil is singular")
    work.columns(top, np.hstack([turned.right[:, keep:], turned.right[:, :keep]]))
    work.rows(bottom, turned.left)
    work.F.clear(bottom, slice(rank))
    work.F.data[bottom, bottom] = np.diag(turned.values)
    return turned.decision


def _finished(work: _Work, n: int, deficiencies, decisions) -> SplitPencil:
    """Normalize the infinite part's F, upper triangular and regular, to the identity."""
    finite, infinite = slice(n), slice(n, None)
    if n < len(work.F.data):
        F22 = work.F.data[infinite, infinite]
        work.rows(infinite, scipy.linalg.solve_triangular(F22, np.eye(len(F22))))
    return SplitPencil(
        left=work.left.cleaned(),
        right=work.right.cleaned(),
        right_noise=work.right.noise,
        E11=work.E.data[finite, finite],
        F11=work.F.data[finite, finite],
        E12=work.E.data[finite, infinite],
        F12=work.F.data[finite, infinite],
        nilpotent=np.triu(work.E.cleaned()[infinite, infinite], 1),
        deficiencies=deficiencies,
        decisions=decisions,
    )


def _mixes(matrix, axis):
    """1 where a row (or column) sums more than one term and so rounds, 0 where it only copies or scales."""
    return (np.count_nonzero(matrix, axis=axis) > 1).astype(float)
