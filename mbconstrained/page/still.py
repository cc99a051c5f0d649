"""What a still picture may hold: shapes and texts, and nothing that runs or is fetched."""

from __future__ import annotations

import re
from xml.etree import ElementTree

from ..errors import InputError

#: Elements of shapes and texts; no script, style sheet, image, link, animation or foreign object.
_ELEMENTS = re.compile(r"svg|g|defs|use|clipPath|pattern|path|rect|line|polyline|polygon|circle|ellipse|text|tspan")

#: An address in a style or an attribute: only "#name", an element of the same picture, may follow.
_OUTSIDE = re.compile(r"url\(\s*+[\"']?+(?!#)|@import|javascript:", re.IGNORECASE)


def checked_svg(svg: str, what: str) -> str:
    """The picture itself if it is one element <svg> of shapes and texts, or an InputError that names what is not.

    It is read as XML without comments, declarations and CDATA: then a browser, which reads it as HTML, finds the
    same elements.

    >>> checked_svg('<svg viewBox="0 0 1 1"><path d="M0 0H1"/></svg>', "figure")
    '<svg viewBox="0 0 1 1"><path d="M0 0H1"/></svg>'
    """
    if not svg.lstrip().startswith("<svg") or "<!" in svg or "<?" in svg:
        raise InputError(f"{what}: found {svg[:60]!r}; expected one element <svg> without prolog and comments")
    try:
        root = ElementTree.fromstring(svg)
    except ElementTree.ParseError as problem:
        raise InputError(f"{what}: the picture is no XML ({problem}); give one element <svg>") from None
    for element in root.iter():
        _check(element, what)
    return svg


def _check(element: ElementTree.Element, what: str) -> None:
    tag = _local(element.tag)
    if not _ELEMENTS.fullmatch(tag):
        raise InputError(f"{what}: found the element <{tag[:30]}>; a picture is made of shapes and texts only")
    for name, value in element.items():
        name = _local(name).lower()
        elsewhere = name in ("href", "src") and not value.startswith("#")
        if name.startswith("on") or elsewhere or (name != "aria-label" and _OUTSIDE.search(value)):
            raise InputError(f'{what}: found {name}="{value[:40]}" in <{tag}>; a picture runs nothing and refers to itself only')


def _local(name: str) -> str:
    return name.rsplit("}", 1)[-1]
