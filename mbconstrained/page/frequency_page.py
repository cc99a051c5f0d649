"""The page of a frequency response: its plots, and the animated operating deflection shape at the frequency of the cursor."""

from __future__ import annotations

import html
from dataclasses import dataclass

import numpy as np

from ..ground.display import TextTable, is_number
from ..ground.notices import Notice
from .animation.figure import figure_data
from .animation.keyframes import packed
from .content import Plot
from .drawing.bodies import Drawing
from .mode_page import CYCLE, SPEEDS, ModePicture, cycle
from .plots.svg_plot import PlotFunctions, plot_figures
from .sections import stage_section, table_section
from .typeset import typeset

#: Frequencies of the shapes from which the picture takes its bounds.
MOST_BOUNDS = 24

#: Digits after the decimal point of the part of the cycle on the clock.
DECIMALS = 2


@dataclass(frozen=True, eq=False)
class Deflections:
    """Operating deflection shapes: the steady motion Re(u e^{i w t}) under a unit of one input at a time.

    Attributes:
        drawing: bodies that move with the coordinates, at rest.
        names: names of the n coordinates.
        inputs: texts of m inputs with a unit of each, such as "1 N on cart".
        frequencies: frequencies of F lines, ascending, in the unit of the axis of the plots.
        periods: periods of a cycle at each line, s.
        shapes: complex, shape (m, F, n), as large as the drawing allows.
        factors: by which each is magnified, besides the drawing, shape (m, F).
    """

    drawing: Drawing
    names: tuple[str, ...]
    inputs: tuple[str, ...]
    frequencies: np.ndarray
    periods: np.ndarray
    shapes: np.ndarray
    factors: np.ndarray

    def nearest(self, frequency: float) -> int:
        """The index of the line nearest to a frequency in the unit of the axis."""
        return int(np.abs(np.log(self.frequencies / frequency)).argmin())


@dataclass(frozen=True, eq=False)
class FrequencyContent:
    """The content of a page of a frequency response.

    Attributes:
        title, source: heading of the page and the line under it.
        deflections: shapes with their drawing; None where there is nothing to draw.
        plots: over the frequency.
        peaks: a table with one row for each peak.
        peak_frequencies: of its rows, in the unit of the axis of the plots.
        peak_inputs: numbers of the inputs of its rows.
        axis: the unit of the frequencies.
        tables, notices, facts: as on the page of a run.
    """

    title: str
    source: str
    deflections: Deflections | None
    plots: tuple[Plot, ...]
    peaks: TextTable
    peak_frequencies: tuple[float, ...]
    peak_inputs: tuple[int, ...]
    axis: str = "Hz"
    tables: tuple[TextTable, ...] = ()
    notices: tuple[Notice, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()


def frequency_sections(content: FrequencyContent, functions: PlotFunctions) -> tuple[list[str], dict]:
    """The sections of the page, and the data of its animation; none where nothing is drawn."""
    plots, tables = plot_figures(content.plots, functions), [table_section(table) for table in content.tables]
    shapes = content.deflections
    if shapes is None or not shapes.shapes.any():
        return [plots, table_section(content.peaks), *tables], {}
    lines = [shapes.nearest(frequency) for frequency in content.peak_frequencies]
    first = (lines[0], content.peak_inputs[0]) if lines else (len(shapes.frequencies) // 2, 0)
    figure = figure_data(shapes.drawing, _bounding(shapes, lines))
    stage = stage_section(
        figure,
        0.0,
        1.0,
        "",
        ("part of the cycle", "cycle"),
        SPEEDS,
        1.0,
        loop=False,
        further=_frequency_controls(shapes, content.axis, first),
    )
    data = {
        "figure": figure,
        "names": list(shapes.names),
        "note": shapes.drawing.note,
        "inputs": list(shapes.inputs),
        "axis": content.axis,
        "lines": packed(shapes.frequencies, "<f8"),
        "periods": packed(shapes.periods, "<f8"),
        "real": [packed(block) for block in shapes.shapes.real],
        "imaginary": [packed(block) for block in shapes.shapes.imag],
        "factors": [packed(row) for row in shapes.factors * shapes.drawing.scale],
        "moves": any(body.moves for body in shapes.drawing.bodies),
        "first": {"line": first[0], "input": first[1]},
        "cycle": CYCLE,
        "decimals": DECIMALS,
        "unit": "cycle",
    }
    together = f'<div class="response">\n<div class="deflection">\n{stage}\n</div>\n<div class="beneath">\n{plots}\n</div>\n</div>'
    return [together, _peak_list(content, lines), *tables], data


def _bounding(shapes: Deflections, lines: list[int]):
    """Key frames of some shapes, at peaks and between them."""
    count = len(shapes.frequencies)
    some = [*lines[:MOST_BOUNDS], *np.linspace(0, count - 1, min(MOST_BOUNDS, count)).astype(int).tolist()]
    chosen = [(i, line) for i in range(len(shapes.inputs)) for line in dict.fromkeys(some)]
    return [ModePicture("", values=cycle(shapes.shapes[place])).frames(shapes.drawing, shapes.names) for place in chosen]


def _frequency_controls(shapes: Deflections, axis: str, first: tuple[int, int]) -> str:
    """The slider of the frequency, and the choice of the input where there are several."""
    count, frequency = len(shapes.frequencies), shapes.frequencies[first[0]]
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


def _peak_list(content: FrequencyContent, lines: list[int]) -> str:
    """List of peaks with a group of radio buttons: the arrow keys move from peak to peak."""
    table = content.peaks
    columns = list(zip(*table.rows)) or [()] * len(table.columns)
    kinds = [' class="number"' if column and all(map(is_number, column)) else "" for column in columns]
    head = "".join(f'<th scope="col"{kind}>{typeset(text)}</th>' for kind, text in zip(kinds[1:], table.columns[1:]))
    rows = []
    for i, (row, line, source) in enumerate(zip(table.rows, lines, content.peak_inputs)):
        checked, chosen = (" checked", " class=selected") if i == 0 else ("", "")
        button = f'<input type="radio" name="peak" value="{i}" autocomplete="off"{checked}>'
        cells = "".join(f"<td{kind}>{typeset(cell)}</td>" for kind, cell in zip(kinds[1:], row[1:]))
        name = f'<td class="number">{i + 1}</td><td><label>{button}<span>{typeset(row[0])}</span></label></td>'
        rows.append(f'<tr data-line="{line}" data-input="{source}"{chosen}>{name}{cells}</tr>')
    note = f'<p class="note">{typeset(table.note)}</p>' if table.note else ""
    if not rows:
        return f'<section class="peaks">\n<h2>{html.escape(table.title)}</h2>\n{note}\n</section>'
    return (
        f'<section class="modes peaks">\n<h2>{html.escape(table.title)}</h2>\n'
        '<div class="scroll" role="radiogroup" aria-label="selected peak"><table>\n'
        f'<thead><tr><th scope="col" class="number">no.</th><th scope="col">{typeset(table.columns[0])}</th>{head}</tr></thead>\n'
        f"<tbody>\n{chr(10).join(rows)}\n</tbody>\n</table></div>\n{note}\n</section>"
    )
