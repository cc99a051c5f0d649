"""Scene files and the files that they include as plain tables, values set on the command line, and messages with the place of an entry.

An entry may come from the scene file, from a file that it includes, or from the command line; ``SceneName`` records which.

Included files come first, in the order in which they are named, the including file last: arrays of tables grow, for everything
else the last value counts. A file included by several others is read once. The robot.toml of a robot comes first of all: the table
[robot] of a scene changes it for this scene.
"""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple
from zlib import crc32

from ..ground.checks import nearest
from ..ground.errors import InputError, SceneError, quoted, shown
from ..ground.notices import Notice, NoticeKind
from ..ground.quantities import any_quantity, described, unit_of

#: The origin of entries that the command line sets.
ORIGIN = "--set"

#: Problems listed in one message; the others are counted.
MOST_PROBLEMS = 5

Place = tuple  # of keys, and of numbers of entries from 1

_PART = re.compile(r'\.?"([^"]+)"|\.?([^\s.\[\]:]+)|\[(\d+)\]')


class EntryError(InputError):
    """A wrong entry of a table, with the file of the entry.

    Attributes:
        key: of the entry.
        other: the key of another entry of the table that contradicts it.
    """

    def __init__(self, message: str, key: str, other: str | None = None):
        super().__init__(message)
        self.key, self.other = key, other


class SceneName(str):
    """The name of a scene file, with the origins of the entries from other files.

    Attributes:
        origins: file and place there, by place in the merged tables; entries without an own origin share that of their table.
        settings: names given with --set, by the places of the values that depend on them.

    >>> name = SceneName("scene.toml", {("model", "mass", 2): ("base.toml", ("model", "mass", 1))})
    >>> name.located('model.mass[2].mass: found -1')
    ('base.toml', 'model.mass[1].mass: found -1')
    >>> name.located("time.end: found -1")
    ('scene.toml', 'time.end: found -1')
    """

    origins: Mapping[Place, tuple[str, Place]]
    settings: Mapping[Place, Sequence[str]]

    def __new__(cls, name: str, origins: Mapping[Place, tuple[str, Place]] | None = None, settings=None):
        result = super().__new__(cls, name)
        result.origins, result.settings = origins or {}, settings or {}
        return result

    def located(self, text: str, key: str | None = None, other: str | None = None) -> tuple[str, str]:
        """The file of the place with which a message about a key begins, and the message with the place in that file."""
        parts, ends = _parts(text)
        if other is not None:
            file = self.file_of((*parts, other))[0]
            text += f" ({other} stands in {file})" if file != self.file_of((*parts, key))[0] else ""
        whole = (*parts, key) if key is not None else tuple(parts)
        for count in range(len(whole), 0, -1):
            if whole[:count] in self.origins:
                file, place = self.origins[whole[:count]]
                shared = min(count, len(parts))
                there, rest = written(place[: len(place) - count + shared]), text[ends[shared] :]
                text = there + (rest.removeprefix("the file") if there else rest)
                return file, text if file == ORIGIN else text + self._with_settings(whole)
        return str(self), text + self._with_settings(whole)

    def _with_settings(self, place: Place) -> str:
        """The names given with --set on which the entry or table at a location depends."""
        near = (names for other, names in self.settings.items() if all(a == b for a, b in zip(place, other)))
        names = dict.fromkeys(name for each in near for name in each)
        return f" (with {' and '.join(f'{ORIGIN} {name}' for name in names)})" if place and names else ""

    def file_of(self, place: Place) -> tuple[str, Place]:
        """The file of an entry, and its location there."""
        for count in range(len(place), 0, -1):
            if place[:count] in self.origins:
                file, there = self.origins[place[:count]]
                return file, (*there, *place[count:])
        return str(self), place


def _located(file_name: str, text: str, problem: Exception | None = None) -> tuple[str, str]:
    """``SceneName.located``, also for a plain file name and problems with the attributes of an ``EntryError``."""
    if not isinstance(file_name, SceneName):
        return file_name, text
    return file_name.located(text, getattr(problem, "key", None), getattr(problem, "other", None))


@contextmanager
def at(file_name: str, where: str = "") -> Iterator[None]:
    """A context that adds the file and the location, if any, to the message of an InputError."""
    try:
        yield
    except SceneError:
        raise
    except InputError as problem:
        if str(problem).startswith(f"{file_name}, line "):
            raise SceneError(str(problem)) from None
        raise SceneError(": ".join(_located(file_name, f"{where}: {problem}" if where else str(problem), problem))) from None


def together(file_name: str, problems: Sequence[str | tuple[str, Exception | None]], more: int = 0) -> str:
    """One message for several problems."""
    pairs = [(problem, None) if isinstance(problem, str) else problem for problem in problems]
    located = list(dict.fromkeys(_located(file_name, *pair) for pair in pairs))
    count = len(located) + more
    if count == 1:
        return ": ".join(located[0])
    lines = [f"  {text}" if file == file_name else f"  {file}: {text}" for file, text in located[:MOST_PROBLEMS]]
    if count > MOST_PROBLEMS:
        lines.append(f"  and {count - MOST_PROBLEMS} more")
    return "\n".join([f"{file_name}: {count} entries are wrong", *lines])


def place(location: tuple, data) -> str:
    """A location of pydantic in the notation of users.

    >>> place(("model", "mass", 1, "mass"), {"model": {"kind": "lumped", "mass": [{}, {"name": "cart"}]}})
    'model.mass[2].mass (of "cart")'
    """
    text, owner = "", ""
    for part in location:
        text += f"[{part + 1}]" if isinstance(part, int) else f"{'.' if text else ''}{part}"
        data = _entry(data, part)
        if isinstance(part, int) and isinstance(data, dict) and isinstance(data.get("name"), str):
            owner = f" (of {shown(data['name'])})"
    return (text or "the file") + owner


def _entry(data, part):
    if isinstance(data, dict):
        return data.get(part)
    return data[part] if isinstance(data, list) and isinstance(part, int) and part < len(data) else None


def written(place: Place) -> str:
    """A location in the notation of users.

    >>> written(("model", "mass", 1, "mass"))
    'model.mass[1].mass'
    """
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place).removeprefix(".")


def parts_of(text: str) -> Place:
    """The keys and numbers of a location.

    >>> parts_of("model.mass[1].mass"), parts_of('robot.joint_damping."crank pivot"')
    (('model', 'mass', 1, 'mass'), ('robot', 'joint_damping', 'crank pivot'))
    """
    return tuple(_parts(text)[0])


def _parts(text: str) -> tuple[list, list[int]]:
    """Keys and numbers at the beginning of a text, and the position at which each ends."""
    parts, ends = [], [0]
    while text[:8] != "the file" and (match := _PART.match(text, ends[-1])):
        parts.append(match[1] or match[2] or int(match[3]))
        ends.append(match.end())
    return parts, ends


LARGEST_SCENE = 1_000_000  # bytes; larger matrices belong into files next to the scene
DEEPEST_NAME = 40  # parts of a dotted name; tomllib needs quadratic time for longer ones
_DOTTED = re.compile(rf"""(?<![\w-])(?:(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){{{DEEPEST_NAME}}}""")


class FileKind(NamedTuple):
    """Texts about a kind of file: its minimal content, and what a too large one is."""

    least: str
    large: str


_LARGE = "which is no scene; keep large matrices in files (.npz, .mat, .mtx, .csv) next to it"
SCENE, INCLUDED = FileKind("a scene has at least [model]", _LARGE), FileKind("leave out its name in include", _LARGE)


def read_text(path: Path, kind: FileKind = SCENE) -> str:
    """The text of a scene file, or of another file in the same format."""
    try:
        if path.is_dir():
            names = sorted(path.name for path in path.glob("*.toml"))[:5]
            known = f", e.g. {', '.join(names)}" if names else ""
            raise SceneError(f"{path.name or path}: this is a directory; give the scene file in it{known}")
        if path.exists() and not path.is_file():
            raise SceneError(f"{path.name}: this is not a file; give a scene file")
        with open(path, "rb") as file:
            content = file.read(LARGEST_SCENE + 1)
    except FileNotFoundError:
        near = nearest(path.name, [other.name for other in path.parent.glob("*.toml")]) if path.parent.is_dir() else ""
        near = '; it has at least urdf = "FILE"' if path.name == ROBOT_FILE else near
        raise SceneError(f"{path}: there is no such file{near}") from None
    except SceneError:  # a ValueError as well
        raise
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or str(problem)
        raise SceneError(f"{quoted(str(path))}: the file cannot be read ({reason})") from None
    if len(content) > LARGEST_SCENE:
        raise SceneError(f"{path.name}: the file has more than {LARGEST_SCENE:,} bytes, {kind.large}")
    if not content.strip():
        raise SceneError(f"{path.name}: the file is empty; {kind.least}")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        line = content.count(b"\n", 0, problem.start) + 1
        raise SceneError(f"{path.name}: line {line} is not UTF-8 text; save the file with the encoding UTF-8") from None


def parse(text: str, name: str) -> dict:
    if _DOTTED.search(text):
        raise SceneError(f"{name}: a name of more than {DEEPEST_NAME} parts joined by dots; a scene nests far less")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        raise SceneError(f"{name}: not a TOML file: {_readable(problem, text)}") from None
    except ValueError:  # whole numbers of thousands of digits
        raise SceneError(f"{name}: a number with far too many digits") from None
    except RecursionError:
        raise SceneError(f"{name}: arrays or tables are nested too deeply; a scene needs three or four levels") from None


_TEXT = 'a text such as "3 N/mm" needs quotes'
_MEANINGS = {  # messages of tomllib: their meaning to somebody who writes a scene
    "Cannot overwrite a value": "a key is given twice",
    "Expected newline or end of document after a statement": f"expected one value on the line; {_TEXT}",
    "Invalid value": f"this is no value; {_TEXT}, an array needs its closing bracket",
    "Invalid statement": 'expected [table], [[table]] or key = value, as in end = "5 s"',
    "Expected '=' after a key in a key/value pair": 'expected = between a key and its value, as in end = "5 s"',
    "Illegal character '\\n'": "a text ends with the quote that it begins with, on the same line",
}
_SIGNS = (  # the error of a line with this pattern
    (r"[\u201c\u201d\u201e\u2018\u2019]", 'quotes must be straight, "…"'),
    (r"=\s*[+-]?\d+,\d", "decimals have a point, as in 0.5"),
    (r"^\s*(\[[A-Za-z_][\w.-]*|\[\[[A-Za-z_][\w.-]*\s*\]?)\s*$",
     "a table ends with as many brackets as it begins with, [time], [[model.mass]]"),
)  # fmt: skip


_BOTH = "[{0}] and [[{0}]] stand in one file; write double brackets, [[{0}]], once for every entry"


def _is_both(text: str, table: str) -> bool:
    """Whether a table is used with single and with double brackets."""
    name = rf"[ \t]*{re.escape(table)}[ \t]*"  # blanks of one line only: across empty lines each start would search all of them
    heads = (rf"^[ \t]*{brackets}[ \t\r]*(#.*)?$" for brackets in (rf"\[{name}\]", rf"\[\[{name}\]\]"))
    return all(re.search(head, text, re.MULTILINE) for head in heads)


def _readable(problem: tomllib.TOMLDecodeError, text: str) -> str:
    """The parser's sentence in plain words, with its line."""
    if text.lstrip().startswith(("{", "<")):
        return 'it looks like JSON or XML; a scene has tables, [model], and below them lines such as kind = "lumped"'
    message, _, place = str(problem).partition(" (at ")
    line = re.match(r"line (\d+)", place)  # or the end of the document
    lines = text.split("\n")[: int(line[1])] if line else text.rstrip().split("\n")
    if (head := re.fullmatch(r"\s*\[+([^\[\]]+)\]+\s*(#.*)?", lines[-1])) and _is_both(text, head[1].strip()):
        return f"{_BOTH.format(head[1].strip())}; at {place.rstrip(')')}"
    message = _MEANINGS.get(message, message)
    if twice := re.fullmatch(r"Cannot declare \((.*)\) twice", message):
        table = ".".join(re.findall("'([^']*)'", twice[1]))
        message = f"the table [{table}] stands there twice; write it once"
    message = next((words for sign, words in _SIGNS if re.search(sign, lines[-1])), message)
    return f"{message}; at {place.rstrip(')')}, near {quoted(lines[-1].strip()[:60])}" if place else message


class SceneFolder(NamedTuple):
    """The folder of a scene, and further ones from which its data files may be read."""

    path: Path
    allowed: tuple[Path, ...] = ()

    def data_file(self, name: str) -> Path:
        """The path of a data file that a scene names, relative to its folder; absolute within the allowed folders."""
        rule = (
            "data files must lie in the folder of the scene or in one inside it; to allow another folder give --data-folder DIR, in Python "
            "read_scene(…, data_folders=[…])"
        )
        if self.allowed and name and name.isprintable():
            with suppress(OSError, RuntimeError):
                path = (self.path.resolve() / name).resolve()
                if any(path.is_relative_to(folder.resolve()) for folder in self.allowed):
                    return path
            rule = f"data files must lie in the folder of the scene, or in {' or '.join(map(str, self.allowed))}"
        return inside(self.path, name, rule, "the name of a file such as record.csv or matrices.npz")


def inside(folder: Path, name: str, rule: str, expected: str) -> Path:
    """The path of a file in a folder."""
    if not name or not name.isprintable():
        raise InputError(f"found {shown(name)}; expected {expected}")
    if Path(name).is_absolute():
        raise InputError(f"found {shown(name)}, an absolute path; {rule}")
    folder = folder.resolve()
    try:
        path = (folder / name).resolve()
    except (OSError, RuntimeError):  # Python before 3.13 has the second for a circle of links
        raise InputError(f"found {shown(name)}, which is a link that leads in a circle; name the file itself") from None
    if not path.is_relative_to(folder):
        raise InputError(f"found {shown(name)}, which leads out of the folder; {rule}")
    return path


ROBOT_FILE = "robot.toml"
ROBOT_KIND = FileKind("a robot.toml has at least urdf", "which is no robot.toml; meshes lie in files of their own")

MOST_FILES = 20  # that a scene includes, directly or not
DEEPEST_INCLUDE = 5
EXPECTED = 'expected names of scene files, e.g. include = ["materials.toml"]'
BODIES = (("model", "mass"), ("model", "inertia"), ("model", "node"), ("drawing", "body"))
MATRICES = ("mass", "damping", "stiffness", "A", "B", "C", "D", "descriptor")


def read_tables(path: Path) -> tuple[dict, SceneName]:
    """The tables of a scene and of the files that it includes, and its name with the origins of their entries."""
    read = _Files(path.parent)
    read.add(path)
    if len(read.files) == 1:
        return next(iter(read.files.values()))[1], SceneName(path.name)
    data: dict = {}
    origins: dict[Place, tuple[str, Place]] = {}
    for file_name, tables in read.files.values():
        _merge(data, tables, (), file_name, origins)
    name = SceneName(path.name, origins)
    _check_bodies(data, name)
    return data, name


def robot_path(name: str, folder: Path) -> Path:
    if not name or not name.isprintable() or Path(name).is_absolute():
        raise InputError(f'found {shown(name)}; expected a folder relative to the scene, e.g. "../robots/four_bar"')
    path = folder / name
    if not path.exists():
        raise InputError(f"found {shown(name)}; there is no such folder or file")
    if not path.is_dir() and path.suffix != ".toml":
        hint = f'; next to the URDF write a {ROBOT_FILE} with urdf = "{path.name}"' if path.suffix == ".urdf" else ""
        raise InputError(f"found {shown(name)}; expected the folder of a robot, or its {ROBOT_FILE}{hint}")
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


@dataclass(frozen=True)
class _Files:
    """The files of a scene, included ones before those that include them."""

    folder: Path  # of the scene
    files: dict[Path, tuple[str, dict]] = field(default_factory=dict)  # by path: the name in messages, and the tables

    def add(self, path: Path, includers: tuple[Path, ...] = ()) -> None:
        """Read a file after the files that it includes."""
        name = self._name(path) if includers else path.name
        data = parse(read_text(path, INCLUDED if includers else SCENE), name)
        if "include" in data:
            with at(name, "include"):
                for other in self._others(path, data.pop("include"), (*includers, path.resolve())):
                    self.add(other, (*includers, path.resolve()))
        if includers:
            _lead_from(data, os.path.relpath(path.parent, self.folder))
        self.files[path.resolve()] = name, data

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
    if folder == ".":
        return
    model, random = (own if isinstance(own := data.get(key), dict) else {} for key in ("model", "random"))
    for key in ("robot", *MATRICES):
        if isinstance(model.get(key), str) and not model[key].lstrip().startswith("="):
            model[key] = f"{folder}/{model[key]}"
    lists = (data.get("force"), data.get("motion"), random.get("input"))
    for table in (*_tables(model.values()), *(table for each in lists for table in _list(each)), *_list(model.get("coefficients"))):
        if isinstance(table, dict) and isinstance(table.get("file"), str) and not Path(table["file"]).is_absolute():
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


# Values from the command line: of parameters by name, of other entries by their location in the scene.

TEXTS = ("title", "source")  # what stands above all tables
LONGEST_PART = 80  # characters of the name of a file; of more the end is a check sum
PLACES = "time.end, model.mass[1].mass or model.mass.cart.mass"


@dataclass(frozen=True)
class Setting:
    """A value set on the command line."""

    name: str  # name of the parameter, or the place
    value: Any  # the new value, as it could be written in the file
    before: Any = None  # the previous value; None without one

    @property
    def notice(self) -> Notice:
        was = "which the file leaves out" if self.before is None else f"instead of {_plainly(self.before)} in the file"
        return Notice(NoticeKind.OVERRIDE, f"{self}, {was}")

    def __str__(self) -> str:
        return f"{self.name} = {_plainly(self.value)}"


def file_part(settings: Sequence[Setting]) -> str:
    """The part of the name of a file for values that were set.

    >>> file_part([Setting("k", "3 N/mm"), Setting("time.end", 2)])
    'k=3_N_mm,time.end=2'
    """
    text = ",".join(f"{one.name}={one.value}" for one in settings)
    part = re.sub(r"[^\w.=+,-]+", "_", text)
    return part if len(part) <= LONGEST_PART else f"{part[: LONGEST_PART - 9]}_{crc32(text.encode()):08x}"


def value_of(text: str):
    """The value of a text on the command line: a number, true, an array …, or else the text itself.

    >>> value_of("3"), value_of("3 N/mm"), value_of("true"), value_of('["x1", "q1"]')
    (3, '3 N/mm', True, ['x1', 'q1'])
    """
    try:
        tables = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return tables["value"] if len(tables) == 1 and not isinstance(tables["value"], dict) else text


def with_settings(data: dict, name: SceneName, settings: Mapping[str, Any]) -> tuple[SceneName, tuple[Setting, ...]]:
    """Set values in the tables of a scene, in place, before validation."""
    changes, origins, set_by = [], dict(name.origins), dict(name.settings)
    for key, value in settings.items():
        with at(ORIGIN, key if key.isprintable() else quoted(key)):
            setting, place = _set_parameter(data, key, value) or _set_at(data, key, value)
        changes.append(setting)
        origins[place], set_by[place] = (ORIGIN, place), (key,)
    return SceneName(name, origins, set_by), tuple(changes)


def with_values(name: SceneName, changes: Sequence[Setting], uses: Mapping[Place, Collection[str]]) -> SceneName:
    """The name of the scene with the values that depend on parameters that were set."""
    names = [setting.name for setting in changes]
    dependent = {place: tuple(each for each in names if each in used) for place, used in uses.items()}
    return SceneName(
        name, name.origins, {**name.settings, **{place: names_set for place, names_set in dependent.items() if names_set}}
    )


def _set_parameter(data: dict, name: str, value) -> tuple[Setting, tuple] | None:
    """The parameter of this name set; None where the name is a location."""
    parameters = data.get("parameters")
    parameters = parameters if isinstance(parameters, dict) else {}
    if name not in parameters and (len(parts_of(name)) > 1 or name in TEXTS):
        return None
    if name not in parameters:
        there = f"; there are {', '.join(parameters)}" if parameters else ": the scene has none"
        wanted = f"give one of [parameters], or a place, e.g. {PLACES}"
        raise InputError(f"there is no such parameter{nearest(name, parameters)}{there}; {wanted}")
    before = parameters[name]
    parameters[name] = _of_the_kind(value, before)
    return Setting(name, parameters[name], before), ("parameters", name)


def _of_the_kind(value, before):
    """The value in the kind of the previous one; a plain number gets its SI unit."""
    if not _is_quantity(value) or not isinstance(before, str) or not _is_quantity(before):
        return value  # what it is instead is judged as if it stood in the file
    _, kind = any_quantity(value)
    _, wanted = any_quantity(before)
    if kind is None:
        return f"{value} {unit_of(wanted)}"
    if kind != wanted:
        raise InputError(f"found {shown(value)}, {described(kind)}; expected {described(wanted)}, as {shown(before)} in the file")
    return value


def _is_quantity(value) -> bool:
    if isinstance(value, str):
        return not value.lstrip().startswith("=")
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _set_at(data: dict, name: str, value) -> tuple[Setting, tuple]:
    """The value at a location set; missing tables are added, and the location of the first of them is returned."""
    place: tuple = ()
    new_tables: list[tuple] = []
    *tables, last = parts_of(name)
    for part in tables:
        key = _key(data, part, place)
        place = (*place, key)
        if isinstance(data, dict) and key not in data:
            data[key] = {}
            new_tables.append(place)
        data = data[key - 1] if isinstance(data, list) else data[key]
        if not isinstance(data, (dict, list)):
            raise InputError(f"{written(place)} is {shown(data)}, which has no parts")
    last = _key(data, last, place)
    where = last - 1 if isinstance(data, list) else last
    before = data[where] if isinstance(data, list) else data.get(where)
    data[where] = value
    return Setting(name, value, before), (*new_tables, (*place, last))[0]


def _key(data: dict | list, part, place: tuple):
    """The key of a table; the index of an entry of an array, which may be given by its name."""
    if isinstance(data, dict):
        if isinstance(part, int) and not data:
            raise InputError(f"the scene has no [[{written(place)}]], so no entry {part}; write it into the file first")
        if isinstance(part, int):
            raise InputError(f"{written(place)} is a table, which has no entry {part}; give a key, e.g. {PLACES}")
        return part
    names = [entry.get("name") if isinstance(entry, dict) else None for entry in data]
    if part in names:
        return names.index(part) + 1
    if isinstance(part, int) and 1 <= part <= len(data):
        return part
    known = [name for name in names if isinstance(name, str)]
    there = ", ".join(known[:10]) if known else f"{len(data)}, the first is {written(place)}[1]"
    called = part if isinstance(part, int) else shown(part)
    raise InputError(f"{written(place)} has no entry {called}{nearest(part, known)}; there are {there}")


def _plainly(value) -> str:
    return quoted(value)[1:-1] if isinstance(value, str) else shown(value)
