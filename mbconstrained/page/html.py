"""A page as one static HTML file, with its sections: notices, formulas, tables, animation and swinging shapes.

All texts are escaped.

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
from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Literal

import numpy as np

from ..ground.checks import counted
from ..ground.display import TextTable, is_number
from ..ground.errors import InputError, MbconstrainedError
from ..ground.files import Replacements
from ..ground.notices import Notice
from .animation import MODE, Animation, Deflections, KeyFrames, ModePicture, Shapes, cycle, key_frames, packed
from .content import Formulas, PageContent, scientific, shortened, typeset
from .drawing import Drawing
from .figure import figure_data, force_scale, invisible_errors
from .plots import PlotFunctions, plot_figures

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
    rows = ""
    for row, time in zip_longest(table.rows, table.times):
        cells = [typeset(cell) for cell in row]
        if time is not None:
            cells[0] = f'<a href="#t={time!r}">{cells[0]}</a>'
        rows += "<tr>" + "".join(f"<td{kind}>{cell}</td>" for kind, cell in zip(kinds, cells)) + "</tr>\n"
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


def _marks(figure: dict, slow: bool | None) -> str:
    """A box for each kind of mark that the figure has, for a slower pace at events if there are any, and the buttons that record."""
    offered = [(kind, text) for kind, entry, text in _MARKS if any(body[entry] for body in figure["bodies"])]
    boxes = "".join(
        f'<label><input type="checkbox" data-shows="{kind}"{" checked" * (kind == "names")}> {text}</label>\n'
        for kind, text in offered
    )
    if slow is not None:
        boxes += f'<label><input type="checkbox" id="slow" autocomplete="off"{" checked" * slow}> slow at events</label>\n'
    return f"""<div class="controls shown further">
{boxes}<div class="together">
<button type="button" id="reset">Reset view</button>
<button type="button" id="keys" aria-label="Keyboard" title="Keyboard">?</button>
</div>
<div class="recordings">
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
<details class="joints further"><summary>Joints</summary>
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
    slow: bool | None = None,
) -> str:
    """The animation: the stage, the controls below it, and the keyboard shortcuts as a closed dialog."""
    loop_button = '\n<button type="button" id="loop" class="further" aria-pressed="true">Loop</button>' if loop else ""
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
<label class="further">speed <select id="speed">{options}</select></label>{loop_button}
<button type="button" id="more" aria-expanded="false">More</button>
</div>{further}
{_marks(figure, slow)}{_posing(figure)}
<p class="visually-hidden" id="announcement" role="status"></p>
<dialog id="help" aria-label="Keyboard">
<h2>Keyboard</h2>
<dl>{keys}</dl>
<button type="button" id="close">Close</button>
</dialog>
</section>"""


#: Duration of one cycle at speed 1, s, and digits after the decimal point of the phase on the clock.
CYCLE, DECIMALS = 2.0, 2

#: Entries of a shape on the page; the command prints all as JSON.
MOST_ENTRIES = 30

#: Smaller energy shares are rounding errors, and shown as 0.
SMALLEST_SHARE = 1e-9

#: Columns of facts in the list of modes next to the picture, and those that phones have, too; further facts are in the details.
MOST_FACTS, FACTS_ON_PHONES = 3, 2

#: Factors of the speed menu.
SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0)

#: Frequencies of the deflection shapes from which the picture takes its bounds.
MOST_BOUNDS = 24

_TIME = "part of the cycle", "cycle"
_CLOCK = {"cycle": CYCLE, "decimals": DECIMALS, "unit": "cycle"}


def mode_sections(content: PageContent, shapes: Shapes, functions: PlotFunctions) -> tuple[list[str], dict]:
    """The sections of a page of mode shapes, and the data of its animation; none without modes."""
    modes, names = shapes.modes, shapes.names
    cycles = [mode.frames(shapes.drawing, names) for mode in modes]
    if not cycles:
        return ['<section><p class="note">no modes</p></section>'], {}
    moves = [len(frames.times) > 1 for frames in cycles]
    elastic = [moves[i] and mode.period is not None and not mode.is_zero for i, mode in enumerate(modes)]
    first = next((own.index(True) for own in (elastic, moves) if any(own)), 0)
    notes = [_scale_note(shapes.drawing, *each) for each in zip(modes, moves)]
    figure = figure_data(shapes.drawing, cycles)
    slider = ""
    if shapes.word != MODE and len(modes) > 1:  # through a list of other things than modes
        slider = _slider(shapes.word, "choice", "chosen", len(modes), first, html.escape(modes[first].name))
    picture = stage_section(figure, 0.0, float(any(moves)), notes[first], _TIME, SPEEDS, 1.0, loop=False, further=slider)
    facts = [dict(mode.facts) for mode in modes]
    labels, details = list(dict.fromkeys(label for own in facts for label in own)), ""
    if any(mode.shares or mode.shape or mode.note for mode in modes):
        # without scripts the details of all modes are visible
        visible = "<noscript><style>.details section[hidden] { display: block; }</style></noscript>"
        labels, further = labels[:MOST_FACTS], labels[FACTS_ON_PHONES:]
        details = "\n".join(_details(i, mode, further, i == first) for i, mode in enumerate(modes))
        details = f'\n<div class="details">{visible}\n{details}\n</div>'
    data = {
        "figure": figure,
        "names": list(names),
        "modes": [
            {"name": mode.name, "period": mode.period, "note": note, "frames": frames.as_packed()}
            for mode, note, frames in zip(modes, notes, cycles)
        ],
        "first": first,
        **_CLOCK,
    }
    rows = [(mode.name, *(own.get(label, "") for label in labels)) for mode, own in zip(modes, facts)]
    table = TextTable(f"{shapes.word.capitalize()}s", (shapes.word, *labels), tuple(rows))
    marks = [f'data-mode="{i}"' for i in range(len(modes))]
    listed = _list("modes", table, shapes.word, "mode", marks, first, folded=[mode.is_zero for mode in modes])
    plots = plot_figures(content.plots, functions) if content.plots else ""
    together = f'<div class="picture">\n{picture}\n<div class="aside">\n{listed}{details}\n</div>\n</div>'
    return [together, plots, *map(table_section, content.tables)], data


def deflection_sections(content: PageContent, shapes: Deflections, functions: PlotFunctions) -> tuple[list[str], dict]:
    """The sections of a page of deflection shapes, and the data of its animation; the first table is that of the peaks."""
    peaks, *tables = content.tables
    lines = [shapes.nearest(frequency) for frequency, _ in shapes.peaks]
    inputs = [number for _, number in shapes.peaks]
    first = (lines[0], inputs[0]) if lines else (len(shapes.frequencies) // 2, 0)
    figure = figure_data(shapes.drawing, _bounding(shapes, lines))
    stage = stage_section(figure, 0.0, 1.0, "", _TIME, SPEEDS, 1.0, loop=False, further=_frequency_controls(shapes, first))
    data = {
        "figure": figure,
        "names": list(shapes.names),
        "note": shapes.drawing.note,
        "inputs": list(shapes.inputs),
        "axis": shapes.axis,
        "lines": packed(shapes.frequencies, "<f8"),
        "periods": packed(shapes.periods, "<f8"),
        "real": [packed(block) for block in shapes.shapes.real],
        "imaginary": [packed(block) for block in shapes.shapes.imag],
        "factors": [packed(row) for row in shapes.factors * shapes.drawing.scale],
        "moves": any(body.moves for body in shapes.drawing.bodies),
        "first": {"line": first[0], "input": first[1]},
        **_CLOCK,
    }
    plots = plot_figures(content.plots, functions)
    together = f'<div class="response">\n<div class="deflection">\n{stage}\n</div>\n<div class="beneath">\n{plots}\n</div>\n</div>'
    note = f'<p class="note">{typeset(peaks.note)}</p>' if peaks.note else ""
    listed = f'<section class="peaks">\n<h2>{html.escape(peaks.title)}</h2>\n{note}\n</section>'
    if peaks.rows:
        data_of_rows = [f'data-line="{line}" data-input="{number}"' for line, number in zip(lines, inputs)]
        listed = _list("modes peaks", peaks, "peak", "peak", data_of_rows, 0, f"\n{note}")
    return [together, listed, *map(table_section, tables)], data


def _list(
    kind: str, table: TextTable, word: str, group: str, data: Sequence[str], first: int, note: str = "", folded: Sequence[bool] = ()
) -> str:
    """A table with a group of radio buttons in its first column, so that the arrow keys move from row to row.

    Rows that are folded are in a second table, which is closed unless there are no others.
    """
    cells = [' class="number"' * (any(column) and all(map(is_number, column))) for column in list(zip(*table.rows))[1:]]
    head = "".join(f'<th scope="col"{number}>{typeset(text)}</th>' for number, text in zip(cells, table.columns[1:]))
    lines = []
    for i, (row, own) in enumerate(zip(table.rows, data)):
        button = f'<input type="radio" name="{group}" value="{i}" autocomplete="off"{" checked" * (i == first)}>'
        others = "".join(f"<td{number}>{typeset(cell)}</td>" for number, cell in zip(cells, row[1:]))
        name = f"<td><label>{button}<span>{typeset(row[0])}</span></label></td>"
        lines.append(f'<tr {own}{" class=selected" * (i == first)}><td class="number">{i + 1}</td>{name}{others}</tr>')
    head = f'<thead><tr><th scope="col" class="number">no.</th><th scope="col">{typeset(table.columns[0])}</th>{head}</tr></thead>'
    shown, hidden = ([line for line, away in zip_longest(lines, folded) if bool(away) is own] for own in (False, True))
    texts = [f"<table>\n{head}\n<tbody>\n{chr(10).join(own)}\n</tbody>\n</table>" if own else "" for own in (shown, hidden)]
    if hidden:
        names = ", ".join(dict.fromkeys(row[0].split(" (")[0] for row, away in zip(table.rows, folded) if away))
        summary = f"{counted(len(hidden), 'zero eigenvalue')}: {typeset(shortened(names, LONGEST_LABEL))}"
        texts[1] = f"<details{'' if shown else ' open'}><summary>{summary}</summary>\n{texts[1]}</details>"
    return (
        f'<section class="{kind}">\n<h2>{html.escape(table.title)}</h2>\n'
        f'<div class="scroll" role="radiogroup" aria-label="selected {word}">{"".join(texts)}</div>{note}\n</section>'
    )


def _factor(factor: float) -> str:
    """A factor with three digits.

    >>> _factor(135714.3), _factor(5e6)
    ('136000', '5·10⁶')
    """
    return scientific(f"{float(f'{factor:.3g}'):g}")


def _scale_note(drawing: Drawing, mode: ModePicture, moves: bool) -> str:
    """The drawing's note, and the factors by which the mode is magnified."""
    factors = [f"shape drawn × {_factor(mode.scale)}"] if mode.paths else []
    if any(body.moves for body in drawing.bodies):
        factors.append(f"displacements of the shape drawn × {_factor(drawing.scale * mode.scale)}")
    if any(body.turns for body in drawing.bodies):
        factors.append(f"angles × {_factor(drawing.turn_scale * mode.scale)}")
    return "\n".join(filter(None, (drawing.note, "not to scale: " + ", ".join(factors) if moves else "does not move")))


def _slider(label: str, name: str, chosen: str, count: int, first: int, text: str, further: str = "") -> str:
    """A slider through a list, and the name of the entry that is chosen."""
    return (
        f'\n<div class="controls">\n<label for="{name}">{label}</label>\n<input type="range" id="{name}" min="0" max="{count - 1}"'
        f' step="1" value="{first}" autocomplete="off" aria-valuetext="{text}">\n<span id="{chosen}">{text}</span>{further}</div>'
    )


def _frequency_controls(shapes: Deflections, first: tuple[int, int]) -> str:
    """The slider of the frequency, and the choice of the input where there are several."""
    options = "".join(
        f'<option value="{i}"{" selected" if i == first[1] else ""}>{html.escape(text)}</option>'
        for i, text in enumerate(shapes.inputs)
    )
    choice = f'<label>input <select id="input" autocomplete="off">{options}</select></label>' if len(shapes.inputs) > 1 else ""
    frequency = f"{shapes.frequencies[first[0]]:.4g} {shapes.axis}"
    return _slider("frequency", "line", "frequency", len(shapes.frequencies), first[0], frequency, f"\n{choice}")


def _bounding(shapes: Deflections, lines: list[int]):
    """Key frames of some shapes, at peaks and between them."""
    count = len(shapes.frequencies)
    some = [*lines[:MOST_BOUNDS], *np.linspace(0, count - 1, min(MOST_BOUNDS, count)).astype(int).tolist()]
    chosen = [(i, line) for i in range(len(shapes.inputs)) for line in dict.fromkeys(some)]
    return [ModePicture("", values=cycle(shapes.shapes[place])).frames(shapes.drawing, shapes.names) for place in chosen]


def _details(number: int, mode: ModePicture, labels: Sequence[str], shown: bool) -> str:
    """Note, further facts, shares and shape of a mode; visible where it is selected."""
    facts = ", ".join(f"{label}: {text}" for label, text in mode.facts if label in labels and text)
    blocks = [f'<p class="note">{typeset(text)}</p>' for text in (mode.note, facts) if text]
    if mode.shares:  # a bar for each share, without empty columns
        names, kinetic, strain = zip(*mode.shares)
        columns = {"kinetic energy": kinetic, "strain energy": strain}
        columns = {title: column for title, column in columns.items() if any(share is not None for share in column)}
        bars = ["".join(map(_bar, row)) for row in zip(*columns.values())] or [""] * len(names)
        blocks.append(_small_table(["element", *columns], list(zip(names, bars))))
    if mode.shape:
        entries = [(name, f"<td>{typeset(entry)}</td>") for name, entry in mode.shape[:MOST_ENTRIES]]
        blocks.append(_small_table(["coordinate", "shape"], entries))
        if len(mode.shape) > MOST_ENTRIES:
            blocks.append(f'<p class="note">and {len(mode.shape) - MOST_ENTRIES} more with smaller amplitudes</p>')
    title = f'<section id="mode-{number + 1}"{"" if shown else " hidden"}>\n<h2>{typeset(mode.name)}</h2>'
    return f"{title}{''.join(blocks)}\n</section>"


def _small_table(titles: list[str], rows: list[tuple[str, str]]) -> str:
    """Rows of a name and cells."""
    head = "".join(f'<th scope="col">{title}</th>' for title in titles)
    body = "\n".join(f'<tr><th scope="row">{typeset(name)}</th>{cells}</tr>' for name, cells in rows)
    return f'<table class="shares">\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table>'


def _bar(share: float | None) -> str:
    """A bar with its percentage, such as "12.3 %"; a small share is not 0."""
    if share is None:
        return "<td></td>"
    share = share if abs(share) > SMALLEST_SHARE else 0.0
    percent = f"{100 * share:.1f}".removesuffix(".0").replace("-", "−") if abs(share) < 1e6 else f"{100 * share:.3g}"
    if 0 < abs(share) < 0.0005:
        percent = "< 0.1" if share > 0 else "> −0.1"
    kind = "bar negative" if share < 0 else "bar"
    bar = f'<span class="{kind}" style="--share: {min(1.0, abs(share)):.3f}"></span>' if share else ""
    return f'<td><span class="share"><span class="percent">{html.escape(percent)} %</span>{bar}</span></td>'


#: Location of the 3-D viewer: in the page, in a file shared by many pages, or in the page and compressed with all scripts.
Delivery = Literal["inside", "separate", "compressed"]

#: The viewer in a file of its own, next to the pages that share it.
VIEWER_FILE = "mbconstrained-viewer.js"

_ASSETS = Path(__file__).with_name("assets")
_ANIMATION = "motion shapes solids links names marks stage record frames gif player keys print".split()
_PLOTS = "readings axes plots".split()


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
        script, (sections, data) = "modes", mode_sections(content, shown, functions)
    elif isinstance(shown, Deflections):
        script, (sections, data) = "frequency", deflection_sections(content, shown, functions)
    else:
        script, (sections, data) = "run", _run_sections(content, shown, functions)
    if functions.needed:
        blocks["plot-data"], names = functions.as_data(), list(_PLOTS)
    if data:
        blocks["motion-data"] = data
        names += [*_ANIMATION, *(name for name in ("overlay", "posing", "switching", "rotors") if name in data["figure"]), script]
    return sections, data, ["theme", "numbers", *names] if names else [], blocks


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
        text, slow = _magnification(animation, frames), animation.overlay.slow if animation.overlay.events else None
        stage = stage_section(figure, start, end, text, ("time in seconds", "s"), speeds, usual, slow=slow)
    frequencies, plots = table_section(content.frequencies, "frequencies") if content.frequencies else "", content.plots
    if stage and (frequencies or plots):  # the motion next to the first plot
        first, plots = plot_figures(plots[:1], functions, with_help=len(plots) == 1), plots[1:]
        frequencies, stage = "", f'<div class="overview">\n{stage}\n<div class="aside">\n{first}\n{frequencies}\n</div>\n</div>'
    return [
        frequencies,
        stage,
        plot_figures(plots, functions),
        formula_section(content.formulas) if content.formulas else "",
        *map(table_section, content.tables),
    ], data


#: Words for the colours of links by their engagement.
ENGAGEMENTS = ("grey: without force", "yellow: slipping", "orange: closed, stuck or taut")


def _magnification(animation: Animation, frames: KeyFrames) -> str:
    """The drawing's note, the magnification of the motion and the scale of the arrows."""
    drawing = animation.drawing
    texts = []
    if any(body.path and body.path.moves for body in drawing.bodies) and drawing.scale != 1:
        texts.append(f"motion drawn {_factor(drawing.scale)} × as large")
    elif any(body.moves for body in drawing.bodies) and drawing.scale != 1:
        texts.append(f"displacements drawn {_factor(drawing.scale)} × as large")
    if any(body.turns for body in drawing.bodies) and drawing.turn_scale != 1:
        texts.append(f"angles drawn {_factor(drawing.turn_scale)} × as large")
    if animation.overlay.forces:
        texts.append(f"arrows: {animation.overlay.description}, {force_scale(animation.overlay.forces)}")
    if any(body.traced for body in drawing.bodies):
        texts.append("orange: orbits" + " over the last revolution" * (drawing.revolution is not None))
    levels = {level for link in drawing.links for _, level in link.states}
    texts += [", ".join(ENGAGEMENTS[level] for level in sorted(levels, reverse=True))] if levels else []
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
        unpack = _script("unpack")
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
    """A script without indentation and the lines of its comments, which are a sixth of it; no text of a script is longer than a line."""
    return re.sub(r"^ *(//.*\n)?", "", _asset(f"{name}.js"), flags=re.MULTILINE)


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
