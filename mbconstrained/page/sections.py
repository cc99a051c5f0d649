"""The sections of a page as HTML: notices, figures, formulas, tables, and the animation with its controls.

All texts are escaped.
"""

from __future__ import annotations

import html
from collections.abc import Sequence

from ..ground.checks import counted
from ..ground.display import TextTable, is_number
from ..ground.notices import Notice
from .content import Figure, Formulas
from .typeset import shortened, typeset

#: A table cell with more letters than the first is a sentence, with more than the second a long one.
SENTENCE, LONG_SENTENCE = 24, 40

#: Letters of a name for assistive technology.
LONGEST_LABEL = 100

#: Letters of the first notice in the line that stands for all.
LONGEST_SUMMARY = 200

_KEYS = (
    ("Space", "play, pause"),
    ("←</kbd> <kbd>→", "back, forward by a hundredth of the duration"),
    ("Home</kbd> <kbd>End", "to the start, to the end"),
    ("+</kbd> <kbd>−", "faster, slower"),
    ("L", "loop at the end, or stop there"),
    ("?", "this list"),
)


def notice_section(notices: tuple[Notice, ...]) -> str:
    """The notices, folded into one line with their number; doubtful ones first and as warnings."""
    if not notices:
        return ""
    rows, texts = [], []
    for notice in sorted(notices, key=lambda notice: not notice.doubtful):
        kind, label = ("notice doubtful", "Warning") if notice.doubtful else ("notice", "Note")
        rows.append(f'<p class="{kind}"><b>{label} ({html.escape(notice.kind)}):</b> {typeset(notice.text)}</p>')
        texts.append(notice.text)
    doubtful = sum(notice.doubtful for notice in notices)
    counts = [counted(count, one) for count, one in ((doubtful, "warning"), (len(notices) - doubtful, "note")) if count]
    first = shortened(texts[0], LONGEST_SUMMARY)
    return (
        f'<details class="notices{" doubtful" * bool(doubtful)}"><summary><b>{", ".join(counts)}:</b> {typeset(first)}</summary>\n'
        f"{''.join(rows)}</details>"
    )


def figure_section(figure: Figure) -> str:
    """A <figure> over the full width; in a narrow window it scrolls, so that it stays readable."""
    labelled = f'<svg role="img" aria-label="{html.escape(figure.description)}"'
    svg = figure.svg.strip().replace("<svg", labelled, 1)
    title = f'<figure class="static">\n<h2>{html.escape(figure.title)}</h2>'
    return f"{title}\n{_scrollable(figure.title)}{svg}</div>{_note(figure.note, before=chr(10))}\n</figure>"


def formula_section(formulas: Formulas) -> str:
    """Formulas, each in a box of its own that scrolls where it is too wide."""
    lines = "\n".join(f'<div class="formula">{line}</div>' for line in formulas.lines)
    title = f'<section class="formulas">\n<h2>{html.escape(formulas.title)}</h2>'
    return f'{title}\n<div class="all-formulas">{lines}</div>{_note(formulas.note)}\n</section>'


def table_section(table: TextTable, kind: str = "") -> str:
    """A titled table; columns of numbers are set flush right. A folded one shows its title only."""
    columns = list(zip(*table.rows)) or [()] * len(table.columns)
    kinds = [_kind(column) for column in columns]
    head = "".join(f'<th scope="col"{kind}>{typeset(text)}</th>' for kind, text in zip(kinds, table.columns))
    rows = "".join(
        "<tr>" + "".join(f"<td{kind}>{typeset(cell)}</td>" for kind, cell in zip(kinds, row)) + "</tr>\n" for row in table.rows
    )
    body = f"<table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table>"
    content = f"{_scrollable(table.title)}{body}</div>{_note(table.note)}" if table.columns else _note(table.note)
    title = f"<h2>{html.escape(table.title)}</h2>"
    if table.folded:
        return f'<section class="folded">\n<details><summary>{title}</summary>\n{content}\n</details>\n</section>'
    return f"<section{f' class={chr(34)}{kind}{chr(34)}' if kind else ''}>\n{title}\n{content}\n</section>"


def _note(text: str, before: str = "") -> str:
    return f'{before}<p class="note">{typeset(text)}</p>' if text else ""


def _scrollable(name: str) -> str:
    """The start of an element that may be wider than the window, so that the arrow keys can scroll it."""
    return f'<div class="scroll" tabindex="0" role="group" aria-label="{html.escape(name[:LONGEST_LABEL])}">'


def _kind(column: tuple[str, ...]) -> str:
    """Numbers are flush right; columns of sentences are wide enough for some words in each line."""
    longest = max(map(len, column), default=0)
    if column and longest <= LONG_SENTENCE and all(map(is_number, column)):
        return ' class="number"'
    return ' class="long sentence"' if longest > LONG_SENTENCE else ' class="sentence"' if longest > SENTENCE else ""


#: Optional contents: kind, entry of a body in the figure that has it, text of its box.
_MARKS = (
    ("names", "label", "names"),
    ("perspective", "name", "perspective"),
    ("frames", "frame", "frames"),
    ("collision", "collision", "collision geometry"),
    ("masses", "ellipsoid", "centres of mass"),
)


def _marks(figure: dict) -> str:
    """A box for each kind of mark that the figure has, and the buttons that record."""
    offered = [(kind, text) for kind, entry, text in _MARKS if any(body[entry] for body in figure["bodies"])]
    boxes = "".join(
        f'<label><input type="checkbox" data-shows="{kind}"{" checked" * (kind == "names")}> {text}</label>\n'
        for kind, text in offered
    )
    return f"""<div class="controls shown">
{boxes}<div class="recordings">
<button type="button" id="frames" hidden>Save frames</button>
<button type="button" id="gif" hidden>Save GIF</button>
<button type="button" id="record" hidden>Record</button>
</div>
</div>"""


def _posing(figure: dict) -> str:
    """A folded panel with a slider for each independent coordinate of a robot."""
    if "posing" not in figure:
        return ""
    sliders = "\n".join(
        f'<label><span>{html.escape(name)}</span><input type="range" data-joint="{k}" data-unit="{unit}" min="{-limit!r}"'
        f' max="{limit!r}" step="any" value="0" autocomplete="off"><output>0 {unit}</output></label>'
        for k, (name, unit, limit) in enumerate(figure["posing"]["sliders"])
    )
    closed = " The joints without a slider follow and close the loops to first order." * (
        len(figure["posing"]["columns"]) > len(figure["posing"]["sliders"])
    )
    return f"""
<details class="joints"><summary>Joints</summary>
<p class="note">Small motions from the posture, not magnified.{closed}</p>
<div class="sliders">
{sliders}
</div>
<button type="button" id="posture">Reset joints</button>
</details>"""


def stage_section(
    figure: dict,
    start: float,
    end: float,
    text: str,
    time: tuple[str, str],
    speeds: Sequence[float],
    usual: float,
    *,
    loop: bool = True,
    further: str = "",
) -> str:
    """The animation: the stage, the controls below it, and the keyboard shortcuts as a closed dialog."""
    loop_button = '\n<button type="button" id="loop" aria-pressed="true">Loop</button>' if loop else ""
    fixed = " disabled" if end == start else ""
    options = "".join(f'<option value="{speed!r}"{" selected" if speed == usual else ""}>× {speed:g}</option>' for speed in speeds)
    keys = "".join(f"<dt><kbd>{key}</kbd></dt><dd>{does}</dd>" for key, does in _KEYS if loop or key != "L")
    return f"""<section class="motion">
<h2 class="visually-hidden">Animation</h2>
<div id="stage"><div class="view" role="img" aria-label="the model at the time of the slider" id="meshcat-pane" \
title="drag to rotate, drag with the right button to pan, turn the wheel with the control key to zoom"></div>
<div class="labels" aria-hidden="true"></div>
<p class="magnification">{html.escape(text)}</p>
<p class="missing">The 3-D view needs WebGL, which this browser does not offer.</p></div>
<noscript><p class="note">The animation needs JavaScript.</p></noscript>
<div class="controls">
<button type="button" id="play"{fixed}>Play</button>
<input type="range" id="time" min="{start!r}" max="{end!r}" step="any" value="{start!r}"
 aria-label="{time[0]}" aria-valuetext="{start:g} {time[1]}"{fixed}>
<span id="clock">{start:g} {time[1]}</span>
<label>speed <select id="speed">{options}</select></label>{loop_button}
<button type="button" id="reset">Reset view</button>
<button type="button" id="keys" aria-label="Keyboard" title="Keyboard">?</button>
</div>
{_marks(figure)}{_posing(figure)}{further}
<p class="visually-hidden" id="announcement" role="status"></p>
<dialog id="help" aria-label="Keyboard">
<h2>Keyboard</h2>
<dl>{keys}</dl>
<button type="button" id="close">Close</button>
</dialog>
</section>"""
