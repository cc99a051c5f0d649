"""Tendons: springs, dampers and inertias along a length that is a sum over joints and over straight lines between points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..ground.errors import InputError
from .kinematics import Anchor, Kinematics, RelativePose
from .mechanism import LinkFrames
from .tangent import Tangent, joint_displacement


@dataclass(frozen=True)
class Segment:
    """A straight line between points of two bodies (m), whose length counts ``factor`` times."""

    body1: str
    point1: tuple[float, ...]
    body2: str
    point2: tuple[float, ...]
    factor: float = 1.0


@dataclass(frozen=True)
class Tendon:
    """A spring with damper and inertia along L = sum(c q) + sum(factor |p2 - p1|), with the force a x + b x^2 + c x^3.

    Attributes:
        name: name of the tendon.
        joints: the coefficient c by joint.
        segments: its straight lines.
        stiffness: a, b, c.
        rest: the lengths between which there is no force, x being the distance from them; None for the length at the guess.
        damping, inertia: along the tendon.
    """

    name: str
    joints: Mapping[str, float] = field(default_factory=dict)
    segments: tuple[Segment, ...] = ()
    stiffness: tuple[float, ...] = ()
    rest: tuple[float, float] | None = (0.0, 0.0)
    damping: float = 0.0
    inertia: float = 0.0

    def attached(self, tangent: Tangent, frames: LinkFrames, locked: Mapping[str, float], guess: Kinematics) -> AttachedTendon:
        """The tendon of a robot; locked joints and lines within a body have a constant part of the length."""
        row, offset = np.zeros(guess.tree.model.nv), 0.0
        lines: list[tuple[Anchor, Anchor, float]] = []
        for name, coefficient in self.joints.items():
            if name in locked:
                offset += coefficient * locked[name]
            else:
                row[tangent.place(name, f'tendon "{self.name}"')] = coefficient
        for item in self.segments:
            ends = [
                frames.anchor(body, point, (0.0, 0.0, 0.0), f'tendon "{self.name}"')
                for body, point in ((item.body1, item.point1), (item.body2, item.point2))
            ]
            if ends[0].joint == ends[1].joint:
                offset += item.factor * float(np.linalg.norm(ends[0].point - ends[1].point))
            else:
                lines.append((ends[0], ends[1], item.factor))
        attached = AttachedTendon(self, row, offset, tuple(lines), self.rest or (0.0, 0.0))
        if self.rest is None:
            length = StretchedTendon(attached, guess).length
            return AttachedTendon(self, row, offset, tuple(lines), (length, length))
        return attached


@dataclass(frozen=True, eq=False)
class AttachedTendon:
    """A tendon by the coordinates, shape (nv,), with lines between anchors and the lengths at rest."""

    tendon: Tendon
    row: np.ndarray
    offset: float
    lines: tuple[tuple[Anchor, Anchor, float], ...]
    rest: tuple[float, float]


class StretchedTendon:
    """The contributions of a tendon to the equations in one configuration."""

    def __init__(self, attached: AttachedTendon, kinematics: Kinematics):
        self.attached, self._kinematics = attached, kinematics
        self._poses = [(RelativePose(kinematics, first, second, False), factor) for first, second, factor in attached.lines]
        if any(not np.any(pose.value[:3]) for pose, _ in self._poses):
            raise InputError(
                f'tendon "{attached.tendon.name}": two of its points are at the same place, so that it has no direction'
            )

    @cached_property
    def length(self) -> float:
        """L (m, rad)."""
        model, q = self._kinematics.tree.model, self._kinematics.configuration
        turned = (
            self.attached.row[joint.idx_v] * joint_displacement(joint, q, 0.0)
            for joint in list(model.joints)[1:]
            if joint.nv == 1 and self.attached.row[joint.idx_v]
        )
        return self.attached.offset + sum(turned) + sum(factor * np.linalg.norm(pose.value[:3]) for pose, factor in self._poses)

    @cached_property
    def _directions(self) -> list[np.ndarray]:
        return [np.append(pose.value[:3], np.zeros(3)) / np.linalg.norm(pose.value[:3]) for pose, _ in self._poses]

    @cached_property
    def gradient(self) -> np.ndarray:
        """dL/dq, shape (nv,)."""
        return self.attached.row + sum(
            (factor * u @ pose.jacobian for u, (pose, factor) in zip(self._directions, self._poses)),
            np.zeros(len(self.attached.row)),
        )

    @cached_property
    def _tension(self) -> tuple[float, float]:
        """The force along the tendon and its derivative by the length."""
        low, high = self.attached.rest
        stretch = max(self.length - high, 0.0) + min(self.length - low, 0.0)
        if low < self.length < high:
            return 0.0, 0.0
        force = np.polynomial.Polynomial([0.0, *self.attached.tendon.stiffness])
        return float(force(stretch)), float(force.deriv()(stretch))

    @property
    def force(self) -> np.ndarray:
        """The generalized force on the left of the equations, shape (nv,)."""
        return self._tension[0] * self.gradient

    @cached_property
    def stiffness(self) -> np.ndarray:
        """Derivative of the generalized force, shape (nv, nv)."""
        force, slope = self._tension
        K = slope * np.outer(self.gradient, self.gradient)
        for u, (pose, factor) in zip(self._directions, self._poses):
            across = (np.eye(3) - np.outer(u[:3], u[:3])) / np.linalg.norm(pose.value[:3])
            K = K + force * factor * (pose.hessian(u) + pose.jacobian[:3].T @ across @ pose.jacobian[:3])
        return K

    @property
    def damping(self) -> np.ndarray:
        """Damping matrix of the tendon, shape (nv, nv)."""
        return self.attached.tendon.damping * np.outer(self.gradient, self.gradient)

    @property
    def inertia(self) -> np.ndarray:
        """Inertia matrix of the tendon, shape (nv, nv)."""
        return self.attached.tendon.inertia * np.outer(self.gradient, self.gradient)
