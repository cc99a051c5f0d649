"""The commands accuracy and stability. What is heavy is imported by the command that needs it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..scene.answering import FINE, NOT_TRUSTED, answer, leave
from ..scene.commands import Json, Out, ScenePath, Settings

if TYPE_CHECKING:
    from ..scene import Scene


def add_to(app: typer.Typer) -> None:
    """Give the command line the two commands."""
    app.command(short_help="Error against run time, beside what one would use instead.")(accuracy)
    app.command(short_help="Digits right, expected and claimed, over decades.")(stability)


def accuracy(
    scene: ScenePath,
    out: Out = "",
    seconds: Annotated[float, typer.Option("--seconds", min=0.1, max=3600.0, help="Break off a single run after so long.")] = 5.0,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Measure error against run time: the closed form in each of its ways, and what one would use instead.

    That is scipy's solve_ivp (DOP853, LSODA, Radau, BDF), odeint, steps with e^(S dt), scipy.signal.lsim and, where they are
    installed, python-control and IDA of scikit-sundae, each over its tolerances. Errors are held against exact arithmetic. Writes
    NAME.accuracy.html, .png and .json."""

    def work(found: Scene) -> int:
        from ..scene.printing import say_blocks, say_json, step_progress
        from .accuracy.page import page_content, picture_of
        from .accuracy.report import accuracy_report
        from .accuracy.tables import blocks
        from .problem import problem_of
        from .writing import writable, write_report, written_lines

        folder = writable(Path(out or Path("results") / found.name))
        with step_progress() as tell:
            report = accuracy_report(problem_of(found), seconds=seconds, tell=tell or _silent)
        picture, data = picture_of(report), report.as_json()
        files = write_report(folder, f"{found.name}.accuracy", page_content(report, picture), [picture], data)
        say_json(data) if json else say_blocks([*blocks(report), written_lines(files)])
        return FINE if report.is_trusted else NOT_TRUSTED

    answer(scene, json, work, settings)


def stability(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="The scene file, a .toml; left out: the gallery.")] = "",
    out: Out = "",
    systems: Annotated[str, typer.Option("--systems", metavar="A,B", help="Only these systems of the gallery.")] = "",
    decades: Annotated[int, typer.Option("--decades", min=1, max=16, help="Turn a scene from 10^-N to 10^N times.")] = 8,
    step: Annotated[int, typer.Option("--step", min=1, max=16, help="So many decades from point to point.")] = 2,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Count the digits that are right, that the condition of the data allows, and that the error estimate claims.

    Without a scene this is done for the gallery of stiff and extreme systems; with one its masses, dampers, springs and its
    horizon are turned over decades. Writes NAME.stability.html, .png and .json. The exit code is 3 if any answer was wrong without
    a warning."""
    if scene and systems:
        raise typer.BadParameter("give a scene or systems of the gallery, not both", param_hint="--systems")
    if settings and not scene:
        raise typer.BadParameter("values are set in a scene; name one", param_hint="--set")
    if scene:
        answer(scene, json, lambda found: _stability_of(found, decades, step, out, json), settings)
    leave("gallery", json, lambda: _stability_of_gallery([name.strip() for name in systems.split(",") if name.strip()], out, json))


def _stability_of(scene: Scene, decades: int, step: int, out: str, json: bool) -> int:
    from ..scene.printing import step_progress
    from .stability.report import scene_report
    from .writing import writable

    folder = writable(Path(out or Path("results") / scene.name))
    with step_progress() as tell:
        report = scene_report(scene, decades, step, tell or _silent)
    return _show_stability(report, scene.name, folder, json)


def _stability_of_gallery(names: list[str], out: str, json: bool) -> int:
    from ..scene.printing import step_progress
    from .stability.gallery import system
    from .stability.report import gallery_report
    from .writing import writable

    systems, folder = [system(name) for name in names], writable(Path(out or Path("results") / "gallery"))
    with step_progress() as tell:
        report = gallery_report(systems, tell or _silent)
    return _show_stability(report, "gallery", folder, json)


def _show_stability(report, name: str, folder: Path, json: bool) -> int:
    from ..scene.printing import say_blocks, say_json
    from .stability.page import page_content, pictures_of
    from .stability.tables import blocks
    from .writing import write_report, written_lines

    pictures, data = pictures_of(report), report.as_json()
    files = write_report(folder, f"{name}.stability", page_content(report, pictures), pictures, data)
    say_json(data) if json else say_blocks([*blocks(report), written_lines(files)])
    return FINE if report.is_trusted else NOT_TRUSTED


def _silent(text: str) -> None:
    pass
