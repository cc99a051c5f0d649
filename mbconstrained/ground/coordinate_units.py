"""Units of the rates, forces and impulses of a coordinate in metres, radians, electrical units or without unit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .checks import nearest
from .errors import InputError

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
    return unit if order == 0 else f"{unit}/{_seconds(order)}"


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
    return f"{unit} {_seconds(order + 1)}"


def _seconds(power: int) -> str:
    return "s" if power == 1 else f"s^{power}"


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
