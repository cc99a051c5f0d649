"""The command random: the response of a scene to random forces and random motions of supports."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .answer import FINE, NOT_TRUSTED, Compress, Json, Out, ScenePath, Settings, SharedViewer, answer
from .commands import viewer_of

if TYPE_CHECKING:
    from ..scene.run.scene import Scene


def add_to(app: typer.Typer) -> None:
    """Give the command line the command."""
    app.command("random", short_help="Random vibration: RMS values, spectra, expected largest values.")(_random)


def _random(
    scene: ScenePath,
    out: Out = "",
    plots: Annotated[bool, typer.Option("--plots", help="Write the plots as SVG and PNG too.")] = False,
    shared_viewer: SharedViewer = False,
    compress: Compress = False,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """The stationary response to the spectra of the table [random]: RMS values, rates, expected largest values.

    Variances are exact integrals, not sums over a grid; one that is infinite is reported with its reason. Writes NAME.random.html,
    .csv and .npz."""
    from .printing import show

    viewer = viewer_of(shared_viewer, compress)

    def work(loaded: Scene) -> int:
        from ..scene.run.random.scene_random import SceneRandom

        response = SceneRandom(loaded.with_viewer(viewer) if viewer else loaded)
        response.write(Path(out or Path("results") / loaded.name), images=plots or loaded.table.output.plot_images)
        show(json, response.as_json, response.blocks)
        return FINE if response.is_trusted else NOT_TRUSTED

    answer(scene, json, work, settings)
