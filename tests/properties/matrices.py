"""Random regular A(s) = U(s) diag(d_1, ..., d_r) V(s) with U, V unimodular, all coefficients small integers.

The zeros of A(s) are those of the d_i, known exactly; U and V mix them and bring infinite zeros and a singular A_q.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

import mbconstrained as mb
from tests.oracles import exact

LARGEST_ENTRY = 300
LARGEST_PENCIL = 12

real_factors = st.integers(-3, 0).map(lambda zero: ((complex(zero),), (-zero, 1)))
pair_factors = st.tuples(st.integers(-2, 0), st.integers(1, 2)).map(
    lambda z: ((complex(*z), complex(z[0], -z[1])), (z[0] ** 2 + z[1] ** 2, -2 * z[0], 1))
)
factors = st.lists(st.one_of(real_factors, pair_factors), max_size=2)


@dataclass(frozen=True)
class Sample:
    """A(s) with integer coefficients (q + 1, r, r) and its zeros with multiplicities."""

    coefficients: np.ndarray
    zeros: Counter

    def __repr__(self) -> str:
        return f"Sample({self.coefficients.astype(int).tolist()})"

    @property
    def degree(self) -> int:
        return len(self.coefficients) - 1

    @property
    def size(self) -> int:
        return self.coefficients.shape[1]

    @property
    def finite_count(self) -> int:
        return sum(self.zeros.values())

    @cached_property
    def matrix(self) -> mb.PolynomialMatrix:
        return mb.PolynomialMatrix(self.coefficients)

    @cached_property
    def pairs(self) -> mb.JordanPairs:
        return self.matrix.jordan_pairs()

    @cached_property
    def exact(self) -> list:
        """The coefficients as Fractions."""
        return exact.rational(self.coefficients)

    @cached_property
    def orders_at_infinity(self) -> list[int]:
        """q_1 >= ... >= q_r from the degrees of the minors."""
        return exact.orders_at_infinity(self.exact)

    @property
    def highest_impulse(self) -> int:
        """q_hat_r."""
        return max(0, *(-order for order in self.orders_at_infinity))

    @cached_property
    def _laurent(self) -> dict[int, list]:
        return exact.laurent(self.exact, -2 * self.degree - 2)

    def H_exact(self, index: int) -> np.ndarray:
        """H_i for i >= -2 q - 2, by exact long division."""
        nothing = np.zeros((self.size, self.size))
        return np.array(self._laurent.get(index, nothing), float)

    def H(self, index: int) -> np.ndarray:
        """H_i of the package."""
        return self.pairs.laurent(index)


@st.composite
def unimodular(draw, size: int):
    """A product of up to three elementary matrices I + p(s) e_i e_j^T, integer coefficients (k, r, r)."""
    product = np.eye(size, dtype=int)[None]
    for _ in range(draw(st.integers(0, 3)) if size > 1 else 0):
        i, j = draw(st.permutations(range(size)))[:2]
        entry = draw(st.lists(st.integers(-2, 2), min_size=1, max_size=2))
        step = np.zeros((len(entry), size, size), dtype=int)
        step[0] = np.eye(size, dtype=int)
        step[:, i, j] = entry
        product = times(product, step)
    return product


def times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The product of two polynomial matrices given by their coefficients."""
    product = np.zeros((len(a) + len(b) - 1, a.shape[1], b.shape[2]), dtype=a.dtype)
    for i, left in enumerate(a):
        for j, right in enumerate(b):
            product[i + j] += left @ right
    return product


@st.composite
def samples(draw, largest_size: int = 4, least_degree: int = 0, over_declared: bool = True):
    """Sample matrices of size 1 .. largest_size; now and then with a zero A_q declared on top."""
    size = draw(st.integers(1, largest_size))
    zeros: Counter = Counter()
    diagonal = np.zeros((5, size, size), dtype=int)
    for i in range(size):
        polynomial = np.array([1])
        for roots, factor in draw(factors):
            zeros.update(roots)
            polynomial = np.convolve(polynomial, factor)
        diagonal[: len(polynomial), i, i] = polynomial
    A = times(times(draw(unimodular(size)), diagonal), draw(unimodular(size)))
    while len(A) > 1 + least_degree and not A[-1].any():
        A = A[:-1]
    if over_declared and draw(st.integers(0, 9)) == 0:
        A = np.concatenate([A, np.zeros((1, size, size), dtype=int)])
    assume(np.abs(A).max() <= LARGEST_ENTRY and size * (len(A) - 1) <= LARGEST_PENCIL)
    return Sample(A.astype(float), zeros)


def relative(found, known) -> float:
    """Largest difference relative to the largest known entry (or 1)."""
    found, known = np.asarray(found, float), np.asarray(known, float)
    assert found.shape == known.shape
    return float(np.abs(found - known).max(initial=0.0) / max(1.0, np.abs(known).max(initial=0.0)))
