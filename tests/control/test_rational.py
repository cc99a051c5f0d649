"""What is read: numbers of many kinds, exactly; what cannot be used, told in plain words."""

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.control.rational import ONE, RationalFunction, rational_function, trimmed


@pytest.mark.parametrize(
    "numerator, denominator, words",
    [
        ([], [1.0], "numerator: found no coefficient"),
        ([1.0], [], "denominator: found no coefficient"),
        ([1.0], [0.0, 0.0], "denominator: every coefficient is zero"),
        ([1.0], 0, "denominator: every coefficient is zero"),
        ([np.nan], [1.0], "numerator: the coefficient at 0 is nan; expected a finite number"),
        ([1.0], [1.0, np.inf], "denominator: the coefficient at 1 is inf"),
        ([1.0, 2j], [1.0], "numerator: the coefficient at 1 is 2j; expected its coefficients as a list of real numbers"),
        ("12", [1.0], "numerator: found '12'"),
        (None, [1.0], "numerator: found None"),
        ([1.0, "2"], [1.0], "numerator: the coefficient at 1 is '2'"),
        ([True], [1.0], "numerator: the coefficient at 0 is True"),
        ({1.0: 2.0}, [1.0], "numerator: found {1.0: 2.0}"),
        ([[1.0], [2.0]], [1.0], "several inputs or outputs use mb.matrix_fraction_response"),
        (np.eye(2), [1.0], "several inputs or outputs use mb.matrix_fraction_response"),
        ([10**400], [1.0], "expected a finite number in the range of float64"),
        ([Fraction(1, 10**400)], [1.0], "lies below the range of float64"),
        ([Decimal("NaN")], [1.0], "expected a finite number"),
    ],
)
def test_what_cannot_be_used_is_told(numerator, denominator, words):
    with pytest.raises(mb.InputError) as error:
        mb.transfer_function_response(numerator, denominator)
    assert words in str(error.value)


@pytest.mark.parametrize("gamma", [1.5, True, "2", None, [1], 10**6, mb.zero(2)])
def test_an_input_that_is_none_is_refused(gamma):
    with pytest.raises(mb.InputError, match="gamma"):
        mb.transfer_function_response([1.0], [1.0, 1.0], gamma)


@pytest.mark.parametrize(
    "half", [0.5, Fraction(1, 2), Decimal("0.5"), np.float64(0.5), np.float32(0.5), sympy.Rational(1, 2), np.array(0.5)]
)
def test_numbers_of_all_kinds_are_taken_exactly(half):
    found = rational_function([half], [np.int64(1), half])
    assert found.numerator == (Fraction(1, 2),) and found.denominator == (Fraction(1, 2), Fraction(1))
    assert all(type(c) is Fraction for c in (*found.numerator, *found.denominator))


def test_only_floats_are_known_to_a_rounding():
    assert rational_function([0.1], [1]).rounded
    assert not rational_function([1.0, 2.0], [Fraction(1, 3), Decimal("0.1"), 3]).rounded


def test_leading_zeros_are_left_out_and_told():
    y = mb.transfer_function_response([0, 0, 1], [0.0, 1, 2])
    assert y.numerator == (1,) and y.denominator == (1, 2)
    assert [n.text for n in y.notices] == ["numerator: 2 leading zeros left out", "denominator: 1 leading zero left out"]
    assert not any(n.doubtful for n in y.notices)


def test_a_zero_numerator_is_zero_whatever_the_poles():
    y = mb.transfer_function_response([0, 0], [1, -1], 2)
    assert y([0.0, 1.0, 100.0]).tolist() == [[0.0, 0.0, 0.0]] and y.impulses == () and y.numerator == (0,)


def test_a_common_factor_is_told_once_and_kept_in_what_was_given():
    y = mb.transfer_function_response([1, -1], [1, 1, -2])
    assert y.common_factor == (1, -1) and y.denominator == (1, 1, -2)
    assert [zero.value for zero in y.pairs.finite.zeros] == [-2]
    (notice,) = (n for n in y.notices if n.kind == "omitted")
    assert notice.text == "numerator and denominator have the common factor s - 1: it does not act on a response from rest"


@pytest.mark.parametrize(
    ("factor", "grows"),
    [([1, -1], "s - 1"), ([1, -2, 5], "s^2 - 2 s + 5"), ([1, 1], ""), ([1, 0], ""), ([1, 0, 4], ""), ([1, 2, 1], "")],
)
def test_a_growing_common_factor_is_told(factor, grows):
    y = mb.transfer_function_response(factor, np.polymul(factor, [1, 2]).tolist())
    told = [n.text for n in y.notices if n.kind == "unstable"]
    text = "has a zero in the right half plane: from any start but rest that motion grows"
    assert told == ([f"the common factor {grows} {text}"] if grows else [])


def test_decimals_have_the_common_factor_that_they_are_written_with():
    """(s - 0.1) in (s - 0.1)(s + 0.3): as binary numbers the coefficients have none."""
    y = mb.transfer_function_response([1, -0.1], [1, 0.2, -0.03])
    assert y.common_factor == (1, Fraction(-1, 10))
    assert y(600.0)[0] == pytest.approx((1 - np.exp(-180)) / 0.3, rel=1e-15)


def test_binary_numbers_have_the_common_factor_that_they_are():
    """1/64^3 needs more digits than its shortest decimal has."""
    small = 1 / 64
    y = mb.transfer_function_response([1, -small], np.polymul([1, -small], np.polymul([1, small], [1, small / 4])))
    assert y.common_factor == (1, Fraction(-1, 64))


rationals = st.fractions(min_value=-20, max_value=20, max_denominator=12)
polynomials = st.lists(rationals, min_size=1, max_size=6).map(trimmed).filter(bool)


def product(one, two):
    return tuple(np.convolve(np.array(one, dtype=object), np.array(two, dtype=object)))


@given(polynomials, polynomials, polynomials)
def test_a_common_factor_divides_both_and_the_quotients_have_none(p, q, r):
    fraction = RationalFunction(product(p, q), product(p, r))
    factor, reduced = fraction.common_factor, fraction.reduced
    assert factor[-1] == 1 and len(factor) >= len(p)
    assert [product(factor, each) for each in (reduced.numerator, reduced.denominator)] == [product(p, q), product(p, r)]
    assert reduced.common_factor == ONE
