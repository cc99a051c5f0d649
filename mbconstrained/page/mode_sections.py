"""The list of modes and, beside the picture, what the one that is picked is made of. All texts are escaped."""

from __future__ import annotations

import html

from .mode_content import ModePicture
from .sections import is_number
from .typeset import typeset

#: More entries of a shape than this are not listed on the page; the command prints all as JSON.
MOST_ENTRIES = 30

#: Shares smaller than this are rounding, and shown as 0.
ROUNDING = 1e-9


def modes_section(modes: tuple[ModePicture, ...], first: int) -> str:
    """One row to a mode, each a radio button of one group, so that arrow keys go from mode to mode."""
    labels = list(dict.fromkeys(label for mode in modes for label, _ in mode.facts))
    facts = [dict(mode.facts) for mode in modes]
    kinds = {label: _column_kind([own.get(label, "") for own in facts]) for label in labels}
    head = "".join(f'<th scope="col"{kinds[label]}>{typeset(label)}</th>' for label in labels)
    rows = "\n".join(_row(i, mode, facts[i], kinds, i == first) for i, mode in enumerate(modes))
    return (
        '<section class="modes">\n<h2>Modes</h2>\n<div class="scroll" role="radiogroup" aria-label="mode that is shown"><table>\n'
        f'<thead><tr><th scope="col" class="number">no.</th><th scope="col">mode</th>{head}</tr></thead>\n'
        f"<tbody>\n{rows}\n</tbody>\n</table></div>\n</section>"
    )


def _column_kind(cells: list[str]) -> str:
    return ' class="number"' if any(cells) and all(map(is_number, cells)) else ""


def _row(number: int, mode: ModePicture, facts: dict[str, str], kinds: dict[str, str], picked: bool) -> str:
    button = f'<input type="radio" name="mode" value="{number}" autocomplete="off"{" checked" * picked}>'
    cells = "".join(f"<td{kind}>{typeset(facts.get(label, ''))}</td>" for label, kind in kinds.items())
    name = f"<td><label>{button}<span>{typeset(mode.name)}</span></label></td>"
    return f'<tr data-mode="{number}"{" class=picked" * picked}><td class="number">{number + 1}</td>{name}{cells}</tr>'


def has_details(modes: tuple[ModePicture, ...]) -> bool:
    """Whether any mode has shares, a shape or a note."""
    return any(mode.shares or mode.shape or mode.note for mode in modes)


def details_section(modes: tuple[ModePicture, ...], first: int) -> str:
    """For each mode its note and shares, all but the first hidden until they are picked; all shown without a script."""
    blocks = "\n".join(_details(i, mode, i == first) for i, mode in enumerate(modes))
    all_shown = "<noscript><style>.details section[hidden] { display: block; }</style></noscript>"
    return f'<div class="details">{all_shown}\n{blocks}\n</div>'


def _details(number: int, mode: ModePicture, shown: bool) -> str:
    note = f'<p class="note">{typeset(mode.note)}</p>' if mode.note else ""
    shares = _shares(mode) if mode.shares else ""
    shape = _shape(mode) if mode.shape else ""
    return (
        f'<section id="mode-{number + 1}"{"" if shown else " hidden"}>\n<h2>{typeset(mode.name)}</h2>{note}{shares}{shape}\n</section>'
    )


def _shares(mode: ModePicture) -> str:
    """A table with a bar for each share; columns without any number are left out."""
    columns = [(1, "kinetic energy"), (2, "strain energy")]
    columns = [(place, title) for place, title in columns if any(row[place] is not None for row in mode.shares)]
    head = "".join(f'<th scope="col">{title}</th>' for _, title in columns)
    rows = "\n".join(
        f'<tr><th scope="row">{typeset(row[0])}</th>{"".join(_bar(row[place]) for place, _ in columns)}</tr>'
        for row in mode.shares
    )
    return (
        f'<table class="shares">\n<thead><tr><th scope="col">part</th>{head}</tr></thead>\n<tbody>\n{rows}\n</tbody>\n</table>'
    )


def _shape(mode: ModePicture) -> str:
    """How far each coordinate moves, and when."""
    more = len(mode.shape) - MOST_ENTRIES
    rows = "\n".join(
        f'<tr><th scope="row">{typeset(name)}</th><td>{typeset(entry)}</td></tr>' for name, entry in mode.shape[:MOST_ENTRIES]
    )
    note = f'<p class="note">and {more} more, which move less</p>' if more > 0 else ""
    head = '<thead><tr><th scope="col">coordinate</th><th scope="col">shape</th></tr></thead>'
    return f'<table class="shares">\n{head}\n<tbody>\n{rows}\n</tbody>\n</table>{note}'


def _bar(share: float | None) -> str:
    if share is None:
        return "<td></td>"
    share = share if abs(share) > ROUNDING else 0.0
    width = 100 * min(1.0, abs(share))
    kind = "bar negative" if share < 0 else "bar"
    bar = f'<span class="{kind}" style="width: {width:.1f}%"></span>' if share else ""
    return f'<td>{bar}<span class="percent">{html.escape(_percent(share))}</span></td>'


def _percent(share: float) -> str:
    """Such as "12.3 %"; what is there but small is no 0.

    >>> [_percent(x) for x in (0.1234, 0.0, 1e-5, -0.02, 1.0)]
    ['12.3 %', '0 %', '< 0.1 %', '−2 %', '100 %']
    """
    if 0 < abs(share) < 0.0005:
        return "< 0.1 %" if share > 0 else "> −0.1 %"
    text = f"{100 * share:.1f}".removesuffix(".0")
    return f"{text.replace('-', '−')} %" if abs(share) < 1e6 else f"{100 * share:.3g} %"
