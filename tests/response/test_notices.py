"""What an answer says about itself without being asked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.response.response_notices import unsatisfied


def kinds(x: mb.Response) -> list[str]:
    return [notice.kind for notice in x.notices]


def test_a_decent_oscillator_has_nothing_to_say():
    assert mb.solve(mb.PolynomialMatrix([[[1.0]], [[0.1]], [[1.0]]]), [[1.0], [0.0]]).notices == ()


def test_an_undamped_oscillator_is_not_called_unstable():
    K = np.array([[2.0, -1.0], [-1.0, 2.0]]) * 1e7 / 3
    assert mb.solve(mb.PolynomialMatrix([K, np.zeros((2, 2)), np.eye(2)]), np.eye(2)).notices == ()


@pytest.mark.parametrize("fast", [1.0, 1e3, 1e6, 1e9])
def test_slow_growth_is_told_beside_any_fast_decay(fast):
    x = mb.solve(mb.PolynomialMatrix([np.diag([-1e-3, fast]), np.eye(2)]), [[1.0, 1.0]])
    (notice,) = x.notices
    assert notice.kind == "unstable"
    assert not notice.doubtful
    assert "1 zero(s) in the right half plane" in notice.text and "e^(0.001 t)" in notice.text


def test_jumps_and_impulses_are_told_by_name_with_their_sizes():
    """x1 = x2', x2 = 0: x2 drops from 3 to 0, x1 gets the impulse."""
    A = mb.PolynomialMatrix([np.eye(2), [[0.0, -1.0], [0.0, 0.0]]], coordinates=["speed", "place"])
    x = mb.solve(A, [[0.0, 3.0]])
    assert [notice.text for notice in x.notices] == [
        "place: its value jumps at t = 0 from 3 to 0",
        "speed: a Dirac impulse at t = 0 of size -3",
    ]
    assert not any(notice.doubtful for notice in x.notices)


def test_high_derivatives_are_named_by_their_order():
    A = mb.PolynomialMatrix([[[1.0]]] + [[[0.0]]] * 5)
    texts = [notice.text for notice in mb.solve(A, np.ones((5, 1))).notices]
    assert [text.split(" jumps")[0] for text in texts] == [
        "x1: its value",
        "x1: its velocity",
        "x1: its acceleration",
        "x1: its jerk",
        "x1: its derivative 4",
    ]


def test_small_jumps_are_told_beside_large_ones():
    """Two independent coordinates of very different size: the small one jumps as surely as the large one."""
    x = mb.solve(mb.PolynomialMatrix([np.eye(2), np.zeros((2, 2))]), [[1e6, 1e-12]])
    assert x.jump.tolist() == [[-1e6, -1e-12]]
    assert x.start.tolist() == [[0.0, 0.0]]
    assert kinds(x) == ["jump", "jump"]


@pytest.mark.parametrize("gap, doubtful", [(0.0, False), (2.3e-16, False), (3e-14, True), (1e-6, False)])
def test_a_rank_decision_near_the_rounding_is_doubtful(gap, doubtful):
    """Leading coefficient [[1, 1/3], [3, 1 + gap]]: its rank is one or two, and near the rounding of 1/3 that is a guess."""
    A = mb.PolynomialMatrix([np.eye(2), [[1.0, 1 / 3], [3.0, 1.0 + gap]]])
    x = mb.solve(A, [[1.0, 0.0]])
    assert ("rank" in kinds(x)) == doubtful
    assert any(notice.doubtful for notice in x.notices) == doubtful
    if doubtful:
        assert "no clear gap" in next(notice.text for notice in x.notices if notice.kind == "rank")


def test_a_very_light_mass_is_a_mass():
    """diag(1, 1e-14) s^2 is of rank two without a doubt, diag(1, 0) of rank one."""
    K, D = np.array([[2.0, -1.0], [-1.0, 1.0]]), np.diag([0.1, 0.1])
    light = mb.solve(mb.PolynomialMatrix([K, D, np.diag([1.0, 1e-14])]), np.zeros((2, 2)), mb.step([1.0, 0.0]))
    none = mb.solve(mb.PolynomialMatrix([K, D, np.diag([1.0, 0.0])]), np.zeros((2, 2)), mb.step([1.0, 0.0]))
    assert light.pairs.structure.finite_count == 4
    assert none.pairs.structure.finite_count == 3
    assert not [notice for notice in (*light.notices, *none.notices) if notice.doubtful]
    times = np.linspace(0.5, 10, 20)
    assert np.abs(light(times) - none(times)).max() < 1e-9


@pytest.mark.parametrize(
    ("problem", "text"),
    [
        (lambda x: replace(x.problem, force=x.force + 1e-15 * mb.step([0.0, 1.0])), 'equation "equation 2" is not satisfied'),
        (lambda x: replace(x.problem, initial=x.initial + [[0.0, 1e-20], [0.0, 0.0]]), "x2: derivative 0 is off by"),
    ],
)
@pytest.mark.parametrize("slow", [-1.0, 9.0])
def test_a_solution_that_lost_something_small_is_reported(problem, text, slow):
    """The solution of another problem, whose force or start differs by far less than rounding errors of the largest."""
    x = mb.solve(mb.PolynomialMatrix([np.diag([4.0, slow]), np.diag([0.1, 0.2]), np.eye(2)]), [[1.0, 0], [0, 0]], mb.step([1.0, 0]))
    assert not any(notice.doubtful for notice in x.notices)
    wrong = [notice.text for notice in unsatisfied(mb.Response(problem(x), x.solution))]
    assert any(text in sentence for sentence in wrong)
