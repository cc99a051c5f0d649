"""Frequency responses drawn by matplotlib: Bode, Nyquist, real and imaginary parts; one column for each input, one row for each output."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..ground.errors import InputError

if TYPE_CHECKING:
    from .frequency_response import FrequencyResponse

KINDS = ("bode", "nyquist", "parts")


def draw(response: FrequencyResponse, kind: str, figure=None):
    """The response as a matplotlib figure; lines at poles are left out.

    Args:
        response: with its frequencies.
        kind: "bode", "nyquist" or "parts".
        figure: to draw in; a new one where None.

    Returns:
        The figure.
    """
    if kind not in KINDS:
        raise InputError(f"kind: found {kind!r}; expected one of {', '.join(KINDS)}")
    if figure is None:
        from matplotlib.figure import Figure

        rows = len(response.outputs) * (1 if kind == "nyquist" else 2)
        figure = Figure(figsize=(5.0 * len(response.inputs), 2.2 * rows + 0.6), layout="constrained")
    lower = 1 if kind == "nyquist" else 2
    axes = figure.subplots(lower * len(response.outputs), len(response.inputs), squeeze=False)
    usable = ~np.isin(np.arange(len(response.frequencies_hz)), [one.line for one in response.poles_on_lines])
    f = response.frequencies_hz[usable]
    for i, output in enumerate(response.outputs):
        for j, input in enumerate(response.inputs):
            H, unit = response.values[i, j, usable], response.units[i, j]
            own = axes[lower * i : lower * (i + 1), j]
            own[0].set_title(f"{output} / {input}")
            _DRAWN[kind](own, f, H, f"{response.quantity} ({unit})" if unit else response.quantity)
    return figure


def _bode(axes, f, H, label) -> None:
    size = np.abs(H)
    axes[0].loglog(f[(f > 0) & (size > 0)], size[(f > 0) & (size > 0)])
    axes[0].set_ylabel(label)
    axes[1].semilogx(f[f > 0], np.degrees(np.unwrap(np.angle(H[f > 0]))))
    axes[1].set_ylabel("phase (°)")
    axes[1].set_xlabel("frequency (Hz)")


def _nyquist(axes, f, H, label) -> None:
    axes[0].plot(H.real, H.imag)
    axes[0].set_aspect("equal", adjustable="datalim")
    axes[0].set_xlabel(f"real part of {label}")
    axes[0].set_ylabel("imaginary part")


def _parts(axes, f, H, label) -> None:
    for axis, part, name in ((axes[0], H.real, "real"), (axes[1], H.imag, "imaginary")):
        axis.plot(f, part)
        axis.set_ylabel(f"{name} part of {label}")
    axes[1].set_xlabel("frequency (Hz)")


_DRAWN = {"bode": _bode, "nyquist": _nyquist, "parts": _parts}
