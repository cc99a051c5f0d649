"""What tests of pictures look at: shapes and texts of an SVG, and the matplotlib figure behind it."""

from __future__ import annotations

import re
from xml.etree import ElementTree

from mbconstrained.analyses.figures import WIDTH, Picture
from mbconstrained.page.plots import page_style
from tests.page.svg import checked_svg

SVG = "{http://www.w3.org/2000/svg}"

#: Names that are no formulas, no markup and no single lines.
HOSTILE = """<script>$x_1$&amp;"'\\frac{1}\u2028\x00]]>-->\ud800"""
HOSTILE_SHOWN = """<script>$x_1$&amp;"'\\frac{1} ]]>-->"""


def texts(picture: Picture) -> list[str]:
    """All texts, in the order in which they are drawn."""
    return ["".join(element.itertext()) for element in _root(picture).iter(SVG + "text")]


def markers(picture: Picture, color: str) -> list[tuple[float, float]]:
    """Places of the markers that are filled with a colour; legends have some too."""
    used = [element for element in _root(picture).iter(SVG + "use") if _fill(element) == color]
    return [(float(element.get("x")), float(element.get("y"))) for element in used]


def drawn(picture: Picture):
    """The matplotlib figure with everything in it."""
    from matplotlib.figure import Figure

    with page_style():
        figure = Figure(figsize=(WIDTH, picture.height), layout="constrained")
        picture.draw(figure)
        figure.draw_without_rendering()
        return figure


def _root(picture: Picture) -> ElementTree.Element:
    return checked_svg(picture.svg)


def _fill(element: ElementTree.Element) -> str | None:
    found = re.search(r"fill: ?(#\w+)", element.get("style", ""))
    return found and found[1]
