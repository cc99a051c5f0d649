"""One look for all pictures that matplotlib draws: that of the page, whatever settings the user has."""

from __future__ import annotations

import warnings
from contextlib import contextmanager

#: The page's ink, muted text, lines and light grid (page.css), its warning colour, and a red and a grey of their own.
INK, MUTED, LINE, GRID, WARN, RED, GREY = "#1c2530", "#5d6b79", "#b5c0ca", "#e8edf1", "#e69f00", "#c8102e", "#aab4be"

#: Dots per inch of the pictures that are made of dots.
DPI = 160

_LOOK = {
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


@contextmanager
def look():
    """Matplotlib's own settings and ours on top, whatever the user has set; as before afterwards."""
    import matplotlib.style

    with matplotlib.style.context(_LOOK, after_reset=True), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")  # a box in the file; on the page the browser's font
        yield
