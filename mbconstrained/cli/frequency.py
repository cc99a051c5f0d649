"""The command frequency: the response of a scene to harmonic loads and prescribed motions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .answer import FINE, NOT_TRUSTED, Compress, Json, Out, ScenePath, Settings, SharedViewer, answer, viewer_of

if TYPE_CHECKING:
    from ..scene.run.scene import Scene

Names = list[str] | None


def add_to(app: typer.Typer) -> None:
    """Give the command line the command."""
    app.command("frequency", short_help="Frequency response: peaks, antiresonances, Bode plots.")(_frequency)


def _frequency(
    scene: ScenePath,
    inputs: Annotated[
        Names, typer.Option("--input", metavar="NAME", help="A coordinate, a force on it, or a prescribed motion; repeat it.")
    ] = None,
    outputs: Annotated[
        Names, typer.Option("--output", metavar="NAME", help="A coordinate or, of reactions, a row; repeat it.")
    ] = None,
    quantity: Annotated[str, typer.Option("--quantity", metavar="NAME", help="receptance, mobility, transmissibility, …")] = "",
    lowest: Annotated[str, typer.Option("--from", metavar="F", help='The lowest frequency, in Hz or as "600 rpm".')] = "",
    highest: Annotated[str, typer.Option("--to", metavar="F", help="The highest frequency.")] = "",
    out: Out = "",
    plots: Annotated[bool, typer.Option("--plots", help="Write the plots as SVG and PNG too.")] = False,
    shared_viewer: SharedViewer = False,
    compress: Compress = False,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Compute the frequency response: peaks, antiresonances, values, Bode plots.

    The steady-state response to loads Re(f e^(i w t)). Omitted options are those of the table [frequency] of the scene, or chosen:
    all prescribed motions or loaded coordinates, and frequencies placed by the poles, so that no peak is missed.
    Writes NAME.frequency.html, .csv and .npz."""
    from ..scene.quantities.settings import value_of
    from .printing import show

    given: dict = {"inputs": _names(inputs), "outputs": _names(outputs), "quantity": quantity or None}
    given |= {"from": value_of(lowest) if lowest else None, "to": value_of(highest) if highest else None}
    options = {key: value for key, value in given.items() if value is not None}
    viewer = viewer_of(shared_viewer, compress)

    def work(loaded: Scene) -> int:
        from ..scene.run.frequency.frequency_summary import as_json, blocks
        from ..scene.run.frequency.scene_frequency import SceneFrequency
        from ..scene.run.frequency.scene_response import with_options

        loaded = loaded.with_viewer(viewer) if viewer else loaded
        response = SceneFrequency(loaded, with_options(loaded.table.frequency, "frequency", options, loaded.file_name))
        response.write(Path(out or Path("results") / loaded.name), images=plots or loaded.table.output.plot_images)
        show(json, lambda: as_json(response), lambda: blocks(response))
        return FINE if response.is_trusted else NOT_TRUSTED

    answer(scene, json, work, settings)


def _names(texts: Names) -> Names:
    """The names of repeated options, each of which may list several with commas."""
    return [name.strip() for text in texts for name in text.split(",")] if texts else None
