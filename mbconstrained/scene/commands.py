"""The commands run, modes, formula, plan and check. What is heavy is imported by the command that needs it."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from .scene import Scene

LONGEST_WORK = 86400.0  # s, that anybody waits for a formula

FINE, SCENE_WRONG, COMMAND_WRONG, NOT_TRUSTED = 0, 1, 2, 3

HELP = """Closed-form motion of constrained mechanical systems, from a scene file to an animated page.

A scene is a text file (TOML): masses, springs, dampers, gears and constraints, or matrices; a start;
a time. The answer is not stepped but computed as a sum of t^k e^(a t) cos(w t + p), with jumps and
Dirac impulses at t = 0 where the start does not fit the constraints."""

EPILOG = """Examples:
  mbconstrained run examples/two_masses.toml     page, CSV and npz into results/two_masses/
  mbconstrained run bridge.toml --out work/b1    the same into another folder
  mbconstrained run bridge.toml --json           zeros, jumps, impulses, evidence for a program
  mbconstrained run bridge.toml --certify        how many digits are proved by exact arithmetic
  mbconstrained modes bridge.toml                frequencies, damping, shapes, who has the energy
  mbconstrained modes bridge.toml --page         the same with a page in which each mode moves
  mbconstrained formula bridge.toml --as python  the motion as a formula, here as a function of NumPy
  mbconstrained plan bridge.toml                 what would be computed, what not, and why
  mbconstrained plan bridge.toml --run           the same with the time and memory that each stage takes
  mbconstrained accuracy bridge.toml             error against run time, beside what one would use instead
  mbconstrained stability bridge.toml            digits right when masses, springs, ... are turned over decades
  mbconstrained stability                        the same for a gallery of stiff and extreme systems
  mbconstrained check bridge.toml                is the file right? nothing is solved or written

Exit codes:
  0  fine
  1  the scene is wrong: the message names the place, what was found and what was expected
  2  the command line is wrong, or the results cannot be written
  3  there is an answer, and it is written, but it cannot be trusted; a warning says why"""

app = typer.Typer(add_completion=False, no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False)

ScenePath = Annotated[str, typer.Argument(metavar="SCENE", help="The scene file, a .toml.")]
Json = Annotated[bool, typer.Option("--json", help="Print plain data (JSON) instead of text.")]
Out = Annotated[str, typer.Option("--out", metavar="DIR", help="Folder to write into; results/NAME_OF_SCENE if left out.")]


def _verbatim(text: str) -> str:
    """A help text that keeps its line breaks."""
    return "\n\n".join("\b\n" + block for block in text.split("\n\n"))


@app.callback(help=_verbatim(HELP), epilog=_verbatim(EPILOG))
def _group() -> None:
    pass


@app.command(short_help="Solve a scene and write its page, CSV and npz.")
def run(
    scene: ScenePath,
    out: Out = "",
    certify: Annotated[bool, typer.Option("--certify", help="Prove digits of the answer by exact arithmetic.")] = False,
    json: Json = False,
) -> None:
    """Solve a scene, write page, CSV and npz, and print what an engineer wants to know.

    With --certify the answer is held against intervals that exact arithmetic proves to contain the true values, for the
    coordinates named in [output] certify or coordinates, or for all; how many digits are proved is printed and stands on the page."""
    from .printing import show_result, stage_progress

    def work(found: Scene) -> int:
        found = found.certified() if certify else found
        with stage_progress() as progress:
            result = found.run(Path(out or Path("results") / found.name), progress)
        show_result(result, json)
        return FINE if result.is_trusted else NOT_TRUSTED

    answer(scene, json, work)


@app.command(short_help="List the modes of a scene, with shapes and energies.")
def modes(
    scene: ScenePath,
    page: Annotated[bool, typer.Option("--page", help="Write NAME.modes.html too, in which each mode moves.")] = False,
    out: Out = "",
    json: Json = False,
) -> None:
    """List the modes: frequencies, damping, what each means, who has its kinetic and strain energy, its shape.

    No motion is solved for, so that neither a start nor forces matter; a page is written only with --page."""
    from .printing import show_modes

    if out and not page:
        raise typer.BadParameter("only the page is written; give --page too", param_hint="--out")

    def work(found: Scene) -> int:
        from .modes import SceneModes

        answer = SceneModes(found)
        if page:
            answer.write_page(Path(out or Path("results") / found.name))
        show_modes(answer, json)
        return FINE if answer.is_trusted else NOT_TRUSTED

    answer(scene, json, work)


@app.command(short_help="List what would be computed, what not, and why.")
def plan(
    scene: ScenePath,
    run: Annotated[
        bool, typer.Option("--run", help="Run it too, into a temporary folder that is removed; tell what each stage took.")
    ] = False,
    json: Json = False,
) -> None:
    """List the stages that a scene needs, and those that are left out, each with its reason.

    Nothing is solved or written, but with --run: then all is done as by the command run, files are written into a temporary
    folder, so that writing counts too, and removed; each stage is listed with its time and memory. Exit codes are those of run."""
    from .printing import show_plan

    answer(scene, json, lambda found: _measured(found, json) if run else show_plan(found, json))


def _measured(scene: Scene, json: bool) -> int:
    from tempfile import TemporaryDirectory

    from .printing import show_costs, stage_progress

    with TemporaryDirectory(prefix="mbconstrained-") as folder:
        with stage_progress() as progress:
            result = scene.run(folder, progress)
        show_costs(result, json)
    return FINE if result.is_trusted else NOT_TRUSTED


@app.command(short_help="See whether a scene is right; solve nothing.")
def check(scene: ScenePath, json: Json = False) -> None:
    """Read a scene and see whether everything in it is right; solve nothing, write nothing."""
    from .printing import show_check

    answer(scene, json, lambda found: show_check(found, json))


class As(StrEnum):
    """How a formula is written."""

    TEXT, LATEX, PYTHON, C, JSON = "text", "latex", "python", "c", "json"


@app.command(short_help="The formula of each coordinate, with parameters as symbols.")
def formula(
    scene: ScenePath,
    kind: Annotated[As, typer.Option("--as", help="As what it is written.")] = As.TEXT,
    numbers: Annotated[
        bool, typer.Option("--numbers", help="Insert the default values of the parameters, write decimals.")
    ] = False,
    digits: Annotated[int | None, typer.Option("--digits", min=2, max=30, help="Of the decimals with --numbers; 6.")] = None,
    coordinates: Annotated[str, typer.Option("--coordinates", metavar="A,B", help="Only these coordinates.")] = "",
    out: Annotated[str, typer.Option("--out", metavar="FILE", help="Write into a file instead of printing.")] = "",
    seconds: Annotated[float, typer.Option("--seconds", min=1.0, max=LONGEST_WORK, help="Break off after so long.")] = 120.0,
    json: Json = False,
) -> None:
    """Print the formula of each coordinate: text, LaTeX, a function of Python (NumPy) or C, or plain data (JSON).

    The [parameters] of the scene are symbols in it; all other numbers are the decimals that they are written as."""
    from .formula_command import show_formula

    names = [name.strip() for name in coordinates.split(",") if name.strip()]
    kind = As.JSON if json else kind
    answer(scene, kind is As.JSON, lambda found: show_formula(found, kind.value, numbers, digits, names, out, seconds))


def answer(path: str, json: bool, work: Callable[[Scene], int | None]) -> None:
    """Read the scene, do the work, and leave with the exit code that says how it went."""
    leave(Path(path).name, json, lambda: work(_read(path)))


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
        code = show_error(f"the results cannot be written: {problem}", json, COMMAND_WRONG)
    except MemoryError:
        code = show_error(f"{name}: this needs more memory than there is; ask for fewer points", json, SCENE_WRONG)
    raise typer.Exit(code)


def _read(path: str) -> Scene:
    """The scene; what the system says while it is read is about the scene, not about the results."""
    from ..errors import SceneError
    from .scene import read_scene

    try:
        return read_scene(path)
    except OSError as problem:
        raise SceneError(f"{Path(path).name}: the scene or a file of it cannot be read: {problem}") from None
