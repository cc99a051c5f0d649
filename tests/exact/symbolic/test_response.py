"""The motion in closed form against the papers, mpmath's inversion of X(s), the numeric engine and rational arithmetic."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
from mbconstrained.exact.symbolic.symbolic_response import (
    ResponseTransform,
    force_sources,
    initial_sources,
    initial_symbols,
    solve_symbolically,
)
from tests.exact.symbolic.laplace import at_infinity, inverted
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
from tests.oracles.exact import ExactResponse, determinant, rational
from tests.oracles.models import TABLES

t = sympy.Symbol("t", real=True)
F, w, p, t0 = sympy.symbols("F w p t0", positive=True)
R = sympy.Rational
VALUES = {
    m: R(7, 3),
    k: R(5, 2),
    c: R(1, 3),
    k1: R(3, 2),
    k2: R(7, 5),
    c1: R(2, 7),
    c2: R(5, 3),
    F: 3,
    w: R(4, 3),
    p: R(1, 5),
    t0: R(5, 4),
}
#: The tables have 25 digits after the point, or more.
PUBLISHED = sympy.Float("1e-24", 40)
MODELS = [OSCILLATOR, DAMPED, TWO_MASSES, MASSLESS_JOINTS, RIGID_LINK, STEP_OF_A_DERIVATIVE, FREE_AND_DECAYING]
#: Three coordinates with symbols make long formulas.
CASES = [
    pytest.param(A, id=",".join(A.coordinates), marks=[pytest.mark.long] * (A in (TWO_MASSES, MASSLESS_JOINTS))) for A in MODELS
]


def numbers(matrix, values, digits=40):
    put = {symbol: sympy.S(value) for symbol, value in values.items()}
    return [complex(sympy.N(sympy.S(entry).xreplace(put), digits)) for entry in matrix]


def table(example: str, *columns: str) -> dict:
    """{time: published values} as expressions."""
    return {R(row["t"]): [R(row[column]) for column in columns] for row in TABLES[example]}


def test_the_table_of_5_1_with_m_and_k_as_symbols():
    x = solve_symbolically(TWO_MASSES, [[R(4, 5), R(6, 5), 2], [0, 0, 0]])
    for time, known in table("ex51", "x1bar", "q1", "q2bar").items():
        found = x.regular.subs({m: 10, k: 2, x.time: time})
        assert all(abs(sympy.N(entry - value, 40)) < PUBLISHED for entry, value in zip(found, known))
    assert not x.impulses and not any(x.jump) and x.assumptions == ()
    assert not x.regular.has(sympy.I) and not x.regular.atoms(sympy.Float)


def test_the_table_of_5_2_with_five_symbols():
    x = solve_symbolically(MASSLESS_JOINTS, [[R(2, 3), 1, 2], [0, 0, 0]])
    values = {m: 10, k2: 3, c2: 4, k1: 6, c1: 8}
    for time, known in table("ex52", "u1", "u2", "u3").items():
        found = x.regular.subs({**values, x.time: time})
        assert all(abs(sympy.N(entry - value, 40)) < PUBLISHED for entry, value in zip(found, known))
    assert not any(x.jump.subs(values)) and not x.impulses
    assert [sympy.factor(e) for e in x.jump[0, :]] == [sympy.factor(2 * k2 / (k1 + k2) - R(2, 3)), 0, 0]


@pytest.mark.long
def test_equations_89_and_90_with_the_matrices_of_the_paper_corrected():
    """C, J, B_F of (86)-(88), entry (6, 3) of (88) without its factor m."""
    r5 = sympy.sqrt(5)
    above, below = (sympy.sqrt(k / m) * sympy.sqrt(3 + sign * r5) / sympy.sqrt(2) for sign in (1, -1))
    C = sympy.Matrix(
        [[0, 0, (3 + r5) / 2, 0, (3 - r5) / 2, 0], [1, 0, (3 + r5) / 2, 0, (3 - r5) / 2, 0], [0, 0, -2 - r5, 0, r5 - 2, 0]]
    )
    rotation = sympy.Matrix([[0, 1], [-1, 0]])
    J = sympy.diag(sympy.Matrix([[0, 1], [0, 0]]), above * rotation, below * rotation)
    B = sympy.zeros(6, 3)
    B[1, 2] = -1
    B[3, :] = sympy.Matrix(
        [
            [
                -sympy.sqrt(2 / (5 * (3 + r5))) * sympy.sqrt(k / m) / k,
                (5 - r5) * sympy.sqrt(k / (6 * m + 2 * r5 * m)) / (5 * k),
                (5 - 3 * r5) / (5 * sympy.sqrt(2 * (3 + r5)) * sympy.sqrt(k / m)),
            ]
        ]
    )
    low = sympy.sqrt((3 - r5) * k / m)
    B[5, :] = sympy.Matrix(
        [[sympy.sqrt(R(2, 5)) / (low * m), (5 + r5) / (5 * sympy.sqrt(2) * low * m), (5 + 3 * r5) / (5 * sympy.sqrt(2) * low)]]
    )
    X0 = initial_symbols(TWO_MASSES)
    A2 = TWO_MASSES.coefficients[2]
    start = J * B * A2 * X0[0, :].T + B * A2 * X0[1, :].T
    turning = [sympy.Matrix([[sympy.cos(f * t), sympy.sin(f * t)], [-sympy.sin(f * t), sympy.cos(f * t)]]) for f in (above, below)]
    printed = C * sympy.diag(sympy.Matrix([[1, t], [0, 1]]), *turning) * start
    found = solve_symbolically(TWO_MASSES, "symbols", time=t).regular
    values = {**VALUES, t: R(7, 4), **{symbol: R(i + 1, 3) for i, symbol in enumerate(X0)}}
    np.testing.assert_allclose(numbers(found, values), numbers(printed, values), rtol=1e-14)


KINDS = ["free", "harmonic", "decaying", "step"]


def force_and_transform(kind, r):
    """f(t) as expressions, and F(s) at VALUES as a function of mpmath numbers."""
    force = {
        "free": [sympy.S.Zero] * r,
        "harmonic": [F * sympy.cos(w * t + p)] + [sympy.S.Zero] * (r - 1),
        "decaying": [sympy.S.Zero] * (r - 1) + [F * t * sympy.exp(-2 * t)],
        "step": [sympy.S.One] * r,
    }[kind]
    laplace = {
        "free": lambda s: [0] * r,
        "harmonic": lambda s: (
            [
                3
                * (s * mpmath.cos(mpmath.mpf(1) / 5) - mpmath.mpf(4) / 3 * mpmath.sin(mpmath.mpf(1) / 5))
                / (s**2 + mpmath.mpf(16) / 9)
            ]
            + [0] * (r - 1)
        ),
        "decaying": lambda s: [0] * (r - 1) + [3 / (s + 2) ** 2],
        "step": lambda s: [1 / s] * r,
    }[kind]
    return force, laplace


@pytest.mark.parametrize("A", MODELS, ids=lambda A: ",".join(A.coordinates))
@pytest.mark.parametrize("kind", KINDS)
def test_impulses_and_values_at_0_are_the_transform_s_at_infinity(A, kind):
    """From general values at 0-, most of which make impulses or jumps where they can; the motion after them takes long."""
    force, laplace = force_and_transform(kind, A.size)
    initial = sympy.Matrix(A.degree, A.size, lambda i, j: R(2 * i - j + 1, 3))
    x = ResponseTransform(A, initial_sources(A, initial) + force_sources(A, force, t))
    for power in range(A.degree + 1):
        known = at_infinity(A.coefficients, VALUES, initial, laplace, power)
        found = x.impulses[power] if power < len(x.impulses) else sympy.zeros(A.size, 1)
        np.testing.assert_allclose(numbers(found, VALUES), [complex(e) for e in known], rtol=1e-14, atol=1e-25)
    assert len(x.impulses) <= A.degree + 1 and (not x.impulses or any(x.impulses[-1]))
    for i in range(A.degree):
        known = at_infinity(A.coefficients, VALUES, initial, laplace, -1 - i)
        np.testing.assert_allclose(numbers(x.start[i, :], VALUES), [complex(e) for e in known], rtol=1e-14, atol=1e-25)


#: Without a formula in eight symbols, which takes half a minute.
MOTIONS = [
    pytest.param(*case.values, kind, id=f"{kind}-{case.id}", marks=case.marks)
    for case in CASES
    for kind in KINDS
    if (case.values[0], kind) != (MASSLESS_JOINTS, "harmonic")
]


@pytest.mark.parametrize(("A", "kind"), MOTIONS)
def test_values_are_those_of_the_inverted_transform(A, kind):
    """From general values at 0-, changed where these would make impulses: Talbot needs X(s) -> 0 at infinity."""
    r, q = A.size, A.degree
    force, laplace = force_and_transform(kind, r)
    initial = sympy.Matrix(q, r, lambda i, j: R(2 * i - j + 1, 3))
    if A in (RIGID_LINK, STEP_OF_A_DERIVATIVE):
        conditions = solve_symbolically(A, None, force, t).admissible_conditions
        values = dict(zip(initial_symbols(A), initial))
        for condition in reversed(conditions):
            values[condition.lhs] = condition.rhs.subs(values).subs(VALUES)
        initial = initial_symbols(A).subs(values)
    x = solve_symbolically(A, initial, force, t)
    assert all(abs(entry) < 1e-30 for impulse in x.impulses for entry in numbers(impulse, VALUES))
    for time, known in zip((R(1, 2), R(3)), inverted(A.coefficients, VALUES, initial, laplace, (0.5, 3))):
        np.testing.assert_allclose(numbers(x.regular, {**VALUES, t: time}), [complex(e) for e in known], rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("A", [case for case in CASES if case.values[0] is not MASSLESS_JOINTS])
def test_the_equations_hold_after_0_and_the_start_is_that_of_the_formula(A):
    """A(d/dt) x - f = 0 for t > 0, and the Laurent coefficients of X are the derivatives of x at 0+."""
    force = sympy.Matrix([F * sympy.cos(R(4, 3) * t + p), t**2, sympy.exp(-t)][: A.size])
    x = solve_symbolically(A, "symbols", force, t)
    values = {**VALUES, **{symbol: R(i - 2, 3) for i, symbol in enumerate(initial_symbols(A))}}
    residual = sum((matrix * x.derivative(i) for i, matrix in enumerate(A.coefficients)), -force)
    assert all(abs(entry) < 1e-30 for entry in numbers(residual, {**values, t: R(9, 7)}, 60))
    for i in range(A.degree):
        at_start = numbers(x.derivative(i), {**values, t: 0}, 60)
        np.testing.assert_allclose(at_start, numbers(x.start[i, :], values), rtol=1e-14, atol=1e-25)


@pytest.mark.long
@settings(max_examples=6)  # formulas in symbols each time
@given(
    st.sampled_from([DAMPED, TWO_MASSES]),
    st.lists(st.integers(1, 12), min_size=3, max_size=3),
    st.lists(st.integers(-4, 4), min_size=6, max_size=6),
    st.integers(1, 9),
)
def test_the_numeric_engine_agrees_at_random_values(A, parameters, start, frequency):
    values = dict(zip((m, k, c), parameters))
    if not values[c] ** 2 - 4 * values[k] * values[m]:
        return
    X0 = np.reshape(start[: A.degree * A.size], (A.degree, A.size)).astype(float)
    vector = np.arange(1.0, A.size + 1)
    numeric = mb.PolynomialMatrix([np.array(matrix.subs(values), float) for matrix in A.coefficients])
    force = mb.harmonic(vector, angular_frequency=frequency / 7, phase=0.3)
    known = mb.solve(numeric, X0, force)
    wave = sympy.cos(R(frequency, 7) * t + R(3, 10))
    x = solve_symbolically(A, X0.astype(int).tolist(), [int(v) * wave for v in vector], t)
    scale = max(1.0, np.abs(known(2.0)).max())
    np.testing.assert_allclose(numbers(x.regular, {**values, t: 2}), known(2.0), rtol=0, atol=1e-9 * scale)
    np.testing.assert_allclose(numbers(x.jump, values), known.jump.ravel(), rtol=0, atol=1e-9 * scale)


@pytest.mark.parametrize(
    ("initial", "force", "orders"),
    [
        ([[1, 0, 0], [0, 0, 0]], [0, 0, 0], [[0, 0, 0], [0, 0, -R(1, 2)]]),
        ([[0, 0, 0], [1, 0, 0]], [0, 0, 0], [[0, 0, -R(1, 2)]]),
        (None, [0, 0, 1], [[0, 0, 0], [0, 0, R(1, 2)]]),
        (None, [0, 0, t], [[0, 0, R(1, 2)]]),
        ([[1, 1, R(1, 2)], [1, 1, R(1, 2)]], [0, 0, 0], []),
    ],
)
def test_the_impulses_of_the_rigid_link(initial, force, orders):
    x = solve_symbolically(RIGID_LINK, initial, force, t)
    assert [list(impulse) for impulse in x.impulses] == orders
    known = ExactResponse(
        [[[int(e) for e in row] for row in matrix.tolist()] for matrix in RIGID_LINK.coefficients],
        [[sympy_fraction(e) for e in row] for row in (sympy.Matrix(initial) if initial else sympy.zeros(2, 3)).tolist()],
        [([0, 0, 1], int(force[2] == t), 0, 0, "cos")] if force[2] else [],
    )
    assert [[sympy.Rational(str(e)) for e in impulse] for impulse in known.impulses] == orders
    assert [sympy.Rational(str(e)) for i in range(2) for e in known.derivatives[i]] == list(x.start)


@st.composite
def integer_problems(draw):
    """A(s) of small integers, det A(s) not zero, and integer values at 0-."""
    q, r = draw(st.integers(1, 2)), draw(st.integers(1, 3))
    entries = st.lists(st.integers(-2, 2), min_size=r, max_size=r)
    A = [draw(st.lists(entries, min_size=r, max_size=r)) for _ in range(q + 1)]
    X0 = draw(st.lists(st.lists(st.integers(-3, 3), min_size=r, max_size=r), min_size=q, max_size=q))
    return A, X0


@pytest.mark.long
@given(integer_problems().filter(lambda problem: determinant(rational(problem[0]))))
def test_impulses_and_the_start_are_those_of_rational_arithmetic(problem):
    """Exactly; and the formula soon after 0 has the value of its Taylor series."""
    coefficients, initial = problem
    r, q = len(coefficients[0]), len(coefficients) - 1
    known = ExactResponse(rational(coefficients), rational([initial])[0], [([Fraction(1)] * r, 1, -2, 3, "cos")], count=30)
    x = solve_symbolically(SymbolicPolynomialMatrix(coefficients), initial, [t * sympy.exp(-2 * t) * sympy.cos(3 * t)] * r, t)
    assert [[Fraction(int(e.p), int(e.q)) for e in impulse] for impulse in x.impulses] == known.impulses
    assert [[Fraction(int(e.p), int(e.q)) for e in x.start[i, :]] for i in range(q)] == known.derivatives[:q]
    found, value = numbers(x.regular, {t: R(1, 32)}, 60), known(Fraction(1, 32))
    np.testing.assert_allclose(found, value, rtol=1e-12, atol=1e-12 * max(1.0, *map(abs, value)))


def sympy_fraction(number):
    return Fraction(int(sympy.S(number).p), int(sympy.S(number).q))


def test_the_first_start_of_the_rigid_link_is_that_of_the_reference():
    x = solve_symbolically(RIGID_LINK, [[1, 0, 0], [0, 0, 0]])
    assert list(x.start) == [R(1, 2), R(1, 2), R(1, 4), 0, 0, 0]
    assert x.expression[2].coeff(sympy.DiracDelta(x.time, 1)) == -R(1, 2)


def test_the_force_before_0_does_not_enter():
    """CE1: from (0, 0) a step of f_2 makes x_1 = delta; from (0, 1) it makes nothing."""
    assert list(solve_symbolically(STEP_OF_A_DERIVATIVE, [[0, 0]], [0, 1]).impulses[0]) == [1, 0]
    x = solve_symbolically(STEP_OF_A_DERIVATIVE, [[0, 1]], [0, 1])
    assert x.impulses == () and not any(x.jump)


def test_resonance_when_the_frequency_is_the_model_s():
    for frequency in (sympy.sqrt(k / m), sympy.sqrt(k) / sympy.sqrt(m)):
        x = solve_symbolically(OSCILLATOR, None, [F * sympy.cos(frequency * t)], t)
        own = sympy.sqrt(k / m)
        assert sympy.simplify(x.regular[0] - F * t * sympy.sin(own * t) / (2 * m * own)) == 0
    assert (
        solve_symbolically(SymbolicPolynomialMatrix([[[4]], [[0]], [[1]]]), None, [sympy.cos(2 * t)], t).regular[0]
        == t * sympy.sin(2 * t) / 4
    )


def test_without_resonance_the_frequency_is_an_assumption():
    x = solve_symbolically(OSCILLATOR, None, [F * sympy.cos(w * t)], t)
    assert x.assumptions == (k - m * w**2,) or x.assumptions == (-k + m * w**2,)
    limit = sympy.limit(x.regular[0].subs({m: 1, k: 4, F: 1}), w, 2)
    assert sympy.simplify(limit - t * sympy.sin(2 * t) / 4) == 0


def test_a_later_start_is_the_same_motion_later():
    x = solve_symbolically(RIGID_LINK, None, [0, 0, F * sympy.Heaviside(t - t0)], t)
    now = solve_symbolically(RIGID_LINK, None, [0, 0, F], t)
    ((when, impulses),) = x.later_impulses
    assert when == t0 and list(map(list, impulses)) == list(map(list, now.impulses)) and x.impulses == ()
    moved = now.regular.xreplace({t: t - t0}) * sympy.Heaviside(t - t0)
    assert numbers(x.regular, {**VALUES, t: 3}) == pytest.approx(numbers(moved, {**VALUES, t: 3}), rel=1e-14)
    assert numbers(x.regular, {**VALUES, t: 1}) == [0, 0, 0]
    assert x.expression.has(sympy.DiracDelta(t - t0, 1))


def test_degenerate_shapes():
    algebraic = SymbolicPolynomialMatrix([[[k]]])
    x = solve_symbolically(algebraic, None, [F * sympy.sin(w * t) + sympy.DiracDelta(t)], t)
    assert x.regular[0] == F * sympy.sin(w * t) / k and list(x.impulses[0]) == [1 / k]
    assert x.start.shape == (0, 1) and x.continuity_conditions == ()
    rest = solve_symbolically(OSCILLATOR)
    assert list(rest.regular) == [0] and rest.expression == rest.regular and rest.derivative(2)[0] == 0


def test_floats_are_the_decimals_that_they_are_written_as():
    x = solve_symbolically(SymbolicPolynomialMatrix([[[0.1]], [[1]]]), [[0.3]], [0.7 * sympy.exp(-t)], t)
    assert not x.regular.atoms(sympy.Float) and x.start[0] == R(3, 10)


@pytest.mark.parametrize(
    ("ask", "text"),
    [
        (lambda: solve_symbolically([[1]]), "A: found an object of type list"),
        (lambda: solve_symbolically(OSCILLATOR, [[1, 2], [0, 0]]), "initial: expected 2 rows of 1 values"),
        (lambda: solve_symbolically(OSCILLATOR, "zeros"), "initial: found 'zeros'"),
        (lambda: solve_symbolically(OSCILLATOR, [["1"], [0]]), "initial: found '1'"),
        (lambda: solve_symbolically(OSCILLATOR, None, [1, 2]), "force: found 2 entries; expected 1"),
        (lambda: solve_symbolically(OSCILLATOR, None, [sympy.tan(t)]), r"force: found tan\(t\)"),
        (lambda: solve_symbolically(OSCILLATOR, None, [t], sympy.Symbol("t")), 'two symbols "t" of different assumptions'),
        (lambda: solve_symbolically(OSCILLATOR, None, [sympy.Symbol("k")]), 'two symbols "k" of different assumptions'),
        (lambda: solve_symbolically(OSCILLATOR, None, [sympy.Symbol("s")]), 'the symbol "s" is the variable'),
        (lambda: solve_symbolically(OSCILLATOR, None, [t], k), "time: the symbol k is also one of A"),
        (lambda: solve_symbolically(OSCILLATOR, None, [sympy.cos(2 ** R(1, 3) * t)]), "expected a rational function"),
        (
            lambda: solve_symbolically(OSCILLATOR, [1, 0]),
            r"expected 2 rows of 1 values, row i the i-th derivatives.*found \[1, 0\]",
        ),
        (lambda: solve_symbolically(OSCILLATOR, 1), "expected 2 rows of 1 values, row i the i-th derivatives.*found 1"),
        (lambda: solve_symbolically(OSCILLATOR, None, F), "force: found F; expected a list of 1 sympy expression .*Heaviside"),
        (lambda: solve_symbolically(OSCILLATOR, None, {"x1": F}), "force: found {'x1': F}; expected a list"),
        (
            lambda: solve_symbolically(OSCILLATOR, None, mb.step([1.0])),
            "force: found .*mb.step and others like it are .* of mb.solve",
        ),
        (lambda: solve_symbolically(OSCILLATOR, None, [2**t]), r"force: found 2\*\*t; expected exp\(a\*t\) with a rational"),
        (lambda: solve_symbolically(OSCILLATOR, None, [t], "t"), "time: found 't'; expected a sympy.Symbol"),
        (lambda: solve_symbolically(mb.PolynomialMatrix([[[1]], [[1]]])), "A: found an object of type PolynomialMatrix"),
        (lambda: initial_symbols(3), "A: found an object of type int"),
    ],
)
def test_what_cannot_be_done_is_said(ask, text):
    with pytest.raises(mb.InputError, match=text):
        ask()


def test_a_factor_without_closed_roots_is_named():
    A = SymbolicPolynomialMatrix([[[k]], [[c]], [[c1]], [[m]]])
    with pytest.raises(mb.InputError, match="no roots in closed form"):
        solve_symbolically(A, [[1], [0], [0]])
    numbers_only = SymbolicPolynomialMatrix([[[1]], [[3]], [[1]], [[1]]])
    x = solve_symbolically(numbers_only, [[1], [0], [0]])
    assert abs(sympy.N(x.regular[0].subs(x.time, 0), 30) - 1) < 1e-28


@pytest.mark.parametrize(
    ("coordinates", "name", "text"),
    [
        (None, "x1_0", "coordinate x1 and parameter x1_0: the value of x1 at 0-"),
        (["u"], "u_1", "coordinate u and parameter u_1: derivative 1 of u at 0-"),
    ],
)
@pytest.mark.parametrize("real", [True, None])
def test_a_parameter_called_like_a_value_at_0_is_refused(coordinates, name, text, real):
    """Else it would be taken for that value, or be printed like it."""
    parameter = sympy.Symbol(name, real=real)
    A = SymbolicPolynomialMatrix([[[parameter]], [[0]], [[1]]], coordinates)
    for initial in ("symbols", None, [[1], [0]]):
        with pytest.raises(mb.InputError, match=text):
            solve_symbolically(A, initial)
    fixed = SymbolicPolynomialMatrix([[[k]], [[0]], [[1]]], coordinates)
    with pytest.raises(mb.InputError, match=text):
        solve_symbolically(fixed, [[1], [0]], [F * parameter])
    third = SymbolicPolynomialMatrix([[[sympy.Symbol("x1_2")]], [[0]], [[1]]])
    assert third.symbols[0] in solve_symbolically(third, "symbols").regular.free_symbols


def test_a_force_may_depend_on_the_value_at_0():
    """A spring that is at rest where it starts: nothing moves."""
    x10, x11 = initial_symbols(OSCILLATOR)
    assert solve_symbolically(OSCILLATOR, [[x10], [0]], [k * x10], t).regular[0] == x10
    assert solve_symbolically(OSCILLATOR, "symbols", [k * x10], t).start[1] == x11


@pytest.mark.parametrize(
    "force",
    [sympy.Heaviside(w - 1), sympy.DiracDelta(w - 1), sympy.sin(w), F * sympy.exp(-w), sympy.cos(2 * w) ** 2, sympy.sinh(w)],
)
def test_a_force_of_another_time_is_refused(force):
    with pytest.raises(mb.InputError, match=r"but no time t; if w is the time, pass time=w"):
        solve_symbolically(OSCILLATOR, None, [force])
    moving = solve_symbolically(OSCILLATOR, None, [force], w)
    assert moving.time == w and w in moving.regular.free_symbols


def test_a_constant_force_may_have_an_angle():
    """m g sin(alpha), where the time is given; a step that does not depend on time is no force all the same."""
    x = solve_symbolically(SymbolicPolynomialMatrix([[[0]], [[0]], [[m]]]), None, [m * sympy.sin(p)], t)
    assert x.regular[0] == t**2 * sympy.sin(p) / 2
    with pytest.raises(mb.InputError, match=r"found Heaviside\(w - 1\), in which there is no t"):
        solve_symbolically(OSCILLATOR, None, [F * t * sympy.Heaviside(w - 1)], t)


def test_start_times_are_positive():
    early = sympy.Symbol("T", negative=True)
    for force in (sympy.Heaviside(t - early), sympy.Heaviside(t + 2 * early), sympy.DiracDelta(t - early)):
        with pytest.raises(mb.InputError, match="symbol T: it is declared not to be positive"):
            solve_symbolically(OSCILLATOR, None, [force], t)
    plain = sympy.Symbol("T")
    assert solve_symbolically(OSCILLATOR, None, [sympy.Heaviside(t - plain)], t).assumptions == (plain,)
    assert solve_symbolically(OSCILLATOR, None, [sympy.Heaviside(t - t0)], t).assumptions == ()


def test_what_is_divided_by_is_assumed():
    a, b = sympy.symbols("a b", positive=True)
    decaying = SymbolicPolynomialMatrix([[[a]], [[1]]])
    cases = [
        solve_symbolically(SymbolicPolynomialMatrix([[[1 / (a - b)]], [[1]]]), [[1]]),
        solve_symbolically(decaying, [[1 / (a - b)]]),
        solve_symbolically(decaying, None, [F / (b - a)], t),
        solve_symbolically(decaying, None, [sympy.exp(-t / (a + b)) / (a**2 - b**2) ** 2], t),
        solve_symbolically(decaying, None, [F / sympy.sqrt(a - b)], t),
    ]
    assert all((a - b) in x.assumptions or (b - a) in x.assumptions for x in cases)
    assert [len(x.assumptions) for x in cases] == [1, 1, 1, 2, 1]
    assert solve_symbolically(decaying, None, [F / (1 - sympy.cos(b))], t).assumptions == (1 - sympy.cos(b),)
    assert solve_symbolically(decaying, [[1 / (a + b)]], [F / a], t).assumptions == ()


@pytest.mark.parametrize("damping", [0, R(1, 5), 2, 7], ids=["undamped", "oscillating", "critical", "overdamped"])
def test_values_put_in_by_solving_again(damping):
    """Critical damping, where the formula is 0/0, and resonance: exactly the response of numbers, and no root of a negative number."""
    x = solve_symbolically(DAMPED, [[F], [-1]], [F * sympy.cos(w * t)], t)
    values = {k: 1, c: damping, m: 1, F: -R(1, 2), w: 1}
    found = x.at(values)
    A = SymbolicPolynomialMatrix([[[1]], [[damping]], [[1]]])
    known = solve_symbolically(A, [[-R(1, 2)], [-1]], [-sympy.cos(t) / 2], t)
    assert found.regular == known.regular and found.start == known.start and found.time == t
    assert found.regular.free_symbols == {t} and found.assumptions == ()
    values_of = sympy.lambdify(t, found.regular[0])(np.array([0.5, 2.0]))
    numeric = mb.solve(
        mb.PolynomialMatrix([[[1]], [[float(damping)]], [[1]]]), [[-0.5], [-1]], mb.harmonic([-0.5], angular_frequency=1)
    )
    np.testing.assert_allclose(values_of, numeric([0.5, 2.0])[0], rtol=1e-12)


@pytest.mark.parametrize(
    ("values", "text"),
    [
        (3, "values: found 3; expected a dictionary with values by symbol, of c, k, m"),
        ({"k": 1}, "values: found {'k': 1}"),
        ({sympy.Symbol("k"): 1}, "values: found {k: 1}"),
        ({t: 1}, "values: found {t: 1}"),
        ({k: "1"}, "k: found '1'"),
        ({m: sympy.nan}, "m: found nan"),
    ],
)
def test_values_that_cannot_be_put_in(values, text):
    x = solve_symbolically(DAMPED, [[1], [0]], time=t)
    with pytest.raises(mb.InputError, match=text):
        x.at(values)
    with pytest.raises(mb.SingularPolynomialMatrix):
        x.at({k: 0, c: 0, m: 0})
    divided = solve_symbolically(SymbolicPolynomialMatrix([[[1 / (k - c)]], [[1]]]), [[1]])
    with pytest.raises(mb.InputError, match="must be finite"):
        divided.at({k: c})


def test_pi_is_a_number_of_the_field():
    """A frequency in Hz, and a stiffness of 4 pi^2 m f^2."""
    f = sympy.Symbol("f", positive=True)
    x = solve_symbolically(OSCILLATOR, None, [F * sympy.sin(2 * sympy.pi * f * t)], t)
    other = solve_symbolically(OSCILLATOR, None, [F * sympy.sin(w * t)], t)
    values = {**VALUES, w: 2 * sympy.pi * R(3, 7), f: R(3, 7), t: R(5, 4)}
    assert numbers(x.regular, values) == pytest.approx(numbers(other.regular, values), rel=1e-14)
    (assumed,) = x.assumptions
    assert sympy.expand(assumed**2 - (k - 4 * sympy.pi**2 * f**2 * m) ** 2) == 0
    A = SymbolicPolynomialMatrix([[[4 * sympy.pi**2 * m * f**2]], [[0]], [[m]]])
    assert solve_symbolically(A, [[1], [0]], time=t).regular[0] == sympy.cos(2 * sympy.pi * f * t)
    assert A.symbols == (f, m) and A.structure().finite_zeros[0].value == 2 * sympy.pi * sympy.I * f and A.assumptions == ()
    resonant = solve_symbolically(A, None, [m * sympy.cos(2 * sympy.pi * f * t)], t)
    assert sympy.simplify(resonant.regular[0] - t * sympy.sin(2 * sympy.pi * f * t) / (4 * sympy.pi * f)) == 0


@pytest.mark.parametrize("damping, overdamped", [(sympy.pi, False), (7, True), (2 * sympy.pi, None)])
def test_the_sign_of_a_number_with_pi_decides(damping, overdamped):
    x = solve_symbolically(SymbolicPolynomialMatrix([[[sympy.pi**2]], [[damping]], [[1]]]), [[1], [2]], time=t)
    assert x.assumptions == () and x.regular[0].has(sympy.cos) == (overdamped is False)
    assert x.regular[0].has(t * sympy.exp(-sympy.pi * t)) == (overdamped is None)
    numeric = mb.solve(mb.PolynomialMatrix([[[np.pi**2]], [[float(damping)]], [[1]]]), [[1], [2]])
    assert numbers(x.regular, {t: R(4, 5)})[0] == pytest.approx(numeric(0.8)[0], rel=1e-7)
