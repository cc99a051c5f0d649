"""Pencils split into finite and infinite parts, against pencils put together from known parts."""

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.ground.errors import IllConditioned
from mbconstrained.linalg.rank import Noisy
from mbconstrained.linalg.staircase import SingularPencil, split_regular

chains = st.lists(st.integers(1, 4), max_size=3)


def canonical(finite: int, degrees) -> tuple[np.ndarray, np.ndarray]:
    """s diag(I, N) - diag(J, I), N with the given chain lengths and J with zeros -1, -2, ..."""
    size = finite + sum(degrees)
    E, F = np.eye(size), np.eye(size)
    F[:finite, :finite] = -np.diag(np.arange(1.0, finite + 1))
    E[finite:, finite:] = scipy.linalg.block_diag(*[np.eye(d, k=1) for d in degrees]) if degrees else 0.0
    return E, F


def mixed(E, F, seed):
    """The pencil with its rows and columns mixed by regular integer matrices."""
    random, size = np.random.default_rng(seed), len(E)

    def unimodular():
        lower = np.tril(random.integers(-1, 2, (size, size)), -1) + np.eye(size)
        return lower @ (np.triu(random.integers(-1, 2, (size, size)), 1) + np.eye(size))

    left, right = unimodular(), unimodular()
    return left @ E @ right, left @ F @ right


def rotated(E, F, seed):
    """The pencil with its rows and columns rotated, every entry rounded."""
    random = np.random.default_rng(seed)
    left, right = (np.linalg.qr(random.normal(size=E.shape))[0] for _ in range(2))
    return left @ E @ right, left @ F @ right


def check(E, F, split, finite, degrees):
    """W (s E - F) Z has the promised form, and the degrees are those put in."""
    size = len(E)
    assert split.infinite_divisors == tuple(sorted(degrees))
    E11, F11, E12, F12, N = (part.data for part in (split.E11, split.F11, split.E12, split.F12, split.nilpotent))
    assert E11.shape == F11.shape == (finite, finite)
    assert not np.tril(N).any()
    for s in (0.7, -1.3 + 0.4j):
        found = split.left.data @ (s * E - F) @ split.right.data
        known = np.zeros((size, size), complex)
        known[:finite, :finite] = s * E11 - F11
        known[:finite, finite:] = s * E12 - F12
        known[finite:, finite:] = s * N - np.eye(size - finite)
        weight = np.abs(split.left.data) @ (np.abs(s * E) + np.abs(F)) @ np.abs(split.right.data)
        assert np.abs(found - known).max(initial=0.0) <= 1e-11 * max(1.0, weight.max(initial=0.0))


@given(st.integers(0, 4), chains, st.integers(0, 10**6))
def test_what_is_mixed_beyond_recognition_is_never_wrong_in_silence(finite, degrees, seed):
    """Dense integer mixtures up to 16 x 16, some of condition 1e6: right, or told as unclear, or refused."""
    E, F = mixed(*canonical(finite, degrees), seed)
    try:
        split = split_regular(Noisy.rounded(E), Noisy.rounded(F))
    except IllConditioned as refused:
        assert "float64 cannot tell which of their zeros are infinite" in str(refused)
        return
    if all(decision.clear for decision in split.decisions):
        check(E, F, split, finite, degrees)


@given(st.integers(0, 4), chains, st.integers(0, 10**6))
def test_zeros_of_the_finite_part_are_those_put_in(finite, degrees, seed):
    split = split_regular(*map(Noisy.rounded, rotated(*canonical(finite, degrees), seed)))
    zeros = np.sort(scipy.linalg.eigvals(split.F11.data, split.E11.data).real) if finite else []
    assert np.allclose(zeros, -np.arange(finite, 0.0, -1), rtol=1e-6)


@pytest.mark.parametrize("degrees", [[], [1], [1, 1], [2, 1], [3], [4, 2, 1], [6]])
def test_canonical_pencils_are_split_without_rounding(degrees):
    E, F = canonical(2, degrees)
    split = split_regular(Noisy.rounded(E), Noisy.rounded(F))
    check(E, F, split, 2, degrees)
    assert all(decision.clear for decision in split.decisions)
    assert set(np.unique(split.nilpotent.data)) <= {0.0, 1.0}


@given(chains.filter(bool), st.integers(0, 10**6), st.sampled_from(["left", "right"]))
def test_a_dependent_row_or_column_makes_it_singular(degrees, seed, side):
    """s E - F with its first row (column) replaced by twice the second."""
    E, F = mixed(*canonical(2, degrees), seed)  # rows and columns of small integers: doubling them is exact
    if side == "left":
        E[0], F[0] = 2 * E[1], 2 * F[1]
    else:
        E[:, 0], F[:, 0] = 2 * E[:, 1], 2 * F[:, 1]
    with pytest.raises(SingularPencil):
        split_regular(Noisy.rounded(E), Noisy.rounded(F))


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_kronecker_chains_of_any_length_are_singular(degree):
    """L_k and its transpose together are square and singular though no row or column is a multiple of another."""
    L0, L1 = np.eye(degree, degree + 1), np.eye(degree, degree + 1, k=1)
    E = scipy.linalg.block_diag(L1, L1.T)
    F = scipy.linalg.block_diag(L0, L0.T)
    with pytest.raises(SingularPencil):
        split_regular(Noisy.rounded(E), Noisy.rounded(F))
    with pytest.raises(SingularPencil):
        split_regular(*map(Noisy.rounded, mixed(E, F, degree)))


def test_nothing_is_split_into_nothing():
    split = split_regular(*[Noisy.exact(np.zeros((0, 0)))] * 2)
    assert (split.infinite_divisors, split.deficiencies) == ((), ())
