"""The parts of the page that need no script: heading, notices, plots, tables, facts. All texts are escaped."""

from __future__ import annotations

import html
import re

from ..notices import Notice
from .content import Figure, Formulas, PageContent, Table
from .mode_content import ModesContent
from .plot_content import PhasePlot, Plot
from .plots import plot_figure
from .readings import Coordinates
from .typeset import typeset
from .viewer import viewer_licences

#: A cell of more letters than this is a sentence, or a long one.
SENTENCE, LONG_SENTENCE = 24, 40

#: Letters of a name that is read out.
LONGEST_NAME = 100


def header(content: PageContent | ModesContent, *, with_theme: bool = False) -> str:
    """Title and source, and where there are scripts the switch from light to dark."""
    source = f"\n<p>{html.escape(content.source)}</p>" if content.source else ""
    theme = '\n<button type="button" id="theme" aria-pressed="false">Dark</button>' if with_theme else ""
    return f"<header>\n<h1>{html.escape(content.title)}</h1>{source}{theme}\n</header>"


def plot_figures(plots: tuple[Plot | PhasePlot, ...], coordinates: Coordinates | None = None) -> str:
    """All plots, in pairs side by side where the window is wide enough; one without a partner takes the whole width.

    Args:
        coordinates: of the animation on the same page.
    """
    paired = len(plots) - len(plots) % 2
    figures = "\n".join(plot_figure(plot, coordinates, alone=i >= paired) for i, plot in enumerate(plots))
    return f'<div class="plots">\n{figures}\n</div>' if plots else ""


def notice_section(notices: tuple[Notice, ...]) -> str:
    """The notices, doubtful ones first and as warnings."""
    if not notices:
        return ""
    ordered = sorted(notices, key=lambda notice: not notice.doubtful)
    return f'<section class="notices" aria-label="Notes and warnings">{"".join(_notice(notice) for notice in ordered)}</section>'


def _notice(notice: Notice) -> str:
    kind, label = ("notice doubtful", "Warning") if notice.doubtful else ("notice", "Note")
    return f'<p class="{kind}"><b>{label} ({html.escape(notice.kind)}):</b> {typeset(notice.text)}</p>'


def still_figure(figure: Figure) -> str:
    """One <figure> over the whole width; where the window is narrow the picture scrolls, so that it stays readable."""
    spoken = f'<svg role="img" aria-label="{html.escape(figure.description)}"'
    svg = figure.svg.strip().replace("<svg", spoken, 1)
    note = f'\n<p class="note">{typeset(figure.note)}</p>' if figure.note else ""
    return f'<figure class="still">\n<h2>{html.escape(figure.title)}</h2>\n<div class="scroll" {_scrolls(figure.title)}>{svg}</div>{note}\n</figure>'


def formula_section(formulas: Formulas | None) -> str:
    """Formulas, each of them in a box of its own that scrolls where it is too wide."""
    if formulas is None:
        return ""
    lines = "\n".join(f'<div class="formula">{line}</div>' for line in formulas.lines)
    note = f'<p class="note">{typeset(formulas.note)}</p>' if formulas.note else ""
    return f'<section class="formulas">\n<h2>{html.escape(formulas.title)}</h2>\n<div class="all-formulas">{lines}</div>{note}\n</section>'


def table_section(table: Table) -> str:
    """A titled table; columns of numbers are set flush right. A folded one shows its title only."""
    title = f"<h2>{html.escape(table.title)}</h2>"
    if table.folded:
        return f'<section class="folded">\n<details><summary>{title}</summary>\n{_table(table)}\n</details>\n</section>'
    return f"<section>\n{title}\n{_table(table)}\n</section>"


def _table(table: Table) -> str:
    columns = list(zip(*table.rows)) or [()] * len(table.columns)
    kinds = [_kind(column) for column in columns]
    head = "".join(f'<th scope="col"{kind}>{typeset(text)}</th>' for kind, text in zip(kinds, table.columns))
    rows = "".join(
        "<tr>" + "".join(f"<td{kind}>{typeset(cell)}</td>" for kind, cell in zip(kinds, row)) + "</tr>\n" for row in table.rows
    )
    note = f'<p class="note">{typeset(table.note)}</p>' if table.note else ""
    rows = f"<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>"
    return f'<div class="scroll" {_scrolls(table.title)}><table>\n{rows}\n</table></div>{note}'


def _scrolls(name: str) -> str:
    """Attributes of what may be wider than the window, so that the arrow keys can scroll it."""
    return f'tabindex="0" role="group" aria-label="{html.escape(name[:LONGEST_NAME])}"'


def _kind(column: tuple[str, ...]) -> str:
    """Numbers are flush right; sentences have room for some words in each line."""
    if column and all(map(is_number, column)):
        return ' class="number"'
    longest = max(map(len, column), default=0)
    return ' class="long sentence"' if longest > LONG_SENTENCE else ' class="sentence"' if longest > SENTENCE else ""


def is_number(cell: str) -> bool:
    """Whether a text starts like a number, or is a dash or nothing."""
    return re.match(r"[-+−]?(± ?)?\d|[-–—]?$", cell) is not None


def footer(facts: tuple[tuple[str, str], ...], *, with_viewer: bool) -> str:
    """Facts, and the licences of what the page passes on."""
    rows = "".join(f"<dt>{html.escape(label)}</dt><dd>{typeset(text)}</dd>" for label, text in facts)
    facts_list = f"<dl>{rows}</dl>\n" if facts else ""
    return f"<footer>\n{facts_list}{_licences() if with_viewer else ''}</footer>"


def _licences() -> str:
    texts = html.escape(viewer_licences())
    return f'<details><summary>Licences of the 3-D viewer</summary><pre tabindex="0">{texts}</pre></details>\n'
