"""What a page shows: an animation, plots, tables, notices and facts. The only input of ``page_html``."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..checks import counted, names_of, real_array, whole_number
from ..errors import InputError
from ..notices import Notice
from .drawing import Drawing
from .still import checked_svg

#: Numbers beyond this cannot be drawn: the arithmetic of axes and of interpolation would overflow.
LARGEST = 1e290


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

    Raises:
        InputError: shapes that do not match, NaN, infinity or numbers beyond 1e290, times that do not ascend.
    """

    drawing: Drawing
    names: tuple[str, ...]
    times: np.ndarray
    values: np.ndarray
    rates: np.ndarray | None = None

    def __post_init__(self):
        times = _times(self.times, "animation, times")
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


@dataclass(frozen=True)
class Curve:
    """One line of a plot.

    Attributes:
        name: for the legend.
        values: shape (T,), at the plot's times.
        color: number of its colour and dashes; for a coordinate its place among the animation's names, so that the curve
            has the colour of the body that it moves. None for the place in the plot.
    """

    name: str
    values: np.ndarray
    color: int | None = None


@dataclass(frozen=True)
class Plot:
    """Curves over time.

    Attributes:
        title: what is plotted, such as "displacement".
        unit: its unit, such as "m"; an empty string for a pure number.
        times: shape (T,), ascending, in s.
        curves: their values have the shape of the times.

    Raises:
        InputError: shapes that do not match, NaN, infinity or numbers beyond 1e290, times that do not ascend.
    """

    title: str
    unit: str
    times: np.ndarray
    curves: tuple[Curve, ...]

    def __post_init__(self):
        times = _times(self.times, f'plot "{self.title}", times')
        curves = tuple(self._checked(curve, place, times.shape) for place, curve in enumerate(self.curves))
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "curves", curves)

    def _checked(self, curve: Curve, place: int, shape: tuple[int, ...]) -> Curve:
        where = f'plot "{self.title}", curve "{curve.name}"'
        color = place if curve.color is None else whole_number(curve.color, f"{where}, color", minimum=0)
        return replace(curve, name=str(curve.name), values=drawable(curve.values, where, shape), color=color)


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
    plots: tuple[Plot, ...] = ()
    tables: tuple[Table, ...] = ()
    notices: tuple[Notice, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()
    formulas: Formulas | None = None
    figures: tuple[Figure, ...] = ()


def drawable(value, what: str, shape: tuple[int | None, ...]) -> np.ndarray:
    """An array of finite numbers small enough that differences of them are finite too."""
    array = real_array(value, what, shape=shape)
    if np.abs(array).max(initial=0.0) > LARGEST:
        raise InputError(f"{what}: found {np.abs(array).max():.3g}, which is too large to draw; ask for earlier times")
    return array


def _times(value, what: str) -> np.ndarray:
    times = drawable(value, what, (None,))
    if len(times) == 0:
        raise InputError(f"{what}: no times found; give at least one")
    if (np.diff(times) <= 0).any():
        place = int(np.argmax(np.diff(times) <= 0))
        raise InputError(f"{what}: {times[place]:g} s is followed by {times[place + 1]:g} s; times must ascend")
    return times
