"""Universal files (UFF) through pyuff: functions of time and of frequency, and modes, with header, units and, where points are given, geometry.

Data sets 151 (header) and 164 (units: SI) come first, then 15 (nodes) and 82 (lines), then 58 (functions) or 55 (modes). pyuff writes
the fields of fixed width that the format defines: 6 digits of mode shapes and of the times of functions in text, 12 of their values.
Binary functions keep every bit.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

import numpy as np

from ..ground.by_name import Public
from ..ground.checks import nearest, optional_package
from ..ground.errors import InputError, shown
from ..ground.files import damaged, read_isolated
from ..ground.quantities import any_quantity, meant, unit_name

UNIVERSAL = (".uff", ".unv", ".uf", ".bunv")

#: Specific data types: code, then for translations and for rotations the unit and its exponents of length and force.
_DATA_TYPES = {
    8: (("m", 1, 0), ("rad", 0, 0)),
    11: (("m/s", 1, 0), ("rad/s", 0, 0)),
    12: (("m/s^2", 1, 0), ("rad/s^2", 0, 0)),
    9: (("N", 0, 1), ("N*m", 1, 1)),
    13: (("N", 0, 1), ("N*m", 1, 1)),
}
_TIME, _TIME_RESPONSE, _FREQUENCY, _FREQUENCY_RESPONSE, _REACTION = 17, 1, 18, 4, 9
_DIRECTIONS = ("", "X", "Y", "Z", "RX", "RY", "RZ")
LONGEST_ID = 80

#: Units whose sizes differ by less are the same: factors of data set 164 may be single numbers.
SAME_UNIT = 1e-5


@dataclass(frozen=True, eq=False)
class Function:
    """A function of time of a universal file."""

    name: str  # its first line of identification
    # shape (T,), in s and in the unit
    times: np.ndarray = field(repr=False)
    values: np.ndarray = field(repr=False)
    unit: str  # in SI; the label of its axis where the file does not state the kind of quantity
    is_scaled: bool  # whether the values are in SI
    notes: tuple[str, ...] = ()  # where the label of its axis is another unit


def read_function(path: Path, which: int | str | None = None) -> Function:
    """A function of time (data set 58, text or binary) of a universal file, converted to SI by the factors of data set 164."""
    functions, units = [], {"length": 1.0, "force": 1.0}
    for dataset in _datasets(path):
        if dataset["type"] == 164:
            units = dataset
        else:
            functions.append((dataset, units))
    names = [str(dataset["id1"]).strip() for dataset, _ in functions]
    if not functions:
        raise InputError(f"{path.name}: found no function of time (data set 58 of function type 1)")
    if which is None and len(functions) > 1:
        listed = ", ".join(f"{number} {name}" for number, name in enumerate(names[:8], 1))
        raise InputError(f"{path.name}: column: the file has {len(functions)} functions; give the number or name of one: {listed}")
    if isinstance(which, bool) or not isinstance(which, (str, int, type(None))):
        raise InputError(f"{path.name}: column: found {shown(which)}; expected the number or the name of a function")
    if isinstance(which, str):
        if names.count(which.strip()) != 1:
            problem = "several functions have" if which.strip() in names else "there is no function of"
            raise InputError(f'{path.name}: column: {problem} the name "{which}"{nearest(which, names)}; give the number of one')
        place = names.index(which.strip())
    else:
        place = 0 if which is None else which - 1
    if not 0 <= place < len(functions):
        raise InputError(f"{path.name}: column: found {which}; the file has {len(functions)} functions of time, numbered from 1")
    return _function(path, names[place], *functions[place])


def _function(path: Path, name: str, dataset: Mapping, units: Mapping) -> Function:
    times, values = dataset["x"], dataset["data"]
    if np.iscomplexobj(values):
        raise InputError(f'{path.name}: the function "{name}" is complex; expected real values over time')
    if len(values) != dataset["num_pts"] or len(times) != len(values):
        raise InputError(f'{path.name}: the function "{name}" has {len(values)} values of the {dataset["num_pts"]} that it states')
    if not (np.isfinite(values).all() and np.isfinite(times).all()):
        raise InputError(f'{path.name}: the function "{name}" has a value that is nan or infinite; expected numbers')
    kinds = _DATA_TYPES.get(int(dataset["ordinate_spec_data_type"]), (("", 0, 0), ("", 0, 0)))
    unit, length, force = kinds[abs(int(dataset["rsp_dir"])) > 3]
    scale = units["length"] ** length * units["force"] ** force
    if not 0 < scale < np.inf:
        raise InputError(f"{path.name}: the factors of its units (data set 164) are not positive numbers")
    label = dataset["ordinate_axis_units_lab"].strip()
    if not unit:
        return Function(name, times, values, "" if label == "NONE" else label, False)
    with suppress(InputError):  # of labels that are no units
        written = meant(unit_name(label), unit)
        if written != "1" and abs(any_quantity(f"1 {written}")[0] * scale - 1) > SAME_UNIT:
            read_as = unit if scale == 1 else f"{1 / scale:.6g} {unit}"
            note = f'the axis is labelled "{label}", but {read_as} is its unit by data set 164, SI without one; give a factor if the label is right'
            return Function(name, times, values / scale, unit, True, (note,))
    return Function(name, times, values if scale == 1 else values / scale, unit, True)


def _save_datasets(path: str, function_type: int) -> None:
    """Write the functions of one type and the units of a universal file: executed in a separate process."""
    import json

    import numpy as np
    import pyuff

    file = pyuff.UFF(path)
    datasets: list[dict] = []
    kinds = [int(kind) for kind in file.get_set_types()]
    if not any(kinds):
        raise ValueError("no data sets between lines of -1")
    for place, kind in enumerate(kinds):
        if kind == 164:
            units = file.read_sets(place)
            datasets.append({"type": kind, "length": float(units["length"]), "force": float(units["force"])})
        elif kind == 58:
            function = file.read_sets(place)
            if function.get("func_type") != function_type:
                continue
            x, data = np.asarray(function["x"]), np.asarray(function["data"])
            np.savez(
                f"{len(datasets)}.npz", x=x[: data.size + 1], data=data
            )  # x has as many entries as the file states, perhaps billions
            numbers = {key: int(function[key]) for key in ("num_pts", "ordinate_spec_data_type", "rsp_dir")}
            label = str(function.get("ordinate_axis_units_lab", ""))
            datasets.append({"type": kind, "id1": str(function["id1"]), "ordinate_axis_units_lab": label, **numbers})
    with open("datasets.json", "w") as text:
        json.dump(datasets, text)


def _datasets(path: Path) -> list[dict]:
    """The functions of time and the units of a file, in its order."""
    optional_package("pyuff", "reading universal files")
    failure = "not a universal file that can be read"
    with read_isolated(_save_datasets, path, failure, function_type=_TIME_RESPONSE) as folder:
        if not (whole := folder / "datasets.json").is_file():
            raise damaged(path, failure)
        datasets = json.loads(whole.read_text("utf-8"))
        for place, dataset in enumerate(datasets):
            if dataset["type"] == 58:
                with np.load(folder / f"{place}.npz", allow_pickle=False) as arrays:
                    dataset |= arrays
    return datasets


@dataclass(frozen=True)
class Geometry(Public):
    """Geometry of a model in a universal file: nodes and directions of its coordinates.

    Args:
        places: a node number and a direction ("X", "-Y", "Z", "RX", ...) for each coordinate by name. By default each coordinate is
            a separate node, numbered from 1, in the direction X, or RX of an angle.
        points: x, y, z in m by node number; written as data set 15.
        lines: sequences of node numbers; written as data set 82.

    Raises:
        InputError: a direction or a node number that does not exist.

    >>> Geometry({"tip": (2, "-Z")}, points={1: (0, 0, 0), 2: (1, 0, 0)}, lines=[[1, 2]]).place("tip", 0, "m")
    (2, -3)
    """

    places: Mapping[str, tuple[int, str]] = field(default_factory=dict)
    points: Mapping[int, Sequence[float]] = field(default_factory=dict)
    lines: Sequence[Sequence[int]] = ()

    def __post_init__(self):
        for name, place in self.places.items():
            if not (isinstance(place, Sequence) and len(place) == 2 and str(place[1]).lstrip("+-") in _DIRECTIONS[1:]):
                raise InputError(f"places: found {place!r} of {name}; expected a node and a direction, e.g. (1, 'X') or (2, '-RZ')")
        numbers = [*self.points, *(place[0] for place in self.places.values()), *(node for line in self.lines for node in line)]
        for number in numbers:
            if not isinstance(number, int) or number < 1:
                raise InputError(f"found the node {number!r}; nodes are whole numbers from 1")
        for node, point in self.points.items():
            if np.shape(point) != (3,) or not np.isfinite(np.asarray(point, dtype=float)).all():
                raise InputError(f"points: found {point!r} of the node {node}; expected x, y, z in m")
        for node in (node for line in self.lines for node in line if node not in self.points):
            raise InputError(f"lines: the node {node} has no point; give it in points")

    def place(self, name: str, index: int, unit: str) -> tuple[int, int]:
        """Node number and code of the direction of a coordinate.

        Args:
            name: name of the coordinate.
            index: from 0.
            unit: unit of its displacement.

        Returns:
            The node and 1 to 6, negative for a negative direction.
        """
        node, direction = self.places.get(name, (index + 1, "RX" if unit == "rad" else "X"))
        return node, (-1 if direction.startswith("-") else 1) * _DIRECTIONS.index(direction.lstrip("+-"))

    def datasets(self) -> list[dict]:
        """Data sets 15 and 82."""
        datasets: list[dict] = []
        if self.points:
            x, y, z = np.array([self.points[node] for node in self.points], dtype=float).T
            ones = [1] * len(x)
            nodes = list(self.points)
            datasets.append(
                {"type": 15, "node_nums": nodes, "def_cs": ones, "disp_cs": ones, "color": ones, "x": x, "y": y, "z": z}
            )
        for number, line in enumerate(self.lines, 1):
            datasets.append({"type": 82, "trace_num": number, "n_nodes": len(line), "color": 1, "id": f"line {number}"})
            datasets[-1]["nodes"] = np.array(line)
        return datasets


def write_functions(path: Path, times: np.ndarray, curves, geometry: Geometry, title: str, binary: bool = True) -> None:
    """Write functions of time as data sets 58."""
    kinds = {"displacement": 8, "velocity": 11, "acceleration": 12, "reaction": 9}
    if len(times) < 2:
        raise InputError("times: found one; a function of a universal file needs at least two")
    datasets = [
        _function_dataset(
            _TIME_RESPONSE, (_TIME, "Time", "s"), times, values, binary, f"{name} {block.kind}", title, block.kind, unit
        )
        | {"ordinate_spec_data_type": kinds.get(block.kind, 0)}
        | dict(zip(("rsp_node", "rsp_dir"), geometry.place(name, index, "rad" if _rotates(unit) else "m")))
        for block in curves
        for index, (name, unit, values) in enumerate(zip(block.names, block.units, block.values))
    ]
    _write(path, [*_headers(title), *geometry.datasets(), *datasets])


def _rotates(unit: str) -> bool:
    return unit.startswith("rad") or unit in ("N m", "N*m")


def _function_dataset(
    kind: int, abscissa: tuple[int, str, str], x, values, binary: bool, name: str, title: str, what: str, unit: str
) -> dict:
    """A data set 58, without the point and direction of an input."""
    return {
        "type": 58, "func_type": kind, "binary": int(binary), "id1": _line(name), "id2": _line(title), "ref_node": 0, "ref_dir": 0,
        "x": x, "data": np.ascontiguousarray(values), "abscissa_spacing": 0, "abscissa_spec_data_type": abscissa[0],
        "orddenom_spec_data_type": 0, "abscissa_axis_lab": abscissa[1], "abscissa_axis_units_lab": abscissa[2],
        "ordinate_axis_lab": what.capitalize()[:20], "ordinate_axis_units_lab": unit[:20],
    }  # fmt: skip


def write_frequency_responses(path: Path, response, geometry: Geometry, title: str, binary: bool = True) -> None:
    """Write the data of a ``FrequencyResponse`` as data sets 58 of function type 4, one for each output and input."""
    datasets = [*_headers(title), *geometry.datasets()]
    if len(response.frequencies_hz) < 2:
        raise InputError("frequencies_hz: found one; a function of a universal file needs at least two")
    codes = {unit: code for code, units in _DATA_TYPES.items() for unit, _, _ in units if code != _REACTION}
    for (i, output), (j, input) in product(enumerate(response.outputs), enumerate(response.inputs)):
        unit, H = str(response.units[i, j]), response.values[i, j]
        above, _, below = unit.partition("/(") if "/(" in unit else unit.rpartition("/")
        above, below = above.replace("N m", "N*m"), below.removesuffix(")").replace("N m", "N*m")
        node, direction = geometry.place(output, i, "rad" if _rotates(above) else "m")
        reference, along = geometry.place(input, j, "rad" if _rotates(below) else "m")
        name, abscissa = f"{output} by {input} {response.quantity}", (_FREQUENCY, "Frequency", "Hz")
        own = _function_dataset(
            _FREQUENCY_RESPONSE, abscissa, response.frequencies_hz, H, binary, name, title, response.quantity, unit
        )
        own |= {"rsp_node": node, "rsp_dir": direction, "ref_node": reference, "ref_dir": along}
        datasets.append(own | {"ordinate_spec_data_type": codes.get(above, 0), "orddenom_spec_data_type": codes.get(below, 0)})
    _write(path, datasets)


def write_modes(path: Path, modes, names: Sequence[str], units: Sequence[str], geometry: Geometry, title: str) -> None:
    """Write modes as data sets 55: normal modes where a shape and its frequency are real, complex eigenvalues otherwise."""
    places = [geometry.place(name, index, unit) for index, (name, unit) in enumerate(zip(names, units))]
    nodes = list(dict.fromkeys(node for node, _ in places))
    datasets = [*_headers(title), *geometry.datasets()]
    for number, (eigenvalue, shape) in enumerate(modes, 1):
        values = np.zeros((6, len(nodes)), dtype=shape.dtype)
        for (node, direction), entry in zip(places, shape):
            values[abs(direction) - 1, nodes.index(node)] += entry * np.sign(direction)
        is_complex, rotates = np.iscomplexobj(shape), bool(values[3:].any())
        common = {
            "type": 55, "id1": _line(title), "id2": f"mode {number}", "model_type": 1, "spec_data_type": 8, "load_case": 1,
            "mode_n": number, "node_nums": nodes, "id4": _line(f"eigenvalue {complex(eigenvalue)!r} 1/s"),
        }  # fmt: skip
        size = abs(eigenvalue)
        kind = {"analysis_type": 3, "eig": eigenvalue} if is_complex else {"analysis_type": 2, "freq": size / (2 * np.pi)}
        if not is_complex:
            kind["modal_damp_vis"] = -eigenvalue.real / size if size else 0.0
        parts = 6 if rotates and not is_complex else 3
        if rotates and is_complex:
            raise InputError(
                f"mode {number}: universal files hold complex shapes of translations only; write angles in .mat or .npz"
            )
        shapes = {f"r{k + 1}": values[k] for k in range(parts)}
        datasets.append({**common, **kind, "data_ch": 3 if parts == 6 else 2, **shapes})
    _write(path, datasets)


def _headers(title: str) -> list[dict]:
    """Data sets 151 and 164."""
    program = "mbconstrained"
    header = {"type": 151, "model_name": _line(title), "description": "NONE", "db_app": program, "program": program}
    units = {"type": 164, "units_code": 1, "units_description": "SI", "temp_mode": 1, "length": 1.0, "force": 1.0, "temp": 1.0}
    return [header, {**units, "temp_offset": 273.15}]


def _write(path: Path, datasets: list[dict]) -> None:
    """Write data sets one after another to a temporary file, as pyuff reads the whole file again after each."""
    pyuff = optional_package("pyuff", "writing universal files")
    part = path.with_name(f"{path.name}.part")
    try:
        with open(path, "wb") as whole, warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)  # pyuff leaves closing the file of a binary data set to Python
            for dataset in datasets:
                part.unlink(missing_ok=True)  # the mode overwrite loses the header of a binary data set
                pyuff.UFF(str(part)).write_sets(dataset, mode="add")
                whole.write(part.read_bytes())
    finally:
        part.unlink(missing_ok=True)


def _line(text: str) -> str:
    """An ASCII line of identification, which may not be empty."""
    return text.encode("ascii", "replace").decode()[:LONGEST_ID].strip() or "NONE"
