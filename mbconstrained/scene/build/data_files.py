"""Data files of a scene: matrices and records in its folder, or in folders inside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...ground.errors import InputError
from ...ground.quantities import LARGEST, LEAST
from ..file.reading import inside
from ..quantities.coordinates import force_value


def _data_file(folder: Path, name: str) -> Path:
    """The path of a data file named in a scene."""
    rule = "data files must lie in the folder of the scene, or in a folder inside it"
    return inside(folder, name, rule, "the name of a file such as record.csv or matrices.npz")


def entries_of(source, folder: Path) -> np.ndarray:
    """The entries of a matrix, with expressions of parameters unevaluated."""
    if isinstance(source, np.ndarray):
        return source
    from ...exchange.matrices import full_matrix, read_matrix

    matrix = full_matrix(read_matrix(_data_file(folder, source.file), source.array), source.file)
    sizes = np.abs(matrix[matrix != 0])
    if sizes.size and not (LEAST <= sizes.min() and sizes.max() <= LARGEST):
        raise InputError(f"{source.file}: entries must be 0 or of a size between {LEAST:g} and {LARGEST:g}")
    return matrix


def record_of(source, unit: str | None, folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """A record in a file."""
    from .record_file import record_in_si

    keys = ("column", "time", "time_unit", "step", "header", "array", "factor")
    given = {key: getattr(source, key) for key in keys if getattr(source, key) is not None}
    offset = force_value(source.offset, unit, what="offset")
    record = record_in_si(_data_file(folder, source.file), unit=source.unit, expected=unit, offset=offset, **given)
    return record.times, record.values
