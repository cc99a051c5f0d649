"""Robots: the robot's file, an equilibrium, small motions about it; posture, forces and limits in reports."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import asin, atan2, degrees
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...ground.checks import listed
from ...ground.display import TextTable, number_text, with_unit
from ...ground.errors import InputError, shown
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import JOINT_LIMIT
from ...ground.units import GROUND, force_unit
from ...signals.bohl import BohlFunction
from ..coordinates import Coordinates
from ..file import SceneName, at, robot_name, robot_path
from .model import Decision, Equations, ModelTables
from .robot_file import PLACE, RobotData, given, joint_values, point_motion, posing, robot_data, robot_of

if TYPE_CHECKING:
    from ...robot.connections import Connection, PointMotion
    from ...robot.linear_range import LinearRange
    from ...robot.linearized import LinearizedRobot
    from ...robot.robot import Robot
    from ...robot.statics import Posture
    from ...robot.switching import RobotSwitch


@dataclass(frozen=True)
class RobotScene:
    """A robot in its posture, as a system in small deviations from it."""

    data: RobotData  # content of its file
    # of the models' floor; the system knows inputs and outputs by name
    robot: Robot
    posture: Posture
    system: LinearizedRobot
    inputs: Mapping[str, str | PointMotion]  # the joint or PointMotion of each input, by its name
    forces: Mapping[str | PointMotion, float] = field(default_factory=dict)  # constant forces, as in ``Robot.equilibrium``

    @property
    def coordinates(self) -> Coordinates:
        """Names and units of the deviations."""
        names = tuple(self.system.names)
        return Coordinates(names, tuple(self.system.units[name] for name in names))

    @property
    def outputs(self) -> Coordinates:
        """Names and units of the outputs."""
        return Coordinates(tuple(self.system.outputs), tuple(self.system.output_units.values()))


@dataclass(frozen=True, eq=False)
class RobotEquations(Equations):
    """The equations of a robot in small deviations from its posture."""

    robot_scene: RobotScene = None

    @property
    def outputs(self) -> Coordinates | None:
        outputs = self.robot_scene.outputs
        return outputs if outputs.names else None

    @property
    def has_connections(self) -> bool:  # type: ignore[override]
        return bool(self.robot.loops or self.robot.springs) and self.switching is None

    def output_values(self, times: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
        return self.robot_scene.system.output_matrix @ coordinates

    def output_closed_form(self, motion: Any) -> BohlFunction:
        return motion.function.mapped(self.robot_scene.system.output_matrix)

    def linear_range(self, motion: Any, times: np.ndarray) -> LinearRange | None:
        return self.robot_scene.system.linear_range(motion, times)

    @property
    def facts(self) -> tuple[tuple[str, str], ...]:  # type: ignore[override]
        return (robot_fact(self.robot_scene),)

    @property
    def robot(self) -> Robot:  # type: ignore[override]
        return self.robot_scene.robot

    @property
    def posture(self) -> Posture:  # type: ignore[override]
        return self.robot_scene.posture

    @property
    def mesh_notices(self) -> tuple[Notice, ...]:  # type: ignore[override]
        return self.robot.mesh_notices()

    def notices(self, result: Any) -> tuple[Notice, ...]:
        ends = result.extrema("displacement")
        limits = limit_notices(self.robot_scene, np.column_stack([ends.minimum, ends.maximum]))
        if self.switching is not None:
            return (*self.robot_scene.system.range_notices(result.motion), *limits)
        return (*(result.linear_range.notices if result.linear_range else ()), *limits, *_forces_notices(result))

    def tables(self, result: Any) -> ModelTables:
        posture, motion, evidence = self.posture, result.linear_range, []
        if motion:
            evidence.append(
                ("equilibrium: residual", f"{posture.residual:.2g}", "largest unbalanced force relative to the largest force")
            )
            if posture.balance.load.has_rows:
                evidence.append(("equilibrium: loops", f"{posture.loop_error:.2g}", "largest gap of a loop, in m or rad"))
            meaning = "force that the linear motion leaves in the nonlinear equations, relative to its own forces"
            reached = f"; {motion.limit_text}" if motion.limit_text else ""
            evidence.append(("linear motion: residual", f"{motion.deviation:.2g}", f"{meaning}{reached}"))
        return ModelTables((), [_extremes_table(result)], posture_tables(self.robot_scene), evidence)

    def to_dict(self, result: Any) -> dict:
        return posture_json(self.robot_scene) | {"forces": _extremes(result)}

    @property
    def unit_texts(self) -> int:  # type: ignore[override]
        return self.robot_scene.data.unit_texts

    def rows_decision(self, removed: int | None = None, none: str = "") -> Decision:
        removed = len(self.posture.balance.load.row_names) - len(self.system.rows)
        return super().rows_decision(removed, "the robot has no loops: no rows are built")

    def outputs_decision(self, plots: Sequence[str]) -> Decision:
        if self.outputs is None:
            return super().outputs_decision(plots)
        requested = "output" in plots
        return requested, "of the links, from the deviations of the joints" if requested else "output is not among the plots"

    def connections_decision(self, requested: bool) -> Decision:
        if self.switching is not None:
            return False, "reactions are those of the phases"
        if not self.has_connections:
            return super().connections_decision(requested)
        if requested:
            return True, "requested in [output]"
        feet = any(getattr(item, "friction", None) is not None for item in (*self.robot.loops, *self.robot.springs))
        return feet, "friction and lift-off of feet are checked" if feet else "not requested in [output]"

    def without_formula(self, modal_damping: bool) -> str:
        return "a robot"


def robot_scene(model, changed: dict, folder: Path, file_name: SceneName, lap: Callable[[str], object]) -> RobotScene:
    """Read the robot, find its equilibrium and linearize it there."""
    path = robot_path(model.robot, folder)
    data = robot_data(path, changed, robot_name(file_name, f"{path.absolute().parent.name}/{path.name}"))
    with at(file_name, "model"):
        data = data.with_locked(joint_values(model.locked, data.names, PLACE))
        arguments = _posture_arguments(data, posing(model, data.names, data.table.base, data.semantics))
    robot = robot_of(data)
    lap("robot model (pinocchio)")
    with at(file_name, "model"):
        posture = robot.equilibrium(**arguments)
    lap("equilibrium")
    inputs, outputs = (_motions(getattr(model, key), data, f"model.{key}", file_name) for key in ("input", "output"))
    with at(file_name, "model"):
        system = robot.linearize(posture, level=model.level, inputs=inputs, outputs=outputs)
    return RobotScene(data, robot, posture, system, inputs, arguments["forces"])


def robot_switches(model, data: RobotData, file_name: str) -> list[RobotSwitch]:
    """Joint stops, contacts, feet that lift off, loops that close or open, of the tables of a scene."""
    from ...robot.connections import Loop
    from ...robot.switching import ClosingLoop, JointStop, LiftingFoot, PointContact

    def closing(entry) -> ClosingLoop:
        own = {key: getattr(entry, key) for key in ("at", "gap", "released")}
        return ClosingLoop(Loop(**{"point1": None, "point2": None, **given(entry, *own)}), **own)

    kinds: dict[str, Callable] = {
        "joint_stop": lambda entry: JointStop(**given(entry)),
        "contact": lambda entry: PointContact(**given(entry)),
        "lifting_foot": lambda entry: LiftingFoot(**given(entry)),
        "closing_loop": closing,
        "release": lambda entry: ClosingLoop(entry.target, released=entry.at),
    }
    switches = []
    for key, kind_of_switch in kinds.items():
        for number, entry in enumerate(getattr(model, key), 1):
            with at(file_name, f"model.{key}[{number}]"):
                if key == "joint_stop":
                    data.names.joint_unit(entry.joint)
                for body in {"body", "other", "body1", "body2"} & set(type(entry).model_fields):
                    data.names.check_body(getattr(entry, body), GROUND)
                switches.append(kind_of_switch(entry))
    return switches


def _posture_arguments(data: RobotData, own: dict) -> dict:
    """The posture of the robot's file, with the changes of the scene."""
    posture = data.posture
    merged = {key: {**posture[key], **own[key]} for key in ("guess", "forces")}
    return data.unlocked({**merged, "hold": own.get("hold", posture["hold"])})


def _motions(entries, data: RobotData, key: str, file_name: str) -> dict:
    """Joint names and PointMotions by name."""
    motions = {}
    for number, entry in enumerate(entries, 1):
        with at(file_name, f"{key}[{number}] (of {shown(entry.name)})"):
            if entry.name in motions:
                raise InputError("this name is used twice; names must differ")
            if entry.joint is not None:
                data.names.joint_unit(entry.joint)
            motions[entry.name] = point_motion(entry, data.names) if entry.joint is None else entry.joint
    return motions


# Reports: the posture.

#: Loop forces below this share of the largest, and places and torques below this share of 1 in SI, are rounding and printed as 0.
ROUNDING = 1e-12


def posture_tables(robot_scene: RobotScene) -> list[TextTable]:
    return [_joint_table(robot_scene), _force_table(robot_scene)]


def robot_fact(robot_scene: RobotScene) -> tuple[str, str]:
    data = robot_scene.data
    return "robot", "; ".join(filter(None, [data.title or data.name, data.source, data.licence and f"licence {data.licence}"]))


def posture_json(robot_scene: RobotScene) -> dict:
    data, posture = robot_scene.data, robot_scene.posture
    return {
        "robot": {"name": data.name, "title": data.title, "source": data.source, "licence": data.licence},
        "posture": {
            "joints": {name: list(value) if isinstance(value, tuple) else value for name, value in posture.joints.items()},
            "torques": dict(posture.torques),
            "reactions": {name: value.tolist() for name, value in posture.reactions.items()},
            "ground_reactions": {name: value.tolist() for name, value in posture.ground_reactions.items()},
            "residual": posture.residual,
            "loop_error": posture.loop_error,
        },
    }


def _joint_table(robot_scene: RobotScene) -> TextTable:
    torques = dict(zip(robot_scene.posture.torques, _cleaned(robot_scene.posture.torques.values())))
    robot = robot_scene.robot
    units, tangent = dict(zip(robot.coordinates, robot.units)), robot.tangent
    columns = ("joint", "rests at", "with load") if torques else ("joint", "rests at")
    rows = []
    for name, value in robot_scene.posture.joints.items():
        own = [one for one in tangent.coordinates_of(name) if one in torques]
        acting = [one for one in own if torques[one]] or own[:1]
        loads = [f"{one[len(name) :]} {with_unit(torques[one], force_unit(units[one]))}".strip() for one in acting]
        rows.append((name, _place(value, [units[one] for one in tangent.coordinates_of(name)]), ", ".join(loads))[: len(columns)])
    return TextTable("Posture", columns, tuple(rows))


def _place(value, units: Sequence[str]) -> str:
    """The position of a joint: displacements, then an angle, several, or a quaternion as roll, pitch and yaw."""
    values, moving = np.atleast_1d(value).tolist(), units.count("m")
    if len(values) == 1:
        return _single(values[0], units[0] if units else "")
    moved, turned = _cleaned(values[:moving]), values[moving:]
    texts = [f"{_vector(moved)} m"] if moving else []
    if len(turned) == 1:
        texts.append(_single(turned[0], "rad"))
    elif len(turned) == 4:
        texts.append(f"roll, pitch, yaw {_vector(_cleaned(_angles(turned)))} rad")
    elif turned:
        texts.append(f"{_vector(_cleaned(turned))} rad")
    return ", ".join(texts)


def _single(value: float, unit: str) -> str:
    (value,) = _cleaned([value])
    return f"{with_unit(value, unit)} ({degrees(value):.4g}°)" if unit == "rad" else with_unit(value, unit)


def _angles(quaternion) -> tuple[float, float, float]:
    """Roll, pitch and yaw of a unit quaternion x, y, z, w, as a URDF writes rotations."""
    x, y, z, w = quaternion
    pitch = asin(max(-1.0, min(1.0, 2 * (w * y - x * z))))
    return atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), pitch, atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def _cleaned(values) -> list[float]:
    """Positions or torques, with rounding errors set to 0."""
    largest = max([1.0, *map(abs, values)])
    return [value if abs(value) > ROUNDING * largest else 0.0 for value in values]


def _force_table(robot_scene: RobotScene) -> TextTable:
    """Forces of loops, springs and bushings in the frames on their first bodies, and along the axes of the ground where these differ."""
    posture, robot = robot_scene.posture, robot_scene.robot
    items = (*robot.loops, *robot.springs)
    forces = np.array([[values[item.name] for item in items] for values in (posture.reactions, posture.ground_reactions)])
    forces = forces.reshape(2, -1, 6)
    rounding = ROUNDING * np.abs(forces).max(initial=0.0)
    own, ground = np.where(np.abs(forces) > rounding, forces, 0.0)
    rows = [(item.name, item.body2, *_wrench(item, own[i]), *_wrench(item, ground[i])) for i, item in enumerate(items)]
    columns = ("loop or spring", "on", "force", "torque", "force, axes of the ground", "torque, axes of the ground")
    same = np.abs(own - ground).max(initial=0.0) <= rounding
    left_out = {3, 5} if not any(item.turning for item in items) else set()
    shown = sorted({0, 1, 2, 3, *(() if same else (4, 5))} - left_out)
    axes = "x, y, z of the ground" if same else "x, y, z of its frame on the first body, then of the ground"
    note = f"{axes}; forces during the motion come on top."
    return TextTable(
        "Forces of loops and springs at rest",
        tuple(columns[i] for i in shown),
        tuple(tuple(row[i] for i in shown) for row in rows),
        note,
    )


def _wrench(connection: Connection, value: np.ndarray) -> tuple[str, str]:
    return f"{_vector(value[:3])} N", f"{_vector(value[3:])} N m" if connection.turning else ""


def _vector(values) -> str:
    return f"({', '.join(number_text(value) for value in values)})"


#: A motion passes a limit by this share of the range of its joint: a joint that rests at its limit may tremble.
LIMIT_SHARE = 1e-3


def limit_notices(robot_scene: RobotScene, ends: np.ndarray) -> list[Notice]:
    """A notice on joints that exceed their limits during the motion."""
    lowest, highest = ends[: len(robot_scene.robot.coordinates)].T
    robot, furthest = robot_scene.robot, {}
    rests = robot.tangent.angles(robot_scene.posture.configuration)
    for name, (low, high) in robot.limits.items():
        place = robot.coordinates.index(name)
        rest = float(rests[place])
        reached = float(rest + lowest[place]), float(rest + highest[place])
        beyond = not low - JOINT_LIMIT <= rest <= high + JOINT_LIMIT  # which the posture reports
        furthest[name] = low if beyond else max(reached, key=lambda value: max(low - value, value - high))
    outside = robot.tangent.outside_limits(furthest, JOINT_LIMIT, LIMIT_SHARE)
    text = f"during the motion {outside}; the equations have no limits"
    return [Notice(NoticeKind.LARGE_MOTION, text)] if outside else []


# Reports: forces of loops, springs and bushings during the motion, and feet that leave the ground.


def _extremes(result: Any) -> dict:
    """Extremes of the forces of loops, springs and bushings during the run (N, s); empty where they are not computed.

    For a foot with friction also those of the normal force and the largest tangential force.
    """
    if not result.watches_connections:
        return {}
    from ...robot.connections import Support

    forces, at = result.scene.equations.robot_scene.system.connection_forces, result.functions("ground_reaction")
    feet = {one.name: one for one in forces.connections if isinstance(one, Support) and one.friction is not None}

    def sizes(times: np.ndarray) -> np.ndarray:
        """Magnitude of each force, and for a foot the normal and the tangential part."""
        rows, values = [], at(times)
        for connection in forces.connections:
            force = values[forces.places[connection.name]][:3]
            foot = feet.get(connection.name)
            rows += [np.linalg.norm(force, axis=0), *(foot.parts(foot.on_foot(force)) if foot else ())]
        return np.array(rows)

    extrema = result.sampled_extrema(sizes)
    extremes, row = {}, 0
    for connection in forces.connections:
        largest, time = float(extrema.maximum[row]), float(extrema.maximum_time[row])
        extremes[connection.name] = {"on": connection.body2, "largest": largest, "time": time}
        if connection.name in feet:
            ends = [float(extrema.minimum[row + 1]), float(extrema.maximum[row + 1])]
            extremes[connection.name] |= {"normal": ends, "tangential": float(extrema.maximum[row + 2])}
        row += 3 if connection.name in feet else 1
    return extremes


def _extremes_table(result: Any) -> TextTable:
    extremes = _extremes(result)
    rounding, rows = ROUNDING * max((one["largest"] for one in extremes.values()), default=0.0), []
    for name, one in extremes.items():
        sizes = [one["largest"], *one.get("normal", ()), *([one["tangential"]] if "normal" in one else [])]
        largest, *of_foot = [f"{size if abs(size) > rounding else 0.0:.4g}" for size in sizes]
        ends, along = (f"{of_foot[0]} ... {of_foot[1]} N", f"{of_foot[2]} N") if of_foot else ("", "")
        rows.append((name, one["on"], f"{largest} N", f"{one['time']:.4g} s", ends, along))
    has_feet = any("normal" in one for one in extremes.values())
    columns = ("loop or spring", "on", "largest force", "at", "normal force", "tangential force")
    count = len(columns) if has_feet else 4
    note = "During the run, loads at rest included, to first order in the motion"
    note += "; a normal force is positive where the foot presses, a tangential one is the largest." if has_feet else "."
    return TextTable("Forces during the motion", columns[:count], tuple(row[:count] for row in rows), note + _open_shares(result))


def _open_shares(result: Any) -> str:
    """A sentence on redundant rows of loops; empty without them."""
    from ...robot.posture_search import implied_rows

    posture = result.scene.equations.posture
    names = implied_rows(posture.balance, posture.independent_rows)
    if not names:
        return ""
    has = "has" if len(names) == 1 else "have"
    return f" It is open how connections share the changes of forces: here {listed(names)} {has} no part in them."


def _forces_notices(result: Any) -> tuple[Notice, ...]:
    """Notices on feet that lift off, slip or tip over during the motion, at the times of the closed form."""
    from ...robot.connections import Support
    from ...robot.linearized import foot_limits, foot_notices

    forces, posture = result.scene.equations.robot_scene.system.connection_forces, result.scene.equations.posture
    feet = [one.name for one in forces.connections if isinstance(one, Support) and one.friction is not None]
    if not feet:
        return ()
    error = max(result.error_estimates.get(part, 0.0) for part in ("displacement", "velocity", "reaction"))
    drawn, at = result.drawn_functions("ground_reaction"), result.functions("ground_reaction")
    places = [forces.places[name] for name in feet]

    def norms(times: np.ndarray) -> np.ndarray:
        values = drawn(times)
        return np.linalg.norm([values[rows][:3] for rows in places], axis=1)

    largest = result.sampled_extrema(norms)

    def outside(times: np.ndarray, clearly: float = 2.0) -> np.ndarray:
        """Excess of feet over a multiple of the tolerances, by foot and limit: notices lie between this and its half."""
        sizes = dict(zip(feet, clearly * largest.maximum))
        return foot_limits(posture, forces, drawn(times), sizes, error).reshape(len(feet), -1, len(times))

    lifting = result.positive_times(lambda times: outside(times, 0.5)[:, 0])[1][:, None, None]

    def before(times: np.ndarray) -> np.ndarray:
        """Slipping and tipping of a foot, until it lifts off."""
        limits = outside(times)
        return np.concatenate([limits[:, :1], np.where(times < lifting, limits[:, 1:], -1.0)], axis=1).reshape(-1, len(times))

    further = np.concatenate([largest.maximum_time, *result.positive_times(before)])
    times = np.union1d(result.times, further[np.isfinite(further)])
    reactions = dict(zip((row.name for row in result.system.rows), result.motion.reaction(times)))
    return tuple(foot_notices(posture, forces, times, at(times), reactions, error))
