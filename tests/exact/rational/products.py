"""Matrices for exact tests: named ones, and random A(s) = U(s) diag(d_1, ..., d_r) V(s), all known as Fractions.

Everything here is arithmetic of Fractions in numpy object arrays: nothing is shared with the package.
"""

from fractions import Fraction
from functools import cache

import numpy as np

import mbconstrained as mb
from tests.oracles.models import massless_joints, rigid_link, two_masses, two_masses_with_multiplier

#: Lowest power first: rational zeros, quadratic and cubic factors without one, and no zero at all.
FACTORS = [(1,), (0, 1), (0, 1), (1, 1), (-2, 1), (1, 2), (1, 0, 1), (1, 1, 1), (-2, 0, 1), (2, 0, 0, 1)]


def product(seed: int) -> np.ndarray:
    """Coefficients (q + 1, r, r) of a random product; every third one is declared a power too high."""
    random = np.random.default_rng(seed)
    size = 1 + seed % 4
    A = _unimodular(random, size)
    repeated = random.choice(len(FACTORS), 2)
    diagonal = [_polynomial_product([FACTORS[k] for k in random.choice(repeated, random.integers(0, 3))]) for _ in range(size)]
    A = times(A, _diagonal(diagonal))
    A = times(A, _unimodular(random, size))
    while len(A) > 1 and not A[-1].any():
        A = A[:-1]
    return np.concatenate([A, np.zeros((1, size, size))]) if seed % 3 == 0 else A


def larger_product(seed: int, size: int = 9) -> tuple[np.ndarray, dict[tuple, tuple[int, ...]]]:
    """Coefficients, and the exponents of the irreducible factors by construction."""
    random = np.random.default_rng(seed)
    exponents = {factor: random.choice(4, size, p=[0.5, 0.2, 0.2, 0.1]) for factor in [(0, 1), (1, 1), (2, 2, 1), (-2, 0, 0, 1)]}
    diagonal = [_polynomial_product([p for p, given in exponents.items() for _ in range(given[i])]) for i in range(size)]
    A = times(times(_unimodular(random, size, 8), _diagonal(diagonal)), _unimodular(random, size, 8))
    return A, {p: tuple(sorted(int(k) for k in given if k)) for p, given in exponents.items()}


def _unimodular(random, size: int, steps: int = 3) -> np.ndarray:
    A = np.eye(size)[None]
    for _ in range(steps if size > 1 else 0):
        i, j = random.permutation(size)[:2]
        step = np.zeros((2, size, size))
        step[0] = np.eye(size)
        step[:, i, j] = random.integers(-2, 3, 2)
        A = times(A, step)
    return A


def _diagonal(polynomials) -> np.ndarray:
    A = np.zeros((max(map(len, polynomials)), len(polynomials), len(polynomials)))
    for i, p in enumerate(polynomials):
        A[: len(p), i, i] = p
    return A


def _polynomial_product(factors) -> np.ndarray:
    p = np.ones(1)
    for factor in factors:
        p = np.convolve(p, factor)
    return p


def times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The product of two polynomial matrices given by their coefficients."""
    found = np.zeros((len(a) + len(b) - 1, a.shape[1], b.shape[2]))
    for i, left in enumerate(a):
        for j, right in enumerate(b):
            found[i + j] += left @ right
    return found


def _named() -> dict[str, np.ndarray]:
    nilpotent = np.array([np.eye(5), np.eye(5, k=1)])
    random = np.random.default_rng(0)
    loose = random.normal(size=(3, 4, 4))
    loose[2, 2:] = 0.0  # a singular leading matrix of floats that are no short fractions
    return {
        "size 1": np.array([[[2.0]], [[3.0]], [[1.0]]]),
        "degree 0": np.array([[[2.0, 1.0], [1.0, 1.0]]]),
        "degree 0 declared 2": np.array([[[2.0, 1.0], [1.0, 1.0]], np.zeros((2, 2)), np.zeros((2, 2))]),
        "integrator": np.array([np.zeros((2, 2)), np.zeros((2, 2)), np.eye(2)]),
        "impulses of order 4": nilpotent,
        "repeated pair": np.array([np.eye(2), np.zeros((2, 2)), np.eye(2)]),
        "chain of pairs": np.array([[[1.0, 1], [0, 1]], np.zeros((2, 2)), np.eye(2)]),
        "two masses, position": two_masses(0),
        "two masses, velocity": two_masses(1),
        "two masses, acceleration": two_masses(2),
        "two masses with multiplier": two_masses_with_multiplier(0),
        "massless joints": massless_joints(),
        "rigid link": rigid_link(),
        "floats": loose,
    }


MATRICES = {**_named(), **{f"product {seed}": product(seed) for seed in range(24)}}


class Known:
    """A matrix, its coefficients as Fractions, its exact pairs and structure."""

    def __init__(self, coefficients: np.ndarray):
        self.matrix = mb.PolynomialMatrix(coefficients)
        self.pairs = mb.exact.jordan_pairs(self.matrix)
        self.A = np.array([[[Fraction(float(c)) for c in row] for row in matrix] for matrix in coefficients], dtype=object)
        self.q, self.r = len(self.A) - 1, self.A.shape[1]
        self.structure = self.pairs.structure


@cache
def known(name: str) -> Known:
    """The matrix with this name."""
    return Known(MATRICES[name])
