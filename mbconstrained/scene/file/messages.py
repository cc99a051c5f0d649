"""Messages about the entries of a scene: the file, the location, the value found, the value expected.

An entry may come from the scene file, from a file that it includes, or from the command line; ``SceneName`` records which.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

from ...ground.errors import InputError, SceneError, shown

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
        """The name with its origins."""
        result = super().__new__(cls, name)
        result.origins, result.settings = origins or {}, settings or {}
        return result

    def located(self, text: str, key: str | None = None, other: str | None = None) -> tuple[str, str]:
        """The file that a message concerns, and the message with its location in that file.

        Args:
            text: begins with a place in the merged tables.
            key: in the table at the place, if the message concerns this key.
            other: another key of the table; its file is named where it differs from that of the key.

        Returns:
            The name of the file, and the text.
        """
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

    >>> place(("model", "lumped", "mass", 1, "mass"), {"model": {"kind": "lumped", "mass": [{}, {"name": "cart"}]}})
    'model.mass[2].mass (of "cart")'
    """
    text, owner, marked = "", "", None
    for part in location:
        if isinstance(data, dict) and data.get("kind") == part and data is not marked:
            marked = data  # the tag by which pydantic chose the kind of table
            continue
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
