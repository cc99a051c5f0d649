"""The JSON Schemas of scenes and of robot.toml, with which an editor completes keys, explains them and marks errors."""

from __future__ import annotations

import json

from pydantic import BaseModel

from ...ground.quantities import KINDS
from .robot_tables import RobotFile
from .scene_schema import SceneFile

#: Location of the schema of a scene, and of a robot.toml: in the same folder, under this name.
SCHEMA_FILE, ROBOT_SCHEMA_FILE = "mbconstrained.schema.json", "robot.schema.json"
EDITORS = """{file} is written. An editor with TOML support (in VS Code the extension Even Better TOML) uses it for a
{what} in the same folder that begins with the line

#:schema ./{name}"""


def schema_text(*, robot: bool = False) -> str:
    """The schema of scenes, or of a robot.toml, as JSON."""
    return json.dumps(robot_schema() if robot else scene_schema(), indent=2, ensure_ascii=False)


def scene_schema() -> dict:
    """The schema as plain data: JSON Schema 2020-12, with title and description of every key, with the unit of quantities.

    >>> stiffness = scene_schema()["$defs"]["SpringTable"]["properties"]["stiffness"]
    >>> stiffness["unit"], stiffness["examples"][0]
    ('N/m', '3 N/mm')
    """
    schema = _schema(SceneFile, "A scene of mbconstrained")
    whole = schema.pop("required")
    return {**schema, "anyOf": [{"required": whole}, {"required": ["include"]}]}  # an included file may have the model


def robot_schema() -> dict:
    """The schema of a robot.toml, as plain data.

    >>> robot_schema()["required"]
    ['urdf']
    """
    return _schema(RobotFile, "A robot.toml of mbconstrained")


def _schema(of: type[BaseModel], title: str) -> dict:
    schema = of.model_json_schema()
    for table in (schema, *schema["$defs"].values()):
        for key, entry in table.get("properties", {}).items():
            _complete(key, entry)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": title}


def _complete(key: str, entry: dict) -> None:
    """Add a title to a key, and the kind of quantity to its description."""
    entry.setdefault("title", key.replace("_", " ").capitalize())
    alternatives = [entry, *entry.get("anyOf", ())]
    quantity = next((each for each in (*alternatives, *(each.get("items", {}) for each in alternatives)) if each.get("unit")), None)
    if quantity is None:
        return
    unit = quantity["unit"]
    entry |= {"unit": unit, "examples": quantity["examples"]}
    what = "A plain number" if unit == "1" else f"In {unit}, or a text with a unit of {KINDS[unit][0]}, such as {KINDS[unit][1]}"
    if "description" in entry:
        entry["description"] += f" {what}."
