"""Real matrices in block diagonal form: by Schur forms and clusters, or by eigenvectors where eigenvalues are well separated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
import scipy

from ..ground.threads import one_thread
from ..ground.tolerances import DECOUPLING_LIMIT, EPS, MODE_AMPLIFICATION, SEPARATION_STEPS, WEAK_COUPLING
from .arrays import Matrix, block_diag, compressed, entries, full, kept, lapack, of_like_kind
from .precise import of_kind
from .scaling import balancing_units

# A real Schur form turned into a block diagonal one, with the condition of the decoupling bounded.
# The leading block is decoupled from the rest by a Sylvester equation. Where that would need a transformation
# with large entries, the zero nearest to the block is swapped in and it is tried again (Bavely and Stewart
# 1979). Close or defective zeros therefore end up together in one block, a cluster.

#: Largest number of entries computed at once (bounds the memory used).
CHUNK_ENTRIES = 2_000_000

#: The groups of more rows are those of a sparse matrix: step by step along a chain takes longer.
MANY_ROWS = 64


@dataclass(frozen=True, eq=False)
class BlockDiagonal:
    """inverse @ T @ basis = diag(blocks), inverse @ basis = I.

    Attributes:
        basis, inverse: shape (n, n).
        blocks: real quasi-triangular diagonal blocks.
        coupling: the largest norm of a decoupling transformation used.
        exact_blocks: number of last blocks that are exact to rounding errors of their own entries, however slow.
    """

    basis: np.ndarray
    inverse: np.ndarray
    blocks: tuple[np.ndarray, ...]
    coupling: float
    exact_blocks: int = 0

    def modal_output(self, output: Matrix) -> np.ndarray:
        """output @ basis."""
        used = abs(output).sum(axis=0).nonzero()[0]
        return output[:, used] @ self.basis[used]

    def coordinates(self, states: np.ndarray) -> np.ndarray:
        """inverse @ states."""
        return self.inverse @ states


def block_diagonalize(triangle: np.ndarray, limit: float = DECOUPLING_LIMIT) -> BlockDiagonal:
    """Block-diagonalize a real quasi-triangular matrix (a real Schur form); uncoupled parts stay separate."""
    groups = coupled_rows(triangle)
    return assembled(groups, [_block_diagonalize(triangle[np.ix_(at, at)], limit) for at in groups])


def assembled(groups: Sequence[np.ndarray], parts: Sequence[BlockDiagonal]) -> BlockDiagonal:
    """A matrix decoupled from its parts on groups of its rows, which no entry couples to each other."""
    if len(parts) == 1:
        return parts[0]
    n = sum(map(len, groups))
    basis, inverse = np.zeros((n, n)), np.zeros((n, n))
    if parts:
        basis, inverse = of_kind(basis, parts[0].basis), of_kind(inverse, parts[0].basis)
    blocks: list[np.ndarray] = []
    worst, begin = 0.0, 0
    for at, result in zip(groups, parts):
        end = begin + len(at)
        basis[at, begin:end], inverse[begin:end, at] = result.basis, result.inverse
        blocks += result.blocks
        worst, begin = max(worst, result.coupling), end
    return BlockDiagonal(basis, inverse, tuple(blocks), worst)


def block_slices(blocks: Sequence[np.ndarray]) -> list[slice]:
    """The rows of each block of diag(blocks), as slices.

    >>> block_slices([np.eye(2), np.eye(1)])
    [slice(0, 2, None), slice(2, 3, None)]
    """
    ends = list(accumulate(map(len, blocks)))
    return list(map(slice, [0, *ends], ends))


def block_matrix(blocks: Sequence[np.ndarray]) -> np.ndarray:
    """diag(blocks) as one array."""
    result = np.zeros((sum(map(len, blocks)),) * 2)
    for block, at in zip(blocks, block_slices(blocks)):
        result[at, at] = block
    return result


def coupled_rows(matrix: np.ndarray) -> list[np.ndarray]:
    """The rows of a square matrix in groups that no entry couples to each other, each ascending."""
    n = len(matrix)
    if n > MANY_ROWS:
        count, which = scipy.sparse.csgraph.connected_components(compressed(matrix), directed=False)
        return [np.flatnonzero(which == group) for group in range(count)]
    return [rows for rows, _ in coupled((matrix != 0) | np.eye(n, dtype=bool))]


def coupled(pattern: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """The connected components of a matrix of bools: rows that share columns, directly or through others, and these columns.

    Rows without any are in none. Sets of columns are kept as the bits of whole numbers.
    """
    result: list[tuple[int, list[int]]] = []
    met = 0
    for row, line in enumerate(np.packbits(pattern, axis=1)):
        columns, rows = int.from_bytes(line.tobytes(), "big"), [row]
        if columns & met:
            touched = [group for group in result if group[0] & columns]
            result = [group for group in result if not group[0] & columns]
            for others, more in touched:
                columns, rows = columns | others, rows + more
        if columns:
            result.append((columns, rows))
        met |= columns
    groups = sorted(sorted(rows) for _, rows in result)
    return [(np.array(rows), pattern[rows].any(axis=0).nonzero()[0]) for rows in groups]


def _block_diagonalize(triangle, limit) -> BlockDiagonal:
    T = np.array(triangle, dtype=float, order="F")
    n = len(T)
    basis, inverse = np.eye(n), np.eye(n)
    blocks, worst, start = [], 0.0, 0
    while start < n:
        end, coupling, norm = _grow(T, basis, inverse, start, limit)
        if end < n:
            basis[:, end:] += basis[:, start:end] @ coupling
            inverse[start:end] -= coupling @ inverse[end:]
            T[start:end, end:] = 0.0
        worst = max(worst, norm)
        blocks.append(T[start:end, start:end].copy())
        start = end
    return BlockDiagonal(basis, inverse, tuple(blocks), worst)


def _grow(T, basis, inverse, start, limit):
    """Grow the block that begins at start until it decouples; return its end, the coupling and its norm."""
    n = len(T)
    end = start + _step(T, start)
    while end < n:
        coupling = _decoupling(T[start:end, start:end], T[end:, end:], T[start:end, end:])
        norm = float(np.abs(coupling).max())
        if norm <= limit:
            return end, coupling, norm
        source = _nearest(T, start, end)
        size = _step(T, source)
        end = end + size if _swap(T, basis, inverse, start, source, end) else source + size
    return end, None, 0.0


def _decoupling(top, bottom, corner):
    """X with top X - X bottom = -corner, or infinite entries where top and bottom share a zero."""
    if not corner.any():
        return np.zeros_like(corner)
    solution, scale, info = lapack.dtrsyl(top, bottom, -corner, isgn=-1)
    if info != 0 or scale == 0:
        return np.full(corner.shape, np.inf)
    return solution / scale


def _step(T, at) -> int:
    """Size of the diagonal block of the quasi-triangular T that begins at this row."""
    return 2 if at + 1 < len(T) and T[at + 1, at] != 0 else 1


def zeros_of(blocks: Sequence[np.ndarray]) -> np.ndarray:
    """The zeros of diagonal blocks, of each complex pair the one above the real axis."""
    result: list[complex] = []
    for block in blocks:
        if len(block) > 2:
            values = block_eigenvalues(block)
            result.extend(values[values.imag >= 0].tolist())
            continue
        (a, *b), *below = block.tolist()
        if not below:
            result.append(a)
            continue
        (c, d), half = below[0], (a - below[0][1]) / 2
        square = half * half + b[0] * c
        root, mean = abs(square) ** 0.5, d + half
        result.extend([complex(mean, root)] if square < 0 else [mean + root, mean - root])
    return np.array(result, dtype=complex)


def block_eigenvalues(blocks: np.ndarray) -> np.ndarray:
    """The eigenvalues of a block or of a stack of them, shape (..., n, n).

    Of pairs [[a, b], [-b, a]] that are coupled alike they are those of half as many complex rows: with double pairs and tiny couplings
    LAPACK's iteration for real matrices may not converge.
    """
    pairs = [blocks[..., i::2, j::2] for i in (0, 1) for j in (0, 1)]
    if blocks.shape[-1] > 2 and blocks.shape[-1] % 2 == 0 and (pairs[0] == pairs[3]).all() and (pairs[1] == -pairs[2]).all():
        half = np.linalg.eigvals(pairs[0] + 1j * pairs[1])
        return np.concatenate([half, half.conj()], axis=-1)
    return np.linalg.eigvals(blocks)


def eigenvalues(T: np.ndarray) -> np.ndarray:
    """Zeros of a quasi-triangular matrix in the order of its diagonal."""
    values = np.diag(T).astype(complex)
    first = np.flatnonzero(np.diag(T, -1))
    pairs = np.stack([first, first + 1], axis=1)
    values[pairs] = np.linalg.eigvals(T[pairs[:, :, None], pairs[:, None, :]])
    return values


def _nearest(T, start, end) -> int:
    """Row at which the diagonal block with the zero nearest to the block [start, end) begins."""
    values = eigenvalues(T[start:, start:])
    size = end - start
    distance = np.abs(values[size:, None] - values[None, :size]).min(axis=1)
    row = end + int(distance.argmin())
    return row - 1 if row > end and T[row, row - 1] != 0 else row


def _swap(T, basis, inverse, start, source, target) -> bool:
    """Move the diagonal block at row source up to row target by orthogonal swaps, within [start, n).

    False where two zeros were too close to be swapped: the block then has to take in all up to the source.
    """
    if source == target:
        return True
    part, turn, info = lapack.dtrexc(T[start:, start:], np.eye(len(T) - start), source - start + 1, target - start + 1)
    T[start:, start:] = part
    basis[:, start:] = basis[:, start:] @ turn
    inverse[start:] = turn.T @ inverse[start:]
    return info == 0


# A real matrix decoupled by its eigenvectors: blocks of size one and two, where its eigenvalues are well separated.
# The eigenvectors x_i and the rows y_i of their inverse give each zero once more as y_i S x_i (Rayleigh's quotient), its error
# the square of theirs: rounding of the QR algorithm grows with the size of S, that of the quotient with that of S x_i. The states are
# measured in units that balance S. How well an eigenvalue is separated from the others is measured by the sum of |y_i| |x_i| over its
# states (its condition for small relative errors of S, after Skeel 1979), which no unit of theirs enters. Zeros may be well known,
# and their vectors hardly independent: where one of two like parts is coupled one way to the other. The modes are huge then, and
# cancel.

#: Number of vectors processed at once.
COLUMNS = 32


def decoupled(matrix: Matrix, units: np.ndarray | None = None) -> BlockDiagonal:
    """inverse @ S @ basis = diag(blocks) for a real square matrix S, dense or sparse.

    Where an eigenvector is hardly independent of the others, by its Schur form and clusters instead (``linalg.blocks``).
    """
    if not matrix.shape[0]:
        return BlockDiagonal(*np.zeros((2, 0, 0)), (), 0.0)
    matrix = kept(matrix) if isinstance(matrix, np.ndarray) else matrix
    units = balancing_units(matrix) if units is None else units
    balanced = of_like_kind(matrix * units / units[:, None], matrix)
    result = _by_groups(balanced) or _by_eigenvectors(balanced) or _by_clusters(balanced)
    basis, inverse = result.basis, result.inverse
    basis *= units[:, None]
    inverse /= units
    return BlockDiagonal(basis, inverse, result.blocks, result.coupling)


def _by_clusters(matrix: Matrix) -> BlockDiagonal:
    triangle, rotation = scipy.linalg.schur(full(matrix), output="real")
    parts = block_diagonalize(triangle)
    return BlockDiagonal(rotation @ parts.basis, parts.inverse @ rotation.T, parts.blocks, parts.coupling)


def _by_eigenvectors(matrix: Matrix) -> BlockDiagonal | None:
    """Decoupled form with LAPACK's real and imaginary parts of the vectors side by side as basis, without a complex matrix."""
    n = matrix.shape[0]
    room = int(lapack.dgeev_lwork(n, compute_vl=0)[0])
    with one_thread(n):
        _, imaginary, _, basis, failed = lapack.dgeev(np.array(full(matrix), order="F"), compute_vl=0, lwork=room, overwrite_a=1)
    factors, pivots, singular = lapack.dgetrf(basis)
    if failed or singular:
        return None
    inverse = lapack.dgetri(factors, pivots, lwork=room, overwrite_lu=1)[0]
    single, upper = (imaginary == 0).nonzero()[0], (imaginary > 0).nonzero()[0]
    ratios = np.einsum("ij,ij->j", basis, basis) * np.einsum("ij,ij->i", inverse, inverse)  # of modes to their summands, squared
    if not np.sqrt(ratios.max()) <= MODE_AMPLIFICATION:
        return None
    worst, result = 0.0, {}
    # in chunks, whose products stay small relative to the matrix
    for at in (single[begin : begin + COLUMNS] for begin in range(0, len(single), COLUMNS)):
        right, left = basis[:, at], inverse[at]
        worst = max(worst, (np.abs(right) * np.abs(left).T).sum(axis=0).max())
        result |= zip(at.tolist(), left.dot(matrix @ right).diagonal()[:, None, None])  # y S x of real x, y
    for at in (upper[begin : begin + COLUMNS] for begin in range(0, len(upper), COLUMNS)):
        k, both = len(at), np.concatenate([at, at + 1])
        right, left = basis[:, both], inverse[both]
        sizes = np.hypot(right[:, :k], right[:, k:]), np.hypot(left[:k], left[k:])
        worst = max(worst, (sizes[0] * sizes[1].T).sum(axis=0).max() / 2)
        quotients = left.dot(matrix @ right)
        diagonal = quotients.diagonal()
        a, b = (diagonal[:k] + diagonal[k:]) / 2, (quotients.diagonal(k) - quotients.diagonal(-k)) / 2
        result |= zip(at.tolist(), np.array([a, b, -b, a]).T.reshape(-1, 2, 2))  # of complex ones [[a, b], [-b, a]]
    if not worst <= DECOUPLING_LIMIT:
        return None
    return BlockDiagonal(basis, inverse, tuple(result[at] for at in sorted(result)), float(worst))


# Groups of states that are coupled weakly, or one way only, decoupled each for itself and then from each other.
#
# Errors of the QR algorithm are relative to the largest entries: of a coupling of 1e-12 it keeps four digits. With the modes V of the
# groups V^-1 S V = D + E, and the entries of E, the couplings, have errors relative to their own block of two groups. Then
# (D + E)(I + X) = (I + X)(D + F) is solved entry by entry (Stewart 1973), F between close rates only and X between all others.


def _by_groups(matrix: Matrix) -> BlockDiagonal | None:
    """Decoupled form by weakly coupled groups; None for one group, or couplings not weak relative to differences of rates."""
    row, column, strong, largest = _coupled_states(matrix)
    if strong.all() and WEAK_COUPLING * largest.max(initial=0.0) <= largest.min(initial=np.inf):
        return None
    joined = scipy.sparse.csr_array((strong[strong], (row[strong], column[strong])), shape=matrix.shape)
    count, which = scipy.sparse.csgraph.connected_components(joined, connection="strong")
    if count == 1:
        return None
    groups, S = [np.flatnonzero(which == group) for group in range(count)], full(matrix)
    parts = [_by_eigenvectors(S[np.ix_(at, at)]) for at in groups]
    if not all(parts):
        return None
    whole, between = assembled(groups, parts), S.copy()
    for at in groups:
        between[np.ix_(at, at)] = 0.0
    turn, back, rates = _complex_modes(whole.blocks)
    separated = _separation(back @ (whole.inverse @ between @ whole.basis) @ turn, rates, len(groups))
    if separated is None:
        return None
    X, D = (turn @ separated[0] @ back).real, (turn @ (separated[1] + np.diag(rates)) @ back).real
    undone = _inverse_of_sum(X)
    if undone is None:
        return None
    clusters = _clusters(whole.blocks, separated[1])
    order = np.concatenate(clusters)
    basis, inverse = (whole.basis + whole.basis @ X)[:, order], (undone @ whole.inverse)[order]
    worst = float((np.abs(basis) * np.abs(inverse.T)).sum(axis=0).max())
    blocks = tuple(_paired(D[np.ix_(at, at)]) for at in clusters)
    return BlockDiagonal(basis, inverse, blocks, worst) if worst <= DECOUPLING_LIMIT else None


def is_weakly_coupled(matrix: Matrix) -> bool:
    """Whether some states of a balanced matrix are weakly coupled."""
    return not _coupled_states(matrix)[2].all()


def _coupled_states(matrix: Matrix) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rows and columns of the entries, which of them are strong, and the largest size in each row.

    What couples a fast state with a slow one moves the rates by its square over the faster rate, and counts relative to that.
    """
    row, column, values = entries(matrix)
    largest, sizes = np.zeros(matrix.shape[0]), np.abs(values)
    np.maximum.at(largest, row, sizes)
    less, more = np.minimum(largest[row], largest[column]), np.maximum(largest[row], largest[column])
    return row, column, sizes > WEAK_COUPLING * np.where(less > WEAK_COUPLING * more, less, more), largest


def _complex_modes(blocks: tuple[np.ndarray, ...]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """U, U^-1 and s with U^-1 diag(blocks) U = diag(s) for blocks [a] and [[a, b], [-b, a]]."""
    turns = [np.array([[1.0, 1.0], [1j, -1j]]) if len(block) == 2 else np.eye(1) for block in blocks]
    rates = [block[0, 0] + 1j * block[0, 1] * np.array([1.0, -1.0]) if len(block) == 2 else block[0] for block in blocks]
    turn = block_diag(*turns)
    return turn, (turn / np.abs(turn).sum(axis=0)).conj().T, np.concatenate(rates)


def _separation(E: np.ndarray, rates: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray] | None:
    """X and F for these groups, None where the couplings are too strong."""
    gaps, sizes = rates - rates[:, None], np.maximum(np.abs(rates), np.abs(rates)[:, None])
    close = np.abs(gaps) * DECOUPLING_LIMIT <= sizes
    gaps[close] = 1.0
    X = F = np.zeros_like(E)
    last = np.inf
    for step in range(SEPARATION_STEPS):
        change = E + E @ X - X @ F
        following = np.where(close, 0.0, change / gaps)
        F = np.where(close, change, 0.0)
        rounding = 4 * EPS * (np.abs(E) + np.abs(E) @ np.abs(X) + np.abs(X) @ np.abs(F)) / np.abs(gaps)
        moved = np.abs(following - X)
        if (moved <= rounding).all():
            return following, F * ((np.abs(F) > EPS / 2 * sizes) | (E != 0))
        if moved.max() > DECOUPLING_LIMIT or (step > count and moved.max() > last / 2):
            return None
        X, last = following, moved.max()
    return None


def _inverse_of_sum(X: np.ndarray) -> np.ndarray | None:
    """(I + X)^-1, with accurate small entries."""
    result, size = np.eye(len(X)), np.abs(X)
    for _ in range(SEPARATION_STEPS):
        following = np.eye(len(X)) - X @ result
        if (np.abs(following - result) <= 4 * EPS * (size @ np.abs(result))).all():
            return following
        result = following
    return None


def _paired(block: np.ndarray) -> np.ndarray:
    """A cluster of pairs [[a, b], [-b, a]] whose couplings agree to rounding errors, without these errors; any other unchanged."""
    pairs = block[0::2, 0::2], block[0::2, 1::2], -block[1::2, 0::2], block[1::2, 1::2]
    if len(block) % 2 or not (np.diag(pairs[0]) == np.diag(pairs[3])).all() or not np.diag(pairs[1]).all():
        return block
    result = block.copy()
    result[1::2, 1::2], result[1::2, 0::2] = pairs[0], -pairs[1]
    return result if np.abs(result - block).max() <= EPS * np.abs(block).max() else block


def _clusters(blocks: tuple[np.ndarray, ...], F: np.ndarray) -> list[np.ndarray]:
    """The modal states in clusters, those of one block and of blocks that F couples together."""
    number = np.repeat(np.arange(len(blocks)), list(map(len, blocks)))
    row, column = F.nonzero()
    joined = scipy.sparse.csr_array((np.ones(len(row)), (number[row], number[column])), shape=(len(blocks),) * 2)
    which = scipy.sparse.csgraph.connected_components(joined, directed=False)[1][number]
    return [np.flatnonzero(which == cluster) for cluster in np.unique(which)]
