"""Matrices in files: NumPy .npz, Matrix Market .mtx and .csv, read as data and never as code."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from ..ground.checks import nearest, real_array
from ..ground.errors import InputError

LARGEST_FILE = 200_000_000  # bytes, also of one unpacked array
LARGEST_SIDE = 5000  # rows or columns: 200 MB as float64


def read_matrix(path: str | Path, array: str | None = None) -> np.ndarray:
    """One matrix of finite real numbers from a file.

    Args:
        path: a file that ends in .npz, .mtx or .csv.
        array: the name of the array in an .npz file; not needed when it holds only one.

    Returns:
        A float64 array of two dimensions.

    Raises:
        InputError: no such file, unknown ending, too large, cannot be read, unknown array, not a matrix of real numbers.

    >>> import pathlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "mass.csv")
    ...     _ = path.write_text("10, 0\\n0, 10\\n")
    ...     read_matrix(path).tolist()
    [[10.0, 0.0], [0.0, 10.0]]
    """
    path = Path(path)
    readers = {".npz": _from_npz, ".mtx": _from_matrix_market, ".csv": _from_csv}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{path.name}: expected a file that ends in {', '.join(readers)}")
    if array is not None and reader is not _from_npz:
        raise InputError(f"{path.name}: only .npz files hold named arrays; leave out the name {array}")
    try:
        _check_file(path)
        matrix = reader(path, array) if reader is _from_npz else reader(path)
    except OSError as problem:
        raise InputError(f"{path.name}: the file cannot be read ({problem.strerror or problem})") from None
    return real_array(matrix, path.name, shape=(None, None))


def _check_file(path: Path) -> None:
    if not path.exists():
        others = [other.name for other in path.parent.glob("*") if other.is_file()] if path.parent.is_dir() else []
        raise InputError(f"{path.name}: there is no such file in the folder{nearest(path.name, others)}")
    if not path.is_file():
        raise InputError(f"{path.name}: expected a file, found another object of that name")
    size = path.stat().st_size
    if size > LARGEST_FILE:
        raise InputError(f"{path.name}: the file has {size:,} bytes; at most {LARGEST_FILE:,} are read")
    if size == 0:
        raise InputError(f"{path.name}: the file is empty")
    with open(path, "rb"):  # not every reader reports a missing permission itself
        return


def _check_size(path: Path, shape: tuple[int, ...]) -> None:
    if any(side > LARGEST_SIDE for side in shape):
        shape_text = " x ".join(map(str, shape))
        raise InputError(f"{path.name}: the matrix is {shape_text}; at most {LARGEST_SIDE} rows and columns are read")


def _from_npz(path: Path, array: str | None) -> np.ndarray:
    try:
        with zipfile.ZipFile(path) as archive:
            sizes = {info.filename.removesuffix(".npy"): info.file_size for info in archive.infolist()}
        name = _chosen(path, array, sizes)
        with np.load(path, allow_pickle=False) as arrays:
            return arrays[name]
    except InputError:
        raise
    except (ValueError, EOFError, MemoryError, NotImplementedError, RuntimeError, zipfile.BadZipFile) as problem:
        raise InputError(f"{path.name}: not an .npz file of numbers ({_first_line(problem)})") from None


def _chosen(path: Path, array: str | None, sizes: dict[str, int]) -> str:
    if array is None and len(sizes) != 1:
        raise InputError(f"{path.name}: holds the arrays {', '.join(sizes) or 'none'}; give the name of one")
    name = next(iter(sizes)) if array is None else array
    if name not in sizes:
        raise InputError(f"{path.name}: no array {name} in it{nearest(name, sizes)}; it holds {', '.join(sizes)}")
    if sizes[name] > LARGEST_FILE:
        raise InputError(f"{path.name}: the array {name} has {sizes[name]:,} bytes; at most {LARGEST_FILE:,} are read")
    return name


def _from_matrix_market(path: Path) -> np.ndarray:
    import scipy.io  # takes a quarter of a second

    try:
        _check_size(path, scipy.io.mminfo(path)[:2])
        return scipy.io.mmread(path)
    except InputError:
        raise
    except (ValueError, TypeError, OverflowError, MemoryError) as problem:
        raise InputError(f"{path.name}: not a Matrix Market file ({_first_line(problem)})") from None


def _from_csv(path: Path) -> list[list[float]]:
    try:
        lines = path.read_text("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise InputError(f"{path.name}: not a text file in UTF-8") from None
    return [_row(path, number, line) for number, line in enumerate(lines, 1) if line.strip() and line.strip()[0] != "#"]


def _row(path: Path, number: int, line: str) -> list[float]:
    try:
        return [float(entry) for entry in line.split(",")]
    except ValueError:
        raise InputError(
            f"{path.name}, line {number}: found {line[:40]!a}; expected numbers separated by commas, "
            "with a decimal point; a line that begins with # is left out"
        ) from None


def _first_line(problem: Exception) -> str:
    return (str(problem).splitlines() or [type(problem).__name__])[0][:120]
