"""The commands random and shock: responses to random excitation, and peaks under a shock."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .answer import FINE, NOT_TRUSTED, Compress, Json, Out, ScenePath, Settings, SharedViewer, answer, leave
from .commands import viewer_of

if TYPE_CHECKING:
    from ..scene.run.frequency.scene_random import SceneRandom
    from ..scene.run.frequency.scene_shock import SceneShock
    from ..scene.run.scene import Scene

Plots = Annotated[bool, typer.Option("--plots", help="Write the plots as SVG and PNG too.")]


def add_to(app: typer.Typer) -> None:
    """Give the command line the two commands."""
    app.command("random", short_help="Random vibration: RMS values, spectra, expected largest values.")(_random)
    app.command("shock", short_help="Peaks under a shock, shock response spectra.")(_shock)


def _random(
    scene: ScenePath,
    out: Out = "",
    plots: Plots = False,
    shared_viewer: SharedViewer = False,
    compress: Compress = False,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """The stationary response to the spectra of the table [random]: RMS values, rates, expected largest values.

    Variances are exact integrals, not sums over a grid; one that is infinite is reported with its reason. Writes NAME.random.html,
    .csv and .npz."""
    viewer = viewer_of(shared_viewer, compress)

    def work(loaded: Scene) -> int:
        from ..scene.run.frequency.scene_random import SceneRandom

        return _written(SceneRandom(loaded.with_viewer(viewer) if viewer else loaded), out, plots, json)

    answer(scene, json, work, settings)


def _shock(
    source: Annotated[
        str, typer.Argument(metavar="SCENE|RECORD", help="A scene, a .toml; or a file with an acceleration over time.")
    ],
    damping: Annotated[str, typer.Option("--damping", metavar="Z", help="Damping ratio of the oscillators, 0.05 by default.")] = "",
    quality: Annotated[str, typer.Option("--quality", metavar="Q", help="Instead: Q = 1 / (2 Z).")] = "",
    quantity: Annotated[str, typer.Option("--quantity", metavar="NAME", help="absolute acceleration, pseudo-velocity, …")] = "",
    lowest: Annotated[str, typer.Option("--from", metavar="F", help="The lowest natural frequency, in Hz.")] = "",
    highest: Annotated[str, typer.Option("--to", metavar="F", help="The highest natural frequency.")] = "",
    tripartite: Annotated[bool, typer.Option("--tripartite", help="The tripartite plot of the pseudo-velocity, too.")] = False,
    unit: Annotated[
        str, typer.Option("--unit", metavar="UNIT", help='Of a record, e.g. g or "mm/s^2"; by default that in its header.')
    ] = "",
    column: Annotated[str, typer.Option("--column", metavar="NAME", help="Of a record, by number or name; 2 by default.")] = "",
    step: Annotated[str, typer.Option("--step", metavar="TIME", help="Between samples of a record without times.")] = "",
    out: Out = "",
    plots: Plots = False,
    shared_viewer: SharedViewer = False,
    compress: Compress = False,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Peaks with their times of every coordinate, reaction and force of an element, and the shock response spectrum of a support.

    Peaks are those of the closed-form motion, none is missed between samples. Of a record, a file with columns of times and
    accelerations, the spectrum alone. Writes NAME.shock.html, .csv, .peaks.csv and .npz."""
    from ..scene.quantities.settings import value_of

    given = {"damping_ratio": damping, "quality_factor": quality, "from": lowest, "to": highest}
    options: dict = {key: value_of(text) for key, text in given.items() if text}
    options |= {"quantity": quantity} if quantity else {}
    options |= {"tripartite": True} if tripartite else {}
    reading: dict = {"unit": unit or None, "column": int(column) if column.isdigit() else column or None, "step": step or None}
    viewer = viewer_of(shared_viewer, compress)
    if Path(source).suffix.lower() == ".toml":
        if used := [key for key, value in reading.items() if value is not None]:
            raise typer.BadParameter("it belongs to a record; a scene has its units in its tables", param_hint=f"--{used[0]}")
        answer(
            source,
            json,
            lambda loaded: _shock_of_scene(loaded.with_viewer(viewer) if viewer else loaded, options, out, plots, json),
            settings,
        )
    if settings:
        raise typer.BadParameter("values are set in a scene; this is a record", param_hint="--set")

    def work() -> int:
        from ..scene.quantities.quantities import quantity as in_si
        from ..scene.run.frequency.scene_response import with_options
        from ..scene.run.frequency.scene_shock import SceneShock

        table = with_options(None, "shock", options, Path(source).name)
        own = {**reading, "step": in_si(step, "s") if step else None, "unit": unit or None}
        return _written(SceneShock.of_record(Path(source), table, **own), out, plots, json)

    leave(Path(source).name, json, work)


def _shock_of_scene(scene: Scene, options: dict, out: str, plots: bool, json: bool) -> int:
    from ..scene.run.frequency.scene_response import with_options
    from ..scene.run.frequency.scene_shock import SceneShock

    table = with_options(scene.table.shock, "shock", options, scene.file_name)
    return _written(SceneShock.of_scene(scene, table), out, plots, json)


def _written(response: SceneRandom | SceneShock, out: str, plots: bool, json: bool) -> int:
    """Write the files of a response and print it; the exit code."""
    from .printing import show

    response.write(Path(out or Path("results") / response.name), images=plots or response.output.plot_images)
    show(json, response.as_json, response.blocks)
    return FINE if response.is_trusted else NOT_TRUSTED
