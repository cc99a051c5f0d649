"""The joints, bodies, connections and motors of a robot, as they were given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, Literal
from xml.etree.ElementTree import Element

import numpy as np

from ..ground.checks import nearest, real_array, real_number
from ..ground.display import Displayed
from ..ground.errors import InputError
from ..ground.units import GROUND
from .connections import ZEROS, BodySpring, Bushing, LinkFrames, Loop, PointMotion, checked_connections
from .description.sdf import read_description
from .description.urdf import (
    Payload,
    SemanticDescription,
    description_notices,
    has_free_base,
    link_masses,
    mimics_of,
    read_srdf,
    replace_masses,
    root_link,
    skeleton,
)
from .flexible_joint import FlexibleJoint, Motor
from .kinematics import Tree, built_model, finished_model
from .tangent import BASE, JointGear, Tangent, geared, locked_values, mimic_rows


class RobotModel(Displayed):
    """Data of a ``Robot``, without the answers to questions about it."""

    _instead: ClassVar = {
        "fk": "link_frames",
        **dict.fromkeys(("frequencies_hz", "modes", "solve"), "linearize it first: robot.linearize(robot.equilibrium()).modes()"),
    }

    def __init__(
        self,
        urdf: str | Path | Any,
        loops: Sequence[Loop] = (),
        springs: Sequence[BodySpring | Bushing] = (),
        base: Literal["fixed", "free", "moving"] = "fixed",
        joint_stiffness: Mapping[str, float] | None = None,
        joint_rest: Mapping[str, float] | None = None,
        joint_damping: Mapping[str, float] | None = None,
        gravity=None,
        locked: Mapping[str, float] | None = None,
        flexible_joints: Mapping[str, FlexibleJoint] | None = None,
        motors: Mapping[str, Motor] | None = None,
        gears: Sequence[JointGear] = (),
        payloads: Sequence[Payload] = (),
        masses: Mapping[str, float] | None = None,
        inertias: Mapping[str, Sequence[float]] | None = None,
        srdf: str | Path | None = None,
        package_dirs: Sequence[str | Path] = (),
        name: str | None = None,
    ):
        if isinstance(package_dirs, str) or not all(isinstance(folder, (str, Path)) for folder in package_dirs):
            raise InputError(f"package_dirs: found {package_dirs!r}; expected a list of folders")
        self.package_dirs = tuple(Path(folder) for folder in package_dirs)
        self.source = source = read_description(urdf, base, self.package_dirs)
        given_model, self.folder, self.description = source.model, source.folder, source.description
        if given_model is not None and (masses or inertias):
            raise InputError("masses, inertias: found them with a pinocchio model; change model.inertias, or add an mb.Payload")
        self.name = str(name or self.description.get("name") or "robot")
        if base not in (bases := ("fixed", "free", "moving")):
            raise InputError(f'base: found {base!r}{nearest(str(base), bases)}; expected "fixed", "free" or "moving"')
        if given_model is not None and base != "moving":
            base = "free" if has_free_base(given_model) else "fixed"
        self.base = base
        replace_masses(self.description, masses or {}, inertias or {})
        types = {joint.get("name", ""): joint.get("type") for joint in self.description.findall("joint")}
        single = {name: kind in ("revolute", "continuous", "prismatic") for name, kind in types.items()}
        mimics = geared([*source.gears, *gears] if isinstance(gears, Sequence) else gears, mimics_of(self.description), single)
        self.locked = locked_values(locked, mimics)
        if given_model is None:
            model = self.model_of(self.description, _gravity(gravity, source.gravity))
        else:
            if base == "moving" and not has_free_base(given_model):
                raise InputError('base: found "moving" with a pinocchio model; give it a JointModelFreeFlyer as its first joint')
            model = finished_model(given_model.copy(), self.locked, _gravity(gravity, source.gravity))
        self.tree = Tree(model)
        self.description_notices = (*source.notices, *description_notices(self.description))
        self.tangent = Tangent(self.model, base != "fixed", tuple(self.locked))
        self.link_frames = LinkFrames(self.model, link_masses(self.description))
        self._add_payloads(payloads)
        self.mimic_rows = mimic_rows(mimics, self.tangent)
        given = checked_connections(loops, (Loop,), "loops", self.link_frames)
        self.moving_base = None
        if base == "moving":
            self.moving_base = Loop(GROUND, ZEROS, root_link(self.description), ZEROS, kind="rigid", name=f"motion of {BASE}")
        given = (*source.loops, *given, *filter(None, [self.moving_base]))
        self.loops = checked_connections(given, (Loop,), "loops", self.link_frames)
        own_springs = checked_connections(springs, (BodySpring, Bushing), "springs", self.link_frames)
        own_springs = (*source.springs, *own_springs)
        self.springs = checked_connections(own_springs, (BodySpring, Bushing), "springs", self.link_frames, self.loops)
        self.lift, self._is_compared = self._lift(), False
        moving = {name for name in source.joint_stiffness if name in self.coordinates and name not in (joint_stiffness or {})}
        own, rest = ({name: values[name] for name in moving} for values in (source.joint_stiffness, source.joint_rest))
        self._set_joints({**own, **(joint_stiffness or {})}, {**rest, **(joint_rest or {})}, joint_damping)
        self.flexible_joints = self._by_joint(flexible_joints, FlexibleJoint, "flexible_joints")
        self.semantics = SemanticDescription() if srdf is None else read_srdf(srdf)
        single_motors = set(self.coordinates) - set(self.flexible_joints)
        own_motors = {name: motor for name, motor in source.motors.items() if name in single_motors}
        self._set_motors({**self._rotors(), **own_motors, **self._by_joint(motors, Motor, "motors")})

    def model_of(self, description: Element, gravity: np.ndarray | None = None):
        """The pinocchio model of another description, with the base, the locked joints and the gravity of this robot."""
        gravity = self.model.gravity.linear if gravity is None else gravity
        return built_model(skeleton(description), self.base != "fixed", self.locked, gravity)

    def _lift(self) -> dict[PointMotion, float]:
        """Forces that compensate the weight of bodies, from the file of the robot (N)."""
        gravity = np.array(self.model.gravity.linear)
        if not (size := float(np.linalg.norm(gravity))):
            return {}
        return {
            PointMotion(body, point, along=(-gravity).tolist()): mass * size for body, (point, mass) in self.source.lift.items()
        }

    def _add_payloads(self, payloads: Sequence[Payload]) -> None:
        import pinocchio

        if isinstance(payloads, Payload) or not all(isinstance(payload, Payload) for payload in payloads):
            raise InputError("payloads: expected a list of mb.Payload(body, mass, ...)")
        self.payloads = tuple(payloads)
        for payload in payloads:
            anchor = self.link_frames.anchor(payload.body, "payloads", payload.centre)
            tensor = anchor.rotation @ payload.tensor @ anchor.rotation.T
            self.model.inertias[anchor.joint] += pinocchio.Inertia(payload.mass, anchor.point, (tensor + tensor.T) / 2)

    def _by_joint(self, values, kind: type, what: str) -> dict:
        """Validated motors or flexible joints by joint."""
        if not isinstance(values or {}, Mapping):
            raise InputError(f"{what}: found {type(values).__name__}; expected mb.{kind.__name__}(...) by joint")
        for name, value in (values or {}).items():
            self.tangent.place(name, what)
            if not isinstance(value, kind):
                raise InputError(f"{what}: {name}: found {type(value).__name__}; make it with mb.{kind.__name__}(...)")
        return dict(values or {})

    def _rotors(self) -> dict[str, Motor]:
        """Motors from the SRDF file, for moving joints that are not flexible."""
        single = set(self.coordinates) & set(self.joints) - set(self.flexible_joints)
        rotors = ((name, rotor) for name, rotor in self.semantics.rotors.items() if name in single)
        return {name: Motor(rotor_inertia=inertia, gear_ratio=abs(ratio)) for name, (inertia, ratio) in rotors}

    def _set_motors(self, motors: dict[str, Motor]) -> None:
        """Set inertias in the model, and gains as vectors by coordinate, shape (nv,)."""
        self.motors, self.position_gains = motors, np.zeros(self.model.nv)
        for name, motor in motors.items():
            if name in self.flexible_joints:
                raise InputError(f'motors: "{name}" is a flexible joint, which has a motor; give its inertia and gains there')
            place = self.tangent.place(name, "motors")
            self.model.armature[place] += motor.reflected_inertia
            self.position_gains[place] = motor.position_gain
            self.joint_damping[place] += motor.velocity_gain

    def _set_joints(self, stiffness, rest, damping) -> None:
        self.joint_stiffness = self.tangent.vector(stiffness, "joint_stiffness", minimum=0.0)
        self.joint_rest = self.tangent.vector(rest, "joint_rest")
        self.rests_at_guess = self.joint_stiffness > 0
        for name in rest or ():
            place = self.tangent.place(name, "joint_rest")
            if not self.joint_stiffness[place]:
                raise InputError(f"joint_rest: {name} has no joint_stiffness; give it one, or leave the rest out")
            if name not in self.joints:
                raise InputError(f"joint_rest: {name}: a joint with several degrees of freedom rests at the posture; leave it out")
            self.rests_at_guess[place] = False
        self.joint_damping = np.array(self.model.damping) + self.tangent.vector(damping, "joint_damping", minimum=0.0)

    @property
    def model(self):
        """The pinocchio model."""
        return self.tree.model

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints that move, "base" for a free base."""
        return self.tangent.joints

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the links."""
        return self.link_frames.names

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the tangent coordinates."""
        return self.tangent.coordinates

    @property
    def units(self) -> tuple[str, ...]:
        """ "m" or "rad" for each of them."""
        return self.tangent.units

    @property
    def limits(self) -> dict[str, tuple[float, float]]:
        """Lower and upper limit (rad, m) by joint, of those that have any."""
        return self.tangent.limits

    @property
    def states(self) -> dict[str, dict[str, float | tuple[float, ...]]]:
        """The guesses of the SRDF or MJCF file by name: values (rad, m) of the joints that move."""
        base = BASE if self.base != "fixed" else None
        own = self.source.named_states(self.tangent)
        return own | {name: self.semantics.state(name, self.joints, base) for name in self.semantics.states}

    def _guess(self, guess):
        """The values of a guess, which may be the name of a state."""
        if isinstance(guess, str):
            return self.states[guess] if guess in self.states else self.semantics.state(guess, self.joints, None)
        return {} if guess is None else guess

    def _summary(self) -> str:
        closed_by = f", {len(self.loops)} loop{'s' if len(self.loops) != 1 else ''}" if self.loops else ""
        return f"{self.name}: {len(self.bodies)} links, {len(self.coordinates)} coordinates{closed_by}"


def _gravity(gravity, usual) -> np.ndarray:
    """The vector of the gravitational acceleration, the standard one by default."""
    if gravity is None:
        return np.array(usual)
    if np.ndim(gravity) == 0:
        return np.array([0.0, 0.0, -real_number(gravity, "gravity")])
    return real_array(gravity, "gravity", shape=(3,))
