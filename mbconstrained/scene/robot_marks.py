"""Reactions and impulses of a robot as arrows, where they act: at the frames of its loops, at its joints, at points pushed.

Reactions are the whole load: the multipliers at rest and their changes, which the plots show alone, together.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..mechanics.units import force_unit, impulse_unit
from ..models.robot import PointMotion
from ..models.robot.wrenches import Wrench, coordinate_wrench, row_wrenches
from ..page.marks import Arrow, LastingForce, Strike
from .forces import placed_signal
from .robot_values import FORCE

if TYPE_CHECKING:
    from .result import Result

#: Of more bodies than these only the number is told over the picture.
MOST_NAMED = 3

#: An arrow shorter than this share of the longest of its kind is rounding.
ROUNDING = 1e-9


def robot_reactions(result: Result, times: np.ndarray) -> tuple[tuple[LastingForce, ...], str]:
    """A force, and a moment where there is one, for each loop and coupling, at times (T,); and what they are, in words."""
    posture, function = result.scene.equations.posture, result.motion.reaction_function
    kept = list(posture.independent_rows)
    multipliers = np.tile(posture.multipliers[:, None], len(times))
    rates = np.zeros_like(multipliers)
    multipliers[kept] += function(times)
    rates[kept] = function.derivative(1)(times)
    wrenches = row_wrenches(posture)
    drawn = [(wrench, arrow, part) for wrench in wrenches for arrow, part in _arrows(wrench, 0)]
    forces = tuple(LastingForce(_name(*pair), part @ multipliers, part @ rates, ((pair[1], 1.0),)) for *pair, part in drawn)
    return forces, f"reactions on {_listed([wrench.on for wrench, *_ in drawn])}, the load at rest included"


def _name(wrench: Wrench, arrow: Arrow) -> str:
    return f"{wrench.name} on {wrench.on}{', moment' if arrow.turns else ''}"


def _listed(names: Sequence[str]) -> str:
    names = list(dict.fromkeys(names))
    if len(names) > MOST_NAMED:
        names[MOST_NAMED - 1 :] = [f"{len(names) - MOST_NAMED + 1} more bodies"]
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))


def _arrows(wrench: Wrench, order: int) -> Iterator[tuple[Arrow, np.ndarray]]:
    """The force and the moment with what they are made of, shape (3, m), those that can act; impulses for order 1."""
    for unit, turns, part in ((FORCE["m"], False, wrench.force), (FORCE["rad"], True, wrench.moment)):
        if part.any():
            unit = unit.replace("*", " ")
            yield Arrow(wrench.body, None, impulse_unit(unit) if order else unit, turns, tuple(wrench.point.tolist())), part


def robot_strikes(result: Result, of_rows: np.ndarray | None, time: float) -> tuple[Strike, ...]:
    """Impulses of the constraint rows (k,), or None, and of the forces at a time as arrows."""
    posture, found = result.scene.equations.posture, []
    if of_rows is not None:
        multipliers = np.zeros(len(posture.multipliers))
        multipliers[list(posture.independent_rows)] = of_rows
        found += [_strike(arrow, part @ multipliers) for wrench in row_wrenches(posture) for arrow, part in _arrows(wrench, 1)]
    for name, unit, values in robot_blows(result, time):
        if values and values[0]:
            found += [_strike(arrow, part * values[0]) for arrow, part in _pushed(result, name, unit)]
    largest: dict[str, float] = {}
    for arrow, size, _ in found:
        largest[arrow.unit] = max(largest.get(arrow.unit, 0.0), float(np.linalg.norm(size)))
    return tuple(strike for strike in found if np.linalg.norm(strike[1]) > ROUNDING * largest[strike[0].unit])


def _strike(arrow: Arrow, size: np.ndarray | float) -> Strike:
    return arrow, size, f"{np.linalg.norm(size):.3g} {arrow.unit}"


def robot_blows(result: Result, time: float) -> Iterator[tuple[str, str, list[float]]]:
    """Name, unit ("m" or "rad") and impulses by order of each input or coordinate that is struck at a time."""
    equations, struck = result.scene.equations, {}
    for table in result.scene.table.force:
        if table.kind == "sampled":
            continue
        _, unit, signal = placed_signal(table, equations.coordinates, result.scene.path.parent, equations.robot_scene.system)
        blows = {0.0: signal.impulses, **{blow.time: blow.impulses for blow in signal.later}}
        values = [float(impulse[0]) for impulse in blows.get(time, ())]
        _, before = struck.get(table.coordinate, (unit, []))
        length = max(len(values), len(before))
        sums = np.pad(values, (0, length - len(values))) + np.pad(before, (0, length - len(before)))
        struck[table.coordinate] = unit, sums.tolist()
    return ((name, unit, values) for name, (unit, values) in struck.items() if any(values))


def _pushed(result: Result, name: str, unit: str) -> Iterator[tuple[Arrow, np.ndarray | float]]:
    """The arrow of a unit impulse on an input or coordinate."""
    found = result.scene.equations.robot_scene
    motion = found.inputs.get(name, name)
    if isinstance(motion, PointMotion):
        arrow = Arrow(motion.body, motion.along, impulse_unit(force_unit(unit)), motion.turn, motion.point)
        return iter([(arrow, 1.0)])
    joints = found.robot.coordinates
    place = joints.index(motion.removesuffix(" motor") if motion not in joints else motion)
    return ((arrow, part[:, 0]) for arrow, part in _arrows(coordinate_wrench(found.posture, place), 1))
