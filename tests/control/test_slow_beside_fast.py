"""Slow or growing modes whose share is tiny beside that of a fast one, at times when nothing else is left."""

from __future__ import annotations

from fractions import Fraction

import pytest

import mbconstrained as mb
from tests.oracles.transfer import factors, multiplied, residues

CASES = [  # poles, zeros at 0, gamma, t
    ([Fraction(-(10**7)), Fraction(1, 2)], 2, 0, 40.0),
    ([Fraction(-1000), Fraction(-1, 4)], 3, -2, 5.0),
    ([Fraction(-(10**4)), Fraction(1, 2)], 3, -1, 20.0),
    ([Fraction(-(10**4)), Fraction(-1, 4)], 3, -2, 10.0),
    ([Fraction(-(10**6)), Fraction(-1)], 0, -5, 1.0),
    ([Fraction(-(10**5)), Fraction(-1)], 0, -6, 1.0),
    ([Fraction(-(10**8)), Fraction(-1, 2**30)], 1, 0, 1000.0),
]


@pytest.mark.parametrize("poles, zeros, gamma, time", CASES)
def test_what_is_left_of_slow_modes_has_all_digits(poles, zeros, gamma, time):
    a = multiplied(*factors(poles))
    y = mb.transfer_function_response([1, *[0] * zeros], a[::-1], gamma)
    known = residues([Fraction(0)] * zeros + [Fraction(1)], poles, gamma, time, digits=120)
    assert y(time)[0] == pytest.approx(known, rel=1e-12)
    assert y.error_estimate([time]) < 1e-9
