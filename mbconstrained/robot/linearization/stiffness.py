"""The stiffness of a robot at a posture by its parts, and matrices of a posture without entries that are rounding errors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS, NOISE_SAFETY, SYMMETRIC_STIFFNESS, noise_of
from ..connections import AXES
from ..kinematics import cross_matrix
from ..statics.equilibrium import rows_of

if TYPE_CHECKING:
    from ..posture import Posture

#: Rounding of an entry that is computed through a chain of joints, a rotation at each, relative to the largest of its kind.
COMPUTED = 16 * EPS


def stiffness_parts(posture: Posture) -> list[tuple[str, np.ndarray]]:
    """The contributions to K: springs of joints, springs between bodies, gravity and forces."""
    robot, balance = posture.robot, posture.balance
    gravity, joints, *others = balance.stiffnesses
    first, last = len(balance.elastic), len(others) - len(balance.tendons)
    springs, applied, tendons = others[:first], others[first:last], others[last:]
    sizes = balance.entry_sizes
    rest = np.sum([cleaned(part, sizes) for part in (gravity, *applied)], axis=0)
    rest = rest - sum(cleaned(part, sizes) for part in balance.geometric(posture.multipliers)) + _of_loads(posture)
    parts = [(f"spring of {name}", np.diag(row)) for name, row, k in zip(robot.coordinates, joints, robot.joint_stiffness) if k]
    gains = zip(robot.coordinates, np.diag(robot.position_gains), robot.position_gains)
    parts += [(f"control of {name}", np.diag(row)) for name, row, k in gains if k]
    parts += [(item.connection.name, cleaned(part, sizes)) for item, part in zip(balance.load.springs, springs)]
    parts += [(item.tendon.name, cleaned(part, sizes)) for item, part in zip(balance.load.tendons, tendons)]
    return [*parts, ("gravity and forces", rest)]


def _of_loads(posture: Posture) -> np.ndarray:
    """Stiffness of the loads that keep joints with several degrees of freedom in place, with potential -F . p - T . theta.

    A force F keeps its direction while the body turns, and T belongs to the rotation vector theta from the posture (semitangential):
    along the axes of the body they change by F x theta and T x theta / 2.
    """
    robot, K = posture.robot, np.zeros((len(posture.robot.coordinates),) * 2)
    for joint in robot.joints:
        own = robot.tangent.coordinates_of(joint)
        if len(own) == 1:
            continue
        places = [robot.coordinates.index(name) for name in own]
        axes = [AXES.index(name.removeprefix(f"{joint} ")) for name in own]
        wrench, change = np.zeros(6), np.zeros((6, 6))
        wrench[axes] = [posture.torques.get(name, 0.0) for name in own]
        change[:3, 3:], change[3:, 3:] = cross_matrix(wrench[:3]), cross_matrix(wrench[3:]) / 2
        K[np.ix_(places, places)] = -change[np.ix_(axes, axes)]
    return K


def stiffness_rounding(posture: Posture) -> np.ndarray:
    """Rounding errors of K, from each contribution; for loops from the largest multiplier, since one equation gives all of them."""
    balance, load = posture.balance, posture.balance.load
    sizes = balance.entry_sizes
    largest = np.abs(posture.multipliers * load.row_lengths).max(initial=0.0) / load.row_lengths
    return sum(
        (rounding_errors(part, sizes) for part in (*balance.stiffnesses, *balance.geometric(largest))), np.zeros(sizes.shape)
    )


def symmetric_stiffness(posture: Posture, K: np.ndarray) -> tuple[np.ndarray, tuple[Notice, ...]]:
    """K made symmetric where the forces have a potential.

    At an equilibrium the derivative of a conservative force is symmetric; the skew part lies across the motion.
    """
    balance, lengths = posture.balance, posture.balance.load.lengths
    N = rows_of(balance.scaled_jacobian[list(posture.independent_rows)]).motions
    scaled = K * np.outer(lengths, lengths)
    along = N.T @ scaled @ N
    skew = np.abs(along - along.T).max(initial=0.0)
    if skew <= SYMMETRIC_STIFFNESS * np.abs(scaled).max(initial=0.0):
        return (K + K.T) / 2, ()
    text = f"the stiffness matrix is not symmetric (by {skew / np.abs(along).max():.1e} of its largest entry along the motion)"
    return K, (Notice(NoticeKind.UNSYMMETRIC, f"{text}: a torque that keeps its direction has no potential"),)


def instability(posture: Posture) -> tuple[Notice, ...]:
    """A notice where the energy decreases along a motion that the loops allow: without damping the equilibrium is unstable.

    Flexible joints count as their spring in series with the position gain of their motor.
    """
    robot, lengths = posture.robot, posture.balance.load.lengths
    K = np.sum([part for _, part in stiffness_parts(posture)], axis=0)
    for name, joint in robot.flexible_joints.items():
        place, both = robot.coordinates.index(name), joint.stiffness + joint.proportional_gain
        K[place, place] += joint.stiffness * joint.proportional_gain / both if both else 0.0
    N = rows_of(posture.balance.scaled_jacobian[list(posture.independent_rows)]).motions
    scale = np.outer(lengths, lengths)
    along, noise = (N.T @ (part + part.T) @ N / 2 for part in (K * scale, stiffness_rounding(posture) * scale))
    if not along.size:
        return ()
    stiffness, directions = np.linalg.eigh(along)
    if stiffness[0] >= -max(NOISE_SAFETY * np.abs(noise).sum(axis=1).max(), SYMMETRIC_STIFFNESS * np.abs(K * scale).max()):
        return ()
    most = robot.coordinates[int(np.abs(N @ directions[:, 0]).argmax())]
    text = f"the equilibrium is unstable: along a motion, most of all of {most}, the forces increase the deviation"
    return (Notice(NoticeKind.UNSTABLE, text),)


def lost_springs(parts: Sequence[tuple[str, np.ndarray]], noise: np.ndarray) -> tuple[Notice, ...]:
    """A notice on springs that are smaller than the rounding errors of others."""
    lost = [name for name, part in parts if part.any() and (np.abs(part) <= noise).all()]
    if not lost:
        return ()
    named = f"{', '.join(lost[:3])}{f' and {len(lost) - 3} more' if len(lost) > 3 else ''}"
    text = f"smaller than the rounding errors of the stiffest springs, so that they are lost: {named}; give less stiff springs, or loops instead"
    return (Notice(NoticeKind.ACCURACY, text, doubtful=True),)


def cleaned(part: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """The matrix without rounding errors of its largest entry: a zero stiffness must be zero, or a free motion oscillates."""
    scaled = np.abs(part / sizes)
    return np.where(scaled > noise_of(scaled.max(initial=0.0), len(part)), part, 0.0)


def rounding_errors(part: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """The rounding errors of the entries: that of the largest, since entries are sums."""
    largest = np.abs(part / sizes).max(initial=0.0)
    return np.where(cleaned(part, sizes) != 0, COMPUTED * largest * sizes, 0.0)


def cleaned_rows(J: np.ndarray, sizes: np.ndarray, units: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Rows of loops without rounding errors of the largest entry of the same unit, and their rounding errors."""
    clean, doubt = np.zeros_like(J), np.zeros_like(J)
    for unit in set(units):
        rows = np.array(units) == unit
        clean[rows], doubt[rows] = cleaned(J[rows], sizes), rounding_errors(J[rows], sizes)
    return clean, doubt
