"""Force, stiffness and damping of springs and bushings, as functions of the relative pose phi of their frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from .connections import BodySpring, Bushing
from .relative_pose import RelativePose


@dataclass(frozen=True)
class Elastic:
    """What an element with the energy U(phi) adds to the equations at one configuration.

    Attributes:
        force: dU/dq = J^T dU/dphi, shape (nv,).
        stiffness: d force / dq = J^T U'' J + the second derivative of phi in the direction dU/dphi, shape (nv, nv).
        damping: J^T D J, shape (nv, nv).
    """

    force: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray


def elastic(element: BodySpring | Bushing, pose: RelativePose, rest_length: float) -> Elastic:
    """The contributions of an element whose frames have this relative pose.

    Raises:
        InputError: a spring of no length, which has no direction.
    """
    is_spring = isinstance(element, BodySpring)
    slope, curvature, damping = _spring(element, pose.value, rest_length) if is_spring else _bushing(element, pose.value)
    J = pose.jacobian
    return Elastic(J.T @ slope, J.T @ curvature @ J + pose.hessian(slope), J.T @ damping @ J)


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
