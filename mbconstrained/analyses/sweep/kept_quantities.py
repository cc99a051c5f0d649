"""Kept quantities of each sample: frequencies, response peaks, RMS values, values and extremes of motions, curves.

A text selects one, such as "frequencies", "largest velocity of cart" or "cart at 2 s"; the middle sample determines names, units
and sizes.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...ground.checks import nearest
from ...ground.errors import InputError
from ...ground.quantities import quantity
from ...ground.units import impulse_unit
from ...scene.run.result import ORDERS, Result
from ..frequency import Frequency
from ..random import random_response

if TYPE_CHECKING:
    from ...mechanics.switched.switched_motion import SwitchEvent
    from ...scene.coordinates import OutputUnits
    from ...scene.run.scene import Scene

#: Natural frequencies that are kept, lowest first.
MOST_MODES = 20

#: Coordinates whose largest values are kept where nothing else is said; of models with more the first ones.
MOST_COORDINATES = 8

#: Statistics of a motion over the times of the scene.
STATISTICS = ("largest", "maximum", "minimum", "RMS", "curve", "peak")

#: Possible kept quantities, for messages.
FORMS = (
    '"frequencies", "response peaks", "response curves", "random RMS", or of a motion "largest x", "maximum x", "minimum x", "RMS x", '
    '"curve x", "x at 2 s", with x a coordinate, "velocity of x", "b - a", "force of spring", "reaction of row" …; largest, maximum and minimum '
    'are those of the closed form, none between the times is missed, and RMS its integral; of a model that switches "number of events", '
    '"time of event 3", "time of event last", "largest impulse of x"'
)

#: Beginnings of the names of figures, by the text that selects all of them.
WHOLE = {
    "frequencies": ("frequency ", "damping ratio "), "response peaks": ("response peak",), "random RMS": ("random RMS ",)
}  # fmt: skip

#: Figures of the events of models that switch.
NUMBER_OF_EVENTS, EVENT_TIME, LARGEST_IMPULSE = (
    "number of events",
    re.compile(r"time of event (\d+|last)"),
    re.compile(r"largest impulse of (.+)"),
)


@dataclass(frozen=True)
class Variable:
    """An array over the samples."""

    name: str  # in the store
    unit: str  # in SI; "1" for a plain number; several joined by "or"
    axis: str = ""  # the name of its second axis; an empty string for one number per sample
    labels: tuple = ()  # along that axis, texts or numbers
    source: str = (
        "motion"  # analysis that computes it: "modes", "response peaks", "response curves", "random RMS", "events" or "motion"
    )
    statistic: str = ""  # of a motion, or "at"
    curve: tuple[str, int] = ("", 0)  # kind of the curve and its row, of a motion
    time: float = 0.0  # of a value, in s
    units: tuple[str, ...] = ()  # in SI, along the axis where they differ

    @property
    def shape(self) -> tuple[int, ...]:
        return (len(self.labels),) if self.axis else ()

    @property
    def is_curve(self) -> bool:
        """Whether the values of one sample are a function of time or frequency."""
        return self.statistic == "curve"

    def figures(self) -> list[tuple[str, tuple[int, ...]]]:
        """Names of the scalar quantities of a sample with their positions; none for curves."""
        if self.is_curve:
            return []
        if not self.axis:
            return [(self.name, ())]
        numbered = len(self.labels) > 1 or self.axis == "mode"
        return [(f"{self.name} {label}" if numbered else self.name, (i,)) for i, label in enumerate(self.labels)]


@dataclass(frozen=True)
class SampleFigure:
    """A scalar quantity of each sample."""

    name: str  # such as "frequency 1"
    unit: str  # in SI
    variable: Variable  # the variable that contains it
    place: tuple[int, ...]  # in the variable

    def shown(self, units: OutputUnits) -> tuple[str, float]:
        """The unit in which it is shown, with the factor of its values."""
        is_ratio = self.variable.source in ("response peaks", "response curves") and self.unit != "Hz"
        return units.of_ratio(self.unit) if is_ratio else units.of(self.unit, self.name)

    def of(self, arrays: Mapping[str, np.ndarray]) -> np.ndarray:
        """Values from arrays of variables over samples, shape (S,)."""
        values = arrays[self.variable.name]
        return values[:, self.place[0]] if self.place else values


def figures_of(variables: Sequence[Variable]) -> dict[str, SampleFigure]:
    """The scalar quantities of a sample, by name."""
    pairs = ((name, one, place) for one in variables for name, place in one.figures())
    return {name: SampleFigure(name, one.units[place[0]] if one.units else one.unit, one, place) for name, one, place in pairs}


def limits_of(limits: Mapping[str, Any], figures: Mapping[str, SampleFigure]) -> dict[str, float]:
    """Limits in SI."""
    result = {}
    for name, limit in limits.items():
        try:
            result[name] = float(quantity(limit, figures[name].unit or "1"))
        except InputError as problem:
            raise InputError(f'limits: "{name}": {problem}') from None
    return result


def figure_of(name: str, known: Mapping[str, SampleFigure], scene: Scene) -> SampleFigure:
    """The scalar quantity of this name: one that is known, or any other that can be kept."""
    figures = known
    if name not in figures:
        try:
            figures = figures_of(variables_of([name], scene))
        except InputError as problem:
            if "[frequency]" in str(problem):
                raise
            there = ", ".join(list(known)[:20])
            raise InputError(
                f'there is no figure "{name}"{nearest(name, known)}; there are {there}, or all that can be kept, as "largest x", "x at 2 s" …'
            ) from None
    if name not in figures and len(figures) != 1:
        raise InputError(f'"{name}" is several numbers; name one of {", ".join(list(figures or known)[:20])}')
    return figures.get(name) or next(iter(figures.values()))


def variables_of(keep: Sequence[str] | None, scene: Scene) -> tuple[Variable, ...]:
    """The variables selected by texts."""
    texts = _usual(scene) if keep is None else keep
    if not texts:
        raise InputError(f"keep: nothing is kept of the samples; expected some of {FORMS}")
    result: dict[str, Variable] = {}
    curves = _Curves(scene)
    for text in texts:
        for variable in _of_text(text.strip(), scene, curves):
            result[variable.name] = variable
    return tuple(result.values())


def _usual(scene: Scene) -> list[str]:
    table, output = scene.table, scene.table.output
    texts = ["frequencies"] if _modes(scene) else []
    texts += ["response peaks"] if table.frequency else []
    texts += ["random RMS"] if table.random else []
    if not table.time.is_given:
        return texts
    kind = next((kind for kind in output.plots if kind in (*ORDERS, "output")), "displacement")
    names = _Curves(scene).names[kind]
    if kind in ORDERS and output.coordinates:
        names = tuple(name for name in names if name in output.coordinates)
    of = {"displacement": "", "output": ""}.get(kind, f"{kind} of ")
    return [*texts, *(f"largest {of}{name}" for name in names[:MOST_COORDINATES])]


def _of_text(text: str, scene: Scene, curves: _Curves) -> Iterator[Variable]:
    if text in ("frequencies", "modes", "damping ratios"):
        modes = _modes(scene)
        if not modes:
            raise InputError(f"keep: found {text}, but nothing oscillates; leave it out")
        yield Variable("frequency", "Hz", "mode", modes, "modes")
        yield Variable("damping ratio", "1", "mode", modes, "modes")
    elif text in ("response peaks", "response curves"):
        if scene.table.frequency is None:
            raise InputError(f"keep: found {text}, but the scene has no table [frequency]; write one with from and to")
        yield from _responses(text, Frequency(scene))
    elif text == "random RMS":
        response = random_response(scene)
        unit, units = _common(response.units)
        yield Variable("random RMS", unit, "output", response.outputs, "random RMS", units=units)
    elif text == NUMBER_OF_EVENTS or EVENT_TIME.fullmatch(text) or LARGEST_IMPULSE.fullmatch(text):
        yield _of_events(text, scene, curves)
    elif (whole := next((one for one in WHOLE if text.startswith(WHOLE[one])), None)) is not None:
        variables = list(_of_text(whole, scene, curves))
        figures = figures_of(variables)
        if text not in figures:
            raise InputError(f'keep: there is no "{text}"{nearest(text, figures)}; there are {", ".join(list(figures)[:20])}')
        yield figures[text].variable
    else:
        yield _of_motion(text, scene, curves)


def _responses(text: str, frequency: Frequency) -> Iterator[Variable]:
    empty = frequency.empty
    pairs = tuple(f"{output} by {name}" for output in empty.outputs for name in empty.inputs)
    unit, units = _common([unit for row in empty.units for unit in row])
    if text == "response peaks":
        yield Variable("response peak", unit, "response", pairs, text, units=units)
        yield Variable("response peak frequency", "Hz", "response", pairs, text)
        return
    lines = response_lines(frequency)
    for pair, own in zip(pairs, units or [unit] * len(pairs)):
        yield Variable(f"response of {pair}", own, "frequency (Hz)", tuple(lines.tolist()), text, "curve")


def response_lines(frequency: Frequency) -> np.ndarray:
    """The frequencies in Hz at which the responses of all samples are kept, shape (F,)."""
    table = frequency.table
    if not table.is_auto:
        return table.lines
    if table.lowest is None or table.highest is None:
        raise InputError("keep: response curves of different samples need common frequencies; give from and to in [frequency]")
    return np.geomspace(table.lowest, table.highest, 401) if table.lowest else np.linspace(0.0, table.highest, 401)


def _of_events(text: str, scene: Scene, curves: _Curves) -> Variable:
    """A figure of the events of a model that switches."""
    if scene.equations.switching is None:
        raise InputError(f"keep: found {text}, but the model has no contacts, friction or other switches; leave it out")
    if not (impulse := LARGEST_IMPULSE.fullmatch(text)):
        return Variable(text, "1" if text == NUMBER_OF_EVENTS else "s", source="events")
    units = dict(curves.result.motion._force_units)
    if impulse[1] not in units:
        raise InputError(f'keep: "{text}": there is no contact or constraint row "{impulse[1]}"{nearest(impulse[1], units)}')
    return Variable(text, impulse_unit(units[impulse[1]]), source="events")


def event_figure(variable: Variable, events: Sequence[SwitchEvent]) -> float:
    """A figure of the events of one sample; NaN where it has fewer events."""
    if variable.name == NUMBER_OF_EVENTS:
        return float(len(events))
    if impulse := LARGEST_IMPULSE.fullmatch(variable.name):
        return max((abs(event.impulses.get(impulse[1], 0.0)) for event in events), default=0.0)
    number = EVENT_TIME.fullmatch(variable.name)[1]
    times = [event.time for event in events]
    if number == "last":
        return times[-1] if times else np.nan
    return times[int(number) - 1] if 0 < int(number) <= len(times) else np.nan


def _of_motion(text: str, scene: Scene, curves: _Curves) -> Variable:
    statistic, _, rest = text.partition(" ")
    timed = re.fullmatch(r"(.*) at (.+)", text)
    if statistic in STATISTICS and rest:
        (kind, row), unit = curves.place(rest.strip(), text)
        axis, labels = ("time (s)", tuple(curves.result.times.tolist())) if statistic == "curve" else ("", ())
        return Variable(text, unit, axis, labels, statistic=statistic, curve=(kind, row))
    if timed:
        place, unit = curves.place(timed[1].strip(), text)
        try:
            time = float(quantity(float(timed[2]) if timed[2].replace(".", "", 1).isdigit() else timed[2], "s"))
        except InputError as problem:
            raise InputError(f'keep: "{text}": {problem}') from None
        if not 0 <= time:
            raise InputError(f'keep: found "{text}"; expected a time from 0 on')
        return Variable(text, unit, statistic="at", curve=place, time=time)
    raise InputError(f'keep: found "{text}"{nearest(text, curves.texts)}; expected some of {FORMS}')


class _Curves:
    """The curves of a scene by name."""

    def __init__(self, scene: Scene):
        self.result = Result(scene)
        equations = scene.equations
        self.names = dict.fromkeys(ORDERS, equations.coordinates.names)
        if equations.has_reactions:
            self.names["reaction"] = tuple(row.name for row in self.result.rows)
        if scene.table.output.quantity:
            self.names["quantity"] = self.result.curves("quantity").names
        if equations.outputs is not None and not equations.has_outputs_among_coordinates:
            self.names["output"] = equations.outputs.names

    @property
    def texts(self) -> list[str]:
        """Valid continuations of "largest", for hints."""
        return [f"largest {name}" for names in self.names.values() for name in names]

    def place(self, name: str, text: str) -> tuple[tuple[str, int], str]:
        """Kind, row and unit of a curve."""
        kind, of, own = name.partition(" of ")
        kinds = (
            [kind] if of and kind in self.names else [kind for kind in self.names if kind in ("displacement", "quantity", "output")]
        )
        own = own if of and kind in self.names else name
        for kind in kinds:
            if own in self.names[kind]:
                row = self.names[kind].index(own)
                return (kind, row), self.result.curves(kind).units[row]
        with suppress(InputError):
            return (name, 0), self.result.output_names.output(name).unit
        known = [each for kind in kinds for each in self.names[kind]]
        raise InputError(f'keep: "{text}": there is no curve "{own}"{nearest(own, known)}; there are {", ".join(known[:12])}')


def _modes(scene: Scene) -> tuple[int, ...]:
    """Numbers of the kept modes."""
    values = eigenvalues_of(scene)
    return tuple(range(1, min(int((values.imag > 0).sum()), MOST_MODES) + 1))


def eigenvalues_of(scene: Scene) -> np.ndarray:
    """The finite eigenvalues in 1/s, one of each pair or all."""
    system = scene.equations.system
    if system is not None:
        return np.atleast_1d(system.modes().eigenvalues)
    zeros = scene.equations.polynomial_matrix.jordan_pairs().finite.zeros
    return np.array([zero.value for zero in zeros for _ in range(zero.multiplicity)], dtype=complex)


def _common(units: Sequence[str]) -> tuple[str, tuple[str, ...]]:
    """The common unit, or all units in one text, and each where they differ."""
    distinct = dict.fromkeys(units)
    return " or ".join(distinct) or "1", tuple(units) if len(distinct) > 1 else ()
