"""Every value of a small model is right to 1e-12 of the largest value at that time, and the estimate is never far below the error.

The families are those in which a weak coupling, a small force or a soft spring decides the answer in the end. The oracle is mpmath's
exponential of a first-order form with 60 digits, made from the data by solutions in fractions: nothing of the package enters.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mbconstrained as mb

DIGITS, MOST_DIGITS = 60, 2000

#: What is promised, and what an estimate may be below the error.
ACCURACY, BELOW = 1e-12, 10.0


@dataclass(frozen=True)
class Model:
    """M x'' + C x' + K x = f step(t) from x, x' at 0, all numbers floats; M regular."""

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    force: np.ndarray

    @classmethod
    def of(cls, mass, damping, stiffness, displacement=None, velocity=None, force=None) -> Model:
        n = len(mass)
        vectors = (np.zeros(n) if vector is None else np.array(vector, float) for vector in (displacement, velocity, force))
        return cls(np.array(mass, float), np.array(damping, float), np.array(stiffness, float), *vectors)

    def response(self) -> mb.Response:
        A = mb.PolynomialMatrix([self.stiffness, self.damping, self.mass])
        return mb.solve(A, [self.displacement, self.velocity], mb.step(self.force) if self.force.any() else None)

    def oracle(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """x and x' at a time, exact data, as mpmath numbers; what has decayed below the digits is computed anew with more of them."""
        values, digits = self._oracle(time), mpmath.mp.dps
        start = max(1.0, *np.abs(self.displacement), *np.abs(self.velocity))
        if digits < MOST_DIGITS and any(0 < max(map(abs, row)) < mpmath.mpf(10) ** -(digits // 2) * start for row in values):
            with mpmath.workdps(2 * digits):
                return self.oracle(time)
        return values

    def _oracle(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        n = len(self.mass)
        right = solved(self.mass, np.column_stack([-self.stiffness, -self.damping, self.force]))
        G = mpmath.zeros(2 * n + 1)
        for i in range(n):
            G[i, n + i] = 1
            for j in range(2 * n + 1):
                G[n + i, j] = mpmath.mpf(right[i][j].numerator) / right[i][j].denominator
        start = mpmath.matrix([*map(float, self.displacement), *map(float, self.velocity), 1.0])
        values = exponential(G * mpmath.mpf(float(time))) * start
        return np.array(list(values[:n]), dtype=object), np.array(list(values[n : 2 * n]), dtype=object)


def exponential(X: mpmath.matrix) -> mpmath.matrix:
    """e^X by its Taylor series, squared; digits as many as the squares lose are added."""
    size = max(1, int(mpmath.ceil(mpmath.log(mpmath.mnorm(X, 1) + 1, 2))))
    with mpmath.workdps(mpmath.mp.dps + size + 20):
        X, total = X / mpmath.mpf(2) ** (size + 4), mpmath.eye(X.rows)
        term, k = mpmath.eye(X.rows), 0
        while mpmath.mnorm(term, 1) > mpmath.mpf(10) ** -(mpmath.mp.dps + 5):
            k += 1
            term = term * X / k
            total += term
        for _ in range(size + 4):
            total = total * total
        return total


def solved(matrix: np.ndarray, right: np.ndarray) -> list[list[Fraction]]:
    """matrix^-1 right by Gauss and Jordan in fractions."""
    n = len(matrix)
    rows = [[Fraction(x) for x in (*matrix[i].tolist(), *right[i].tolist())] for i in range(n)]
    for k in range(n):
        pivot = next(i for i in range(k, n) if rows[i][k])
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(n):
            if i != k and rows[i][k]:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k])]
    return [row[n:] for row in rows]


def check(model: Model, times) -> None:
    """x, x' and the estimate at each time, asked alone and with all others."""
    x = model.response()
    with mpmath.workdps(DIGITS):
        for order in (0, 1):
            together = x.derivative(order)(np.array(times, float))
            for k, time in enumerate(times):
                true = model.oracle(time)[order]
                size = max(map(abs, true))
                alone = x.derivative(order)(time)
                for values in (alone, together[:, k]):
                    error = max(abs(mpmath.mpf(float(value)) - exact) for value, exact in zip(values, true))
                    estimate = x.error_estimate(time, order=order)
                    assert error <= max(ACCURACY, BELOW * estimate) * size, (order, time, float(error / size), estimate)
                    assert error <= ACCURACY * size or not x.function.is_provable, (order, time, float(error / size))


EYE = np.eye(2)


@pytest.mark.parametrize("coupling", [1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-19])
def test_a_weakly_coupled_part_that_goes_on_when_the_strong_one_has_decayed(coupling):
    e = coupling
    check(Model.of(EYE, np.diag([1.0, 0.0]), [[1 + e, -e], [-e, 1 + e]], [1.0, 0.0]), [0.0, 0.3, 10.0, 60.0, 100.0])


@pytest.mark.parametrize("coupling", [1e-3, 1e-10, 1e-16, 1e-18, 1e-30])
def test_a_growing_part_driven_through_a_tiny_entry(coupling):
    check(Model.of(EYE, 0 * EYE, [[4.0, 0.0], [coupling, -1.0]], [1.0, 0.0]), [0.1, 5.0, 60.0])


@pytest.mark.parametrize("small", [1e-6, 1e-15, 1e-25])
@pytest.mark.parametrize("stiffness", [-1.0, 1.0])
def test_a_small_force_next_to_a_large_one(small, stiffness):
    check(Model.of(EYE, np.diag([0.5, 0.0]), np.diag([4.0, stiffness]), force=[1.0, small]), [0.01, 1.0, 60.0])


@pytest.mark.parametrize("ground", [2.0**-20, 2.0**-47])
def test_a_free_chain_with_tiny_ground_springs(ground):
    n = 4
    K = np.diag([1.0, *[2.0] * (n - 2), 1.0]) - np.eye(n, k=1) - np.eye(n, k=-1) + ground * np.eye(n)
    check(Model.of(np.eye(n), 0 * K, K, np.ones(n)), [1.0, 1e3, 1e7])


@pytest.mark.parametrize("row", [[1.0, -1.0, 0.0], [1.0, -3.0, 0.5], [0.3, -0.7, 1.1]])
@pytest.mark.parametrize("stiffness", [1e3, 1e9, 1e14])
def test_a_stiff_spring_along_a_constraint_row(row, stiffness):
    """The spring does nothing, and its rounding errors do much. The oracle: x3 or x2 eliminated in fractions."""
    K = stiffness * np.outer(row, row) + np.diag([1.0, 2.0, 3.0])
    start = np.cross(row, [1.0, 1.0, 1.0])
    motion = mb.MechanicalSystem(np.diag([1.0, 2.0, 1.5]), 0.1 * np.eye(3), K, [mb.Constraint(row)]).solve(start)
    a, fixed = [Fraction(x) for x in row], 2 if row[2] else 1
    free = [k for k in range(3) if k != fixed]
    V = [[Fraction(i == k) if i != fixed else -a[k] / a[fixed] for k in free] for i in range(3)]

    def reduced(matrix: np.ndarray) -> list[list[Fraction]]:
        X = [[Fraction(x) for x in line] for line in matrix.tolist()]
        return [[sum(V[i][k] * X[i][j] * V[j][m] for i in range(3) for j in range(3)) for m in range(2)] for k in range(2)]

    M, C, whole = reduced(np.diag([1.0, 2.0, 1.5])), reduced(0.1 * np.eye(3)), reduced(K)
    right = solved(np.array(M, dtype=object), np.array([[-x for x in (*k, *c)] for k, c in zip(whole, C)], dtype=object))
    with mpmath.workdps(DIGITS):
        G = mpmath.zeros(4)
        for i in range(2):
            G[i, 2 + i] = 1
            for j in range(4):
                G[2 + i, j] = mpmath.mpf(right[i][j].numerator) / right[i][j].denominator
        for time in (0.7, 20.0, 100.0):
            z = exponential(G * time) * mpmath.matrix([*start[free].tolist(), 0.0, 0.0])
            expected = [sum(mpmath.mpf(v.numerator) / v.denominator * z[k] for k, v in enumerate(line)) for line in V]
            error = max(abs(mpmath.mpf(float(value)) - exact) for value, exact in zip(motion(time), expected))
            assert error <= ACCURACY * max(map(abs, expected))


def test_a_small_input_of_a_state_space():
    system = mb.StateSpace(np.diag([-1.0, 1.0]), [[1.0], [1e-15]], np.eye(2))
    x = system.solve(input=mb.step([1.0]))
    with mpmath.workdps(DIGITS):
        expected = mpmath.mpf(1e-15) * mpmath.expm1(60)
        assert abs(x(60.0)[1] - expected) <= ACCURACY * expected
        assert abs(x.output(60.0)[1] - expected) <= ACCURACY * expected


@st.composite
def graded_models(draw, largest: int = 3) -> Model:
    """Chains, dense symmetric and unsymmetric models; couplings, forces, starts and units over many orders of magnitude."""
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    n = draw(st.integers(1, largest))
    exponents = draw(st.sampled_from([(0, 0), (-6, 0), (-12, 0), (-19, 0), (-16, -9)]))
    kind = draw(st.sampled_from(["chain", "symmetric", "unsymmetric"]))

    def matrix(diagonal: np.ndarray) -> np.ndarray:
        parts = random.normal(size=(n, n)) * 10.0 ** random.uniform(*exponents, size=(n, n))
        if kind != "unsymmetric":
            parts = np.triu(parts, 1) + np.triu(parts, 1).T
        if kind == "chain":
            parts = np.triu(np.tril(parts, 1), -1)
        parts *= random.random((n, n)) < 0.8
        return parts - np.diag(np.diag(parts)) + np.diag(diagonal)

    K = matrix(random.choice([1.0, 1.0, 2.0, 4.0, 0.0, -0.1], size=n) * random.uniform(0.5, 2.0, size=n))
    C = matrix(random.choice([0.0, 0.0, 0.1, 1.0, 3.0], size=n))
    M = np.diag(random.uniform(0.5, 2.0, size=n))
    if draw(st.booleans()):
        M = M + 0.1 * matrix(np.zeros(n))
    if draw(st.booleans()):
        C = np.diag(np.diag(C))
    units = 10.0 ** random.integers(-8, 8, size=n) if draw(st.booleans()) else np.ones(n)
    rows = 10.0 ** random.integers(-8, 8, size=n) if draw(st.booleans()) else np.ones(n)
    M, C, K = (matrix * units * rows[:, None] for matrix in (M, C, K))
    vectors = [random.normal(size=n) * 10.0 ** random.uniform(*exponents, size=n) * (random.random(n) < 0.6) for _ in range(3)]
    if not any(vector.any() for vector in vectors):
        vectors[0][0] = 1.0
    return Model.of(M, C, K, vectors[0] / units, vectors[1] / units, vectors[2] * rows if draw(st.booleans()) else None)


times_of = st.lists(st.sampled_from([0.0, 1e-3, 0.1, 0.7, 3.0, 10.0, 40.0, 100.0, 300.0]), min_size=1, max_size=3, unique=True)


@pytest.mark.long
@settings(deadline=None, max_examples=25)
@given(graded_models(), times_of)
def test_graded_models(model, times):
    check(model, times)


@pytest.mark.long
@settings(deadline=None, max_examples=25)
@given(graded_models(largest=8), times_of)
def test_larger_graded_models(model, times):
    check(model, times)


def graded_chain(seed: int, n: int = 5) -> mb.MechanicalSystem:
    """Masses one behind the other with springs of four orders of magnitude, lightly damped."""
    rng = np.random.default_rng(seed)
    k, links = 10.0 ** rng.uniform(-1, 3, n), np.eye(n) - np.eye(n, k=-1)
    K = links.T @ np.diag(k) @ links
    return mb.MechanicalSystem(np.diag(rng.uniform(0.5, 2, n)), 1e-3 * K, K)


def test_a_record_is_the_sum_of_its_ramps():
    """The response to a record is the sum of those to its changes of slope, each solved by itself; at the samples, too."""
    system, rng = graded_chain(1), np.random.default_rng(2)
    knots, values = np.sort(np.r_[0, rng.integers(1, 512, 7) / 128]), rng.integers(-8, 8, (5, 8)).astype(float)
    changes = np.diff(np.diff(values) / np.diff(knots), prepend=0.0, append=0.0)
    times = np.r_[knots, rng.uniform(0, 6, 40)]
    whole = system.solve(force=mb.sampled(knots, values))(times)
    parts = [(0.0, mb.step(values[:, 0])), (knots[-1], mb.step(-values[:, -1]))]
    parts += [(t, mb.term(change, power=1)) for t, change in zip(knots, changes.T)]
    each = [np.where(times >= t, system.solve(force=force)(np.maximum(times - t, 0.0)), 0.0) for t, force in parts]
    size = np.abs(each).max(axis=(0, 1))
    assert (np.abs(sum(each) - whole).max(axis=0) <= 1e-13 * size).all()
