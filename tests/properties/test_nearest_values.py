"""The nearest admissible values against least squares on condition matrices in rational arithmetic."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import given

import mbconstrained as mb
from tests.oracles.exact import ExactResponse
from tests.properties.problems import Problem, problems, scale_of

BAR = 1e-7


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
