"""The JSON Schema of scenes, by which an editor completes keys, says what each is, and marks what is wrong while one writes."""

from __future__ import annotations

import json

from .dimensions import KINDS
from .schema import SceneFile

#: Where a scene looks for its schema: beside itself, under this name.
SCHEMA_FILE = "mbconstrained.schema.json"
EDITORS = """{file} is written. An editor with TOML support (in VS Code the extension Even Better TOML) uses it for a
scene in the same folder that begins with the line

#:schema ./{name}"""


def schema_text() -> str:
    """The schema as JSON."""
    return json.dumps(scene_schema(), indent=2, ensure_ascii=False)


def scene_schema() -> dict:
    """The schema as plain data: JSON Schema 2020-12, with title and description of every key, with the unit of quantities.

    >>> stiffness = scene_schema()["$defs"]["SpringTable"]["properties"]["stiffness"]
    >>> stiffness["unit"], stiffness["examples"][0]
    ('N/m', '3 N/mm')
    """
    found = SceneFile.model_json_schema()
    for table in (found, *found["$defs"].values()):
        for key, entry in table.get("properties", {}).items():
            _complete(key, entry)
    found |= {"title": "A scene of mbconstrained"}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **found}


def _complete(key: str, entry: dict) -> None:
    """Give a key a title, and say in its description of which kind of quantity it is."""
    entry.setdefault("title", key.replace("_", " ").capitalize())
    found = [entry, *entry.get("anyOf", ())]
    quantity = next((each for each in (*found, *(each.get("items", {}) for each in found)) if each.get("unit")), None)
    if quantity is None:
        return
    unit = quantity["unit"]
    entry |= {"unit": unit, "examples": quantity["examples"]}
    what = "A plain number" if unit == "1" else f'In {unit}, or a text with a unit of {KINDS[unit][0]}, such as {KINDS[unit][1]}'
    if "description" in entry:
        entry["description"] += f" {what}."
