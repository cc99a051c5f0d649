"""Counter-examples to conditions of Moysis et al. as printed, with the corrected answers (rational arithmetic)."""

from __future__ import annotations

import numpy as np

import mbconstrained as mb
from tests.oracles.models import close

#: q = 1, H_1 = [[0, 1], [0, 0]], H_0 = I: the solution is x2 = f2, x1 = f1 + f2'.
DIFFERENTIATOR = mb.PolynomialMatrix([[[1, 0], [0, 1]], [[0, -1], [0, 0]]])
#: q = 2, no infinite zero.
DIAGONAL = mb.PolynomialMatrix([np.diag([0.0, 1]), np.diag([0.0, 1]), np.diag([1.0, 0])])
STEP = mb.step([0.0, 1.0])


def test_step_into_a_differentiator_from_rest_gives_an_impulse():
    """Eq. (58) with f(0-) calls this admissible; the truth is x1 = delta(t)."""
    x = mb.solve(DIFFERENTIATOR, [[0.0, 0.0]], STEP)
    assert [v.tolist() for v in x.impulses] == [[1.0, 0.0]]
    assert x.start.tolist() == [[0.0, 1.0]]


def test_step_that_the_values_already_have_gives_none():
    """Eq. (58) with f(0-) calls this inadmissible; the truth is x = (0, 1), continuous."""
    x = mb.solve(DIFFERENTIATOR, [[0.0, 1.0]], STEP)
    assert x.impulses == ()
    assert not x.jump.any()
    assert x(3.0).tolist() == [0.0, 1.0]


def test_equilibrium_is_continuous():
    """Eq. (60) as printed calls it discontinuous; the full Toeplitz matrix of H_i does not."""
    x = mb.solve(DIAGONAL, [[0.0, 1.0], [0.0, 0.0]], STEP)
    assert not x.jump.any()
    assert close(x(np.array([0.0, 1.0, 10.0])), [[0, 0, 0], [1, 1, 1]], 1e-15)


def test_velocity_of_a_first_order_coordinate_jumps():
    """Eq. (60) as printed calls it continuous; x2' jumps from -1 to 0."""
    x = mb.solve(DIAGONAL, [[0.0, 1.0], [0.0, -1.0]], STEP)
    assert close(x.jump, [[0, 0], [0, 1]], 1e-15)
    assert x.start.tolist() == [[0.0, 1.0], [0.0, 0.0]]
