"""Variations of a parameter: ranges, lists and distributions, as texts such as "1..3 N/mm:50" or "normal(10 kg, 2 %)"."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..ground.by_name import answering
from ..ground.errors import InputError, shown
from ..ground.quantities import Dimension, any_quantity, described, unit_of

#: Values of one range or list: more are another kind of study.
MOST_VALUES = 1_000_000

FORMS = '"1..3 N/mm:50", "1 N/mm, 2 N/mm", "normal(10 kg, 2 %)", "lognormal(10 kg, 2 %)", "uniform(1 kg, 2 kg)", "1..3 N/mm"'

_CALL = re.compile(r"(normal|lognormal|uniform)\s*\((.*)\)")
_NUMBER = re.compile(r"[-+]?(\d|\.\d)")
_COUNT = re.compile(r"(.*\.\..*?)(?::\s*(\S+?)\s*(log)?)?\s*")
_PERCENT = re.compile(r"([-+]?[\d.eE+-]+)\s*%")


@dataclass(frozen=True)
class Values:
    """Given values, combined with all values of other parameters."""

    values: tuple[Any, ...]  # numbers in SI, or texts
    unit: str = ""  # unit of the numbers in SI; an empty string for plain numbers and texts

    @property
    def nominal(self):
        """The first of texts, the middle one of numbers."""
        return self.values[0 if self.is_text else len(self.values) // 2]

    @property
    def is_text(self) -> bool:
        """Whether texts are varied, such as names of files."""
        return isinstance(self.values[0], str)

    @property
    def ends(self) -> tuple[float, float]:
        """Lowest and highest value."""
        return min(self.values), max(self.values)

    def to_dict(self) -> dict:
        return {"values": list(self.values), "unit": self.unit}


@dataclass(frozen=True)
class Distribution:
    """Random values."""

    kind: str  # "uniform", "normal" or "lognormal"
    first: float  # the ends of a uniform distribution; or mean and standard deviation, of a lognormal one those of the value itself
    second: float
    low: float = -math.inf  # limits of the truncation
    high: float = math.inf
    unit: str = ""  # in SI; an empty string for plain numbers

    @cached_property
    def _whole(self):
        """The distribution without truncation."""
        from scipy import stats

        if self.kind == "uniform":
            return stats.uniform(self.first, self.second - self.first)
        if self.kind == "normal":
            return stats.norm(self.first, self.second)
        spread = math.sqrt(math.log1p((self.second / self.first) ** 2))
        return stats.lognorm(spread, scale=self.first * math.exp(-(spread**2) / 2))

    @property
    def _limits(self) -> tuple[float, float]:
        return float(self._whole.cdf(self.low)), float(self._whole.cdf(self.high))

    @property
    def mass(self) -> float:
        """The probability within the truncation."""
        low, high = self._limits
        return high - low

    def inverse(self, probabilities: np.ndarray) -> np.ndarray:
        """The quantiles at probabilities, within the truncation.

        >>> Distribution("uniform", 1.0, 3.0).inverse(np.array([0.0, 0.25])).tolist()
        [1.0, 1.5]
        """
        low, high = self._limits
        return np.clip(self._whole.ppf(low + (high - low) * probabilities), self.low, self.high)

    @property
    def nominal(self) -> float:
        """The median."""
        return float(self.inverse(np.array(0.5)))

    @property
    def ends(self) -> tuple[float, float]:
        """The ends of a uniform distribution, the quantiles of 5 and 95 % of others."""
        low, high = self.inverse(np.array([0.0, 1.0] if self.kind == "uniform" else [0.05, 0.95])).tolist()
        return low, high

    def to_dict(self) -> dict:
        limits = [None if math.isinf(end) else end for end in (self.low, self.high)]
        return {"distribution": self.kind, "parameters": [self.first, self.second], "truncated": limits, "unit": self.unit}


Variation = Values | Distribution


@answering
def linspace(start, stop, count: int) -> Values:
    """Evenly spaced values of a parameter, both ends included.

    Args:
        start, stop: numbers in SI or texts with a unit.
        count: count of values.

    Returns:
        The values.

    Raises:
        InputError: ends of different kinds, equal ends, fewer than two values.

    >>> linspace("1 N/mm", "3 N/mm", 3)
    Values(values=(1000.0, 2000.0, 3000.0), unit='N/m')
    """
    (first, last), kind = _numbers([start, stop])
    return Values(tuple(np.linspace(first, last, _count(count, first, last)).tolist()), _unit(kind))


def variation_of(given) -> Variation:
    """The variation given by a text, a list, or an array of numbers.

    >>> variation_of("1..3 N/mm:3")
    Values(values=(1000.0, 2000.0, 3000.0), unit='N/m')
    >>> variation_of("normal(10 kg, 2 %)")
    Distribution(kind='normal', first=10.0, second=0.2, low=-inf, high=inf, unit='kg')
    """
    if isinstance(given, (Values, Distribution)):
        return given
    if isinstance(given, str):
        return _of_text(given.strip())
    if isinstance(given, np.ndarray):
        given = given.tolist()
    if not isinstance(given, (list, tuple, range)):
        raise InputError(f"found {shown(given)}; expected a range, a list or a distribution: {FORMS}")
    return _list(list(given))


def _of_text(text: str) -> Variation:
    if call := _CALL.fullmatch(text):
        return _distribution(call[1], [part.strip() for part in call[2].split(",")], text)
    if ".." in text and "," not in text and _NUMBER.match(text):
        match = _COUNT.fullmatch(text)
        first, _, last = match[1].partition("..")
        (low, high), kind = _numbers([first.strip(), last.strip()])
        if not low < high:
            raise InputError(
                f"found {shown(text)}, a range that is {'empty' if low == high else 'reversed'}; expected one that ascends"
            )
        if match[2] is None:
            return Distribution("uniform", low, high, unit=_unit(kind))
        count = _count(int(match[2]) if match[2].isdecimal() else match[2], low, high)
        if match[3] and not low > 0:
            raise InputError(f"found {shown(text)}; even steps of the logarithm need a positive start")
        spaced = np.geomspace if match[3] else np.linspace
        return Values(tuple(spaced(low, high, count).tolist()), _unit(kind))
    return _list([part.strip() for part in text.split(",")])


def _list(entries: list) -> Values:
    if not entries or any(entry == "" for entry in entries):
        raise InputError(f"found an empty list or value; expected a range, a list or a distribution: {FORMS}")
    if all(isinstance(entry, str) and not _NUMBER.match(entry) for entry in entries):
        values: tuple = tuple(entries)
        unit = ""
    else:
        numbers, kind = _numbers(entries)
        values, unit = tuple(numbers), _unit(kind)
    if len(set(values)) < len(values):
        raise InputError(f"a value is given twice in a list of {len(values)}; once is enough")
    return Values(values, unit)


def _distribution(kind: str, parts: Sequence[str], text: str) -> Distribution:
    if kind == "uniform":
        if len(parts) != 2:
            raise InputError(f"found {shown(text)}; expected the two ends, e.g. uniform(1 kg, 2 kg)")
        (low, high), dimension = _numbers(list(parts))
        if not low < high:
            raise InputError(
                f"found {shown(text)}, whose range is {'empty' if low == high else 'reversed'}; expected ends that ascend"
            )
        return Distribution(kind, low, high, unit=_unit(dimension))
    if len(parts) not in (2, 3):
        raise InputError(
            f"found {shown(text)}; expected mean and standard deviation, and perhaps limits: {kind}(10 kg, 2 %, 9.5..10.5 kg)"
        )
    limits = parts[2].partition("..")[::2] if len(parts) == 3 else ()
    percent = _PERCENT.fullmatch(parts[1])
    given = [parts[0], *([] if percent else [parts[1]]), *(limit.strip() for limit in limits)]
    numbers, dimension = _numbers(given)
    mean = numbers.pop(0)
    try:
        deviation = abs(mean) * float(percent[1]) / 100 if percent else numbers.pop(0)
    except ValueError:
        raise InputError(f"found {shown(text)}; expected a number before %") from None
    low, high = numbers or (-math.inf, math.inf)
    if not deviation > 0:
        raise InputError(f"found {shown(text)}, without variance; expected a standard deviation above 0, or set the value by --set")
    if kind == "lognormal" and not mean > 0:
        raise InputError(f"found {shown(text)}; a lognormal distribution has a positive mean")
    if not low < high:
        raise InputError(
            f"found {shown(text)}, whose limits are {'equal' if low == high else 'reversed'}; expected limits that ascend"
        )
    result = Distribution(kind, mean, deviation, low, high, _unit(dimension))
    if not result.mass > 0:
        raise InputError(f"found {shown(text)}; the distribution has no values between its limits")
    return result


def _numbers(entries: Sequence) -> tuple[list[float], Dimension | None]:
    """The values in SI of entries of one kind; entries of a text without a unit have that of the last one."""
    *before, last = entries
    value, kind = any_quantity(_number_or_text(last))
    values = []
    for entry in before:
        own = _number_or_text(entry)
        if isinstance(own, float) and isinstance(entry, str) and isinstance(last, str) and kind is not None:
            own = f"{entry} {last.lstrip('+-.0123456789eE ').strip()}"
        number, other = any_quantity(own)
        if (other is None) != (kind is None) or (other is not None and described(other) != described(kind)):
            kinds = [described(each) if each else "a plain number" for each in (other, kind)]
            raise InputError(f"found {shown(entry)}, {kinds[0]}, and {shown(last)}, {kinds[1]}; expected values of one kind")
        values.append(number)
    return [*values, value], kind


def _number_or_text(entry):
    """A text of digits alone is a plain number."""
    if not isinstance(entry, str):
        return entry
    try:
        return float(entry)
    except ValueError:
        return entry


def _unit(kind: Dimension | None) -> str:
    return "" if kind is None else unit_of(kind)


def _count(count, first: float, last: float) -> int:
    if first == last:
        raise InputError(f"found a range from {first:g} to {last:g}, which is empty; expected two different ends")
    if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or not 2 <= count <= MOST_VALUES:
        raise InputError(f"found {shown(count)} values of a range; expected a whole number from 2 to {MOST_VALUES:,}")
    return int(count)
