"""Data files of a scene: matrices and records in its folder, or in folders inside it."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

from ...ground.errors import InputError
from ...models.matrices import read_matrix
from ..file.reading import inside
from ..quantities.quantities import LARGEST, LEAST


def _data_file(folder: Path, name: str) -> Path:
    """The path of a data file named in a scene."""
    rule = "data files must lie in the folder of the scene, or in a folder inside it"
    return inside(folder, name, rule, "the name of a .npz, .mtx or .csv file")


def entries_of(source, folder: Path) -> np.ndarray:
    """The entries of a matrix, those that are expressions of parameters as such.

    Args:
        source: the matrix written in the scene, or the table with the file that contains it.
        folder: of the scene.

    Returns:
        The matrix, in SI, of objects where it is written in the scene.

    Raises:
        InputError: a file that cannot be read, or that is not in the folder of the scene, also by a symbolic link.
    """
    if isinstance(source, np.ndarray):
        return source
    matrix = read_matrix(_data_file(folder, source.file), source.array)
    sizes = np.abs(matrix[matrix != 0])
    if sizes.size and not (LEAST <= sizes.min() and sizes.max() <= LARGEST):
        raise InputError(f"{source.file}: entries must be 0 or of a size between {LEAST:g} and {LARGEST:g}")
    return matrix


def record_of(source, folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """A record in a file.

    Args:
        source: the [[force]] table that names it.
        folder: of the scene.

    Returns:
        Times in s, the first column, and values, another column.

    Raises:
        InputError: as ``entries_of``; too few columns, times that do not ascend. Of a .csv file the line is named.
    """
    path = _data_file(folder, source.file)
    try:
        columns = read_matrix(path, source.array)
    except InputError:
        if line := _odd_line(path):
            raise InputError(f"{source.file}, line {line}: it has another number of columns than the lines before it") from None
        if line := _line_without_number(path):
            raise InputError(f"{source.file}, line {line}: found an entry that is nan or infinite; expected numbers") from None
        raise
    if columns.shape[1] < source.column:
        raise InputError(
            f"{source.file}: found {columns.shape[1]} column{'s' if columns.shape[1] != 1 else ''}; expected the times in s in "
            f"column 1 and the force in column {source.column}"
        )
    times, values = columns[:, 0], columns[:, source.column - 1]
    sizes = np.abs(columns[:, [0, source.column - 1]])
    if (beyond := ((sizes != 0) & ((sizes < LEAST) | (sizes > LARGEST))).any(axis=1)).any():
        row = int(np.argmax(beyond))
        raise InputError(
            f"{source.file}, {_place(path, row)}: found {times[row]:g} s and {values[row]:g}; expected 0 or a size between "
            f"{LEAST:g} and {LARGEST:g} of both"
        )
    if (backwards := np.diff(times) < 0).any():
        row = int(np.argmax(backwards)) + 1
        raise InputError(
            f"{source.file}, {_place(path, row)}: {times[row - 1]:g} s is followed by {times[row]:g} s; times must ascend"
        )
    return times, values


def _data_lines(path: Path) -> list[tuple[int, str]]:
    """The lines of a .csv file that hold numbers, with their numbers."""
    if path.suffix.lower() != ".csv" or not path.is_file():
        return []
    lines = enumerate(path.read_text("utf-8-sig", errors="replace").splitlines(), 1)
    return [(number, line) for number, line in lines if line.strip() and line.strip()[0] != "#"]


def _odd_line(path: Path) -> int | None:
    """The first line with another number of columns than the one before."""
    lines = _data_lines(path)
    return next((number for (_, before), (number, line) in pairwise(lines) if line.count(",") != before.count(",")), None)


def _line_without_number(path: Path) -> int | None:
    """The first line with an entry that is nan or infinite."""
    return next((number for number, line in _data_lines(path) if not np.isfinite(_numbers(line)).all()), None)


def _numbers(line: str) -> list[float]:
    try:
        return [float(entry) for entry in line.split(",")]
    except ValueError:  # reported by the reader
        return []


def _place(path: Path, row: int) -> str:
    lines = _data_lines(path)
    return f"line {lines[row][0]}" if lines else f"row {row + 1}"
