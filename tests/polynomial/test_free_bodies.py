"""Free bodies found as such, only where that is clear, against closed forms, conservation laws and the Jordan pairs."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

import mbconstrained as mb
from mbconstrained.polynomial.direct_reduction import reduction_of
from mbconstrained.polynomial.reduced_equations import Reduction, freed, null_rows

TIMES = np.linspace(0.0, 1000.0, 41)


def links(n, pairs, values):
    """The matrix of springs or dampers between pairs of n coordinates."""
    B = np.zeros((len(pairs), n))
    for row, (i, j) in zip(B, pairs):
        row[i], row[j] = 1.0, -1.0
    return B.T @ (np.asarray(values, dtype=float)[:, None] * B)


def chain(n, values=None):
    return links(n, [(i, i + 1) for i in range(n - 1)], np.ones(n - 1) if values is None else values)


def starts(n, seed=0):
    return np.random.default_rng(seed).standard_normal((2, n))


def solved(M, C, K, start, force=None):
    """The reduced answer, and that of the Jordan pairs."""
    A = mb.PolynomialMatrix([K, C, M])
    assert isinstance(reduction_of(A), Reduction)
    return mb.solve(A, start, force), mb.solve(A, start, force, rank_tolerance=1e-13)


@pytest.mark.parametrize("n", [30, 60, 160])
def test_uniform_free_chain(n):
    """Cosines of w_i = 2 sin(i pi / (2 n)), and the first of them a + b t (Lagrange)."""
    i = np.arange(n)
    shapes = np.cos(np.pi * np.outer(i + 0.5, i) / n)
    shapes /= np.linalg.norm(shapes, axis=0)
    w = 2 * np.sin(np.pi * i[1:, None] / (2 * n))
    start = starts(n)
    a, b = shapes.T @ start.T[:, 0], shapes.T @ start.T[:, 1]
    exact = a[1:, None] * np.cos(w * TIMES) + b[1:, None] * np.sin(w * TIMES) / w
    exact = shapes[:, 1:] @ exact + shapes[:, :1] * (a[0] + b[0] * TIMES)
    x = mb.solve(mb.PolynomialMatrix([chain(n), np.zeros((n, n)), np.eye(n)]), start)
    assert np.abs(x(TIMES) - exact).max() < 1e-13 * np.abs(exact).max()


@given(st.integers(0, 10**6))
def test_momentum_and_centre_of_mass(seed):
    """m x_cm'' = F for the sums of all masses and forces, whatever the springs and dampers between them: a step gives t^2 / 2."""
    random = np.random.default_rng(seed)
    n = int(random.integers(24, 40))
    masses, start = random.uniform(0.5, 2.0, n), random.standard_normal((2, n))
    C = links(n, [(2, 3), (7, 11)], random.integers(0, 1024, 2) / 1024 * random.integers(0, 2))  # sums of entries are exact
    v = random.standard_normal(n)
    x, other = solved(np.diag(masses), C, chain(n, random.integers(512, 2048, n - 1) / 1024), start, mb.step(v))
    momentum, path = masses @ start[1], masses @ start[0]
    expected = path + momentum * TIMES + v.sum() * TIMES**2 / 2
    found = masses @ x(TIMES)
    assert np.abs(found - expected).max() < 1e-11 * np.abs(masses[:, None] * x(TIMES)).sum(axis=0).max()
    assert np.abs(x(TIMES) - other(TIMES)).max() < 1e-9 * np.abs(other(TIMES)).max()


@pytest.mark.parametrize("kind", ["to ground", "between"])
def test_what_only_dampers_hold(kind):
    """One zero at 0 and a decay where a damper leads to the ground; between two free chains their common motion stays free."""
    n = 40
    K = links(n, [(i, i + 1) for i in range(n - 1) if i != 19], np.ones(n - 2))
    C = np.diag(np.eye(n)[0] + np.eye(n)[30]) if kind == "to ground" else links(n, [(5, 25)], [0.3])
    start = starts(n)
    x, other = solved(np.eye(n), C, K, start)
    zeros = reduction_of(x.polynomial_matrix).eigenvalues
    assert (zeros == 0).sum() == (2 if kind == "to ground" else 3) and np.abs(zeros[zeros != 0]).min() > 1e-6
    assert np.abs(x(TIMES) - other(TIMES)).max() < 1e-10 * np.abs(other(TIMES)).max()
    if kind == "between":
        assert np.allclose(x(TIMES).sum(axis=0), start[0].sum() + start[1].sum() * TIMES, rtol=1e-12, atol=1e-10)


def test_far_away_and_fast():
    """A body keeps its shape a million of its lengths away: what is added to all coordinates comes back as it is."""
    n, start = 60, starts(60)
    A = mb.PolynomialMatrix([chain(n), 0.01 * chain(n), np.eye(n)])
    near, far = mb.solve(A, start), mb.solve(A, start + [[1e6], [1e3]])
    moved = far(TIMES) - near(TIMES) - (1e6 + 1e3 * TIMES)
    assert np.abs(moved).max() < 1e-14 * 2e6 * n


def test_a_lever_turns_freely():
    """What is free need not be a shift: two ends of a massless lever, a to b, tied to chains."""
    n, a, b = 60, 1.0, 2.5
    K = links(n, [(i, i + 1) for i in range(n - 1) if i != 29], np.ones(n - 2))
    row = np.zeros(n)
    row[0], row[-1] = a, b
    K = K + np.outer(row, row)
    v, _ = null_rows(K)
    assert len(v) == 1 and np.allclose(v[0, :30] * a, -v[0, 30:] * b, rtol=1e-13)
    start = starts(n)
    x, other = solved(np.eye(n), 0 * K, K, start)
    assert np.allclose(v[0] @ x(TIMES), v[0] @ start[0] + v[0] @ start[1] * TIMES, rtol=1e-11, atol=1e-9)
    assert np.abs(x(TIMES) - other(TIMES)).max() < 1e-9 * np.abs(other(TIMES)).max()


def test_resonance_with_the_motion_at_zero():
    """x_cm'' = t^3: the force is among the zeros at 0, four more integrations."""
    n = 48
    x, _ = solved(np.eye(n), 0 * chain(n), chain(n), np.zeros((2, n)), mb.term(np.eye(n)[3], power=3))
    assert np.allclose(x(TIMES).mean(axis=0), TIMES**5 / 20 / n, rtol=1e-12)


@pytest.mark.parametrize("spring", [1e-3, 1e-7, 1e-11, 1e-13, 2.0**-51])
def test_a_soft_spring_is_no_free_body(spring):
    """It is not stiff enough to be found among the others, and stays in the equation of the momentum."""
    n = 60
    K = chain(n) + np.diag(np.eye(n)[0] * spring)
    result = freed(np.eye(n), np.zeros((n, n)), K)
    assert (result is None) == (spring >= 1e-7)
    if result is not None:
        assert result.remainders[0].sum() == K[0].sum() and not result.remainders[1].any()


SOFT = {
    "first grounded": [(0, 4e-14)],
    "two grounded": [(3, 1e-13), (40, 3e-13)],
    "all grounded": [(i, 2.0**-47) for i in range(60)],
}


@pytest.mark.parametrize("supports", SOFT)
@pytest.mark.parametrize("damping", [0.0, 0.02])
def test_a_softly_supported_body_returns(supports, damping):
    """One body on the sum of its supports, whose own motions are a million times faster: x = cos(w t), w^2 = sum of springs / mass."""
    n, random = 60, np.random.default_rng(0)
    masses, K = random.uniform(0.5, 2.0, n), chain(n)
    for place, spring in SOFT[supports]:
        K[place, place] += spring
    springs = sum(K.sum(axis=1))
    times = np.array([0.0, 0.3, 1.0, 4.0]) / np.sqrt(springs / masses.sum())
    x = mb.solve(mb.PolynomialMatrix([K, damping * chain(n), np.diag(masses)]), [np.ones(n), np.zeros(n)])
    expected = np.cos(np.sqrt(springs / masses.sum()) * times)
    # The support is a difference of entries of K: one unit in the last place of one of them changes it by 1e-3 and more.
    assert np.abs(x(times) - expected).max() <= 1e-8


UNITS = 30

SUPPORTED = {  # what the ground adds to the diagonals of stiffness and damping of a free chain
    "an ulp of each entry": (np.full(UNITS, 2.0**-51), np.zeros(UNITS), 0.0),
    "the first one only": (4e-14 * np.eye(UNITS)[0], np.zeros(UNITS), 0.1),
    "dampers of all sizes": (np.zeros(UNITS), np.geomspace(1e-17, 1e-12, UNITS), 0.1),
    "one damper": (np.zeros(UNITS), 1e-13 * np.eye(UNITS)[7], 0.0),
    "a spring and a damper": (3e-15 * np.eye(UNITS)[4], 1e-12 * np.eye(UNITS)[9], 0.1),
}


@pytest.mark.parametrize("supports", SUPPORTED)
@pytest.mark.parametrize("random_springs", [False, True])
def test_supports_of_the_size_of_rounding_errors_count(supports, random_springs):
    """Entries are exact numbers: the body moves as one mass on the sums of all entries of K and C, as long as these are tiny."""
    springs, dampers, damping = SUPPORTED[supports]
    k = np.random.default_rng(0).uniform(0.5, 2.0, UNITS - 1) if random_springs else np.ones(UNITS - 1)
    K, C = chain(UNITS, k) + np.diag(springs), damping * chain(UNITS) + np.diag(dampers)
    stiffness, rate = (float(sum(map(Fraction, matrix.ravel().tolist())) / UNITS) for matrix in (K, C))
    x = mb.solve(mb.PolynomialMatrix([K, C, np.eye(UNITS)]), [np.ones(UNITS), np.ones(UNITS)])
    for time in (10.0, 2.0**15, 2.0**24):
        body = expm(np.array([[0.0, 1.0], [-stiffness, -rate]]) * time) @ [1.0, 1.0]
        error = np.abs(x(time) - body[0]).max() / abs(body[0])
        assert error <= 1e-9
    if supports == "an ulp of each entry" and not random_springs:
        assert any("a few units in the last place" in notice.text for notice in x.notices)


def test_bodies_on_springs_softer_than_their_own_by_thirteen_orders():
    """Two chains between which a spring of 1e-13 acts: the distance of their centres turns with w^2 = 2 k / m."""
    n, spring = 30, 1e-13
    K = np.kron(np.eye(2), chain(n))
    K[np.ix_([n - 1, n], [n - 1, n])] += spring * np.array([[1.0, -1.0], [-1.0, 1.0]])
    w = np.sqrt(-2 * K[n - 1, n] / n)
    times = np.array([0.5, 2.0, 6.0]) / w
    x = mb.solve(
        mb.PolynomialMatrix([K, 0.01 * np.kron(np.eye(2), chain(n)), np.eye(2 * n)]), [np.repeat([1.0, 0.0], n), np.zeros(2 * n)]
    )
    distance = x(times)[:n].mean(axis=0) - x(times)[n:].mean(axis=0)
    assert np.abs(distance - np.cos(w * times)).max() <= 1e-3  # entries of 1 + 1e-13 are rounded by a thousandth of that spring


def test_unsymmetric_stiffness():
    """A follower force: v K = 0 with v other than w in K w = 0."""
    n = 60
    K = chain(n)
    K[0] += 0.2 * K[5]
    start = starts(n)
    v = null_rows(K)[0]
    rounding = n * np.finfo(float).eps * (np.abs(v) @ np.abs(K)).max()  # of products of n terms
    assert len(v) == 1 and np.abs(v @ K).max() < rounding and np.ptp(v) > 0.1
    x, other = solved(np.eye(n), 0 * K, K, start)
    times = TIMES[:10]
    assert np.abs(x(times) - other(times)).max() < 1e-9 * np.abs(other(times)).max()
