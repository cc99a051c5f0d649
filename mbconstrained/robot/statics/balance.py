"""The balance of forces of a robot at rest, in one configuration.

    g(q) + tau_springs(q) - tau_applied(q) = J^T lambda,   phi(q) = 0

with gravity g, the loops' rows phi and their multipliers lambda. The derivative of the left side, and that of the
right side at constant lambda (the geometric stiffness of the loop forces), are exact; nothing is differenced.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...ground.errors import InputError
from ..connections import BodySpring, Bushing, PointMotion
from ..kinematics import Anchor, Kinematics, RelativePose, Tree
from ..mechanism import Attached
from ..tangent import MimicRow, joint_displacement
from ..tendons import AttachedTendon, StretchedTendon


@dataclass(frozen=True, eq=False)
class Load:
    """The loads and connections of a robot besides gravity.

    Attributes:
        loops, springs: attached connections.
        mimic_rows: of joints that follow others; these rows come after those of the loops.
        joint_stiffness, joint_rest: by tangent coordinate, shape (nv,); only of joints with one degree of freedom.
        joint_force: constant forces and torques of the joints, shape (nv,).
        point_forces: motions of points, with the force or torque along each.
        units: "m" or "rad" for each coordinate.
        size: a characteristic length of the robot (m).
        tendons: attached tendons.
    """

    loops: tuple[Attached, ...]
    springs: tuple[Attached, ...]
    mimic_rows: tuple[MimicRow, ...]
    joint_stiffness: np.ndarray
    joint_rest: np.ndarray
    joint_force: np.ndarray
    point_forces: Mapping[PointMotion, tuple[Anchor, float]]
    units: tuple[str, ...]
    size: float
    tendons: tuple[AttachedTendon, ...] = ()

    @cached_property
    def lengths(self) -> np.ndarray:
        """Units that make coordinates comparable: the robot's size (m) for displacements, 1 for angles; shape (nv,)."""
        return np.where(np.array(self.units) == "m", self.size, 1.0)

    @cached_property
    def row_lengths(self) -> np.ndarray:
        """Units of the rows of loops, shape (m,)."""
        return np.where(np.array(self.row_units) == "m", self.size, 1.0)

    @cached_property
    def row_names(self) -> tuple[str, ...]:
        """Names of the rows of all loops and mimic_rows."""
        return (*(name for item in self.loops for name in item.connection.row_names), *(item.name for item in self.mimic_rows))

    @cached_property
    def row_units(self) -> tuple[str, ...]:
        """ "m" or "rad" for each of them."""
        return (*(unit for item in self.loops for unit in item.connection.row_units), *(item.unit for item in self.mimic_rows))

    @property
    def has_rows(self) -> bool:
        """Whether there are rows of loops or mimic joints."""
        return bool(self.loops or self.mimic_rows)


class Balance:
    """Forces and their derivatives by the nv tangent coordinates, in one configuration q."""

    def __init__(self, tree: Tree, load: Load, configuration: np.ndarray):
        self.tree, self.load = tree, load
        self.configuration = configuration
        self.kinematics = Kinematics(tree, configuration)

    @cached_property
    def gravity(self) -> np.ndarray:
        """g, shape (nv,)."""
        return self.tree.gravity(self.configuration)

    @cached_property
    def forces(self) -> tuple[np.ndarray, ...]:
        """The terms of the left side, each of shape (nv,)."""
        springs = [*(element.force for element in self.elastic), *(tendon.force for tendon in self.tendons)]
        applied = [-value * row for row, value in self._rows]
        return (self.gravity, self.load.joint_stiffness * self.joint_stretch, *springs, -self.load.joint_force, *applied)

    @property
    def force(self) -> np.ndarray:
        """The left side, shape (nv,)."""
        return np.sum(self.forces, axis=0)

    @cached_property
    def stiffnesses(self) -> tuple[np.ndarray, ...]:
        """The derivatives of the forces, each of shape (nv, nv)."""
        springs = [element.stiffness for element in self.elastic]
        applied = [-value * self._row_change(motion, anchor) for motion, (anchor, value) in self.load.point_forces.items()]
        gravity = self.tree.gravity_stiffness(self.configuration)
        tendons = [tendon.stiffness for tendon in self.tendons]
        return (gravity, np.diag(self.load.joint_stiffness), *springs, *applied, *tendons)

    @cached_property
    def elastic(self) -> list[Elastic]:
        """Contributions of the springs and bushings."""
        return [elastic(item.connection, item.pose(self.kinematics), item.rest_length) for item in self.load.springs]

    @cached_property
    def tendons(self) -> list[StretchedTendon]:
        """Contributions of the tendons."""
        return [StretchedTendon(item, self.kinematics) for item in self.load.tendons]

    @cached_property
    def _poses(self):
        return [(item, item.pose(self.kinematics)) for item in self.load.loops]

    @cached_property
    def gaps(self) -> np.ndarray:
        """phi, the rows of all loops and mimic_rows (m, rad), shape (m,)."""
        mimicked = [item.gap(self.tree.model, self.configuration) for item in self.load.mimic_rows]
        return np.concatenate([*(item.connection.gaps(pose.value, item.rest_length) for item, pose in self._poses), mimicked])

    @cached_property
    def gradients(self) -> list[np.ndarray]:
        """The derivatives of the rows of each loop by its phi, each of shape (k, 6)."""
        return [item.connection.gradient(pose.value) for item, pose in self._poses]

    @cached_property
    def jacobian(self) -> np.ndarray:
        """J = d phi / dq, shape (m, nv)."""
        mimicked = [item.row(self.tree.model) for item in self.load.mimic_rows]
        return np.vstack(
            [
                np.zeros((0, self.tree.model.nv)),
                *(G @ pose.jacobian for G, (_, pose) in zip(self.gradients, self._poses)),
                *mimicked,
            ]
        )

    @cached_property
    def scaled_gaps(self) -> np.ndarray:
        """phi in rad or relative to the robot's size, so that rows are comparable, shape (m,)."""
        return self.gaps / self.load.row_lengths

    @cached_property
    def scaled_jacobian(self) -> np.ndarray:
        """J in comparable coordinates and rows, shape (m, nv)."""
        return self.jacobian * self.load.lengths / self.load.row_lengths[:, None]

    @property
    def widest_gap(self) -> tuple[str, float, str]:
        """Name of the row with the largest gap, the gap (m, rad), and the unit."""
        worst = int(np.abs(self.scaled_gaps).argmax())
        return self.load.row_names[worst], abs(self.gaps[worst]), self.load.row_units[worst]

    def geometric(self, multipliers: np.ndarray) -> tuple[np.ndarray, ...]:
        """d(J^T lambda)/dq at constant lambda, a matrix (nv, nv) for each loop."""
        parts, start = [], 0
        for G, (item, pose) in zip(self.gradients, self._poses):
            own = multipliers[start : start + len(G)]
            curvature = item.connection.curvature(pose.value, own)
            parts.append(pose.hessian(G.T @ own) + (pose.jacobian.T @ curvature @ pose.jacobian if curvature.any() else 0.0))
            start += len(G)
        return tuple(parts)

    def stiffness(self, multipliers: np.ndarray) -> np.ndarray:
        """The derivative of the left side less that of the right, shape (nv, nv)."""
        return np.sum(self.stiffnesses, axis=0) - np.sum(self.geometric(multipliers), axis=0)

    @cached_property
    def mass(self) -> np.ndarray:
        """M, shape (nv, nv), rotors not included."""
        return sum((tendon.inertia for tendon in self.tendons), self.tree.mass(self.configuration))

    @cached_property
    def sizes(self) -> np.ndarray:
        """sqrt(M_ii): in coordinates times these, metres and radians of any body count alike; shape (nv,)."""
        diagonal = np.sqrt(np.maximum(np.diag(self.mass), 0.0))  # negative moments of inertia are possible
        least = diagonal[diagonal > 0].min(initial=np.inf)
        return np.where(diagonal > 0, diagonal, least if np.isfinite(least) else 1.0)

    @cached_property
    def entry_sizes(self) -> np.ndarray:
        """sqrt(M_ii M_jj): the scale of the entries of M, D and K, shape (nv, nv)."""
        return np.outer(self.sizes, self.sizes)

    def row(self, motion: PointMotion, anchor: Anchor) -> np.ndarray:
        """The rate of a point's motion by that of each coordinate, shape (nv,).

        Args:
            motion: of a point.
            anchor: the point in its joint.

        Returns:
            Shape (nv,).
        """
        if motion.turn:
            return np.array(motion.along) @ self.kinematics.velocity(anchor.joint)[3:]
        return np.array(motion.along) @ self.kinematics.of_point(anchor.joint, self.kinematics.frame(anchor)[1])

    @cached_property
    def _rows(self):
        return [(self.row(motion, anchor), value) for motion, (anchor, value) in self.load.point_forces.items()]

    def _row_change(self, motion: PointMotion, anchor: Anchor) -> np.ndarray:
        """d(row^T) / dq, shape (nv, nv), of a force or torque that keeps its direction."""
        along, point = np.array(motion.along), self.kinematics.frame(anchor)[1]
        if motion.turn:
            return self.kinematics.turning(anchor.joint, np.concatenate([np.zeros(3), along]))
        arm = np.cross(self.kinematics.of_point(anchor.joint, point), along, axis=0)
        kept = self.kinematics.turning(anchor.joint, np.concatenate([along, np.cross(point, along)]))
        return kept + self.kinematics.velocity(anchor.joint)[3:].T @ arm

    @cached_property
    def joint_stretch(self) -> np.ndarray:
        """The displacement of each joint from its rest, for a continuous one modulo a full turn, shape (nv,)."""
        stretch = np.zeros(self.tree.model.nv)
        for joint in list(self.tree.model.joints)[1:]:
            if joint.nv == 1:
                stretch[joint.idx_v] = joint_displacement(joint, self.configuration, self.load.joint_rest[joint.idx_v])
        return stretch


@dataclass(frozen=True, eq=False)
class Elastic:
    """The contributions of an element with the energy U(phi) to the equations in one configuration.

    Attributes:
        pose: phi with its derivatives by the coordinates.
        slope: dU/dphi, shape (6,).
        curvature: U'', shape (6, 6).
        damper: D, shape (6, 6).
    """

    pose: RelativePose
    slope: np.ndarray
    curvature: np.ndarray
    damper: np.ndarray

    @property
    def wrench(self) -> np.ndarray:
        """-dU/dphi, the force and torque on body2 in the frame on body1, shape (6,)."""
        return -self.slope

    @cached_property
    def force(self) -> np.ndarray:
        """dU/dq = J^T dU/dphi, shape (nv,)."""
        return self.pose.jacobian.T @ self.slope

    @cached_property
    def stiffness(self) -> np.ndarray:
        """d force / dq = J^T U'' J + the second derivative of phi in the direction dU/dphi, shape (nv, nv)."""
        return self.pose.jacobian.T @ self.curvature @ self.pose.jacobian + self.pose.hessian(self.slope)

    @cached_property
    def damping(self) -> np.ndarray:
        """J^T D J, shape (nv, nv)."""
        return self.pose.jacobian.T @ self.damper @ self.pose.jacobian


def elastic(element: BodySpring | Bushing, pose: RelativePose, rest_length: float) -> Elastic:
    """The contributions of an element whose frames have this relative pose."""
    is_spring = isinstance(element, BodySpring)
    return Elastic(pose, *(_spring(element, pose.value, rest_length) if is_spring else _bushing(element, pose.value)))


def _spring(spring: BodySpring, phi: np.ndarray, rest_length: float):
    """U = k (|p| - l0)^2 / 2: tension along p, and across it the tension over the length."""
    length, slope, curvature, damping = np.linalg.norm(phi[:3]), np.zeros(6), np.zeros((6, 6)), np.zeros((6, 6))
    if not length and (rest_length or spring.damping):
        raise InputError(f"{spring.label}: both its ends are at the same place, so that it has no direction; move one of them")
    tension = spring.stiffness * (length - rest_length)
    across = spring.stiffness if not rest_length else tension / length
    along = np.outer(phi[:3], phi[:3]) / length**2 if length else np.eye(3)
    slope[:3] = across * phi[:3]
    curvature[:3, :3] = spring.stiffness * along + across * (np.eye(3) - along)
    damping[:3, :3] = spring.damping * along
    return slope, curvature, damping


def _bushing(bushing: Bushing, phi: np.ndarray):
    """U = phi^T K phi / 2."""
    K = np.array([*bushing.stiffness, *bushing.turning_stiffness])
    return K * phi, np.diag(K), np.diag([*bushing.damping, *bushing.turning_damping])
