"""What an answer says about itself without being asked."""

from dataclasses import replace

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.ground.tolerances import TRUST_LIMIT
from mbconstrained.response.response_notices import unsatisfied


def kinds(x: mb.Response) -> list[str]:
    return [notice.kind for notice in x.notices]


def test_a_decent_oscillator_has_nothing_to_say():
    assert mb.solve(mb.PolynomialMatrix([[[1.0]], [[0.1]], [[1.0]]]), [[1.0], [0.0]]).notices == ()


@pytest.mark.parametrize("fast", [1.0, 1e3, 1e6, 1e9])
def test_slow_growth_is_told_beside_any_fast_decay(fast):
    x = mb.solve(mb.PolynomialMatrix([np.diag([-1e-3, fast]), np.eye(2)]), [[1.0, 1.0]])
    (notice,) = x.notices
    assert notice.kind == "unstable"
    assert not notice.doubtful
    assert "1 eigenvalue in the right half plane" in notice.text and "e^(0.001 t)" in notice.text


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


def nearly_singular(gap: float, parts: int = 1) -> tuple[mb.PolynomialMatrix, np.ndarray]:
    """Leading coefficient [[1, 1/3], [3, 1 + gap]], many times over: its rank is one or two; and a start."""
    blocks = [np.kron(np.eye(parts), part) for part in (np.eye(2), [[1.0, 1 / 3], [3.0, 1.0 + gap]])]
    return mb.PolynomialMatrix(blocks), np.tile([1.0, 0.0], parts)[None]


@pytest.mark.parametrize("gap, doubtful", [(0.0, False), (2.3e-16, False), (3e-14, True), (1e-6, False)])
def test_a_rank_decision_near_the_rounding_is_doubtful(gap, doubtful):
    """Of a model whose values are not proved: near the rounding of 1/3 the rank is a guess."""
    x = mb.solve(*nearly_singular(gap, parts=26))
    assert ("rank" in kinds(x)) == doubtful
    assert any(notice.doubtful for notice in x.notices) == doubtful
    if doubtful:
        assert "no clear gap" in next(notice.text for notice in x.notices if notice.kind == "rank")


@pytest.mark.parametrize("gap, start, doubtful", [(2e-15, 3.0, False), (2e-15, 0.0, True), (-2e-15, 3.0, True)])
def test_a_rank_decision_is_a_doubt_where_the_other_one_changes_the_answer(gap, start, doubtful):
    """A leading coefficient that counts as singular: kept, it adds a zero at -2 / gap, which decays at once or grows beyond bounds.

    From x2 = 3 x1, where both decisions begin, x1 = e^(-t / 2) in the limit of no gap; other starts jump or do not.
    """
    A, _ = nearly_singular(gap, parts=26)
    x = mb.solve(A, np.tile([1.0, start], 26)[None])
    (notice,) = (notice for notice in x.notices if notice.kind == "rank")
    assert notice.doubtful == doubtful == ("the other decision changes no coordinate" not in notice.text)
    assert (x.error_estimate([0.0, 1.0]) > TRUST_LIMIT) == doubtful
    if not doubtful:
        assert np.allclose(x(1.0), np.tile([1.0, 3.0], 26) * np.exp(-0.5), rtol=1e-14)


@pytest.mark.parametrize("gap", [3e-14, -3e-14])
def test_a_rank_that_the_exact_data_have_is_no_doubt_of_a_small_model(gap):
    """It is solved as the data are, a fast zero near -2 / gap included."""
    x = mb.solve(*nearly_singular(gap))
    assert not x.solution.has_clear_ranks and not any(notice.doubtful for notice in x.notices)
    assert not x.jump.any() and x.error_estimate(1e-14) <= 1e-12


def test_a_rank_that_the_exact_data_have_not_names_the_entry_that_decides():
    """det [[1, 1/3], [3, 1 + gap]] vanishes where an entry is less by gap: 3e-15, to the rounding of 1/3 and of 1 + gap."""
    x = mb.solve(*nearly_singular(3e-15))
    (notice,) = (notice for notice in x.notices if notice.doubtful)
    assert 'the entry of A_1 in the equation "equation 1" for x1' in notice.text and "less by 3" in notice.text


def test_jumps_of_a_small_model_are_those_of_the_data_where_float64_leaves_a_doubt():
    """x1 + x2 = 0 and x1 + (1 + g) x2 + g x3 = 0 leave x = (-x2, x2, -x2); M = diag(1, 2, 3) keeps (-1, 1, -1) M x'."""
    g = 2.0**-44
    rows = [mb.Constraint([1.0, 1.0, 0.0]), mb.Constraint([1.0, 1.0 + g, g])]
    motion = mb.MechanicalSystem(np.diag([1.0, 2.0, 3.0]), stiffness=np.eye(3), constraints=rows).solve([0, 0, 0], [1.0, 0.0, 0.0])
    after = motion.initial[1] + motion.jump[1]
    assert np.allclose(after, np.array([1.0, -1.0, 1.0]) / 6, rtol=1e-15, atol=0)
    assert not any(notice.doubtful for notice in motion.notices)
    # the momentum lost is A^T p: p1 + p2 = -5/6, p1 + (1 + g) p2 = -1/3, g p2 = 1/2
    (impulse,) = motion.constraint_impulses
    assert np.allclose(impulse, [-5 / 6 - 0.5 / g, 0.5 / g], rtol=1e-15, atol=0)


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
