"""Precise arrays: what float64 rounds away is kept."""

from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.linalg.precise import (
    floats,
    inverse,
    magnitude,
    power_of_two,
    precise,
    precise_arithmetic,
    product,
    solved,
    zero_multiplicity,
)
from mbconstrained.linalg.rank import Noisy, compress_rows


def exact(value) -> Fraction:
    """The midpoint of a precise number."""
    mantissa, exponent = value.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


@given(st.integers(0, 10**6), st.integers(1, 5))
def test_inverse_of_an_ill_conditioned_matrix(seed, size):
    """A A^-1 = I to the last digits but those that a condition of 1e40 takes; float64 knows nothing of this inverse."""
    random = np.random.default_rng(seed)
    with precise_arithmetic():
        graded = power_of_two(-30.0 * np.arange(size))
        mixing = precise(random.integers(-9, 10, (size, size)) + 40.0 * np.eye(size))
        A = product(mixing * graded, mixing.T)
        assert magnitude(product(A, inverse(A)) - precise(np.eye(size))).max() < 1e-25
        assert magnitude(solved(A, product(A, mixing)) - mixing).max() < 1e-25


def test_a_singular_matrix_is_refused():
    with precise_arithmetic(), pytest.raises(np.linalg.LinAlgError):
        inverse(precise(np.array([[1.0, 2.0], [2.0, 4.0]])))


def test_rank_of_what_float64_cannot_tell_apart():
    """Rows (1e16 + 1, 1e16) and (1e16, 1e16 - 1) have the determinant -1, all lost in float64."""
    big = Fraction(10**16)
    with precise_arithmetic():
        exact = precise(np.array([[big + 1, big], [big, big - 1]], dtype=object))
        assert compress_rows(Noisy.exact(exact)).decision.rank == 2
    assert compress_rows(Noisy.rounded(floats(exact))).decision.rank == 1


def test_null_combinations_are_precise():
    """The combination of dependent rows that vanishes is found to all digits."""
    with precise_arithmetic():
        rows = precise(np.array([[Fraction(1), Fraction(1, 3)], [Fraction(3), Fraction(1)]], dtype=object))
        found = compress_rows(Noisy(rows, 1e-60 * magnitude(rows)))
        assert found.decision.rank == 1
        assert magnitude(product(found.null.data, rows)).max() < 1e-60


@given(st.integers(1, 4), st.integers(0, 10**6))
def test_zeros_at_zero_are_those_of_the_determinant(size, seed):
    """Counted modulo a prime."""
    random = np.random.default_rng(seed)
    E, F = random.integers(-1, 2, (2, size, size)) / 8.0
    s = sympy.Symbol("s")
    determinant = sympy.Poly((s * sympy.Matrix(E.astype(str)) - sympy.Matrix(F.astype(str))).applyfunc(sympy.nsimplify).det(), s)
    if not determinant.is_zero:
        assert zero_multiplicity(E, F) == min(power for (power,) in determinant.monoms())
