"""Products of band matrices against those of full ones."""

from __future__ import annotations

import numpy as np
import pytest

from mbconstrained.linalg.bands import ROWS, banded_product, bandwidth, multiply_in_place, narrow_order

SIZES = (0, 1, 2, ROWS - 1, ROWS, ROWS + 1, 450)


def band_matrix(size: int, below: int, above: int, seed: int = 0) -> np.ndarray:
    full = np.random.default_rng(seed).normal(size=(size, size))
    return np.triu(np.tril(full, above), -below)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("bands", [(0, 0), (1, 1), (2, 0), (0, 5), (40, 30)])
def test_the_product_is_that_of_full_matrices(size, bands):
    left, right = band_matrix(size, *bands, seed=1), band_matrix(size, *bands[::-1], seed=2)
    found = banded_product(left, right, bandwidth(left), bandwidth(right))
    assert np.allclose(found, left @ right, rtol=0, atol=1e-13 * max(bands[0], 1))


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("columns", [0, 1, 7])
def test_a_band_matrix_times_columns(size, columns):
    left, right = band_matrix(size, 3, 1), np.random.default_rng(3).normal(size=(size, columns))
    assert np.allclose(banded_product(left, right, bandwidth(left)), left @ right, rtol=0, atol=1e-14)


@pytest.mark.parametrize("size", SIZES)
def test_a_bandwidth_is_the_farthest_entry_from_the_diagonal(size):
    random = np.random.default_rng(size)
    matrix = np.zeros((size, size))
    places = random.integers(0, max(size, 1), (2, 3))[:, : 3 * (size > 0)]
    matrix[tuple(places)] = 1.0
    assert bandwidth(matrix) == np.abs(places[0] - places[1]).max(initial=0)


def test_entries_on_one_side_only_and_rows_of_zeros():
    matrix = np.zeros((6, 6))
    matrix[4, 1] = 1.0
    assert bandwidth(matrix) == bandwidth(matrix.T) == 3
    assert bandwidth(np.zeros((6, 6))) == 0


def test_the_bands_of_a_product_are_no_wider_than_those_of_its_factors_together():
    left, right = band_matrix(300, 4, 2), band_matrix(300, 1, 6)
    assert bandwidth(banded_product(left, right, 4, 6)) <= 10


@pytest.mark.parametrize("size", [1, 2, 50, 450])
def test_a_shuffled_chain_is_put_in_order(size):
    places = np.random.default_rng(0).permutation(size)
    chain = band_matrix(size, 1, 1)[np.ix_(places, places)]
    order = narrow_order(chain)
    assert sorted(order) == list(range(size))
    assert bandwidth(chain[np.ix_(order, order)]) <= 1


def test_the_order_is_that_of_the_pattern_and_its_transpose():
    one_way = np.diag(np.ones(19), 1)
    places = np.random.default_rng(1).permutation(20)
    shuffled = one_way[np.ix_(places, places)]
    order = narrow_order(shuffled)
    assert bandwidth(shuffled[np.ix_(order, order)]) == 1


@pytest.mark.parametrize("one, other", [(0, 3), (5, 0), (7, 20), (400, 400)])
def test_a_product_takes_the_place_of_its_right_factor(one, other):
    rng, n = np.random.default_rng(4), 300
    away = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    left, right = (np.where(away <= band, rng.standard_normal((n, n)), 0.0) for band in (one, other))
    expected = left @ right
    multiply_in_place(left, right, one, other)
    assert np.allclose(right, expected, rtol=0, atol=1e-12)


def test_a_full_matrix_keeps_its_order():
    assert np.array_equal(narrow_order(np.ones((50, 50))), np.arange(50))
