"""What acts on a robot, from the places of its links: the referee of the geometric stiffness and of the motion.

The tree of joints is pinocchio's (frame placements, frame Jacobians, mass matrix, gravity, bias forces). All that joins
bodies besides the joints is written down here from its definition, as forces on points, and differentiated only
numerically; nothing of mbconstrained/models/robot is used.

    loops: exact gradients of p2 - p1 = 0 (ground's directions, or directions of the first body where it slides), of lengths, and of
        scalar products of axes that are to stay at right angles; no logarithm, no convention of a body frame.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import pinocchio as pin

STEP = 1e-3  # fourth-order central differences: truncation and rounding near 1e-12 of the largest entry


def skew(v) -> np.ndarray:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def rpy(angles) -> np.ndarray:
    """R = Rz(yaw) Ry(pitch) Rx(roll), as in a URDF."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles), np.sin(angles)
    x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    return np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]) @ y @ x


@dataclass
class End:
    """A frame on a body: place, directions, and the Jacobians of both, ground's directions."""

    place: np.ndarray
    turn: np.ndarray
    moves: np.ndarray
    turns: np.ndarray


@dataclass
class Reference:
    """A robot as the tests see it. Loops and springs are ``mb.Loop``, ``mb.BodySpring``, ``mb.Bushing``: read, not run.

    Attributes:
        forces: pairs of a ``mb.PointMotion`` and a number.
        start: the guess as a configuration of pinocchio, for ends that are given by where they lie there.
    """

    text: str
    base: str = "fixed"
    gravity: tuple = (0.0, 0.0, -9.81)
    joint_stiffness: dict = field(default_factory=dict)
    joint_rest: dict = field(default_factory=dict)
    joint_damping: dict = field(default_factory=dict)
    loops: tuple = ()
    springs: tuple = ()
    forces: tuple = ()

    def __post_init__(self):
        root = (pin.JointModelFreeFlyer(),) if self.base == "free" else ()
        self.model = pin.buildModelFromXML(self.text, *root)
        self.model.gravity.linear = np.array(self.gravity, float)
        self.data, self._forces = self.model.createData(), self.model.createData()
        self.start = pin.neutral(self.model)

    @property
    def coordinates(self) -> list[str]:
        """Names in pinocchio's order, written as the interface of Robot promises them."""
        names: list[str] = []
        for name, kind in zip(self.model.names[1:], self.model.joints.tolist()[1:]):
            axes = ("x", "y", "z", "rx", "ry", "rz")
            names += [f"base {axis}" for axis in axes] if kind.nv == 6 else [str(name)]
        return names

    def configuration(self, joints: dict, base=None) -> np.ndarray:
        """q from values by name; base: 7 numbers."""
        q = pin.neutral(self.model)
        for name, kind in zip(self.model.names[1:], self.model.joints.tolist()[1:]):
            value = joints.get(name, 0.0)
            part = np.asarray(base, float) if kind.nv == 6 else [value] if kind.nq == 1 else [np.cos(value), np.sin(value)]
            q[kind.idx_q : kind.idx_q + kind.nq] = part
        return q

    def angles(self, q) -> dict:
        """Values by name of the joints with one degree of freedom."""
        solution = {}
        for name, kind in zip(self.model.names[1:], self.model.joints.tolist()[1:]):
            if kind.nv == 1:
                part = q[kind.idx_q : kind.idx_q + kind.nq]
                solution[str(name)] = float(part[0]) if kind.nq == 1 else float(np.arctan2(part[1], part[0]))
        return solution

    def place(self, q) -> None:
        pin.computeJointJacobians(self.model, self.data, q)
        pin.updateFramePlacements(self.model, self.data)

    def end(self, body: str, point, rotation) -> End:
        """After ``place``."""
        if body == "ground":
            none = np.zeros((3, self.model.nv))
            return End(np.array(point, float), rpy(rotation), none, none)
        index = self.model.getFrameId(body, pin.FrameType.BODY)
        frame = self.data.oMf[index]
        J = pin.getFrameJacobian(self.model, self.data, index, pin.LOCAL_WORLD_ALIGNED)
        arm = frame.rotation @ np.array(point, float)
        return End(frame.translation + arm, frame.rotation @ rpy(rotation), J[:3] - skew(arm) @ J[3:], J[3:])

    @cached_property
    def at_start(self) -> "Reference":
        """The same robot, placed at the start."""
        other = replace(self)
        other.place(self.start)
        return other

    def ends(self, connection) -> tuple[End, End]:
        """Both ends now; a point that is not given lies where the other is at the start, with the directions of the first frame."""
        (body1, point1), (body2, point2) = (connection.body1, connection.point1), (connection.body2, connection.point2)
        if point1 is not None and point2 is not None:
            return self.end(body1, point1, connection.rotation1), self.end(body2, point2, connection.rotation2)
        first, second = (self.at_start.end(body, (0, 0, 0), (0, 0, 0)) for body in (body1, body2))
        if point1 is None:
            point1 = first.turn.T @ (second.place + second.turn @ point2 - first.place)
        else:
            point2 = second.turn.T @ (first.place + first.turn @ point1 - second.place)
        here, there = self.end(body1, point1, connection.rotation1), self.end(body2, point2, (0, 0, 0))
        there.turn = there.turn @ second.turn.T @ first.turn @ rpy(connection.rotation1)
        return here, there

    def applied(self, q) -> np.ndarray:
        """Weight, joint springs, springs and bushings: the generalized force that they exert at rest."""
        self.place(q)
        force = -pin.computeGeneralizedGravity(self.model, self._forces, q)
        angles = self.angles(q)
        for name, k in self.joint_stiffness.items():
            force[self.coordinates.index(name)] -= k * (angles[name] - self.joint_rest.get(name, 0.0))
        for spring in self.springs:
            force += self.of_bushing(spring) if hasattr(spring, "turning_stiffness") else self.of_spring(spring)
        for motion, value in self.forces:
            end = self.end(motion.body, motion.point, (0, 0, 0))
            force += value * (end.turns if motion.turn else end.moves).T @ np.array(motion.along)
        return force

    def of_spring(self, spring) -> np.ndarray:
        first, second = self.ends(spring)
        gap = second.place - first.place
        length = np.linalg.norm(gap)
        pull = spring.stiffness * (length - self.rest_length(spring)) * gap / length
        return (first.moves - second.moves).T @ pull

    def rest_length(self, spring) -> float:
        if spring.rest_length is not None:
            return spring.rest_length
        first, second = self.at_start.ends(spring)
        return float(np.linalg.norm(second.place - first.place)) - (spring.preload / spring.stiffness if spring.preload else 0.0)

    def of_bushing(self, bushing) -> np.ndarray:
        first, second = self.ends(bushing)
        gap = second.place - first.place
        reached, turned = first.turn.T @ gap, pin.log3(first.turn.T @ second.turn)
        moves = first.turn.T @ (second.moves - first.moves + skew(gap) @ first.turns)
        turns = pin.Jlog3(first.turn.T @ second.turn) @ second.turn.T @ (second.turns - first.turns)
        return -moves.T @ (np.array(bushing.stiffness) * reached) - turns.T @ (np.array(bushing.turning_stiffness) * turned)

    def damping(self, q) -> np.ndarray:
        """D of the resistance D v."""
        self.place(q)
        D = np.diag(np.array(self.model.damping, float))
        for name, c in self.joint_damping.items():
            D[self.coordinates.index(name)] += c * np.eye(self.model.nv)[self.coordinates.index(name)]
        for spring in self.springs:
            first, second = self.ends(spring)
            gap = second.place - first.place
            if hasattr(spring, "turning_stiffness"):
                moves = first.turn.T @ (second.moves - first.moves + skew(gap) @ first.turns)
                turns = pin.Jlog3(first.turn.T @ second.turn) @ second.turn.T @ (second.turns - first.turns)
                D += moves.T @ np.diag(spring.damping) @ moves + turns.T @ np.diag(spring.turning_damping) @ turns
            else:
                row = gap / np.linalg.norm(gap) @ (second.moves - first.moves)
                D += spring.damping * np.outer(row, row)
        return D

    def rows(self, q) -> np.ndarray:
        """Exact gradients of all loops, world's directions; (m, nv)."""
        self.place(q)
        return np.vstack([np.zeros((0, self.model.nv)), *(self._gradient(loop) for loop in self.loops)])

    def _gradient(self, loop) -> np.ndarray:
        first, second = self.ends(loop)
        gap, moves = second.place - first.place, second.moves - first.moves
        slides = loop.kind in ("prismatic", "cylindrical")  # along directions that turn with the first body
        shifts = [a @ moves + slides * np.cross(a, gap) @ first.turns for a in self._directions(loop, first, gap)]
        turns = [np.cross(e, a) @ (second.turns - first.turns) for a, e in self._right_angles(loop, first, second)]
        return np.vstack([*shifts, *turns])

    def gaps(self, q) -> np.ndarray:
        """What the loops hold at zero."""
        self.place(q)
        solution = []
        for loop in self.loops:
            first, second = self.ends(loop)
            gap = second.place - first.place
            rest = self._distance(loop) if loop.kind == "rod" else 0.0
            solution += [a @ gap - rest for a in self._directions(loop, first, gap)]
            solution += [a @ e for a, e in self._right_angles(loop, first, second)]
        return np.array(solution)

    def _distance(self, loop) -> float:
        """The length of a rod, that at the start."""
        first, second = self.at_start.ends(loop)
        return float(np.linalg.norm(second.place - first.place))

    @staticmethod
    def _directions(loop, first, gap) -> list[np.ndarray]:
        """Directions in which the loop keeps its points together: fixed in space, or, of one that slides, in the first body."""
        if loop.kind == "rod":
            return [gap / np.linalg.norm(gap)]
        if loop.kind in ("prismatic", "cylindrical"):
            return [first.turn @ u for u in np.linalg.svd(np.array(loop.axis)[None])[2][1:]]
        return [*np.eye(3)]

    @staticmethod
    def _right_angles(loop, first, second):
        """Pairs of an axis of the first frame and one of the second that the loop keeps at right angles."""
        if loop.kind in ("point", "rod"):
            return []
        if loop.kind in ("rigid", "prismatic"):
            return [(first.turn[:, i], second.turn[:, (i + 1) % 3]) for i in range(3)]
        if loop.kind == "universal":
            return [(first.turn @ loop.axis, second.turn @ loop.axis2)]
        axis = np.array(loop.axis, float) / np.linalg.norm(loop.axis)
        across = np.linalg.svd(axis[None])[2][1:]
        return [(first.turn @ axis, second.turn @ u) for u in across]

    def multipliers(self, q, reactions: dict) -> np.ndarray:
        """Of ``rows``, from force and torque on body 2 in the directions of the ground, by loop name."""
        self.place(q)
        solution: list = []
        for loop in self.loops:
            first, second = self.ends(loop)
            directions = np.array(self._directions(loop, first, second.place - first.place))
            arms = np.array([np.cross(e, a) for a, e in self._right_angles(loop, first, second)]).reshape(-1, 3)
            for basis, part in zip((directions, arms), np.split(reactions[loop.name], 2)):
                solution += [*np.linalg.lstsq(basis.T, part, rcond=None)[0]] if len(basis) else []
        return np.array(solution)

    def stiffness(self, q, multipliers) -> np.ndarray:
        """-d (applied + J^T lambda) / dq by central differences of fourth order over pin.integrate."""

        def total(d):
            there = pin.integrate(self.model, q, d)
            return self.applied(there) + (self.rows(there).T @ multipliers if len(self.loops) else 0)

        columns = []
        for unit in np.eye(self.model.nv) * STEP:
            columns.append((8 * (total(unit) - total(-unit)) - (total(2 * unit) - total(-2 * unit))) / (12 * STEP))
        return -np.array(columns).T

    def mass(self, q) -> np.ndarray:
        return pin.crba(self.model, self._forces, q).copy()

    def acceleration(self, q, v, constant) -> np.ndarray:
        """v' with all loops closed; ``constant``: generalized force of the motors that hold the posture."""
        return self.motion(q, v, constant)[0]

    def motion(self, q, v, constant) -> tuple[np.ndarray, np.ndarray]:
        """v' and the multipliers of ``rows``, those of least norm."""
        bias = pin.nonLinearEffects(self.model, self._forces, q, v) - pin.computeGeneralizedGravity(self.model, self._forces, q)
        load = self.applied(q) + constant - bias - self.damping(q) @ v
        M = self.mass(q)
        free = np.linalg.solve(M, load)
        if not self.loops:
            return free, np.zeros(0)
        J = self.rows(q)
        h = 1e-4 / max(np.linalg.norm(v), 1e-9)
        drift = (self.rows(pin.integrate(self.model, q, h * v)) - self.rows(pin.integrate(self.model, q, -h * v))) @ v / (2 * h)
        X = np.linalg.solve(M, J.T)
        multipliers = -np.linalg.lstsq(J @ X, J @ free + drift, rcond=1e-10)[0]
        return free + X @ multipliers, multipliers

    def closed(self, q) -> np.ndarray:
        """The nearest configuration on the loops (Gauss-Newton)."""
        for _ in range(20):
            gap = self.gaps(q)
            if not len(gap) or np.abs(gap).max() < 1e-15:
                break
            q = pin.integrate(self.model, q, -np.linalg.lstsq(self.rows(q), gap, rcond=1e-9)[0])
        return q
