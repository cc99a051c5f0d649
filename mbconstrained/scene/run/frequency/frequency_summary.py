"""The frequency response of a scene as text of 80 columns and as plain data."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ....ground.checks import counted
from ....ground.display import TextTable, finite_or_none
from ..report.summary import notices_json, response_blocks

if TYPE_CHECKING:
    from ....frequency.features import Peak
    from .frequency_data import FrequencyData

#: Rows of a table for a terminal; the page has more, and JSON has all.
MOST_ROWS = 16

#: Rows of a table of the page.
MOST_ROWS_OF_PAGE = 200

NOTHING = "–"
HALF_POWER = "bandwidth: between the frequencies of half the power; damping ratio: bandwidth / (2 frequency)"
NO_PEAKS = "There are none in this range."


def blocks(frequency: FrequencyData) -> list[str | TextTable]:
    """Printed blocks: quantity, peaks, antiresonances, notices and files."""
    tables = [peak_table(frequency, MOST_ROWS), antiresonance_table(frequency, MOST_ROWS)]
    return response_blocks(
        (frequency.scene.heading, frequency.scene.table.source), facts(frequency), tables, frequency.notices, frequency.files
    )


def facts(frequency: FrequencyData) -> tuple[tuple[str, str], ...]:
    """Quantity, inputs and outputs, and frequencies."""
    response, table = frequency.response, frequency.table
    low, high = (f"{frequency.axis_factor * f:.4g}" for f in response.frequencies_hz[[0, -1]])
    error = response.error_estimate[np.isfinite(response.error_estimate)].max(initial=0.0)
    how = "placed by the poles" if table.is_auto else f"{table.spacing} steps" if table.frequencies is None else "as given"
    count = counted(len(response.frequencies_hz), "frequency", "frequencies")
    lines = [
        ("quantity", response.quantity),
        ("inputs", ", ".join(response.inputs)),
        ("outputs", ", ".join(response.outputs)),
        ("frequencies", f"{low} to {high} {table.axis}, {count}, {how}"),
        ("error estimate", f"{error:.2g} of each value"),
    ]
    if response.rigid_body.any():
        lines.append(("rigid body", "the responses contain 1/s², motion that nothing restores"))
    return tuple(lines)


def _entry(frequency: FrequencyData, output: str, input: str) -> tuple[str, ...]:
    return (output, input) if len(frequency.response.inputs) > 1 else (output,)


def _heads(frequency: FrequencyData) -> tuple[str, ...]:
    return ("output", "input") if len(frequency.response.inputs) > 1 else ("output",)


def shown_amplitude(frequency: FrequencyData, peak: Peak) -> tuple[float, str]:
    """The amplitude of a peak and its unit, as they are shown."""
    place = frequency.response.outputs.index(peak.output), frequency.response.inputs.index(peak.input)
    return float(frequency.shown.factors[place]) * peak.amplitude, str(frequency.shown.units[place])


def peak_table(frequency: FrequencyData, most: int = MOST_ROWS_OF_PAGE) -> TextTable:
    """Frequency, amplitude, bandwidth, damping ratio and phase of the peaks, entry by entry."""
    rows = [_peak_row(frequency, peak) for peak in frequency.peaks]
    unit = frequency.table.axis
    wide = (f"frequency ({unit})", "amplitude", f"bandwidth ({unit})", "damping ratio", "phase (°)")
    narrow = (unit, "amplitude", "bandwidth", "damping", "phase (°)")
    columns = (*_heads(frequency), *(narrow if most == MOST_ROWS else wide))
    more = [f"and {len(rows) - most} more"] if len(rows) > most else []
    note = "; ".join([*more, HALF_POWER]) if rows else NO_PEAKS
    return TextTable(f"Peaks of the {frequency.response.quantity}", columns, tuple(rows[:most]), note)


def _peak_row(frequency: FrequencyData, peak: Peak) -> tuple[str, ...]:
    amplitude, unit = shown_amplitude(frequency, peak)
    size = f"{amplitude:.4g}" if np.isfinite(amplitude) else "infinite"
    factor, width, ratio = frequency.axis_factor, peak.bandwidth_hz, half_power_ratio(peak)
    return (
        *_entry(frequency, peak.output, peak.input),
        f"{factor * peak.frequency_hz:.5g}",
        size if unit == "1" or size == "infinite" else f"{size} {unit}",
        NOTHING if width is None else f"{factor * width:.4g}",
        NOTHING if ratio is None else f"{ratio:.4g}",
        f"{_degrees(peak.phase):.1f}",
    )


def half_power_ratio(peak: Peak) -> float | None:
    """The damping ratio by the half-power bandwidth; None where there is no bandwidth."""
    return None if peak.bandwidth_hz is None else peak.bandwidth_hz / (2 * peak.frequency_hz)


def _degrees(phase: float) -> float:
    return float(np.degrees(phase)) + 0.0


def antiresonance_table(frequency: FrequencyData, most: int = MOST_ROWS_OF_PAGE) -> TextTable | None:
    """Frequency and damping ratio of the antiresonances; None where there are none."""
    rows = [
        (
            *_entry(frequency, zero.output, zero.input),
            f"{frequency.axis_factor * zero.frequency_hz:.5g}",
            f"{_clean(zero.damping_ratio):.4g}",
        )
        for zero in frequency.antiresonances
    ]
    if not rows:
        return None
    columns = (*_heads(frequency), f"frequency ({frequency.table.axis})", "damping ratio")
    note = f"and {len(rows) - most} more" if len(rows) > most else ""
    return TextTable("Antiresonances", columns, tuple(rows[:most]), note)


#: A damping ratio below this is a rounding error.
SMALLEST_RATIO = 1e-12


def _clean(ratio: float) -> float:
    return ratio if abs(ratio) > SMALLEST_RATIO else 0.0


def as_json(frequency: FrequencyData) -> dict:

    scene, response = frequency.scene, frequency.response
    return {
        "title": scene.title,
        "source": scene.table.source,
        "quantity": response.quantity,
        "inputs": list(response.inputs),
        "outputs": list(response.outputs),
        "units": response.units.tolist(),
        "frequencies": {
            "from": float(response.frequencies_hz[0]),
            "to": float(response.frequencies_hz[-1]),
            "count": len(response.frequencies_hz),
        },
        "peaks": [
            {
                "output": peak.output,
                "input": peak.input,
                "frequency_hz": peak.frequency_hz,
                "amplitude": finite_or_none(peak.amplitude),
                "bandwidth_hz": peak.bandwidth_hz,
                "damping_ratio": half_power_ratio(peak),
                "phase": peak.phase,
            }
            for peak in frequency.peaks
        ],
        "antiresonances": [
            {"output": zero.output, "input": zero.input, "frequency_hz": zero.frequency_hz, "damping_ratio": zero.damping_ratio}
            for zero in frequency.antiresonances
        ],
        "poles": [{"real": float(pole.real), "imaginary": float(pole.imag)} for pole in response.poles],
        "poles_on_lines": [{"frequency_hz": one.frequency_hz, "order": one.pole.order} for one in response.poles_on_lines],
        "error_estimate": float(response.error_estimate[np.isfinite(response.error_estimate)].max(initial=0.0)),
        "notices": notices_json(frequency.notices),
        "trusted": frequency.is_trusted,
        "files": [str(path) for path in frequency.files],
    }
