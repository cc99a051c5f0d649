"""Zeros of a reduced A(s) once more from its equations, where those of S = M^-1 K ... have lost what cancels in them.

A slow motion of a chain has neighbours that move alike: K x is a small difference of large terms, and rounding errors of S move its
zero by as much as that of the stiffest ones. With the vectors x and u of a zero s, found from S, one step of Newton's method on

u^T P(s) x = 0,  P(s) = M s^2 + C s + K,        s - u^T P(s) x / (u^T P'(s) x)

has an error of the second order in theirs (Lancaster 1961, the generalized Rayleigh quotient), if P(s) x keeps its digits: each
row is summed as (sum of its entries) x_i + sum over j of K_ij (x_j - x_i), in which nothing large cancels.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_array

from ..ground.tolerances import EPS, SIMILAR_EIGENVALUES
from ..linalg.accurate_products import exact_row_sums
from ..linalg.arrays import Matrix, entries
from ..linalg.blocks import BlockDiagonal, block_slices, zeros_of
from ..linalg.division import solved

if TYPE_CHECKING:
    from .reduced_equations import Reduction

#: A matrix of fewer rows is not sparse.
FEW = 48

#: So many zeros are refined at once.
CHUNK = 32


def refined(reduction: Reduction, parts: BlockDiagonal) -> BlockDiagonal:
    """The same with single zeros and pairs [[a, b], [-b, a]] refined; clusters stay as they are."""
    blocks = list(parts.blocks)
    count = len(blocks) - parts.exact_blocks
    moduli = np.abs(zeros_of(blocks[:count]))
    if SIMILAR_EIGENVALUES * moduli.min(initial=np.inf, where=moduli > 0) >= moduli.max(initial=0.0):
        return parts
    largest, places = max(np.abs(block).max() for block in blocks), block_slices(blocks)
    correction = _correction(reduction)
    for chosen in _chunks([i for i, block in enumerate(blocks[:count]) if _is_single(block)]):
        zeros, right, left = _vectors(parts, [blocks[i] for i in chosen], [places[i] for i in chosen])
        change = correction(zeros, right, left)
        change[~(np.abs(change) <= EPS**0.5 * largest)] = 0.0  # no refinement of what was wrong
        for i, zero in zip(chosen, zeros + change):
            a, b = zero.real, zero.imag
            blocks[i] = np.array([[a, b], [-b, a]]) if len(blocks[i]) == 2 else np.array([[a]])
    return replace(parts, blocks=tuple(blocks))


def _is_single(block: np.ndarray) -> bool:
    """Whether it is a real zero, other than 0 itself, or a pair in the form [[a, b], [-b, a]]."""
    if len(block) == 1:
        return bool(block[0, 0])
    return len(block) == 2 and block[0, 0] == block[1, 1] and block[0, 1] == -block[1, 0]


def _chunks(numbers: list[int]) -> Iterator[list[int]]:
    for begin in range(0, len(numbers), CHUNK):
        yield numbers[begin : begin + CHUNK]


def _vectors(parts: BlockDiagonal, blocks, places) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The zeros s above the real axis or on it with S x = s x, shape (n, k), and y S = s y, shape (k, n), y x = 1."""
    begin = np.array([place.start for place in places])
    pair = np.array([len(block) == 2 for block in blocks])
    second = begin + pair
    zeros = np.array([block[0, -1] * 1j * (len(block) == 2) + block[0, 0] for block in blocks])
    right = parts.basis[:, begin] + 1j * pair * parts.basis[:, second]
    left = np.where(pair[:, None], (parts.inverse[begin] - 1j * parts.inverse[second]) / 2, parts.inverse[begin])
    return zeros, right, left


def _correction(reduction: Reduction) -> Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]:
    """By how much zeros change, from them and their vectors in the states (x_m, x_m', x_d)."""
    m, C = len(reduction.second), reduction.C
    damped, stiff = _Differences(C), _Differences(reduction.K)
    first, mass = C[m:, m:].T, reduction.M.T

    def correction(zeros, right, left) -> np.ndarray:
        x = np.vstack([right[:m], right[2 * m :]])
        u = solved(mass, left[:, m : 2 * m].T)
        if first.shape[0]:
            u = np.vstack([u, solved(first, left[:, 2 * m :].T - C[:m, m:].T @ u)])
        inertia = reduction.M @ x[:m]
        residual = zeros * damped(x) + stiff(x)
        residual[:m] += zeros**2 * inertia
        slope = C @ x
        slope[:m] += 2 * zeros * inertia
        return -np.einsum("ik,ik->k", u, residual) / np.einsum("ik,ik->k", u, slope)

    return correction


class _Differences:
    """A square matrix times vectors by differences of their entries, where these are the smaller terms: units may differ."""

    def __init__(self, matrix: Matrix):
        self.matrix = matrix
        row, column, values = entries(matrix)
        beyond = row != column
        self.row, self.column = row[beyond], column[beyond]
        shape = matrix.shape[0], len(self.row)
        if shape[0] < FEW:
            self.factors: Matrix = np.zeros(shape)
            self.factors[self.row, range(shape[1])] = values[beyond]
        else:
            self.factors = csr_array((values[beyond], (self.row, np.arange(shape[1]))), shape=shape)
        self.sums = exact_row_sums(matrix)

    def __call__(self, x: np.ndarray) -> np.ndarray:
        relative, size = x[self.column] - x[self.row], np.abs(x)
        differences = np.abs(self.sums)[:, None] * size + abs(self.factors) @ np.abs(relative)
        less = differences < abs(self.matrix) @ size
        return np.where(less, self.sums[:, None] * x + self.factors @ relative, self.matrix @ x)
