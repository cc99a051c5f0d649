"""The formula of each coordinate, with the parameters of the scene as symbols."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import BeforeValidator, Field

from ..ground.errors import InputError
from ..scene.run.formula import DIGITS, SECONDS, formula_of, parameters_text
from ..scene.schema.entry_types import Table
from .base import Analysis, Answer

if TYPE_CHECKING:
    from ..exact.closed_form import ClosedForm
    from ..scene.run.scene import Scene

#: Longest time that anybody waits for a formula, in s.
LONGEST_WORK = 86400.0


def _names(given) -> list[str]:
    texts = [given] if isinstance(given, str) else given
    return [name.strip() for text in texts for name in text.split(",") if name.strip()]


class FormulaOptions(Table):
    """The language of a formula, and what is in it."""

    language: Literal["text", "latex", "python", "c", "json"] = Field("text", alias="as", description="Output format.")
    numbers: bool = Field(False, description="Insert the default values of the parameters, write decimals.")
    digits: int | None = Field(None, ge=2, le=30, description="Digits of decimals with --numbers; 6.")
    coordinates: Annotated[list[str], BeforeValidator(_names)] = Field([], description="Only these coordinates, A,B.")
    seconds: float = Field(SECONDS, ge=1.0, le=LONGEST_WORK, description="Time limit in s.")


class FormulaOfMotion(Analysis):
    """Print the formula of each coordinate: text, LaTeX, a function of Python (NumPy) or C, or plain data (JSON).

    The [parameters] of the scene are symbols in it; all other numbers are the decimals that they are written as.
    """

    name = "formula"
    settings = FormulaOptions
    options: ClassVar = {"coordinates": "--coordinates"}
    formats = ("text",)
    progress = "steps"

    @classmethod
    def solve(cls, scene: Scene, settings: FormulaOptions | None, progress: Callable[[str], None] | None = None) -> Answer:  # type: ignore[override]
        """The answer of a scene whose formula can be written.

        Raises:
            InputError: there is no such formula, digits without numbers.
        """
        from ..exact.formula_printers import records

        own = settings or FormulaOptions()
        if own.digits is not None and not own.numbers:
            raise InputError("--digits is of the decimals with --numbers; add --numbers")
        wanted, digits = own.coordinates or None, (own.digits or DIGITS) if own.numbers else None
        form = formula_of(scene, numbers=own.numbers, coordinates=wanted, seconds=own.seconds, progress=progress)
        notes = filter(None, [parameters_text(form), form.step_note, *map(str, scene.notices)])
        text = written(form, own.language, digits)
        parts = [form.title, text, "\n".join(notes)] if own.language == "text" else [text]
        return Answer(
            "formula",
            scene.name,
            scene.title,
            scene.table.source,
            (),
            (),
            scene.notices,
            records(form, digits),
            keys=(),
            text="\n\n".join(filter(None, parts)),
        )


def written(form: ClosedForm, language: str, digits: int | None = None) -> str:
    """The formula in a language."""
    from ..exact.formula_printers import formula_text, latex, records
    from ..exact.source_code import c_source, python_source

    if language == "json":
        return json.dumps(records(form, digits), indent=2, allow_nan=False, ensure_ascii=False)
    if language in ("python", "c"):
        return {"python": python_source, "c": c_source}[language](form).rstrip("\n")
    return {"text": formula_text, "latex": latex}[language](form, digits=digits)
