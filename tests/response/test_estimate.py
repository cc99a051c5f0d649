"""The estimate of the error: never far below the error, and quiet where there is none to speak of."""

from __future__ import annotations

import numpy as np
import pytest

import mbconstrained as mb

EPS = np.finfo(float).eps


def test_zero_is_known_to_the_last_place():
    x = mb.solve(mb.PolynomialMatrix([[[1.0]], [[1.0]]]))
    assert x.error_estimate([0.0, 1.0]) == EPS
    assert x.error_estimate([]) == EPS


def test_the_estimate_is_reproducible():
    x = mb.solve(mb.PolynomialMatrix([[[1.0]], [[0.0]], [[1.0]]]), [[1.0], [0.0]])
    times = np.linspace(0, 100, 11)
    assert x.error_estimate(times) == x.error_estimate(times)


@pytest.mark.parametrize("periods", [1.0, 1e3, 1e6])
def test_the_estimate_grows_with_the_phase_error(periods):
    """Half a unit in the last place of the stiffness moves the phase by eps w t / 4."""
    x = mb.solve(mb.PolynomialMatrix([[[1.0]], [[0.0]], [[1.0]]]), [[1.0], [0.0]])
    estimate = x.error_estimate(2 * np.pi * periods + np.linspace(0, 1, 5))
    phase = 2 * np.pi * periods * EPS
    assert 0.1 * phase <= estimate <= 100 * phase


def test_the_estimate_sees_an_ill_conditioned_answer():
    """k1 - k2 of two almost equal stiffnesses: x = f / (k1 - k2) keeps half of the digits."""
    A = mb.PolynomialMatrix([[[1.0, 1.0], [1.0, 1.0 + 1e-8]]])
    x = mb.solve(A, force=mb.step([1.0, 0.0]))
    assert 1e-9 <= x.error_estimate(1.0) <= 1e-6


def test_the_estimate_of_a_well_conditioned_answer_is_a_few_roundings():
    x = mb.solve(mb.PolynomialMatrix([np.diag([1.0, 2.0]), np.eye(2)]), [[1.0, 1.0]])
    assert x.error_estimate(np.linspace(0, 2, 5)) <= 20 * EPS
