"""The explicit acceleration of Udwadia and Phohomsiri, its uniqueness test, and the force of the constraints."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained import InputError, NotUnique
from mbconstrained.mechanics.constraints import Constraint
from mbconstrained.mechanics.system import MechanicalSystem
from tests.mechanics.systems import massless_joints, two_masses

STATE = [0.8, 1.2, 2.0]


@pytest.mark.parametrize("m, k", [(10.0, 2.0), (1e-6, 5.0), (3e4, 1e9)])
@pytest.mark.parametrize("level", ["position", "velocity", "acceleration"])
def test_singular_mass_matrix_of_the_paper(m, k, level):
    # Moysis et al., Eq. 83 (the result of Udwadia and Phohomsiri 2006), with equal masses and springs
    x1, _, q2 = STATE
    expected = [k * (q2 - x1) / m, k * (q2 - x1) / m, -k * (2 * q2 - x1) / m]
    assert np.allclose(two_masses(level, m, k).acceleration(STATE, np.zeros(3)), expected, rtol=1e-13)


def test_massless_coordinates_have_no_acceleration_of_their_own():
    with pytest.raises(NotUnique, match=r'acceleration of "u1", "u2" is not determined: rank \[M; A\] = 1, with 3 coordinates'):
        massless_joints().acceleration([0, 0, 1], [0, 0, 0])


def test_rounding_makes_no_mass():
    # the mass moves only against the gear: V^T M = 0 by ratio * m - m * ratio
    ratio = 0.1
    mass = 0.7 * np.array([[1.0, -ratio], [-ratio, ratio * ratio]])
    geared = MechanicalSystem(mass, constraints=Constraint([1, -ratio]), names=["wheel", "pinion"])
    with pytest.raises(NotUnique, match='acceleration of "wheel", "pinion" is not determined'):
        geared.acceleration([0, 0], [0, 0])


def test_wrong_states_are_named():
    system = two_masses()
    with pytest.raises(InputError, match="displacement: expected shape 3, found 2"):
        system.acceleration([1, 2], [0, 0, 0])
    with pytest.raises(InputError, match='velocity: there is no coordinate "speed"'):
        system.acceleration([0, 0, 0], {"speed": 1.0})


@st.composite
def constrained_systems(draw, singular=False):
    n = draw(st.integers(1, 4))
    whole = st.integers(-3, 3)
    square = st.lists(st.lists(whole, min_size=n, max_size=n), min_size=n, max_size=n)
    factor = np.array(draw(square), float)
    mass = factor.T @ factor + (0 if singular else np.eye(n))
    rows = np.array(draw(st.lists(st.lists(whole, min_size=n, max_size=n), max_size=n)), float).reshape(-1, n)
    system = MechanicalSystem(mass, draw(square), draw(square), Constraint(rows, level="acceleration"))
    return system, *(np.array(draw(st.lists(whole, min_size=n, max_size=n)), float) for _ in range(3))


@given(constrained_systems())
def test_it_is_udwadia_and_kalaba_for_a_regular_mass_matrix(case):
    system, x, v, f = case
    A = system.constraint_matrix
    free = np.linalg.solve(system.mass, f - system.damping @ v - system.stiffness @ x)
    values, vectors = np.linalg.eigh(system.mass)
    root = vectors / np.sqrt(values) @ vectors.T  # M^(-1/2)
    expected = free + root @ np.linalg.pinv(A @ root) @ (-A @ free)  # Udwadia and Kalaba 1992, with b = 0
    assert np.allclose(system.acceleration(x, v, f), expected, rtol=1e-9, atol=1e-9 * (1 + np.abs(free).max()))


@given(constrained_systems(singular=True))
def test_it_is_udwadia_and_phohomsiri_or_is_refused(case):
    system, x, v, f = case
    form = system.constrained_form()
    M = form.polynomial_matrix.coefficients[2]
    if np.linalg.matrix_rank(M) < system.size:
        with pytest.raises(NotUnique, match="is not determined"):
            system.acceleration(x, v, f)
        return
    n = form.null_space.shape[1]
    right = np.concatenate([form.null_space.T @ (f - system.damping @ v - system.stiffness @ x), np.zeros(system.size - n)])
    expected = np.linalg.solve(M, right)
    A = system.constraint_matrix
    stacked = np.vstack([(np.eye(system.size) - np.linalg.pinv(A) @ A) @ system.mass, A])  # the formula as published
    load = np.concatenate([f - system.damping @ v - system.stiffness @ x, np.zeros(len(A))])
    assert np.allclose(np.linalg.pinv(stacked) @ load, expected, rtol=1e-8, atol=1e-8 * (1 + np.abs(expected).max()))
    assert np.allclose(system.acceleration(x, v, f), expected, rtol=1e-8, atol=1e-8 * (1 + np.abs(expected).max()))
    force = system.constraint_force(x, v, f)
    assert np.allclose(form.null_space.T @ force, 0, atol=1e-7 * (1 + np.abs(expected).max()))  # f_c = A^T lambda
