"""Symmetric P(s) = M s^2 + C s + K of few couplings, a chain, a tree, a ring, a ladder or a beam, by its entries."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse
from scipy.sparse import csr_array

from .elimination import WIDEST, couplings, elimination
from .kinds import Matrix, entries
from .multifrontal import Multifrontal

#: What is cut off is near this part of the whole: two halves of a uniform chain would have the same zeros.
PART = 0.45

#: For so few s an order with wider fronts and fewer steps is faster, if it has this many times fewer steps.
FEW, FEWER = 128, 4


@dataclass(frozen=True, eq=False)
class SparseQuadratic:
    """P(s) by the entries of its coefficients.

    Attributes:
        diagonal: of K, C and M, shape (3, N).
        beside: the entries of K, C and M that couple two coordinates, shape (3, E).
        ends: which these are, shape (2, E).
        places: where the coordinates are in what was given, shape (N,).
        narrow: P(s) in the order of least fill.
    """

    diagonal: np.ndarray
    beside: np.ndarray
    ends: np.ndarray
    places: np.ndarray
    narrow: Multifrontal

    @property
    def size(self) -> int:
        """N."""
        return len(self.places)

    @cached_property
    def is_heavy(self) -> np.ndarray:
        """Which coordinates have a mass, shape (N,)."""
        return self.diagonal[2] != 0

    @property
    def zero_count(self) -> int:
        """The degree of det P(s)."""
        return self.size + int(np.count_nonzero(self.is_heavy))

    @cached_property
    def together(self) -> Multifrontal:
        """P(s) in an order of few steps, where there is one."""
        width = 2 * self.narrow.order.width
        order = elimination(self.size, self.ends, 2 * WIDEST, together=width)
        if order is None or FEWER * len(order.rounds) > len(self.narrow.order.rounds):
            return self.narrow
        return Multifrontal(order, self.diagonal, self.beside, self.ends)

    def dense(self) -> np.ndarray:
        """K, C and M, shape (3, N, N)."""
        found, every, (one, other) = np.zeros((3, self.size, self.size)), np.arange(self.size), self.ends
        found[:, every, every] = self.diagonal
        found[:, one, other] = found[:, other, one] = self.beside
        return found

    def newton(self, s: np.ndarray) -> np.ndarray:
        """p'(s) / p(s) where p = det P, shape as s."""
        return (self.narrow if len(s) > FEW else self.together).newton(s)

    def applied(self, s: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """P(s) x, C x and M x of a vector x for each s, shape (N, S).

        Where it costs nothing P(s) x is a sum of differences of neighbours, in which nothing large cancels.
        """
        of_each, of_differences = self._parts
        apart = x[self.ends[1]] - x[self.ends[0]]
        stiff, damped, damping, inertia = (of_each @ x.view(float)).view(x.dtype).reshape(4, *x.shape)
        more_stiff, more_damped = (of_differences @ apart.view(float)).view(x.dtype).reshape(2, *x.shape)
        return stiff + more_stiff + s * (damped + more_damped) + s * s * inertia, damping, inertia

    def kept_digits(self, x: np.ndarray) -> float:
        """x^T K x by the sum of the sizes of its terms as ``applied`` has them, x of shape (N, 1)."""
        (of_each, of_differences), n = self._parts, self.size
        terms = np.abs(of_each[:n]) @ np.abs(x) + np.abs(of_differences[:n]) @ np.abs(x[self.ends[1]] - x[self.ends[0]])
        return float(np.abs((x * self.applied(np.zeros(1), x)[0]).sum()) / (np.abs(x) * terms).sum())

    @cached_property
    def _parts(self) -> tuple[csr_array, csr_array]:
        """For x parts of K and C and all of C and M, shape (4 N, N), for differences of x at two ends the rest, (2 N, E).

        Rows are sums of differences where their entries beside the diagonal are not the larger ones: else units of neighbours differ.
        """
        n, (one, other), every = self.size, self.ends, np.arange(self.size)
        rows, columns, each = np.concatenate([every, one, other]), np.concatenate([every, other, one]), np.arange(len(one))
        whole = [csr_array((line, (rows, columns)), shape=(n, n)) for line in np.hstack([self.diagonal, self.beside, self.beside])]
        of_each, of_differences = [], []
        for matrix, diagonal, beside in zip(whole[:2], self.diagonal, self.beside):
            both = np.concatenate([beside, beside])
            near = np.bincount(rows[n:], np.abs(both), n) <= 2 * np.abs(diagonal)
            sums = diagonal.astype(np.longdouble)
            np.add.at(sums, rows[n:], both)
            of_each.append(_scaled_rows(1.0 - near, matrix) + _diagonal(near * sums.astype(float)))
            signed = np.concatenate([beside, -beside]) * near[rows[n:]]
            of_differences.append(csr_array((signed, (rows[n:], np.concatenate([each, each]))), shape=(n, len(each))))
        return (_without_zeros([*of_each, *whole[1:]]), _without_zeros(of_differences))

    def halves(self) -> tuple[SparseQuadratic, SparseQuadratic]:
        """What is eliminated because of one coordinate, and all else, the couplings of both taken out: their ends are held."""
        below = np.zeros(self.size, dtype=bool)
        below[self.narrow.order.subtree(PART)] = True
        return self._part(below), self._part(~below)

    def _part(self, chosen: np.ndarray) -> SparseQuadratic:
        kept, number = chosen[self.ends].all(axis=0), np.cumsum(chosen) - 1
        return _sparse_quadratic(self.diagonal[:, chosen], self.beside[:, kept], number[self.ends[:, kept]], self.places[chosen])


def sparse_quadratic(M: Matrix, C: Matrix, K: Matrix) -> SparseQuadratic | None:
    """From symmetric matrices, M of the first coordinates only; None where a front is wider than ``WIDEST``."""
    size, ends, found = K.shape[0], couplings(M, C, K), [entries(matrix) for matrix in (K, C, M)]
    if ends.shape[1] > WIDEST * size:
        return None
    diagonal, beside, pairs = np.zeros((3, size)), np.zeros((3, ends.shape[1])), ends[0] * size + ends[1]
    for on, couple, (row, column, values) in zip(diagonal, beside, found):
        own, above = row == column, row < column
        on[row[own]] = values[own]
        couple[np.searchsorted(pairs, row[above].astype(np.int64) * size + column[above])] = values[above]
    return _sparse_quadratic(diagonal, beside, ends, np.arange(size))


def _sparse_quadratic(diagonal, beside, ends, places) -> SparseQuadratic | None:
    order = elimination(len(places), ends)
    return None if order is None else SparseQuadratic(diagonal, beside, ends, places, Multifrontal(order, diagonal, beside, ends))


def _diagonal(entries: np.ndarray) -> csr_array:
    return csr_array(scipy.sparse.diags_array(entries))


def _scaled_rows(factors: np.ndarray, matrix: csr_array) -> csr_array:
    return csr_array(_diagonal(factors) @ matrix)


def _without_zeros(parts: list[csr_array]) -> csr_array:
    found = csr_array(scipy.sparse.vstack(parts, format="csr"))
    found.eliminate_zeros()
    return found
