"""Admissibility (58) and continuity (60), corrected, against counter-examples, the structure and solve itself."""

from __future__ import annotations

import numpy as np
import pytest

import mbconstrained as mb

RIGID_LINK = [[[1, 0, -1], [0, 0, 1], [1, -1, 0]], np.zeros((3, 3)), np.diag([1, 1, 0])]
MASSLESS_JOINTS = [[[9, 0, -3], [0, 0, 0], [-3, 0, 3]], [[0, 0, 0], [0, 12, -4], [0, -4, 4]], np.diag([0, 0, 10])]


def test_the_force_counts_at_0_plus_not_at_0_minus():
    # A(s) = [[1, -s], [0, 1]], f = (0, 1) for t >= 0: x2 = f2, x1 = f2' (worked by hand)
    A = mb.PolynomialMatrix([np.eye(2), [[0, -1], [0, 0]]])
    rest = mb.admissible(A, [[0, 0]], mb.step([0, 1]))
    assert not rest.is_impulse_free
    np.testing.assert_allclose(rest.residuals, [[1, 0]])  # x1 = delta
    loaded = mb.admissible(A, [[0, 1]], mb.step([0, 1]))
    assert loaded.is_impulse_free and loaded.is_continuous


def test_equilibrium_under_a_step_is_continuous():
    # A(s) = diag(s^2, s + 1), f = (0, 1): (0, 1) at rest is the equilibrium; with velocity -1 its velocity jumps to 0
    A = mb.PolynomialMatrix([np.diag([0, 1]), np.diag([0, 1]), np.diag([1, 0])])
    assert mb.admissible(A, [[0, 1], [0, 0]], mb.step([0, 1])).is_continuous
    moving = mb.admissible(A, [[0, 1], [0, -1]], mb.step([0, 1]))
    assert moving.is_impulse_free and not moving.is_continuous
    np.testing.assert_allclose(moving.jump, [[0, 0], [0, 1]], atol=1e-15)


def test_the_three_sets_have_the_dimensions_that_the_structure_at_infinity_says():
    # rigid link with multiplier: det = 2 s^2 + 1, one infinite zero of order 2; massless joints: n = 3, none
    assert mb.admissible(mb.PolynomialMatrix(RIGID_LINK)).dimensions == (2, 4, 6)
    assert mb.admissible(mb.PolynomialMatrix(MASSLESS_JOINTS)).dimensions == (3, 6, 6)


def test_impulse_free_is_not_continuous():
    # the published example with massless joints, from (1, 1, 2) and (0, 1, 0): jumps, no impulse
    found = mb.admissible(mb.PolynomialMatrix(MASSLESS_JOINTS), [[1, 1, 2], [0, 1, 0]])
    assert found.is_impulse_free and not found.is_continuous
    assert np.array_equal(found.nearest, [[1, 1, 2], [0, 1, 0]])


@pytest.mark.parametrize("coefficients", [RIGID_LINK, MASSLESS_JOINTS])
@pytest.mark.parametrize("seed", range(5))
def test_the_nearest_values_are_what_they_are_called_and_reach_no_further_than_any_other(coefficients, seed):
    A, random = mb.PolynomialMatrix(coefficients), np.random.default_rng(seed)
    values, force = random.normal(size=(2, 3)), mb.ramp(random.normal(size=3)) + mb.step(random.normal(size=3))
    found = mb.admissible(A, values, force)
    free = mb.solve(A, found.nearest, force)
    assert max((np.abs(c).max() for c in free.impulses), default=0.0) <= 1e-13
    still = mb.solve(A, found.nearest_continuous, force)
    assert np.abs(still.jump).max() <= 1e-13 and not still.impulses
    # x(0+) is a continuous start too: the nearest one is at most as far, in the solver's units
    scaling = A.jordan_pairs().form.companion.scaling

    def distance(other):
        return np.linalg.norm((other - values) / scaling.columns * scaling.time ** -np.arange(2.0)[:, None])

    assert distance(found.nearest) <= distance(found.nearest_continuous) * (1 + 1e-12)
    assert distance(found.nearest_continuous) <= distance(mb.solve(A, values, force).start) * (1 + 1e-12)


def test_a_system_without_algebraic_equations_admits_all():
    found = mb.admissible(mb.PolynomialMatrix([[[4.0]], [[0.0]], [[1.0]]]), [[1.0], [2.0]])
    assert found.is_continuous and found.residuals == () and found.dimensions == (2, 2, 2)
    assert np.array_equal(found.nearest_continuous, [[1.0], [2.0]])
