"""Two-point boundary values against closed forms, collocation and degenerate cases."""

import math

import numpy as np
import pytest
import scipy.integrate

import mbconstrained as mb


def oscillator(k=4.0, c=0.0):
    return mb.MechanicalSystem([[1.0]], [[c]], [[k]])


def test_oscillator():
    x = mb.boundary_solve(oscillator(), start={"x1": 0.5}, end={"x1": 1.0}, duration=0.7)
    t = np.linspace(0.0, 0.7, 9)
    exact = (0.5 * np.sin(2 * (0.7 - t)) + np.sin(2 * t)) / np.sin(1.4)
    assert np.abs(x.displacement(t)[0] - exact).max() < 1e-14
    assert not x.notices and x.boundary.rank == 2 and x.boundary.residual < 1e-14
    assert x.error_estimate(t) < 1e-12


def test_growing_motions_are_measured_at_the_end():
    """x'' = 100 x over 20 s: e^{200} between the ends."""
    x = mb.boundary_solve(oscillator(-100.0), start={"x1": 1.0}, end={"x1": 2.0}, duration=20.0)
    t = np.array([0.0, 0.1, 1.0, 19.0, 19.9, 20.0])
    exact = np.exp(-10 * t) + 2 * np.exp(-10 * (20 - t))
    assert np.abs(x(t)[0] / exact - 1).max() < 1e-12
    assert x.boundary.condition < 10
    with pytest.raises(mb.Overflow, match="shorter"):
        mb.boundary_solve(oscillator(-100.0), start={"x1": 1.0}, end={"x1": 2.0}, duration=80.0)


def test_chain_against_collocation_with_force_and_velocities():
    n, T = 4, 1.5
    M = np.diag([1.0, 2.0, 1.0, 3.0])
    K = 20 * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    C = 0.02 * K
    system = mb.MechanicalSystem(M, C, K)
    x = mb.boundary_solve(
        system,
        start={"displacement": {"x1": 0.1, "x2": 0.0, "x3": 0.0}, "velocity": {"x4": 1.0}},
        end={"x1": 0.0, "x2": 0.2, "velocity": {"x3": 0.0, "x4": -1.0}},
        duration=T,
        force={"x2": mb.harmonic(3.0, angular_frequency=2.0)},
    )
    inverse = np.linalg.inv(M)

    def rate(t, y):
        load = np.zeros((n, len(t)))
        load[1] = 3 * np.cos(2 * t)
        return np.vstack([y[n:], inverse @ (load - C @ y[n:] - K @ y[:n])])

    def ends(a, b):
        return np.array([a[0] - 0.1, a[1], a[2], a[7] - 1, b[0], b[1] - 0.2, b[6], b[7] + 1])

    reference = scipy.integrate.solve_bvp(rate, ends, np.linspace(0, T, 50), np.zeros((2 * n, 50)), tol=1e-9, max_nodes=20000)
    t = np.linspace(0.0, T, 11)
    assert reference.success
    assert np.abs(x.displacement(t) - reference.sol(t)[:n]).max() < 1e-7
    assert np.abs(x.velocity(t) - reference.sol(t)[n:]).max() < 1e-6


def test_polynomial_matrix_of_third_degree():
    """x''' = 0: the parabola through three values."""
    A = mb.PolynomialMatrix([[[0.0]], [[0.0]], [[0.0]], [[1.0]]], coordinates=["y"])
    x = mb.boundary_solve(A, start={"y": 1.0, "velocity": {"y": 0.0}}, end={"y": 5.0}, duration=2.0)
    t = np.linspace(0.0, 2.0, 5)
    assert np.allclose(x(t)[0], 1 + t**2, rtol=1e-13)


def test_conjugate_point():
    T = math.pi / 2
    with pytest.raises(mb.ContradictoryConstraints, match="x1 at T"):
        mb.boundary_solve(oscillator(), start={"x1": 0.0}, end={"x1": 1.0}, duration=T)
    x = mb.boundary_solve(oscillator(), start={"x1": 1.0}, end={"x1": -1.0}, duration=T)
    assert any("conjugate point" in notice.text for notice in x.notices)
    assert len(x.boundary.undetermined) == 1
    assert np.allclose(x(np.array([0.0, 0.3]))[0], np.cos([0.0, 0.6]), atol=1e-13)  # least values: no sine


def test_too_few_and_too_many():
    x = mb.boundary_solve(oscillator(), start={"x1": 1.0}, duration=1.0)
    assert "1 motion free" in x.notices[0].text and math.isclose(x(0.0)[0], 1.0, rel_tol=1e-13)
    with pytest.raises(mb.ContradictoryConstraints):
        mb.boundary_solve(oscillator(), start={"x1": 1.0, "velocity": {"x1": 0.0}}, end={"x1": 0.0}, duration=1.0)
    consistent = {"x1": math.cos(2.0)}
    assert not mb.boundary_solve(
        oscillator(), start={"displacement": [1.0], "velocity": [0.0]}, end=consistent, duration=1.0
    ).notices


def test_singular_mass_and_constraint():
    """A massless coordinate in the middle of two springs in series, and a constraint with a value."""
    K = np.array([[5.0, -5.0], [-5.0, 10.0]])
    massless = mb.MechanicalSystem(np.diag([1.0, 0.0]), stiffness=K, names=["m", "joint"])
    x = mb.boundary_solve(massless, start={"joint": 0.5}, end={"m": 0.0}, duration=0.4)
    w = math.sqrt(2.5)
    t = np.linspace(0, 0.4, 5)
    exact = np.sin(w * (0.4 - t)) / math.sin(0.4 * w)
    assert np.allclose(x.displacement(t), [exact, exact / 2], atol=1e-13)
    tied = mb.MechanicalSystem(
        np.eye(2),
        stiffness=np.diag([4.0, 0.0]),
        constraints=[mb.Constraint([1, -1], level="position", value=0.2)],
        names=["a", "b"],
    )
    y = mb.boundary_solve(tied, start={"a": 0.0}, end={"b": 0.3}, duration=0.5)
    w = math.sqrt(2.0)
    a = 0.5 * np.sin(w * np.linspace(0, 0.5, 4)) / math.sin(w * 0.5)
    assert np.allclose(y.displacement(np.linspace(0, 0.5, 4)), [a, a - 0.2], atol=1e-13)
    assert np.abs(y.jump).max() == 0
    with pytest.raises(mb.ContradictoryConstraints):
        mb.boundary_solve(tied, start={"a": 0.0, "b": 0.0}, end={"b": 0.3}, duration=0.5)


def test_impulse_at_zero_acts_before_the_start_value():
    x = mb.boundary_solve(oscillator(), start={"x1": 0.0}, end={"x1": 1.0}, duration=0.5, force=mb.impulse([3.0]))
    assert np.isclose(x(0.25)[0], math.sin(0.5) / math.sin(1.0))
    assert math.isclose(x.jump[1, 0], 3.0, rel_tol=1e-12)


def test_no_finite_states():
    A = mb.PolynomialMatrix([[[2.0]]], coordinates=["y"])
    assert mb.boundary_solve(A, start={"y": 1.0}, duration=1.0, force=mb.step([2.0]))(0.5)[0] == 1.0
    with pytest.raises(mb.ContradictoryConstraints):
        mb.boundary_solve(A, start={"y": 2.0}, duration=1.0, force=mb.step([2.0]))


@pytest.mark.parametrize(
    "options, message",
    [
        ({"start": {"x2": 0.0}, "duration": 1.0}, 'no coordinate "x2"'),
        ({"start": {"velocity": {"y": 0.0}}, "duration": 1.0}, 'no coordinate "y"'),
        ({"start": {"x1": math.nan}, "duration": 1.0}, "x1"),
        ({"start": {"x1": 0.0, "displacement": {"x1": 1.0}}, "duration": 1.0}, "twice"),
        ({"start": [0.0], "duration": 1.0}, "by name"),
        ({"start": {"x1": 0.0}}, "duration"),
        ({"start": {"x1": 0.0}, "duration": 0.0}, "duration"),
    ],
)
def test_bad_input(options, message):
    with pytest.raises(mb.InputError, match=message):
        mb.boundary_solve(oscillator(), **options)


def test_singular_pencil_is_refused():
    with pytest.raises(mb.SingularPolynomialMatrix):
        mb.boundary_solve(mb.MechanicalSystem([[0.0]]), start={"x1": 0.0}, duration=1.0)
