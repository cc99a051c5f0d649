"""One static HTML file with all it needs inside it.

Nothing is fetched and nothing but the scripts written here can run: the content security policy forbids everything
else and names the scripts by their hashes. The same content always gives the same bytes.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from .viewer import VIEWER_FILE, viewer_script

#: Where the 3-D viewer is: in the page, in a file that many pages share, or in the page and compressed with all scripts.
Delivery = Literal["inside", "beside", "compressed"]

_ASSETS = Path(__file__).with_name("assets")
_MOTION = ("motion.js", "shapes.js", "parts.js", "links.js", "names.js", "stage.js", "player.js", "keys.js", "print.js")
_MARKS = ("marks.js",)


@dataclass(frozen=True)
class Scripts:
    """What runs in a page.

    Attributes:
        own: the page's own script.
        data: what it reads.
        moves: whether it needs the 3-D viewer.
        delivery: where that is.
    """

    own: str
    data: dict | None = None
    moves: bool = False
    delivery: Delivery = "inside"


def page_scripts(kind: str = "", data: dict | None = None, *, plots: bool = False, delivery: Delivery = "inside") -> Scripts | None:
    """The scripts of a page that moves, of which the last is for this kind of page, or that has plots; None for any other.

    They stand in one scope, so that they name nothing in the window but ``mbconstrained``.
    """
    if not (kind or plots):
        return None
    marks = _MARKS if data and "marks" in data["figure"] else ()
    names = ("theme.js", *(("plots.js",) if plots else ()), *((*_MOTION, *marks, kind) if kind else ()))
    own = "\n".join(_asset(name) for name in names)
    return Scripts('(function () {\n"use strict";\n' + own + "})();\n", data, bool(kind), delivery)


def document(title: str, body: str, scripts: Scripts | None = None) -> str:
    """The whole file: its head, the body and the scripts, which are the only ones that may run.

    Raises:
        MbconstrainedError: something moves, but meshcat is not installed.
    """
    elements, policy = _elements(scripts) if scripts else ([], "'none'")
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_policy(policy)}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{html.escape(title)}</title>
<style>
{_asset("page.css")}</style>
</head>
<body>
{chr(10).join([body, *elements])}
</body>
</html>
"""


def script_json(data) -> str:
    """JSON that can stand in a script element: nothing in it can end the element or start another.

    >>> script_json("</script>")
    '"\\\\u003c/script\\\\u003e"'
    """
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _elements(scripts: Scripts) -> tuple[list[str], str]:
    """The elements at the end of the body, and what the policy says of scripts."""
    viewer = [viewer_script()] if scripts.moves else []
    data = [] if scripts.data is None else [_data(script_json(scripts.data))]
    if scripts.delivery == "compressed" and scripts.moves:
        return _compressed(viewer[0], scripts)
    if scripts.delivery == "beside" and scripts.moves:
        beside = [f'<script src="{VIEWER_FILE}"></script>', f"<script>{scripts.own}</script>"]
        return [*data, *beside], f"'self' file: {_hashes(scripts.own)}"  # of a page on a disk, 'self' is not said by all
    texts = [*viewer, scripts.own]
    return [*data, *(f"<script>{text}</script>" for text in texts)], _hashes(*texts)


def _compressed(viewer: str, scripts: Scripts) -> tuple[list[str], str]:
    unpack = _asset("unpack.js")
    packed = [("viewer", viewer), ("motion-data", script_json(scripts.data)), ("own", scripts.own)]
    elements = [f'<script type="application/gzip" data-holds="{name}">{_gzip(text)}</script>' for name, text in packed]
    return [*elements, f"<script>{unpack}</script>"], _hashes(unpack, viewer, scripts.own)


def _gzip(text: str) -> str:
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode("ascii")


def _data(text: str) -> str:
    return f'<script type="application/json" id="motion-data">{text}</script>'


def _hashes(*texts: str) -> str:
    hashes = [base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in texts]
    return " ".join(f"'sha256-{value}'" for value in hashes)


def _policy(scripts: str) -> str:
    return f"default-src 'none'; script-src {scripts}; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"


def _asset(name: str) -> str:
    return (_ASSETS / name).read_text(encoding="utf-8")
