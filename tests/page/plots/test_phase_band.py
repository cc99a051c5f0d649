"""The band of phases below plots: on pages, in their data and in pictures."""

import base64
import json
import re

import numpy as np

from mbconstrained.analyses.motion_plots import plots_of
from mbconstrained.analyses.python_models import result_of
from mbconstrained.page.content import Curve, Plot
from mbconstrained.page.plots import CELLS, PHASE_COLORS, PlotFunctions, plot_figures, plot_image
from tests.page.contents import HOSTILE
from tests.page.switched_motions import ball, stick_slip


def bands(figure: str) -> list[tuple[str, list[list[float]]]]:
    """Name and ranges of each phase, in cells."""
    paths = re.findall(r'<path fill="currentColor"[^>]* d="([^"]*)"><title>([^<]*)</title>', figure)
    return [(name, [[float(x) for x in part] for part in re.findall(r"M(\S+) 3V\d+H([^V]+)V3z", data)]) for data, name in paths]


def test_the_bands_of_a_motion_are_its_phases_to_the_last_digit_in_the_data():
    x = stick_slip()
    plots = plots_of(result_of(x, plots=["displacement", "velocity", "phase"]))
    data = PlotFunctions(plots).as_data()["phases"]
    assert list(zip(np.frombuffer(base64.b64decode(data["begins"]), "<f8").tolist(), data["names"])) == list(x.phases)
    figures = plot_figures(plots).split("<figure ")[1:]
    ends = [*(begin for begin, _ in x.phases[1:]), x.end]
    expected = {name: [] for _, name in x.phases}
    for (begin, name), end in zip(x.phases, ends):
        expected[name].append([begin, end])
    assert len(expected) == 2 and len(x.phases) > 8
    for figure in figures[:2]:
        found = dict(bands(figure))
        assert found.keys() == expected.keys()
        for name, ranges in expected.items():
            assert np.allclose(found[name], CELLS * np.array(ranges) / x.end, rtol=2e-6)
    assert "of-phase" not in figures[2], "a phase plane has no axis of time"


def test_impacts_are_jumps_and_kinks_at_their_times_to_rounding():
    x = ball()
    place, speed = plots_of(result_of(x, plots=["displacement", "velocity"]))
    impact = x.events[0].time
    for plot, order in ((place, 0), (speed, 1)):
        after = int(np.flatnonzero(plot.times == impact)[0])
        assert plot.times[after - 1] == np.nextafter(impact, 0), "no slope: the values on both sides belong to one time"
        values = plot.curves[0].values[[after - 1, after]]
        assert np.allclose(values, x.derivative(order)(plot.times[[after - 1, after]])[0], rtol=1e-12)
    assert np.isclose(values[1], -0.5 * values[0], rtol=1e-9), "the restitution"
    assert np.isclose(values[1] - values[0], x.events[0].jump[1, 0], rtol=1e-9)


def test_more_phases_than_colours_have_bars_of_other_heights_and_names_are_escaped():
    names = [HOSTILE, *(f"phase {i}" for i in range(1, 12))]
    times = np.linspace(0.0, 12.0, 25)
    plot = Plot("p", "m", times, (Curve("c", times),), phases=tuple((float(i), name) for i, name in enumerate(names)))
    figure = plot_figures((plot,))
    tops = re.findall(r'light-dark\((#\w+), #\w+\)"[^>]* d="M\S+ 3V(\d)', figure)
    assert len(set(tops)) == len(names) == 12 > len(PHASE_COLORS)
    assert "<script" not in figure.lower() and figure.count('class="of-phase"') == 12
    svg = plot_image(plot, "svg").decode()
    assert "<script" not in svg and svg.count(PHASE_COLORS[0][0]) >= 2
    assert ">phase 3<" in svg, "the legend of the picture has the phases"


def test_data_of_pages_without_phases_have_none():
    plot = Plot("p", "m", np.array([0.0, 1.0]), (Curve("c", np.array([0.0, 1.0])),))
    assert "phases" not in json.dumps(PlotFunctions((plot,)).as_data()) and "of-phase" not in plot_figures((plot,))
