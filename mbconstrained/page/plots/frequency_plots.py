"""Plots of a frequency response: amplitude and phase (Bode), real and imaginary part, one over the other (Nyquist)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...frequency.features import frequencies_by_poles
from ...frequency.frequency_response import FrequencyResponse, evaluated
from ...frequency.pole_residue_form import poles_on_axis
from ...ground.tolerances import LINE_ACCURACY
from ..content import Curve, Plot, TimeFunctions
from .axis import Scale

#: Parts of the stored functions in each decade of the frequency: on a logarithmic axis each is as wide.
PARTS_EACH_DECADE = 8

#: Lines closer to a pole on the axis than this share of its frequency do not determine the height of the picture.
NEAR_POLE = 1e-3

#: Height of the picture above those lines, as a factor.
ABOVE = 10.0

#: Below the highest value of a curve in dB.
LOWEST_DECIBEL = 360.0

#: A response whose largest value is below this share of that of another is zero but for rounding errors, and has no curve.
ABSENT = 1e-13

#: More lines in one plot are drawn from every second, third ... of them.
MOST_LINES = 4000


@dataclass(frozen=True)
class ResponseLook:
    """Style of the plots of a response.

    Attributes:
        kinds: a selection of "bode", "parts" and "nyquist".
        amplitude: the vertical axis of amplitudes, "log", "linear" or "dB".
        unwrapped: whether phases go on beyond 180 degrees.
        axis, factor: unit of the horizontal axis, and its value for 1 Hz.
        colors: numbers of the colours of the outputs.
    """

    kinds: tuple[str, ...] = ("bode",)
    amplitude: str = "log"
    unwrapped: bool = True
    axis: str = "Hz"
    factor: float = 1.0
    colors: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class _Entry:
    """One response of a plot: its indices, its name, and its factor of the displayed unit."""

    i: int
    j: int
    name: str
    factor: float


class _Drawn:
    """The functions of all responses of a page, evaluated once for each set of frequencies."""

    def __init__(self, response: FrequencyResponse, look: ResponseLook):
        self.harmonic, self.look = response.harmonic, look
        given = response.frequencies_hz[response.frequencies_hz > 0]
        placed = frequencies_by_poles(self.harmonic)
        inside = placed[(placed > given[0]) & (placed < given[-1])]
        lines = np.union1d(given, inside)
        lines = lines[:: len(lines) // MOST_LINES + 1]
        self.poles = np.array(
            [pole.value.imag / (2 * np.pi) for pole in poles_on_axis(self.harmonic.form.poles) if pole.value.imag]
        )
        self.lines = np.setdiff1d(lines, response.frequencies_hz[[one.line for one in response.poles_on_lines]])
        self.values = evaluated(self.harmonic, self.lines).values
        errors = response.error_estimate[np.isfinite(response.error_estimate)]
        self.is_accurate = bool(errors.max(initial=0.0) <= 2 * LINE_ACCURACY)
        self.known: tuple[np.ndarray, np.ndarray] = (np.zeros(0), np.zeros(0))
        decades = np.log10(self.lines[-1] / self.lines[0]) if len(self.lines) > 1 else 0.0
        parts = np.geomspace(self.lines[0], self.lines[-1], int(PARTS_EACH_DECADE * decades) + 2)[1:-1]
        zeros = [zero.frequency_hz for zero in response.antiresonances if abs(zero.damping_ratio) < NEAR_POLE**2]
        self.breaks = np.unique([*parts, *self.poles, *zeros])

    @property
    def is_far(self) -> np.ndarray:
        """Lines that are not near a pole on the axis, shape (F,)."""
        far = np.ones(len(self.lines), dtype=bool)
        for pole in self.poles:
            far &= np.abs(self.lines - pole) > NEAR_POLE * pole
        return far if far.any() else ~far

    def at(self, frequencies: np.ndarray) -> np.ndarray:
        """H, shape (outputs, inputs, F)."""
        if not np.array_equal(self.known[0], frequencies):
            self.known = frequencies, evaluated(self.harmonic, frequencies).values
        return self.known[1]

    def curves(self, entries: list[_Entry], part: Callable[[_Entry, np.ndarray, np.ndarray], np.ndarray]) -> tuple[Curve, ...]:
        """A curve for each response."""
        colors, factor = self.look.colors or tuple(range(len(self.harmonic.output_names))), self.look.factor

        def functions(frequencies: np.ndarray) -> np.ndarray:
            H = self.at(frequencies / factor)
            return np.array([part(entry, frequencies / factor, H[entry.i, entry.j]) for entry in entries])

        stored = TimeFunctions(functions, factor * self.breaks, 0.0) if self.is_accurate else None
        several = len({entry.i for entry in entries}) < len(entries)
        return tuple(
            Curve(
                entry.name,
                part(entry, self.lines, self.values[entry.i, entry.j]),
                row if several else colors[entry.i],
                None if stored is None else (stored, row),
            )
            for row, entry in enumerate(entries)
        )


def frequency_plots(response: FrequencyResponse, look: ResponseLook, units: np.ndarray, factors: np.ndarray) -> tuple[Plot, ...]:
    """The plots of a response, amplitude and phase of one unit side by side."""
    if (response.frequencies_hz > 0).sum() < 2:
        return ()
    drawn, plots = _Drawn(response, look), []
    groups: dict[str, list[_Entry]] = {}
    for i, j in np.ndindex(len(response.outputs), len(response.inputs)):
        name = f"{response.outputs[i]} by {response.inputs[j]}" if len(response.inputs) > 1 else response.outputs[i]
        groups.setdefault(str(units[i, j]), []).append(_Entry(i, j, name, float(factors[i, j])))
    by = f' by "{response.inputs[0]}"' if len(response.inputs) == 1 else ""
    for unit, entries in groups.items():
        own = f" ({unit})" if len(groups) > 1 else ""
        titles = f"{response.quantity}{own}{by}", response.quantity, "" if unit == "1" else unit
        for kind in look.kinds:
            plots += _KINDS[kind](drawn, entries, *titles)
    return tuple(plots)


def _plot(drawn: _Drawn, title: str, unit: str, curves: tuple[Curve, ...], quantity: str, vertical: Scale = "linear") -> Plot:
    look = drawn.look
    lines = look.factor * drawn.lines
    return Plot(
        title, unit, lines, curves, across_unit=look.axis, quantity=quantity, variable="frequency", scales=("log", vertical)
    )


def _bode(drawn: _Drawn, entries: list[_Entry], title: str, quantity: str, unit: str) -> list[Plot]:
    is_decibel = drawn.look.amplitude == "dB"
    highest = {id(each): float(np.abs(each.factor * drawn.values[each.i, each.j][drawn.is_far]).max()) for each in entries}

    def amplitude(entry: _Entry, _, H: np.ndarray) -> np.ndarray:
        size = np.abs(entry.factor * H)
        if not is_decibel:
            return size
        lowest = highest[id(entry)] * 10 ** (-LOWEST_DECIBEL / 20) or 1.0
        return 20 * np.log10(np.maximum(size, lowest))

    present = [each for each in entries if highest[id(each)] > ABSENT * max(highest.values())]
    curves = drawn.curves(present, amplitude)
    if len(drawn.poles):  # an infinite peak has a finite picture
        most = {id(each): 20 * np.log10(ABOVE * size) if is_decibel else ABOVE * size for each, size in _with(present, highest)}
        curves = tuple(replace(curve, values=np.minimum(curve.values, most[id(each)])) for curve, each in zip(curves, present))
    if quantity == "transmissibility":
        one = np.full(len(drawn.lines), 0.0 if is_decibel else 1.0)
        curves += (Curve("as the support", one, max(curve.color or 0 for curve in curves) + 1),)
    vertical: Scale = "log" if drawn.look.amplitude == "log" and any((curve.values > 0).any() for curve in curves) else "linear"
    shown = f"dB re 1 {unit}".rstrip() if is_decibel else unit
    phases = drawn.curves(present, _phase(drawn, present))
    if not present:
        return []
    return [
        _plot(drawn, title, shown, curves, quantity, vertical),
        _plot(drawn, f"phase of the {title}", "°", phases, "phase"),
    ]


def _with(entries: list[_Entry], sizes: dict[int, float]) -> list[tuple[_Entry, float]]:
    return [(each, sizes[id(each)] or 1.0) for each in entries]


def _phase(drawn: _Drawn, entries: list[_Entry]) -> Callable[[_Entry, np.ndarray, np.ndarray], np.ndarray]:
    """Phases in degrees, continued beyond 180 by the number of turns at the lines where requested."""

    def principal(H: np.ndarray) -> np.ndarray:
        angles = np.degrees(np.angle(H))
        return np.where(angles > 180.0 - 1e-9, angles - 360.0, angles)  # past an undamped resonance -180

    if not drawn.look.unwrapped:
        return lambda entry, _, H: principal(H)
    along = {id(each): np.unwrap(principal(drawn.values[each.i, each.j]), period=360.0) for each in entries}

    def unwrapped(entry: _Entry, frequencies: np.ndarray, H: np.ndarray) -> np.ndarray:
        own = principal(H)
        return own + 360.0 * np.round((np.interp(frequencies, drawn.lines, along[id(entry)]) - own) / 360.0)

    return unwrapped


def _parts(drawn: _Drawn, entries: list[_Entry], title: str, quantity: str, unit: str) -> list[Plot]:
    plots = []
    for name, part in (("real", np.real), ("imaginary", np.imag)):
        curves = drawn.curves(entries, lambda entry, _, H, part=part: entry.factor * part(H))
        if len(drawn.poles):
            most = ABOVE * max(float(np.abs(curve.values[drawn.is_far]).max()) for curve in curves) or 1.0
            curves = tuple(replace(curve, values=np.clip(curve.values, -most, most)) for curve in curves)
        plots.append(_plot(drawn, f"{name} part of the {title}", unit, curves, f"{name} part"))
    return plots


def _nyquist(drawn: _Drawn, entries: list[_Entry], title: str, quantity: str, unit: str) -> list[Plot]:
    plots = []
    for entry in entries:
        values = entry.factor * drawn.values[entry.i, entry.j]
        most = ABOVE * float(np.abs(values[drawn.is_far]).max()) or 1.0
        values = np.where(np.abs(values) > most, values * most / np.maximum(np.abs(values), most), values)
        curve, across = Curve(entry.name, values.imag), Curve(f"real part of the {quantity}", values.real)
        name = f"Nyquist plot of the {title}" if len(entries) == 1 else f"Nyquist plot of {entry.name}"
        lines = drawn.look.factor * drawn.lines
        plots.append(Plot(name, unit, lines, (curve,), across, unit, "imaginary part", variable="frequency"))
    return plots


_KINDS = {"bode": _bode, "parts": _parts, "nyquist": _nyquist}
