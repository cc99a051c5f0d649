"""What must hold of every solution whatever its formula: residual, linearity, restart, constant combinations of rows."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from tests.properties.problems import Problem, problems, scale_of

BAR = 1e-7
TIMES = np.array([0.0, 0.125, 0.5, 1.0, 3.0])


@given(problems())
def test_motion_satisfies_its_equation(problem: Problem):
    """A_0 x + A_1 x' + ... + A_q x^(q) = f for t > 0, resonance included."""
    terms = [A @ problem.answer.derivative(k)(TIMES) for k, A in enumerate(problem.sample.coefficients)]
    force = problem.force(TIMES)
    assert np.abs(sum(terms) - force).max() <= BAR * scale_of(force, *terms)


@given(problems(), problems(), st.integers(-3, 3))
def test_motion_is_linear_in_values_and_force(problem: Problem, other: Problem, factor: int):
    A, r, q = problem.sample.matrix, problem.sample.size, problem.sample.degree
    shaped = np.resize(other.initial if other.initial.size else np.ones(1), (q, r))
    force = mb.harmonic(np.arange(1.0, r + 1), angular_frequency=2.0)
    x, y = problem.answer, mb.solve(A, shaped, force)
    both = mb.solve(A, factor * problem.initial + shaped, factor * problem.force + force)
    assert np.abs(both(TIMES) - factor * x(TIMES) - y(TIMES)).max() <= BAR * scale_of(x(TIMES), y(TIMES))
    assert np.abs(both.jump - factor * x.jump - y.jump).max(initial=0.0) <= BAR * scale_of(x.jump, y.jump)
    count = max(len(x.impulses), len(y.impulses), len(both.impulses))
    combined = factor * _padded(x, count) + _padded(y, count)
    assert np.abs(_padded(both, count) - combined).max(initial=0.0) <= BAR * scale_of(combined)


@given(problems(forced=False), st.sampled_from([0.25, 1.0]))
def test_motion_can_be_started_again_from_any_moment(problem: Problem, moment: float):
    """The stack of x at t1, taken as values at 0-, gives x(t1 + t) with no jump and no impulse worth the name."""
    x = problem.answer
    orders = range(problem.sample.degree)
    stack = np.array([x.derivative(k)(moment) for k in orders]).reshape(problem.initial.shape)
    again = mb.solve(problem.sample.matrix, stack)
    assert np.abs(again(TIMES) - x(TIMES + moment)).max() <= BAR * scale_of(stack, x(TIMES + moment))
    assert np.abs(again.jump).max(initial=0.0) <= BAR * scale_of(stack)
    assert np.abs(_padded(again, len(again.impulses))).max(initial=0.0) <= BAR * scale_of(stack)


@given(problems(with_impulses=False))
def test_values_after_zero_are_admissible(problem: Problem):
    """Started from its own values at 0+ the motion is the same, and nothing jumps."""
    x = problem.answer
    again = mb.solve(problem.sample.matrix, x.start, problem.force)
    assert np.abs(again(TIMES) - x(TIMES)).max() <= BAR * scale_of(x(TIMES), x.start)
    assert np.abs(again.jump).max(initial=0.0) <= BAR * scale_of(x.start)


@given(problems(), st.data())
def test_constant_combinations_of_the_equations_change_nothing(problem: Problem, data):
    """A -> W A, f -> W f with a constant invertible W."""
    r = problem.sample.size
    below = data.draw(st.lists(st.integers(-1, 1), min_size=r * r, max_size=r * r))
    W = np.tril(np.reshape(below, (r, r)), -1) + np.eye(r)
    W = W @ (np.triu(np.reshape(below[::-1], (r, r)), 1) + np.eye(r))
    x, y = problem.answer, mb.solve(mb.PolynomialMatrix(W @ problem.sample.coefficients), problem.initial, problem.force.mapped(W))
    assert np.abs(y(TIMES) - x(TIMES)).max() <= BAR * scale_of(x(TIMES))
    assert np.abs(y.start - x.start).max(initial=0.0) <= BAR * scale_of(x.start)
    count = max(len(x.impulses), len(y.impulses))
    assert np.abs(_padded(y, count) - _padded(x, count)).max(initial=0.0) <= BAR * scale_of(_padded(x, count))


@given(problems(with_impulses=False), st.integers(1, 2))
def test_delaying_nothing_by_a_higher_declared_degree(problem: Problem, more: int):
    """Zero coefficients on top, with any further values at 0-, change neither the motion nor its impulses."""
    sample, r = problem.sample, problem.sample.size
    raised = mb.PolynomialMatrix(np.concatenate([sample.coefficients, np.zeros((more, r, r))]))
    x = problem.answer
    y = mb.solve(raised, np.concatenate([problem.initial, np.ones((more, r))]), problem.force)
    assert np.abs(y(TIMES) - x(TIMES)).max() <= BAR * scale_of(x(TIMES))
    count = max(len(x.impulses), len(y.impulses))
    assert np.abs(_padded(y, count) - _padded(x, count)).max(initial=0.0) <= BAR * scale_of(_padded(x, count))


def _padded(x: mb.Response, count: int) -> np.ndarray:
    """The impulses as rows, zeros added up to the count."""
    rows = np.zeros((count, x.polynomial_matrix.size))
    for order, row in enumerate(x.impulses):
        rows[order] = row
    return rows
