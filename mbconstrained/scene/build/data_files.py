"""Data files of a scene, in its folder or in allowed ones: matrices, and records with units, also for ``mbconstrained.read_record``."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...ground.by_name import answering
from ...ground.checks import counted, real_number
from ...ground.display import Pictured
from ...ground.errors import InputError, named, shown
from ...ground.notices import Notice, NoticeKind
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
from ..coordinates import force_value
from ..file import SceneFolder

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
        notices: how the file was read, what is missing in it, and what was corrected.
        unit_in_file: unit of the values in the file; an empty text where it is unknown.
    """

    times: np.ndarray = field(repr=False)
    values: np.ndarray = field(repr=False)
    unit: str = ""
    name: str = ""
    notices: tuple[Notice, ...] = ()
    unit_in_file: str = ""

    @property
    def signal(self) -> ImpulsiveSmooth:
        """The record as a force of one row, linear between its samples (``mbconstrained.sampled``), with its notices."""
        if len(self.times) and self.times[0] < 0:
            raise InputError(
                f'it begins at {self.times[0]:g} s; give start, e.g. start = "{self.times[0]:g} s", which becomes t = 0'
            )
        signal = sampled(self.times, [self.values])
        return replace(signal, notices=self.notices).described_by(*signal.exact_inputs)

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
    decimal: str | None = None,
    speed=None,
    start=None,
    end=None,
    baseline: str | None = None,
    baseline_fit: str = "record",
) -> Record:
    """Read a record from a file: factor * values + offset over time, in SI; nothing is resampled.

    Read are text with columns of numbers, with comma, semicolon, tab or blanks between them, a decimal point or comma, marks between
    thousands, dates and times of day, a row of units, header and comment lines (any ending); sheets in .xlsx; recordings of ground
    motion of PEER (.AT2, .VT2, .DT2), K-NET, ESM and ITACA; .wav; universal files (.uff, .unv: functions of data set 58; needs
    pyuff); and arrays in .npy, .npz, .mat, .mtx and .op4.

    Args:
        path: path of the file.
        column: of the values, by its number from 1 or by its name in the header; 2 by default, 1 with a step. Of .wav the channel, of a
            universal file the function.
        time: the column of the times; 1 by default.
            Dates and times of day become seconds after the first; a date is joined with a time of day in the column next to it.
        step: between samples, in s or as text with a unit, of a file without times. Without a column every number of the file is
            a sample, line by line.
        unit: of the values. By default what stands in parentheses or after a slash behind the name of the column, where it
            is a unit, otherwise SI; g is the acceleration of gravity, gram a mass.
            Formats that fix their unit need none; WAV has shares of full scale.
        time_unit: of the times; by default as for the values.
        factor: a number, or a text with a unit that multiplies the unit of the values, e.g. "-1200 kg" for an acceleration.
        offset: is added, a number in SI or a text with a unit.
        header: so many lines at the start of a text hold no numbers; found without it where they do not look like numbers.
        array: the name of the array, or of the sheet of .xlsx, in a file of several.
        decimal: "." or "," where the numbers do not tell which of both begins decimals.
        speed: in m/s or as text with a unit: of a record over a distance, whose first column is x, in m unless the header or
            ``time_unit`` states another unit; t = x / speed. ``step``, ``start`` and ``end`` are lengths then, or times as texts.
        start, end: of the part that is read, in s or as texts with a unit; t = 0 is at the start then.
        baseline: a polynomial of time, "constant", "linear", "quadratic" or "cubic", that is fitted by least squares and removed;
            a notice states its size.
        baseline_fit: "record", or "integral" for the integral of the record from rest, the velocity of an acceleration. Sources:
            Boore and Bommer, Soil Dynamics and Earthquake Engineering 25 (2005); Berg and Housner, Bulletin of the Seismological
            Society of America 51 (1961).

    Returns:
        The record.

    Raises:
        InputError: a file that cannot be read, no such column, entries that are not finite numbers, times that do not ascend, another
            kind of unit; the text has the line.
        MissingPackage: pyuff, for universal files, openpyxl, for .xlsx, or pyyeti, for .op4, is not installed.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "logger.txt")
    ...     _ = path.write_text("t (ms);F (kN)\\n0,0;1,5\\n500,0;2,5\\n")
    ...     record = read_record(path, column="F", offset="-1 kN")
    >>> record.times.tolist(), record.values.tolist(), record.unit
    ([0.0, 0.5], [500.0, 1500.0], 'N')
    """
    with named("unit"):
        unit = None if unit is None else unit_name(unit)
    with named("time_unit"):
        time_unit = None if time_unit is None else unit_name(time_unit)
    reading: dict[str, Any] = {"column": column, "time": time, "header": header, "array": array, "decimal": decimal}
    part = {"speed": speed, "step": step, "start": start, "end": end, "baseline": baseline, "baseline_fit": baseline_fit}
    return record_in_si(path, unit=unit, time_unit=time_unit, factor=factor, offset=offset, **part, **reading)


def record_in_si(
    path: str | Path,
    *,
    unit: str | None = None,
    time_unit: str | None = None,
    factor=1.0,
    offset=0.0,
    expected: str | None = None,
    speed=None,
    step=None,
    start=None,
    end=None,
    baseline: str | None = None,
    baseline_fit: str = "record",
    **reading,
) -> Record:
    """``read_record`` with checked units."""
    from ...exchange.samples import read_samples

    along = _Abscissa(speed)
    samples = read_samples(path, step=None if step is None else along.number("step", step), **reading)
    if samples.is_scaled and (unit or time_unit or speed is not None):
        extra = "unit" if unit else "time_unit" if time_unit else "speed"
        raise InputError(f"{samples.file}: its format fixes the units ({samples.unit}, s); leave out {extra}")
    notes = list(samples.notes)
    seconds = along.seconds(samples, time_unit, step is not None)
    if unit is None and samples.unit not in ("", "-", "1", "%") and _readable(samples.unit) is None and not isinstance(factor, str):
        notes.append(
            f'"{samples.unit[:40]}" behind the name of the column is no known unit; {expected or "SI"} is taken: give unit'
        )
    if step is None and time_unit is None and not samples.time_unit:
        notes += _named_unit(samples.time_name, along.unit, "time_unit")
    if unit is None and not samples.unit and expected:
        notes += _named_unit(samples.name, expected, "unit")
    if unit is None and samples.unit == "g" and expected is None and not isinstance(factor, str):
        notes.append('"g" behind the name of the column is the acceleration of gravity; give unit = "gram" for a mass')
    unit = unit or _readable(samples.unit)
    unit = unit if unit is None or isinstance(factor, str) else meant(unit, expected or "m/s^2")  # nothing is recorded in grams
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
    own_unit = expected or _unit_of(kind)
    values = values + size if (size := _offset(offset, own_unit)) else values
    _check_sizes(samples, times, values)
    times, values = along.part(samples.file, times, values, start, end)
    if times[0] > times[-1] - times[0]:
        notes.append(
            f'it begins at {times[0]:.12g} s, which is longer than it lasts, and has no effect before; start = "{times[0]:.12g} s" '
            "makes this t = 0"
        )
    if baseline is not None:
        values, note = _without_baseline(times, values, own_unit, baseline, baseline_fit)
        notes.append(note)
    elif baseline_fit != "record":
        raise InputError('baseline_fit: there is no baseline to be fitted; give baseline, e.g. "linear"')
    notices = tuple(Notice(NoticeKind.RECORD, f"{samples.file}: {note}") for note in notes)
    return Record(times, values, "" if kind is None else own_unit, samples.name, notices, unit or "")


class _Abscissa:
    """The first column of a record: times, or with a speed distances."""

    def __init__(self, speed):
        self.speed = None if speed is None else quantity(speed, "m/s")
        if self.speed is not None and not self.speed > 0:
            raise InputError(f"speed: found {shown(speed)}; expected a positive speed")
        self.unit = "s" if speed is None else "m"

    def number(self, key: str, value) -> float:
        """A number or quantity along it, in s or m; with a speed a time, too."""
        with named(key):
            try:
                return quantity(value, self.unit)
            except InputError:
                if self.speed is not None:
                    return self.speed * quantity(value, "s")
                if isinstance(value, str) and any_quantity(value)[1] == dimension("m"):
                    raise InputError(
                        f"found {shown(value)}; a length belongs to a record over a distance: give speed, too"
                    ) from None
                raise

    def seconds(self, samples: Samples, unit: str | None, is_stepped: bool) -> float:
        """Seconds of a unit of the first column."""
        if is_stepped:
            return 1.0 / (self.speed or 1.0)
        what = "time" if self.speed is None else "distance"
        scale, kind = _si(unit := unit or _readable(samples.time_unit) or self.unit)
        if kind is None or not same_kind(kind, self.unit):
            is_length = kind is not None and same_kind(kind, "m") and self.speed is None
            hint = "give speed for a record over a distance, or time_unit" if is_length else "give time_unit"
            raise InputError(f"{samples.file}: the unit of the {what} is {shown(unit)}; expected one such as {self.unit}; {hint}")
        return scale / (self.speed or 1.0)

    def part(self, file: str, times: np.ndarray, values: np.ndarray, start, end) -> tuple[np.ndarray, np.ndarray]:
        """The record between two times, from t = 0 on where a start is given."""
        low, high = (
            None if one is None else self.number(key, one) / (self.speed or 1.0) for key, one in (("start", start), ("end", end))
        )
        if low is None and high is None:
            return times, values
        first, last = times[0] if low is None else low, times[-1] if high is None else high
        if not first < last or first >= times[-1] or last <= times[0]:
            raise InputError(
                f"{file}: start, end: found {first:g} s to {last:g} s; expected a part of the record, {times[0]:g} s to {times[-1]:g} s"
            )
        new = [one for one in (first, last) if times[0] <= one <= times[-1] and one not in times]
        values = np.insert(values, np.searchsorted(times, new), np.interp(new, times, values))
        times = np.insert(times, np.searchsorted(times, new), new)
        inside = (times >= first) & (times <= last)
        return times[inside] - (0.0 if low is None else low), values[inside]


def _without_baseline(times, values, unit: str, degree: str, fit: str) -> tuple[np.ndarray, str]:
    """The values without their baseline, and a sentence on its size and its effect."""
    from ...exchange.samples import baseline, integrals

    removed = baseline(times, values, degree, fit)(times)
    most, peak = np.abs(removed).max(), np.abs(values).max()
    share = f" ({most / peak:.2g} of the largest value)" if peak else ""
    fitted = "record" if fit == "record" else "integral of the record"
    text = (
        f"a {degree} baseline of at most {most:.3g}{unit and f' {unit}'}{share} is removed, fitted to the {fitted} by least squares"
    )
    if unit in ("m/s^2", "rad/s^2"):
        before, after = (integrals(times, own) for own in (values, values - removed))
        length = unit.split("/")[0]
        changes = (
            f"{what} {old[-1]:.3g} {length}{rate}, now {new[-1]:.3g}"
            for what, rate, old, new in zip(("velocity", "displacement"), ("/s", ""), before, after)
        )
        text += f"; at its end {'; '.join(changes)}"
    return values - removed, text


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


def _named_unit(name: str, expected: str, key: str) -> Iterator[str]:
    """A note where the last word of a name is a unit of the expected kind, as in t_ms, which is not read as such."""
    word = re.split(r"[\s_,.;:-]+", name)[-1]
    if word != name and (unit := _readable(word)) is not None:
        size, kind = _si(unit)
        if kind is not None and size != 1 and same_kind(kind, expected):
            yield f'the name "{name[:40]}" may mean {unit}; {expected} is taken: give {key} = "{unit}" if it does'


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


def entries_of(source, folder: SceneFolder) -> np.ndarray:
    """The entries of a matrix, with expressions of parameters unevaluated."""
    if isinstance(source, np.ndarray):
        return source
    from ...exchange.matrices import full_matrix, read_matrix

    matrix = full_matrix(read_matrix(folder.data_file(source.file), source.array), source.file)
    sizes = np.abs(matrix[matrix != 0])
    if sizes.size and not (LEAST <= sizes.min() and sizes.max() <= LARGEST):
        raise InputError(f"{source.file}: entries must be 0 or of a size between {LEAST:g} and {LARGEST:g}")
    return matrix


def record_of(source, unit: str | None, folder: SceneFolder) -> Record:
    given = {key: getattr(source, key) for key in (*source.OF_FILE, "speed") if getattr(source, key) is not None}
    given["offset"] = force_value(source.offset, unit, what="offset")
    return record_in_si(folder.data_file(source.file), expected=unit, **given)


def curve_of(source, folder: SceneFolder) -> tuple[np.ndarray, np.ndarray, str | None]:
    """Frequencies in Hz, the values at them, and the unit of these, of a table that may name a file in the place of both."""
    if source.file is None:
        return source.frequencies, source.values, source.unit
    from ...exchange.samples import read_samples

    given = {key: getattr(source, key) for key in ("column", "header", "array", "decimal")}
    curve = read_samples(folder.data_file(source.file), over_time=False, **given)
    with named(f"{curve.file}: unit of the frequencies"):
        hertz = quantity(f"1 {_readable(curve.time_unit) or 'Hz'}", "Hz")
    return hertz * curve.times, curve.values, source.unit or curve.unit or None
