"""Matrices in files, read as data and never as code; what is sparse in the file stays sparse.

NumPy .npy and .npz, scipy.sparse .npz, Matrix Market .mtx, MATLAB .mat, Nastran OUTPUT4 .op4, and text with columns of numbers.
"""

from __future__ import annotations

import warnings
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import scipy.sparse

from ..ground.checks import nearest, optional_package, real_array
from ..ground.errors import InputError
from ..ground.files import LARGEST_FILE, checked_file, readable_as
from .number_table import number_table
from .universal import UNIVERSAL

LARGEST_SIDE = 5000  # rows or columns of an array: 200 MB as float64
LARGEST_SPARSE_SIDE = 5_000_000  # of a sparse matrix, whose file has at most LARGEST_FILE bytes

TEXT = (".csv", ".txt", ".dat")


def read_matrix(path: str | Path, array: str | None = None) -> np.ndarray | scipy.sparse.csc_array:
    """One matrix of finite real numbers from a file.

    Args:
        path: a file that ends in .npy, .npz, .mtx, .mat, .op4, .csv, .txt or .dat.
        array: the name of the matrix in an .npz, .mat or .op4 file; not needed when it holds only one.

    Returns:
        A float64 array of two dimensions; a ``scipy.sparse.csc_array`` where the file holds a sparse matrix.

    Raises:
        InputError: no such file, unknown ending, too large, cannot be read, unknown name, not a matrix of real numbers.
        MissingPackage: .op4 files need pyyeti.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "mass.csv")
    ...     _ = path.write_text("10, 0\\n0, 10\\n")
    ...     read_matrix(path).tolist()
    [[10.0, 0.0], [0.0, 10.0]]
    """
    path = Path(path)
    reader = READERS.get(path.suffix.lower())
    if path.suffix.lower() in UNIVERSAL:
        raise InputError(
            f"{path.name}: matrices of universal files (data set 252) are not read, since pyuff, which reads these files, does not know "
            "them; write them as .op4, .mat or .mtx, which keep their digits"
        )
    if reader is None:
        raise InputError(f"{path.name}: expected a file that ends in {', '.join(READERS)}")
    if array is not None and path.suffix.lower() not in NAMED:
        raise InputError(f"{path.name}: only {', '.join(NAMED)} files hold named arrays; leave out the name {array}")
    checked_file(path)
    try:
        matrix = reader(path, array)
    except OSError as problem:
        raise InputError(f"{path.name}: the file cannot be read ({problem.strerror or problem})") from None
    return _sparse(path, matrix) if scipy.sparse.issparse(matrix) else real_array(matrix, path.name, shape=(None, None))


def full_matrix(matrix, name: str) -> np.ndarray:
    """A matrix as an array, where it is not too large for one.

    Args:
        matrix: an array or a sparse matrix.
        name: of the file, for messages.

    Returns:
        The array.

    Raises:
        InputError: a sparse matrix of more than LARGEST_SIDE rows or columns.
    """
    if not scipy.sparse.issparse(matrix):
        return matrix
    _check_size(name, matrix.shape)
    return matrix.toarray()


def _sparse(path: Path, matrix) -> scipy.sparse.csc_array:
    """Of a file: indices are checked, which SciPy leaves to the caller, before anything computes with them."""
    if any(side > LARGEST_SPARSE_SIDE for side in matrix.shape):
        raise InputError(
            f"{path.name}: the matrix is {_by(matrix.shape)}; at most {LARGEST_SPARSE_SIDE:,} rows and columns are read"
        )
    with readable_as(path, "not a sparse matrix"):
        if hasattr(matrix, "check_format"):
            matrix.check_format(full_check=True)
        if matrix.dtype.kind not in "biuf":
            kind = "complex numbers" if matrix.dtype.kind == "c" else f"entries of type {matrix.dtype}"
            raise InputError(f"{path.name}: {kind} found; only real data is accepted")
        matrix = scipy.sparse.csc_array(matrix, dtype=float)
    matrix.sum_duplicates()
    if not np.isfinite(matrix.data).all():
        entries = matrix.tocoo()
        place = int(np.argmin(np.isfinite(entries.data)))
        at = (int(entries.row[place]), int(entries.col[place]))
        raise InputError(f"{path.name}: the entry at {at} is {entries.data[place]}; every entry must be a finite number")
    return matrix


def _check_size(name: str, shape: tuple[int, ...], largest: int = LARGEST_SIDE) -> None:
    if any(side > largest for side in shape):
        raise InputError(f"{name}: the matrix is {_by(shape)}; at most {largest} rows and columns are read")


def _by(shape: tuple[int, ...]) -> str:
    return " x ".join(map(str, shape))


def _chosen(path: Path, array: str | None, names: Iterable[str]) -> str:
    """The name of the matrix to read."""
    names = list(names)
    if array is None and len(names) != 1:
        raise InputError(f"{path.name}: holds the arrays {', '.join(names) or 'none'}; give the name of one")
    name = names[0] if array is None else array
    if name not in names:
        raise InputError(f"{path.name}: no array {name} in it{nearest(name, names)}; it holds {', '.join(names) or 'none'}")
    return name


def _check_bytes(path: Path, name: str, size: int) -> None:
    if size > LARGEST_FILE:
        raise InputError(f"{path.name}: the array {name} has {size:,} bytes; at most {LARGEST_FILE:,} are read")


def _from_npz(path: Path, array: str | None):
    with readable_as(path, "not an .npz file of numbers"):
        with zipfile.ZipFile(path) as archive:
            sizes = {info.filename.removesuffix(".npy"): info.file_size for info in archive.infolist()}
        if {"format", "shape", "data"} <= set(sizes) and array is None:  # as scipy.sparse.save_npz writes it
            for name, size in sizes.items():
                _check_bytes(path, name, size)
            return scipy.sparse.load_npz(path)
        name = _chosen(path, array, sizes)
        _check_bytes(path, name, sizes[name])
        with np.load(path, allow_pickle=False) as arrays:
            return arrays[name]


def _from_npy(path: Path, array: None) -> np.ndarray:
    with readable_as(path, "not an .npy file of numbers"):
        return np.array(np.load(path, allow_pickle=False, mmap_mode="r"))  # mapped: no header can request more than the file has


def _from_matrix_market(path: Path, array: None):
    import scipy.io  # takes a quarter of a second

    with readable_as(path, "not a Matrix Market file"):
        *shape, _, kind, _, _ = scipy.io.mminfo(path)
        _check_size(path.name, tuple(shape), LARGEST_SPARSE_SIDE if kind == "coordinate" else LARGEST_SIDE)
        return scipy.io.mmread(path)


def _from_mat(path: Path, array: str | None):
    """A variable of a MATLAB file of version 4 to 7; later ones are HDF5 files."""
    import scipy.io

    if path.read_bytes()[:8] == b"\x89HDF\r\n\x1a\n" or b"MATLAB 7.3" in path.read_bytes()[:128]:
        raise InputError(f"{path.name}: a MATLAB file of version 7.3; write it in MATLAB with save('{path.name}', '-v7')")
    with readable_as(path, "not a MATLAB file of numbers"):
        shapes = {name: (shape, kind) for name, shape, kind in scipy.io.whosmat(path)}
        name = _chosen(path, array, [name for name, (shape, kind) in shapes.items() if kind in _MATLAB_KINDS])
        shape, kind = shapes[name]
        if kind != "sparse":
            _check_bytes(path, name, 8 * int(np.prod([float(side) for side in shape])))
        return scipy.io.loadmat(path, variable_names=[name])[name]


_MATLAB_KINDS = (
    *("double", "single", "sparse", "logical"),
    *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)),
)


def _from_op4(path: Path, array: str | None):
    """A matrix of a Nastran OUTPUT4 file, text or binary; sparse where the file stores columns as strings of entries."""
    op4 = optional_package("pyyeti.nastran.op4", "reading .op4 files")
    with (
        readable_as(path, "not a Nastran OUTPUT4 file"),
        warnings.catch_warnings(),
    ):  # of names that are none in MATLAB, which it replaces; messages list those
        warnings.simplefilter("ignore", RuntimeWarning)
        names, sizes, *_ = op4.OP4().dir(str(path), verbose=False)
        name = _chosen(path, array.lower() if array else None, names)
        shape = tuple(map(int, sizes[names.index(name)]))
        _check_size(path.name, shape, LARGEST_SPARSE_SIDE)
        sparse = True if max(shape) > LARGEST_SIDE else None  # None: as the file stores it
        return op4.OP4().dctload(str(path), namelist=[name], justmatrix=True, sparse=sparse)[name]


def _from_text(path: Path, array: None) -> np.ndarray:
    table = number_table(path)
    return table.checked(*range(table.values.shape[1]))


READERS: dict[str, Callable] = {
    ".npz": _from_npz,
    ".npy": _from_npy,
    ".mtx": _from_matrix_market,
    ".mat": _from_mat,
    ".op4": _from_op4,
    **dict.fromkeys(TEXT, _from_text),
}
NAMED = (".npz", ".mat", ".op4")
