"""Break points in closed form and against exact discriminants; crossings and near coalescences are none."""

import numpy as np
import pytest
import sympy

import mbconstrained as mb
from mbconstrained.polynomial.variation import MatrixFamily, break_points, followed


def points(base, slope, parameters):
    """The break points of K, C, M = base + p slope."""
    family = MatrixFamily.linear(np.array(base, dtype=float), np.array(slope, dtype=float))
    return break_points(family, followed(family, np.asarray(parameters, dtype=float)))


@pytest.mark.parametrize("grid", [np.linspace(0, 10, 6), np.linspace(0, 10, 11), np.linspace(3.99, 4.01, 4), [3.0, 4.0, 5.0]])
def test_critical_damping(grid):
    """c = 2 sqrt(k m), s = -sqrt(k / m); also where a value of the grid is the break point."""
    (point,) = points([[[4]], [[0]], [[1]]], [[[0]], [[1]], [[0]]], grid)
    assert point.parameter == pytest.approx(4.0, rel=1e-14)
    assert point.eigenvalue == pytest.approx(-2.0, rel=1e-14)
    assert point.residual < 1e-14


def test_two_equal_oscillators_have_a_break_point_each():
    K, C, M = 4 * np.eye(2), np.eye(2), np.eye(2)
    found = points([K, 0 * C, M], [0 * K, C, 0 * M], np.linspace(0, 10, 8))
    assert [point.parameter for point in found] == pytest.approx([4.0, 4.0], rel=1e-14)
    assert [np.abs(point.shape).tolist() for point in found] == [[1.0, 0.0], [0.0, 1.0]]


def test_flutter_of_a_circulatory_pair():
    """K = [[1, p], [-p, 2]]: (w^2 - 1)(w^2 - 2) + p^2 = 0 is double at p = 1/2, w^2 = 3/2 (Ziegler, Principles of Structural Stability)."""
    (point,) = points(
        [np.diag([1, 2]), np.zeros((2, 2)), np.eye(2)], [[[0, 1], [-1, 0]], np.zeros((2, 2)), np.zeros((2, 2))], [0, 0.2, 1]
    )
    assert point.parameter == pytest.approx(0.5, rel=1e-14)
    assert point.eigenvalue.imag == pytest.approx(np.sqrt(1.5), rel=1e-14)
    np.testing.assert_allclose(point.shape, [1.0, 1.0], atol=1e-13)


def exact_break_points(K, C, slope, low, high):
    """The real roots of the discriminant of det(s^2 + (C + p slope) s + K) whose double root in s is real, with 30 digits."""
    s, p = sympy.symbols("s p")
    K, C, slope = (sympy.Matrix(matrix).applyfunc(lambda entry: sympy.Rational(float(entry))) for matrix in (K, C, slope))
    A = K + s * (C + p * slope) + s**2 * sympy.eye(K.rows)
    characteristic = sympy.Poly(A.det(), s)
    roots = sympy.Poly(characteristic.discriminant(), p).nroots(n=30, maxsteps=200)
    return sorted(float(sympy.re(root)) for root in roots if abs(sympy.im(root)) < 1e-20 and low < sympy.re(root) < high)


@pytest.mark.parametrize(
    "K, C, slope",
    [
        ([[5, -2], [-2, 3]], [[0, 0], [0, 0]], [[1, -1], [-1, 1]]),
        ([[5, -2], [-2, 3]], [[1, 0], [0, 0]], [[1, 0], [0, 2]]),
        ([[9, -4, 0], [-4, 7, -3], [0, -3, 3]], [[1, -1, 0], [-1, 2, -1], [0, -1, 1]], [[1, 0, 0], [0, 1, 0], [0, 0, 3]]),
    ],
)
def test_break_points_are_the_roots_of_the_discriminant(K, C, slope):
    zero = np.zeros_like(K)
    found = points([K, C, np.eye(len(K))], [zero, slope, zero], np.linspace(0.0, 12.0, 61))
    expected = exact_break_points(K, C, slope, 0.0, 12.0)
    assert len(expected)
    np.testing.assert_allclose([point.parameter for point in found], expected, rtol=1e-12)


def test_crossings_and_veerings_are_no_break_points():
    """Two uncoupled oscillators cross, weakly coupled ones veer; a damped pair near its exceptional point misses it."""
    zero = np.zeros((2, 2))
    for coupling in (0.0, 0.01):
        K = np.array([[1.0, coupling], [coupling, 2.0]])
        assert not points([K, zero, np.eye(2)], [np.diag([1.0, 0.0]), zero, zero], np.linspace(0.0, 2.0, 21))
    scene = mb.read_scene("examples/tuned_mass_damper.toml")
    locus = scene.root_locus("zeta", np.linspace(0.01, 0.6, 41))
    gaps = np.abs(locus.eigenvalues[:, :, None] - locus.eigenvalues[:, None]) + 1e9 * np.eye(4)
    assert gaps.min() < 1.0 and not locus.break_points


def test_the_locus_of_a_model_and_its_limits_of_stability():
    """x'' + c x' + x = 0 with c from -1 to 3: it is unstable below 0, aperiodic from 2 on."""
    oscillator = mb.MechanicalSystem([[1.0]], [[1.0]], [[1.0]])
    locus = oscillator.root_locus("damping[x1, x1]", np.linspace(-1.0, 3.0, 10))
    assert locus.stability_limits == pytest.approx([0.0], abs=1e-15)
    assert [point.parameter for point in locus.break_points] == pytest.approx([2.0], rel=1e-14)
    assert locus.damping_ratios[-1] == pytest.approx([1.0, 1.0])


def test_a_parameter_that_the_matrices_do_not_depend_on_linearly():
    """k = m w^2 of a frequency w: critical damping c = 2 m w, here over w of a scene."""
    scene = mb.read_scene("examples/tuned_mass_damper.toml")
    by_frequency = scene.root_locus("tuning", np.linspace(0.5, 1.5, 11))
    for tuning, column in zip(by_frequency.values, by_frequency.eigenvalues):
        modes = mb.read_scene(scene.path, {"tuning": float(tuning)}).equations.system.modes().eigenvalues
        np.testing.assert_allclose(np.sort(column[column.imag > 0].imag), np.sort(modes.imag), rtol=1e-10)


@pytest.mark.parametrize(
    "name, values, message",
    [
        ("damping[x1, x2]", [1.0, 2.0], 'no parameter "damping\\[x1, x2\\]"; did you mean "damping\\[x1, x1\\]"'),
        ("damping[x1, x1]", [2.0, 1.0], "ascending"),
        ("damping[x1, x1]", [1.0], "two or more"),
        ("damping[x1, x1]", [1.0, np.inf], "finite"),
    ],
)
def test_what_is_wrong_is_named(name, values, message):
    with pytest.raises(mb.InputError, match=message):
        mb.MechanicalSystem([[1.0]], [[1.0]], [[1.0]]).root_locus(name, values)


def test_rows_that_change_are_refused():
    model = mb.LumpedModel()
    model.rigid_bar("bar", 1.0, inertia=1.0, points={"end": 1.0})
    model.spring("ground", "end", 4.0)
    with pytest.raises(mb.InputError, match="constraint rows change"):
        model.assemble().root_locus("bar.end", [0.5, 1.5])
