"""Exact questions about float64 matrices, answered in the integers modulo a prime: fast, and wrong with a chance of 1e-8.

Floats are fractions with powers of two below, so they have images modulo an odd prime, and what is zero stays zero there.
What is not zero is taken for zero only if the prime happens to divide it.
"""

from __future__ import annotations

import numpy as np

#: The largest prime below 2^27: sums of 2^9 products of two remainders are int64 numbers.
PRIME = 2**27 - 39


def chains_at_zero(E: np.ndarray, F: np.ndarray) -> int:
    """How often s = 0 is a zero of det(s E - F), regular and of shape (n, n), whole numbers, floats or Fractions taken exactly.

    The vectors that begin chains F v_1 = 0, F v_2 = E v_1, ... span a space of that dimension (Wong 1974).

    >>> chains_at_zero(np.eye(2), np.array([[1e15, -1e15], [-1e15, 1e15]]))
    1
    >>> chains_at_zero(np.eye(2), np.array([[1e15 + 2, -1e15], [-1e15, 1e15]]))
    0
    """
    E, F = remainders(E), remainders(F)
    n, found = len(F), np.zeros((len(F), 0), dtype=np.int64)
    while True:
        null = null_space(np.hstack([F, -(E @ found) % PRIME]))
        reduced, pivots = reduced_rows(null[:n].T)
        if len(pivots) == found.shape[1]:
            return len(pivots)
        found = reduced[: len(pivots)].T


def remainders(matrix: np.ndarray) -> np.ndarray:
    """The entries, whole numbers, floats or Fractions of floats, modulo the prime, from 0 on."""
    ratios = [value.as_integer_ratio() for value in np.asarray(matrix).ravel().tolist()]
    found = [numerator * pow(denominator, -1, PRIME) % PRIME for numerator, denominator in ratios]
    return np.array(found, dtype=np.int64).reshape(np.shape(matrix))


def null_space(matrix: np.ndarray) -> np.ndarray:
    """Columns that span the null space, modulo the prime."""
    reduced, pivots = reduced_rows(matrix)
    columns = matrix.shape[1]
    free = np.setdiff1d(np.arange(columns), pivots)
    null = np.zeros((columns, len(free)), dtype=np.int64)
    null[free, np.arange(len(free))] = 1
    null[pivots] = -reduced[: len(pivots)][:, free] % PRIME
    return null


def reduced_rows(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The reduced row echelon form modulo the prime, and its pivot columns."""
    work, pivots = matrix.copy(), []
    for column in range(work.shape[1]):
        rank = len(pivots)
        below = np.flatnonzero(work[rank:, column])
        if not below.size:
            continue
        work[[rank, rank + below[0]]] = work[[rank + below[0], rank]]
        work[rank] = work[rank] * pow(int(work[rank, column]), -1, PRIME) % PRIME
        factors = work[:, column].copy()
        factors[rank] = 0
        work = (work - np.multiply.outer(factors, work[rank])) % PRIME
        pivots.append(column)
    return work, np.array(pivots, dtype=int)
