"""The page: one static HTML file with all it needs inside it.

Nothing is fetched and nothing but the scripts written here can run: the content security policy forbids everything
else and names the scripts by their hashes. The same content always gives the same bytes.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
from pathlib import Path

from .content import Animation, PageContent
from .figure import figure_data
from .keyframes import KeyFrames, key_frames
from .sections import footer, header, notice_section, plot_figures, table_section
from .stage import decimals, stage_section
from .viewer import viewer_script

_ASSETS = Path(__file__).with_name("assets")
_SCRIPTS = ("motion.js", "shapes.js", "links.js", "stage.js", "player.js")


def page_html(content: PageContent) -> str:
    """The whole page as text.

    An animation brings the viewer, its controls and one script; without one there is no script in the page at all.

    Raises:
        InputError: the drawing names a coordinate that the animation does not have.
        MbconstrainedError: there is an animation, but meshcat is not installed.

    >>> "<script" in page_html(PageContent("Nothing moves"))
    False
    """
    frames = None if content.animation is None else _frames(content.animation)
    scripts = [] if frames is None else [viewer_script(), _own_script()]
    parts = [
        header(content),
        "<main>",
        notice_section(content.notices),
        "" if frames is None else stage_section(content.animation, frames),
        plot_figures(content.plots),
        *(table_section(table) for table in content.tables),
        "</main>",
        footer(content.facts, with_viewer=frames is not None),
        "" if frames is None else _data(content.animation, frames),
        *(f"<script>{script}</script>" for script in scripts),
    ]
    return _document(content.title, "\n".join(filter(None, parts)), scripts)


def _document(title: str, body: str, scripts: list[str]) -> str:
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_policy(scripts)}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(title)}</title>
<style>
{_asset("page.css")}</style>
</head>
<body>
{body}
</body>
</html>
"""


def _policy(scripts: list[str]) -> str:
    hashes = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts]
    allowed = " ".join(f"'sha256-{value}'" for value in hashes) or "'none'"
    return f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"


def _asset(name: str) -> str:
    return (_ASSETS / name).read_text(encoding="utf-8")


def _own_script() -> str:
    """The page's own scripts in one scope, so that they name nothing in the window but ``mbconstrained``."""
    return '(function () {\n"use strict";\n' + "\n".join(_asset(name) for name in _SCRIPTS) + "})();\n"


def _frames(animation: Animation) -> KeyFrames:
    return key_frames(animation.drawing, animation.names, animation.times, animation.values, animation.rates)


def _data(animation: Animation, frames: KeyFrames) -> str:
    data = {
        "figure": figure_data(animation.drawing, frames),
        "frames": frames.as_data(),
        "decimals": decimals(frames),
    }
    return f'<script type="application/json" id="motion-data">{script_json(data)}</script>'


def script_json(data) -> str:
    """JSON that can stand in a script element: nothing in it can end the element or start another.

    >>> script_json("</script>")
    '"\\\\u003c/script\\\\u003e"'
    """
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
