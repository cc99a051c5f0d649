"""Signs, square roots and zeros in radicals, against their values at numbers for the symbols."""

import mpmath
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.exact.symbolic.fields import (
    element,
    field_of,
    root_expression,
    sign,
    sign_with_root,
    square_root,
)
from mbconstrained.exact.symbolic.radicals import Surd, compact_expression, roots
from mbconstrained.exact.symbolic.symbolic_matrix import inverse_modulo
from tests.exact.symbolic.gallery import s

DIGITS = 40
a, b, c, d = sympy.symbols("a b c d")
K = field_of([a, b, c, d])
POSITIVE = [1, a, a / b, a**2 - a * b + b**2, (a - b) ** 2 / c, (a * d - b * c) ** 2 + a * b * c * d, (a + b) ** 2 - 2 * a * b]
UNDECIDED = [a - b, (a - b) / (a + c), a**2 - 3 * a * b + b**2, a - 1]
VALUES = ({a: 2, b: 3, c: 5, d: 7}, {a: sympy.Rational(9, 4), b: sympy.Rational(1, 3), c: 1, d: sympy.Rational(1, 5)})


def in_K(expression):
    return element(K, sympy.sympify(expression), "x")


@pytest.mark.parametrize("expression", POSITIVE, ids=str)
def test_signs_that_are_seen(expression):
    assert sign(K, in_K(expression)) == 1
    assert sign(K, in_K(-expression)) == -1
    assert sign(K, in_K(expression)) in (1, -1)


@pytest.mark.parametrize("expression", UNDECIDED, ids=str)
def test_signs_that_depend_on_the_values(expression):
    assert sign(K, in_K(expression)) is None
    assert sign(K, in_K(expression)) not in (1, -1)


coefficients = st.lists(st.integers(-3, 3), min_size=6, max_size=6)


@given(coefficients)
def test_a_sign_that_is_seen_is_that_of_every_value(numbers):
    terms = [a**2, a * b, b**2, a * c, b * c, c**2]
    expression = sum(n * term for n, term in zip(numbers, terms))
    found = sign(K, in_K(expression))
    if found is not None:
        values = [sympy.sign(sympy.sympify(expression).subs({a: x, b: y, c: z})) for x in (1, 7) for y in (1, 5) for z in (1, 9)]
        assert set(values) <= {found}


@given(st.integers(-9, 9), st.integers(-9, 9), st.sampled_from([2, 3, 5]))
def test_sign_with_a_root(u, v, g):
    exact = sympy.sign(u + v * sympy.sqrt(g))
    assert sign_with_root(sympy.QQ, sympy.QQ(u), sympy.QQ(v), sympy.QQ(g)) == exact


@pytest.mark.parametrize(
    "expression", [12, a, 5 * a**3 / b**2, (a - b) ** 2 * 8, -9 * a**2, (a**2 + b) ** 3 / c, sympy.Rational(5, 4)], ids=str
)
def test_square_roots(expression):
    value = in_K(expression)
    f, g = square_root(K, value)
    assert f**2 * g == value
    assert all(power == 1 for part in (K.numer(g), K.denom(g)) for _, power in part.factor_list()[1])
    assert sympy.simplify(root_expression(K, value) ** 2 - expression) == 0


def test_surds_are_a_field_extension():
    one = Surd(sympy.QQ, sympy.QQ(1), sympy.QQ(2), sympy.QQ(3))
    two = Surd(sympy.QQ, sympy.QQ(-4), sympy.QQ(1), sympy.QQ(3))
    assert sympy.expand(compact_expression(one * two) - compact_expression(one) * compact_expression(two)) == 0
    assert compact_expression(one - two + (-one)) == compact_expression(-two)


POLYNOMIALS = [
    s - a / b,
    s**2 + a / b,
    s**2 - a / b,
    a * s**2 + b * s + c,
    a * s**2 + 2 * b * s + b**2 / a + a,
    s**4 + 3 * a / b * s**2 + a**2 / b**2,
    (c * s**2 + a + b) * (d * s**2 + b) - b**2,
    s**4 + (a - b) * s**2 + c,
    (a * s**2 + 2 * b * s + 2 * c) ** 2 - 2 * (b * s + c) ** 2,
    *(s**4 + p * s**2 + q for p, q in [(0, 1), (0, -2), (0, 2), (-1, -1), (-5, 5), (5, 5), (-1, 3), (1, 2), (10, 1)]),
    (s**2 + s + 1) ** 2 - 2,
    (s**2 + s - 1) ** 2 - 2,
    s**2 + sympy.sqrt(2),
    s**2 + sympy.sqrt(2) * a,
]


@pytest.mark.parametrize("values", VALUES, ids=["values 1", "values 2"])
@pytest.mark.parametrize("expression", POLYNOMIALS, ids=str)
def test_zeros_and_what_polynomials_are_there(expression, values):
    expression = sympy.expand(expression)
    symbols = expression.free_symbols - {s}
    field = field_of([*symbols, *(x for x in [sympy.sqrt(2)] if expression.has(x))] or [sympy.Integer(1)])
    p = sympy.Poly(expression, s, domain=field).monic()
    found = roots(p)
    assert sum(2 if root.is_pair else 1 for root in found) == p.degree()
    e = sympy.Poly(3 * s**3 + 7 * s**2 - s + 3, s, domain=field)
    with mpmath.workdps(DIGITS + 20):
        zeros = []
        for root in found:
            zero = at(root.value, values)
            zeros += [zero, mpmath.conj(zero)] if root.is_pair else [zero]
            assert not root.is_pair or mpmath.im(zero) > 0
            real, imaginary = root.at(e)
            assert close(at(real, values) + 1j * at(imaginary, values), at(e.as_expr().subs(s, sympy.Symbol("z")), values, zero))
        monic = [at(coefficient, values) for coefficient in p.all_coeffs()]
        assert all(close(one, two) for one, two in zip(from_zeros(zeros), monic))


def at(expression, values, z=None):
    if z is not None:
        return mpmath.polyval([at(c, values) for c in sympy.Poly(expression, sympy.Symbol("z")).all_coeffs()], z)
    return mpmath.mpmathify(sympy.N(sympy.sympify(expression).subs(values), DIGITS + 20))


def from_zeros(zeros):
    product = [mpmath.mpf(1)]
    for zero in zeros:
        product = [x - zero * y for x, y in zip([*product, 0], [0, *product])]
    return product


def close(one, two) -> bool:
    return abs(one - two) <= mpmath.mpf(10) ** -DIGITS * (1 + abs(two))


@pytest.mark.parametrize("expression", [s**3 - a, s**6 + a * s**4 + b, s**4 + a * s + 1], ids=str)
@pytest.mark.parametrize("split", [True, False])
def test_no_short_closed_form(expression, split):
    assert roots(sympy.Poly(expression, s, domain=field_of([*expression.free_symbols - {s}])), split) is None


def test_pairs_where_it_depends_on_the_symbols():
    """As two zeros, or as one pair of which the imaginary part may be the root of a negative number."""
    p = sympy.Poly(s**2 + a * s + b, s, domain=field_of([a, b]))
    one, two = roots(p)
    (pair,) = roots(p, split=False)
    assert pair.is_pair and not one.is_pair and not two.is_pair
    assert sympy.expand(pair.real - (one.real + two.real) / 2) == 0
    assert sympy.expand(pair.imaginary**2 + (one.real - two.real) ** 2 / 4) == 0


CERTAINLY_COMPLEX = [s**4 + a * s**2 + 3 * a**2, s**4 + 4 * s**3 + (6 + a) * s**2 + (4 + 2 * a) * s + 1 + a + 3 * a**2]


@pytest.mark.parametrize("expression", CERTAINLY_COMPLEX, ids=str)
@pytest.mark.parametrize("split", [True, False])
def test_parts_are_real_where_no_zero_is(expression, split):
    p = sympy.Poly(expression, s, domain=field_of([a]))
    for root in roots(p, split):
        assert root.is_pair
        for part in (root.real, root.imaginary, *root.at(p.diff())):
            assert sympy.im(at(part, {a: sympy.Rational(2, 7)})) == 0 and not part.has(sympy.I)


@given(st.lists(st.integers(-4, 4), min_size=4, max_size=4))
def test_quartics_in_numbers(numbers):
    """Real, complex, in radicals or as decimals: of each pair the zero above the real axis, and what a polynomial is there."""
    p = sympy.Poly([1, *numbers], s, domain=sympy.QQ)
    if not p.is_irreducible:
        return
    found, e = roots(p), sympy.Poly(5 * s**3 - s + 2, s, domain=sympy.QQ)
    zeros = [at(root.value, {}) for root in found]
    zeros += [mpmath.conj(zero) for zero, root in zip(zeros, found) if root.is_pair]
    with mpmath.workdps(DIGITS):
        exact = [mpmath.mpmathify(zero) for zero in p.nroots(n=DIGITS, maxsteps=500)]
        assert len(zeros) == 4
        for root, zero in zip(found, zeros):
            assert min(abs(zero - other) for other in exact) < mpmath.mpf(10) ** -28
            assert mpmath.im(zero) > 0 if root.is_pair else mpmath.im(zero) == 0
            real, imaginary = (at(part, {}) for part in root.at(e))
            assert abs(real + 1j * imaginary - (5 * zero**3 - zero + 2)) < mpmath.mpf(10) ** -26 * (1 + abs(zero) ** 3)


@pytest.mark.parametrize(
    "expression", [s - a, (s - a) * (b * s + c), s**2 + a * s + b, (s**2 + a) ** 2 * (s - 1), sympy.Integer(3)], ids=str
)
@pytest.mark.parametrize("modulus", [s**3, (s**2 + c) ** 2], ids=str)
def test_inverses_modulo_a_polynomial(expression, modulus):
    unit, modulus = (sympy.Poly(sympy.expand(e), s, domain=K) for e in (expression, modulus))
    assert (unit * inverse_modulo(unit, modulus)).rem(modulus).as_expr() == 1
