"""Polynomials over the rationals: the ring's laws, division and the greatest common divisor."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbconstrained.response.transfer.polynomials import ONE, PRIME, common_factor, divided, laurent, product, trimmed

rationals = st.fractions(min_value=-20, max_value=20, max_denominator=12)
polynomials = st.lists(rationals, min_size=1, max_size=6).map(trimmed).filter(bool)


@settings(max_examples=60, deadline=None)
@given(polynomials, polynomials)
def test_division_with_remainder(one, two):
    quotient, rest = divided(one, two)
    total = list(product(quotient, two)) + [Fraction(0)] * len(one)
    for k, c in enumerate(rest):
        total[k] += c
    assert trimmed(total) == one and len(rest) < len(two)


@settings(max_examples=60, deadline=None)
@given(polynomials, polynomials, polynomials)
def test_a_common_factor_divides_both_and_nothing_is_left(p, q, r):
    found = common_factor(product(p, q), product(p, r))
    assert found[-1] == 1
    assert divided(found, p)[1] == ()  # p divides it
    quotients = [divided(product(p, other), found) for other in (q, r)]
    assert [rest for _, rest in quotients] == [(), ()]
    assert common_factor(quotients[0][0], quotients[1][0]) == ONE


def test_a_common_factor_only_modulo_the_prime_is_none():
    """s and s - p are the same modulo p."""
    assert common_factor((Fraction(0), Fraction(1)), (Fraction(-PRIME), Fraction(1))) == ONE


def test_a_highest_coefficient_that_is_a_multiple_of_the_prime():
    one = product((Fraction(1), Fraction(PRIME)), (Fraction(1), Fraction(1)))
    two = product((Fraction(1), Fraction(PRIME)), (Fraction(2), Fraction(1)))
    assert common_factor(one, two) == (Fraction(1, PRIME), Fraction(1))


@settings(max_examples=40, deadline=None)
@given(polynomials, polynomials)
def test_a_laurent_series_times_the_denominator_is_the_numerator(b, a):
    count = len(b) + len(a) + 3
    series = laurent(b, a, count)
    for k in range(count):  # the coefficient of s^(m - k)
        total = sum(a[len(a) - 1 - i] * series[k - i] for i in range(min(k + 1, len(a))))
        assert total == (b[len(b) - 1 - k] if k < len(b) else 0)


@pytest.mark.parametrize("degree", [0, 1, 60])
def test_polynomials_of_any_degree_are_relatively_prime_at_once(degree):
    one = tuple(Fraction(k + 1, 7) for k in range(degree + 1))
    assert common_factor(one, (*one[:-1], one[-1] + 1)) == ONE
