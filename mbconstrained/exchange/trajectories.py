"""Trajectories with names and units, and the files that they are written to: CSV, npz, MATLAB, netCDF, Zarr, universal files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..ground.checks import nearest, optional_package
from ..ground.errors import InputError
from ..ground.files import Replacements
from .universal import UNIVERSAL, Geometry, write_functions


@dataclass(frozen=True, eq=False)
class Curves:
    """Values of one kind over time.

    Attributes:
        kind: "displacement", "velocity", "acceleration", "reaction", "energy" or "output".
        names, titles, units: of the rows; a title names the quantity, e.g. "angle". An unknown unit is an empty text.
        values: shape (rows, T).
    """

    kind: str
    names: tuple[str, ...]
    titles: tuple[str, ...]
    units: tuple[str, ...]
    values: np.ndarray

    @property
    def heads(self) -> list[str]:
        """Name, title and unit of each row."""
        units = (f" ({unit})" if unit else "" for unit in self.units)
        return [f"{name} {title}{unit}" for name, title, unit in zip(self.names, self.titles, units)]


def checked_kinds(kinds: Sequence[str], known: Sequence[str]) -> list[str]:
    """The names of kinds, each once; an InputError for others.

    >>> checked_kinds("velocity", ("displacement", "velocity"))
    ['velocity']
    """
    chosen = [kinds] if isinstance(kinds, str) else list(kinds)
    for kind in chosen:
        if kind not in known:
            raise InputError(f"kinds: found {kind!r}{nearest(str(kind), known)}; expected some of {', '.join(known)}")
    return list(dict.fromkeys(chosen))


#: The endings of files of trajectories.
ENDINGS = (".csv", ".npz", ".mat", ".nc", ".zarr", *UNIVERSAL)


def write_trajectories(
    path: str | Path,
    times: np.ndarray,
    curves: Sequence[Curves],
    arrays: Mapping[str, np.ndarray] | None = None,
    *,
    excel: bool = False,
    geometry: Geometry | None = None,
    binary: bool = True,
    files: Replacements | None = None,
) -> Path:
    """Write trajectories; the ending of the file chooses the format. Every format but text of universal files keeps every bit.

    >>> import tempfile
    >>> curves = Curves("displacement", ("cart",), ("displacement",), ("m",), np.array([[0.5, 0.25]]))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     print(write_trajectories(Path(folder, "run.csv"), np.array([0.0, 1.0]), [curves]).read_text())
    time (s),cart displacement (m)
    0,0.5
    1,0.25
    <BLANKLINE>
    """
    path = Path(path)
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise InputError(f"{path.name}: expected a file that ends in {', '.join(ENDINGS)}{nearest(ending, ENDINGS)}")
    if excel and ending != ".csv":
        raise InputError(f"{path.name}: excel is an option of .csv files; leave it out")
    if (geometry or not binary) and ending not in UNIVERSAL:
        raise InputError(
            f"{path.name}: geometry and binary are options of universal files ({', '.join(UNIVERSAL)}); leave them out"
        )
    path.parent.mkdir(parents=True, exist_ok=True)
    with nullcontext(files) if files is not None else Replacements() as files:
        place = files.temporary(path, ".zgroup" if ending == ".zarr" else "")
        if ending == ".csv":
            write_csv(place, times, curves, excel)
        elif ending in (".nc", ".zarr"):
            _write_dataset(place, dataset_of(times, curves, arrays), ending)
        elif ending in UNIVERSAL:
            write_functions(place, times, curves, geometry or Geometry(), path.stem, binary)
        else:
            write_arrays(place, {**arrays_of(times, curves), **(arrays or {})}, ending)
    return path


def _write_dataset(path: Path, dataset, ending: str) -> None:
    if ending == ".nc":
        dataset.to_netcdf(path, engine="scipy")
        return
    optional_package("zarr", "Zarr")
    dataset.to_zarr(path, mode="w", zarr_format=2)  # version 3 has no standard for texts yet


def csv_of(columns: Mapping[str, Any]) -> str:
    """A CSV text with a line of heads; commas and line breaks in texts are replaced.

    >>> csv_of({"f (Hz)": np.array([1.0]), "a, b": ["x"]})
    'f (Hz),a; b\\n1.0,x\\n'
    """
    lines: list[Iterable[str]] = [map(_cell, columns)]
    for row in zip(*(np.asarray(column).tolist() for column in columns.values())):
        lines.append(_cell(cell) if isinstance(cell, str) else repr(cell) for cell in row)
    return "\n".join(map(",".join, lines)) + "\n"


def _cell(text: str) -> str:
    return text.replace(",", ";").replace("\n", " ")


def write_csv(path: Path, times: np.ndarray, curves: Sequence[Curves], excel: bool = False) -> None:
    """Write one line for each time: time, then every curve, headed by name and unit, with 17 digits."""
    columns = np.vstack([times, *(block.values for block in curves)])
    heads = ["time (s)", *(head for block in curves for head in block.heads)]
    separator = ";" if excel else ","
    quoted = [f'"{head}"' if separator in head else head for head in heads]
    with open(path, "w", encoding="utf-8-sig" if excel else "utf-8", newline="\n") as file:
        file.write(separator.join(quoted) + "\n")
        for row in columns.T.tolist():
            line = separator.join([f"{value:.17g}" for value in row])
            file.write((line.replace(".", ",") if excel else line) + "\n")


def arrays_of(times: np.ndarray, curves: Sequence[Curves]) -> dict[str, np.ndarray]:
    """The times, and of each kind the values, names and units."""
    arrays = {"times": times}
    for block in curves:
        arrays |= {
            block.kind: block.values,
            f"{block.kind}_names": np.array(block.names),
            f"{block.kind}_units": np.array(block.units),
        }
    return arrays


def write_arrays(path: Path, arrays: Mapping[str, np.ndarray], ending: str) -> None:
    """Write arrays by name, readable without pickle."""
    with open(path, "wb") as file:  # by its name alone, np.savez would put .npz behind it
        if ending == ".npz":
            np.savez(file, **arrays)  # type: ignore[arg-type]
            return
        import scipy.io

        cells = {name: array.astype(object) if array.dtype.kind == "U" else array for name, array in arrays.items()}
        scipy.io.savemat(file, cells, long_field_names=True, do_compression=True)


def dataset_of(times: np.ndarray, curves: Sequence[Curves], arrays: Mapping[str, np.ndarray] | None = None):
    """An ``xarray.Dataset``: for each kind an array over time and name, with the units as a coordinate."""
    xarray = optional_package("xarray", "netCDF and Zarr")
    coords: dict[str, object] = {"time": ("time", times, {"units": "s"})}
    variables: dict[str, object] = {}
    for block in curves:
        rows = f"{block.kind}_name"
        variables[block.kind] = (("time", rows), block.values.T)
        coords |= {rows: list(block.names), f"{block.kind}_unit": (rows, list(block.units))}
    for name, array in (arrays or {}).items():
        if array.size:
            variables[name] = (tuple(f"{name}_{axis}" for axis in range(array.ndim)), array)
    return xarray.Dataset(variables, coords, {"source": "mbconstrained"})
