"""Matplotlib's SVG made fit for a page: one plain element that takes the page's width, its font and nothing else."""

from __future__ import annotations

import re
from xml.etree import ElementTree

#: The page's own fonts; where they are missing any without serifs.
FONTS = "system-ui,-apple-system,'Segoe UI',Roboto,'Helvetica Neue',Arial,'Liberation Sans',sans-serif"

#: What matplotlib writes into a style sheet, which on a page would hold for everything on it.
_STYLE = f"stroke-linejoin:round;stroke-linecap:butt;font-family:{FONTS}"

#: A font in one of the two ways in which versions of matplotlib write it: together with its size and weight, or alone.
_FONT = re.compile(r"font: (?:(\w+) )?([\d.]+px) [^;]*|font-family: [^;]*;? ?")


def page_svg(svg: str) -> str:
    """One element <svg> without prolog, metadata and style sheet; its size is that of its box, its font inherited.

    Names that nothing refers to are left out, since several pictures stand on one page.

    >>> page_svg('<svg xmlns="http://www.w3.org/2000/svg" width="9pt" height="9pt" viewBox="0 0 9 9"><g id="a"/></svg>')[:62]
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9" styl'
    """
    root = ElementTree.fromstring(svg)
    used = set(re.findall(r"url\(#([^)]*)\)", svg)) | set(re.findall(r'href="#([^"]*)"', svg))
    _clean(root, used)
    plain = ElementTree.Element("svg", {"xmlns": "http://www.w3.org/2000/svg", "viewBox": root.attrib["viewBox"], "style": _STYLE})
    plain.extend(root)
    return ElementTree.tostring(plain, encoding="unicode")


def _clean(element: ElementTree.Element, used: set[str]) -> None:
    """Local names, needed ids and no line ends between elements, here and below."""
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
