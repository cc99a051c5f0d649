"""Corollaries 4.2 to 4.4 and the special case of Apostol and Kolodner: the same motion as by the general path, written differently."""

import numpy as np
import pytest
import sympy

import mbconstrained as mb
from mbconstrained.exact.symbolic.response.inverse_transform import initial_symbols
from mbconstrained.exact.symbolic.response.symbolic_response import solve_symbolically
from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
from tests.exact.symbolic.models import (
    DAMPED,
    FREE_AND_DECAYING,
    MASSLESS_JOINTS,
    OSCILLATOR,
    RIGID_LINK,
    STEP_OF_A_DERIVATIVE,
    TWO_MASSES,
    c,
    c1,
    c2,
    k,
    k1,
    k2,
    m,
)
from tests.oracles.papers.apostol_kolodner import apostol_kolodner
from tests.oracles.papers.corollaries import (
    free_motion_by_interpolation,
    free_motion_by_jordan_blocks,
    free_motion_by_zeros,
)

R = sympy.Rational
t = sympy.Symbol("t", real=True)
ONE_TWICE = SymbolicPolynomialMatrix([sympy.eye(2) * k**2, sympy.eye(2) * 2 * k, sympy.eye(2)])  # (s + k)^2, twice: derogatory
PAIR_TWICE = SymbolicPolynomialMatrix([[[k**2]], [[0]], [[2 * k * m]], [[0]], [[m**2]]])  # (m s^2 + k)^2: chains of length 2
UNEQUAL = SymbolicPolynomialMatrix([[[0, 0], [0, 0]], [[k, 1], [0, 0]], [[1, 0], [0, 1]]])
ALGEBRAIC = SymbolicPolynomialMatrix([[[1, 0], [0, k]]])
FORMULAS = [free_motion_by_jordan_blocks, free_motion_by_interpolation, free_motion_by_zeros]
MODELS = [
    OSCILLATOR,
    DAMPED,
    TWO_MASSES,
    MASSLESS_JOINTS,
    RIGID_LINK,
    FREE_AND_DECAYING,
    STEP_OF_A_DERIVATIVE,
    ONE_TWICE,
    PAIR_TWICE,
    UNEQUAL,
]
VALUES = {m: R(7, 3), k: R(5, 2), c: R(1, 3), k1: R(3, 2), k2: R(7, 5), c1: R(2, 7), c2: R(5, 3), t: R(7, 4)}
#: Overdamped: where the square roots in J are real.
OVERDAMPED = {**VALUES, c: 20, c1: 50, c2: 60}


def numbers(matrix, A, values):
    at = {**values, **{symbol: R(i - 2, 3) for i, symbol in enumerate(initial_symbols(A))}}
    return [complex(sympy.N(sympy.S(entry).subs(at), 30)) for entry in matrix]


@pytest.mark.parametrize("A", MODELS, ids=lambda A: f"{A.size}x{A.degree}")
def test_each_is_the_motion_of_the_general_path(A):
    known, *motions = solve_symbolically(A, "symbols", time=t).regular, *(formula(A, "symbols", t) for formula in FORMULAS)
    for values in (VALUES, OVERDAMPED):
        expected = numbers(known, A, values)
        for motion in motions:
            np.testing.assert_allclose(numbers(motion, A, values), expected, rtol=1e-14, atol=1e-16)


@pytest.mark.parametrize("formula", FORMULAS)
def test_no_state_no_motion(formula):
    assert list(formula(ALGEBRAIC, None, t)) == [0, 0]


@pytest.mark.parametrize("formula", FORMULAS)
def test_the_motion_of_an_oscillator_is_written_at_once(formula):
    x0, v0 = initial_symbols(OSCILLATOR)
    own = sympy.sqrt(k / m)
    known = x0 * sympy.cos(own * t) + v0 * sympy.sin(own * t) / own
    assert sympy.simplify(formula(OSCILLATOR, "symbols", t)[0] - known) == 0


@pytest.mark.parametrize("formula", [free_motion_by_interpolation, free_motion_by_jordan_blocks, free_motion_by_zeros])
def test_numbers_without_closed_roots_have_decimal_ones(formula):
    A = SymbolicPolynomialMatrix([[[1]], [[3]], [[1]], [[1]]])
    x = formula(A, [[1], [0], [0]], t)
    known = solve_symbolically(A, [[1], [0], [0]], time=t).regular
    assert abs(sympy.N((x - known)[0].subs(t, 2), 25)) < 1e-24


@pytest.mark.parametrize("formula", [free_motion_by_jordan_blocks, free_motion_by_zeros])
def test_symbols_without_closed_roots_have_no_jordan_form(formula):
    A = SymbolicPolynomialMatrix([[[k]], [[c]], [[0]], [[m]]])
    with pytest.raises(mb.InputError, match="no roots in closed form"):
        formula(A, [[1], [0], [0]], t)


@pytest.mark.parametrize("A", [OSCILLATOR, TWO_MASSES, RIGID_LINK, STEP_OF_A_DERIVATIVE], ids=lambda A: f"{A.size}x{A.degree}")
def test_apostol_kolodner_is_the_general_path(A):
    x, known = apostol_kolodner(A, "symbols", t), solve_symbolically(A, "symbols", time=t)
    np.testing.assert_allclose(numbers(x.function, A, VALUES), numbers(known.regular, A, VALUES), rtol=1e-14, atol=1e-16)
    assert [[sympy.expand(e) for e in impulse] for impulse in x.impulses] == [[sympy.expand(e) for e in i] for i in known.impulses]


def test_apostol_kolodner_in_numbers_is_the_same():
    """A mass on a spring, a joint without mass between two more springs: A_2 is singular."""
    A = SymbolicPolynomialMatrix([[[2 * k, -k], [-k, k + k1]], sympy.zeros(2), sympy.diag(m, 0)])
    values, X0 = {m: 2, k: 3, k1: 5}, [[1, 2], [-1, 3]]
    known = apostol_kolodner(mb.PolynomialMatrix([np.array(matrix.subs(values), float) for matrix in A.coefficients]), X0)
    x = apostol_kolodner(A, X0, t)
    np.testing.assert_allclose(numbers(x.function, A, {**values, t: R(1, 2)}), known.function(0.5), rtol=1e-12)
    assert x.impulses == () and x.finite_start.shape == (2, 1) and x.infinite_start.shape == (1, 1)


def test_the_sign_of_the_infinite_start():
    """x1 = x2', x2 = 0 from x2(0-) = 1: -delta. As printed, (76) gives +delta."""
    x = apostol_kolodner(STEP_OF_A_DERIVATIVE, [[0, 1]])
    assert [list(impulse) for impulse in x.impulses] == [[-1, 0]]


@pytest.mark.parametrize("A", [DAMPED, ALGEBRAIC], ids=["damping", "degree 0"])
def test_other_forms_are_refused(A):
    with pytest.raises(mb.InputError, match="with q >= 1 and nothing between"):
        apostol_kolodner(A, None)


EVERY = [free_motion_by_jordan_blocks, free_motion_by_interpolation, free_motion_by_zeros]
SYMBOLIC = [*EVERY, apostol_kolodner]


@pytest.mark.parametrize("real", [True, None])
@pytest.mark.parametrize("formula", SYMBOLIC)
def test_the_time_is_called_like_nothing_else(formula, real):
    """e^{-t t} would be the motion of a rate that is called t."""
    rate, other = sympy.Symbol("t", real=real), sympy.Symbol("tau", real=real)
    with pytest.raises(mb.InputError, match="time: the symbol t is also one of A or of the values at 0-"):
        formula(SymbolicPolynomialMatrix([[[rate]], [[1]]]), [[1]])
    with pytest.raises(mb.InputError, match="time: the symbol tau is also one of A or of the values at 0-"):
        formula(SymbolicPolynomialMatrix([[[k]], [[1]]]), [[other]], sympy.Symbol("tau"))
    with pytest.raises(mb.InputError, match='the symbol "s" is the variable'):
        formula(SymbolicPolynomialMatrix([[[k]], [[1]]]), [[1]], sympy.Symbol("s"))


@pytest.mark.parametrize("formula", EVERY)
def test_other_arguments_are_refused(formula):
    with pytest.raises(mb.InputError, match="time: found 't'; expected a sympy.Symbol"):
        formula(OSCILLATOR, [[1], [0]], "t")
    with pytest.raises(mb.InputError, match="A: found an object of type PolynomialMatrix; expected a SymbolicPolynomialMatrix"):
        formula(mb.PolynomialMatrix([[[1]], [[1]]]), [[1]])
    parameter = SymbolicPolynomialMatrix([[[sympy.Symbol("x1_0", real=True)]], [[1]]])
    with pytest.raises(mb.InputError, match="coordinate x1 and parameter x1_0"):
        formula(parameter, "symbols")
