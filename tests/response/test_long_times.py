"""Long times, fast decay, growth to the end of float64, clusters of zeros, resonance: against closed forms."""

import numpy as np
import pytest

import mbconstrained as mb
from tests.oracles.ball_exponential import motion


def scalar(*zeros) -> mb.PolynomialMatrix:
    """The polynomial with these zeros."""
    return mb.PolynomialMatrix(np.real(np.poly(zeros))[::-1][:, None, None])


def unit(count: int) -> np.ndarray:
    """x(0-) = 1, derivatives zero."""
    return np.eye(count)[:, :1]


@pytest.mark.parametrize("periods", [1, 1e3, 1e6])
def test_an_oscillator_keeps_its_phase(periods):
    """The phase is known to eps w t: 1e6 periods leave ten digits."""
    x = mb.solve(mb.PolynomialMatrix([[[1.0]], [[0.0]], [[1.0]]]), [[1.0], [0.0]])
    times = 2 * np.pi * periods + np.array([0.0, 0.3, 1.0])
    assert np.abs(x(times)[0] - np.cos(times)).max() <= 4e-16 * 2 * np.pi * max(periods, 1)


@pytest.mark.parametrize("spread", [0.0, 1e-8, 1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("time", [1e3, 1e5, 1e7, 1e12])
def test_a_stable_cluster_ends_in_zero_at_any_late_time(spread, time):
    """Zeros -1, -1 - d, -1 - 2 d: nothing grows, so nothing may overflow."""
    assert abs(mb.solve(scalar(-1, -1 - spread, -1 - 2 * spread), unit(3))(time)[0]) <= 1e-300


@pytest.mark.parametrize("spread", [1e-9, 1e-6, 1e-4, 1e-2])
def test_a_nearly_defective_pair_joins_the_defective_one_smoothly(spread):
    """((1 + d) e^{-t} - e^{-(1 + d) t}) / d, by a series where it cancels."""
    times = np.array([0.1, 1.0, 5.0])
    known = np.exp(-times) * (1 - np.expm1(-spread * times) / spread)
    found = mb.solve(scalar(-1, -1 - spread), unit(2))(times)[0]
    assert np.allclose(found, known, rtol=1e-7)


def test_a_fast_decay_does_not_spoil_a_slow_one():
    """(s + 1)(s + 1e9): the slow part alone is left after 1e-6."""
    fast = 1e9
    times = np.array([1e-10, 1e-6, 1.0, 20.0])
    known = (fast * np.exp(-times) - np.exp(-fast * times)) / (fast - 1)
    assert np.allclose(mb.solve(scalar(-1, -fast), unit(2))(times)[0], known, rtol=1e-9)


@pytest.mark.parametrize("frequency", [1.0, 3.0])
def test_resonance_grows_with_the_time(frequency):
    """x'' + w^2 x = cos(w t): x = t sin(w t) / (2 w)."""
    A = mb.PolynomialMatrix([[[frequency**2]], [[0.0]], [[1.0]]])
    x = mb.solve(A, force=mb.harmonic([1.0], angular_frequency=frequency))
    times = np.array([0.01, 1.0, 100.0, 1e4])
    assert np.allclose(x(times)[0], times * np.sin(frequency * times) / (2 * frequency), rtol=1e-10, atol=1e-9 * times.max())


def test_the_rest_of_a_motion_that_starts_small_is_exact():
    """A chain of twenty integrators: x = t^20/20!, nothing else is there to hide it."""
    A = mb.PolynomialMatrix([[[0.0]]] * 20 + [[[1.0]]])
    x = mb.solve(A, force=mb.step([1.0]))
    factorial = float(np.prod(np.arange(1.0, 21.0)))
    assert np.allclose(x([0.5, 1.0, 2.0])[0], np.array([0.5, 1.0, 2.0]) ** 20 / factorial, rtol=1e-12, atol=0)


@pytest.mark.parametrize("drive", [1.0, 1e-8, 1e-12, 1e-15, 0.0])
def test_a_weak_drive_in_resonance_does_not_spoil_the_free_motion(drive):
    """x1'' + x1 = d cos t, x2 = x1 + cos t, x3 = 0.3 x1 - 0.7 x2, rows mixed: x1 = cos t + d t sin(t) / 2 for any d."""
    mixing = np.array([[1.0, 0.3, -0.2], [0.1, 1.0, 0.7], [0.4, -0.6, 1.0]])
    K = np.array([[1.0, 0, 0], [-1, 1, 0], [-0.3, 0.7, 1]])
    A = mb.PolynomialMatrix([mixing @ K, np.zeros((3, 3)), mixing @ np.diag([1.0, 0, 0])])
    x = mb.solve(A, [[1.0, 0, 0], [0, 0, 0]], mb.harmonic([drive, 1.0, 0.0], angular_frequency=1.0).mapped(mixing))
    times = np.linspace(0, 20, 9)
    first = np.cos(times) + drive * times * np.sin(times) / 2
    second = np.cos(times) + first
    assert np.allclose(x(times), [first, second, 0.3 * first - 0.7 * second], rtol=0, atol=1e-10)


@pytest.mark.parametrize("frequency", [1.0, 2.0**10, 2.0**27, 2.0**40])
def test_a_small_force_survives_beside_a_large_one(frequency):
    """x' = w (1 + (w t)^2 cos w t), the same in any unit of time: x = u + (u^2 - 2) sin u + 2 u cos u with u = w t."""
    force = mb.step([1.0]) + mb.term([frequency**2], power=2, angular_frequency=frequency)
    x = mb.solve(mb.PolynomialMatrix([[[0.0]], [[1 / frequency]]]), force=force)
    u = np.array([0.25, 1.0, 3.0])
    assert np.allclose(x(u / frequency)[0], u + (u**2 - 2) * np.sin(u) + 2 * u * np.cos(u), rtol=1e-12)


@pytest.mark.parametrize("slow", [1e-2, 1e-4, 1e-7, 1e-12])
@pytest.mark.parametrize("order", [0, 1])
def test_a_slow_force_with_a_power_is_followed(slow, order):
    """x = f, and x + x' = f, for f = (w t)^3 e^{-w t} cos w t slow beside the system."""
    A = mb.PolynomialMatrix([[[1.0]], [[1.0]]][: order + 1])
    force = mb.term([slow**3], power=3, rate=-slow, angular_frequency=slow)
    x = mb.solve(A, force=force)
    u = np.array([0.3, 1.0, 4.0])
    residual = x(u / slow) + order * x.derivative()(u / slow) - u**3 * np.exp(-u) * np.cos(u)
    assert np.abs(residual).max() < 1e-12


@pytest.mark.parametrize("late", [1e3, 1e6, 1e9])
def test_early_values_do_not_depend_on_how_far_the_times_reach(late):
    x = mb.solve(scalar(-1, -1, -1), unit(3))
    times = np.array([0.01, 1.0, 10.0])
    known = np.exp(-times) * (1 + times + times**2 / 2)
    assert np.allclose(x([*times, late])[0, :3], known, rtol=1e-12, atol=0)


def test_growth_is_followed_to_the_end_of_float64_and_then_told():
    x = mb.solve(scalar(1.0), unit(1))
    assert x(709.0)[0] == pytest.approx(np.exp(709.0), rel=1e-12)
    with pytest.raises(mb.Overflow, match=r"t = 710 s.* beyond the range of float64.* ask for earlier times"):
        x([1.0, 710.0, 800.0])


@pytest.mark.parametrize(
    "ask", [lambda x: x, lambda x: x.derivative(), lambda x: x.function, lambda x: x.function.mapped([[0.0, 1.0]])]
)
def test_growth_in_one_coordinate_is_told_by_every_function_that_has_it(ask):
    x = mb.solve(mb.PolynomialMatrix([np.diag([1.0, -1.0]), np.eye(2)]), [[1.0, 1.0]])
    with pytest.raises(mb.Overflow, match="beyond the range of float64"):
        ask(x)(800.0)


def test_the_largest_and_the_smallest_numbers_pass():
    A = mb.PolynomialMatrix([[[1.0]], [[1.0]]])
    for size in (1e308, 1e-308):
        assert mb.solve(A, [[size]])(0.5)[0] / size == pytest.approx(np.exp(-0.5), rel=1e-12)


def test_a_free_chain_with_dampers_to_the_ground_has_separate_modes():
    """What the dampers' row conserves is a sum of all momenta; its units bend no others. Clusters of 51 states had errors of 2e-9."""
    random = np.random.default_rng([42, 4])
    n = 39
    K = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    K[0, 0] = K[-1, -1] = 1.0
    M, C, start = np.diag(random.uniform(0.5, 2, n)), np.diag(random.uniform(0, 0.1, n)), random.normal(size=n)
    x = mb.solve(mb.PolynomialMatrix([K, C, M]), [start, np.zeros(n)])
    expected = np.array([float(value) for value in motion([K, C, M], [start, np.zeros(n)], 5.0)])
    assert np.abs(x(5.0) - expected).max() <= 1e-11 * np.abs(expected).max()
    assert all(len(block) <= 2 for block in x.method.flow.reduction.decoupled.blocks)
