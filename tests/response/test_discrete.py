"""Difference equations against exact arithmetic: planted solutions, recursions over the rationals, boundary values, bad input."""

from __future__ import annotations

from fractions import Fraction

import flint
import numpy as np
import pytest
import scipy.signal

import mbconstrained as mb
from mbconstrained.exact.enclosure.sequences import rounded_values
from mbconstrained.ground.notices import NoticeKind
from mbconstrained.response.sample_recursion import SETTLED


def unimodular(random, r: int, factors: int, degree: int) -> list[np.ndarray]:
    """A product of elementary polynomial matrices with whole coefficients, ascending powers."""
    total = [np.eye(r, dtype=int)]
    for _ in range(factors if r > 1 else 0):
        i, j = random.choice(r, 2, replace=False)
        step = [np.eye(r, dtype=int)] + [np.zeros((r, r), dtype=int) for _ in range(degree)]
        for part in step:
            part[i, j] += random.integers(-1, 2) * (i != j)
        total = product(total, step)
    return total


def product(one, other) -> list[np.ndarray]:
    result = [np.zeros_like(one[0] @ other[0]) for _ in range(len(one) + len(other) - 1)]
    for i, a in enumerate(one):
        for j, b in enumerate(other):
            result[i + j] = result[i + j] + a @ b
    return result


def planted(random, leading: int = 2) -> mb.PolynomialMatrix:
    """A(z) = U(z) diag(d_i(z)) V(z) with whole coefficients: zeros anywhere (also at 0 and at infinity), any index."""
    r = int(random.integers(1, 4))
    diagonal = [np.zeros((r, r), dtype=int) for _ in range(3)]
    for i in range(r):
        middle = int(random.integers(-2, 3))
        entries = ([1], [0, 1], [middle, leading], [int(random.integers(1, 4)), middle, leading])[random.integers(4)]
        for power, entry in enumerate(entries):
            diagonal[power][i, i] = entry
    A = product(product(unimodular(random, r, 2, 1), diagonal), unimodular(random, r, 2, 1))
    while len(A) > 1 and not A[-1].any():
        A.pop()
    return mb.PolynomialMatrix([part.astype(float) for part in A])


def applied(A, x: np.ndarray) -> np.ndarray:
    """f_k = A(sigma) x_k of whole numbers x (K, r), exactly."""
    count = len(x) - A.degree
    return np.array([sum(A.coefficients[j] @ x[k + j] for j in range(A.degree + 1)) for k in range(count)])


def test_a_planted_solution_is_reproduced_by_random_systems_of_any_index():
    random = np.random.default_rng(1)
    orders = set()
    for _ in range(40):
        A = planted(random)
        x = random.integers(-9, 10, (30, A.size)).astype(float)
        f = applied(A, x)
        y = mb.solve_discrete(A, initial=x[: A.degree], force=f)
        ahead = y.equations.look_ahead
        orders.add(ahead)
        known = np.arange(len(f) - ahead)
        values = y(known)
        assert np.abs(values - x[known].T).max() <= 1e-12 * np.abs(x).max()
        assert not y.correction.any() and not y.violations
        assert y.error_estimate(known[np.abs(x[known]).max(axis=1) > 0]) < 1e-12
    assert max(orders) >= 2  # systems that look ahead were among them


@pytest.mark.parametrize("seed", range(3))
def test_free_and_forced_values_agree_with_the_exact_recursion(seed):
    random = np.random.default_rng(seed)
    for _ in range(10):
        q, r = int(random.integers(1, 4)), int(random.integers(1, 4))
        A = mb.PolynomialMatrix([random.integers(-3, 4, (r, r)) / 2 for _ in range(q)] + [np.eye(r) * 2 + np.eye(r, k=1)])
        initial = random.standard_normal((q, r))
        ratio, v = random.integers(-3, 4) / 4, random.standard_normal(r)
        forces = (
            (None, lambda k: np.zeros(r)),
            (mb.geometric(v, ratio, power=1), lambda k: [Fraction(x) * k * Fraction(ratio) ** k for x in v]),
        )
        for force, exact in forces:
            y = mb.solve_discrete(A, initial=initial, force=force)
            truth = _recursion_of_fractions(A, initial, exact, 40)
            for k in (0, 1, q, 7, 39):
                size = max(abs(value) for value in truth[k]) or 1
                values = y(k)
                assert max(abs(Fraction(float(a)) - b) for a, b in zip(values, truth[k])) <= Fraction(1e-12) * size
            assert y.error_estimate([1, 7, 39]) < 1e-12


def _recursion_of_fractions(A, initial, force, count):
    q = A.degree

    def number(value):
        return flint.fmpq(*Fraction(value).as_integer_ratio())

    parts = [flint.fmpq_mat([[number(float(v)) for v in row] for row in part]) for part in A.coefficients]
    x = [flint.fmpq_mat([[number(float(v))] for v in row]) for row in initial]
    inverse = parts[-1].inv()
    for k in range(count - q):
        right = flint.fmpq_mat([[number(v)] for v in force(k)])
        for j in range(q):
            right = right - parts[j] * x[k + j]
        x.append(inverse * right)
    return [[Fraction(int(entry.p), int(entry.q)) for entry in column.entries()] for column in x[:count]]


def test_values_at_a_million_agree_with_powers_of_whole_numbers():
    turn = mb.PolynomialMatrix([[[-0.8, 0.6], [-0.6, -0.8]], np.eye(2)])  # float64 numbers, slightly outside or inside the circle
    y = mb.solve_discrete(turn, initial=[1.0, 0.0])
    k = 10**6
    with flint.ctx.workprec(400):
        number = flint.acb(flint.arb(0.8), flint.arb(0.6)) ** k
        truth = np.array([float(number.real), float(number.imag)])
    assert np.abs(y(k) - truth).max() <= 1e-15
    assert y.error_estimate(k) < 1e-15


def test_a_harmonic_and_a_constant_reach_a_million():
    A = mb.PolynomialMatrix([[[-0.5]], [[1.0]]])
    k = np.array([0, 3, 10**6])
    y = mb.solve_discrete(A, initial=[0.0], force=mb.step([1.0]))
    assert np.allclose(y(k)[0], 2 * (1 - 0.5**k), rtol=1e-15)
    w = 0.3
    y = mb.solve_discrete(A, initial=[0.0], force=mb.harmonic([1.0], angular_frequency=w))
    with flint.ctx.workprec(300):
        ratio = (flint.acb(0, 1) * flint.arb(w)).exp()
        for number in k.tolist():
            truth = ((ratio**number - flint.arb(0.5) ** number) / (ratio - 0.5)).real
            assert abs(y(number)[0] - float(truth)) < 1e-15


def test_resonance_of_an_exact_ratio():
    y = mb.solve_discrete(mb.PolynomialMatrix([[[-0.5]], [[1.0]]]), initial=[0.0], force=mb.geometric([1.0], 0.5))
    k = np.arange(60)
    assert np.allclose(y(k)[0], k * 0.5 ** (k - 1.0), rtol=1e-15)


def test_a_nilpotent_leading_coefficient_looks_ahead_and_refuses_nothing():
    N = np.eye(3, k=1)
    A = mb.PolynomialMatrix([np.eye(3), -N])  # x = f + N f_(k+1) + N^2 f_(k+2)
    f = np.arange(12.0).reshape(4, 3)
    y = mb.solve_discrete(A, force=f)
    shifted = np.vstack([f, np.zeros((3, 3))])
    for k in range(4):
        assert np.array_equal(y(k), shifted[k] + N @ shifted[k + 1] + N @ N @ shifted[k + 2])
    assert not y(7).any()


def test_a_nilpotent_state_is_forgotten():
    y = mb.solve_discrete(mb.PolynomialMatrix([-np.eye(3, k=1), np.eye(3)]), initial=[1.0, 2.0, 4.0])
    assert y(range(4)).T.tolist() == [[1, 2, 4], [2, 4, 0], [4, 0, 0], [0, 0, 0]]


def test_a_start_that_does_not_fit_is_reported_with_the_condition():
    A = mb.PolynomialMatrix(
        [[[-0.5, 0.0], [1.0, -1.0]], [[1.0, 0.0], [0.0, 0.0]]], coordinates=["tank", "gauge"], equations=["flow", "reading"]
    )
    y = mb.solve_discrete(A, initial=[1.0, 3.0])
    assert y(0).tolist() == [1.0, 1.0]
    assert y.correction.tolist() == [[0.0, -2.0]]
    assert [notice.kind for notice in y.notices] == [NoticeKind.JUMP] * 2
    assert "gauge: its value at k = 0 is 1, not the given 3" in y.notices[0].text
    assert '"reading" at k = 0' in y.notices[1].text and "-2" in y.notices[1].text
    assert mb.solve_discrete(A, initial=[1.0, 1.0]).notices == ()


def test_boundary_values_of_a_horizon():
    N = 9
    A = mb.PolynomialMatrix(
        [[[-0.5, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0], [0.0, 0.0, -0.5], [0.0, 0.0, 0.0]]]
    )
    y = mb.solve_discrete(A, initial=[[2.0, 0.0, 0.0]], horizon=N, final=[[2.0 * 0.5**N, 7.0, 4.0]])
    x = y(np.arange(N + 1)).T
    assert np.abs(applied(A, x)).max() == 0
    assert x[0].tolist() == [2.0, 0.0, 0.0] and x[N].tolist() == [2.0 * 0.5**N, 7.0, 4.0] and x[N - 1, 1] == 2.0
    assert not y.notices
    wrong = mb.solve_discrete(A, initial=[[2.0, 0.0, 0.0]], horizon=N, final=[[1.0, 7.0, 4.0]])
    assert "x1: its value at k = 9" in wrong.notices[0].text
    with pytest.raises(mb.InputError, match="horizon ends at k = 9"):
        y(10)


def test_a_function_a_list_and_a_sequence_give_the_same_values():
    A = mb.PolynomialMatrix([[[0.25]], [[-1.0]], [[1.0]]])  # a double zero at 1/2
    k = np.arange(30)
    sequence = mb.geometric([1.0], -0.5) + 2.0 * mb.geometric([1.0], 1.0, power=2)
    values = sequence(k).T
    results = [mb.solve_discrete(A, initial=[1.0, 2.0], force=force)(k) for force in (sequence, values, lambda n: sequence(n))]
    for other in results[1:]:
        assert np.allclose(other, results[0], rtol=1e-13)


def test_degenerate_shapes():
    static = mb.PolynomialMatrix([[[2.0]]])
    assert mb.solve_discrete(static, force=[[4.0], [6.0]])([0, 1, 2]).tolist() == [[2.0, 3.0, 0.0]]
    assert mb.solve_discrete(static, initial=np.zeros((0, 1)))(3).tolist() == [0.0]
    one = mb.PolynomialMatrix([[[-2.0]], [[1.0]]])
    assert mb.solve_discrete(one, initial=1.0)(10).tolist() == [1024.0]
    assert mb.solve_discrete(one, initial=[[1.0]])([]).shape == (1, 0)
    with pytest.raises(mb.Overflow, match="k = 2000"):
        mb.solve_discrete(one, initial=1.0)([3, 2000])


def test_rank_decisions_follow_the_pairs_where_rounding_errors_are_the_leading_coefficient():
    noise = 0.1 + 0.2 - 0.3
    A = mb.PolynomialMatrix([[[-0.5, 0.0], [-1.0, 0.3]], [[1.0, 0.0], [0.0, noise]]], uncertainty=np.full((2, 2, 2), 1e-15))
    y = mb.solve_discrete(A, initial=[1.0, 1 / 0.3])
    assert np.allclose(y(4), [0.0625, 0.0625 / 0.3])
    assert any(notice.kind == NoticeKind.RANK and notice.doubtful for notice in y.notices)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"initial": [[1.0, 2.0, 3.0]]}, "initial: expected shape 2 x 2"),
        ({"initial": [[np.nan, 0.0], [0.0, 0.0]]}, "initial: the entry at"),
        ({"force": [[1.0, 2.0, 3.0]]}, "force: expected f_0, f_1, ... as rows, shape any x 2, found 1 x 3"),
        ({"force": np.ones((2, 5))}, "give its transpose"),
        ({"force": [1.0, 2.0]}, "a constant is mb.geometric"),
        ({"force": mb.step([1.0])}, "it has 1 row; expected 2"),
        ({"force": mb.impulse([1.0, 0.0])}, "Dirac impulses"),
        ({"force": "fast"}, "force: found 'fast'"),
        ({"horizon": 1}, "horizon"),
        ({"final": np.zeros((2, 2))}, "final: values at the end need a horizon"),
    ],
)
def test_bad_input_is_named(given, text):
    A = mb.PolynomialMatrix([np.eye(2), np.eye(2), np.eye(2)])
    with pytest.raises(mb.InputError, match=text.replace("(", r"\(")):
        mb.solve_discrete(A, **given)(0)


def test_numbers_between_samples_are_refused():
    y = mb.solve_discrete(mb.PolynomialMatrix([[[-2.0]], [[1.0]]]), initial=1.0)
    with pytest.raises(mb.InputError, match="no values between samples"):
        y(0.5)
    with pytest.raises(mb.InputError, match="numbered from 0"):
        y(-1)
    with pytest.raises(mb.InputError):
        y(np.nan)


def test_a_singular_matrix_is_refused_by_name():
    with pytest.raises(mb.SingularPolynomialMatrix):
        mb.solve_discrete(mb.PolynomialMatrix([np.ones((2, 2)), np.ones((2, 2))]))


def test_a_function_that_returns_nonsense():
    y = mb.solve_discrete(mb.PolynomialMatrix([[[-2.0]], [[1.0]]]), force=lambda k: [np.nan] if k == 2 else [0.0])
    with pytest.raises(mb.InputError, match=r"force\(2\)"):
        y(5)


# Samples by recursion against balls and exact fractions.


def balls(y, numbers) -> np.ndarray:
    return rounded_values([y._closed], y._sums, list(numbers))[0]


def assert_rounded(y, count: int) -> None:
    numbers = np.arange(count)
    exact, values = balls(y, numbers), y(numbers)
    assert (np.abs(values - exact) <= 2.0**-52 * np.abs(exact).max(axis=0)).all()
    assert y.error_estimate(numbers) < 1e-15


@pytest.mark.parametrize("seed", range(2))
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


def test_boundary_values_are_exact_and_any_ends_leave_solutions():
    random = np.random.default_rng(11)
    for _ in range(25):
        A = planted(random, 3)  # zeros that are thirds: no sample is a float64 number
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
