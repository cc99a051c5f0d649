"""The reference is what exact arithmetic says, with more digits than float64; a cross-check says that it is one."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.accuracy import measure as module
from mbconstrained.analyses.accuracy.measure import ReferenceSolution, reference_solution
from mbconstrained.analyses.study_problem import StudyProblem, chosen_places, mechanical_problem


def oscillator(times) -> StudyProblem:
    return mechanical_problem("oscillator", mb.MechanicalSystem([[1.0]], stiffness=[[2.0]]), times, [1.0])


def test_the_truth_has_more_digits_than_a_double():
    """cos(sqrt(2) t) with 40 digits, by mpmath."""
    times = np.linspace(0.0, 30.0, 7)
    reference = reference_solution(oscillator(times))
    with mpmath.workdps(40):
        for value, rest, t in zip(reference.values[0], reference.rest[0], times):
            true = mpmath.cos(mpmath.sqrt(2) * mpmath.mpf(t))
            assert abs(mpmath.mpf(value) + mpmath.mpf(rest) - true) < mpmath.mpf(10) ** -24


def test_an_error_is_relative_to_the_largest_value_and_not_rounded_away():
    reference = ReferenceSolution(np.array([0, 2]), np.array([[1.0, -4.0]]), np.array([[1e-17, 0.0]]), 0.0, "by hand")
    assert reference.scale == 4.0
    assert reference.error(np.array([[1.0, 99.0, -4.0]])) == 1e-17 / 4  # the value in between is not compared
    assert reference.error(np.array([[1.0, 0.0, -3.0]])) == 0.25
    assert reference.error(np.array([[np.nan, 0.0, -4.0]])) == np.inf
    assert reference.error(np.array([[1.0, 0.0, np.inf]])) == np.inf


def test_of_an_answer_that_is_zero_the_error_itself_is_told():
    times = np.linspace(0.0, 1.0, 3)
    reference = reference_solution(mechanical_problem("rest", mb.MechanicalSystem([[1.0]]), times))
    assert reference.error(np.zeros((1, 3))) == 0.0
    assert reference.error(np.full((1, 3), 1e-5)) == 1e-5


@pytest.mark.parametrize("count", [1, 2, 100, 101, 102, 1001])
def test_chosen_places_have_both_ends_and_ascend(count):
    places = chosen_places(count, 101)
    assert places[0] == 0 and places[-1] == count - 1 and len(places) == min(count, 101)
    assert (np.diff(places) > 0).all()


def test_where_exact_arithmetic_takes_too_long_the_cross_check_says_how_far_it_goes(monkeypatch):
    times = np.linspace(0.0, 5.0, 21)
    monkeypatch.setattr(module, "MOST_STATES", 1)
    reference = reference_solution(oscillator(times))
    assert "2 states takes too long" in reference.source and "agrees to" in reference.source
    exact = np.cos(np.sqrt(2) * times)
    assert 0 < reference.error_bound < 1e-13
    assert reference.error(exact[None]) <= 1e-13
    assert reference.error(exact[None] + 1e-9) == pytest.approx(1e-9, rel=1e-3)
    # nothing is told to be better than the check can see
    assert reference.error(reference.values) == reference.error_bound


def test_a_rational_motion_is_exact():
    """x = t^2 / 2 under a unit force on a unit mass: every value is a fraction."""
    times = np.array([0.0, 0.5, 3.0])
    reference = reference_solution(mechanical_problem("pushed", mb.MechanicalSystem([[1.0]], force=[1.0]), times))
    assert [Fraction(v) for v in reference.values[0]] == [0, Fraction(1, 8), Fraction(9, 2)] and not reference.rest.any()
