"""Where multipliers and generalized forces act: as forces and moments at points of links, in the frames of these."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..element import GROUND
from .coupling import Coupling
from .kinematics import Anchor
from .mechanism import Attached

if TYPE_CHECKING:
    from .posture import Posture


@dataclass(frozen=True)
class Wrench:
    """A force F = force @ x and a moment T = moment @ x about the point, for multipliers or a generalized force x.

    Attributes:
        name: of the loop, coupling or coordinate.
        on: the link that they act on.
        body, point: the frame in which they are told, that of a link or "ground", and their point in it (m).
        force, moment: shape (3, m), in N and N m for a unit of each entry of x.
    """

    name: str
    on: str
    body: str
    point: np.ndarray
    force: np.ndarray
    moment: np.ndarray


def row_wrenches(posture: Posture) -> tuple[Wrench, ...]:
    """Of all loops and couplings, x the multipliers of all their rows, shape (m,).

    A loop's acts on its second body, or on the first where the second is the ground. A coupling's are two: on the link
    of the joint that follows, and on that of the joint which it follows, each along or about the axis of the joint.
    """
    load = posture.balance.load
    found, start = [], 0
    for item in load.loops:
        stop = start + len(item.connection.rows)
        found.append(_of_loop(posture, item, np.eye(len(load.row_names))[start:stop]))
        start = stop
    for item, row in zip(load.couplings, np.eye(len(load.row_names))[start:]):
        found += _of_coupling(posture, item, row)
    return tuple(found)


def _of_loop(posture: Posture, item: Attached, rows: np.ndarray) -> Wrench:
    """J^T mu is the work of (R1 f; R1 t) on the second body and of the opposite on the first, (f; t) = rows^T mu."""
    loop, body = item.connection, item.connection.body1
    link = posture.robot.link_frames.link(body)
    on, sign = (loop.body2, 1.0) if loop.body2 != GROUND else (body, -1.0)
    parts = sign * loop.rows.T @ rows
    turn = link.rotation.T @ item.first.rotation
    return Wrench(loop.name, on, body, _in_link(link, item.first.point), turn @ parts[:3], turn @ parts[3:])


def _of_coupling(posture: Posture, item: Coupling, row: np.ndarray) -> Iterator[Wrench]:
    for joint, factor in ((item.follower, 1.0), (item.leader, -item.multiplier)):
        acting = coordinate_wrench(posture, posture.robot.model.joints[joint].idx_v)
        force, moment = (factor * part @ row[None] for part in (acting.force, acting.moment))
        yield Wrench(item.name, acting.on, acting.body, acting.point, force, moment)


def coordinate_wrench(posture: Posture, place: int) -> Wrench:
    """Of a generalized force along a coordinate of the links, x its value, shape (1,): at the joint, on the link behind it."""
    robot, kinematics = posture.robot, posture.balance.kinematics
    joint = next(number for number, joint in enumerate(robot.model.joints) if number and 0 <= place - joint.idx_v < joint.nv)
    body = robot.link_frames.heaviest_links()[joint]
    link = robot.link_frames.link(body)
    turn = (kinematics.rotations[joint] @ link.rotation).T
    velocity, rate = turn @ kinematics.columns[:3, [place]], turn @ kinematics.columns[3:, [place]]
    none, turns = np.zeros((3, 1)), bool(robot.units[place] == "rad")
    return Wrench(
        robot.coordinates[place],
        body,
        body,
        _in_link(link, np.zeros(3)),
        none if turns else velocity,
        rate if turns else none,
    )


def _in_link(link: Anchor, point: np.ndarray) -> np.ndarray:
    """A point of the joint's frame in that of the link."""
    return link.rotation.T @ (point - link.point)
