"""A_q x^(q) = A_0 x by the formulas of the special case: the same motion as by the general path."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from tests.oracles import exact
from tests.oracles.exact import ExactResponse
from tests.oracles.papers.apostol_kolodner import apostol_kolodner
from tests.oracles.referee import case

TIMES = np.linspace(0.0, 2.0, 9)


@pytest.mark.parametrize("name", ["ak3", "rot_ak3"])
def test_the_referee_agrees(name):
    problem = case(name)
    function, _ = apostol_kolodner(mb.PolynomialMatrix(problem.coefficients), problem.initial)
    np.testing.assert_allclose(function(problem.times), problem.values, rtol=0, atol=1e-9 * problem.scale)


@st.composite
def forms(draw):
    """A_q and A_0 of small integers, A_q of any rank, and integer values at 0-."""
    q, r = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    entries = st.lists(st.integers(-2, 2), min_size=r * r, max_size=r * r).map(
        lambda values: np.reshape(values, (r, r)).astype(float)
    )
    coefficients = np.zeros((q + 1, r, r))
    coefficients[q], coefficients[0] = draw(entries), draw(entries)
    initial = draw(st.lists(st.integers(-3, 3), min_size=q * r, max_size=q * r))
    return coefficients, np.reshape(initial, (q, r)).astype(float)


@given(forms().filter(lambda problem: exact.determinant(exact.rational(problem[0]))))
def test_same_motion_and_impulses_as_by_the_general_path_and_in_rational_arithmetic(problem):
    coefficients, initial = problem
    A = mb.PolynomialMatrix(coefficients)
    (function, impulses), general = apostol_kolodner(A, initial), mb.solve(A, initial)
    size = np.abs(general(TIMES)).max(initial=1.0)
    np.testing.assert_allclose(function(TIMES), general(TIMES), rtol=0, atol=1e-9 * size)
    known = np.array(ExactResponse(exact.rational(coefficients), exact.rational([initial])[0], count=1).impulses, float)
    impulses = np.array(impulses).reshape(-1, A.size)
    padded = np.zeros_like(impulses)
    padded[: len(known)] = known.reshape(-1, A.size)
    np.testing.assert_allclose(impulses, padded, rtol=0, atol=1e-9 * max(1.0, np.abs(padded).max(initial=0.0)))


def test_the_sign_of_the_infinite_start():
    """x2 = 0 and x1 = x2' from x2(0-) = 1: x2 falls to 0, so x1 = -delta; as printed (76) gives +delta."""
    A = mb.PolynomialMatrix([np.eye(2), [[0, -1], [0, 0]]])
    _, impulses = apostol_kolodner(A, np.array([[0.0, 1.0]]))
    np.testing.assert_allclose(impulses, [[-1.0, 0.0]])
    assert np.array_equal(mb.solve(A, [[0.0, 1.0]]).impulses, [[-1.0, 0.0]])
