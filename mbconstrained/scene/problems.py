"""Messages about the entries of a scene: the place, what was found, what was expected."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import contextmanager

from ..checks import nearest
from ..errors import InputError, SceneError
from .origins import located
from .units import shown

MOST_PROBLEMS = 5  # in one message; the rest is counted
KINDS = {
    "model": '"lumped", "matrices", "robot", "state-space" or "transfer-function"',
    "force": '"step", "ramp", "power", "impulse", "harmonic", "term", "pulse" or "sampled"',
}

MISSING = {
    "model": 'this table is missing: write [model], and below it kind = "lumped", "matrices", …',
    "time": 'this table is missing: write [time], and below it end = "10 s"',
}


def validated(data: dict, file_name: str, schema: type | None = None):
    """The tables of a scene, checked against its schema, or those of another file.

    Raises:
        SceneError: with one line for every entry that is wrong.
    """
    from pydantic import ValidationError

    if schema is None:
        from .schema import SceneFile as schema
    try:
        return schema.model_validate(data)
    except ValidationError as error:
        lines = [_line(problem, data) for problem in error.errors()]
    raise SceneError(together(file_name, lines))


def _line(problem: dict, data: dict) -> tuple[str, Exception | None]:
    """The place with what is wrong there, and the error that was raised there, if one was."""
    where = place(problem["loc"], data)
    return f"{where}: {_sentence(problem, where)}", problem.get("ctx", {}).get("error")


def together(file_name: str, lines: Sequence[str | tuple[str, Exception | None]]) -> str:
    """One message of one or more problems, each a text that begins with a place, perhaps with the error that was raised there."""
    pairs = [(line, None) if isinstance(line, str) else line for line in lines]
    found = list(dict.fromkeys(located(file_name, *pair) for pair in pairs))
    if len(found) == 1:
        return ": ".join(found[0])
    shown_lines = [f"  {text}" if file == file_name else f"  {file}: {text}" for file, text in found[:MOST_PROBLEMS]]
    if len(found) > MOST_PROBLEMS:
        shown_lines.append(f"  and {len(found) - MOST_PROBLEMS} more")
    return "\n".join([f"{file_name}: {len(found)} entries are wrong", *shown_lines])


@contextmanager
def at(file_name: str, where: str):
    """Put the file and the place in front of what an inner part says about a value."""
    try:
        yield
    except SceneError:
        raise
    except InputError as problem:
        raise SceneError(": ".join(located(file_name, f"{where}: {problem}", problem))) from None


def place(location: tuple, data) -> str:
    """A place in the file as people write it; entries of arrays count from 1 and show their name.

    >>> place(("model", "lumped", "mass", 1, "mass"), {"model": {"kind": "lumped", "mass": [{}, {"name": "cart"}]}})
    'model.mass[2].mass (of "cart")'
    """
    text, owner, marked = "", "", None
    for part in location:
        if isinstance(data, dict) and data.get("kind") == part and data is not marked:
            marked = data  # the schema's own mark for the kind of the table
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


def _sentence(problem: dict, where: str) -> str:
    """One problem that pydantic found, in plain words."""
    kind, context, value = problem["type"], problem.get("ctx", {}), problem["input"]
    if kind == "value_error":
        return str(context["error"])
    if kind == "missing":
        return MISSING.get(where, "this key is missing")
    if kind in ("union_tag_invalid", "union_tag_not_found", "model_attributes_type"):
        return _kind_sentence(value, problem["loc"][0])
    if kind == "literal_error":
        return _choice(value, context["expected"].replace("'", '"'))
    if kind == "list_type" and isinstance(value, dict):
        return f"found one table; write it with double brackets, [[{where}]], once for every entry"
    return f"found {shown(value)}; {_expectation(kind, context) or problem['msg']}"


def _kind_sentence(value, where: str) -> str:
    known = KINDS[where]
    if isinstance(value, list) and value:
        return f"there is one {where} only: write it with single brackets, [{where}]"
    if not isinstance(value, dict):
        return f"found {shown(value)}; expected a table with the key kind = {known}"
    if "kind" not in value:
        return f"the key kind is missing; expected {known}"
    return "kind: " + _choice(value["kind"], known)


def _choice(value, known: str) -> str:
    names = re.findall(r'"([^"]*)"', known)
    return f"found {shown(value)}; expected {known}{nearest(value, names) if isinstance(value, str) else ''}"


def _expectation(kind: str, context: dict) -> str:
    return {
        "list_type": "expected an array [ … ]",
        "dict_type": "expected a table",
        "bool_type": "expected true or false",
        "int_type": "expected a whole number",
        "too_short": f"expected at least {context.get('min_length')} entries",
        "too_long": f"expected at most {context.get('max_length')} entries",
        "greater_than_equal": f"expected at least {context.get('ge')}",
        "less_than_equal": f"expected at most {context.get('le')}",
    }.get(kind, "")
