"""Constructed crossings and veerings: families of which every branch is known in closed form keep each branch in its column."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbconstrained.polynomial.variation import MatrixFamily, followed


def pairs_of_curves(blocks, p):
    """Squares of frequencies of blocks [[a + u p, e], [e, b + v p]], each the lower and the upper branch, shape (P, 2 k).

    With e = 0 the lines cross, where e is not 0 the branches of a block never meet.
    """
    curves = []
    for a, u, b, v, e in blocks:
        first, second = a + u * p, b + v * p
        if not e:
            curves += [first, second]
            continue
        middle, half = (first + second) / 2, np.hypot((first - second) / 2, e)
        curves += [middle - half, middle + half]
    return np.array(curves).T


def mixed_family(blocks, seed, damping=0.0):
    """M x'' + C x' + K(p) x = 0 of these blocks in coordinates that mix all of them."""
    size = 2 * len(blocks)
    K, slope = np.zeros((2, size, size))
    for place, (a, u, b, v, e) in enumerate(blocks):
        at = slice(2 * place, 2 * place + 2)
        K[at, at], slope[at, at] = [[a, e], [e, b]], np.diag([u, v])
    T = np.linalg.qr(np.random.default_rng(seed).normal(size=(size, size)))[0] @ np.diag(np.linspace(1.0, 2.0, size))
    K, slope, M = (T.T @ matrix @ T for matrix in (K, slope, np.eye(size)))
    zero = np.zeros_like(M)
    return MatrixFamily.linear(np.array([K, damping * M, M]), np.array([slope, zero, zero]))


def upper_branches(branches):
    """The columns of the eigenvalues above the real axis."""
    return branches.values[:, branches.values[0].imag > 0]


def assert_same_columns(found, expected, accuracy):
    """Both have the same columns, in any order."""
    distance = np.abs(found[:, :, None] - expected[:, None, :]).max(axis=0)
    partner = distance.argmin(axis=1)
    assert sorted(partner) == list(range(expected.shape[1]))
    assert distance[range(len(partner)), partner].max() < accuracy


@pytest.mark.parametrize("points", [2, 3, 8, 41])
@pytest.mark.parametrize("coupling", [0.0, 0.3, 1e-2, 1e-4, 1e-6, 1e-8])
def test_lines_cross_and_coupled_ones_veer(points, coupling):
    """Two frequencies whose distance is anything from none to a third: an interval may be 10^8 times as wide as the veering."""
    blocks = [(4.0, 1.0, 5.1, -1.0, coupling), (4.2, 0.9, 6.0, -0.8, 0.0), (9.0, 0.2, 9.9, -0.3, coupling)]
    p = np.linspace(0.0, 1.5, points)
    found = upper_branches(followed(mixed_family(blocks, 3), p))
    assert_same_columns(found, 1j * np.sqrt(pairs_of_curves(blocks, p)), 1e-10)


@pytest.mark.long
@settings(max_examples=25)
@given(
    blocks=st.lists(
        st.tuples(
            st.floats(3.0, 9.0),
            st.floats(-1.0, 1.0),
            st.floats(3.0, 9.0),
            st.floats(-1.0, 1.0),
            st.sampled_from([0.0, 0.2, 1e-3, 1e-5]),
        ),
        min_size=1,
        max_size=4,
    ),
    seed=st.integers(0, 1000),
    points=st.integers(2, 30),
    damping=st.sampled_from([0.0, 0.01]),
)
def test_no_branch_is_swapped(blocks, seed, points, damping):
    """Curves of different blocks cross, also in one point or as one curve; those of one block veer."""
    p = np.linspace(0.0, 2.0, points)
    squares = pairs_of_curves(blocks, p)
    values = -damping / 2 + 1j * np.sqrt(squares - damping**2 / 4)
    found = upper_branches(followed(mixed_family(blocks, seed, damping), p))
    inside = np.abs(found[:, :, None] - values[:, None, :]).max(axis=0)
    assert inside.min(axis=1).max() < 1e-7
    np.testing.assert_allclose(np.sort(found.imag, axis=1), np.sort(values.imag, axis=1), atol=1e-9)


def test_a_pair_that_becomes_real_is_followed_through_the_defective_value():
    """x'' + p x' + x = 0: a pair on the unit circle up to critical damping at p = 2, two real eigenvalues beyond."""
    zero, one = np.zeros((1, 1)), np.eye(1)
    p = np.linspace(0.0, 5.0, 21)
    branches = followed(MatrixFamily.linear(np.array([one, zero, one]), np.array([zero, one, zero])), p)
    np.testing.assert_allclose(branches.values.prod(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(branches.values.sum(axis=1), -p, atol=1e-7)
    assert (np.abs(np.diff(branches.values[10:], axis=0)) < 1.5).all()


def test_a_massless_coordinate_follows():
    """A spring p in series with k = 1 through a massless joint: w^2 = p / (1 + p)."""
    base = np.array([[[1.0, -1.0], [-1.0, 1.0]], np.zeros((2, 2)), np.diag([1.0, 0.0])])
    slope = np.array([np.diag([0.0, 1.0]), np.zeros((2, 2)), np.zeros((2, 2))])
    p = np.linspace(0.5, 3.0, 6)
    found = upper_branches(followed(MatrixFamily.linear(base, slope), p))
    np.testing.assert_allclose(found[:, 0], 1j * np.sqrt(p / (1 + p)), rtol=1e-12)
