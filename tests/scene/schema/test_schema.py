"""The schema as editors will get it: complete, described, closed."""

import contextlib
import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from pydantic import ValidationError

from mbconstrained.cli import new
from mbconstrained.ground.errors import InputError, SceneError
from mbconstrained.scene.run.scene import read_scene
from mbconstrained.scene.schema.entry_types import KINDS_OF_ENTRIES, Table
from mbconstrained.scene.schema.scene_schema import SceneFile, robot_schema, scene_schema
from tests.scene.scenes import EXAMPLES, OSCILLATOR, scene_of

TEMPLATES = Path(new.__file__).parent / "templates"
SCENES = sorted([*EXAMPLES.glob("*.toml"), *(path for path in TEMPLATES.glob("*.toml") if not path.name.endswith(".robot.toml"))])


SCHEMA = SceneFile.model_json_schema()
CHECK = Draft202012Validator(scene_schema())


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


def test_kinds_in_messages_are_those_of_the_schema():
    for key in ("model", "force", "motion"):
        entry = SCHEMA["properties"][key]
        tagged = entry.get("items", entry)["discriminator"]["mapping"]
        assert [f'"{kind}"' in KINDS_OF_ENTRIES[key] for kind in tagged] == [True] * len(tagged)


def data_of(path: Path) -> dict:
    return tomllib.loads(path.read_text(encoding="utf-8"))


def test_the_schema_of_a_robot_toml_is_complete_and_every_robot_fits_it():
    schema = robot_schema()
    tables_are_closed_and_described(schema)
    references_lead_somewhere(schema)
    check = Draft202012Validator(schema)
    robots = [*(EXAMPLES.parent / "robots").glob("*/robot.toml"), *TEMPLATES.glob("*.robot.toml")]
    assert len(robots) > 10
    assert {path: [error.message for error in check.iter_errors(data_of(path))] for path in robots} == {path: [] for path in robots}
    right = data_of(robots[0])
    for wrong in ({"urdff": "a.urdf"}, {"base": "fre"}, {"joint_damping": {"j": "3,5"}}, {"loop": {"body1": "a"}}):
        assert not check.is_valid({**right, **wrong})


def test_the_schema_is_one_and_every_key_has_title_description_and_unit():
    Draft202012Validator.check_schema(CHECK.schema)
    tables = {"the file": CHECK.schema, **CHECK.schema["$defs"]}
    entries = {f"{name}.{key}": entry for name, table in tables.items() for key, entry in table["properties"].items()}
    assert [name for name, entry in entries.items() if not (entry.get("title") and entry.get("description"))] == []
    for name, unit in (
        ("MassTable.mass", "kg"),
        ("SpringTable.rest_length", "m"),
        ("TimeTable.end", "s"),
        ("GearTable.radii", "m"),
    ):
        assert entries[name]["unit"] == unit and entries[name]["examples"], name
    assert entries["SpringTable.stiffness"]["description"].endswith(
        'In N/m, or a text with a unit of a stiffness, such as "3 N/mm".'
    )


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_every_example_and_template_is_valid(path):
    assert [error.message for error in CHECK.iter_errors(data_of(path))] == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("[initial]", "[inital]"), ("[[model.mass]]", "[model.mass]"), ("[[model.spring]]", "[[model.springs]]"),
        ('end = "5 s"', ""), ("points = 11", "points = 1"), ("points = 11", 'points = "11"'), ('"2 kg"', '"2,5 kg"'),
        ('"2 kg"', '"2"'), ('"2 kg"', "true"), ('"lumped"', '"lumpd"'), ('["ground", "cart"]', '["ground"]'),
        ("stiffness", "stifness"), ("cart = 0.1", 'cart = "0,1 m"'), ("[time]", "[output]\npage = 1\n[time]"),
        ("[time]", '[output]\nplots = ["dsplacement"]\n[time]'), ("[time]", '[[force]]\ncoordinate = "cart"\nkind = "stp"\nvalue = 1\n[time]'),
    ],
)  # fmt: skip
def test_mistakes_are_marked_while_one_writes(old, new):
    assert old in OSCILLATOR and CHECK.is_valid(tomllib.loads(OSCILLATOR))
    assert not CHECK.is_valid(tomllib.loads(OSCILLATOR.replace(old, new, 1)))


@pytest.mark.parametrize(("arguments", "schema"), [([], CHECK.schema), (["--robot"], robot_schema())])
def test_the_command_prints_it(command, arguments, schema):
    code, out, _ = command("schema", *arguments)
    assert code == 0 and json.loads(out) == schema


VALUES = ("0", "-1", "1.5", '"x"', '""', "[]", "{}", "true", "nan", "inf", "1979-05-27")


@pytest.mark.parametrize(
    "key, table",
    [
        ("title", ""),
        ("points", "time"),
        ("end", "time"),
        ("scale", "drawing"),
        ("zoom", "drawing.view"),
        ("full_meshes", "drawing"),
    ],
)
def test_what_is_wrong_with_a_value_is_said_in_words_of_the_project(tmp_path, key, table):
    model = '[model]\nkind = "lumped"\nmass = [{ name = "a", mass = 1 }]\nspring = [{ between = ["ground", "a"], stiffness = 4 }]\n'
    own = "" if table == "time" else "[time]\nend = 1\n"
    refused = 0
    for value in VALUES:
        entry = f"[{table}]\n{key} = {value}\n" if table else f"{key} = {value}\n"
        entry += "end = 1\n" if (table, key) == ("time", "points") else ""
        (tmp_path / "scene.toml").write_text(f"{model}{own}{entry}" if table else f"{entry}{model}{own}")
        try:
            read_scene(tmp_path / "scene.toml")
        except SceneError as problem:
            refused += 1
            text = str(problem)
            assert "scene.toml" in text and "nput should" not in text and "alid string" not in text, text
            assert "found" in text or "expected" in text, text
    assert refused >= 4


def test_bounds_of_fields_are_checked():
    """Every bound that a table declares refuses the number beyond it, whatever the type of the field."""
    accepted = []
    for table in tables_below(Table):
        for name, field in table.model_fields.items():
            for bound in field.metadata:
                for key, beyond in (("gt", -1), ("ge", -1), ("lt", 1), ("le", 1)):
                    if hasattr(bound, key):
                        with contextlib.suppress(ValidationError, InputError):
                            table.__pydantic_validator__.validate_assignment(
                                table.model_construct(), name, getattr(bound, key) + beyond
                            )
                            accepted.append(f"{table.__name__}.{name}")
    assert accepted == []


def tables_below(table):
    for one in table.__subclasses__():
        yield one
        yield from tables_below(one)


def test_times_are_needed_by_a_motion_alone(tmp_path, command):
    """Modes: sqrt(8 / 2) / (2 pi) Hz; sweep and frequency response have no motion either; a model that switches is linear in its phase."""
    scene = scene_of(tmp_path, OSCILLATOR.partition("[time]")[0])
    assert scene.modes().data["modes"][0]["frequency_hz"] == pytest.approx(1 / np.pi, rel=1e-12)
    assert scene.frequency(from_="0.1 Hz", to="1 Hz").is_trusted
    result = scene.sweep({"model.spring[1].stiffness": ["8 N/m", "32 N/m"]}).run()
    assert result.values("frequency 1") == pytest.approx([1 / np.pi, 2 / np.pi], rel=1e-12)
    for command_name in ("run", "plan", "shock"):
        code, _, error = command(command_name, scene.path)
        assert code == 1 and 'time: this table is missing, and a motion needs it: write [time], and below it end = "10 s"' in error
    code, out, _ = command("check", scene.path)
    assert code == 0 and "without [time], which a run needs" in " ".join(out.split())
    hopper = (EXAMPLES / "dropped_crate.toml").read_text(encoding="utf-8")
    tables = [text for text in re.split(r"\n(?=\[)", hopper) if not text.startswith("[time]")]
    assert scene_of(tmp_path, "\n".join(tables)).modes().is_trusted
