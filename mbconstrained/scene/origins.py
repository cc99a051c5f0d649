"""Where the entries of a scene come from, for messages: the scene file itself, a file that it includes, the command line."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from ..errors import InputError

#: Where what was set from outside comes from.
ORIGIN = "--set"

Place = tuple  # of keys, and of numbers of entries from 1

_PART = re.compile(r"\.?([^\s.\[\]:]+)|\[(\d+)\]")


class EntryError(InputError):
    """An entry of the table at the place that a message tells is wrong; by its key the file is found that it stands in.

    Attributes:
        key: of the entry.
        beside: the key of another one there, which it does not fit.
    """

    def __init__(self, message: str, key: str, beside: str | None = None):
        super().__init__(message)
        self.key, self.beside = key, beside


class SceneName(str):
    """The name of a scene file, which knows the entries that come from elsewhere.

    Attributes:
        origins: file and place there, by place in the tables that were put together; what is not told belongs to its table.
        settings: names of what was set from outside, by the places of the values that come of it.

    >>> name = SceneName("scene.toml", {("model", "mass", 2): ("base.toml", ("model", "mass", 1))})
    >>> name.located('model.mass[2].mass: found -1')
    ('base.toml', 'model.mass[1].mass: found -1')
    >>> name.located("time.end: found -1")
    ('scene.toml', 'time.end: found -1')
    """

    origins: Mapping[Place, tuple[str, Place]]
    settings: Mapping[Place, Sequence[str]]

    def __new__(cls, name: str, origins: Mapping[Place, tuple[str, Place]] | None = None, settings=None):
        """The name with what comes from elsewhere."""
        found = super().__new__(cls, name)
        found.origins, found.settings = origins or {}, settings or {}
        return found

    def located(self, text: str, key: str | None = None, beside: str | None = None) -> tuple[str, str]:
        """The file that a message is about, and the message with its place, which it begins with, as that file has it.

        Args:
            key: in the table at the place, if the message is about this key.
            beside: another key there that the message is about, whose file is told where it is another one.
        """
        parts, ends = _parts(text)
        if beside is not None:
            other = self.file_of((*parts, beside))[0]
            text += f" ({beside} stands in {other})" if other != self.file_of((*parts, key))[0] else ""
        whole = (*parts, key) if key is not None else tuple(parts)
        for count in range(len(whole), 0, -1):
            if whole[:count] in self.origins:
                file, place = self.origins[whole[:count]]
                shared = min(count, len(parts))
                text = written(place[:shared]) + text[ends[shared] :]
                return file, text if file == ORIGIN else text + self._with_settings(whole)
        return str(self), text + self._with_settings(whole)

    def _with_settings(self, place: Place) -> str:
        """Which of the values at a place, or in the table there, come of what was set from outside."""
        near = (names for other, names in self.settings.items() if all(a == b for a, b in zip(place, other)))
        names = dict.fromkeys(name for each in near for name in each)
        return f" (with {' and '.join(f'{ORIGIN} {name}' for name in names)})" if place and names else ""

    def file_of(self, place: Place) -> tuple[str, Place]:
        """The file that an entry is from, and its place there."""
        for count in range(len(place), 0, -1):
            if place[:count] in self.origins:
                file, there = self.origins[place[:count]]
                return file, (*there, *place[count:])
        return str(self), place


def located(file_name: str, text: str, problem: Exception | None = None) -> tuple[str, str]:
    """The same for a file that includes none, too.

    Args:
        problem: what the message tells of; it may know the keys.
    """
    if not isinstance(file_name, SceneName):
        return file_name, text
    return file_name.located(text, getattr(problem, "key", None), getattr(problem, "beside", None))


def written(place: Place) -> str:
    """A place as people write it.

    >>> written(("model", "mass", 1, "mass"))
    'model.mass[1].mass'
    """
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place).removeprefix(".")


def parts_of(text: str) -> Place:
    """The keys and numbers of a place that somebody wrote.

    >>> parts_of("model.mass[1].mass")
    ('model', 'mass', 1, 'mass')
    """
    return tuple(_parts(text)[0])


def _parts(text: str) -> tuple[list, list[int]]:
    """Keys and numbers that a text begins with, and after how many characters each ends."""
    parts, ends = [], [0]
    while text[:8] != "the file" and (match := _PART.match(text, ends[-1])):
        parts.append(match[1] if match[1] is not None else int(match[2]))
        ends.append(match.end())
    return parts, ends
