"""Plots as inline SVG: readable without scripts, as wide as the page allows, with texts of one size on every screen.

The origin of the picture is the upper left corner of its axes; horizontal positions are in percent of their width and
vertical ones in pixels. The curves lie in a square of ``CELLS`` by ``CELLS`` that is stretched over the axes, and are
written in whole cells from point to point. The page's script reads from them the values next to the names, of a coordinate
of the animation from its key frames, and displays no more digits than these data determine: a number with an error of at
most half a unit of its last digit has, once rounded, an error of at most one unit.
"""

from __future__ import annotations

import html
import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..animation.animation import Animation
from ..animation.keyframes import KeyFrames
from ..content import Curve, Plot
from ..typeset import raised, shortened, superscript
from .axis import NOISE_SPAN, Axis, axis_of

#: Height of the axes, px.
HEIGHT = 214

#: Size of the square that the curves are written in, in cells.
CELLS = 10_000

#: A curve of more points than the picture has pixels is drawn by the lowest and highest value of each pixel column.
MOST_POINTS = 2400

#: Curves shown at first: more in one picture are indistinct.
MOST_SHOWN = 8

#: Curves kept: more are a burden to the page.
MOST_CURVES = 24

#: Labels along an axis that fit on a phone.
MOST_LABELS = 5

#: Letters of a name along an axis.
AXIS_NAME = 20

#: Colours of curves in the style sheet, and patterns of dashes: one for each round through the colours.
COLORS, DASHES = 6, 4

#: Error of interpolation between points relative to the error with every second point left out: a quarter for lines through a
#: smooth curve, a sixteenth for cubics, a half at a kink.
INTERPOLATION_ERROR = 0.5


@dataclass(frozen=True)
class AnimatedCoordinates:
    """The coordinates of an animation as the page reads them.

    Attributes:
        animation: the exact values.
        frames: the key frames.
        storage_errors: of each coordinate by the method of storing its key frames, shape (r,).
    """

    animation: Animation
    frames: KeyFrames
    storage_errors: np.ndarray


def plot_figures(plots: tuple[Plot, ...], coordinates: AnimatedCoordinates | None = None) -> str:
    """All plots, in pairs side by side where the window is wide enough; the last of an odd number takes the whole width.

    Args:
        plots: in their order.
        coordinates: of the animation on the same page, from which curves that show them are read.

    Returns:
        One <figure> for each plot: title, axes with units, curves, cursor and legend. Every text of the user is escaped.
    """
    paired = len(plots) - len(plots) % 2
    figures = "\n".join(_figure(plot, coordinates, " wide" if i >= paired else "") for i, plot in enumerate(plots))
    return f'<div class="plots">\n{figures}\n</div>' if plots else ""


def _figure(plot: Plot, coordinates: AnimatedCoordinates | None, wide: str) -> str:
    kept, count, note = plot.curves[:MOST_CURVES], len(plot.curves), ""
    body = f"{_svg(plot, kept, coordinates)}\n{_legend(kept, len(plot.times) > 1)}" if count else '<p class="note">no curves</p>'
    if count > MOST_SHOWN:
        number = f"the first {MOST_CURVES} of {count} curves are available" if count > MOST_CURVES else f"{count} curves"
        note = f'\n<p class="note">{number}, {MOST_SHOWN} of them shown at first: click on a name to show or hide its curve</p>'
    return f'<figure class="plot-figure{wide}">\n<h2>{html.escape(plot.title)}</h2>\n{body}{note}\n</figure>'


def _svg(plot: Plot, curves: tuple[Curve, ...], coordinates: AnimatedCoordinates | None) -> str:
    """The picture alone; its data attributes describe the axes to the script."""
    times, phase, horizontal = plot.times, plot.across is not None, plot.horizontal.values
    across = axis_of(horizontal.min(), horizontal.max(), widen=phase)
    values = np.array([curve.values for curve in curves])
    up = axis_of(values.min(), values.max())
    x, y = _cells(across, horizontal), CELLS - _cells(up, values)
    digits, elements = _digits(across, 0.0), [_grid(across, up)]
    right, upwards = map(html.escape, axis_titles(plot, across.exponent, up.exponent))
    elements += [
        f'<text x="50%" y="{HEIGHT + 38}" text-anchor="middle">{right}</text>',
        f'<text transform="translate(-58 {HEIGHT // 2}) rotate(-90)" text-anchor="middle">{upwards}</text>',
    ]
    if len(times) == 1:
        elements += [
            f'<circle class="{_classes(curve.color)}" cx="{100 * x[0] / CELLS:.2f}%" cy="{HEIGHT * row[0] / CELLS:.1f}" r="3.5"/>'
            for curve, row in zip(curves, y)
        ]
    else:
        drawn = [plotted(times, x, row, phase=phase) for row in y]
        paths = "\n".join(
            _path(i, curve, cells, _reading(plot, curve, cells, errors, up, coordinates))
            for i, (curve, (cells, errors)) in enumerate(zip(curves, drawn))
        )
        elements.append(f'<svg class="curves" viewBox="0 0 {CELLS} {CELLS}" preserveAspectRatio="none">\n{paths}\n</svg>')
        digits = _digits(across, drawn[0][1][0]) if phase else digits
    even = evenly(times)
    time = ' data-even=""' * even
    if phase:  # times of points, in cells from point to point, unless evenly spaced
        time = f' data-times="{"" if even else " ".join(map(str, _time_steps(times)))}"'
    return (
        f'<svg class="plot" role="img" aria-label="{html.escape(_description(plot, curves))}"'
        f' data-start="{float(times[0])!r}" data-end="{float(times[-1])!r}"{time}'
        f' {_scale("across", across, plot.across_unit)} data-across-digits="{digits}" {_scale("up", up, plot.unit)}>\n'
        + "\n".join(elements)
        + "\n</svg>"
    )


def _cells(axis: Axis, values: np.ndarray) -> np.ndarray:
    return (values - axis.low) * (CELLS / (axis.high - axis.low))


def _digits(axis: Axis, cells: float) -> str:
    """Digits after the decimal point, in the unit of the labels, of numbers with an error of some cells; "none" without any."""
    span, unit = axis.high - axis.low, 10.0**axis.exponent
    digits = min(12, math.floor(NOISE_SPAN - math.log10(span / CELLS * max(1.0, 2 * cells) / unit)))
    return "none" if unit * 10.0**-digits > span else str(digits)


def _reading(plot: Plot, curve: Curve, cells: np.ndarray, errors, up: Axis, coordinates: AnimatedCoordinates | None) -> str:
    """Where the script reads the values of a curve, and how many digits are known or how accurate its points are."""
    if coordinates and plot.across is None and (known := _coordinate(coordinates, curve, plot.times)):
        number, error = known
        return f'data-digits="{_digits(up, error * CELLS / (up.high - up.low))}" data-coordinate="{number}"'
    is_complete = plot.across is None and cells.shape[1] == len(plot.times)
    return f'data-error="{errors[1]:.3g}"' if is_complete else f'data-digits="{_digits(up, errors[1])}"'


def _coordinate(coordinates: AnimatedCoordinates, curve: Curve, times: np.ndarray) -> tuple[int, float] | None:
    """The number of the coordinate that a curve shows, and its largest error at any time; None where it shows something else."""
    animation, frames, exact = coordinates.animation, coordinates.frames, curve.values
    if curve.name not in animation.names or not np.array_equal(times, animation.times):
        return None
    number = animation.names.index(curve.name)
    if not np.array_equal(exact, animation.values[number]):
        return None
    keys, values, rates = frames.times, frames.values[number], frames.rates[number]
    at_times = np.abs(_cubic(keys, values, rates, times) - exact).max()
    half = np.unique([*range(0, len(keys), 2), len(keys) - 1])
    between = INTERPOLATION_ERROR * np.abs(_cubic(keys[half], values[half], rates[half], keys) - values).max()
    rounding = np.finfo(np.float32).eps * np.abs(exact).max()  # of key frames stored with 4 bytes
    return number, float(max(at_times, between) + rounding + coordinates.storage_errors[number])


def _scale(name: str, axis: Axis, unit: str) -> str:
    """For the script: ends of the axis in the unit of its labels, the power of ten of that, the unit."""
    ends = " ".join(f"{end / 10.0**axis.exponent:.12g}" for end in (axis.low, axis.high))
    return f'data-{name}="{ends} {axis.exponent}" data-{name}-unit="{html.escape(_measure(unit, axis.exponent))}"'


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


def axis_titles(plot: Plot, across: int = 0, up: int = 0) -> tuple[str, str]:
    """The titles of the axes, such as "displacement in 10⁻³ m"; a long name is shortened, the heading has all of it.

    Args:
        plot: names and units.
        across, up: the powers of ten of the labels.

    Returns:
        Of the horizontal and of the vertical axis.
    """
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


def _path(number: int, curve: Curve, cells: np.ndarray, reading: str) -> str:
    (x, y), steps = cells[:, 0], np.diff(cells).T.tolist()
    data = f"M{x} {y}l" + " ".join(f"{a} {b}" for a, b in steps).replace(" -", "-")
    return f'<path class="{_classes(curve.color)}{" off" if number >= MOST_SHOWN else ""}" d="{data}" {reading}/>'


def _legend(curves: tuple[Curve, ...], lines: bool) -> str:
    """Names, of lines as buttons that show and hide them, each with space for its value."""
    rows = []
    for number, curve in enumerate(curves):
        name = html.escape(curve.name)
        entry = (
            f'<svg width="26" height="8" aria-hidden="true"><path class="{_classes(curve.color)}" d="M1 4H25"/></svg>'
            f"<span>{name}</span>"
        )
        if lines:
            title = f' title="{name}"' if len(curve.name) > AXIS_NAME else ""
            pressed = "true" if number < MOST_SHOWN else "false"
            entry = f'<button type="button" aria-pressed="{pressed}"{title}>{entry}</button><span class="value"></span>'
        rows.append(f"<li>{entry}</li>")
    return f'<ul class="legend">{"".join(rows)}</ul>'


def _classes(number: int) -> str:
    """Classes of the style sheet: a colour, and another pattern of dashes for each further round through the colours."""
    dashes = number // COLORS % DASHES
    return f"curve c{number % COLORS}" + (f" d{dashes}" if dashes else "")


def plotted(times: np.ndarray, x: np.ndarray, y: np.ndarray, *, phase: bool) -> tuple[np.ndarray, tuple[float, float]]:
    """The drawn points of a curve: all, or the extremes of each pixel column; of a phase plane evenly chosen ones.

    Args:
        times: in s, shape (T,), at least two.
        x, y: in cells, shape (T,).
        phase: whether it is a curve in a phase plane.

    Returns:
        Whole cells to the right and down, shape (2, k), and the errors of a horizontal and a vertical reading in cells; of a
        curve over time of which all points are drawn the errors at these, as the script estimates those between them.
    """
    kept = _sparse(times) if phase else _kept(x, y)
    cells = np.rint(np.array([x[kept], y[kept]])).astype(int)
    read_times = cells[0]  # as the script reads them, in cells of the duration
    if evenly(times):
        read_times = np.linspace(0, CELLS, len(kept))
    elif phase:
        read_times = np.cumsum(_time_steps(times))
    share = CELLS * (times - times[0]) / (times[-1] - times[0])
    is_complete = not phase and len(kept) == len(times)
    across, up = (_reading_error(share, exact, read_times, read, is_complete) for exact, read in zip((x, y), cells))
    return cells, (across, up)


def _reading_error(moments: np.ndarray, values: np.ndarray, read_moments: np.ndarray, read: np.ndarray, is_complete: bool) -> float:
    """Largest error of linear interpolation of the drawn points (k,): at the exact ones (T,) and, unless complete, between."""
    at_moments = float(np.abs(np.interp(moments, read_moments, read) - values).max())
    if is_complete:
        return at_moments
    share = (moments[1:-1] - moments[:-2]) / (moments[2:] - moments[:-2])
    bend = values[1:-1] - values[:-2] - share * (values[2:] - values[:-2])
    return float(at_moments + INTERPOLATION_ERROR * np.abs(bend).max(initial=0.0))


def _cubic(keys: np.ndarray, values: np.ndarray, rates: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Cubic Hermite interpolation of key frames (k,) at times (T,), as in the page's script."""
    if len(keys) == 1:
        return np.full(len(times), values[0])
    key = np.clip(np.searchsorted(keys, times, side="right") - 1, 0, len(keys) - 2)
    length = keys[key + 1] - keys[key]
    s = (times - keys[key]) / length
    r = 1 - s
    ends = r * r * (1 + 2 * s) * values[key] + s * s * (1 + 2 * r) * values[key + 1]
    return ends + length * s * r * (r * rates[key] - s * rates[key + 1])


def evenly(times: np.ndarray) -> bool:
    """Whether all points are drawn and evenly spaced, so that the script needs no times."""
    return len(times) <= MOST_POINTS and bool(
        np.abs(times - np.linspace(times[0], times[-1], len(times))).max() * CELLS <= 0.1 * (times[-1] - times[0])
    )


def _time_steps(times: np.ndarray) -> np.ndarray:
    """The times of the points of a phase curve, in cells from point to point."""
    shares = (times[_sparse(times)] - times[0]) / ((times[-1] - times[0]) or 1.0)
    return np.diff(np.rint(CELLS * shares).astype(int), prepend=0)


def _sparse(times: np.ndarray) -> np.ndarray:
    """Indices of the drawn points of a phase curve: at most ``MOST_POINTS``, evenly chosen."""
    return np.linspace(0, len(times) - 1, min(len(times), MOST_POINTS)).round().astype(int)


def _kept(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    if len(x) <= MOST_POINTS:
        return np.arange(len(x))
    edges = np.linspace(0, len(x), MOST_POINTS // 2 + 1).astype(int)
    extremes = [(a + y[a:b].argmin(), a + y[a:b].argmax()) for a, b in pairwise(edges)]
    return np.unique(np.concatenate([[0, len(x) - 1], np.ravel(extremes)]))
