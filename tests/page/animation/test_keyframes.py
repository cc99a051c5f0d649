"""Key frames: exact values, rates good enough that cubics between them lose nothing."""

import base64

import numpy as np
import pytest

from mbconstrained.page.animation import MOST_FRAMES, Animation, key_frames, slopes
from mbconstrained.page.drawing import Drawing, DrawnBody, Path
from mbconstrained.page.figure import figure_data, invisible_errors
from tests.page.contents import hermite, many, two_masses

EMPTY = Drawing(())


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 9])
def test_rates_of_polynomials_are_exact_up_to_the_degree_that_so_many_times_allow(count):
    times = np.cumsum(np.linspace(0.5, 1.7, count))  # of uneven spacing
    degree = min(4, count - 1)
    coefficients = np.array([[0.3, -1.0, 2.0, 0.7, -0.2][: degree + 1]])
    values = coefficients @ np.vander(times, degree + 1, increasing=True).T
    powers = np.arange(1, degree + 1)
    known = (coefficients[:, 1:] * powers) @ np.vander(times, degree, increasing=True).T if degree else np.zeros((1, 1))
    assert np.allclose(slopes(times, values), known, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("unit", [1e-60, 1.0, 1e60])
def test_rates_do_not_depend_on_the_unit_of_time(unit):
    times = np.linspace(0, 3, 31)
    assert np.allclose(slopes(unit * times, np.sin(times)[None]) * unit, np.cos(times), atol=1e-4)


def test_rates_are_of_fourth_order():
    errors = []
    for count in (51, 101):
        times = np.linspace(0, 6, count)
        errors.append(np.abs(slopes(times, np.sin(times)[None]) - np.cos(times)).max())
    assert 14 < errors[0] / errors[1] < 18  # 2^4


def test_two_masses_between_the_times_to_a_millionth():
    times = np.linspace(0, 50, 401)
    frames = key_frames(Animation(EMPTY, ("x1", "q1", "q2"), times, two_masses(times)))
    errors = [abs(hermite(frames, t)[2] - two_masses(np.array([t]))[2, 0]) for t in np.linspace(0.01, 49.9, 97)]
    assert max(errors) < 1e-6


def test_what_does_not_move_has_no_key_frames():
    data = key_frames(Animation(EMPTY, ("still", "moving"), [0, 1], [[5, 5], [0, 1]])).as_data()
    assert (data["values"][0], unpacked(data["values"][1], "<f8").tolist()) == (5.0, [0.0, 1.0])
    assert (data["rates"][0], unpacked(data["rates"][1], "<f8").tolist()) == (0, [1.0, 1.0])


def test_one_time_is_enough():
    frames = key_frames(Animation(EMPTY, ("x",), [2.0], [[7.0]]))
    times = {"start": 2.0, "end": 2.0, "count": 1}
    assert frames.as_data() == {"names": ["x"], "bytes": 8, "times": times, "values": [7.0], "rates": [0], "paths": []}


def test_too_many_times_are_thinned_evenly_with_both_ends():
    times = np.arange(2 * MOST_FRAMES + 7.0)
    frames = key_frames(Animation(EMPTY, ("x",), times, np.sin(times / 100)[None]))
    assert len(frames.times) <= MOST_FRAMES
    assert (frames.times[0], frames.times[-1], frames.stride) == (times[0], times[-1], 3)


def still_and_moving(count):
    moving = Path(np.array([np.arange(count), np.zeros(count), np.zeros(count)]), np.tile([[0], [0], [0], [1]], count))
    still = Path([[1], [2], [3]], [[0], [0], [0], [1]])
    return Drawing((DrawnBody("a", "solids", path=moving), DrawnBody("b", "solids", path=still), DrawnBody("c")))


def test_a_path_that_rests_is_one_pose_and_a_body_without_one_has_none():
    resting = Path(np.ones((3, 5)), np.ones((4, 5)))
    drawing = Drawing((*still_and_moving(5).bodies, DrawnBody("d", "solids", path=resting)))
    paths = key_frames(Animation(drawing, (), np.arange(5.0), np.zeros((0, 5)))).paths
    assert [path and path.count for path in paths] == [5, 1, None, 1]


def test_packed_key_frames_are_the_same_numbers_in_single_precision():
    frames = key_frames(Animation(still_and_moving(3), ("still", "moving"), [0, 1, 2], [[5, 5, 5], [0, 0.1, 0.4]]))
    data = frames.as_packed()
    assert data["values"][0] == 5
    assert np.array_equal(unpacked(data["values"][1]), np.float32([0, 0.1, 0.4]))
    assert np.array_equal(unpacked(data["paths"][0]).reshape(3, 7)[:, 0], [0, 1, 2])
    assert unpacked(data["paths"][1]).tolist() == [1, 2, 3, 0, 0, 0, 1]
    assert data["paths"][2] is None


def unpacked(text, kind="<f4"):
    return np.frombuffer(base64.b64decode(text), kind)


def shown(track, kind="<f4"):
    """What the page reads of a row, written here from the format."""
    if isinstance(track, str):
        return unpacked(track, kind)
    return track["low"][0] + track["step"][0] * unpacked(track["codes"], "<u2")


def test_many_numbers_are_codes_of_two_bytes_without_rates_and_nobody_sees_it():
    drawing, names, frequencies, times, values, rates = many()
    frames = key_frames(Animation(drawing, names, times, values, rates))
    figure = figure_data(drawing, [frames])
    data = frames.as_data(*invisible_errors(drawing, names, figure))
    assert set(data["rates"]) == {None} and all(isinstance(track, dict) for track in data["values"])
    pixel = max(np.subtract(figure["bounds"]["high"], figure["bounds"]["low"])) / 4000
    read = np.array([shown(track) for track in data["values"]])
    assert np.abs(read - values).max() < 0.1 * pixel
    half, drawn = times[:-1] + np.diff(times) / 2, slopes(times, read)
    middle = (read[:, :-1] + read[:, 1:]) / 2 + np.diff(times) * (drawn[:, :-1] - drawn[:, 1:]) / 8
    assert np.abs(middle - 5 - np.sin(frequencies * half)).max() < 0.1 * pixel


def test_rates_stay_where_the_page_would_miss_them_and_all_digits_where_they_are_told():
    drawing, names, _, times, values, rates = many()
    values, rates = np.vstack([values, values[-1:]]), np.vstack([rates, 1 - rates[-1:]])
    frames = key_frames(Animation(drawing, (*names, "told"), times, values, rates))
    errors, paths = invisible_errors(drawing, frames.names, figure_data(drawing, [frames]))
    kinked = frames.as_data(errors, paths)
    assert errors[-1] == 0 and np.array_equal(unpacked(kinked["values"][-1]), values[-1].astype("<f4"))
    rates[29] *= 1.5  # as beside a kink
    kinked = key_frames(Animation(drawing, (*names, "told"), times, values, rates)).as_data(errors, paths)
    assert kinked["rates"][28] is None and np.allclose(shown(kinked["rates"][29]), rates[29], atol=1e-4 * rates[29].max())
