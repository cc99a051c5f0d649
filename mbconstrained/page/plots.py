"""Plots as inline SVG: readable without any script, with a cursor line that the page's script moves."""

from __future__ import annotations

import html
from dataclasses import replace

import numpy as np

from .content import Curve, Plot
from .figure import PALETTE
from .ticks import Axis, axis_of
from .typeset import raised, superscript

HALF_WIDTH, FULL_WIDTH = 520, 1080  # of a plot beside another one, and of one alone, about one unit to a pixel
HEIGHT, LEFT, TOP, BOTTOM, RIGHT_MARGIN = 270, 74, 12, 226, 14

#: A curve of more points than the picture has pixels is drawn by the lowest and highest value of each pixel column.
MOST_POINTS = 1200

#: More curves than this in one picture cannot be told apart; the first are drawn.
MOST_CURVES = 12

_DASHES = ("", "7 4", "2 4", "9 4 2 4")


def plot_figure(plot: Plot, *, alone: bool = False) -> str:
    """One <figure>: title, axes with units, curves, cursor and legend. Every text of the user is escaped."""
    title, count = html.escape(plot.title), len(plot.curves)
    plot = replace(plot, curves=plot.curves[:MOST_CURVES])
    body = plot_svg(plot, FULL_WIDTH if alone else HALF_WIDTH) if count else '<p class="note">no curves</p>'
    left_out = f'\n<p class="note">the first {MOST_CURVES} of {count} curves</p>' if count > MOST_CURVES else ""
    kind = ' class="wide"' if alone else ""
    return f'<figure{kind}>\n<h2>{title}</h2>\n{body}\n<ul class="legend">{_legend(plot)}</ul>{left_out}\n</figure>'


def plot_svg(plot: Plot, width: int = HALF_WIDTH) -> str:
    """The picture alone; its data attributes tell the script where the first and last time are."""
    right = width - RIGHT_MARGIN
    values = np.array([curve.values for curve in plot.curves])
    across = axis_of(plot.times[0], plot.times[-1], widen=False)
    up = axis_of(values.min(), values.max())
    x = _x(across, plot.times, right)
    parts = [_grid(across, up, right), _axis_titles(plot, across, up, right)]
    parts += [_curve(curve, x, _y(up, curve.values)) for curve in plot.curves]
    parts.append(f'<g class="cursor" visibility="hidden"><line y1="{TOP}" y2="{BOTTOM}"/></g>')
    start, end = float(plot.times[0]), float(plot.times[-1])
    return (
        f'<svg class="plot" viewBox="0 0 {width} {HEIGHT}" role="img" aria-label="{html.escape(plot.title)} over time"'
        f' data-start="{start!r}" data-end="{end!r}" data-left="{x[0]:.6g}" data-right="{x[-1]:.6g}">\n'
        + "\n".join(parts)
        + "\n</svg>"
    )


def _x(axis: Axis, times: np.ndarray, right: int) -> np.ndarray:
    return LEFT + (times - axis.low) * ((right - LEFT) / (axis.high - axis.low))


def _y(axis: Axis, values: np.ndarray) -> np.ndarray:
    return BOTTOM - (values - axis.low) * ((BOTTOM - TOP) / (axis.high - axis.low))


def _grid(across: Axis, up: Axis, right: int) -> str:
    lines = []
    for x, label in zip(_x(across, np.array(across.ticks), right), across.labels):
        lines.append(f'<line class="grid" x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{BOTTOM}"/>')
        lines.append(f'<text x="{x:.1f}" y="{BOTTOM + 18}" text-anchor="middle">{_signed(label)}</text>')
    for tick, y, label in zip(up.ticks, _y(up, np.array(up.ticks)), up.labels):
        kind = "zero" if tick == 0 else "grid"
        lines.append(f'<line class="{kind}" x1="{LEFT}" x2="{right}" y1="{y:.1f}" y2="{y:.1f}"/>')
        lines.append(f'<text x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{_signed(label)}</text>')
    lines.append(f'<path class="axis" d="M{LEFT} {TOP}V{BOTTOM}H{right}"/>')
    return "\n".join(lines)


def _axis_titles(plot: Plot, across: Axis, up: Axis, right: int) -> str:
    middle = (TOP + BOTTOM) / 2
    vertical = html.escape(_quantity(plot.title, plot.unit, up.exponent))
    return (
        f'<text x="{(LEFT + right) / 2}" y="{BOTTOM + 38}" text-anchor="middle">{_quantity("time", "s", across.exponent)}</text>\n'
        f'<text transform="translate(14 {middle}) rotate(-90)" text-anchor="middle">{vertical}</text>'
    )


def _quantity(name: str, unit: str, exponent: int) -> str:
    """Such as "displacement in 10⁻³ m"; a long name would not fit beside the axis and is left to the heading."""
    factor = f"10{superscript(exponent)}" if exponent else ""
    name, unit = (text if len(text) <= 20 else text[:19] + "…" for text in (name, raised(unit)))
    measure = " ".join(filter(None, (factor, unit)))
    return f"{name} in {measure}" if measure else name


def _curve(curve: Curve, x: np.ndarray, y: np.ndarray) -> str:
    x, y = _thinned(x, y)
    if len(x) == 1:
        return f'<circle cx="{x[0]:.2f}" cy="{y[0]:.2f}" r="3.5" fill="{_color(curve.color)}"/>'
    points = " ".join(f"{a:.2f},{b:.2f}" for a, b in zip(x, y))
    return f'<polyline class="curve" {_stroke(curve.color)} points="{points}"/>'


def _thinned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    if len(x) <= MOST_POINTS:
        return x, y
    edges = np.linspace(0, len(x), MOST_POINTS // 2 + 1).astype(int)
    extremes = [(a + y[a:b].argmin(), a + y[a:b].argmax()) for a, b in zip(edges, edges[1:])]
    kept = np.unique(np.concatenate([[0, len(x) - 1], np.ravel(extremes)]))
    return x[kept], y[kept]


def _legend(plot: Plot) -> str:
    return "".join(
        f'<li><svg width="26" height="8"><path d="M1 4H25" stroke-width="2.4" {_stroke(curve.color)}/></svg>'
        f'<span title="{html.escape(curve.name)}">{html.escape(curve.name)}</span></li>'
        for curve in plot.curves
    )


def _color(number: int) -> str:
    return PALETTE[number % len(PALETTE)]


def _stroke(number: int) -> str:
    """The colour, and another dash pattern for each further round through the palette."""
    dashes = _DASHES[number // len(PALETTE) % len(_DASHES)]
    return f'stroke="{_color(number)}"' + (f' stroke-dasharray="{dashes}"' if dashes else "")


def _signed(label: str) -> str:
    return label.replace("-", "−")
