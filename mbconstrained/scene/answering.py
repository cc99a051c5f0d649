"""How each command answers: it reads the scene, does the work, and leaves with the exit code that tells how it went."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from .scene import Scene

FINE, SCENE_WRONG, COMMAND_WRONG, NOT_TRUSTED = 0, 1, 2, 3


def answer(path: str, json: bool, work: Callable[[Scene], int | None], settings: Sequence[str] | None = None) -> None:
    """Read the scene, do the work, and leave with the exit code that says how it went."""
    values = dict(_setting(text) for text in settings or ())
    leave(Path(path).name, json, lambda: work(_read(path, values)))


def _setting(text: str) -> tuple[str, Any]:
    """Name and value of a --set."""
    from .settings import value_of

    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        raise typer.BadParameter(f'found "{text}"; expected NAME=VALUE, e.g. k="3 N/mm" or time.end=20', param_hint="--set")
    return name, value_of(value)


def leave(name: str, json: bool, work: Callable[[], int | None]) -> None:
    """Do the work on what has this name, and leave with the exit code that says how it went."""
    from ..errors import MbconstrainedError, SceneError
    from .printing import show_error

    try:
        code = work() or FINE
    except MbconstrainedError as problem:
        named = str(problem) if isinstance(problem, SceneError) else f"{name}: {problem}"
        code = show_error(named, json, SCENE_WRONG)
    except OSError as problem:
        code = show_error(f"the results cannot be written: {_cause(problem)}", json, COMMAND_WRONG)
    except MemoryError:
        code = show_error(f"{name}: this needs more memory than there is; ask for fewer points", json, SCENE_WRONG)
    raise typer.Exit(code)


def _cause(problem: OSError) -> str:
    """The file and what the system says of it."""
    return f"{problem.filename}: {problem.strerror}" if problem.filename and problem.strerror else str(problem)


def _read(path: str, settings: Mapping[str, Any]) -> Scene:
    """The scene; what the system says while it is read is about the scene, not about the results."""
    from ..errors import SceneError
    from .scene import read_scene

    try:
        return read_scene(path, settings)
    except OSError as problem:
        raise SceneError(f"{Path(path).name}: the scene or a file of it cannot be read: {_cause(problem)}") from None
