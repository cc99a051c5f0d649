"""The condition against formulas, against finite differences in multiprecision, and what counts as data."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses import stability as module
from mbconstrained.analyses.gallery import bodies, equations, moving, system
from mbconstrained.analyses.stability import condition_of
from mbconstrained.analyses.study_problem import StudyProblem, mechanical_problem


def condition(problem, **choices):
    return condition_of(problem, problem.solve().exact, **choices)


@pytest.fixture
def all_up(monkeypatch):
    """Every datum is moved by exactly + h: the condition is the sum of the sensitivities, with their signs."""
    monkeypatch.setattr(module, "MOVES", (1.0,))


# --- formulas


@pytest.mark.parametrize(("rate", "time"), [(1e-3, 2.0), (1.0, 2.0), (50.0, 2.0), (-3.0, 100.0)])
def test_scalar_decay_and_growth(rate, time):
    """x = e^(-(k/c) t) x0: of k, c and x0 at most 1 + 2 |k| t / c; a few draws of half moves find at least a quarter of it."""
    problem = equations([[[rate]], [[1.0]]], [[3.0]], [time])
    largest = 1 + 2 * abs(rate) * time
    assert largest / 6 <= condition(problem) <= largest * (1 + 1e-9)


@pytest.mark.parametrize("turns", [1.0, 1e3, 1e6])
def test_phase_of_an_oscillator(turns):
    """x = cos w t: each of stiffness and mass moves the phase by w t / 2."""
    times = 2 * np.pi * turns + np.linspace(0.0, 7.0, 8)
    problem = equations([[[1.0]], [[0.0]], [[1.0]]], [[1.0], [0.0]], times)
    largest = times.max() + 2
    assert largest / 8 <= condition(problem) <= largest


def test_all_data_moved_alike_leave_only_start_and_force(all_up):
    """A(s) times 1 + h does nothing to a free motion; the start moves x by h: the condition is one."""
    free = equations([[[4.0, -1.0], [-1.0, 3.0]], np.eye(2), np.eye(2)], [[1.0, 2.0], [0.0, -1.0]], [0.5, 2.0])
    assert condition(free) == pytest.approx(1.0, rel=1e-12)


def test_a_force_is_moved_in_size_and_frequency(all_up):
    """x' = cos w t from rest, x = sin w t / w: the equation as a whole divides by 1 + h, the size and the frequency multiply."""
    w, time = 7.0, 11.0
    problem = equations([[[0.0]], [[1.0]]], [[0.0]], [time], mb.harmonic([1.0], angular_frequency=w))
    expected = abs(-1 + w * time * math.cos(w * time) / math.sin(w * time))
    assert condition(problem) == pytest.approx(expected, rel=1e-9)


# --- finite differences in multiprecision


def exponential(matrices, start, times):
    """x at the times by mpmath's exponential of the companion matrix, r rows."""
    r = len(start) // 2
    K, C, M = (mpmath.matrix(matrix) for matrix in matrices)
    companion = mpmath.zeros(2 * r)
    companion[:r, r:] = mpmath.eye(r)
    companion[r:, :r], companion[r:, r:] = -(M**-1) * K, -(M**-1) * C
    return [mpmath.expm(companion * time) * mpmath.matrix(start) for time in times]


def test_finite_differences_of_every_datum():
    """Two damped bodies: the sum over all data of |change| bounds the condition, and a few draws find a good part of it."""
    K, C, M = [[5.0, -2.0], [-2.0, 3.0]], [[0.3, 0.0], [0.0, 0.0]], [[1.0, 0.0], [0.0, 2.0]]
    start, times, r = [1.0, -1.0, 0.5, 0.0], [0.7, 3.0, 9.0], 2
    problem = equations([K, C, M], [start[:2], start[2:]], times)
    with mpmath.workdps(60):
        h, total = mpmath.mpf(10) ** -25, [[mpmath.mpf(0)] * r for _ in times]
        truth = exponential([K, C, M], start, times)
        largest = max(abs(column[i]) for column in truth for i in range(r))
        data = [(0, ((0, 0),)), (0, ((0, 1), (1, 0))), (0, ((1, 1),)), (1, ((0, 0),)), (2, ((0, 0),)), (2, ((1, 1),))]
        for which, places in data:
            moved = [[[mpmath.mpf(entry) for entry in row] for row in matrix] for matrix in (K, C, M)]
            for i, j in places:
                moved[which][i][j] *= 1 + h
            _add(total, exponential(moved, start, times), truth, h)
        for place, value in enumerate(start):
            _add(total, exponential([K, C, M], [*start[:place], value * (1 + h), *start[place + 1 :]], times), truth, h)
        bound = float(max(max(row) for row in total) / largest)
    assert bound / 5 <= condition(problem) <= bound * (1 + 1e-9)


def _add(total, moved, truth, h):
    for row, one, other in zip(total, moved, truth):
        for i in range(len(row)):
            row[i] += abs(one[i] - other[i]) / h


# --- what counts as data


def test_elements_are_data_where_there_are_elements():
    """Assembled, a soft spring on a stiff one is known to eps times their ratio; as elements to eps."""
    by_elements = bodies([1.0, 1.0], [(0, 1, 1.0), (1, 2, 1e10)], [(1, 2, 1e5)])
    plain = mb.MechanicalSystem(by_elements.mass, by_elements.damping, by_elements.stiffness)
    found = [condition(moving(one, [1.0, 5.0], ([1.0, 1.0], [0.0, 0.0]))) for one in (by_elements, plain)]
    assert found[0] < 100 and found[1] > 1e8


def test_zeros_stay_and_constraint_rows_move_with_their_forces():
    problem = system("two_masses").build(2.0)
    exact = problem.solve().exact
    moved = module._moved(problem, exact, np.random.default_rng(0))
    before, after = ([matrix.tolist() for matrix in one.matrix.coefficients] for one in (exact, moved))
    assert [row[3] for row in after[0]][:3] == [-entry for entry in after[2][3]][:3] and after[2][3] != before[2][3]
    for one, other in zip(before, after):
        assert all((a == 0) == (b == 0) for row, moved_row in zip(one, other) for a, b in zip(row, moved_row))
    assert before != after and moved.rows == exact.rows


@pytest.mark.parametrize("name", ["parallel_rows_position", "parallel_rows_acceleration"])
def test_rows_that_turn_parallel_lose_digits_by_the_rounding_of_their_entries(name):
    """What is rounded in the entries turns the line on which both rows leave the bodies by eps / angle."""
    found = [condition(system(name).build(angle)) for angle in (1e-3, 1e-6, 1e-9)]
    assert found[0] > 100
    assert [found[1] / found[0], found[2] / found[1]] == pytest.approx([1e3, 1e3], rel=0.1)


def test_constraint_values_stay():
    held = mb.MechanicalSystem(np.eye(2), stiffness=np.eye(2), constraints=[mb.Constraint([1.0, -1.0], value=0.25)])
    problem = mechanical_problem("held", held, [1.0], [1.0, 0.75], force=mb.step([3.0, 0.0]))
    exact = problem.solve().exact
    moved = module._moved(problem, exact, np.random.default_rng(0))
    pairs = [(one.vector, other.vector) for one, other in zip(exact.sources, moved.sources)]
    assert any(one[0] != other[0] for one, other in pairs)
    assert all(one[2] == other[2] for one, other in pairs) and any(one[2] for one, _ in pairs)


@pytest.mark.parametrize("name", ["infinite_order", "differentiated_force", "unit_of_time"])
def test_the_number_of_finite_zeros_is_kept(name):
    """Moved at random, the entries of a nilpotent block would make new zeros of the size of 1 / h."""
    one = system(name)
    for parameter in one.values[:2]:
        problem = one.build(parameter)
        exact = problem.solve().exact
        for seed in range(3):
            moved = module._moved(problem, exact, np.random.default_rng(seed))
            assert moved.matrix.determinant.degree() == exact.matrix.determinant.degree()
        assert condition(problem) < 1e6


# --- degenerate


def test_no_answer_to_lose_digits_of():
    zero = equations([[[1.0]], [[1.0]]], [[0.0]], [1.0, 2.0])
    assert condition(zero) == 0.0
    assert condition(zero.at([])) == 0.0
    assert condition(equations([[[1.0]], [[1.0]]], [[1.0]], [1.0]), draws=0) == 0.0


def test_an_answer_that_vanishes_only_here_has_no_relative_condition():
    """x1 - x2 of two equal bodies is zero, but not when they are moved."""
    A = [[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, -1.0, 1.0]], np.diag([1.0, 1.0, 0.0])]
    problem = equations(A, [[1.0, 1.0, 0.0]], [1.0])
    exact = problem.solve().exact
    assert condition_of(problem, exact.with_rows(range(2, 3))) == math.inf


def test_a_matrix_without_derivatives():
    """2 x = f: the change of the quotient, at most 2 h, whatever the size."""
    constant = StudyProblem("constant", mb.PolynomialMatrix([[[2.0]]]), np.zeros((0, 1)), mb.step([1e30]), np.array([1.0]))
    assert 0.0 < condition(constant) <= 2.0 + 1e-9


def test_it_is_reproducible_and_knows_no_units():
    problems = [system("small_to_huge").build(parameter) for parameter in (1.0, 2.0**12, 2.0**-20)]
    found = [condition(problem) for problem in problems]
    assert found[0] == condition(problems[0])
    assert found == pytest.approx([found[0]] * 3, rel=1e-12)
