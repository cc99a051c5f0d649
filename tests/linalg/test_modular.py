"""Modulo a prime: the multiplicity of the zero at s = 0 is that of the rational numbers."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.linalg.precise import PRIME, remainders, zero_multiplicity

seeds = st.integers(0, 10**6)


def test_the_prime_is_the_largest_that_is_wanted():
    assert sympy.prevprime(2**63) == PRIME


@pytest.mark.parametrize("value", [0.0, 1.0, -1.5, 0.1, 1e300, -1e-300, 5e-324, Fraction(3, 8), 10**30])
def test_a_remainder_is_what_it_stands_for(value):
    exact, found = Fraction(value), int(remainders(np.array([value], dtype=object))[0])
    assert 0 <= found < PRIME
    assert (found * exact.denominator - exact.numerator) % PRIME == 0


@given(st.integers(1, 4), seeds)
def test_zeros_at_zero_are_those_of_the_determinant(size, seed):
    random = np.random.default_rng(seed)
    E, F = random.integers(-1, 2, (2, size, size)) / 8.0
    s = sympy.Symbol("s")
    determinant = sympy.Poly((s * sympy.Matrix(E.astype(str)) - sympy.Matrix(F.astype(str))).applyfunc(sympy.nsimplify).det(), s)
    if not determinant.is_zero:
        assert zero_multiplicity(E, F) == min(power for (power,) in determinant.monoms())


def test_no_equations():
    assert zero_multiplicity(np.zeros((0, 0)), np.zeros((0, 0))) == 0


def test_a_long_chain_is_followed_to_its_end():
    assert zero_multiplicity(np.eye(5), np.eye(5, k=1)) == 5
    assert zero_multiplicity(np.eye(5, k=1), np.eye(5)) == 0
