"""Tables of texts, and how public objects show themselves: one line at the prompt, tables in a notebook."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass

from .errors import InputError
from .notices import Notice

#: More rows of a table are not shown in a notebook.
MOST_ROWS = 50


@dataclass(frozen=True)
class TextTable:
    """A titled table of texts for the terminal, the page and notebooks.

    Attributes:
        title: heading.
        columns, rows: headings, and the texts below them.
        note: a sentence below, or an empty string.
        folded: on the page only the title is shown until it is clicked.

    Raises:
        InputError: a row whose length is not the number of columns.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
    folded: bool = False

    def __post_init__(self):
        object.__setattr__(self, "columns", tuple(map(str, self.columns)))
        object.__setattr__(self, "rows", tuple(tuple(map(str, row)) for row in self.rows))
        for number, row in enumerate(self.rows, start=1):
            if len(row) != len(self.columns):
                raise InputError(
                    f'table "{self.title}": row {number} has {len(row)} entries for {len(self.columns)} columns; give one each'
                )


class Displayed:
    """A public object that prints as ``Name(summary)`` and shows its tables in a notebook.

    A subclass defines ``_summary`` and, for notebooks, ``_tables``; a dataclass needs ``repr=False``.
    """

    def _summary(self) -> str:
        """The text between the parentheses: sizes and counts, no arrays."""
        return ""

    def _tables(self) -> Sequence[TextTable]:
        """What a notebook shows below the summary."""
        return ()

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._summary()})"

    def _repr_html_(self) -> str:
        return f"<p>{html.escape(repr(self))}</p>" + "".join(map(table_html, self._tables()))


def notice_table(notices: Sequence[Notice]) -> TextTable:
    """Notices by kind and text."""
    return TextTable("Notices", ("kind", "text"), tuple((notice.kind, notice.text) for notice in notices))


def number_text(value: float) -> str:
    """A number to six digits.

    >>> number_text(-0.0), number_text(1 / 3)
    ('0', '0.333333')
    """
    return f"{value + 0.0:.6g}"


def with_unit(value: float, unit: str) -> str:
    """A number with its unit; the unit 1 is not printed.

    Args:
        value: the number.
        unit: as text.

    Returns:
        Both as text.

    >>> with_unit(0.5, "m/s"), with_unit(0.5, "1"), with_unit(0.5, "1/s"), with_unit(0.5, "1 s")
    ('0.5 m/s', '0.5', '0.5 1/s', '0.5 s')
    """
    return f"{number_text(value)} {'' if unit == '1' else unit.removeprefix('1 ')}".rstrip()


def table_text(table: TextTable) -> str:
    """The table as text, columns set flush left with two spaces between them; without rows its title and note.

    >>> print(table_text(TextTable("Jumps", ("of", "size"), (("cart", "1 m"),))))
    Jumps
      of    size
      cart  1 m
    """
    if not table.rows:
        return f"{table.title}\n  {table.note}"
    lines = [table.columns, *table.rows]
    widths = [max(len(line[i]) for line in lines) for i in range(len(table.columns))]
    text = ["  " + "  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip() for line in lines]
    return "\n".join([table.title, *text, *([f"  {table.note}"] if table.note else [])])


def table_html(table: TextTable) -> str:
    """The table as HTML, its texts escaped, its first rows if there are many; without rows an empty text.

    >>> table_html(TextTable("Jumps", ("of",), (("x < y",),)))
    '<table><caption>Jumps</caption><tr><th>of</th></tr><tr><td>x &lt; y</td></tr></table>'
    """
    if not table.rows:
        return ""
    rows = [("th", table.columns), *(("td", row) for row in table.rows[:MOST_ROWS])]
    lines = ("<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in row) + "</tr>" for tag, row in rows)
    more = f"The first {MOST_ROWS} of {len(table.rows)} rows." if len(table.rows) > MOST_ROWS else ""
    note = "".join(f"<p>{html.escape(text)}</p>" for text in (table.note, more) if text)
    return f"<table><caption>{html.escape(table.title)}</caption>{''.join(lines)}</table>{note}"
