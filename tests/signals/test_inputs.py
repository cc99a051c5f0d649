"""Inputs: what the constructors mean, and that Dirac impulses are separate from the regular part."""

import math

import numpy as np
import pytest

import mbconstrained as mb

V = np.array([1.0, -2.0])
TIMES = np.array([0.0, 0.5, 2.0])


@pytest.mark.parametrize(
    "force, shape_in_time",
    [
        (mb.step(V), np.ones(3)),
        (mb.ramp(V), TIMES),
        (mb.harmonic(V, angular_frequency=3.0, phase=0.5), np.cos(3 * TIMES + 0.5)),
        (mb.harmonic(V, angular_frequency=-3.0, phase=0.5), np.cos(-3 * TIMES + 0.5)),
        (mb.harmonic(V, angular_frequency=0.0, phase=0.5), np.full(3, math.cos(0.5))),
        (mb.term(V, power=2, rate=-1.0, angular_frequency=3.0), TIMES**2 * np.exp(-TIMES) * np.cos(3 * TIMES)),
        (mb.zero(2), np.zeros(3)),
        (mb.impulse(V), np.zeros(3)),
    ],
)
def test_constructors_mean_what_they_say(force, shape_in_time):
    assert force.size == 2
    assert np.allclose(force(TIMES), np.outer(V, shape_in_time), rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize("gamma", range(-3, 5))
def test_power_is_the_gamma_fold_integral_of_the_impulse(gamma):
    """I_gamma = t^(gamma-1)/(gamma-1)! for gamma >= 1, delta^(-gamma) for gamma <= 0 (Hauksdottir)."""
    force = mb.power(V, gamma)
    if gamma > 0:
        assert np.allclose(force(TIMES), np.outer(V, TIMES ** (gamma - 1) / math.factorial(gamma - 1)), rtol=1e-14)
        assert force.impulses == ()
    else:
        assert not force(TIMES).any()
        assert [row.tolist() for row in force.impulses] == [[0.0, 0.0]] * -gamma + [V.tolist()]


def test_a_matrix_maps_regular_part_and_impulses():
    matrix = np.array([[1.0, 1.0]])
    mapped = (mb.impulse(V) + mb.ramp(V)).mapped(matrix)
    assert mapped.size == 1
    assert mapped.impulses[0].tolist() == [-1.0]
    assert mapped(2.0).tolist() == [-2.0]


def test_a_frequency_in_hz_is_that_of_whole_periods():
    f = mb.harmonic(V, frequency_hz=2)
    assert f(np.array([0.25, 0.5])) == pytest.approx(np.outer(V, [-1, 1]))
    assert mb.term(V, frequency_hz=2)(0.3) == pytest.approx(f(0.3))


@pytest.mark.parametrize(
    "make, text",
    [
        (lambda: mb.step(None), "vector"),
        (lambda: mb.step([[1.0]]), "vector: expected shape any, found 1 x 1"),
        (lambda: mb.step([np.nan]), "vector: the entry at .* is nan"),
        (lambda: mb.step([1j]), "vector: complex numbers found"),
        (lambda: mb.term(V, power=-1), "power: found -1; expected a whole number of at least 0"),
        (lambda: mb.term(V, power=1.5), "power: found 1.5; expected a whole number"),
        (lambda: mb.term(V, rate=np.inf), "rate: found inf; expected a finite number"),
        (lambda: mb.harmonic(V, angular_frequency="2 Hz"), "found .2 Hz.; expected a number in SI units without quotes"),
        (lambda: mb.harmonic(V), r"give angular_frequency \(rad/s\) or frequency_hz \(Hz\)"),
        (lambda: mb.harmonic(V, angular_frequency=1, frequency_hz=1), "either angular_frequency .* or frequency_hz .*, not both"),
        (lambda: mb.sampled([0, 1], [1, 2, 3]), "values: found shape 1 x 3; expected one row per coordinate, each of 2"),
        (lambda: mb.power(V, 1.0), "gamma: found 1.0; expected a whole number"),
        (lambda: mb.power(V, True), "gamma: found True; expected a whole number"),
        (lambda: mb.impulse(V, order=-1), "order: found -1; expected a whole number of at least 0"),
        (lambda: mb.zero(-1), "size: found -1; expected a whole number of at least 0"),
        (lambda: mb.step(V) + mb.step([1.0]), "inputs of different sizes cannot be added: 2 and 1 rows"),
        (lambda: mb.impulse(V) + mb.impulse([1.0]), "inputs of different sizes cannot be added: 2 and 1 rows"),
        (lambda: mb.step(V).mapped([1.0, 2.0]), "matrix: expected shape any x 2, found 2"),
    ],
)
def test_what_makes_no_input_is_refused(make, text):
    with pytest.raises(mb.InputError, match=text):
        make()
