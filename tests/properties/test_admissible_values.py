"""Three sets of values at 0-: continuous inside impulse-free inside all, and the nearest of each (Moysis et al., Eqs. 58, 60)."""

from __future__ import annotations

import numpy as np
from hypothesis import given

import mbconstrained as mb
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
