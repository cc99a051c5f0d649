"""Texts beside points cover no point, no curve and no other text, and stay within the axes."""

from itertools import combinations

import numpy as np
import pytest

from mbconstrained.reports.labels import Label, place_labels


def placed(points, curve=None):
    from matplotlib.figure import Figure

    figure = Figure(layout="constrained")
    axes = figure.add_subplot(xlim=(0, 1), ylim=(0, 1))
    if curve is not None:
        axes.plot(*curve)
    place_labels(figure, [(axes, [Label(x, y, f"number {i}", "black") for i, (x, y) in enumerate(points)])])
    return axes


def test_a_text_stands_to_the_right_of_a_lonely_point():
    axes = placed([(0.5, 0.5)])
    (text,) = axes.texts
    assert text.get_window_extent().x0 > axes.transData.transform((0.5, 0.5))[0]


def test_at_the_right_edge_it_stands_to_the_left():
    axes = placed([(0.99, 0.5)])
    (text,) = axes.texts
    assert text.get_window_extent().x1 < axes.transData.transform((0.99, 0.5))[0]


@pytest.mark.parametrize("seed", range(3))
def test_texts_cover_nothing_and_stay_inside(seed):
    points = np.random.default_rng(seed).uniform(size=(80, 2))
    axes = placed(points)
    boxes = [text.get_window_extent() for text in axes.texts]
    assert 0 < len(boxes) < len(points)
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    assert not any(box.contains(*axes.transData.transform(point)) for box in boxes for point in points)
    assert all(
        axes.bbox.x0 <= box.x0 and box.x1 <= axes.bbox.x1 and axes.bbox.y0 <= box.y0 and box.y1 <= axes.bbox.y1 for box in boxes
    )


def test_where_a_curve_runs_there_is_no_text():
    across = np.linspace(0, 1, 500)
    assert placed([(0.5, 0.5)], (across, 0.5 + 0.5 * np.sin(400 * across))).texts[:] == []


def test_points_without_a_text_keep_their_places_free():
    from matplotlib.figure import Figure

    axes = (figure := Figure()).add_subplot(xlim=(0, 1), ylim=(0, 1))
    place_labels(figure, [(axes, [Label(0.5, 0.5, "text", "black"), Label(0.54, 0.5, "", "black")])])
    assert axes.texts[0].get_window_extent().x1 < axes.transData.transform((0.5, 0.5))[0]
