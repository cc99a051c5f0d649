"""One look for all pictures of the reports: drawn by matplotlib, as SVG for the page and as PNG for other places.

Matplotlib is imported when a picture is drawn, never before; its pyplot, which keeps figures in a global place, never.
"""

from __future__ import annotations

import io
import re
import unicodedata
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from ..page.content import Figure
from ..page.look import DPI, MUTED, look
from ..page.typeset import superscript
from ..replacing import replacing
from .svg import page_svg

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawn

#: Width of every picture in inches: with letters of 8.5 points they are 12 to 13 pixels high on the page.
WIDTH = 9.4

#: Room for the title, which the page sets itself and the file does not, in inches.
HEADING = 0.36


@dataclass(frozen=True)
class Picture:
    """A picture that can be shown on a page and written to a file.

    Attributes:
        title: a heading on the page; drawn into the file.
        description: what is to be seen, in words.
        height: of the picture without its title, in inches; its width is always ``WIDTH``.
        draw: puts everything but the title into an empty matplotlib figure.
        note: a sentence below, or an empty string.

    Example:
        >>> picture = Picture("Nothing", "An empty picture.", 1.0, lambda figure: None)
        >>> picture.svg[:4], picture.png()[1:4]
        ('<svg', b'PNG')
    """

    title: str
    description: str
    height: float
    draw: Callable[[Drawn], None]
    note: str = ""

    @cached_property
    def svg(self) -> str:
        """One element <svg> with a view box and no size of its own; the same content gives the same text."""
        return page_svg(self._rendered("svg").decode())

    def png(self, path=None) -> bytes:
        """The picture with its title at 160 dots per inch, also written to the path if one is given."""
        image = self._rendered("png")
        if path is not None:
            with replacing(Path(path)) as beside:
                beside.write_bytes(image)
        return image

    def on_page(self) -> Figure:
        """As a page takes it."""
        return Figure(self.title, self.svg, self.description, self.note)

    def _rendered(self, kind: str) -> bytes:
        with look():
            from matplotlib.backends.backend_agg import FigureCanvasAgg
            from matplotlib.figure import Figure as Drawn

            heading = HEADING if kind == "png" else 0.0
            figure = Drawn(figsize=(WIDTH, self.height + heading), layout="constrained")
            FigureCanvasAgg(figure)
            if heading:
                figure.suptitle(shown(self.title, 90), x=0.01, ha="left", fontsize=11, fontweight="bold")
            self.draw(figure)
            file, dates = io.BytesIO(), {"Date": None} if kind == "svg" else {"Software": None}
            figure.savefig(file, format=kind, dpi=DPI, metadata=dates)
            return file.getvalue()


def shown(text: str, length: int = 40) -> str:
    """A text of the user on one line, without what cannot be drawn, shortened.

    >>> shown("a\\x00b\\nc"), shown("abcdefgh", 5)
    ('a b c', 'abcd…')
    """
    printable = "".join(" " if unicodedata.category(letter)[0] in "CZ" else letter for letter in str(text)[: 8 * length])
    plain = " ".join(printable.split())
    return plain if len(plain) <= length else plain[: length - 1].rstrip() + "…"


def width_of(text: str) -> float:
    """About how wide a text is, in inches: enough to tell how many stand side by side before anything is drawn.

    >>> width_of("WW") > width_of("Kk") > width_of("kk")
    True
    """
    return sum(_letter_width(letter) for letter in text)


def _letter_width(letter: str) -> float:
    if letter in "MWmw@%" or unicodedata.east_asian_width(letter) in "WF":
        return 0.117
    return 0.085 if letter.isupper() else 0.075


def powers(text: str) -> str:
    """Powers of ten as one writes them by hand.

    >>> powers("rtol 1e-06"), powers("2.5e+03 N/m")
    ('rtol 10⁻⁶', '2.5·10³ N/m')
    """
    return re.sub(r"(?<![\w.])(\d+(?:\.\d*)?)e([-+]?\d+)\b", _power, text)


def _power(found: re.Match) -> str:
    factor = "" if float(found[1]) == 1 else found[1] + "·"
    return f"{factor}10{superscript(int(found[2]))}"


def power_of_ten(value: float, place=None) -> str:
    """The label of a whole power of ten on an axis.

    >>> power_of_ten(1e-8), power_of_ten(1.0), power_of_ten(10.0)
    ('10⁻⁸', '1', '10')
    """
    return powers(f"{value:.0e}") if not 0.99 < value < 11 else f"{value:.0f}"


def nothing_to_show(title: str, what: str, note: str = "") -> Picture:
    """A picture that says that there is nothing to be seen."""
    text = "nothing was measured"

    def draw(figure: Drawn) -> None:
        figure.text(0.5, 0.5, text, ha="center", va="center", color=MUTED)

    return Picture(title, f"{what}: {text}.", 1.2, draw, note)
