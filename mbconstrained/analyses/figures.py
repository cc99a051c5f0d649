"""Figures of the reports, by matplotlib in the style of the page, as SVG for the page and as PNG files.

Matplotlib is imported when a figure is drawn, never before.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal
from xml.etree import ElementTree

from ..ground.files import replacing
from ..page.content import Figure, shortened, superscript
from ..page.plots import MUTED, drawn_image

if TYPE_CHECKING:
    from matplotlib.figure import Figure as MatplotlibFigure

#: Width of every figure, inches: its letters of 8.5 points are 12 to 13 pixels high on the page.
WIDTH = 9.4

#: Height of the title in PNG files; on the page it is a heading of its own, inches.
HEADING = 0.36

#: The fonts of the page.
FONTS = "system-ui,-apple-system,'Segoe UI',Roboto,'Helvetica Neue',Arial,'Liberation Sans',sans-serif"

#: Replaces matplotlib's style sheet, which would apply to the whole page.
_STYLE = f"stroke-linejoin:round;stroke-linecap:butt;font-family:{FONTS}"

#: A font as different versions of matplotlib write it: with size and weight, or alone.
_FONT = re.compile(r"font: (?:(\w+) )?([\d.]+px) [^;]*|font-family: [^;]*;? ?")


@dataclass(frozen=True)
class Picture:
    """A figure for a page and a file.

    Attributes:
        title: a heading on the page; part of the file.
        description: a text alternative.
        height: without the title, in inches; the width is ``WIDTH``.
        draw: draws all but the title into an empty matplotlib figure.
        note: a sentence below, or an empty string.

    Example:
        >>> picture = Picture("Nothing", "An empty picture.", 1.0, lambda figure: None)
        >>> picture.svg[:4], picture.png()[1:4]
        ('<svg', b'PNG')
    """

    title: str
    description: str
    height: float
    draw: Callable[[MatplotlibFigure], None]
    note: str = ""

    @cached_property
    def svg(self) -> str:
        """One element <svg> with a view box and without a size; equal contents give equal texts."""
        return page_svg(self._rendered("svg").decode())

    def png(self, path=None) -> bytes:
        """The picture with its title at 160 dots per inch, also written to the path if one is given."""
        image = self._rendered("png")
        if path is not None:
            with replacing(Path(path)) as temporary:
                temporary.write_bytes(image)
        return image

    def on_page(self) -> Figure:
        """The figure for a page."""
        return Figure(self.title, self.svg, self.description, self.note)

    def _rendered(self, kind: Literal["svg", "png"]) -> bytes:
        heading = HEADING if kind == "png" else 0.0

        def draw(figure: MatplotlibFigure) -> None:
            if heading:
                figure.suptitle(shortened(self.title, 90), x=0.01, ha="left", fontsize=11, fontweight="bold")
            self.draw(figure)

        return drawn_image(draw, WIDTH, self.height + heading, kind)


def powers(text: str) -> str:
    """Powers of ten in mathematical notation.

    >>> powers("rtol 1e-06"), powers("2.5e+03 N/m")
    ('rtol 10⁻⁶', '2.5·10³ N/m')
    """
    return re.sub(r"(?<![\w.])(\d+(?:\.\d*)?)e([-+]?\d+)\b", _power, text)


def _power(match: re.Match) -> str:
    factor = "" if float(match[1]) == 1 else match[1] + "·"
    return f"{factor}10{superscript(int(match[2]))}"


def power_of_ten(value: float) -> str:
    """The label of a whole power of ten on an axis.

    >>> power_of_ten(1e-8), power_of_ten(1.0), power_of_ten(10.0)
    ('10⁻⁸', '1', '10')
    """
    return powers(f"{value:.0e}") if not 0.99 < value < 11 else f"{value:.0f}"


def nothing_to_show(title: str, content: str, note: str = "") -> Picture:
    """A figure without data."""
    text = "nothing was measured"

    def draw(figure: MatplotlibFigure) -> None:
        figure.text(0.5, 0.5, text, ha="center", va="center", color=MUTED)

    return Picture(title, f"{content}: {text}.", 1.2, draw, note)


def page_svg(svg: str) -> str:
    """Matplotlib's SVG as one element <svg> without prolog, metadata and style sheet, as wide as the page.

    Unused ids are left out, since a page has several figures.

    >>> page_svg('<svg xmlns="http://www.w3.org/2000/svg" width="9pt" height="9pt" viewBox="0 0 9 9"><g id="a"/></svg>')[:62]
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9" styl'
    """
    root = ElementTree.fromstring(svg)
    used = set(re.findall(r"url\(#([^)]*)\)", svg)) | set(re.findall(r'href="#([^"]*)"', svg))
    _clean(root, used)
    element = ElementTree.Element(
        "svg", {"xmlns": "http://www.w3.org/2000/svg", "viewBox": root.attrib["viewBox"], "style": _STYLE}
    )
    element.extend(root)
    return ElementTree.tostring(element, encoding="unicode")


def _clean(element: ElementTree.Element, used: set[str]) -> None:
    """Keep local names and used ids, and remove line ends between elements."""
    element.tag = _local(element.tag)
    kept = {_local(name): value for name, value in element.items() if name != "id" or value in used}
    if "style" in kept:
        kept["style"] = _FONT.sub(_without_family, kept["style"])
    element.attrib.clear()
    element.attrib.update(kept)
    if element.tag not in ("text", "tspan"):
        element.text = None
    element.tail = "\n" if element.tag == "g" else None
    for child in list(element):
        _clean(child, used)
        if child.tag in ("metadata", "style"):
            element.remove(child)


def _without_family(font: re.Match) -> str:
    weight, size = font.groups()
    return (f"font-size: {size}" if size else "") + (f"; font-weight: {weight}" if weight else "")


def _local(name: str) -> str:
    return name.rsplit("}", 1)[-1]
