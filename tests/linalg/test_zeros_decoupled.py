"""The coupling between zeros at 0 and slow ones beside fast ones, in precise arithmetic."""

from __future__ import annotations

from fractions import Fraction

import pytest

import mbconstrained as mb
from mbconstrained.control.matrix_fraction import scalar_matrix
from tests.oracles.transfer import factors, multiplied, residues


@pytest.mark.parametrize("time", [10.0, 20.0, 40.0])
def test_rows_that_stay_coupled_to_zeros_at_zero_see_those_that_do_not(time):
    poles = [Fraction(0)] * 4 + [Fraction(1, 4)] * 3 + [Fraction(-2)] * 3
    x = mb.solve(scalar_matrix(tuple(multiplied(*factors(poles))), False), force=mb.impulse([1.0]))
    known = float(residues([Fraction(1)], poles, 0, time))
    assert x(time)[0] == pytest.approx(known, rel=1e-12)
