"""Columns of numbers in text files and sheets as loggers write them: decimal and thousands marks, units, dates and times of day."""

from __future__ import annotations

import csv
import datetime
import io
import re
from array import array
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from numbers import Integral
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..ground.checks import counted, nearest, optional_package
from ..ground.errors import InputError, shown
from ..ground.files import LARGEST_FILE, damaged, read_isolated
from ..ground.quantities import unit_name

# Comma, semicolon, tab or blanks between columns, header lines and comments above them. The first line of numbers decides which sign
# separates the columns.

COMMENTS = ("#", "%", "!", "//")
SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", None: "blanks"}
SHEETS = (".xlsx", ".xlsm")
_UNIT = re.compile(r"[(\[]((?:[^()\[\]]|\([^()\[\]]*\))+)[)\]]\s*$")  # also ((m/s^2)^2/Hz)


@dataclass(frozen=True, eq=False)
class NumberTable:
    """The numbers of a text file or sheet."""

    file: str  # its name, for messages
    values: np.ndarray = field(repr=False)  # shape (rows, columns); nan where an entry is empty
    lines: np.ndarray = field(repr=False)  # the line of each row in the file, shape (rows,)
    # the header and comment lines above the numbers that have an entry for each column, the last one first
    heads: tuple[tuple[str, ...], ...] = ()
    stamps: frozenset[int] = frozenset()  # columns of dates and times of day, whose values are seconds after the first row
    texts: Mapping[int, str] = field(default_factory=dict)  # columns of texts, with the first of them
    notes: tuple[str, ...] = ()  # how numbers of more than one reading were read

    def column(self, which: int | str, key: str = "column") -> int:
        """The place of a column."""
        count = self.values.shape[1]
        if isinstance(which, bool) or not isinstance(which, (str, Integral)):
            raise InputError(f"{self.file}: {key}: found {shown(which)}; expected the number or the name of a column")
        if not isinstance(which, str):
            if 1 <= which <= count:
                return int(which) - 1
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
        names = self.heads[1] if self._units else self.heads[0] if self.heads else ()
        return without_unit(names[place]) if names else ""

    def unit(self, place: int) -> str:
        """The unit at the end of the name of a column, e.g. "kN" of "F (kN)" and "F / kN", or in a row of units below the names."""
        if place in self.stamps:
            return "s"
        names = self.heads[1:] if self._units else self.heads
        own = next((unit for head in names if (unit := _parts(head[place])[1])), "")
        return own or (self._units[place] if self._units else "")

    @cached_property
    def _units(self) -> tuple[str, ...]:
        """The row of units below that of the names; empty without one."""
        units = self.heads[0] if len(self.heads) > 1 else ()
        return units if any(map(is_unit, units)) and all(is_unit(unit) or unit in ("", "-", "1", "%") for unit in units) else ()

    def checked(self, *places: int) -> np.ndarray:
        """Columns whose entries are all finite numbers, shape (rows, len(places))."""
        for place in places:
            if place in self.texts:
                raise InputError(
                    f"{self.file}: column {place + 1} holds texts such as {self.texts[place][:40]!a}; expected numbers"
                )
        columns = self.values[:, list(places)]
        if not (is_finite := np.isfinite(columns).all(axis=1)).all():
            row, others = int(np.argmin(is_finite)), int((~is_finite).sum()) - 1
            more = f", and so have {counted(others, 'line')} more" if others else ""
            raise InputError(
                f"{self.file}, line {self.lines[row]}: found an entry that is nan or infinite{more}; expected numbers: nothing is "
                "filled in, take these lines out or correct them"
            )
        return columns


def without_unit(name: str) -> str:
    """The name of a column without the unit behind it.

    >>> without_unit("a_x [m/s^2]"), without_unit("t / ms"), without_unit("force")
    ('a_x', 't', 'force')
    """
    return _parts(name)[0] or name.strip()


def _parts(name: str) -> tuple[str, str]:
    """The name of a column and its unit: a text in parentheses or brackets, or a known unit by which it is divided."""
    if match := _UNIT.search(name):
        return name[: match.start()].strip().removesuffix("/").strip(), match[1].strip()
    quantity, _, unit = (part.strip() for part in name.partition("/"))
    return (quantity, unit) if quantity and is_unit(unit) else (name.strip(), "")


def is_unit(text: str) -> bool:
    """Whether a text is a unit that scenes know."""
    try:
        return unit_name(text) != "1"
    except InputError:
        return False


def number_table(path: Path, header: int = 0, sheet: str | None = None, decimal: str | None = None) -> NumberTable:
    """Read the columns of numbers of a text file, or of a sheet.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "record.txt")
    ...     _ = path.write_text("time (s);force (kN)\\n0,0;1.001,5\\n0,1;2,5\\n")
    ...     table = number_table(path)
    >>> table.values.tolist(), table.unit(table.column("force")), table.notes
    ([[0.0, 1001.5], [0.1, 2.5]], 'kN', ("'1.001,5' in line 2 is read as 1001.5",))
    """
    if decimal not in (None, ".", ","):
        raise InputError(f'{path.name}: decimal: found {decimal!r}; expected "." or ","')
    lines = _lines(_sheet_text(path, sheet) if path.suffix.lower() in SHEETS else text_of(path))
    if header > len(lines):
        raise InputError(f"{path.name}: header: found {header}; the file has {counted(len(lines), 'line')}")
    start, separator, texts = _first(lines, header)
    if start is None:
        expected = f"columns of numbers between {', '.join(SEPARATORS.values())}"
        first = next((f" (the first one is {line[:40]!a})" for line in lines if line.strip()), "")
        clock = "; write times such as 12:30 with their seconds" if any(map(_SHORT_CLOCK.search, lines)) else ""
        raise InputError(f"{path.name}: found no line of numbers{first}; expected {expected}{clock}")
    above = _above(lines, header, start)
    columns = len(_entries(lines[start], separator))
    for number, line in above:
        entries = _entries(line, separator, columns)
        begins = bool(entries[0].strip()) and _number(entries[0], _Marks()) is not None
        begins |= _stamp(entries[0]) is not None and all(_value(entry, _Marks()) is not None for entry in entries)
        if number > header and begins and len(entries) == columns and not _is_comment(line):
            raise _wrong_line(path, number, line, separator, f", and header = {number} leaves out the first {number}")
    heads = tuple(head for _, line in reversed(above) if (head := _head(line, separator, columns)))
    if separator == "," and above and not header and not heads and columns == 2 * len(_entries(above[-1][1], separator)):
        raise InputError(
            f"{path.name}, line {start + 1}: found {columns} numbers under {columns // 2} names; commas that separate columns cannot begin "
            f"decimals, too: write decimal points or semicolons, or give header = {start} if these are {columns} columns"
        )
    if decimal is None and not texts and (quick := _read_digits(lines, start, separator, columns)) is not None:
        return NumberTable(path.name, *quick, heads)
    reader = _RowReader(path, separator, columns, texts, decimal)
    return reader.table(lambda: ((number, line) for number, line in enumerate(lines[start:], start + 1) if line.strip()), heads)


def _lines(text: str) -> list[str]:
    """The lines, which other signs than line feeds and carriage returns do not end."""
    return [line.strip("\n\f\x85") for line in io.StringIO(text, newline=None)]


#: A field in quotes that goes on in the next line.
_OPEN_FIELD = re.compile(r'(?:^|[,;\t])\s*"[^"]*$')


def _above(lines: list[str], header: int, start: int) -> list[tuple[int, str]]:
    """The filled lines above the numbers, by their number; names in quotes may go over several of them."""
    result: list[tuple[int, str]] = []
    is_open = False
    for number, line in enumerate(lines[:start], 1):
        if is_open:
            result[-1] = result[-1][0], f"{result[-1][1]} {line}"
        elif line.strip():
            result.append((number, line))
        is_open = number != header and bool(result) and _OPEN_FIELD.search(result[-1][1]) is not None
    return result


def _first(lines: list[str], header: int) -> tuple[int | None, str | None, frozenset[int]]:
    """The place of the first line of numbers, the separator, and columns of texts between those of numbers."""
    for place, line in _filled(lines, header):
        for separator in SEPARATORS:
            if (separator is None or separator in line) and not _texts_of(line, separator):
                return place, separator, frozenset()
    for (place, line), (_, after) in pairwise(_filled(lines, header)):  # columns such as OK or a name: two lines of one pattern
        for separator in SEPARATORS:
            texts = _texts_of(line, separator)
            entries = _entries(line, separator)
            alike = _texts_of(after, separator) == texts and len(_entries(after, separator)) == len(entries)
            if alike and texts and 0 not in texts and len(texts) <= len(entries) - 2:
                return place, separator, texts
    return None, None, frozenset()


def _filled(lines: list[str], header: int) -> Iterator[tuple[int, str]]:
    return ((place, lines[place]) for place in range(header, len(lines)) if lines[place].strip() and not _is_comment(lines[place]))


def _texts_of(line: str, separator: str | None) -> frozenset[int]:
    """The columns of a line that hold texts, numbers and dates aside; all of them where nothing is a number."""
    entries = _entries(line, separator)
    values = [_value(entry, _Marks()) for entry in entries]
    texts = frozenset(place for place, value in enumerate(values) if value is None)
    is_empty = all(value is None or value != value for value in values) and "nan" not in line.lower()
    is_empty |= len(values) == 1 and isinstance(values[0], _Stamp)  # times without values, of which an entry with a comma is made
    return frozenset(range(len(entries))) if is_empty else texts


def _read_digits(lines: list[str], start: int, separator: str | None, columns: int) -> tuple[np.ndarray, np.ndarray] | None:
    """Numbers and lines of a body of digits, signs and one mark alone, by NumPy's reader; None for any other."""
    comma = "" if separator == "," else ","
    body = lines[start:]
    signs = set("\n".join(body))
    marks = {mark for mark in (".", comma) if mark and mark in signs}
    if len(marks) > 1 or not signs <= set(f"0123456789+-eE \n{separator or ''}").union(marks):
        return None
    try:
        rows = [line.replace(",", ".") for line in body] if "," in marks else body
        values = np.loadtxt(rows, delimiter=separator, comments=None, ndmin=2)
    except ValueError:
        return None
    if values.shape[1] != columns:
        return None
    numbers = np.arange(start + 1, len(lines) + 1)
    if len(numbers) != len(values):
        numbers = numbers[[bool(line.strip()) for line in body]]
    return values, numbers


class _Marks:
    """Marks of decimals and of thousands, as far as the numbers of a file tell them."""

    def __init__(self, decimal: str | None = None, thousands: Iterable[str] = ()):
        self.decimals, self.thousands = {decimal} if decimal else set[str](), set(thousands)
        self.either = set[str]()  # marks of numbers such as 1.234, which may be both
        self.example = ""  # of a number with a mark of thousands
        self.is_grouped = False

    @property
    def agree(self) -> bool:
        """Whether one mark begins decimals, and no mark is both."""
        return len(self.decimals) <= 1 and len(self.thousands) <= 1 and not self.decimals & self.thousands

    @property
    def settled(self) -> _Marks | None:
        """The marks with which numbers that may be both are read again as whole ones; None where all are read already."""
        others = {mark for mark in self.either if self.decimals and mark not in self.decimals} - self.thousands
        again = others | (self.either & self.thousands)
        return _Marks(next(iter(self.decimals), None), self.thousands | others) if again else None


_UNGROUPED = re.compile(r"[+-]?(?:\d+([.,]?)\d*|([.,])\d+)(?:[eEdD][+-]?\d+)?")
_GROUPED = re.compile(r"([+-]?[1-9]\d{0,2}(?:([.,'’ \u00a0\u202f])\d{3})(?:\2\d{3})*)(?:(?!\2)([.,])(\d*))?")
_SPECIAL = re.compile(r"[+-]?(?:nan|inf|infinity)", re.IGNORECASE)


def _number(entry: str, marks: _Marks) -> float | None:
    """The number of an entry, nan for an empty one; None where it is none. Its marks are added to the others."""
    entry = entry.strip(' "\u00a0')
    if not entry:
        return np.nan
    ungrouped, grouped = _UNGROUPED.fullmatch(entry), _GROUPED.fullmatch(entry)
    mark = (ungrouped[1] or ungrouped[2] or "") if ungrouped else ""
    if grouped and (not ungrouped or mark in marks.thousands):
        marks.thousands.add(grouped[2])
        marks.example = marks.example or entry
        if grouped[3]:
            marks.decimals.add(grouped[3])
        return float(f"{grouped[1].replace(grouped[2], '')}.{grouped[4] or 0}")
    if not ungrouped:
        return float(entry) if _SPECIAL.fullmatch(entry) else None
    if mark:
        (marks.either if grouped else marks.decimals).add(mark)
    return float(entry.replace(",", ".").replace("d", "e").replace("D", "e"))


class _Stamp(NamedTuple):
    """A date, a time of day, or both."""

    date: tuple[int, int, int] | None  # as written
    sign: str  # between its parts
    clock: int | None  # nanoseconds of the day, in the time of Greenwich where a zone is given

    @property
    def readings(self) -> dict[str, int]:
        """The nanoseconds since 1970 by the possible orders of the date."""
        if self.date is None:
            return {"": self.clock or 0}
        result, (a, b, c) = {}, self.date
        orders = {"ymd": (a, b, c)} if a > 31 else {"dmy": (c, b, a), **({} if self.sign == "." else {"mdy": (c, a, b)})}
        for order, parts in orders.items():
            try:
                days = datetime.date(*parts).toordinal() - _EPOCH
            except ValueError:
                continue
            result[order] = days * 86_400 * 10**9 + (self.clock or 0)
        return result


_EPOCH = datetime.date(1970, 1, 1).toordinal()
_DATE = r"(?P<a>\d{1,4})(?P<sign>[-./])(?P<b>\d{1,2})(?P=sign)(?P<c>\d{1,4})"
_CLOCK = (
    r"(?:(?P<h>\d{1,4}):)?(?P<m>\d{1,2}):(?P<s>\d{2})(?:[.,](?P<f>\d{1,9}))?\s*(?P<half>[AaPp][Mm])?\s*(?P<zone>Z|[+-]\d\d:?\d\d)?"
)
_SHORT_CLOCK = re.compile(r"(?:^|[;,\s])\d{1,2}:\d\d(?:$|[;,\s])")  # hours or minutes first
_STAMP = re.compile(rf"{_DATE}(?:[T_ ]\s*{_CLOCK})?|{_CLOCK.replace('(?P<', '(?P<own_')}")


def _stamp(entry: str) -> _Stamp | None:
    match = _STAMP.fullmatch(entry.strip(' "'))
    if match is None:
        return None
    date = (int(match["a"]), int(match["b"]), int(match["c"])) if match["a"] else None
    if date and max(len(match["a"]), len(match["c"])) != 4:
        return None  # a year of two digits may be a day
    own = "" if date else "own_"
    hours, minutes, seconds, fraction, half, zone = (match[f"{own}{key}"] for key in ("h", "m", "s", "f", "half", "zone"))
    if minutes is None:
        return _Stamp(date, match["sign"], None)
    if hours is None and fraction is None:
        if date is None:
            return None  # 12:30 may be hours or minutes
        hours, minutes, seconds = minutes, seconds, "0"
    h, m, s = int(hours or 0), int(minutes), int(seconds)
    if m > 59 or s > 59:
        return None
    if half:
        h = h % 12 + 12 * (half.lower() == "pm")
    if zone and zone != "Z":
        shift = int(zone[1:3]) * 60 + int(zone[-2:])
        m -= shift if zone[0] == "+" else -shift
    clock = (h * 3600 + m * 60 + s) * 10**9 + int((fraction or "").ljust(9, "0"))
    return _Stamp(date, match["sign"] or "", clock)


def _value(entry: str, marks: _Marks) -> float | _Stamp | None:
    number = _number(entry, marks)
    return _stamp(entry) if number is None else number


class _RowReader:
    """The rows of a file, line by line, with all that NumPy's reader does not know."""

    def __init__(self, path: Path, separator: str | None, columns: int, texts: frozenset[int], decimal: str | None):
        self.path, self.separator, self.columns = path, separator, columns
        self.marks, self.texts, self.stamps = _Marks(decimal), dict.fromkeys(texts, ""), dict[int, list[_Stamp]]()
        self.example = (0, "", 0.0)

    def table(self, rows, heads: tuple[tuple[str, ...], ...]) -> NumberTable:
        """The table of the rows, which a function gives, since they may be read twice."""
        numbers, lines = self.read(rows())
        if settled := self.marks.settled:
            self.marks, self.stamps = settled, {}
            numbers, lines = self.read(rows())
        open_mark = self.marks.either == {","} and not self.marks.decimals
        if open_mark and self.separator == ",":
            raise InputError(
                f"{self.path.name}: all commas in its numbers may begin decimals or stand between thousands; give decimal, "
                '"," or ".", or write them with points'
            )
        values = np.array(numbers).reshape(-1, self.columns)
        notes = (f"{self.example[1]!a} in line {self.example[0]} is read as {self.example[2]:.12g}",) if self.example[0] else ()
        for place, seconds in self.seconds(len(values)).items():
            values[:, place] = seconds
        return NumberTable(self.path.name, values, np.array(lines), heads, frozenset(self.stamps), self.texts, notes)

    def read(self, rows: Iterator[tuple[int, str]]) -> tuple[array, array]:
        """All numbers in the order of reading, and the line of each row."""
        numbers, lines = array("d"), array("q")
        for number, line in rows:
            if _is_comment(line) or not line.strip(f" \t{self.separator or ''}"):
                continue
            row = self.row(number, line)
            if not self.marks.agree:
                raise InputError(
                    f"{self.path.name}, line {number}: found {line[:40]!a}; decimals have a point or a comma, not both in one file"
                )
            if self.marks.example and not self.example[0]:
                self.example = (number, self.marks.example, _number(self.marks.example, self.marks) or 0.0)
            numbers.extend(row)
            lines.append(number)
        return numbers, lines

    def row(self, number: int, line: str) -> list[float]:
        """The numbers of a line, nan for an empty entry, a text or a date."""
        entries, row = _entries(line, self.separator, self.columns), []
        for place, entry in enumerate(entries):
            value = _number(entry, self.marks)
            if value is None and place in self.texts:
                self.texts[place] = self.texts[place] or entry.strip()
                value = np.nan
            elif value is None and (stamp := _stamp(entry)):
                self.stamps.setdefault(place, []).append(stamp)
                value = np.nan
            if value is None:
                raise _wrong_line(self.path, number, line, self.separator)
            row.append(value)
        if all(value != value for value in row) and not self.stamps and "nan" not in line.lower():
            raise _wrong_line(self.path, number, line, self.separator)
        if len(row) != self.columns:
            hint = "; commas between thousands need quotes around the number, or another separator" * (self.separator == ",")
            raise InputError(
                f"{self.path.name}, line {number}: it has another number of columns than the lines before it "
                f"({len(row)}, not {self.columns}){hint}"
            )
        return row

    def seconds(self, count: int) -> dict[int, np.ndarray]:
        """The seconds of columns of dates and times of day after their first row; of a date and a time of day next to it of both."""
        result = {}
        for place, stamps in self.stamps.items():
            if len(stamps) != count:
                raise InputError(
                    f"{self.path.name}: column {place + 1}: found dates or times of day in some lines and not in others"
                )
            partner = next((other for other in (place + 1, place - 1) if len(self.stamps.get(other, ())) == count), None)
            if partner is not None:
                others = self.stamps[partner]
                if all(one.date is None for one in stamps):
                    stamps, others = others, stamps
                if all(one.clock is None for one in stamps) and all(one.date is None for one in others):
                    stamps = [_Stamp(one.date, one.sign, other.clock) for one, other in zip(stamps, others)]
            result[place] = self.since_first(place, stamps)
        return result

    def since_first(self, place: int, stamps: list[_Stamp]) -> np.ndarray:
        readings = [stamp.readings for stamp in stamps]
        orders = [order for order in readings[0] if all(order in one for one in readings)]
        times = [[one[order] - readings[0][order] for one in readings] for order in orders]
        if not times:
            raise InputError(f"{self.path.name}: column {place + 1}: found dates that do not exist, or in more than one order")
        if any(other != times[0] for other in times[1:]):
            raise InputError(
                f"{self.path.name}: column {place + 1}: day and month of the dates are ambiguous; write them as 2024-12-31"
            )
        return np.array(times[0], dtype=object).astype(float) / 1e9


def text_of(path: Path) -> str:
    """The text of a file: UTF-8, UTF-16, or the signs of Windows and Latin-1, which older instruments write; no NUL characters."""
    content = path.read_bytes()
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        encodings = ["utf-16"]
    elif b"\0" in content[:2]:  # without its mark
        encodings = ["utf-16-le" if content[1:2] == b"\0" else "utf-16-be"]
    else:
        encodings = ["utf-8-sig", "cp1252", "latin-1"]
    for encoding in encodings:
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise InputError(f"{path.name}: not a text file; expected lines of numbers")


def _entries(line: str, separator: str | None, columns: int = 0) -> list[str]:
    """The entries of a line; an empty one behind all columns is left out, as a sign that ends every line leaves it."""
    if separator is None:
        return line.split()
    line = line.strip(" \r\n")
    entries = next(csv.reader([line], delimiter=separator, skipinitialspace=True), [""]) if '"' in line else line.split(separator)
    return entries[:-1] if len(entries) > 1 and len(entries) != columns and not entries[-1].strip() else entries


def _head(line: str, separator: str | None, columns: int) -> tuple[str, ...]:
    """The names in a header line; none where it has not one for each column."""
    line = line.strip(" \r\n").lstrip("#%!/ ") if _is_comment(line) else line.strip(" \r\n")
    if separator is None:
        options = [line.split(), re.split(r"\s*[,;\t]\s*|\s{2,}", line.strip())]
    else:
        options = [next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]
        options += [[*options[0], ""], options[0][:-1] if options[0] and not options[0][-1].strip() else []]
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


# Sheets of Excel, as the text with tabs of the stored values of their cells: formulas, links and macros are never evaluated.

#: Cells of a sheet that are read at most.
MOST_CELLS = 20_000_000


def _save_sheet(path: str, sheet: str | None, most_cells: int) -> None:
    """Write the names of the sheets of a file, and the cells of the selected one: executed in a separate process."""
    import datetime
    import json

    import openpyxl

    book = openpyxl.load_workbook(path, read_only=True, data_only=True, keep_links=False)
    names = [one.title for one in book.worksheets]
    with open("sheets.json", "w") as file:
        json.dump(names, file)
    name = sheet or (names[0] if len(names) == 1 else None)
    if name not in names:
        return
    count, width, lines = 0, 0, []
    for row in book[name].iter_rows(values_only=True):
        count += len(row)
        if count > most_cells:
            raise ValueError(f"the sheet has more than {most_cells:,} cells")
        texts = []
        for value in row:
            if isinstance(value, (int, float)) and not isinstance(value, bool):
                texts.append(repr(value))
            elif isinstance(value, datetime.timedelta):
                micros = round(value.total_seconds() * 1e6)
                texts.append(f"{micros // 3_600_000_000}:{micros // 60_000_000 % 60:02}:{micros % 60_000_000 / 1e6:09.6f}")
            elif isinstance(value, (datetime.date, datetime.time)):
                texts.append(value.isoformat(*([" "] if isinstance(value, datetime.datetime) else [])))
            else:
                texts.append("" if value is None else '"' + " ".join(str(value).split()).replace('"', "'") + '"')
        while texts and not texts[-1]:
            texts.pop()
        width = max(width, len(texts))
        lines.append(texts)
    with open("sheet.txt", "w", encoding="utf-8") as file:
        for texts in lines:
            file.write("\t".join([*texts, *[""] * (width + 1 - len(texts))]) + "\n")


def _sheet_text(path: Path, sheet: str | None) -> str:
    import json
    import zipfile

    optional_package("openpyxl", "reading .xlsx files")
    failure = "not an Excel file of numbers"
    try:
        with zipfile.ZipFile(path) as archive:  # what a small file unpacks to is stated in it, and reading stops there
            size = sum(info.file_size for info in archive.infolist())
    except (zipfile.BadZipFile, ValueError, NotImplementedError, EOFError) as problem:
        raise InputError(f"{path.name}: {failure} ({problem})") from None
    if size > 4 * LARGEST_FILE:
        raise InputError(f"{path.name}: it unpacks to {size:,} bytes; at most {4 * LARGEST_FILE:,} are read")
    with read_isolated(_save_sheet, path, failure, sheet=sheet, most_cells=MOST_CELLS) as folder:
        sheets, text = folder / "sheets.json", folder / "sheet.txt"
        names = json.loads(sheets.read_text("utf-8")) if sheets.is_file() else []
        if names and sheet is None and len(names) > 1:
            raise InputError(f"{path.name}: holds the sheets {', '.join(names)}; give the name of one in array")
        if names and sheet is not None and sheet not in names:
            raise InputError(f"{path.name}: no sheet {sheet} in it{nearest(sheet, names)}; it holds {', '.join(names)}")
        if text.is_file():
            return text.read_text("utf-8")
    raise damaged(path, failure)
