"""The formula of each coordinate of a scene: its parameters as symbols, its numbers exact, one expression in t."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import BeforeValidator, Field

from ..ground.checks import nearest
from ..ground.errors import InputError
from ..scene.run.plan import OutOfTime, time_limit
from ..scene.run.scene_data import SceneData
from ..scene.run.stages import too_large_for_formula
from ..scene.schema.entry_types import Table
from .base import Analysis, Answer

if TYPE_CHECKING:
    from ..exact.closed_form import ClosedForm
    from ..page.content import Formulas
    from ..scene.run.scene import Scene

#: Most operations of all formulas together.
MOST_OPERATIONS = 20_000

#: Default seconds after which the work is broken off.
SECONDS = 120.0

#: Most operations in exact numbers of a readable formula.
SHORT = 80

#: The limit for the formula on a page.
PAGE_SECONDS = 30.0

#: Default digits of decimals.
DIGITS = 6

Progress = Callable[[str], None]


def formula_of(
    scene: SceneData,
    *,
    numbers: bool = False,
    coordinates: Sequence[str] | None = None,
    seconds: float = SECONDS,
    progress: Progress | None = None,
) -> ClosedForm:
    """The formula of each coordinate, with impulses, jumps, conditions and assumptions."""
    _check_coordinates(scene, coordinates)
    if reason := too_large_for_formula(scene):
        raise InputError(f"{reason}; take a smaller model, or run the scene: its answer is evaluated at any time all the same")
    try:
        with time_limit(seconds):
            form = _solved(scene, numbers, coordinates, progress or (lambda text: None))
    except OutOfTime:
        raise InputError(f"the formula is not found within {seconds:g} s; {_advice(scene, numbers)}") from None
    operations = sum(value.count_ops() for value in form.values)
    if operations > MOST_OPERATIONS:
        raise InputError(f"the formula has {operations} operations, which is unreadable; {_advice(scene, numbers)}")
    return form


def _solved(scene: SceneData, numbers: bool, coordinates, progress: Progress) -> ClosedForm:
    try:
        return _formula(scene, numbers, coordinates, progress)
    except InputError as problem:
        if "closed form" in str(problem) and scene.parameters.values:
            symbols = ", ".join(scene.parameters.values)
            raise InputError(f"the eigenvalues have no closed form in {symbols}; {_advice(scene, numbers)}") from problem
        if numbers or scene.parameters.values:
            raise
        return _formula(scene, True, coordinates, progress)  # pi, as in 2 pi f, was the only symbol


def _formula(scene: SceneData, numbers: bool, coordinates, progress: Progress) -> ClosedForm:
    from ..exact.closed_form import ClosedForm
    from ..exact.source_code import real_form
    from ..exact.symbolic.symbolic_response import solve_symbolically
    from ..exact.symbolic_equations import Symbols, without_implied
    from ..scene.build.symbolic_scene import exact_equations

    symbols = Symbols(scene.parameters.values, scene.parameters.units, numbers)
    try:
        progress("equations with symbols")
        equations = exact_equations(scene, symbols)
        progress("formula of the motion")
        x = solve_symbolically(equations.polynomial_matrix, equations.initial.tolist(), equations.force, symbols.time)
        progress("conditions on the start")
        form = ClosedForm.of(x).only(coordinates or equations.shown)
        form = replace(form, title=" ".join(scene.title.split()), **without_implied(form, x, equations.implied))
    except InputError as problem:
        raise type(problem)(symbols.readable(str(problem))) from problem
    progress("signs with the default values")
    return real_form(symbols.finished(form))


def _check_coordinates(scene: SceneData, names: Sequence[str] | None) -> None:
    known = scene.equations.coordinates.names
    if scene.table.model.kind == "state-space":
        known = (*scene.equations.control.system.states, *scene.equations.control.system.outputs)
    for place, name in enumerate(names or ()):
        if name in names[:place]:
            raise InputError(f'the coordinate "{name}" is named twice; name each once')
        if name not in known:
            raise InputError(f'there is no coordinate "{name}"{nearest(name, known)}; there are {", ".join(known)}')


def _advice(scene: SceneData, numbers: bool) -> str:
    if scene.parameters.values and not numbers:
        return (
            "insert numbers for the symbols (mbconstrained formula --numbers), make fewer numbers parameters, or ask for fewer "
            "coordinates (--coordinates)"
        )
    return "ask for fewer coordinates (--coordinates), or run the scene: its answer is evaluated at any time all the same"


def parameters_text(form: ClosedForm) -> str:
    """Default values, m = 10 kg, k = 2, and the signs that the formula assumes."""
    given = (f"{p.name} = {float(p.value):.12g} {p.unit}".strip() for p in form.parameters if p.value is not None)
    text = ", ".join(given)
    return f"Default values: {text}. {_signs(form)}" if text else ""


def _signs(form: ClosedForm) -> str:
    negative = ", ".join(p.name for p in form.parameters if p.symbol.is_negative)
    return f"Parameters are assumed positive, {negative} negative." if negative else "Parameters are assumed positive."


def formulas_on_page(form: ClosedForm) -> Formulas:
    """The section of a page with the formula: MathML, default values, assumed signs."""
    from ..exact.formula_printers import mathml
    from ..page.content import Formulas

    digits = None if form.parameters or all(value.count_ops() <= SHORT for value in form.values) else DIGITS
    notes = [parameters_text(form), "" if digits is None else f"Numbers to {digits} digits.", form.step_note]
    return Formulas("Formula", mathml(form, digits=digits), " ".join(filter(None, notes)))


#: Longest time that anybody waits for a formula, in s.
LONGEST_WORK = 86400.0


def _names(given) -> list[str]:
    texts = [given] if isinstance(given, str) else given
    return [name.strip() for text in texts for name in text.split(",") if name.strip()]


class FormulaOptions(Table):
    """The language of a formula, and what is in it."""

    language: Literal["text", "latex", "python", "c", "json"] = Field("text", alias="as", description="Output format.")
    numbers: bool = Field(False, description="Insert the default values of the parameters, write decimals.")
    digits: int | None = Field(None, ge=2, le=30, description="Digits of decimals with --numbers; 6 by default.")
    coordinates: Annotated[list[str], BeforeValidator(_names)] = Field([], description="Only these coordinates, A,B.")
    seconds: float = Field(SECONDS, ge=1.0, le=LONGEST_WORK, description="Time limit in s.")


class FormulaOfMotion(Analysis):
    """Print the formula of each coordinate: text, LaTeX, a function of Python (NumPy) or C, or plain data (JSON).

    The [parameters] of the scene are symbols in it; all other numbers are the decimals that they are written as.
    """

    name = "formula"
    handles_choices = True
    switches = "none"
    settings = FormulaOptions
    options: ClassVar = {"coordinates": "--coordinates"}
    formats = ("text",)
    progress = "steps"

    @classmethod
    def solve(cls, scene: Scene, settings: FormulaOptions | None, progress: Callable[[str], None] | None = None) -> Answer:
        from ..exact.formula_printers import records

        own = settings or FormulaOptions()
        if own.digits is not None and not own.numbers:
            raise InputError("--digits is of the decimals with --numbers; add --numbers")
        wanted, digits = own.coordinates or None, (own.digits or DIGITS) if own.numbers else None
        form = formula_of(scene, numbers=own.numbers, coordinates=wanted, seconds=own.seconds, progress=progress)
        notes = filter(None, [parameters_text(form), form.step_note, *map(str, scene.notices)])
        text = written(form, own.language, digits)
        parts = [form.title, text, "\n".join(notes)] if own.language == "text" else [text]
        return cls.of(scene, tables=(), data=records(form, digits), keys=(), text="\n\n".join(filter(None, parts)))


def written(form: ClosedForm, language: str, digits: int | None = None) -> str:
    from ..exact.formula_printers import formula_text, latex, records
    from ..exact.source_code import c_source, python_source

    if language == "json":
        return json.dumps(records(form, digits), indent=2, allow_nan=False, ensure_ascii=False)
    if language in ("python", "c"):
        return {"python": python_source, "c": c_source}[language](form).rstrip("\n")
    return {"text": formula_text, "latex": latex}[language](form, digits=digits)
