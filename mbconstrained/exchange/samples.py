"""Records over time in files (tables of text, arrays, recordings of ground motion, WAV, universal files), never resampled, and their baselines."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..ground.checks import check_known, counted, real_number, whole_number
from ..ground.errors import InputError
from ..ground.files import checked_file, readable_as
from .columns import SHEETS, NumberTable, number_table, text_of
from .matrices import READERS, TEXT, full_matrix, read_matrix
from .universal import UNIVERSAL, read_function

STANDARD_GRAVITY = 9.80665  # m/s^2, by definition


@dataclass(frozen=True, eq=False)
class Samples:
    """Values over time as they are in a file."""

    file: str  # its name, for messages
    times: np.ndarray = field(repr=False)  # shape (T,), ascending; two samples at one time are a jump
    values: np.ndarray = field(repr=False)  # shape (T,)
    name: str = ""  # name of the column or channel; an empty text where there is none
    # as the file writes them; empty texts where it does not
    time_unit: str = ""
    unit: str = ""
    is_scaled: bool = False  # whether the format itself fixes times in s and values in an SI unit, 1 for shares of full scale
    lines: np.ndarray | None = field(default=None, repr=False)  # the line of each sample in the file; None where it has no lines
    notes: tuple[str, ...] = ()  # how the file was read where it has another reading, and steps that differ from all others
    of_clock: bool = False  # whether the times are seconds between dates or times of day
    time_name: str = ""  # name of the column of the times

    def place(self, row: int) -> str:
        """Location of a sample in the file, for messages."""
        return f"row {row + 1}" if self.lines is None else f"line {self.lines[row]}"


def read_samples(
    path: str | Path,
    *,
    column: int | str | None = None,
    time: int | str | None = None,
    step: float | None = None,
    header: int = 0,
    array: str | None = None,
    decimal: str | None = None,
    over_time: bool = True,
) -> Samples:
    """A record in a file; or where it is not over time the values of a column over any other one.

    Read are text with columns of numbers (any ending), sheets in .xlsx, recordings of ground motion in the text formats of PEER (.AT2),
    K-NET and DYNA, .wav, universal files (functions of data set 58), and arrays in .npy, .npz, .mat, .mtx and .op4.
    """
    path = checked_file(path)
    step = None if step is None else real_number(step, "step", positive=True)
    whole_number(header, "header")
    if step is not None and time is not None:
        raise InputError(f"{path.name}: found step and time; give the step between samples, or the column of the times")
    try:
        record = _samples(path, column, time, step, header, array, decimal)
        if not record.values.size:
            raise InputError(f"{path.name}: found no samples in it")
        return _ascending(record) if over_time and step is None else record
    except OSError as problem:
        raise InputError(f"{path.name}: the file cannot be read ({problem.strerror or problem})") from None


def _samples(path: Path, column, time, step, header: int, array, decimal) -> Samples:
    suffix = path.suffix.lower()
    if suffix in (".xls", ".xlsb", ".ods"):
        raise InputError(f"{path.name}: {suffix} files are not read; save it as .xlsx or .csv")
    if suffix in SHEETS:
        return _from_table(number_table(path, header, array, decimal), column, time, step)
    if suffix in READERS and suffix not in TEXT:
        _refuse(path, "only a text has a decimal mark", decimal=decimal)
        _refuse(path, "only a text has header lines", header=header)
        matrix = full_matrix(read_matrix(path, array), path.name)
        return _from_table(NumberTable(path.name, matrix, np.arange(1, len(matrix) + 1)), column, time, step, lines=False)
    _refuse(path, "only files of arrays hold named arrays", array=array)
    if suffix == ".wav":
        _refuse(path, "the file has its own times", time=time, step=step, header=header)
        return _from_wav(path, 1 if column is None else column)
    if suffix in UNIVERSAL:
        _refuse(path, "the file has its own times", time=time, step=step, header=header)
        function = read_function(path, column)
        data = function.times, function.values, function.name, "s", function.unit
        return Samples(path.name, *data, is_scaled=function.is_scaled, notes=function.notes)
    if step is None and not header and decimal is None and (motion := ground_motion(path.name, text_of(path))):
        _refuse(path, "the file has its own times and one column", time=time, column=column)
        times = motion.step * np.arange(len(motion.values))
        return Samples(path.name, times, motion.values, motion.name, "s", motion.unit, True)
    return _from_table(number_table(path, header, decimal=decimal), column, time, step)


def _refuse(path: Path, reason: str, **arguments) -> None:
    for name, value in arguments.items():
        if value not in (None, 0):
            raise InputError(f"{path.name}: {reason}; leave out {name}")


def _from_table(table: NumberTable, column, time, step, lines: bool = True) -> Samples:
    count = table.values.shape[1]
    if step is not None:
        if column is None:
            values = table.checked(*range(count)).reshape(-1)
            rows = np.repeat(table.lines, count)
            name, unit = (table.title(0), table.unit(0)) if count == 1 else ("", "")
        else:
            place = table.column(column)
            values, rows, name, unit = table.checked(place)[:, 0], table.lines, table.title(place), table.unit(place)
        return Samples(table.file, step * np.arange(len(values)), values, name, "s", unit, False, rows if lines else None)
    first = table.column(1 if time is None else time, "time")
    others = [place for place in range(count) if place != first and place not in table.stamps and place not in table.texts]
    if column is None and first and not (first in table.stamps and len(others) == 1):
        raise InputError(f"{table.file}: column: give the column of the values, by number or name; the times are in {first + 1}")
    if not others and column is None:
        raise InputError(
            f"{table.file}: found {counted(count, 'column')}; expected the times in s in column 1 and the values in column 2, or a step "
            "between samples"
        )
    place = others[0] if column is None else table.column(column)
    if place == first:
        raise InputError(
            f"{table.file}: column: column {place + 1} holds the times; give another one, or step instead of the times"
        )
    times, values = table.checked(first, place).T
    rows = table.lines if lines else None
    name, units = table.title(place), (table.unit(first), table.unit(place))
    return Samples(table.file, times, values, name, *units, False, rows, table.notes, first in table.stamps, table.title(first))


def _ascending(record: Samples) -> Samples:
    """The record with ascending times, and notes on steps that are missing or repeated in a record of even steps otherwise."""
    if (backwards := np.diff(record.times) < 0).any():
        row = int(np.argmax(backwards)) + 1
        before, after = record.times[row - 1 : row + 1]
        hint = "; a time of day that passes midnight needs its date" if record.of_clock else ""
        unit = record.time_unit or "s"
        raise InputError(
            f"{record.file}, {record.place(row)}: {before:g} {unit} is followed by {after:g} {unit}; times must ascend{hint}"
        )
    return replace(record, notes=(*record.notes, *_notes_on_steps(record)))


#: A record has even steps where at least this share of them differs from their median by no more than a part of it.
MOST_STEPS, STEP_SPREAD = 0.9, 0.2

#: Records of fewer steps may have any.
FEWEST_STEPS = 20


def _notes_on_steps(record: Samples) -> Iterator[str]:
    steps = np.diff(record.times)
    if len(steps) < FEWEST_STEPS or not (usual := float(np.median(steps))) > 0:
        return
    if (np.abs(steps - usual) <= STEP_SPREAD * usual).mean() < MOST_STEPS:
        return
    unit = record.time_unit or "s"
    (gaps,), (repeated,) = (steps > (2 - STEP_SPREAD) * usual).nonzero(), (steps == 0).nonzero()
    if len(gaps):
        at, lost = gaps[0], int(np.round(steps[gaps] / usual - 1).sum())
        more = f", and {counted(len(gaps) - 1, 'gap')} more: {lost} in all" if len(gaps) > 1 else ""
        yield (
            f"{record.place(at + 1)}: {counted(round(steps[at] / usual) - 1, 'sample')} missing after {record.times[at]:g} {unit}{more}; "
            f"steps are {usual:.6g} {unit} elsewhere, and the record is linear across a gap"
        )
    if len(repeated):
        more = f", and those of {counted(len(repeated) - 1, 'line')} more" if len(repeated) > 1 else ""
        yield f"{record.place(repeated[0] + 1)} repeats the time {record.times[repeated[0]]:g} {unit}{more}; the record jumps there"


def _from_wav(path: Path, column: int | str) -> Samples:
    """A channel of a WAV file; whole numbers as shares of full scale."""
    from scipy.io import wavfile

    with readable_as(path, "not a WAV file of samples"), warnings.catch_warnings():  # of chunks that hold no samples
        warnings.simplefilter("ignore", wavfile.WavFileWarning)
        rate, data = wavfile.read(path)
    if not data.size:
        raise InputError(f"{path.name}: found no samples in it")
    channels = data.reshape(len(data), -1)
    if not isinstance(column, int) or not 1 <= column <= channels.shape[1]:
        raise InputError(
            f"{path.name}: column: found {column!r}; the file has {counted(channels.shape[1], 'channel')}, numbered from 1"
        )
    values = channels[:, column - 1]
    if values.dtype.kind in "iu":
        bits = 8 * values.dtype.itemsize
        values = (values.astype(float) - (2 ** (bits - 1) if values.dtype.kind == "u" else 0)) / 2 ** (bits - 1)
    if not rate > 0 or not np.isfinite(values).all():
        raise InputError(f"{path.name}: found samples that are not finite, or no sampling rate")
    return Samples(path.name, np.arange(len(values)) / rate, values.astype(float), f"channel {column}", "s", "1", True)


# Records of ground motion: PEER (.AT2, .VT2, .DT2), K-NET and KiK-net, and the DYNA files of ESM and ITACA, all text.

GAL = 0.01  # m/s^2
HEADER_LINES = 80  # in which a format is recognized; DYNA has 64


class GroundMotion(NamedTuple):
    """A record of even steps."""

    step: float  # between samples, in s
    values: np.ndarray  # shape (T,), in the unit
    unit: str  # "m", "m/s" or "m/s^2"
    name: str  # name of the record


def ground_motion(file: str, text: str) -> GroundMotion | None:
    """The record in a text of one of the formats; None for any other text.

    >>> record = ground_motion("a.AT2", "PEER\\nquake\\nACCELERATION TIME SERIES IN UNITS OF G\\nNPTS= 2, DT= .005 SEC\\n .1 -.2\\n")
    >>> record.step, record.values.round(4).tolist(), record.unit
    (0.005, [0.9807, -1.9613], 'm/s^2')
    """
    head = "\n".join(text.split("\n", HEADER_LINES)[:HEADER_LINES]).splitlines()
    reader = next((reader for is_it, reader in _FORMATS if any(re.search(is_it, line) for line in head)), None)
    return reader(file, text.splitlines()) if reader else None


_PEER_UNITS = {
    "G": (STANDARD_GRAVITY, "m/s^2"), "CM/S/S": (GAL, "m/s^2"), "CM/S**2": (GAL, "m/s^2"), "CM/SEC/SEC": (GAL, "m/s^2"),
    "M/S/S": (1.0, "m/s^2"), "CM/S": (0.01, "m/s"), "CM/SEC": (0.01, "m/s"), "CM": (0.01, "m"),
}  # fmt: skip


def _peer(file: str, lines: list[str]) -> GroundMotion:
    """Three lines of text, one of count and step, then the values."""
    place = next(k for k, line in enumerate(lines) if re.search(_PEER, line))
    line = lines[place].upper()
    new = re.search(r"NPTS\s*=\s*(\d+)\s*,\s*DT\s*=\s*([\d.E+-]+)", line)
    old = re.match(r"\s*(\d+)\s+([\d.E+-]+)\s+NPTS", line)
    count, step = (new or old).groups()
    stated = next((match for above in lines[:place] if (match := re.search(r"UNITS OF\s+([A-Z/*0-9]+)", above.upper()))), None)
    if stated is None or stated[1] not in _PEER_UNITS:
        raise InputError(f"{file}: the header states no known unit; expected a line such as ACCELERATION TIME SERIES IN UNITS OF G")
    factor, unit = _PEER_UNITS[stated[1]]
    values = _values(file, lines, place + 1, int(count))
    name = lines[1].strip() if place > 1 else ""
    return GroundMotion(_positive(file, place + 1, step), factor * values, unit, name)


def _knet(file: str, lines: list[str]) -> GroundMotion:
    """17 lines of words and values, then whole numbers to be scaled; the mean of the record stays in it."""
    entry = _entry(file, lines)
    hertz, line = entry(r"Sampling Freq\(Hz\)\s+([\d.]+)\s*Hz", "Sampling Freq(Hz)")
    scale, at = entry(r"Scale Factor\s+([\d.]+\s*\(gal\)\s*/\s*[\d.]+)", "Scale Factor")
    top, bottom = re.split(r"\(gal\)\s*/", scale.replace(" ", ""))
    memo = next((k for k, line in enumerate(lines) if line.startswith("Memo.")), 16)
    factor = GAL * _positive(file, at, top) / _positive(file, at, bottom)
    name = " ".join(entry(pattern, pattern)[0] for pattern in (r"Station Code\s+(\S+)", r"Dir\.\s+(\S+)"))
    return GroundMotion(1 / _positive(file, line, hertz), factor * _values(file, lines, memo + 1), "m/s^2", name)


_DYNA_UNITS = {"cm/s^2": (GAL, "m/s^2"), "cm/s": (0.01, "m/s"), "cm": (0.01, "m"), "m/s^2": (1.0, "m/s^2")}


def _dyna(file: str, lines: list[str]) -> GroundMotion:
    """Lines KEY: value, then one value each line."""
    entry = _entry(file, lines)
    step, at = entry(r"^SAMPLING_INTERVAL_S:\s*(\S+)", "SAMPLING_INTERVAL_S")
    unit, line = entry(r"^UNITS:\s*(\S+)", "UNITS")
    count, _ = entry(r"^NDATA:\s*(\d+)", "NDATA")
    if unit not in _DYNA_UNITS:
        raise InputError(f"{file}, line {line}: found the unit {unit[:20]!a}; expected one of {', '.join(_DYNA_UNITS)}")
    factor, unit = _DYNA_UNITS[unit]
    first = next((k for k, line in enumerate(lines) if line.strip() and not re.match(r"[A-Z][A-Z0-9_ ]*:", line)), len(lines))
    name = entry(r"^STATION_CODE:\s*(\S+)", "STATION_CODE")[0]
    return GroundMotion(_positive(file, at, step), factor * _values(file, lines, first, int(count)), unit, name)


_PEER = r"(?i)NPTS\s*=\s*\d+\s*,\s*DT\s*=\s*[\d.]|^\s*\d+\s+[\d.E+-]+\s+NPTS\s*,\s*DT"
_FORMATS: tuple[tuple[str, Callable[[str, list[str]], GroundMotion]], ...] = (
    (_PEER, _peer),
    (r"^Sampling Freq\(Hz\)", _knet),
    (r"^SAMPLING_INTERVAL_S:", _dyna),
)


def _entry(file: str, lines: list[str]):
    """A function that finds the value of an entry of the header and the number of its line."""

    def entry(pattern: str, name: str) -> tuple[str, int]:
        for number, line in enumerate(lines[:HEADER_LINES], 1):
            if match := re.search(pattern, line):
                return match[1], number
        raise InputError(f"{file}: the header has no readable entry {name}")

    return entry


def _positive(file: str, line: int, text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = 0.0
    if not 0 < number < np.inf:
        raise InputError(f"{file}, line {line}: found {text[:20]!a}; expected a positive number")
    return number


def _values(file: str, lines: list[str], first: int, count: int | None = None) -> np.ndarray:
    """All numbers from a line onwards, in the order of reading."""
    values: list[float] = []
    for number, line in enumerate(lines[first:], first + 1):
        try:
            values += map(float, line.split())
        except ValueError:
            raise InputError(f"{file}, line {number}: found {line.strip()[:40]!a}; expected numbers") from None
        if not np.isfinite(values[-len(line.split()) or len(values) :]).all():
            raise InputError(f"{file}, line {number}: found an entry that is nan or infinite; expected numbers")
    if count not in (None, len(values)):
        raise InputError(f"{file}: the header states {count} samples, the file has {len(values)}; it is not complete")
    return np.array(values)


# Baselines: polynomials of time, fitted by least squares to a record or to its integral.

#: Degrees by name.
DEGREES = {"constant": 0, "linear": 1, "quadratic": 2, "cubic": 3}

#: Points and weights of Gauss's rule on an interval, exact to degree 5: the square of the integral of a record has degree 4.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True, eq=False)
class Baseline:
    """p(t) = sum of coefficients[k] (t - start)^k."""

    start: float  # time of the first sample
    coefficients: np.ndarray  # ascending powers, in the unit of the record by s^k

    def __call__(self, times) -> np.ndarray:
        """p at times."""
        return np.polynomial.polynomial.polyval(np.asarray(times) - self.start, self.coefficients)


def baseline(times: np.ndarray, values: np.ndarray, degree: str = "linear", fit: str = "record") -> Baseline:
    """The baseline p(t) of a record a(t), linear between its samples, from its first time 0 to its last T.

    Of the fit "record" the integral of (a - p)^2 over [0, T] is smallest, of "integral" that of (v - w)^2 with v and w the integrals
    of a and p from 0: the velocities, if a is an acceleration. Sources: Berg and Housner, Integrated velocity and displacement of strong
    earthquake ground motion, Bulletin of the Seismological Society of America 51 (1961), for "integral" with a quadratic p; Boore and
    Bommer, Processing of strong-motion accelerograms, Soil Dynamics and Earthquake Engineering 25 (2005), on both.
    """
    check_known(degree, DEGREES, "baseline")
    check_known(fit, ("record", "integral"), "baseline_fit")
    duration = float(times[-1] - times[0]) if len(times) else 0.0
    if not duration > 0:
        raise InputError("baseline: found a record without a duration; expected samples at several times")
    h, slopes = _steps(times, values)
    inside = h[:, None] * (_NODES + 1) / 2  # times after the sample before
    u, root = ((times[:-1] - times[0])[:, None] + inside).ravel() / duration, np.sqrt(h[:, None] * _WEIGHTS).ravel()
    aims, powers = values[:-1, None] + slopes[:, None] * inside, np.arange(DEGREES[degree] + 1)
    basis = u[:, None] ** powers
    if fit == "integral":
        aims = integrals(times, values)[0][:-1, None] + inside * (values[:-1, None] + slopes[:, None] * inside / 2)
        basis = duration * u[:, None] ** (powers + 1) / (powers + 1)
    coefficients = np.linalg.lstsq(root[:, None] * basis, root * aims.ravel(), rcond=None)[0]
    return Baseline(float(times[0]), coefficients / duration**powers)


def integrals(times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The first and the second integral of a record at its samples, from 0."""
    h, slopes = _steps(times, values)
    first = np.append(0.0, np.cumsum(h * (values[:-1] + slopes * h / 2)))
    second = np.append(0.0, np.cumsum(h * (first[:-1] + h * (values[:-1] / 2 + slopes * h / 6))))
    return first, second


def _steps(times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    h = np.diff(times)
    return h, np.divide(np.diff(values), h, out=np.zeros(len(h)), where=h > 0)
