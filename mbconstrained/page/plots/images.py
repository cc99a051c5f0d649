"""Images drawn by matplotlib: the plots of a page as SVG and PNG for reports, with the page's curves, colours and ticks.

Matplotlib is imported when an image is drawn, never before; its pyplot, which keeps figures in a global place, never.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..animation.figure import PALETTE
from ..content import LEAST_SHARE, Curve, Plot
from ..typeset import shortened
from .svg_plot import axis_titles

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Curves of an image: more are indistinct.
MOST_CURVES = 24

#: Size of an image without its legend, half a page of a report, and the height of a large one, inches.
WIDTH, HEIGHT, LARGE_HEIGHT = 6.4, 3.1, 4.4

#: For each round through the colours another pattern of dashes, in widths of the line; the first is solid.
_DASHES = (None, (4, 2.2), (1.2, 2.2), (5, 2.2, 1.2, 2.2))

#: Marks of matplotlib by shape.
_MARKERS = {"circle": "o", "cross": "x", "diamond": "D"}

#: Height of a row of the legend, width of the line before a name and of a letter, inches.
_ROW, _SAMPLE, _LETTER = 0.19, 0.6, 0.075

#: Colours of text, secondary text, lines, grid and warnings as in page.css, and a red and a grey for figures.
INK, MUTED, LINE, GRID, WARN, RED, GREY = "#1c2530", "#5d6b79", "#b5c0ca", "#e8edf1", "#e69f00", "#c8102e", "#aab4be"

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
def page_style() -> Iterator[None]:
    """The style of the page as matplotlib's settings, whatever the user has set; restored afterwards."""
    import matplotlib.style

    with matplotlib.style.context(_STYLE, after_reset=True), warnings.catch_warnings():
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
        if plot.curves:
            images[f"{name}-{count + 1}" if count else name] = plot
    return images


def plot_image(plot: Plot, kind: Literal["svg", "png"]) -> bytes:
    """The image of a plot; of more curves than a page can show, as many as it can.

    >>> import numpy as np
    >>> plot_image(Plot("speed", "m/s", np.array([0.0, 1.0]), (Curve("cart", np.array([0.0, 2.0])),)), "png")[1:4]
    b'PNG'
    """
    curves = plot.curves[: max(MOST_CURVES, plot.shown)]
    longest = max(len(shortened(curve.name)) for curve in curves)
    columns = min(len(curves), max(1, int((WIDTH - 0.3) / (_SAMPLE + _LETTER * longest))))
    height = (LARGE_HEIGHT if plot.is_large else HEIGHT) + _ROW * -(-(len(curves) + len(_named_marks(plot))) // columns)
    return drawn_image(lambda figure: _draw(figure, plot, curves, columns), WIDTH, height, kind)


def _named_marks(plot: Plot) -> set[str]:
    return {marks.name for marks in plot.marks if marks.name}


def _draw(figure: Figure, plot: Plot, curves: tuple[Curve, ...], columns: int) -> None:
    axes = figure.add_subplot()
    across, up = plot.axes
    marker = "o" if len(plot.times) == 1 else ""
    for curve in curves:
        dashes = _DASHES[curve.color // len(PALETTE) % len(_DASHES)]
        values = curve.values if curve.drawn is None else np.where(curve.drawn, curve.values, np.nan)
        (line,) = axes.plot(plot.along(curve), values, label=shortened(curve.name), marker=marker)
        line.set(color=PALETTE[curve.color % len(PALETTE)], linestyle="-" if dashes is None else (0, dashes))
    axes.set(xscale=across.scale, yscale=up.scale)
    axes.set_xlim(across.low, across.high)
    axes.set_ylim(up.low, up.high)
    axes.set_xticks(across.ticks, across.labels)
    axes.set_yticks(up.ticks, up.labels)
    axes.minorticks_off()
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
    for band in plot.bands:
        axes.axvspan(*band, color=RED, alpha=0.12, linewidth=0)
    named = set()
    for marks in plot.marks:
        if marks.curve is None or marks.curve < len(curves):
            color = INK if marks.curve is None else PALETTE[(curves[marks.curve].color or 0) % len(PALETTE)]
            label = marks.name if marks.name not in named else ""
            named.add(marks.name)
            style: dict[str, Any] = {
                "marker": _MARKERS[marks.shape],
                "linestyle": "none",
                "markersize": 4,
                "label": label or "_",
                "clip_on": False,
                "zorder": 3,
            }
            axes.plot(*marks.points.T, color=color, markerfacecolor="white", **style)
    if 0.0 in up.ticks:
        axes.axhline(0.0, color=LINE, linewidth=0.8, zorder=0.9)
    xlabel, ylabel = axis_titles(plot, across.exponent, up.exponent)
    axes.set(xlabel=xlabel, ylabel=ylabel)
    axes.set_title(shortened(plot.title, 80), loc="left", fontsize=10, fontweight="bold", color=INK)
    if len(curves) > 1 or plot.across is None or named - {""}:
        figure.legend(loc="outside lower left", ncols=columns, labelcolor=INK, handlelength=2.2, columnspacing=1.6)
    if len(plot.curves) > MOST_CURVES:
        axes.set_title(f"the first {MOST_CURVES} of {len(plot.curves)} curves", loc="right", fontsize=8, color=MUTED)
