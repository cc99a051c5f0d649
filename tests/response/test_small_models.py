"""Small plain models: the reduced equations against the Jordan pairs, for every kind of part that they may have."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.ground.tolerances import DIVISOR_CONDITION
from mbconstrained.polynomial.reduced_equations import NotReducible
from mbconstrained.response.methods.reduced_solution import ReducedSolution
from tests.linalg.few_couplings import assembled

from .plain_models import general

TIMES = np.concatenate([[0.0, 1e-9, 1e-3], np.linspace(0.1, 25.0, 40)])


def is_reduced(x) -> bool:
    return isinstance(x.solution, ReducedSolution)


def agree(x, tolerance: float = 3e-12) -> None:
    """Values, two derivatives, jumps, events, what is said: as through the pencil."""
    expected = general(x)
    for order in (0, 1, 2):
        values = expected.derivative(order)(TIMES)
        assert np.abs(x.derivative(order)(TIMES) - values).max() <= tolerance * max(
            np.abs(values).max(), np.abs(x.initial).max(), 1.0
        )
    assert np.array_equal(x.jump != 0, expected.jump != 0)
    assert np.abs(x.jump - expected.jump).max() <= 1e-12 * max(np.abs(expected.jump).max(), 1.0)
    assert x.impulses == expected.impulses == ()
    assert [event.time for event in x.events] == [event.time for event in expected.events]
    for one, two in zip(x.events, expected.events):
        assert np.array_equal(one.jump != 0, two.jump != 0)
    assert [notice.text for notice in x.notices] == [notice.text for notice in expected.notices]
    if is_reduced(x):  # the evidence is that of the method
        residual, decoupling, condition = x.evidence
        assert (residual.name, decoupling.name, condition.name) == ("residual", "decoupling", "condition")
        assert residual.value <= 1e-10 and condition.value <= DIVISOR_CONDITION


@given(
    seed=st.integers(0, 10**6),
    size=st.integers(2, 6),
    level=st.sampled_from(["velocity", "acceleration"]),
    damped=st.booleans(),
    value=st.sampled_from([0.0, 0.5]),
)
def test_rows_that_drift(seed, size, level, damped, value):
    """Rows without stiffness: zeros at s = 0 exactly, once or twice."""
    random = np.random.default_rng(seed)
    links = [(node - 1, node) for node in range(size)]
    K = assembled(links, random.uniform(0.5, 2.0, size), size)
    C = 0.1 * assembled(links[::2], random.uniform(0.5, 2.0, len(links[::2])), size) if damped else None
    row = np.zeros(size)
    row[random.permutation(size)[:2]] = 1.0, -random.uniform(0.5, 2.0)
    system = mb.MechanicalSystem(np.diag(random.uniform(0.5, 2.0, size)), C, K, [mb.Constraint(row, level=level, value=value)])
    x0, v0 = random.normal(size=(2, size))
    if level == "velocity":
        v0 = v0 - row * (row @ v0 - value) / (row @ row)
    x = system.solve(x0, v0)
    assert is_reduced(x) == (level == "acceleration")  # one at velocity level leaves fewer equations for masses than there are
    agree(mb.solve(x.polynomial_matrix, x.initial, x.force), 1e-11)
    assert np.abs(row @ x.derivative(1 if level == "velocity" else 2)(TIMES) - value).max() <= 1e-12 * max(
        np.abs(x(TIMES)).max(), 1.0
    )


@pytest.mark.parametrize("ratio", [0.0, 1e-12, 1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("what", ["damping", "frequency"])
def test_repeated_and_nearly_repeated_zeros(what, ratio):
    """Critical damping, and two equal frequencies with and without a coupling that makes them defective."""
    K, C, M = np.diag([4.0, 4.0 * (1 + ratio)]), np.diag([4.0, 4.0]), np.eye(2)
    if what == "frequency":
        K, C = K + [[0.0, 0.5], [0.0, 0.0]], 0 * C
    x = mb.solve(mb.PolynomialMatrix([K, C, M]), [[1.0, -2.0], [0.5, 3.0]])
    box = x.enclose(TIMES[3:], 20)
    proved = np.array(box.error_bounds(x(TIMES[3:])), dtype=float).max()
    assert proved <= x.error_estimate(TIMES[3:]) * np.abs(x(TIMES)).max() <= 1e-12 * np.abs(x(TIMES)).max()


@pytest.mark.parametrize("mass", [1e-14, 1e-6, 1e14])
def test_what_is_stiff_is_right_at_each_time(mass):
    x = mb.solve(
        mb.PolynomialMatrix([[[2.0, -1.0], [-1.0, 1.0]], np.zeros((2, 2)), np.diag([1.0, mass])]), [[1.0, -2.0], [0.5, 3.0]]
    )
    values = x(TIMES)
    errors = np.array(x.enclose(TIMES, 20).error_bounds(values), dtype=float)
    assert (errors.max(axis=0) <= 1e-12 * np.abs(values).max(axis=0)).all()


def test_stiffness_that_rounding_took_away_is_not_taken_for_none():
    """Tied, 1e15 - 1e15 + 3: whether a body is free the rank decisions have to say."""
    K = 1e15 * np.array([[1.0, -1.0], [-1.0, 1.0]]) + np.diag([3.0, 2.0])
    assert isinstance(mb.PolynomialMatrix([K, 0 * K, np.diag([1.0, 0.0])]).reduction, NotReducible)


def test_a_spring_without_mass_follows_its_force_without_modes():
    t = np.array([0.0, 1.0, 2.0])
    force = mb.step([1.0]) + mb.harmonic([1.0], angular_frequency=2.0)
    x = mb.MechanicalSystem([[0.0]], stiffness=[[1.0]]).solve(force=force)
    assert x(t)[0] == pytest.approx(1 + np.cos(2 * t), rel=1e-14)
    assert x.velocity(t)[0] == pytest.approx(-2 * np.sin(2 * t), rel=1e-14)
    assert x.acceleration(t)[0] == pytest.approx(-4 * np.cos(2 * t), rel=1e-14)


def test_a_free_mass_moves_on_for_ever():
    """Its zeros are 0 exactly, beside oscillations: x = x0 + v0 t to a rounding after 1e9 seconds."""
    x = mb.solve(mb.PolynomialMatrix([np.diag([1.0, 0.0]), np.zeros((2, 2)), np.eye(2)]), [[1.0, 3.0], [0.0, 2.0]])
    times = np.array([1.0, 1e4, 1e9])
    assert np.allclose(x(times)[1], 3.0 + 2.0 * times, rtol=1e-15, atol=0)


def test_like_parts_that_are_hardly_coupled_backward():
    """In balanced units their modes are apart; what the first drives the others by is a difference of motions 1e5 times larger."""
    n = 3
    K = 4.0 * np.eye(n) + 4e-12 * np.ones((n, n))
    K[1:, 0] += [0.1, -0.3]
    x = mb.solve(mb.PolynomialMatrix([K, 0.1 * np.eye(n), np.eye(n)]), [[-0.2, 0.05, 1.0], [0.3, -0.1, 0.2]])
    times = np.array([0.1, 0.5, 1.0, 3.0])
    assert np.array(x.enclose(times, 20).error_bounds(x(times)), dtype=float).max() <= 1e-13


def test_a_slow_motion_at_the_times_of_a_fast_force():
    """Zeros of 1e-4 beside a force of 2.7 rad/s: before they have turned, sums of their modes cancel."""
    K = np.array([[4e2, -4e5, 0.0], [-0.4, 1.1e3, -3e5], [0.0, -0.03, 30.0]])
    M = np.array([[1.3e9, -1e11, -1e14], [-1e5, 3e8, -5e11], [-10.0, -5e4, 9e7]])
    force = mb.harmonic([1e5, -1.0, 2.0], angular_frequency=4.1e-4) + mb.harmonic([1.0, 1.0, 0.5], angular_frequency=2.7)
    x, times = mb.solve(mb.PolynomialMatrix([K, 0 * K, M]), [[2.1, -0.4, 0.2], [1.2, 0.3, 0.8]], force), np.array([0.5, 0.8, 1.0])
    assert np.array(x.enclose(times, 20).error_bounds(x(times)), dtype=float).max() <= 1e-12


@pytest.mark.parametrize("mass", [0.0, 1.0])
@pytest.mark.parametrize("value", [0.0, 1.0])
def test_many_samples_that_do_nothing_or_move_nothing(mass, value):
    """A record of zeros, and one of a spring without mass, however many samples they have."""
    values = value * np.sin(np.arange(100.0))[None]
    x = mb.solve(
        mb.PolynomialMatrix([[[2.0]], [[0.0]], [[mass]]]), [[values[0, 0] / 2], [0.0]], mb.sampled(np.linspace(0, 3, 100), values)
    )
    assert np.abs(x(TIMES) - general(x)(TIMES)).max() <= 1e-13


def test_what_drives_a_growing_part_has_no_part_in_its_growth():
    """x1' = -x1 drives x2' = 3 x2 + x1: x1 stays e^{-t} to its last digits beside e^{3 t}."""
    A = mb.PolynomialMatrix([[[1.0, 0.0], [-1.0, -3.0]], [[1.0, 0.0], [0.0, 1.0]]])
    times = np.array([1.0, 10.0, 40.0])
    assert np.allclose(mb.solve(A, [[1.0, 1.0]])(times)[0], np.exp(-times), rtol=1e-12, atol=0)
