"""Units that balance a sparse generator: what changes of units do to it, and a bound of its zeros."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from mbconstrained.linalg.scaling import balanced_norm, balancing_units


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


def test_a_chain_of_stiff_and_soft_links_keeps_its_own_units():
    """D^-1 S D is balanced in the units D, whatever the weak coupling is."""
    n = 40
    scale = 2.0 ** np.random.default_rng(0).integers(-20, 20, n)
    S = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    S[0, -1] = 1e-12
    units = balancing_units(csr_array(S * scale / scale[:, None])) * scale
    assert units.max() <= 2 * units.min()
