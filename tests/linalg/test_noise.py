"""Carried noise bounds what rounding really does, and what is exact stays exact."""

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.linalg.precise import precise, precise_arithmetic
from mbconstrained.linalg.rank import Noisy

seeds = st.integers(0, 10**6)


def rational(array):
    """The array as Fractions with exactly its values."""
    return np.vectorize(Fraction, otypes=[object])(array)


@given(seeds, st.integers(1, 5), st.integers(1, 5))
def test_noise_of_products_bounds_their_rounding(seed, rows, columns):
    """|computed - exact| <= noise times a small factor, for a chain of products of thirds, entry by entry."""
    random = np.random.default_rng(seed)
    A, B, C = (random.integers(-9, 10, shape) / 3 for shape in [(rows, 4), (4, columns), (columns, 3)])
    found = Noisy.rounded(A) @ Noisy.rounded(B) @ Noisy.rounded(C)
    exact = rational(np.round(3 * A)) @ rational(np.round(3 * B)) @ rational(np.round(3 * C)) / 27
    error = np.abs(rational(found.data) - exact).astype(float)
    assert (error <= 4 * found.noise).all()


def test_a_difference_that_should_be_zero_is_cleaned_to_zero():
    """0.1 + 0.2 - 0.3."""
    total = Noisy.rounded(np.array([[0.1, 0.2, 0.3]])) @ Noisy.exact(np.array([[1.0], [1.0], [-1.0]]))
    assert total.data[0, 0] != 0
    assert total.cleaned().tolist() == [[0.0]]


def test_a_small_number_that_is_known_is_kept():
    product = Noisy.rounded(np.array([[1e-30, 0.0]])) @ Noisy.exact(np.eye(2))
    assert product.cleaned().tolist() == [[1e-30, 0.0]]


def test_cleaning_rounds_nothing_away_outside_of_precise_arithmetic():
    with precise_arithmetic():
        third = precise(np.array([Fraction(1, 3), Fraction(1, 7)]))
    kept = Noisy(third, np.array([0.0, 1.0])).cleaned()
    assert kept[0] == third[0] and kept[1] == 0


def test_a_product_with_one_term_in_each_sum_has_the_noise_of_its_factors_alone():
    """A permutation with factors: one product each, whose rounding is part of what its factors are wrong by."""
    left, right = Noisy.exact(np.array([[0.0, 3.0], [0.1, 0.0]])), Noisy.exact(np.array([[0.7, 0.0], [0.0, 0.3]]))
    assert not (left @ right).noise.any()
    assert (left @ Noisy.exact(np.ones((2, 1)))).noise.tolist() == [[0.0], [0.0]]
    assert (Noisy.exact(np.ones((1, 2))) @ right).noise.tolist() == [[0.0, 0.0]]
    assert (Noisy.exact(np.ones((1, 2))) @ Noisy.exact(np.full((2, 1), 0.1))).noise[0, 0] > 0
