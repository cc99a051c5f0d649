"""Orders of elimination against the pattern of Cholesky's factor."""

from __future__ import annotations

import numpy as np
import pytest

from mbconstrained.linalg.elimination import WIDEST, are_worth, as_slice, coupled_pairs, elimination, front_width

from .few_couplings import band, beam, ladder, ring
from .test_quadratic_modes import chain_between_walls, random_tree, tree

MODELS = {
    "chain": (chain_between_walls(40), 1),
    "tree": (tree(random_tree(0, 40)[0], *random_tree(0, 40)[1]), 1),
    "ring": (ring(40), 2),
    "ladder": (ladder(40), 2),
    "beam": (beam(20), 3),
    "band": (band(40, 5), 5),
}


def shuffled(model, seed=0):
    order = np.random.default_rng(seed).permutation(len(model[0]))
    return [matrix[np.ix_(order, order)] for matrix in model]


@pytest.mark.parametrize(("model", "width"), MODELS.values(), ids=MODELS)
def test_chains_rings_ladders_and_beams_have_the_fronts_of_their_kind_in_any_numbering(model, width):
    assert front_width(*model) == width
    assert front_width(*shuffled(model)) == width


@pytest.mark.parametrize("together", [0, 4])
@pytest.mark.parametrize(("model", "width"), MODELS.values(), ids=MODELS)
def test_fronts_are_the_columns_of_the_factor(model, width, together):
    """No entry of Cholesky's factor of a matrix with this pattern is outside of the fronts; none of a round is in one of the same."""
    M, C, K = shuffled(model)
    order = elimination(len(K), coupled_pairs(M, C, K), 2 * WIDEST, together)
    pattern = (np.abs(M) + np.abs(C) + np.abs(K))[np.ix_(order.nodes, order.nodes)]
    factor = np.linalg.cholesky(pattern * np.random.default_rng(0).uniform(0.5, 1.0) + np.diag(pattern.sum(axis=0)))
    ends = np.cumsum(order.rounds)
    for own, front in enumerate(order.fronts):
        assert [*(np.flatnonzero(factor[own + 1 :, own]) + own + 1)] == list(front)
        assert not front or front[0] >= ends[np.searchsorted(ends, own, side="right")]


@pytest.mark.parametrize("together", [0, 4])
@pytest.mark.parametrize(("model", "width"), MODELS.values(), ids=MODELS)
def test_steps_are_the_order_and_each_child_is_taken_over_once(model, width, together):
    M, C, K = shuffled(model, 1)
    order = elimination(len(K), coupled_pairs(M, C, K), 2 * WIDEST, together)
    assert np.array_equal(np.concatenate([np.arange(len(K))[step.own] for step in order.steps]), np.arange(len(K)))
    taken, open_steps = [], set()
    for number, step in enumerate(order.steps):
        assert [tuple(column) for column in step.fronts.T] == list(order.fronts[step.own])
        for link in step.links:
            assert link.step in open_steps
            taken.extend(np.arange(len(K))[order.steps[link.step].own][link.given].tolist())
            if link.is_last:
                open_steps.remove(link.step)
        if len(step.fronts):
            open_steps.add(number)
        for places, row, column in step.spread:
            assert len(set(places)) == len(places) and np.array_equal(step.fronts[row, column], places)
    assert sorted(taken) == [own for own, front in enumerate(order.fronts) if front] and not open_steps


def test_what_is_eliminated_together():
    """Of a ring every other one, of a chain its ends, or every other one where two neighbours are as good as one."""
    ends = np.array([np.arange(64), (np.arange(64) + 1) % 64])
    assert elimination(64, ends).rounds[:3] == (32, 16, 8)
    assert elimination(64, ends[:, :-1]).rounds == (2,) * 31 + (1, 1)
    assert elimination(64, ends[:, :-1], together=2).rounds[:3] == (32, 16, 8)


def test_where_fronts_are_worth_their_width():
    zero, apart = np.zeros((4, 4)), np.kron(np.eye(2), np.ones((2, 2)))
    assert front_width(np.eye(4), zero, apart) == 1 and front_width(np.eye(4), zero, np.eye(4)) == 0
    assert front_width(np.ones((3, 3)), zero, apart) == 2 and front_width(np.ones((40, 40))) is None
    assert front_width(np.kron(np.eye(12), np.eye(12, k=1) + np.eye(12, k=-1)) + np.eye(144, k=12) + np.eye(144, k=-12)) is None
    assert are_worth(1, 4) and not are_worth(2, 30) and are_worth(2, 250)


def test_a_part_of_the_elimination_tree_is_coupled_to_one_front_only():
    M, C, K = shuffled(ladder(60))
    order = elimination(60, coupled_pairs(M, C, K))
    below = order.subtree(0.45)
    rest = np.setdiff1d(np.arange(60), below)
    assert 20 <= len(below) <= 34
    assert np.count_nonzero(K[np.ix_(below, rest)].any(axis=0)) <= order.width


def test_even_places_are_slices():
    assert as_slice([5]) == slice(5, 6, 1) and as_slice([3, 1]).tolist() == [3, 1]
