"""Inputs of least energy against closed forms, exact integrals and degenerate cases."""

import math

import numpy as np
import pytest
import scipy.integrate

import mbconstrained as mb


def test_double_integrator():
    cart = mb.MechanicalSystem([[2.0]], names=["cart"])
    u = mb.least_energy_input(cart, inputs=["cart"], start={"cart": 1.0}, end={"cart": 4.0}, duration=3.0)
    t = np.linspace(0.0, 2.9, 7)
    assert np.abs(u(t)[0] - 2 * 3 * (6 - 12 * t / 3) / 9).max() < 1e-13
    assert math.isclose(u.energy, 4 * 9 * 12 / 27, rel_tol=1e-13)
    assert u.error < 1e-13 and u(3.0)[0] == 0.0 and not u.notices
    assert np.allclose(u.motion.displacement([3.0, 10.0]), 4.0, rtol=1e-13)


def test_oscillator():
    """From rest to x = 1: W in closed form, u = [sin, cos] of w (T - t) times its inverse."""
    w, T = 3.0, 1.3
    s = mb.MechanicalSystem([[1.0]], stiffness=[[w**2]])
    u = mb.least_energy_input(s, end={"displacement": {"x1": 1.0}, "velocity": [0.5]}, duration=T)
    s2, c2, sc = (T / 2 - math.sin(2 * w * T) / (4 * w)), (T / 2 + math.sin(2 * w * T) / (4 * w)), math.sin(w * T) ** 2 / (2 * w)
    W = np.array([[s2 / w**2, sc / w], [sc / w, c2]])
    weights = np.linalg.solve(W, [1.0, 0.5])
    t = np.linspace(0.0, 1.2, 6)
    assert np.abs(u(t)[0] - weights @ [np.sin(w * (T - t)) / w, np.cos(w * (T - t))]).max() < 1e-12
    assert math.isclose(u.energy, weights @ [1.0, 0.5], rel_tol=1e-12)


@pytest.mark.parametrize("T", [2.0, 60.0])
def test_damped_chain(T):
    K = 20 * (2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1))
    system = mb.MechanicalSystem(np.diag([1.0, 2.0, 3.0]), 0.05 * K, K, names=["a", "b", "c"])
    u = mb.least_energy_input(system, ["a"], {"c": 0.1}, {"velocity": {"c": 0.2}}, T)
    assert u.error < 1e-8
    energy = scipy.integrate.quad_vec(lambda t: u(t) ** 2, 0.0, T * (1 - 1e-15), epsrel=1e-10)[0][0]
    assert math.isclose(u.energy, energy, rel_tol=1e-6)
    more = mb.least_energy_input(system, ["a", "b"], {"c": 0.1}, {"velocity": {"c": 0.2}}, T)
    assert more.energy < u.energy and u.condition > more.condition


def test_very_stiff_decay_keeps_its_input():
    """x' = -1000 x + u by a massless coordinate over 2 s: u = 2000 e^{-1000 (T - t)} x(T) / (1 - e^{-4000})."""
    system = mb.MechanicalSystem([[0.0]], [[1.0]], [[1000.0]])
    u = mb.least_energy_input(system, end={"x1": 1.0, "velocity": {"x1": -1000.0}}, duration=2.0)
    t = np.array([0.0, 1.5, 1.9, 1.999])
    assert np.allclose(u(t)[0], 2000 * np.exp(-1000 * (2.0 - t)), rtol=1e-9)


def test_free_drift_with_a_constraint_and_a_constant_force():
    system = mb.MechanicalSystem(
        np.eye(2), constraints=[mb.Constraint([1, -1], level="position", value=0.2)], names=["a", "b"], static_force=[1.0, 0.0]
    )
    u = mb.least_energy_input(system, ["b"], {"a": 0.2}, {"a": 1.2, "b": 1.0}, 1.0)
    t = np.array([0.0, 0.5, 0.9])
    assert np.abs(u(t)[0] - (2 * (6 - 12 * t) - 1)).max() < 1e-12
    with pytest.raises(mb.InputError, match="violates the constraints"):
        mb.least_energy_input(system, ["b"], {"a": 0.2}, {"a": 1.2, "b": 0.0}, 1.0)


def test_unreachable_state_is_named():
    """A symmetric pair driven at its centre: the difference of the outer masses is not reachable."""
    K = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]])
    system = mb.MechanicalSystem(np.eye(3), stiffness=K, names=["left", "centre", "right"])
    with pytest.raises(mb.InputError, match="left.*right.* would be missing"):
        mb.least_energy_input(system, ["centre"], None, {"left": 1.0, "right": -1.0}, 5.0)
    assert mb.least_energy_input(system, ["centre"], None, {"left": 1.0, "right": 1.0}, 5.0).error < 1e-10


def test_nothing_to_do():
    u = mb.least_energy_input(mb.MechanicalSystem([[1.0]]), duration=1.0)
    assert u.energy == 0 and (u([0.0, 0.5]) == 0).all()


@pytest.mark.parametrize(
    "options, message",
    [
        ({"inputs": ["cart2"], "duration": 1.0}, "inputs"),
        ({"end": {"cat": 1.0}, "duration": 1.0}, 'end.*"cat"'),
        ({"end": {"velocity": {"cat": 1.0}}, "duration": 1.0}, 'end.*"cat"'),
        ({"end": {"cart": math.inf}, "duration": 1.0}, "end"),
        ({"end": [1.0], "duration": 1.0}, "end"),
        ({}, "duration"),
        ({"duration": -1.0}, "duration"),
    ],
)
def test_bad_input(options, message):
    with pytest.raises(mb.InputError, match=message):
        mb.least_energy_input(mb.MechanicalSystem([[1.0]], names=["cart"]), **options)
