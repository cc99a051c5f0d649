"""Samples by recursion against balls and exact fractions, accuracy of its bound, and its speed relative to scipy.signal."""

from fractions import Fraction

import numpy as np
import pytest
import scipy.signal

import mbconstrained as mb
from mbconstrained.exact.enclosure.sequences import rounded_values
from mbconstrained.response.sample_recursion import SETTLED
from tests.response.test_discrete import applied, planted, product, unimodular


def balls(y, numbers) -> np.ndarray:
    return rounded_values([y._closed], y._sums, list(numbers))[0]


def assert_rounded(y, count: int) -> None:
    numbers = np.arange(count)
    exact, values = balls(y, numbers), y(numbers)
    assert (np.abs(values - exact) <= 2.0**-52 * np.abs(exact).max(axis=0)).all()
    assert y.error_estimate(numbers) < 1e-15


@pytest.mark.parametrize("seed", range(4))
def test_matrices_of_any_structure_agree_with_balls(seed):
    random = np.random.default_rng(seed)
    for _ in range(15):
        A = planted(random)
        initial = random.standard_normal((A.degree, A.size))  # mostly not admissible: the projection is refined too
        assert_rounded(mb.solve_discrete(A, initial=initial, force=random.standard_normal((20, A.size))), 25)


def test_state_spaces_and_transfer_functions_agree_with_balls():
    random = np.random.default_rng(1)
    for _ in range(10):
        n = int(random.integers(1, 6))
        system = mb.DiscreteStateSpace(*(random.standard_normal(shape) / 2 for shape in ((n, n), (n, 2), (1, n), (1, 2))))
        assert_rounded(system.solve(random.standard_normal(n), random.standard_normal((30, 2))).together, 40)
        b, a = random.standard_normal(int(random.integers(1, 5))), random.standard_normal(int(random.integers(1, 4)))
        assert_rounded(mb.discrete_transfer_function_response(b, a, random.standard_normal(30)), 40)


def test_products_of_input_matrix_and_input_are_exact():
    system = mb.DiscreteStateSpace([[1.0]], [[0.1, -0.3]], [[1.0]])
    u = np.random.default_rng(0).standard_normal((3000, 2))
    exact = sum(Fraction(0.1) * Fraction(a) - Fraction(0.3) * Fraction(b) for a, b in u.tolist())
    assert system.solve(input=u)(3000)[0] == float(exact)


def test_rank_decisions_lead_to_the_numbers_of_the_pairs():
    random = np.random.default_rng(2)
    U, V = random.standard_normal((2, 5, 5))
    A = mb.PolynomialMatrix(
        [
            U @ np.diag([0.5, -0.3, 0.2, 1.0, 1.0]) @ V,
            U @ (np.diag([1.0, 1.0, 1.0, 0.0, 0.0]) + np.eye(5, k=1) * [0, 0, 0, 0, 1]) @ V,
        ]
    )
    y = mb.solve_discrete(A, initial=random.standard_normal((1, 5)), force=random.standard_normal((20, 5)))
    assert not y.equations.is_exact and y.equations.look_ahead == 1
    numbers = np.arange(24)
    assert np.allclose(y(numbers), balls(y, numbers), rtol=1e-15, atol=1e-15)


def test_an_unstable_part_without_excitation_needs_balls_and_gets_them():
    system = mb.DiscreteStateSpace([[3.0, 0.0], [1.0, 0.5]], [[0.0], [1.0]], [[0.0, 1.0]])
    y = system.solve(input=np.ones((200, 1)))
    assert np.allclose(y.output(np.arange(200))[0], 2 * (1 - 0.5 ** np.arange(200.0)), rtol=1e-15)


@pytest.mark.parametrize("scale", [1e-320, 1e-300, 1e300])
def test_values_at_the_ends_of_float64(scale):
    y = mb.solve_discrete(mb.PolynomialMatrix([[[-0.5]], [[1.0]]]), initial=[scale], force=np.full((3, 1), scale))
    assert y([0, 1, 2]).tolist()[0] == [scale, 1.5 * scale if scale > 1e-310 else float(Fraction(3, 2) * Fraction(scale)), y(2)[0]]
    assert abs(Fraction(float(y(2)[0])) - Fraction(7, 4) * Fraction(scale)) <= Fraction(1e-15) * Fraction(scale) + Fraction(5e-324)


def test_growth_beyond_float64_is_refused_at_the_first_sample():
    y = mb.solve_discrete(mb.PolynomialMatrix([[[-2.0]], [[1.0]]]), initial=[1.0], force=np.ones((5000, 1)))
    assert y(1022)[0] == 2.0**1023
    with pytest.raises(mb.Overflow, match="k = 1023 "):
        y([10, 1023, 4000])


def test_zeros_by_cancellation_are_zero():
    y = mb.solve_discrete(mb.PolynomialMatrix([[[-1.0]], [[1.0]]]), initial=[1.0], force=[[-1.0], [0.0], [1.0]])
    assert y(range(5)).tolist() == [[1.0, 0.0, 0.0, 1.0, 1.0]]


def test_nothing_has_no_samples():
    y = mb.solve_discrete(mb.PolynomialMatrix(np.zeros((2, 0, 0))), force=np.zeros((3, 0)))
    assert y([0, 1]).shape == (0, 2) and y.terms == () and y.notices == ()


def thirds(random) -> mb.PolynomialMatrix:
    """Like ``planted``, with zeros that are thirds: no sample is a float64 number."""
    r = int(random.integers(1, 4))
    diagonal = [np.zeros((r, r), dtype=int) for _ in range(3)]
    for i in range(r):
        for power, entry in enumerate(
            ([1], [0, 1], [int(random.integers(-2, 3)), 3], [2, int(random.integers(-2, 3)), 3], [3, 1])[random.integers(5)]
        ):
            diagonal[power][i, i] = entry
    A = product(product(unimodular(random, r, 2, 1), diagonal), unimodular(random, r, 2, 1))
    while len(A) > 1 and not A[-1].any():
        A.pop()
    return mb.PolynomialMatrix([part.astype(float) for part in A])


def test_boundary_values_are_exact_and_any_ends_leave_solutions():
    random = np.random.default_rng(11)
    for _ in range(25):
        A = thirds(random)
        q, r = A.degree, A.size
        if not q:
            continue
        N = int(random.integers(2 * q, 2 * q + 12))
        x = random.integers(-4, 5, (N + 1, r)).astype(float)
        f = applied(A, x)
        y = mb.solve_discrete(A, initial=x[:q], force=f, horizon=N, final=x[N - q + 1 :])
        assert np.array_equal(y(np.arange(N + 1)).T, x)
        ends = random.integers(-4, 5, (2, q, r)).astype(float)
        v = mb.solve_discrete(A, initial=ends[0], force=f, horizon=N, final=ends[1])(np.arange(N + 1)).T
        for k in range(N - q + 1):  # the equations hold whatever the ends are
            terms = np.array([[[A.coefficients[j][i, c] * v[k + j, c] for c in range(r)] for j in range(q + 1)] for i in range(r)])
            size = np.abs(terms).sum(axis=(1, 2)) + np.abs(f[k])
            assert (np.abs(terms.sum(axis=(1, 2)) - f[k]) <= 1e-14 * size).all()


@pytest.mark.parametrize(("n", "count"), [(4, 20_000), (40, 50)])
def test_many_samples_and_many_states_need_no_balls(n, count):
    random = np.random.default_rng(0)
    A, B, C = random.standard_normal((n, n)), random.standard_normal((n, 1)), random.standard_normal((1, n))
    A *= 0.95 / np.abs(np.linalg.eigvals(A)).max()
    u = random.standard_normal((count, 1))
    y = mb.DiscreteStateSpace(A, B, C).solve(input=u)
    _, reference, _ = scipy.signal.dlsim(scipy.signal.StateSpace(A, B, C, [[0.0]], dt=1.0), u)
    assert np.allclose(y.output(np.arange(count))[0], reference[:, 0], rtol=1e-9, atol=1e-9)
    assert (y.together._recursive(count - 1)[1] <= SETTLED).all()
