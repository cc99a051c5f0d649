"""The commands accuracy and stability."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .answer import FINE, NOT_TRUSTED, Json, Out, ScenePath, Settings, answer, leave

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ..scene.run.scene import Scene
    from ..studies.study_report import Progress, StudyReport


def add_to(app: typer.Typer) -> None:
    """Give the command line the two commands."""
    app.command("accuracy", short_help="Error against run time, compared with other tools.")(_accuracy)
    app.command("stability", short_help="Correct, expected and claimed digits over decades.")(_stability)


def _accuracy(
    scene: ScenePath,
    out: Out = "",
    seconds: Annotated[float, typer.Option("--seconds", min=0.1, max=3600.0, help="Time limit of a single run.")] = 5.0,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Measure error against run time: the methods of this package and those of other tools.

    The other tools are scipy's solve_ivp (DOP853, LSODA, Radau, BDF), odeint, steps with e^(S dt), scipy.signal.lsim and, where
    they are installed, python-control and IDA of scikit-sundae, each over its tolerances. Errors are measured with exact arithmetic. Writes
    NAME.accuracy.html, .png and .json."""

    def work(loaded: Scene) -> int:
        from ..studies.accuracy.accuracy_report import accuracy_report
        from ..studies.study_problem import problem_of

        return published(
            lambda progress: accuracy_report(problem_of(loaded), seconds=seconds, progress=progress),
            loaded.name,
            "accuracy",
            out,
            json,
        )

    answer(scene, json, work, settings)


def _stability(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="The scene file, a .toml; left out: the gallery.")] = "",
    out: Out = "",
    systems: Annotated[str, typer.Option("--systems", metavar="A,B", help="Only these systems of the gallery.")] = "",
    decades: Annotated[int, typer.Option("--decades", min=1, max=16, help="Scale a scene by 10^-N to 10^N.")] = 8,
    step: Annotated[int, typer.Option("--step", min=1, max=16, help="Decades from point to point.")] = 2,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Count the digits that are right, that the condition of the data allows, and that the error estimate claims.

    Without a scene this is done for the gallery of stiff and extreme systems; with one its masses, dampers, springs and its
    horizon are scaled over decades. Writes NAME.stability.html, .png and .json. The exit code is 3 if any answer was wrong without
    a warning."""
    if scene and systems:
        raise typer.BadParameter("give a scene or systems of the gallery, not both", param_hint="--systems")
    if settings and not scene:
        raise typer.BadParameter("values are set in a scene; name one", param_hint="--set")
    if scene:
        answer(scene, json, lambda loaded: _stability_of(loaded, decades, step, out, json), settings)
    leave("gallery", json, lambda: _stability_of_gallery([name.strip() for name in systems.split(",") if name.strip()], out, json))


def _stability_of(scene: Scene, decades: int, step: int, out: str, json: bool) -> int:
    from ..studies.stability.stability_report import scene_report

    return published(lambda progress: scene_report(scene, decades, step, progress), scene.name, "stability", out, json)


def _stability_of_gallery(names: list[str], out: str, json: bool) -> int:
    from ..studies.stability.gallery import system
    from ..studies.stability.stability_report import gallery_report

    systems = [system(name) for name in names]
    return published(lambda progress: gallery_report(systems, progress), "gallery", "stability", out, json)


def published(study: Callable[[Progress], StudyReport], name: str, kind: str, out: str, json: bool) -> int:
    """Run a study, write its files, print its report.

    Args:
        study: makes the report, and calls its argument as it proceeds.
        name, kind: name and kind of the files, NAME.KIND.html, ....
        out: the folder, or an empty text.
        json: whether plain data is printed.

    Returns:
        The exit code.
    """
    from ..studies.study_report import no_progress, writable
    from .printing import step_progress

    folder = writable(Path(out or Path("results") / name))
    with step_progress() as progress:
        report = study(progress or no_progress)
    return printed(report, report.write(folder, f"{name}.{kind}"), json, report.as_json)


def printed(report: StudyReport, files: Sequence[Path], json: bool, data: Callable[[], dict]) -> int:
    """Print a report and the names of its files.

    Args:
        report: report of a study.
        files: written files.
        json: whether plain data is printed.
        data: makes it.

    Returns:
        The exit code.
    """
    from .printing import show

    show(json, data, lambda: [*report.blocks, "\n".join(f"wrote {path}" for path in files)])
    return FINE if report.is_trusted else NOT_TRUSTED
