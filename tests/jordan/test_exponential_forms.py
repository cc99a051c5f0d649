"""The three formulas for e^{J t} against the exponential in fifty digits, each other, the engine, and its laws."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from scipy.linalg import block_diag

import mbconstrained as mb
from mbconstrained.jordan.exponential_forms import (
    exponential_by_blocks,
    exponential_by_interpolation,
    exponential_of_jordan_block,
    exponential_of_real_jordan_block,
)
from mbconstrained.linalg.exponential import block_states

# (zero, sizes of its Jordan blocks) of each; derogatory: more than one block for a zero
STRUCTURES = [
    [(-1.0, (1,))],
    [(0.0, (1, 1))],
    [(0.0, (3,))],
    [(0.0, (1, 3)), (-2.0, (2, 2))],
    [(-0.5, (4,)), (1.0, (1,))],
    [(complex(-1, 2), (2,)), (complex(-1, -2), (2,))],
    [(0.0, (2,)), (3j, (1, 2)), (-3j, (1, 2)), (-1.0, (1, 1, 1))],
]
TIMES = (0.0, 0.3, 1.7)


def jordan_block(zero, size):
    return zero * np.eye(size) + np.eye(size, k=1)


def collected(structure):
    """J_i with all blocks of a zero, for each zero."""
    return [block_diag(*[jordan_block(zero, size) for size in sizes]) for zero, sizes in structure]


def known(J, t) -> np.ndarray:
    """e^{J t} by mpmath, independent of the package."""
    with mpmath.workdps(50):
        value = mpmath.expm(mpmath.matrix(J.tolist()) * mpmath.mpf(t), method="taylor")
    return np.array([[complex(value[i, j]) for j in range(len(J))] for i in range(len(J))])


def by_lemma_2_11(structure, t):
    return block_diag(*[exponential_of_jordan_block(zero, size, t) for zero, sizes in structure for size in sizes])


def by_lemma_2_12(structure, t):
    return exponential_by_interpolation(block_diag(*collected(structure)), {zero: max(sizes) for zero, sizes in structure}, t)


def by_lemma_2_13(structure, t):
    zeros, sizes = zip(*structure, strict=True)
    return exponential_by_blocks(collected(structure), zeros, [max(s) for s in sizes], t)


formulas = pytest.mark.parametrize("formula", [by_lemma_2_11, by_lemma_2_12, by_lemma_2_13])
structures = pytest.mark.parametrize("structure", STRUCTURES)


@formulas
@structures
@pytest.mark.parametrize("t", TIMES)
def test_each_is_the_exponential(formula, structure, t):
    np.testing.assert_allclose(formula(structure, t), known(block_diag(*collected(structure)), t), rtol=0, atol=1e-11)


@formulas
@structures
def test_a_longer_time_is_the_product_of_two(formula, structure):
    np.testing.assert_allclose(formula(structure, 0.9), formula(structure, 0.5) @ formula(structure, 0.4), rtol=0, atol=1e-11)


@formulas
@structures
def test_its_derivative_is_j_times_itself(formula, structure):
    """By Richardson's central difference, exact to h^4."""
    J, t, h = block_diag(*collected(structure)), 0.6, 1e-3
    one, two = (formula(structure, t + k * h) - formula(structure, t - k * h) for k in (1, 2))
    np.testing.assert_allclose((8 * one - two) / (12 * h), J @ formula(structure, t), rtol=0, atol=1e-8)


@pytest.mark.parametrize(("a", "b", "size"), [(-1.0, 2.0, 1), (-1.0, 2.0, 3), (0.0, 3.0, 2), (0.5, 1.0, 4)])
@pytest.mark.parametrize("t", TIMES)
def test_a_real_block_of_a_pair(a, b, size, t):
    D = np.array([[a, b], [-b, a]])
    J = np.kron(np.eye(size), D) + np.kron(np.eye(size, k=1), np.eye(2))
    found = exponential_of_real_jordan_block(a, b, size, t)
    np.testing.assert_allclose(found, known(J, t).real, rtol=0, atol=1e-13)
    pair = {complex(a, b): size, complex(a, -b): size}
    np.testing.assert_allclose(exponential_by_interpolation(J, pair, t), found, rtol=0, atol=1e-11)
    engine = np.stack([block_states([J], column, np.array([t]))[:, 0] for column in np.eye(2 * size)], axis=1)
    np.testing.assert_allclose(engine, found, rtol=0, atol=1e-13)


def test_interpolation_needs_no_jordan_form():
    """A companion matrix of (s + 1)^2 (s + 2)."""
    J = np.array([[0.0, 1, 0], [0, 0, 1], [-2, -5, -4]])
    np.testing.assert_allclose(exponential_by_interpolation(J, {-1.0: 2, -2.0: 1}, 1.5), known(J, 1.5).real, atol=1e-13)


def test_close_zeros_break_the_interpolation_but_not_the_engine():
    """The reason for the engine's own way: at a distance of 1e-7 the Vandermonde system loses more than half of the digits."""
    J = np.diag([-1.0, -1.0 - 1e-7, -1.0 - 2e-7]) + np.eye(3, k=1)
    true = known(J, 1.0).real
    lost = exponential_by_interpolation(J, {value: 1 for value in np.diag(J)}, 1.0)
    engine = np.stack([block_states([J], column, np.array([1.0]))[:, 0] for column in np.eye(3)], axis=1)
    assert np.abs(lost - true).max() > 1e-8
    assert np.abs(engine - true).max() < 1e-14


def test_what_is_asked_is_checked():
    with pytest.raises(mb.InputError, match="exponent of 1.0: found 0; expected a whole number of at least 1"):
        exponential_by_interpolation(np.eye(2), {1.0: 0}, 1.0)
    with pytest.raises(mb.InputError, match="one zero and one exponent"):
        exponential_by_blocks([np.eye(1), np.eye(1)], [1.0, 1.0], [1, 1], 1.0)


@pytest.mark.parametrize(
    "ask",
    [
        lambda: exponential_of_jordan_block(800.0, 2, 1.0),
        lambda: exponential_of_jordan_block(-1e308, 3, 1e200),
        lambda: exponential_of_real_jordan_block(800.0, 1.0, 2, 1.0),
        lambda: exponential_of_real_jordan_block(1.0, 1e308, 1, 1e308),
        lambda: exponential_by_interpolation(np.eye(2), {800.0: 2}, 1.0),
        lambda: exponential_by_blocks([np.eye(2)], [800.0], [2], 1.0),
    ],
)
def test_what_leaves_the_range_is_told(ask):
    with pytest.raises(mb.Overflow, match=r"e\^\(J t\) at t = .* beyond the range of float64"):
        ask()


@pytest.mark.parametrize(
    ("ask", "text"),
    [
        (lambda: exponential_of_jordan_block("a", 2, 1.0), "zero: found 'a'; expected a finite number"),
        (lambda: exponential_of_jordan_block(np.nan, 2, 1.0), "zero: found nan; expected a finite number"),
        (lambda: exponential_of_jordan_block(1.0, -1, 1.0), "size: found -1; expected a whole number"),
        (lambda: exponential_of_jordan_block(1.0, 2, np.nan), "t: found nan; expected a finite number"),
        (lambda: exponential_of_real_jordan_block(1.0, "a", 2, 1.0), "imaginary: found 'a'; expected numbers"),
        (lambda: exponential_by_interpolation(np.eye(2), {1.0: "a"}, 1.0), "exponent of 1.0: found 'a'; expected a whole number"),
        (lambda: exponential_by_interpolation(np.eye(2), {1.0: 1.5}, 1.0), "exponent of 1.0: found 1.5; expected a whole number"),
        (lambda: exponential_by_interpolation(np.eye(2), {"a": 1}, 1.0), "zero: found 'a'"),
        (lambda: exponential_by_interpolation(np.eye(2), 3, 1.0), "exponents: found 3"),
        (lambda: exponential_by_interpolation(np.ones((2, 3)), {1.0: 1}, 1.0), r"J: found .* shape \(2, 3\); expected square"),
        (lambda: exponential_by_blocks([np.eye(1)], [[1.0]], [1], 1.0), r"zeros: found \[1.0\]"),
        (lambda: exponential_by_blocks([np.eye(1)], [1.0], ["a"], 1.0), "exponent of 1.0: found 'a'"),
        (lambda: exponential_by_blocks(3, [1.0], [1], 1.0), "expected three lists"),
    ],
)
def test_numbers_are_checked(ask, text):
    with pytest.raises(mb.InputError, match=text):
        ask()
