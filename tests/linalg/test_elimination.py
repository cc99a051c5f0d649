"""Orders of elimination against the pattern of Cholesky's factor."""

import numpy as np
import pytest

from mbconstrained.linalg.elimination import WIDEST, coupled_pairs, elimination, front_width

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
