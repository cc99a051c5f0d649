"""A real Schur form turned into a block diagonal one, with the condition of the decoupling bounded.

The leading block is decoupled from the rest by a Sylvester equation. Where that would need a transformation
with large entries, the zero nearest to the block is swapped in and it is tried again (Bavely and Stewart
1979). Close or defective zeros therefore end up together in one block, a cluster.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from scipy.linalg import lapack
from scipy.sparse.csgraph import connected_components

from ..ground.tolerances import DECOUPLING_LIMIT
from .arrays import Matrix, compressed
from .precise import of_kind

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
    blocks, worst, begin = [], 0.0, 0
    for at, result in zip(groups, parts):
        end = begin + len(at)
        basis[at, begin:end], inverse[begin:end, at] = result.basis, result.inverse
        blocks, worst, begin = [*blocks, *result.blocks], max(worst, result.coupling), end
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
    """The rows of a square matrix in groups that no entry couples to each other, each ascending.

    >>> [rows.tolist() for rows in coupled_rows(np.array([[1.0, 0, 2], [0, 1, 0], [0, 0, 1]]))]
    [[0, 2], [1]]
    """
    n = len(matrix)
    if n > MANY_ROWS:
        count, which = connected_components(compressed(matrix), directed=False)
        return [np.flatnonzero(which == group) for group in range(count)]
    pattern = matrix != 0
    if n and _reached(pattern | pattern.T).all():  # mostly
        return [np.arange(n)]
    return [rows for rows, _ in coupled(pattern | np.eye(n, dtype=bool))]


def _reached(pattern: np.ndarray) -> np.ndarray:
    """Which rows of a symmetric matrix of bools are connected with the first."""
    reached, before = pattern[0] | (np.arange(len(pattern)) == 0), 0
    while (count := np.count_nonzero(reached)) > before:
        reached, before = reached | pattern[reached].any(axis=0), count
    return reached


def coupled(pattern: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """The connected components of a matrix of bools: rows that share columns, directly or through others, and these columns.

    Rows without any are in none. Sets of columns are kept as the bits of whole numbers.

    >>> [(rows.tolist(), columns.tolist()) for rows, columns in coupled(np.array([[0, 1, 1], [0, 0, 0], [1, 0, 0], [0, 0, 1]]) > 0)]
    [([0, 3], [1, 2]), ([2], [0])]
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
    """The zeros of diagonal blocks, of each complex pair the one above the real axis.

    >>> zeros_of([np.array([[-1.0, 2.0], [-2.0, -1.0]]), np.array([[3.0]])]).tolist()
    [(-1+2j), (3+0j)]
    """
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
