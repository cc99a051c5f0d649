"""Units of the page, of tables and of CSV files that a scene selects in place of SI units."""

from __future__ import annotations

from dataclasses import dataclass

from ...ground.display import with_unit
from ...ground.errors import InputError, shown
from ...ground.quantities import dimension, meant, unit_name
from ...ground.units import unit_in_si

ACCELERATION = "m/s^2"

#: Units that are shown by another name than in the table of units.
_SHOWN = {"gn": "g"}


@dataclass(frozen=True)
class OutputUnits:
    """Units in place of SI units of the same kind; derivatives and products follow, so that mm implies mm/s and kN implies kN m.

    Accelerations remain in m/s^2 unless they have a unit of their own, such as mm/s^2 or g.

    >>> units = OutputUnits(("mm", "deg", "rpm", "kN"))
    >>> units.of("m/s"), units.of("N m"), units.of("rad/s")[0], units.of("J")
    (('mm/s', 1000.0), ('kN m', 0.001), 'rpm', ('J', 1.0))
    >>> units.of("m/s^2"), OutputUnits(("mm", "mm/s^2")).of("m/s^2")
    (('m/s^2', 1.0), ('mm/s^2', 1000.0))
    """

    units: tuple[str, ...] = ()  # each of another kind; none for SI

    def of(self, unit: str) -> tuple[str, float]:
        """The unit in place of an SI unit, which has products with a blank, with the factor of the values."""
        for each in self.units if unit != "1" else ():
            if _alike(each, unit):
                return _SHOWN.get(each, each), _factor(unit, each)
        if unit == ACCELERATION:
            return unit, 1.0
        head, slash, below = unit.partition("/")
        first, blank, further = head.partition(" ")
        for each in self.units if first != "1" and (blank or slash) else ():
            if _alike(each, first):
                return f"{each}{blank}{further}{slash}{below}", _factor(first, each)
        return unit, 1.0

    def of_ratio(self, unit: str) -> tuple[str, float]:
        """The unit in place of that of a response, a ratio such as m/N or N/(m/s^2), with its factor.

        >>> OutputUnits(("mm", "kN")).of_ratio("m/N")
        ('mm/kN', 1000000.0)
        """
        above, slash, below = unit.partition("/(") if "/(" in unit else unit.rpartition("/")
        if not slash:
            return self.of(unit)
        (above, up), (below, down) = self.of(above), self.of(below.removesuffix(")"))
        return f"{above}/({below})" if any(sign in below for sign in " /") else f"{above}/{below}", up / down

    def text(self, value: float, unit: str) -> str:
        """A value in SI as a text in the selected unit."""
        name, factor = self.of(unit)
        return with_unit(factor * value, name)


def output_units(value) -> tuple[str, ...]:
    """The units of a text such as "mm, deg, rpm, kN", or of a list; g is the standard acceleration of gravity."""
    if not isinstance(value, (str, list)):
        raise InputError(f'found {shown(value)}; expected units, e.g. "mm, deg, rpm, kN"')
    names = tuple(
        meant(unit_name(name.strip() if isinstance(name, str) else name), ACCELERATION)
        for name in (value.split(",") if isinstance(value, str) else value)
    )
    for number, name in enumerate(names):
        if twin := next((other for other in names[:number] if _alike(other, name)), None):
            raise InputError(f'found "{twin}" and "{name}", which measure the same; give one of them')
    return names


def _alike(one: str, other: str) -> bool:
    """Whether both units measure the same quantity; a torque in N m is no energy."""
    is_energy = [name.endswith("J") for name in (one, other)]
    return is_energy[0] == is_energy[1] and dimension(one) == dimension(other.replace(" ", "*"))


def _factor(unit: str, chosen: str) -> float:
    return float(unit_in_si(unit.replace(" ", "*"))[0] / unit_in_si(chosen)[0])
