"""e^{S k h} v by powers, against SciPy's exponential, sixty digits (mpmath) and closed forms."""

import mpmath
import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

from mbconstrained.ground.tolerances import EPS
from mbconstrained.linalg.recursion import ExponentialSeries, Propagator

COUNTS = (1, 2, 31, 33, 1000)


def chain(masses: int, damping: float = 0.0) -> np.ndarray:
    """[[0, I], [-K, -c I]] of equal masses between two walls."""
    K = 2 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1)
    return np.block([[np.zeros((masses, masses)), np.eye(masses)], [-K, -damping * np.eye(masses)]])


def reference(S, step, start, places) -> np.ndarray:
    """e^{S k h} v for the places k, by eigenvectors in sixty digits."""
    with mpmath.workdps(60):
        values, vectors = mpmath.eig(mpmath.matrix(S.tolist()))
        weights = mpmath.lu_solve(vectors, mpmath.matrix(start.tolist()))
        columns = []
        for k in places:
            turned = mpmath.matrix([w * mpmath.exp(value * mpmath.mpf(step) * k) for w, value in zip(weights, values)])
            columns.append([float(mpmath.re(x)) for x in vectors * turned])
    return np.array(columns).T


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("starts", [None, 1, 3, 40])
def test_values_are_those_of_the_exponential(count, starts):
    random = np.random.default_rng(0)
    S, output = chain(4, 0.02), random.normal(size=(3, 8))
    start = random.normal(size=8 if starts is None else (8, starts))
    found = Propagator(S, 0.3).values(output, start, count)
    expected = np.moveaxis(np.array([output @ scipy.linalg.expm(S * 0.3 * k) @ start for k in range(count)]), 0, 1)
    assert found.shape == expected.shape
    assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max() * count**0.5


@pytest.mark.parametrize("step", [1e-9, 1e-3, 1.0, 40.0])
def test_a_chain_against_sixty_digits(step):
    S, start = chain(5, 0.01), np.random.default_rng(1).normal(size=10)
    places = [0, 1, 30, 99]
    found = Propagator(S, step).values(np.eye(10), start, 100)[:, places]
    expected = reference(S, step, start, places)
    assert np.abs(found - expected).max() <= 40 * EPS * (1 + 4 * 100 * step) * np.abs(expected).max()


def test_a_slow_motion_beside_a_fast_one_keeps_its_digits():
    fast, slow = -1e5, -1.0
    S = np.array([[fast, 1.0], [0.0, slow]])
    times = 0.5 * np.arange(40)
    found = Propagator(S, 0.5).values(np.array([[0.0, 1.0]]), np.ones(2), 40)[0]
    assert np.abs(found / np.exp(slow * times) - 1).max() <= 1e-13


@pytest.mark.parametrize("unit", [1e-9, 1e-3, 1e6])
def test_other_units_of_the_states_give_the_same_digits(unit):
    S, start = chain(6), np.random.default_rng(2).normal(size=12)
    units = np.repeat([1.0, unit], 6)
    other = S * units / units[:, None]
    found = Propagator(other, 0.4).values(np.eye(12), start / units, 70) * units[:, None]
    expected = Propagator(S, 0.4).values(np.eye(12), start, 70)
    assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max()


def test_a_motion_that_grows_leaves_others_alone():
    calm, start = chain(4, 0.02), np.random.default_rng(2).normal(size=8)
    both = scipy.linalg.block_diag(calm, [[2.0]])
    found = Propagator(both, 1.0).values(np.eye(9), np.append(start, 0.0), 300)
    expected = Propagator(calm, 1.0).values(np.eye(8), start, 300)
    assert np.abs(found[:8] - expected).max() <= 1e-12 * np.abs(expected).max()
    assert not found[8].any()


@pytest.mark.parametrize("start", [0, 60])
def test_a_long_chain_from_one_end_has_the_values_of_its_sines(start):
    """Places far from the start have entries of e^{S h} below any number; K = V w^2 V^T with sines V."""
    masses, step, count = 120, 0.1, 1000
    places, times = np.arange(1.0, masses + 1), step * np.arange(count)
    V = np.sqrt(2 / (masses + 1)) * np.sin(np.multiply.outer(places, places) * np.pi / (masses + 1))
    w, z = 2 * np.sin(places * np.pi / (2 * (masses + 1))), np.eye(2 * masses)[start]
    expected = V @ (np.cos(np.multiply.outer(w, times)) * V[start][:, None])
    propagator = Propagator(chain(masses), step)
    found = propagator.values(np.eye(masses, 2 * masses), z, count)
    assert np.abs(found - expected).max() <= 40 * EPS * w.max() * times[-1]
    mixed = propagator.values(np.eye(masses, 2 * masses)[::-1] - np.eye(masses, 2 * masses), z, count)
    assert np.abs(mixed - (expected[::-1] - expected)).max() <= 80 * EPS * w.max() * times[-1]


@pytest.mark.parametrize("coupling", [1e-110, 1e-160, 1e-250])
def test_a_tiny_coupling_is_no_remote_entry(coupling):
    times = 0.25 * np.arange(100)
    found = Propagator(np.array([[1.0, 0.0], [coupling, 1.0]]), 0.25).values(np.eye(2), np.array([1.0, 0.0]), 100)
    expected = np.exp(times) * np.array([np.ones(100), coupling * times])
    assert (np.abs(found - expected) <= 1e-12 * np.abs(expected)).all()


@pytest.mark.parametrize("step", [0.01, 0.5, 7.0])
def test_series_of_a_sparse_model_agree_with_its_exponential(step):
    """Vectors by products with the sparse S and by powers of e^(S h), many rows of them, stiff and soft units included."""
    n, random = 60, np.random.default_rng(3)
    S = np.diag(-random.random(n)) + np.diag(random.random(n - 1), 1) - np.diag(random.random(n - 1), -1)
    units = 2.0 ** random.integers(-20, 20, n)
    S, start, output = S * units / units[:, None], random.standard_normal(n) / units, np.eye(n)[[0, 7, 31]] * units
    expected = Propagator(S, step).values(output, start, 40)
    for matrix in (S, scipy.sparse.csr_array(S)):
        found = ExponentialSeries(matrix, step, start, 40).values(output)
        assert found == pytest.approx(expected, rel=0, abs=4e-14 * np.abs(expected).max())


def test_series_of_nothing_that_moves():
    """Without entries of S vectors stay as they are, and with few times or none there are as many."""
    for count in (0, 1, 5):
        values = ExponentialSeries(np.zeros((3, 3)), 1.0, np.arange(3.0), count).values(np.eye(3)[:2])
        assert np.array_equal(values, [[0.0] * count, [1.0] * count])
