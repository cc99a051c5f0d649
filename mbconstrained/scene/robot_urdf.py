"""What a scene needs to know of a URDF before it is loaded: names, units, and where its meshes lie."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..checks import nearest
from ..errors import InputError, SceneError
from .units import shown

if TYPE_CHECKING:
    from ..models.robot.urdf import Mimic

JOINT_UNITS = {"revolute": "rad", "continuous": "rad", "prismatic": "m"}


@dataclass(frozen=True)
class UrdfNames:
    """What a URDF names.

    Attributes:
        path: the file.
        links: their names.
        units: of the joints with one degree of freedom, "rad" or "m", by name.
        mimics: joints that follow others.
        meshes: file names of the meshes that are drawn, as they stand in the URDF, each with its link.
    """

    path: Path
    links: tuple[str, ...]
    units: dict[str, str]
    mimics: tuple[Mimic, ...]
    meshes: tuple[tuple[str, str], ...]

    def joint_unit(self, name: str) -> str:
        """The unit of a joint.

        Raises:
            InputError: no such joint.
        """
        if name not in self.units:
            raise InputError(f"there is no joint {shown(name)}{nearest(name, self.units)}; the joints are {_some(self.units)}")
        return self.units[name]

    def check_body(self, name: str, *others: str) -> None:
        """Raise an InputError where there is no such link."""
        if name not in (*self.links, *others):
            known = (*others, *self.links)
            raise InputError(f"there is no body {shown(name)}{nearest(name, known)}; the bodies are {_some(known)}")


@contextmanager
def in_urdf(place: str) -> Iterator[None]:
    """Put the place of the URDF in front of what is said about it."""
    try:
        yield
    except SceneError:
        raise
    except InputError as problem:
        raise SceneError(f"{place}: {problem}") from None


def names_of_urdf(path: Path) -> UrdfNames:
    """Look through a URDF. Collision geometry is not looked at.

    Raises:
        InputError: it cannot be read, is too large, or is no URDF.
    """
    from ..models.robot.urdf import checked_tree, mimics_of, read_urdf

    if not path.is_file():
        others = [other.name for other in path.parent.glob("*.urdf")] if path.parent.is_dir() else []
        raise InputError(f"there is no file {shown(path.name)}{nearest(path.name, others)}")
    text, _ = read_urdf(path)
    root = checked_tree(text)
    units = {joint.get("name").strip(): JOINT_UNITS.get(joint.get("type")) for joint in root.findall("joint")}
    links = {link.get("name").strip(): link for link in root.findall("link")}
    meshes = ((name, mesh.get("filename", "")) for name, link in links.items() for mesh in link.findall("visual/geometry/mesh"))
    return UrdfNames(path, tuple(links), {name: unit for name, unit in units.items() if unit}, mimics_of(root), tuple(meshes))


def _some(names) -> str:
    names = list(names)
    return ", ".join(names[:12]) + (f" and {len(names) - 12} more" if len(names) > 12 else "")
