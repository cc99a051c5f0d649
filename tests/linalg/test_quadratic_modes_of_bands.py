"""Modes of rings, ladders, bands and beams against LAPACK's eigenvalues, the identities that modes obey and closed forms."""

import numpy as np
import pytest

from mbconstrained.linalg.elimination import EACH, front_width

from .few_couplings import band, beam, ladder, ring, uniform_ring
from .test_quadratic_modes import check, quadratic_modes

MODELS = {
    "ring": ring(250),
    "ladder": ladder(250),
    "band": band(3 * EACH, 3),
    "beam on a foundation": beam(3 * EACH // 2, foundation=50.0),
}


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_zeros_and_motions_are_those_of_the_generator(model):
    check(quadratic_modes(*model), *model)


def test_a_ring_with_massless_joints():
    """Every tenth coordinate has a damper to the ground and no mass."""
    count = 260
    M, C, K = ring(count, seed=2)
    light = np.arange(count) % 10 == 7
    C[light, light] += 0.3
    order, m = np.argsort(light, kind="stable"), count - np.count_nonzero(light)
    M, C, K = M[np.ix_(order, order)][:m, :m], C[np.ix_(order, order)], K[np.ix_(order, order)]
    found = quadratic_modes(M, C, K)
    assert len(found.real) >= count - m
    check(found, M, C, K)


@pytest.mark.parametrize("damping", [(), (3,)], ids=["none", "one damper"])
def test_equal_zeros_of_a_uniform_ring_are_refused_or_right(damping):
    """Waves go round both ways alike: every zero but two is there twice, or near another where one damper tells them apart."""
    model = uniform_ring(250, damping)
    found = quadratic_modes(*model)
    assert damping or found is None
    if found is not None:
        check(found, *model)


def test_a_uniform_ring_whose_dampers_tell_its_waves_apart():
    model = uniform_ring(242, (3, 40, 58))
    check(quadratic_modes(*model), *model)


def test_a_uniform_ladder_has_the_frequencies_of_its_formula():
    """Both rails alike: together they are a chain, against each other a chain on the ground of twice the rungs; leading parts have
    motions of the whole, whose pivots vanish."""
    half = 143  # half + 1 has many divisors
    chain = 2 * np.eye(half) - np.eye(half, k=1) - np.eye(half, k=-1)
    K = np.kron(chain, np.eye(2)) + np.kron(np.eye(half), 0.3 * np.array([[1.0, -1.0], [-1.0, 1.0]]))
    found = quadratic_modes(np.eye(2 * half), 0.01 * np.eye(2 * half), K)
    squares = (2 * np.sin(np.pi * np.arange(1, half + 1) / (2 * (half + 1)))) ** 2
    squares = np.sort(np.concatenate([squares, squares + 0.6]))
    assert np.abs(np.sort(np.abs(found.upper) ** 2) / squares - 1).max() <= 1e-12
    assert np.abs(found.upper.real + 0.005).max() <= 1e-14


def test_a_free_ring_is_refused():
    """It moves off as a whole: a double zero at 0 with one vector."""
    M, C, K = ring(250, ground=())
    assert quadratic_modes(M, C, K) is None


def test_a_long_beam_is_refused_before_its_zeros_are_looked_for(monkeypatch):
    model = beam(3 * EACH // 2)
    monkeypatch.setattr("mbconstrained.linalg.tree_modes._zeros", None)
    assert front_width(*model) == 3 and quadratic_modes(*model) is None


def test_a_beam_of_integers_with_one_damper_keeps_its_modes():
    """Beside its slow zeros P(s) is K to the last digit, and pivots of integers cancel to exactly 0.

    Modes of beams lose digits with the fourth power of the length: of 120 more bodies those of some processors are refused.
    """
    D, one = np.diff(np.eye(2 * EACH), 2, axis=0), np.zeros(2 * EACH)
    one[len(one) // 2] = 1.0
    K = D.T @ D
    K[[0, 1, -1], [0, 1, -1]] += 1.0
    check(quadratic_modes(np.eye(len(K)), np.diag(one), K), np.eye(len(K)), np.diag(one), K)


def test_what_has_too_few_coordinates_for_its_width_is_left_to_others():
    assert quadratic_modes(*ring(2 * EACH - 2)) is None
