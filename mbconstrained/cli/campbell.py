"""The command campbell: eigenvalues, critical speeds and unbalance response of a rotor over its speed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from .answer import Json, Out, ScenePath, Settings, answer
from .studies import published

if TYPE_CHECKING:
    from ..scene.run.scene import Scene


def add_to(app: typer.Typer) -> None:
    """Give the command line the command."""
    app.command("campbell", short_help="Critical speeds, whirl, stability and unbalance response of a rotor.")(_campbell)


def _campbell(
    scene: ScenePath,
    lowest: Annotated[str, typer.Option("--from", metavar="SPEED", help='The lowest speed, such as "500 rpm"; 0 by default.')] = "",
    highest: Annotated[str, typer.Option("--to", metavar="SPEED", help="The highest; by default beyond all critical speeds.")] = "",
    points: Annotated[int, typer.Option("--points", metavar="N", help="How many speeds; 101 by default.")] = 0,
    order: Annotated[
        list[str] | None,
        typer.Option("--order", metavar="N", help="Of an excitation, a multiple of the speed; repeat it. 1 by default."),
    ] = None,
    out: Out = "",
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Eigenvalues of a rotor over its speed, each mode followed through crossings; critical speeds, limits of stability, unbalance response.

    Critical speeds come from one eigenproblem for each order, not from a search. The waterfall is a sequence of steady states. Writes
    NAME.campbell.html, .png and .json."""
    from ..scene.quantities.settings import value_of

    given = {"from": lowest, "to": highest, "points": points}
    options: dict = {key: value_of(text) if isinstance(text, str) else text for key, text in given.items() if text}
    options |= {"orders": [value_of(text) for text in order]} if order else {}

    def work(loaded: Scene) -> int:
        from ..scene.run.frequency.scene_response import with_options
        from ..studies.rotating.rotor_report import RotorReport

        table = with_options(loaded.table.campbell, "campbell", options, loaded.file_name)
        return published(lambda progress: RotorReport(loaded, table), loaded.name, "campbell", out, json)

    answer(scene, json, work, settings)
