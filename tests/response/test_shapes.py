"""Degenerate systems and the shapes of what comes out."""

import numpy as np
import pytest

import mbconstrained as mb


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_no_coordinates_at_all(degree):
    A = mb.PolynomialMatrix([np.zeros((0, 0))] * (degree + 1))
    x = mb.solve(A)
    assert A.is_regular
    assert x(1.0).shape == (0,)
    assert x([1.0, 2.0]).shape == (0, 2)
    assert x.jump.shape == x.start.shape == x.initial.shape == (degree, 0)
    assert (x.impulses, x.notices) == ((), ())
    assert A.structure() == mb.polynomial.structure.Structure((0, 0), degree, (), ())
    assert x.error_estimate([1.0]) < 1e-15
    assert mb.admissible(A).dimensions == (0, 0, 0)


def test_one_algebraic_equation():
    """2 x = 1 + t + delta: no values at 0- exist, x follows the force with its impulse."""
    x = mb.solve(mb.PolynomialMatrix([[[2.0]]]), force=mb.step([1.0]) + mb.ramp([1.0]) + mb.impulse([1.0]))
    assert x([0.0, 1.0, 3.0]).tolist() == [[0.5, 1.0, 2.0]]
    assert x.derivative()(1.0).tolist() == [0.5]
    assert [v.tolist() for v in x.impulses] == [[0.5]]
    assert x.jump.shape == (0, 1)


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_too_high_a_declared_degree_answers_with_zero(degree):
    """x = 0 with a declared degree: whatever the values at 0-, x jumps to 0, and without an impulse."""
    A = mb.PolynomialMatrix([np.eye(2)] + [np.zeros((2, 2))] * degree)
    x = mb.solve(A, np.ones((degree, 2)))
    assert not x([0.0, 1.0]).any()
    assert np.array_equal(x.jump, -np.ones((degree, 2)))
    assert not x.start.any()
    assert x.impulses == ()


def test_a_second_derivative_of_x_equal_to_the_force():
    """x'' = f with everything: values, step, impulse and its derivative."""
    A = mb.PolynomialMatrix([[[0.0]], [[0.0]], [[1.0]]])
    x = mb.solve(A, [[1.0], [2.0]], mb.step([3.0]) + mb.impulse([4.0]) + mb.impulse([5.0], order=1))
    times = np.array([0.0, 1.0, 10.0])
    assert np.allclose(x(times), (1 + 5) + (2 + 4) * times + 1.5 * times**2, rtol=1e-14)
    assert x.jump.tolist() == [[5.0], [4.0]]
    assert x.impulses == ()


def test_a_hammer_changes_the_velocity_and_nothing_else():
    """(s + 1)^2 x = delta: x = t e^{-t}; the position does not jump."""
    x = mb.solve(mb.PolynomialMatrix([[[1.0]], [[2.0]], [[1.0]]]), force=mb.impulse([1.0]))
    assert x.jump[0].tolist() == [0.0]
    assert x.jump[1, 0] == pytest.approx(1.0, rel=1e-15)
    assert x(2.0)[0] == pytest.approx(2 * np.exp(-2.0), rel=1e-14)
    assert [notice.text for notice in x.notices] == ["x1: its velocity jumps at t = 0 from 0 to 1"]


def test_shapes_follow_the_times():
    x = mb.solve(mb.PolynomialMatrix([np.eye(3), np.eye(3)]), np.ones((1, 3)))
    for f in (x, x.derivative(), x.derivative(2), x.function):
        assert f(1.0).shape == f(np.float64(1.0)).shape == f(np.array(1.0)).shape == (3,)
        assert f([]).shape == (3, 0)
        assert f(range(4)).shape == (3, 4)


@pytest.mark.parametrize("exponent", [-1000, -500, -100, 100, 500, 1000])
def test_amplitude_is_only_a_factor(exponent):
    """Values and force times 2^n: everything in the answer times 2^n, to the last bit, zeros included."""
    K, row = np.array([[2.0, -1.0], [-1.0, 3.0]]), np.array([1.0, -1.0])
    A = np.zeros((3, 3, 3))
    A[0, :2, :2], A[0, :2, 2], A[0, 2, :2], A[2, :2, :2] = K, -row, row, np.eye(2)
    matrix, factor = mb.PolynomialMatrix(A), 2.0**exponent
    start, force = np.array([[0.3, 0.1, 0.0], [0.0, 0.7, 0.0]]), mb.step([1.0, 0.0, 0.2]) + mb.impulse([0.0, 1.0, 0.0])
    x, y = mb.solve(matrix, start, force), mb.solve(matrix, factor * start, factor * force)
    assert np.array_equal(y.jump, factor * x.jump)
    assert len(y.impulses) == len(x.impulses) > 0
    assert all(np.array_equal(mine, factor * other) for mine, other in zip(y.impulses, x.impulses))
    assert np.array_equal(y([0.0, 1.0]), factor * x([0.0, 1.0]))
    mine, other = (mb.admissible(matrix, times * start, times * force) for times in (factor, 1.0))
    assert np.allclose(mine.nearest / factor, other.nearest, rtol=1e-14)
    assert np.allclose(mine.nearest_continuous / factor, other.nearest_continuous, rtol=1e-14)
