"""The commands run, plan, check, new and schema; each imports what it needs when it is called."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..analyses import ANALYSES
from .analysis import Commands, File, Plots
from .answer import (
    COMMAND_WRONG,
    FINE,
    NOT_TRUSTED,
    Compress,
    DataFolders,
    Json,
    Out,
    Results,
    ScenePath,
    Settings,
    SharedViewer,
    Verbose,
    answer,
    leave,
    line_width,
    show,
    show_text,
    stage_progress,
    viewer_of,
)

if TYPE_CHECKING:
    from ..scene.run.scene import Scene

HELP = """Closed-form motion of constrained mechanical systems, from a scene file to an animated page.

A scene is a text file (TOML): masses, springs, dampers, gears and constraints, or matrices; a start;
a time. The answer is not stepped but computed as a sum of t^k e^(a t) cos(w t + p), with jumps and
Dirac impulses at t = 0 where the start does not fit the constraints."""

EPILOG = """Examples:
  mbconstrained new two-masses.toml              a scene to begin with, a comment on every line; --list: others
  mbconstrained run examples/two_masses.toml     page, CSV and npz into results/two_masses/
  mbconstrained run bridge.toml --verbose        all tables: eigenvalues, jumps, impulses, evidence, ...
  mbconstrained run bridge.toml --out work/b1    the same into another folder
  mbconstrained run bridge.toml --json           eigenvalues, jumps, impulses, evidence for a program
  mbconstrained run bridge.toml --set k="3 N/m"  another value of a parameter; --set time.end=20: of any entry
  mbconstrained run bridge.toml --plots          the plots as SVG and PNG too, for reports
  mbconstrained run bridge.toml --still 1.25s    a picture of the model at that time too, by an installed Chromium
  mbconstrained run bridge.toml --certify        digits proved by exact arithmetic
  mbconstrained run bridge.toml --compress       a page of less than half the size; --shared-viewer: one viewer for many
  mbconstrained compare a.toml b.toml            both runs, each in a folder of its own, their curves in common plots
  mbconstrained compare a.toml --set k=1,2       the same of one scene with several values
  mbconstrained modes bridge.toml                frequencies, damping, shapes, shares of energy
  mbconstrained modes bridge.toml --page         the same with a page in which each mode moves
  mbconstrained frequency bridge.toml            frequency response: peaks, antiresonances, Bode plots, values
  mbconstrained frequency bridge.toml --input base --output deck --quantity transmissibility --to "200 Hz"
  mbconstrained shock record.csv --quality 10    shock response spectrum of a record; of a scene its peaks, too
  mbconstrained formula bridge.toml --as python  the motion as a formula, here as a function of NumPy
  mbconstrained plan bridge.toml                 the stages of a run, taken or left out, and why
  mbconstrained plan bridge.toml --run           the same with the time and memory that each stage takes
  mbconstrained accuracy bridge.toml             error against run time, compared with other methods
  mbconstrained stability bridge.toml            correct digits when masses, springs, ... vary over decades
  mbconstrained stability                        the same for a gallery of stiff and extreme systems
  mbconstrained check bridge.toml                is the scene correct? nothing is written
  mbconstrained schema --out scene.schema.json   the JSON Schema of scenes for editors

Exit codes:
  0  fine
  1  the scene is wrong: the message names the place, what was found and what was expected
  2  the command line is wrong, or the results cannot be written
  3  there is an answer, and it is written, but it cannot be trusted; a warning gives the reason"""

app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _verbatim(text: str) -> str:
    """A help text that keeps its line breaks."""
    return "\n\n".join("\b\n" + block for block in text.split("\n\n"))


@app.callback(help=_verbatim(HELP), epilog=_verbatim(EPILOG))
def _group(version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False) -> None:
    """The option stands in the help; ``main`` answers it, before the commands are imported."""


@app.command("run", short_help=ANALYSES["run"][1])
def _run(
    scene: ScenePath,
    out: Out = "",
    certify: Annotated[bool, typer.Option("--certify", help="Prove digits of the answer by exact arithmetic.")] = False,
    plots: Plots = False,
    still: Annotated[str, typer.Option("--still", metavar="TIME", help="Write a picture of the model then too, as PNG.")] = "",
    shared_viewer: SharedViewer = False,
    compress: Compress = False,
    verbose: Verbose = False,
    settings: Settings = None,
    data_folder: DataFolders = None,
    json: Json = False,
) -> None:
    """Solve a scene, write page, CSV and npz, and print a summary of one screen: natural frequencies, warnings, files.

    With --certify the answer is compared with intervals that exact arithmetic proves to contain the true values, for the
    coordinates named in [output] certify or coordinates, or for all; how many digits are proved is printed and stands on the page."""
    from ..analyses.run import overview

    viewer, moment = viewer_of(shared_viewer, compress), _moment(still)

    def work(loaded: Scene) -> int:
        loaded = loaded.certified() if certify else loaded
        loaded = loaded.with_output(viewer=viewer) if viewer else loaded
        loaded = loaded.with_output(plot_images=True) if plots else loaded
        loaded = loaded if moment is None else loaded.with_still(moment)
        results = Results(loaded.path, out)
        with results.replacing() as files:
            with stage_progress() as progress:
                result = loaded.run(results.folder, progress)
            files += result.files
        show(json, result.to_dict, lambda: result.blocks() if verbose else overview(result, line_width()))
        return FINE if result.is_trusted else NOT_TRUSTED

    answer(scene, json, work, settings, data_folder)


@app.command("plan", short_help="List the stages of a run, needed or omitted, with the reasons.")
def _plan(
    scene: ScenePath,
    run: Annotated[
        bool, typer.Option("--run", help="Run it too, into a temporary folder that is removed; list the cost of each stage.")
    ] = False,
    settings: Settings = None,
    data_folder: DataFolders = None,
    json: Json = False,
) -> None:
    """List the stages that a scene needs, and those that are left out, each with its reason.

    Nothing is solved or written, but with --run: then all is done as by the command run, files are written into a temporary
    folder, so that writing counts too, and removed; each stage is listed with its time and memory. Exit codes are those of run."""
    from tempfile import TemporaryDirectory

    def work(loaded: Scene) -> int:
        if not run:
            plan = loaded.plan()
            show(json, lambda: {"title": loaded.heading, "plan": plan.to_list()}, lambda: [loaded.heading, plan.table()])
            return FINE
        with TemporaryDirectory(prefix="mbconstrained-") as folder, stage_progress() as progress:
            result = loaded.run(folder, progress)
        plan, doubts = result.plan, [notice for notice in result.notices if notice.doubtful]
        data: dict = {"title": loaded.heading, "plan": plan.to_list(), "totals": plan.totals_to_dict()}
        data |= {"notices": [notice.to_dict() for notice in doubts], "trusted": result.is_trusted}
        show(json, lambda: data, lambda: [loaded.heading, *plan.cost_tables(), *map(str, doubts)])
        return FINE if result.is_trusted else NOT_TRUSTED

    answer(scene, json, work, settings, data_folder)


@app.command("check", short_help="Check a scene; write nothing.")
def _check(scene: ScenePath, settings: Settings = None, data_folder: DataFolders = None, json: Json = False) -> None:
    """Read a scene and see whether everything in it is right; write nothing.

    It lists unconstrained bodies and, where the start violates the constraints, the jumps and impulses at t = 0."""
    from ..ground.checks import counted

    def work(loaded: Scene) -> None:
        from ..scene.run.result import start_notices

        names = loaded.equations.coordinates.names
        count = len(loaded.plan().needed) if loaded.table.time.is_given else None
        notices = [str(notice) for notice in (*loaded.notices, *start_notices(loaded.equations))]
        size = f"{counted(len(names), 'coordinate')} ({', '.join(names)}), {counted(count, 'stage') + ' to run' if count else WITHOUT_TIME}"
        lines = [f"{loaded.path.name} is fine: {loaded.title}", size, *notices]
        data = {"title": loaded.title, "coordinates": list(names), "stages": count, "notices": notices}
        show(json, lambda: data, lambda: ["\n".join(lines)])

    answer(scene, json, work, settings, data_folder)


WITHOUT_TIME = "without [time], which a run needs; modes and frequency responses do not"


def _moment(still: str) -> float | None:
    """The time of a still picture in s; None where there shall be none."""
    if not still:
        return None
    from ..ground.errors import InputError
    from ..ground.quantities import quantity
    from ..page.photograph import NONE_INSTALLED, browser
    from ..scene.file import value_of

    try:
        time = quantity(value_of(still), "s")
    except InputError as problem:
        raise typer.BadParameter(f"{problem}", param_hint="--still") from None
    if browser() is None:
        raise typer.BadParameter(f"{NONE_INSTALLED}; install one, or leave it out", param_hint="--still")
    return time


@app.command("new", short_help="Write a template of a scene, a comment on every line.")
def _new(
    file: Annotated[str, typer.Argument(metavar="FILE", help="The scene to write, a .toml; never one that is there.")] = "",
    template: Annotated[
        str, typer.Option("--template", metavar="NAME", help="Which; left out: the one that FILE is named after, or two-masses.")
    ] = "",
    listed: Annotated[bool, typer.Option("--list", help="List the templates.")] = False,
) -> None:
    """Write a scene from a template, in which a comment explains every line.

    A file that is there is never overwritten. Change the values, and ask mbconstrained check whether all is right."""
    from .new import template_table, write_template

    if not (listed or file):
        raise typer.BadParameter("give the name of the scene to write, e.g. two-masses.toml, or --list", param_hint="FILE")

    def work() -> int | None:
        if listed:
            show_text(template_table())
            return None
        try:
            written = write_template(Path(file), template)
        except FileExistsError as problem:
            typer.echo(f"{problem.filename}: there is such a file already, and it is left as it is; give another name", err=True)
            return COMMAND_WRONG
        show_text(written)
        return None

    leave(file, False, work)


@app.command("schema", short_help="Print the JSON Schema of scenes for editors.")
def _schema(
    out: File = "",
    robot: Annotated[bool, typer.Option("--robot", help="The schema of a robot.toml instead of that of a scene.")] = False,
) -> None:
    """Print the JSON Schema of scenes, or of a robot.toml: every key with description and unit, for completion and checks."""
    from ..scene.schema.scene_schema import EDITORS, schema_text

    def work() -> None:
        if not out:
            return show_text(schema_text(robot=robot))
        from ..ground.files import replacing

        with replacing(Path(out)) as temporary:
            temporary.write_text(schema_text(robot=robot) + "\n", encoding="utf-8")
        show_text(EDITORS.format(file=Path(out).as_posix(), name=Path(out).name, what="robot.toml" if robot else "scene"))

    leave(Path(out).name or "schema", False, work)
