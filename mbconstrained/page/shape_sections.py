"""The sections of a page of swinging shapes: mode shapes in a list, or the deflection shape at the frequency of the cursor of its plots."""

from __future__ import annotations

import html
from collections.abc import Sequence

import numpy as np

from ..ground.display import is_number
from .animation.figure import figure_data
from .animation.keyframes import packed
from .animation.shapes import MODE, Deflections, ModePicture, Shapes, cycle
from .content import PageContent
from .drawing.bodies import Drawing
from .plots.svg_plot import PlotFunctions, plot_figures
from .sections import figure_section, stage_section, table_section
from .typeset import typeset

#: Duration of one cycle at speed 1, s, and digits after the decimal point of the phase on the clock.
CYCLE, DECIMALS = 2.0, 2

#: Entries of a shape on the page; the command prints all as JSON.
MOST_ENTRIES = 30

#: Smaller energy shares are rounding errors, and shown as 0.
SMALLEST_SHARE = 1e-9

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
    first = moves.index(True) if any(moves) else 0
    notes = [_scale_note(shapes.drawing, *each) for each in zip(modes, moves)]
    figure = figure_data(shapes.drawing, cycles)
    picture = stage_section(
        figure, 0.0, float(any(moves)), notes[first], _TIME, SPEEDS, 1.0, loop=False, further=_slider(shapes, first)
    )
    if any(mode.shares or mode.shape or mode.note for mode in modes):
        # without scripts the details of all modes are visible
        visible = "<noscript><style>.details section[hidden] { display: block; }</style></noscript>"
        details = "\n".join(_details(i, mode, i == first) for i, mode in enumerate(modes))
        picture = f'<div class="picture">\n{picture}\n<div class="details">{visible}\n{details}\n</div>\n</div>'
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
    facts = [dict(mode.facts) for mode in modes]
    labels = list(dict.fromkeys(label for own in facts for label in own))
    rows = [(mode.name, *(own.get(label, "") for label in labels)) for mode, own in zip(modes, facts)]
    listed = _list(
        "modes",
        f"{shapes.word.capitalize()}s",
        shapes.word,
        "mode",
        [shapes.word, *labels],
        rows,
        [f'data-mode="{i}"' for i in range(len(modes))],
        first,
    )
    plots = plot_figures(content.plots, functions) if content.plots else ""
    return [picture, listed, *map(figure_section, content.figures), plots, *map(table_section, content.tables)], data


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
        listed = _list("modes peaks", peaks.title, "peak", "peak", peaks.columns, peaks.rows, data_of_rows, 0, f"\n{note}")
    return [together, listed, *map(table_section, tables)], data


def _list(
    kind: str,
    title: str,
    word: str,
    group: str,
    columns: Sequence[str],
    rows: Sequence[Sequence[str]],
    data: Sequence[str],
    first: int,
    note: str = "",
) -> str:
    """A table with a group of radio buttons in its first column, so that the arrow keys move from row to row."""
    cells = [' class="number"' * (any(column) and all(map(is_number, column))) for column in list(zip(*rows))[1:]]
    head = "".join(f'<th scope="col"{number}>{typeset(text)}</th>' for number, text in zip(cells, columns[1:]))
    lines = []
    for i, (row, own) in enumerate(zip(rows, data)):
        button = f'<input type="radio" name="{group}" value="{i}" autocomplete="off"{" checked" * (i == first)}>'
        others = "".join(f"<td{number}>{typeset(cell)}</td>" for number, cell in zip(cells, row[1:]))
        name = f"<td><label>{button}<span>{typeset(row[0])}</span></label></td>"
        lines.append(f'<tr {own}{" class=selected" * (i == first)}><td class="number">{i + 1}</td>{name}{others}</tr>')
    return (
        f'<section class="{kind}">\n<h2>{html.escape(title)}</h2>\n'
        f'<div class="scroll" role="radiogroup" aria-label="selected {word}"><table>\n'
        f'<thead><tr><th scope="col" class="number">no.</th><th scope="col">{typeset(columns[0])}</th>{head}</tr></thead>\n'
        f"<tbody>\n{chr(10).join(lines)}\n</tbody>\n</table></div>{note}\n</section>"
    )


def _scale_note(drawing: Drawing, mode: ModePicture, moves: bool) -> str:
    """The drawing's note, and the factors by which the mode is magnified."""
    factors = [f"shape drawn × {mode.scale:g}"] if mode.paths else []
    if any(body.moves for body in drawing.bodies):
        factors.append(f"displacements of the shape drawn × {drawing.scale * mode.scale:g}")
    if any(body.turns for body in drawing.bodies):
        factors.append(f"angles × {drawing.turn_scale * mode.scale:g}")
    return "\n".join(filter(None, (drawing.note, "not to scale: " + ", ".join(factors) if moves else "does not move")))


def _slider(shapes: Shapes, first: int) -> str:
    """Slider through the list, for a list of other things than modes."""
    if shapes.word == MODE or len(shapes.modes) < 2:
        return ""
    text = html.escape(shapes.modes[first].name)
    return (
        f'\n<div class="controls">\n<label for="choice">{shapes.word}</label>\n<input type="range" id="choice" min="0"'
        f' max="{len(shapes.modes) - 1}" step="1" value="{first}" autocomplete="off" aria-valuetext="{text}">\n'
        f'<span id="chosen">{text}</span></div>'
    )


def _frequency_controls(shapes: Deflections, first: tuple[int, int]) -> str:
    """The slider of the frequency, and the choice of the input where there are several."""
    count, frequency, axis = len(shapes.frequencies), shapes.frequencies[first[0]], shapes.axis
    options = "".join(
        f'<option value="{i}"{" selected" if i == first[1] else ""}>{html.escape(text)}</option>'
        for i, text in enumerate(shapes.inputs)
    )
    choice = f'<label>input <select id="input" autocomplete="off">{options}</select></label>' if len(shapes.inputs) > 1 else ""
    return (
        f'\n<div class="controls">\n<label for="line">frequency</label>\n<input type="range" id="line" min="0" max="{count - 1}" step="1"'
        f' value="{first[0]}" autocomplete="off" aria-valuetext="{frequency:.4g} {axis}">\n'
        f'<span id="frequency">{frequency:.4g} {axis}</span>\n{choice}</div>'
    )


def _bounding(shapes: Deflections, lines: list[int]):
    """Key frames of some shapes, at peaks and between them."""
    count = len(shapes.frequencies)
    some = [*lines[:MOST_BOUNDS], *np.linspace(0, count - 1, min(MOST_BOUNDS, count)).astype(int).tolist()]
    chosen = [(i, line) for i in range(len(shapes.inputs)) for line in dict.fromkeys(some)]
    return [ModePicture("", values=cycle(shapes.shapes[place])).frames(shapes.drawing, shapes.names) for place in chosen]


def _details(number: int, mode: ModePicture, shown: bool) -> str:
    """Note, shares and shape of a mode; visible where it is selected."""
    blocks = [f'<p class="note">{typeset(mode.note)}</p>'] if mode.note else []
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
    bar = f'<span class="{kind}" style="width: {100 * min(1.0, abs(share)):.1f}%"></span>' if share else ""
    return f'<td>{bar}<span class="percent">{html.escape(percent)} %</span></td>'
