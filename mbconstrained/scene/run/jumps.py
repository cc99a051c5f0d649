"""Jumps and impulses at t = 0 and later, with their units: the same texts for tables, notices and marks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from ...ground.coordinate_units import derivative_name, force_unit, impulse_unit, rate_unit
from ...ground.display import number_text
from ...ground.notices import Notice, NoticeKind
from ...mechanics.motion import DELTAS
from ...response.admissible import admissible
from ...response.events import Event
from ...response.response_notices import first_and_count, kink_notices, sides, without_kinks
from ..quantities.coordinates import Coordinates, beyond_noise
from ..quantities.output_units import OutputUnits

if TYPE_CHECKING:
    from ...mechanics.system import MechanicalSystem
    from ...response.response import Response
    from ..build.model import Equations


@dataclass(frozen=True)
class ReportedJump:
    """A jump of a coordinate or a derivative of it at a time; values are texts with units."""

    name: str
    what: str
    before: str
    after: str
    size: str


@dataclass(frozen=True)
class ReportedImpulse:
    """A multiple of the derivative of this order of Dirac's delta; the size is a text with a unit."""

    name: str
    order: int
    size: str

    @property
    def delta(self) -> str:
        """The distribution that it multiplies, as text."""
        return DELTAS[self.order] if self.order < len(DELTAS) else f"the derivative of order {self.order} of a Dirac impulse"


def jumps_of(motion: Response, coordinates: Coordinates, event: Event | None = None) -> list[ReportedJump]:
    """The jumps of the coordinates and their derivatives."""
    jumps = []
    for order, row in enumerate((event or motion).jump):
        if event is None:
            before, after = motion.initial[order], motion.start[order]
            places = beyond_noise(row, before, after)
        elif places := row.nonzero()[0].tolist():
            before, after = sides(motion, event, order)
        for i in places:
            unit = rate_unit(coordinates.units[i], order)
            texts = (coordinates.shown.text(value, unit) for value in (before[i], after[i], row[i]))
            jumps.append(ReportedJump(coordinates.names[i], derivative_name(coordinates.units[i], order), *texts))
    return jumps


def impulses_of(impulses: Sequence, coordinates: Coordinates) -> list[ReportedImpulse]:
    """The impulses that are not zero."""
    return [
        ReportedImpulse(coordinates.names[i], order, coordinates.shown.text(row[i], impulse_unit(coordinates.units[i], order)))
        for order, row in enumerate(impulses)
        for i in row.nonzero()[0]
    ]


def forces_of_rows(system: MechanicalSystem, name: str = "force of {}", shown: OutputUnits = OutputUnits()) -> Coordinates:
    """Names and units of the constraint forces."""
    return Coordinates(
        tuple(name.format(row.name) for row in system.rows), tuple(force_unit(row.unit) for row in system.rows), shown
    )


def with_units(response: Response, coordinates: Coordinates) -> tuple[Notice, ...]:
    """The notices of a response without units of its coordinates, with these units."""
    own = (NoticeKind.JUMP, NoticeKind.IMPULSE, NoticeKind.KINK)
    others = [notice for notice in response.notices if notice.kind not in own]
    later = first_and_count(lambda event: _sentences(response, coordinates, event), without_kinks(response))
    kinks = kink_notices(response, partial(_kink_text, coordinates))
    return (*_sentences(response, coordinates), *later, *kinks, *others)


def _kink_text(coordinates: Coordinates, number: int, order: int, size: float) -> str:
    unit = coordinates.units[number]
    size_text = coordinates.shown.text(size, rate_unit(unit, order))
    return f"{derivative_name(unit, order)} of {coordinates.names[number]} by {size_text}"


def _sentences(motion: Response, coordinates: Coordinates, event: Event | None = None) -> list[Notice]:
    """A notice for each jump and each impulse in the coordinates, at an event or at t = 0."""
    when = f"t = {number_text(event.time)} s" if event else "t = 0"
    quantities = {name: derivative_name(unit, 0) for name, unit in zip(coordinates.names, coordinates.units)}
    notices = [
        Notice(NoticeKind.JUMP, f"{jump.name}: its {jump.what} jumps at {when} by {jump.size}, from {jump.before} to {jump.after}")
        for jump in jumps_of(motion, coordinates, event)
    ]
    return notices + [
        Notice(
            NoticeKind.IMPULSE,
            f"{impulse.name}: its {quantities[impulse.name]} contains {impulse.delta} of {impulse.size} at {when}",
        )
        for impulse in impulses_of((event or motion).impulses, coordinates)
    ]


def folded(notices: Sequence[Notice], jumps: int, impulses: int, later: tuple[int, int] = (0, 0)) -> tuple[Notice, ...]:
    """One sentence in place of the notices on each jump and impulse, which are in tables."""
    counts_of_events = [*_counted("At t = 0", jumps, impulses), *_counted("After t = 0", *later)]
    return (*counts_of_events, *(notice for notice in notices if not _has_table(notice)))


def _counted(when: str, jumps: int, impulses: int) -> list[Notice]:
    counts = [f"{count} {one}{'s' if count > 1 else ''}" for count, one in ((jumps, "jump"), (impulses, "impulse")) if count]
    text = f"{when} there {'is' if jumps + impulses == 1 else 'are'} {' and '.join(counts)}; the tables give the sizes"
    return [Notice(NoticeKind.JUMP if jumps else NoticeKind.IMPULSE, text)] if counts else []


def _has_table(notice: Notice) -> bool:
    """Whether a notice is shown in a table, unlike a jump of a constraint row, which is a cause."""
    return notice.kind == NoticeKind.IMPULSE or (notice.kind == NoticeKind.JUMP and not notice.text.startswith("constraint "))


MOST_NOTICES = 12


def start_notices(equations: Equations) -> tuple[Notice, ...]:
    """Notices on the start: causes first, then the jumps and impulses; none where the start is consistent."""
    if equations.start_fits:
        return ()
    motion: Any = equations.solve()  # a Motion where there is a system
    coordinates = equations.coordinates
    notices = [*_causes(equations, motion), *_sentences(motion, coordinates)]
    if equations.system is not None:
        forces = forces_of_rows(equations.system, 'constraint "{}"')
        notices += [
            Notice(NoticeKind.IMPULSE, f"{impulse.name}: its force contains {impulse.delta} of {impulse.size} at t = 0")
            for impulse in impulses_of(motion.constraint_impulses, forces)
        ]
    return tuple(notices[:MOST_NOTICES]) + (
        (Notice(NoticeKind.JUMP, f"and {len(notices) - MOST_NOTICES} more"),) if len(notices) > MOST_NOTICES else ()
    )


def _causes(equations: Equations, motion: Response) -> Iterator[Notice]:
    """Violated constraint rows, or else the violated equations."""
    rows = [notice for notice in motion.notices if notice.kind == NoticeKind.JUMP and notice.text.startswith("constraint ")]
    yield from rows
    if not rows:
        admissibility = admissible(equations.polynomial_matrix, initial=equations.initial, force=equations.right_hand_side)
        for violation in admissibility.violations:
            _, _, text = violation.text.partition(": ")
            yield Notice(NoticeKind.JUMP, f"the start does not fit: {text}")
