"""The estimate of the error: never far below the error, and quiet where there is none to speak of."""

import numpy as np
import pytest
import scipy.linalg

import mbconstrained as mb
from mbconstrained.ground.tolerances import UNCLEAR_ERROR
from mbconstrained.response.estimate import error_estimate
from tests.oracles.ball_exponential import motion

EPS = np.finfo(float).eps


def test_zero_is_known_to_the_last_place():
    x = mb.solve(mb.PolynomialMatrix([[[1.0]], [[1.0]]]))
    assert x.error_estimate([0.0, 1.0]) == EPS
    assert x.error_estimate([]) == EPS


def test_the_estimate_is_reproducible():
    x = mb.solve(mb.PolynomialMatrix([[[1.0]], [[0.0]], [[1.0]]]), [[1.0], [0.0]])
    times = np.linspace(0, 100, 11)
    assert x.error_estimate(times) == x.error_estimate(times)


#: So many equal parts of one to four states are no small model any more, whose answers are proved.
PARTS = 26


def in_parts(A: mb.PolynomialMatrix) -> mb.PolynomialMatrix:
    """The same equations many times."""
    return mb.PolynomialMatrix([np.kron(np.eye(PARTS), matrix) for matrix in A.coefficients])


@pytest.mark.parametrize("periods", [1.0, 1e3, 1e6])
def test_the_estimate_grows_with_the_phase_error(periods):
    """Half a unit in the last place of the stiffness moves the phase by eps w t / 4; as it is given the answer is right."""
    x = mb.solve(mb.PolynomialMatrix([[[1.0]], [[0.0]], [[1.0]]]), [[1.0], [0.0]])
    estimate = x.error_estimate(2 * np.pi * periods + np.linspace(0, 1, 5))
    phase = 2 * np.pi * periods * EPS
    assert min(0.1 * phase, 1e-13) <= estimate <= min(100 * phase, 1e-12)


def test_the_estimate_sees_an_ill_conditioned_answer():
    """k1 - k2 of two almost equal stiffnesses: x = f / (k1 - k2) keeps half of the digits."""
    A = mb.PolynomialMatrix([[[1.0, 1.0], [1.0, 1.0 + 1e-8]]])
    x = mb.solve(A, force=mb.step([1.0, 0.0]))
    assert 1e-9 <= x.error_estimate(1.0) <= 1e-6


def test_the_estimate_of_a_well_conditioned_answer_is_a_few_roundings():
    x = mb.solve(mb.PolynomialMatrix([np.diag([1.0, 2.0]), np.eye(2)]), [[1.0, 1.0]])
    assert x.error_estimate(np.linspace(0, 2, 5)) <= 20 * EPS


# what is read off an answer


def test_a_derivative_loses_what_the_value_does_not():
    """Two bodies lean on each other and sink at x' = -5e-7 x: a small difference of entries near 1."""
    A = mb.PolynomialMatrix([[[1.0, -1.0], [-1.0, 1.0 + 1e-6]], np.eye(2)])
    times = np.array([5.0, 10.0, 20.0])
    small = mb.solve(A, [[1.0, 1.0]])
    assert error_estimate(small, times, lambda response: response.derivative(1)) <= 1e-12
    x = mb.solve(in_parts(A), np.ones((1, 2 * PARTS)))
    assert x.error_estimate(times) <= 100 * EPS
    assert 1e5 * EPS <= error_estimate(x, times, lambda response: response.derivative(1)) <= 1e9 * EPS


@pytest.mark.parametrize("order", [0, 1, 2, 3])
@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6])
def test_derivatives_of_a_decay_and_an_oscillation(order, ratio):
    """x1' = -w x1 and x2'' = -x2, coupled by a turn of the coordinates and of the equations: true error and estimate."""
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    A = [turn @ np.diag(d) @ turn.T for d in ([ratio, 1.0], [1.0, 0.0], [0.0, 1.0])]
    x = mb.solve(mb.PolynomialMatrix(A), [turn @ [1.0, 1.0], turn @ [-ratio, 0.0]])
    times = np.linspace(0.1, 3.0, 7) / ratio
    phase = times + order * np.pi / 2
    known = turn @ np.array([(-ratio) ** order * np.exp(-ratio * times), np.cos(phase)])
    found = x.derivative(order)(times)
    true = np.abs(found - known).max() / np.abs(known).max()
    estimate = error_estimate(x, times, lambda response: response.derivative(order))
    assert 0.1 * max(true, 8 * EPS) <= max(estimate, 8 * EPS) <= 1e3 * max(true, 8 * EPS)


# what counted as rounding


def pinned_pair(spring: float, mass) -> mb.PolynomialMatrix:
    """Springs of 3 and 2 N/m to the ground, and a stiff one between, assembled."""
    K = spring * np.array([[1.0, -1.0], [-1.0, 1.0]]) + np.diag([3.0, 2.0])
    return mb.PolynomialMatrix([K, 0 * K, np.diag(mass)])


@pytest.mark.parametrize("mass", [[1.0, 0.0], [1.0, 1.0]])
@pytest.mark.parametrize("spring", [1e15, 3e15, 1e16])
def test_springs_lost_beside_stiffer_ones_are_told(spring, mass):
    """The float matrix still has the springs, or a part; the answer without them is another motion. A small model keeps them."""
    A, times = pinned_pair(spring, mass), np.linspace(0, 5, 11)
    small = mb.solve(A, [[1.0, 1.0], [0.0, 0.0]])
    assert small.error_estimate(times) <= 1e-12 and small.enclose(times, 12).contains(small(times))
    if not all(mass):
        x = mb.solve(in_parts(A), np.repeat([[1.0], [0.0]], 2 * PARTS, axis=1))
        assert x.error_estimate(times) >= UNCLEAR_ERROR


def free_pair(stiffness: float) -> mb.PolynomialMatrix:
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    return mb.PolynomialMatrix([turn @ np.diag([0.0, stiffness]) @ turn.T, np.zeros((2, 2)), np.eye(2)])


@pytest.mark.parametrize("stiffness", [1.0, 1e3, 1e6])
def test_a_free_body_in_turned_coordinates_is_trusted(stiffness):
    """What rounding left of its stiffness moves it by eps k t^2 / 2 at most."""
    x = mb.solve(free_pair(stiffness), [[0.8, 0.6], [0.0, 0.0]])
    assert x.error_estimate([1.0, 10.0]) <= 100 * EPS * stiffness * 10.0**2


def test_a_free_body_as_it_is_written_is_known_to_the_last_digits():
    spring = np.array([[1.0, -1.0], [-1.0, 1.0]])
    x = mb.solve(mb.PolynomialMatrix([1e16 * spring, 0 * spring, np.eye(2)]), [[1.0, 1.0], [0.0, 0.0]])
    assert x.error_estimate([1.0, 10.0]) <= 20 * EPS


@pytest.mark.parametrize("soft, grows", [(1.0, False), (2.5, True)])
def test_a_growing_part_that_is_driven_at_its_far_end(soft, grows):
    """The mode that grows is 1e-16 or less at the far end of a chain: float64 excites it by rounding, without it the answer is small."""
    n, rng = 30, np.random.default_rng(0)
    K = np.zeros((n + 1, n + 1))
    K[range(n), range(n)] = rng.uniform(2, 3, n)
    K[range(1, n), range(n - 1)] = K[range(n - 1), range(1, n)] = -rng.uniform(0.3, 1, n - 1)
    K[0, 0], K[n, n], K[n - 1, n], end = -soft, 4.0, 1e-18, 60.0
    start = np.zeros(n + 1)
    start[n] = 1.0
    M, zero = np.eye(n + 1), np.zeros_like(K)
    x = mb.MechanicalSystem(M, stiffness=K).solve(displacement=start)
    truth = np.array(list(map(float, motion([K, zero, M], [start, 0 * start], end))))
    error, estimate = np.abs(x(end) - truth).max() / np.abs(truth).max(), x.error_estimate(end)
    assert estimate >= error / 10
    assert (estimate == np.inf) == grows


@pytest.mark.parametrize("spread", [0.0, 1e-15, 1e-10, 0.3])
@pytest.mark.parametrize("count", [49, 60, 100])
def test_lags_in_series_are_no_alarm(count, spread):
    """x_i' = r_i (x_(i+1) - x_i): one cluster without independent eigenvectors. With r the largest rate e^((A + r) t) is a series of positive
    terms, in which nothing cancels."""
    rates = 3.0 * (1 + spread * np.random.default_rng(0).uniform(-1, 1, count))
    generator, start = np.diag(-rates) + np.diag(rates[:-1], 1), np.eye(count)[-1]
    x = mb.solve(mb.PolynomialMatrix([-generator, np.eye(count)]), initial=[start])
    positive = generator + rates.max() * np.eye(count)
    for t in (0.5, 5.0, 20.0):
        term = np.exp(-rates.max() * t) * start
        exact = term
        for power in range(1, 600):
            term = positive @ term * (t / power)
            exact = exact + term
        error = np.abs(x(t) - exact).max() / np.abs(exact).max()
        assert error <= max(x.error_estimate(t), 1e-13) and x.error_estimate(t) <= 1e-12
    assert not x.notices


def coalescing_pairs(count, seed, turned):
    """Pairs of oscillators at the edge of flutter, (k_1 - k_2)^2 = 4 p^2 to rounding, in coordinates of whole numbers."""
    rng = np.random.default_rng(seed)
    K = np.zeros((2 * count, 2 * count))
    for i in range(count):
        k1, k2 = rng.uniform(1, 10, 2)
        p = abs(k1 - k2) / 2 * (1 + rng.choice([0, 1e-15, 1e-12, -1e-12, 1e-8, -1e-8, 1e-4]))
        K[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[k1, p], [-p, k2]]
    T = np.eye(2 * count) + turned * np.triu((rng.random(K.shape) < 0.03) * rng.integers(-1, 2, K.shape), 1)
    return T.T @ T, T.T @ K @ T, rng.standard_normal(2 * count), rng.standard_normal(2 * count)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_values_without_a_digit_say_so(seed, turned):
    """Against SciPy's exponential of the companion matrix: values that are off by more than the limit have a doubtful notice, others none."""
    M, K, x0, v0 = coalescing_pairs(15, seed, turned)
    x = mb.MechanicalSystem(M, None, K).solve(x0, v0)
    n, t = len(M), 10.0
    companion = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), np.zeros((n, n))]])
    exact = (scipy.linalg.expm(companion * t) @ np.concatenate([x0, v0]))[:n]
    error = np.abs(x(t) - exact).max() / np.abs(exact).max()
    doubtful = any(notice.doubtful for notice in x.notices)
    assert error <= x.error_estimate(t) + 1e-9
    assert doubtful or error <= 1e-3
    assert not doubtful or x.error_estimate(t) > 1e-4
