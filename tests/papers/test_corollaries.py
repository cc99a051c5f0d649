"""Corollaries 4.2 to 4.4 and the special case of Apostol and Kolodner: the same motion as by the general path, written differently."""

import numpy as np
import pytest
import sympy

from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
from mbconstrained.exact.symbolic.symbolic_response import initial_symbols, solve_symbolically
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
from tests.oracles.papers.apostol_kolodner import apostol_kolodner_in_symbols
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
    at = {symbol: sympy.S(value) for symbol, value in values.items()}
    at |= {symbol: R(i - 2, 3) for i, symbol in enumerate(initial_symbols(A))}
    return [complex(sympy.N(sympy.S(entry).xreplace(at), 30)) for entry in matrix]


@pytest.mark.parametrize("A", MODELS, ids=lambda A: f"{A.size}x{A.degree}")
def test_each_is_the_motion_of_the_general_path(A):
    known, motions = solve_symbolically(A, "symbols", time=t).regular, [formula(A, initial_symbols(A), t) for formula in FORMULAS]
    for values in (VALUES, OVERDAMPED):
        expected = numbers(known, A, values)
        for motion in motions:
            np.testing.assert_allclose(numbers(motion, A, values), expected, rtol=1e-14, atol=1e-16)


@pytest.mark.parametrize("A", [OSCILLATOR, TWO_MASSES, RIGID_LINK, STEP_OF_A_DERIVATIVE], ids=lambda A: f"{A.size}x{A.degree}")
def test_apostol_kolodner_is_the_general_path(A):
    (motion, impulses), known = apostol_kolodner_in_symbols(A, initial_symbols(A), t), solve_symbolically(A, "symbols", time=t)
    np.testing.assert_allclose(numbers(motion, A, VALUES), numbers(known.regular, A, VALUES), rtol=1e-14, atol=1e-16)
    assert [[sympy.expand(e) for e in impulse] for impulse in impulses] == [[sympy.expand(e) for e in i] for i in known.impulses]
