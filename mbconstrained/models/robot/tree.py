"""From a URDF text to the tree that pinocchio computes with. The only place where a model is made."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...checks import nearest, real_number
from ...errors import InputError


def built_model(text: str, free_base: bool, locked: Mapping[str, float], gravity: np.ndarray):
    """The pinocchio model of a ``skeleton``, locked joints taken out; its gravity set.

    Raises:
        InputError: pinocchio cannot read the text, an unknown locked joint, masses without sense.
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

    if not isinstance(locked, Mapping):
        locked = dict.fromkeys(locked, 0.0)
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
        value = real_number(value, f"locked: {name}")
        q[joint.idx_q : joint.idx_q + joint.nq] = value if joint.nq == 1 else (np.cos(value), np.sin(value))
    return pinocchio.buildReducedModel(model, numbers, q)
