"""Plain tables from a file; every error of the file itself becomes one message."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import NamedTuple

from ...ground.checks import nearest
from ...ground.errors import InputError, SceneError, quoted, shown

LARGEST_SCENE = 1_000_000  # bytes; larger matrices belong into files next to the scene
DEEPEST_NAME = 40  # parts of a dotted name; tomllib needs quadratic time for longer ones
_DOTTED = re.compile(rf"""(?<![\w-])(?:(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){{{DEEPEST_NAME}}}""")


class FileKind(NamedTuple):
    """Texts about a kind of file: its minimal content, and what a too large one is."""

    least: str
    large: str


SCENE = FileKind(
    "a scene has at least [model] and [time]",
    "which is no scene; keep large matrices in files (.npz, .mat, .mtx, .csv) next to it",
)


def read_text(path: Path, kind: FileKind = SCENE) -> str:
    """The text of a scene file, or of another file in the same format."""
    content = _content(path)
    if len(content) > LARGEST_SCENE:
        raise SceneError(f"{path.name}: the file has more than {LARGEST_SCENE:,} bytes, {kind.large}")
    if not content.strip():
        raise SceneError(f"{path.name}: the file is empty; {kind.least}")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        line = content.count(b"\n", 0, problem.start) + 1
        raise SceneError(f"{path.name}: line {line} is not UTF-8 text; save the file with the encoding UTF-8") from None


def _content(path: Path) -> bytes:
    try:
        if path.is_dir():
            raise SceneError(f"{path.name or path}: this is a directory; give the scene file in it{_scenes_in(path)}")
        if path.exists() and not path.is_file():
            raise SceneError(f"{path.name}: this is not a file; give a scene file")
        with open(path, "rb") as file:
            return file.read(LARGEST_SCENE + 1)
    except FileNotFoundError:
        raise SceneError(f"{path}: there is no such file{_near(path)}") from None
    except SceneError:  # a ValueError as well
        raise
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or str(problem)
        raise SceneError(f"{quoted(str(path))}: the file cannot be read ({reason})") from None


def _scenes_in(folder: Path) -> str:
    names = sorted(path.name for path in folder.glob("*.toml"))[:5]
    return f", e.g. {', '.join(names)}" if names else ""


def _near(path: Path) -> str:
    return nearest(path.name, [other.name for other in path.parent.glob("*.toml")]) if path.parent.is_dir() else ""


def parse(text: str, name: str) -> dict:
    """The tables of a TOML text."""
    if _DOTTED.search(text):
        raise SceneError(f"{name}: a name of more than {DEEPEST_NAME} parts joined by dots; a scene nests far less")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        raise SceneError(f"{name}: not a TOML file: {_readable(problem, text)}") from None
    except ValueError:  # whole numbers of thousands of digits
        raise SceneError(f"{name}: a number with far too many digits") from None
    except RecursionError:
        raise SceneError(f"{name}: arrays or tables are nested too deeply; a scene needs three or four levels") from None


_TEXT = 'a text such as "3 N/mm" needs quotes'
_MEANINGS = {  # messages of tomllib: their meaning to somebody who writes a scene
    "Cannot overwrite a value": "a key is given twice",
    "Expected newline or end of document after a statement": f"expected one value on the line; {_TEXT}",
    "Invalid value": f"this is no value; {_TEXT}, an array needs its closing bracket",
    "Invalid statement": 'expected [table], [[table]] or key = value, as in end = "5 s"',
    "Expected '=' after a key in a key/value pair": 'expected = between a key and its value, as in end = "5 s"',
    "Illegal character '\\n'": "a text ends with the quote that it begins with, on the same line",
}
_SIGNS = (  # the error of a line with this pattern
    (r"[\u201c\u201d\u201e\u2018\u2019]", 'quotes must be straight, "…"'),
    (r"=\s*[+-]?\d+,\d", "decimals have a point, as in 0.5"),
    (r"^\s*(\[[A-Za-z_][\w.-]*|\[\[[A-Za-z_][\w.-]*\s*\]?)\s*$",
     "a table ends with as many brackets as it begins with, [time], [[model.mass]]"),
)  # fmt: skip


_BOTH = "[{0}] and [[{0}]] stand in one file; write double brackets, [[{0}]], once for every entry"


def _is_both(text: str, table: str) -> bool:
    """Whether a table is used with single and with double brackets."""
    name = rf"[ \t]*{re.escape(table)}[ \t]*"  # blanks of one line only: across empty lines each start would search all of them
    heads = (rf"^[ \t]*{brackets}[ \t\r]*(#.*)?$" for brackets in (rf"\[{name}\]", rf"\[\[{name}\]\]"))
    return all(re.search(head, text, re.MULTILINE) for head in heads)


def _readable(problem: tomllib.TOMLDecodeError, text: str) -> str:
    """The parser's sentence in plain words, with its line."""
    if text.lstrip().startswith(("{", "<")):
        return 'it looks like JSON or XML; a scene has tables, [model], and below them lines such as kind = "lumped"'
    message, _, place = str(problem).partition(" (at ")
    line = re.match(r"line (\d+)", place)  # or the end of the document
    lines = text.split("\n")[: int(line[1])] if line else text.rstrip().split("\n")
    if (head := re.fullmatch(r"\s*\[+([^\[\]]+)\]+\s*(#.*)?", lines[-1])) and _is_both(text, head[1].strip()):
        return f"{_BOTH.format(head[1].strip())}; at {place.rstrip(')')}"
    message = _MEANINGS.get(message, message)
    if twice := re.fullmatch(r"Cannot declare \((.*)\) twice", message):
        table = ".".join(re.findall("'([^']*)'", twice[1]))
        message = f"the table [{table}] stands there twice; write it once"
    message = next((words for sign, words in _SIGNS if re.search(sign, lines[-1])), message)
    return f"{message}; at {place.rstrip(')')}, near {quoted(lines[-1].strip()[:60])}" if place else message


def inside(folder: Path, name: str, rule: str, expected: str) -> Path:
    """The path of a file in a folder."""
    if not name or not name.isprintable():
        raise InputError(f"found {shown(name)}; expected {expected}")
    if Path(name).is_absolute():
        raise InputError(f"found {shown(name)}, an absolute path; {rule}")
    folder = folder.resolve()
    try:
        path = (folder / name).resolve()
    except (OSError, RuntimeError):  # Python before 3.13 has the second for a circle of links
        raise InputError(f"found {shown(name)}, which is a link that leads in a circle; name the file itself") from None
    if not path.is_relative_to(folder):
        raise InputError(f"found {shown(name)}, which leads out of the folder; {rule}")
    return path
