"""Plots: as inline SVG of the page, readable without scripts, and as images drawn by matplotlib for reports.

The origin of the picture is the upper left corner of its axes; horizontal positions are in percent of their width and
vertical ones in pixels. The curves lie in a square of ``CELLS`` by ``CELLS`` that is stretched over the axes, and are
written in whole cells from point to point. The first of many curves are drawn here, the others by the page's script, which also
draws the part of all of them that a zoomed plot shows: from the functions in ``readings.py``, which give it the values next to the
names, too.

Matplotlib is imported when an image is drawn, never before; its pyplot, which keeps figures in a global place, never.
"""

from __future__ import annotations

import html
import io
import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import groupby, pairwise, zip_longest
from textwrap import fill
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..ground.display import phase_labels
from .animation import packed
from .content import (
    LEAST_SHARE,
    MOST_SHOWN,
    Axis,
    Cells,
    Curve,
    Marks,
    Plot,
    TimeFunctions,
    axis_of,
    is_power,
    measured,
    raised,
    shortened,
    superscript,
    typeset,
    unit_text,
)
from .figure import PALETTE
from .readings import Readings, RecordReadings, RecordSteps, linear_readings, readings_of, record_readings, record_steps

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Height of the axes and of those of a large plot, px.
HEIGHT, LARGE_HEIGHT = 214, 400

#: Size of the square that the curves are written in, in cells.
CELLS = 10_000

#: A curve of more points than the picture has pixels is drawn by the lowest and highest value of each pixel column.
MOST_POINTS = 2400

#: With more curves than this the names can be searched, and all be shown or hidden at once.
FEW_CURVES = 12

#: Width of a letter, space between labels, the narrowest horizontal axis on a desktop and on a phone, px.
LETTER, SPACE, WIDTHS = 7.4, 8, (340, 260)

#: The usual margin on the left, for labels of so many letters, and the height of a row with its name, px.
MARGIN, MARGIN_LETTERS, ROW_HEIGHT = 70, 6, 34

#: A label with more letters ends near the end of its axis when it is beyond this share of it.
END, END_LETTERS = 0.98, 4

#: Beyond this share of an axis there is no room for the name of a line.
NEAR_END = 0.9

#: Letters of the name of an axis, of a unit, and of a name in a legend; longer ones are shortened.
AXIS_NAME, UNIT, LEGEND_NAME = 120, 40, 120

#: Names of curves with at most so many letters stand in two columns on a phone.
SHORT = 13

#: Colours of curves in the style sheet, and patterns of dashes: one for each round through the colours.
COLORS, DASHES = 6, 4

#: Curves that differ by less than this share of the height coincide in the picture.
COINCIDE = 1 / 200

#: Shapes of marks, in px about their point.
MARKS = {"circle": "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0z", "cross": "M-4-4L4 4M-4 4L4-4", "diamond": "M0-5L5 0L0 5L-5 0z"}
MARKS["dot"] = "M-2 0a2 2 0 1 0 4 0a2 2 0 1 0-4 0z"

#: Colours of the cells of a map, from low to high: even steps of brightness, for colour-blind readers too; grey means no value.
CELL_COLORS = ("#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725")

#: Colours of phases, light and dark: Tol's muted scheme, which is distinct with any kind of colour vision, each next to one of another
#: brightness. A further round through them has bars of two thirds of the height, then of one.
PHASE_COLORS = (
    ("#332288", "#8f85e6"),
    ("#ddcc77", "#ddcc77"),
    ("#44aa99", "#3a9585"),
    ("#cc6677", "#e98a99"),
    ("#88ccee", "#a9ddf7"),
    ("#882255", "#b3447d"),
    ("#999933", "#b5b54a"),
    ("#aa4499", "#cf74c2"),
)

#: Height of the band of phases in thirds, and in px; letters of the name of a phase.
THIRDS, BAND, PHASE_NAME = 3, 6, 80

HELP = (
    "To zoom into a plot turn the wheel, pinch, or press + and −; drag or press the arrow keys to move the part that is shown; "
    "double-click or press 0 for the whole. A click on a name shows or hides its curve, a double click shows it alone."
)


class PlotFunctions:
    """The functions behind the curves of a page, numbered as the page's script finds them."""

    def __init__(self, plots: tuple[Plot, ...]):
        self.phases = next((plot.phases for plot in plots if plot.phases), ())
        drawn = [plot for plot in plots if plot.curves and len(plot.times) > 1]
        self.needed = bool(drawn) or any(plot.cells for plot in plots)
        self.sets: list[tuple[Readings | RecordReadings, ...]] = []
        self.records: list[RecordSteps] = []
        self._steps: dict[tuple, int | None] = {}
        self._places: dict[tuple, tuple[int, int]] = {}
        shared: dict[tuple, tuple[TimeFunctions, list[int]]] = {}
        for plot in drawn:
            own: dict[tuple, np.ndarray] = {}
            for values, function in (each for curve in plot.curves for each in _functions(plot, curve)):
                if function is None:
                    own.setdefault((id(plot), id(values)), values)
                    continue
                functions, row = function
                rows = shared.setdefault((id(functions), plot.times[0], plot.times[-1]), (functions, []))[1]
                if row not in rows:
                    rows.append(row)
            if own:
                self._places |= {key: (len(self.sets), row) for row, key in enumerate(own)}
                self.sets.append((linear_readings(plot.times, np.array(list(own.values()))),))
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

    def places(self, plot: Plot, curve: Curve) -> list[tuple[int, int]]:
        """Positions of the functions of a curve; in a phase plane first that along the horizontal axis."""
        return [
            self._places[id(plot), id(values)]
            if function is None
            else self._places[id(function[0]), plot.times[0], plot.times[-1], function[1]]
            for values, function in _functions(plot, curve)
        ]

    def as_data(self) -> dict[str, Any]:
        data: dict[str, Any] = {
            "records": [steps.as_data() for steps in self.records],
            "sets": [[part.as_data() for part in parts] for parts in self.sets],
        }
        if self.phases:
            begins, names = zip(*self.phases)
            data["phases"] = {"begins": packed(np.array(begins), "<f8"), "names": list(names)}
        return data


def _functions(plot: Plot, curve: Curve) -> Iterator[tuple[np.ndarray, tuple[TimeFunctions, int] | None]]:
    """Values and function of a curve along each axis that is not the time."""
    if plot.across:
        yield plot.along(curve), plot.across.function if curve.along is None else None
    yield curve.values, curve.function


def _selected(functions: TimeFunctions, rows: list[int]) -> TimeFunctions:
    return replace(functions, at=lambda times: functions.at(times)[rows])


def plot_figures(plots: tuple[Plot, ...], functions: PlotFunctions | None = None, *, with_help: bool = True) -> str:
    """All plots, in pairs side by side where the window is wide enough; large ones and those without a neighbour have the full width."""
    functions, texts = functions or PlotFunctions(plots), []
    for is_large, group in groupby(plots, lambda plot: plot.is_large):
        own = list(group)
        paired = 0 if is_large else len(own) - len(own) % 2
        texts += [_figure(plot, functions, " wide" if i >= paired else "") for i, plot in enumerate(own)]
    figures = "\n".join(texts)
    note = f'\n<p class="note plot-help">{HELP}</p>' if functions.needed and with_help else ""
    return f'<div class="plots">\n{figures}\n</div>{note}' if plots else ""


def _figure(plot: Plot, functions: PlotFunctions, wide: str) -> str:
    count, body = len(plot.curves), '<p class="note">no curves</p>'
    note = f'\n<p class="note">{typeset(plot.note)}</p>' if plot.note else ""
    if count or plot.cells:
        above, below = (
            f'<p class="axis-name">{arrow} {html.escape(name)}</p>\n' if name else ""
            for arrow, name in zip("↑→", _long_names(plot))
        )
        body = f"{above}{_svg(plot)}\n{below}{_legend(plot, functions)}"
    if count > plot.shown:
        note += f'\n<p class="note">{count} curves, {plot.shown} of them shown at first</p>'
    return f'<figure class="plot-figure{wide}">\n<h2>{html.escape(plot.title)}</h2>\n{body}{note}\n</figure>'


def _height(plot: Plot) -> int:
    """Height of the axes in px; names of rows do not lie on the marks of others."""
    up = plot.axes[1]
    return max(HEIGHT, round(ROW_HEIGHT * (up.high - up.low))) if up.scale == "rows" else LARGE_HEIGHT if plot.is_large else HEIGHT


def _long_names(plot: Plot) -> tuple[str, str]:
    """The names of the vertical and of the horizontal axis that are longer than these: paragraphs above and below the picture."""
    across, up = plot.axes
    right, upwards = axis_titles(plot, across.exponent, up.exponent)
    return upwards if LETTER * len(upwards) > _height(plot) else "", right if LETTER * len(right) > WIDTHS[1] else ""


def _svg(plot: Plot) -> str:
    """The picture alone; its data attributes describe the axes for the script."""
    times, phase = plot.times, plot.across is not None
    across, up = plot.axes
    shown, height = plot.curves[: plot.shown], _height(plot)
    x = np.array([_cells(across, plot.along(curve)) for curve in shown]).reshape(len(shown), len(times))
    y = CELLS - np.array([_cells(up, curve.values) for curve in shown]).reshape(len(shown), len(times))
    names = zip(axis_titles(plot, across.exponent, up.exponent), reversed(_long_names(plot)))
    right, upwards = (html.escape("" if long else name) for name, long in names)
    letters = max(map(len, up.labels), default=0)
    style = f"--left: {MARGIN + LETTER * (letters - MARGIN_LETTERS):.0f}px; " if letters > MARGIN_LETTERS else ""
    style += f"height: {height}px" if height not in (HEIGHT, LARGE_HEIGHT) or up.scale == "rows" else ""
    style = f' style="{style.rstrip("; ")}"' if style else ""
    elements = [
        f'<g class="ticks">\n{_grid(across, up, height)}\n{_guide_names(plot, across, up, height)}</g>',
        *_guides(plot, across, up),
        *_phase_band(plot, across, height),
        f'<text x="50%" y="{height + 38}" text-anchor="middle">{right}</text>',
        f'<text class="up-name" style="--middle: {height // 2}px" text-anchor="middle">{upwards}</text>',
    ]
    if len(times) == 1:
        elements += [
            f'<circle class="{_classes(curve.color)}" cx="{100 * a[0] / CELLS:.2f}%" cy="{height * b[0] / CELLS:.1f}" r="3.5"/>'
            for curve, a, b in zip(shown, x, y)
        ]
    else:
        order = np.argsort(-np.ptp(y, axis=1), kind="stable")  # the smallest is drawn last, so that no larger one hides it
        paths = []
        for number, twin in zip(order.tolist(), _coinciding(np.hstack([x, y])[order])):
            ends = [slice(a, b + 1) for a, b in shown[number].parts]
            paths.append(
                _path(number, shown[number], [plotted(x[number, part], y[number, part], phase=phase) for part in ends], twin)
            )
        curves = "\n".join(paths)
        elements.append(f'<svg class="curves" viewBox="0 0 {CELLS} {CELLS}" preserveAspectRatio="none">\n{curves}\n</svg>')
    elements += _marks(plot, across, up, height)
    over = "phase" if phase else html.escape(plot.variable)
    variable = f' data-variable="{html.escape(plot.variable)}"' if phase and plot.variable != "time" else ""
    variable += "" if plot.variable_unit is None else f' data-variable-unit="{html.escape(unit_text(plot.variable_unit))}"'
    return (
        f'<svg class="plot{" large" * plot.is_large}"{style} role="img" tabindex="0"'
        f' aria-label="{html.escape(_description(plot, plot.curves))}"'
        f' data-start="{float(times[0])!r}" data-end="{float(times[-1])!r}" data-over="{over}"{variable}'
        f' data-name="{html.escape(plot.across_name)}" data-up-name="{html.escape(plot.quantity or plot.title)}"'
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
    return f'data-{name}="{ends}" data-{name}-unit="{html.escape(shortened(unit_text(unit), UNIT))}"'


def _grid(across: Axis, up: Axis, height: int) -> str:
    """Lines and labels; horizontal labels that would meet are left out, where the window is narrow more of them."""
    lines = []
    desktop = _labelled(across, range(len(across.ticks)), WIDTHS[0])
    phone = _labelled(across, desktop, WIDTHS[1])
    for i, (x, label) in enumerate(zip(_cells(across, np.array(across.ticks)), across.labels)):
        place, kind = f"{100 * x / CELLS:.2f}%", "" if i in phone else ' class="second"'
        lines.append(f'<line class="grid" x1="{place}" x2="{place}" y2="{height}"/>')
        if i in desktop:
            anchor = 'dx="14" text-anchor="end"' if x > END * CELLS and len(label) > END_LETTERS else 'text-anchor="middle"'
            lines.append(f'<text{kind} x="{place}" y="{height + 18}" {anchor}>{label}</text>')
    for tick, y, label in zip(up.ticks, _cells(up, np.array(up.ticks)), up.labels):
        down = height * (1 - y / CELLS)
        lines.append(f'<line class="{"axis" if tick == 0 else "grid"}" x2="100%" y1="{down:.1f}" y2="{down:.1f}"/>')
        lines.append(f'<text x="-8" y="{down + 4:.1f}" text-anchor="end">{label}</text>')
    lines.append(f'<line class="axis" y2="{height}"/><line class="axis" x2="100%" y1="{height}" y2="{height}"/>')
    return "\n".join(lines)


def _labelled(axis: Axis, places: Sequence[int], width: float) -> Sequence[int]:
    """Places of ticks whose labels do not meet on an axis of this width in px: all, powers of ten, or some at even steps."""
    shares = axis.shares(np.array(axis.ticks))
    decades = [i for i in places if axis.scale == "log" and is_power(axis.ticks[i])] or places

    def is_clear(kept: Sequence[int]) -> bool:
        letters = ((len(axis.labels[a]) + len(axis.labels[b])) / 2 for a, b in pairwise(kept))
        return all(width * (shares[b] - shares[a]) >= LETTER * count + SPACE for (a, b), count in zip(pairwise(kept), letters))

    return next(kept for kept in (places, *(decades[::step] for step in range(1, len(places) + 1))) if is_clear(kept))


def _guides(plot: Plot, across: Axis, up: Axis) -> list[str]:
    """Bands and guide lines, in a separate picture with the view of the curves."""
    lines = [
        f'<rect class="band" x="{left:.0f}" width="{right - left:.0f}" height="{CELLS}"/>'
        for left, right in (_cells(across, np.array(band)) for band in plot.bands)
    ]
    for guide in plot.guides:
        if ends := guide.ends(across, up):
            (a, b), (c, d) = ends
            data = f"M{CELLS * a:.0f} {CELLS * (1 - b):.0f}L{CELLS * c:.0f} {CELLS * (1 - d):.0f}"
            name = f' data-name="{html.escape(guide.name)}"' if guide.name else ""
            lines.append(f'<path class="guide {guide.kind}"{name} d="{data}"/>')
    lines = [*_cell_rectangles(plot.cells, across, up), *lines] if plot.cells else lines
    if not lines:
        return []
    cells = f' data-cells="true" data-unit="{html.escape(unit_text(plot.cells.unit))}"' if plot.cells else ""
    return [f'<svg class="guides"{cells} viewBox="0 0 {CELLS} {CELLS}" preserveAspectRatio="none">{"".join(lines)}</svg>']


def _phase_band(plot: Plot, across: Axis, height: int) -> Iterator[str]:
    """The phases, in a separate picture with the horizontal view of the curves; the shortest are drawn last, at least a pixel wide."""
    ranges = plot.phase_ranges
    if ranges:
        order = sorted(ranges, key=lambda name: -sum(end - begin for begin, end in ranges[name]))
        paths = "".join(_phase_path(name, list(ranges).index(name), _cells(across, np.array(ranges[name]))) for name in order)
        view = f'viewBox="0 0 {CELLS} {THIRDS}" preserveAspectRatio="none"'
        yield f'<svg class="phases" y="{height + 1}" height="{BAND}" {view}>{paths}</svg>'


def _phase_path(name: str, number: int, ranges: np.ndarray) -> str:
    tall = _thirds(number)
    data = "".join(f"M{begin:.6g} {THIRDS}V{THIRDS - tall}H{end:.6g}V{THIRDS}z" for begin, end in ranges.tolist())
    return f'<path {_phase_color(number)} stroke="currentColor" vector-effect="non-scaling-stroke" d="{data}"><title>{html.escape(name)}</title></path>'


def _phase_color(number: int) -> str:
    light, dark = PHASE_COLORS[number % len(PHASE_COLORS)]
    return f'fill="currentColor" style="color: light-dark({light}, {dark})"'


def _thirds(number: int) -> int:
    """Height of the bars of a phase, in thirds of the band."""
    return THIRDS - number // len(PHASE_COLORS) % THIRDS


def _cell_rectangles(cells: Cells, across: Axis, up: Axis) -> Iterator[str]:
    """The cells of a map, with their texts."""
    x, y = np.rint(_cells(across, cells.across)).astype(int), CELLS - np.rint(_cells(up, cells.up)).astype(int)
    across_places, up_places = (row.tolist() for row in cells.places)
    for row, (colors, texts) in enumerate(zip(_colors(cells), cells.texts)):
        for column, (color, text) in enumerate(zip(colors, texts)):
            size = f'width="{x[column + 1] - x[column]}" height="{y[row] - y[row + 1]}"'
            place = f"{across_places[column]!r} {up_places[row]!r} {float(cells.values[row, column])!r}"
            look = f'fill="{color}"' if color else 'class="unknown"'
            yield f'<rect x="{x[column]}" y="{y[row + 1]}" {size} {look} data-at="{place}"><title>{html.escape(raised(text))}</title></rect>'


def _colors(cells: Cells) -> list[list[str]]:
    """Colours of the cells, empty where there is no value."""
    low, high = cells.ends
    anchors = np.array([[int(color[i : i + 2], 16) for i in (1, 3, 5)] for color in CELL_COLORS])
    places = (len(anchors) - 1) * (cells.values - low) / ((high - low) or 1.0)
    channels = np.array([np.interp(np.nan_to_num(places), range(len(anchors)), channel) for channel in anchors.T])
    known = np.isfinite(cells.values)
    return [
        [f"#{r:02x}{g:02x}{b:02x}" if shown else "" for (r, g, b), shown in zip(row, own)]
        for row, own in zip(np.rint(np.moveaxis(channels, 0, -1)).astype(int).tolist(), known)
    ]


def _guide_names(plot: Plot, across: Axis, up: Axis, height: int) -> str:
    """Names next to the ends of the lines, where the lines themselves do not pass."""
    texts = []
    for guide in plot.guides:
        if guide.name and (ends := guide.ends(across, up)):
            (x, y), rises = ends[1], ends[1][1] > ends[0][1]
            is_at_side, is_right_of_line = not LEAST_SHARE < x < 1 - LEAST_SHARE, ends[0][0] < x < NEAR_END and y > 1 - LEAST_SHARE
            down = height * (1 - y) + (-4 if rises and is_at_side and y < NEAR_END else 11)
            anchor, away = ("start", 4) if x < LEAST_SHARE or is_right_of_line else ("end", -4)
            place = f'x="{100 * x:.2f}%" y="{min(down, height - 3):.1f}" dx="{away}" text-anchor="{anchor}"'
            texts.append(f'<text class="guide-name" {place}>{html.escape(guide.name)}</text>\n')
    return "".join(texts)


def _marks(plot: Plot, across: Axis, up: Axis, height: int) -> Iterator[str]:
    """Marks at their places, with their values for the script."""
    for marks in plot.marks:
        own = "" if marks.curve is None else f' data-curve="{marks.curve}"'
        own += ' visibility="hidden"' * (marks.curve is not None and marks.curve >= plot.shown)
        for point, text in zip_longest(marks.points.tolist(), marks.texts, fillvalue=""):
            x, y = (float(axis.shares(value)) for axis, value in zip((across, up), point))
            title = html.escape(raised(text))
            title = title if marks.shape == "text" else f"<title>{title}</title>" if text else ""
            place = f'x="{100 * x:.2f}%" y="{height * (1 - y):.1f}" data-at="{point[0]!r} {point[1]!r}"'
            yield f'<svg class="mark" {place}{own}>{_mark(plot, marks, title)}</svg>'


def _mark(plot: Plot, marks: Marks, title: str = "") -> str:
    if marks.shape == "text":
        return f'<text class="guide-name" dx="4" dy="-8">{title}</text>'
    color = "" if marks.curve is None else f" c{(plot.curves[marks.curve].color or 0) % COLORS}"
    return f'<path class="{marks.shape}{color}" d="{MARKS[marks.shape]}">{title}</path>'


def axis_titles(plot: Plot, across: int = 0, up: int = 0) -> tuple[str, str]:
    """The titles of the axes, such as "displacement in 10⁻³ m"."""
    rows = (plot.across_name, plot.across_unit, across), (plot.quantity or plot.title, plot.unit, up)
    titles = []
    for name, unit, power in rows:
        measure = " ".join(filter(None, (f"10{superscript(power)}" if power else "", shortened(unit_text(unit), UNIT))))
        titles.append(" in ".join(filter(None, (shortened(name, AXIS_NAME), measure))))
    return titles[0], titles[1]


def _description(plot: Plot, curves: tuple[Curve, ...]) -> str:
    """A text alternative of the picture."""
    horizontal, vertical = axis_titles(plot)
    rows = [
        f"{shortened(curve.name)}: from {values[0]:.3g} to {values[-1]:.3g}, lowest {values.min():.3g}, highest {values.max():.3g}"
        for curve in curves[:MOST_SHOWN]
        for values in (curve.values if curve.drawn is None else curve.values[curve.drawn],)
        if len(values)
    ]
    unit = (plot.variable_unit or "s") if plot.across else plot.across_unit
    along = f"{plot.times[0]:g} to {plot.times[-1]:g} {unit}".rstrip()
    return f"{vertical} over {horizontal}, {along}. {'; '.join(rows)}.".replace("-", "−")


def _path(number: int, curve: Curve, parts: list[np.ndarray], twin: bool) -> str:
    """A curve from its first point in relative steps; a part begins at the end of the one before."""
    data, last = "", np.zeros(2, dtype=int)
    for cells in parts:
        (x, y), steps = cells[:, 0] - last, np.diff(cells).T.tolist() or [[0, 0]]  # a single point is a dot
        last = cells[:, -1]
        data += f"{'m' if data else 'M'}{x} {y}l" + " ".join(f"{a} {b}" for a, b in steps).replace(" -", "-")
    return f'<path class="{_classes(curve.color)}{" twin" if twin else ""}" data-number="{number}" d="{data}"/>'


def _legend(plot: Plot, functions: PlotFunctions) -> str:
    """Names, of lines as buttons that show and hide them, each with space for its value; of many curves with a search."""
    rows, has_lines, curves = [], len(plot.times) > 1, plot.curves if len(plot.times) > 1 else plot.curves[: plot.shown]
    own_marks = {marks.curve: marks for marks in plot.marks}
    for number, curve in enumerate(curves):
        name, data = html.escape(curve.name), ""
        sample = f'height="8"><path class="{_classes(curve.color)}" d="M1 4H25"/>'
        if not curve.parts and number in own_marks:  # nothing but marks
            sample = f'height="12" viewBox="-13 -6 26 12"><g class="mark">{_mark(plot, own_marks[number])}</g>'
        entry = f'<svg width="26" aria-hidden="true" {sample}</svg><span>{name}</span>'
        if has_lines:
            pressed = "true" if number < plot.shown else "false"
            entry = f'<button type="button" aria-pressed="{pressed}">{entry}</button><span class="value"></span>'
            data = f' data-function="{" ".join(f"{number} {row}" for number, row in functions.places(plot, curve))}"'
            if curve.drawn is not None:
                ends = " ".join(f"{float(plot.times[i])!r}" for part in curve.parts for i in part)
                data += f' data-parts="{ends}"'
        rows.append(f"<li{data}>{entry}</li>")
    rows += [
        f'<li class="of-marks"><svg width="26" height="12" viewBox="-13 -6 26 12" aria-hidden="true">{_mark(plot, replace(marks, curve=None))}</svg>'
        f"<span>{html.escape(marks.name)}</span></li>"
        for marks in {marks.name: marks for marks in plot.marks if marks.name}.values()
    ]
    for number, (name, label) in enumerate(phase_labels(plot.phase_ranges).items()):
        tall = 3 * _thirds(number)
        swatch = f'<rect {_phase_color(number)} y="{9 - tall}" width="26" height="{tall}"/>'
        rows.append(
            f'<li class="of-phase" data-phase="{html.escape(name)}"><svg width="26" height="9" aria-hidden="true">{swatch}</svg>'
            f'<span title="{html.escape(name)}">{html.escape(shortened(label, PHASE_NAME))}</span></li>'
        )
    if plot.cells:
        low, high = (measured(end, plot.cells.unit) for end in plot.cells.ends)
        bar = "".join(f'<rect x="{10 * i}" width="10" height="10" fill="{color}"/>' for i, color in enumerate(CELL_COLORS))
        rows.append(
            f'<li class="of-marks">{typeset(low)} <svg width="90" height="10" aria-hidden="true">{bar}</svg> {typeset(high)}</li>'
        )
    choice = ""
    if has_lines and len(curves) > FEW_CURVES:
        choice = (
            '<div class="choice"><input type="search" placeholder="find a name" aria-label="find a name">'
            '<button type="button" data-choice="all">Show all</button><button type="button" data-choice="none">Hide all</button></div>\n'
        )
    kinds = " many" * bool(choice) + " short" * (
        has_lines and plot.across is None and 0 < max((len(curve.name) for curve in curves), default=0) <= SHORT
    )
    return f'{choice}<ul class="legend{kinds}">{"".join(rows)}</ul>'


def _classes(number: int) -> str:
    """Classes of the style sheet: a colour, and another pattern of dashes for each further round through the colours."""
    dashes = number // COLORS % DASHES
    return f"curve c{number % COLORS}" + (f" d{dashes}" if dashes else "")


def plotted(x: np.ndarray, y: np.ndarray, *, phase: bool) -> np.ndarray:
    """The drawn points of a curve: all, or the extremes of each pixel column; of a phase plane evenly chosen ones."""
    kept = np.linspace(0, len(x) - 1, min(len(x), MOST_POINTS)).round().astype(int) if phase else _kept(x, y)
    return np.rint(np.array([x[kept], y[kept]])).astype(int)


def _kept(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    if len(x) <= MOST_POINTS:
        return np.arange(len(x))
    edges = np.unique(np.searchsorted(x, np.linspace(x[0], x[-1], MOST_POINTS // 2 + 1)[:-1]).tolist() + [len(x)])
    extremes = [(a + y[a:b].argmin(), a + y[a:b].argmax()) for a, b in pairwise(edges)]
    return np.unique(np.concatenate([[0, len(x) - 1], np.ravel(extremes)]))


#: Curves of an image: more are indistinct.
MOST_CURVES = 24

#: Size of an image without its legend, half a page of a report, and the height of a large one, inches.
IMAGE_WIDTH, IMAGE_HEIGHT, LARGE_IMAGE_HEIGHT = 6.4, 3.1, 4.4

#: Width of one of several panels, inches; letters on a line of a title, of the names of the axes and of a legend; those of one panel.
PANEL_WIDTH, TITLE, ACROSS_NAME, UP_NAME, LEGEND_LINE, PANEL_TITLE = 3.2, 58, 80, 38, 30, 26

#: Width of the axes of a single plot, in the px in which letters have the width of those of a page.
IMAGE_PIXELS = 480

#: Height of a row with its name and of a further line of a title or of the name of an axis, inches.
IMAGE_ROW, LINE_HEIGHT = 0.3, 0.17

#: For each round through the colours another pattern of dashes, in widths of the line; the first is solid.
_DASHES = (None, (4, 2.2), (1.2, 2.2), (5, 2.2, 1.2, 2.2))

#: Marks of matplotlib by shape.
_MARKERS = {"circle": "o", "cross": "x", "diamond": "D", "dot": "."}

#: Height of the band of phases relative to the axes.
PHASE_HEIGHT = 0.035

#: Height of a row of the legend, width of the line before a name and of a letter, inches.
_ROW, _SAMPLE, _LETTER = 0.19, 0.6, 0.075

#: Colours of text, secondary text, lines and grid as in page.css, and a red for limits.
INK, MUTED, LINE, GRID, RED = "#1c2530", "#5d6b79", "#b5c0ca", "#e8edf1", "#c8102e"

#: Resolution of PNG files, dots per inch.
DPI = 160

_STYLE = {
    "text.parse_math": False,  # "$x_1$" in a user's name is that name
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "mbconstrained",  # names within the SVG depend on what they name only
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # comes with matplotlib: the same picture everywhere
    "font.size": 8.5,
    "axes.titlesize": 9,
    "axes.labelsize": 8.5,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8.5,
    "text.color": INK,
    "axes.titlecolor": INK,
    "axes.labelcolor": MUTED,
    "xtick.color": LINE,
    "ytick.color": LINE,
    "xtick.labelcolor": MUTED,
    "ytick.labelcolor": MUTED,
    "axes.edgecolor": LINE,
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.major.size": 3,
    "ytick.major.size": 3,
    "xtick.minor.size": 0,
    "ytick.minor.size": 0,
    "lines.linewidth": 1.4,
    "legend.frameon": False,
    "legend.handlelength": 2.6,
}


def new_axes() -> Axes:
    """Axes in a new figure, for Matplotlib's interactive window or a notebook."""
    from matplotlib import pyplot

    return pyplot.figure(layout="constrained").add_subplot()


def drawn_image(draw: Callable[[Figure], None], width: float, height: float, kind: Literal["svg", "png"]) -> bytes:
    """An image in the style of the page, whatever settings the user has; the same content gives the same bytes.

    >>> drawn_image(lambda figure: None, 1.0, 1.0, "png")[1:4]
    b'PNG'
    """
    file, undated = io.BytesIO(), {"Date": None} if kind == "svg" else {"Software": None}
    with page_style():
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=(width, height), layout="constrained", facecolor="white")
        FigureCanvasAgg(figure)
        draw(figure)
        figure.savefig(file, format=kind, dpi=DPI, metadata=undated)
    return file.getvalue()


@contextmanager
def page_style(**others: object) -> Iterator[None]:
    """The style of the page, and others, as matplotlib's settings, whatever the user has set; restored afterwards."""
    import matplotlib.style

    with matplotlib.style.context({**_STYLE, **others}, after_reset=True), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")  # a box in the file; the page has the browser's fonts
        yield


def plot_images(plots: Iterable[Plot]) -> dict[str, Plot]:
    """The plots that have curves, by unique names for their files, such as "angular-velocity".

    >>> import numpy as np
    >>> plots = [Plot("angular velocity", unit, np.array([0.0]), (Curve("a", np.array([1.0])),)) for unit in ("rad/s", "1")]
    >>> list(plot_images(plots))
    ['angular-velocity', 'angular-velocity-2']
    """
    images: dict[str, Plot] = {}
    for plot in plots:
        name = re.sub(r"[^\w]+", "-", plot.title).strip("-") or "plot"
        count = sum(other.title == plot.title for other in images.values())
        if plot.curves or plot.cells:
            images[f"{name}-{count + 1}" if count else name] = plot
    return images


def plot_image(plot: Plot | Sequence[Plot], kind: Literal["svg", "png"]) -> bytes:
    """The image of a plot, or of several side by side; of more curves than a page can show, as many as it can.

    >>> import numpy as np
    >>> plot_image(Plot("speed", "m/s", np.array([0.0, 1.0]), (Curve("cart", np.array([0.0, 2.0])),)), "png")[1:4]
    b'PNG'
    """
    panels = (plot,) if isinstance(plot, Plot) else tuple(plot)
    first, width = panels[0], IMAGE_WIDTH if len(panels) == 1 else PANEL_WIDTH * len(panels)
    names = [*_legend_names(first), *dict.fromkeys(marks.name for marks in first.marks if marks.name)]
    letters = max((len(line) for name in names for line in name.split("\n")), default=0)
    columns = max(1, min(len(names), int((width - 0.3) / (_SAMPLE + _LETTER * letters))))
    rows = -(-len(names) // columns)
    lines = sum(max(name.count("\n") + 1 for name in names[row::rows]) for row in range(rows))
    titles = max(own.count("\n") for each in panels for own in _image_titles(each, len(panels)))

    def draw(figure: Figure) -> None:
        axes = [figure.add_subplot(1, len(panels), number) for number in range(1, len(panels) + 1)]
        has_names = [_draw(each, own, len(panels)) for each, own in zip(axes, panels)]
        if has_names[0]:
            handles, texts = axes[0].get_legend_handles_labels()
            style = {"ncols": columns, "labelcolor": INK, "handlelength": 2.2, "columnspacing": 1.6}
            figure.legend(handles, texts, loc="outside lower left", **style)

    height = max(map(_image_height, panels)) + LINE_HEIGHT * titles
    return drawn_image(draw, width, height + _ROW * lines, kind)


def _legend_names(plot: Plot) -> list[str]:
    """Names of curves and phases, on lines that fit."""
    names = (*(curve.name for curve in plot.curves[: _most(plot)]), *phase_labels(plot.phase_ranges).values())
    return [fill(shortened(name, LEGEND_NAME), LEGEND_LINE) for name in names]


def _image_titles(plot: Plot, panels: int) -> tuple[str, str, str]:
    """Title and names of the horizontal and the vertical axis, on lines that fit."""
    across, up = plot.axes
    letters = (TITLE, ACROSS_NAME, UP_NAME) if panels == 1 else (PANEL_TITLE, PANEL_TITLE, UP_NAME)
    title, right, upwards = (
        fill(text, own)
        for text, own in zip((shortened(plot.title, 2 * AXIS_NAME), *axis_titles(plot, across.exponent, up.exponent)), letters)
    )
    return title, right, upwards


def _image_height(plot: Plot) -> float:
    """Height of the image of a plot without its legend, inches."""
    up = plot.axes[1]
    usual = LARGE_IMAGE_HEIGHT if plot.is_large else IMAGE_HEIGHT
    return max(usual, IMAGE_ROW * (up.high - up.low) + 0.6) if up.scale == "rows" else usual


def image_groups(plots: Iterable[Plot]) -> list[tuple[Plot, ...]]:
    """The plots of each image."""
    groups = groupby(enumerate(plots), lambda pair: pair[1].image or pair[0])
    return [tuple(plot for _, plot in group) for _, group in groups]


def _most(plot: Plot) -> int:
    """Number of curves of an image."""
    return max(MOST_CURVES, plot.shown)


def _draw(axes: Axes, plot: Plot, panels: int) -> bool:
    """Draw a plot, one of so many panels, and return whether its legend is needed."""
    curves, names, (across, up) = plot.curves[: _most(plot)], _legend_names(plot), plot.axes
    marker = "o" if len(plot.times) == 1 else ""
    for curve, name in zip(curves, names):
        dashes = _DASHES[curve.color // len(PALETTE) % len(_DASHES)]
        values = curve.values if curve.drawn is None else np.where(curve.drawn, curve.values, np.nan)
        (line,) = axes.plot(plot.along(curve), values, label=name, marker=marker)
        line.set(color=PALETTE[curve.color % len(PALETTE)], linestyle="-" if dashes is None else (0, dashes))
    axes.set(xscale="log" if across.scale == "log" else "linear", yscale="log" if up.scale == "log" else "linear")
    axes.set_xlim(across.low, across.high)
    axes.set_ylim(up.low, up.high)
    kept = _labelled(across, range(len(across.ticks)), IMAGE_PIXELS / (1 if panels == 1 else 2))
    axes.set_xticks(across.ticks, [label if i in kept else "" for i, label in enumerate(across.labels)])
    axes.set_yticks(up.ticks, up.labels)
    axes.minorticks_off()
    if plot.cells:
        from matplotlib.colors import LinearSegmentedColormap

        colors = LinearSegmentedColormap.from_list("cells", CELL_COLORS)
        mesh = axes.pcolormesh(plot.cells.across, plot.cells.up, np.ma.masked_invalid(plot.cells.values), cmap=colors)
        axes.set_facecolor(LINE)
        axes.grid(False)
        levels = axis_of(*plot.cells.ends, widen=False)
        power = f"10{superscript(levels.exponent)}" if levels.exponent else ""
        scale = axes.figure.colorbar(mesh, ax=axes, label=" ".join(filter(None, (power, unit_text(plot.cells.unit)))))
        scale.set_ticks(levels.ticks, labels=levels.labels)
    for guide in plot.guides:
        if ends := guide.ends(across, up):
            (line,) = axes.plot(*zip(*ends), transform=axes.transAxes, scalex=False, scaley=False)
            if guide.kind == "grid":
                line.set(color=LINE, linewidth=0.5, linestyle="--", zorder=0.8)
            else:
                line.set(color=RED if guide.kind == "limit" else MUTED, linewidth=0.9, zorder=1.5, clip_on=False)
            x, y = ends[1]
            text = axes.text(x, y, guide.name, color=MUTED, fontsize=6.5, transform=axes.transAxes)
            text.set(ha="left" if x < LEAST_SHARE else "right", va="bottom" if y < LEAST_SHARE else "top")
    ranges = plot.phase_ranges
    for number, (name, own) in enumerate(zip(names[len(curves) :], ranges.values())):
        tall = PHASE_HEIGHT * _thirds(number) / THIRDS
        widths = [(begin, end - begin) for begin, end in own]
        bar = axes.broken_barh(widths, (-PHASE_HEIGHT, tall), transform=axes.get_xaxis_transform(), clip_on=False)
        bar.set(color=PHASE_COLORS[number % len(PHASE_COLORS)][0], linewidth=0.5, label=name)
    if ranges:
        axes.tick_params(axis="x", length=0, pad=9)
    for band in plot.bands:
        axes.axvspan(*band, color=RED, alpha=0.12, linewidth=0)
    named = set()
    for marks in plot.marks:
        if marks.shape == "text":
            for point, name in zip(marks.points.tolist(), marks.texts):
                axes.annotate(name, point, (3, 5), textcoords="offset points", color=MUTED, fontsize=7)
        elif marks.curve is None or marks.curve < len(curves):
            color = INK if marks.curve is None else PALETTE[(curves[marks.curve].color or 0) % len(PALETTE)]
            label = marks.name if marks.name not in named else ""
            named.add(marks.name)
            style: dict[str, Any] = {
                "marker": _MARKERS[marks.shape],
                "linestyle": "none",
                "markersize": 4,
                "markerfacecolor": color if marks.shape == "dot" else "white",
            }
            axes.plot(*marks.points.T, color=color, label=label or "_", clip_on=False, zorder=3, **style)
            if marks.curve is not None and not curves[marks.curve].parts:
                axes.lines[marks.curve].set(**style)  # in the legend, too
    if 0.0 in up.ticks:
        axes.axhline(0.0, color=LINE, linewidth=0.8, zorder=0.9)
    title, xlabel, ylabel = _image_titles(plot, panels)
    axes.set(xlabel=xlabel, ylabel=ylabel)
    axes.set_title(title, loc="left", fontsize=10, fontweight="bold", color=INK)
    if len(plot.curves) > MOST_CURVES:
        axes.set_title(f"the first {MOST_CURVES} of {len(plot.curves)} curves", loc="right", fontsize=8, color=MUTED)
    return len(curves) > 1 or plot.across is None or bool(named - {""})
