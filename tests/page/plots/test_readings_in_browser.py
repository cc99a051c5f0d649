"""What the pointer reads in the plots of each analysis, and what they save, is what the solver has computed."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.frequency import Frequency
from mbconstrained.page.content import Curve, PageContent, Plot
from mbconstrained.page.html import write_page
from tests.page.browser import needs_chromium
from tests.page.plots.in_browser import number_of, pointed, tables

pytestmark = needs_chromium

READ = """(() => {{
    const figure = document.querySelectorAll(".plot-figure")[{}];
    const values = [...figure.querySelectorAll(".legend [data-function] .value")].map((value) => value.textContent);
    return [figure.querySelector(".pointer-time").textContent, values];
}})()"""


def plots_of(kind: str, example: str) -> tuple[Plot, ...]:
    """Plots of the page of an analysis."""
    answer = getattr(mb.read_scene(f"examples/{example}.toml"), kind)()
    plots = [plot for plot in answer.plots() if plot.across is None and len(plot.times) > 1 and plot.curves]
    return tuple(plot for plot in plots if not any(curve.function for curve in plot.curves))


@pytest.mark.parametrize(("kind", "example"), [("campbell", "rotor"), ("random", "electronics_box")])
def test_readings_are_computed_values(browser, tmp_path, kind, example):
    """At the pointer: the nearest computed point, on a logarithmic axis the nearest there, and the values of all curves at it."""
    plots = plots_of(kind, example)
    browser.size(1100, 900)
    browser.open(write_page(tmp_path / "page.html", PageContent("t", plots=plots)))
    count = 0
    for number, plot in enumerate(plots):
        across = plot.axes[0]
        for share in (0.137, 0.5, 0.871):
            pointed(browser, number, share, 0.5)
            place, texts = browser.evaluate(READ.format(number))
            nearest = int(np.abs(across.shares(plot.times) - share).argmin())
            right = int(np.searchsorted(across.shares(plot.times), share).clip(1, len(plot.times) - 1))
            if all(curve.values[right - 1] == curve.values[right] for curve in plot.curves):
                nearest = right  # a step, which is read wherever the pointer is
            else:
                assert number_of(place) == pytest.approx(plot.times[nearest], rel=2e-3, abs=1e-3 * np.ptp(plot.times))
            for curve, text in zip(plot.curves[: plot.shown], texts):
                if curve.drawn is not None and not curve.drawn[nearest]:
                    assert text == ""
                    continue
                assert number_of(text) == pytest.approx(curve.values[nearest], rel=6e-4, abs=1e-9 * np.abs(curve.values).max())
                count += 1
    assert count and browser.messages == []
    for plot, text in zip(plots, tables(browser)):
        head, saved = table_of(text)
        drawn = [np.ones(len(plot.times), bool) if curve.drawn is None else curve.drawn for curve in plot.curves[: plot.shown]]
        kept = np.any(drawn, axis=0)
        assert np.allclose(saved[0, : kept.sum()], plot.times[kept], rtol=1e-11) and head[0].startswith(plot.across_name)
        for row, curve, own in zip(saved[1:, : kept.sum()], plot.curves, drawn):
            assert np.array_equal(np.isfinite(row), own[kept])
            assert np.allclose(row[own[kept]], curve.values[own], rtol=1e-5, atol=1e-12 * np.abs(curve.values).max())


def table_of(text: str) -> tuple[list[str], np.ndarray]:
    """Heads and columns of a table, without the column of notes; NaN where a cell is empty."""
    head, *rows = (line.split(",") for line in text.splitlines())
    count = len(head) - head.count("note")
    return head, np.array([[float(cell or "nan") for cell in row[:count]] for row in rows]).T


def test_a_table_of_functions_has_values_of_the_solver(browser, tmp_path):
    """A frequency response, whose curves are functions: |H| at frequencies of the table, and the largest of them near the peak."""
    frequency = Frequency(mb.read_scene("examples/tuned_mass_damper.toml"))
    (plot, _), outputs = frequency.to_answer().plots(), frequency.response.outputs
    browser.size(1100, 900)
    browser.open(write_page(tmp_path / "page.html", PageContent("t", plots=(plot,))))
    (text,) = tables(browser)
    _, (frequencies, *rows) = table_of(text)
    assert len(frequencies) == 2001 and np.ptp(np.diff(np.log(frequencies))) < 1e-9
    expected, drawn = (np.abs(frequency.response(at).values[:, 0]) for at in (frequencies, plot.times))
    for curve, row in zip(plot.curves, rows, strict=True):
        factor = np.median(curve.values / drawn[outputs.index(curve.name)])  # of the unit that is shown
        assert np.allclose(row, factor * expected[outputs.index(curve.name)], rtol=2e-5)


def test_the_table_of_a_root_locus_has_the_eigenvalues(browser, tmp_path):
    """Against the eigenvalues of the companion matrix of the solver's own matrices, at every value of the table."""
    scene = mb.read_scene("examples/tuned_mass_damper.toml")
    values = np.linspace(0.02, 0.3, 15)
    browser.size(1100, 900)
    browser.open(write_page(tmp_path / "page.html", PageContent("t", plots=scene.locus(vary={"zeta": values.tolist()}).plots())))
    (text,) = tables(browser)
    head, columns = table_of(text)
    assert head[:3] == ["zeta", "branch 1: real part (1/s)", "branch 1 (rad/s)"]
    rows = columns[:, np.isfinite(columns[0])]
    assert set(values.round(9)) < set(rows[0].round(9))  # and further ones where the branches turn
    for zeta, *parts in rows.T:
        system = mb.read_scene("examples/tuned_mass_damper.toml", {"zeta": zeta}).equations.system
        inverse = np.linalg.inv(system.mass)
        companion = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ system.stiffness, -inverse @ system.damping]])
        shown = np.array(parts[::2]) + 1j * np.array(parts[1::2])
        distances = np.abs(shown[:, None] - np.linalg.eigvals(companion))
        assert distances.min(axis=0).max() < 1e-5 * 30 and distances.min(axis=1).max() < 1e-5 * 30


def test_the_map_of_mode_shapes_reads_the_modal_assurance_criterion(browser, tmp_path):
    answer = mb.read_scene("examples/three_storeys.toml").mac(other="examples/three_storeys.toml")
    browser.size(390, 900, mobile=True)
    browser.open(write_page(tmp_path / "page.html", answer.page()))
    mac = answer.data["mac"]
    for i, j in np.ndindex(3, 3):
        pointed(browser, 0, (j + 0.5) / 3, (i + 0.5) / 3)
        text = browser.evaluate("document.querySelector('.reading:not([hidden])').textContent")
        assert text.startswith(f"mode {i + 1} (") and text.endswith(f": {mac[i, j]:.4f}")
    ticks = browser.evaluate("[...document.querySelectorAll('.ticks text')].map((text) => text.textContent)")
    assert ticks == ["1", "2", "3", "1", "2", "3"] and browser.messages == []


LONG = "relative displacement of the upper left control arm bushing against the subframe, φ̈_ω"
T = np.linspace(0.0, 1.0, 201)
WAVE = np.sin(6 * T)
HARD = {
    "long names": Plot(
        LONG, "N*m/rad", T, (Curve(LONG, WAVE), Curve("q", -WAVE)), quantity=LONG, variable=LONG[:60], across_unit="kg*m^2"
    ),
    "tiny": Plot("tiny", "m", 1e-9 * T, (Curve("a", 1e-12 * WAVE),)),
    "huge": Plot("huge", "N/m", 1e9 * T, (Curve("a", 1e9 * (2 + WAVE)),)),
    "offset": Plot("offset", "m", 1000 + 1e-3 * T, (Curve("a", 123.0 + 1e-7 * WAVE),)),
    "constant": Plot("constant", "m", T, (Curve("a", np.full(201, 3.3)),)),
    "one point": Plot("one", "m", T[:1], (Curve("a", T[:1]),)),
    "15 decades": Plot("decades", "m", np.geomspace(1e-8, 1e7, 201), (Curve("a", np.geomspace(1e-12, 1e3, 201)),), scales=("log", "log")),
    "2 decades": Plot("two", "m", np.geomspace(11.0, 7000.0, 201), (Curve("a", 2 + WAVE),), scales=("log", "log")),
    "part of a decade": Plot("part", "m", np.geomspace(1e5, 1.2e5, 201), (Curve("a", 2 + WAVE),), scales=("log", "linear")),
    "fifty": Plot("fifty", "m", T, tuple(Curve(f"cylinder {i} over the liner" if i % 7 else f"q{i}", WAVE + i) for i in range(50))),
}  # fmt: skip

#: Pairs of texts of a plot that overlap, and texts that reach out of their figure.
OVERLAPS = """(() => [...document.querySelectorAll(".plot-figure")].flatMap((figure) => {
    const frame = figure.getBoundingClientRect();
    const texts = [...figure.querySelectorAll("svg.plot text, h2, .axis-name, .legend button, .legend .value")].filter((text) => text.textContent);
    const boxes = texts.map((text) => [text.textContent, text.getBoundingClientRect()]).filter(([, box]) => box.width);
    const out = boxes.filter(([, box]) => box.left < frame.left - 0.5 || box.right > frame.right + 0.5).map(([text]) => `outside: ${text}`);
    const meet = (a, b) => a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 2 && b.top < a.bottom - 2;
    const pairs = boxes.flatMap(([text, box], i) => boxes.slice(i + 1).filter(([, other]) => meet(box, other)).map(([other]) => `${text} | ${other}`));
    return [...out, ...pairs];
}))()"""


@pytest.mark.parametrize("width", [1100, 390])
def test_texts_of_plots_do_not_meet_and_are_not_cut(browser, tmp_path, width):
    browser.size(width, 900, mobile=width < 500)
    browser.open(write_page(tmp_path / "page.html", PageContent("t", plots=tuple(HARD.values()))))
    assert browser.evaluate(OVERLAPS) == []
    assert browser.evaluate("document.documentElement.scrollWidth") <= width
    for number in range(len(HARD) - 1):
        browser.evaluate(f"document.querySelectorAll('svg.plot')[{number}].focus()")
        for _ in range(12):
            browser.press("+")
    browser.wait(0.2)
    assert browser.evaluate(OVERLAPS) == [] and browser.messages == []
