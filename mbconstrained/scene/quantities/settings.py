"""Values from the command line: of parameters by name, of other entries by their location in the scene."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from zlib import crc32

from ...ground.checks import nearest
from ...ground.errors import InputError, quoted, shown
from ...ground.notices import Notice, NoticeKind
from ...ground.quantities import any_quantity, described, unit_of
from ..file import ORIGIN, Place, SceneName, at, parts_of, written

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
