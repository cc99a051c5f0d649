"""What happens at t = 0 and later, jumps and impulses with their units: read once, said alike by tables and notices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..mechanics.motion_notices import DELTAS
from ..mechanics.units import impulse_unit, rate_unit
from ..notices import Notice
from ..response.events import Event
from ..response.notices import first_and_count, sides
from .values import Coordinates, beyond_noise, derivative_name

if TYPE_CHECKING:
    from ..response import Response


@dataclass(frozen=True)
class Jump:
    """A coordinate or a derivative of it that is another just after a time; values are texts with units."""

    name: str
    what: str
    before: str
    after: str
    size: str


@dataclass(frozen=True)
class Impulse:
    """A multiple of the derivative of this order of Dirac's delta; the size is a text with a unit."""

    name: str
    order: int
    size: str

    @property
    def delta(self) -> str:
        """What it multiplies, in words."""
        return DELTAS[self.order] if self.order < len(DELTAS) else f"the derivative of order {self.order} of a Dirac impulse"


def number(value: float) -> str:
    """A number to six digits.

    >>> number(-0.0), number(1 / 3)
    ('0', '0.333333')
    """
    return f"{value + 0.0:.6g}"


def sized(value: float, unit: str) -> str:
    """A number with its unit; of the unit 1 nothing is printed.

    >>> sized(0.5, "m/s"), sized(0.5, "1"), sized(0.5, "1/s"), sized(0.5, "1 s")
    ('0.5 m/s', '0.5', '0.5 1/s', '0.5 s')
    """
    return f"{number(value)} {'' if unit == '1' else unit.removeprefix('1 ')}".rstrip()


def jumps_of(motion: Response, coordinates: Coordinates) -> list[Jump]:
    """The jumps at t = 0 that are more than rounding, by order of derivative."""
    return [
        _jump(coordinates, order, i, motion.initial[order, i], motion.start[order, i], row[i])
        for order, row in enumerate(motion.jump)
        for i in beyond_noise(row, motion.initial[order], motion.start[order])
    ]


def later_jumps_of(motion: Response, event: Event, coordinates: Coordinates) -> list[Jump]:
    """The jumps of an event, by order of derivative."""
    found = []
    for order, row in enumerate(event.jump):
        if row.any():
            before, after = sides(motion, event, order)
            found += [_jump(coordinates, order, i, before[i], after[i], row[i]) for i in row.nonzero()[0]]
    return found


def _jump(coordinates: Coordinates, order: int, i: int, *values: float) -> Jump:
    unit = rate_unit(coordinates.units[i], order)
    what = derivative_name(coordinates.units[i], order)
    return Jump(coordinates.names[i], what, *(sized(value, unit) for value in values))


def impulses_of(impulses: Sequence, names: Sequence[str], units: Sequence[str]) -> list[Impulse]:
    """The impulses of quantities with these names and units, by order of derivative."""
    return [
        Impulse(names[i], order, sized(row[i], impulse_unit(units[i], order)))
        for order, row in enumerate(impulses)
        for i in row.nonzero()[0]
    ]


def with_units(response: Response, coordinates: Coordinates) -> tuple[Notice, ...]:
    """The notices of a response that itself does not know the units of its coordinates."""
    others = [notice for notice in response.notices if notice.kind not in ("jump", "impulse")]
    first = sentences(jumps_of(response, coordinates), response.impulses, coordinates, "t = 0")

    def of_event(event: Event) -> list[Notice]:
        return sentences(later_jumps_of(response, event, coordinates), event.impulses, coordinates, f"t = {event.time:.6g} s")

    return (*first, *first_and_count(of_event, response.events), *others)


def sentences(jumps: list[Jump], impulses, coordinates: Coordinates, when: str) -> list[Notice]:
    """A notice for each jump and each impulse in the coordinates."""
    what = {name: derivative_name(unit, 0) for name, unit in zip(coordinates.names, coordinates.units)}
    told = [
        Notice("jump", f"{jump.name}: its {jump.what} jumps at {when} by {jump.size}, from {jump.before} to {jump.after}")
        for jump in jumps
    ]
    return told + [
        Notice("impulse", f"{impulse.name}: its {what[impulse.name]} contains {impulse.delta} of {impulse.size} at {when}")
        for impulse in impulses_of(impulses, coordinates.names, coordinates.units)
    ]


def folded(notices: Sequence[Notice], jumps: int, impulses: int, later: tuple[int, int] = (0, 0)) -> tuple[Notice, ...]:
    """One sentence instead of a notice for each of the jumps and impulses, which have tables of their own.

    Args:
        jumps, impulses: how many at t = 0.
        later: how many of both after t = 0.
    """
    told = [*_counted("At t = 0", jumps, impulses), *_counted("After t = 0", *later)]
    return (*told, *(notice for notice in notices if not _has_table(notice)))


def _counted(when: str, jumps: int, impulses: int) -> list[Notice]:
    counts = [f"{count} {one}{'s' if count > 1 else ''}" for count, one in ((jumps, "jump"), (impulses, "impulse")) if count]
    text = f"{when} there {'is' if jumps + impulses == 1 else 'are'} {' and '.join(counts)}; the tables give the sizes"
    return [Notice("jump" if jumps else "impulse", text)] if counts else []


def _has_table(notice: Notice) -> bool:
    """A jump of a constraint row is the cause (the start does not fit the row) and stands in no table."""
    return notice.kind == "impulse" or (notice.kind == "jump" and not notice.text.startswith("constraint "))
