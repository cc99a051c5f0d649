"""Which equation belongs to which coordinate, against all orders there are and against SciPy's matching of sparse matrices."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from mbconstrained.polynomial.direct_reduction import matching_rows


def unlike(seed: int, size: int, part: float = 0.6) -> np.ndarray:
    """A matrix of sizes far apart, that is not symmetric, with so many of its entries."""
    random = np.random.default_rng(seed)
    return np.exp(random.normal(0, 3, (size, size))) * random.choice([-1, 1], (size, size)) * (random.random((size, size)) < part)


def product_of(M: np.ndarray, rows) -> float:
    return float(np.abs(M[np.asarray(rows), np.arange(len(M))]).prod())


@pytest.mark.parametrize("seed", range(40))
def test_no_order_of_few_rows_has_a_larger_product_on_the_diagonal(seed):
    M = unlike(seed, 2 + seed % 4)
    best = max(product_of(M, rows) for rows in permutations(range(len(M))))
    found = matching_rows(M)
    if not best:
        assert found is None or np.array_equal(M, M.T)  # what is symmetric stays as it is
    else:
        assert sorted(found) == list(range(len(M))) and np.isclose(product_of(M, found), best, rtol=1e-12)


def test_an_order_of_named_equations_is_found_back():
    order = np.array([2, 0, 3, 1])
    M = (np.diag([5.0, 3.0, 8.0, 2.0]) + np.eye(4, k=1))[order]
    assert (M[matching_rows(M)].diagonal() == [5, 3, 8, 2]).all()
