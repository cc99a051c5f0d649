"""Plots of a sweep have the samples, the spreads and the statistics that they show."""

from __future__ import annotations

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.sweep.plots import row_plot
from mbconstrained.analyses.sweep.samples import Estimate
from mbconstrained.page.plots import image_groups, plot_figures, plot_image
from tests.analyses.sweep.test_sweep import SCENE


def plots_of(tmp_path, parameters, **options):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    result = mb.read_scene(path).sweep(parameters, keep=["frequencies"], **options).run()
    return result, {plot.title: plot for plot in result.answer().plots()}


def test_random_samples_have_distributions_scatter_and_tornado_plots(tmp_path):
    result, plots = plots_of(tmp_path, {"k": "normal(2 N/mm, 5 %)", "m": "normal(10 kg, 5 %)"}, samples=30)
    scatter, distribution = plots["frequency 1 over k"], plots["distribution of frequency 1"]
    points = scatter.marks[0].points
    assert sorted(points[:, 0]) == pytest.approx(sorted(result.parameter("k")))
    assert sorted(points[:, 1]) == pytest.approx(sorted(result.values("frequency 1")))
    assert distribution.curves[0].values[::2].sum() == 30
    tornado = plots["tornado plot of frequency 1: rank correlations"]
    assert tornado.marks[-1].texts == ("m", "k") or tornado.marks[-1].texts == ("k", "m")
    assert len(image_groups(plots.values())) == 2 + 4 + 3  # distributions stand in rows of three


def test_a_grid_of_two_parameters_is_a_map(tmp_path):
    result, plots = plots_of(tmp_path, {"k": "1..3 N/mm:4", "m": [10.0, 8.0, -1.0]})
    plot = plots["frequency 1 over k and m"]
    grid = result.values("frequency 1").reshape(4, 3)[:, ::-1].T  # masses ascend
    assert np.array_equal(np.isnan(plot.cells.values), np.isnan(grid)) and np.isnan(grid[0]).all()
    assert plot.cells.values[1:] == pytest.approx(grid[1:])
    assert plot.cells.texts[0][0].endswith("no answer") and "4 samples" in plot.note
    assert plot_figures((plot,)).count("<rect x=") >= 12 and plot_image((plot, plot), "png")[1:4] == b"PNG"


def test_one_parameter_is_a_curve(tmp_path):
    result, plots = plots_of(tmp_path, {"k": "1..3 N/mm:5"})
    assert plots["frequency 1 over k"].curves[0].values == pytest.approx(result.values("frequency 1"))


def test_one_at_a_time_shows_how_far_each_parameter_moves_a_figure(tmp_path):
    result, plots = plots_of(tmp_path, {"k": "1..3 N/mm", "m": "9..11 kg"}, method="one at a time")
    low, high, names = plots["tornado plot of frequency 1"].marks
    values = result.values("frequency 1")
    spread = {name: (values[1 + 2 * i], values[2 + 2 * i]) for i, name in enumerate(("k", "m"))}
    assert names.texts[0] == max(spread, key=lambda name: abs(np.subtract(*spread[name])))
    for i, marks in enumerate((low, high)):
        assert dict(zip(names.texts, marks.points[:, 0])) == pytest.approx({name: ends[i] for name, ends in spread.items()})


def test_rows_have_their_names_and_intervals():
    estimates = (Estimate(0.5, 0.4, 0.6), Estimate(0.1, np.nan, np.nan))
    plot = row_plot("Sobol indices", ["a", "b"], {"alone": [0.5, 0.1]}, "share", intervals=(estimates,))
    assert [guide.start[0] for guide in plot.guides if guide.kind == "limit"] == [0.4]
    assert plot.marks[-1].texts == ("a", "b") and plot.marks[-1].points[:, 1].tolist() == [2.0, 1.0]
    assert plot.axes[1].ticks == () and plot_image(plot, "png")[1:4] == b"PNG"
    assert ">a</text>" in plot_figures((plot,))
