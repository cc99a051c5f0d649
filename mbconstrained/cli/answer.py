"""Common parts of all commands: options, reading of the scene, exit codes."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from ..scene.run.scene import Scene

ScenePath = Annotated[str, typer.Argument(metavar="SCENE", help="The scene file, a .toml.")]
Json = Annotated[bool, typer.Option("--json", help="Print plain data (JSON) instead of text.")]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Override a parameter or a key of the scene; may be repeated."),
]
SharedViewer = Annotated[
    bool, typer.Option("--shared-viewer", help="Write the 3-D viewer once next to the pages of a folder, not into each.")
]
Compress = Annotated[bool, typer.Option("--compress", help="Compress the scripts in the page; needs a recent browser.")]
Out = Annotated[str, typer.Option("--out", metavar="DIR", help="Folder to write into; results/NAME_OF_SCENE by default.")]

_NUMBER = re.compile(r"[-+]?\.?\d")

FINE, SCENE_WRONG, COMMAND_WRONG, NOT_TRUSTED = 0, 1, 2, 3


def answer(path: str, json: bool, work: Callable[[Scene], int | None], settings: Sequence[str] | None = None) -> None:
    """Read the scene, do the work, and leave with the exit code of the outcome.

    Args:
        path: path of the scene.
        json: whether an error is printed as plain data.
        work: returns the exit code, or None for 0.
        settings: NAME=VALUE of each --set.
    """
    values: dict[str, Any] = {}
    for text in settings or ():
        name, value = setting(text)
        if len(several_values(text)) > 1 and all(map(_NUMBER.match, several_values(text))):
            raise typer.BadParameter(
                f'found several values in "{text}"; expected one. To run each of them: mbconstrained compare {path} --set "{text}"',
                param_hint="--set",
            )
        if name in values:
            raise typer.BadParameter(f'"{name}" is set twice; give it one value', param_hint="--set")
        values[name] = value
    leave(Path(path).name, json, lambda: work(read(path, values)))


def setting(text: str, option: str = "--set") -> tuple[str, Any]:
    """Name and value of a --set, or of another option of this form.

    Args:
        text: NAME=VALUE.
        option: for messages.

    Returns:
        Both, the value as it could stand in the file.

    >>> setting("k=3 N/mm")
    ('k', '3 N/mm')
    """
    from ..scene.quantities.settings import value_of

    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        raise typer.BadParameter(f'found "{text}"; expected NAME=VALUE, e.g. k="3 N/mm" or time.end=20', param_hint=option)
    return name, value_of(value)


def several_values(text: str) -> list[str]:
    """The values of a --set, separated by commas outside brackets and quotes.

    Args:
        text: NAME=VALUE or NAME=VALUE,VALUE.

    Returns:
        Their texts.

    >>> several_values("k=1 N/m, 2 N/m"), several_values("times=[0, 1]")
    (['1 N/m', '2 N/m'], ['[0, 1]'])
    """
    value = text.partition("=")[2]
    parts: list[str] = re.findall(r"""(?:\[[^\]]*\]|"[^"]*"|[^,\[\]"])+""", value) or [value]
    return [part.strip() for part in parts]


def leave(name: str, json: bool, work: Callable[[], int | None]) -> None:
    """Do the work, and leave with the exit code of the outcome.

    Args:
        name: name of the object of the work, for messages.
        json: whether an error is printed as plain data.
        work: returns the exit code, or None for 0.
    """
    from ..ground.errors import MbconstrainedError, SceneError
    from .printing import show_error

    try:
        code = work() or FINE
    except MbconstrainedError as problem:
        is_named = isinstance(problem, SceneError) or str(problem).startswith((f"{name}: ", f"{name}, line "))
        named = str(problem) if is_named else f"{name}: {problem}"
        code = show_error(named, json, SCENE_WRONG)
    except OSError as problem:
        code = show_error(f"the results cannot be written: {_cause(problem)}", json, COMMAND_WRONG)
    except MemoryError:
        code = show_error(f"{name}: this needs more memory than there is; ask for fewer points", json, SCENE_WRONG)
    raise typer.Exit(code)


def _cause(problem: OSError) -> str:
    """The file and the message of the system about it."""
    return f"{problem.filename}: {problem.strerror}" if problem.filename and problem.strerror else str(problem)


def read(path: str, settings: Mapping[str, Any]) -> Scene:
    """The scene; errors of the system while it is read are about the scene, not about the results.

    Args:
        path: path of the scene file.
        settings: values by the name of a parameter or place.

    Returns:
        The scene.

    Raises:
        SceneError: a file that cannot be read, or what it has is no scene.
    """
    from ..ground.errors import SceneError
    from ..scene.run.scene import read_scene

    try:
        return read_scene(path, settings)
    except OSError as problem:
        raise SceneError(f"{Path(path).name}: the scene or a file of it cannot be read: {_cause(problem)}") from None


def viewer_of(shared: bool, compressed: bool) -> str:
    """Location of the viewer's script, or an empty string for that in the scene.

    Args:
        shared: whether in a file that pages share.
        compressed: whether compressed in the page.

    Returns:
        A value of [output] viewer.
    """
    if shared and compressed:
        raise typer.BadParameter("a viewer in a separate file is not compressed; leave out one of the two", param_hint="--compress")
    return "separate" if shared else "compressed" if compressed else ""
