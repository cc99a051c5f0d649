"""Content of a page: plots with their axes, formulas, tables, notices and facts, and the typography of its texts."""

from __future__ import annotations

import html
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from ..ground.display import MICRO, TextTable, with_unit
from ..ground.errors import InputError
from ..ground.notices import Notice
from .animation import Animation, Deflections, Shapes, ascending_times, drawable

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

#: A unit with a power, but not a name such as "x^2".
_POWER = re.compile(r"(\b(?:kg|m|s|A|K|mol|cd|rad|N|J)|\))\^(-?\d+)\b")


def typeset(text: str) -> str:
    """HTML for a text of the user or of a table, escaped; no line ends within "-0.5 ± 0.25 i".

    >>> typeset("5 N s^2 < 1")
    '5 N s² &lt; 1'
    """
    return html.escape(re.sub(r"(?<=\d) (?=±|i\b)|(?<=±) (?=\d)", "\N{NO-BREAK SPACE}", raised(text)))


def raised(text: str) -> str:
    """Units with raised powers.

    >>> raised("m/s^2"), raised("(m/s)^5")
    ('m/s²', '(m/s)⁵')
    """
    return _POWER.sub(lambda power: power[1] + superscript(int(power[2])), text)


def unit_text(unit: str) -> str:
    """A unit as it is printed.

    >>> unit_text("N*m^2/rad"), unit_text("um/us")
    ('N·m²/rad', 'µm/µs')
    """
    return raised(MICRO.sub("µ", unit)).replace("*", "·")


def superscript(number: int) -> str:
    """A whole number as an exponent.

    >>> superscript(-12)
    '⁻¹²'
    """
    return str(number).translate(_SUPERSCRIPT)


def shortened(text: object, length: int = 40) -> str:
    """A text on one line, without characters that cannot be printed, cut off where it is longer.

    >>> shortened("a\\nb"), shortened("abcdefgh", 5)
    ('a b', 'abcd…')
    """
    text = "".join(letter if letter.isprintable() else " " for letter in str(text)[: 8 * length])
    text = " ".join(text.split())
    return text if len(text) <= length else text[: length - 1].rstrip() + "…"


Scale = Literal["linear", "log", "rows"]

#: A range narrower than this share of its values is rounding error and drawn as a constant.
NOISE_SPAN = 1e-9

#: Most steps between the ends of an axis before it is widened.
MOST_STEPS = 6

#: Values smaller than this count as zero.
SMALLEST = 1e-290

#: Powers of ten within which a tick of a logarithmic axis is labelled as a decimal number.
FIRST_POWER, LAST_POWER = -3, 4

#: Decades of a logarithmic axis up to which each has ticks at 2 and 5, too.
FEW_DECADES = 2

#: With fewer ticks at 1, 2 and 5 times powers of ten a logarithmic axis has them at even steps.
FEWEST_TICKS = 3

#: The largest number of decades of a logarithmic axis: smaller values are at its low end.
MOST_DECADES = 18


@dataclass(frozen=True)
class Axis:
    """A range and its ticks."""

    # the range; every tick lies in it
    low: float
    high: float
    ticks: tuple[float, ...]  # values of the ticks
    labels: tuple[str, ...]  # their texts, in units of 10^exponent
    exponent: int  # a multiple of three, or 0 for labels without a common power of ten
    scale: Scale = "linear"  # "linear", "log" for even steps of the logarithm, or "rows" for whole numbers that stand for names

    def shares(self, values: np.ndarray) -> np.ndarray:
        """Positions on the axis, from 0 at its low end to 1 at its high end; on a logarithmic axis smaller values are at that end.

        >>> axis_of(1.0, 100.0, scale="log").shares(np.array([1.0, 10.0, 0.0]))
        array([0. , 0.5, 0. ])
        """
        return self.fractions(np.maximum(values, self.low) if self.scale == "log" else values)

    def fractions(self, values) -> np.ndarray:
        """Positions of values, those outside the axis below 0 or above 1; positive ones on a logarithmic axis."""
        low, high, values = self.low, self.high, np.asarray(values, dtype=float)
        if self.scale == "log":
            low, high, values = math.log10(low), math.log10(high), np.log10(values)
        return (values - low) / (high - low)


def axis_of(low: float, high: float, *, widen: bool = True, scale: Scale = "linear") -> Axis:
    """An axis with ticks at even steps of 1, 2 or 5 times a power of ten, or at powers of ten.

    >>> axis_of(-0.93, 1.7).labels
    ('−1.0', '−0.5', '0.0', '0.5', '1.0', '1.5', '2.0')
    >>> axis_of(0.0, 50.0, widen=False).labels
    ('0', '10', '20', '30', '40', '50')
    >>> axis_of(0.02, 300.0, scale="log").labels
    ('0.01', '0.1', '1', '10', '100', '1000')
    """
    if scale == "log":
        return _log_axis(low, high, widen)
    if scale == "rows":
        return Axis(low - 0.5, high + 0.5, (), (), 0, scale)
    size = max(abs(low), abs(high))
    if size < SMALLEST:
        low, high = -1.0, 1.0
    elif high - low <= NOISE_SPAN * size:
        low, high = min(0.5 * low, 1.5 * low), max(0.5 * high, 1.5 * high)
    step = _step(high - low)
    ticks = _multiples(low, high, step, widen)
    if widen:
        low, high = ticks[0], ticks[-1]
    largest = math.floor(math.log10(max(abs(low), abs(high))))
    exponent = 0 if -3 <= largest <= 4 else 3 * (largest // 3)
    digits = max(0, exponent - math.floor(math.log10(step) + NOISE_SPAN))
    labels = (f"{tick / 10.0**exponent:z.{digits}f}".replace("-", "−") for tick in ticks)
    return Axis(low, high, ticks, tuple(labels), exponent)


def _step(span: float) -> float:
    """1, 2 or 5 times a power of ten, at most ``MOST_STEPS`` of them in the span."""
    rough = span / MOST_STEPS
    power = 10.0 ** math.floor(math.log10(rough))
    return power * next(factor for factor in (1.0, 2.0, 5.0, 10.0) if rough <= factor * power * (1 + NOISE_SPAN))


def _multiples(low: float, high: float, step: float, widen: bool) -> tuple[float, ...]:
    """The multiples of a step in a range, or with those just outside it."""
    down, up = (math.floor, math.ceil) if widen else (math.ceil, math.floor)
    outwards = NOISE_SPAN if widen else -NOISE_SPAN  # an end within rounding error of a tick is one
    return tuple(k * step for k in range(down(low / step + outwards), up(high / step - outwards) + 1))


def _log_axis(low: float, high: float, widen: bool) -> Axis:
    """Ticks at powers of ten; of few decades at 2 and 5 too, and of a small part of one at even steps."""
    if high < SMALLEST:
        raise InputError(f"a logarithmic axis: found values up to {high:g}; expected positive ones, or give a linear axis")
    low = max(low, SMALLEST, high * 10.0**-MOST_DECADES)
    if high - low <= NOISE_SPAN * high:
        low, high = low / 2, high * 2
    if widen:
        low, high = 10.0 ** math.floor(math.log10(low) + NOISE_SPAN), 10.0 ** math.ceil(math.log10(high) - NOISE_SPAN)
    first, last = math.ceil(math.log10(low) - NOISE_SPAN), math.floor(math.log10(high) + NOISE_SPAN)
    stride = max(1, math.ceil((last - first) / MOST_STEPS))
    factors = (1.0, 2.0, 5.0) if last - first <= FEW_DECADES else (1.0,)
    powers = [k for k in range(first - 1, last + 1) if k % stride == 0]
    every = [factor * 10.0**k for k in powers for factor in factors]
    ticks = tuple(tick for tick in every if low * (1 - NOISE_SPAN) <= tick <= high * (1 + NOISE_SPAN))
    if len(ticks) < FEWEST_TICKS:
        ticks = _multiples(low, high, _step(high - low), widen=False)
    return Axis(low, high, ticks, tuple(map(power_label, ticks)), 0, "log")


def power_label(value: float) -> str:
    """Label of a number on a logarithmic axis.

    >>> power_label(200.0), power_label(2e6)
    ('200', '2·10⁶')
    """
    power = math.floor(math.log10(value) + NOISE_SPAN)
    if FIRST_POWER <= power <= LAST_POWER:
        return f"{value:.12g}"
    factor = value / 10.0**power
    return ("" if abs(factor - 1) < 1e-6 else f"{factor:.6g}·") + f"10{superscript(power)}"


def is_power(value: float) -> bool:
    """Whether a tick of a logarithmic axis is a power of ten.

    >>> is_power(0.001), is_power(200.0)
    (True, False)
    """
    power = math.log10(value)
    return abs(power - round(power)) < NOISE_SPAN


def scientific(text: str) -> str:
    """A text with its number as a factor of a power of ten.

    >>> scientific("1.5e-09 m"), scientific("12 m")
    ('1.5·10⁻⁹ m', '12 m')
    """
    return re.sub(r"(?<=\d)e([-+]\d+)", lambda power: f"·10{superscript(int(power[1]))}", text)


def measured(value: float, unit: str) -> str:
    """A number with its unit as a reader of a plot sees them.

    >>> measured(1.5e-9, "N*m"), measured(0.5, "1")
    ('1.5·10⁻⁹ N·m', '0.5')
    """
    return scientific(with_unit(value, unit_text(unit)))


#: Shares of an axis below this are rounding errors.
LEAST_SHARE = 1e-9

#: Curves shown at first: more in one picture are indistinct.
MOST_SHOWN = 8


@dataclass(frozen=True, eq=False)
class RecordResponse:
    """A linear motion under a force that restarts often."""

    knots: np.ndarray  # times in s at which the force restarts, ascending, shape (K,)
    force: np.ndarray  # its states after each, shape (m, K)
    states: Callable[[np.ndarray], np.ndarray]  # states of the motion, shape (p, T), at ascending times (T,)


@dataclass(frozen=True, eq=False)
class TimeFunctions:
    """Functions of time that curves show."""

    at: Callable[[np.ndarray], np.ndarray]  # their values, shape (r, T), at ascending times (T,)
    breaks: np.ndarray  # times at which one of them or a derivative of it may jump, ascending
    noise: float = 1e-13  # their error, relative to the largest value of any of them
    record: RecordResponse | None = None  # the motion that they belong to, where its force is a record


@dataclass(frozen=True, eq=False)
class Curve:
    """Curve of a plot."""

    name: str  # name for the legend
    values: np.ndarray  # shape (T,), at the plot's times
    # number of its colour and dashes; for a coordinate its number in the animation, so that the curve has the colour of the body
    # that it moves. None for its number in the plot
    color: int | None = None
    # its values at all times, as functions and a row of them; None for straight lines between the values
    function: tuple[TimeFunctions, int] | None = None
    along: np.ndarray | None = None  # its values along the horizontal axis of a phase plane, shape (T,); None for those of the plot
    drawn: np.ndarray | None = None  # where it is drawn, shape (T,); None for everywhere

    @property
    def parts(self) -> list[tuple[int, int]]:
        """First and last index of each part that is drawn.

        >>> Curve("c", np.zeros(5), drawn=np.array([True, True, False, True, True])).parts
        [(0, 1), (3, 4)]
        """
        if self.drawn is None:
            return [(0, len(self.values) - 1)]
        edges = np.flatnonzero(np.diff(np.concatenate([[False], self.drawn, [False]])))
        return [(int(first), int(end) - 1) for first, end in edges.reshape(-1, 2)]


def curve_with_gaps(name: str, values: np.ndarray, color: int | None = None, along: np.ndarray | None = None) -> Curve:
    """A curve that is drawn where its values are numbers, and those along the horizontal axis.

    >>> curve_with_gaps("c", np.array([1.0, np.nan, 3.0])).drawn
    array([ True, False,  True])
    """
    drawn = np.isfinite(values) if along is None else np.isfinite(values) & np.isfinite(along)
    values, along = (row if row is None else np.where(drawn, row, 0.0) for row in (values, along))
    return Curve(name, values, color, along=along, drawn=drawn)


@dataclass(frozen=True)
class Guide:
    """A straight line of the picture, of which the part within the axes is drawn."""

    name: str  # next to the end; an empty string for none
    # two of its points
    start: tuple[float, float]
    end: tuple[float, float]
    kind: Literal["grid", "line", "limit"] = "grid"  # drawn as one of the grid, with a meaning of its own, or as a limit

    def ends(self, across: Axis, up: Axis) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """End points of the line in the picture, as fractions of both axes from the left and from below; None where it is outside.

        >>> axis = axis_of(0.0, 10.0)
        >>> np.round(Guide("twice", (0.0, 0.0), (10.0, 20.0)).ends(axis, axis), 6).tolist()
        [[0.0, 0.0], [0.5, 1.0]]
        """
        first, last = np.array([[axis.fractions(value) for axis, value in zip((across, up), at)] for at in (self.start, self.end)])
        step = last - first
        with np.errstate(divide="ignore", invalid="ignore"):
            hits = np.sort((np.array([[-LEAST_SHARE], [1 + LEAST_SHARE]]) - first) / step, axis=0)
        hits[:, step == 0] = [[-np.inf], [np.inf]]
        low, high = max(0.0, hits[0].max()), min(1.0, hits[1].min())
        constant = first[step == 0]
        if high <= low or (np.abs(constant - 0.5) > 0.5 + LEAST_SHARE).any():
            return None
        (a, b), (c, d) = (np.clip(first + share * step, 0.0, 1.0).tolist() for share in (low, high))
        return (a, b), (c, d)


#: Shapes of marks; "text" for the texts themselves, to the right of their points.
Shape = Literal["circle", "cross", "diamond", "dot", "text"]


@dataclass(frozen=True, eq=False)
class Marks:
    """Marks at points of a plot."""

    name: str  # for the legend; an empty string for none
    points: np.ndarray  # shape (P, 2)
    texts: tuple[str, ...] = ()  # of each point, shown where the pointer rests on it; none by default
    shape: Shape = "circle"  # of the marks
    curve: int | None = None  # number of the curve to which they belong, whose colour they have; None for none


@dataclass(frozen=True, eq=False)
class Cells:
    """A map: cells whose colour shows a value."""

    # edges of the columns and of the rows, ascending, shapes (C + 1,) and (R + 1,)
    across: np.ndarray
    up: np.ndarray
    values: np.ndarray  # shape (R, C); grey where NaN
    texts: Sequence[Sequence[str]]  # of each cell, shown where the pointer rests on it, R rows of C
    unit: str = ""  # of the values, such as "Hz"
    at: tuple[np.ndarray, np.ndarray] | None = None  # where the values are, shapes (C,) and (R,); None for the middles of the cells

    @property
    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """Where the values are along both axes."""
        return self.at or ((self.across[1:] + self.across[:-1]) / 2, (self.up[1:] + self.up[:-1]) / 2)

    @property
    def ends(self) -> tuple[float, float]:
        """The lowest and the highest value; 0 and 1 without any."""
        known = self.values[np.isfinite(self.values)]
        return (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Plot:
    """Curves over time or another variable, or in a phase plane."""

    title: str  # heading, such as "displacement"
    unit: str  # unit of the curves, such as "m"; an empty string or "1" for a pure number
    times: np.ndarray  # shape (T,), ascending, in s; of a plot over another variable its values
    curves: tuple[Curve, ...]  # their values have the shape of the times
    across: Curve | None = None  # of a phase plane, a curve along the horizontal axis, whose name is its title; None for the time
    across_unit: str = "s"  # of the horizontal axis
    quantity: str = ""  # title of the vertical axis; an empty string for that of the plot
    variable: str = "time"  # quantity along the horizontal axis, such as "frequency"; of a phase plane the one along its curves
    # of the horizontal and of the vertical axis; values that are not positive are at the low end of a logarithmic one
    scales: tuple[Scale, Scale] = ("linear", "linear")
    guides: tuple[Guide, ...] = ()  # further lines
    marks: tuple[Marks, ...] = ()  # marks at points
    note: str = ""  # a sentence below
    includes: tuple[float, ...] = ()  # values that the vertical axis reaches in any case
    shown: int = MOST_SHOWN  # number of curves that are shown at first
    bands: tuple[tuple[float, float], ...] = ()  # ranges of the horizontal axis with a background of their own
    is_large: bool = False  # whether the picture is high and as wide as the page
    # in a phase plane, unit of the variable, whose value is shown at the pointer; None for no such text
    variable_unit: str | None = None
    cells: Cells | None = None  # a map behind the curves, which fills the axes
    image: str = ""  # successive plots with the same text here are panels of one image
    # begins of phases along the horizontal axis, ascending, with their names; a coloured band below the axes shows them
    phases: tuple[tuple[float, str], ...] = ()

    def __post_init__(self):
        for axis in ("unit", "across_unit"):
            object.__setattr__(self, axis, "" if getattr(self, axis) == "1" else getattr(self, axis))
        times = ascending_times(self.times, f'plot "{self.title[:60]}", {"times" if self.variable == "time" else self.variable}')
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "curves", tuple(self._checked(curve, i) for i, curve in enumerate(self.curves)))
        object.__setattr__(self, "across", self.across and self._checked(self.across, 0))
        drawn = self._drawn_values() if self.curves and "log" in self.scales else ()
        for name, scale, values in zip(("horizontal", "vertical"), self.scales, drawn):
            if scale == "log" and not (values > 0).any():
                raise InputError(
                    f'plot "{self.title[:60]}": no value along its {name} axis is positive; '
                    "a logarithmic axis needs positive values, give it a linear one"
                )

    def _checked(self, curve: Curve, place: int) -> Curve:
        what = f'plot "{self.title[:60]}", curve "{curve.name}"'
        values, along = (row if row is None else drawable(row, what, self.times.shape) for row in (curve.values, curve.along))
        return replace(curve, values=values, along=along, color=place if curve.color is None else curve.color)

    def along(self, curve: Curve) -> np.ndarray:
        """The values of a curve along the horizontal axis."""
        return curve.along if curve.along is not None else self.across.values if self.across else self.times

    @property
    def phase_ranges(self) -> dict[str, list[tuple[float, float]]]:
        """The ranges of each phase within the drawn ones, by its name.

        >>> row = np.array([0.0, 4.0])
        >>> Plot("gap", "m", row, (Curve("a", row),), phases=((0.0, "open"), (1.0, "closed"), (3.0, "open"))).phase_ranges
        {'open': [(0.0, 1.0), (3.0, 4.0)], 'closed': [(1.0, 3.0)]}
        """
        first, last = float(self.times[0]), float(self.times[-1])
        ranges: dict[str, list[tuple[float, float]]] = {}
        for (begin, name), (end, _) in pairwise((*self.phases, (math.inf, ""))):
            if begin < last and end > first:
                ranges.setdefault(name, []).append((max(begin, first), min(end, last)))
        return ranges

    @property
    def across_name(self) -> str:
        """Title of the horizontal axis."""
        return self.across.name if self.across else self.variable

    def _drawn_values(self) -> tuple[np.ndarray, np.ndarray]:
        """All drawn values along both axes, and the points of all marks."""
        corners = [np.array([self.cells.across[[0, -1]], self.cells.up[[0, -1]]]).T] if self.cells else []
        points = np.concatenate([np.zeros((0, 2)), *corners, *(marks.points for marks in self.marks)])
        pairs = [(self.along(curve), curve.values, curve.drawn) for curve in self.curves]
        rows = [[row if drawn is None else row[drawn] for row in (x, y)] for x, y, drawn in pairs]
        xs, ys = zip(*rows) if self.across and rows else ([self.times], [y for _, y in rows])
        return np.concatenate([*xs, points[:, 0]]), np.concatenate([*ys, points[:, 1], np.array(self.includes)])

    @property
    def axes(self) -> tuple[Axis, Axis]:
        """The horizontal and the vertical axis; of a plot with at least one curve."""
        across, up = (_range(values, scale) for values, scale in zip(self._drawn_values(), self.scales))
        axes = (
            axis_of(*across, widen=self.across is not None, scale=self.scales[0]),
            axis_of(*up, widen=self.cells is None, scale=self.scales[1]),
        )
        if self.cells is None:
            return axes
        first, second = (_whole(axis) if (own == own.round()).all() else axis for axis, own in zip(axes, self.cells.places))
        return first, second


def _whole(axis: Axis) -> Axis:
    """An axis of numbers that count: with those of its ticks that are whole, where there are any."""
    kept = tuple(tick for tick in axis.ticks if tick == round(tick))
    return replace(axis, ticks=kept, labels=tuple(f"{tick:g}" for tick in kept)) if kept and not axis.exponent else axis


def _range(values: np.ndarray, scale: Scale) -> tuple[float, float]:
    """The lowest and the highest value; of a logarithmic axis of the positive ones."""
    values = values[values > 0] if scale == "log" else values
    return float(values.min()), float(values.max())


@dataclass(frozen=True)
class Formulas:
    """Formulas in MathML."""

    title: str  # heading
    lines: tuple[str, ...]  # elements <math>, which the page includes as they are
    note: str = ""  # a sentence below, or an empty string


@dataclass(frozen=True)
class PageContent:
    """The content of one page; parts that are None or empty are absent from the file."""

    title: str  # heading of the page
    source: str = ""  # the line under it
    animation: Animation | Shapes | Deflections | None = None  # over time, shapes in a list, or over the frequency of the plots
    plots: tuple[Plot, ...] = ()
    tables: tuple[TextTable, ...] = ()
    notices: tuple[Notice, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()  # pairs of a label and a text for the end of the page, such as ("Coordinates", "3")
    formulas: Formulas | None = None
    frequencies: TextTable | None = None  # a narrow table next to the animation, in a narrow window below it
