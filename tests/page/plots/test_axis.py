"""Axes: sensible numbers for any range."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.page.plots.axis import axis_of

ends = st.floats(-1e200, 1e200, allow_nan=False)


@given(ends, ends)
def test_an_axis_covers_its_range_with_a_few_ticks_at_even_steps(a, b):
    low, high = min(a, b), max(a, b)
    axis = axis_of(low, high)
    slack = 1e-8 * (high - low)  # far below a pixel
    assert axis.low <= low + slack and high - slack <= axis.high
    assert 3 <= len(axis.ticks) <= 9
    assert len(set(axis.labels)) == len(axis.labels)
    assert np.all(np.abs(np.diff(axis.ticks, 2)) <= 1e-6 * (axis.high - axis.low))


@given(ends, ends)
def test_an_axis_that_is_not_widened_keeps_its_ends(a, b):
    low, high = min(a, b), max(a, b) + 1.0
    axis = axis_of(low, high, widen=False)
    if high - low > 1e-9 * max(abs(low), abs(high)):
        assert (axis.low, axis.high) == (low, high)
        slack = 1e-8 * (high - low)
        assert all(low - slack <= tick <= high + slack for tick in axis.ticks)


@pytest.mark.parametrize(
    "low, high, labels, exponent",
    [
        (0, 1, ("0.0", "0.2", "0.4", "0.6", "0.8", "1.0"), 0),
        (-1e-5, 1e-5, ("-10", "-5", "0", "5", "10"), -6),
        (0, 4e6, ("0", "1", "2", "3", "4"), 6),
        (0, 0, ("-1.0", "-0.5", "0.0", "0.5", "1.0"), 0),
        (2, 2, ("1.0", "1.5", "2.0", "2.5", "3.0"), 0),
        (0.1, 0.1 + 1e-15, ("0.04", "0.06", "0.08", "0.10", "0.12", "0.14", "0.16"), 0),
    ],
)
def test_labels(low, high, labels, exponent):
    axis = axis_of(low, high)
    assert (tuple(label.replace("−", "-") for label in axis.labels), axis.exponent) == (labels, exponent)
