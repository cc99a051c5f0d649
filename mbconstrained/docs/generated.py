"""The generated parts of the documentation: Python names, keys of a scene file, commands, units, notices and errors, and the rooms of the package.

They stand in the pages between the lines ``<!-- generated: NAME -->`` and ``<!-- end of NAME -->``; ``python -m mbconstrained.docs.generated``
writes them, and a test compares them with the code. Sphinx adds the full docstrings of the Python names.
"""

from __future__ import annotations

import ast
import inspect
import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import typer

import mbconstrained as mb
from mbconstrained.ground import errors
from mbconstrained.ground.notices import NoticeKind

PACKAGE = Path(mb.__file__).parent


def api() -> str:
    """One autodoc directive for each public name, classes first."""
    names = [name for name in mb.__all__ if not inspect.ismodule(getattr(mb, name))]
    classes = [name for name in names if inspect.isclass(getattr(mb, name))]
    groups = {
        "Functions": [name for name in names if name not in classes],
        "Classes": [name for name in classes if not issubclass(getattr(mb, name), Exception)],
    }
    return "\n\n".join(f"## {title}\n\n" + "\n\n".join(map(_directive, group)) for title, group in groups.items())


def _table(titles: str, rows: Iterable[tuple[str, ...]]) -> str:
    """A table with titles such as "name | meaning"."""
    lines = (" | ".join(("", *row, "")).strip() for row in rows)
    return "\n".join([f"| {titles} |", "|---" * (titles.count("|") + 1) + "|", *lines])


def names() -> str:
    """The public names with the first sentence of each."""
    values = {name: getattr(mb, name) for name in mb.__all__}
    sentences = {name: inspect.getdoc(value) or "" for name, value in values.items() if not inspect.ismodule(value)}
    return _table("name | meaning", ((f"`{name}`", _cell(text.split("\n\n")[0])) for name, text in sentences.items()))


def methods() -> str:
    """The methods of a scene that answer an analysis, each with its question."""
    from mbconstrained.analyses import ANALYSES
    from mbconstrained.scene.run.scene import METHOD_NAMES

    return _table("method | question", ((f"`{METHOD_NAMES.get(name, name)}`", help) for name, (_, help) in ANALYSES.items()))


def _directive(name: str) -> str:
    value = getattr(mb, name)
    kind, options = ("autoclass", ":members:\n") if inspect.isclass(value) else ("autofunction", "")
    return f"### {name}\n\n```{{eval-rst}}\n.. {kind}:: {value.__module__}.{value.__qualname__}\n   {options}```"


def notices() -> str:
    """The kinds of notices with their meanings."""
    return _table("kind | meaning", ((str(kind), kind.meaning) for kind in NoticeKind))


def exceptions() -> str:
    """The exceptions with the first line of their docstrings."""
    classes = [value for value in vars(errors).values() if inspect.isclass(value) and issubclass(value, Exception)]
    rows = ((f"`{c.__name__}`", f"`{c.__bases__[0].__name__}`", inspect.getdoc(c).splitlines()[0]) for c in classes)
    return _table("exception | base | meaning", rows)


#: An option of more commands than this is listed once, at the top.
FEW_COMMANDS = 5


def commands() -> str:
    """The options of many commands, then every command with its help, arguments and options."""
    from mbconstrained.cli import application

    group: Any = typer.main.get_command(application())
    commands = {name: group.get_command(None, name) for name in sorted(group.list_commands(None))}
    rows = {name: [_option(each) for each in command.params if getattr(each, "help", None)] for name, command in commands.items()}
    count = Counter(row for own in rows.values() for row in own)
    common = [row for row in count if count[row] > FEW_COMMANDS]
    sections = [f"## Arguments and options of most commands\n\n{_option_table(common)}"]
    for name, command in commands.items():
        also = [row[0] for row in rows[name] if row in common]
        own = [row for row in rows[name] if row not in common]
        parts = [
            f"## {name}",
            inspect.cleandoc(command.help or ""),
            _option_table(own) if own else "",
            f"Also {', '.join(also)}." if also else "",
        ]
        sections.append("\n\n".join(part for part in parts if part))
    return "\n\n".join(sections)


def _option_table(rows: list[tuple[str, str]]) -> str:
    return _table("argument or option | meaning", rows)


def _option(parameter) -> tuple[str, str]:
    return ", ".join(f"`{name}`" for name in parameter.opts), _cell(parameter.help)


def scene() -> str:
    """The tables and keys of a scene file."""
    from mbconstrained.scene.schema.scene_schema import scene_schema

    return "\n\n".join(_tables(scene_schema()))


def robot() -> str:
    """The tables and keys of a robot.toml."""
    from mbconstrained.scene.schema.scene_schema import robot_schema

    return "\n\n".join(_tables(robot_schema()))


def _tables(schema: dict) -> Iterator[str]:
    """A section for each table, headed by the place at which it is written."""
    for table, place, repeats in _places(schema):
        rows = (_key(key, field, key in table.get("required", ())) for key, field in table["properties"].items())
        title = f"`[[{place}]]`" if repeats else f"`[{place}]`" if place else "Top level"
        kind = table["properties"].get("kind", {}).get("const")
        title += f', `kind = "{kind}"`' if kind else ""
        keys = _table("key | unit or values | default | meaning", rows)
        yield f"## {title}\n\n{_cell(table.get('description', ''))}\n\n{keys}"


#: The end of a description that the column of units has shorter.
UNIT_TEXT = re.compile(r"\s*(?:In (?:\S+), or a text with a unit of .*|A plain number\.)$")


def _key(key: str, field: dict, required: bool) -> tuple[str, str, str, str]:
    values = field.get("enum") or ([field["const"]] if "const" in field else [])
    unit = ", ".join(f'`"{value}"`' for value in values) or field.get("unit", "")
    default = "required" if required else _default(field.get("default"))
    return f"`{key}`", _cell(unit), default, _cell(UNIT_TEXT.sub("", field.get("description", "")))


def _default(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    return "" if value in (None, "", []) or isinstance(value, dict) else f"`{json.dumps(value)}`"


def _places(schema: dict) -> Iterator[tuple[dict, str, bool]]:
    """(table, place, whether it repeats) of the top level and then of every table, each once, followed by those below it."""
    waiting, known = [(schema, "", False)], {id(schema)}
    while waiting:
        table, place, repeats = waiting.pop(0)
        yield table, place, repeats
        entries = []
        for key, field in table["properties"].items():
            for name, below in _references(field):
                entry = schema["$defs"][name]
                if entry.get("properties") and id(entry) not in known:
                    known.add(id(entry))
                    entries.append((entry, f"{place}.{key}".strip("."), below))
        waiting = entries + waiting


def _references(field, repeats: bool = False) -> Iterator[tuple[str, bool]]:
    """Names of the tables that a key may contain, and whether as an array of tables."""
    if isinstance(field, dict):
        if "$ref" in field:
            yield field["$ref"].rpartition("/")[2], repeats
        for key, part in field.items():
            if key not in ("discriminator", "description"):
                yield from _references(part, repeats or key == "items")
    elif isinstance(field, list):
        for part in field:
            yield from _references(part, repeats)


#: The rooms in the order in which they import each other.
ROOMS = (
    "ground exchange linalg signals polynomial exact response frequency control mechanics models robot page scene analyses cli"
).split()


def rooms() -> str:
    """Every room of the package with the purpose of its files, from their docstrings."""
    present = [PACKAGE / room for room in ROOMS if (PACKAGE / room).is_dir()]
    return "\n\n".join(f"### {room.name}\n\n{_module_text(room / '__init__.py')}\n\n{_files(room)}" for room in present)


def _files(room: Path) -> str:
    files = sorted(room.rglob("*.py"), key=lambda file: (len(file.relative_to(room).parts), file))
    texts = {_name(file): _module_text(file) for file in files if file.parent != room or file.stem != "__init__"}
    return _table("file | contents", ((f"`{name}`", _cell(text.split("\n\n")[0])) for name, text in texts.items()))


def _name(file: Path) -> str:
    place = file.relative_to(PACKAGE)
    return f"{place.parent}/" if file.stem == "__init__" else str(place)


def _module_text(file: Path) -> str:
    """The docstring of a module, up to its first example."""
    text = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    return text.split("\n\n>>>")[0].replace("``", "`")


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")


def units() -> str:
    """The accepted units by kind, and the spellings that are refused."""
    from mbconstrained.ground.units import AMBIGUOUS, UNITS

    known = _table("measures | symbol | SI prefixes | other spellings | definition", map(_unit, UNITS))
    refused = _table("spelling | may be read as", ((f"`{name}`", _cell(text)) for name, text in AMBIGUOUS.items()))
    return f"{known}\n\n## Refused spellings\n\n{refused}"


def _unit(unit) -> tuple[str, ...]:
    symbols, spellings = (
        ", ".join(f"`{name}`" for name in names.split()) for names in (unit.symbols, f"{unit.names} {unit.irregular}")
    )
    definition = "base unit" if unit.definition.startswith("[") else f"`{unit.definition}`"
    return unit.of, symbols, unit.prefixes.replace(" ", ", "), spellings, definition


GENERATED: dict[str, Callable[[], str]] = {
    "names": names,
    "methods": methods,
    "scene": scene,
    "robot": robot,
    "units": units,
    "commands": commands,
    "notices": notices,
    "exceptions": exceptions,
    "rooms": rooms,
}

#: The pages with generated parts.
PAGES = [
    PACKAGE / "docs" / f"{page}.md"
    for page in (
        "reference/python",
        "reference/scene",
        "reference/robot",
        "reference/units",
        "reference/commands",
        "reference/notices",
        "development/map",
    )
]


def current(page: Path) -> str:
    """The text of a page with its generated parts as they are now."""

    def part(match: re.Match) -> str:
        name = match[1]
        return f"<!-- generated: {name} -->\n\n{GENERATED[name]()}\n\n<!-- end of {name} -->"

    return re.sub(r"<!-- generated: (\w+) -->.*<!-- end of \1 -->", part, page.read_text(encoding="utf-8"), flags=re.DOTALL)


if __name__ == "__main__":
    for page in PAGES:
        page.write_text(current(page), encoding="utf-8")
