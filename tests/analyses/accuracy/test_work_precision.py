"""The work-precision diagram: every measured point is in it, whatever was measured."""

import numpy as np
import pytest

from mbconstrained.analyses.accuracy.accuracy import LOWEST, work_precision
from mbconstrained.analyses.accuracy.measure import Measurement
from mbconstrained.analyses.accuracy.methods import ComparedMethod, MethodSetting
from mbconstrained.analyses.timing import Timing


def timing(seconds: float) -> Timing:
    return Timing((0.8 * seconds, 0.9 * seconds, seconds, 1.2 * seconds, 1.3 * seconds))


def run(method: ComparedMethod, error: float, seconds: float, label: str = "") -> Measurement:
    """One run takes so many seconds, a further evaluation 0.4 of them."""
    return Measurement(method, MethodSetting(label), error, timing(0.5 * seconds), timing(0.5 * seconds), timing(0.4 * seconds))


def named(name: str, is_ours: bool = False) -> ComparedMethod:
    return ComparedMethod(name, lambda problem, value: None, is_ours=is_ours)


def peer(name: str, start: float = 1e-3) -> list[Measurement]:
    method = named(name)
    return [run(method, 1e-3 * 100.0**-i, start * 3.0**i, f"rtol 1e-{2 * i + 3:02d}") for i in range(4)]


OURS = [run(named("closed form", is_ours=True), 3e-16, 4e-3)]
SOME = [*OURS, *(one for i in range(3) for one in peer(f"method {i}", 1e-3 * 1.7**i))]


@pytest.mark.parametrize("place, kind", [(0, "one_run"), (1, "further")])
def test_points_have_their_times_and_errors(place, kind):
    plot = list(work_precision(SOME))[place]
    assert [curve.name for curve in plot.curves] == ["closed form", "method 0", "method 1", "method 2"]
    assert plot.scales == ("log", "log") and plot.shown == 4
    points = np.concatenate([marks.points for marks in plot.marks])
    assert points.tolist() == [[getattr(run, kind).median, run.error] for run in SOME]
    for curve, marks in zip(plot.curves, plot.marks):
        assert np.array_equal(np.array([curve.along, curve.values])[:, curve.drawn].T, marks.points)
    assert "rtol 1e-05: 1.0e-05 in" in plot.marks[1].texts[1]


@pytest.mark.parametrize("error", [0.0, 1e-30])
def test_what_is_too_small_is_drawn_at_the_bottom_and_named_in_the_note(error):
    method = named("a")
    plot = next(work_precision([run(method, error, 1e-3), run(method, 1e-9, 2e-3)]))
    assert plot.marks[0].points[0, 1] == LOWEST and "1e-17" in plot.note and plot.axes[1].low <= LOWEST
    assert "1e-17" not in next(work_precision(SOME)).note
