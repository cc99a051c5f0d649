"""Products and quotients with twice the digits against fractions."""

from fractions import Fraction

import numpy as np
import pytest

from mbconstrained.linalg.division import PRODUCT_ERROR, accurate_product, accurately_solved

EPS = np.finfo(float).eps


def fractions(matrix: np.ndarray) -> np.ndarray:
    """The same numbers, exactly."""
    return np.array([Fraction(value) for value in matrix.ravel().tolist()], dtype=object).reshape(matrix.shape)


@pytest.mark.parametrize("shape", [(0, 3, 2), (3, 0, 2), (1, 1, 1), (7, 12, 5)])
def test_a_product_and_what_it_is_rounded_by_add_up(shape):
    random = np.random.default_rng(0)
    A, B = random.normal(size=shape[:2]), random.normal(size=shape[1:])
    high, low = accurate_product(A, B)
    exact = fractions(A) @ fractions(B) if shape[1] else np.zeros(high.shape)
    errors = fractions(high) + fractions(low) - exact
    sizes = np.multiply.outer(np.abs(A).max(axis=1, initial=0.0), np.abs(B).max(axis=0, initial=0.0))
    assert (np.abs(errors.astype(float)) <= shape[1] * PRODUCT_ERROR * sizes).all()


def solved_exactly(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """A^-1 B by elimination in fractions."""
    n, work = len(A), np.hstack([fractions(A), fractions(B)])
    for k in range(n):
        pivot = next(i for i in range(k, n) if work[i, k])
        work[[k, pivot]] = work[[pivot, k]]
        work[k] = work[k] / work[k, k]
        for i in range(n):
            if i != k:
                work[i] = work[i] - work[i, k] * work[k]
    return work[:, n:]


@pytest.mark.parametrize("spread", [0, 8])
def test_entries_that_cancel_keep_their_digits(spread):
    """B = A X rounded, X with entries down to 1e-20 and zeros: in its quotient some are differences of nearly equal terms."""
    random = np.random.default_rng(1)
    A = random.integers(-9, 9, size=(6, 6)) + 20.0 * np.eye(6)
    X = np.where(random.random((6, 5)) < 0.5, 1.0, 2.0**-60) * (random.random((6, 5)) < 0.8)
    units = 2.0 ** random.integers(-spread, spread + 1, 6)
    A = A * units / units[:, None]
    B = A @ X
    exact, found = solved_exactly(A, B), accurately_solved(A, B)
    zero = exact == 0
    assert (found[zero] == 0).all()
    assert max(abs(Fraction(f) / e - 1) for f, e in zip(found[~zero].tolist(), exact[~zero])) <= 16 * EPS
