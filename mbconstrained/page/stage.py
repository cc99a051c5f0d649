"""The moving picture's place on the page: the stage, its controls and what they say."""

from __future__ import annotations

import html
import math

from .content import Animation
from .keyframes import KeyFrames

_HINT = "drag to turn, drag with the right button to shift, turn the wheel with the control key to zoom"


def stage_section(animation: Animation, frames: KeyFrames) -> str:
    """The picture, its play button, time slider, clock and choice of speed."""
    start, end = float(frames.times[0]), float(frames.times[-1])
    told = html.escape(_magnification(animation, frames))
    controls = stage_controls(start, end, told, ("time in seconds", "s"), _speeds(end - start))
    return f'<section class="motion">\n{controls}\n</section>'


def stage_controls(start: float, end: float, told: str, time: tuple[str, str], speeds: str) -> str:
    """The stage and what is below it.

    Args:
        start, end: of the time that runs.
        told: what is said over the picture, HTML.
        time: what it is that runs, and its unit.
        speeds: options to choose from, HTML.
    """
    fixed = " disabled" if end == start else ""
    return f"""<div id="stage"><div class="view" id="meshcat-pane" title="{_HINT}"></div><div class="labels"></div>
<p class="magnification">{told}</p>
<p class="missing">The 3-D view needs WebGL, which this browser does not offer.</p></div>
<noscript><p class="note">The moving picture needs JavaScript.</p></noscript>
<div class="controls">
<button type="button" id="play" aria-pressed="false"{fixed}>Play</button>
<input type="range" id="time" min="{start!r}" max="{end!r}" step="any" value="{start!r}" aria-label="{time[0]}"{fixed}>
<output id="clock" for="time">{start:g} {time[1]}</output>
<label>speed <select id="speed">{speeds}</select></label>
<button type="button" id="reset">Reset view</button>
</div>"""


def _magnification(animation: Animation, frames: KeyFrames) -> str:
    drawing = animation.drawing
    texts = []
    if any(body.path and body.path.moves for body in drawing.bodies) and drawing.scale != 1:
        texts.append(f"motion drawn {drawing.scale:g} × as large")
    elif any(body.moves for body in drawing.bodies) and drawing.scale != 1:
        texts.append(f"displacements drawn {drawing.scale:g} × as large")
    if any(body.turns for body in drawing.bodies) and drawing.turn_scale != 1:
        texts.append(f"angles drawn {drawing.turn_scale:g} × as large")
    if frames.stride > 1:
        texts.append(f"one in {frames.stride} of the times")
    return " · ".join(filter(None, (drawing.note, *texts)))


def _speeds(duration: float) -> str:
    """Factors to real time around one that shows the motion in a comfortable time."""
    usual = 1.0 if 3 <= duration <= 90 or duration <= 0 else 10.0 ** round(math.log10(duration / 15))
    options = [usual * factor for factor in (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0)]
    return "".join(
        f'<option value="{speed!r}"{" selected" if speed == usual else ""}>× {speed:g}</option>' for speed in options
    )


def decimals(frames: KeyFrames) -> int:
    """Digits after the point that tell a thousandth of the animation."""
    duration = frames.times[-1] - frames.times[0]
    return min(12, max(0, 3 - math.floor(math.log10(duration)))) if duration > 0 else 3
