"""Where the gallery and the referee cases overlap: the same problem, the same truth to 30 digits, the same judgement."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.gallery import system
from mbconstrained.analyses.stability import MOST_EXPECTED, point_of
from mbconstrained.analyses.study_problem import values_of
from tests.oracles.referee import EPS, answer, case

#: Name of the case: system and parameter.
OVERLAPS = {
    "stiff_ratio_1e14": ("stiff_chain_assembled", 1e14),
    "penalty_massless": ("penalty_link", 1e14),
    "near_massless_1e14": ("nearly_massless_joint", 1e-14),
    "crit_exact": ("damping_ratio", 1.0),
    "crit_near_1e9": ("near_critical", 1e-9),
    "mems_gyro": ("gyroscope", 50.0),
    "two_mass_pos_incons": ("inconsistent_start", 1.0),
    "long_1e6": ("long_horizon", 5e6),
    "rigid7": ("free_chain", 100.0),
    "unstable300": ("unstable_growth", 100.0),
    "huge_units": ("unit_of_force", 1e9),
    "mems_jordan4_qep": ("small_to_huge", 2.0**-20),
    "giga_jordan4_qep": ("small_to_huge", 2.0**12),
    "inf_order2": ("unit_of_time", 1.0),
    "nilpotent5": ("differentiated_force", 2.0),
    "jordan3_scalar": ("chain_length", 3.0),
    "resonance_double": ("resonance", 0.0),
}

everywhere = pytest.mark.parametrize("name", OVERLAPS)


def problem_of(name):
    one, parameter = OVERLAPS[name]
    return system(one).build(parameter)


@cache
def judged(name):
    one, parameter = OVERLAPS[name]
    return point_of(system(one).build(parameter))


@everywhere
def test_exact_arithmetic_has_the_thirty_digits_of_the_case(name):
    known = case(name)
    problem = problem_of(name)
    entries = mb.PolynomialMatrix(problem.polynomial_matrix.coefficients)  # of the case; elements are known better than these
    truth = values_of(replace(problem, polynomial_matrix=entries, system=None).solve().exact.enclose(known.times, 32))
    written = np.array([[Fraction(value) for value in row] for row in known.record["x_reg"]], dtype=object).T
    largest = max(abs(value) for value in written.flat)
    assert max(abs(one - other) for one, other in zip(truth.flat, written.flat)) <= largest * Fraction(1, 10**29)


@everywhere
def test_the_verdict_agrees_with_the_bars_of_the_case(name):
    """Right where the fair bar is met, also where rounded entries do not determine the answer: small models take them as exact."""
    known = case(name)
    point = judged(name)
    error = known.error(answer(name))
    assert error <= known.fair_bar
    assert point.verdict == "right"
    assert max(point.error, 16 * EPS) == pytest.approx(max(error, 16 * EPS), rel=0.5)


@everywhere
def test_the_condition_agrees_with_that_of_the_case(name):
    """Both are the largest of a few random moves: within two digits; elements that are data here are parameters there."""
    known, (one, parameter) = case(name), OVERLAPS[name]
    point, parts = judged(name), known.record["kappa_parts"]
    by_elements = system(one).build(parameter).system is not None and one not in ("stiff_chain_assembled", "penalty_link")
    kappa = max(1.0, (parts["data"] or 0) + (parts["param"] or 0)) if by_elements else known.record["kappa"]
    expected = min(-np.log10(kappa * EPS), MOST_EXPECTED)
    assert abs(point.expected - max(expected, 0.0)) <= 2
