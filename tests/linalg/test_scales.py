"""Zeros of very different size, each to the last digit; truth from mpmath's eigenvalues with 60 digits."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.ground.tolerances import EPS
from mbconstrained.linalg.precise import magnitude, power_of_two, precise, precise_arithmetic, product
from mbconstrained.linalg.triangular import block_diagonal


def eigenvalues(matrix):
    """By mpmath, which knows nothing of scales, with 60 digits."""
    with mpmath.workdps(60):
        rows = [[mpmath.mpf(entry.str(70, radius=False)) for entry in row] for row in matrix]
        return np.array(mpmath.eig(mpmath.matrix(rows), left=False, right=False)).astype(complex).reshape(-1)


def check(matrix, digits=20 * EPS):
    """The decomposition is one, and every zero is right relative to itself."""
    found = block_diagonal(matrix)
    defect = magnitude(product(found.inverse, found.basis) - precise(np.eye(len(matrix)))).max()
    assert defect < 1e-20
    zeros = np.concatenate([np.linalg.eigvals(block) for block in found.blocks])
    truth = eigenvalues(matrix)
    assert len(zeros) == len(truth)
    for value in truth:
        at = np.abs(zeros - value).argmin()
        assert abs(zeros[at] - value) <= digits * abs(value)
        zeros = np.delete(zeros, at)


def chain(ratio: float, damping: float, count: int = 4) -> np.ndarray:
    """x'' = -K x - damping K x' of a chain of unit masses, springs 1 and ratio in turn, exact; states (x, x')."""
    K = np.full((count, count), Fraction(0), dtype=object)
    for i in range(count):
        k = Fraction(ratio if i % 2 else 1.0)
        K[i, i] += k
        if i:
            K[i - 1, i - 1] += k
            K[i - 1, i] -= k
            K[i, i - 1] -= k
    T = np.full((2 * count, 2 * count), Fraction(0), dtype=object)
    T[:count, count:] = np.vectorize(Fraction, otypes=[object])(np.eye(count))
    T[count:, :count], T[count:, count:] = -K, -K * Fraction(damping)
    return precise(T)


@pytest.mark.parametrize("ratio", [1.0, 1e8, 1e16, 1e20])
@pytest.mark.parametrize("damping", [0.0, 1e-3, 10.0])
def test_stiff_chains(ratio, damping):
    """Frequencies 1 and sqrt(ratio), and with damping rates up to damping * ratio, all to the last digits."""
    with precise_arithmetic():
        matrix = chain(ratio, damping)
        # stiff springs alike make zeros that differ by 1 / ratio relatively: 15 digits of a double zero need 30 of its sum
        check(matrix, digits=200 * EPS)


@given(st.integers(0, 10**6), st.integers(2, 5), st.integers(0, 60))
def test_graded_random_matrices(seed, size, exponent):
    """Random matrices whose rows fall by a power of two each."""
    random = np.random.default_rng(seed)
    with precise_arithmetic():
        rows = random.integers(-9, 10, (size, size)) + 12.0 * np.eye(size)
        matrix = precise(rows) * power_of_two(-exponent * np.arange(size) / max(size - 1, 1) // 1)[:, None]
        check(matrix, digits=1e3 * EPS)


def test_a_defective_zero_stays_one_block():
    """A chain of three at -1 beside a zero at -1e-12: its block keeps the multiplicity, within what three digits in one cost."""
    with precise_arithmetic():
        J = np.diag([-1.0, -1.0, -1.0, -1e-12]) + np.diag([1.0, 1.0, 0.0], 1)
        mixing = np.array([[2.0, 1, 0, 1], [1, 3, 1, 0], [0, 1, 2, 1], [1, 0, 1, 3]])
        found = block_diagonal(product(precise(mixing), J, np.linalg.inv(mixing)))
    assert sorted(len(block) for block in found.blocks) == [1, 3]
    slow = next(block for block in found.blocks if len(block) == 1)
    assert abs(slow[0, 0] + 1e-12) < 1e-15  # the inverse is rounded: an error of eps in a matrix of size one


def test_no_zeros():
    with precise_arithmetic():
        assert block_diagonal(precise(np.zeros((0, 0)))).blocks == ()


def oscillators(coupling: float, detuning: int) -> np.ndarray:
    """Two of frequency 4096, detuned by a few roundings, a weak spring between, exact; states (x, x')."""
    k, more = Fraction(coupling), Fraction(detuning * EPS)
    T = np.full((4, 4), Fraction(0), dtype=object)
    T[:2, 2:] = np.vectorize(Fraction, otypes=[object])(np.eye(2))
    T[2:, :2] = 4096**2 * np.array([[-1 - k, k], [k, -1 - k - more]])
    return precise(T)


@pytest.mark.parametrize("detuning", [-6, -3, -2, -1, 0, 1, 2, 3, 6])
@pytest.mark.parametrize("coupling", [1e-12, 1e-13, 3e-14, 1e-14, 5e-15, 3e-15, 1e-15, 1e-16])
def test_zeros_as_close_as_float64_can_just_tell_apart(coupling, detuning):
    """Newton steps gain as many digits as float64 knows of the distance: two, where it is 1e-14."""
    with precise_arithmetic():
        check(oscillators(coupling, detuning))
