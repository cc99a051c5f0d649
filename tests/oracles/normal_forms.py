"""Mechanical normal forms in rational arithmetic: existence by its definition and by its criterion, and systems to try.

Nothing here is shared with the package. By definition a normal form exists where B can be extended to B_e with [B_e, A B_e]
regular. The determinant is a polynomial of the entries of the extension, so that a few random ones settle it; they prove a yes.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

#: Random extensions tried, with entries up to the bound: a wrong no has a probability below (8 / 2000)^4.
TRIES, BOUND = 4, 1000


def rank(rows) -> int:
    """Of integers, by Bareiss's elimination without fractions."""
    M = [[int(entry) for entry in row] for row in rows]
    found, previous = 0, 1
    for column in range(len(M[0]) if M else 0):
        pivot = next((i for i in range(found, len(M)) if M[i][column]), None)
        if pivot is None:
            continue
        M[found], M[pivot] = M[pivot], M[found]
        top = M[found]
        for i in range(found + 1, len(M)):
            row = M[i]
            M[i] = [(top[column] * row[j] - row[column] * top[j]) // previous for j in range(len(row))]
        previous, found = top[column], found + 1
        if found == len(M):
            break
    return found


def exists_by_definition(A, B) -> bool:
    """For integer matrices as arrays of ints or objects: some [B_2, B, A B_2, A B] is regular."""
    A, B = np.array(A, dtype=object), np.array(B, dtype=object)
    n, p = B.shape
    random = np.random.default_rng(0)
    for _ in range(TRIES):
        extended = np.hstack([random.integers(-BOUND, BOUND + 1, (n, n // 2 - p)).astype(object), B])
        if rank(np.hstack([extended, A.dot(extended)])) == n:
            return True
    return False


def exists_by_criterion(A, B) -> bool:
    """rank [B, A B] = 2 p and rank [A - lambda I, B] >= n/2 + p for every integer lambda; other real ones cannot fail alone."""
    A, B = np.array(A, dtype=object), np.array(B, dtype=object)
    n, p = B.shape
    if rank(np.hstack([B, A.dot(B)])) < 2 * p:
        return False
    bound = int(np.abs(A).sum(axis=1).max())
    eigenvalues = np.linalg.eigvals(A.astype(float))
    spread = np.finfo(float).eps ** (1 / n) * (1 + np.abs(A.astype(float)).max()) * n
    near = [k for k in range(-bound, bound + 1) if np.abs(eigenvalues - k).min() <= spread]
    return all(rank(np.hstack([A - k * np.eye(n, dtype=object), B])) >= n // 2 + p for k in near)


def exists_in_the_paper(A, B) -> bool:
    """Theorem 2.1 as printed, for B = e_n and integer A: rank K = 1 and rank G >= n/2 - 1."""
    A = np.array(A, dtype=object)
    n = len(A)
    K = A[:-1, -1:]
    if not K.any():
        return False
    first = np.flatnonzero(K[:, 0])[0]
    length = int((K * K).sum())
    others = np.delete(np.eye(n - 1, dtype=object), first, axis=1)
    complement = length * others - K.dot(K.T.dot(others))  # columns span the complement of K, orthogonal to it
    return rank(complement.T.dot(A[:-1, :-1]).dot(complement)) >= n // 2 - 1


def zero_one_matrix(number: int) -> np.ndarray:
    """The number-th of the 65,536 matrices of size 4 with entries 0 and 1."""
    return np.array([(number >> place) & 1 for place in range(16)], dtype=object).reshape(4, 4)


def matrix_of(text: str) -> np.ndarray:
    """An array of Fractions from "[1 2/3; 0 1]"."""
    rows = text.strip("[]").split(";")
    return np.array([[Fraction(entry) for entry in row.split()] for row in rows], dtype=object)


def jordan(*blocks: tuple[int, int]) -> np.ndarray:
    """The Jordan matrix of blocks (eigenvalue, size)."""
    size = sum(length for _, length in blocks)
    J, at = np.zeros((size, size), dtype=int), 0
    for value, length in blocks:
        J[at : at + length, at : at + length] = value * np.eye(length, dtype=int) + np.eye(length, k=1, dtype=int)
        at += length
    return J


def unimodular(random, n: int, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """An integer matrix S of determinant 1 and its inverse."""
    S, inverse = np.eye(n, dtype=object), np.eye(n, dtype=object)
    for _ in range(steps if n > 1 else 0):
        i, j = random.choice(n, 2, replace=False)
        k = int(random.integers(-1, 2))
        S[i] = S[i] + k * S[j]
        inverse[:, j] = inverse[:, j] - k * inverse[:, i]
    return S, inverse


def random_blocks(random, size: int) -> np.ndarray:
    """A Jordan matrix with few eigenvalues, so that repeated and defective ones are frequent, some of them complex pairs."""
    blocks, left = [], size
    while left:
        length = int(random.integers(1, min(left, 3) + 1)) if random.random() < 0.4 else 1
        blocks.append((int(random.choice([5, 5, 5, 0, -2])), length))
        left -= length
    J = jordan(*blocks)
    if size > 2 and random.random() < 0.2:
        J[-2:, :] = J[:, -2:] = 0
        J[-2, -1], J[-1, -2] = 1, -1
    return J


def random_system(random, n: int, p: int) -> tuple[np.ndarray, np.ndarray]:
    """Integer (A, B): an uncontrollable part of any size with a Jordan structure, coupled, and a dense or sparse rest."""
    uncontrollable = int(random.integers(0, n - p + 1)) if p else n
    A = random.integers(-2, 3, (n, n)) * (random.random((n, n)) < random.choice([0.4, 1.0]))
    at = n - uncontrollable
    A[at:, :at] = 0
    A[at:, at:] = random_blocks(random, uncontrollable) if uncontrollable else 0
    B = np.zeros((n, p), dtype=int)
    while rank(B) < p:
        B[:at] = random.integers(-1, 2, (at, p))
    S, inverse = unimodular(random, n, int(random.choice([0, n, 2 * n])))
    return S.dot(A.astype(object)).dot(inverse), S.dot(B.astype(object))
