"""Columns of numbers in a text file: comma, semicolon, tab or blanks between them, header lines and comments above them.

The first line of numbers decides which sign separates the columns. A decimal comma is read where the comma does not separate.
"""

from __future__ import annotations

import csv
import re
from array import array
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..ground.checks import counted, nearest
from ..ground.errors import InputError

COMMENTS = ("#", "%", "!", "//")
SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", None: "blanks"}
_UNIT = re.compile(r"[(\[]([^()\[\]]+)[)\]]\s*$")


@dataclass(frozen=True, eq=False)
class NumberTable:
    """The numbers of a text file.

    Attributes:
        file: its name, for messages.
        values: shape (rows, columns); nan where an entry is empty.
        lines: the line of each row in the file, shape (rows,).
        heads: the header and comment lines above the numbers that have an entry for each column, the last one first.
    """

    file: str
    values: np.ndarray = field(repr=False)
    lines: np.ndarray = field(repr=False)
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
        raise InputError(f"{path.name}: found no line of numbers; expected columns of numbers between {', '.join(_words())}")
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


def _words() -> list[str]:
    return list(SEPARATORS.values())


def _wrong_line(path: Path, number: int, line: str, separator: str | None, more: str = "") -> InputError:
    return InputError(
        f"{path.name}, line {number}: found {line[:40]!a}; expected numbers separated by {SEPARATORS[separator]}; "
        f"a line that begins with # is left out{more}"
    )
