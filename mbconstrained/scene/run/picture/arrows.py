"""The overlay of an animation: jumps and impulses at their times, and the reactions that [output] arrows requests."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ....ground.coordinate_units import force_unit, impulse_unit
from ....ground.display import number_text, with_unit
from ....page.animation.animation import Arrow, DrawnEvent, ForceArrows, ImpulseArrow, Overlay, arrow_at
from ....page.drawing.bodies import Drawing
from ....response.response_notices import sides, without_kinks
from ..report.jumps import ReportedJump, forces_of_rows, impulses_of, jumps_of

if TYPE_CHECKING:
    from ....response.events import Event
    from ..answer import SceneAnswer

#: Most events in an animation; the first are shown.
MOST_EVENTS = 100

#: Lines of one event in the picture; the tables have all.
MOST_LINES = 6


def overlay_of(result: SceneAnswer, drawing: Drawing, times: np.ndarray) -> Overlay:
    """Jumps, impulses and reactions to be drawn; empty without any of them and without [output] arrows."""
    applied = result.motion.applied if result.system else None
    has_events = result.jumps or result.impulses or result.later or (applied and (applied.impulses or applied.later))
    events = tuple(_events(result, drawing)) if has_events else ()
    if "reaction" not in result.scene.table.output.arrows:
        return Overlay(events)
    if result.scene.equations.robot_scene is None:
        return Overlay(events, _reaction_arrows(result, drawing, times))
    from .robot_arrows import robot_reactions

    return Overlay(events, *robot_reactions(result, times))


def _reaction_arrows(result: SceneAnswer, drawing: Drawing, times: np.ndarray) -> tuple[ForceArrows, ...]:
    """Forces of the constraint rows, each on the bodies of all coordinates in its row; rows without a body are omitted."""
    values, rates = result.motion.reaction(times), result.motion.reaction_function.derivative(1)(times)
    forces = []
    for i, row in enumerate(result.system.rows):
        arrows = tuple(_row_arrows(result, drawing, row.coefficients, 0))
        if arrows:
            forces.append(ForceArrows(row.name, values[i], rates[i], arrows))
    return tuple(forces)


def _row_arrows(result: SceneAnswer, drawing: Drawing, row: np.ndarray, order: int) -> Iterator[tuple[Arrow, float]]:
    """Arrows with the row's factors: of forces for order 0, of their impulses for order 1."""
    coordinates = result.scene.equations.coordinates
    for i in np.flatnonzero(row):
        unit = force_unit(coordinates.units[i])
        arrow = arrow_at(drawing, coordinates.names[i], impulse_unit(unit) if order else unit)
        if arrow:
            yield arrow, float(row[i])


def _events(result: SceneAnswer, drawing: Drawing) -> Iterator[DrawnEvent]:
    motion = result.motion
    impulse_arrows = _impulse_arrows(result, drawing, 0.0)
    lines = _lines(0.0, result.jumps, _impulses(result, motion.impulses, 0.0))
    if lines:
        yield DrawnEvent(0.0, lines, motion.initial[0], motion.start[0], impulse_arrows)
    events = {event.time: event for event in without_kinks(motion)}
    impulse_times = {load.time for loads in _later_impulsive_loads(result) for load in loads}
    end = float(result.times[-1])
    for time in sorted({*events, *impulse_times})[:MOST_EVENTS]:
        if time <= end:
            yield _later(result, drawing, time, events.get(time))


def _later(result: SceneAnswer, drawing: Drawing, time: float, event: Event | None) -> DrawnEvent:
    motion, coordinates = result.motion, result.scene.equations.coordinates
    before, after = sides(motion, event, 0) if event else (motion(time), motion(time))
    jumps = jumps_of(motion, coordinates, event) if event else []
    lines = _lines(time, jumps, _impulses(result, event.impulses if event else (), time))
    return DrawnEvent(time, lines, before, after, _impulse_arrows(result, drawing, time))


def _lines(time: float, jumps: Sequence[ReportedJump], impulses: Iterable[str]) -> tuple[str, ...]:
    """A heading and the events, or nothing."""
    lines = [f"{_whose(jump)} jumps from {jump.before} to {jump.after}" for jump in jumps] + list(impulses)
    more = len(lines) - MOST_LINES
    kept = lines if more <= 0 else [*lines[:MOST_LINES], f"and {more} more, see the tables"]
    faint = " (faint: just before)" if any(jump.what in ("displacement", "angle") for jump in jumps) else ""
    return (f"at t = {number_text(time)} s{faint}", *kept) if lines else ()


def _whose(jump: ReportedJump) -> str:
    return jump.name if jump.what in ("displacement", "angle", "value") else f"{jump.what} of {jump.name}"


def _impulses(result: SceneAnswer, impulses, time: float) -> Iterator[str]:
    """Impulses of coordinates, of constraint forces and of forces, at a time."""
    for impulse in impulses_of(impulses, result.scene.equations.coordinates):
        yield f"{impulse.name} contains {_delta(impulse.order)} of {impulse.size}"
    for name, unit, values in _force_impulses(result, time):
        for order, value in enumerate(values):
            if value:
                yield f"{_delta(order)} of {with_unit(value, impulse_unit(unit, order))}: {name}"


def _delta(order: int) -> str:
    return "δ" + "′" * order if order < 4 else f"δ^({order})"


def _impulse_arrows(result: SceneAnswer, drawing: Drawing, time: float) -> tuple[ImpulseArrow, ...]:
    """Arrows of the impulses of constraint forces and forces at a time, without derivatives of impulses."""
    if result.scene.equations.robot_scene is not None:
        from .robot_arrows import robot_impulse_arrows

        of_rows = _impulses_at(result, time)[0]
        return robot_impulse_arrows(result, of_rows[0] if of_rows else None, time)
    impulse_arrows: list[ImpulseArrow] = []
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
            impulse_arrows.append(ImpulseArrow(drawn, size, with_unit(abs(size), drawn.unit)))
    return tuple(impulse_arrows)


def _force_impulses(result: SceneAnswer, time: float) -> Iterator[tuple[str, str, list[float]]]:
    """Name, unit and impulses by order of each force that has any at a time: of constraint rows, then on coordinates."""
    if result.system is None:
        return
    of_rows, applied = _impulses_at(result, time)
    forces = forces_of_rows(result.system)
    for i, (name, unit) in enumerate(zip(forces.names, forces.units)):
        values = [float(impulse[i]) for impulse in of_rows]
        if any(values):
            yield name, unit, values
    for name, unit, values in _applied(result, applied, time):
        if any(values):
            yield f"force on {name}", force_unit(unit), values


def _applied(result: SceneAnswer, applied, time: float) -> Iterable[tuple[str, str, list[float]]]:
    """Coordinates under an impulsive load, for a robot also inputs, with their impulses by order."""
    coordinates = result.scene.equations.coordinates
    if result.scene.equations.robot_scene is not None:
        from .robot_arrows import robot_impulsive_loads

        return robot_impulsive_loads(result, time)
    rows = zip(coordinates.names, coordinates.units)
    return [(name, unit, [float(impulse[i]) for impulse in applied]) for i, (name, unit) in enumerate(rows)]


def _impulses_at(result: SceneAnswer, time: float):
    """Impulses of the constraint rows and of the forces at a time, by order."""
    motion = result.motion
    if time == 0.0:
        return motion.constraint_impulses if result.system.rows else (), motion.applied.impulses
    return tuple(next((load.impulses for load in loads if load.time == time), ()) for loads in _later_impulsive_loads(result))


def _later_impulsive_loads(result: SceneAnswer):
    """Impulsive loads after t = 0: of the constraint rows, and of the forces."""
    if result.system is None:
        return ((), ())
    return (result.motion.later_constraint_impulses, result.motion.applied.later)
