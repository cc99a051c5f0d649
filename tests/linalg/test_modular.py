"""Modulo a prime: the multiplicity of the zero at s = 0 is that of the rational numbers."""

import numpy as np
import sympy
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.linalg.precise import zero_multiplicity

seeds = st.integers(0, 10**6)


@given(st.integers(1, 4), seeds)
def test_zeros_at_zero_are_those_of_the_determinant(size, seed):
    random = np.random.default_rng(seed)
    E, F = random.integers(-1, 2, (2, size, size)) / 8.0
    s = sympy.Symbol("s")
    determinant = sympy.Poly((s * sympy.Matrix(E.astype(str)) - sympy.Matrix(F.astype(str))).applyfunc(sympy.nsimplify).det(), s)
    if not determinant.is_zero:
        assert zero_multiplicity(E, F) == min(power for (power,) in determinant.monoms())
