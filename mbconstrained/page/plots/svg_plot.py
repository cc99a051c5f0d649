"""Plots as inline SVG: readable without scripts, as wide as the page allows, with texts of one size on every screen.

The origin of the picture is the upper left corner of its axes; horizontal positions are in percent of their width and
vertical ones in pixels. The curves lie in a square of ``CELLS`` by ``CELLS`` that is stretched over the axes, and are
written in whole cells from point to point. The first of many curves are drawn here, the others by the page's script, which also
draws the part of all of them that a zoomed plot shows: from the functions in ``readings.py``, which give it the values next to the
names, too.
"""

from __future__ import annotations

import html
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..content import Curve, Plot, TimeFunctions
from ..typeset import raised, shortened, superscript
from .axis import Axis
from .readings import Readings, linear_readings, readings_of
from .record_steps import RecordReadings, RecordSteps, record_readings, record_steps

#: Height of the axes, px.
HEIGHT = 214

#: Size of the square that the curves are written in, in cells.
CELLS = 10_000

#: A curve of more points than the picture has pixels is drawn by the lowest and highest value of each pixel column.
MOST_POINTS = 2400

#: Curves shown at first: more in one picture are indistinct.
MOST_SHOWN = 8

#: With more curves than this the names can be searched, and all be shown or hidden at once.
FEW_CURVES = 12

#: Labels along an axis that fit on a phone.
MOST_LABELS = 5

#: Letters of a name along an axis.
AXIS_NAME = 20

#: Colours of curves in the style sheet, and patterns of dashes: one for each round through the colours.
COLORS, DASHES = 6, 4

#: Curves that differ by less than this share of the height coincide in the picture.
COINCIDE = 1 / 200

HELP = (
    "To zoom into a plot turn the wheel, pinch, or press + and −; drag or press the arrow keys to move the part that is shown; "
    "double-click or press 0 for the whole. A click on a name shows or hides its curve, a double click shows it alone."
)


class PlotFunctions:
    """The functions behind the curves of a page, numbered as the page's script finds them."""

    def __init__(self, plots: tuple[Plot, ...]):
        drawn = [plot for plot in plots if plot.curves and len(plot.times) > 1]
        self.sets: list[tuple[Readings | RecordReadings, ...]] = []
        self.records: list[RecordSteps] = []
        self._steps: dict[tuple, int | None] = {}
        self._places: dict[tuple, tuple[int, int]] = {}
        shared: dict[tuple, tuple[TimeFunctions, list[int]]] = {}
        for plot in drawn:
            own = []
            for curve in _all_curves(plot):
                if curve.function is None:
                    own.append(curve)
                    continue
                functions, row = curve.function
                rows = shared.setdefault((id(functions), plot.times[0], plot.times[-1]), (functions, []))[1]
                if row not in rows:
                    rows.append(row)
            if own:
                self._places |= {(id(plot), id(curve.values)): (len(self.sets), row) for row, curve in enumerate(own)}
                self.sets.append((linear_readings(plot.times, np.array([curve.values for curve in own])),))
        for (key, start, end), (functions, rows) in shared.items():
            self._places |= {(key, start, end, row): (len(self.sets), place) for place, row in enumerate(rows)}
            self.sets.append(self._parts(_selected(functions, rows), float(start), float(end)))

    def _parts(self, functions: TimeFunctions, start: float, end: float) -> tuple[Readings | RecordReadings, ...]:
        """Readings by the steps of a record, with panels before and after them, or by panels alone."""
        record = functions.record
        if record is not None:
            key = id(record), start, end
            if key not in self._steps:
                steps = record_steps(record, start, end)
                self._steps[key] = None if steps is None else len(self.records)
                self.records += [] if steps is None else [steps]
            if (place := self._steps[key]) is not None:
                steps = self.records[place]
                if (middle := record_readings(functions, steps, place)) is not None:
                    before = (readings_of(functions, start, steps.start, middle.largest),) if start < steps.start else ()
                    after = (readings_of(functions, steps.end, end, middle.largest),) if steps.end < end else ()
                    return (*before, middle, *after)
        return (readings_of(functions, start, end),)

    def place(self, plot: Plot, curve: Curve) -> tuple[int, int]:
        """Position of the function of a curve."""
        if curve.function is None:
            return self._places[id(plot), id(curve.values)]
        functions, row = curve.function
        return self._places[id(functions), plot.times[0], plot.times[-1], row]

    def as_data(self) -> dict[str, list]:
        return {
            "records": [steps.as_data() for steps in self.records],
            "sets": [[part.as_data() for part in parts] for parts in self.sets],
        }


def _all_curves(plot: Plot) -> tuple[Curve, ...]:
    return (*([plot.across] if plot.across else []), *plot.curves)


def _selected(functions: TimeFunctions, rows: list[int]) -> TimeFunctions:
    return replace(functions, at=lambda times: functions.at(times)[rows])


def plot_figures(plots: tuple[Plot, ...], functions: PlotFunctions | None = None) -> str:
    """All plots, in pairs side by side where the window is wide enough; the last of an odd number takes the full width."""
    paired, functions = len(plots) - len(plots) % 2, functions or PlotFunctions(plots)
    figures = "\n".join(_figure(plot, functions, " wide" if i >= paired else "") for i, plot in enumerate(plots))
    note = f'\n<p class="note plot-help">{HELP}</p>' if functions.sets else ""
    return f'<div class="plots">\n{figures}\n</div>{note}' if plots else ""


def _figure(plot: Plot, functions: PlotFunctions, wide: str) -> str:
    count, note, body = len(plot.curves), "", '<p class="note">no curves</p>'
    if count:
        body = f"{_svg(plot)}\n{_legend(plot, functions)}"
    if count > MOST_SHOWN:
        note = f'\n<p class="note">{count} curves, {MOST_SHOWN} of them shown at first</p>'
    return f'<figure class="plot-figure{wide}">\n<h2>{html.escape(plot.title)}</h2>\n{body}{note}\n</figure>'


def _svg(plot: Plot) -> str:
    """The picture alone; its data attributes describe the axes for the script."""
    times, phase = plot.times, plot.across is not None
    across, up = plot.axes
    shown = plot.curves[:MOST_SHOWN]
    x, y = _cells(across, plot.horizontal.values), CELLS - _cells(up, np.array([curve.values for curve in shown]))
    right, upwards = map(html.escape, axis_titles(plot, across.exponent, up.exponent))
    elements = [
        *_guides(plot, across, up),
        f'<g class="ticks">\n{_grid(across, up)}\n{_guide_names(plot, across, up)}</g>',
        f'<text x="50%" y="{HEIGHT + 38}" text-anchor="middle">{right}</text>',
        f'<text transform="translate(-58 {HEIGHT // 2}) rotate(-90)" text-anchor="middle">{upwards}</text>',
    ]
    if len(times) == 1:
        elements += [
            f'<circle class="{_classes(curve.color)}" cx="{100 * x[0] / CELLS:.2f}%" cy="{HEIGHT * row[0] / CELLS:.1f}" r="3.5"/>'
            for curve, row in zip(shown, y)
        ]
    else:
        order = np.argsort(-np.ptp(y, axis=1), kind="stable")  # the smallest is drawn last, so that no larger one hides it
        twins = _coinciding(y[order])
        paths = "\n".join(
            _path(number, shown[number], plotted(x, y[number], phase=phase), twin) for number, twin in zip(order.tolist(), twins)
        )
        elements.append(f'<svg class="curves" viewBox="0 0 {CELLS} {CELLS}" preserveAspectRatio="none">\n{paths}\n</svg>')
    over = "phase" if phase else html.escape(plot.variable)
    variable = f' data-variable="{html.escape(plot.variable)}"' if phase and plot.variable != "time" else ""
    return (
        f'<svg class="plot" role="img" tabindex="0" aria-label="{html.escape(_description(plot, plot.curves))}"'
        f' data-start="{float(times[0])!r}" data-end="{float(times[-1])!r}" data-over="{over}"{variable}'
        f" {_scale('across', across, plot.across_unit)} {_scale('up', up, plot.unit)}>\n" + "\n".join(elements) + "\n</svg>"
    )


def _coinciding(rows: np.ndarray) -> list[bool]:
    """Which curves, in the order of drawing, coincide with an earlier one."""
    near = COINCIDE * CELLS
    return [any(np.abs(row - other).max() < near for other in rows[:i]) for i, row in enumerate(rows)]


def _cells(axis: Axis, values: np.ndarray) -> np.ndarray:
    return CELLS * axis.shares(values)


def _scale(name: str, axis: Axis, unit: str) -> str:
    """Data attributes for the script: ends of the axis, the power of ten of its labels, the kind of its scale, the unit."""
    ends = f"{axis.low!r} {axis.high!r} {axis.exponent} {axis.scale}"
    return f'data-{name}="{ends}" data-{name}-unit="{html.escape(shortened(raised(unit), AXIS_NAME))}"'


def _grid(across: Axis, up: Axis) -> str:
    """Lines and labels; every other horizontal label is left out where the window is narrow."""
    lines = []
    crowded = len(across.labels) > MOST_LABELS
    for i, (x, label) in enumerate(zip(_cells(across, np.array(across.ticks)), across.labels)):
        place, kind = f"{100 * x / CELLS:.2f}%", ' class="second"' if crowded and i % 2 else ""
        lines.append(f'<line class="grid" x1="{place}" x2="{place}" y2="{HEIGHT}"/>')
        lines.append(f'<text{kind} x="{place}" y="{HEIGHT + 18}" text-anchor="middle">{label}</text>')
    for tick, y, label in zip(up.ticks, _cells(up, np.array(up.ticks)), up.labels):
        down = HEIGHT * (1 - y / CELLS)
        lines.append(f'<line class="{"axis" if tick == 0 else "grid"}" x2="100%" y1="{down:.1f}" y2="{down:.1f}"/>')
        lines.append(f'<text x="-8" y="{down + 4:.1f}" text-anchor="end">{label}</text>')
    lines.append(f'<line class="axis" y2="{HEIGHT}"/><line class="axis" x2="100%" y1="{HEIGHT}" y2="{HEIGHT}"/>')
    return "\n".join(lines)


def _guides(plot: Plot, across: Axis, up: Axis) -> list[str]:
    """The guide lines, in a separate picture with the view of the curves."""
    ends = [place for guide in plot.guides if (place := guide.ends(across, up))]
    lines = "".join(
        f'<path class="guide" d="M{CELLS * a:.0f} {CELLS * (1 - b):.0f}L{CELLS * c:.0f} {CELLS * (1 - d):.0f}"/>'
        for (a, b), (c, d) in ends
    )
    return [f'<svg class="guides" viewBox="0 0 {CELLS} {CELLS}" preserveAspectRatio="none">{lines}</svg>'] if lines else []


def _guide_names(plot: Plot, across: Axis, up: Axis) -> str:
    """Names at ends of the lines, below the point, at the lower edge above it."""
    texts = []
    for guide in plot.guides:
        if place := guide.named_at(across, up):
            x, y, is_left = place
            down = min(HEIGHT * (1 - y) + 11, HEIGHT - 3)
            anchor = "end" if is_left else "start"
            name = html.escape(guide.name)
            texts.append(f'<text class="guide-name" x="{100 * x:.2f}%" y="{down:.1f}" text-anchor="{anchor}">{name}</text>\n')
    return "".join(texts)


def axis_titles(plot: Plot, across: int = 0, up: int = 0) -> tuple[str, str]:
    """The titles of the axes, such as "displacement in 10⁻³ m"; a long name is shortened, the heading has all of it."""
    rows = (plot.horizontal.name, plot.across_unit, across), (plot.quantity or plot.title, plot.unit, up)
    horizontal, vertical = (
        " in ".join(filter(None, (shortened(name, AXIS_NAME), _measure(unit, power)))) for name, unit, power in rows
    )
    return horizontal, vertical


def _measure(unit: str, exponent: int) -> str:
    return " ".join(filter(None, (f"10{superscript(exponent)}" if exponent else "", shortened(raised(unit), AXIS_NAME))))


def _description(plot: Plot, curves: tuple[Curve, ...]) -> str:
    """A text alternative of the picture."""
    horizontal, vertical = axis_titles(plot)
    rows = [
        f"{shortened(curve.name)}: from {values[0]:.3g} to {values[-1]:.3g}, lowest {values.min():.3g}, highest {values.max():.3g}"
        for curve in curves[:MOST_SHOWN]
        for values in (curve.values,)
    ]
    return f"{vertical} over {horizontal}, {plot.times[0]:g} to {plot.times[-1]:g} s. {'; '.join(rows)}.".replace("-", "−")


def _path(number: int, curve: Curve, cells: np.ndarray, twin: bool) -> str:
    (x, y), steps = cells[:, 0], np.diff(cells).T.tolist()
    data = f"M{x} {y}l" + " ".join(f"{a} {b}" for a, b in steps).replace(" -", "-")
    return f'<path class="{_classes(curve.color)}{" twin" if twin else ""}" data-number="{number}" d="{data}"/>'


def _legend(plot: Plot, functions: PlotFunctions) -> str:
    """Names, of lines as buttons that show and hide them, each with space for its value; of many curves with a search."""
    rows, has_lines, curves = [], len(plot.times) > 1, plot.curves if len(plot.times) > 1 else plot.curves[:MOST_SHOWN]
    for number, curve in enumerate(curves):
        name, data = html.escape(curve.name), ""
        entry = (
            f'<svg width="26" height="8" aria-hidden="true"><path class="{_classes(curve.color)}" d="M1 4H25"/></svg>'
            f"<span>{name}</span>"
        )
        if has_lines:
            title = f' title="{name}"' if len(curve.name) > AXIS_NAME else ""
            pressed = "true" if number < MOST_SHOWN else "false"
            entry = f'<button type="button" aria-pressed="{pressed}"{title}>{entry}</button><span class="value"></span>'
            across = (plot.across,) if plot.across else ()
            places = " ".join(f"{number} {row}" for number, row in (functions.place(plot, each) for each in (*across, curve)))
            data = f' data-function="{places}"'
        rows.append(f"<li{data}>{entry}</li>")
    choice = ""
    if has_lines and len(curves) > FEW_CURVES:
        choice = (
            '<div class="choice"><input type="search" placeholder="find a name" aria-label="find a name">'
            '<button type="button" data-choice="all">Show all</button><button type="button" data-choice="none">Hide all</button></div>\n'
        )
    return f'{choice}<ul class="legend{" many" if choice else ""}">{"".join(rows)}</ul>'


def _classes(number: int) -> str:
    """Classes of the style sheet: a colour, and another pattern of dashes for each further round through the colours."""
    dashes = number // COLORS % DASHES
    return f"curve c{number % COLORS}" + (f" d{dashes}" if dashes else "")


def plotted(x: np.ndarray, y: np.ndarray, *, phase: bool) -> np.ndarray:
    """The drawn points of a curve: all, or the extremes of each pixel column; of a phase plane evenly chosen ones."""
    kept = _sparse(x) if phase else _kept(x, y)
    return np.rint(np.array([x[kept], y[kept]])).astype(int)


def _sparse(x: np.ndarray) -> np.ndarray:
    """Indices of the drawn points of a phase curve: at most ``MOST_POINTS``, evenly chosen."""
    return np.linspace(0, len(x) - 1, min(len(x), MOST_POINTS)).round().astype(int)


def _kept(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    if len(x) <= MOST_POINTS:
        return np.arange(len(x))
    edges = np.unique(np.searchsorted(x, np.linspace(x[0], x[-1], MOST_POINTS // 2 + 1)[:-1]).tolist() + [len(x)])
    extremes = [(a + y[a:b].argmin(), a + y[a:b].argmax()) for a, b in pairwise(edges)]
    return np.unique(np.concatenate([[0, len(x) - 1], np.ravel(extremes)]))
