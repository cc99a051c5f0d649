"""Plain A(s) reduced to first-order equations: A(s)^-1 by theorem, and what is not plain is left alone."""

from itertools import permutations

import numpy as np
import pytest

import mbconstrained.linalg.blocks
import mbconstrained.polynomial.reduced_equations
from mbconstrained.linalg.arrays import full
from mbconstrained.linalg.blocks import block_matrix
from mbconstrained.polynomial.coefficients import Factors
from mbconstrained.polynomial.direct_reduction import matching_rows, reduction_of
from mbconstrained.polynomial.polynomial_matrix import PolynomialMatrix
from mbconstrained.polynomial.reduced_equations import NotReducible, Reduction

POINTS = (0.3, 1.7 + 0.4j, -0.2 + 2.5j, 30.0)


def chain(size: int) -> np.ndarray:
    return 2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1)


def inverse_at(reduction: Reduction, s: complex) -> np.ndarray:
    """A(s)^-1 = P (s I - S)^-1 D + Y G from the reduced equations: G the right sides of algebraic rows, D what drives w."""
    n, size = reduction.state_count, reduction.V.shape[0]
    every = np.eye(size)
    held = every[reduction.algebraic]
    right = every[np.concatenate([reduction.second, reduction.first])].astype(complex)
    for power, through in enumerate(reduction.through):
        right = right - s**power * (through @ held)
    drive = full(reduction.rates(right.real)) + 1j * full(reduction.rates(right.imag))
    states = np.linalg.solve(s * np.eye(n) - full(reduction.generator), drive)
    return reduction.output @ states + reduction.Y @ held


def check(A: PolynomialMatrix, states: int | None = None) -> Reduction:
    reduction = reduction_of(A)
    assert isinstance(reduction, Reduction)
    for s in POINTS:
        value, found = A(s), inverse_at(reduction, s)
        size = np.abs(value).max() * np.abs(found).max() * A.size
        assert np.abs(value @ found - np.eye(A.size)).max() <= 1e-12 * max(size, 1.0)
    assert states is None or reduction.state_count == states
    return reduction


def masses_and(*, static=0, damped=0, size=6, seed=0) -> list[np.ndarray]:
    """K, C, M of a chain whose first nodes have neither mass nor damper, the next ones a damper and no mass."""
    random = np.random.default_rng(seed)
    K, C, M = chain(size) + np.eye(size), np.zeros((size, size)), np.diag(random.uniform(0.5, 2.0, size))
    massless = random.permutation(size)[: static + damped]
    M[massless, massless] = 0.0
    C[massless[static:], massless[static:]] = random.uniform(0.5, 2.0, damped)
    return [K, C, M]


def tied(K, C, M, *, rows) -> PolynomialMatrix:
    """V^T of the equations of motion over the ties, V from the ties' singular value decomposition: nothing is sparse."""
    rows = np.asarray(rows, dtype=float)
    V = np.linalg.svd(rows)[2][len(rows) :].T
    nothing = np.zeros_like(rows)
    return PolynomialMatrix([np.vstack([V.T @ K, rows]), np.vstack([V.T @ C, nothing]), np.vstack([V.T @ M, nothing])])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("static", "damped", "states"), [(2, 0, 8), (0, 2, 10), (2, 1, 7), (6, 0, 0), (0, 6, 6), (1, 5, 5)])
def test_joints_without_mass(static, damped, states, seed):
    if states:
        check(PolynomialMatrix(masses_and(static=static, damped=damped, seed=seed)), states=states)
    else:
        assert isinstance(reduction_of(PolynomialMatrix(masses_and(static=static)[:1])), NotReducible)


@pytest.mark.parametrize(
    "rows",
    [
        [[1, 0, -1, 0, 0, 0]],
        [[1, -2, 0, 0, 0, 0], [0, 0, 0, 1, 1, 1]],
        [[0.3, 0.1, 0, 0, 0, -7], [0, 0.2, 0, 5, 0, 1], [1, 1, 1, 1, 1, 1]],
    ],
)
def test_ties(rows):
    check(tied(*masses_and(), rows=rows), states=2 * (6 - len(rows)))


def test_random_models_with_ties_to_joints_and_dampers():
    random = np.random.default_rng(3)
    found = 0
    for seed in range(20):
        K, C, M = masses_and(static=int(random.integers(0, 3)), damped=int(random.integers(0, 3)), size=8, seed=seed)
        rows = random.integers(-2, 3, (int(random.integers(1, 3)), 8))
        A = tied(K, C, M, rows=rows)
        if np.linalg.matrix_rank(rows) == len(rows) and isinstance(reduction_of(A), Reduction):
            check(A)
            found += 1
    assert found >= 5


K, C, M = masses_and()
NOTHING = np.zeros((6, 6))
LOOSE = M.copy()
LOOSE[2, 2] = 0.0
FREE = np.diag(np.ones(6)) * 2 - np.eye(6, k=1) - np.eye(6, k=-1)
FREE[0, 0] = FREE[5, 5] = 1.0
NO_SPRING = K.copy()
NO_SPRING[2] = NO_SPRING[:, 2] = 0.0
SINGULAR = M.copy()
SINGULAR[:2, :2] = [[1.0, 1.0], [1.0, 1.0]]
NOT_PLAIN = {
    "degree 0": [K],
    "degree 3": [K, C, M, np.eye(6)],
    "a node without mass, damper and spring": [NO_SPRING, C, LOOSE],
    "masses that are singular together": [K, C, SINGULAR],
    "masses that are nearly singular together": [K, C, SINGULAR + 1e-9 * np.eye(6)],
    "a free chain": [FREE, C, M],
    "dampers that are singular together": [K, np.ones((6, 6)), NOTHING],
    "a damper between two massless nodes": [K, np.pad([[1.0, -1.0], [-1.0, 1.0]], (0, 4)), np.diag([0.0, 0, 1, 1, 1, 1])],
}


@pytest.mark.parametrize("name", NOT_PLAIN)
def test_what_is_not_plain_is_left_to_the_general_way(name):
    assert isinstance(reduction_of(PolynomialMatrix(NOT_PLAIN[name])), NotReducible)


@pytest.mark.parametrize("difference", [0.0, 1e-15, 1e-6])
def test_ties_that_depend_on_each_other_or_nearly_so(difference):
    rows = np.array([[1.0, -1, 0, 0, 0, 0], [1, -1, 0, 0, difference, 0]])
    coefficients = [np.vstack([matrix[:4], other]) for matrix, other in zip((K, C, M), (rows, 0 * rows, 0 * rows))]
    assert isinstance(reduction_of(PolynomialMatrix(coefficients)), NotReducible)


def test_uncertain_entries_and_factors_are_left_to_the_general_way():
    plain = PolynomialMatrix([K, C, M])
    assert isinstance(reduction_of(plain), Reduction)
    uncertainty = np.zeros((3, 6, 6))
    uncertainty[0, 0, 0] = 1e-6
    assert isinstance(reduction_of(PolynomialMatrix([K, C, M], uncertainty=list(uncertainty))), NotReducible)
    factors = Factors(np.eye(6), np.diag(M).copy(), np.eye(6))
    assert isinstance(reduction_of(PolynomialMatrix([K, C, factors])), NotReducible)


def test_a_damper_that_ties_take_away_but_for_rounding_is_none():
    """u = 0.3 w and v = 3 (0.1 w), a damper between u and v: what is left of it, 5e-17, is no damper of w."""
    damper = np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    V = np.array([[0.3, 3 * 0.1, 1.0]])
    rows = np.array([[1.0, 0.0, -0.3], [0.0, 1.0, -3 * 0.1]])
    A = PolynomialMatrix([np.vstack([V @ np.eye(3), rows]), np.vstack([V @ (1e3 * damper), 0 * rows])])
    assert A.coefficients[1][0].any()
    assert isinstance(reduction_of(A), NotReducible)


def test_symmetry_is_told_beside_each_row_not_beside_the_largest_one():
    stiff = np.diag([1e12, 1e12, 2.0, 2.0])
    stiff[2, 3], stiff[3, 2] = -1.0, -1.0 + 1e-6
    assert not reduction_of(PolynomialMatrix([stiff, np.zeros((4, 4)), np.eye(4)])).is_symmetric
    stiff[3, 2] = -1.0 * (1 + 4e-16)
    assert reduction_of(PolynomialMatrix([stiff, np.zeros((4, 4)), np.eye(4)])).is_symmetric


@pytest.mark.parametrize(
    ("stiffness", "damping", "dissipative"),
    [
        ([1e12, 1.0, 1.0], [0.0, 0.0, 0.0], True),
        ([1e12, -1e-3, 1.0], [0.0, 0.0, 0.0], False),
        ([1.0, 1.0, 1.0], [1e9, 0.0, 1.0], True),
        ([1.0, 1.0, 1.0], [1e9, 0.0, -1e-9], False),
    ],
)
def test_a_soft_instability_is_seen_beside_stiff_springs_and_dampers(stiffness, damping, dissipative):
    A = PolynomialMatrix([np.diag(stiffness), np.diag(damping), np.eye(3)])
    assert reduction_of(A).is_dissipative is dissipative


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_units_do_not_change_what_is_plain(unit):
    """Of time, and of one coordinate and one equation."""
    for K, C, M in (masses_and(static=1, damped=1), masses_and()):
        own = np.ones(6)
        own[2] = unit
        scaled = [matrix * own * own[:, None] * unit**power for power, matrix in enumerate((K, C, M))]
        expected, found = reduction_of(PolynomialMatrix([K, C, M])), reduction_of(PolynomialMatrix(scaled))
        assert found.state_count == expected.state_count
        assert found.is_symmetric == expected.is_symmetric
        assert found.is_dissipative == expected.is_dissipative


def conserving(random, ignorable: bool) -> PolynomialMatrix:
    """Damped masses, the last one without a spring of its own; where the others' springs pull at it, momentum drives them."""
    K, C, M = chain(3) + np.eye(3), np.diag(random.uniform(0.1, 0.5, 3)), np.eye(3)
    K[2] = 0.0
    K[:2, 2] = 0.0 if ignorable else random.uniform(0.2, 0.5, 2)
    C[2, :2] = random.uniform(-0.1, 0.1, 2)
    return PolynomialMatrix([K, C, M])


@pytest.mark.parametrize("ignorable", [True, False])
@pytest.mark.parametrize("seed", range(5))
def test_what_is_conserved_is_apart_from_the_rest_which_keeps_the_units_of_all_states(ignorable, seed, monkeypatch):
    """S is decoupled; balanced once, whether conserved numbers drive what is left of it or not."""
    balanced = []
    for module in (mbconstrained.linalg.blocks, mbconstrained.polynomial.reduced_equations):
        found = module.balancing_units
        monkeypatch.setattr(module, "balancing_units", lambda S, found=found: balanced.append(len(S)) or found(S))
    reduction = check(conserving(np.random.default_rng(seed), ignorable), states=6)
    parts, S = reduction.decoupled, reduction.generator
    assert reduction.is_well_separated and balanced == [6]
    assert np.allclose(parts.inverse @ S @ parts.basis, block_matrix(parts.blocks), rtol=0, atol=1e-13)
    assert np.allclose(parts.inverse @ parts.basis, np.eye(6), rtol=0, atol=1e-13)
    expected = np.sort_complex(np.round(np.linalg.eigvals(S), 8))
    assert np.allclose(np.sort_complex(np.round(np.linalg.eigvals(block_matrix(parts.blocks)), 8)), expected, atol=1e-7)


@pytest.mark.parametrize("seed", range(5))
def test_the_bound_of_the_spread_is_one(seed):
    """|s| of every eigenvalue lies between 1/|S^-1| and |S|, in any units of the states."""
    K, C, M = masses_and(static=1, damped=1, size=30, seed=seed)
    reduction = reduction_of(PolynomialMatrix([K, C, M]))
    assert not reduction.is_small
    assert reduction.spread <= reduction.spread_bound <= 1e6 * reduction.spread


def unlike(seed: int, size: int, part: float = 0.6) -> np.ndarray:
    """A matrix of sizes far apart, that is not symmetric, with so many of its entries."""
    random = np.random.default_rng(seed)
    return np.exp(random.normal(0, 3, (size, size))) * random.choice([-1, 1], (size, size)) * (random.random((size, size)) < part)


def product_of(M: np.ndarray, rows) -> float:
    return float(np.abs(M[np.asarray(rows), np.arange(len(M))]).prod())


@pytest.mark.parametrize("seed", range(12))
def test_no_order_of_few_rows_has_a_larger_product_on_the_diagonal(seed):
    M = unlike(seed, 2 + seed % 4)
    best = max(product_of(M, rows) for rows in permutations(range(len(M))))
    found = matching_rows(M)
    if not best:
        assert found is None or np.array_equal(M, M.T)  # what is symmetric stays as it is
    else:
        assert sorted(found) == list(range(len(M))) and np.isclose(product_of(M, found), best, rtol=1e-12)


def test_an_order_of_named_equations_is_found_back():
    order = np.array([2, 0, 3, 1])
    M = (np.diag([5.0, 3.0, 8.0, 2.0]) + np.eye(4, k=1))[order]
    assert (M[matching_rows(M)].diagonal() == [5, 3, 8, 2]).all()
