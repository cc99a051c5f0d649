"""Units are taken out of the data by powers of two, and changing the units changes nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.linalg.scaling import equilibration, joint_scaling

exponents = st.integers(-60, 60)


def sample(seed=0, degree=2, size=3) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(degree + 1, size, size)).round(1)


def is_power_of_two(values) -> bool:
    return bool((np.frexp(np.atleast_1d(values))[0] == 0.5).all())


@given(st.integers(0, 20), exponents, st.lists(exponents, min_size=3, max_size=3), st.lists(exponents, min_size=3, max_size=3))
def test_scaled_coefficients_do_not_depend_on_units_of_powers_of_two(seed, time, rows, columns):
    A = sample(seed)
    changed = np.exp2(rows)[:, None] * A * np.exp2(columns) * np.exp2(time * np.arange(3.0))[:, None, None]
    one, other = joint_scaling(A).apply(A), joint_scaling(changed).apply(changed)
    # the least-squares exponents of both agree up to the rounding of a tie: factors of two at most
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(A == 0, 1.0, other / one)
    assert (ratio >= 2.0**-4).all() and (ratio <= 2.0**4).all()


def test_factors_are_powers_of_two_and_cost_no_rounding():
    A = sample() * 10.0 ** np.random.default_rng(1).integers(-20, 20, (3, 3, 3))
    scaling = joint_scaling(A)
    assert is_power_of_two(scaling.time) and is_power_of_two(scaling.rows) and is_power_of_two(scaling.columns)
    back = scaling.apply(A) / scaling.rows[:, None] / scaling.columns / (scaling.time ** np.arange(3.0))[:, None, None]
    assert np.array_equal(back, A)


def test_equilibration_brings_row_maxima_within_a_factor_of_two_of_one():
    size = 10.0 ** np.random.default_rng(2).uniform(-12, 12, (5, 4))
    rows, columns = equilibration(size)
    largest = (rows[:, None] * size * columns).max(axis=1)
    assert is_power_of_two(rows) and is_power_of_two(columns)
    assert (largest >= 0.5).all() and (largest <= 2).all()


@pytest.mark.parametrize("entries", [(1e308, 1e-308), (1.0, 5e-324), (1e-308, 1e308)])
def test_zeros_beyond_float64_are_told(entries):
    """1e308 x + 1e-308 x' has the zero -1e616 1/s."""
    with pytest.raises(mb.IllConditioned, match="no unit of time"):
        mb.PolynomialMatrix([[[entry]] for entry in entries]).jordan_pairs()
