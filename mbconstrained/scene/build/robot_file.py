"""Robots from files: a folder with robot.toml and its URDF, read as data; the names in the URDF, their values and units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ...ground.by_name import answering
from ...ground.checks import listed, nearest
from ...ground.errors import InputError, named, shown
from ...ground.files import path_of
from ...ground.quantities import count_texts, quantity
from ...ground.units import GROUND
from ..file import ROBOT_FILE, EntryError, at, inside, robot_tables
from ..schema.entry_types import validated

if TYPE_CHECKING:
    from ...robot.description.urdf import Mimic, SemanticDescription
    from ...robot.robot import Robot
    from ..schema.robot_tables import RobotFile

STIFFNESS = {"rad": "N*m/rad", "m": "N/m"}
DAMPING = {"rad": "N*m*s/rad", "m": "N*s/m"}
FORCE = {"rad": "N*m", "m": "N"}
INERTIA = {"rad": "kg*m^2", "m": "kg"}
PLACE = {"rad": "rad", "m": "m"}
BASE = "base"
POSE_UNITS = ("m", "m", "m", "rad", "rad", "rad")

#: Joints or bodies that a message lists.
MOST_NAMES = 12


COORDINATE_UNITS = {
    "planar": {"x": "m", "y": "m", "rz": "rad"},
    "floating": dict.fromkeys("xyz", "m") | {f"r{axis}": "rad" for axis in "xyz"},
    "ball": {f"r{axis}": "rad" for axis in "xyz"},
}
JOINT_UNITS = {"revolute": "rad", "continuous": "rad", "prismatic": "m"}


@dataclass(frozen=True)
class UrdfNames:
    """Names in a URDF."""

    path: Path  # the file
    links: tuple[str, ...]  # names of the links
    units: dict[str, str]  # units of the joints with one degree of freedom and of the coordinates of others, "rad" or "m", by name
    mimics: tuple[Mimic, ...]  # joints that follow others
    meshes: tuple[tuple[str, str], ...]  # file names of the meshes that are drawn, as they stand in the URDF, each with its link
    # the coordinates of joints with several degrees of freedom, by joint
    several: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    states: Mapping[str, dict] = field(default_factory=dict)  # values by joint, by name of a key frame of an MJCF file
    has_free_joint: bool = False  # whether the base of an MJCF or SDF file is free by itself

    def joint_unit(self, name: str) -> str:
        if name not in self.units:
            raise InputError(
                f"there is no joint {shown(name)}{nearest(name, self.units)}; the joints are {listed([*self.units], MOST_NAMES)}"
            )
        return self.units[name]

    def check_body(self, name: str, *others: str) -> None:
        """Refuse a name that is neither that of a link nor one of the others."""
        if name not in (*self.links, *others):
            known = (*others, *self.links)
            raise InputError(f"there is no body {shown(name)}{nearest(name, known)}; the bodies are {listed(known, MOST_NAMES)}")


def names_of_urdf(path: Path, base: str = "fixed", package_dirs: Sequence[Path] = ()) -> UrdfNames:
    """Names in a URDF, an SDF, or an MJCF file, which MuJoCo compiles; collision geometry is ignored."""
    from ...robot.description.sdf import read_description
    from ...robot.description.urdf import HIDDEN, has_free_base, mimics_of
    from ...robot.tangent import Tangent

    if not path.is_file():
        others = [other.name for other in path.parent.glob("*.urdf")] if path.parent.is_dir() else []
        raise InputError(f"there is no file {shown(path.name)}{nearest(path.name, others)}")
    free_base = base != "fixed"
    source = read_description(path, base, tuple(package_dirs))
    model, root = source.model, source.description
    has_free_joint = (
        has_free_base(model) if model is not None else root.find(f"joint[@name='{BASE}'][@type='floating']") is not None
    )
    units = {joint.get("name").strip(): JOINT_UNITS.get(joint.get("type")) for joint in root.findall("joint")}
    own_units = [(joint.get("name").strip(), COORDINATE_UNITS.get(joint.get("type"), {})) for joint in root.findall("joint")]
    coordinates = {}
    for name, own in (*own_units, *([(BASE, COORDINATE_UNITS["floating"])] if free_base or has_free_joint else [])):
        units |= {f"{name} {suffix}": unit for suffix, unit in own.items()}
        coordinates[name] = tuple(f"{name} {suffix}" for suffix in own)
    links = {link.get("name").strip(): link for link in root.findall("link") if not link.get("name").startswith(HIDDEN)}
    meshes = ((name, mesh.get("filename", "")) for name, link in links.items() for mesh in link.findall("visual/geometry/mesh"))
    known = {name: unit for name, unit in units.items() if unit}
    several = {name: own for name, own in coordinates.items() if own}
    states = {} if model is None else source.named_states(Tangent(model, free_base or has_free_joint))
    return UrdfNames(path, tuple(links), known, mimics_of(root), tuple(meshes), several, states, has_free_joint)


def joint_values(values: Mapping, names: UrdfNames, units: Mapping[str, str]) -> dict[str, float]:
    by_name = {}
    for name, value in values.items():
        unit = names.joint_unit(name)
        try:
            by_name[name] = quantity(value, units[unit])
        except InputError as problem:
            raise EntryError(f"{name}: {problem}", name) from None
    return by_name


def _pose(value) -> tuple[float, ...]:
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) not in (6, 7):
        raise InputError(f"found {shown(value)}; expected [x, y, z, roll, pitch, yaw], or x, y, z and a quaternion x, y, z, w")
    units = POSE_UNITS if len(value) == 6 else ("m", "m", "m", "1", "1", "1", "1")
    return tuple(quantity(entry, unit) for entry, unit in zip(value, units))


def _triple(value, of_ball: bool) -> tuple[float, ...]:
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 3:
        raise InputError(f"found {shown(value)}; expected {'[roll, pitch, yaw]' if of_ball else '[x, y, angle]'}")
    return tuple(quantity(entry, unit) for entry, unit in zip(value, ("rad" if of_ball else "m",) * 2 + ("rad",)))


def given(entry, *left_out: str) -> dict:
    """The entries of a table as arguments of a function with the same names."""
    values = {key: getattr(entry, key) for key in type(entry).model_fields if key in entry.model_fields_set and key not in left_out}
    return {key: tuple(value) if isinstance(value, list) else value for key, value in values.items() if value is not None}


#: Units of a drive, by that of its joint.
_MOTOR_UNITS = {
    "stiffness": STIFFNESS, "proportional_gain": STIFFNESS, "position_gain": STIFFNESS,
    "damping": DAMPING, "derivative_gain": DAMPING, "velocity_gain": DAMPING, "armature": INERTIA,
}  # fmt: skip


def _drives(kind: type, entries: Mapping, key: str, names: UrdfNames, place: str) -> dict:
    """The FlexibleJoint or Motor of each joint, in its units."""
    drives = {}
    for name, entry in entries.items():
        with at(place, f"{key}.{name}"):
            unit, values = names.joint_unit(name), given(entry)
            for field_name in values.keys() & _MOTOR_UNITS.keys():
                with named(field_name):
                    values[field_name] = quantity(values[field_name], _MOTOR_UNITS[field_name][unit])
            drives[name] = kind(**values)
    return drives


def _gear(kind: type, entry, names: UrdfNames):
    """A JointGear; its ratio has the units of both joints."""
    own, leading = names.joint_unit(entry.joint), names.joint_unit(entry.leader)
    unit = {("m", "rad"): "m/rad", ("rad", "m"): "rad/m"}.get((own, leading), "1")
    with named("ratio"):
        ratio = quantity(entry.ratio, unit)
    with named("offset"):
        return kind(entry.joint, entry.leader, ratio, quantity(entry.offset, own))


def point_motion(entry, names: UrdfNames):
    from ...robot.connections import PointMotion

    names.check_body(entry.body)
    return PointMotion(entry.body, tuple(entry.point), tuple(entry.along), entry.turn)


def _body_forces(entries, names: UrdfNames) -> dict:
    forces = {}
    for number, entry in enumerate(entries, 1):
        with named(f"body_force[{number}]"):
            motion = point_motion(entry, names)
            forces[motion] = forces.get(motion, 0.0) + quantity(entry.value, "N*m" if entry.turn else "N")
    return forces


def _guess(values: Mapping, names: UrdfNames, free_base: bool) -> dict:
    """The values of joints and coordinates; for a joint with several degrees of freedom all at once, as for a free base."""
    several = {name: value for name, value in values.items() if name in names.several and (free_base or name != BASE)}
    guess = joint_values({name: value for name, value in values.items() if name not in several}, names, PLACE)
    for name, value in several.items():
        with named(name):
            of_ball = names.several[name] == tuple(f"{name} {suffix}" for suffix in COORDINATE_UNITS["ball"])
            guess[name] = _pose(value) if len(names.several[name]) == len(POSE_UNITS) else _triple(value, of_ball)
    return guess


def posing(table, names: UrdfNames, base: str, semantics: SemanticDescription) -> dict:
    """The posture that a robot.toml or a scene gives."""
    joints, free_base = (*names.units, *names.several), base == "free" or (base == "fixed" and names.has_free_joint)
    state = {} if table.state is None else semantics.state(table.state, joints, BASE if free_base else None)
    posture: dict = {}
    with named("guess"):
        posture["guess"] = state | _guess(table.guess, names, free_base)
    with named("forces"):
        posture["forces"] = joint_values(table.forces, names, FORCE)
    posture["forces"] |= _body_forces(table.body_force, names)
    if "hold" in table.model_fields_set:
        with named("hold"):
            for name in table.hold if table.hold != "all" else ():
                names.joint_unit(name if name not in names.several else names.several[name][0])
            posture["hold"] = table.hold if table.hold == "all" else tuple(table.hold)
    return posture


def robot_arguments(table, names: UrdfNames, place: str) -> dict:
    """Arguments of the robot from a robot.toml, in addition to its URDF."""
    from ...robot.connections import BodySpring, Bushing, Loop
    from ...robot.description.urdf import Payload
    from ...robot.flexible_joint import FlexibleJoint, Motor
    from ...robot.tangent import JointGear

    values = {"base": table.base, "gravity": tuple(table.gravity) if isinstance(table.gravity, list) else table.gravity}
    units = {"joint_stiffness": STIFFNESS, "joint_rest": PLACE, "joint_damping": DAMPING}
    for key, unit in units.items():
        with at(place, key):
            values[key] = joint_values(getattr(table, key), names, unit)
    for key, kind in (("flexible_joints", FlexibleJoint), ("motors", Motor)):
        values[key] = _drives(kind, getattr(table, key), key, names, place)
    with at(place, "gear"):
        values["gears"] = [_gear(JointGear, entry, names) for entry in table.gear]
    with at(place, "payload"):
        for entry in table.payload:
            names.check_body(entry.body)
        values["payloads"] = [Payload(**given(entry)) for entry in table.payload]
    values |= {"masses": table.masses, "inertias": table.inertias}
    values["loops"] = _connections(Loop, table.loop, "loop", names, place)
    springs = _connections(BodySpring, table.spring, "spring", names, place)
    values["springs"] = (*springs, *_connections(Bushing, table.bushing, "bushing", names, place))
    return values


def _connections(kind: type, entries, key: str, names: UrdfNames, place: str) -> tuple:
    """Loops, springs between bodies or bushings."""
    connections = []
    for number, entry in enumerate(entries, 1):
        with at(place, f"{key}[{number}]" + (f" (of {shown(entry.name)})" if entry.name else "")):
            for end in ("body1", "body2"):
                with named(end):
                    names.check_body(getattr(entry, end), GROUND)
            connections.append(kind(**{"point1": None, "point2": None, **given(entry)}))
    return tuple(connections)


@dataclass(frozen=True)
class RobotData:
    """The validated content of a robot.toml."""

    path: Path  # the robot.toml
    table: RobotFile  # its content
    names: UrdfNames  # names of the links and joints in its URDF
    semantics: SemanticDescription  # the states of its SRDF or MJCF
    package_dirs: tuple[Path, ...]  # folders in which package://NAME/... is looked up
    locks: dict[str, float] = field(default_factory=dict)  # joints that the files name as locked, with their values in SI
    locked: dict[str, float] = field(default_factory=dict)  # values of the locked joints and of those that follow them
    unit_texts: int = 0  # number of quantities written with a unit
    place: str = ""  # the file in messages
    _posture: dict = field(default_factory=dict, repr=False)

    @property
    def name(self) -> str:
        """The name of the folder."""
        return self.path.absolute().parent.name

    @property
    def title(self) -> str:
        """Title of the robot; by default the name of the folder."""
        return self.table.title or self.name

    @property
    def source(self) -> str:
        return self.table.source

    @property
    def licence(self) -> str:
        return self.table.licence

    def with_locked(self, locks: Mapping[str, float]) -> RobotData:
        """The data with more joints locked."""
        from ...robot.tangent import locked_values

        locks = {**self.locks, **locks}
        return replace(self, locks=locks, locked=locked_values(locks, self.names.mimics))

    @property
    def posture(self) -> dict:
        """guess, forces and hold, in SI, without the locked joints: ``robot.equilibrium(**data.posture)``."""
        return self.unlocked(self._posture)

    def unlocked(self, posture: dict) -> dict:
        """A posture without the joints that are locked."""
        guess, forces = ({k: v for k, v in posture[key].items() if k not in self.locked} for key in ("guess", "forces"))
        hold = posture.get("hold", ())
        hold = hold if hold == "all" else tuple(name for name in hold if name not in self.locked)
        return {"guess": guess, "forces": forces, "hold": hold}

    @property
    def urdf_place(self) -> str:
        """The URDF in messages."""
        return f"{self.name}/{self.names.path.name}"


@answering
def read_robot(path: str | Path, *, package_dirs: Sequence[str | Path] = (), locked: Mapping[str, float] | None = None):
    """Read a robot and the content of its file.

    Args:
        path: a folder with a robot.toml, or the robot.toml.
        package_dirs: folders in which the meshes named package://NAME/... are looked up, in addition to those of the file.
        locked: joints to be frozen at a value (rad or m), in addition to those of the file.

    Returns:
        The ``Robot``, and ``RobotData`` with title, source, licence and the posture it is meant to stand in:
        ``robot.equilibrium(**data.posture)``.

    Raises:
        SceneError: a file that cannot be read, or something in it that is wrong; the text names file, place, what was
            found and what was expected.
    """
    path = path_of(path)
    path = path / ROBOT_FILE if path.is_dir() else path
    data = robot_data(path, *robot_tables(path), package_dirs)
    with at(data.place, "the robot"):
        data = data.with_locked(locked or {})
    return robot_of(data), data


def robot_data(path: Path, data: dict, place: str, package_dirs: Sequence[str | Path] = ()) -> RobotData:
    """Validate the tables of a robot.toml and the names in its URDF, without pinocchio."""
    from ..schema.robot_tables import RobotFile

    table = validated(data, place, RobotFile)
    folder = path.parent.resolve()
    with at(place, "urdf"):
        urdf = inside(folder, table.urdf, "the URDF must lie in the robot's folder", 'the name of a file, e.g. "robot.urdf"')
    dirs = (*_package_dirs(table.package_dirs, folder, place), *(Path(place).resolve() for place in package_dirs))
    with at(f"{folder.name}/{urdf.name}"):
        names = names_of_urdf(urdf, table.base, dirs)
    semantics = _semantics(table.srdf, folder, place, names.states)
    texts = count_texts({key: value for key, value in data.items() if key not in ("title", "source", "licence", "urdf")})
    with at(place, "locked"):
        locked = joint_values(table.locked, names, PLACE)
    with at(place, "posture"):
        posture = posing(table.posture, names, table.base, semantics)
    with at(place, "the robot"):
        return RobotData(path, table, names, semantics, dirs, unit_texts=texts, place=place, _posture=posture).with_locked(locked)


def robot_of(data: RobotData) -> Robot:
    from ...robot.robot import Robot

    values = robot_arguments(data.table, data.names, data.place)
    for key in ("joint_stiffness", "joint_rest", "joint_damping", "flexible_joints", "motors"):
        values[key] = {name: value for name, value in values[key].items() if name not in data.locked}
    files = sorted({file for file, _ in getattr(data.place, "origins", {}).values()})
    with at(f"{data.place} with {' and '.join(files)}" if files else data.place, "the robot"):
        srdf = None if data.table.srdf is None else data.path.parent / data.table.srdf
        return Robot(data.names.path, srdf=srdf, package_dirs=data.package_dirs, name=data.name, locked=data.locked, **values)


def _semantics(name: str | None, folder: Path, place: str, states: Mapping[str, dict]) -> SemanticDescription:
    """The content of the SRDF file, if there is one, with states of an MJCF."""
    from ...robot.description.urdf import SemanticDescription, read_srdf

    with at(place, "srdf"):
        if name is None:
            return SemanticDescription(dict(states))
        own = read_srdf(inside(folder, name, "the SRDF must lie in the robot's folder", 'the name of a file, e.g. "robot.srdf"'))
        return SemanticDescription({**states, **own.states}, own.rotors)


def _package_dirs(dirs: Sequence[str], folder: Path, place: str) -> list[Path]:
    folders = []
    for name in dirs:
        with at(place, "package_dirs"):
            if not name.isprintable() or not (folder / name).is_dir():
                raise InputError(f"found {shown(name)}; expected a folder: its path, or one relative to the robot's")
            folders.append((folder / name).resolve())
    return folders
