"""What a page shows: an animation, plots, tables, notices and facts. The only input of ``page_html``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..checks import counted, names_of
from ..errors import InputError
from ..notices import Notice
from .drawing import Drawing
from .marks import Marks
from .plot_content import PhasePlot, Plot, ascending_times, drawable
from .still import checked_svg


@dataclass(frozen=True)
class Animation:
    """A drawing and how its coordinates move.

    Attributes:
        drawing: bodies and links.
        names: r coordinate names; those that the drawing does not use are still reported by the page.
        times: shape (T,), ascending, in s.
        values: shape (r, T), in the units of the coordinates.
        rates: their time derivatives, shape (r, T); estimated from the values when None. With them the motion between
            the times is exact to fourth order in their spacing.
        marks: arrows of forces, and jumps and impulses, that are drawn over the model.

    Raises:
        InputError: shapes that do not match, NaN, infinity or numbers beyond 1e290, times that do not ascend.
    """

    drawing: Drawing
    names: tuple[str, ...]
    times: np.ndarray
    values: np.ndarray
    rates: np.ndarray | None = None
    marks: Marks = Marks()

    def __post_init__(self):
        times = ascending_times(self.times, "animation, times")
        values = drawable(self.values, "animation, values", (None, len(times)))
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "names", names_of(self.names, len(values), "animation, names", "x"))
        if self.rates is not None:
            object.__setattr__(self, "rates", drawable(self.rates, "animation, rates", values.shape))
        for body in self.drawing.bodies:
            if body.path is not None and body.path.count not in (1, len(times)):
                poses, expected = counted(body.path.count, "pose"), counted(len(times), "time")
                raise InputError(f'body "{body.name[:60]}", path: found {poses} for {expected}; give one each, or one alone')

    @property
    def with_forces(self) -> tuple[tuple[str, ...], np.ndarray, np.ndarray, np.ndarray | None]:
        """Names, times, values and rates, the forces that arrows show among them as if they were coordinates."""
        forces = self.marks.forces
        names = (*self.names, *(name for force in forces for name in force.names))
        values = np.vstack([self.values, *(force.values for force in forces)])
        rates = None if self.rates is None else np.vstack([self.rates, *(force.rates for force in forces)])
        return names, self.times, values, rates


@dataclass(frozen=True)
class Table:
    """A titled table of texts; a column in which every entry starts like a number is set flush right.

    Attributes:
        title: heading.
        columns, rows: headings, and texts below them.
        note: a sentence below, or an empty string.
        folded: only the title is shown until it is clicked; on paper all of it.

    Raises:
        InputError: a row whose length is not the number of columns.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
    folded: bool = False

    def __post_init__(self):
        object.__setattr__(self, "columns", tuple(str(column) for column in self.columns))
        object.__setattr__(self, "rows", tuple(tuple(str(cell) for cell in row) for row in self.rows))
        for number, row in enumerate(self.rows, start=1):
            if len(row) != len(self.columns):
                raise InputError(
                    f'table "{self.title}": row {number} has {len(row)} entries for {len(self.columns)} columns; give one each'
                )


@dataclass(frozen=True)
class Formulas:
    """Formulas in MathML.

    Attributes:
        title: heading.
        lines: elements <math>, made by this package: they are the only markup that a page takes as it is.
        note: a sentence below, or an empty string.

    Raises:
        InputError: a line that is no element <math>.
    """

    title: str
    lines: tuple[str, ...]
    note: str = ""

    def __post_init__(self):
        for line in self.lines:
            if not (line.startswith("<math") and line.endswith("</math>")) or "<script" in line.lower():
                raise InputError(f"formula: found {line[:60]!r}; expected an element <math>")


@dataclass(frozen=True)
class Figure:
    """A still picture, full width.

    Attributes:
        title: heading.
        svg: one element <svg>, made by this package: shapes and texts, which refer to nothing outside it.
        description: what the picture shows, for those who cannot see it.
        note: a sentence below, or an empty string.

    Raises:
        InputError: anything else in the picture, such as a script, an image or an address.
    """

    title: str
    svg: str
    description: str
    note: str = ""

    def __post_init__(self):
        checked_svg(self.svg, f'figure "{self.title[:60]}"')


@dataclass(frozen=True)
class PageContent:
    """Everything on one page; what is None or empty leaves no trace in the file.

    Attributes:
        title, source: heading of the page and the line under it (where the model is from).
        formulas: in MathML, or None.
        facts: pairs of a label and a text for the end of the page, such as ("Coordinates", "3").
        figures: still pictures, right after the notices.
    """

    title: str
    source: str = ""
    animation: Animation | None = None
    plots: tuple[Plot | PhasePlot, ...] = ()
    tables: tuple[Table, ...] = ()
    notices: tuple[Notice, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()
    formulas: Formulas | None = None
    figures: tuple[Figure, ...] = ()
