"""Quantities: a number in SI, a text of a number and a unit such as "3 N/mm", or the value of an expression of parameters.

A pattern splits a text into its number and names of units; nothing in a text is executed.
"""

from __future__ import annotations

import functools
import math
import re
from collections import Counter
from typing import Any, NamedTuple

from .errors import InputError, quoted, shown
from .units import instead_of, unit_in_si, unknown_name

KINDS = {  # SI unit: (what it is called, an example)
    "1": ("a plain number", "2"),
    "kg": ("a mass", '"10 kg"'),
    "kg*m": ("an unbalance, mass times eccentricity", '"20 g*mm"'),
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


class Dimension(NamedTuple):
    """A kind of quantity: exponents of the base units, and of the radian."""

    units: tuple[tuple[str, int], ...]  # ascending by name, without the radian
    radian: int | None  # None in products, where radians may be written or not

    def times(self, other: Dimension, power: int = 1) -> Dimension:
        """The kind of a product with a power, -1 for a quotient."""
        exponents = Counter(dict(self.units))
        exponents.update({unit: power * exponent for unit, exponent in other.units})
        return Dimension(tuple(sorted((unit, exponent) for unit, exponent in exponents.items() if exponent)), None)

    def power(self, exponent: int) -> Dimension:
        """The kind of a power."""
        return Dimension((), None).times(self, exponent)


def unit_of(kind: Dimension) -> str:
    """The SI unit of a kind of quantity.

    >>> unit_of(dimension("N/mm"))
    'N/m'
    """
    if not kind.units and not kind.radian:
        return "1"
    if known := next((unit for unit in KINDS if unit != "1" and same_kind(kind, unit)), ""):
        return known
    powers = [(name if abs(power) == 1 else f"{name}^{abs(power)}", power > 0) for name, power in kind.units]
    above = "*".join(text for text, is_above in powers if is_above) or "1"
    return "/".join([above, *(text for text, is_above in powers if not is_above)])


@functools.cache
def dimension(text: str) -> Dimension:
    """The kind of a unit."""
    exponents = dict(unit_in_si(text)[1])
    radian = exponents.pop("rad", 0)
    return Dimension(tuple(sorted(exponents.items())), radian)


def same_kind(kind: Dimension, unit: str) -> bool:
    """Whether dimensions are equal; N*m/rad may also be written N*m, as is common for torsion springs."""
    wanted = dimension(unit)
    if kind.radian is None:  # radians are not written in products
        return kind.units == wanted.units
    return kind.units == wanted.units and kind.radian in ((wanted.radian, 0) if wanted.radian < 0 else (wanted.radian,))


def described(kind: Dimension, otherwise: str = "another kind of quantity") -> str:
    """The name of a kind of quantity."""
    if not kind.units and not kind.radian:
        return "a plain number"
    radians = (kind.radian,) if kind.radian is not None else (0, 1, -1)
    kinds = [Dimension(kind.units, radian) for radian in radians]
    name = next((name for unit, (name, _) in KINDS.items() if unit != "1" and dimension(unit) in kinds), None)
    return name or otherwise


def meant(unit: str, expected: str | None) -> str:
    """The intended unit: g alone is the standard acceleration of gravity where an acceleration is expected, not a gram.

    >>> meant("g", "m/s^2"), meant("g", "kg")
    ('gn', 'g')
    """
    return "gn" if unit == "g" and expected == "m/s^2" else unit


def advice(text: str, number: float, kind: Dimension, unit: str) -> str:
    """A hint where hertz and radians per second, or masses and weights, are confused.

    >>> advice("3 Hz", 3.0, dimension("Hz"), "rad/s")
    '; an angular frequency is 2 pi times the frequency: write "18.8496 rad/s", or frequency = "3 Hz"'
    """
    if text.startswith("=") and (unit, unit_of(kind)) in (("Hz", "rad/s"), ("rad/s", "Hz")):
        inside = text[1:].strip() if text[1:].strip().isidentifier() else f"({text[1:].strip()})"
        return f'; a cycle is a turn of 2 pi: write "={inside}{"/" if unit == "Hz" else "*"}(1 rev)"'
    if unit == "rad/s" and kind == dimension("Hz"):
        angular = f"{2 * math.pi * number:.6g} rad/s"
        return f'; an angular frequency is 2 pi times the frequency: write "{angular}", or frequency = "{text}"'
    if unit == "Hz" and kind == dimension("rad/s"):
        frequency = f"{number / (2 * math.pi):.6g} Hz"
        return f'; a frequency is the angular frequency divided by 2 pi: write "{frequency}", or angular_frequency = "{text}"'
    if unit == "m/s^2" and kind == dimension("kg"):
        return '; the standard acceleration of gravity is gn, or g alone: write "0.3 gn"'
    if unit == "N" and kind == dimension("kg"):
        return "; the weight of a mass is given in N, lbf or kgf"
    if "A" in dict(kind.units) and unit != "s" and "A" not in dict(dimension(unit).units):
        return '; of a circuit, the coordinates of matrices have their unit in units below [model], e.g. units = { charge = "C" }'
    return ""


#: Units that count turns, so that a frequency of rotation may have them.
COUNTS_TURNS = frozenset(["rpm", "rev", "revs", "revolution", "revolutions", "turn", "turns"])

LONGEST_QUANTITY = 60  # characters; "-0.123456789012345678e-10 N*m*s/rad" has 36

ANOTHER = "which is another kind of quantity"

LEAST, LARGEST = 1e-100, 1e100  # in SI; squares of what lies between stay within the range of float64

_FACTOR = r"[^\W\d_]+(?:\^-?[1-9])?"
_UNIT = re.compile(rf"(?:1(?=/)|{_FACTOR}(?:\*{_FACTOR})*)(?:/{_FACTOR})*")  # a product after a division is ambiguous
_DIGITS = r"\d+(?:_\d+)*"
_QUANTITY = re.compile(rf"([+-]?(?:{_DIGITS}\.?(?:{_DIGITS})?|\.{_DIGITS})(?:[eE][+-]?\d{{1,3}})?)\s*(\S.*)", re.ASCII)


def quantity(value, unit: str) -> float:
    """The value in the given SI unit: a finite number, or a text with a unit of the same kind.

    Angles count as a kind of their own, so "2 Hz" is no angular velocity and "3 rad/s" no frequency: the factor 2 pi between them is
    never guessed. A number of turns leaves no doubt: "300 rpm" is the frequency of 5 Hz, and the angular velocity of 31.4 rad/s.

    >>> quantity("3 N/mm", "N/m"), quantity("300 rpm", "Hz")
    (3000.0, 5.0)
    >>> quantity(0.5, "m")
    0.5
    """
    if isinstance(value, Expressed):
        return _checked(value, unit)
    if isinstance(value, str) and unit != "1":
        return _finite(_from_text(value, unit), value, unit)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        hint = f"; {_how_to_write(value)}" if isinstance(value, OfParameters) else ""
        raise InputError(f"found {shown(value)}; expected {expected(unit)}{hint}")
    return _finite(value, value, unit)


def any_quantity(value) -> tuple[float, Dimension | None]:
    """A quantity of any kind in SI, and its dimension: None for a plain number; expressions stay unevaluated.

    >>> any_quantity(2)
    (2.0, None)
    """
    if not isinstance(value, str):
        return quantity(value, "1"), getattr(value, "dimension", None)
    number, unit = _split(value)
    return _finite(_in_si(number, unit), value, "1"), dimension(unit)


def number_and_unit(text: str) -> tuple[float, str]:
    """The number of a text, and what stands behind it, which is checked by who knows that unit.

    >>> number_and_unit("0.04 g^2/Hz"), number_and_unit("2 (m/s^2)^2/Hz")
    ((0.04, 'g^2/Hz'), (2.0, '(m/s^2)^2/Hz'))
    """
    match = _QUANTITY.fullmatch(text.strip()) if len(text) <= LONGEST_QUANTITY else None
    if not match:
        raise InputError(f"found {shown(text)}; expected a number with its unit")
    return _finite(match[1], text, "1"), match[2]


def in_range(number, text: str) -> float:
    """The value of an expression as a float."""
    try:
        return _finite(number, text, "1")
    except InputError:
        size = "of a size beyond 1e308" if abs(number) > LARGEST**3 else f"{float(number):g}"
        raise InputError(f"found {shown(text)}, which is {size}; expected 0 or a size between {LEAST:g} and {LARGEST:g}") from None


def expected(unit: str) -> str:
    """Description of the expected quantity for messages.

    >>> expected("kg")
    'a mass, e.g. "10 kg", or a number in kg'
    """
    if unit == "1":
        return "a plain number"
    name, example = KINDS.get(unit, (f"a quantity in {unit}", f'"2 {unit}"'))
    return f"{name}, e.g. {example}, or a number in {unit}"


def unit_name(value) -> str:
    """The name of a unit in normal form; "1" for a plain number.

    >>> unit_name("N m"), unit_name("1")
    ('N*m', '1')
    """
    text = _normal_unit(value.strip()) if isinstance(value, str) and len(value) <= LONGEST_QUANTITY else ""
    if text in KINDS:
        return text
    if not _UNIT.fullmatch(text):
        raise InputError(f'found {shown(value)}; expected a unit such as "m", "rad/s" or "V", or "1" for a plain number')
    if unknown := unknown_name(text):
        raise InputError(f"found {shown(value)}, but {instead_of(unknown)}")
    return text


def _finite(number, value, unit: str) -> float:
    try:
        number = float(number)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"found {shown(value)}; expected a finite number" + (f": {expected(unit)}" if unit != "1" else ""))
    if number and not LEAST <= abs(number) <= LARGEST:
        raise InputError(f"found {shown(value)}; expected 0 or a size between {LEAST:g} and {LARGEST:g}")
    return number


def _checked(value: Expressed, unit: str) -> Expressed:
    """An expression of parameters whose dimension, as far as it is known, is that of the unit."""
    if unit != "1" and value.dimension is not None and not same_kind(value.dimension, unit):
        kind = described(value.dimension, ANOTHER)
        named = f'; numbers in an expression may have units, as in "=2*{KINDS[unit][1].strip(chr(34))}"' if unit in KINDS else ""
        hint = advice(value.text, float(value), value.dimension, unit) or ("" if value.dimension.units else named)
        raise InputError(f"found {shown(value)}, {kind}; expected {expected(unit)}{hint}")
    return value


def _from_text(text: str, unit: str) -> float:
    number, unit_text = _split(text, unit)
    unit_text = meant(unit_text, unit)
    kind = dimension(unit_text)
    if unit == "Hz" and kind == dimension("rad/s") and any(name in COUNTS_TURNS for name in re.split(r"[*/^]", unit_text)):
        return float(number) * float(unit_in_si(unit_text)[0] / unit_in_si("rev")[0])
    if not same_kind(kind, unit):
        hint = advice(text, _in_si(number, unit_text), kind, unit) or _other_case(number, unit_text, unit)
        raise InputError(f"found {shown(text)}, {described(kind, ANOTHER)}; expected {expected(unit)}{hint}")
    return float(number) * float(unit_in_si(unit_text)[0] / unit_in_si(unit)[0])


def _in_si(number: str, unit: str) -> float:
    """The value in the base units, those of SI."""
    return float(number) * float(unit_in_si(unit)[0])


def _other_case(number: str, unit_text: str, unit: str) -> str:
    """Hint for a letter of the wrong case: seconds and siemens differ in it only."""
    small = unit_text.lower()
    fits = small != unit_text and not unknown_name(small) and same_kind(dimension(small), unit)
    return f'; did you mean "{number} {small}"?' if fits else ""


def _split(text: str, unit: str | None = None) -> tuple[str, str]:
    """The number and the unit of a text where a quantity of a kind is expected, or one of any kind."""
    match = _QUANTITY.fullmatch(text.strip()) if len(text) <= LONGEST_QUANTITY else None
    unit_text = _normal_unit(match[2]) if match else ""
    if not _UNIT.fullmatch(unit_text):
        wanted = 'a quantity, e.g. 2.0 or "10 kg"' if unit is None else expected(unit)
        raise InputError(f"found {shown(text)}; expected {wanted}; {_how_to_write(text)}")
    if unknown := unknown_name(unit_text):
        wanted = 'a quantity, e.g. "10 kg"' if unit is None else expected(unit)
        raise InputError(f"found {shown(text)}, but {instead_of(unknown)}; expected {wanted}")
    return match[1], unit_text


def _how_to_write(text: str) -> str:
    """Hint for a text that is not a number with a unit."""
    if isinstance(text, OfParameters):
        what = "the name of a parameter" if text.isidentifier() else "an expression of parameters without its ="
        return f"this is {what}: write {quoted('=' + text.strip())}"
    if re.match(r"\s*[+-]?\d+,\d", text):
        return f"decimals have a point: {quoted(text.replace(',', '.', 1))}"
    if re.fullmatch(r"\s*[+-]?[\d._]+([eE][+-]?\d+)?\s*", text):
        return "write its unit too, or the number without quotes, which is then in SI"
    if re.match(r"\s*[+-]?[\d.]+ \d", text):
        return "write the digits without blanks, or with _ between them, 1_000"
    return "write one number, then a unit made of names, *, / and ^, such as N*s/m or kg*m^2"


def _normal_unit(text: str) -> str:
    """Normal form of a unit: ** and superscripts become ^, a dot or a space between two units becomes *."""
    text = text.replace("**", "^").replace("·", "*").replace("²", "^2").replace("³", "^3").replace("°", "deg")
    return re.sub(r"\s+", "*", re.sub(r"\s*([*/^])\s*", r"\1", text))


def count_texts(data) -> int:
    """The number of texts in tables and arrays that look like a number with a unit."""
    if isinstance(data, str):
        return int(len(data) <= LONGEST_QUANTITY and bool(_QUANTITY.fullmatch(data)))
    if isinstance(data, dict):
        data = list(data.values())
    return sum(map(count_texts, data)) if isinstance(data, list) else 0


class OfParameters(str):
    """A text of a scene whose names are all those of parameters: where a quantity is expected, it lacks its "="."""


class Expressed(float):
    """The value of an expression with the default values of its parameters, or of a text with a unit, in SI; a float.

    >>> Expressed(4.0, "=2*k", None, None) + 1.0
    5.0
    """

    text: str  # as it stands in the scene, that of an expression with its "="
    tree: Any  # the expression; None of a text with a unit
    dimension: Dimension | None  # its kind of quantity; None where unknown

    def __new__(cls, value: float, text: str, tree: Any, dimension: Dimension | None):
        """The number with where it comes from."""
        result = super().__new__(cls, value)
        result.text, result.tree, result.dimension = text, tree, dimension
        return result

    def __getnewargs__(self):
        return float(self), self.text, self.tree, self.dimension
