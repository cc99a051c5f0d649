"""Reactions and impulses of a robot as arrows at the frames of its loops, at its joints, at loaded points.

Reactions are the whole load: the multipliers at rest plus their changes, which the plots show alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np

from ....ground.coordinate_units import force_unit, impulse_unit
from ....ground.tolerances import NOT_DRAWN
from ....page.animation.animation import Arrow, ForceArrows, ImpulseArrow
from ....robot.connections import PointMotion
from ....robot.visualization import Wrench, coordinate_wrench, row_wrenches

if TYPE_CHECKING:
    from ..answer import SceneAnswer

#: For more bodies than these only the number is given over the picture.
MOST_NAMED = 3


def robot_reactions(result: SceneAnswer, times: np.ndarray) -> tuple[tuple[ForceArrows, ...], str]:
    """The reactions of the loops and couplings."""
    posture, function = result.scene.equations.posture, result.motion.reaction_function
    kept = list(posture.independent_rows)
    multipliers = np.tile(posture.multipliers[:, None], len(times))
    rates = np.zeros_like(multipliers)
    multipliers[kept] += function(times)
    rates[kept] = function.derivative(1)(times)
    wrenches = row_wrenches(posture)
    drawn = [(wrench, arrow, part) for wrench in wrenches for arrow, part in _arrows(wrench, 0)]
    forces = tuple(ForceArrows(_name(*pair), part @ multipliers, part @ rates, ((pair[1], 1.0),)) for *pair, part in drawn)
    return forces, f"reactions on {_listed([wrench.on for wrench, *_ in drawn])}, the load at rest included"


def _name(wrench: Wrench, arrow: Arrow) -> str:
    return f"{wrench.name} on {wrench.on}{', moment' if arrow.turns else ''}"


def _listed(names: Sequence[str]) -> str:
    names = list(dict.fromkeys(names))
    if len(names) > MOST_NAMED:
        names[MOST_NAMED - 1 :] = [f"{len(names) - MOST_NAMED + 1} more bodies"]
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))


def _arrows(wrench: Wrench, order: int) -> Iterator[tuple[Arrow, np.ndarray]]:
    """The force and the moment with their contributions, shape (3, m), where they can act; impulses for order 1."""
    for unit, turns, part in (("m", False, wrench.force), ("rad", True, wrench.moment)):
        if part.any():
            force = force_unit(unit)
            yield Arrow(wrench.body, None, impulse_unit(force) if order else force, turns, tuple(wrench.point.tolist())), part


def robot_impulse_arrows(result: SceneAnswer, of_rows: np.ndarray | None, time: float) -> tuple[ImpulseArrow, ...]:
    """The impulses at a time as arrows."""
    posture, arrows = result.scene.equations.posture, []
    if of_rows is not None:
        multipliers = np.zeros(len(posture.multipliers))
        multipliers[list(posture.independent_rows)] = of_rows
        arrows += [
            _impulse_arrow(arrow, part @ multipliers) for wrench in row_wrenches(posture) for arrow, part in _arrows(wrench, 1)
        ]
    for name, unit, values in robot_impulsive_loads(result, time):
        if values and values[0]:
            arrows += [_impulse_arrow(arrow, part * values[0]) for arrow, part in _load_arrows(result, name, unit)]
    largest: dict[str, float] = {}
    for arrow, size, _ in arrows:
        largest[arrow.unit] = max(largest.get(arrow.unit, 0.0), float(np.linalg.norm(size)))
    return tuple(impulse for impulse in arrows if np.linalg.norm(impulse[1]) > NOT_DRAWN * largest[impulse[0].unit])


def _impulse_arrow(arrow: Arrow, size: np.ndarray | float) -> ImpulseArrow:
    return ImpulseArrow(arrow, size, f"{np.linalg.norm(size):.3g} {arrow.unit}")


def robot_impulsive_loads(result: SceneAnswer, time: float) -> Iterator[tuple[str, str, list[float]]]:
    """The impulsive loads at a time."""
    totals: dict[str, tuple[str, list[float]]] = {}
    for load in result.scene.equations.loads:
        impulses = {0.0: load.signal.impulses, **{later.time: later.impulses for later in load.signal.later}}.get(time, ())
        values = [float(impulse[0]) for impulse in impulses]
        _, before = totals.get(load.name, (load.unit, []))
        totals[load.name] = load.unit, [a + b for a, b in zip_longest(values, before, fillvalue=0.0)]
    return ((name, unit, values) for name, (unit, values) in totals.items() if any(values))


def _load_arrows(result: SceneAnswer, name: str, unit: str) -> Iterator[tuple[Arrow, np.ndarray | float]]:
    """The arrow of a unit impulse on an input or coordinate."""
    robot_scene = result.scene.equations.robot_scene
    motion = robot_scene.inputs.get(name, name)
    if isinstance(motion, PointMotion):
        arrow = Arrow(motion.body, motion.along, impulse_unit(force_unit(unit)), motion.turn, motion.point)
        return iter([(arrow, 1.0)])
    joints = robot_scene.robot.coordinates
    place = joints.index(motion.removesuffix(" motor") if motion not in joints else motion)
    return ((arrow, part[:, 0]) for arrow, part in _arrows(coordinate_wrench(robot_scene.posture, place), 1))
