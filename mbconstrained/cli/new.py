"""Templates of scenes, in which a comment explains every line."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from ..ground.checks import nearest
from ..ground.display import TextTable, table_text
from ..ground.errors import InputError, quoted, shown
from ..scene.schema.scene_schema import ROBOT_SCHEMA_FILE, SCHEMA_FILE

DEFAULT = "two-masses"
ROBOT = "pendulum"  # the files next to the template of a robot are named after it
COMPANIONS = {"robot": (f"{ROBOT}.robot.toml", f"{ROBOT}.urdf")}
_FOLDER = files(__package__).joinpath("templates")


def template_names() -> tuple[str, ...]:
    """The names of all templates, the one to begin with first.

    >>> template_names()[0]
    'two-masses'
    """
    names = [file.name.removesuffix(".toml") for file in _FOLDER.iterdir() if file.name.endswith(".toml")]
    return tuple(sorted((name for name in names if "." not in name), key=lambda name: (name != DEFAULT, name)))


def template_text(name: str) -> str:
    if name not in template_names():
        known = template_names()
        raise InputError(f"--template: there is no template {shown(name)}{nearest(name, known)}; there are {', '.join(known)}")
    return _text(f"{name}.toml")


def template_table() -> str:
    """Table of all templates with a sentence each, the first line of each."""
    rows = tuple((name, template_text(name).splitlines()[0].removeprefix("# ")) for name in template_names())
    note = "Write one: mbconstrained new FILE --template NAME, or name the file after it."
    return table_text(TextTable("Templates", ("name", "what it shows"), rows, note))


def write_template(path: Path, template: str = "") -> str:
    """Write a template with its files where none of them is yet, and return their names and the next commands."""
    path = _scene_path(path)
    if not path.parent.is_dir():
        raise FileNotFoundError(None, "there is no such folder; make it first", str(path.parent))
    named = path.stem.replace("_", "-")
    template = template or (named if named in template_names() else DEFAULT)
    texts = {path: _with_schema(path, SCHEMA_FILE) + _named(template_text(template), path.stem)}
    for other in COMPANIONS.get(template, ()):
        schema = _with_schema(path, ROBOT_SCHEMA_FILE) if other.endswith(".toml") else ""
        texts[path.with_name(other.replace(ROBOT, path.stem, 1))] = schema + _named(_text(other), path.stem)
    for each in texts:
        if each.exists() or each.is_symlink():
            raise FileExistsError(None, "there is such a file already", str(each))
    for each, text in texts.items():
        with open(each, "x", encoding="utf-8") as file:
            file.write(text)
    written = ", ".join(map(str, texts))
    shown_path = f'"{path}"' if " " in str(path) else path
    return (
        f"{written} {'is' if len(texts) == 1 else 'are'} written from the template {template}. Next:\n\n"
        f"  mbconstrained run {shown_path}      and open the page that it names\n"
        f"  mbconstrained check {shown_path}    after each change: is everything right?"
    )


def _with_schema(path: Path, schema: str) -> str:
    """The line by which an editor finds the schema, if it is there."""
    return f"#:schema ./{schema}\n" if path.with_name(schema).is_file() else ""


def _scene_path(path: Path) -> Path:
    path = path if path.suffix == ".toml" else path.with_name(path.name + ".toml")
    if not path.stem or not path.name.isprintable() or {*path.name} & {*"\"'\\"}:
        raise InputError(f"found the name {quoted(path.name)}; expected one without quotes and backslashes, e.g. bridge.toml")
    return path


def _named(text: str, stem: str) -> str:
    """The text with the names of the files next to it after the scene."""
    return text.replace(f'"{ROBOT}.', f'"{stem}.')


def _text(file: str) -> str:
    return _FOLDER.joinpath(file).read_text(encoding="utf-8")
