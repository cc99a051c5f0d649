"""The page of mode shapes: a list of modes, of which the one that is picked moves; one static HTML file."""

from __future__ import annotations

import html

from .document import Delivery, document, page_scripts
from .figure import figure_data
from .keyframes import KeyFrames
from .mode_content import ModePicture, ModesContent
from .mode_sections import details_section, has_details, modes_section
from .sections import footer, header, notice_section
from .stage import stage_controls

#: Seconds in which one cycle is shown at speed 1.
CYCLE = 2.0

_SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0)

#: Digits after the point of the phase on the clock.
_DECIMALS = 2


def modes_html(content: ModesContent, viewer: Delivery = "inside") -> str:
    """The whole page as text.

    Without a mode there is no script and no picture in the page.

    Args:
        content: what is shown.
        viewer: where the script of the 3-D viewer is, as in ``page_html``.

    Raises:
        InputError: the drawing names a coordinate that the content does not have, or a mode is too large to be drawn.
        MbconstrainedError: there is a mode, but meshcat is not installed.

    >>> from mbconstrained.page.drawing import Drawing
    >>> "<script" in modes_html(ModesContent("Nothing moves", "", Drawing(()), ()))
    False
    """
    takes = [mode.frames(content.drawing, content.names) for mode in content.modes]
    first = next((i for i, frames in enumerate(takes) if len(frames.times) > 1), 0)
    parts = [
        header(content, with_theme=bool(takes)),
        "<main>",
        notice_section(content.notices),
        _picture(content, takes, first) if takes else '<section><p class="note">no modes</p></section>',
        modes_section(content.modes, first) if takes else "",
        "</main>",
        footer(content.facts, with_viewer=bool(takes)),
    ]
    scripts = page_scripts("modes.js", _data(content, takes, first), delivery=viewer) if takes else None
    return document(content.title, "\n".join(filter(None, parts)), scripts)


def _picture(content: ModesContent, takes: list[KeyFrames], first: int) -> str:
    moves = any(len(frames.times) > 1 for frames in takes)
    options = "".join(f'<option value="{speed!r}"{" selected" * (speed == 1)}>× {speed:g}</option>' for speed in _SPEEDS)
    told = html.escape(_told(content, content.modes[first], takes[first]))
    controls = stage_controls(0.0, float(moves), told, ("part of the cycle", "cycle"), options, loop=False)
    stage = f'<section class="motion">\n{controls}\n</section>'
    if not has_details(content.modes):
        return stage
    return f'<div class="picture">\n{stage}\n{details_section(content.modes, first)}\n</div>'


def _data(content: ModesContent, takes: list[KeyFrames], first: int) -> dict:
    rows = zip(content.modes, takes)
    return {
        "figure": figure_data(content.drawing, *takes),
        "names": list(content.names),
        "modes": [_mode_data(content, mode, frames) for mode, frames in rows],
        "first": first,
        "cycle": CYCLE,
        "decimals": _DECIMALS,
        "unit": "cycle",
    }


def _mode_data(content: ModesContent, mode: ModePicture, frames: KeyFrames) -> dict:
    return {"name": mode.name, "period": mode.period, "told": _told(content, mode, frames), "frames": frames.as_packed()}


def _told(content: ModesContent, mode: ModePicture, frames: KeyFrames) -> str:
    """The drawing's note, and by which factors the mode is not to scale."""
    drawing = content.drawing
    return "\n".join(filter(None, (drawing.note, _factors(content, mode) if len(frames.times) > 1 else "does not move")))


def _factors(content: ModesContent, mode: ModePicture) -> str:
    drawing, bodies = content.drawing, content.drawing.bodies
    slides, turns = (any(getattr(body, kind) for body in bodies) for kind in ("moves", "turns"))
    by_path = f"shape drawn × {mode.scale:g}" if mode.paths else ""
    sliding = f"displacements of the shape drawn × {drawing.scale * mode.scale:g}" if slides else ""
    turning = f"angles × {drawing.turn_scale * mode.scale:g}" if turns else ""
    return "not to scale: " + ", ".join(filter(None, (by_path, sliding, turning)))
