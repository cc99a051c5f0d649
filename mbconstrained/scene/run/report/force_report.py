"""Forces of loops, springs and bushings of a robot during the motion: extremes as a table and as data, and feet that leave the ground."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ....ground.coordinate_units import GROUND
from ....ground.display import TextTable
from ....ground.notices import Notice
from ..curves import PARTS
from ..decisions import connection_forces

if TYPE_CHECKING:
    from ..result import Result


def forces_json(result: Result) -> dict:
    """By loop, spring and bushing the extremes of its force at the times of the run (N, s); empty where they are not computed.

    Of a foot with friction those across the ground, on the foot, and the largest along it, too.
    """
    if not connection_forces(result.scene)[0]:
        return {}
    from ....robot.connections import Support

    forces, values = result.scene.equations.robot_scene.system.connection_forces, result.curves("ground_reaction").values
    extremes = {}
    for connection in forces.connections:
        force = values[forces.places[connection.name]][:3]
        sizes = np.linalg.norm(force, axis=0)
        most = int(sizes.argmax())
        extremes[connection.name] = {"on": connection.body2, "largest": float(sizes[most]), "time": float(result.times[most])}
        if isinstance(connection, Support) and connection.friction is not None:
            normal = np.array(connection.normal) / np.linalg.norm(connection.normal)
            along = normal @ force
            across = np.linalg.norm(force - np.outer(normal, along), axis=0)
            ends = sorted((along if connection.body1 == GROUND else -along)[[along.argmin(), along.argmax()]].tolist())
            extremes[connection.name] |= {"normal": ends, "tangential": float(across.max())}
    return extremes


def forces_table(result: Result) -> TextTable:
    """The same for the summary and the page."""
    extremes = forces_json(result)
    rows = []
    for name, one in extremes.items():
        ends = f"{one['normal'][0]:.4g} ... {one['normal'][1]:.4g} N" if "normal" in one else ""
        along = f"{one['tangential']:.4g} N" if "normal" in one else ""
        rows.append((name, one["on"], f"{one['largest']:.4g} N", f"{one['time']:.4g} s", ends, along))
    has_feet = any("normal" in one for one in extremes.values())
    columns = ("loop or spring", "on", "largest force", "at", "normal force", "tangential force")
    count = len(columns) if has_feet else 4
    note = "At the times of the run, loads at rest included, to first order in the motion"
    note += "; a normal force is positive where the foot presses, a tangential one is the largest." if has_feet else "."
    return TextTable("Forces during the motion", columns[:count], tuple(row[:count] for row in rows), note)


def forces_notices(result: Result) -> tuple[Notice, ...]:
    """Notices on feet that lift off, slip or tip over during the motion."""
    from ....robot.connections import Support
    from ....robot.linearization.connection_forces import foot_notices

    forces = result.scene.equations.robot_scene.system.connection_forces
    if not any(isinstance(connection, Support) and connection.friction is not None for connection in forces.connections):
        return ()
    error = max(result.error_estimates.get(part, 0.0) for part in PARTS["ground_reaction"])
    reactions = dict(zip((row.name for row in result.system.rows), result.motion.reaction(result.times)))
    values = result.curves("ground_reaction").values
    return tuple(foot_notices(result.scene.equations.posture, forces, result.times, values, reactions, error))
