"""The formula of a scene: its parameters as symbols, its numbers exact, one expression in t for each coordinate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ..checks import nearest
from ..errors import InputError
from .time_limit import OutOfTime, time_limit

if TYPE_CHECKING:
    from ..exact.formulas import ClosedForm
    from .scene import Scene

#: Coordinates times degree beyond which exact arithmetic is not begun.
LARGEST = 60

#: Operations of all formulas together beyond which nobody reads them.
MOST_OPERATIONS = 20_000

#: Seconds after which the work is broken off, where no others are asked for.
SECONDS = 120.0

#: Operations in exact numbers of a formula that people still read.
SHORT = 80

#: The same for the formula on a page, which is not all that its reader is waiting for.
PAGE_SECONDS = 30.0

#: Digits of decimals, where no others are asked for.
DIGITS = 6

Progress = Callable[[str], None]


def formula_of(
    scene: Scene,
    *,
    numbers: bool = False,
    coordinates: Sequence[str] | None = None,
    seconds: float = SECONDS,
    progress: Progress | None = None,
) -> ClosedForm:
    """The formula of each coordinate, with impulses, jumps, conditions and assumptions.

    Args:
        scene: of any kind but robot.
        numbers: parameters are their default values from the start, so that nothing depends on the sign of a discriminant.
        coordinates: which of them; all when not given.
        seconds: after which the work is broken off.
        progress: told what is being done.

    Raises:
        InputError: a robot, an unknown coordinate, no closed form with symbols, too large.
    """
    _check_coordinates(scene, coordinates)
    _check_size(scene)
    try:
        with time_limit(seconds):
            found = _solved(scene, numbers, coordinates, progress or (lambda text: None))
    except OutOfTime:
        raise InputError(f"the formula is not found within {seconds:g} s; {_advice(scene, numbers)}") from None
    operations = sum(value.count_ops() for value in found.values)
    if operations > MOST_OPERATIONS:
        raise InputError(f"the formula has {operations} operations, which nobody can read; {_advice(scene, numbers)}")
    return found


def _solved(scene: Scene, numbers: bool, coordinates, progress: Progress) -> ClosedForm:
    try:
        return _formula(scene, numbers, coordinates, progress)
    except InputError as problem:
        if "closed form" in str(problem) and scene.parameters.values:
            symbols = ", ".join(scene.parameters.values)
            raise InputError(f"the zeros have no closed form in {symbols}; {_advice(scene, numbers)}") from problem
        if numbers or scene.parameters.values:
            raise
        return _formula(scene, True, coordinates, progress)  # pi, as in 2 pi f, was the only symbol


def _formula(scene: Scene, numbers: bool, coordinates, progress: Progress) -> ClosedForm:
    from ..exact.formulas.closed_form import ClosedForm
    from ..exact.formulas.implied import without_implied
    from ..exact.formulas.real_form import real_form
    from ..exact.formulas.symbols import Symbols
    from ..exact.symbolic import solve_symbolically
    from .exact_equations import exact_equations

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
        raise type(problem)(symbols.plain(str(problem))) from problem
    progress("signs with the default values")
    return real_form(symbols.finished(form))


def _check_coordinates(scene: Scene, names: Sequence[str] | None) -> None:
    known = scene.equations.coordinates.names
    if scene.table.model.kind == "state-space":
        known = (*scene.equations.control.system.states, *scene.equations.control.system.outputs)
    for place, name in enumerate(names or ()):
        if name in names[:place]:
            raise InputError(f'the coordinate "{name}" is asked for twice; name each once')
        if name not in known:
            raise InputError(f'there is no coordinate "{name}"{nearest(name, known)}; there are {", ".join(known)}')


def too_large(scene: Scene) -> str:
    """Why no formula is looked for; an empty text where one is."""
    A = scene.equations.polynomial_matrix
    if scene.equations.robot is not None or A.size * A.degree <= LARGEST:
        return ""
    return f"{A.size} coordinates with equations of degree {A.degree} are too many for formulas (at most {LARGEST} for both multiplied)"


def _check_size(scene: Scene) -> None:
    if reason := too_large(scene):
        raise InputError(f"{reason}; take a smaller model, or run the scene: its answer is evaluated at any time all the same")


def _advice(scene: Scene, numbers: bool) -> str:
    if scene.parameters.values and not numbers:
        return (
            "insert numbers for the symbols (mbconstrained formula --numbers), make fewer numbers parameters, or ask for fewer "
            "coordinates (--coordinates)"
        )
    return "ask for fewer coordinates (--coordinates), or run the scene: its answer is evaluated at any time all the same"


def is_short(form: ClosedForm) -> bool:
    """Whether people can read the exact numbers in it."""
    return all(value.count_ops() <= SHORT for value in form.values)


def parameters_text(form: ClosedForm) -> str:
    """Default values: m = 10 kg, k = 2; and the signs that the formula relies on."""
    given = (f"{p.name} = {float(p.value):.12g} {p.unit}".strip() for p in form.parameters if p.value is not None)
    text = ", ".join(given)
    return f"Default values: {text}. {_signs(form)}" if text else ""


def _signs(form: ClosedForm) -> str:
    negative = ", ".join(p.name for p in form.parameters if p.symbol.is_negative)
    return f"Parameters are taken as positive, {negative} as negative." if negative else "Parameters are taken as positive."


def written(form: ClosedForm, kind: str, digits: int | None = None) -> str:
    """The formula as "text", "latex", "python", "c" or "json"."""
    from ..exact import formulas

    if kind == "json":
        import json

        return json.dumps(as_json(form, digits), indent=2, allow_nan=False, ensure_ascii=False)
    if kind in ("python", "c"):
        return {"python": formulas.python_source, "c": formulas.c_source}[kind](form).rstrip("\n")
    return {"text": formulas.plain_text, "latex": formulas.latex}[kind](form, digits=digits)


def as_json(form: ClosedForm, digits: int | None = None) -> dict:
    """The formula as plain data: texts by coordinate, parameters, impulses, jumps, conditions, assumptions."""
    from ..exact.formulas.records import records

    return records(form, digits)
