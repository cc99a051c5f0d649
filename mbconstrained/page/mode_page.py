"""The page of mode shapes: a list of modes, of which the selected one is animated, with its shape and energy shares."""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..ground.display import TextTable, is_number
from ..ground.notices import Notice
from .animation.animation import Animation
from .animation.figure import figure_data
from .animation.keyframes import KeyFrames, key_frames
from .content import Figure
from .drawing.bodies import Drawing
from .drawing.paths import Path
from .sections import figure_section, stage_section, table_section
from .typeset import typeset

#: Times of one cycle, both ends included: the error of cubic interpolation is less than 2e-6 of the amplitude.
PHASES = 49

#: Duration of one cycle at speed 1, s.
CYCLE = 2.0

#: Entries of a shape on the page; the command prints all as JSON.
MOST_ENTRIES = 30

#: Smaller energy shares are rounding errors, and shown as 0.
SMALLEST_SHARE = 1e-9

#: Digits after the decimal point of the phase on the clock.
_DECIMALS = 2

#: Factors of the speed menu of pages with cycles.
SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0)

#: The usual word for what is listed.
MODE = "mode"

Share = tuple[str, float | None, float | None]


@dataclass(frozen=True, eq=False)
class ModePicture:
    """Picture of one mode.

    Attributes:
        name: name, such as "mode 3".
        facts: pairs of a label and a text, such as ("frequency (Hz)", "1.52"); the labels of all modes are the columns of
            the page's table.
        shares: for each element its name, its share of the kinetic and of the strain energy; None where it has none.
        values: the coordinates over one cycle at F equally spaced phases, shape (r, F), the last as the first; None for a
            mode in which no coordinate moves.
        paths: by body name the poses over the same cycle (or one pose), of bodies that move on paths.
        period: period of one cycle in s; None where it does not oscillate.
        scale: magnification of the values, in addition to that of the drawing; paths are already magnified.
        note: a sentence, such as the reason why a mode does not move.
        shape: for each coordinate that moves its name and its amplitude, with its phase where it has one; texts.
    """

    name: str
    facts: tuple[tuple[str, str], ...] = ()
    shares: tuple[Share, ...] = ()
    values: np.ndarray | None = None
    paths: Mapping[str, Path] = field(default_factory=dict)
    period: float | None = None
    scale: float = 1.0
    note: str = ""
    shape: tuple[tuple[str, str], ...] = ()

    def frames(self, drawing: Drawing, names: tuple[str, ...]) -> KeyFrames:
        """One cycle of the mode as key frames."""
        bodies = tuple(replace(body, path=self.paths.get(body.name, body.path)) for body in drawing.bodies)
        values = np.zeros((len(names), 1)) if self.values is None else self.scale * self.values
        count = max([values.shape[1], *(body.path.count for body in bodies if body.path)])
        if values.shape[1] == 1:
            values = values + np.zeros((1, count))
        if not ((values != values[:, :1]).any() or any(body.path and body.path.moves for body in bodies)):
            values, count = values[:, :1], 1
            bodies = tuple(replace(body, path=body.path and body.path.thinned([0])) for body in bodies)
        return key_frames(Animation(replace(drawing, bodies=bodies), names, np.linspace(0.0, 1.0, count), values))


@dataclass(frozen=True, eq=False)
class ModesContent:
    """The content of a page of mode shapes.

    Attributes:
        title, source: heading of the page and the line under it.
        drawing: bodies and links; a body without a path in a mode moves on its own path or with the coordinates.
        names: r coordinate names.
        modes: in the order in which they are listed.
        notices, facts: as on the page of a run.
        figures: before the tables, both below the list.
        tables: tables of the page.
        word: the kind of the entries, "mode"; others, such as "variant", have a slider too.
    """

    title: str
    source: str
    drawing: Drawing
    names: tuple[str, ...]
    modes: tuple[ModePicture, ...] = ()
    notices: tuple[Notice, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()
    tables: tuple[TextTable, ...] = ()
    figures: tuple[Figure, ...] = ()
    word: str = MODE


def cycle(shape, phases: int = PHASES) -> np.ndarray:
    """A shape over one cycle: Re(u e^{2 pi i s}) at equally spaced s from 0 to 1.

    >>> cycle([1.0, 1j], 5).round(12) + 0.0
    array([[ 1.,  0., -1.,  0.,  1.],
           [ 0., -1.,  0.,  1.,  0.]])
    """
    turns = np.exp(2j * np.pi * np.arange(phases) / (phases - 1))
    turns[-1] = turns[0]
    return np.outer(np.asarray(shape), turns).real


def mode_sections(content: ModesContent) -> tuple[list[str], dict]:
    """The sections of the page, and the data of its animation; none without modes."""
    modes = content.modes
    cycles = [mode.frames(content.drawing, content.names) for mode in modes]
    if not cycles:
        return ['<section><p class="note">no modes</p></section>'], {}
    moves = [len(frames.times) > 1 for frames in cycles]
    first = moves.index(True) if any(moves) else 0
    notes = [_scale_note(content.drawing, *each) for each in zip(modes, moves)]
    figure = figure_data(content.drawing, cycles)
    time, slider = ("part of the cycle", "cycle"), _slider(content, first)
    picture = stage_section(figure, 0.0, float(any(moves)), notes[first], time, SPEEDS, 1.0, loop=False, further=slider)
    if any(mode.shares or mode.shape or mode.note for mode in modes):
        # without scripts the details of all modes are visible
        visible = "<noscript><style>.details section[hidden] { display: block; }</style></noscript>"
        details = "\n".join(_details(i, mode, i == first) for i, mode in enumerate(modes))
        picture = f'<div class="picture">\n{picture}\n<div class="details">{visible}\n{details}\n</div>\n</div>'
    data = {
        "figure": figure,
        "names": list(content.names),
        "modes": [
            {"name": mode.name, "period": mode.period, "note": note, "frames": frames.as_packed()}
            for mode, note, frames in zip(modes, notes, cycles)
        ],
        "first": first,
        "cycle": CYCLE,
        "decimals": _DECIMALS,
        "unit": "cycle",
    }
    return [picture, _list(content, first), *map(figure_section, content.figures), *map(table_section, content.tables)], data


def _scale_note(drawing: Drawing, mode: ModePicture, moves: bool) -> str:
    """The drawing's note, and the factors by which the mode is magnified."""
    factors = [f"shape drawn × {mode.scale:g}"] if mode.paths else []
    if any(body.moves for body in drawing.bodies):
        factors.append(f"displacements of the shape drawn × {drawing.scale * mode.scale:g}")
    if any(body.turns for body in drawing.bodies):
        factors.append(f"angles × {drawing.turn_scale * mode.scale:g}")
    return "\n".join(filter(None, (drawing.note, "not to scale: " + ", ".join(factors) if moves else "does not move")))


def _slider(content: ModesContent, first: int) -> str:
    """Slider through the list, for a list of other things than modes."""
    if content.word == MODE or len(content.modes) < 2:
        return ""
    text = html.escape(content.modes[first].name)
    return (
        f'\n<div class="controls">\n<label for="choice">{content.word}</label>\n<input type="range" id="choice" min="0"'
        f' max="{len(content.modes) - 1}" step="1" value="{first}" autocomplete="off" aria-valuetext="{text}">\n'
        f'<span id="chosen">{text}</span></div>'
    )


def _list(content: ModesContent, first: int) -> str:
    """List of modes with a group of radio buttons, so that the arrow keys move from mode to mode."""
    modes, word = content.modes, content.word
    facts = [dict(mode.facts) for mode in modes]
    labels = dict.fromkeys(label for own in facts for label in own)
    columns = {label: [own.get(label, "") for own in facts] for label in labels}
    kinds = {label: ' class="number"' * (any(cells) and all(map(is_number, cells))) for label, cells in columns.items()}
    head = "".join(f'<th scope="col"{kinds[label]}>{typeset(label)}</th>' for label in labels)
    rows = []
    for i, mode in enumerate(modes):
        button = f'<input type="radio" name="mode" value="{i}" autocomplete="off"{" checked" * (i == first)}>'
        cells = "".join(f"<td{kind}>{typeset(columns[label][i])}</td>" for label, kind in kinds.items())
        name = f"<td><label>{button}<span>{typeset(mode.name)}</span></label></td>"
        rows.append(f'<tr data-mode="{i}"{" class=selected" * (i == first)}><td class="number">{i + 1}</td>{name}{cells}</tr>')
    return (
        f'<section class="modes">\n<h2>{word.capitalize()}s</h2>\n'
        f'<div class="scroll" role="radiogroup" aria-label="selected {word}"><table>\n'
        f'<thead><tr><th scope="col" class="number">no.</th><th scope="col">{word}</th>{head}</tr></thead>\n'
        f"<tbody>\n{chr(10).join(rows)}\n</tbody>\n</table></div>\n</section>"
    )


def _details(number: int, mode: ModePicture, shown: bool) -> str:
    """Note, shares and shape of a mode; visible where it is selected."""
    blocks = [f'<p class="note">{typeset(mode.note)}</p>'] if mode.note else []
    if mode.shares:  # a bar for each share, without empty columns
        titles = {1: "kinetic energy", 2: "strain energy"}
        columns = [column for column in titles if any(row[column] is not None for row in mode.shares)]
        bars = [(row[0], "".join(_bar(row[column]) for column in columns)) for row in mode.shares]
        blocks.append(_small_table(["element", *(titles[column] for column in columns)], bars))
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
