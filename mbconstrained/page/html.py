"""A page as one static HTML file.

The page fetches nothing, and only the scripts written here can run: its content security policy forbids everything else and
names the scripts by their hashes. The same content always gives the same bytes.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
import importlib.util
import json
import math
import re
from pathlib import Path
from typing import Literal

from ..ground.errors import InputError, MbconstrainedError
from ..ground.files import Replacements
from .animation.animation import Animation
from .animation.figure import figure_data, invisible_errors
from .animation.keyframes import KeyFrames, key_frames
from .animation.overlay import force_scale
from .animation.shapes import Deflections, Shapes
from .content import PageContent
from .plots.svg_plot import PlotFunctions, plot_figures
from .sections import figure_section, formula_section, notice_section, stage_section, table_section
from .shape_sections import deflection_sections, mode_sections
from .typeset import typeset

#: Location of the 3-D viewer: in the page, in a file shared by many pages, or in the page and compressed with all scripts.
Delivery = Literal["inside", "separate", "compressed"]

#: The viewer in a file of its own, next to the pages that share it.
VIEWER_FILE = "mbconstrained-viewer.js"

_ASSETS = Path(__file__).with_name("assets")
_ANIMATION = (
    "motion.js",
    "shapes.js",
    "solids.js",
    "links.js",
    "names.js",
    "marks.js",
    "stage.js",
    "record.js",
    "frames.js",
    "gif.js",
    "player.js",
    "keys.js",
    "print.js",
)
_PLOTS = ("readings.js", "axes.js", "plots.js")


def write_page(path, content: PageContent, viewer: Delivery = "inside", files: Replacements | None = None) -> Path:
    """Write a page; an existing file is replaced only when the new one is complete."""
    path = Path(path)
    if files is None:
        try:
            with Replacements() as files:
                return write_page(path, content, viewer, files)
        except OSError as error:
            raise InputError(f'the page "{path}" cannot be written: {error.strerror or error}; give another path') from None
    text = page_html(content, viewer)
    files.temporary(path).write_bytes(text.encode("utf-8", errors="replace"))
    if f'src="{VIEWER_FILE}"' in text:
        files.temporary(path.with_name(VIEWER_FILE)).write_text(viewer_script(), encoding="utf-8")
    return path


def page_html(content: PageContent, viewer: Delivery = "inside") -> str:
    """The whole page as text.

    An animation brings the viewer, its controls and one script, plots bring a script; without both there is no script in
    the page at all.

    >>> "<script" in page_html(PageContent("Only a title"))
    False
    """
    sections, data, names, blocks = _parts(content)
    elements, allowed = _scripts(names, blocks, viewer)
    body = [
        _header(content.title, content.source, with_theme=bool(names)),
        "<main>",
        notice_section(content.notices),
        *sections,
        "</main>",
        _footer(content.facts, viewer_licences() if data else ""),
        *elements,
    ]
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; \
base-uri 'none'; form-action 'none'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{html.escape(content.title)}</title>
<style>
{_asset("page.css")}</style>
</head>
<body>
{chr(10).join(filter(None, body))}
</body>
</html>
"""


def _header(title: str, source: str, *, with_theme: bool) -> str:
    """Title and source, and with scripts the switch from light to dark."""
    source = f"\n<p>{html.escape(source)}</p>" if source else ""
    theme = '\n<button type="button" id="theme">Switch to dark</button>' if with_theme else ""
    return f"<header>\n<h1>{html.escape(title)}</h1>{source}{theme}\n</header>"


def _footer(facts: tuple[tuple[str, str], ...], licences: str) -> str:
    """Facts, and the licences of the 3-D viewer where the page contains it."""
    rows = "".join(f"<dt>{html.escape(label)}</dt><dd>{typeset(text)}</dd>" for label, text in facts)
    details = f'<details><summary>Licences of the 3-D viewer</summary><pre tabindex="0">{html.escape(licences)}</pre></details>\n'
    return f"<footer>\n{f'<dl>{rows}</dl>{chr(10)}' if facts else ''}{details if licences else ''}</footer>"


def _parts(content: PageContent) -> tuple[list[str], dict, list[str], dict[str, list | dict]]:
    """The sections, the data of the animation, the names of the scripts, and the data that they read."""
    names: list[str] = []
    blocks: dict[str, list | dict] = {}
    functions, shown = PlotFunctions(content.plots), content.animation
    if isinstance(shown, Shapes):
        script, (sections, data) = "modes.js", mode_sections(content, shown, functions)
    elif isinstance(shown, Deflections):
        script, (sections, data) = "frequency.js", deflection_sections(content, shown, functions)
    else:
        script, (sections, data) = "run.js", _run_sections(content, shown, functions)
    if functions.sets:
        blocks["plot-data"], names = functions.as_data(), list(_PLOTS)
    if data:
        names += [*_ANIMATION, *[f"{name}.js" for name in ("overlay", "posing") if name in data["figure"]], script]
        blocks["motion-data"] = data
    if names:
        names = ["theme.js", "numbers.js", *names]
    return sections, data, names, blocks


def _run_sections(content: PageContent, animation: Animation | None, functions: PlotFunctions) -> tuple[list[str], dict]:
    """The sections of the page of a run, and the data of its animation; none without."""
    stage, data = "", {}
    if animation is not None:
        frames = key_frames(animation)
        figure = figure_data(animation.drawing, [frames], animation.overlay)
        errors = invisible_errors(animation.drawing, frames.names, figure)
        start, end = float(frames.times[0]), float(frames.times[-1])
        decimals = min(12, max(0, 3 - math.floor(math.log10(end - start)))) if end > start else 3
        data = {"figure": figure, "frames": frames.as_data(*errors), "decimals": decimals, "unit": "s"}
        usual = 1.0 if 3 <= end - start <= 90 or end <= start else 10.0 ** round(math.log10((end - start) / 15))
        speeds = [usual * factor for factor in (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0)]  # 1 shows the motion in 3 to 90 s
        stage = stage_section(figure, start, end, _magnification(animation, frames), ("time in seconds", "s"), speeds, usual)
    frequencies = table_section(content.frequencies, "frequencies") if content.frequencies else ""
    if stage and frequencies:
        frequencies, stage = "", f'<div class="overview">\n{frequencies}\n{stage}\n</div>'
    return [
        *map(figure_section, content.figures),
        frequencies,
        stage,
        plot_figures(content.plots, functions),
        formula_section(content.formulas) if content.formulas else "",
        *map(table_section, content.tables),
    ], data


def _magnification(animation: Animation, frames: KeyFrames) -> str:
    """The drawing's note, the magnification of the motion and the scale of the arrows."""
    drawing = animation.drawing
    texts = []
    if any(body.path and body.path.moves for body in drawing.bodies) and drawing.scale != 1:
        texts.append(f"motion drawn {drawing.scale:g} × as large")
    elif any(body.moves for body in drawing.bodies) and drawing.scale != 1:
        texts.append(f"displacements drawn {drawing.scale:g} × as large")
    if any(body.turns for body in drawing.bodies) and drawing.turn_scale != 1:
        texts.append(f"angles drawn {drawing.turn_scale:g} × as large")
    if animation.overlay.forces:
        texts.append(f"arrows: {animation.overlay.description}, {force_scale(animation.overlay.forces)}")
    if frames.stride > 1:
        texts.append(f"one in {frames.stride} of the times")
    return " · ".join(filter(None, (drawing.note, *texts)))


def _scripts(names: list[str], blocks: dict[str, list | dict], delivery: Delivery) -> tuple[list[str], str]:
    """The elements at the end of the body, and the sources of scripts that the policy allows.

    The page's own scripts are in one scope, so that the only global name is ``mbconstrained``. Each block of data is an element
    with its name.
    """
    if not names:
        return [], "'none'"
    own = '(function () {\n"use strict";\n' + "\n".join(map(_script, names)) + "})();\n"
    texts = {name: script_json(data) for name, data in blocks.items()}
    data = [f'<script type="application/json" id="{name}">{text}</script>' for name, text in texts.items()]
    if "motion-data" not in blocks:
        return [*data, f"<script>{own}</script>"], _hashes(own)
    viewer = viewer_script()
    if delivery == "compressed":
        unpack = _script("unpack.js")
        packed = [
            f'<script type="application/gzip" data-content="{name}">{_base64(gzip.compress(part.encode(), 9, mtime=0))}</script>'
            for name, part in (("viewer", viewer), *texts.items(), ("own", own))
        ]
        return [*packed, f"<script>{unpack}</script>"], _hashes(unpack, viewer, own)
    if delivery == "separate":
        allowed = f"'self' file: {_hashes(own)}"  # not all browsers take file: for 'self'
        return [*data, f'<script src="{VIEWER_FILE}"></script>', f"<script>{own}</script>"], allowed
    return [*data, f"<script>{viewer}</script>", f"<script>{own}</script>"], _hashes(viewer, own)


def _base64(content: bytes) -> str:
    return base64.b64encode(content).decode("ascii")


def _hashes(*texts: str) -> str:
    return " ".join(f"'sha256-{_base64(hashlib.sha256(text.encode()).digest())}'" for text in texts)


def script_json(data) -> str:
    """JSON for a script element: nothing in it can end the element or start another.

    >>> script_json("</script>")
    '"\\\\u003c/script\\\\u003e"'
    """
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _asset(name: str) -> str:
    return (_ASSETS / name).read_text(encoding="utf-8")


def _script(name: str) -> str:
    """A script without the lines of its comments, which are a tenth of it."""
    return re.sub(r"^ *//.*\n", "", _asset(name), flags=re.MULTILINE)


def viewer_script() -> str:
    """MeshCat's viewer, one file of JavaScript that can be included in a page."""
    text = (_viewer_folder() / "dist" / "main.min.js").read_text(encoding="utf-8")
    if "</script" in text.lower() or "<!--" in text:
        raise MbconstrainedError("meshcat: its script cannot be included in a page; install meshcat 0.3.2")
    return text


def viewer_licences() -> str:
    """The licences under which MeshCat and the libraries in its script may be passed on."""
    texts = ["MeshCat\n\n" + (_viewer_folder() / "LICENSE").read_text(encoding="utf-8").strip()]
    rows = json.loads((_viewer_folder() / "dist" / "main.min.js.THIRD_PARTY_LICENSES.json").read_text(encoding="utf-8"))
    texts += [f"{row['name']} {row['version']} ({row['license']})\n\n{row['licenseText'] or ''}".strip() for row in rows]
    return "\n\n\n".join(texts)


def _viewer_folder() -> Path:
    """The package is located, not imported: importing it would load IPython, zmq and tornado."""
    package = importlib.util.find_spec("meshcat")
    if package is None:
        raise MbconstrainedError('the animation needs the package "meshcat", which is not installed: pip install meshcat')
    return Path(package.submodule_search_locations[0]) / "viewer"
