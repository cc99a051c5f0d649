"""phi, the pose of a frame on one body as seen from a frame on another, with its first and second derivatives."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from .kinematics import Anchor, Kinematics


class RelativePose:
    """phi = [R1^T (p2 - p1); log(R1^T R2)] in one configuration (m; rad).

    The first derivative is exact off the surface phi = 0 as well, and the second is a symmetric function of the
    configuration: a force K phi or a multiplier of a row of phi has a potential.

    Where only points count (turning False), the rotation vector is not computed: its rows are 0.
    """

    def __init__(self, kinematics: Kinematics, first: Anchor, second: Anchor, turning: bool = True):
        self._turning = turning
        self._kinematics = kinematics
        self._first, self._second = first, second
        (self._R1, p1), (self._R2, self._p2) = kinematics.frame(first), kinematics.frame(second)
        self.turn = rotation_vector(self._R1.T @ self._R2) if turning else np.zeros(3)
        self.value = np.concatenate([self._R1.T @ (self._p2 - p1), self.turn])

    @cached_property
    def jacobian(self) -> np.ndarray:
        """d phi / dq, shape (6, nv)."""
        relative = self._relative
        shift = self._R1.T @ (relative[:3] + np.cross(relative[3:], self._p2, axis=0))
        turn = inverse_right_jacobian(self.turn) @ self._R2.T @ relative[3:] if self._turning else np.zeros_like(shift)
        return np.vstack([shift, turn])

    def hessian(self, factors: np.ndarray) -> np.ndarray:
        """d (J^T f) / dq at constant f, shape (nv, nv): the second derivative of f . phi, for f of shape (6,)."""
        force, torque = self._R1 @ factors[:3], self._R2 @ inverse_right_jacobian(self.turn).T @ factors[3:]
        wrench = np.concatenate([force, np.cross(self._p2, force) + torque])
        kinematics, first, second = self._kinematics, self._first.joint, self._second.joint
        moved = kinematics.turning(second, wrench) - kinematics.turning(first, wrench)
        return moved + self._relative.T @ self._wrench_change(factors, force, torque)

    @cached_property
    def _relative(self) -> np.ndarray:
        """Velocity of the second body less that of the first, by rate of each coordinate, shape (6, nv)."""
        return self._kinematics.velocity(self._second.joint) - self._kinematics.velocity(self._first.joint)

    def _wrench_change(self, factors, force, torque) -> np.ndarray:
        """How the wrench of constant factors changes: the force turns with body 1, its point moves with body 2."""
        turning1, turning2 = (self._kinematics.velocity(anchor.joint)[3:] for anchor in (self._first, self._second))
        d_force = np.cross(turning1, force, axis=0)
        d_point = self._kinematics.of_point(self._second.joint, self._p2)
        d_torque = np.cross(turning2, torque, axis=0) + self._R2 @ self._turn_change(factors[3:])
        arm = np.cross(d_point, force, axis=0) + np.cross(self._p2, d_force, axis=0)
        return np.vstack([d_force, arm + d_torque])

    def _turn_change(self, factors: np.ndarray) -> np.ndarray:
        """d(Jlog(turn)^T f) / dq at constant f, shape (3, nv)."""
        if not factors.any():
            return np.zeros((3, self.jacobian.shape[1]))
        return inverse_right_jacobian_change(self.turn, factors) @ self.jacobian[3:]


def rotation_vector(rotation: np.ndarray) -> np.ndarray:
    """log R, the axis times the angle, for an angle from 0 to pi."""
    import pinocchio

    return pinocchio.log3(rotation)


def inverse_right_jacobian(turn: np.ndarray) -> np.ndarray:
    """d log(R exp(w)) / dw at w = 0 for R = exp(turn): I + [a]/2 + c(|a|) [a]^2."""
    X = cross_matrix(turn)
    return np.eye(3) + X / 2 + _curvature(turn)[0] * X @ X


def inverse_right_jacobian_change(turn: np.ndarray, factors: np.ndarray) -> np.ndarray:
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


def cross_matrix(vector: np.ndarray) -> np.ndarray:
    """[a] with [a] b = a x b."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
