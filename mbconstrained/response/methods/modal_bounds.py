"""Bounds of a sum of modes e^(J t) v in the rows of its blocks: growth, turning, and the response to small changes of J."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...linalg.blocks import block_matrix


@dataclass(frozen=True, eq=False)
class BoundedModes:
    """J and v with the bounds of e^(J t) v. An oscillating pair is one row of the bounds, with the norms of both states.

    Attributes:
        J: block diagonal, shape (N, N).
        starts: the first state of each row of the bounds, shape (K,).
        sizes: |v|, shape (K,), as all below.
        zeros: an eigenvalue, of complex pairs the one above the real axis.
        rates: the largest real part of the block of the row.
        clustered: whether the row belongs to a block of several eigenvalues.
        stretch: |e^(T t)| <= stretch e^(a t) for a pair T alone.
        links: the sizes of the entries of J between rows, shape (K, K).
    """

    J: np.ndarray
    starts: np.ndarray
    sizes: np.ndarray
    zeros: np.ndarray
    rates: np.ndarray
    clustered: np.ndarray
    stretch: np.ndarray
    links: np.ndarray | None

    @classmethod
    def of(cls, blocks: tuple[np.ndarray, ...], v: np.ndarray) -> BoundedModes | None:
        """Bounds of e^(J t) v.

        Args:
            blocks: diagonal blocks of J.
            v: shape (N,).

        Returns:
            The bounds; None where a block is not quasi upper triangular, or has a pair of two real eigenvalues.
        """
        if not blocks:
            return None
        zeros: list[complex] = []
        starts, stretch, of_block, begin = [], [], [], 0
        for number, block in enumerate(blocks):
            entries, row, size = block.tolist(), 0, len(block)
            while row < size:
                a, pair = entries[row][row], row + 1 < size and entries[row + 1][row] != 0.0
                starts.append(begin + row)
                of_block.append(number)
                if not pair:
                    zeros.append(a)
                    stretch.append(1.0)
                else:
                    up, down, half = entries[row][row + 1], entries[row + 1][row], (a - entries[row + 1][row + 1]) / 2
                    square = -up * down - half * half
                    if not square > 0:
                        return None
                    larger = (half * half + (up * up + down * down) / 2) / square  # (s^2 + 1 / s^2) / 2 of singular values s, 1 / s
                    zeros.append(complex(a - half, square**0.5))
                    stretch.append((larger + max(larger * larger - 1, 0.0) ** 0.5) ** 0.5)
                row += 1 + pair
            begin += size
        J, at, first = block_matrix(blocks), np.array(starts), np.array(zeros, dtype=complex)
        rates, clustered, links = first.real, np.zeros(len(at), dtype=bool), None
        if len(at) > len(blocks):
            if any(np.tril(block, -2).any() for block in blocks if len(block) > 2):
                return None
            links = folded(np.triu(J, 1), at, at)
            np.fill_diagonal(links, 0.0)
            counts = np.bincount(of_block)
            clustered, rates = counts[of_block] > 1, rates.copy()
            for joined in np.flatnonzero(counts > 1):
                rates[np.equal(of_block, joined)] = rates[np.equal(of_block, joined)].max()
        sizes = np.hypot.reduceat(np.abs(v), at)
        return cls(J, at, sizes, first, rates, clustered, np.array(stretch), links)

    def spread(self, end: float) -> np.ndarray:
        """Q with |e^(J t)| <= e^(a t) Q for all t <= end."""
        total = term = np.diag(self.stretch)
        if self.clustered.any():
            step = end * (term @ self.links)
            for k in range(1, len(term)):
                term = step @ term / k
                if not term.any():
                    break
                total = total + term
        return total

    def responses(self, E: np.ndarray, Q: np.ndarray, end: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Y, Z, S and X, bounds of motions caused by a term E e^(J t) v.

        By the length of time, or by the difference of the eigenvalues: e^(T t) Y - Y e^(J t) with T Y - Y J = E.

        Args:
            E: shape (k, K), for the first rows.
            Q: as ``spread``.
            end: in s.

        Returns:
            Four arrays of this shape.
        """
        n = len(E)
        distance = np.abs(np.subtract.outer(self.zeros[:n], self.zeros))
        direct = self.stretch[:n, None] * E * self.stretch
        if not self.clustered.any():
            by_time = end * distance < 1
            separate = np.where(by_time, 0.0, direct / distance)
            return separate, separate, by_time * direct, direct
        most, joined, separate = Q[:n, :n] @ E @ Q, self.stretch[:, None] * self.links, direct / distance
        for _ in range(2 * len(joined)):
            more = (direct + joined[:n, :n] @ separate + separate @ joined) / distance
            if np.array_equal(more, separate, equal_nan=True):
                break
            separate = more
        rows, columns = Q[:n, :n] @ separate, separate @ Q
        by_time = ~(rows + columns < end * most)
        return np.where(by_time, 0.0, rows), np.where(by_time, 0.0, columns), by_time * most, most


def folded(matrix: np.ndarray, rows: np.ndarray | None, columns: np.ndarray) -> np.ndarray:
    """Norms of the parts of a matrix."""
    squares = np.add.reduceat(matrix * matrix, columns, axis=1)
    return np.sqrt(squares if rows is None else np.add.reduceat(squares, rows, axis=0))
