"""Small next to large: answer and estimate against exponentials in ball arithmetic, not against the package's exact engine."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.gallery import GALLERY, system
from mbconstrained.analyses.stability import LARGEST_RATIO, point_of
from mbconstrained.analyses.study_problem import values_of
from tests.oracles.ball_exponential import after_pulse, motion

FAMILIES = [one.name for one in GALLERY if one.theme == "small next to large"]

CASES = [(name, value) for name in FAMILIES for value in system(name).values[1::2]]


def reference(problem, parameter, name) -> np.ndarray:
    """x at the last of the times, shape (r,), from the equations alone."""
    coefficients, time = problem.polynomial_matrix.coefficients.tolist(), problem.times[-1]
    if name == "late_short_pulse":
        after = Fraction(time) - 1000 - Fraction(parameter)
        return np.array(after_pulse(coefficients, [0.0, 1.0 / parameter], parameter, after))
    if name == "link_over_a_spring":  # 2 x'' + k x = 0, k the exact sum of the entries
        stiffness = sum(map(Fraction, problem.system.stiffness.ravel().tolist()))
        return np.array(2 * motion([[[stiffness]], [[0]], [[2]]], [[1.0], [0.0]], time))
    return np.array(motion(coefficients, problem.initial.tolist(), time, problem.force(1.0).tolist()))


@pytest.mark.parametrize(("name", "value"), CASES)
def test_the_answer_is_as_right_as_it_claims_or_carries_a_warning(name, value):
    problem = system(name).build(value)
    problem = problem.at(problem.times[-1:])
    truth = reference(problem, value, name)
    exact = values_of(problem.solve().exact.enclose(problem.times, 32))[:, 0]
    largest = max(map(abs, truth))
    assert max(map(abs, exact - truth)) <= largest / 10**30
    response = problem.solve()
    values, estimate = response(problem.times)[:, 0], response.error_estimate(problem.times)
    error = float(max(abs(Fraction(value) - true) for value, true in zip(values, truth)) / largest)
    assert error <= LARGEST_RATIO * max(estimate, 8 * np.finfo(float).eps) or point_of(problem, variations=0).warnings


@pytest.mark.long
def test_a_dense_damped_model_by_powers_is_as_right_as_its_estimate():
    """60 coordinates at 2000 even times; the estimate describes these values, and leaves them as they are."""
    random, n = np.random.default_rng(0), 60
    damping, stiffness = (factor @ factor.T / n for factor in random.standard_normal((2, n, n)))
    damping, stiffness = 0.05 * damping, stiffness + np.eye(n)
    start = np.array([random.standard_normal(n), np.zeros(n)])
    x, times = mb.MechanicalSystem(np.eye(n), damping, stiffness).solve(*start), np.linspace(0.0, 20.0, 2000)
    values = x(times)
    estimate = x.error_estimate(times)
    assert np.array_equal(values, x(times))
    truth = motion([stiffness.tolist(), damping.tolist(), np.eye(n).tolist()], start.tolist(), times[-1])
    error = max(abs(Fraction(value) - true) for value, true in zip(values[:, -1], truth))
    assert float(error) <= LARGEST_RATIO * max(estimate, 8 * np.finfo(float).eps) * np.abs(values).max()
