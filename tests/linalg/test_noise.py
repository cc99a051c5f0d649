"""Carried noise bounds what rounding really does, and what is exact stays exact."""

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

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
