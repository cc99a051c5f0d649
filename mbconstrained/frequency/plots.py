"""Frequency responses drawn by matplotlib: Bode, Nyquist, real and imaginary parts; one column for each input, rows for each output.

Branches of periodic motions over the frequency, too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ..ground.checks import check_known
from ..ground.tolerances import EPS

KINDS = ("bode", "nyquist", "parts")

#: Values of 1 Hz by the unit of the axis.
AXIS_FACTORS = {"Hz": 1.0, "rad/s": 2 * np.pi, "rev/min": 60.0, "rpm": 60.0}

#: Most peaks of one response that are marked: more labels cover each other.
MOST_PEAKS = 8

#: A range of frequencies below this factor has labels between the powers of ten, too.
FEW_DECADES = 12.0


def shown_axis(unit: str) -> str:
    """The unit of an axis as it is printed, which has one spelling."""
    return "rev/min" if unit == "rpm" else unit


@dataclass(frozen=True)
class PlotStyle:
    """Style of the plot of a response: the arguments of ``FrequencyResponse.plot``, and the dead time of the input in s."""

    amplitude: str = "log"
    unwrapped: bool = True
    axis: str = "Hz"
    peaks: bool = True
    dead_time: float = 0.0

    def __post_init__(self):
        check_known(self.amplitude, ("log", "linear", "dB"), "amplitude")
        check_known(self.axis, AXIS_FACTORS, "axis")
        object.__setattr__(self, "axis", shown_axis(self.axis))

    def shown(self, size):
        """Amplitudes as plotted."""
        return 20 * np.log10(size) if self.amplitude == "dB" else size


def principal_phase(H: np.ndarray) -> np.ndarray:
    """The phase in degrees; that of a negative number is -180, as past an undamped resonance."""
    angles = np.degrees(np.angle(H))
    return np.where(angles > 180.0 * (1 - EPS**0.5), angles - 360.0, angles)


def continuous_phase(H: np.ndarray, frequencies_hz: np.ndarray, dead_time: float) -> np.ndarray:
    """The phase in degrees without jumps between lines, from one to the next of which a dead time may turn it by more than half a turn."""
    turns = 360.0 * dead_time * frequencies_hz
    return np.unwrap(principal_phase(H * np.exp(1j * np.radians(turns))), period=360.0) - turns


def draw(response, kind: str, figure=None, style: PlotStyle = PlotStyle()):
    """A ``FrequencyResponse`` as a matplotlib figure; lines at poles are left out."""
    check_known(kind, KINDS, "kind")
    lower = 1 if kind == "nyquist" else 2
    if figure is None:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(5.0 * len(response.inputs), 2.2 * lower * len(response.outputs) + 0.6), layout="constrained")
    axes = figure.subplots(lower * len(response.outputs), len(response.inputs), squeeze=False)
    usable = ~np.isin(np.arange(len(response.frequencies_hz)), [one.line for one in response.poles_on_lines])
    f = response.frequencies_hz[usable]
    for i, output in enumerate(response.outputs):
        for j, input in enumerate(response.inputs):
            H, unit = response.values[i, j, usable], response.units[i, j]
            own = axes[lower * i : lower * (i + 1), j]
            own[0].set_title(f"{output} / {input}")
            own_style = replace(style, dead_time=response.harmonic.dead_time(j))
            _DRAWN[kind](own, f, H, response.quantity, "" if unit == "1" else unit, own_style)
            if kind == "bode":
                if response.quantity == "transmissibility":
                    own[0].axhline(style.shown(1.0), color="0.5", linewidth=0.8)
                if style.peaks and len(f):
                    _mark_peaks(own[0], response, (output, input), (f[0], f[-1]), style)
    return figure


def draw_branch(frequencies_hz, amplitudes, unstable, marks: Mapping[str, Sequence[tuple[float, float]]], label: str, axes=None):
    """A branch of periodic motions as matplotlib axes: unstable parts dashed, marked points by their kind."""
    if axes is None:
        from matplotlib.figure import Figure

        axes = Figure(layout="constrained").subplots()
    ends = [0, *(np.flatnonzero(np.diff(unstable.astype(int))) + 1), len(unstable)]
    for begin, end in pairwise(ends):
        part = slice(max(begin - 1, 0), end)  # from the last point before it on, without a gap
        axes.plot(frequencies_hz[part], amplitudes[part], color="C0", linestyle="--" if unstable[begin] else "-")
    for number, (kind, points) in enumerate(marks.items(), start=1):
        axes.plot(*np.transpose(points), f"C{number}o", label=kind)
    if marks:
        axes.legend()
    axes.set_xlabel("frequency (Hz)")
    axes.set_ylabel(label)
    return axes


def _mark_peaks(axes, response, entry: tuple[str, str], ends: tuple[float, float], style: PlotStyle) -> None:
    """Mark the highest peaks within the plot with their frequencies."""
    known = [
        p for p in response.peaks if (p.output, p.input) == entry and ends[0] <= p.frequency_hz <= ends[1] and p.frequency_hz > 0
    ]
    finite = sorted((p for p in known if np.isfinite(p.amplitude)), key=lambda p: -p.amplitude)
    for peak in finite[:MOST_PEAKS]:
        x, y = AXIS_FACTORS[style.axis] * peak.frequency_hz, style.shown(peak.amplitude)
        axes.plot([x], [y], "o", color="C3", markersize=3)
        axes.annotate(f"{x:.4g} {style.axis}", (x, y), (4, 3), textcoords="offset points", fontsize="small")
    if finite:
        axes.margins(y=0.15)


def _bode(axes, f, H, quantity, unit, style) -> None:
    factor, size = AXIS_FACTORS[style.axis], np.abs(H)
    there = (f > 0) & (size > 0)
    drawn = {"log": axes[0].loglog, "linear": axes[0].semilogx, "dB": axes[0].semilogx}[style.amplitude]
    drawn(factor * f[there], style.shown(size[there]))
    shown = f"dB re 1 {unit}".rstrip() if style.amplitude == "dB" else unit
    axes[0].set_ylabel(_labelled(quantity, shown))
    positive, drawn = f[f > 0], H[f > 0]
    phase = continuous_phase(drawn, positive, style.dead_time) if style.unwrapped else principal_phase(drawn)
    axes[1].semilogx(factor * positive, phase)
    axes[1].set_ylabel("phase (°)")
    axes[1].set_xlabel(f"frequency ({style.axis})")
    for each in axes:  # decimal numbers; between the powers of ten only where few of these are in the picture
        each.xaxis.set_major_formatter("{x:g}")
        if there.any() and f[there][-1] < FEW_DECADES * f[there][0]:
            each.xaxis.set_minor_formatter("{x:g}")


def _labelled(text: str, unit: str) -> str:
    return f"{text} ({unit})" if unit else text


def _nyquist(axes, f, H, quantity, unit, style) -> None:
    axes[0].plot(H.real, H.imag)
    axes[0].set_aspect("equal", adjustable="datalim")
    axes[0].set_xlabel(_labelled(f"real part of {quantity}", unit))
    axes[0].set_ylabel("imaginary part")


def _parts(axes, f, H, quantity, unit, style) -> None:
    for axis, part, name in ((axes[0], H.real, "real"), (axes[1], H.imag, "imaginary")):
        axis.plot(AXIS_FACTORS[style.axis] * f, part)
        axis.set_ylabel(_labelled(f"{name} part of {quantity}", unit))
    axes[1].set_xlabel(f"frequency ({style.axis})")


_DRAWN = {"bode": _bode, "nyquist": _nyquist, "parts": _parts}
