"""What a page reads, re-implemented: functions from its data, their values and the texts next to the names."""

import base64
import json
import math
import re
from fractions import Fraction

import numpy as np

from mbconstrained.page.readings import BOUNDS, interpolation

_SIGNS = {sign: digit for digit, sign in zip("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")}


class StoredFunctions:
    """Functions as the page's script has them, in parts."""

    def __init__(self, parts: list[dict], records: list[dict] = ()):
        self.parts = [StoredSteps(part, records[part["steps"]]) if "steps" in part else StoredPanels(part) for part in parts]

    def at(self, row: int, time: float) -> tuple[float, float]:
        """Value and bound of its error."""
        return next(part for part in reversed(self.parts) if time >= part.start or part is self.parts[0]).at(row, time)


class StoredSteps:
    """Functions by the steps of a record."""

    def __init__(self, data: dict, record: dict):
        self.start, self.gap, self.count, self.block = (record[key] for key in ("start", "gap", "count", "block"))
        self.samples = numbers(record["samples"], "<f4").astype(float).reshape(record["forces"], self.count + 1)
        self.first = numbers(record["first"], "<f8").reshape(-(-self.count // self.block), -1)
        self.matrix = numbers(record["matrix"], "<f8").reshape(self.first.shape[1], -1)
        self.degree, self.quadratic = data["degree"], data["quadratic"]
        self.bounds = numbers(data["bounds"], "<i2").astype(int).reshape(-1, len(self.first))
        self.rows = numbers(data["rows"], "<f8").reshape(self.degree + 1, len(self.bounds), -1)

    def at(self, row: int, time: float) -> tuple[float, float]:
        """Value and bound of its error."""
        gap = min(max(int((time - self.start) / self.gap), 0), self.count - 1)
        state = self.first[gap // self.block]
        for before in range(gap - gap % self.block, gap):
            around = self.samples[:, np.minimum([before, before + 1, before + 2], self.count)]
            state = self.matrix @ np.concatenate([state, around.T.ravel(), [1.0]])
        features = np.concatenate([state, self.samples[:, [gap, gap + 1]].T.ravel(), [1.0]])
        if self.quadratic:
            features = np.concatenate([features[i] * features[i:] for i in range(len(features))])
        share = np.clip(2 * (time - self.start) / self.gap - 2 * gap - 1, -1, 1)
        value = (interpolation(self.degree, np.array([share])) @ (self.rows[:, row] @ features))[0]
        return float(value), 2.0 ** self.bounds[row, gap // self.block]


class StoredPanels:
    """Functions by panels."""

    def __init__(self, data: dict):
        self.start = data["start"]
        self.degrees = numbers(data["degrees"], "u1").astype(int)
        count = len(self.degrees)
        if "edges" in data:
            inner = numbers(data["edges"], "<f8")
        else:
            inner = data["start"] + data["unit"] * np.cumsum(numbers(data["counts"], "<u2"), dtype=float)
        self.edges = np.concatenate([[data["start"]], inner, [data["end"]]])
        size = data["bytes"]
        codes = numbers(data["codes"], "u1").reshape(-1, size).astype(int) @ 256 ** np.arange(size)
        codes = np.where(codes >= 2 ** (8 * size - 1), codes - 2 ** (8 * size), codes)
        self.exponents = data["base"] + numbers(data["exponents"], "u1").astype(int).reshape(-1, count)
        self.places = np.concatenate([[0], np.cumsum(self.degrees + 1)])
        self.codes = codes.reshape(len(self.exponents), -1)

    def at(self, row: int, time: float) -> tuple[float, float]:
        """Value and bound of its error."""
        panel = min(max(int(np.searchsorted(self.edges[:-1], time, side="right")) - 1, 0), len(self.degrees) - 1)
        left, right, degree = self.edges[panel], self.edges[panel + 1], int(self.degrees[panel])
        if degree == 0:
            steps = 2.0 ** self.exponents[row, panel : panel + 2]
            line = self.codes[row, panel : panel + 2] * steps
            return float(line[0] + (line[-1] - line[0]) * (time - left) / ((right - left) or 1)), float(steps.max())
        share = 2 * (time - left) / (right - left) - 1 if right > left else 1.0
        codes = self.codes[row, self.places[panel] : self.places[panel + 1]]
        step = 2.0 ** self.exponents[row, panel]
        return float((interpolation(degree, np.array([share])) @ codes)[0]) * step, BOUNDS[degree] * step


def numbers(text: str, kind: str) -> np.ndarray:
    """Packed numbers."""
    return np.frombuffer(base64.b64decode(text), dtype=kind)


def functions_of_page(page: str) -> list[StoredFunctions]:
    """All sets of functions of a page."""
    return functions_of_data(json.loads(re.search(r'id="plot-data">(.*?)</script>', page)[1]))


def functions_of_data(data: dict) -> list[StoredFunctions]:
    """All sets of functions of plain data."""
    return [StoredFunctions(parts, data["records"]) for parts in data["sets"]]


def places_of_page(page: str) -> list[list[list[tuple[int, int]]]]:
    """Of each curve of each plot with lines, set and row of its functions: one, or two in a phase plane."""
    figures = re.findall(r'<figure class="plot-figure.*?</figure>', page, re.S)
    found = [re.findall(r'data-function="([\d ]+)"', figure) for figure in figures]
    return [[list(zip(*[iter(map(int, text.split()))] * 2)) for text in texts] for texts in found]


def certain(value: float, error: float) -> tuple[int, int]:
    """The whole number and the power of ten that a reading shows: at most four digits, none of which the error could change."""
    for digits in (4, 3, 2, 1):
        if value == 0:
            break
        power = math.floor(math.log10(abs(value))) - digits + 1
        low, high = (math.floor((value + side * error) / 10.0**power + 0.5) for side in (-1, 1))
        if low == high != 0:
            return low, power
    return 0, 0


def shown(text: str) -> tuple[Fraction, Fraction, int]:
    """Of a displayed number, such as "−1.60·10⁻⁵ J": the number, the unit of its last digit, and its significant digits."""
    sign, number, power = re.match(r"(−?)([\d.]+)(?:·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?", text).groups()
    scale = Fraction(10) ** int("".join(_SIGNS[each] for each in power or "⁰"))
    last = scale / 10 ** len(number.partition(".")[2])
    digits = number.replace(".", "").lstrip("0")
    return scale * Fraction(number) * (-1 if sign else 1), last, len(digits)
