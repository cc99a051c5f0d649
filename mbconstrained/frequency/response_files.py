"""The contents of files with the values of a frequency response: CSV, and arrays for NumPy."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .frequency_response import FrequencyResponse


def arrays_of(response: FrequencyResponse) -> dict[str, np.ndarray]:
    """Frequencies, values, error estimates, names, units and quantity, by name."""
    texts = {"outputs": np.array(response.outputs), "inputs": np.array(response.inputs), "units": np.array(response.units)}
    numbers = {name: getattr(response, name) for name in ("frequencies_hz", "values", "error_estimate")}
    return {**numbers, **texts, "quantity": np.array(response.quantity)}


def csv_text(response: FrequencyResponse) -> str:
    """Real and imaginary parts with names and units, one line for each frequency."""
    heads, columns = ["frequency (Hz)"], [response.frequencies_hz]
    for i, output in enumerate(response.outputs):
        for j, input in enumerate(response.inputs):
            for part in ("real", "imag"):
                heads.append(f"{part} {output}/{input} ({response.units[i, j]})".replace(",", ";").replace("\n", " "))
                columns.append(getattr(response.values[i, j], part))
    lines = [",".join(heads), *(",".join(map(repr, row)) for row in np.array(columns).T.tolist())]
    return "\n".join(lines) + "\n"
