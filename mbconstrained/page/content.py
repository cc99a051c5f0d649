"""Content of a page: plots, formulas, figures, tables, notices and facts; the animation has a separate folder."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..ground.display import TextTable
from ..ground.errors import InputError
from ..ground.notices import Notice
from .animation.animation import Animation, ascending_times, drawable
from .animation.shapes import Deflections, Shapes
from .plots.axis import Axis, Scale, axis_of

#: Shares of an axis below this are rounding errors.
LEAST_SHARE = 1e-9


@dataclass(frozen=True, eq=False)
class RecordResponse:
    """A linear motion under a force that restarts often.

    Attributes:
        knots: times in s at which the force restarts, ascending, shape (K,).
        force: its states after each, shape (m, K).
        states: states of the motion, shape (p, T), at ascending times (T,).
    """

    knots: np.ndarray
    force: np.ndarray
    states: Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class TimeFunctions:
    """Functions of time that curves show.

    Attributes:
        at: their values, shape (r, T), at ascending times (T,).
        breaks: times at which one of them or a derivative of it may jump, ascending.
        noise: their error, relative to the largest value of any of them.
        record: the motion that they belong to, where its force is a record.
    """

    at: Callable[[np.ndarray], np.ndarray]
    breaks: np.ndarray
    noise: float = 1e-13
    record: RecordResponse | None = None


@dataclass(frozen=True, eq=False)
class Curve:
    """Curve of a plot.

    Attributes:
        name: name for the legend.
        values: shape (T,), at the plot's times.
        color: number of its colour and dashes; for a coordinate its number in the animation, so that the curve has the
            colour of the body that it moves. None for its number in the plot.
        function: its values at all times, as functions and a row of them; None for straight lines between the values.
    """

    name: str
    values: np.ndarray
    color: int | None = None
    function: tuple[TimeFunctions, int] | None = None


@dataclass(frozen=True)
class Guide:
    """A power law level x^exponent, a straight line of the grid on two logarithmic axes.

    Attributes:
        name: next to the line.
        level: at 1 on the horizontal axis.
        exponent: its slope.
    """

    name: str
    level: float
    exponent: float

    def ends(self, across: Axis, up: Axis) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """End points of the line in the picture, as fractions of both axes from the left and from below; None where it is outside.

        Args:
            across, up: logarithmic.

        Returns:
            The left and the right end.
        """
        (left, right), (low, high) = (np.log10((axis.low, axis.high)) for axis in (across, up))
        start = np.log10(self.level)
        at = np.sort(np.append((np.array([low, high]) - start) / self.exponent, [left, right]))[
            1:3
        ]  # where it is within both ranges
        x, y = (at - left) / (right - left), (start + self.exponent * at - low) / (high - low)
        if x[1] <= x[0] or (y < -LEAST_SHARE).any() or (y > 1 + LEAST_SHARE).any():
            return None
        return (float(x[0]), float(y[0])), (float(x[1]), float(y[1]))

    def named_at(self, across: Axis, up: Axis) -> tuple[float, float, bool] | None:
        """Position of its name: at the upper end of a rising line, at the left or lower end of a falling one; none meet.

        Args:
            across, up: logarithmic.

        Returns:
            Shares of the axes, and whether the name is left of that point; None for no name.
        """
        if (ends := self.ends(across, up)) is None:
            return None
        if self.exponent > 0:
            return *ends[1], True
        return (*ends[0], False) if ends[0][0] < LEAST_SHARE else (*ends[1], True) if ends[1][1] < LEAST_SHARE else None


@dataclass(frozen=True, eq=False)
class Plot:
    """Curves over time or another variable, or in a phase plane.

    Attributes:
        title: heading, such as "displacement".
        unit: unit of the curves, such as "m"; an empty string for a pure number.
        times: shape (T,), ascending, in s; of a plot over another variable its values.
        curves: their values have the shape of the times.
        across: of a phase plane, a curve along the horizontal axis, whose name is its title; None for the time.
        across_unit: of the horizontal axis.
        quantity: title of the vertical axis; an empty string for that of the plot.
        variable: quantity along the horizontal axis, such as "frequency".
        scales: of the horizontal and of the vertical axis, "linear" or "log"; values that are not positive are at the low end of a
            logarithmic axis.
        guides: further lines of the grid, on two logarithmic axes.

    Raises:
        InputError: shapes that do not match, NaN, infinity or numbers beyond 1e290, times that do not ascend; no positive value for
            a logarithmic axis.
    """

    title: str
    unit: str
    times: np.ndarray
    curves: tuple[Curve, ...]
    across: Curve | None = None
    across_unit: str = "s"
    quantity: str = ""
    variable: str = "time"
    scales: tuple[Scale, Scale] = ("linear", "linear")
    guides: tuple[Guide, ...] = ()

    def __post_init__(self):
        times = ascending_times(self.times, f'plot "{self.title[:60]}", {"times" if self.variable == "time" else self.variable}')
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "curves", tuple(self._checked(curve, i) for i, curve in enumerate(self.curves)))
        object.__setattr__(self, "across", self.across and self._checked(self.across, 0))
        values = [curve.values for curve in self.curves]
        for name, scale, rows in zip(("horizontal", "vertical"), self.scales, ([self.horizontal.values], values)):
            if scale == "log" and rows and not (np.array(rows) > 0).any():
                raise InputError(
                    f'plot "{self.title[:60]}": no value along its {name} axis is positive; '
                    "a logarithmic axis needs positive values, give it a linear one"
                )

    def _checked(self, curve: Curve, place: int) -> Curve:
        values = drawable(curve.values, f'plot "{self.title[:60]}", curve "{curve.name}"', self.times.shape)
        return replace(curve, values=values, color=place if curve.color is None else curve.color)

    @property
    def horizontal(self) -> Curve:
        """The values along the horizontal axis and their name."""
        return self.across or Curve(self.variable, self.times)

    @property
    def axes(self) -> tuple[Axis, Axis]:
        """The horizontal and the vertical axis; of a plot with at least one curve."""
        across, up = self.horizontal.values, np.array([curve.values for curve in self.curves])
        return (
            axis_of(*_range(across, self.scales[0]), widen=self.across is not None, scale=self.scales[0]),
            axis_of(*_range(up, self.scales[1]), scale=self.scales[1]),
        )


def _range(values: np.ndarray, scale: Scale) -> tuple[float, float]:
    """The lowest and the highest value; of a logarithmic axis of the positive ones."""
    values = values[values > 0] if scale == "log" else values
    return float(values.min()), float(values.max())


@dataclass(frozen=True)
class Formulas:
    """Formulas in MathML.

    Attributes:
        title: heading.
        lines: elements <math>, which the page includes as they are.
        note: a sentence below, or an empty string.
    """

    title: str
    lines: tuple[str, ...]
    note: str = ""


@dataclass(frozen=True)
class Figure:
    """A static figure over the full width.

    Attributes:
        title: heading.
        svg: one element <svg> of shapes and texts, without references to anything outside it; the page includes it as it is.
        description: a text alternative.
        note: a sentence below, or an empty string.
    """

    title: str
    svg: str
    description: str
    note: str = ""


@dataclass(frozen=True)
class PageContent:
    """The content of one page; parts that are None or empty are absent from the file.

    Attributes:
        title, source: heading of the page and the line under it.
        animation: a motion over time, shapes in a list, or shapes over the frequency of the plots.
        frequencies: a narrow table next to the animation, in a narrow window below it.
        facts: pairs of a label and a text for the end of the page, such as ("Coordinates", "3").
        figures: after the notices.
    """

    title: str
    source: str = ""
    animation: Animation | Shapes | Deflections | None = None
    plots: tuple[Plot, ...] = ()
    tables: tuple[TextTable, ...] = ()
    notices: tuple[Notice, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()
    formulas: Formulas | None = None
    figures: tuple[Figure, ...] = ()
    frequencies: TextTable | None = None
