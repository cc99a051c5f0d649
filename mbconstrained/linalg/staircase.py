"""A regular pencil s E - F split into its finite and its infinite part, and the Kronecker form of any other pencil.

The infinite part is deflated step by step: rows of E that vanish are found by a rank decision, the same rows
of F are compressed to the right, and what is left is a smaller pencil with the same finite zeros (Van Dooren
1979, the algorithm for the zero at infinity). Rounding noise is carried through every step, entry by entry.
The number of vanishing rows in step i is the number of infinite elementary divisors of degree at least i.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from ..ground.errors import IllConditioned
from ..ground.tolerances import EPS, NOISE_SAFETY
from .arrays import lapack
from .precise import inverse, is_precise, magnitude, of_kind, unit
from .rank import Noisy, RankDecision, RowCompression, compress_rows, null_columns, rotate_rows, stacked


class SingularPencil(ArithmeticError):
    """det(s E - F) = 0 for every s."""


@dataclass(frozen=True, eq=False)
class SplitPencil:
    """W (s E - F) Z = [[s E11 - F11, s E12 - F12], [0, s N - I]], N strictly upper triangular, hence nilpotent.

    Attributes:
        left, right: W and Z, shape (N, N), with their rounding noise.
        E11, F11: finite part, shape (n, n), E11 regular, with their rounding noise.
        E12, F12: coupling, shape (n, m), likewise.
        nilpotent: N, shape (m, m), with its rounding noise.
        deficiencies: number of infinite elementary divisors of degree at least 1, 2, ...
        decisions: the rank decisions taken, in order.
    """

    left: Noisy
    right: Noisy
    E11: Noisy
    F11: Noisy
    E12: Noisy
    F12: Noisy
    nilpotent: Noisy
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

    def rounded_to_float(self) -> SplitPencil:
        """The split pencil in float64."""
        if not is_precise(self.left.data):
            return self
        parts = {field.name: getattr(self, field.name) for field in fields(self)}
        return replace(self, **{name: part.rounded_to_float() for name, part in parts.items() if isinstance(part, Noisy)})


@dataclass
class _Work:
    """The pencil being transformed, left (s E_0 - F_0) right = s E - F; the active part is the leading one.

    E, F and left are kept side by side: they have their rows in common.
    """

    whole: Noisy
    right: Noisy

    @property
    def E(self) -> Noisy:
        return self.whole[:, : len(self.right.data)]

    @property
    def F(self) -> Noisy:
        return self.whole[:, len(self.right.data) : 2 * len(self.right.data)]

    @property
    def left(self) -> Noisy:
        return self.whole[:, 2 * len(self.right.data) :]

    def rows(self, at: slice, matrix: Noisy) -> None:
        """Replace the rows ``at`` by matrix times them."""
        self.whole[at] = matrix @ self.whole[at]

    def dependent_rows_last(self, at: slice, compression: RowCompression) -> None:
        """Reorder and combine the rows ``at``: the independent ones first, then the combinations that vanish."""
        self.whole[at] = compression.apply(self.whole[at])

    def dependent_columns_first(self, at: slice, compression: RowCompression) -> None:
        """Reorder and combine the columns ``at``: the combinations that vanish first, then the independent ones."""
        parts, size = (self.E, self.F, self.right), len(self.right.data)
        columns = stacked(*(part[:, at] for part in parts)).T
        turned = stacked(compression.combined(columns), columns[compression.pivots]).T
        for place, part in enumerate(parts):
            part[:, at] = turned[place * size : (place + 1) * size]


#: Where a pencil is tried for regularity: generic numbers, so that no zero is hit by chance.
GENERIC = (0.7390851 + 0.3183099j, -0.5671433 + 1.2020569j, 1.6180340 - 0.9159656j)


def split_regular(E: Noisy, F: Noisy) -> SplitPencil:
    """Split s E - F."""
    try:
        return split_pencil(E, F)
    except SingularPencil:
        if not _has_full_rank(E, F):
            raise
    raise IllConditioned(
        "the equations are regular, but so close to dependent ones that float64 cannot tell which of their zeros are "
        "infinite; write them with fewer redundant coordinates, or in coordinates closer to the machine's own"
    )


def _has_full_rank(E: Noisy, F: Noisy) -> bool:
    """Whether s E - F is regular beyond its noise at a generic s."""
    E, F = E.rounded_to_float(), F.rounded_to_float()
    for s in GENERIC:
        values = np.linalg.svd(s * E.data - F.data, compute_uv=False)
        noise = max(np.linalg.norm(abs(s) * E.noise + F.noise), EPS * len(values) * values[0])
        if values[-1] > NOISE_SAFETY * noise:
            return True
    return False


def split_pencil(E: Noisy, F: Noisy, decided: Iterator[RankDecision] | None = None) -> SplitPencil:
    """Split s E - F, square and real, with its noise; split_pencil(F, E) splits the zeros at s = 0 off instead."""
    n = len(E.data)
    left, right = (Noisy.exact(of_kind(np.eye(n), E.data)) for _ in range(2))
    work = _Work(stacked(E.T, F.T, left.T).T, right)
    deficiencies, decisions = [], []
    while True:
        compression = compress_rows(work.E[:n, :n], decided=_next(decided))
        decisions.append(compression.decision)
        if compression.decision.rank == n:
            return _finished(work, n, tuple(deficiencies), tuple(decisions))
        deficiencies.append(n - compression.decision.rank)
        decisions.append(_deflate(work, n, compression, _next(decided)))
        n = compression.decision.rank


def _next(decided):
    return None if decided is None else next(decided)


def _deflate(work: _Work, active: int, compression: RowCompression, decided: RankDecision | None) -> RankDecision:
    """Move the vanishing rows of E to the end, and the columns that they determine through F with them."""
    rank = compression.decision.rank
    top, bottom = slice(active), slice(rank, active)
    work.dependent_rows_last(top, compression)
    work.E[bottom, top] = Noisy.exact(np.zeros((active - rank, active)))
    still = ~(work.E.data[:rank, top] != 0).any(axis=0)
    turned = null_columns(work.F[bottom, top], still, decided)
    if turned.decision.rank < active - rank:
        raise SingularPencil("the pencil is singular")
    work.dependent_columns_first(top, turned)
    work.rows(bottom, _with_rounding(inverse(work.F.data[bottom, rank:active])))
    work.F[bottom, top] = Noisy.exact(np.eye(active - rank, active, k=rank))
    return turned.decision


def _finished(work: _Work, n: int, deficiencies, decisions) -> SplitPencil:
    """Normalize the infinite part's F, upper triangular and regular, to the identity."""
    finite, infinite = slice(n), slice(n, None)
    F22 = work.F.data[infinite, infinite]
    if len(F22):
        work.rows(infinite, _with_rounding(inverse(F22) if is_precise(F22) else lapack.dtrtrs(F22, np.eye(len(F22)))[0]))
    nilpotent, above = work.E[infinite, infinite], ~np.tri(len(F22), dtype=bool)
    return SplitPencil(
        left=work.left,
        right=work.right,
        E11=work.E[finite, finite],
        F11=work.F[finite, finite],
        E12=work.E[finite, infinite],
        F12=work.F[finite, infinite],
        nilpotent=Noisy(nilpotent.cleaned() * above, nilpotent.noise * above),
        deficiencies=deficiencies,
        decisions=decisions,
    )


def _with_rounding(matrix: np.ndarray) -> Noisy:
    return Noisy(matrix, unit(matrix) * magnitude(matrix))


# The Kronecker form of a singular or rectangular pencil s E - F, shape (m, n), without its transformations.
#
# Null columns of E are the ends of chains: combinations of columns that F alone acts on. Where F maps a combination of them to zero,
# a block L_k of k rows and k + 1 columns ends, otherwise an infinite elementary divisor goes on. Both, and the rows that F maps the
# null columns to, are taken out, and so on (Van Dooren 1979; Demmel and Kagstrom 1993). Of s_1, s_2, ... null columns
# mapped to r_1, r_2, ... rows, s_k - r_k are ends of L_(k - 1), and r_k - s_(k + 1) are infinite elementary divisors of degree k. What
# remains has an E of full column rank: finite zeros, and the transposed blocks L_k^T, which the same steps find in its transpose.


@dataclass(frozen=True, eq=False)
class RightStaircase:
    """The right minimal indices of s E - F and its infinite elementary divisors.

    Attributes:
        E, F: what remains without both, E of full column rank.
        vectors: a minimal basis of the x(s) with (s E - F) x(s) = 0, ascending degrees, the coefficients of each as columns, shape
            (n, degree + 1).
        divisors: degrees of the infinite elementary divisors, ascending.
        decisions: the rank decisions taken, in order.
    """

    E: Noisy
    F: Noisy
    vectors: tuple[Noisy, ...]
    divisors: tuple[int, ...]
    decisions: tuple[RankDecision, ...]

    @property
    def indices(self) -> tuple[int, ...]:
        """The right minimal indices, ascending."""
        return tuple(vector.data.shape[1] - 1 for vector in self.vectors)


def right_staircase(E: Noisy, F: Noisy, by_rotation: bool = False) -> RightStaircase:
    """Take the right minimal indices and the infinite elementary divisors out of s E - F, with its noise, by elimination or orthogonally."""
    steps: list[tuple] = []
    decisions: list[RankDecision] = []
    while True:
        columns = rotate_rows(E.T) if by_rotation else null_columns(E, ~(E.data != 0).any(axis=0))
        decisions.append(columns.decision)
        if columns.decision.rank == E.data.shape[1]:
            break
        image, E, F = F @ columns.null.T, columns.kept(E.T).T, columns.kept(F.T).T
        rows = rotate_rows(image) if by_rotation else compress_rows(image)
        decisions.append(rows.decision)
        steps.append((columns, *map(rows.kept, (image, E, F))))
        E, F = rows.combined(E), rows.combined(F)
    ranks = [decision.rank for decision in decisions[1::2]]
    nullities = [*(len(columns.null.data) for columns, *_ in steps), 0]
    divisors = tuple(k + 1 for k, rank in enumerate(ranks) for _ in range(rank - nullities[k + 1]))
    vectors: list[Noisy] = []
    for step in reversed(steps):
        vectors = _extended(vectors, *step)
    return RightStaircase(E, F, tuple(sorted(vectors, key=lambda vector: vector.data.shape[1])), divisors, tuple(decisions))


def _extended(vectors: Sequence[Noisy], columns: RowCompression, image: Noisy, E: Noisy, F: Noisy) -> list[Noisy]:
    """Kernel vectors of a step from those of the next one, and those that end here.

    x = null^T u + v in the columns kept, v a vector of the next step, solves (s E - F) x = 0 where image u = (s E - F) v: its degree is
    one more.
    """
    null, result = columns.null.T, []
    ends = null_columns(image, decided=RankDecision(len(image.data), np.inf, 0.0))
    solution = _with_rounding(inverse(image.data[:, ends.pivots]))
    for v in vectors:
        pushed, kept = (Noisy.exact(of_kind(np.zeros((len(E.data), v.data.shape[1] + 1)), v.data)) for _ in range(2))
        pushed[:, 1:], kept[:, :-1] = E @ v, -(F @ v)
        x = null[:, ends.pivots] @ (solution @ (pushed + kept))
        x[:, :-1] = x[:, :-1] + columns.placed(v)
        result.append(x)
    ended = null @ ends.null.T
    return result + [ended[:, [place]] for place in range(ended.data.shape[1])]
