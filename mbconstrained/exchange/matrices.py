"""Matrices in files, read as data and never as code; sparse matrices in files stay sparse."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import scipy

from ..ground.by_name import answering
from ..ground.checks import nearest, optional_package, real_array
from ..ground.errors import InputError
from ..ground.files import LARGEST_FILE, checked_file, damaged, read_isolated, readable_as
from .columns import SHEETS, number_table
from .universal import UNIVERSAL

# Matrices in files.
# NumPy .npy and .npz, scipy.sparse .npz, Matrix Market .mtx, MATLAB .mat, Nastran OUTPUT4 .op4, and text with columns of numbers.

LARGEST_SIDE = 5000  # rows or columns of an array: 200 MB as float64
LARGEST_SPARSE_SIDE = 5_000_000  # of a sparse matrix, whose file has at most LARGEST_FILE bytes

TEXT = (".csv", ".txt", ".dat")


@answering
def read_matrix(path: str | Path, array: str | None = None) -> np.ndarray | scipy.sparse.csc_array:
    """Read one matrix of finite real numbers from a file.

    Args:
        path: a file that ends in .npy, .npz, .mtx, .mat, .op4, .csv, .txt, .dat or .xlsx.
        array: the name of the matrix in an .npz, .mat or .op4 file, or of the sheet of .xlsx; not needed when it holds only one.

    Returns:
        A float64 array of two dimensions, a column of an array with one; a ``scipy.sparse.csc_array`` where the file holds a sparse matrix.

    Raises:
        InputError: no such file, unknown ending, too large, cannot be read, unknown name, not a matrix of real numbers.
        MissingPackage: .op4 files need pyyeti, .xlsx openpyxl.

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
    if scipy.sparse.issparse(matrix):
        return _sparse(path, matrix)
    return real_array(matrix if np.ndim(matrix) != 1 else np.reshape(matrix, (-1, 1)), path.name, shape=(None, None))


def full_matrix(matrix, name: str) -> np.ndarray:
    """A matrix as an array, where it is not too large for one."""
    if not scipy.sparse.issparse(matrix):
        return matrix
    _check_size(name, matrix.shape)
    return matrix.toarray()


def _sparse(path: Path, matrix) -> scipy.sparse.csc_array:
    """A sparse matrix of a file, with checked indices, which SciPy leaves to the caller."""
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


#: Types of MATLAB's numbers, of dense arrays of other files "double".
_NUMBERS = ("double", "single", "sparse", "logical", *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)))


def _save_matrix(path: str, suffix: str, array: str | None, kinds: list[str], most_bytes: int, largest_side: int) -> None:
    """Write shapes and types of all arrays of a file, then the selected one: executed in a separate process."""
    import json

    import numpy as np
    import scipy.io
    import scipy.sparse

    if suffix == ".op4":
        import importlib
        import sys
        import types
        from importlib.util import find_spec

        # Without its package, which imports Matplotlib, pandas and numba first: reading takes 0.5 s instead of 2.5 s.
        package = types.ModuleType("pyyeti.nastran")
        package.__path__ = [f"{place}/nastran" for place in find_spec("pyyeti").submodule_search_locations]
        sys.modules["pyyeti.nastran"] = package
        op4 = importlib.import_module("pyyeti.nastran.op4")
        names, sizes, *_ = op4.OP4().dir(path, verbose=False)
        arrays = {name: ([int(n) for n in size], "sparse") for name, size in zip(names, sizes)}
    elif suffix == ".mat":
        arrays = {name: ([int(n) for n in shape], kind) for name, shape, kind in scipy.io.whosmat(path)}
    else:
        *shape, _, form, _, _ = scipy.io.mminfo(path)
        arrays = {"matrix": ([int(n) for n in shape], "sparse" if form == "coordinate" else "double")}
    with open("arrays.json", "w") as file:
        json.dump(arrays, file)
    numbers = [name for name, (_, kind) in arrays.items() if kind in kinds]
    name = array or (numbers[0] if len(numbers) == 1 else None)
    if name not in numbers:
        return
    shape, kind = arrays[name]
    if kind != "sparse" and 8.0 * np.prod(shape, dtype=float) > most_bytes:
        return
    if suffix == ".op4":
        sparse = True if max(shape) > largest_side else None  # None: as the file stores it
        matrix = op4.OP4().dctload(path, namelist=[name], justmatrix=True, sparse=sparse)[name]
    elif suffix == ".mat":
        matrix = scipy.io.loadmat(path, variable_names=[name])[name]
    else:
        matrix = scipy.io.mmread(path)
    if scipy.sparse.issparse(matrix):
        scipy.sparse.save_npz("matrix.npz", matrix)
    else:
        np.save("matrix.npy", matrix, allow_pickle=False)


def _read_by_process(path: Path, array: str | None, failure: str, largest: int = LARGEST_SPARSE_SIDE):
    """A matrix of a file whose reader may crash or never end on damaged ones."""
    suffix, limits = path.suffix.lower(), {"most_bytes": LARGEST_FILE, "largest_side": LARGEST_SIDE}
    with read_isolated(_save_matrix, path, failure, suffix=suffix, array=array, kinds=_NUMBERS, **limits) as folder:
        names, whole, sparse = (folder / name for name in ("arrays.json", "matrix.npy", "matrix.npz"))
        arrays = json.loads(names.read_text("utf-8")) if names.is_file() else {}
        if arrays:
            name = _chosen(path, array, [name for name, (_, kind) in arrays.items() if kind in _NUMBERS])
            shape, kind = arrays[name]
            _check_size(path.name, tuple(shape), LARGEST_SPARSE_SIDE if kind == "sparse" else largest)
            if kind != "sparse":
                _check_bytes(path, name, 8 * int(np.prod(shape, dtype=float)))
        if whole.is_file():
            return np.load(whole, allow_pickle=False)
        if sparse.is_file():
            return scipy.sparse.load_npz(sparse)
    raise damaged(path, failure)


def _from_matrix_market(path: Path, array: None):
    return _read_by_process(path, None, "not a Matrix Market file", LARGEST_SIDE)


def _from_mat(path: Path, array: str | None):
    """A variable of a MATLAB file of version 4 to 7; later ones are HDF5 files."""
    with path.open("rb") as file:
        head = file.read(128)
    if head[:8] == b"\x89HDF\r\n\x1a\n" or b"MATLAB 7.3" in head:
        raise InputError(f"{path.name}: a MATLAB file of version 7.3; write it in MATLAB with save('{path.name}', '-v7')")
    return _read_by_process(path, array, "not a MATLAB file of numbers")


def _from_op4(path: Path, array: str | None):
    """A matrix of a Nastran OUTPUT4 file, text or binary; sparse where the file stores columns as strings of entries."""
    optional_package("pyyeti", "reading .op4 files")
    return _read_by_process(path, array.lower() if array else None, "not a Nastran OUTPUT4 file")


def _from_text(path: Path, array: str | None) -> np.ndarray:
    table = number_table(path, sheet=array)
    return table.checked(*range(table.values.shape[1]))


READERS: dict[str, Callable] = {
    ".npz": _from_npz,
    ".npy": _from_npy,
    ".mtx": _from_matrix_market,
    ".mat": _from_mat,
    ".op4": _from_op4,
    **dict.fromkeys((*TEXT, *SHEETS), _from_text),
}
NAMED = (".npz", ".mat", ".op4", *SHEETS)
