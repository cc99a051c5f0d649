"""Validation of tables against a schema, with the problems of pydantic in the words of a scene."""

from __future__ import annotations

import re

from pydantic import BaseModel, ValidationError

from ...ground.checks import nearest
from ...ground.errors import SceneError, shown
from ..file.messages import place, together

SIGNALS = '"step", "ramp", "power", "impulse", "harmonic", "term", "pulse" or "sampled"'
KINDS = {
    "model": '"lumped", "matrices", "robot", "state-space" or "transfer-function"',
    "force": SIGNALS,
    "motion": SIGNALS,
}

#: Common names of a kind: its name in scenes.
OTHER_NAMES = {"record": "sampled", "file": "sampled", "sine": "harmonic", "cosine": "harmonic", "constant": "step"}

#: Wrong entries that get a sentence, of which the first ones are shown; what is meant by each is searched for among all names.
MOST_EXPLAINED = 100

MISSING = {
    "model": 'this table is missing: write [model], and below it kind = "lumped", "matrices", …',
    "time": 'this table is missing: write [time], and below it end = "10 s"',
}


def validated(data: dict, file_name: str, schema: type[BaseModel]):
    """The tables of a scene, or of another file with its schema, validated."""
    try:
        return schema.model_validate(data)
    except ValidationError as error:
        errors = error.errors()
        problems = [_problem(problem, data) for problem in errors[:MOST_EXPLAINED]]
    raise SceneError(together(file_name, problems, len(errors) - len(problems)))


def _problem(problem: dict, data: dict) -> tuple[str, Exception | None]:
    """The location with the sentence, and the exception raised there, if any."""
    where = place(problem["loc"], data)
    return f"{where}: {_sentence(problem, where)}", problem.get("ctx", {}).get("error")


def _sentence(problem: dict, where: str) -> str:
    """The sentence for a problem of pydantic."""
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
    meant = OTHER_NAMES.get(value) if isinstance(value, str) else None
    hint = f'; did you mean "{meant}"?' if meant in names else nearest(value, names) if isinstance(value, str) else ""
    return f"found {shown(value)}; expected {known}{hint}"


def _limit(context: dict, key: str) -> str:
    return f"{context.get(key, 0):g}"


def _expectation(kind: str, context: dict) -> str:
    return {
        "list_type": "expected an array [ … ]",
        "dict_type": "expected a table",
        "bool_type": "expected true or false",
        "int_type": "expected a whole number",
        "int_from_float": "expected a whole number",
        "float_type": "expected a number",
        "finite_number": "expected a finite number",
        "string_type": "expected a text in quotes",
        "tuple_type": "expected an array [ … ]",
        "string_too_short": f"expected at least {context.get('min_length')} letters",
        "string_too_long": f"expected at most {context.get('max_length')} letters",
        "too_short": f"expected at least {context.get('min_length')} entries",
        "too_long": f"expected at most {context.get('max_length')} entries",
        "greater_than": f"expected more than {_limit(context, 'gt')}",
        "less_than": f"expected less than {_limit(context, 'lt')}",
        "greater_than_equal": f"expected at least {_limit(context, 'ge')}",
        "less_than_equal": f"expected at most {_limit(context, 'le')}",
    }.get(kind, "")
