"""Exports of responses to other programs: labelled tables of xarray and pandas, trajectories with units, files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ..ground.checks import optional_package, real_array
from ..ground.coordinate_units import DERIVATIVES, derivative_name, rate_unit
from ..ground.errors import InputError
from .trajectories import Curves, checked_kinds, write_trajectories
from .universal import Geometry

#: Kinds of trajectories: x, x', x''.
RATES = DERIVATIVES[:3]


class ExportedSystem:
    """Conversions of a mechanical system: functions of ``control.descriptor_form``, set by ``mbconstrained/__init__.py``."""

    to_state_space: ClassVar[Callable[..., Any]]
    to_dict: ClassVar[Callable[..., dict]]


class Exported:
    """A function of time with names, perhaps units, jumps, impulses and events: the base of ``Response``."""

    initial: Any
    jump: Any
    impulses: Any
    events: Any
    derivative: Any

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
        for kind in checked_kinds(kinds, self.kinds):
            order, whole = RATES.index(kind), _whole(self)
            titles = tuple(derivative_name(units.get(name, ""), order) for name in names)
            rates = tuple(rate_unit(units[name], order) if name in units else "" for name in names)
            curves.append(Curves(kind, names, titles, rates, whole.derivative(order)(times) if order else whole(times)))
        return tuple(curves)

    #: Kinds that ``trajectories`` and ``write`` accept.
    kinds: ClassVar[tuple[str, ...]] = RATES

    def start_arrays(self) -> dict[str, np.ndarray]:
        """Arrays by name: initial and jump (q, r), impulses (P, r); event_times (E,), event_jumps, event_impulses where there are."""
        return {"initial": self.initial, **_arrays_of_jumps(self.jump, self.impulses, self.events)}

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
        return write_trajectories(path, times, curves, self.start_arrays(), excel=excel, geometry=geometry, binary=binary)


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
