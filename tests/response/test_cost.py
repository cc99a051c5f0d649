"""What the ways to evaluate a motion are said to cost: orders that hold on every machine, and which way is taken."""

from __future__ import annotations

import numpy as np
import pytest

from mbconstrained.response.cost import decomposition_cost, stepping_cost, way_of
from mbconstrained.response.reduced import way_to_evaluate
from mbconstrained.response.solve import solve
from mbconstrained.signals.inputs import zero

from .plain_models import plain_system

UNDAMPED = plain_system("chain").polynomial_matrix()
DAMPED = plain_system("chain", damping="some").polynomial_matrix()
LONG = plain_system("chain", size=120, damping="some", damped=8).polynomial_matrix()
GRID = plain_system("grid", size=121, damping="some").polynomial_matrix()


def test_a_symmetric_eigenproblem_costs_less_than_a_general_one():
    assert decomposition_cost(UNDAMPED.reduction) < decomposition_cost(DAMPED.reduction)


@pytest.mark.parametrize("states", [48, 200, 2000])
@pytest.mark.parametrize("known", [False, True])
def test_stepping_costs_more_for_more_times_and_larger_steps_and_less_when_known(states, known):
    costs = [stepping_cost(states, times, 1.0, known) for times in (32, 1000, 100_000)]
    assert 0 <= costs[0] <= costs[1] < costs[2]
    assert stepping_cost(states, 100, 1e6, False) > stepping_cost(states, 100, 1.0, False)
    assert stepping_cost(states, 100, 1.0, True) < stepping_cost(states, 100, 1.0, False)


def test_each_way_has_its_name_and_its_reason():
    assert way_of(None, 100, None).name == "pairs"
    assert way_of(plain_system("chain", size=10).polynomial_matrix().reduction, 100, 1.0).name == "eigenvectors"
    assert way_of(UNDAMPED.reduction, 100, None).name == "symmetric"
    assert way_of(DAMPED.reduction, 100, None).name == "eigenvectors"
    assert way_of(LONG.reduction, 100, None).name == "chain"
    assert way_of(GRID.reduction, 100, None).name == "eigenvectors"
    assert way_of(DAMPED.reduction, 100, 1.0).name == "powers"
    assert way_of(DAMPED.reduction, 10**9, 1.0).name == "eigenvectors"
    assert all(way_of(reduction, 100, None).reason for reduction in (None, UNDAMPED.reduction))


def test_the_way_told_is_the_way_taken():
    start, even = np.ones((2, 36)), np.linspace(0.0, 10.0, 100)
    for times, name in ((even, "powers"), (even + 1.0, "eigenvectors")):
        A = plain_system("chain", damping="some").polynomial_matrix()
        assert way_to_evaluate(A, start, zero(36), times).name == name
        solve(A, start)(times)
        assert ("decoupled" in A.reduction.__dict__) == (name != "powers")
    small = plain_system("chain", size=10).polynomial_matrix()
    assert way_to_evaluate(small, np.ones((2, 10)), zero(10), even).name == "eigenvectors"


def test_modes_of_a_long_chain_cost_less_than_eigenvectors_and_their_number_says_how_much():
    assert decomposition_cost(LONG.reduction) < decomposition_cost(GRID.reduction)
    assert way_of(LONG.reduction, 10**6, 1.0).name == "chain"
