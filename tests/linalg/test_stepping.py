"""Many steps at once against one after the other, in fractions where the data are such."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from mbconstrained.linalg.recursion import best_length, powers, scanned, values_of_steps


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


def test_unused_states_are_not_made_and_the_values_are_the_same():
    random = np.random.default_rng(0)
    step, drive = 0.2 * random.normal(size=(9, 9)), random.normal(size=(9, 2))
    start, inputs = random.normal(size=9), random.normal(size=(2, 50))
    output = np.zeros((40, 9))
    output[:, 3] = random.normal(size=40)
    found = values_of_steps(csr_array(output), step, drive, start, inputs)
    assert np.allclose(found, output @ values_of_steps(np.eye(9), step, drive, start, inputs), rtol=0, atol=1e-13)


@pytest.mark.parametrize("rows, states, driven, count", [(1, 1, 1, 1), (3, 5, 0, 2), (200, 200, 2, 10**5)])
def test_the_length_of_a_group_is_a_power_of_two(rows, states, driven, count):
    length = best_length(rows, states, driven, count)
    assert length >= 1 and length & (length - 1) == 0


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


@pytest.mark.parametrize("count", [1, 2, 3, 8, 13])
def test_powers_are_powers(count):
    values = np.array([-1.0, 0.0, 0.5, 1.0])
    assert np.array_equal(powers(values, count), values[:, None] ** np.arange(count))
