"""Dimensions: kinds of quantities with a name for messages."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, NamedTuple

from .units import registry

if TYPE_CHECKING:
    from pint.util import UnitsContainer

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
    """A kind of quantity: the base units of pint with their exponents, and the radian.

    Attributes:
        units: pint's container of base units, which multiplies and divides.
        radian: the exponent of the radian; None in products, where radians may be written or not.
    """

    units: UnitsContainer
    radian: float | None

    def times(self, other: Dimension) -> Dimension:
        """The kind of a product."""
        return Dimension(self.units * other.units, None)

    def over(self, other: Dimension) -> Dimension:
        """The kind of a quotient."""
        return Dimension(self.units / other.units, None)

    def power(self, exponent: int) -> Dimension:
        """The kind of a power."""
        return Dimension(self.units**exponent, None)


def unit_of(kind: Dimension) -> str:
    """The SI unit of a kind of quantity.

    >>> unit_of(dimension("N/mm"))
    'N/m'
    """
    if not kind.units and not kind.radian:
        return "1"
    known = (unit for unit in KINDS if unit != "1" and same_kind(kind, unit))
    return next(known, "") or f"{registry().Quantity(1, kind.units).units:~C}".replace("**", "^")


@functools.cache
def unit_named(text: str):
    """A pint unit from a text of known names, * / and ^."""
    return registry().parse_units(text)


@functools.cache
def dimension(text: str) -> Dimension:
    """The kind of a unit."""
    from pint.util import UnitsContainer

    exponents = dict((1 * unit_named(text)).to_root_units().unit_items())
    radian = exponents.pop("rad", 0)
    return Dimension(UnitsContainer(exponents), radian)


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
    return ""
