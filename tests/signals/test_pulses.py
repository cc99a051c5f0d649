"""Pulses of all shapes against their formulas, and over when they end."""

from __future__ import annotations

import numpy as np
import pytest

import mbconstrained as mb

SHAPES = {
    "rectangle": lambda u: np.ones_like(u),
    "half-sine": lambda u: np.sin(np.pi * u),
    "versed-sine": lambda u: (1 - np.cos(2 * np.pi * u)) / 2,
    "triangle": lambda u: 1 - np.abs(2 * u - 1),
    "sawtooth": lambda u: u,
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("start", "duration"), [(0.0, 2.0), (3.0, 11e-3), (1e3, 1e-3)])
def test_a_pulse_has_its_shape(shape, start, duration):
    f = mb.pulse([2.0, -1.0], start=start, duration=duration, shape=shape)
    u = np.linspace(0.02, 0.98, 25)
    values = f(start + duration * u)
    precision = 8 * np.spacing(start) / duration + 1e-14  # of the times themselves
    np.testing.assert_allclose(values, np.outer([2.0, -1.0], SHAPES[shape](u)), atol=8 * precision)
    assert np.abs(f(np.array([start + 1.5 * duration, start + 20 * duration]))).max() <= 1e-13
    assert not start or not f(0.5 * start).any()


@pytest.mark.parametrize("shape", SHAPES)
def test_the_impulse_of_a_pulse_is_the_momentum_of_a_free_mass(shape):
    x = mb.solve(mb.PolynomialMatrix([[[0.0]], [[0.0]], [[1.0]]]), force=mb.pulse([1.0], start=1.0, duration=0.5, shape=shape))
    mean = {"rectangle": 1.0, "half-sine": 2 / np.pi}.get(shape, 0.5)
    assert x.derivative()(4.0).item() == pytest.approx(0.5 * mean, rel=1e-13)


def test_an_unknown_shape_is_named():
    with pytest.raises(mb.InputError, match="half-sine"):
        mb.pulse([1.0], duration=1.0, shape="halfsine")
