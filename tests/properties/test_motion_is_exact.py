"""Values at 0+, impulses and motion of random problems against Laurent and Taylor series in rational arithmetic."""

from __future__ import annotations

import numpy as np
from hypothesis import given

from tests.properties.problems import Problem, problems, scale_of

BAR = 1e-8
TIMES = np.array([0.0, 0.0625, 0.25, 0.5])


@given(problems())
def test_values_after_zero_are_the_laurent_coefficients_of_the_transform(problem: Problem):
    """x^(k)(0+) is the coefficient of s^(-1-k) in X(s) = A(s)^-1 (X_in(s) + F(s))."""
    x = problem.answer
    assert x.start.shape == problem.start.shape
    assert np.abs(x.start - problem.start).max(initial=0.0) <= BAR * scale_of(problem.start, problem.initial)
    assert np.array_equal(x.initial, problem.initial)


@given(problems())
def test_impulses_are_the_polynomial_part_of_the_transform(problem: Problem):
    """The coefficient of s^k in X(s) multiplies delta^(k); there is none beyond the last that is not zero."""
    known, found = problem.known_impulses, np.array(problem.answer.impulses).reshape(-1, problem.sample.size)
    assert found.shape == known.shape
    assert np.abs(found - known).max(initial=0.0) <= BAR * scale_of(known)


@given(problems())
def test_a_coordinate_that_keeps_its_value_is_not_said_to_jump(problem: Problem):
    """Entries of the jump are exactly zero where x^(k)(0+) = x^(k)(0-), and only there."""
    assert np.array_equal(problem.answer.jump != 0, problem.start != problem.initial)


@given(problems())
def test_motion_is_its_taylor_series(problem: Problem):
    known = np.array([problem.exact(t) for t in TIMES]).T
    assert np.abs(problem.answer(TIMES) - known).max() <= BAR * scale_of(known)


@given(problems())
def test_error_estimate_is_not_blind(problem: Problem):
    """The true error is below ten times the estimate, both at least a few units in the last place."""
    known = np.array([problem.exact(t) for t in TIMES]).T
    largest = np.abs(known).max()
    if largest == 0:
        assert not problem.answer(TIMES).any()
        return
    true = np.abs(problem.answer(TIMES) - known).max() / largest
    assert true <= max(1e-14, 10 * problem.answer.error_estimate(TIMES))
