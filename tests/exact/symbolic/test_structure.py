"""Structures known beforehand, and those of random matrices against minors in rational arithmetic."""

from fractions import Fraction

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
from tests.exact.symbolic.gallery import PRODUCTS, from_polynomials, s
from tests.exact.symbolic.models import k, m
from tests.oracles import exact
from tests.oracles.smith import partial_multiplicities

DIVISORS = {
    "rational, derogatory": [1, s - k, (s - k) ** 3],
    "zero and a ratio": [s, s * (s + k / m), s**2 * (s + k / m) ** 2],
    "complex pair, twice": [1, s**2 + k / m, (s**2 + k / m) ** 2],
    "damped pair": [1, 1, (s**2 + 2 * s / m + k / m) ** 2],
    "quartic in squares": [1, 1, (s**4 + 3 * k / m * s**2 + k**2 / m**2) ** 2],
    "cubic": [1, s**3 - k, (s**3 - k) ** 2],
    "numbers": [1, s**2 - 2, (s**2 - 2) * (s**2 + s + 1) ** 2],
    "no zeros": [1, 1, 1],
}


@pytest.mark.parametrize("name", PRODUCTS)
def test_smith_form_of_products(name):
    form = PRODUCTS[name].smith_form()
    assert form.is_diagonal()
    assert [sympy.cancel(form[i, i] - expected) for i, expected in enumerate(DIVISORS[name])] == [0, 0, 0]


def test_elementary_divisors_and_zeros():
    structure = PRODUCTS["zero and a ratio"].structure()
    assert [(d.polynomial.as_expr(), d.exponents, d.multiplicity) for d in structure.elementary_divisors] == [
        (s, (1, 1, 2), 4),
        (s + k / m, (1, 2), 3),
    ]
    assert [(z.value, z.multiplicity, z.partial_multiplicities, z.count) for z in structure.finite_zeros] == [
        (0, 4, (1, 1, 2), 4),
        (-k / m, 3, (1, 2), 3),
    ]
    assert structure.notices == ()


def test_zeros_without_a_closed_form_are_elementary_divisors_only():
    structure = PRODUCTS["cubic"].structure()
    assert structure.finite_zeros == ()
    assert [(d.polynomial.as_expr(), d.exponents) for d in structure.elementary_divisors] == [(s**3 - k, (1, 2))]


def test_zeros_that_may_coincide_are_an_assumption():
    A = from_polynomials(sympy.diag(s + k, s + m))
    assert A.structure().assumptions == (k - m,)
    assert A.structure().elementary_divisors[0].exponents == (1,)
    same = from_polynomials(sympy.diag(s + k, s + k))
    assert same.structure().elementary_divisors[0].exponents == (1, 1)
    assert same.structure().assumptions == ()


def test_a_leading_coefficient_that_may_vanish_is_an_assumption():
    A = from_polynomials(sympy.Matrix([[(k - m) * s + 1]]))
    assert A.assumptions == (k - m,)
    assert A.structure().finite_count == 1


def test_a_pivot_at_infinity_that_may_vanish_is_an_assumption():
    """[[s, k - m], [1, 0]]: the order of the zero at infinity rests on k - m."""
    A = from_polynomials(sympy.Matrix([[s, k - m], [1, 0]]))
    assert A.assumptions == (k - m,)
    assert A.structure().at_infinity == (1, -1)


entries = st.integers(-2, 2)


def matrices(size, degree):
    return st.lists(
        st.lists(st.lists(entries, min_size=size, max_size=size), min_size=size, max_size=size),
        min_size=degree + 1,
        max_size=degree + 1,
    )


@given(st.integers(1, 3).flatmap(lambda r: st.integers(0, 2).flatmap(lambda q: matrices(r, q))))
def test_against_minors_in_rational_arithmetic(matrices):
    A, known = SymbolicPolynomialMatrix(matrices), exact.rational(matrices)
    if not exact.determinant(known):
        with pytest.raises(mb.SingularPolynomialMatrix):
            A.structure()
        return
    assert [Fraction(int(c.p), int(c.q)) for c in A.determinant.all_coeffs()][::-1] == exact.determinant(known)
    structure, pairs = A.structure(), A.jordan_pairs()
    assert list(structure.at_infinity) == exact.orders_at_infinity(known)
    for index, H in exact.laurent(known, -4).items():
        expected = sympy.Matrix([[sympy.Rational(x.numerator, x.denominator) for x in row] for row in H])
        assert pairs.laurent(index) == expected
        if index < 0:
            assert pairs.rational.C * pairs.rational.J ** (-1 - index) * pairs.rational.B == expected
        else:
            assert pairs.infinite.C * pairs.infinite.J**index * pairs.infinite.B == expected
    assert all(len(d.exponents) <= A.size for d in structure.elementary_divisors)


def test_partial_multiplicities_from_ranks():
    """The elementary divisors of s from the ranks of block Toeplitz matrices of A_0, A_1, ... at numbers for the symbols."""
    A = PRODUCTS["zero and a ratio"]
    numbers = [[[Fraction(str(entry.subs({k: 7, m: 3}))) for entry in row] for row in M.tolist()] for M in A.coefficients]
    assert partial_multiplicities(numbers, 0j, 4) == [e for e in A.local_smith_form(0).exponents if e]
