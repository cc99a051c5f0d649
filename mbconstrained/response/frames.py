"""A response at given times as an xarray ``DataArray`` or a pandas ``DataFrame``, with names, units, jumps and impulses."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..checks import optional_package, real_array
from ..errors import InputError

if TYPE_CHECKING:
    from .response import Response


def to_xarray(x: Response, times):
    """x at times (T,) as a ``DataArray`` with the dimensions time (s) and coordinate; of a state space the outputs too.

    Its coordinate "unit" gives the unit of each entry, where units are known. Its attributes are arrays with an entry for each
    coordinate: jump_0, jump_1, ... of x, x', ... at t = 0 and impulse_0, impulse_1, ..., the factors of Dirac's delta and its
    derivatives there; event_times are the times of the later events.

    Raises:
        InputError: times that are not a list of numbers, negative or not finite.
        MissingPackage: xarray is not installed.
    """
    xarray = optional_package("xarray", "to_xarray")
    times, names, values, units = _curves(x, times)
    coords = {"time": ("time", times, {"units": "s"}), "coordinate": list(names)}
    if units:
        coords["unit"] = ("coordinate", [units[name] for name in names])
    attributes = {"long_name": "regular part of x"}
    if units and len({units[name] for name in names}) == 1:
        attributes["units"] = units[names[0]]
    return xarray.DataArray(values.T, coords, ("time", "coordinate"), "x", {**attributes, **_happenings(x)})


def to_pandas(x: Response, times):
    """x at times (T,) as a ``DataFrame``: the index is the time in s, a column for each coordinate, of a state space outputs too.

    ``.attrs`` has the units by name (where they are known), and the same jumps and impulses as ``to_xarray``, as dictionaries.

    Raises:
        InputError: times that are not a list of numbers, negative or not finite.
        MissingPackage: pandas is not installed.
    """
    pandas = optional_package("pandas", "to_pandas")
    times, names, values, units = _curves(x, times)
    frame = pandas.DataFrame(values.T, pandas.Index(times, name="time"), pandas.Index(names, name="coordinate"))
    frame.attrs = {"units": {"time": "s", **{name: units[name] for name in names if name in units}}}
    for key, values in _happenings(x).items():
        frame.attrs[key] = values.tolist() if key == "event_times" else dict(zip(names, values.tolist()))
    return frame


def _curves(x: Response, times) -> tuple[np.ndarray, tuple[str, ...], np.ndarray, dict[str, str]]:
    """Times, names, values and units; those are known to the system that a response is of, if there is one."""
    times = real_array(times, "times")
    if times.ndim != 1:
        raise InputError(f"times: found {'one number' if times.ndim == 0 else 'a table'}; expected a list of numbers")
    units, whole = getattr(getattr(x, "system", None), "units", {}), _whole(x)
    return times, whole.polynomial_matrix.coordinates, whole(times), units


def _whole(x: Response) -> Response:
    """States and outputs together where x has outputs."""
    return getattr(x, "together", x)


def _happenings(x: Response) -> dict[str, np.ndarray]:
    x = _whole(x)
    found = {f"jump_{order}": row.copy() for order, row in enumerate(x.jump)}
    found |= {f"impulse_{order}": row.copy() for order, row in enumerate(x.impulses)}
    return found | ({"event_times": np.array([event.time for event in x.events])} if x.events else {})
