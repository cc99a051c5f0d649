"""The tree of joints that pinocchio computes with. The only place where a model is made and asked for numbers."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np

from ...checks import nearest
from ...errors import InputError


class Tree:
    """A pinocchio model, and what it says of a configuration q, in arrays of our own.

    The workspace that pinocchio writes into is made once: it holds nv^3 numbers.

    Attributes:
        model: joints, masses and gravity.
        joint_of: the number of the joint of each tangent coordinate, shape (nv,).
        moving: whether a coordinate moves a joint's body, shape (joints, nv).
    """

    def __init__(self, model):
        self.model = model
        self._data = model.createData()

    @cached_property
    def joint_of(self) -> np.ndarray:
        """By coordinate; joint 0 is the ground."""
        return np.repeat(np.arange(1, self.model.njoints), [joint.nv for joint in list(self.model.joints)[1:]])

    @cached_property
    def moving(self) -> np.ndarray:
        """By joint and coordinate."""
        return np.array([np.isin(self.joint_of, list(support)) for support in self.model.supports])

    @cached_property
    def carried(self) -> np.ndarray:
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

    def moved(self, q: np.ndarray, step: np.ndarray) -> np.ndarray:
        """q (+) step, the step in tangent coordinates."""
        import pinocchio

        return pinocchio.integrate(self.model, q, step)

    def way(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
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
    """The pinocchio model of a ``skeleton``, locked joints taken out; its gravity set.

    Raises:
        InputError: pinocchio cannot read the text, an unknown locked joint, or one locked beyond its limits.
    """
    import pinocchio

    try:
        model = pinocchio.buildModelFromXML(text, *([pinocchio.JointModelFreeFlyer()] if free_base else []))
    except (ValueError, RuntimeError) as problem:
        raise InputError(f"urdf: it cannot be read as a robot ({str(problem).splitlines()[0]})") from None
    model = _without(model, locked)
    if not model.nv:
        raise InputError(
            "urdf: found no joint that moves; a robot needs at least one that is neither fixed nor locked, or a free base"
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
            raise InputError(f'locked: "{name}" moves in several ways; only joints with one degree of freedom can be locked')
        low, high = model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]
        if joint.nq == 1 and low < high and not low <= value <= high:
            raise InputError(f"locked: {name}: found {value:g}, beyond its limits {low:g} ... {high:g}")
        q[joint.idx_q : joint.idx_q + joint.nq] = value if joint.nq == 1 else (np.cos(value), np.sin(value))
    return pinocchio.buildReducedModel(model, numbers, q)
