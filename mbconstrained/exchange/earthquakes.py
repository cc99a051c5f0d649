"""Records of ground motion: PEER (.AT2, .VT2, .DT2), K-NET and KiK-net, and the DYNA files of ESM and ITACA, all text."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.constants import g as STANDARD_GRAVITY

from ..ground.errors import InputError

GAL = 0.01  # m/s^2
HEADER_LINES = 80  # in which a format is recognized; DYNA has 64


class GroundMotion(NamedTuple):
    """A record of even steps.

    Attributes:
        step: between samples, in s.
        values: shape (T,), in the unit.
        unit: "m", "m/s" or "m/s^2".
        name: of the record.
    """

    step: float
    values: np.ndarray
    unit: str
    name: str


def ground_motion(file: str, text: str) -> GroundMotion | None:
    """The record in a text of one of the formats; None for any other text.

    >>> record = ground_motion("a.AT2", "PEER\\nquake\\nACCELERATION TIME SERIES IN UNITS OF G\\nNPTS= 2, DT= .005 SEC\\n .1 -.2\\n")
    >>> record.step, record.values.round(4).tolist(), record.unit
    (0.005, [0.9807, -1.9613], 'm/s^2')
    """
    lines = text.splitlines()
    head = lines[:HEADER_LINES]
    reader = next((reader for is_it, reader in _FORMATS if any(re.search(is_it, line) for line in head)), None)
    return reader(file, lines) if reader else None


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
    """All numbers from a line on, in the order of reading."""
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
