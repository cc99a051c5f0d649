"""Three sets of values at 0-: continuous inside impulse-free inside all, and the nearest of each (Moysis et al., Eqs. 58, 60)."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import given

import mbconstrained as mb
from tests.oracles.exact import ExactResponse
from tests.properties.problems import Problem, problems, scale_of

BAR = 1e-7


def distance(problem: Problem, values) -> float:
    """From the values given, each coordinate and derivative in the solver's own units."""
    scaling = problem.answer.pairs.form.companion.scaling
    units = scaling.columns * (scaling.time ** np.arange(problem.sample.degree, dtype=float))[:, None]
    return float(np.linalg.norm((values - problem.initial) / units))


def largest_impulse(x: mb.Response) -> float:
    return max((float(np.abs(row).max()) for row in x.impulses), default=0.0)


@given(problems(with_impulses=False))
def test_dimensions_of_the_three_sets(problem: Problem):
    """n, r q less the sum of the infinite zero orders, r q."""
    found = mb.admissible(problem.sample.matrix, problem.initial, problem.force)
    everything = problem.sample.size * problem.sample.degree
    zeros = sum(max(0, -order) for order in problem.sample.orders_at_infinity)
    assert found.dimensions == (problem.sample.finite_count, everything - zeros, everything)


@given(problems(with_impulses=False))
def test_the_verdict_is_that_of_the_exact_transform(problem: Problem):
    found = mb.admissible(problem.sample.matrix, problem.initial, problem.force)
    assert found.is_impulse_free == (len(problem.known_impulses) == 0)
    assert found.is_continuous == np.array_equal(problem.start, problem.initial)
    known = np.zeros((problem.sample.highest_impulse, problem.sample.size))
    known[: len(problem.known_impulses)] = problem.known_impulses
    assert np.abs(np.reshape(found.residuals, known.shape) - known).max(initial=0.0) <= BAR * scale_of(known)


@given(problems(with_impulses=False))
def test_nearest_values_are_admissible(problem: Problem):
    A, force = problem.sample.matrix, problem.force
    found = mb.admissible(A, problem.initial, force)
    quiet, smooth = mb.solve(A, found.nearest, force), mb.solve(A, found.nearest_continuous, force)
    size = scale_of(problem.initial, problem.start, problem.known_impulses)
    assert largest_impulse(quiet) <= BAR * size
    assert largest_impulse(smooth) <= BAR * size
    assert np.abs(smooth.jump).max(initial=0.0) <= BAR * size


@given(problems(with_impulses=False))
def test_nothing_admissible_is_nearer(problem: Problem):
    """The impulse-free values are a larger set than the continuous ones, and the values at 0+ are among those."""
    found = mb.admissible(problem.sample.matrix, problem.initial, problem.force)
    quiet, smooth = distance(problem, found.nearest), distance(problem, found.nearest_continuous)
    slack = 1 + BAR
    assert quiet <= slack * smooth + BAR
    assert smooth <= slack * distance(problem, problem.answer.start) + BAR
    if found.is_continuous:
        assert smooth <= BAR


@given(problems(with_impulses=False))
def test_the_nearest_of_the_nearest_is_itself(problem: Problem):
    found = mb.admissible(problem.sample.matrix, problem.initial, problem.force)
    again = mb.admissible(problem.sample.matrix, found.nearest_continuous, problem.force)
    change = again.nearest_continuous - found.nearest_continuous
    assert np.abs(change).max(initial=0.0) <= BAR * scale_of(found.nearest_continuous)


# The nearest values against least squares on condition matrices in rational arithmetic.


def exact_maps(problem: Problem, initial, terms) -> tuple[np.ndarray, np.ndarray]:
    """(jump, impulses) as vectors for values (q, r) of Fractions."""
    q, r, highest = problem.sample.degree, problem.sample.size, problem.sample.highest_impulse
    found = ExactResponse(problem.sample.exact, initial, terms, count=max(q, 1))
    jump = [found.derivatives[i][j] - initial[i][j] for i in range(q) for j in range(r)]
    impulses = [value for row in found.impulses for value in row]
    return np.array(jump, float), np.array(impulses + [0] * (highest * r - len(impulses)), float)


def conditions(problem: Problem):
    """Matrices and right-hand sides of both sets of conditions, matrix @ values = right."""
    q, r = problem.sample.degree, problem.sample.size
    nothing = [[Fraction(0)] * r for _ in range(q)]
    offsets = exact_maps(problem, nothing, [term.rational for term in problem.terms])
    columns = []
    for i in range(q):
        for j in range(r):
            unit = [row[:] for row in nothing]
            unit[i][j] = Fraction(1)
            columns.append(exact_maps(problem, unit, []))
    return [(np.array([column[kind] for column in columns]).T, -offsets[kind]) for kind in (0, 1)]


@given(problems(largest_size=3, with_impulses=False))
def test_nearest_values_are_those_of_least_squares_on_exact_conditions(problem: Problem):
    q, r = problem.sample.degree, problem.sample.size
    if not q:
        return
    found = mb.admissible(problem.sample.matrix, problem.initial, problem.force)
    scaling = problem.answer.pairs.form.companion.scaling
    units = (scaling.columns * scaling.time ** np.arange(q, dtype=float)[:, None]).ravel()
    (jump, jump_right), (impulse, impulse_right) = conditions(problem)
    for matrix, right, values in (
        (jump, jump_right, found.nearest_continuous),
        (np.vstack([impulse, np.zeros((1, q * r))]), np.append(impulse_right, 0.0), found.nearest),
    ):
        residual = right - matrix @ problem.initial.ravel()
        change = units * np.linalg.lstsq(matrix * units, residual, rcond=1e-9)[0]
        size = scale_of(problem.initial, change)
        assert np.abs(values.ravel() - problem.initial.ravel() - change).max() <= BAR * size
        assert np.abs(matrix @ values.ravel() - right).max() <= BAR * size * scale_of(matrix)


@given(problems(with_impulses=False))
def test_values_violate_a_condition_just_where_the_motion_is_not_continuous(problem: Problem):
    found = mb.admissible(problem.sample.matrix, problem.initial, problem.force)
    assert bool(found.violations) == (not found.is_continuous)
    assert any(violation.impulsive for violation in found.violations) or found.is_impulse_free
    assert all(violation.amount for violation in found.violations)
