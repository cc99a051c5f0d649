"""Axes: sensible numbers for any range."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.ground.errors import InputError
from mbconstrained.page.content import MOST_DECADES, axis_of

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


positive = st.floats(1e-150, 1e150)


@given(positive, positive, st.booleans())
def test_a_logarithmic_axis_covers_its_range_with_a_few_ticks(a, b, widen):
    low, high = min(a, b), max(a, b)
    axis = axis_of(low, high, widen=widen, scale="log")
    assert axis.low <= max(low, high * 10.0**-MOST_DECADES) * (1 + 1e-8) and high <= axis.high * (1 + 1e-8)
    assert 2 <= len(axis.ticks) <= 14 and len(set(axis.labels)) == len(axis.labels)
    assert np.allclose(axis.shares(np.array([axis.low, np.sqrt(axis.low) * np.sqrt(axis.high), axis.high])), [0, 0.5, 1], atol=1e-6)
    assert ((axis.shares(np.array(axis.ticks)) >= -1e-8) & (axis.shares(np.array(axis.ticks)) <= 1 + 1e-8)).all()


@pytest.mark.parametrize(
    "low, high, widen, labels",
    [
        (0.02, 300, True, ("0.01", "0.1", "1", "10", "100", "1000")),
        (3, 70, True, ("1", "2", "5", "10", "20", "50", "100")),
        (99, 1001, False, ("100", "200", "500", "1000")),
        (0.9, 1.1, False, ("0.90", "0.95", "1.00", "1.05", "1.10")),
        (1e-9, 1e9, True, ("10⁻⁹", "10⁻⁶", "0.001", "1", "1000", "10⁶", "10⁹")),
        (1e-30, 1e-29, True, ("10⁻³⁰", "2·10⁻³⁰", "5·10⁻³⁰", "10⁻²⁹")),
        (7, 7, True, ("1", "2", "5", "10", "20", "50", "100")),
    ],
)
def test_labels_of_logarithmic_axes(low, high, widen, labels):
    assert [float_of(label) for label in axis_of(low, high, widen=widen, scale="log").labels] == [float_of(each) for each in labels]


def float_of(label: str) -> float:
    factor, _, power = label.replace("·", "").partition("10") if "⁻" in label or label[-1] in "⁶⁹" else (label, "", "")
    exponent = int("".join("-0123456789"["⁻⁰¹²³⁴⁵⁶⁷⁸⁹".index(sign)] for sign in power) or 0)
    return float(factor or 1) * 10.0**exponent


def test_a_logarithmic_axis_needs_positive_values():
    with pytest.raises(InputError, match="expected positive ones"):
        axis_of(-2.0, 0.0, scale="log")
