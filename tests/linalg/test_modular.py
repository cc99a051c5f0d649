"""Modulo a prime: ranks, null spaces and the zeros at s = 0 are those of the rational numbers."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.linalg.modular import PRIME, chains_at_zero, null_space, reduced_rows, remainders

seeds = st.integers(0, 10**6)


def test_the_prime_is_the_largest_that_is_wanted():
    assert sympy.prevprime(2**27) == PRIME


@pytest.mark.parametrize("value", [0.0, 1.0, -1.5, 0.1, 1e300, -1e-300, 5e-324, Fraction(3, 8), 10**30])
def test_a_remainder_is_what_it_stands_for(value):
    exact, found = Fraction(value), int(remainders(np.array([value], dtype=object))[0])
    assert 0 <= found < PRIME
    assert (found * exact.denominator - exact.numerator) % PRIME == 0


@pytest.mark.parametrize("shape", [(0, 0), (0, 3), (3, 0)])
def test_empty_matrices(shape):
    assert null_space(np.zeros(shape, dtype=np.int64)).shape == (shape[1], shape[1])


@given(st.integers(1, 6), st.integers(1, 6), seeds)
def test_rank_and_null_space(rows, columns, seed):
    random = np.random.default_rng(seed)
    inner = int(random.integers(0, 4))
    matrix = random.integers(-3, 4, (rows, inner)) @ random.integers(-3, 4, (inner, columns))
    image = remainders(matrix)
    null, rank = null_space(image), sympy.Matrix(matrix.tolist()).rank()
    assert len(reduced_rows(image)[1]) == rank and null.shape == (columns, columns - rank)
    assert not (image @ null % PRIME).any()


@given(st.integers(1, 4), seeds)
def test_zeros_at_zero_are_those_of_the_determinant(size, seed):
    random = np.random.default_rng(seed)
    E, F = random.integers(-1, 2, (2, size, size)) / 8.0
    s = sympy.Symbol("s")
    determinant = sympy.Poly((s * sympy.Matrix(E.astype(str)) - sympy.Matrix(F.astype(str))).applyfunc(sympy.nsimplify).det(), s)
    if not determinant.is_zero:
        assert chains_at_zero(E, F) == min(power for (power,) in determinant.monoms())


def test_a_long_chain_is_followed_to_its_end():
    assert chains_at_zero(np.eye(5), np.eye(5, k=1)) == 5
    assert chains_at_zero(np.eye(5, k=1), np.eye(5)) == 0
