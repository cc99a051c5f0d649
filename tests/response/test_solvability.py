"""A(d/dt) x = f for matrices that are singular or not square: planted solutions are found, contradictions refused by name."""

import math
from fractions import Fraction

import numpy as np
import pytest

import mbconstrained as mb

# Pencils P diag(L_eps, L_eta^T, regular with Jordan blocks, nilpotent blocks) Q with whole numbers, and solutions
# x(t) = sum of c_kj t^k e^(a_j t), of which f = A(d/dt) x follows in whole numbers.


def wide(epsilon):
    """L_epsilon, epsilon x (epsilon + 1): s in the diagonal, -1 right of it."""
    return np.array([-np.eye(epsilon, epsilon + 1, 1), np.eye(epsilon, epsilon + 1)])


def tall(eta):
    return wide(eta).transpose(0, 2, 1)


def jordan(size, zero):
    return np.array([-zero * np.eye(size) - np.eye(size, k=1), np.eye(size)])


def nilpotent(size):
    return np.array([np.eye(size), np.eye(size, k=1)])


def diagonal(blocks):
    rows, columns = sum(len(b[0]) for b in blocks), sum(len(b[0].T) for b in blocks)
    result, i, j = np.zeros((2, rows, columns)), 0, 0
    for block in blocks:
        _, m, n = block.shape
        result[:, i : i + m, j : j + n] = block
        i, j = i + m, j + n
    return result


def regular_matrix(random, size):
    while True:
        matrix = random.integers(-2, 3, (size, size)).astype(float)
        if size == 0 or abs(np.linalg.det(matrix)) > 0.5:
            return matrix


class Planted:
    """A(s), a solution x and its force, from a seed."""

    def __init__(self, seed):
        random = self.random = np.random.default_rng(seed)
        wides = [wide(int(k)) for k in random.integers(0, 3, random.integers(0, 3))]
        self.tails = [int(k) for k in random.integers(0, 3, random.integers(0, 3))]
        if not wides and not self.tails:
            self.tails = [2]
        others = [jordan(int(random.integers(1, 3)), int(random.integers(-3, 2))) for _ in range(random.integers(1, 3))]
        others += [nilpotent(int(random.integers(1, 3))) for _ in range(random.integers(0, 2))]
        kronecker = diagonal([*[tall(eta) for eta in self.tails], *wides, *others])
        self.freedom, self.redundancy = len(wides), len(self.tails)
        _, m, n = kronecker.shape
        self.P, Q = regular_matrix(random, m), regular_matrix(random, n)
        A = np.einsum("ij,kjl,lp->kip", self.P, kronecker, Q)
        if seed % 3 == 0 and n > 1:  # times I + s E, E^2 = 0, of degree 2: unimodular, so the structure stays
            E = np.zeros((n, n))
            E[random.permutation(n)[0], :] = 0
            E[0, n - 1] = 1.0
            A = np.array([A[0], A[1] + A[0] @ E, A[1] @ E])
        self.A = mb.PolynomialMatrix(A)
        self.shape, self.rates = (m, n), random.permutation([-2, -1, 0, 1])[:2].tolist()
        self.terms = {(k, a): random.integers(-3, 4, n).astype(float) for a in self.rates for k in range(2)}

    def derivative(self, terms):
        result = {}
        for (k, a), vector in terms.items():
            result[k, a] = result.get((k, a), 0) + a * vector
            if k:
                result[k - 1, a] = result.get((k - 1, a), 0) + k * vector
        return result

    @property
    def initial(self):
        terms, rows = self.terms, []
        for _ in range(self.A.degree):
            rows.append(sum(vector for (k, _), vector in terms.items() if k == 0) + np.zeros(self.shape[1]))
            terms = self.derivative(terms)
        return np.array(rows)

    @property
    def force(self):
        total, terms = mb.zero(self.shape[0]), self.terms
        for matrix in self.A.coefficients:
            for (k, a), vector in terms.items():
                if (matrix @ vector).any():
                    total = total + mb.term(matrix @ vector, power=k, rate=a)
            terms = self.derivative(terms)
        return total

    def signal(self, i):
        return sum((mb.term([vector[i]], power=k, rate=a) for (k, a), vector in self.terms.items()), mb.zero(1))

    def values(self, times):
        return np.array([sum(np.outer(v, t**k * np.exp(a * t)) for (k, a), v in self.terms.items())[:, 0] for t in times]).T

    def free(self):
        report = mb.solvability(self.A, self.initial, self.force)
        assert (len(report.conditions), report.freedom) == (self.redundancy, self.freedom)
        assert report.is_solvable, report
        return {name: self.signal(self.A.coordinates.index(name)) for name in report.chosen}


TIMES = np.array([0.0, 0.01, 0.3, 1.0, 2.5, 6.0])


def check_planted(seed):
    planted = Planted(seed)
    x = mb.solve(planted.A, planted.initial, planted.force, free=planted.free())
    expected = planted.values(TIMES)
    error, size = np.abs(x(TIMES) - expected).max(), np.abs(expected).max()
    doubtful = any(notice.doubtful for notice in x.notices)
    assert error <= 1.1 * x.error_estimate(TIMES) * size + 1e-14 * size or doubtful, (seed, error / size)
    assert not x.jump.any() and not x.impulses
    assert error <= 1e-11 * size or doubtful
    box = x.enclose(TIMES, digits=12)
    exact = [
        [sum(Fraction(v[i]) * Fraction(t) ** k * Fraction(math.exp(a * t)) for (k, a), v in planted.terms.items()) for t in TIMES]
        for i in range(planted.shape[1])
    ]
    widths = np.array([[float(abs(Fraction(low) - e)) for low, e in zip(*rows)] for rows in zip(box.lower, exact)])
    assert (widths <= 1e-9 * size).all(), seed


@pytest.mark.parametrize("part", [0, 1, *(pytest.param(part, marks=pytest.mark.long) for part in range(2, 12))])
def test_planted_solutions_are_found(part):
    for seed in range(12 * part, 12 * part + 12):
        check_planted(seed)


def test_a_growing_force_and_a_slow_motion_are_reported_without_overflow():
    """Notices test the equations up to ten times the slowest time, where e^t is beyond the range of float64."""
    x = mb.solve(mb.PolynomialMatrix([[[0.001, 0.0]], [[1.0, -1.0]]]), None, mb.term([1.0], rate=1.0), free={"x2": mb.step([1.0])})
    assert not any(notice.doubtful for notice in x.notices)


# Contradictions: the force of a planted solution and another outside the range of A(d/dt).


def polynomials(condition, equations):
    """N(s) of a condition, shape (degree + 1, m)."""
    degree = max(len(factors) for _, factors in condition.equations)
    row = np.zeros((degree, len(equations)))
    for name, factors in condition.equations:
        row[: len(factors), equations.index(name)] = factors
    return row


def convolved(row, coefficients):
    """N(s) A(s), highest powers last."""
    result = np.zeros((len(row) + len(coefficients) - 1, coefficients.shape[2]))
    for k, factors in enumerate(row):
        for power, matrix in enumerate(coefficients):
            result[k + power] += factors @ matrix
    return result


def check_contradiction(seed):
    planted = Planted(seed)
    if not planted.tails:
        return
    begins = float(planted.random.integers(0, 3))
    place = planted.random.integers(0, planted.tails[0] + 1)  # an equation of the first block L_eta^T
    outside = planted.P[:, place]
    force = planted.force + mb.term(outside, rate=-1.0).delayed(begins)
    with pytest.raises(mb.NotSolvable) as caught:
        mb.solve(planted.A, planted.initial, force, free=planted.free())
    assert len(caught.value.conditions) == planted.redundancy
    rows = [polynomials(one, planted.A.equations) for one in caught.value.conditions]
    for row in rows:
        noise = 1e-14 * convolved(np.abs(row), np.abs(planted.A.coefficients))
        assert (np.abs(convolved(row, planted.A.coefficients)) <= noise).all()
    for row, condition in zip(rows, caught.value.conditions):
        factors = row @ outside  # N(s) P e
        factors[np.abs(factors) < 1e-14 * (np.abs(row) @ np.abs(outside))] = 0.0
        assert condition.is_satisfied == (not factors.any()), (seed, condition)
        if factors.any():
            assert condition.time == begins and not condition.is_doubtful
            remains = sum(c * (-1.0) ** k for k, c in enumerate(factors))  # N(d/dt) e^-t = N(-1) e^-t and impulses
            if condition.impulse is None:
                assert condition.size == pytest.approx(remains)
            assert condition.combination in str(caught.value)


@pytest.mark.parametrize("part", [0, 1, *(pytest.param(part, marks=pytest.mark.long) for part in range(2, 12))])
def test_contradictions_are_refused_by_name(part):
    for seed in range(12 * part, 12 * part + 12):
        check_contradiction(seed)


GAUGES = mb.PolynomialMatrix([[[3.0], [1.0], [2.0]], [[1.0], [0.0], [0.0]]], ["x"], ["motion", "gauge 1", "gauge 2"])


def test_values_at_zero_may_contradict():
    """x' + 3 x = 3, x = 1 and 2 x = 2 hold for x(0-) = 1 alone: another value would jump, and make an impulse in x'."""
    force = mb.step([3.0, 1.0, 2.0])
    x = mb.solve(GAUGES, [[1.0]], force)
    assert x([0.0, 5.0]).tolist() == [[1.0, 1.0]] and not x.jump.any()
    with pytest.raises(mb.NotSolvable, match=r"impulse of size .* at t = 0 s, with the values of x at 0-") as caught:
        mb.solve(GAUGES, [[0.5]], force)
    (violated,) = [one for one in caught.value.conditions if not one.is_satisfied]
    assert (violated.time, violated.impulse, violated.coordinates) == (0.0, 0, ("x",))
    assert abs(violated.size) == pytest.approx(0.5)


def test_a_contradiction_is_reported_with_its_size_and_time():
    """Gauge 2 shows twice gauge 1, and 3 more from t = 1 s on."""
    force = mb.step([3.0, 1.0, 2.0]) + mb.step([0.0, 0.0, 3.0]).delayed(1.0)
    with pytest.raises(mb.NotSolvable, match='2 "gauge 1" - "gauge 2": the left side is zero .* is -3 from t = 1 s on'):
        mb.solve(GAUGES, [[1.0]], force)
    report = mb.solvability(GAUGES, [[1.0]], force)
    assert not report.is_solvable and report.rank == 1 and report.freedom == 0
    assert "not solvable: 3 equations of rank 1 for 1 coordinate" in repr(report)
    assert max(map(len, report.summary().splitlines())) <= 80


def test_rounding_errors_contradict_nothing_and_what_may_be_one_is_doubtful():
    """0.1 + 0.2 against 0.3 is a rounding error; 1e-13 may be one; 1e-9 is none, unless the data are measured."""
    A = mb.PolynomialMatrix([[[1.0], [1.0]]])
    x = mb.solve(A, None, mb.step([0.1 + 0.2, 0.3]))
    assert x(1.0)[0] == pytest.approx(0.3) and not any(notice.doubtful for notice in x.notices)
    assert any(notice.doubtful for notice in mb.solve(A, None, mb.step([0.3, 0.3 + 1e-13])).notices)
    measured = mb.step([0.3, 0.3 + 1e-9])
    with pytest.raises(mb.NotSolvable, match="rank_tolerance"):
        mb.solve(A, None, measured)
    assert mb.solve(A, None, measured, 1e-8)(0.0)[0] == pytest.approx(0.3)


def test_decimals_are_dependent_as_they_are_written():
    """3 times 0.1 is not 0.3 in binary numbers: the equations would be independent by rounding errors."""
    A = mb.PolynomialMatrix([[[0.1, 0.7], [0.3, 2.1]]])
    x = mb.solve(A, None, mb.step([0.1, 0.3]), free={"x2": mb.ramp([1.0])})
    assert x(2.0) == pytest.approx([1.0 - 7.0 * 2.0, 2.0])


# Free coordinates.

BEAM = mb.PolynomialMatrix(
    [[[2.0, -1.0, 0.0], [0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]], ["a", "b", "c"]
)  # a' + 2 a = b, c' + c = 0


def test_a_free_coordinate_moves_as_given():
    """a' + 2 a = b with b = 2 from a(0-) = 0: a = 1 - e^(-2 t), c = e^(-t)."""
    t = np.linspace(0.0, 3.0, 7)
    x = mb.solve(BEAM, [[0.0, 2.0, 1.0]], free={"b": mb.step([2.0])})
    np.testing.assert_allclose(x(t), [1 - np.exp(-2 * t), 2 + 0 * t, np.exp(-t)], atol=1e-14)
    assert x.polynomial_matrix.equations == ("equation 1", "equation 2", "choice of b")
    y = mb.solve(BEAM, [[0.0, 2.0, 1.0]], free={"a": mb.ramp([1.0])})  # b = a' + 2 a
    np.testing.assert_allclose(y(t), [t, 1 + 2 * t, np.exp(-t)], atol=1e-14)
    assert y.jump.tolist() == [[0.0, -1.0, 0.0]]


def test_a_jump_of_a_free_coordinate_makes_impulses():
    """a jumps by 1: b = a' + 2 a has an impulse of 1."""
    x = mb.solve(BEAM, free={"a": mb.step([1.0])})
    assert [part.tolist() for part in x.impulses] == [[0.0, 1.0, 0.0]]


def test_coordinates_that_are_not_named_are_chosen_and_reported():
    x = mb.solve(BEAM, [[1.0, 0.0, 1.0]], free={})
    assert x.of("b")([0.0, 1.0]).tolist() == [[0.0, 0.0]]
    assert [notice.text for notice in x.notices if notice.kind == mb.NoticeKind.FREE] == [
        "b: the equations leave it free; its motion was chosen to be zero"
    ]


@pytest.mark.parametrize(
    "A, free, text",
    [
        (BEAM, {"d": 0.0}, 'free: there is no coordinate "d"'),
        (BEAM, {"c": 0.0}, 'free: "c" is determined by the equations; choose of a, b$'),
        (BEAM, {"a": 0.0, "b": 0.0}, 'free: found "a", "b"; 1 coordinate may be chosen, of a, b'),
        (BEAM, {"b": mb.step([1.0, 2.0])}, "free: b: the signal has 2 rows; expected 1"),
        (BEAM, ["b"], "free: found list; expected signals by names"),
        (mb.PolynomialMatrix([[[1.0]]]), {"x1": 0.0}, 'free: the equations determine every coordinate, "x1" too'),
        (
            mb.PolynomialMatrix([[[1.0, -1.0, 0.0, 0.0]]]),
            {"x1": 0.0, "x2": 0.0},
            'free: "x1", "x2" determine each other and cannot all be chosen',
        ),
    ],
)
def test_choices_that_are_none_are_refused(A, free, text):
    with pytest.raises(mb.InputError, match=text):
        mb.solve(A, free=free)


def test_without_a_choice_free_coordinates_are_refused_by_name():
    with pytest.raises(mb.SingularPolynomialMatrix, match='leave 1 coordinate free, of "a", "b": give free='):
        mb.solve(BEAM)


@pytest.mark.parametrize("seed", range(5))
def test_rounded_equations_are_solved_like_the_exact_ones(seed):
    """Q A(s) Z with orthogonal Q and Z: every number is rounded, rank and free motions are those of A(s)."""
    planted, random = Planted(seed), np.random.default_rng(seed)
    Q, Z = (np.linalg.qr(random.normal(size=(k, k)))[0] for k in planted.shape)
    A = mb.PolynomialMatrix(Q @ planted.A.coefficients @ Z)
    initial, force = planted.initial @ Z, planted.force.mapped(Q)
    report = mb.solvability(A, initial, force)
    assert (len(report.conditions), report.freedom) == (planted.redundancy, planted.freedom) and report.is_solvable
    signals = (planted.signal(i) for i in range(planted.shape[1]))
    columns = [signal.mapped(Z.T[:, [i]]) for i, signal in enumerate(signals)]
    motion = sum(columns[1:], columns[0])
    free = {name: motion.mapped(np.eye(planted.shape[1])[[A.coordinates.index(name)]]) for name in report.chosen}
    x = mb.solve(A, initial, force, free=free)
    expected = Z.T @ planted.values(TIMES)
    error = np.abs(x(TIMES) - expected).max() / np.abs(expected).max()
    assert error <= max(x.error_estimate(TIMES), 1e-14) and error < 1e-10


def test_the_least_start_cannot_be_made_smaller_by_any_free_motion():
    """x1 + x2 = 3 has the least solution (1.5, 1.5); constants and rates chosen at random give no smaller norm of x(0+)."""
    x = mb.solve(mb.PolynomialMatrix([[[1.0, 1.0]]]), force=mb.step([3.0]), free="least start")
    assert np.allclose(x([0.0, 2.0]), 1.5, atol=1e-14)
    A = mb.PolynomialMatrix([[[1.0, 1.0, 0.5], [0.0, 1.0, 1.0]], [[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]]])
    force, report = mb.step([3.0, -1.0]) + mb.ramp([0.5, 0.0]), mb.solvability(A)
    x = mb.solve(A, force=force, free="least start")
    t = np.linspace(0.1, 3.0, 7)
    assert np.allclose(A.coefficients[0] @ x(t) + A.coefficients[1] @ x.derivative()(t), force(t), atol=1e-12)
    for choices in np.random.default_rng(1).normal(size=(30, report.freedom, 2)):
        free = {name: mb.step([value]) + mb.ramp([rate]) for name, (value, rate) in zip(report.chosen, choices)}
        assert np.linalg.norm(x(0.0)) <= np.linalg.norm(mb.solve(A, force=force, free=free)(0.0)) * (1 + 1e-12)
    with pytest.raises(mb.InputError, match="least start"):
        mb.solve(A, free="least")


def test_a_square_contradiction_is_not_solvable_and_a_free_coordinate_is_named():
    A = mb.PolynomialMatrix([[[1.0, 1.0], [2.0, 2.0]]])
    with pytest.raises(mb.NotSolvable) as refusal:
        mb.solve(A, force=mb.step([1.0, 3.0]))
    (condition,) = refusal.value.conditions
    assert {name for name, _ in condition.equations} == {"equation 1", "equation 2"}
    with pytest.raises(mb.SingularPolynomialMatrix, match="free="):
        mb.solve(A, force=mb.step([1.0, 2.0]))
