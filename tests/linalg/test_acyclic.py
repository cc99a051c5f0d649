"""Elimination of trees against dense matrices, and the zeros of a polynomial against its roots."""

from __future__ import annotations

import numpy as np
import pytest

from mbconstrained.linalg.aberth import zeros_near
from mbconstrained.linalg.acyclic import CHUNK, acyclic_of, is_acyclic
from mbconstrained.tolerances import EPS

from .test_quadratic_modes import random_tree, tree

S = np.array([0.3 + 1.2j, -0.1 + 0.5j, -2.0 + 0.0j])


def model(seed, count=20, reach=None):
    parents, (stiffness, dampers, mass), _ = random_tree(seed, count, reach)
    return tree(parents, stiffness, dampers, mass)


def dense(P, s):
    K, C, M = P.dense()
    return K + s * C + s * s * M, C + 2 * s * M


@pytest.mark.parametrize("reach", [1, 2, None])
@pytest.mark.parametrize("seed", range(3))
def test_solutions_and_the_derivative_of_the_determinant_are_those_of_dense_matrices(seed, reach):
    P = acyclic_of(*model(seed, reach=reach))
    right = np.random.default_rng(seed).normal(size=(P.size, len(S))) + 0j
    x = P.solved(*P.factored(S), right)
    for k, s in enumerate(S):
        matrix, slope = dense(P, s)
        assert np.abs(matrix @ x[:, k] - right[:, k]).max() <= 1e-12 * np.abs(x).max()
        assert np.isclose(P.newton(S)[k], np.trace(np.linalg.solve(matrix, slope)), rtol=1e-11)
    applied, damping, inertia = P.applied(S, x)
    assert np.abs(applied - right).max() <= 1e-12 * np.abs(x).max()
    _, C, M = P.dense()
    assert np.allclose(damping, C @ x, rtol=0, atol=1e-12) and np.allclose(inertia, M @ x, rtol=0, atol=1e-12)


@pytest.mark.parametrize("reach", [1, None])
def test_the_matrix_is_the_given_one_in_another_order_and_halves_are_parts_of_it(reach):
    M, C, K = model(5, reach=reach)
    P = acyclic_of(M, C, K)
    for found, given in zip(P.dense(), (K, C, M)):
        assert np.array_equal(found, given[np.ix_(P.places, P.places)])
    halves = P.halves()
    assert sorted(np.concatenate([half.places for half in halves])) == list(range(P.size))
    for half in halves:
        assert np.array_equal(half.dense()[0], K[np.ix_(half.places, half.places)])


def test_more_numbers_than_are_taken_at_once():
    P = acyclic_of(*model(6, count=3))
    s = 1j * np.linspace(0.1, 2, CHUNK // 3 + 5) - 0.01
    assert np.array_equal(P.newton(s)[-3:], P.newton(s[-3:]))


def test_a_slow_motion_keeps_its_digits():
    """K x of a chain without walls and equal x is nothing but rounding of the sums of rows, not of K."""
    P = acyclic_of(np.eye(30), np.zeros((30, 30)), 1e-9 * np.diag(np.arange(30) == 0) + _free_chain(30))
    applied = P.applied(np.zeros(1), np.ones((30, 1)))[0]
    assert abs(applied.sum() - 1e-9) <= 10 * EPS * 1e-9 + EPS


def _free_chain(count):
    K = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    K[0, 0] = K[-1, -1] = 1.0
    return K


def test_what_is_a_tree():
    ring = 3 * np.eye(4) - np.roll(np.eye(4), 1, 0) - np.roll(np.eye(4), -1, 0)
    apart = np.kron(np.eye(2), np.ones((2, 2)))
    zero = np.zeros((4, 4))
    assert not is_acyclic(np.eye(4), zero, ring) and acyclic_of(np.eye(4), zero, ring) is None
    assert is_acyclic(np.eye(4), zero, apart) and acyclic_of(np.eye(4), zero, apart) is None
    assert not is_acyclic(np.ones((3, 3)), zero, apart)
    assert is_acyclic(np.eye(4), zero, np.diag(np.ones(4)))


ROOTS = {
    "real ones": [-1.0, -2.0, -5.0, 3.0],
    "pairs": [-1 + 2j, -1 - 2j, 0.5 + 1j, 0.5 - 1j],
    "both": [-1 + 2j, -1 - 2j, -4.0, -0.1],
    "near the axis": [-1 + 1e-4j, -1 - 1e-4j, -3.0, -7.0],
}


@pytest.mark.parametrize("roots", ROOTS.values(), ids=ROOTS)
@pytest.mark.parametrize("start", ROOTS.values(), ids=ROOTS)
def test_pairs_become_real_zeros_and_real_zeros_pairs(roots, start):
    p = np.polynomial.Polynomial.fromroots(roots)
    p = np.polynomial.Polynomial(p.coef.real)
    found = zeros_near(lambda s: p.deriv()(s) / p(s), 1.1 * np.array(start, dtype=complex), 1e-10)
    assert len(found.all) == len(roots)
    assert np.abs(np.sort_complex(found.all) - np.sort_complex(np.array(roots, dtype=complex))).max() <= 1e-6
    assert len(found.real) == np.count_nonzero(np.imag(roots) == 0)
    assert (found.upper.imag > 0).all()


def test_exact_zeros_stay_and_none_is_found_twice():
    p = np.polynomial.Polynomial.fromroots([-1.0, -2.0, -3.0])
    found = zeros_near(lambda s: p.deriv()(s) / p(s), np.array([-1.0, -1.0001, -3.0]), 1e-10)
    assert found.real == pytest.approx([-3.0, -2.0, -1.0])


def test_what_does_not_settle_is_none():
    random = np.random.default_rng(0)
    assert zeros_near(lambda s: random.normal(size=len(s)) + 0j, np.array([1.0 + 1j, 1.0 - 1j, 2.0]), 1e-10) is None
