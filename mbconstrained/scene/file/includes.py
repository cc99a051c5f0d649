"""Scenes that include others: the merged tables of several files, each entry with its file.

Included files come first, in the order in which they are named, the including file last: arrays of tables grow, for everything
else the last value counts. A file included by several others is read once. The robot.toml of a robot comes first of all: the table
[robot] of a scene changes it for this scene.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from ...ground.checks import nearest
from ...ground.errors import InputError, SceneError, shown
from .messages import Place, SceneName, at, written
from .reading import FileKind, parse, read_text

ROBOT_FILE = "robot.toml"
ROBOT_KIND = FileKind("a robot.toml has at least urdf", "which is no robot.toml; meshes lie in files of their own")

MOST_FILES = 20  # that a scene includes, directly or not
DEEPEST_INCLUDE = 5
EXPECTED = 'expected names of scene files, e.g. include = ["materials.toml"]'
INCLUDED = FileKind(
    "leave out its name in include", "which is no scene; keep large matrices in files (.npz, .mat, .mtx, .csv) next to it"
)
BODIES = (("model", "mass"), ("model", "inertia"), ("model", "node"), ("drawing", "body"))
MATRICES = ("mass", "damping", "stiffness", "A", "B", "C", "D", "descriptor")


def read_tables(path: Path) -> tuple[dict, SceneName]:
    """The tables of a scene and of the files that it includes, and its name with the origins of their entries."""
    files = _Files(path)
    files.read(path, ())
    return files.together()


def robot_path(name: str, folder: Path) -> Path:
    """The robot.toml that a scene names."""
    if not name or not name.isprintable() or Path(name).is_absolute():
        raise InputError(f'found {shown(name)}; expected a folder relative to the scene, e.g. "../robots/four_bar"')
    path = folder / name
    if not path.exists():
        raise InputError(f"found {shown(name)}; there is no such folder or file")
    if not path.is_dir() and path.suffix != ".toml":
        raise InputError(f"found {shown(name)}; expected the folder of a robot, or its {ROBOT_FILE}")
    return path / ROBOT_FILE if path.is_dir() else path


def robot_tables(path: Path) -> tuple[dict, str]:
    """The tables of a robot.toml, and its name in messages."""
    place = f"{path.absolute().parent.name}/{path.name}"
    return parse(read_text(path, ROBOT_KIND), place), place


def with_robot_file(data: dict, name: SceneName, folder: Path) -> SceneName:
    """Merge the robot.toml of a scene into its table [robot], in place; entries of the scene take precedence."""
    model, changes = data.get("model"), data.get("robot", {})
    if not isinstance(model, dict) or model.get("kind") != "robot" or not isinstance(model.get("robot"), str):
        return name
    with at(name, "model.robot"):
        path = robot_path(model["robot"], folder)
    if not isinstance(changes, dict):
        with at(name, "robot"):
            raise InputError(f"found {shown(changes)}; expected a table, [robot], with changes of the {ROBOT_FILE}")
    tables, file = robot_tables(path)
    merged: dict = {}
    own: dict[Place, tuple[str, Place]] = {}
    changed: dict[Place, tuple[str, Place]] = {}
    _merge(merged, tables, (), file, own)
    _merge(merged, changes, (), "", changed)
    data["robot"] = merged
    origins = {("robot", *place): origin for place, origin in own.items()}
    origins |= {("robot", *place): name.file_of(("robot", *there)) for place, (_, there) in changed.items()}
    return SceneName(name, {**name.origins, **origins}, name.settings)


def robot_name(name: SceneName, file: str) -> SceneName:
    """The name of a robot.toml whose tables are those merged under [robot]."""
    inside = ((place[1:], origin) for place, origin in name.origins.items() if place[0] == "robot" and len(place) > 1)
    return SceneName(file, {place: origin for place, origin in inside if origin[0] != file})


class _Files:
    """The files of a scene, included ones before those that include them."""

    def __init__(self, path: Path):
        self.folder, self.main = path.parent, path.name
        self.files: dict[Path, tuple[str, dict]] = {}  # by path: the name in messages, and the tables

    def read(self, path: Path, includers: tuple[Path, ...]) -> None:
        """Read a file after the files that it includes."""
        name = self._name(path) if includers else self.main
        data = parse(read_text(path, INCLUDED) if includers else read_text(path), name)
        given = data.pop("include", [])
        with at(name, "include"):
            for other in self._others(path, given, (*includers, path.resolve())):
                self.read(other, (*includers, path.resolve()))
        if includers:
            _lead_from(data, os.path.relpath(path.parent, self.folder))
        self.files[path.resolve()] = name, data

    def together(self) -> tuple[dict, SceneName]:
        """The merged tables of all files."""
        if len(self.files) == 1:
            return next(iter(self.files.values()))[1], SceneName(self.main)
        data: dict = {}
        origins: dict[Place, tuple[str, Place]] = {}
        for file_name, tables in self.files.values():
            _merge(data, tables, (), file_name, origins)
        name = SceneName(self.main, origins)
        _check_bodies(data, name)
        return data, name

    def _name(self, path: Path) -> str:
        return Path(os.path.relpath(path, self.folder)).as_posix()

    def _others(self, path: Path, given, includers: tuple[Path, ...]):
        """The files included by one, except those already read."""
        given = [given] if isinstance(given, str) else given
        if not isinstance(given, list):
            raise InputError(f"found {shown(given)}; {EXPECTED}")
        for entry in given:
            other = _path(path.parent, entry)
            if other.resolve() in includers:
                circle = " → ".join(map(self._name, (*includers[includers.index(other.resolve()) :], other)))
                raise InputError(f"found {shown(entry)}, which leads in a circle: {circle}; leave one of them out")
            if len(includers) > DEEPEST_INCLUDE or len(self.files) >= MOST_FILES:
                raise InputError(
                    f"found {shown(entry)}; expected at most {MOST_FILES} files, included at most {DEEPEST_INCLUDE} deep"
                )
            if other.resolve() not in self.files:
                yield other


def _path(folder: Path, name) -> Path:
    if not isinstance(name, str) or not name.isprintable() or not name.endswith(".toml") or Path(name).is_absolute():
        raise InputError(f"found {shown(name)}; {EXPECTED}, relative to this file")
    path = folder / name
    if not path.is_file():
        known = [other.name for other in path.parent.glob("*.toml")] if path.parent.is_dir() else []
        raise InputError(f"found {shown(name)}, but there is no such file{nearest(path.name, known)}")
    return path


def _lead_from(data: dict, folder: str) -> None:
    """Make the names of data files relative to the scene instead of their own file."""
    model = data.get("model")
    if folder == "." or not isinstance(model, dict):
        return
    for key in ("robot", *MATRICES):
        if isinstance(model.get(key), str) and not model[key].lstrip().startswith("="):
            model[key] = f"{folder}/{model[key]}"
    for table in (*_tables(model.values()), *_tables(_list(data.get("force"))), *_list(model.get("coefficients"))):
        if isinstance(table, dict) and isinstance(table.get("file"), str):
            table["file"] = f"{folder}/{table['file']}"


def _tables(values) -> list[dict]:
    return [value for value in values if isinstance(value, dict)]


def _list(value) -> list:
    return value if isinstance(value, list) else []


def _merge(into: dict, data: dict, place: Place, name: str, origins: dict) -> None:
    for key, value in data.items():
        here, old = (*place, key), into.get(key)
        if isinstance(old, dict) and isinstance(value, dict):
            _merge(old, value, here, name, origins)
        elif _is_array_of_tables(old) and _is_array_of_tables(value):
            for number in range(1, len(value) + 1):
                origins[(*here, len(old) + number)] = (name, (*here, number))
            into[key] = [*old, *value]
        else:
            into[key] = value
            origins[here] = (name, here)


def _is_array_of_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(entry, dict) for entry in value)


def _check_bodies(data: dict, name: SceneName) -> None:
    """Raise an InputError for a body defined in two files."""
    places: dict[tuple[str, str], tuple[str, Place]] = {}
    for table, key in BODIES:
        for number, entry in enumerate(_list(_entry(data.get(table), key)), 1):
            body = _entry(entry, "name")
            if not isinstance(body, str):
                continue
            file, place = name.file_of((table, key, number))
            other, there = places.setdefault((table, body), (file, place))
            if other != file:
                raise SceneError(
                    f"{file}: {written(place)} (of {shown(body)}): {other} has a body of this name too, {written(there)}; "
                    "names must differ: leave one of them out, or call it otherwise"
                )


def _entry(table, key: str):
    return table.get(key) if isinstance(table, dict) else None
