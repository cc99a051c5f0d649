"""Plots as inline SVG: readable without any script, as wide as there is room for, with texts of one size on every screen.

The origin of the picture is the upper left corner of its axes; places across are in percent of their width and places
down in pixels, so that the browser does the rest. The curves lie in a square of ``CELLS`` by ``CELLS`` that is stretched
over the axes, and are written in whole cells from point to point: a script reads their values from them again.
"""

from __future__ import annotations

import html

import numpy as np

from .plot_content import Curve, PhasePlot, Plot
from .plot_points import CELLS, PlottedPoints, evenly, moment_steps, plotted
from .readings import Coordinates, digits_told
from .ticks import Axis, axis_of
from .typeset import raised, superscript

HEIGHT = 214  # of the axes, in pixels

#: More curves than this in one picture cannot be told apart; the others are there to be shown instead of them.
MOST_SHOWN = 8

#: More curves than this are a burden to the page; the first are kept.
MOST_CURVES = 24

#: More labels than this along an axis do not fit on a phone.
CROWDED = 5

#: Of a name or a unit in a place that has no room for a long one.
LONGEST = 40

#: Colours of curves in the style sheet, and patterns of dashes: one for each round through the colours.
COLORS, DASHES = 6, 4


def plot_figure(plot: Plot | PhasePlot, coordinates: Coordinates | None = None, *, alone: bool = False) -> str:
    """One <figure>: title, axes with units, curves, cursor and legend. Every text of the user is escaped.

    Args:
        coordinates: of the animation on the same page, from which values of curves that show them are read.
        alone: whether it has the width of the page for itself.
    """
    kept, count = plot.curves[:MOST_CURVES], len(plot.curves)
    body = f"{_svg(plot, kept, coordinates)}\n{_legend(kept, len(plot.times) > 1)}" if count else '<p class="note">no curves</p>'
    note = _left_out(count)
    kind = "plot-figure wide" if alone else "plot-figure"
    return f'<figure class="{kind}">\n<h2>{html.escape(plot.title)}</h2>\n{body}{note}\n</figure>'


def _left_out(count: int) -> str:
    if count <= MOST_SHOWN:
        return ""
    kept = f"the first {MOST_CURVES} of {count} curves can be shown" if count > MOST_CURVES else f"{count} curves"
    return f'\n<p class="note">{kept}, {MOST_SHOWN} of them are at first: click on a name to show or hide its curve</p>'


def _svg(plot: Plot | PhasePlot, curves: tuple[Curve, ...], coordinates: Coordinates | None) -> str:
    """The picture alone; its data attributes tell the script what its axes stand for."""
    phase = isinstance(plot, PhasePlot)
    along = plot.displacement if phase else plot.times
    across = axis_of(along.min(), along.max(), widen=phase)
    values = np.array([curve.values for curve in curves])
    up = axis_of(values.min(), values.max())
    x, y = _cells(across, along), CELLS - _cells(up, values)
    names = _names(plot)
    parts, known = [_grid(across, up), _axis_titles(names, across, up)], _digits(across, 0.0)
    if len(along) == 1:
        parts += [_dot(curve, x[0], row[0]) for curve, row in zip(curves, y)]
    else:
        drawn = [plotted(plot.times, x, row, phase=phase) for row in y]
        paths = (_path(*each, _reading(plot, *each[1:], up, coordinates)) for each in zip(range(len(curves)), curves, drawn))
        parts.append(
            f'<svg class="curves" viewBox="0 0 {CELLS} {CELLS}" preserveAspectRatio="none">\n' + "\n".join(paths) + "\n</svg>"
        )
        known = _digits(across, drawn[0].errors[0]) if phase else known
    told = html.escape(_description(plot, curves, names))
    return (
        f'<svg class="plot" role="img" aria-label="{told}"'
        f' data-start="{float(plot.times[0])!r}" data-end="{float(plot.times[-1])!r}"{_moments(plot)}'
        f' {_scale("across", across, names[1])} data-across-digits="{known}" {_scale("up", up, names[3])}>\n'
        + "\n".join(parts)
        + "\n</svg>"
    )


def _digits(axis: Axis, cells: float) -> str:
    """Digits of numbers that may be off by some cells; "none" where none are known."""
    cell = (axis.high - axis.low) / CELLS
    digits = digits_told(cells * cell, axis, cell)
    return "none" if digits is None else str(digits)


def _reading(plot: Plot | PhasePlot, curve: Curve, drawn: PlottedPoints, up: Axis, coordinates: Coordinates | None) -> str:
    """Where the script reads values of a curve, if not from its points, and how many digits of them it tells, or how exact points are."""
    cell = (up.high - up.low) / CELLS
    number = coordinates.number_of(curve, plot.times) if coordinates and isinstance(plot, Plot) else None
    if number is None and drawn.is_whole:
        return f'data-error="{drawn.errors[1]:.3g}"'
    if number is None:
        return f'data-digits="{_digits(up, drawn.errors[1])}"'
    return f'data-digits="{_digits(up, coordinates.error(number) / cell)}" data-coordinate="{number}"'


def _names(plot: Plot | PhasePlot) -> tuple[str, str, str, str]:
    """What is across, its unit, what is up, its unit."""
    if isinstance(plot, Plot):
        return "time", "s", plot.title, plot.unit
    return plot.titles[0], plot.units[0], plot.titles[1], plot.units[1]


def _moments(plot: Plot | PhasePlot) -> str:
    """When points are reached: those of a phase plane one by one, in cells from point to point, unless evenly."""
    even = evenly(plot.times)
    if isinstance(plot, Plot):
        return ' data-even=""' if even else ""
    return f' data-moments="{"" if even else " ".join(map(str, moment_steps(plot.times)))}"'


def _scale(name: str, axis: Axis, unit: str) -> str:
    """What the script tells values by: ends of the axis in the unit of its labels, the power of ten of that, the unit."""
    ends = " ".join(f"{end / 10.0**axis.exponent:.12g}" for end in (axis.low, axis.high))
    return f'data-{name}="{ends} {axis.exponent}" data-{name}-unit="{html.escape(_measure(unit, axis.exponent))}"'


def _cells(axis: Axis, values: np.ndarray) -> np.ndarray:
    return (values - axis.low) * (CELLS / (axis.high - axis.low))


def _grid(across: Axis, up: Axis) -> str:
    """Lines and labels; every other label across is left out where the window is narrow."""
    lines = []
    crowded = len(across.labels) > CROWDED
    for i, (x, label) in enumerate(zip(_cells(across, np.array(across.ticks)), across.labels)):
        place, kind = f"{100 * x / CELLS:.2f}%", ' class="second"' if crowded and i % 2 else ""
        lines.append(f'<line class="grid" x1="{place}" x2="{place}" y2="{HEIGHT}"/>')
        lines.append(f'<text{kind} x="{place}" y="{HEIGHT + 18}" text-anchor="middle">{_signed(label)}</text>')
    for tick, y, label in zip(up.ticks, _cells(up, np.array(up.ticks)), up.labels):
        down = HEIGHT * (1 - y / CELLS)
        lines.append(f'<line class="{"axis" if tick == 0 else "grid"}" x2="100%" y1="{down:.1f}" y2="{down:.1f}"/>')
        lines.append(f'<text x="-8" y="{down + 4:.1f}" text-anchor="end">{_signed(label)}</text>')
    lines.append(f'<line class="axis" y2="{HEIGHT}"/><line class="axis" x2="100%" y1="{HEIGHT}" y2="{HEIGHT}"/>')
    return "\n".join(lines)


def _axis_titles(names: tuple[str, str, str, str], across: Axis, up: Axis) -> str:
    along, unit, upwards, up_unit = names
    return (
        f'<text x="50%" y="{HEIGHT + 38}" text-anchor="middle">{html.escape(_quantity(along, unit, across.exponent))}</text>\n'
        f'<text transform="translate(-58 {HEIGHT // 2}) rotate(-90)" text-anchor="middle">'
        f"{html.escape(_quantity(upwards, up_unit, up.exponent))}</text>"
    )


def _quantity(name: str, unit: str, exponent: int) -> str:
    """Such as "displacement in 10⁻³ m"; a long name would not fit beside the axis and is left to the heading."""
    measure = _measure(unit, exponent)
    return f"{_clipped(name, 20)} in {measure}" if measure else _clipped(name, 20)


def _measure(unit: str, exponent: int) -> str:
    return " ".join(filter(None, (f"10{superscript(exponent)}" if exponent else "", _clipped(raised(unit), 20))))


def _clipped(text: str, most: int = LONGEST) -> str:
    return text if len(text) <= most else text[: most - 1] + "…"


def _description(plot: Plot | PhasePlot, curves: tuple[Curve, ...], names: tuple[str, str, str, str]) -> str:
    """What the picture shows, for those who cannot see it."""
    along, unit, upwards, up_unit = names
    head = f"{_quantity(_clipped(upwards), up_unit, 0)} over {_quantity(along, unit, 0)}"
    rows = [f"{_clipped(curve.name)}: {_course(curve.values)}" for curve in curves[:MOST_SHOWN]]
    return f"{head}, {plot.times[0]:g} to {plot.times[-1]:g} s. {'; '.join(rows)}.".replace("-", "−")


def _course(values: np.ndarray) -> str:
    return f"from {values[0]:.3g} to {values[-1]:.3g}, lowest {values.min():.3g}, highest {values.max():.3g}"


def _path(number: int, curve: Curve, drawn: PlottedPoints, reading: str) -> str:
    (x, y), steps = drawn.cells[:, 0], np.diff(drawn.cells).T.tolist()
    data = f"M{x} {y}l" + " ".join(f"{a} {b}" for a, b in steps).replace(" -", "-")
    return f'<path class="{_look(curve.color)}{" off" if number >= MOST_SHOWN else ""}" d="{data}" {reading}/>'


def _dot(curve: Curve, x: float, y: float) -> str:
    return f'<circle class="{_look(curve.color)}" cx="{100 * x / CELLS:.2f}%" cy="{HEIGHT * y / CELLS:.1f}" r="3.5"/>'


def _legend(curves: tuple[Curve, ...], lines: bool) -> str:
    """Names, of lines as buttons that show and hide them, each with room for its value."""
    rows = "".join(_entry(curve, number < MOST_SHOWN, lines) for number, curve in enumerate(curves))
    return f'<ul class="legend">{rows}</ul>'


def _entry(curve: Curve, shown: bool, line: bool) -> str:
    name, look = html.escape(curve.name), _look(curve.color)
    swatch = f'<svg width="26" height="8" aria-hidden="true"><path class="{look}" d="M1 4H25"/></svg><span>{name}</span>'
    if not line:
        return f"<li>{swatch}</li>"
    title = f' title="{name}"' if len(curve.name) > LONGEST // 2 else ""
    pressed = "true" if shown else "false"
    return f'<li><button type="button" aria-pressed="{pressed}"{title}>{swatch}</button><span class="value"></span></li>'


def _look(number: int) -> str:
    """Classes of the style sheet: a colour, and another pattern of dashes for each further round through the colours."""
    dashes = number // COLORS % DASHES
    return f"curve c{number % COLORS}" + (f" d{dashes}" if dashes else "")


def _signed(label: str) -> str:
    return label.replace("-", "−")
