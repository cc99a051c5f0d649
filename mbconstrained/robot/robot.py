"""A robot: a URDF with loops, springs and flexible joints, which a URDF cannot express."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..ground.checks import nearest, real_array, real_number
from ..ground.coordinate_units import GROUND
from ..ground.display import Displayed
from ..ground.errors import InputError
from ..mechanics.constraints import Level
from .connections import BodySpring, Bushing, Loop, PointMotion
from .description.masses import Payload, description_notices, replace_masses
from .description.mjcf import is_mjcf, read_mjcf
from .description.models import ModelFile, described, has_free_base, is_model
from .description.sdf import read_description
from .description.srdf import SemanticDescription, read_srdf
from .description.urdf import link_masses, mimics_of, root_link, skeleton
from .flexible_joint import FlexibleJoint, Motor
from .kinematics import Tree, built_model, finished_model
from .linearization.linearized import LinearizedRobot
from .mechanism import LinkFrames, checked_connections
from .posture import Posture, find_posture
from .tangent import BASE, JointGear, Tangent, geared, locked_values, mimic_rows

if TYPE_CHECKING:
    from ..ground.notices import Notice
    from .cartesian_path import PathModes
    from .description.mesh_files import MeshFiles
    from .description.visuals import Visual
    from .visualization import ConnectionPoints, Poses


_ORIGIN = (0.0, 0.0, 0.0)


class Robot(Displayed):
    """A tree of joints from a URDF, with loops, springs and flexible joints.

    Args:
        urdf: the path of a .urdf file, or the XML text itself; the path of an SDF file (.sdf, .world); that of an MJCF file, compiled by MuJoCo (extra ``mjcf``), whose
            ``connect`` and ``weld`` are loops, whose key frames are states, and whose free joint makes the base free; or a pinocchio model, which has its own base
            and is not drawn. Collision geometry is never read.
        loops: joints that close loops, ``Loop``.
        springs: connections between bodies, ``BodySpring`` and ``Bushing``.
        base: "fixed" to the ground; "free"; or "moving", with a prescribed motion: it rests at the origin unless
            ``LinearizedRobot.prescribe`` moves it, and the rows "motion of base x" ... "rz" are inputs of frequency responses.
        joint_stiffness: spring constants by joint or coordinate (N m/rad, N/m).
        joint_rest: values of these joints without spring force (rad, m), of a continuous joint modulo a full turn. A spring without
            one carries the load of its joint: the joint keeps the guess, and ``Posture.torques`` has the load.
        joint_damping: damping constants by joint or coordinate (N m s/rad, N s/m), in addition to those of the URDF.
        gravity: the acceleration of free fall (m/s^2), a vector or the number g for (0, 0, -g); by default that of a pinocchio model,
            and (0, 0, -9.81) of a URDF.
        locked: joints that do not move, with their values (rad, m).
        flexible_joints: a ``FlexibleJoint`` by joint.
        motors: a ``Motor`` by joint, with a rigid gear.
        gears: gears and racks between joints, ``JointGear``.
        payloads: bodies fixed to links, ``Payload``.
        masses: other masses of links than those of the URDF (kg), by link; the inertia changes in the same ratio.
        inertias: other inertias of links, by link, as of ``Payload`` (kg m^2).
        srdf: the path of an SRDF file: its group states are guesses by name, ``equilibrium("standing")``, and its rotors are motors of
            the joints that have no other.
        package_dirs: folders that contain the folder NAME of package://NAME/... in names of mesh files.
        name: the URDF's when not given.

    Raises:
        InputError: an invalid URDF or argument; the text names the place.

    >>> from mbconstrained import Robot
    >>> import numpy as np
    >>> urdf = '''<robot name="pendulum"><link name="base"/><link name="rod"><inertial><mass value="2"/>
    ...   <origin xyz="0 0 -0.5"/><inertia ixx="0.1" iyy="0.1" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
    ...   <joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint></robot>'''
    >>> robot = Robot(urdf)
    >>> system = robot.linearize(robot.equilibrium({"hinge": 0.1}))
    >>> bool(np.isclose(system.modes().natural_frequencies[0] ** 2, 2 * 9.81 * 0.5 / (0.1 + 2 * 0.5**2)))
    True
    """

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
        source = urdf if isinstance(urdf, ModelFile) else None
        if is_mjcf(urdf):
            source = read_mjcf(urdf, base != "fixed", self.package_dirs)
        if is_model(urdf):
            model: Any = urdf
            source = ModelFile(model, model.gravity.linear.tolist())
        self.source = source = source or read_description(urdf, base, self.package_dirs)
        given_model: Any = source.model
        self.folder = source.folder
        self.description = source.description if source.description is not None else described(given_model)
        if given_model is not None and (masses or inertias):
            raise InputError("masses, inertias: found them with a pinocchio model; change model.inertias, or add an mb.Payload")
        self.name = str(name or self.description.get("name") or "robot")
        if base not in (bases := ("fixed", "free", "moving")):
            raise InputError(f'base: found {base!r}{nearest(str(base), bases)}; expected "fixed", "free" or "moving"')
        if given_model is not None and base != "moving":
            base = "free" if has_free_base(given_model) else "fixed"
        self.base = base
        replace_masses(self.description, masses or {}, inertias or {})
        single = {
            j.get("name", ""): j.get("type") in ("revolute", "continuous", "prismatic") for j in self.description.findall("joint")
        }
        mimics = geared([*source.gears, *gears] if isinstance(gears, Sequence) else gears, mimics_of(self.description), single)
        self.locked = locked_values(locked, mimics)
        if given_model is None:
            model = built_model(skeleton(self.description), base != "fixed", self.locked, _gravity(gravity, source.gravity))
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
        self.moving_base = self._moving_base() if base == "moving" else None
        given = (*source.loops, *given, *filter(None, [self.moving_base]))
        self.loops = checked_connections(given, (Loop,), "loops", self.link_frames)
        own_springs = checked_connections(springs, (BodySpring, Bushing), "springs", self.link_frames)
        self.springs = checked_connections(
            (*source.springs, *own_springs), (BodySpring, Bushing), "springs", self.link_frames, self.loops
        )
        self.lift, self._is_compared = self._lift(), False
        moving = {name for name in source.joint_stiffness if name in self.coordinates and name not in (joint_stiffness or {})}
        own, rest = ({name: values[name] for name in moving} for values in (source.joint_stiffness, source.joint_rest))
        self._set_joints({**own, **(joint_stiffness or {})}, {**rest, **(joint_rest or {})}, joint_damping)
        self.flexible_joints = self._by_joint(flexible_joints, FlexibleJoint, "flexible_joints")
        self.semantics = SemanticDescription() if srdf is None else read_srdf(srdf)
        own_motors = {
            name: motor for name, motor in source.motors.items() if name in self.coordinates and name not in self.flexible_joints
        }
        self._set_motors({**self._rotors(), **own_motors, **self._by_joint(motors, Motor, "motors")})

    def _moving_base(self) -> Loop:
        return Loop(GROUND, _ORIGIN, root_link(self.description), _ORIGIN, kind="rigid", name=f"motion of {BASE}")

    def _lift(self) -> dict[PointMotion, float]:
        """The forces that compensate the weight of bodies, by the file that the robot is read from (N)."""
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
            anchor = self.link_frames.anchor(payload.body, payload.centre, _ORIGIN, "payloads")
            tensor = anchor.rotation @ payload.tensor @ anchor.rotation.T
            self.model.inertias[anchor.joint] += pinocchio.Inertia(payload.mass, anchor.point, (tensor + tensor.T) / 2)

    def _by_joint(self, values, kind: type, what: str) -> dict:
        """Motors or flexible joints by joint, checked."""
        if not isinstance(values or {}, Mapping):
            raise InputError(f"{what}: found {type(values).__name__}; expected mb.{kind.__name__}(...) by joint")
        for name, value in (values or {}).items():
            self.tangent.place(name, what)
            if not isinstance(value, kind):
                raise InputError(f"{what}: {name}: found {type(value).__name__}; make it with mb.{kind.__name__}(...)")
        return dict(values or {})

    def _rotors(self) -> dict[str, Motor]:
        """Those of the SRDF file, of joints that move and are not flexible."""
        single = set(self.coordinates) & set(self.joints) - set(self.flexible_joints)
        rotors = ((name, rotor) for name, rotor in self.semantics.rotors.items() if name in single)
        return {name: Motor(rotor_inertia=inertia, gear_ratio=abs(ratio)) for name, (inertia, ratio) in rotors}

    def _set_motors(self, motors: dict[str, Motor]) -> None:
        """Inertias go to the model, gains into vectors by coordinate, shape (nv,)."""
        self.motors, self.position_gains = motors, np.zeros(self.model.nv)
        armature = np.array(self.model.armature)
        for name, motor in motors.items():
            if name in self.flexible_joints:
                raise InputError(f'motors: "{name}" is a flexible joint, which has a motor; give its inertia and gains there')
            place = self.tangent.place(name, "motors")
            armature[place] += motor.reflected_inertia
            self.position_gains[place] = motor.position_gain
            self.joint_damping[place] += motor.velocity_gain
        self.model.armature = armature

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

    def equilibrium(
        self,
        guess: Mapping | np.ndarray | str | None = None,
        forces: Mapping[str | PointMotion, float] | None = None,
        hold: Sequence[str] | Literal["all"] = (),
    ) -> Posture:
        """The posture near a guess at which the robot stays at rest, its loops closed.

            g(q) + tau_springs(q) - tau = J^T lambda,   phi(q) = 0        (Newton's method)

        Args:
            guess: values by joint or coordinate (rad, m), 0 for those not named: for a free base ("base") x, y, z, roll, pitch, yaw
                or x, y, z and a quaternion x, y, z, w, and "base z" alone for one of them; or all of q; or the
                name of a state of the SRDF file.
            forces: constant ones by joint (N m, N) or by ``PointMotion`` (N, N m).
            hold: joints or coordinates that keep the guess, or "all" joints; ``Posture.torques`` has their loads. Flexible joints
                and those with a spring without a rest keep it always.

        Returns:
            The posture with its multipliers and residual.

        Raises:
            InputError: there is none near the guess, the loops do not close, or the posture is singular.
        """
        return find_posture(self, self._guess(guess), forces or {}, hold)

    def _guess(self, guess):
        """The values of a guess, which may be the name of a state."""
        if isinstance(guess, str):
            return self.states[guess] if guess in self.states else self.semantics.state(guess, self.joints, None)
        return {} if guess is None else guess

    def inverse_kinematics(
        self, body: str, place, point=_ORIGIN, orientation=None, guess: Mapping | np.ndarray | str | None = None
    ) -> dict[str, float | tuple[float, ...]]:
        """The values of the joints, near a guess, with which a point of a body is at a place and the loops are closed.

        The place is a loop between body and ground, which Gauss-Newton steps of least size close; where these get stuck, they start
        again from places near the guess, then from the middle of the limits of the joints. Values within the limits are
        preferred; where the search finds none, the notices of ``equilibrium`` name the joints that are beyond.

        Args:
            body: a link.
            place: in the directions of the ground (m), shape (3,).
            point: of the body, in its frame (m), shape (3,).
            orientation: of the body, roll, pitch, yaw (rad), shape (3,); any where it is None.
            guess: as of ``equilibrium``.

        Returns:
            Values by joint (rad, m), a guess of ``equilibrium``.

        Raises:
            InputError: the place is out of reach, with the distance that remains.

        >>> from mbconstrained import Robot
        >>> arm = Robot("robots/double_pendulum/double_pendulum.urdf")
        >>> joints = arm.inverse_kinematics("lower", (0.3, -0.02, -0.5), point=(0, 0, -0.3), guess={"shoulder": -0.5, "elbow": 0.3})
        >>> posture = arm.equilibrium(joints, hold="all")
        """
        from .cartesian_path import inverse_kinematics, target

        q = inverse_kinematics(self, target(body, point, place, orientation), self._guess(guess))
        return self.tangent.values(q)

    def modes_along(
        self,
        body: str,
        places,
        point=_ORIGIN,
        orientation=None,
        guess: Mapping | np.ndarray | str | None = None,
        hold: Sequence[str] | Literal["all"] = "all",
        forces: Mapping[str | PointMotion, float] | None = None,
    ) -> PathModes:
        """The modes without damping where a point of a body is at each place of a path, each mode followed by its shape.

        Args:
            body, point, orientation: as of ``inverse_kinematics``.
            places: along the path (m), shape (P, 3).
            guess: near the first place, from which each posture is sought from the one before.
            hold, forces: as of ``equilibrium``; joints that do not keep the guess give way to their load.

        Returns:
            ``PathModes``: ``frequencies_hz``, shape (P, m), ``postures``, ``systems``, and ``unreachable`` places.

        Raises:
            InputError: the first place is out of reach.

        >>> from mbconstrained import Robot
        >>> springs = {"shoulder": 900.0, "elbow": 300.0}
        >>> arm = Robot("robots/double_pendulum/double_pendulum.urdf", joint_stiffness=springs)
        >>> path = [(x, -0.02, -0.5) for x in (0.1, 0.2, 0.3, 0.9)]
        >>> along = arm.modes_along("lower", path, point=(0, 0, -0.3), guess={"shoulder": -0.5, "elbow": 0.3})
        >>> along.frequencies_hz.shape, along.unreachable
        ((4, 2), (3,))
        """
        from .cartesian_path import modes_along, target

        return modes_along(self, target(body, point, _ORIGIN, orientation), places, self._guess(guess), hold, forces or {})

    def linearize(
        self,
        posture: Posture,
        level: Level = "position",
        inputs: Mapping[str, str | PointMotion] | None = None,
        outputs: Mapping[str, str | PointMotion] | None = None,
    ) -> LinearizedRobot:
        """Small motions about a posture, M d'' + D d' + K d = f + J^T lambda with J d = 0.

        K is the derivative of all forces at rest, the geometric stiffness of the loop forces included,

            K = dg/dq + d tau_springs/dq - d(J^T lambda)/dq at constant lambda.

        Args:
            posture: from ``equilibrium`` of this robot.
            level: of the constraint rows of the loops, "position", "velocity" or "acceleration".
            inputs, outputs: by name of your own: a joint (its torque; its angle), or a ``PointMotion``.

        Returns:
            The linear system in the coordinates of the joints.

        Raises:
            InputError: a posture of another robot, unknown names.
        """
        if not isinstance(posture, Posture) or posture.robot is not self:
            raise InputError("linearize: expected a posture from equilibrium() of this robot")
        linearized = LinearizedRobot(posture, level, inputs or {}, outputs or {})
        if self.source.compiled is not None and not self._is_compared:
            from .description.mujoco_check import compared_with_mujoco

            linearized._notices += compared_with_mujoco(self, posture)
            self._is_compared = True
        return linearized

    def visuals(self, *, collision: bool = False) -> tuple[Visual, ...]:
        """The shapes of the links, without meshes of missing files; this reads mesh files.

        Args:
            collision: whether the collision shapes are read instead; those that cannot be read are left out.

        Raises:
            InputError: visual shapes without sense, their mesh files that cannot be read.
        """
        from .description.visuals import visuals_of, visuals_of_mjcf

        if self.source.path is not None:
            return visuals_of_mjcf(self.source, collision=collision)
        return visuals_of(self.description, self._mesh_files, collision=collision)

    @cached_property
    def _mesh_files(self) -> MeshFiles:
        """Those that were read are kept, since visual and collision shapes may share them."""
        from .description.mesh_files import MeshFiles

        return MeshFiles(self.folder, self.package_dirs)

    def inertia_ellipsoids(self) -> dict[str, np.ndarray]:
        """Of each body, by its heaviest link: the placement (4, 4) in the link's frame that makes a unit sphere a uniform ellipsoid with
        its mass, centre of mass and inertia, payloads included."""
        from .linearization.inertia import inertia_ellipsoids

        return inertia_ellipsoids(self)

    def mesh_notices(self) -> tuple[Notice, ...]:
        """A notice on the meshes that are not drawn, since their files are missing or lie outside the folders named."""
        from .description.visuals import mesh_notices

        return mesh_notices(self.description, self._mesh_files)

    def poses(self, posture: Posture, displacements, scale: float = 1.0) -> dict[str, Poses]:
        """The places of all links for displacements (n, T) about a posture times a scale, with closed loops.

        Args:
            posture: of the linearization.
            displacements: shape (n, T), in m and rad.
            scale: factor of them.

        Returns:
            Positions and quaternions by link.
        """
        from .visualization import link_poses

        return link_poses(posture, displacements, scale)

    def connection_points(self, posture: Posture) -> tuple[ConnectionPoints, ...]:
        """The ends of all loops and springs in the frames of their bodies."""
        from .visualization import connection_points

        return connection_points(posture)

    def _summary(self) -> str:
        closed_by = f", {len(self.loops)} loop{'s' if len(self.loops) != 1 else ''}" if self.loops else ""
        return f"{self.name}: {len(self.bodies)} links, {len(self.coordinates)} coordinates{closed_by}"


def _gravity(gravity, usual) -> np.ndarray:
    """The vector of the acceleration, the usual one where none is given."""
    if gravity is None:
        return np.array(usual)
    if np.ndim(gravity) == 0:
        return np.array([0.0, 0.0, -real_number(gravity, "gravity")])
    return real_array(gravity, "gravity", shape=(3,))
