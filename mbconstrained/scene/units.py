"""Quantities: a number in SI, or a text of a number and a unit such as "3 N/mm".

The text is taken apart by the pattern below before pint sees any of it, and pint is only ever given the
names of units: nothing in a scene file is evaluated. pint is imported at the first text, so a scene of plain
numbers never pays for it.
"""

from __future__ import annotations

import math
import re

from ..checks import nearest
from ..errors import InputError
from .dimensions import KINDS, Dimension, advice, described, dimension, registry, same_kind, unit_named
from .expressed import Expressed

LONGEST_QUANTITY = 60  # characters; "-0.123456789012345678e-10 N*m*s/rad" has 36

ANOTHER = "which is another kind of quantity"

LEAST, LARGEST = 1e-100, 1e100  # in SI; squares of what lies between stay within the range of float64

_COMMON_UNITS = (
    "kg g t lb slug m mm cm um km in ft N kN mN MN Nm kNm Nmm Ns lbf kgf s ms us min h Hz kHz rpm rad deg rev "
    "J W Pa kPa MPa GPa bar"
).split()

_FACTOR = r"(?:[^\W\d_]+(?:\^-?[1-9])?|°)"
_UNIT = re.compile(rf"(?:1(?=/)|{_FACTOR}(?:\*{_FACTOR})*)(?:/{_FACTOR})*")  # a product after a division is ambiguous
_QUANTITY = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*(\S.*)", re.ASCII)


def quantity(value, unit: str) -> float:
    """The value in the given SI unit: a finite number as it stands, or a text with a unit of the same kind.

    Angles count as a kind of their own, so "2 Hz" is no angular velocity and "300 rpm" no frequency: the factor
    2 pi between them is never guessed.

    >>> quantity("3 N/mm", "N/m")
    3000.0
    >>> quantity(0.5, "m")
    0.5

    Raises:
        InputError: not a finite number, not a number with a unit, unknown unit, or a unit of another kind.
    """
    if isinstance(value, Expressed):
        return _checked(value, unit)
    if isinstance(value, str) and unit != "1":
        return _finite(_from_text(value, unit), value, unit)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError(f"found {shown(value)}; expected {expected(unit)}")
    return _finite(value, value, unit)


def any_quantity(value) -> tuple[float, Dimension | None]:
    """A quantity of any kind in SI, and its kind: None for a plain number, which may be anything in SI.

    Raises:
        InputError: as ``quantity``.

    >>> any_quantity(2)
    (2.0, None)
    """
    if not isinstance(value, str):
        return quantity(value, "1"), None
    number, unit = _split(value, 'a quantity, e.g. 2.0 or "10 kg"')
    _check_known(value, unit, 'a quantity, e.g. "10 kg"')
    try:
        if (0 * unit_named(unit)).to_base_units().magnitude:
            raise ValueError("its zero is not that of SI")
        found, kind = (float(number) * unit_named(unit)).to_base_units().magnitude, dimension(unit)
    except (TypeError, ValueError):  # what pint says of degrees Celsius and of decibels
        raise InputError(f"found {shown(value)}; expected a unit that is a multiple of one of SI") from None
    return _finite(found, value, "1"), kind


def in_range(number, text: str) -> float:
    """The value of an expression as a float.

    Raises:
        InputError: it is not 0 and not of a size that machines have.
    """
    try:
        return _finite(number, text, "1")
    except InputError:
        size = "of a size beyond 1e308" if abs(number) > LARGEST**3 else f"{float(number):g}"
        raise InputError(f"found {shown(text)}, which is {size}; expected 0 or a size between {LEAST:g} and {LARGEST:g}") from None


def expected(unit: str) -> str:
    """What a quantity of this unit looks like, for messages.

    >>> expected("kg")
    'a mass, e.g. "10 kg", or a number in kg'
    """
    if unit == "1":
        return "a plain number"
    name, example = KINDS.get(unit, (f"a quantity in {unit}", f'"2 {unit}"'))
    return f"{name}, e.g. {example}, or a number in {unit}"


def unit_name(value) -> str:
    """The name of a unit, written in one way; "1" for a plain number.

    Raises:
        InputError: no name of a unit.

    >>> unit_name("N m"), unit_name("1")
    ('N*m', '1')
    """
    text = _plain_unit(value.strip()) if isinstance(value, str) and len(value) <= LONGEST_QUANTITY else ""
    if text in KINDS:
        return text
    if not _UNIT.fullmatch(text):
        raise InputError(f'found {shown(value)}; expected a unit such as "m", "rad/s" or "V", or "1" for a plain number')
    if unknown := _unknown_name(text):
        raise InputError(f'found {shown(value)}, but there is no unit "{unknown}"{nearest(unknown, _COMMON_UNITS)}')
    return text


def shown(value, longest: int = 60) -> str:
    """A value as it is quoted in a message: texts in double quotes, control characters escaped, never long."""
    if isinstance(value, (str, Expressed)):
        text = quoted((value.text if isinstance(value, Expressed) else value)[: longest + 1])
    elif isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, dict):
        text = "a table"
    elif isinstance(value, list):
        text = f"an array of {len(value)}"
    elif isinstance(value, int) and abs(value) > 10**18:
        text = "a whole number of more than 18 digits"
    else:
        text = str(value)
    return text if len(text) <= longest + 2 else text[:longest] + "..."


def quoted(text: str) -> str:
    """The text in double quotes with every unprintable character escaped."""
    return '"' + "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text) + '"'


def _finite(number, value, unit: str) -> float:
    try:
        number = float(number)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"found {shown(value)}; expected a finite number" + (f": {expected(unit)}" if unit != "1" else ""))
    if number and not LEAST <= abs(number) <= LARGEST:
        raise InputError(f"found {shown(value)}; expected 0 or a size between {LEAST:g} and {LARGEST:g}: no machine has others")
    return number


def _checked(value: Expressed, unit: str) -> Expressed:
    """An expression of parameters whose kind, as far as it is known, is that of the unit."""
    if unit != "1" and value.dimension is not None and not same_kind(value.dimension, unit):
        found = described(value.dimension, ANOTHER)
        named = "; a number in an expression has no unit: give what has one a name in [parameters]"
        hint = advice(value.dimension, unit) or ("" if value.dimension.exponents else named)
        raise InputError(f"found {shown(value)}, {found}; expected {expected(unit)}{hint}")
    return value


def _from_text(text: str, unit: str) -> float:
    number, found_unit = _split(text, expected(unit))
    _check_known(text, found_unit, expected(unit))
    found = dimension(found_unit)
    if not same_kind(found, unit):
        hint = advice(found, unit) or _other_case(number, found_unit, unit)
        raise InputError(f"found {shown(text)}, {described(found, ANOTHER)}; expected {expected(unit)}{hint}")
    return float(registry().convert(float(number), unit_named(found_unit), unit_named(unit)))


def _other_case(number: str, found: str, unit: str) -> str:
    """Seconds and siemens differ in a letter's size."""
    small = found.lower()
    fits = small != found and not _unknown_name(small) and same_kind(dimension(small), unit)
    return f'; did you mean "{number} {small}"?' if fits else ""


def _check_known(text: str, unit: str, wanted: str) -> None:
    if unknown := _unknown_name(unit):
        same_letters = [name for name in _COMMON_UNITS if name.lower() == unknown.lower()]
        hint = nearest(unknown, _COMMON_UNITS) if not same_letters else f'; did you mean "{same_letters[0]}"?'
        raise InputError(f'found {shown(text)}, but there is no unit "{unknown}"{hint}; expected {wanted}')


def _split(text: str, wanted: str) -> tuple[str, str]:
    match = _QUANTITY.fullmatch(text.strip()) if len(text) <= LONGEST_QUANTITY else None
    found_unit = _plain_unit(match[2]) if match else ""
    if not _UNIT.fullmatch(found_unit):
        raise InputError(f"found {shown(text)}; expected {wanted}; {_how_to_write(text)}")
    return match[1], found_unit


def _how_to_write(text: str) -> str:
    """What is wrong with a text that is no number with a unit."""
    if re.match(r"\s*[+-]?\d+,\d", text):
        return f"decimals have a point: {quoted(text.replace(',', '.', 1))}"
    if re.fullmatch(r"\s*[+-]?[\d.]+([eE][+-]?\d+)?\s*", text):
        return "write its unit too, or the number without quotes, which is then in SI"
    return "write one number, then a unit made of names, *, / and ^, such as N*s/m or kg*m^2"


def _plain_unit(text: str) -> str:
    """One way of writing: ** and superscripts become ^, a dot or a space between two units becomes *."""
    text = text.replace("**", "^").replace("·", "*").replace("²", "^2").replace("³", "^3")
    return re.sub(r"\s+", "*", re.sub(r"\s*([*/^])\s*", r"\1", text))


def count_texts(data) -> int:
    """How many texts in tables and arrays look like a number with a unit."""
    if isinstance(data, str):
        return int(len(data) <= LONGEST_QUANTITY and bool(_QUANTITY.fullmatch(data)))
    if isinstance(data, dict):
        data = list(data.values())
    return sum(map(count_texts, data)) if isinstance(data, list) else 0


def _unknown_name(unit: str) -> str | None:
    return next((name for name in re.findall(r"[^\W\d_]+", unit) if name not in registry()), None)
