"""Robots from files: a folder with robot.toml and its URDF, read as data; the names in the URDF are known before it is loaded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ...ground.errors import InputError, shown
from ...ground.quantities import count_texts
from ..file.includes import ROBOT_FILE, robot_tables
from ..file.messages import at
from ..file.reading import inside
from ..schema.validation import validated
from .robot_values import PLACE, UrdfNames, joint_values, names_of_urdf, posing, robot_arguments

if TYPE_CHECKING:
    from ...robot.description.srdf import SemanticDescription
    from ...robot.robot import Robot
    from ..schema.robot_tables import RobotFile


@dataclass(frozen=True)
class RobotData:
    """The validated content of a robot.toml.

    Attributes:
        path: the robot.toml.
        table: its content.
        names: names of the links and joints in its URDF.
        semantics: the states of its SRDF or MJCF.
        package_dirs: folders in which package://NAME/... is looked up.
        locks: joints that the files name as locked, with their values in SI.
        locked: values of the locked joints and of those that follow them.
        unit_texts: number of quantities written with a unit.
        place: the file in messages.
    """

    path: Path
    table: RobotFile
    names: UrdfNames
    semantics: SemanticDescription
    package_dirs: tuple[Path, ...]
    locks: dict[str, float] = field(default_factory=dict)
    locked: dict[str, float] = field(default_factory=dict)
    unit_texts: int = 0
    place: str = ""
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
        """Source of the robot."""
        return self.table.source

    @property
    def licence(self) -> str:
        """Licence of the robot."""
        return self.table.licence

    def with_locked(self, locks: Mapping[str, float]) -> RobotData:
        """The data with more joints locked.

        Raises:
            InputError: a joint follows another, which moves.
        """
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
    path = Path(path) / ROBOT_FILE if Path(path).is_dir() else Path(path)
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
    """The robot of validated data."""
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
    from ...robot.description.srdf import SemanticDescription, read_srdf

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
