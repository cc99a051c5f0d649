"""SVG that a page may include: one element of shapes and texts, without references to anything outside it."""

import re
from xml.etree import ElementTree

#: Elements of shapes and texts; no script, style sheet, image, link, animation or foreign object.
ELEMENTS = re.compile(r"svg|g|defs|use|clipPath|pattern|path|rect|line|polyline|polygon|circle|ellipse|text|tspan")

#: An address in a style or an attribute: only "#name", an element of the same picture, may follow.
OUTSIDE = re.compile(r"url\(\s*+[\"']?+(?!#)|@import|javascript:", re.IGNORECASE)


def checked_svg(svg: str) -> ElementTree.Element:
    """The element <svg>, without comments, declarations and CDATA: a browser, which reads it as HTML, finds the same elements."""
    assert svg.lstrip().startswith("<svg") and "<!" not in svg and "<?" not in svg
    root = ElementTree.fromstring(svg)
    for element in root.iter():
        assert ELEMENTS.fullmatch(element.tag.rsplit("}", 1)[-1]), element.tag
        for name, value in element.items():
            name = name.rsplit("}", 1)[-1].lower()
            assert not name.startswith("on") and (name not in ("href", "src") or value.startswith("#")), (name, value)
            assert name == "aria-label" or not OUTSIDE.search(value), (name, value)
    return root
