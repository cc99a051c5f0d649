"""Robots from files: a folder with robot.toml and the URDF that it names. Nothing in them is ever executed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError
from .files import inside
from .problems import at, validated
from .reading import FileKind, parse, read_text
from .robot_urdf import UrdfNames, in_urdf, names_of_urdf
from .robot_values import (
    DAMPING,
    FORCE,
    PLACE,
    STIFFNESS,
    body_forces,
    connection,
    flexible_joint,
    guess_values,
    held,
    joint_values,
    of,
)
from .units import count_texts, shown

if TYPE_CHECKING:
    from ..models.robot import Robot
    from .robot_tables import RobotFile

ROBOT_FILE = "robot.toml"
_KIND = FileKind("a robot.toml has at least urdf, source and licence", "which is no robot.toml; meshes lie in files of their own")


@dataclass(frozen=True)
class RobotData:
    """What stands in a robot.toml, checked.

    Attributes:
        path: the robot.toml.
        table: its content.
        names: of the links and joints in its URDF.
        package_dirs: folders in which package://NAME/... is looked up.
        locks: joints that the files name as locked, with their values in SI.
        locked: the same with those that follow them.
        unit_texts: how many quantities were written with a unit.
    """

    path: Path
    table: RobotFile
    names: UrdfNames
    package_dirs: tuple[Path, ...]
    locks: dict[str, float] = field(default_factory=dict)
    locked: dict[str, float] = field(default_factory=dict)
    unit_texts: int = 0
    _posture: dict = field(default_factory=dict, repr=False)

    @property
    def name(self) -> str:
        """The name of the folder."""
        return self.path.absolute().parent.name

    @property
    def title(self) -> str:
        """What the robot is; the name of the folder where the file does not say."""
        return self.table.title or self.name

    @property
    def source(self) -> str:
        """Where the robot comes from."""
        return self.table.source

    @property
    def licence(self) -> str:
        """Its licence."""
        return self.table.licence

    def with_locked(self, locks: Mapping[str, float]) -> RobotData:
        """The same with more joints frozen.

        Raises:
            InputError: a joint follows another, which moves.
        """
        from ..models.robot.coupling import locked_values

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
    def place(self) -> str:
        """The file in messages."""
        return f"{self.name}/{self.path.name}"

    @property
    def urdf_place(self) -> str:
        """The URDF in messages."""
        return f"{self.name}/{self.names.path.name}"

    def check_meshes(self) -> None:
        """See that the meshes that are to be drawn are there; they are not opened.

        Raises:
            SceneError: one is missing, or lies elsewhere than it may; names its link.
        """
        from ..models.robot.visuals import mesh_file

        with in_urdf(self.urdf_place):
            for link, mesh in self.names.meshes:
                mesh_file(mesh, f"mesh of link {shown(link)}", self.names.path.parent, self.package_dirs)


def read_robot(path: str | Path, *, package_dirs: Sequence[str | Path] = (), locked: Mapping[str, float] | None = None):
    """A robot and what its file says of it.

    Args:
        path: a folder with a robot.toml, or the robot.toml.
        package_dirs: folders in which the meshes named package://NAME/... are looked up, beside those of the file.
        locked: joints to be frozen at a value (rad or m), beside those of the file.

    Returns:
        The ``Robot``, and ``RobotData`` with title, source, licence and the posture it is meant to stand in:
        ``robot.equilibrium(**data.posture)``.

    Raises:
        SceneError: a file that cannot be read, or something in it that is wrong; the text names file, place, what was
            found and what was expected.
    """
    data = robot_data(Path(path), package_dirs)
    with at(data.place, "the robot"):
        data = data.with_locked(locked or {})
    return robot_of(data), data


def robot_data(path: Path, package_dirs: Sequence[str | Path] = ()) -> RobotData:
    """Read and check a robot.toml and the names in its URDF; pinocchio is not needed for it.

    Raises:
        SceneError: as ``read_robot``.
    """
    from .robot_tables import RobotFile

    path = path / ROBOT_FILE if path.is_dir() else path
    place = f"{path.absolute().parent.name}/{path.name}"
    found = parse(read_text(path, _KIND), place)
    table = validated(found, place, RobotFile)
    folder = path.parent.resolve()
    with at(place, "urdf"):
        urdf = inside(folder, table.urdf, "the URDF must lie in the robot's folder", 'the name of a file, e.g. "robot.urdf"')
    with in_urdf(f"{folder.name}/{urdf.name}"):
        names = names_of_urdf(urdf)
    dirs = (*_package_dirs(table.package_dirs, folder, place), *(Path(place).resolve() for place in package_dirs))
    texts = count_texts({key: value for key, value in found.items() if key not in ("title", "source", "licence", "urdf")})
    with at(place, "locked"):
        locked = joint_values(table.locked, names, PLACE)
    with at(place, "posture"):
        posture = posing(table.posture, names, table.base == "free")
    with at(place, "the robot"):
        return RobotData(path, table, names, dirs, unit_texts=texts, _posture=posture).with_locked(locked)


def robot_of(data: RobotData) -> Robot:
    """The robot of checked data.

    Raises:
        SceneError: something that only shows when its parts come together.
    """
    from ..models.robot import Robot

    values = _values(data)
    for key in ("joint_stiffness", "joint_rest", "joint_damping", "flexible_joints"):
        values[key] = {name: value for name, value in values[key].items() if name not in data.locked}
    with at(data.place, "the robot"):
        return Robot(data.names.path, package_dirs=data.package_dirs, name=data.name, locked=data.locked, **values)


def posing(table, names: UrdfNames, free_base: bool) -> dict:
    """guess, forces and hold of a robot.toml or a scene, as far as they are given, in SI."""
    found = {}
    with of("guess"):
        found["guess"] = guess_values(table.guess, names, free_base)
    with of("forces"):
        found["forces"] = joint_values(table.forces, names, FORCE)
    found["forces"] |= body_forces(table.body_force, names)
    if "hold" in table.model_fields_set:
        with of("hold"):
            found["hold"] = held(table.hold, names)
    return found


def _package_dirs(dirs: Sequence[str], folder: Path, place: str) -> list[Path]:
    found = []
    for name in dirs:
        with at(place, "package_dirs"):
            if Path(name).is_absolute() or not name.isprintable() or not (folder / name).is_dir():
                raise InputError(f"found {shown(name)}; expected a folder, relative to the robot's")
            found.append((folder / name).resolve())
    return found


def _values(data: RobotData) -> dict:
    """The arguments of Robot."""
    from ..models.robot import BodySpring, Bushing, Loop

    table, names, place = data.table, data.names, data.place
    values = {"base": table.base, "gravity": tuple(table.gravity) if isinstance(table.gravity, list) else table.gravity}
    units = {"joint_stiffness": STIFFNESS, "joint_rest": PLACE, "joint_damping": DAMPING}
    for key, unit in units.items():
        with at(place, key):
            values[key] = joint_values(getattr(table, key), names, unit)
    values["flexible_joints"] = {}
    for name, entry in table.flexible_joints.items():
        with at(place, f"flexible_joints.{name}"):
            values["flexible_joints"][name] = flexible_joint(name, entry, names)
    values["loops"] = _connections(Loop, table.loop, "loop", names, place)
    springs = _connections(BodySpring, table.spring, "spring", names, place)
    values["springs"] = (*springs, *_connections(Bushing, table.bushing, "bushing", names, place))
    return values


def _connections(kind: type, entries, key: str, names: UrdfNames, place: str) -> tuple:
    found = []
    for number, entry in enumerate(entries, 1):
        with at(place, f"{key}[{number}]" + (f" (of {shown(entry.name)})" if entry.name else "")):
            found.append(connection(kind, entry, names))
    return tuple(found)
