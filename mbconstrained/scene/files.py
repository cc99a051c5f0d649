"""Data files of a scene: only those in its folder, or in folders inside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import InputError
from ..models.matrices import read_matrix
from .units import LARGEST, LEAST, shown


def data_file(folder: Path, name: str) -> Path:
    """The path of a data file named in a scene.

    Raises:
        InputError: an absolute path, or one that leads out of the folder of the scene, also by a symbolic link.
    """
    rule = "data files must lie in the folder of the scene, or in a folder inside it"
    return inside(folder, name, rule, "the name of a .npz, .mtx or .csv file")


def inside(folder: Path, name: str, rule: str, expected: str) -> Path:
    """The path of a file in a folder.

    Raises:
        InputError: an absolute path, or one that leads out of the folder, also by a symbolic link; it says the rule.
    """
    if not name or not name.isprintable():
        raise InputError(f"found {shown(name)}; expected {expected}")
    if Path(name).is_absolute():
        raise InputError(f"found {shown(name)}, an absolute path; {rule}")
    folder = folder.resolve()
    try:
        path = (folder / name).resolve()
    except (OSError, RuntimeError):  # Python before 3.13 has the second for a circle of links
        raise InputError(f"found {shown(name)}, which is a link that leads in a circle; name the file itself") from None
    if not path.is_relative_to(folder):
        raise InputError(f"found {shown(name)}, which leads out of the folder; {rule}")
    return path


def matrix_of(source, folder: Path) -> np.ndarray:
    """A matrix written in the scene, its parameters at their default values, or read from the file that the scene names."""
    return entries_of(source, folder).astype(float)


def entries_of(source, folder: Path) -> np.ndarray:
    """The same with the entries that are expressions of parameters as such."""
    if isinstance(source, np.ndarray):
        return source
    matrix = read_matrix(data_file(folder, source.file), source.array)
    sizes = np.abs(matrix[matrix != 0])
    if sizes.size and not (LEAST <= sizes.min() and sizes.max() <= LARGEST):
        raise InputError(f"{source.file}: entries must be 0 or of a size between {LEAST:g} and {LARGEST:g}")
    return matrix


def record_of(source, folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Times and values, the first and another column of the file that a sampled force names.

    Raises:
        InputError: as ``matrix_of``; too few columns, times that do not ascend. Of a .csv file the line is named.
    """
    path = data_file(folder, source.file)
    try:
        found = read_matrix(path, source.array)
    except InputError:
        if line := _odd_line(path):
            raise InputError(f"{source.file}, line {line}: it has another number of columns than the lines before it") from None
        if line := _line_without_number(path):
            raise InputError(f"{source.file}, line {line}: found an entry that is nan or infinite; expected numbers") from None
        raise
    if found.shape[1] < source.column:
        raise InputError(
            f"{source.file}: found {found.shape[1]} column{'s' if found.shape[1] != 1 else ''}; expected the times in s in "
            f"column 1 and the force in column {source.column}"
        )
    times, values = found[:, 0], found[:, source.column - 1]
    sizes = np.abs(found[:, [0, source.column - 1]])
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
    return next((number for (_, before), (number, line) in zip(lines, lines[1:]) if line.count(",") != before.count(",")), None)


def _line_without_number(path: Path) -> int | None:
    """The first line with an entry that is nan or infinite."""
    return next((number for number, line in _data_lines(path) if not np.isfinite(_numbers(line)).all()), None)


def _numbers(line: str) -> list[float]:
    try:
        return [float(entry) for entry in line.split(",")]
    except ValueError:  # the reader has told
        return []


def _place(path: Path, row: int) -> str:
    lines = _data_lines(path)
    return f"line {lines[row][0]}" if lines else f"row {row + 1}"
