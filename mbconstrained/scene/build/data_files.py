"""Data files of a scene in its folder or in folders inside it: matrices, and records with units, also for ``mbconstrained.read_record``."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...ground.by_name import answering
from ...ground.checks import counted, real_number
from ...ground.display import Pictured
from ...ground.errors import InputError, named, shown
from ...ground.quantities import (
    KINDS,
    LARGEST,
    LEAST,
    Dimension,
    Expressed,
    any_quantity,
    described,
    dimension,
    meant,
    quantity,
    same_kind,
    unit_name,
    unit_of,
)
from ...signals.inputs import ImpulsiveSmooth, sampled
from ..file import inside
from ..quantities.coordinates import force_value

if TYPE_CHECKING:
    from ...exchange.samples import Samples


@dataclass(frozen=True, repr=False, eq=False)
class Record(Pictured):
    """Record over time, in SI.

    Attributes:
        times: shape (T,), in s, ascending; two samples at one time are a jump.
        values: shape (T,).
        unit: unit of the values in SI; an empty text where it is unknown.
        name: name of the column, channel or function in the file.
        unit_in_file: unit of the values in the file; an empty text where it is unknown.
    """

    times: np.ndarray = field(repr=False)
    values: np.ndarray = field(repr=False)
    unit: str = ""
    name: str = ""
    unit_in_file: str = ""

    @property
    def signal(self) -> ImpulsiveSmooth:
        """The record as a force of one row, linear between its samples (``mbconstrained.sampled``)."""
        return sampled(self.times, [self.values])

    def _summary(self) -> str:
        named = f"{self.name}: " if self.name else ""
        until = f" from {self.times[0]:g} s to {self.times[-1]:g} s" if len(self.times) else ""
        return f"{named}{counted(len(self.times), 'sample')}{until}{f' in {self.unit}' if self.unit else ''}"


@answering
def read_record(
    path: str | Path,
    *,
    column: int | str | None = None,
    time: int | str | None = None,
    step=None,
    unit: str | None = None,
    time_unit: str | None = None,
    factor=1.0,
    offset=0.0,
    header: int = 0,
    array: str | None = None,
) -> Record:
    """Read a record from a file: factor * values + offset over time, in SI; nothing is resampled.

    Read are text with columns of numbers, with comma, semicolon, tab or blanks between them, a decimal point or comma, header and
    comment lines (any ending); recordings of ground motion of PEER (.AT2, .VT2, .DT2), K-NET, ESM and ITACA; .wav; universal files
    (.uff, .unv: functions of data set 58; needs pyuff); and arrays in .npy, .npz, .mat, .mtx and .op4.

    Args:
        path: path of the file.
        column: of the values, by its number from 1 or by its name in the header; 2 by default, 1 with a step. Of .wav the channel, of a
            universal file the function.
        time: the column of the times; 1 by default.
        step: between samples, in s or as text with a unit, of a file without times. Without a column every number of the file is
            a sample, line by line.
        unit: of the values. By default what stands in parentheses behind the name of the column, where it is a unit, otherwise SI.
            Formats that fix their unit need none; WAV has shares of full scale.
        time_unit: of the times; by default as for the values.
        factor: a number, or a text with a unit that multiplies the unit of the values, e.g. "-1200 kg" for an acceleration.
        offset: is added, a number in SI or a text with a unit.
        header: so many lines at the start of a text hold no numbers; found without it where they do not look like numbers.
        array: the name of the array in a file of several.

    Returns:
        The record.

    Raises:
        InputError: a file that cannot be read, no such column, entries that are not finite numbers, times that do not ascend, another
            kind of unit; the text has the line.
        MissingPackage: pyuff, for universal files, or pyyeti, for .op4, is not installed.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "logger.txt")
    ...     _ = path.write_text("t (ms);F (kN)\\n0,0;1,5\\n500,0;2,5\\n")
    ...     record = read_record(path, column="F", offset="-1 kN")
    >>> record.times.tolist(), record.values.tolist(), record.unit
    ([0.0, 0.5], [500.0, 1500.0], 'N')
    """
    step = None if step is None else quantity(step, "s")
    with named("unit"):
        unit = None if unit is None else unit_name(unit)
    with named("time_unit"):
        time_unit = None if time_unit is None else unit_name(time_unit)
    record = record_in_si(
        path, unit=unit, time_unit=time_unit, factor=factor, column=column, time=time, step=step, header=header, array=array
    )
    return replace(record, values=record.values + _offset(offset, record.unit))


def record_in_si(
    path: str | Path,
    *,
    unit: str | None = None,
    time_unit: str | None = None,
    factor=1.0,
    offset: float = 0.0,
    expected: str | None = None,
    **reading,
) -> Record:
    """``read_record`` with an offset in SI and checked units."""
    from ...exchange.samples import read_samples

    samples = read_samples(path, **reading)
    if samples.is_scaled and (unit or time_unit):
        raise InputError(
            f"{samples.file}: its format fixes the units ({samples.unit}, s); leave out {'unit' if unit else 'time_unit'}"
        )
    seconds = _scale(samples, time_unit or _readable(samples.time_unit) or "s", "s", "time")
    unit = unit or _readable(samples.unit)
    unit = unit if unit is None or isinstance(factor, str) else meant(unit, expected)
    scale, kind = (1.0, None) if unit is None else _si(unit)
    number, factor_kind = _factor(factor)
    if factor_kind is not None and "1" in (unit, samples.unit):
        kind = factor_kind
    elif kind is not None and factor_kind is not None:
        kind = kind.times(factor_kind)
    elif factor_kind is not None:
        raise InputError(f"factor: found {shown(factor)}, but the unit of the record is unknown; give unit as well")
    if kind is not None and expected not in (None, "1") and not same_kind(kind, expected):
        raise InputError(
            f"{samples.file}: the values are {described(kind)} ({unit or 'no unit'}{'' if factor_kind is None else ' times factor'}); "
            f"expected {expected}: give their unit, or a factor with a unit"
        )
    times = samples.times if seconds == 1 else seconds * samples.times
    values = samples.values if scale * number == 1 else scale * number * samples.values
    values = values + offset if offset else values
    _check_sizes(samples, times, values)
    return Record(times, values, expected or _unit_of(kind), samples.name, unit or "")


def _unit_of(kind: Dimension | None) -> str:
    """The SI unit of a kind, also of a product, with optional radians."""
    if kind is None:
        return ""
    return next((unit for unit in KINDS if unit != "1" and same_kind(kind, unit)), "") or unit_of(kind)


def _check_sizes(samples: Samples, times: np.ndarray, values: np.ndarray) -> None:
    sizes = np.abs([times, values])
    beyond = ((sizes != 0) & ((sizes < LEAST) | (sizes > LARGEST))).any(axis=0)
    if beyond.any():
        row = int(np.argmax(beyond))
        raise InputError(
            f"{samples.file}, {samples.place(row)}: found {times[row]:g} s and {values[row]:g}; expected 0 or a size between "
            f"{LEAST:g} and {LARGEST:g} of both"
        )


def _readable(text: str) -> str | None:
    """The unit written in a file, where it is a known one."""
    if not text or text == "1":
        return None
    try:
        return unit_name(text)
    except InputError:
        return None


def _si(unit: str) -> tuple[float, Dimension | None]:
    """The size of a unit in SI, and its kind."""
    return (1.0, None) if unit == "1" else any_quantity(f"1 {unit}")


def _scale(samples: Samples, unit: str, si: str, what: str) -> float:
    scale, kind = _si(unit)
    if kind is None or not same_kind(kind, si):
        raise InputError(f"{samples.file}: the unit of the {what} is {shown(unit)}; expected one such as {si}; give {what}_unit")
    return scale


def _factor(factor) -> tuple[float, Dimension | None]:
    if isinstance(factor, Expressed):
        raise InputError("factor: found an expression of parameters; give a number, or a text with a unit")
    if isinstance(factor, str):
        with named("factor"):
            return any_quantity(factor)
    return real_number(factor, "factor"), None


def _offset(offset, unit: str) -> float:
    if not isinstance(offset, str):
        return real_number(offset, "offset")
    number, kind = any_quantity(offset)
    if unit and kind is not None and kind != dimension(unit):
        raise InputError(f"offset: found {shown(offset)}, {described(kind)}; expected a quantity in {unit}")
    return number


def _data_file(folder: Path, name: str) -> Path:
    """The path of a data file named in a scene."""
    rule = "data files must lie in the folder of the scene, or in a folder inside it"
    return inside(folder, name, rule, "the name of a file such as record.csv or matrices.npz")


def entries_of(source, folder: Path) -> np.ndarray:
    """The entries of a matrix, with expressions of parameters unevaluated."""
    if isinstance(source, np.ndarray):
        return source
    from ...exchange.matrices import full_matrix, read_matrix

    matrix = full_matrix(read_matrix(_data_file(folder, source.file), source.array), source.file)
    sizes = np.abs(matrix[matrix != 0])
    if sizes.size and not (LEAST <= sizes.min() and sizes.max() <= LARGEST):
        raise InputError(f"{source.file}: entries must be 0 or of a size between {LEAST:g} and {LARGEST:g}")
    return matrix


def record_of(source, unit: str | None, folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """A record in a file."""
    keys = ("column", "time", "time_unit", "step", "header", "array", "factor")
    given = {key: getattr(source, key) for key in keys if getattr(source, key) is not None}
    offset = force_value(source.offset, unit, what="offset")
    record = record_in_si(_data_file(folder, source.file), unit=source.unit, expected=unit, offset=offset, **given)
    return record.times, record.values
