"""The schema as editors will get it: complete, described, closed."""

import json
from typing import get_args

from mbconstrained.page.drawing import LINK_KINDS, SHAPES
from mbconstrained.scene import drawing_tables, problems
from mbconstrained.scene.schema import SceneFile

SCHEMA = SceneFile.model_json_schema()


def tables():
    yield "scene", SCHEMA
    yield from SCHEMA["$defs"].items()


def test_every_key_has_a_description_and_no_table_takes_unknown_keys():
    for name, table in tables():
        assert table["description"], name
        assert table["additionalProperties"] is False, name
        for key, entry in table["properties"].items():
            assert entry.get("description"), f"{name}.{key}"


def test_schema_is_json_and_its_references_lead_somewhere():
    text = json.dumps(SCHEMA)
    references = {part.split('"')[0] for part in text.split('"$ref": "')[1:]}
    assert references and {reference.removeprefix("#/$defs/") for reference in references} <= set(SCHEMA["$defs"])


def test_drawing_knows_the_shapes_and_links_of_the_page():
    assert get_args(drawing_tables.Shape) == SHAPES
    assert get_args(drawing_tables.LinkKind) == LINK_KINDS


def test_kinds_in_messages_are_those_of_the_schema():
    for key in ("model", "force"):
        entry = SCHEMA["properties"][key]
        tagged = entry.get("items", entry)["discriminator"]["mapping"]
        assert [f'"{kind}"' in problems.KINDS[key] for kind in tagged] == [True] * len(tagged)
