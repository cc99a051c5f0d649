"""The schema as editors will get it: complete, described, closed."""

import json
from typing import get_args

from mbconstrained.page.drawing import LINK_KINDS, SHAPES
from mbconstrained.scene import drawing_tables, problems
from mbconstrained.scene.schema import SceneFile

SCHEMA = SceneFile.model_json_schema()


def tables_are_closed_and_described(schema):
    """Every key has a description, and no table takes unknown keys."""
    for name, table in (("the file", schema), *schema["$defs"].items()):
        assert table["description"], name
        assert table["additionalProperties"] is False, name
        for key, entry in table["properties"].items():
            assert entry.get("description"), f"{name}.{key}"


def references_lead_somewhere(schema):
    """It is JSON, and what it refers to is there."""
    text = json.dumps(schema)
    references = {part.split('"')[0] for part in text.split('"$ref": "')[1:]}
    assert references and {reference.removeprefix("#/$defs/") for reference in references} <= set(schema["$defs"])


def test_the_schema_of_scenes_is_complete():
    tables_are_closed_and_described(SCHEMA)
    references_lead_somewhere(SCHEMA)


def test_drawing_knows_the_shapes_and_links_of_the_page():
    assert (*get_args(drawing_tables.Shape), "parts") == SHAPES  # parts are made from a URDF, never written
    assert get_args(drawing_tables.LinkKind) == LINK_KINDS


def test_kinds_in_messages_are_those_of_the_schema():
    for key in ("model", "force"):
        entry = SCHEMA["properties"][key]
        tagged = entry.get("items", entry)["discriminator"]["mapping"]
        assert [f'"{kind}"' in problems.KINDS[key] for kind in tagged] == [True] * len(tagged)
