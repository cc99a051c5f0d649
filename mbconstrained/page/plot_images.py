"""The plots of a page as pictures for reports, SVG and PNG: the same curves, colours, ticks and names, drawn by matplotlib.

Matplotlib is imported when a picture is drawn, never before; its pyplot, which keeps figures in a global place, never.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .plot_content import Curve, PhasePlot, Plot
from .figure import PALETTE
from .look import DPI, INK, LINE, MUTED, look
from .plots import MOST_CURVES
from .ticks import Axis, axis_of
from .typeset import raised, superscript

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Of a picture without its legend, in inches: half a page of a report.
WIDTH, HEIGHT = 6.4, 3.1

#: For each round through the colours another pattern, in widths of the line; the first is solid.
_DASHES = (None, (4, 2.2), (1.2, 2.2), (5, 2.2, 1.2, 2.2))

#: A row of the legend, the line before a name and a letter, in inches.
_ROW, _SAMPLE, _LETTER = 0.19, 0.6, 0.075

#: Of a name in the legend and of one beside an axis.
_LONGEST = 40


@dataclass(frozen=True)
class PlotImage:
    """A plot that can be written as a file.

    Attributes:
        name: for the file, such as "displacement" or "angular-velocity".
        plot: what is drawn; of more curves than a page can show, as many as it can.
    """

    name: str
    plot: Plot | PhasePlot

    def rendered(self, kind: str) -> bytes:
        """The picture as "svg" or "png"; the same plot gives the same bytes.

        >>> plot = Plot("speed", "m/s", np.array([0.0, 1.0]), (Curve("cart", np.array([0.0, 2.0])),))
        >>> PlotImage("speed", plot).rendered("png")[1:4]
        b'PNG'
        """
        with look():
            from matplotlib.backends.backend_agg import FigureCanvasAgg
            from matplotlib.figure import Figure

            rows = _legend_rows(self.plot.curves[:MOST_CURVES])
            figure = Figure(figsize=(WIDTH, HEIGHT + _ROW * len(rows)), layout="constrained", facecolor="white")
            FigureCanvasAgg(figure)
            _draw(figure, self.plot, len(rows[0]))
            file, undated = io.BytesIO(), {"Date": None} if kind == "svg" else {"Software": None}
            figure.savefig(file, format=kind, dpi=DPI, metadata=undated)
            return file.getvalue()


def plot_images(plots: Iterable[Plot | PhasePlot]) -> list[PlotImage]:
    """A picture for each plot that has curves; their names differ.

    >>> plots = [Plot("angular velocity", unit, np.array([0.0]), (Curve("a", np.array([1.0])),)) for unit in ("rad/s", "1")]
    >>> [image.name for image in plot_images(plots)]
    ['angular-velocity', 'angular-velocity-2']
    """
    images: list[PlotImage] = []
    for plot in plots:
        name = re.sub(r"[^\w]+", "-", plot.title).strip("-") or "plot"
        count = sum(image.plot.title == plot.title for image in images)
        if plot.curves:
            images.append(PlotImage(f"{name}-{count + 1}" if count else name, plot))
    return images


def _draw(figure: Figure, plot: Plot | PhasePlot, columns: int) -> None:
    axes = figure.add_subplot()
    phase = isinstance(plot, PhasePlot)
    curves = plot.curves[:MOST_CURVES]
    along = plot.displacement if phase else plot.times
    values = np.array([curve.values for curve in curves])
    across, up = axis_of(along.min(), along.max(), widen=phase), axis_of(values.min(), values.max())
    for curve in curves:
        axes.plot(along, curve.values, label=shortened(curve.name), **_line(curve), marker="o" if len(along) == 1 else "")
    _scale(axes, across, up)
    titles, units = (plot.titles, plot.units) if phase else (("time", plot.title), ("s", plot.unit))
    axes.set_xlabel(_quantity(titles[0], units[0], across.exponent))
    axes.set_ylabel(_quantity(titles[1], units[1], up.exponent))
    axes.set_title(shortened(plot.title, 80), loc="left", fontsize=10, fontweight="bold", color=INK)
    if len(curves) > 1 or not phase:
        figure.legend(loc="outside lower left", ncols=columns, labelcolor=INK, handlelength=2.2, columnspacing=1.6)
    if len(plot.curves) > MOST_CURVES:
        told = f"the first {MOST_CURVES} of {len(plot.curves)} curves"
        axes.set_title(told, loc="right", fontsize=8, color=MUTED)


def _scale(axes: Axes, across: Axis, up: Axis) -> None:
    axes.set_xlim(across.low, across.high)
    axes.set_ylim(up.low, up.high)
    axes.set_xticks(across.ticks, [label.replace("-", "−") for label in across.labels])
    axes.set_yticks(up.ticks, [label.replace("-", "−") for label in up.labels])
    if 0.0 in up.ticks:
        axes.axhline(0.0, color=LINE, linewidth=0.8, zorder=0.9)


def _line(curve: Curve) -> dict:
    """Colour and dashes, as on the page."""
    dashes = _DASHES[curve.color // len(PALETTE) % len(_DASHES)]
    return {"color": PALETTE[curve.color % len(PALETTE)], "linestyle": "-" if dashes is None else (0, dashes)}


def _quantity(name: str, unit: str, exponent: int) -> str:
    power = f"10{superscript(exponent)}" if exponent else ""
    measure = " ".join(filter(None, (power, raised(shortened(unit)))))
    return f"{shortened(name)} in {measure}" if measure else shortened(name)


def _legend_rows(curves: tuple[Curve, ...]) -> list[tuple[Curve, ...]]:
    """Curves in rows that fit side by side."""
    longest = max(len(shortened(curve.name)) for curve in curves)
    columns = min(len(curves), max(1, int((WIDTH - 0.3) / (_SAMPLE + _LETTER * longest))))
    return [curves[start : start + columns] for start in range(0, len(curves), columns)]


def shortened(text: str, length: int = _LONGEST) -> str:
    """A text on one line, without what cannot be printed, cut off where it is longer.

    >>> shortened("a\\nb"), shortened("abcdefgh", 5)
    ('a b', 'abcd…')
    """
    plain = " ".join("".join(letter if letter.isprintable() else " " for letter in str(text)).split())
    return plain if len(plain) <= length else plain[: length - 1].rstrip() + "…"
