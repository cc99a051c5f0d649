"""Positions and loads of links about a posture, in link frames: the data of drawings.

``link_poses`` gives the motion of the links, ``joint_motions`` its independent directions, ``connection_points`` the ends of loops and springs, ``row_wrenches`` and
``coordinate_wrench`` the forces and moments of multipliers and generalized forces.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import scipy.linalg

from ..ground.checks import real_array, real_number
from ..ground.coordinate_units import GROUND
from ..ground.errors import InputError
from .connections import BodySpring, Connection, Loop
from .kinematics import Anchor
from .mechanism import Attached
from .posture import Posture
from .statics.equilibrium import Search, closed, rows_of
from .tangent import MimicRow

#: Loops count as closed in a drawing below this gap, in rad or relative to the robot's size.
DRAWING_GAP = 1e-5

#: Chord steps with the Jacobian of the posture before Gauss-Newton steps with that of the configuration itself.
MOST_CHORDS = 6

#: A base that moves has the first coordinates.
BASE_COORDINATES = 6


@dataclass(frozen=True, eq=False)
class Poses:
    """Positions (3, T) in m and unit quaternions (4, T) x y z w of a link; both signs of a quaternion are the same rotation."""

    positions: np.ndarray
    quaternions: np.ndarray


def link_poses(posture: Posture, displacements, scale: float = 1.0) -> dict[str, Poses]:
    """The poses of all links for small displacements d, enlarged.

    The configuration is q0 (+) scale d, moved onto the loops by the shortest step: linear motion opens them by the square
    of its size.
    """
    robot, tree = posture.robot, posture.robot.tree
    count = len(robot.coordinates)
    d = real_array(displacements, "displacements", shape=(None, None))
    if len(d) < count:
        raise InputError(f"displacements: found {len(d)} rows; expected one for each of the {count} coordinates")
    d = d[:count] * real_number(scale, "scale")
    on_loops = _onto_loops(posture)
    numbers = [robot.link_frames.number(name) for name in robot.bodies]
    positions, quaternions = np.empty((len(numbers), 3, d.shape[1])), np.empty((len(numbers), 4, d.shape[1]))
    for k, step in enumerate(d.T):
        frames = tree.frames(on_loops(tree.moved(posture.configuration, step)), numbers)
        for body, (position, quaternion) in enumerate(frames):
            positions[body, :, k], quaternions[body, :, k] = position, quaternion
    return {name: Poses(positions[i], quaternions[i]) for i, name in enumerate(robot.bodies)}


@dataclass(frozen=True, eq=False)
class JointMotions:
    """The independent motions of a robot near its posture: q = columns s, with loops closed to first order.

    A link moves by the product exp(S_1 q_1) ... exp(S_n q_n) over its own coordinates; without loops this is exact.

    Attributes:
        names, units: names and units of the r independent coordinates s.
        columns: columns of all coordinates for a unit of each, shape (n, r).
        twists: S_i of each coordinate in ground axes, the velocity at the origin above the rate of rotation, shape (6, n).
        moving: the places of the coordinates that move each link, ascending, by its name.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    columns: np.ndarray
    twists: np.ndarray
    moving: dict[str, tuple[int, ...]]


def joint_motions(posture: Posture) -> JointMotions:
    """The motions that the loops of a robot allow, each named by the coordinate that is 1 in it while the other named ones are 0.

    The names are those of the rows of the null space's basis that a QR decomposition with column pivoting takes first.
    """
    robot, balance = posture.robot, posture.balance
    lengths, columns = balance.load.lengths, np.eye(len(robot.coordinates))
    chosen = np.arange(len(columns))
    if balance.load.has_rows:
        basis = rows_of(balance.scaled_jacobian).motions
        chosen = np.sort(scipy.linalg.qr(basis.T, mode="economic", pivoting=True)[2][: basis.shape[1]])
        columns = lengths[:, None] * np.linalg.solve(basis[chosen].T, basis.T).T / lengths[chosen]
    moves = balance.kinematics.tree.moving
    moving = {name: tuple(np.flatnonzero(moves[robot.link_frames.link(name).joint]).tolist()) for name in robot.bodies}
    names, units = (tuple(texts[i] for i in chosen) for texts in (robot.coordinates, robot.units))
    return JointMotions(names, units, columns, balance.kinematics.columns, moving)


def _onto_loops(posture: Posture) -> Callable[[np.ndarray], np.ndarray]:
    """Map from a configuration near the posture to one with closed loops.

    Chord steps with the Jacobian of the posture come first, since they need no new derivatives; then Gauss-Newton steps. A base
    with a prescribed motion stays where it is moved to.
    """
    robot, load, free = posture.robot, posture.balance.load, np.ones(len(posture.balance.load.units), bool)
    if robot.moving_base is not None:
        load = replace(load, loops=tuple(item for item in load.loops if item.connection != robot.moving_base))
        free[:BASE_COORDINATES] = False
    if not load.has_rows:
        return lambda q: q
    search = Search(robot.tree, load, free)
    rows = rows_of(search.at(posture.configuration).scaled_jacobian[:, free])

    def on_loops(q: np.ndarray) -> np.ndarray:
        here = search.at(q)
        for _ in range(MOST_CHORDS):
            if np.abs(here.scaled_gaps).max() <= DRAWING_GAP:
                return here.configuration
            step = np.zeros(len(free))
            step[free] = -rows.shortest(here.scaled_gaps)
            here = search.moved(here, step * load.lengths)
        return closed(search, q).configuration

    return on_loops


@dataclass(frozen=True, eq=False)
class ConnectionPoints:
    """The two ends of a loop or spring.

    Attributes:
        name: name of the loop or spring.
        kind: a spring with a parallel damper is listed as each of the two.
        body1, point1, body2, point2: links, or "ground", with points in their frames (m), shape (3,).
    """

    name: str
    kind: Literal["loop", "spring", "damper", "bushing"]
    body1: str
    point1: np.ndarray
    body2: str
    point2: np.ndarray


def connection_points(posture: Posture) -> tuple[ConnectionPoints, ...]:
    """The ends of all loops, then of all springs; a moving base is not drawn as a loop."""
    load, points = posture.balance.load, []
    for item in (*load.loops, *load.springs):
        connection = item.connection
        if connection == posture.robot.moving_base:
            continue
        ends = [
            _in_body(posture, body, anchor) for body, anchor in ((connection.body1, item.first), (connection.body2, item.second))
        ]
        points += [
            ConnectionPoints(connection.name, kind, connection.body1, ends[0], connection.body2, ends[1])
            for kind in _kinds(connection)
        ]
    return tuple(points)


def _in_body(posture: Posture, body: str, anchor: Anchor) -> np.ndarray:
    """The anchor's point in the frame of the link instead of that of its joint."""
    return _in_frame(posture.robot.link_frames.link(body), anchor.point)


def _kinds(connection: Connection) -> tuple[str, ...]:
    if isinstance(connection, Loop):
        return ("loop",)
    if isinstance(connection, BodySpring):
        return ("spring",) * bool(connection.stiffness or not connection.damping) + ("damper",) * bool(connection.damping)
    return ("bushing",)


@dataclass(frozen=True, eq=False)
class Wrench:
    """A force F = force @ x and a moment T = moment @ x about the point, for multipliers or a generalized force x.

    Attributes:
        name: name of the loop, coupling or coordinate.
        on: the link under the load.
        body, point: the link, or "ground", whose frame gives the directions, and the point of action in it (m).
        force, moment: shape (3, m), in N and N m for a unit of each entry of x.
    """

    name: str
    on: str
    body: str
    point: np.ndarray
    force: np.ndarray
    moment: np.ndarray


def row_wrenches(posture: Posture) -> tuple[Wrench, ...]:
    """The wrenches of all loops and mimic_rows, x the multipliers of all their rows, shape (m,).

    A loop's acts on its second body, or on the first where the second is the ground. A coupling's are two: on the link
    of the joint that follows, and on that of the joint which it follows, each along or about the axis of the joint.
    """
    load = posture.balance.load
    wrenches, start = [], 0
    for item, G in zip(load.loops, posture.balance.gradients):
        stop = start + len(G)
        wrenches.append(_of_loop(posture, item, G, np.eye(len(load.row_names))[start:stop]))
        start = stop
    for item, row in zip(load.mimic_rows, np.eye(len(load.row_names))[start:]):
        wrenches += _of_mimic_row(posture, item, row)
    return tuple(wrenches)


def _of_loop(posture: Posture, item: Attached, gradient: np.ndarray, rows: np.ndarray) -> Wrench:
    """Wrenches of a loop: J^T mu is the work of (R1 f; R1 t) on body 2 and its opposite on body 1, (f; t) = gradient^T mu."""
    loop, body = item.connection, item.connection.body1
    link = posture.robot.link_frames.link(body)
    on, sign = (loop.body2, 1.0) if loop.body2 != GROUND else (body, -1.0)
    parts = sign * gradient.T @ rows
    turn = link.rotation.T @ item.first.rotation
    return Wrench(loop.name, on, body, _in_frame(link, item.first.point), turn @ parts[:3], turn @ parts[3:])


def _of_mimic_row(posture: Posture, item: MimicRow, row: np.ndarray) -> Iterator[Wrench]:
    for joint, factor in ((item.follower, 1.0), (item.leader, -item.multiplier)):
        acting = coordinate_wrench(posture, posture.robot.model.joints[joint].idx_v)
        force, moment = (factor * part @ row[None] for part in (acting.force, acting.moment))
        yield Wrench(item.name, acting.on, acting.body, acting.point, force, moment)


def coordinate_wrench(posture: Posture, place: int) -> Wrench:
    """Wrench of a generalized force along a coordinate of the links, x its value, shape (1,): at the joint, on the link behind it."""
    robot, kinematics = posture.robot, posture.balance.kinematics
    joint = next(number for number, joint in enumerate(robot.model.joints) if number and 0 <= place - joint.idx_v < joint.nv)
    body = robot.link_frames.link_behind(joint)
    link = robot.link_frames.link(body)
    turn = (kinematics.rotations[link.joint] @ link.rotation).T
    velocity, rate = turn @ kinematics.columns[:3, [place]], turn @ kinematics.columns[3:, [place]]
    none, turns = np.zeros((3, 1)), bool(robot.units[place] == "rad")
    return Wrench(
        robot.coordinates[place],
        body,
        body,
        _in_frame(link, np.zeros(3)),
        none if turns else velocity,
        rate if turns else none,
    )


def _in_frame(link: Anchor, point: np.ndarray) -> np.ndarray:
    """A point of the joint's frame in that of the link."""
    return link.rotation.T @ (point - link.point)
