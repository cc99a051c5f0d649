"""Models of pinocchio as descriptions, for robots that were read from other formats than URDF."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ...ground.errors import InputError
from ...ground.notices import Notice

#: Kinds of joints with several degrees of freedom that have tangent coordinates here.
SEVERAL = ("JointModelPlanar", "JointModelFreeFlyer", "JointModelSpherical", "JointModelTranslation")


#: The acceleration of free fall where a file gives none (m/s^2).
DOWNWARDS = (0.0, 0.0, -9.81)


@dataclass(frozen=True, eq=False)
class ModelFile:
    """A pinocchio model with the further data of its file.

    Attributes:
        model: of pinocchio.
        gravity: shape (3,) (m/s^2).
        path: the file; None for a model alone.
        loops, gears: ``Loop`` and ``JointGear``.
        joint_stiffness, joint_rest: by joint.
        states: configurations q by name.
        notices: notices on what was left out.
        springs, tendons, motors: ``Bushing``, ``Tendon``, and ``Motor`` by joint.
        lift: by body a point (m) at which a force compensates the weight of a mass (kg).
        compiled: the ``MjModel`` of an MJCF file, to compare with; None where it has elastic parts that are not read.
        drawn: the model with shapes.
        links: links of its bodies, by number.
        undrawn: geoms whose mesh is missing.
        description, folder: the element <robot> of a URDF or an SDF, and the folder of the file.
    """

    model: Any
    gravity: Sequence[float]
    path: Path | None = None
    loops: tuple[Any, ...] = ()
    gears: tuple[Any, ...] = ()
    joint_stiffness: Mapping[str, float] = field(default_factory=dict)
    joint_rest: Mapping[str, float] = field(default_factory=dict)
    states: Mapping[str, np.ndarray] = field(default_factory=dict)
    notices: tuple[Notice, ...] = ()
    springs: tuple[Any, ...] = ()
    tendons: tuple[Any, ...] = ()
    motors: Mapping[str, Any] = field(default_factory=dict)
    lift: Mapping[str, tuple[Sequence[float], float]] = field(default_factory=dict)
    compiled: Any = None
    drawn: Any = None
    links: tuple[str, ...] = ()
    undrawn: frozenset[int] = frozenset()
    description: Element | None = None
    folder: Path | None = None

    def named_states(self, tangent) -> dict[str, dict]:
        """The states as guesses: values (rad, m) by joint, of the joints of a ``Tangent``; none where joints of the file are locked."""
        return {name: tangent.values(q) for name, q in self.states.items() if len(q) == tangent.model.nq}


def is_model(given) -> bool:
    """Whether an object is a pinocchio model; pinocchio is imported only where it may be one."""
    if isinstance(given, str) or not type(given).__module__.startswith("pinocchio"):
        return False
    import pinocchio

    return isinstance(given, pinocchio.Model)


def has_free_base(model) -> bool:
    """Whether the first joint of a model is a free one of its base."""
    return model.njoints > 1 and model.joints[1].shortname() == "JointModelFreeFlyer"


def described(model) -> Element:
    """The names, masses and joints of a pinocchio model as the element <robot> of a URDF, without shapes."""
    import pinocchio

    robot, first = Element("robot", name=str(model.name) or "robot"), {}
    for frame in model.frames:
        if frame.type == pinocchio.FrameType.BODY:
            link = SubElement(robot, "link", name=str(frame.name))
            first.setdefault(int(frame.parentJoint), link)
    if not first:
        raise InputError('model: found no body; name the bodies, model.addBodyFrame("link", joint, pinocchio.SE3.Identity(), 0)')
    for number in range(1, model.njoints):
        joint, name = model.joints[number], str(model.names[number])
        kind = joint.shortname()
        if (joint.nv != 1 and kind not in SEVERAL) or "Mimic" in kind:
            raise InputError(
                f'model: the joint "{name}" is a {kind.removeprefix("JointModel")}, which has no coordinates here; write it as joints with one '
                "degree of freedom each"
            )
        if number in first:
            _add_inertial(first[number], model.inertias[number])
            word = "floating" if joint.nv > 1 else "prismatic" if kind.startswith("JointModelP") else "revolute"
            if number > 1 or not has_free_base(model):
                element = SubElement(robot, "joint", name=name, type=word)
                parent = first.get(int(model.parents[number]), first[min(first)])
                SubElement(element, "parent", link=parent.get("name", ""))
                SubElement(element, "child", link=first[number].get("name", ""))
    return robot


def _add_inertial(link: Element, inertia) -> None:
    inertial, tensor = SubElement(link, "inertial"), np.array(inertia.inertia)
    SubElement(inertial, "mass", value=repr(float(inertia.mass)))
    moments = zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), tensor[np.triu_indices(3)].tolist())
    SubElement(inertial, "inertia", {key: repr(value) for key, value in moments})
