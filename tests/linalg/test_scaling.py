"""Units: powers of two take them out of the data, and units that balance a sparse generator bound its eigenvalues."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

import mbconstrained as mb
from mbconstrained.linalg.scaling import balanced_norm, balancing_units, joint_scaling

exponents = st.integers(-60, 60)


def sample(seed=0, degree=2, size=3) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(degree + 1, size, size)).round(1)


@given(st.integers(0, 20), exponents, st.lists(exponents, min_size=3, max_size=3), st.lists(exponents, min_size=3, max_size=3))
def test_scaled_coefficients_do_not_depend_on_units_of_powers_of_two(seed, time, rows, columns):
    A = sample(seed)
    changed = np.exp2(rows)[:, None] * A * np.exp2(columns) * np.exp2(time * np.arange(3.0))[:, None, None]
    one, other = joint_scaling(A).apply(A), joint_scaling(changed).apply(changed)
    # the least-squares exponents of both agree up to the rounding of a tie: factors of two at most
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(A == 0, 1.0, other / one)
    assert (ratio >= 2.0**-4).all() and (ratio <= 2.0**4).all()


@pytest.mark.parametrize("entries", [(1e308, 1e-308), (1.0, 5e-324), (1e-308, 1e308)])
def test_zeros_beyond_float64_are_told(entries):
    """1e308 x + 1e-308 x' has the zero -1e616 1/s."""
    with pytest.raises(mb.IllConditioned, match="no unit of time"):
        mb.PolynomialMatrix([[[entry]] for entry in entries]).jordan_pairs()


def generator(masses: int, seed: int = 0) -> np.ndarray:
    random = np.random.default_rng(seed)
    K = 2 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1)
    return np.block(
        [[np.zeros((masses, masses)), np.eye(masses)], [-K / random.uniform(0.5, 2, masses)[:, None], -0.1 * np.eye(masses)]]
    )


@given(st.integers(1, 12), st.integers(0, 1000))
def test_a_change_of_units_is_taken_back(masses, seed):
    S = generator(masses)
    units = np.exp2(np.random.default_rng(seed).integers(-60, 61, 2 * masses))
    own, other = (balancing_units(csr_array(matrix)) for matrix in (S, S * units / units[:, None]))
    apart = np.log2(own) - np.log2(other * units)
    assert np.ptp(apart) <= 2
    assert balanced_norm(csr_array(S * units / units[:, None])) == pytest.approx(balanced_norm(csr_array(S)), rel=1.0)


@given(st.integers(1, 8), st.integers(0, 1000))
def test_the_norm_bounds_the_zeros(size, seed):
    random = np.random.default_rng(seed)
    S = random.normal(size=(size, size)) * (random.uniform(size=(size, size)) < 0.5) * 10.0 ** random.uniform(-9, 9, (size, size))
    assert np.abs(np.linalg.eigvals(S)).max() <= balanced_norm(csr_array(S)) * (1 + 1e-9)


def test_what_only_drives_does_not_count():
    S = np.zeros((3, 3))
    S[:2, :2], S[:2, 2] = [[0.0, 1.0], [-1.0, 0.0]], 1e12
    assert balanced_norm(csr_array(S)) == 1.0
    assert balanced_norm(csr_array(np.eye(4, k=1))) == 0.0
    assert balanced_norm(csr_array((3, 3))) == 0.0


@pytest.mark.parametrize("weak", [1e-9, 1e-17])
@pytest.mark.parametrize("back", [0.0, 1.0])
def test_a_weak_coupling_does_not_bend_the_units_of_a_chain(weak, back):
    """One more entry between the ends of a chain changes the least-squares fit all along it, and what balances the rows hardly."""
    n = 40
    S = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    S[0, -1], S[-1, 0] = weak, back * weak
    units = balancing_units(csr_array(S))
    assert units.max() <= 2 * units.min()
