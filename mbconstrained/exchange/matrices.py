"""Matrices and columns of numbers in files, read as data and never as code; sparse matrices in files stay sparse."""

from __future__ import annotations

import csv
import json
import re
import zipfile
from array import array
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import scipy

from ..ground.by_name import answering
from ..ground.checks import counted, nearest, optional_package, real_array
from ..ground.errors import InputError
from ..ground.files import LARGEST_FILE, checked_file, damaged, read_isolated, readable_as
from .universal import UNIVERSAL

# Columns of numbers in a text file: comma, semicolon, tab or blanks between them, header lines and comments above them.
# The first line of numbers decides which sign separates the columns. A decimal comma is read where the comma does not separate.

COMMENTS = ("#", "%", "!", "//")
SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", None: "blanks"}
_UNIT = re.compile(r"[(\[]([^()\[\]]+)[)\]]\s*$")


@dataclass(frozen=True, eq=False)
class NumberTable:
    """The numbers of a text file."""

    file: str  # its name, for messages
    values: np.ndarray = field(repr=False)  # shape (rows, columns); nan where an entry is empty
    lines: np.ndarray = field(repr=False)  # the line of each row in the file, shape (rows,)
    # the header and comment lines above the numbers that have an entry for each column, the last one first
    heads: tuple[tuple[str, ...], ...] = ()

    def column(self, which: int | str, key: str = "column") -> int:
        """The place of a column."""
        count = self.values.shape[1]
        if isinstance(which, int):
            if 1 <= which <= count:
                return which - 1
            raise InputError(f"{self.file}: {key}: found {which}; the file has {counted(count, 'column')}")
        for head in self.heads:
            for written in (str.strip, _folded, lambda name: _folded(without_unit(name))):
                places = [place for place, name in enumerate(head) if written(name) == written(which)]
                if len(places) == 1:
                    return places[0]
                if places:
                    numbers = " and ".join(str(place + 1) for place in places)
                    raise InputError(f'{self.file}: {key}: the columns {numbers} have the name "{which}"; give the number of one')
        if not self.heads:
            raise InputError(
                f'{self.file}: {key}: found "{which}", but no header line names its {counted(count, "column")}; give the number'
            )
        names = self.heads[-1] if len(self.heads) == 1 else [name for head in self.heads for name in head]
        raise InputError(
            f'{self.file}: {key}: there is no column "{which}"{nearest(which, names)}; the header has {", ".join(names)[:200]}'
        )

    def title(self, place: int) -> str:
        """The name of a column from 0, without its unit; an empty text where there is none."""
        return without_unit(self.heads[0][place]) if self.heads else ""

    def unit(self, place: int) -> str:
        """The text in parentheses or brackets at the end of the name of a column, e.g. "kN"; empty without any."""
        matches = (_UNIT.search(head[place]) for head in self.heads)
        return next((match[1].strip() for match in matches if match), "")

    def checked(self, *places: int) -> np.ndarray:
        """Columns whose entries are all finite numbers, shape (rows, len(places))."""
        columns = self.values[:, list(places)]
        if not np.isfinite(columns).all():
            row = int(np.argmin(np.isfinite(columns).all(axis=1)))
            raise InputError(f"{self.file}, line {self.lines[row]}: found an entry that is nan or infinite; expected numbers")
        return columns


def without_unit(name: str) -> str:
    """The name of a column without the unit behind it.

    >>> without_unit("a_x [m/s^2]"), without_unit("force")
    ('a_x', 'force')
    """
    return _UNIT.sub("", name).strip() or name.strip()


def number_table(path: Path, header: int = 0) -> NumberTable:
    """Read the columns of numbers of a text file.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "record.txt")
    ...     _ = path.write_text("time (s);force (kN)\\n0,0;1,5\\n0,1;2,5\\n")
    ...     table = number_table(path)
    >>> table.values.tolist(), table.unit(table.column("force"))
    ([[0.0, 1.5], [0.1, 2.5]], 'kN')
    """
    lines = text_of(path).splitlines()
    if header > len(lines):
        raise InputError(f"{path.name}: header: found {header}; the file has {counted(len(lines), 'line')}")
    above = [(number, line) for number, line in enumerate(lines[:header], 1) if line.strip()]
    rows = iter([(number, line) for number, line in enumerate(lines[header:], header + 1) if line.strip()])
    separator, first = ",", None
    for number, line in rows:
        if not _is_comment(line) and (separator := _separator(line)) != "":
            first = (number, line)
            break
        above.append((number, line))
    if first is None:
        raise InputError(
            f"{path.name}: found no line of numbers; expected columns of numbers between {', '.join(SEPARATORS.values())}"
        )
    numbers, places, marks = array("d"), array("q"), set[str]()
    columns = len(_numbers(first[1], separator, marks))
    for number, line in above:
        entries = _entries(line, separator)
        begins = bool(entries[0].strip()) and _number(entries[0], set()) is not None
        if number > header and begins and len(entries) == columns and not _is_comment(line):
            raise _wrong_line(path, number, line, separator, f", and header = {number} leaves out the first {number}")
    for number, line in (first, *rows):
        if _is_comment(line) or not line.strip(f" \t{separator or ''}"):
            continue
        row = _numbers(line, separator, marks)
        if row is None:
            raise _wrong_line(path, number, line, separator)
        if len(row) != columns:
            raise InputError(
                f"{path.name}, line {number}: it has another number of columns than the lines before it ({len(row)}, not {columns})"
            )
        if len(marks) > 1:
            raise InputError(
                f"{path.name}, line {number}: found {line[:40]!a}; decimals have a point or a comma, not both in one file"
            )
        numbers.extend(row)
        places.append(number)
    heads = (_head(line, separator, columns) for _, line in reversed(above))
    return NumberTable(path.name, np.array(numbers).reshape(-1, columns), np.array(places), tuple(head for head in heads if head))


def text_of(path: Path) -> str:
    """The text of a file: UTF-8, UTF-16 with its mark, or Latin-1, which older instruments write; no NUL characters."""
    content = path.read_bytes()
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        encodings = ["utf-16"]
    else:
        encodings = ["utf-8-sig", "latin-1"]
    for encoding in encodings:
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise InputError(f"{path.name}: not a text file; expected lines of numbers")


def _separator(line: str) -> str | None:
    """The separator of the numbers of a line; an empty text where it is no line of numbers."""
    for separator in SEPARATORS:
        if (separator is None or separator in line) and _numbers(line, separator, set()):
            return separator
    return ""


def _numbers(line: str, separator: str | None, marks: set[str]) -> list[float] | None:
    """The numbers of a line, nan for an empty entry; None where an entry is something else. Decimal marks are added to ``marks``."""
    numbers = [_number(entry, marks) for entry in _entries(line, separator)]
    return None if None in numbers or (all(number != number for number in numbers) and "nan" not in line.lower()) else numbers


def _number(entry: str, marks: set[str]) -> float | None:
    entry = entry.strip(' "')
    if not entry:
        return np.nan
    if "," in entry and "." not in entry:
        marks.add(",")
        entry = entry.replace(",", ".")
    elif "." in entry:
        marks.add(".")
    try:
        return float(entry) if "_" not in entry else None
    except ValueError:
        fortran = re.fullmatch(r"([+-]?[\d.]+)[dD]([+-]?\d+)", entry)
        return float(f"{fortran[1]}e{fortran[2]}") if fortran and entry.count(".") <= 1 else None


def _entries(line: str, separator: str | None) -> list[str]:
    """The entries of a line; one empty entry at its end is left out, as a sign that ends every line leaves it."""
    if separator is None:
        return line.split()
    entries = line.strip(" \r\n").split(separator)
    return entries[:-1] if len(entries) > 1 and not entries[-1].strip() else entries


def _head(line: str, separator: str | None, columns: int) -> tuple[str, ...]:
    """The names in a header line; none where it has not one for each column."""
    line = line.strip().lstrip("#%!/ ") if _is_comment(line) else line.strip()
    if separator is None:
        options = [line.split(), re.split(r"\s*[,;\t]\s*|\s{2,}", line)]
    else:
        options = [next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]
    names = next((names for names in options if len(names) == columns), [])
    return tuple(name.strip() for name in names) if any(name.strip() for name in names) else ()


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith(COMMENTS)


def _folded(name: str) -> str:
    return " ".join(name.casefold().split())


def _wrong_line(path: Path, number: int, line: str, separator: str | None, more: str = "") -> InputError:
    return InputError(
        f"{path.name}, line {number}: found {line[:40]!a}; expected numbers separated by {SEPARATORS[separator]}; "
        f"a line that begins with # is left out{more}"
    )


# Matrices in files.
# NumPy .npy and .npz, scipy.sparse .npz, Matrix Market .mtx, MATLAB .mat, Nastran OUTPUT4 .op4, and text with columns of numbers.

LARGEST_SIDE = 5000  # rows or columns of an array: 200 MB as float64
LARGEST_SPARSE_SIDE = 5_000_000  # of a sparse matrix, whose file has at most LARGEST_FILE bytes

TEXT = (".csv", ".txt", ".dat")


@answering
def read_matrix(path: str | Path, array: str | None = None) -> np.ndarray | scipy.sparse.csc_array:
    """Read one matrix of finite real numbers from a file.

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
