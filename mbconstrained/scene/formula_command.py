"""The command formula: what it prints and writes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError
from .formula import DIGITS, formula_of, parameters_text, written
from .printing import show_text, step_progress

if TYPE_CHECKING:
    from ..exact.formulas import ClosedForm
    from .scene import Scene


def show_formula(
    scene: Scene, kind: str, numbers: bool, digits: int | None, coordinates: Sequence[str], out: str, seconds: float
) -> None:
    """The formula of a scene, printed or written into a file.

    Raises:
        InputError: there is no such formula, digits without numbers.
        OSError: the file cannot be written.
    """
    if digits is not None and not numbers:
        raise InputError("--digits is of the decimals with --numbers; add --numbers")
    with step_progress() as progress:
        form = formula_of(scene, numbers=numbers, coordinates=coordinates or None, seconds=seconds, progress=progress)
    text = written(form, kind, (digits or DIGITS) if numbers else None)
    if kind == "text":
        text = "\n\n".join(filter(None, [form.title, text, _notes(form, scene)]))
    if out:
        _write(Path(out), text + "\n", scene.path)
    else:
        show_text(text)


def _notes(form: ClosedForm, scene: Scene) -> str:
    notices = [str(notice) for notice in scene.notices]
    return "\n".join(filter(None, [parameters_text(form), form.step_note, *notices]))


def _write(path: Path, text: str, scene: Path) -> None:
    from ..replacing import replacing

    path = path.resolve()  # a link stays, the file that it leads to is replaced
    if path.exists() and path.samefile(scene):
        raise InputError(f"--out: {path.name} is the scene itself; give another file")
    if path.exists() and not path.is_file():  # a terminal or another device is written to
        path.write_text(text, encoding="utf-8")
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")
