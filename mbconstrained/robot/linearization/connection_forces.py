"""Forces of loops, springs and bushings during small motions, in the directions of the ground.

The wrench T f of a connection, with f = -dU/dphi - D phi' of a spring and f = G^T lambda of a loop, to first order in the motion:

    T f = T_0 f_0 + (dT/dq f_0 + T_0 df/dq) d + T_0 df/dq' d' + T_0 G^T dlambda
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...ground.tolerances import CONE_TOLERANCE
from ..statics.contacts import limit_values, moving_contact_notices

if TYPE_CHECKING:
    from ...ground.notices import Notice
    from ..connections import Connection
    from ..posture import Posture


@dataclass(frozen=True, eq=False)
class ConnectionForces:
    """F = rest + displacement d + velocity d' + multipliers dlambda: forces (N) and torques (N m) on the second bodies, k rows.

    A force has the directions x, y, z of the ground, which do not turn; a torque, too, about the point of the connection on the
    second body. Loads at rest are included.

    Attributes:
        connections: the loops, then springs and bushings.
        places: by name of a connection its rows: three forces, then three torques where it can have any.
        names, units: names and units of the rows.
        rest: at the posture, shape (k,).
        displacement, velocity: by the coordinates of the system, shape (k, n).
        multipliers: by those of its constraint rows, shape (k, m).
    """

    connections: tuple[Connection, ...]
    places: dict[str, slice]
    names: tuple[str, ...]
    units: tuple[str, ...]
    rest: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    multipliers: np.ndarray

    def values(self, d: np.ndarray, rates: np.ndarray, multipliers: np.ndarray) -> np.ndarray:
        """F over time.

        Args:
            d: deviations from the posture, shape (n, T).
            rates: their derivatives by time, shape (n, T).
            multipliers: of the constraint rows, changes of those at rest, shape (m, T).

        Returns:
            Shape (k, T), in N and N m.
        """
        return self.rest[:, None] + self.displacement @ d + self.velocity @ rates + self.multipliers @ multipliers


def connection_forces(posture: Posture, size: int, rows: Sequence[str]) -> ConnectionForces:
    """The forces of all loops, springs and bushings about a posture."""
    balance, load = posture.balance, posture.balance.load
    connections = tuple(item.connection for item in (*load.loops, *load.springs))
    parts, start = [], 0
    for item, G in zip(load.loops, balance.gradients):
        pose, own = item.pose(balance.kinematics), posture.multipliers[start : start + len(G)]
        curvature = item.connection.curvature(pose.value, own)
        gradients = dict(zip(load.row_names[start : start + len(G)], G))
        by_row = np.array([gradients.get(name, np.zeros(6)) for name in rows]).reshape(-1, 6).T
        parts.append((pose, G.T @ own, curvature, np.zeros((6, 6)), by_row))
        start += len(G)
    parts += [(own.pose, own.wrench, -own.curvature, -own.damper, np.zeros((6, len(rows)))) for own in balance.elastic]
    blocks, places, count = [], {}, 0
    for one, (pose, f, by_phi, by_rate, by_row) in zip(connections, parts):
        T, J, kept = pose.directions, pose.jacobian, 6 if one.turning else 3
        moved, damped = pose.wrench_change(f) + T @ by_phi @ J, T @ by_rate @ J
        motors = np.zeros((6, size - J.shape[1]))
        blocks.append(np.column_stack([T @ f, moved, motors, damped, motors, T @ by_row])[:kept])
        places[one.name] = slice(count, count := count + kept)
    rest, displacement, velocity, multipliers = np.split(
        np.vstack([np.zeros((0, 1 + 2 * size + len(rows))), *blocks]), [1, 1 + size, 1 + 2 * size], axis=1
    )
    names = [f"{one.name} {axis}" for one in connections for _ in range(1 + one.turning) for axis in "xyz"]
    units = [unit for one in connections for unit in ("N", "N m")[: 1 + one.turning] for _ in "xyz"]
    return ConnectionForces(
        connections,
        places,
        tuple(names),
        tuple(units),
        rest[:, 0],
        displacement,
        velocity,
        multipliers,
    )


def foot_limits(posture: Posture, forces: ConnectionForces, values, sizes: Mapping[str, float], error: float) -> np.ndarray:
    """Violation of the limits of feet, positive where ``foot_notices`` reports it."""
    return limit_values(posture.balance, _wrenches(forces, values), sizes, max(error, CONE_TOLERANCE))


def _wrenches(forces: ConnectionForces, values: np.ndarray) -> dict[str, np.ndarray]:
    """Force and torque of each connection, shape (6, T)."""
    wrenches = {name: np.zeros((6, values.shape[1])) for name in forces.places}
    for name, rows in forces.places.items():
        wrenches[name][: rows.stop - rows.start] = values[rows]
    return wrenches


def foot_notices(posture: Posture, forces: ConnectionForces, times, values, reactions, error: float) -> Iterator[Notice]:
    """Notices on feet that lift off, slip or tip over during a motion but not at rest."""
    balance, robot = posture.balance, posture.robot
    multipliers = np.tile(posture.multipliers[:, None], 1 + len(times))
    for name, change in reactions.items():
        if name in balance.load.row_names:
            multipliers[balance.load.row_names.index(name), 1:] += change
    wrenches = _wrenches(forces, np.column_stack([forces.rest, values]))
    free = ~np.isin(robot.coordinates, list(posture.torques))
    yield from moving_contact_notices(balance, free, multipliers, times, wrenches, error)
