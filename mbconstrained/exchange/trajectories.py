"""Trajectories with names and units, and the files that they are written to: CSV, npz, MATLAB, netCDF, Zarr, universal files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ..ground.checks import nearest, optional_package, real_array
from ..ground.errors import InputError
from ..ground.files import Replacements
from ..ground.units import DERIVATIVES, derivative_name, rate_unit
from .universal import UNIVERSAL, Geometry, write_functions


@dataclass(frozen=True, eq=False)
class Curves:
    """Values of one kind over time."""

    kind: str  # "displacement", "velocity", "acceleration", "reaction", "energy" or "output"
    # of the rows; a title names the quantity, e.g. "angle". An unknown unit is an empty text
    names: tuple[str, ...]
    titles: tuple[str, ...]
    units: tuple[str, ...]
    values: np.ndarray  # shape (rows, T)

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


# Exports of responses to other programs: labelled tables of xarray and pandas, trajectories with units, files.

#: Kinds of trajectories: x, x', x''.
RATES = DERIVATIVES[:3]


class Exported:
    """A function of time with names, perhaps units, jumps, impulses and events: the base of ``Response``."""

    initial: Any
    jump: Any
    impulses: Any
    events: Any
    derivative: Any

    @property
    def _later_events(self) -> Any:
        """Jumps and impulses of the coordinates after t = 0."""
        return self.events

    def to_xarray(self, times):
        """x at times (T,) as a ``DataArray`` with the dimensions time (s) and coordinate; of a state space the outputs too.

        Its coordinate "unit" gives the unit of each entry, where units are known. Its attributes are arrays with an entry for each
        coordinate: jump_0, jump_1, ... of x, x', ... at t = 0 and impulse_0, impulse_1, ..., the factors of Dirac's delta and its
        derivatives there; event_times are the times of the later events.

        Raises:
            InputError: times that are not a list of numbers, negative or not finite.
            MissingPackage: xarray is not installed.
        """
        xarray = optional_package("xarray", "to_xarray")
        times, names, values, units = _curves(self, times)
        coords = {"time": ("time", times, {"units": "s"}), "coordinate": list(names)}
        if units:
            coords["unit"] = ("coordinate", [units[name] for name in names])
        attributes = {"long_name": "regular part of x"}
        if units and len({units[name] for name in names}) == 1:
            attributes["units"] = units[names[0]]
        return xarray.DataArray(values.T, coords, ("time", "coordinate"), "x", {**attributes, **_jumps_and_impulses(self)})

    def to_pandas(self, times):
        """x at times (T,) as a ``DataFrame``: the index is the time in s, a column for each coordinate, of a state space outputs too.

        ``.attrs`` has the units by name (where they are known), and the same jumps and impulses as ``to_xarray``, as dictionaries.

        Raises:
            InputError: times that are not a list of numbers, negative or not finite.
            MissingPackage: pandas is not installed.
        """
        pandas = optional_package("pandas", "to_pandas")
        times, names, values, units = _curves(self, times)
        frame = pandas.DataFrame(values.T, pandas.Index(times, name="time"), pandas.Index(names, name="coordinate"))
        frame.attrs = {"units": {"time": "s", **{name: units[name] for name in names if name in units}}}
        for key, values in _jumps_and_impulses(self).items():
            frame.attrs[key] = values.tolist() if key == "event_times" else dict(zip(names, values.tolist()))
        return frame

    def trajectories(self, times, kinds: Sequence[str] = RATES[:1]) -> tuple[Curves, ...]:
        """x and its derivatives at times (T,) with names and units, of a state space with the outputs.

        Args:
            times: in s, a list of numbers.
            kinds: "displacement" (x), "velocity" (x'), "acceleration" (x''); of a ``Motion`` also "reaction".

        Returns:
            Values of each kind.

        Raises:
            InputError: an unknown kind; times that are not a list of numbers, negative or not finite.
        """
        times, names, _, units = _curves(self, times, empty=True)
        curves = []
        for kind in checked_kinds(kinds, self._kinds):
            order, whole = RATES.index(kind), _whole(self)
            titles = tuple(derivative_name(units.get(name, ""), order) for name in names)
            rates = tuple(rate_unit(units[name], order) if name in units else "" for name in names)
            curves.append(Curves(kind, names, titles, rates, whole.derivative(order)(times) if order else whole(times)))
        return tuple(curves)

    #: Kinds that ``trajectories`` and ``write`` accept.
    _kinds: ClassVar[tuple[str, ...]] = RATES

    def _start_arrays(self) -> dict[str, np.ndarray]:
        """Arrays by name: initial and jump (q, r), impulses (P, r); event_times (E,), event_jumps, event_impulses where there are."""
        return {"initial": self.initial, **_arrays_of_jumps(self.jump, self.impulses, self._later_events)}

    def write(
        self,
        path: str | Path,
        times,
        kinds: Sequence[str] = RATES[:1],
        *,
        excel: bool = False,
        geometry: Geometry | None = None,
        binary: bool = True,
    ) -> Path:
        """Write values at times (T,) in the format that the ending of the path names; jumps and impulses are added where it has them.

        Args:
            path: path of the file: .csv, .npz, .mat (MATLAB), .nc (netCDF 3), .zarr, or .uff, .unv (universal file).
            times: in s, a list of numbers.
            kinds: as in ``trajectories``.
            excel: semicolons and decimal commas in .csv files.
            geometry: geometry of universal files, an ``mbconstrained.Geometry``: nodes, directions and points of the coordinates.
            binary: whether functions of universal files are binary, which keeps every bit; False for text.

        Returns:
            The path.

        Raises:
            InputError: another ending, an unknown kind, an option of another format, wrong times.
            MissingPackage: xarray for .nc, xarray and zarr for .zarr, pyuff for universal files.
        """
        curves = self.trajectories(times, kinds)
        times = real_array(times, "times", shape=(None,))
        return write_trajectories(path, times, curves, self._start_arrays(), excel=excel, geometry=geometry, binary=binary)


def _curves(x, times, empty: bool = False) -> tuple[np.ndarray, tuple[str, ...], np.ndarray, dict[str, str]]:
    """Times, names, values and units; those are known to the system that a response is of, if there is one."""
    times = real_array(times, "times")
    if times.ndim != 1:
        raise InputError(f"times: found {'one number' if times.ndim == 0 else 'a table'}; expected a list of numbers")
    units, whole = getattr(getattr(x, "system", None), "units", {}), _whole(x)
    return times, whole.polynomial_matrix.coordinates, None if empty else whole(times), units


def _whole(x):
    """States and outputs together where x has outputs."""
    return getattr(x, "together", x)


def _jumps_and_impulses(x) -> dict[str, np.ndarray]:
    x = _whole(x)
    attributes = {f"jump_{order}": row.copy() for order, row in enumerate(x.jump)}
    attributes |= {f"impulse_{order}": row.copy() for order, row in enumerate(x.impulses)}
    return attributes | ({"event_times": np.array([event.time for event in x.events])} if x.events else {})


def _arrays_of_jumps(jump: np.ndarray, impulses: Sequence[np.ndarray], events: Sequence) -> dict[str, np.ndarray]:
    """Jumps and impulses as arrays by name, for files."""
    size = jump.shape[1]
    arrays = {"jump": jump, "impulses": np.reshape(impulses, (len(impulses), size))}
    if not events:
        return arrays
    later = np.zeros((len(events), max(len(event.impulses) for event in events), size))
    for row, event in zip(later, events):
        row[: len(event.impulses)] = np.reshape(event.impulses, (-1, size))
    times, jumps = np.array([event.time for event in events]), np.array([event.jump for event in events])
    return {**arrays, "event_times": times, "event_jumps": jumps, "event_impulses": later}
