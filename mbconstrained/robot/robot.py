"""A robot: a URDF with loops, springs and flexible joints, which a URDF cannot express."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..ground.by_name import answering
from ..ground.errors import InputError
from ..mechanics.constraints import Level
from .connections import ZEROS, PointMotion
from .linearized import LinearizedRobot, linearized_robot
from .posture_search import find_posture
from .robot_model import RobotModel
from .statics import Posture

if TYPE_CHECKING:
    from ..ground.notices import Notice
    from .cartesian_path import PathModes
    from .description.meshes import MeshFiles
    from .visualization import ConnectionPoints, Poses, Visual


@answering
class Robot(RobotModel):
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
        inertias: other inertias of links, by link, as in ``Payload`` (kg m^2).
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

    def equilibrium(
        self,
        guess: Mapping | np.ndarray | str | None = None,
        forces: Mapping[str | PointMotion, float] | None = None,
        hold: Sequence[str] | Literal["all"] = (),
    ) -> Posture:
        """Find the posture near a guess at which the robot is in equilibrium, with closed loops.

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

    def inverse_kinematics(
        self, body: str, place, point=ZEROS, orientation=None, guess: Mapping | np.ndarray | str | None = None
    ) -> dict[str, float | tuple[float, ...]]:
        """Find joint values near a guess for which a point of a body is at a position and the loops are closed.

        The place is a loop between body and ground, which Gauss-Newton steps of least size close; where these get stuck, they start
        again from places near the guess, then from the middle of the limits of the joints. Values within the limits are
        preferred; where the search finds none, the notices of ``equilibrium`` name the joints that are beyond.

        Args:
            body: a link.
            place: in the directions of the ground (m), shape (3,).
            point: of the body, in its frame (m), shape (3,).
            orientation: of the body, roll, pitch, yaw (rad), shape (3,); any where it is None.
            guess: as in ``equilibrium``.

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
        point=ZEROS,
        orientation=None,
        guess: Mapping | np.ndarray | str | None = None,
        hold: Sequence[str] | Literal["all"] = "all",
        forces: Mapping[str | PointMotion, float] | None = None,
    ) -> PathModes:
        """Compute the undamped modes at each position of a point along a path, each mode continued by its shape.

        Args:
            body, point, orientation: as in ``inverse_kinematics``.
            places: along the path (m), shape (P, 3).
            guess: near the first place, from which each posture is sought from the one before.
            hold, forces: as in ``equilibrium``; joints that do not keep the guess give way to their load.

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

        return modes_along(self, target(body, point, ZEROS, orientation), places, self._guess(guess), hold, forces or {})

    def linearize(
        self,
        posture: Posture,
        level: Level = "position",
        inputs: Mapping[str, str | PointMotion] | None = None,
        outputs: Mapping[str, str | PointMotion] | None = None,
    ) -> LinearizedRobot:
        """Linearize about a posture: M d'' + D d' + K d = f + J^T lambda with J d = 0.

        K is the derivative of all forces at rest, the geometric stiffness of the loop forces included,

            K = dg/dq + d tau_springs/dq - d(J^T lambda)/dq at constant lambda.

        Args:
            posture: from ``equilibrium`` of this robot.
            level: level of the constraint rows of the loops, "position", "velocity" or "acceleration".
            inputs, outputs: by name of your own: a joint (its torque; its angle), or a ``PointMotion``.

        Returns:
            The linear system in the coordinates of the joints.

        Raises:
            InputError: a posture of another robot, unknown names.
        """
        if not isinstance(posture, Posture) or posture.robot is not self:
            raise InputError("linearize: expected a posture from equilibrium() of this robot")
        return linearized_robot(posture, level, inputs or {}, outputs or {})

    def visuals(self, *, collision: bool = False) -> tuple[Visual, ...]:
        """The shapes of the links, without meshes of missing files; this reads mesh files.

        Args:
            collision: whether the collision shapes are read instead; those that cannot be read are left out.

        Raises:
            InputError: visual shapes without sense, their mesh files that cannot be read.
        """
        from .visualization import visuals_of, visuals_of_mjcf

        if self.source.path is not None:
            return visuals_of_mjcf(self.source, collision=collision)
        return visuals_of(self.description, self._mesh_files, collision=collision)

    @cached_property
    def _mesh_files(self) -> MeshFiles:
        """Mesh files, cached since visual and collision shapes may share them."""
        from .description.meshes import MeshFiles

        return MeshFiles(self.folder, self.package_dirs)

    def inertia_ellipsoids(self) -> dict[str, np.ndarray]:
        """Return the ellipsoid of equal mass, centre and inertia of each body, as placement (4, 4) of a unit sphere in a link."""
        from .linearized import inertia_ellipsoids

        return inertia_ellipsoids(self)

    def mesh_notices(self) -> tuple[Notice, ...]:
        """A notice on the meshes that are not drawn, since their files are missing or lie outside the folders named."""
        from .visualization import mesh_notices

        return mesh_notices(self.description, self._mesh_files)

    def poses(self, posture: Posture, displacements, scale: float = 1.0) -> dict[str, Poses]:
        """Return the poses of all links for displacements (n, T) about a posture times a scale, with closed loops.

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
        """Return the ends of all loops and springs in the frames of their bodies."""
        from .visualization import connection_points

        return connection_points(posture)
