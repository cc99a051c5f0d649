"""A robot linearized about a posture: matrices in tangent coordinates, loops as constraint rows; forces of connections and parameters.

The wrench T f of a connection, with f = -dU/dphi - D phi' of a spring and f = G^T lambda of a loop, to first order in the motion:

    T f = T_0 f_0 + (dT/dq f_0 + T_0 df/dq) d + T_0 df/dq' d' + T_0 G^T dlambda

Those of joints stand in the matrices as they are, but for the stiffness of a spring with a rest: like masses and connections between
bodies it moves the equilibrium. Then the equilibrium is searched again, from the posture, and the robot is linearized there
(``Parameter.of_function``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy, deepcopy
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..ground.checks import OF_FUNCTION, nearest, real_number
from ..ground.errors import InputError
from ..ground.notices import Notice
from ..ground.tolerances import CONE_TOLERANCE, NOISE_SAFETY
from ..ground.units import force_unit
from ..mechanics.channels import channels, chosen_by_name
from ..mechanics.constraints import Constraint, Level, checked_level
from ..mechanics.energy import EnergyParts
from ..mechanics.equations import ElementForce, Side
from ..mechanics.harmonic_response import frequency_response
from ..mechanics.parameter import Parameter
from ..mechanics.peaks import EffectiveMasses, effective_masses
from ..mechanics.system import MechanicalSystem
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import zero
from .connections import AXES, BodySpring, PointMotion
from .description.urdf import link_masses, replace_masses
from .kinematics import Tree
from .posture_search import limit_values, moving_contact_notices
from .robot_model import RobotModel
from .statics import (
    Search,
    cleaned,
    cleaned_rows,
    equilibrium,
    lost_springs,
    rounding_errors,
    stiffness_parts,
    stiffness_rounding,
    symmetric_stiffness,
)

if TYPE_CHECKING:
    from ..control.state_space import StateSpace
    from ..frequency.frequency_response import FrequencyResponse
    from ..frequency.random.random_response import RandomResponse
    from ..mechanics.motion import Motion
    from ..mechanics.switched.switched_system import SwitchedSystem
    from .connections import Connection
    from .flexible_joint import WithoutMotors
    from .linear_range import LinearRange
    from .statics import Load, Posture
    from .switching import Grip, RobotSwitch

#: Least semi-axis of an ellipsoid (m): a point mass is drawn, and the normals of a flat one exist.
THINNEST = 0.001


def body_masses(posture: Posture) -> list[tuple[str, np.ndarray]]:
    """The contribution S_j^T I_j S_j of each body to M, shape (nv, nv), with the name of its heaviest link."""
    names, inertias = posture.robot.link_frames.heaviest_links(), posture.robot.model.inertias
    return [
        (
            names.get(joint, str(posture.robot.model.names[joint])),
            inertias[joint].mass * v.T @ v + w.T @ np.array(inertias[joint].inertia) @ w,
        )
        for joint, _, v, w, _ in _motions(posture)
    ]


def momentum(posture: Posture) -> np.ndarray:
    """Momentum and angular momentum about the origin of the ground by velocity of each coordinate, shape (6, nv)."""
    total = np.zeros((6, posture.robot.model.nv))
    for joint, centre, v, w, R in _motions(posture):
        inertia = posture.robot.model.inertias[joint]
        total[:3] += inertia.mass * v
        total[3:] += inertia.mass * np.cross(centre, v, axis=0) + R @ np.array(inertia.inertia) @ w
    return total


def inertia_ellipsoids(robot: RobotModel) -> dict[str, np.ndarray]:
    """Inertia ellipsoids as in ``Robot.inertia_ellipsoids``, with semi-axes a, b, c of at least THINNEST: m (b^2 + c^2) / 5 = I_1."""
    ellipsoids = {}
    for joint, name in robot.link_frames.heaviest_links().items():
        inertia = robot.model.inertias[joint]
        if joint == 0 or inertia.mass <= 0:
            continue
        moments, axes = np.linalg.eigh(np.array(inertia.inertia))
        squares = 2.5 * (moments.sum() - 2 * moments) / inertia.mass
        link, placement = robot.link_frames.link(name), np.eye(4)
        axes[:, 0] *= np.linalg.det(axes)  # a rotation
        placement[:3, :3] = link.rotation.T @ axes * np.maximum(np.sqrt(np.maximum(squares, 0.0)), THINNEST)
        placement[:3, 3] = link.rotation.T @ (np.array(inertia.lever) - link.point)
        ellipsoids[name] = placement
    return ellipsoids


def _motions(posture: Posture) -> Iterator[tuple[int, np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Joint, centre of mass, its velocity (3, nv), angular velocity in principal axes (3, nv), and these axes, for each body."""
    model, kinematics = posture.robot.model, posture.balance.kinematics
    for joint in range(1, model.njoints):
        R = kinematics.rotations[joint]
        centre = kinematics.origins[joint] + R @ np.array(model.inertias[joint].lever)
        yield joint, centre, kinematics.of_point(joint, centre), R.T @ kinematics.velocity(joint)[3:], R


@dataclass(frozen=True, eq=False)
class ConnectionForces:
    """F = rest + displacement d + velocity d' + multipliers dlambda: forces (N) and torques (N m) on the second bodies, k rows.

    A force has the directions x, y, z of the ground, which do not turn; a torque, too, about the point of the connection on the
    second body. Loads at rest are included.
    """

    connections: tuple[Connection, ...]  # the loops, then springs and bushings
    places: dict[str, slice]  # by name of a connection its rows: three forces, then three torques where it can have any
    # names and units of the rows
    names: tuple[str, ...]
    units: tuple[str, ...]
    rest: np.ndarray  # at the posture, shape (k,)
    # by the coordinates of the system, shape (k, n)
    displacement: np.ndarray
    velocity: np.ndarray
    multipliers: np.ndarray  # by those of its constraint rows, shape (k, m)

    def values(self, d: np.ndarray, rates: np.ndarray, multipliers: np.ndarray) -> np.ndarray:
        """F over time, shape (k, T), for deviations and their rates (n, T), and changes of the multipliers (m, T)."""
        return self.rest[:, None] + self.displacement @ d + self.velocity @ rates + self.multipliers @ multipliers


def connection_forces(posture: Posture, size: int, rows: Sequence[str]) -> ConnectionForces:
    """The forces of all loops, springs and bushings about a posture."""
    balance, load = posture.balance, posture.balance.load
    connections = tuple(item.connection for item in (*load.loops, *load.springs))
    parts = []
    for item, pose, G, at in balance.loops:
        own = posture.multipliers[at]
        curvature = item.connection.curvature(pose.value, own)
        gradients = dict(zip(load.row_names[at], G))
        by_row = np.array([gradients.get(name, np.zeros(6)) for name in rows]).reshape(-1, 6).T
        parts.append((pose, G.T @ own, curvature, np.zeros((6, 6)), by_row))
    parts += [(own.pose, own.wrench, -own.curvature, -own.damper, np.zeros((6, len(rows)))) for own in balance.elastic]
    blocks, places, count = [], {}, 0
    for one, (pose, f, by_phi, by_rate, by_row) in zip(connections, parts):
        T, J, kept = pose.directions, pose.jacobian, 6 if one.turning else 3
        moved, damped = pose.wrench_change(f) + T @ by_phi @ J, T @ by_rate @ J
        motors = np.zeros((6, size - J.shape[1]))
        blocks.append(np.column_stack([T @ f, moved, motors, damped, motors, T @ by_row])[:kept])
        places[one.name] = slice(count, count := count + kept)
    rest, displacement, velocity, multipliers = np.split(
        np.vstack([np.zeros((0, 1 + 2 * size + len(rows))), *blocks]), [1, 1 + size, 1 + 2 * size], axis=1
    )
    names = [f"{one.name} {axis}" for one in connections for _ in range(1 + one.turning) for axis in "xyz"]
    units = [unit for one in connections for unit in ("N", "N m")[: 1 + one.turning] for _ in "xyz"]
    return ConnectionForces(connections, places, tuple(names), tuple(units), rest[:, 0], displacement, velocity, multipliers)


def foot_limits(posture: Posture, forces: ConnectionForces, values, sizes: Mapping[str, float], error: float) -> np.ndarray:
    """Violation of the limits of feet, positive where ``foot_notices`` reports it."""
    return limit_values(posture.balance, _wrenches(forces, values), sizes, max(error, CONE_TOLERANCE))


def _wrenches(forces: ConnectionForces, values: np.ndarray) -> dict[str, np.ndarray]:
    """Force and torque of each connection, shape (6, T)."""
    wrenches = {name: np.zeros((6, values.shape[1])) for name in forces.places}
    for name, rows in forces.places.items():
        wrenches[name][: rows.stop - rows.start] = values[rows]
    return wrenches


def foot_notices(posture: Posture, forces: ConnectionForces, times, values, reactions, error: float) -> Iterator[Notice]:
    """Notices on feet that lift off, slip or tip over during a motion but not at rest."""
    balance, robot = posture.balance, posture.robot
    multipliers = np.tile(posture.multipliers[:, None], 1 + len(times))
    for name, change in reactions.items():
        if name in balance.load.row_names:
            multipliers[balance.load.row_names.index(name), 1:] += change
    wrenches = _wrenches(forces, np.column_stack([forces.rest, values]))
    free = ~np.isin(robot.coordinates, list(posture.torques))
    yield from moving_contact_notices(balance, free, multipliers, times, wrenches, error)


#: Constants along and about an axis, with their units.
BUSHING_UNITS = {"stiffness": "N/m", "turning_stiffness": "N m/rad", "damping": "N s/m", "turning_damping": "N m s/rad"}

Linearize = Callable[["Posture"], "MechanicalSystem"]


def robot_parameters(posture: Posture, linearize: Linearize) -> Iterator[Parameter]:
    """One parameter for each nonzero constant."""
    yield from _joints(posture, linearize)
    yield from _flexible_joints(posture.robot)
    yield from _connections(posture, linearize)
    yield from _masses(posture, linearize)


def _joints(posture: Posture, linearize: Linearize) -> Iterator[Parameter]:
    robot, size = posture.robot, len(posture.robot.coordinates) + len(posture.robot.flexible_joints)
    for place, (name, unit) in enumerate(zip(robot.coordinates, robot.units)):
        of_force = force_unit(unit)
        value, only = float(robot.joint_stiffness[place]), np.eye(len(robot.coordinates))[place]
        if value:
            build = partial(_with_joint_stiffness, posture, linearize, only, value)
            yield Parameter.of_function(f"{name}.stiffness", value, build, f"{of_force}/{unit}")
        if value := float(robot.joint_damping[place]):
            corner = np.diag(np.eye(size)[place])
            yield Parameter(f"{name}.damping", value, damping=corner, unit=f"{of_force} s/{unit}")


def _flexible_joints(robot: RobotModel) -> Iterator[Parameter]:
    """Stiffness and damping of gears: [1, -1; -1, 1] between link and motor, without effect on the statics of the links."""
    for (name, joint), stretch in zip(robot.flexible_joints.items(), gear_stretches(robot)):
        unit = robot.units[robot.coordinates.index(name)]
        for key, over in (("stiffness", "/"), ("damping", " s/")):
            if value := getattr(joint, key):
                slopes: dict[str, Any] = {key: np.outer(stretch, stretch)}
                yield Parameter(f"{name}.{key}", value, **slopes, unit=f"{force_unit(unit)}{over}{unit}")


def gear_stretches(robot: RobotModel) -> np.ndarray:
    """The angle of each motor less that of its link, by the coordinates of both, shape (f, n)."""
    links = [robot.coordinates.index(name) for name in robot.flexible_joints]
    stretches = np.zeros((len(links), len(robot.coordinates) + len(links)))
    for motor, link in enumerate(links):
        stretches[motor, [link, len(robot.coordinates) + motor]] = -1.0, 1.0
    return stretches


def _connections(posture: Posture, linearize: Linearize) -> Iterator[Parameter]:
    """Constants of springs and bushings between bodies; a spring keeps its rest length."""
    for number, item in enumerate(posture.balance.load.springs):
        spring = item.connection
        for key, unit in BUSHING_UNITS.items():
            given = getattr(spring, key, 0.0)
            for axis, value in zip([""] if isinstance(spring, BodySpring) else [" x", " y", " z"], np.atleast_1d(given).tolist()):
                if value:
                    build = partial(_with_connection, posture, linearize, number, key, axis.strip())
                    yield Parameter.of_function(f"{spring.name}.{key}{axis}", value, build, unit)


def _masses(posture: Posture, linearize: Linearize) -> Iterator[Parameter]:
    """Masses of the links of a URDF, by the description with another mass, and of payloads.

    The inertia of a body is linear in each of them: by joint the ten inertial parameters of pinocchio for 1 kg.
    """
    import pinocchio

    robot = posture.robot
    masses: list[tuple[str, float, dict[int, np.ndarray]]] = []
    if robot.source.model is None:
        own = _inertias(robot, {})
        for name, mass in link_masses(robot.description).items():
            if mass > 0.0:
                changes = _inertias(robot, {name: 2 * mass}) - own
                masses.append((name, mass, {joint: change / mass for joint, change in enumerate(changes, 1) if change.any()}))
    for payload in robot.payloads:
        anchor = robot.link_frames.anchor(payload.body, "payloads", payload.centre)
        slope = np.array(pinocchio.Inertia(1.0, anchor.point, np.zeros((3, 3))).toDynamicParameters())
        if payload.mass and anchor.joint:
            masses.append((f"payload on {payload.body}", payload.mass, {anchor.joint: slope}))
    for name, mass, slopes in masses:
        if slopes:
            yield Parameter.of_function(f"{name}.mass", mass, partial(_with_masses, posture, linearize, mass, slopes), "kg")


def _inertias(robot: RobotModel, masses: dict[str, float]) -> np.ndarray:
    description = deepcopy(robot.description)
    replace_masses(description, masses, {})
    inertias = list(robot.model_of(description).inertias)[1:]
    return np.array([np.array(one.toDynamicParameters()) for one in inertias]).reshape(-1, 10)


def _with_joint_stiffness(posture: Posture, linearize: Linearize, only: np.ndarray, old: float, value: float) -> MechanicalSystem:
    twin = copy(posture.robot)
    twin.joint_stiffness = twin.joint_stiffness + (value - old) * only
    return linearize(_again(posture, twin, replace(posture.balance.load, joint_stiffness=twin.joint_stiffness)))


def _with_connection(posture: Posture, linearize: Linearize, number: int, key: str, axis: str, value: float) -> MechanicalSystem:
    springs = list(posture.balance.load.springs)
    spring: Any = springs[number].connection
    numbers = value if not axis else tuple(value if one == axis else old for one, old in zip("xyz", getattr(spring, key)))
    springs[number] = replace(springs[number], connection=replace(spring, **{key: numbers}))
    return linearize(_again(posture, posture.robot, replace(posture.balance.load, springs=tuple(springs))))


def _with_masses(
    posture: Posture, linearize: Linearize, old: float, slopes: dict[int, np.ndarray], value: float
) -> MechanicalSystem:
    import pinocchio

    twin = copy(posture.robot)
    model = twin.model.copy()
    for joint, slope in slopes.items():
        numbers = model.inertias[joint].toDynamicParameters() + (value - old) * slope
        model.inertias[joint] = pinocchio.Inertia.FromDynamicParameters(numbers)
    twin.tree = Tree(model)
    return linearize(_again(posture, twin, posture.balance.load))


def _again(posture: Posture, robot: RobotModel, load: Load) -> Posture:
    """The equilibrium of a slightly changed robot, near the posture; the constrained coordinates keep their values."""
    free = ~np.isin(robot.coordinates, list(posture.torques))
    state = equilibrium(Search(robot.tree, load, free, names=robot.coordinates), posture.configuration)
    balance = state.balance
    return replace(posture, robot=robot, configuration=balance.configuration, multipliers=state.multipliers, balance=balance)


class LinearizedRobot(MechanicalSystem):
    """Small motions of a robot, M d'' + D d' + K d = f + J^T lambda, J d = 0; returned by ``Robot.linearize``.

    The coordinates d are deviations from the posture, q = q0 (+) d, named after the joints; a flexible joint adds the angle
    of its motor behind the gear, "<joint> motor". Multipliers are changes of the loop forces, in the frames of the loops.

    Attributes:
        posture: the posture of the linearization.
        inputs: by name the distribution of a force over the coordinates, shape (n,): a joint's torque (of a flexible one the
            motor's), or a force or torque on a body.
        outputs: by name a row of C in y = C d, shape (n,): a joint's angle, or the motion of a point.
        input_units, output_units: "m" or "rad" for each, along which a force in N or a torque in N m works.
        flexible_joints: the flexible joints with the places of their links' coordinates; their motors follow after all links.
        switched_loops: names of loops of the posture that are closed in some phases of a switched robot only.
        grips: contacts of a switched robot that do not slide.
    """

    switched_loops: tuple[str, ...] = ()
    grips: tuple[Grip, ...] = ()

    def __init__(self, posture: Posture, level: Level, inputs: Mapping, outputs: Mapping):
        robot, balance = posture.robot, posture.balance
        self.posture = posture
        checked_level(level, "level")
        self._stiffness_parts = stiffness_parts(posture)
        self.flexible_joints = tuple((robot.coordinates.index(name), joint) for name, joint in robot.flexible_joints.items())
        K, rounding = sum(part for _, part in self._stiffness_parts), stiffness_rounding(posture)
        noise = NOISE_SAFETY * rounding
        link_stiffness, notices = symmetric_stiffness(posture, np.where(np.abs(K) > noise, K, 0.0))
        self._notices = (*notices, *lost_springs(self._stiffness_parts[:-1], noise))
        sizes = balance.entry_sizes
        damping = np.diag(robot.joint_damping) + sum(cleaned(part, sizes) for part in balance.dampings)
        motors = [joint for _, joint in self.flexible_joints]
        names = (*robot.coordinates, *(f"{robot.coordinates[i]} motor" for i, _ in self.flexible_joints))
        super().__init__(
            mass=self._with_motors(cleaned(balance.mass, sizes)) + self._at_motors([motor.reflected_inertia for motor in motors]),
            damping=self._with_motors(damping)
            + self._gears([motor.damping for motor in motors])
            + self._at_motors([motor.derivative_gain for motor in motors]),
            stiffness=self._with_motors(link_stiffness)
            + self._gears([motor.stiffness for motor in motors])
            + self._at_motors([motor.proportional_gain for motor in motors]),
            constraints=self._rows(level),
            names=names,
            units=(*robot.units, *(robot.units[i] for i, _ in self.flexible_joints)),
            energy_parts=self._energy_parts(),
            uncertainty={
                "mass": self._with_motors(rounding_errors(balance.mass, sizes)),
                "damping": self._with_motors(sum((rounding_errors(part, sizes) for part in balance.dampings), 0.0 * sizes)),
                "stiffness": self._with_motors(rounding),
            },
        )
        self.inputs, self.input_units = self._directions("input", inputs)
        self.outputs, self.output_units = self._directions("output", outputs)
        self.parameter_source = partial(robot_parameters, posture, partial(type(self), level=level, inputs={}, outputs={}))

    has_one_axis = False

    @cached_property
    def elements(self) -> Mapping[str, ElementForce]:  # type: ignore[override]
        """Springs and dampers of joints, and springs between bodies with elongations from their rest lengths."""
        balance, robot, forces = self.posture.balance, self.posture.robot, {}
        for place, name in enumerate(robot.coordinates):
            stiffness, damping = robot.joint_stiffness[place], robot.joint_damping[place]
            if stiffness or damping:
                stretch = float(balance.joint_stretch[place]) if stiffness else 0.0
                forces[name] = ElementForce(np.eye(self.size)[place], stretch, stiffness, damping, robot.units[place])
        for item in balance.load.springs:
            spring = item.connection
            if hasattr(spring, "preload"):
                pose = item.pose(balance.kinematics)
                length = float(np.linalg.norm(pose.value[:3]))
                row = np.zeros(self.size)
                row[: len(robot.coordinates)] = pose.value[:3] @ pose.jacobian[:3] / (length or 1.0)
                forces[spring.name] = ElementForce(row, length - item.rest_length, spring.stiffness, spring.damping, "m")
        return forces

    @cached_property
    def connection_forces(self) -> ConnectionForces:
        """Forces of loops, springs and bushings as combinations of motion and multipliers, in the directions of the ground."""
        return connection_forces(self.posture, self.size, [row.name for row in self.rows])

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on the posture, on the matrices and on the constraint rows."""
        return (*self.posture.notices, *self._notices, *super().notices)

    def range_notices(self, motion: Motion) -> tuple[Notice, ...]:
        """Return notices on a motion beyond the linear range; of switched robots by phase, and on feet that slip."""
        from .linear_range import range_notices

        return range_notices(motion, self.posture, self.grips)

    def linear_range(self, motion: Motion, times=None) -> LinearRange:
        """Return the range of validity of a motion: its residual force in the nonlinear equations estimates the relative error.

            r = N(q)^T [M(q) a + c(q, v) + g(q) + D(q) v + tau(q) - f],    q = q0 (+) d, loops closed

        Args:
            motion: motion of this robot, from ``solve``.
            times: times in s, shape (T,); two periods of the slowest eigenvalue by default.

        Returns:
            A ``LinearRange``: ``deviation``, the coordinate of the largest displacement with its ``amplitude`` (m, rad), and
            ``limit``, the amplitude at which the deviation is 10 %.

        >>> from mbconstrained import Robot
        >>> urdf = '''<robot name="pendulum"><link name="base"/><link name="rod"><inertial><mass value="2"/>
        ...   <origin xyz="0 0 -0.5"/><inertia ixx="0.1" iyy="0.1" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
        ...   <joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint></robot>'''
        >>> robot = Robot(urdf)
        >>> swing = robot.linearize(robot.equilibrium())
        >>> found = swing.linear_range(swing.solve({"hinge": 0.3}))
        >>> round(found.deviation, 4), round(found.limit, 2)  # sin x is off by 1 - sin(0.3) / 0.3, and by 10 % at 0.79 rad
        (0.0149, 0.79)
        """
        from .linear_range import linear_range

        return linear_range(motion, self.posture, times)

    def named_directions(self, side: Side) -> Mapping[str, tuple[np.ndarray, str]]:
        """Return the directions of the inputs or outputs by name, with units."""
        directions, units = (self.inputs, self.input_units) if side == "inputs" else (self.outputs, self.output_units)
        return {**{name: (direction, units[name]) for name, direction in directions.items()}, **super().named_directions(side)}

    @property
    def output_matrix(self) -> np.ndarray:
        """C, the rows of all outputs, shape (p, n)."""
        return np.array([*self.outputs.values()]).reshape(len(self.outputs), self.size)

    def input_force(self, signals: Mapping[str, ImpulsiveSmooth]) -> ImpulsiveSmooth:
        """f on all coordinates from signals with one row by name of an input or of a coordinate.

        Raises:
            InputError: an unknown name, a signal with more than one row.
        """
        total = zero(self.size)
        for name, signal in signals.items():
            if not isinstance(signal, ImpulsiveSmooth) or signal.size != 1:
                advice = OF_FUNCTION if callable(signal) and not isinstance(signal, ImpulsiveSmooth) else ""
                raise InputError(f'input "{name}": expected a signal with one row, such as mb.step([1.0]){advice}')
            total = total + signal.mapped(self.force_direction(name)[:, None])
        return total

    def force_direction(self, name: str) -> np.ndarray:
        """The distribution of a force over the coordinates, by name of an input or of a coordinate, shape (n,)."""
        if name in self.inputs:
            return self.inputs[name]
        if name not in self.names:
            known = (*self.inputs, *self.names)
            raise InputError(f'there is no input or coordinate "{name}"{nearest(name, known)}')
        return np.eye(self.size)[self.names.index(name)]

    def prescribe(
        self, motions: Mapping[str, ImpulsiveSmooth | float] | Sequence[str] | str, level: Level = "position"
    ) -> LinearizedRobot:
        """Return the robot with prescribed motions: joints, points or a moving base follow signals.

        The multiplier of a row is the force or torque that its motion needs, in addition to that at rest.

        Args:
            motions: by name of a coordinate, an output or a row of a loop: the signal, with one row, of its deviation from the
                posture, or a constant. Names alone stand for 0: motors that hold joints, and inputs of frequency responses.
            level: the derivative that is given, "position", "velocity" or "acceleration".

        Returns:
            A system with rows "motion of NAME", which are inputs of ``frequency_response``; a row that there is already, as
            those of a moving base, takes the signal and the level.

        Raises:
            InputError: unknown names, signals with several rows.
            ContradictoryConstraints: rows that are dependent, with different values.

        >>> from mbconstrained import Robot
        >>> urdf = '''<robot name="pendulum"><link name="base"/><link name="rod"><inertial><mass value="2"/>
        ...   <origin xyz="0 0 -0.5"/><inertia ixx="0.1" iyy="0.1" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
        ...   <joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint></robot>'''
        >>> robot = Robot(urdf, base="moving")
        >>> system = robot.linearize(robot.equilibrium())
        >>> H = system.frequency_response([0.0, 1000.0], ["motion of base x"], ["hinge"])
        >>> H.values.real.round(3).ravel().tolist()  # at last m l / (I + m l^2) with l = 0.5 m: the rod turns about a point at rest
        [0.0, 1.667]
        """
        values = motions if isinstance(motions, Mapping) else dict.fromkeys([motions] if isinstance(motions, str) else motions, 0.0)
        known, rows = channels(self, "outputs"), {row.name: row.constraint() for row in self.rows}
        for name, value in values.items():
            if not isinstance(value, ImpulsiveSmooth):
                value = real_number(value, f"motion of {name}")
            label = name if name in rows else f"motion of {name}"
            (channel,) = chosen_by_name("motions", label if label in rows else name, known, ())
            doubt = rows[label].uncertainty if label in rows else None
            rows[label] = Constraint(np.atleast_2d(channel.direction), level, value, label, channel.unit, doubt)
        return self._with_rows(rows.values())

    def with_switches(self, *parts: RobotSwitch) -> SwitchedSystem:
        """Return the robot with joint stops, contacts, feet that lift off and loops that close: its equations change from phase to phase.

        The rows of contacts are those at the posture, as all motions are small about it; the notices of a motion report by phase how far
        the nonlinear robot is from it.

        Args:
            parts: ``JointStop``, ``PointContact``, ``LiftingFoot`` and ``ClosingLoop``.

        Returns:
            A ``SwitchedSystem``.

        Raises:
            InputError: unknown joints, bodies or loops, a posture beyond a stop, names in use.

        >>> from mbconstrained import JointStop, Robot
        >>> urdf = '''<robot name="pendulum"><link name="base"/><link name="rod"><inertial><mass value="2"/>
        ...   <origin xyz="0 0 -0.5"/><inertia ixx="0.1" iyy="0.1" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
        ...   <joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint></robot>'''
        >>> robot = Robot(urdf)
        >>> swing = robot.linearize(robot.equilibrium()).with_switches(JointStop("hinge", lower="-3 deg", restitution=0.8))
        >>> [event.text for event in swing.solve({"hinge": 0.1}, end=1.0).events]
        ['hinge stop impact']
        """
        from ..mechanics.switched.switched_system import SwitchedSystem
        from .switching import load_of, robot_switches

        switches, grips = robot_switches(self.posture, self.size, parts)
        loops = tuple(part.opened for part in parts if part.opened is not None)
        rows = (row for item in self.posture.loops if item.connection.name in loops for row in item.connection.row_names)
        common = copy(self.without_rows(rows))
        common.static_force = self.static_force - load_of(self.posture, self.size, loops)
        common.switched_loops, common.grips = loops, grips
        return SwitchedSystem.of_switches(common, switches)

    def without_rows(self, names: Iterable[str]) -> LinearizedRobot:
        """Return the robot without some of its constraint rows, such as those of a moving base that another motion replaces.

        Args:
            names: names of rows; unknown names are ignored.

        Returns:
            A ``LinearizedRobot``.
        """
        left = set(names)
        return (
            self
            if left.isdisjoint(row.name for row in self.rows)
            else self._with_rows(row.constraint() for row in self.rows if row.name not in left)
        )

    def _with_rows(self, rows: Iterable[Constraint]) -> LinearizedRobot:
        bare = copy(self)
        bare.constraints = ()
        return bare.with_constraints(*rows)

    def frequency_response(self, frequencies_hz="auto", inputs=None, outputs=None, *arguments, **named) -> FrequencyResponse:
        """Return the frequency response between coordinates, constraint rows, joints and points.

        Args:
            frequencies_hz: frequencies in Hz, or "auto".
            inputs: names of coordinates, rows and ``inputs``, or a mapping from new names to joints and ``PointMotion``: forces
                and torques that act there.
            outputs: names of coordinates, rows and ``outputs``, or such a mapping: measured motions.
            arguments, named: see ``MechanicalSystem.frequency_response``.

        Returns:
            The response.

        Raises:
            InputError: unknown names, quantities that do not fit.

        >>> from mbconstrained import PointMotion, Robot
        >>> urdf = '''<robot name="arm"><link name="base"/><link name="rod"><inertial><mass value="2"/>
        ...   <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
        ...   <joint name="j1" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint></robot>'''
        >>> robot = Robot(urdf, joint_stiffness={"j1": 50.0})
        >>> tip = {"tip": PointMotion("rod", (1, 0, 0), along=(0, 0, 1))}
        >>> robot.linearize(robot.equilibrium()).frequency_response([0.0], tip, tip).values.real.item()
        0.02
        """
        system = self.with_points(inputs, outputs)
        return frequency_response(system, frequencies_hz, _chosen(inputs), _chosen(outputs), *arguments, **named)

    def random_response(self, excitation: Mapping, outputs=None, quantity: str = "displacement", **options) -> RandomResponse:
        """Return the stationary random response, for example the vibration of the tool of a robot on a randomly moving base.

        Args:
            excitation: spectra by names of coordinates, rows ("motion of base x") and ``inputs``.
            outputs: names of coordinates, rows and ``outputs``, or a mapping from new names to joints and ``PointMotion``.
            quantity, options: see ``MechanicalSystem.random_response``.

        Returns:
            The response.

        >>> from mbconstrained import PointMotion, Robot, white_noise
        >>> urdf = '''<robot name="arm"><link name="base"/><link name="rod"><inertial><mass value="2"/>
        ...   <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
        ...   <joint name="slide" type="prismatic"><parent link="base"/><child link="rod"/><axis xyz="0 0 1"/></joint></robot>'''
        >>> robot = Robot(urdf, base="moving", joint_stiffness={"slide": 800.0}, joint_damping={"slide": 8.0})
        >>> arm, tip = robot.linearize(robot.equilibrium()), {"tip": PointMotion("rod", along=(0, 0, 1))}
        >>> noise = {"motion of base z": white_noise(0.3, of="acceleration")}
        >>> R = arm.random_response(noise, tip, "acceleration")
        >>> wn, z = 20.0, 0.1
        >>> bool(np.isclose(R.covariance.item(), wn / 2 * 0.3 * (1 + 4 * z**2) / (4 * z), rtol=1e-12))  # of a mass on its base
        True
        """
        return super(LinearizedRobot, self.with_points(None, outputs)).random_response(
            excitation, _chosen(outputs), quantity, **options
        )

    def to_state_space(self, inputs=None, outputs=None) -> StateSpace:
        """Return the state space between joints and points as inputs and outputs.

        Args:
            inputs, outputs: names, or mappings, as in ``frequency_response``; all coordinates by default.

        Returns:
            The ``StateSpace``.
        """
        return super(LinearizedRobot, self.with_points(inputs, outputs)).to_state_space(_chosen(inputs), _chosen(outputs))

    def effective_masses(self, base=("x", "y", "z")) -> EffectiveMasses:
        """Effective masses of the modes without damping under a motion of all that stands on the ground: a fixed or moving base,
        feet, springs to the ground.

            Gamma_i = u_i^T h with u_i^T M u_i = 1,    m_i = Gamma_i^2

        with the momentum h of the robot by velocity of each coordinate. Bodies that cannot move relative to the base have no part in it.

        Args:
            base: directions of its motion, "x", "y", "z" of the ground, or "rx", "ry", "rz" about its origin.

        Returns:
            ``EffectiveMasses``: ``masses`` (kg, kg m^2), shape (m, d), and ``totals``, shape (d,).

        Raises:
            InputError: another direction.

        >>> from mbconstrained import Robot
        >>> urdf = '''<robot name="pendulum"><link name="base"/><link name="rod"><inertial><mass value="2"/>
        ...   <origin xyz="0 0 -0.5"/><inertia ixx="0.1" iyy="0.1" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
        ...   <joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint></robot>'''
        >>> robot = Robot(urdf)
        >>> robot.linearize(robot.equilibrium()).effective_masses().masses.round(12)  # (m l)^2 / (I + m l^2)
        array([[1.66666667, 0.        , 0.        ]])
        """
        names = [base] if isinstance(base, str) else list(base) if isinstance(base, Iterable) else [base]
        for name in names:
            if name not in AXES:
                raise InputError(f"base: found {name!r}{nearest(str(name), AXES)}; expected {', '.join(AXES)}")
        links = momentum(self.posture)[[AXES.index(name) for name in names]]
        units = ["kg m^2" if name.startswith("r") else "kg" for name in names]
        return effective_masses(self, names, units, np.pad(links, ((0, 0), (0, len(self.flexible_joints)))).T)

    def with_points(self, inputs=None, outputs=None) -> LinearizedRobot:
        """Return the robot with other inputs and outputs.

        Args:
            inputs: a mapping from names of your own to joints and ``PointMotion``: forces and torques that act there; anything else
                keeps the inputs.
            outputs: a mapping of the same form: measured motions.

        Returns:
            The robot.
        """
        system = copy(self)
        if isinstance(inputs, Mapping):
            system.inputs, system.input_units = self._directions("input", inputs)
        if isinstance(outputs, Mapping):
            system.outputs, system.output_units = self._directions("output", outputs)
        return system

    def without_motors(self) -> WithoutMotors:
        """Return the equations without the motors of flexible joints: a polynomial matrix of degree 4."""
        from .flexible_joint import WithoutMotors

        return WithoutMotors(self, self.flexible_joints)

    def _with_motors(self, links: np.ndarray) -> np.ndarray:
        """A matrix of the links, with zeros for the motors."""
        return np.pad(links, (0, len(self.flexible_joints)))

    def _at_motors(self, values: Sequence[float]) -> np.ndarray:
        return np.diag([*np.zeros(len(self.posture.robot.coordinates)), *values])

    def _gears(self, values: Sequence[float]) -> np.ndarray:
        """Each value as a matrix between a motor and its link: [v, -v; -v, v]."""
        stretches = gear_stretches(self.posture.robot)
        return stretches.T @ np.diag(np.array(values, dtype=float)) @ stretches

    def _rows(self, level: Level) -> list[Constraint]:
        balance = self.posture.balance
        names, units = balance.load.row_names, balance.load.row_units
        motors = ((0, 0), (0, len(self.flexible_joints)))
        J, doubt = (np.pad(part, motors) for part in cleaned_rows(balance.jacobian, balance.sizes, units))
        return [
            Constraint(J[i], level=level, names=names[i], unit=units[i], uncertainty=doubt[i])
            for i in self.posture.independent_rows
        ]

    def _row(self, value, what: str) -> np.ndarray:
        robot, row = self.posture.robot, np.zeros(self.size)
        if isinstance(value, PointMotion):
            anchor = robot.link_frames.point(value, what)
            row[: len(robot.coordinates)] = self.posture.balance.row(value, anchor)
        elif isinstance(value, str) and value in self.names:
            row[self.names.index(value)] = 1.0
        else:
            hint = nearest(str(value), self.names)
            raise InputError(f"{what}: found {value!r}{hint}; expected the name of a joint, or mb.PointMotion(body, ...)")
        return row

    def _directions(self, what: str, values) -> tuple[dict[str, np.ndarray], dict[str, str]]:
        """Inputs or outputs by name over the coordinates, with their units; the torque of a flexible joint is that of its motor."""
        if not isinstance(values, Mapping):
            raise InputError(f"{what}s: found {type(values).__name__}; expected joints or mb.PointMotion by names of your own")
        directions, units = {}, {}
        for name, value in values.items():
            label = f'{what} "{name}"'
            if what == "input" and name in self.names:
                raise InputError(f"{label}: this is the name of a coordinate, on which forces can act anyway; choose another")
            if what == "input" and (motor := f"{value} motor") in self.names:
                value = motor
            directions[str(name)] = self._row(value, label)
            units[str(name)] = ("rad" if value.turn else "m") if isinstance(value, PointMotion) else self.units[value]
        return directions, units

    def _energy_parts(self) -> EnergyParts:
        robot, count = self.posture.robot, len(self.flexible_joints)
        kinetic = [(name, self._with_motors(part)) for name, part in body_masses(self.posture)]
        armature = np.array(robot.model.armature)
        rotors = [
            (f"rotor of {name}", np.diag(row)) for name, row, value in zip(robot.coordinates, np.diag(armature), armature) if value
        ]
        rotors += [
            (item.attached.tendon.name, item.inertia) for item in self.posture.balance.tendons if item.attached.tendon.inertia
        ]
        kinetic += [(name, self._with_motors(part)) for name, part in rotors]
        strain = [(name, self._with_motors(part)) for name, part in self._stiffness_parts]
        for place, (link, joint) in enumerate(self.flexible_joints):
            only, name = np.eye(count)[place], robot.coordinates[link]
            kinetic.append((f"{name} motor", self._at_motors(only * joint.reflected_inertia)))
            strain.append((f"gear of {name}", self._gears(only * joint.stiffness)))
            if joint.proportional_gain:
                strain.append((f"control of {name}", self._at_motors(only * joint.proportional_gain)))
        return EnergyParts(_by_distinct_names(kinetic), _by_distinct_names(strain))


def linearized_robot(
    posture: Posture, level: Level = "position", inputs: Mapping | None = None, outputs: Mapping | None = None
) -> LinearizedRobot:
    """The linearized robot; the first of a file of MuJoCo is compared with MuJoCo's own."""
    robot, linearized = posture.robot, LinearizedRobot(posture, level, inputs or {}, outputs or {})
    if robot.source.compiled is not None and not robot._is_compared:
        from .linear_range import compared_with_mujoco

        linearized._notices += compared_with_mujoco(robot, posture)
        robot._is_compared = True
    return linearized


def _by_distinct_names(parts: list[tuple[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """The contributions by distinct name: equal names of links, springs and joints get numbers."""
    named: dict[str, np.ndarray] = {}
    for name, part in parts:
        own = (name, *(f"{name} ({number})" for number in range(2, len(parts) + 2)))
        named[next(candidate for candidate in own if candidate not in named)] = part
    return named


def _chosen(channels):
    """The names of a mapping, and the other names of channels."""
    return list(channels) if isinstance(channels, Mapping) else channels
