"""Velocities and relative poses of the bodies of a robot in one configuration, with their derivatives.

All vectors are in the directions of the ground. The column s_i of S is the velocity (v of the point at the origin; w) of the
bodies behind tangent coordinate i for a unit rate. A column moves with the joints before it,

    d s_i / d q_k = s_k x s_i        for k before i in the chain from the ground, or of the same joint,

which gives all second derivatives of poses.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from xml.sax.saxutils import unescape

import numpy as np

from ..ground.checks import nearest
from ..ground.errors import InputError

#: Degrees of freedom of a robot; the workspace of pinocchio for these takes 4 GB.
MOST_COORDINATES = 400


class Tree:
    """The tree of joints, a pinocchio model, with its quantities in a configuration q as NumPy arrays.

    One workspace of pinocchio, of nv^3 numbers, serves all calls.

    Attributes:
        model: joints, masses and gravity.
        joint_of: the number of the joint of each tangent coordinate, shape (nv,).
        moving: whether a coordinate moves the body of a joint, shape (joints, nv).
    """

    def __init__(self, model):
        self.model = model
        self._data = model.createData()

    @cached_property
    def joint_of(self) -> np.ndarray:
        """Joint of each coordinate; joint 0 is the ground."""
        return np.repeat(np.arange(1, self.model.njoints), [joint.nv for joint in list(self.model.joints)[1:]])

    @cached_property
    def moving(self) -> np.ndarray:
        """Which coordinates move each joint, shape (joints, coordinates)."""
        return np.array([np.isin(self.joint_of, list(support)) for support in self.model.supports])

    @cached_property
    def moves_axis(self) -> np.ndarray:
        """Whether the axis of coordinate i moves with coordinate k, at [i, k]."""
        return self.moving[self.joint_of]

    def placed(self, q: np.ndarray) -> tuple[np.ndarray, list[np.ndarray], list[np.ndarray]]:
        """Columns S (6, nv) of all joints in the directions of the ground, and the joints' rotations and origins."""
        import pinocchio

        columns = pinocchio.computeJointJacobians(self.model, self._data, q)
        placements = [(np.array(pose.rotation), np.array(pose.translation)) for pose in self._data.oMi]
        # of one joint pinocchio returns a vector
        return np.array(columns).reshape(6, self.model.nv), *(list(part) for part in zip(*placements))

    def gravity(self, q: np.ndarray) -> np.ndarray:
        """The generalized force of gravity g(q), shape (nv,), on the left of the equations."""
        import pinocchio

        return np.array(pinocchio.computeGeneralizedGravity(self.model, self._data, q))

    def gravity_stiffness(self, q: np.ndarray) -> np.ndarray:
        """dg/dq, shape (nv, nv)."""
        import pinocchio

        return np.array(pinocchio.computeGeneralizedGravityDerivatives(self.model, self._data, q))

    def mass(self, q: np.ndarray) -> np.ndarray:
        """M(q), shape (nv, nv), rotors not included."""
        import pinocchio

        return np.array(pinocchio.crba(self.model, self._data, q))

    def inverse_dynamics(self, q: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
        """M(q) a + c(q, v) + g(q), shape (nv,), including the rotors in the model."""
        import pinocchio

        return np.array(pinocchio.rnea(self.model, self._data, q, velocity, acceleration))

    def moved(self, q: np.ndarray, step: np.ndarray) -> np.ndarray:
        """The configuration q (+) step, with the step in tangent coordinates."""
        import pinocchio

        return pinocchio.integrate(self.model, q, step)

    def moved_derivative(self, q: np.ndarray, step: np.ndarray) -> np.ndarray:
        """T with v = T d' for q(t) = q (+) d(t), shape (nv, nv); I for joints with one degree of freedom."""
        import pinocchio

        return pinocchio.dIntegrate(self.model, q, step)[1]

    def difference(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """The step from one configuration to another, in tangent coordinates."""
        import pinocchio

        return np.array(pinocchio.difference(self.model, start, end))

    def frames(self, q: np.ndarray, numbers: list[int]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Positions (3,) and quaternions (4,) x y z w of the frames of these numbers."""
        import pinocchio

        pinocchio.framesForwardKinematics(self.model, self._data, q)
        poses = [self._data.oMf[number] for number in numbers]
        return [(np.array(pose.translation), pinocchio.Quaternion(pose.rotation).coeffs()) for pose in poses]


def built_model(text: str, free_base: bool, locked: Mapping[str, float], gravity: np.ndarray):
    """The pinocchio model of a ``skeleton``, locked joints taken out; its gravity set."""
    import pinocchio

    balls = {unescape(name, {"&quot;": '"'}) for name in re.findall(r'<joint name="([^"]*)" type="ball"', text)}
    try:
        model = pinocchio.buildModelFromXML(
            text.replace(' type="ball">', ' type="floating">'), *([pinocchio.JointModelFreeFlyer()] if free_base else [])
        )
    except (ValueError, RuntimeError) as problem:
        raise InputError(f"urdf: pinocchio cannot read it as a robot ({str(problem).splitlines()[0]})") from None
    return finished_model(_with_balls(model, balls) if balls else model, locked, gravity)


def _with_balls(model, balls: set[str]):
    """The model with these free joints as ball joints, which the format of URDF does not have."""
    import pinocchio

    result = pinocchio.Model()
    result.name = model.name
    for number in range(1, model.njoints):
        joint, name = model.joints[number], model.names[number]
        is_ball = name in balls
        kind = pinocchio.JointModelSpherical() if is_ball else joint
        own = result.joints[result.addJoint(model.parents[number], kind, model.jointPlacements[number], name)]
        result.inertias[number] = model.inertias[number]
        for key in ("lowerPositionLimit", "upperPositionLimit") if not is_ball else ():
            getattr(result, key)[own.idx_q : own.idx_q + own.nq] = getattr(model, key)[joint.idx_q : joint.idx_q + joint.nq]
        if not is_ball:
            result.damping[own.idx_v : own.idx_v + own.nv] = model.damping[joint.idx_v : joint.idx_v + joint.nv]
            result.friction[own.idx_v : own.idx_v + own.nv] = model.friction[joint.idx_v : joint.idx_v + joint.nv]
    for frame in list(model.frames)[1:]:
        result.addFrame(frame, False)
    return result


def finished_model(model, locked: Mapping[str, float], gravity: np.ndarray):
    """A model with its locked joints taken out and its gravity set."""
    model = _without(model, locked)
    if model.nv > MOST_COORDINATES:
        raise InputError(f"robot: found {model.nv:,} degrees of freedom; at most {MOST_COORDINATES:,} are read")
    if not model.nv:
        raise InputError(
            "robot: found no joint that moves; a robot needs at least one that is neither fixed nor locked, or a free base"
        )
    model.gravity.linear = gravity
    model.gravity.angular = np.zeros(3)
    return model


def _without(model, locked: Mapping[str, float]):
    """The model with the locked joints fixed at their values."""
    import pinocchio

    if not locked:
        return model
    q, numbers = pinocchio.neutral(model), []
    names = list(model.names)[1:]
    for name, value in locked.items():
        if name not in names:
            raise InputError(f'locked: there is no joint "{name}"{nearest(name, names)}')
        numbers.append(names.index(name) + 1)
        joint = model.joints[numbers[-1]]
        if joint.nv != 1:
            raise InputError(
                f'locked: "{name}" has several degrees of freedom; only joints with one degree of freedom can be locked'
            )
        low, high = model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]
        if joint.nq == 1 and low < high and not low <= value <= high:
            raise InputError(f"locked: {name}: found {value:g}, beyond its limits {low:g} ... {high:g}")
        q[joint.idx_q : joint.idx_q + joint.nq] = value if joint.nq == 1 else (np.cos(value), np.sin(value))
    return pinocchio.buildReducedModel(model, numbers, q)


class RelativePose:
    """The pose phi = [R1^T (p2 - p1); log(R1^T R2)] of a frame relative to another one in one configuration (m; rad).

    The first derivative is exact off the surface phi = 0 as well, and the second is a symmetric function of the
    configuration: a force K phi or a multiplier of a row of phi has a potential.

    With turning False the rows of the rotation vector are 0 and not computed.
    """

    def __init__(self, kinematics: Kinematics, first: Anchor, second: Anchor, turning: bool = True):
        import pinocchio

        self._turning = turning
        self._kinematics = kinematics
        self._first, self._second = first, second
        (self._R1, p1), (self._R2, self._p2) = kinematics.frame(first), kinematics.frame(second)
        self.turn = pinocchio.log3(self._R1.T @ self._R2) if turning else np.zeros(3)
        self.value = np.concatenate([self._R1.T @ (self._p2 - p1), self.turn])

    @cached_property
    def jacobian(self) -> np.ndarray:
        """d phi / dq, shape (6, nv)."""
        relative = self._relative
        shift = self._R1.T @ (relative[:3] + cross_columns(relative[3:], self._p2))
        turn = inverse_right_jacobian(self.turn) @ self._R2.T @ relative[3:] if self._turning else np.zeros_like(shift)
        return np.vstack([shift, turn])

    def hessian(self, factors: np.ndarray) -> np.ndarray:
        """d (J^T f) / dq at constant f, shape (nv, nv): the second derivative of f . phi, for f of shape (6,)."""
        force, torque = np.split(self.directions @ factors, 2)
        wrench = np.concatenate([force, np.cross(self._p2, force) + torque])
        kinematics, first, second = self._kinematics, self._first.joint, self._second.joint
        moved = kinematics.turning(second, wrench) - kinematics.turning(first, wrench)
        d_force, d_torque = np.split(self.wrench_change(factors), 2)
        d_point = kinematics.of_point(second, self._p2)
        arm = cross_columns(d_point, force) - cross_columns(d_force, self._p2)
        return moved + self._relative.T @ np.vstack([d_force, arm + d_torque])

    @cached_property
    def directions(self) -> np.ndarray:
        """Map, shape (6, 6), from f to the force and torque with the work f . d phi, in the directions of the ground."""
        result = np.zeros((6, 6))
        result[:3, :3], result[3:, 3:] = self._R1, self._R2 @ inverse_right_jacobian(self.turn).T
        return result

    def wrench_change(self, factors: np.ndarray) -> np.ndarray:
        """Derivative of the wrench of constant factors by the coordinates, shape (6, nv): the force turns with body 1."""
        force, torque = np.split(self.directions @ factors, 2)
        turning1, turning2 = (self._kinematics.velocity(anchor.joint)[3:] for anchor in (self._first, self._second))
        d_torque = cross_columns(turning2, torque)
        if factors[3:].any():
            d_torque += self._R2 @ (_inverse_right_jacobian_change(self.turn, factors[3:]) @ self.jacobian[3:])
        return np.vstack([cross_columns(turning1, force), d_torque])

    @cached_property
    def _relative(self) -> np.ndarray:
        """Velocity of the second body less that of the first, by rate of each coordinate, shape (6, nv)."""
        return self._kinematics.velocity(self._second.joint) - self._kinematics.velocity(self._first.joint)


def inverse_right_jacobian(turn: np.ndarray) -> np.ndarray:
    """d log(R exp(w)) / dw at w = 0 for R = exp(turn): I + [a]/2 + c(|a|) [a]^2."""
    X = cross_matrix(turn)
    return np.eye(3) + X / 2 + _curvature(turn)[0] * X @ X


def _inverse_right_jacobian_change(turn: np.ndarray, factors: np.ndarray) -> np.ndarray:
    """d(Jlog(a)^T f) / da at constant f, shape (3, 3), a the rotation vector: the transpose has [a] with the other sign."""
    X, (c, dc) = cross_matrix(turn), _curvature(turn)
    crossed = np.cross(turn, factors)
    direct = cross_matrix(factors) / 2  # -[da] f / 2 = [f] da / 2
    square = -cross_matrix(crossed) - X @ cross_matrix(factors)  # ([da][a] + [a][da]) f
    return direct + c * square + dc * np.outer(X @ crossed, turn)


#: Below this angle (rad) the series is used: twelve terms are exact there, while the closed form cancels.
_SMALL_ANGLE = 1.0

_BERNOULLI = (
    1 / 6, 1 / 30, 1 / 42, 1 / 30, 5 / 66, 691 / 2730, 7 / 6, 3617 / 510, 43867 / 798, 174611 / 330, 854513 / 138, 236364091 / 2730
)  # fmt: skip
_SERIES = [number / math.factorial(2 * n) for n, number in enumerate(_BERNOULLI, 1)]  # c(x) = sum |B_2n| / (2n)! x^(2n-2)


def _curvature(turn: np.ndarray) -> tuple[float, float]:
    """c(x) = (1 - x/2 cot(x/2)) / x^2 at the angle x, and c'(x) / x."""
    x2 = float(turn @ turn)
    if x2 < _SMALL_ANGLE**2:
        slope = [2 * n * factor for n, factor in enumerate(_SERIES)][1:]
        return float(np.polyval(_SERIES[::-1], x2)), float(np.polyval(slope[::-1], x2))
    x = math.sqrt(x2)
    half = x / 2
    cot = 1 / math.tan(half)
    c = (1 - half * cot) / x2
    return c, ((half / math.sin(half) ** 2 - cot) / 2 / x2 - 2 * c / x) / x


def directions_across(direction: Sequence[float] | np.ndarray) -> np.ndarray:
    """Two orthonormal directions across another, shape (2, 3), axes of the frame where that is one of them."""
    nonzero = np.abs(direction) > 0
    return np.eye(3)[~nonzero] if nonzero.sum() == 1 else np.linalg.svd(np.array([direction]))[2][1:]


def cross_matrix(vector: np.ndarray) -> np.ndarray:
    """The matrix [a] with [a] b = a x b."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def cross_columns(columns: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Cross products of columns a x vector, shape (3, n), several times faster than NumPy's ``cross`` for few columns."""
    (x, y, z), (u, v, w) = columns, vector
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


#: Terms of the series of cos x, sin(x) / x and (1 - cos x) / x^2 in x^2, exact up to an angle of pi.
_RODRIGUES_TERMS = 18

_RODRIGUES = tuple(
    np.polynomial.Polynomial([(-1) ** k / math.factorial(2 * k + m) for k in range(_RODRIGUES_TERMS)]) for m in range(3)
)


def turned_product(first: Sequence[float], second: Sequence[float], turn: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """a . exp([w]) b with its derivatives by w, by Rodrigues' formula.

    a . exp([w]) b = cos|w| a . b + sin|w| / |w| (b x a) . w + (1 - cos|w|) / |w|^2 (a . w) (b . w)
    """
    a, b, w, eye = np.array(first), np.array(second), np.asarray(turn), np.eye(3)
    normal, s = np.cross(b, a), float(w @ w)
    parts = (
        (a @ b, np.zeros(3), np.zeros((3, 3))),
        (normal @ w, normal, np.zeros((3, 3))),
        ((a @ w) * (b @ w), (b @ w) * a + (a @ w) * b, np.outer(a, b) + np.outer(b, a)),
    )
    value, gradient, second_derivative = 0.0, np.zeros(3), np.zeros((3, 3))
    for series, (h, dh, ddh) in zip(_RODRIGUES, parts):
        P, dP, ddP = (float(series.deriv(order)(s)) for order in range(3))
        value += P * h
        gradient += P * dh + 2 * dP * h * w
        mixed = 2 * dP * np.outer(w, dh)
        second_derivative += P * ddh + mixed + mixed.T + h * (2 * dP * eye + 4 * ddP * np.outer(w, w))
    return float(value), gradient, second_derivative


@dataclass(frozen=True, eq=False)
class Anchor:
    """A frame fixed in a joint of the model; joint 0 is the ground."""

    joint: int  # number of the joint that it moves with
    rotation: np.ndarray  # shape (3, 3), from the frame into that of the joint
    point: np.ndarray  # its origin in the frame of the joint (m)


class Kinematics:
    """Positions and velocities of the bodies of a tree in a configuration q."""

    def __init__(self, tree: Tree, configuration: np.ndarray):
        self.tree = tree
        self.configuration = configuration
        self.columns, self.rotations, self.origins = tree.placed(configuration)

    def frame(self, anchor: Anchor) -> tuple[np.ndarray, np.ndarray]:
        """Directions (3, 3) and origin (3,) of a frame as seen from the ground."""
        rotation = self.rotations[anchor.joint]
        return rotation @ anchor.rotation, self.origins[anchor.joint] + rotation @ anchor.point

    def velocity(self, joint: int) -> np.ndarray:
        """The columns of S that move a joint's body, zero for the others, shape (6, nv)."""
        return self.columns * self.tree.moving[joint]

    def of_point(self, joint: int, point: np.ndarray) -> np.ndarray:
        """Velocity of the body-fixed point at a position in space, by rate of each coordinate, shape (3, nv)."""
        columns = self.velocity(joint)
        return columns[:3] + cross_columns(columns[3:], point)

    def turning(self, joint: int, wrench: np.ndarray) -> np.ndarray:
        """d(S_j^T W) / dq for a constant wrench W (force; torque about the origin), shape (nv, nv): -s_i . (s_k x* W)."""
        columns = self.velocity(joint)
        force, torque = cross_columns(columns[3:], wrench[:3]), cross_columns(columns[:3], wrench[:3])
        torque += cross_columns(columns[3:], wrench[3:])
        return -(columns[:3].T @ force + columns[3:].T @ torque) * self.tree.moves_axis
