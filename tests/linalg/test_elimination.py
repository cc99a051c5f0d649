"""Elimination of few couplings: orders against the pattern of Cholesky's factor, solutions against dense matrices."""

import numpy as np
import pytest

from mbconstrained.ground.tolerances import EPS
from mbconstrained.linalg.elimination import WIDEST, coupled_pairs, elimination, front_width, sparse_quadratic

from .few_couplings import band, beam, chain_between_walls, ladder, random_tree, ring, tree

MODELS = {
    "chain": (chain_between_walls(40), 1),
    "tree": (tree(random_tree(0, 40)[0], *random_tree(0, 40)[1]), 1),
    "ring": (ring(40), 2),
    "ladder": (ladder(40), 2),
    "beam": (beam(20), 3),
    "band": (band(40, 5), 5),
}


def shuffled(model, seed=0):
    order = np.random.default_rng(seed).permutation(len(model[0]))
    return [matrix[np.ix_(order, order)] for matrix in model]


@pytest.mark.parametrize(("model", "width"), MODELS.values(), ids=MODELS)
def test_chains_rings_ladders_and_beams_have_the_fronts_of_their_kind_in_any_numbering(model, width):
    assert front_width(*model) == width
    assert front_width(*shuffled(model)) == width


@pytest.mark.parametrize("together", [0, 4])
@pytest.mark.parametrize(("model", "width"), MODELS.values(), ids=MODELS)
def test_fronts_are_the_columns_of_the_factor(model, width, together):
    """No entry of Cholesky's factor of a matrix with this pattern is outside of the fronts; none of a round is in one of the same."""
    M, C, K = shuffled(model)
    order = elimination(len(K), coupled_pairs(M, C, K), 2 * WIDEST, together)
    pattern = (np.abs(M) + np.abs(C) + np.abs(K))[np.ix_(order.nodes, order.nodes)]
    factor = np.linalg.cholesky(pattern * np.random.default_rng(0).uniform(0.5, 1.0) + np.diag(pattern.sum(axis=0)))
    ends = np.cumsum(order.rounds)
    for own, front in enumerate(order.fronts):
        assert [*(np.flatnonzero(factor[own + 1 :, own]) + own + 1)] == list(front)
        assert not front or front[0] >= ends[np.searchsorted(ends, own, side="right")]


S = np.array([0.3 + 1.2j, -0.1 + 0.5j, -2.0 + 0.0j])


def model(seed, count=20, reach=None):
    parents, (stiffness, dampers, mass), _ = random_tree(seed, count, reach)
    return tree(parents, stiffness, dampers, mass)


SOLVED = {
    "chain": model(0, reach=1),
    "narrow tree": model(1, reach=2),
    "tree": model(2),
    "long chain": model(3, 90, 1),
    "ring": ring(60),
    "ladder": ladder(30),
    "beam": beam(30),
    "band": band(40, 5),
    "all coupled": band(6, 5),
    "one": model(0, 1),
}


@pytest.mark.parametrize("given", SOLVED.values(), ids=SOLVED)
def test_solutions_and_the_derivative_of_the_determinant_are_those_of_dense_matrices(given):
    P = sparse_quadratic(*given)
    K, C, M = P.dense()
    right = np.random.default_rng(0).normal(size=(P.size, len(S))) + 0j
    for solver in (P.narrow, P.together):
        x, newton = solver.solved(solver.factored(S), right), solver.newton(S)
        for k, s in enumerate(S):
            matrix, slope = K + s * C + s * s * M, C + 2 * s * M
            assert np.abs(matrix @ x[:, k] - right[:, k]).max() <= 1e-12 * np.abs(matrix).max() * np.abs(x[:, k]).max()
            assert np.isclose(newton[k], np.trace(np.linalg.solve(matrix, slope)), rtol=1e-10)
    applied, damping, inertia = P.applied(S, x)
    assert np.abs(applied - right).max() <= 1e-12 * np.abs(K).max() * np.abs(x).max()
    assert np.allclose(damping, C @ x, rtol=0, atol=1e-12) and np.allclose(inertia, M @ x, rtol=0, atol=1e-12)


def test_real_numbers_are_solved_in_real_arithmetic():
    M, C, K = ladder(30)
    P = sparse_quadratic(M, C, K)
    s, right = np.array([0.5, 2.0]), np.ones((30, 2))
    x = P.together.solved(P.together.factored(s), right)
    assert x.dtype == float
    assert np.abs((K + 2.0 * C + 4.0 * M) @ x[:, 1] - 1).max() <= 1e-13


@pytest.mark.parametrize("unit", [1.0, 2.0**-300], ids=["units", "small"])
def test_a_pivot_that_is_exactly_zero_is_a_rounding(unit):
    """Integers cancel without any: at its zero one step of inverse iteration finds the vector, in any units."""
    P = sparse_quadratic(np.eye(9), np.zeros((9, 9)), unit * _free_chain(9))
    for solver in (P.narrow, P.together):
        x = solver.solved(solver.factored(np.zeros(1)), np.arange(1.0, 10.0)[:, None])[:, 0]
        assert np.abs(x / x[0] - 1).max() <= 100 * EPS


def test_a_slow_motion_keeps_its_digits():
    """K x of a chain without walls and equal x is nothing but rounding of the sums of rows, not of K."""
    P = sparse_quadratic(np.eye(30), np.zeros((30, 30)), 1e-9 * np.diag(np.arange(30) == 0) + _free_chain(30))
    x = np.ones((30, 1))
    assert abs(P.applied(np.zeros(1), x)[0].sum() - 1e-9) <= 10 * EPS * 1e-9 + EPS
    assert P.kept_digits(x) >= 1e-8


def test_a_long_beam_keeps_few_digits():
    """Its bending is a third difference of its coordinates: K x of a smooth x cancels."""
    M, C, K = beam(60)
    P, x = sparse_quadratic(M, C, K), np.linalg.solve(K, np.ones((120, 1)))
    assert 1e-9 <= P.kept_digits(x) <= 1e-6
    assert P.kept_digits(np.random.default_rng(0).normal(size=(120, 1))) >= 0.1


def _free_chain(count):
    K = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    K[0, 0] = K[-1, -1] = 1.0
    return K


def test_what_is_too_densely_coupled_is_none():
    for width in (9, 20):
        assert sparse_quadratic(*band(40, width)) is None
