"""Units and their kinds, by pint: which unit is of which kind, and what the kind is called.

pint is imported when the first unit is looked up, and is only ever given the names of units.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

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

#: Products that engineers write as one word; to pint, Nm is a fineness of yarn.
_RUN_TOGETHER = ("Nm = newton * meter", "Nmm = newton * millimeter", "Ns = newton * second")


class Dimension(NamedTuple):
    """A unit in the base units of pint: exponents without the radian, and the exponent of the radian, None for any."""

    exponents: frozenset
    radian: float | None


def unit_of(kind: Dimension) -> str:
    """The SI unit of a kind of quantity.

    >>> unit_of(dimension("N/mm"))
    'N/m'
    """
    known = (unit for unit in KINDS if unit != "1" and dimension(unit) == kind)
    return next(known, "") or _base_units(kind.exponents)


def _base_units(exponents: frozenset) -> str:
    """kg, m, s, A, … with their powers."""
    product = unit_named(" * ".join(f"{name}**{exponent}" for name, exponent in sorted(exponents)) or "dimensionless")
    return f"{(1 * product).to_base_units().units:~C}".replace("**", "^")


def load_units() -> None:
    """Import pint and read its definitions of units."""
    registry()


@functools.cache
def registry():
    """The units that there are."""
    import pint

    found = pint.UnitRegistry(on_redefinition="ignore")
    for definition in _RUN_TOGETHER:
        found.define(definition)
    return found


@functools.cache
def unit_named(text: str):
    """A pint unit from a text that is made of known names, * / and ^."""
    return registry().parse_units(text)


@functools.cache
def dimension(text: str) -> Dimension:
    """The kind of a unit."""
    root = (1 * unit_named(text)).to_root_units()
    exponents = dict(root.unit_items())
    radian = exponents.pop("radian", 0)
    return Dimension(frozenset(exponents.items()), radian)


def same_kind(found: Dimension, unit: str) -> bool:
    """Equal dimensions; N*m/rad may also be written N*m, as is common for torsion springs."""
    wanted = dimension(unit)
    if found.radian is None:  # radians are not written in products
        return found.exponents == wanted.exponents
    return found.exponents == wanted.exponents and found.radian in ((wanted.radian, 0) if wanted.radian < 0 else (wanted.radian,))


def described(found: Dimension, otherwise: str = "another kind of quantity") -> str:
    """What a kind of quantity is called."""
    if not found.exponents and not found.radian:
        return "a plain number"
    radians = (found.radian,) if found.radian is not None else (0, 1, -1)
    kinds = [Dimension(found.exponents, radian) for radian in radians]
    name = next((name for unit, (name, _) in KINDS.items() if unit != "1" and dimension(unit) in kinds), None)
    return name or otherwise


def advice(found: Dimension, unit: str) -> str:
    """What to mind where turns per second and radians per second are taken for each other."""
    if unit == "rad/s" and found == dimension("Hz"):
        return "; a frequency in Hz is 2 pi times an angular frequency in rad/s: say which one is meant"
    if unit == "Hz" and found == dimension("rad/s"):
        return "; an angular frequency in rad/s or rpm is 2 pi times a frequency: say which one is meant"
    return ""
