"""Polynomials over the rationals: the common factor, and Laurent series at infinity."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.control.rational import ONE, RationalFunction, laurent, trimmed

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


@given(polynomials, polynomials)
def test_a_laurent_series_times_the_denominator_is_the_numerator(b, a):
    count = len(b) + len(a) + 3
    series = laurent(b, a, count)
    for k in range(count):  # the coefficient of s^(m - k)
        total = sum(a[len(a) - 1 - i] * series[k - i] for i in range(min(k + 1, len(a))))
        assert total == (b[len(b) - 1 - k] if k < len(b) else 0)
