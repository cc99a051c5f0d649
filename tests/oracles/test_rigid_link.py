"""Two unit masses held together by a rigid link with a multiplier: the reference for Dirac impulses.

det A = 2 s^2 + 1. All numbers were worked out in rational arithmetic from A(s)^{-1}.
"""

from __future__ import annotations

import numpy as np
import pytest

import mbconstrained as mb
from tests.oracles.models import close, rigid_link

A = mb.PolynomialMatrix(rigid_link(), coordinates=["q1", "q2", "lambda"])
REST = np.zeros((2, 3))
NONE, HALF = [0, 0, 0], [0, 0, 0.5]


def values(q, velocity, multiplier=0.0) -> np.ndarray:
    return np.array([[*q, multiplier], [*velocity, multiplier]])


def test_structure():
    structure = A.structure()
    assert structure.at_infinity == (2, 2, -2)
    assert structure.infinite_divisors == (0, 0, 4)
    assert structure.highest_impulse == 2
    assert structure.infinite_chains == (3,)
    (zero,) = structure.finite_zeros
    assert abs(zero.value - 1j / 2**0.5) < 1e-15


def test_laurent_coefficients():
    pairs = A.jordan_pairs()
    known = {
        3: np.zeros((3, 3)),
        2: np.diag([0, 0, 1 / 2]),
        1: np.zeros((3, 3)),
        0: np.array([[0, 0, 1 / 2], [0, 0, -1 / 2], [-1 / 2, 1 / 2, 1 / 4]]),
        -1: np.zeros((3, 3)),
        -2: np.array([[1 / 2, 1 / 2, -1 / 4], [1 / 2, 1 / 2, -1 / 4], [1 / 4, 1 / 4, -1 / 8]]),
    }
    for index, H in known.items():
        assert np.abs(pairs.laurent(index) - H).max() <= 1e-15


def test_infinite_pair_reproduces_the_polynomial_part_and_is_nilpotent():
    pair = A.jordan_pairs().infinite
    assert pair.J.shape == (3, 3)
    assert np.abs(np.linalg.matrix_power(pair.J, 3)).max() == 0
    for index in range(3):
        H = pair.C @ np.linalg.matrix_power(pair.J, index) @ pair.B
        assert np.abs(H - A.jordan_pairs().laurent(index)).max() <= 1e-14


@pytest.mark.parametrize(
    "start, force, impulses, after",
    [
        (values((1, 0), (0, 0)), None, (NONE, [0, 0, -0.5]), [[0.5, 0.5, 0.25], [0, 0, 0]]),
        (values((0, 0), (1, 0)), None, ([0, 0, -0.5],), [[0, 0, 0], [0.5, 0.5, 0.25]]),
        (REST, mb.step([0, 0, 1.0]), (NONE, HALF), [[0.5, -0.5, 0.25], [0, 0, 0]]),
        (REST, mb.ramp([0, 0, 1.0]), (HALF,), [[0, 0, 0], [0.5, -0.5, 0.25]]),
        (values((1, 1), (1, 1), 0.5), None, (), [[1, 1, 0.5], [1, 1, 0.5]]),
    ],
    ids=["position violated", "velocity violated", "step on the row", "ramp on the row", "consistent"],
)
def test_impulses_and_values_after_zero(start, force, impulses, after):
    """The row's own force enters by f(0+) and f'(0+) only: H_2 gives the multiplier delta' f(0+) + delta f'(0+)."""
    x = mb.solve(A, start, force)
    assert len(x.impulses) == len(impulses)
    for found, known in zip(x.impulses, impulses):
        assert close(found, known, 1e-14) or np.array_equal(found, known)
    assert close(x.start, after, 1e-14)
    assert close([x(0.0), x.derivative()(0.0)], after, 1e-13)


def test_notices_name_the_coordinate_and_the_kind_of_impulse():
    texts = [notice.text for notice in mb.solve(A, values((1, 0), (0, 0))).notices if notice.kind == "impulse"]
    assert texts == ["lambda: the derivative of order 1 of a Dirac impulse at t = 0 of size -0.5"]


def test_momentum_is_kept_through_the_impact():
    """The link's impulse is internal: q1' + q2' does not change at t = 0."""
    x = mb.solve(A, values((0, 0), (1, 0)))
    assert abs(x.start[1, :2].sum() - 1) < 1e-15
