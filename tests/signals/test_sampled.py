"""Records: exactly the linear interpolation, as a function, as a sum of ramps, and with what jumps known exactly."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb

gaps = st.lists(st.floats(1e-3, 10.0), min_size=1, max_size=8)
values = st.floats(-1e3, 1e3)


@st.composite
def records(draw):
    times = np.cumsum([draw(st.sampled_from([0.0, 0.5, 3.0])), *draw(gaps)])
    rows = draw(st.integers(1, 3))
    return times, np.array([[draw(values) for _ in times] for _ in range(rows)])


def interpolated(times, rows, at):
    inside = (at >= times[0]) & (at < times[-1])
    return np.array([np.where(inside, np.interp(at, times, row), 0.0) for row in rows])


@given(records())
def test_a_record_is_its_linear_interpolation(record):
    times, rows = record
    at = np.concatenate([times, (times[1:] + times[:-1]) / 2, [0.0, times[-1] + 1, 1e6]])
    assert np.allclose(mb.sampled(times, rows)(at), interpolated(times, rows, at), rtol=1e-13, atol=1e-13 * np.abs(rows).max())


@given(records())
def test_a_record_is_a_sum_of_ramps_and_two_jumps(record):
    times, rows = record
    slopes = np.diff(rows, axis=1) / np.diff(times)
    changes = np.diff(np.pad(slopes, ((0, 0), (1, 1))), axis=1)
    parts = [mb.ramp(change).delayed(time) for time, change in zip(times, changes.T)]
    total = sum(parts, mb.step(rows[:, 0]).delayed(times[0]) - mb.step(rows[:, -1]).delayed(times[-1]))
    at = np.linspace(0, times[-1] + 1, 23)
    scale = np.abs(rows).max() + np.abs(slopes).max() * times[-1]
    assert np.allclose(total(at), mb.sampled(times, rows)(at), rtol=0, atol=1e-13 * max(scale, 1))


@given(records(), st.sampled_from([0.25, 2.0]))
def test_a_delayed_record_is_the_record_of_later_times(record, delay):
    times, rows = record
    at = np.linspace(0, times[-1] + 3, 23) + 0.0123
    assert np.allclose(mb.sampled(times, rows).delayed(delay)(at), mb.sampled(times + delay, rows)(at), rtol=1e-11, atol=1e-9)


def test_what_goes_on_is_known_to_go_on():
    """Values that are continuous, and slopes that differ by rounding only, do not jump at all."""
    times = np.arange(11) * 0.1
    restarts = mb.sampled(times, [3 * times + 1, np.where(times < 0.45, 1.0, 2.0)]).smooth.restarts
    assert restarts.jumps[0].nonzero()[0].tolist() == [0, 10]
    assert restarts.jumps[1].nonzero()[0].tolist() == [0, 10]
    assert restarts.jumps[2].nonzero()[0].tolist() == [0, 10]
    assert restarts.jumps[3].nonzero()[0].tolist() == [4, 5]


def test_ten_thousand_samples_need_two_states_a_row():
    times = np.linspace(0, 10, 10_001)
    rows = np.random.default_rng(0).normal(size=(3, 10_001))
    f = mb.sampled(times, rows)
    assert sum(map(len, f.smooth.blocks)) == 6
    at = np.random.default_rng(1).uniform(0, 10, 10_000)
    assert np.allclose(f(at), interpolated(times, rows, at), rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("times", "rows", "text"),
    [
        ([0.0], [[1.0]], "times: found 1; a record needs at least two"),
        ([1.0, 1.0], [[1.0, 2.0]], "times: all are 1 s"),
        ([-1.0, 1.0], [[1.0, 2.0]], "times: the first is -1 s"),
        ([0.0, 2.0, 1.0], [[1.0, 2.0, 3.0]], "times: 2 s is followed by 1 s"),
        ([0.0, 1.0, 1.0, 1.0], [[1.0] * 4], "times: 1 s appears three times"),
        ([0.0, 1.0], [[1.0, 2.0, 3.0]], "values: found shape 1 x 3; expected one row per coordinate, each of 2 values"),
        ([0.0, 1.0], [[[1.0, 2.0]]], r"values: found shape 1 x 1 x 2; expected one row per coordinate, .* e.g. \[\[1, 2\]\]"),
        ([0.0, np.nan], [[1.0, 2.0]], "times: the entry"),
        ([0.0, 1e-300], [[0.0, 1e200]], "the slope after t = 0 s is beyond the range"),
    ],
)
def test_records_are_checked(times, rows, text):
    with pytest.raises(mb.InputError, match=text):
        mb.sampled(times, rows)
