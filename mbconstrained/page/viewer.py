"""The viewer: MeshCat's script as it lies in its installed package, its licences, and the commands it starts with.

The package is looked up, not imported: importing it would load IPython, zmq and tornado, and the page needs only
the one file of JavaScript.
"""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

from ..errors import MbconstrainedError
from ..replacing import Replacements

#: The viewer in a file of its own, beside the pages that share it.
VIEWER_FILE = "mbconstrained-viewer.js"

#: In the form of MeshCat's own messages: no grid, axes, sky or spot lights; a soft light from everywhere instead.
SCENE_COMMANDS = [
    {"type": "set_property", "path": "/Grid", "property": "visible", "value": False},
    {"type": "set_property", "path": "/Axes", "property": "visible", "value": False},
    {"type": "set_property", "path": "/Background", "property": "visible", "value": False},
    {"type": "set_property", "path": "/Lights/PointLightNegativeX", "property": "visible", "value": False},
    {"type": "set_property", "path": "/Lights/PointLightPositiveX", "property": "visible", "value": False},
    {"type": "set_property", "path": "/Lights/FillLight", "property": "visible", "value": False},
    {"type": "set_property", "path": "/Lights/AmbientLight/<object>", "property": "intensity", "value": 0.68},
]


def viewer_script() -> str:
    """The text of MeshCat's viewer, one file of JavaScript that can stand in a page.

    Raises:
        MbconstrainedError: meshcat is not installed, or its script would break out of a page.
    """
    text = (_folder() / "dist" / "main.min.js").read_text(encoding="utf-8")
    if "</script" in text.lower() or "<!--" in text:
        raise MbconstrainedError("meshcat: its script cannot be put into a page; install meshcat 0.3.2")
    return text


def write_viewer(folder: Path, files: Replacements) -> Path:
    """Write the script into a folder for all pages in it that do not hold it themselves.

    Args:
        folder: where the pages are.
        files: what takes its place together with it.
    """
    path = folder / VIEWER_FILE
    files.beside(path).write_text(viewer_script(), encoding="utf-8")
    return path


def viewer_licences() -> str:
    """The licences under which MeshCat and the libraries in its script may be passed on."""
    texts = ["MeshCat\n\n" + (_folder() / "LICENSE").read_text(encoding="utf-8").strip()]
    parts = json.loads((_folder() / "dist" / "main.min.js.THIRD_PARTY_LICENSES.json").read_text(encoding="utf-8"))
    texts += [f"{part['name']} {part['version']} ({part['license']})\n\n{part['licenseText'] or ''}".strip() for part in parts]
    return "\n\n\n".join(texts)


def _folder() -> Path:
    found = importlib.util.find_spec("meshcat")
    if found is None:
        raise MbconstrainedError('the animation needs the package "meshcat", which is not installed: pip install meshcat')
    return Path(found.submodule_search_locations[0]) / "viewer"
