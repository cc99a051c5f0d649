"""Modes of models with few couplings against closed forms, LAPACK's eigenvalues of the generator, and the identities that modes obey."""

import numpy as np
import pytest
import scipy.linalg
from scipy.sparse.linalg import expm_multiply

from mbconstrained.linalg.blocks import block_matrix
from mbconstrained.linalg.elimination import EACH, front_width
from mbconstrained.linalg.exponential import block_states
from mbconstrained.linalg.tree_modes import DENSE, SparseTopology, zeros_near

from .few_couplings import band, beam, chain_between_walls, ladder, random_tree, ring, tree, uniform_ring

#: Coordinates, so that a model is divided at least twice.
MANY = 150


def quadratic_modes(M, C, K):
    """The modes of the whole model by its topology, whatever its width."""
    return SparseTopology(M, C, K, 1).modes(np.arange(len(K)))


def generator(M, C, K) -> np.ndarray:
    """S of the states (x_m, x_m', x_d)."""
    m, n = len(M), len(K)
    weights, states = np.zeros((2, n + m, n + m))
    weights[:m, :m] = states[:m, m : 2 * m] = np.eye(m)
    weights[m:, m : 2 * m] = np.vstack([M, np.zeros((n - m, m))])
    weights[m:, 2 * m :] = C[:, m:]
    states[m:, :m], states[m:, m : 2 * m], states[m:, 2 * m :] = -K[:, :m], -C[:, :m], -K[:, m:]
    return np.linalg.solve(weights, states)


def zeros_of(found) -> np.ndarray:
    return np.concatenate([found.upper, found.upper.conj(), found.real])


def farthest(one, other) -> float:
    """The largest distance of a number of one set from the other, both ways, relative to the largest of all."""
    apart = np.abs(one[:, None] - other)
    return max(apart.min(axis=1).max(), apart.min(axis=0).max()) / np.abs(other).max()


def check(found, M, C, K, accuracy=1e-11):
    """All zeros, the identities, and e^{S t} of a start against SciPy."""
    S = generator(M, C, K)
    assert len(zeros_of(found)) == len(S)
    assert farthest(zeros_of(found), np.linalg.eigvals(S)) <= accuracy
    assert np.abs(found.inverse @ found.basis - np.eye(len(S))).max() <= 1e-11
    size = np.abs(found.basis).max() * np.abs(S).max()
    assert np.abs(S @ found.basis - found.basis @ block_matrix(found.blocks)).max() <= 1e-13 * size * len(S)
    start, times = np.random.default_rng(0).normal(size=len(S)), np.array([0.0, 0.3, 2.0])
    output = np.random.default_rng(1).normal(size=(3, len(S)))
    values = found.modal_output(output) @ block_states(found.blocks, found.coordinates(start), times)
    expected = output @ np.array([expm_multiply(S * t, start) for t in times]).T
    assert np.abs(values - expected).max() <= 1e-11 * np.abs(expected).max()


@pytest.mark.parametrize("count", [1, 2, 3, DENSE // 2 - 1, DENSE, 3 * DENSE])
def test_a_uniform_chain_has_the_frequencies_of_its_formula(count):
    found = quadratic_modes(*chain_between_walls(count))
    expected = 2 * np.sin(np.pi * np.arange(1, count + 1) / (2 * (count + 1)))
    assert not len(found.real)
    assert np.abs(np.sort(found.upper.imag) / expected - 1).max() <= 1e-14
    assert np.abs(found.upper.real).max() <= 1e-15


@pytest.mark.parametrize("damping", [0.01, 0.6, 1.01])
def test_damping_in_proportion_keeps_the_formula_with_pairs_and_real_zeros(damping):
    """s^2 + c w^2 s + w^2 = 0: fast modes are overdamped for c w > 2."""
    squares = (2 * np.sin(np.pi * np.arange(1, MANY + 1) / (2 * (MANY + 1)))) ** 2
    root = np.sqrt((damping * squares) ** 2 - 4 * squares + 0j)
    expected = np.concatenate([-2 * squares / (damping * squares + root), -(damping * squares + root) / 2])
    found = quadratic_modes(*chain_between_walls(MANY, damping))
    assert len(zeros_of(found)) == 2 * MANY
    assert farthest(zeros_of(found), expected) <= 1e-11


@pytest.mark.parametrize("damping", [0.0, 0.02, 0.5, 3.0])
@pytest.mark.parametrize("reach", [1, 3])
def test_chains_and_trees_with_any_damping(damping, reach):
    parents, (stiffness, dampers, mass), random = random_tree(1, MANY, reach)
    model = tree(parents, stiffness, damping * dampers * random.integers(0, 2, MANY), mass)
    check(quadratic_modes(*model), *model)


@pytest.mark.parametrize("seed", range(4))
def test_a_tree_whose_motions_are_hardly_apart_is_refused_or_right(seed):
    """Branches that hang on one mass are alike: their motions against each other have zeros close together."""
    parents, (stiffness, dampers, mass), _ = random_tree(seed, MANY)
    model = tree(parents, stiffness, 0.05 * dampers, mass)
    found = quadratic_modes(*model)
    if found is not None:
        check(found, *model)


def chain_with_dampers(rate):
    """A chain whose every tenth coordinate has a damper to the one before."""
    parents, (stiffness, dampers, mass), _ = random_tree(2, MANY, 1)
    return tree(parents, stiffness, np.where(np.arange(1, MANY) % 10 == 7, rate, 0.0) + 0.02 * dampers[:-1], mass)


def ring_with_dampers():
    """A ring whose every tenth coordinate has a damper to the ground."""
    M, C, K = ring(260, seed=2)
    return M, C + 0.3 * np.diag(np.arange(260) % 10 == 7), K


@pytest.mark.parametrize(
    "model", [*map(chain_with_dampers, (0.05, 1.0, 20.0)), ring_with_dampers()], ids=["weak", "like", "strong", "ring"]
)
def test_massless_joints_with_dampers(model):
    """Every tenth coordinate without mass: one state less each."""
    light = np.arange(len(model[0])) % 10 == 7
    order, m = np.argsort(light, kind="stable"), np.count_nonzero(~light)
    M, C, K = (matrix[np.ix_(order, order)] for matrix in model)
    found = quadratic_modes(M[:m, :m], C, K)
    assert len(found.real) >= np.count_nonzero(light)
    check(found, M[:m, :m], C, K)


def test_masses_of_very_different_sizes():
    """From 1e-6 to 1e6 kg along a chain: each zero to the digits that balanced equations give."""
    parents, (stiffness, dampers, _), _ = random_tree(4, MANY, 1)
    mass = np.geomspace(1e-6, 1e6, MANY)
    model = tree(parents, stiffness, 1e-4 * dampers, mass)
    found = quadratic_modes(*model)
    balanced = scipy.linalg.matrix_balance(generator(*model), permute=False)[0]
    exact = np.linalg.eigvals(balanced)
    fast = np.abs(exact) > 1e-3 * np.abs(exact).max()
    mine = zeros_of(found)
    assert np.abs(mine[:, None] - exact[fast]).min(axis=0).max() <= 1e-12 * np.abs(exact).max()
    assert abs(mine.sum() - np.trace(balanced)) <= 1e-11 * np.abs(mine).sum()


def test_equal_branches_are_refused_or_right():
    """Three equal chains on one mass: each motion of two against each other is there twice."""
    length = MANY // 3
    parents = [0 if at % length == 0 else at for at in range(3 * length)]
    model = tree(parents, np.ones(3 * length), 0.01 * np.ones(3 * length), np.ones(3 * length + 1))
    found = quadratic_modes(*model)
    if found is not None:
        check(found, *model, accuracy=1e-7)


def test_a_double_zero_is_refused():
    """Critically damped, one by one: vectors that are one vector."""
    mass = np.ones(2)
    assert quadratic_modes(np.eye(1), np.array([[2.0]]), np.array([[1.0]])) is None
    model = tree([0], [0.0], [0.0], mass, ground=1.0, ground_damping=2.0)
    assert quadratic_modes(*model) is None


@pytest.mark.parametrize(
    "K",
    [
        2 * np.eye(3) - np.roll(np.eye(3), 1, 0) - np.roll(np.eye(3), -1, 0) + np.eye(3),
        np.eye(3),
        np.array([[2.0, 1.0, 1.0], [1.0, 2.0, 1.0], [1.0, 1.0, 2.0]]),
    ],
    ids=["a ring", "not coupled", "all coupled"],
)
def test_what_is_no_tree_is_not_taken(K):
    assert quadratic_modes(np.eye(3), np.zeros((3, 3)), K) is None


def test_many_branches_at_one_place_are_not_divided():
    count = 2 * DENSE
    parents = [0] * (count - 1)
    model = tree(parents, np.linspace(1, 2, count - 1), np.zeros(count - 1), np.ones(count))
    assert quadratic_modes(*model) is None


ROOTS = {
    "real ones": [-1.0, -2.0, -5.0, 3.0],
    "pairs": [-1 + 2j, -1 - 2j, 0.5 + 1j, 0.5 - 1j],
    "both": [-1 + 2j, -1 - 2j, -4.0, -0.1],
    "near the axis": [-1 + 1e-4j, -1 - 1e-4j, -3.0, -7.0],
}


@pytest.mark.parametrize("roots", ROOTS.values(), ids=ROOTS)
@pytest.mark.parametrize("start", ROOTS.values(), ids=ROOTS)
def test_pairs_become_real_zeros_and_real_zeros_pairs(roots, start):
    p = np.polynomial.Polynomial.fromroots(roots)
    p = np.polynomial.Polynomial(p.coef.real)
    found = zeros_near(lambda s: p.deriv()(s) / p(s), 1.1 * np.array(start, dtype=complex), 1e-10)
    assert len(found.all) == len(roots)
    assert np.abs(np.sort_complex(found.all) - np.sort_complex(np.array(roots, dtype=complex))).max() <= 1e-6
    assert len(found.real) == np.count_nonzero(np.imag(roots) == 0)
    assert (found.upper.imag > 0).all()


def test_what_does_not_settle_is_none():
    random = np.random.default_rng(0)
    assert zeros_near(lambda s: random.normal(size=len(s)) + 0j, np.array([1.0 + 1j, 1.0 - 1j, 2.0]), 1e-10) is None


@pytest.mark.parametrize("count", [550, 700])  # of 650 two zeros are so near that some processors lose their vectors
@pytest.mark.parametrize("damping", [1e-4, 0.01])
def test_close_zeros_of_a_lightly_damped_chain_of_unlike_springs(count, damping):
    """Pairs of zeros that are millionths of the fastest apart settle slowly. Sums of powers: tr S = -tr C and tr S^2 = tr C^2 - 2 tr K."""
    springs = 1 + 0.3 * np.sin(np.arange(count + 1))
    K, C = (
        np.diag(each[1:] + each[:-1]) - np.diag(each[1:-1], 1) - np.diag(each[1:-1], -1)
        for each in (springs, np.full(count + 1, damping))
    )
    zeros = zeros_of(quadratic_modes(np.eye(count), C, K))
    assert len(np.unique(zeros)) == 2 * count
    assert zeros.sum().real == pytest.approx(-np.trace(C), rel=1e-9)
    assert (zeros**2).sum().real == pytest.approx(np.trace(C @ C) - 2 * np.trace(K), rel=1e-11)


# Rings, ladders, bands and beams.

BANDS = {
    "ring": ring(250),
    "ladder": ladder(250),
    "band": band(3 * EACH, 3),
    "beam on a foundation": beam(3 * EACH // 2, foundation=50.0),
}


@pytest.mark.parametrize("model", BANDS.values(), ids=BANDS)
def test_zeros_and_motions_of_rings_and_bands_are_those_of_the_generator(model):
    check(quadratic_modes(*model), *model)


@pytest.mark.parametrize("damping", [(), (3,)], ids=["none", "one damper"])
def test_equal_zeros_of_a_uniform_ring_are_refused_or_right(damping):
    """Waves go round both ways alike: every zero but two is there twice, or near another where one damper tells them apart."""
    model = uniform_ring(250, damping)
    found = quadratic_modes(*model)
    assert damping or found is None
    if found is not None:
        check(found, *model)


def test_a_uniform_ring_whose_dampers_tell_its_waves_apart():
    model = uniform_ring(242, (3, 40, 58))
    check(quadratic_modes(*model), *model)


def test_a_uniform_ladder_has_the_frequencies_of_its_formula():
    """Both rails alike: together they are a chain, against each other a chain on the ground of twice the rungs; leading parts have
    motions of the whole, whose pivots vanish."""
    half = 143  # half + 1 has many divisors
    chain = 2 * np.eye(half) - np.eye(half, k=1) - np.eye(half, k=-1)
    K = np.kron(chain, np.eye(2)) + np.kron(np.eye(half), 0.3 * np.array([[1.0, -1.0], [-1.0, 1.0]]))
    found = quadratic_modes(np.eye(2 * half), 0.01 * np.eye(2 * half), K)
    squares = (2 * np.sin(np.pi * np.arange(1, half + 1) / (2 * (half + 1)))) ** 2
    squares = np.sort(np.concatenate([squares, squares + 0.6]))
    assert np.abs(np.sort(np.abs(found.upper) ** 2) / squares - 1).max() <= 1e-12
    assert np.abs(found.upper.real + 0.005).max() <= 1e-14


def test_a_free_ring_is_refused():
    """It moves off as a whole: a double zero at 0 with one vector."""
    M, C, K = ring(250, ground=())
    assert quadratic_modes(M, C, K) is None


def test_a_long_beam_is_refused_before_its_zeros_are_looked_for(monkeypatch):
    model = beam(3 * EACH // 2)
    monkeypatch.setattr("mbconstrained.linalg.tree_modes._zeros", None)
    assert front_width(*model) == 3 and quadratic_modes(*model) is None


def test_a_beam_of_integers_with_one_damper_keeps_its_modes():
    """Beside its slow zeros P(s) is K to the last digit, and pivots of integers cancel to exactly 0.

    Modes of beams lose digits with the fourth power of the length: of 120 more bodies those of some processors are refused.
    """
    D, one = np.diff(np.eye(2 * EACH), 2, axis=0), np.zeros(2 * EACH)
    one[len(one) // 2] = 1.0
    K = D.T @ D
    K[[0, 1, -1], [0, 1, -1]] += 1.0
    check(quadratic_modes(np.eye(len(K)), np.diag(one), K), np.eye(len(K)), np.diag(one), K)


def test_what_has_too_few_coordinates_for_its_width_is_left_to_others():
    assert quadratic_modes(*ring(2 * EACH - 2)) is None
