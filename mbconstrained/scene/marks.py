"""What is drawn over the model of a scene: jumps and impulses when they happen, and the forces that [output] arrows asks for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..mechanics.units import force_unit, impulse_unit
from ..page.drawing import Drawing
from ..page.marks import Arrow, LastingForce, Marks, Moment, Strike, arrow_at
from ..response.notices import sides
from .happenings import Jump, impulses_of, jumps_of, later_jumps_of, number, sized

if TYPE_CHECKING:
    from ..response.events import Event
    from .result import Result

#: More moments than this follow each other too fast to be looked at one by one; the first are shown.
MOST_MOMENTS = 100

#: Of one moment so many lines are told in the picture; the tables have all.
MOST_TOLD = 6


def marks_of(result: Result, drawing: Drawing, times: np.ndarray) -> Marks:
    """Marks for the drawing of a result; empty where nothing happens at once and no arrows are asked for."""
    moments = tuple(_moments(result, drawing))
    if "reaction" not in result.scene.table.output.arrows:
        return Marks(moments)
    if result.scene.equations.robot_scene is None:
        return Marks(moments, reaction_arrows(result, drawing, times))
    from .robot_marks import robot_reactions

    return Marks(moments, *robot_reactions(result, times))


def reaction_arrows(result: Result, drawing: Drawing, times: np.ndarray) -> tuple[LastingForce, ...]:
    """The forces of the constraint rows, each on the bodies of all coordinates in its row; rows that move no body are left out."""
    values, rates = result.motion.reaction(times), result.motion.reaction_function.derivative(1)(times)
    found = []
    for i, row in enumerate(result.system.rows):
        arrows = tuple(_row_arrows(result, drawing, row.coefficients, 0))
        if arrows:
            found.append(LastingForce(row.name, values[i], rates[i], arrows))
    return tuple(found)


def _row_arrows(result: Result, drawing: Drawing, row: np.ndarray, order: int) -> Iterator[tuple[Arrow, float]]:
    """Arrows with the row's factors: of forces for order 0, of their impulses for order 1."""
    coordinates = result.scene.equations.coordinates
    for i in np.flatnonzero(row):
        unit = force_unit(coordinates.units[i])
        arrow = arrow_at(drawing, coordinates.names[i], impulse_unit(unit) if order else unit)
        if arrow:
            yield arrow, float(row[i])


def _moments(result: Result, drawing: Drawing) -> Iterator[Moment]:
    motion, coordinates = result.motion, result.scene.equations.coordinates
    jumps = jumps_of(motion, coordinates)
    strikes = _strikes(result, drawing, 0.0)
    told = _told(0.0, jumps, _impulses(result, motion.impulses, 0.0))
    if told:
        yield Moment(0.0, told, motion.initial[0], motion.start[0], strikes)
    events = {event.time: event for event in motion.events}
    struck = {blow.time for blows in _later_blows(result) for blow in blows}
    end = float(result.times[-1])
    for time in sorted({*events, *struck})[:MOST_MOMENTS]:
        if time <= end:
            yield _later(result, drawing, time, events.get(time))


def _later(result: Result, drawing: Drawing, time: float, event: Event | None) -> Moment:
    motion, coordinates = result.motion, result.scene.equations.coordinates
    before, after = sides(motion, event, 0) if event else (motion(time), motion(time))
    jumps = later_jumps_of(motion, event, coordinates) if event else []
    told = _told(time, jumps, _impulses(result, event.impulses if event else (), time))
    return Moment(time, told, before, after, _strikes(result, drawing, time))


def _told(time: float, jumps: Sequence[Jump], impulses: Iterable[str]) -> tuple[str, ...]:
    """A heading and what happens, or nothing."""
    lines = [f"{_whose(jump)} jumps from {jump.before} to {jump.after}" for jump in jumps] + list(impulses)
    more = len(lines) - MOST_TOLD
    kept = lines if more <= 0 else [*lines[:MOST_TOLD], f"and {more} more, see the tables"]
    faint = " (faint: just before)" if any(jump.what in ("displacement", "angle") for jump in jumps) else ""
    return (f"at t = {number(time)} s{faint}", *kept) if lines else ()


def _whose(jump: Jump) -> str:
    return jump.name if jump.what in ("displacement", "angle", "value") else f"{jump.what} of {jump.name}"


def _impulses(result: Result, impulses, time: float) -> Iterator[str]:
    """Impulses of coordinates, of constraint forces and of forces, at a time."""
    coordinates = result.scene.equations.coordinates
    for impulse in impulses_of(impulses, coordinates.names, coordinates.units):
        yield f"{impulse.name} contains {_delta(impulse.order)} of {impulse.size}"
    for name, unit, values in _force_impulses(result, time):
        for order, value in enumerate(values):
            if value:
                yield f"{_delta(order)} of {sized(value, impulse_unit(unit, order))}: {name}"


def _delta(order: int) -> str:
    return "δ" + "′" * order if order < 4 else f"δ^({order})"


def _strikes(result: Result, drawing: Drawing, time: float) -> tuple[Strike, ...]:
    """Arrows of the impulses of constraint forces and forces at a time, without derivatives of impulses."""
    if result.scene.equations.robot_scene is not None:
        from .robot_marks import robot_strikes

        of_rows = _blows_at(result, time)[0]
        return robot_strikes(result, of_rows[0] if of_rows else None, time)
    found: list[Strike] = []
    rows = result.system.rows if result.system else ()
    by_name = {f"force of {row.name}": row for row in rows}
    for name, unit, values in _force_impulses(result, time):
        if not values or not values[0]:
            continue
        row = by_name.get(name)
        arrow = arrow_at(drawing, name.removeprefix("force on "), impulse_unit(unit))
        arrows = _row_arrows(result, drawing, row.coefficients, 1) if row else [(arrow, 1.0)] * bool(arrow)
        for drawn, factor in arrows:
            size = factor * values[0]
            found.append((drawn, size, sized(abs(size), drawn.unit)))
    return tuple(found)


def _force_impulses(result: Result, time: float) -> Iterator[tuple[str, str, list[float]]]:
    """Name, unit and impulses by order of each force that has any at a time: of constraint rows, then on coordinates."""
    if result.system is None:
        return
    rows = result.system.rows
    of_rows, applied = _blows_at(result, time)
    for i, row in enumerate(rows):
        values = [float(impulse[i]) for impulse in of_rows]
        if any(values):
            yield f"force of {row.name}", force_unit(row.unit), values
    for name, unit, values in _applied(result, applied, time):
        if any(values):
            yield f"force on {name}", force_unit(unit), values


def _applied(result: Result, applied, time: float) -> Iterable[tuple[str, str, list[float]]]:
    """Of a robot what is struck by name, as it was said, of others each coordinate, with the impulses by order."""
    coordinates = result.scene.equations.coordinates
    if result.scene.equations.robot_scene is not None:
        from .robot_marks import robot_blows

        return robot_blows(result, time)
    rows = zip(coordinates.names, coordinates.units)
    return [(name, unit, [float(impulse[i]) for impulse in applied]) for i, (name, unit) in enumerate(rows)]


def _blows_at(result: Result, time: float):
    """Impulses of the constraint rows and of the forces at a time, by order."""
    motion = result.motion
    if time == 0.0:
        return motion.constraint_impulses if result.system.rows else (), motion.applied.impulses
    return tuple(next((blow.impulses for blow in blows if blow.time == time), ()) for blows in _later_blows(result))


def _later_blows(result: Result):
    """After t = 0: of the constraint rows, and of the forces."""
    if result.system is None:
        return ((), ())
    return (result.motion.later_constraint_impulses, result.motion.applied.later)
