"""Files with the values of a frequency response: CSV, arrays for NumPy, universal files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..exchange.universal import UNIVERSAL, Geometry, write_frequency_responses
from ..ground.errors import InputError
from ..ground.files import replacing

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


def write_response(response: FrequencyResponse, path: Path, geometry: Geometry | None = None) -> Path:
    """Write the values in the format of the ending."""
    if path.suffix not in (".csv", ".npz", *UNIVERSAL):
        raise InputError(f'path: found the ending "{path.suffix}"; expected .csv, .npz or .uff')
    with replacing(path) as temporary:
        if path.suffix == ".npz":
            with temporary.open("wb") as file:
                np.savez(file, allow_pickle=False, **arrays_of(response))
        elif path.suffix == ".csv":
            temporary.write_text(csv_text(response), encoding="utf-8")
        else:
            write_frequency_responses(temporary, response, geometry or Geometry(), path.stem)
    return path
