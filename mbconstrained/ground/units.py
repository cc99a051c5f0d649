"""The units of scenes with their sizes in SI, exactly, and the units of rates, forces and impulses of a coordinate; other spellings are refused."""

from __future__ import annotations

import functools
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import product
from typing import NamedTuple

from .checks import nearest
from .errors import InputError


class Unit(NamedTuple):
    """A unit with its spellings."""

    of: str  # the quantity that it measures
    symbols: str  # its symbols, separated by blanks; the first is that of the tables
    definition: str  # in units above it; of a base unit the quantity in brackets
    prefixes: str = ""  # symbols of the SI prefixes that it may have
    names: str = ""  # its names in full, which may have the names of the prefixes, and an s behind them
    irregular: str = ""  # other spellings, without prefix or plural


_ALL = "n u m k M G"
UNITS = (
    Unit("length", "m", "[length]", "n u m c d k", "meter metre"),
    Unit("length", "in", "0.0254 * m", names="inch", irregular="inches"),
    Unit("length", "ft", "0.3048 * m", names="foot", irregular="feet"),
    Unit("mass", "kg", "[mass]", names="kilogram"),
    Unit("mass", "g", "0.001 * kg", "n u m", "gram"),
    Unit("mass", "t", "1000 * kg", names="tonne"),
    Unit("mass", "lb", "0.45359237 * kg"),
    Unit("mass", "slug", "0.45359237 * 9.80665 / 0.3048 * kg"),
    Unit("time", "s", "[time]", "n u m", "second", "sec"),
    Unit("time", "min", "60 * s", names="minute"),
    Unit("time", "h", "3600 * s", names="hour", irregular="hr"),
    Unit("time", "d", "86400 * s", names="day"),
    Unit("angle", "rad", "[]", "u m", "radian"),
    Unit("angle", "deg", "3.141592653589793 / 180 * rad", names="degree"),
    Unit("angle", "arcmin", "deg / 60", names="arcminute"),
    Unit("angle", "arcsec", "deg / 3600", "m", "arcsecond"),
    Unit("angle", "rev", "2 * 3.141592653589793 * rad", names="revolution turn"),
    Unit("frequency", "Hz", "1 / s", "m k M G", "hertz"),
    Unit("angular velocity", "rpm", "rev / min"),
    Unit("velocity", "mph", "0.44704 * m / s"),
    Unit("acceleration", "gn", "9.80665 * m / s ** 2"),
    Unit("force", "N", "kg * m / s ** 2", "u m k M", "newton"),
    Unit("force", "lbf", "0.45359237 * 9.80665 * N"),
    Unit("force", "kip", "1000 * lbf"),
    Unit("force", "kgf", "9.80665 * N"),
    Unit("torque", "Nm", "N * m", "m k M"),
    Unit("torque", "Nmm", "0.001 * N * m", "k"),
    Unit("impulse", "Ns", "N * s", "m k"),
    Unit("energy", "J", "N * m", _ALL, "joule"),
    Unit("power", "W", "J / s", _ALL, "watt"),
    Unit("pressure", "Pa", "N / m ** 2", "k M G", "pascal"),
    Unit("pressure", "bar", "100000 * Pa", "m"),
    Unit("pressure", "psi", "lbf / in ** 2"),
    Unit("volume", "l L", "0.001 * m ** 3", "m", "liter litre"),
    Unit("current", "A", "[current]", "n u m k", "ampere"),
    Unit("voltage", "V", "W / A", "n u m k M", "volt"),
    Unit("charge", "C", "A * s", "n u m", "coulomb"),
    Unit("resistance", "ohm Ω", "V / A", "u m k M"),
    Unit("conductance", "S", "A / V", "u m", "siemens"),
    Unit("capacitance", "F", "C / V", "p n u m", "farad"),
    Unit("inductance", "H", "V * s / A", "n u m", "henry"),
    Unit("magnetic flux", "Wb", "V * s", "m", "weber"),
    Unit("magnetic flux density", "T", "Wb / m ** 2", "u m", "tesla"),
    Unit("temperature", "K", "[temperature]", "m", "kelvin"),
)
#: SI prefixes with their names, factors, and further symbols.
PREFIXES = {
    "p": ("pico", 1e-12, ""), "n": ("nano", 1e-9, ""), "u": ("micro", 1e-6, "µ μ"), "m": ("milli", 1e-3, ""),
    "c": ("centi", 1e-2, ""), "d": ("deci", 1e-1, ""), "k": ("kilo", 1e3, ""), "M": ("mega", 1e6, ""), "G": ("giga", 1e9, ""),
}  # fmt: skip

#: Spellings with two readings, or with one that is not what a unit of this name is elsewhere: what to write instead.
AMBIGUOUS = {
    "gr": 'a gram, "g", or a grain, "0.0648 g"',
    "ton": 'a tonne, "t" (1000 kg), or a short ton, "907.185 kg"',
    "pound": 'a pound of mass, "lb", or of force, "lbf"',
    "oz": 'an ounce of mass, "28.3495 g", or of force, "0.278014 N"',
    "hp": 'a metric horsepower, "735.499 W", or a mechanical one, "745.7 W"',
    "PS": 'a metric horsepower, "735.499 W", or a picosecond, "1e-12 s"',
    "mil": 'a thousandth of an inch, "0.001 in", or an angle, "0.001 rad"',
    "cycle": 'a whole turn, "rev", or a period; cycles per second are "Hz"',
    "cps": 'cycles per second, "Hz", or turns per second, "rev/s"',
    "kph": 'kilometres per hour, "km/h", or kilopond hours',
    "kp": 'a kilopond, "kgf", or a thousand points',
    "rads": 'radians, "rad", or radian seconds, "rad*s"; radians per second are "rad/s"',
    "cal": 'a thermochemical calorie, "4.184 J", or an international one, "4.1868 J"',
}
#: The factors into which an unknown name such as "Nms" may fall apart.
_FACTORS = ("kg", "g", "rad", *(prefix + unit for prefix, unit in product(("", "m", "u", "c", "k", "M"), ("N", "m", "s"))))


@functools.cache
def _spellings() -> dict[str, str]:
    """Every accepted spelling with its definition in terms of first symbols."""
    result = {}
    for unit in UNITS:
        first, *others = unit.symbols.split()
        result[first] = unit.definition
        names = [name + plural for name in unit.names.split() for plural in ("", "s") if not (plural and name in ("inch", "foot"))]
        result |= dict.fromkeys([*others, *names, *unit.irregular.split()], first)
        for prefix in unit.prefixes.split():
            name, factor, further = PREFIXES[prefix]
            symbols = (letter + symbol for letter in (prefix, *further.split()) for symbol in (first, *others))
            result |= dict.fromkeys([*symbols, *(name + each for each in names)], f"{factor!r} * {first}")
    return result


def is_accepted(name: str) -> bool:
    """Whether a scene may use this spelling of a unit.

    >>> is_accepted("kN"), is_accepted("ton")
    (True, False)
    """
    return name in _spellings()


_PART = re.compile(r"([*/]?)([^*/^]+)(?:\^(-?\d+))?")


@functools.cache
def unit_in_si(text: str) -> tuple[Fraction, dict[str, int]]:
    """The size of a product of numbers and units in SI, and its exponents of kg, m, s, rad, A and K.

    An own table, as the import of pint takes three times as long as all of this module, and that of dask with it ten times.

    >>> unit_in_si("N/mm")
    (Fraction(1000, 1), {'kg': 1, 's': -2})
    """
    size, exponents = Fraction(1), Counter[str]()
    for sign, name, power in _PART.findall(text):
        exponent = int(power or 1) * (-1 if sign == "/" else 1)
        definition = _spellings().get(name, "").replace(" ", "").replace("**", "^")
        if definition and not definition.startswith("["):
            own, units = unit_in_si(definition)
        else:
            own, units = (Fraction(1), {name: 1}) if definition else (Fraction(name), {})
        size *= own**exponent
        exponents.update({unit: exponent * count for unit, count in units.items()})
    return size, {unit: count for unit, count in exponents.items() if count}


def unknown_name(unit: str) -> str:
    """The first name in a unit that is not accepted, or an empty string."""
    return next((name for name in re.findall(r"[^\W\d_]+", unit) if name not in _spellings()), "")


def instead_of(name: str) -> str:
    """Hint for a name that is not accepted.

    >>> instead_of("Nms")
    '"Nms" may be read as N*ms or N*m*s; write one of them'
    >>> instead_of("Kg")
    'there is no unit "Kg"; did you mean "kg"?'
    """
    singular = name.removesuffix("s")
    for spelling in (name, singular, name.lower(), singular.lower()):
        if spelling in AMBIGUOUS:
            return f'"{name}" may be read as {AMBIGUOUS[spelling]}; write one of them'
    common = [symbol for unit in UNITS for symbol in unit.symbols.split()] + [*_COMMON]
    if same_letters := [symbol for symbol in common if symbol.lower() == name.lower()]:
        return f'there is no unit "{name}"; did you mean "{same_letters[0]}"?'
    if readings := _products(name):
        one = "write one of them" if len(readings) > 1 else "write it with the *"
        return f'"{name}" may be read as {" or ".join(readings)}; {one}'
    return f'there is no unit "{name}"{nearest(name, common)}'


#: Symbols with a prefix that stand among the proposals for a misspelled unit.
_COMMON = ("mm", "cm", "um", "km", "kN", "mN", "MN", "ms", "us", "kHz", "kPa", "MPa", "GPa", "kNm", "mV", "mA", "kJ", "kW")


def _products(name: str, most: int = 3) -> list[str]:
    """Products of at most this many mechanical units whose symbols are joined in a name."""
    readings = [name] if name in _FACTORS else []
    for head in _FACTORS if most > 1 else ():
        if name.startswith(head):
            readings += [f"{head}*{tail}" for tail in _products(name[len(head) :], most - 1)]
    return sorted(readings, key=len)


# Units of coordinates: metres, radians, electrical units, or none.

#: The name of the fixed body, which has no coordinate.
GROUND = "ground"

DERIVATIVES = ("displacement", "velocity", "acceleration", "jerk")

#: Of a coordinate. The equation of a charge or a current is a sum of voltages around a mesh, that of a voltage one of currents at a node.
_FORCES = {"m": "N", "rad": "N m", "1": "J", "C": "V", "A": "V", "V": "A"}


def coordinate_units(units, names: Sequence[str]) -> dict[str, str]:
    """The unit of every coordinate by name, metres by default."""
    if units is None:
        return dict.fromkeys(names, "m")
    if not isinstance(units, Mapping):
        units = tuple(units)
        if len(units) != len(names):
            raise InputError(f"units: {len(units)} given for {len(names)} coordinates; give one each")
        units = dict(zip(names, units))
    known = set(names)
    unknown = [name for name in units if name not in known]
    if unknown:
        raise InputError(f'units: there is no coordinate "{unknown[0]}"{nearest(unknown[0], names)}')
    for name, unit in units.items():
        check_unit(unit, f"unit of {name}")
    return {name: units.get(name, "m") for name in names}


def check_unit(unit, what: str) -> str:
    """The unit, if it is one that a coordinate or a constraint row may have."""
    if unit not in _FORCES:
        raise InputError(f'{what}: found {unit!r}; expected "m", "rad", "1", or "C", "A", "V" of circuits{nearest(unit, _FORCES)}')
    return unit


def rate_unit(unit: str, order: int = 1) -> str:
    """The unit of the derivative of this order.

    >>> rate_unit("m", 2)
    'm/s^2'
    """
    return unit if order == 0 else f"{unit}/s^{order}".removesuffix("^1")


def derivative_name(unit: str, order: int) -> str:
    """The name of a derivative.

    >>> derivative_name("m", 1), derivative_name("rad", 0), derivative_name("N", 0), derivative_name("m", 5)
    ('velocity', 'angle', 'value', 'derivative 5')
    """
    if order >= len(DERIVATIVES) or unit not in ("m", "rad"):
        return "value" if order == 0 else f"derivative {order}"
    if unit == "m":
        return DERIVATIVES[order]
    return "angle" if order == 0 else f"angular {DERIVATIVES[order]}"


def force_unit(unit: str) -> str:
    """The unit of the force along a quantity of this unit.

    >>> force_unit("rad"), force_unit("C")
    ('N m', 'V')
    """
    return _FORCES.get(unit, f"J/{unit}")


def impulse_unit(unit: str, order: int = 0) -> str:
    """The unit of the factor of the derivative of this order of Dirac's delta, for a quantity of this unit.

    >>> impulse_unit("N"), impulse_unit("N", 1)
    ('N s', 'N s^2')
    """
    return f"{unit} s^{order + 1}".removesuffix("^1")


def ratio_unit(above: str, below: str) -> str:
    """The unit of a quantity by another.

    >>> ratio_unit("m", "N m"), ratio_unit("m", "m")
    ('m/(N m)', '1')
    """
    if above == below:
        return "1"
    if below == "1":
        return above
    return f"{above}/{below}" if not any(sign in below for sign in " /") else f"{above}/({below})"


def density_unit(unit: str) -> str:
    """The unit of a spectral density.

    >>> density_unit("g"), density_unit("m/s^2"), density_unit("1")
    ('g^2/Hz', '(m/s^2)^2/Hz', '1/Hz')
    """
    if unit in ("", "1"):
        return "1/Hz"
    return f"({unit})^2/Hz" if any(sign in unit for sign in "/ ^*") else f"{unit}^2/Hz"
