"""The commands run, modes, plan, check and formula. What is heavy is imported by the command that needs it."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .answering import FINE, NOT_TRUSTED, answer

if TYPE_CHECKING:
    from .scene import Scene

LONGEST_WORK = 86400.0  # s, that anybody waits for a formula

HELP = """Closed-form motion of constrained mechanical systems, from a scene file to an animated page.

A scene is a text file (TOML): masses, springs, dampers, gears and constraints, or matrices; a start;
a time. The answer is not stepped but computed as a sum of t^k e^(a t) cos(w t + p), with jumps and
Dirac impulses at t = 0 where the start does not fit the constraints."""

EPILOG = """Examples:
  mbconstrained new two-masses.toml              a scene to begin with, a comment on every line; --list: others
  mbconstrained run examples/two_masses.toml     page, CSV and npz into results/two_masses/
  mbconstrained run bridge.toml --out work/b1    the same into another folder
  mbconstrained run bridge.toml --json           zeros, jumps, impulses, evidence for a program
  mbconstrained run bridge.toml --set k="3 N/m"  another value of a parameter; --set time.end=20: of any entry
  mbconstrained run bridge.toml --plots          the plots as SVG and PNG too, for reports
  mbconstrained run bridge.toml --still 1.25s    a picture of the model at that time too, by an installed Chromium
  mbconstrained run bridge.toml --certify        how many digits are proved by exact arithmetic
  mbconstrained run bridge.toml --compress       a page of less than half the size; --shared-viewer: one viewer for many
  mbconstrained modes bridge.toml                frequencies, damping, shapes, who has the energy
  mbconstrained modes bridge.toml --page         the same with a page in which each mode moves
  mbconstrained formula bridge.toml --as python  the motion as a formula, here as a function of NumPy
  mbconstrained plan bridge.toml                 what would be computed, what not, and why
  mbconstrained plan bridge.toml --run           the same with the time and memory that each stage takes
  mbconstrained accuracy bridge.toml             error against run time, beside what one would use instead
  mbconstrained stability bridge.toml            digits right when masses, springs, ... are turned over decades
  mbconstrained stability                        the same for a gallery of stiff and extreme systems
  mbconstrained check bridge.toml                is the file right? nothing is written
  mbconstrained schema --out scene.schema.json   what may stand in a scene, for editors (JSON Schema)

Exit codes:
  0  fine
  1  the scene is wrong: the message names the place, what was found and what was expected
  2  the command line is wrong, or the results cannot be written
  3  there is an answer, and it is written, but it cannot be trusted; a warning says why"""

app = typer.Typer(add_completion=False, no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False)

ScenePath = Annotated[str, typer.Argument(metavar="SCENE", help="The scene file, a .toml.")]
Json = Annotated[bool, typer.Option("--json", help="Print plain data (JSON) instead of text.")]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="NAME=VALUE", help="Take this value of a parameter, or of what stands at a place; repeat it for others."
    ),
]
SharedViewer = Annotated[
    bool, typer.Option("--shared-viewer", help="Write the 3-D viewer once beside the pages of a folder, not into each.")
]
Compress = Annotated[bool, typer.Option("--compress", help="Compress the scripts in the page, to a third; for new browsers.")]
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
    plots: Annotated[bool, typer.Option("--plots", help="Write the plots as SVG and PNG too.")] = False,
    still: Annotated[str, typer.Option("--still", metavar="TIME", help="Write a picture of the model then too, as PNG.")] = "",
    shared_viewer: SharedViewer = False,
    compress: Compress = False,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Solve a scene, write page, CSV and npz, and print what an engineer wants to know.

    With --certify the answer is held against intervals that exact arithmetic proves to contain the true values, for the
    coordinates named in [output] certify or coordinates, or for all; how many digits are proved is printed and stands on the page."""
    from .printing import show_result, stage_progress

    viewer, moment = _viewer(shared_viewer, compress), _moment(still)

    def work(found: Scene) -> int:
        found = found.certified() if certify else found
        found = found.with_viewer(viewer) if viewer else found
        found = found.with_plot_images() if plots else found
        found = found if moment is None else found.with_still(moment)
        with stage_progress() as progress:
            result = found.run(Path(out or Path("results") / found.name), progress)
        show_result(result, json)
        return FINE if result.is_trusted else NOT_TRUSTED

    answer(scene, json, work, settings)


@app.command(short_help="List the modes of a scene, with shapes and energies.")
def modes(
    scene: ScenePath,
    page: Annotated[bool, typer.Option("--page", help="Write NAME.modes.html too, in which each mode moves.")] = False,
    out: Out = "",
    shared_viewer: SharedViewer = False,
    compress: Compress = False,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """List the modes: frequencies, damping, what each means, who has its kinetic and strain energy, its shape.

    No motion is solved for, so that neither a start nor forces matter; a page is written only with --page."""
    from .printing import show_modes

    if out and not page:
        raise typer.BadParameter("only the page is written; give --page too", param_hint="--out")
    viewer = _viewer(shared_viewer, compress)

    def work(found: Scene) -> int:
        from .modes import SceneModes

        answer = SceneModes(found.with_viewer(viewer) if viewer else found)
        if page:
            answer.write_page(Path(out or Path("results") / found.name))
        show_modes(answer, json)
        return FINE if answer.is_trusted else NOT_TRUSTED

    answer(scene, json, work, settings)


@app.command(short_help="List what would be computed, what not, and why.")
def plan(
    scene: ScenePath,
    run: Annotated[
        bool, typer.Option("--run", help="Run it too, into a temporary folder that is removed; tell what each stage took.")
    ] = False,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """List the stages that a scene needs, and those that are left out, each with its reason.

    Nothing is solved or written, but with --run: then all is done as by the command run, files are written into a temporary
    folder, so that writing counts too, and removed; each stage is listed with its time and memory. Exit codes are those of run."""
    from .printing import show_plan

    answer(scene, json, lambda found: _measured(found, json) if run else show_plan(found, json), settings)


def _measured(scene: Scene, json: bool) -> int:
    from tempfile import TemporaryDirectory

    from .printing import show_costs, stage_progress

    with TemporaryDirectory(prefix="mbconstrained-") as folder:
        with stage_progress() as progress:
            result = scene.run(folder, progress)
        show_costs(result, json)
    return FINE if result.is_trusted else NOT_TRUSTED


@app.command(short_help="See whether a scene is right; write nothing.")
def check(scene: ScenePath, settings: Settings = None, json: Json = False) -> None:
    """Read a scene and see whether everything in it is right; write nothing.

    It tells which bodies nothing holds, and where the start does not fit the constraints, what will happen at t = 0."""
    from .printing import show_check

    answer(scene, json, lambda found: show_check(found, json), settings)


def _viewer(shared: bool, compressed: bool) -> str:
    """Where the viewer's script shall be, or an empty string where the scene says it."""
    if shared and compressed:
        raise typer.BadParameter("a viewer beside the page is not compressed; leave out one of the two", param_hint="--compress")
    return "beside" if shared else "compressed" if compressed else ""


def _moment(still: str) -> float | None:
    """The time of a still picture in s; None where there shall be none."""
    if not still:
        return None
    from ..errors import InputError
    from ..page.photograph import NONE_INSTALLED, browser
    from .settings import value_of
    from .units import quantity

    try:
        time = quantity(value_of(still), "s")
    except InputError as problem:
        raise typer.BadParameter(f"{problem}", param_hint="--still") from None
    if browser() is None:
        raise typer.BadParameter(f"{NONE_INSTALLED}; install one, or leave it out", param_hint="--still")
    return time


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
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Print the formula of each coordinate: text, LaTeX, a function of Python (NumPy) or C, or plain data (JSON).

    The [parameters] of the scene are symbols in it; all other numbers are the decimals that they are written as."""
    from .formula_command import show_formula

    names = [name.strip() for name in coordinates.split(",") if name.strip()]
    kind = As.JSON if json else kind
    written = (kind.value, numbers, digits, names, out, seconds)
    answer(scene, kind is As.JSON, lambda found: show_formula(found, *written), settings)
