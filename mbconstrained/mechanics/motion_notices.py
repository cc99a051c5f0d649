"""What a motion says about itself, in sentences with names and units."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..notices import Notice
from ..response.notices import first_and_count, sides
from ..signals.impulsive import Blow
from ..tolerances import noise_of
from .units import force_unit, impulse_unit, rate_unit

if TYPE_CHECKING:
    from .constraint import ConstraintRow
    from .motion import Motion

STATE_NAMES = ("displacement", "velocity")
DELTAS = ("a Dirac impulse", *(f"the {order} derivative of a Dirac impulse" for order in ("first", "second", "third")))


def motion_notices(motion: Motion) -> tuple[Notice, ...]:
    """Everything worth knowing, the causes before their effects."""
    return (
        *motion.system.notices,
        *_broken_rows(motion),
        *_jumps(motion),
        *_coordinate_impulses(motion),
        *_constraint_impulses(motion),
        *_later(motion),
        *motion.force.notices,
        *_drift(motion),
        *_static_offsets(motion),
        *motion.solution.notices,
    )


def _broken_rows(motion: Motion) -> Iterator[Notice]:
    """Rows that the values at 0- do not obey, in the held derivative or in one that follows from it."""
    for row in motion.system.rows:
        for order in range(row.order, 2):
            value = row.value if order == row.order else 0.0
            found, noise = _row_value(row, motion.initial[order])
            if abs(found - value) > noise + noise_of(abs(value)):
                unit = rate_unit(row.unit, order)
                yield Notice(
                    "jump",
                    f'constraint "{row.name}" ({row.level} level) does not hold at 0-: its {STATE_NAMES[order]} is '
                    f"{found:.6g} {unit} instead of {value:.6g} {unit}, off by {found - value:.6g} {unit}; it is enforced at t = 0",
                )


def _jumps(motion: Motion) -> Iterator[Notice]:
    for order, what in enumerate(STATE_NAMES):
        yield from _jump_sentences(motion, order, what, motion.jump[order], motion.start[order], motion.initial[order], "t = 0")


def _jump_sentences(motion: Motion, order, what, jump, after, before, when) -> Iterator[Notice]:
    for i in np.flatnonzero(jump):
        unit = rate_unit(_unit(motion, i), order)
        yield Notice(
            "jump",
            f"{motion.names[i]}: its {what} jumps at {when} by {jump[i]:.6g} {unit}, "
            f"from {before[i]:.6g} {unit} to {after[i]:.6g} {unit}",
        )


def _coordinate_impulses(motion: Motion, impulses=None, when: str = "t = 0") -> Iterator[Notice]:
    for order, sizes in enumerate(motion.impulses if impulses is None else impulses):
        for i in np.flatnonzero(sizes):
            size = f"{sizes[i]:.6g} {impulse_unit(_unit(motion, i), order)}"
            yield Notice("impulse", f"{motion.names[i]}: its displacement contains {_delta(order)} of {size} at {when}")


def _constraint_impulses(motion: Motion, impulses=None, when: str = "t = 0") -> Iterator[Notice]:
    for order, sizes in enumerate(motion.constraint_impulses if impulses is None else impulses):
        for i in np.flatnonzero(sizes):
            row = motion.system.rows[i]
            size = f"{sizes[i]:.6g} {impulse_unit(force_unit(row.unit), order)}"
            yield Notice("impulse", f'constraint "{row.name}": its force contains {_delta(order)} of {size} at {when}')


def _later(motion: Motion) -> Iterator[Notice]:
    """What happens after t = 0, the first of it in the same words, the rest counted."""
    yield from first_and_count(lambda event: _event_sentences(motion, event), motion.events, motion.later_constraint_impulses)


def _event_sentences(motion: Motion, event) -> Iterator[Notice]:
    when = f"t = {event.time:.6g} s"
    if isinstance(event, Blow):
        yield from _constraint_impulses(motion, event.impulses, when)
        return
    for order, what in enumerate(STATE_NAMES):
        if event.jump[order].any():
            before, after = sides(motion, event, order)
            yield from _jump_sentences(motion, order, what, event.jump[order], after, before, when)
    yield from _coordinate_impulses(motion, event.impulses, when)


def _drift(motion: Motion) -> Iterator[Notice]:
    """Rows below position level: what they leave as it was at the start, and how it moves on."""
    for row in motion.system.rows:
        if row.order == 0:
            continue
        place, _ = _row_value(row, motion.start[0])
        rate, noise = _row_value(row, motion.start[1])
        moving = f" and moves on at {rate:.6g} {row.unit}/s" if abs(rate) > noise else ""
        yield Notice(
            "drift",
            f'constraint "{row.name}" is held at {row.level} level ({row.order} drift zero{"s" if row.order > 1 else ""}): '
            f"its position value starts at {place:.6g} {row.unit}{moving}; nothing corrects it",
        )


def _static_offsets(motion: Motion) -> Iterator[Notice]:
    system = motion.system
    loads = [
        f"{name} {load:.6g} {force_unit(unit)}" for (name, unit), load in zip(system.units.items(), system.static_force) if load
    ]
    if loads:
        yield Notice("offset", f"constant forces from rest lengths and weights act from t = 0 on: {', '.join(loads)}")


def _row_value(row: ConstraintRow, state: np.ndarray) -> tuple[float, float]:
    """a x with its rounding noise."""
    size = np.abs(row.coefficients) @ np.abs(state)
    value = float(row.coefficients @ state)
    noise = noise_of(float(size), len(state))
    return (value if abs(value) > noise else 0.0), noise


def _delta(order: int) -> str:
    return DELTAS[order] if order < len(DELTAS) else f"the derivative of order {order} of a Dirac impulse"


def _unit(motion: Motion, i: int) -> str:
    return motion.system.units[motion.names[i]]
