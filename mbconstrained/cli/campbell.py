"""The commands campbell, locus and path: eigenvalues of a rotor over its speed, of any model over a parameter, of a robot along a path."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from .answer import Json, Out, ScenePath, Settings, answer, setting
from .studies import published

if TYPE_CHECKING:
    from ..scene.run.scene import Scene


def add_to(app: typer.Typer) -> None:
    """Give the command line the three commands."""
    app.command("campbell", short_help="Critical speeds, whirl, stability and unbalance response of a rotor.")(_campbell)
    app.command("locus", short_help="Root locus: eigenvalues over a parameter, with break points.")(_locus)
    app.command("path", short_help="Frequencies of a robot along a path of one of its points.")(_path)


def _campbell(
    scene: ScenePath,
    lowest: Annotated[str, typer.Option("--from", metavar="SPEED", help='The lowest speed, such as "500 rpm"; 0 by default.')] = "",
    highest: Annotated[str, typer.Option("--to", metavar="SPEED", help="The highest; by default beyond all critical speeds.")] = "",
    points: Annotated[int, typer.Option("--points", metavar="N", help="Number of speeds; 101 by default.", show_default=False)] = 0,
    order: Annotated[
        list[str] | None,
        typer.Option("--order", metavar="N", help="Order of an excitation, a multiple of the speed; repeat it. 1 by default."),
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
        from ..scene.schema.analyses.options import with_options
        from ..studies.rotating.rotor_report import RotorReport

        table = with_options(loaded.table.campbell, "campbell", options, loaded.file_name)
        return published(lambda progress: RotorReport(loaded, table), loaded.name, "campbell", out, json)

    answer(scene, json, work, settings)


def _locus(
    scene: ScenePath,
    vary: Annotated[
        str, typer.Option("--vary", metavar="NAME=VALUES", help='A parameter or an element, such as "c=1..50 N*s/m:101".')
    ],
    out: Out = "",
    settings: Settings = None,
    json: Json = False,
) -> None:
    """The eigenvalues over a parameter, each branch followed, with the break points where two of them coalesce.

    Break points are solved for, not found on the grid of values. Writes NAME.locus.html, .png and .json."""
    name, values = setting(vary, "--vary")

    def work(loaded: Scene) -> int:
        from ..studies.rotating.locus_report import LocusReport, locus_values

        return published(
            lambda progress: LocusReport(loaded, loaded.root_locus(name, locus_values(loaded, name, values))),
            loaded.name,
            "locus",
            out,
            json,
        )

    answer(scene, json, work, settings)


def _path(
    scene: ScenePath,
    points: Annotated[int, typer.Option("--points", metavar="N", help="Number of points; 21 by default.", show_default=False)] = 0,
    out: Out = "",
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Natural frequencies of a robot along the table [path], its joints kept where the path needs them, each mode followed by its shape.

    Places out of reach are listed. Writes NAME.path.html, .png and .json."""

    def work(loaded: Scene) -> int:
        from ..studies.path_report import PathReport

        return published(lambda progress: PathReport(loaded, points), loaded.name, "path", out, json)

    answer(scene, json, work, settings)
