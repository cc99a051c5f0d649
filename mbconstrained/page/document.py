"""One static HTML file with all it needs inside it.

Nothing is fetched and nothing but the scripts written here can run: the content security policy forbids everything
else and names the scripts by their hashes. The same content always gives the same bytes.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
from pathlib import Path

from .viewer import viewer_script

_ASSETS = Path(__file__).with_name("assets")
_SCRIPTS = ("motion.js", "shapes.js", "parts.js", "links.js", "stage.js", "player.js")


def document(title: str, body: str, scripts: tuple[str, ...] = ()) -> str:
    """The whole file: its head, the body and the scripts, which are the only ones that may run."""
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
{"".join([body, *(f"{chr(10)}<script>{script}</script>" for script in scripts)])}
</body>
</html>
"""


def motion_scripts(page: str) -> tuple[str, str]:
    """The viewer and the page's own scripts, which end with that of this kind of page, such as "run.js".

    The own ones stand in one scope, so that they name nothing in the window but ``mbconstrained``.

    Raises:
        MbconstrainedError: meshcat is not installed.
    """
    own = "\n".join(_asset(name) for name in (*_SCRIPTS, page))
    return viewer_script(), '(function () {\n"use strict";\n' + own + "})();\n"


def motion_data(data: dict) -> str:
    """The element with the data that the scripts read."""
    return f'<script type="application/json" id="motion-data">{script_json(data)}</script>'


def script_json(data) -> str:
    """JSON that can stand in a script element: nothing in it can end the element or start another.

    >>> script_json("</script>")
    '"\\\\u003c/script\\\\u003e"'
    """
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _policy(scripts: tuple[str, ...]) -> str:
    hashes = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts]
    allowed = " ".join(f"'sha256-{value}'" for value in hashes) or "'none'"
    return f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"


def _asset(name: str) -> str:
    return (_ASSETS / name).read_text(encoding="utf-8")
