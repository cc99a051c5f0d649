"""Rank decisions: exact zeros against small numbers, rounding against independence, the gap that is told, and the noise that decides."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.linalg.rank import Noisy, compress_rows


def rank(matrix) -> int:
    return compress_rows(Noisy.rounded(np.asarray(matrix, float))).decision.rank


def rotation(size, seed) -> np.ndarray:
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(size, size)))[0]


@pytest.mark.parametrize(
    "matrix, known",
    [
        (np.zeros((0, 0)), 0),
        (np.zeros((3, 0)), 0),
        (np.zeros((2, 3)), 0),
        (np.eye(4), 4),
        (np.diag([1.0, 1e-14]), 2),
        (np.diag([1.0, 1e-300]), 2),
        (np.diag([1.0, 0.0]), 1),
        (np.diag([1e150, 1e-150, 0.0, 1.0]), 3),
        ([[1, 1], [1, 1]], 1),
        ([[1, 1], [1, 1 + 1e-9]], 2),
        ([[1, 2, 3], [2, 4, 6]], 1),
        ([[1], [2], [0]], 1),
        ([[0.1, 0.2, 0.3], [0.3, 0.6, 0.9], [1.0, 0.0, 0.0]], 2),
        ([[1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 2.0, 1.0]], 2),
        ([[1.0, 1e8], [1e-8, 1.0]], 1),
        ([[1.0, 1e8], [1e-8, 2.0]], 2),
    ],
)
def test_rank_of_what_is_written_down(matrix, known):
    assert rank(matrix) == known
    assert rank(np.transpose(matrix)) == known


@given(st.integers(1, 7), st.integers(0, 7), st.integers(0, 10**6))
def test_rank_survives_rotation_and_rounding(size, kept, seed):
    """Q diag(..., 0, ..., 0) Z with singular values between 1/10 and 10, rounded."""
    kept = min(kept, size)
    values = np.zeros(size)
    values[:kept] = 10 ** np.random.default_rng(seed).uniform(-1, 1, kept)
    decision = compress_rows(Noisy.rounded(rotation(size, seed) * values @ rotation(size, seed + 1))).decision
    assert decision.rank == kept


@given(st.integers(2, 6), st.integers(0, 10**6))
def test_rank_does_not_depend_on_the_units_of_rows_and_columns(size, seed):
    random = np.random.default_rng(seed)
    matrix = random.integers(-2, 3, (size, size)).astype(float)
    rows, columns = np.exp2(random.integers(-40, 41, (2, size)))
    assert rank(rows[:, None] * matrix * columns) == rank(matrix) == np.linalg.matrix_rank(matrix)


@given(st.integers(1, 6), st.integers(1, 6), st.integers(0, 10**6))
def test_dependent_rows_are_combined_to_zero(rows, columns, seed):
    """left @ S has independent rows of S first, then nothing but noise; left is regular."""
    matrix = np.random.default_rng(seed).integers(-2, 3, (rows, columns)).astype(float) / 3
    found = compress_rows(Noisy.rounded(matrix))
    k = found.decision.rank
    assert k == np.linalg.matrix_rank(matrix)
    product = Noisy.exact(found.left.data) @ Noisy.exact(matrix)
    assert np.array_equal(product.data[:k], matrix[found.pivots])
    assert np.abs(product.data[k:]).max(initial=0.0) <= 1e-13
    assert np.linalg.matrix_rank(found.left.data) == rows
    assert not k or np.linalg.matrix_rank(matrix[found.pivots]) == k  # NumPy before 2.3 has no rank of nothing


@pytest.mark.parametrize("gap, known, clear", [(0.0, 1, True), (2e-13, 2, False), (1e-9, 2, True)])
def test_decisions_near_the_rounding_are_not_clear(gap, known, clear):
    decision = compress_rows(Noisy.rounded(np.array([[1.0, 1 / 3], [3.0, 1.0 + gap]]))).decision
    assert (decision.rank, decision.clear) == (known, clear)


def test_noise_beyond_the_rounding_is_respected():
    """The same numbers, known to six digits only."""
    matrix = np.array([[1.0, 1 / 3], [3.0, 1.0 + 1e-9]])
    assert compress_rows(Noisy(matrix, 1e-6 * np.abs(matrix))).decision.rank == 1
    assert compress_rows(Noisy.rounded(matrix)).decision.rank == 2


def test_independent_groups_do_not_hide_each_other():
    """A small group beside a large one, each of deficient rank, none connected to the other."""
    small, large = 1e-12 * np.array([[1.0, 2.0], [2.0, 4.0]]), 1e12 * np.array([[3.0, 1.0], [1.0, 5.0]])
    matrix = np.block([[small, np.zeros((2, 2))], [np.zeros((2, 2)), large]])
    assert rank(matrix) == 3


def test_an_entry_that_could_not_have_raised_the_rank_leaves_the_decision_clear():
    """Three columns allow a rank of three, with the entry near its noise and without it; of a square matrix it decides."""
    regular = Noisy(np.array([[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [8e-16, 0.0, 1.0]]), np.full((4, 3), 1e-16))
    decision = compress_rows(regular).decision
    assert decision.rank == 3 and decision.largest_dropped == pytest.approx(0.5)
    assert decision.is_structural and decision.clear and not decision.singular_values
    deciding = compress_rows(Noisy(np.array([[1.0, 0.0], [1.0, 8e-16]]), np.array([[0.0, 0.0], [0.0, 1e-16]]))).decision
    assert deciding.rank == 1 and not deciding.is_structural and not deciding.clear


@given(st.integers(1, 6), st.integers(1, 6), st.integers(0, 10**6))
def test_entries_that_stand_alone_are_decided_as_in_any_other_company(rows, columns, seed):
    """Sparse rows of small whole numbers: the rank of the exact matrix, independent pivot rows, combinations that vanish."""
    random = np.random.default_rng(seed)
    matrix = random.integers(-3, 4, (rows, columns)) * (random.random((rows, columns)) < 0.3) * 1.0
    found, known = compress_rows(Noisy.rounded(matrix)), np.linalg.matrix_rank(matrix)
    assert found.decision.rank == len(found.pivots) == known == np.linalg.matrix_rank(matrix[found.pivots])
    assert np.abs(found.null.data @ matrix).max(initial=0.0) <= 1e-13
    assert np.linalg.matrix_rank(found.left.data) == rows


# Noise.


def rational(array):
    """The array as Fractions with exactly its values."""
    return np.vectorize(Fraction, otypes=[object])(array)


@given(st.integers(0, 10**6), st.integers(1, 5), st.integers(1, 5))
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
