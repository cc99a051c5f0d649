"""Switched motions in a browser: colours of links at times, readings on both sides of events, rows that lead there, the pace."""

import numpy as np
import pytest

from mbconstrained.analyses.python_models import result_of
from tests.page.browser import needs_chromium
from tests.page.plots.in_browser import number_of
from tests.page.switched_motions import ball, driveline, hanging, rattle, stick_slip

pytestmark = needs_chromium

#: Colours of links without force, slipping, and closed, as the page sets them.
COLORS = ("a9b4bf", "f0c808", "e8590c")

#: The colours of the parts of the first link of a kind that lights up, at a time.
LIT = """((time, kind) => {{
    mbconstrained.seek(time);
    const data = JSON.parse(document.getElementById("motion-data").textContent);
    const number = data.figure.links.findIndex((link) => link.kind === kind);
    const {{ object }} = mbconstrained.viewer.scene_tree.find(["mbconstrained", "links", `link ${{number}}`]);
    const colors = new Set();
    object.traverse((part) => part.material && colors.add(part.material.color.getHexString()));
    return [...colors];
}})({time!r}, {kind!r})"""

#: Text of the value next to each name, by plot.
READ = """[...document.querySelectorAll("figure")].map((figure) =>
    [...figure.querySelectorAll("[data-function] .value")].map((value) => value.textContent))"""


@pytest.mark.parametrize(
    "make, kind", [(ball, "stop"), (stick_slip, "pad"), (hanging, "cable"), (driveline, "clutch"), (rattle, "play")]
)
def test_links_have_the_colour_of_the_phase_of_the_solver(browser, tmp_path, make, kind):
    motion = make()
    browser.open(motion.write_page(tmp_path / "page.html", plots=["displacement", "velocity"]), "#t=0")
    assert (browser.state()["errors"], browser.messages, browser.dialogs) == ([], [], [])
    begins = [*(begin for begin, _ in motion.phases), motion.end]
    for (begin, name), end in list(zip(motion.phases, begins[1:]))[:6]:
        time = (begin + end) / 2
        level = 2 if "closed" in name or "stuck" in name else 1 if "ward" in name and "open" not in name else 0
        lit = browser.evaluate(LIT.format(time=time, kind=kind))
        assert {COLORS[level]} == {color for color in lit if color in COLORS}
        phases = browser.evaluate("[...document.querySelectorAll('.of-phase.lit')].map((entry) => entry.dataset.phase)")
        assert phases == [name, name], "one in each plot"
        values = dict(zip(motion.names, motion(time)))
        assert {key: browser.state()["coordinates"][key] for key in values} == pytest.approx(values, rel=1e-5, abs=1e-6)


def test_numbers_next_to_a_plot_are_the_solvers_on_both_sides_of_an_impact(browser, tmp_path):
    motion = ball()
    impact = motion.events[0]
    browser.open(motion.write_page(tmp_path / "page.html", plots=["displacement", "velocity"]), "#t=0")
    for time in (impact.time - 1e-6, impact.time, impact.time + 1e-6, 1.0):
        browser.evaluate(f"mbconstrained.seek({time!r})")
        (place,), (speed,) = browser.evaluate(READ)
        for text, value in ((place, motion(time)[0]), (speed, motion.derivative(1)(time)[0])):
            assert number_of(text) == pytest.approx(value, rel=6e-4, abs=1e-7)


def test_a_row_of_the_table_of_events_sets_the_time_again_and_again(browser, tmp_path):
    motion = ball()
    browser.open(motion.write_page(tmp_path / "page.html"), "#t=0.1")
    event = motion.events[1]
    row = f"[...document.querySelectorAll('tr')].find((row) => row.querySelector('a')?.hash === '#t={event.time!r}')"
    for click in ("{row}.querySelector('a').click()", "{row}.lastElementChild.click()"):
        browser.evaluate("mbconstrained.seek(0.05)")
        browser.evaluate(click.format(row=row))
        state = browser.state()
        assert state["time"] == event.time and not state["playing"]
    assert browser.evaluate("document.querySelector('.label.impulse').textContent") == f"{event.jump[1, 0]:.6g} N s"


def test_time_passes_slower_near_events_while_that_is_chosen(browser, tmp_path):
    motion = driveline()
    browser.open(motion.write_page(tmp_path / "page.html", slow_events=True), "#t=0")
    first, second = (event.time for event in motion.events)
    near = (second - first) / 3

    def pace(time: float) -> float:
        return browser.evaluate(f"mbconstrained.seek({time!r}), mbconstrained.state().pace")

    assert pace(1.3) == pace(0.2) == pace((first + second) / 2) == 1.0
    assert pace(first) == pace(second) == 0.1
    assert pace(first + near / 2) == pytest.approx(0.5) and pace(second - near / 4) == pytest.approx(0.25)
    browser.evaluate("document.getElementById('slow').click()")
    assert pace(first) == 1.0


def test_a_zoomed_plot_keeps_its_band_on_its_axis(browser, tmp_path):
    motion = stick_slip()
    browser.open(motion.write_page(tmp_path / "page.html"), "#t=0")
    browser.evaluate("document.querySelector('svg.plot').dispatchEvent(new KeyboardEvent('keydown', { key: '+', bubbles: true }))")
    browser.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    view = [float(x) for x in browser.evaluate("document.querySelector('.phases').getAttribute('viewBox')").split()]
    assert view == pytest.approx([10_000 / 6, 0.0, 20_000 / 3, 3.0])
    assert result_of(motion).times[-1] == motion.end and np.isfinite(view).all()
