"""The command sensitivity: derivatives of frequencies and damping with respect to parameters and elements."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from .answer import Json, ScenePath, Settings, answer

if TYPE_CHECKING:
    from ..scene.run.scene import Scene


def add_to(app: typer.Typer) -> None:
    """Give the command line the commands."""
    app.command("sensitivity", short_help="Derivatives of frequencies and damping, sorted by influence.")(_sensitivity)


def _sensitivity(
    scene: ScenePath,
    names: Annotated[
        list[str] | None, typer.Option("--to", metavar="NAME", help="A parameter or an element; repeat it. All by default.")
    ] = None,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Compute changes of natural frequencies and damping per 1 % of each parameter or element, sorted by influence.

    Derivatives of eigenvalues and shapes in closed form; for defective ones exponents and coefficients of their splitting."""

    def work(loaded: Scene) -> None:
        from ..scene.run.modes.scene_sensitivities import SceneSensitivities
        from .printing import show

        sensitivities = SceneSensitivities(loaded, names or ())
        show(json, sensitivities.as_json, sensitivities.blocks)

    answer(scene, json, work, settings)
