"""The moving picture's place on the page: the stage, its controls and what they say."""

from __future__ import annotations

import html
import math

from .content import Animation
from .keyframes import KeyFrames
from .marks_data import told_scale

_SEEN = "the model at the time of the slider"
_KEYS = (
    ("Space", "play, pause"),
    ("←</kbd> <kbd>→", "a hundredth of the time back, on"),
    ("Home</kbd> <kbd>End", "to the start, to the end"),
    ("+</kbd> <kbd>−", "faster, slower"),
    ("L", "start again at the end, or stop there"),
    ("?", "this list"),
)
_HINT = "drag to turn, drag with the right button to shift, turn the wheel with the control key to zoom"


def stage_section(animation: Animation, frames: KeyFrames) -> str:
    """The picture, its play button, time slider, clock and choice of speed."""
    start, end = float(frames.times[0]), float(frames.times[-1])
    told = html.escape(_magnification(animation, frames))
    controls = stage_controls(start, end, told, ("time in seconds", "s"), _speeds(end - start))
    return f'<section class="motion">\n{controls}\n</section>'


def stage_controls(start: float, end: float, told: str, time: tuple[str, str], speeds: str, *, loop: bool = True) -> str:
    """The stage and what is below it.

    Args:
        start, end: of the time that runs.
        told: what is said over the picture, HTML.
        time: what it is that runs, and its unit.
        speeds: options to choose from, HTML.
        loop: whether there is a choice of what comes after the end.
    """
    again = '\n<button type="button" id="loop" aria-pressed="true">Loop</button>' if loop else ""
    fixed = " disabled" if end == start else ""
    return f"""<h2 class="spoken">Moving picture</h2>
<div id="stage"><div class="view" role="img" aria-label="{_SEEN}" id="meshcat-pane" title="{_HINT}"></div>
<div class="labels" aria-hidden="true"></div>
<p class="magnification">{told}</p>
<p class="missing">The 3-D view needs WebGL, which this browser does not offer.</p></div>
<noscript><p class="note">The moving picture needs JavaScript.</p></noscript>
<div class="controls">
<button type="button" id="play"{fixed}>Play</button>
<input type="range" id="time" min="{start!r}" max="{end!r}" step="any" value="{start!r}"
 aria-label="{time[0]}" aria-valuetext="{start:g} {time[1]}"{fixed}>
<span id="clock">{start:g} {time[1]}</span>
<label>speed <select id="speed">{speeds}</select></label>{again}
<button type="button" id="reset">Reset view</button>
<button type="button" id="keys" aria-label="Keyboard" title="keyboard">?</button>
</div>
<p class="spoken" id="said" role="status"></p>
{_help(loop)}"""


def _help(loop: bool) -> str:
    """What the keys do, as a dialog that is closed."""
    rows = "".join(f"<dt><kbd>{key}</kbd></dt><dd>{does}</dd>" for key, does in _KEYS if loop or key != "L")
    close = '<button type="button" id="close">Close</button>'
    return f'<dialog id="help" aria-label="Keyboard">\n<h2>Keyboard</h2>\n<dl>{rows}</dl>\n{close}\n</dialog>'


def _magnification(animation: Animation, frames: KeyFrames) -> str:
    drawing = animation.drawing
    texts = []
    if any(body.path and body.path.moves for body in drawing.bodies) and drawing.scale != 1:
        texts.append(f"motion drawn {drawing.scale:g} × as large")
    elif any(body.moves for body in drawing.bodies) and drawing.scale != 1:
        texts.append(f"displacements drawn {drawing.scale:g} × as large")
    if any(body.turns for body in drawing.bodies) and drawing.turn_scale != 1:
        texts.append(f"angles drawn {drawing.turn_scale:g} × as large")
    if animation.marks.forces:
        texts.append(f"arrows: {animation.marks.told}, {told_scale(animation.marks.forces)}")
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
