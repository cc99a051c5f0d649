"""Tables of texts, and the display of public objects: one line at the prompt, tables in a notebook."""

from __future__ import annotations

import html
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from itertools import zip_longest
from pathlib import Path
from textwrap import TextWrapper

from .by_name import Public
from .errors import InputError
from .notices import Notice

#: More rows of a table are not shown in a notebook.
MOST_ROWS = 50

#: Letters on a line of a terminal.
WIDTH = 80


@dataclass(frozen=True)
class TextTable:
    """A titled table of texts for the terminal, the page and notebooks."""

    title: str  # heading
    # headings, and the texts below them
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""  # a sentence below, or an empty string
    folded: bool = False  # on the page only the title is shown until it is clicked
    times: tuple[float, ...] = ()  # times of the rows, s, which rows on the page lead to; empty for none

    def __post_init__(self):
        object.__setattr__(self, "columns", tuple(map(str, self.columns)))
        object.__setattr__(self, "rows", tuple(tuple(map(str, row)) for row in self.rows))
        for number, row in enumerate(self.rows, start=1):
            if len(row) != len(self.columns):
                raise InputError(
                    f'table "{self.title}": row {number} has {len(row)} entries for {len(self.columns)} columns; give one each'
                )


class Displayed(Public):
    """A public object that prints as ``Name(summary)`` and shows its tables in a notebook.

    A subclass defines ``_summary`` and, for notebooks, ``_tables``; a dataclass needs ``repr=False``.
    """

    def _summary(self) -> str:
        """The text between the parentheses: sizes and counts, no arrays."""
        return ""

    def _tables(self) -> Sequence[TextTable]:
        """Tables that a notebook shows below the summary."""
        return ()

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._summary()})"

    def _repr_html_(self) -> str:
        return f"<p>{html.escape(repr(self))}</p>" + "".join(map(table_html, self._tables()))


class Pictured(Displayed):
    """A public object that a notebook shows with its plots, which are made by a room above this one."""

    def _repr_html_(self) -> str:
        shown = import_module(f"{__package__.partition('.')[0]}.analyses.python_models")
        return super()._repr_html_() + shown.pictures(self)


class Presented(Displayed):
    """A public object with a static page.

    Pages are made by a room above this one, which is looked up by its name when a page is requested.
    """

    @staticmethod
    def _presentation():
        return import_module(f"{__package__.partition('.')[0]}.analyses.python_models")

    def write_page(self, path, **options) -> Path:
        """Write the static HTML page with animation, plots and tables.

        Args:
            path: path of the page.
            options: ``title``, and ``drawing``, entries of the table [drawing] of a scene file such as {"view": "top", "scale": 10,
                "full_meshes": True}; of a motion also ``end``, the last time in s (by default some periods of the slowest oscillation, of
                a switched motion its end), ``points``, the number of times, ``plots``, kinds of curves: "displacement", "velocity",
                "acceleration", "reaction", "energy", "phase", and ``slow_events``, whether the animation is slower around events.

        Returns:
            The path.

        Raises:
            InputError: an unknown kind of curve, an end that is no positive number, wrong entries of the drawing.
        """
        return self._presentation().write_page(self, path, **options)

    def view(self, height: int = 700, **options):
        """The page in a frame, for notebooks.

        Args:
            height: height of the frame, in pixels.
            options: as in ``write_page``.

        Returns:
            An object that a notebook shows as the page.
        """
        return self._presentation().view(self, height, **options)


def notice_table(notices: Sequence[Notice]) -> TextTable:
    """Notices by kind and text."""
    return TextTable("Notices", ("kind", "text"), tuple((notice.kind, notice.text) for notice in notices))


def phase_labels(names: Iterable[str]) -> dict[str, str]:
    """Short labels of phases by name, without the parts that all have in common.

    >>> phase_labels(["stop 1 open, stop 2 open, belt stuck", "stop 1 closed, stop 2 open, belt stuck"])
    {'stop 1 open, stop 2 open, belt stuck': 'open', 'stop 1 closed, stop 2 open, belt stuck': 'closed'}
    >>> list(phase_labels(["gear backward open, gear forward open", "gear backward open, gear forward closed"]).values())
    ['open', 'closed']
    >>> list(phase_labels(["a open, b shut", "a shut, b open"]).values())
    ['a open, b shut', 'a shut, b open']
    """
    names = list(dict.fromkeys(names))
    rows = [name.split(", ") for name in names]
    if len(names) < 2 or len({len(row) for row in rows}) > 1:
        return {name: name for name in names}
    changing = [column for column in zip(*rows) if len(set(column)) > 1]
    words = [[part.split(" ") for part in column] for column in changing]
    every = [part for column in words for part in column]
    common = next((k for k, own in enumerate(zip(*every)) if len(set(own)) > 1), min(map(len, every)) - 1)
    return {name: ", ".join(" ".join(column[i][common:]) for column in words) for i, name in enumerate(names)}


def number_text(value: float) -> str:
    """A number to six digits.

    >>> number_text(-0.0), number_text(1 / 3)
    ('0', '0.333333')
    """
    return f"{value + 0.0:.6g}"


def signed(value, number: str, name: str, follows: bool) -> str:
    """A term of a sum as text: the sign of its value, after other terms with spaces, its size, left out where empty, and its name.

    >>> signed(2.0, "2", "x", False) + signed(-1.0, "", "y", True)
    '2 x - y'
    """
    sign = (" - " if value < 0 else " + ") if follows else "-" * (value < 0)
    return sign + " ".join(filter(None, (number, name)))


def finite_or_none(value: float) -> float | None:
    """The number, or None where it is infinite or NaN, for formats without infinity such as JSON.

    >>> finite_or_none(2.5), finite_or_none(float("nan"))
    (2.5, None)
    """
    return float(value) if math.isfinite(value) else None


#: The prefix u of a unit, which is printed as µ; files and scenes have u, a letter of every keyboard and encoding.
MICRO = re.compile(r"\bu(?=(m|s|g|N|rad|Pa|V|A|J|W)\b)")


def with_unit(value: float, unit: str) -> str:
    """A number with its unit as it is printed: no unit 1, no *, micro as µ.

    >>> with_unit(0.5, "m/s"), with_unit(0.5, "1"), with_unit(0.5, "1/s"), with_unit(0.5, "1 s"), with_unit(2, "kg*um")
    ('0.5 m/s', '0.5', '0.5 1/s', '0.5 s', '2 kg µm')
    """
    return f"{number_text(value)} {'' if unit == '1' else MICRO.sub('µ', unit.removeprefix('1 ').replace('*', ' '))}".rstrip()


def table_text(table: TextTable, width: int = WIDTH) -> str:
    """The table as text, columns set flush left with two spaces between them; without rows its title and note.

    Where the columns are wider than a line, sentences are wrapped between words, names and numbers never; a row that is too
    wide even so is set as a list, one entry a line.

    >>> print(table_text(TextTable("Jumps", ("of", "size", "reason"), (("cart", "1 m", "the start violates a row"),)), width=30))
    Jumps
      of    size  reason
      cart  1 m   the start
                  violates a row
    """
    note = [*_wrapped(table.note, width, "  ")] if table.note else []
    if not table.rows:
        return "\n".join([*_wrapped(table.title, width), *note])
    rows, text = [table.columns, *table.rows], []
    widths = _widths(list(zip(*rows)), width)
    for row in rows if widths else ():
        cells = [[cell] if len(cell) <= size else _wrapped(cell, size) for cell, size in zip(row, widths)]
        for line in zip_longest(*cells, fillvalue=""):
            text.append("  " + "  ".join(part.ljust(size) for part, size in zip(line, widths)).rstrip())
    return "\n".join([*_wrapped(table.title, width), *(text or _entries(table, width)), *note])


def wrapped(text: str, width: int = WIDTH) -> str:
    """A text of one or more lines, wrapped between words; what follows in a wrapped line is indented.

    >>> print(wrapped("Notices\\n  the force at 3 s is zero", 16))
    Notices
      the force at
        3 s is zero
    """
    lines = ((line, line[: len(line) - len(line.lstrip())] + "  ") for line in text.split("\n"))
    return "\n".join(part for line, indent in lines for part in _wrapped(line, width, further=indent))


def is_number(cell: str) -> bool:
    """Whether a text starts like a number, or is a dash or nothing."""
    return re.match(r"(≥ )?[-+−]?(± ?)?\d|[-–—]?$", cell) is not None


#: Blanks at which no line ends: in a number, and between it and its unit.
_KEPT = re.compile(r"(?<=\d) (?=[^\s\d])|(?<=±) (?=\d)")


def _wrapped(text: str, width: int, first: str = "", further: str | None = None) -> list[str]:
    together = _KEPT.sub("\N{NO-BREAK SPACE}", text)
    wrapper = TextWrapper(width, first, first if further is None else further, break_long_words=False, break_on_hyphens=False)
    lines = wrapper.wrap(together) or [""]
    return [line.replace("\N{NO-BREAK SPACE}", " ") for line in lines]


def _widths(columns: Sequence[Sequence[str]], width: int) -> list[int]:
    """The widths at which the columns fit on a line, the widest made narrower in turn; none where that is impossible."""
    unbroken = lambda cell: max(map(len, _KEPT.sub("_", cell).split()), default=0)  # noqa: E731  # its longest part that is not wrapped
    least = [max(map(unbroken, column)) for column in columns]
    widths = [max(map(len, column)) for column in columns]
    excess = sum(widths) + 2 * len(widths) - width
    while excess > 0:
        loose = [i for i, (now, low) in enumerate(zip(widths, least)) if now > low]
        if not loose:
            return []
        widest = max(loose, key=lambda i: widths[i])
        second = max((widths[i] for i in loose if widths[i] < widths[widest]), default=0)
        step = min(excess, widths[widest] - max(least[widest], second - 1))
        widths[widest] -= step
        excess -= step
    return widths


def _entries(table: TextTable, width: int) -> Iterator[str]:
    """Each row as a list of its entries with their headings."""
    for row in table.rows:
        for number, (column, cell) in enumerate(zip(table.columns, row)):
            if cell:
                yield from _wrapped(f"{column}: {cell}", width, "    " if number else "  ", "      ")


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
