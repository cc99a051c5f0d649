"""Forces of loops, springs and bushings of a robot during the motion: extremes as a table and as data, and feet that leave the ground."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ....ground.display import TextTable
from ....ground.notices import Notice
from ..curves import PARTS, drawn_functions, functions_of, positive_times_of, sampled_extrema_of
from ..decisions import connection_forces
from .robot_report import ROUNDING

if TYPE_CHECKING:
    from ..answer import SceneAnswer


def forces_json(result: SceneAnswer) -> dict:
    """Extremes of the forces of loops, springs and bushings during the run (N, s); empty where they are not computed.

    For a foot with friction also those of the normal force and the largest tangential force.
    """
    if not connection_forces(result.scene)[0]:
        return {}
    from ....robot.connections import Support

    forces, at = result.scene.equations.robot_scene.system.connection_forces, functions_of(result, "ground_reaction")
    feet = {one.name: one for one in forces.connections if isinstance(one, Support) and one.friction is not None}

    def sizes(times: np.ndarray) -> np.ndarray:
        """Magnitude of each force, and for a foot the normal and the tangential part."""
        rows, values = [], at(times)
        for connection in forces.connections:
            force = values[forces.places[connection.name]][:3]
            foot = feet.get(connection.name)
            rows += [np.linalg.norm(force, axis=0), *(foot.parts(foot.on_foot(force)) if foot else ())]
        return np.array(rows)

    extrema = sampled_extrema_of(result, sizes)
    extremes, row = {}, 0
    for connection in forces.connections:
        largest, time = float(extrema.maximum[row]), float(extrema.maximum_time[row])
        extremes[connection.name] = {"on": connection.body2, "largest": largest, "time": time}
        if connection.name in feet:
            ends = [float(extrema.minimum[row + 1]), float(extrema.maximum[row + 1])]
            extremes[connection.name] |= {"normal": ends, "tangential": float(extrema.maximum[row + 2])}
        row += 3 if connection.name in feet else 1
    return extremes


def forces_table(result: SceneAnswer) -> TextTable:
    """Table of extremes of forces for the summary and the page."""
    extremes = forces_json(result)
    rounding, rows = ROUNDING * max((one["largest"] for one in extremes.values()), default=0.0), []
    for name, one in extremes.items():
        sizes = [one["largest"], *one.get("normal", ()), *([one["tangential"]] if "normal" in one else [])]
        largest, *of_foot = [f"{size if abs(size) > rounding else 0.0:.4g}" for size in sizes]
        ends, along = (f"{of_foot[0]} ... {of_foot[1]} N", f"{of_foot[2]} N") if of_foot else ("", "")
        rows.append((name, one["on"], f"{largest} N", f"{one['time']:.4g} s", ends, along))
    has_feet = any("normal" in one for one in extremes.values())
    columns = ("loop or spring", "on", "largest force", "at", "normal force", "tangential force")
    count = len(columns) if has_feet else 4
    note = "During the run, loads at rest included, to first order in the motion"
    note += "; a normal force is positive where the foot presses, a tangential one is the largest." if has_feet else "."
    return TextTable("Forces during the motion", columns[:count], tuple(row[:count] for row in rows), note + _open_shares(result))


def _open_shares(result: SceneAnswer) -> str:
    """A sentence on redundant rows of loops; empty without them."""
    from ....robot.statics.regularity import implied_rows

    posture = result.scene.equations.posture
    names = implied_rows(posture.balance, posture.independent_rows)
    if not names:
        return ""
    named = f"{', '.join(names[:3])}{f' and {len(names) - 3} more' if len(names) > 3 else ''}"
    return f" It is open how connections share the changes of forces: here {named} {'has' if len(names) == 1 else 'have'} no part in them."


def forces_notices(result: SceneAnswer) -> tuple[Notice, ...]:
    """Notices on feet that lift off, slip or tip over during the motion, at the times of the closed form."""
    from ....robot.connections import Support
    from ....robot.linearization.connection_forces import foot_limits, foot_notices

    forces, posture = result.scene.equations.robot_scene.system.connection_forces, result.scene.equations.posture
    feet = [one.name for one in forces.connections if isinstance(one, Support) and one.friction is not None]
    if not feet:
        return ()
    error = max(result.error_estimates.get(part, 0.0) for part in PARTS["ground_reaction"])
    drawn, at = drawn_functions(result, "ground_reaction"), functions_of(result, "ground_reaction")
    places = [forces.places[name] for name in feet]

    def norms(times: np.ndarray) -> np.ndarray:
        values = drawn(times)
        return np.linalg.norm([values[rows][:3] for rows in places], axis=1)

    largest = sampled_extrema_of(result, norms)

    def outside(times: np.ndarray, clearly: float = 2.0) -> np.ndarray:
        """Excess of feet over a multiple of the tolerances, by foot and limit: notices lie between this and its half."""
        sizes = dict(zip(feet, clearly * largest.maximum))
        return foot_limits(posture, forces, drawn(times), sizes, error).reshape(len(feet), -1, len(times))

    lifting = positive_times_of(result, lambda times: outside(times, 0.5)[:, 0])[1][:, None, None]

    def before(times: np.ndarray) -> np.ndarray:
        """Slipping and tipping of a foot, until it lifts off."""
        limits = outside(times)
        return np.concatenate([limits[:, :1], np.where(times < lifting, limits[:, 1:], -1.0)], axis=1).reshape(-1, len(times))

    further = np.concatenate([largest.maximum_time, *positive_times_of(result, before)])
    times = np.union1d(result.times, further[np.isfinite(further)])
    reactions = dict(zip((row.name for row in result.system.rows), result.motion.reaction(times)))
    return tuple(foot_notices(posture, forces, times, at(times), reactions, error))
