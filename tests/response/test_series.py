"""The Taylor series at 0+: exact where the structure is, accurate entry by entry, and no seam where the modes take over."""

from fractions import Fraction
from math import factorial

import mpmath
import numpy as np
import pytest
from hypothesis import given

import mbconstrained as mb
from mbconstrained.response.methods.pair_solution import Series, series_of, taylor_series, with_series
from mbconstrained.signals.bohl import BohlFunction
from tests.properties.problems import Problem, problems

EPS = np.finfo(float).eps


def series(x: mb.Response) -> Series:
    return taylor_series(x.pairs.form, x.initial, x.jump, x.force)


def function(x: mb.Response):
    """The regular part with its series, and the sum of its modes alone."""
    modal = BohlFunction(x.function.coefficients, x.function.blocks, x.function.start)
    return with_series(modal, series(x)), modal


def chain(bodies: int) -> mb.PolynomialMatrix:
    """Unit masses on springs and weak dampers, one after the other."""
    K = 2 * np.eye(bodies) - np.eye(bodies, k=1) - np.eye(bodies, k=-1)
    return mb.PolynomialMatrix([K, 0.125 * K, np.eye(bodies)])


def exact_chain(bodies: int, times) -> np.ndarray:
    """x(t) of the chain at rest under a unit step on its first body, by the exponential of its matrix in 120 digits."""
    with mpmath.workdps(120):
        n = 2 * bodies
        A = mpmath.zeros(n + 1)
        for i in range(bodies):
            A[i, bodies + i] = 1
            for j, stiffness in ((i - 1, -1), (i, 2), (i + 1, -1)):
                if 0 <= j < bodies:
                    A[bodies + i, j], A[bodies + i, bodies + j] = -stiffness, -mpmath.mpf(stiffness) / 8
        A[bodies, n] = 1
        columns = [mpmath.expm(A * mpmath.mpf(t))[:bodies, n] for t in times]
        return np.array([[float(value) for value in column] for column in columns]).T


# degenerate problems first


def test_no_coordinates():
    x = mb.solve(mb.PolynomialMatrix(np.zeros((3, 0, 0))))
    found, _ = function(x)
    assert found([0.0, 1.0]).shape == (0, 2) and found.derivative(2)(0.0).shape == (0,)


def test_no_finite_zeros_leave_the_series_of_the_force():
    """x1 + 2 x2' = t^2 / 2, x2 = 1 + 3 t: x1 = t^2 / 2 - 6."""
    f = mb.power([1.0, 0.0], 3) + mb.step([0.0, 1.0]) + mb.ramp([0.0, 3.0])
    found = series(mb.solve(mb.PolynomialMatrix([np.eye(2), [[0.0, 2.0], [0.0, 0.0]]]), [[0.0, 1.0]], f))
    assert np.array_equal(found.coefficients[:, :4] / found.span ** np.arange(4), [[-6.0, 0.0, 0.5, 0.0], [1.0, 3.0, 0.0, 0.0]])
    assert not found.coefficients[:, 4:].any()


def test_a_free_body_has_a_series_that_ends():
    found = series(mb.solve(mb.PolynomialMatrix([[[0.0]], [[0.0]], [[2.0]]]), [[1.0], [2.0]], mb.step([3.0])))
    assert np.array_equal(found.coefficients[0, :4] / found.span ** np.arange(4), [1.0, 2.0, 0.75, 0.0])
    assert not found.coefficients[0, 3:].any()


# the coefficients


@given(problems())
def test_coefficients_are_those_of_the_exact_transform(problem: Problem):
    """Each within its own noise of x^(k)(0+) / k!; never a number where there is none."""
    if any(term.kind == "sin" for term in problem.terms):  # its phase, -pi/2, is rounded itself
        return
    found = series(problem.answer)
    for k in range(16):
        known = np.array(problem.exact.derivatives[k], float) * found.span**k / factorial(k)
        error = np.abs(found.coefficients[:, k] - known)
        assert (error <= 32 * (found.noise[:, k] + EPS * np.abs(known))).all()
        assert not found.coefficients[known == 0, k].any()


@pytest.mark.parametrize("body", [0, 5, 11])
def test_a_far_body_begins_with_its_own_power_of_time(body):
    """A force on the first body of a chain, damper after spring, reaches the n-th as t^(2 + n) c^n / (2 + n)!."""
    found = series(mb.solve(chain(12), force=mb.step(np.eye(12)[0])))
    first = 2 + body
    assert not found.coefficients[body, :first].any()
    assert found.coefficients[body, first] == pytest.approx(found.span**first * 0.125**body / factorial(first), rel=8 * EPS)


# the sum


@pytest.mark.long
def test_far_bodies_are_accurate_from_the_first_moment_on():
    """The last body at t = 1e-4 has moved by 1e-64; its modes sum up to 1e-17 there."""
    times = np.array([1e-4, 0.3])
    found, modal = function(mb.solve(chain(12), force=mb.step(np.eye(12)[0])))
    known = exact_chain(12, times)
    assert np.allclose(found(times), known, rtol=1e-13, atol=0)
    assert np.abs(modal(times) / known - 1).max() > 1e3


def test_there_is_no_seam():
    """On both sides of the switch the two agree as well as the sum of the modes is accurate."""
    found, modal = function(mb.solve(chain(12), force=mb.step(np.eye(12)[0])))
    for row, switch in enumerate(found.switch):
        if switch:
            around = switch * np.array([0.999, 1.001])
            assert np.abs(found(around) - modal(around))[row].max() <= 64 * EPS * np.abs(found(np.linspace(0, 20, 50))).max()


def test_what_the_modes_know_as_well_is_left_to_them():
    """A decay from 1: the series of e^-t would lose digits for nothing."""
    found, _ = function(mb.solve(mb.PolynomialMatrix([[[1.0]], [[1.0]]]), [[1.0]]))
    times = np.linspace(0, 9, 40)
    assert np.allclose(found(times), np.exp(-times)[None], rtol=4 * EPS, atol=0)


# the algebra


def test_derivatives_maps_and_sums_keep_their_accuracy():
    """x'' + x = f: the same numbers as f, that is 1, from t = 1e-12 on; and x - x is nothing at all."""
    found, _ = function(mb.solve(chain(1), force=mb.step([1.0])))
    again = found.derivative(2) + 0.25 * found.derivative(1) + found.mapped([[2.0]])
    times = np.array([1e-12, 1e-6, 0.1, 1.0, 30.0])
    assert np.allclose(again(times), 1.0, rtol=1e-14)
    assert not (found - found)(times).any()
    assert np.allclose((found + mb.ramp([1.0]).smooth - mb.ramp([1.0]).smooth)(times[:3]), found(times[:3]), rtol=1e-3)
    assert np.allclose(found.derivative(1)(1e-9), 1e-9, rtol=1e-9)


def test_the_series_of_a_bohl_function_is_exact_where_its_terms_cancel():
    """e^-t - e^-2t - t = -3 t^2 / 2 + ...."""
    f = mb.term([1.0], rate=-1.0) + mb.term([-1.0], rate=-2.0) - mb.ramp([1.0])
    t = Fraction(1, 2**20)
    known = sum(((-1) ** k - (-2) ** k) * t**k / factorial(k) for k in range(2, 8))
    assert series_of(f.smooth, 1.0)(float(t))[0] == pytest.approx(float(known), rel=1e-14)


def test_the_series_ends_where_the_force_changes():
    x = mb.solve(mb.PolynomialMatrix([[[1.0]], [[0.0]], [[1.0]]]), force=mb.step([1.0]) + mb.step([5.0]).delayed(0.25))
    found, modal = function(x)
    assert found.series.span <= 0.25
    assert np.allclose(found([0.2, 0.25, 0.3, 1.0]), modal([0.2, 0.25, 0.3, 1.0]), rtol=1e-13)
