"""Many steps at once against one after the other, in fractions where the data are such."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from mbconstrained.linalg.recursion import scanned, values_of_steps


def one_by_one(output, step, drive, start, inputs):
    """In fractions, rounded once."""
    exact = [np.array([[Fraction(x) for x in row] for row in np.atleast_2d(part)]) for part in (output, step, drive, inputs)]
    output, step, drive, inputs = exact
    z, found = np.array([Fraction(x) for x in start]), []
    for v in inputs.T:
        found.append(output @ z)
        z = step @ z + drive @ v
    return np.array([*found, output @ z], dtype=float).T


@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.integers(0, 3), st.integers(0, 40), st.booleans())
def test_it_is_one_step_after_the_other(seed, rows, driven, count, sparse):
    random = np.random.default_rng(seed)
    step = np.linalg.qr(random.normal(size=(4, 4)))[0]
    drive, start, inputs = random.normal(size=(4, driven)), random.normal(size=4), random.normal(size=(driven, count))
    output = np.round(random.normal(size=(rows, 4)))
    known = one_by_one(output, step, drive, start, inputs) if count and driven else None
    found = values_of_steps(csr_array(output) if sparse else output, step, drive, start, inputs)
    assert found.shape == (rows, count + 1)
    if known is not None:
        assert np.allclose(found, known, rtol=0, atol=1e-13 * (1 + np.abs(known).max()))


@given(st.integers(0, 2**32 - 1), st.integers(0, 60), st.booleans())
def test_scalars_side_by_side(seed, count, same):
    random = np.random.default_rng(seed)
    factors = np.exp(1j * random.normal(size=(1 if same else max(count, 1), 3)))
    states = random.normal(size=(count + 1, 3)) + 1j * random.normal(size=(count + 1, 3))
    known = [states[0]]
    for j in range(count):
        known.append(factors[j % len(factors)] * known[-1] + states[j + 1])
    scanned(states, factors)
    assert np.allclose(states, known, rtol=0, atol=1e-12)
