"""What entries may be, and what they become."""

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
import sympy

import mbconstrained as mb
from mbconstrained.exact.symbolic.fields import element, exact_expression, field_of, sign
from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix

k, m = sympy.symbols("k m")


@pytest.mark.parametrize(
    "given, expected",
    [
        (1, 1),
        (0.1, sympy.Rational(1, 10)),
        (-2.5e-7, sympy.Rational(-1, 4000000)),
        (np.float64(0.3), sympy.Rational(3, 10)),
        (np.int64(4), 4),
        (Fraction(1, 3), sympy.Rational(1, 3)),
        (Decimal("0.25"), sympy.Rational(1, 4)),
        (sympy.Float(0.1), sympy.Rational(1, 10)),
        (sympy.Float("0.12345678901234567890123", 23), sympy.Rational(12345678901234567890123, 10**23)),
        (0.1 * k + m / 2, k / 10 + m / 2),
        (sympy.sqrt(2) * k, sympy.sqrt(2) * k),
    ],
)
def test_entries_are_exact(given, expected):
    assert exact_expression(given, "A_0") == expected


@pytest.mark.parametrize(
    "entry, found",
    [
        ("k", "'k'"),
        ("1", "'1'"),
        (True, "True"),
        (1j, "1j"),
        (None, "NoneType"),
        ([1], "list"),
        (sympy.Poly(k), "Poly"),
        (float("nan"), "nan"),
        (float("inf"), "inf"),
        (sympy.oo, "oo"),
        (sympy.nan, "nan"),
        (1 / (0 * k), "zoo"),
        (sympy.I * k, "I\\*k"),
        (sympy.sin(k), "sin\\(k\\)"),
        (1 + k * sympy.sqrt(m), "sqrt\\(m\\)"),
        (sympy.exp(k), "exp\\(k\\)"),
        (sympy.sqrt(sympy.pi) * k, "sqrt\\(pi\\)"),
        (sympy.E * k, "E"),
        (sympy.pi * sympy.Symbol("pi"), 'two different symbols are called "pi"'),
        (2**k, "2\\*\\*k"),
        (sympy.Integer(2) ** sympy.Rational(1, 3), "2\\*\\*\\(1/3\\)"),
        (sympy.Function("f")(k), "f\\(k\\)"),
        (1 / (k * (k + 1) - k**2 - k), "denominator"),
        (sympy.Symbol("s"), 'symbol "s" is the variable'),
        (sympy.Symbol("q", negative=True), "symbol q: .*not to be positive"),
        (sympy.Symbol("z", zero=True), "symbol z: .*not to be positive"),
        (sympy.Symbol("n", commutative=False), "symbol n"),
        (k + sympy.Symbol("k", positive=True), 'two different symbols are called "k"'),
        (sympy.sqrt(2) + sympy.sqrt(3) + sympy.sqrt(5), "3 square roots"),
    ],
    ids=str,
)
def test_other_entries_are_refused_with_what_was_found(entry, found):
    with pytest.raises(mb.InputError, match=found):
        SymbolicPolynomialMatrix([[[entry]]])


def test_pi_is_one_more_symbol_of_the_field_and_none_of_the_matrix():
    A = SymbolicPolynomialMatrix([[[4 * sympy.pi**2 * k]], [[1]]])
    assert A.symbols == (k,) and A.field.symbols == (k, sympy.pi)
    assert field_of([sympy.pi]).symbols == (sympy.pi,)


def test_signs_of_numbers_with_pi_are_known():
    K = field_of([sympy.pi, k])
    signs = [sign(K, element(K, e, "x")) for e in (sympy.pi - 3, 22 - 7 * sympy.pi, (3 - sympy.pi) * k, sympy.pi - k)]
    assert signs == [1, 1, -1, None]


def test_fields_are_the_smallest():
    assert field_of([sympy.Integer(1)]) == sympy.QQ
    assert field_of([k / m]) == sympy.ZZ.frac_field(k, m)
    assert field_of([sympy.sqrt(2)]).is_Algebraic
    assert field_of([sympy.sqrt(2) * k]).symbols == (k,)
