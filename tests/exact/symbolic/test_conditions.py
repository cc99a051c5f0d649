"""Conditions on the values at 0-: the papers', the counter-examples', and against impulses and jumps themselves."""

import pytest
import sympy

from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
from mbconstrained.exact.symbolic.symbolic_response import (
    ResponseTransform,
    continuity_equations,
    force_sources,
    impulse_equations,
    initial_sources,
    initial_symbols,
    solve_symbolically,
)
from tests.exact.symbolic.models import (
    DAMPED,
    FREE_AND_DECAYING,
    MASSLESS_JOINTS,
    RIGID_LINK,
    STEP_OF_A_DERIVATIVE,
    TWO_MASSES,
    c1,
    c2,
    k1,
    k2,
)

t = sympy.Symbol("t", real=True)
F, w, p = sympy.symbols("F w p", positive=True)
NILPOTENT = SymbolicPolynomialMatrix([sympy.eye(3), [[0, -k1, 0], [0, 0, -k2], [0, 0, 0]]])  # x1 = k1 x2', x2 = k2 x3', x3 = f3
CUBIC = SymbolicPolynomialMatrix([[[1, 0], [0, 1]], [[0, 0], [0, 0]], [[0, 0], [0, 0]], [[0, -k1], [0, 0]]])  # x1 = k1 x2'''
MODELS = [DAMPED, TWO_MASSES, MASSLESS_JOINTS, RIGID_LINK, STEP_OF_A_DERIVATIVE, FREE_AND_DECAYING, NILPOTENT, CUBIC]
FORCES = [None, [F * sympy.cos(w * t + p), sympy.exp(-2 * t), t**2]]


def solved(conditions, symbols):
    """The values with what the conditions say put in, from the last to the first."""
    values = {symbol: symbol for symbol in symbols}
    for condition in reversed(conditions):
        values[condition.lhs] = condition.rhs.subs(values)
    return [values[symbol] for symbol in symbols]


def test_equation_99_with_the_paper_s_proportions():
    """k1 = 2 k2, c1 = 2 c2: u1 = u3/3, and u1' = u2' = u3'/3."""
    u = initial_symbols(MASSLESS_JOINTS)
    free = solve_symbolically(MASSLESS_JOINTS)
    assert free.admissible_conditions == ()
    proportions = {k1: 2 * k2, c1: 2 * c2}
    found = [(e.lhs, sympy.simplify(e.rhs.subs(proportions))) for e in free.continuity_conditions]
    assert found == [(u[0, 0], u[0, 2] / 3), (u[1, 0], u[1, 2] / 3), (u[1, 1], u[1, 2] / 3)]


def test_conditions_of_5_2_with_five_symbols():
    u = initial_symbols(MASSLESS_JOINTS)
    share, other = k2 / (k1 + k2), c2 / (c1 + c2)
    found = {e.lhs: sympy.simplify(e.rhs / u[int(str(e.lhs)[-1]), 2]) for e in continuity_equations(MASSLESS_JOINTS)}
    assert found == {u[0, 0]: sympy.simplify(share), u[1, 0]: sympy.simplify(share), u[1, 1]: sympy.simplify(other)}


def test_the_jump_projector_of_5_2():
    """P X0 = x(0+), with k1 = 2 k2, c1 = 2 c2."""
    u = initial_symbols(MASSLESS_JOINTS)
    after = solve_symbolically(MASSLESS_JOINTS, "symbols").start.subs({k1: 2 * k2, c1: 2 * c2}).applyfunc(sympy.simplify)
    assert list(after) == [u[0, 2] / 3, u[0, 1], u[0, 2], u[1, 2] / 3, u[1, 2] / 3, u[1, 2]]


def test_the_row_of_5_1_at_position_level_jumps():
    """The constraint x1 - q1 = -d as an equation: values that break it jump onto it, with P = diag(N, N); no impulse."""
    rows = [matrix.tolist() for matrix in TWO_MASSES.coefficients]
    rows[0][2], rows[2][2] = rows[2][2], rows[0][2]
    A = SymbolicPolynomialMatrix(rows)
    x, d = initial_symbols(A), sympy.Symbol("d", positive=True)
    N = sympy.Matrix([[1, 0, 0], [1, 0, 0], [-1, 1, 1]])
    free = solve_symbolically(A, "symbols")
    assert free.start == sympy.Matrix.vstack((N * x[0, :].T).T, (N * x[1, :].T).T) and free.impulses == ()
    shifted = solve_symbolically(A, "symbols", [0, 0, -d])
    assert shifted.continuity_conditions == (sympy.Eq(x[0, 0], x[0, 1] - d), sympy.Eq(x[1, 0], x[1, 1]))


def test_the_force_enters_at_0_plus():
    """CE1: x1 = x2', x2 = f2. As printed, with f(0-), (58) has it wrong both ways."""
    x = solve_symbolically(STEP_OF_A_DERIVATIVE, None, [0, 1])
    (x1, x2) = initial_symbols(STEP_OF_A_DERIVATIVE)
    assert x.admissible_conditions == (sympy.Eq(x2, 1),)
    assert x.continuity_conditions == (sympy.Eq(x1, 0), sympy.Eq(x2, 1))
    smooth = solve_symbolically(STEP_OF_A_DERIVATIVE, None, [0, F * sympy.cos(w * t + p)], t)
    assert smooth.admissible_conditions == (sympy.Eq(x2, F * sympy.cos(p)),)


def test_the_derivatives_of_the_convolution_count():
    """CE2: s^2 x1 = 0, x2' + x2 = 1: continuous where x2' = 1 - x2. As printed, (60) has x2' = -1 or nothing."""
    x = solve_symbolically(FREE_AND_DECAYING, None, [0, 1])
    values = initial_symbols(FREE_AND_DECAYING)
    assert x.admissible_conditions == () and x.continuity_conditions == (sympy.Eq(values[0, 1], 1 - values[1, 1]),)
    for start, jumps in (([[0, 1], [0, 0]], [0, 0, 0, 0]), ([[0, 1], [0, -1]], [0, 0, 0, 1])):
        assert list(solve_symbolically(FREE_AND_DECAYING, start, [0, 1]).jump) == jumps


@pytest.mark.parametrize("force", FORCES, ids=["free", "forced"])
@pytest.mark.parametrize("A", MODELS, ids=lambda A: f"{A.size}x{A.degree}")
def test_they_hold_exactly_where_there_are_no_impulses_and_no_jumps(A, force):
    """Values that fulfil them make none; the number of conditions is the rank of the maps to impulses and to jumps."""
    acting = force_sources(A, [sympy.S(f) for f in force[: A.size]], t) if force else []

    def impulses_and_jumps(initial):  # without the motion after them, which takes long
        x = ResponseTransform(A, initial_sources(A, initial) + acting)
        return [entry for impulse in x.impulses for entry in impulse], list(x.start - initial)

    symbols = list(initial_symbols(A))
    impulses, jumps = impulses_and_jumps(initial_symbols(A))
    for conditions, residuals in ((impulse_equations(A, acting), impulses), (continuity_equations(A, acting), [*jumps, *impulses])):
        left, moved = impulses_and_jumps(sympy.Matrix(A.degree, A.size, solved(conditions, symbols)))
        left += moved if len(residuals) > len(impulses) else []
        assert all(sympy.simplify(entry) == 0 for entry in left)
        rank = (
            sympy.Matrix([[sympy.diff(e, symbol) for symbol in symbols] for e in residuals]).rank(simplify=True) if residuals else 0
        )
        assert rank == len(conditions)


@pytest.mark.parametrize("A", MODELS, ids=lambda A: f"{A.size}x{A.degree}")
def test_their_number_is_that_of_the_structure(A):
    """r q - n conditions for continuity, the sum of the orders of the zeros at infinity for no impulses."""
    structure = A.structure()
    n, zeros = A.determinant.degree(), sum(max(0, -order) for order in structure.at_infinity)
    assert len(continuity_equations(A)) == A.size * A.degree - n and len(impulse_equations(A)) == zeros
