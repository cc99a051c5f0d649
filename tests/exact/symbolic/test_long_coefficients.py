"""Models whose local Smith forms and Taylor coefficients have long units: inverses modulo powers, sums over one denominator."""

from itertools import islice

import pytest
import sympy

from mbconstrained.exact.engine import series_at_infinity
from mbconstrained.exact.symbolic.fields import element, field_of
from mbconstrained.exact.symbolic.radicals import combination
from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix, SymbolicRing, inverse_modulo
from mbconstrained.exact.symbolic.symbolic_response import solve_symbolically
from tests.exact.symbolic.gallery import s
from tests.exact.symbolic.models import c, c1, c2, k1, k2

a, b, m1, m2 = sympy.symbols("a b m1 m2", positive=True)
DAMPED_LINK = SymbolicPolynomialMatrix(
    [[[k1, 0, -1], [0, k2, 1], [1, -1, 0]], [[c1, 0, 0], [0, c2, 0], [0, 0, 0]], [[m1, 0, 0], [0, m2, 0], [0, 0, 0]]]
)
VALUES = {c1: sympy.Rational(2, 3), c2: 5, k1: sympy.Rational(7, 4), k2: 11, m1: 3, m2: sympy.Rational(13, 6)}


def test_a_rigid_link_with_damping():
    """One body of mass m1 + m2, and a multiplier that follows its acceleration: the infinite elementary divisor is of order 4."""
    pairs = DAMPED_LINK.jordan_pairs()
    assert pairs.structure.infinite_divisors == (0, 0, 4)
    assert pairs.infinite.lengths == (3,)
    assert [sympy.expand(e) for e in pairs.assumptions] == [sympy.expand((c1 + c2) ** 2 - 4 * (k1 + k2) * (m1 + m2))]
    (divisor,) = pairs.structure.elementary_divisors
    assert sympy.cancel(divisor.polynomial.as_expr() - s**2 - ((c1 + c2) * s + k1 + k2) / (m1 + m2)) == 0


def test_both_pairs_of_it_are_its_inverse():
    pairs, z = DAMPED_LINK.jordan_pairs(), sympy.Rational(17, 5)
    finite = pairs.rational.C * (z * sympy.eye(2) - pairs.rational.J).inv() * pairs.rational.B
    infinite = pairs.infinite.C * (sympy.eye(3) - z * pairs.infinite.J).inv() * pairs.infinite.B
    assert (finite + infinite).subs(VALUES) == DAMPED_LINK(z).subs(VALUES).inv()


@pytest.mark.long
def test_chains_of_a_quartic_with_long_coefficients():
    """A(s) v_0 vanishes where p does, and so does b_0^T A(s)."""
    A = SymbolicPolynomialMatrix([[[0, 1], [c / a, 0]], [[a - b, b], [c / a, a]], [[-a, 1], [-a, b]]])
    (chain,) = A.jordan_pairs().chains
    assert (chain.polynomial.degree(), chain.length) == (4, 1)
    for vector, rows in ((chain.right[0], A.polynomials), (chain.left[0], list(zip(*A.polynomials)))):
        for row in rows:
            assert sum((e * v for e, v in zip(row, vector)), 0 * vector[0]).rem(chain.polynomial).is_zero


@pytest.mark.long
def test_damping_in_proportion():
    """Against the response of the same system with numbers in it, factors of det A being other ones there."""
    M, K = sympy.diag(m1, 2 * m1), sympy.Matrix([[k1 + k2, -k2], [-k2, k2]])
    matrices = [K, c * M + c1 * K, M]
    x = solve_symbolically(SymbolicPolynomialMatrix(matrices), [[1, 2], [-1, 3]])
    assert not x.regular.has(sympy.I)
    values = {**VALUES, c: sympy.Rational(1, 7), c1: sympy.Rational(1, 9)}
    known = solve_symbolically(SymbolicPolynomialMatrix([matrix.subs(values) for matrix in matrices]), x.initial)
    difference = (x.regular.subs(values) - known.regular).subs(x.time, sympy.Rational(5, 4))
    assert all(abs(sympy.N(e, 30)) < 1e-25 for e in difference)


K = field_of([a, b])
SUMS = {
    "nothing": [],
    "zeros": [(0, a), (b, 0)],
    "whole": [(1, 2), (3, 4)],
    "one denominator": [(1 / a, b), (b / a, a + b)],
    "several": [(1 / (a + b), a / b), (b / (a - b), 1 / (a + b)), (-1, a)],
    "cancelling": [(1 / a, b), (-b, 1 / a)],
}


@pytest.mark.parametrize("name", SUMS)
def test_sums_over_one_denominator(name):
    pairs = [tuple(element(K, sympy.sympify(e), "x") for e in pair) for pair in SUMS[name]]
    assert combination(K, [one for one, _ in pairs], [other for _, other in pairs]) == sum((x * y for x, y in pairs), K.zero)


@pytest.mark.parametrize("unit", [s + a, (a - b) * s**2 + s - 1 / b, s**5 + a * s + a + b, sympy.S.One], ids=str)
@pytest.mark.parametrize("count", [1, 2, 5])
def test_inverse_power_series(unit, count):
    unit, modulus = sympy.Poly(unit, s, domain=K), sympy.Poly(s**count, s, domain=K)
    inverse = inverse_modulo(unit, modulus)
    assert inverse.degree() < count and (unit * inverse).rem(modulus).is_one


@pytest.mark.parametrize("above", [sympy.S.Zero, s - a, s**4 + b * s, s**2 / a], ids=str)
def test_series_at_infinity_times_the_denominator(above):
    below = sympy.Poly((a + 1) * s**2 + b * s - 3, s, domain=K)
    numerator = sympy.Poly(above, s, domain=K)
    highest = max(numerator.degree() - below.degree(), -4)
    terms = islice(series_at_infinity(SymbolicRing.of(below), numerator, below, highest), highest + 5)
    series = sympy.Poly(list(terms), s, domain=K)
    assert (series * below - numerator * s**4).degree() < below.degree()
