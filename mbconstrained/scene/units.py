"""Quantities: a number in SI, or a text of a number and a unit such as "3 N/mm".

The text is taken apart by the pattern below before pint sees any of it, and pint is only ever given the
names of units: nothing in a scene file is evaluated. pint is imported at the first text, so a scene of plain
numbers never pays for it.
"""

from __future__ import annotations

import functools
import math
import re
from typing import NamedTuple

from ..checks import nearest
from ..errors import InputError

LONGEST_QUANTITY = 60  # characters; "-0.123456789012345678e-10 N*m*s/rad" has 36

LEAST, LARGEST = 1e-100, 1e100  # in SI; squares of what lies between stay within the range of float64

KINDS = {  # SI unit: (what it is called, an example)
    "1": ("a plain number", "2"),
    "kg": ("a mass", '"10 kg"'),
    "kg*m^2": ("a moment of inertia", '"0.02 kg*m^2"'),
    "m": ("a length", '"0.2 m"'),
    "m/s": ("a velocity", '"0.5 m/s"'),
    "m/s^2": ("an acceleration", '"-9.81 m/s^2"'),
    "rad": ("an angle", '"30 deg"'),
    "rad/s": ("an angular velocity", '"12 rad/s"'),
    "rad/s^2": ("an angular acceleration", '"3 rad/s^2"'),
    "N": ("a force", '"5 N"'),
    "N*m": ("a torque", '"2 N*m"'),
    "N/m": ("a stiffness", '"3 N/mm"'),
    "N*m/rad": ("a torsional stiffness", '"20 N*m/rad"'),
    "N*s/m": ("a damping coefficient", '"4 N*s/m"'),
    "N*m*s/rad": ("a torsional damping coefficient", '"0.1 N*m*s/rad"'),
    "N*s": ("an impulse", '"3 N*s"'),
    "s": ("a time", '"50 s"'),
    "Hz": ("a frequency", '"2 Hz"'),
    "1/s": ("a rate", '"-0.5 1/s"'),
}

_COMMON_UNITS = (
    "kg g t lb slug m mm cm um km in ft N kN mN MN Nm kNm Nmm Ns lbf kgf s ms us min h Hz kHz rpm rad deg rev "
    "J W Pa kPa MPa GPa bar"
).split()

#: Products that engineers write as one word; to pint, Nm is a fineness of yarn.
_RUN_TOGETHER = ("Nm = newton * meter", "Nmm = newton * millimeter", "Ns = newton * second")

_FACTOR = r"(?:[^\W\d_]+(?:\^-?[1-9])?|°)"
_UNIT = re.compile(rf"(?:1(?=/)|{_FACTOR}(?:\*{_FACTOR})*)(?:/{_FACTOR})*")  # a product after a division is ambiguous
_QUANTITY = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*(\S.*)", re.ASCII)


class Dimension(NamedTuple):
    """A unit in the base units of pint: exponents without the radian, and the exponent of the radian."""

    exponents: frozenset
    radian: float


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
    if isinstance(value, str) and unit != "1":
        return _finite(_from_text(value, unit), value, unit)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError(f"found {shown(value)}; expected {expected(unit)}")
    return _finite(value, value, unit)


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
    if isinstance(value, str):
        text = quoted(value[: longest + 1])
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


def _from_text(text: str, unit: str) -> float:
    number, found_unit = _split(text, unit)
    if unknown := _unknown_name(found_unit):
        same_letters = [name for name in _COMMON_UNITS if name.lower() == unknown.lower()]
        hint = nearest(unknown, _COMMON_UNITS) if not same_letters else f'; did you mean "{same_letters[0]}"?'
        raise InputError(f'found {shown(text)}, but there is no unit "{unknown}"{hint}; expected {expected(unit)}')
    found = _dimension(found_unit)
    if not _same_kind(found, unit):
        raise InputError(f"found {shown(text)}, {_describe(found)}; expected {expected(unit)}{_advice(found, unit)}")
    return float(_registry().convert(float(number), _unit(found_unit), _unit(unit)))


def _split(text: str, unit: str) -> tuple[str, str]:
    match = _QUANTITY.fullmatch(text.strip()) if len(text) <= LONGEST_QUANTITY else None
    found_unit = _plain_unit(match[2]) if match else ""
    if not _UNIT.fullmatch(found_unit):
        raise InputError(
            f"found {shown(text)}; expected {expected(unit)}; "
            "write one number, then a unit made of names, *, / and ^, such as N*s/m or kg*m^2"
        )
    return match[1], found_unit


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


def load_units() -> None:
    """Import pint and read its definitions of units."""
    _registry()


@functools.cache
def _registry():
    import pint

    registry = pint.UnitRegistry(on_redefinition="ignore")
    for definition in _RUN_TOGETHER:
        registry.define(definition)
    return registry


def _unknown_name(unit: str) -> str | None:
    return next((name for name in re.findall(r"[^\W\d_]+", unit) if name not in _registry()), None)


@functools.cache
def _unit(text: str):
    """A pint unit from a text that fits the pattern above and has only known names."""
    return _registry().parse_units(text)


@functools.cache
def _dimension(text: str) -> Dimension:
    root = (1 * _unit(text)).to_root_units()
    exponents = dict(root.unit_items())
    radian = exponents.pop("radian", 0)
    return Dimension(frozenset(exponents.items()), radian)


def _same_kind(found: Dimension, unit: str) -> bool:
    """Equal dimensions; N*m/rad may also be written N*m, as is common for torsion springs."""
    wanted = _dimension(unit)
    return found.exponents == wanted.exponents and found.radian in ((wanted.radian, 0) if wanted.radian < 0 else (wanted.radian,))


def _describe(found: Dimension) -> str:
    name = next((name for unit, (name, _) in KINDS.items() if unit != "1" and _dimension(unit) == found), None)
    return name or "which is another kind of quantity"


def _advice(found: Dimension, unit: str) -> str:
    if unit == "rad/s" and found == _dimension("Hz"):
        return "; a frequency in Hz is 2 pi times an angular frequency in rad/s: say which one is meant"
    if unit == "Hz" and found == _dimension("rad/s"):
        return "; an angular frequency in rad/s or rpm is 2 pi times a frequency: say which one is meant"
    return ""
