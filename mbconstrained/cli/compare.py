"""The command compare: several scenes, or one with several values, run and drawn in common plots."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .answer import FINE, NOT_TRUSTED, Json, leave, read, setting, several_values

if TYPE_CHECKING:
    from ..scene.run.scene import Scene

#: More runs than these are too many for one plot.
MOST_RUNS = 12

Scenes = Annotated[list[str], typer.Argument(metavar="SCENE...", help="Scene files, .toml; or one, with several values by --set.")]
Values = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=A,B,...", help="Run each scene with each of these values of a parameter or place."),
]
Folder = Annotated[str, typer.Option("--out", metavar="DIR", help="Folder to write into; results/compare by default.")]


def add_to(app: typer.Typer) -> None:
    """Give the command line the command."""
    app.command("compare", short_help="Run scenes, or one with several values, and overlay their curves.")(_compare)


def _compare(scenes: Scenes, out: Folder = "", settings: Values = None, json: Json = False) -> None:
    """Run several scenes, or one with several values of parameters, and draw each quantity of all runs in one plot.

    With --set zeta=0.02,0.13 each scene is run with both values. Every run writes its files into a folder of its own name inside
    the output folder, and compare.html has the common plots, at the times of the first run."""
    folder = Path(out or Path("results") / "compare")
    leave(", ".join(Path(path).name for path in scenes), json, lambda: _compared(scenes, settings or (), folder, json))


def _compared(paths: Sequence[str], settings: Sequence[str], folder: Path, json: bool) -> int:
    from ..page.html import write_page
    from ..scene.run.report.comparison import comparison, comparison_table
    from .printing import show

    scenes = dict(_runs(paths, settings))
    first = next(iter(scenes.values())).table.time
    results = []
    for label, scene in scenes.items():
        table = scene.table.model_copy(update={"time": first})
        results.append(_replaced(scene, table).run(folder / label))
    page = write_page(folder / "compare.html", comparison(list(scenes), results))
    files = [*(path for result in results for path in result.files), page]
    table = comparison_table(list(scenes), results)
    trusted = all(result.is_trusted for result in results)
    data = {"runs": {label: result.as_json() for label, result in zip(scenes, results)}, "files": [str(path) for path in files]}
    written = "\n".join(["Written", *(f"  {path}" for path in files)])
    show(json, lambda: {**data, "trusted": trusted}, lambda: [table, written])
    return FINE if trusted else NOT_TRUSTED


def _replaced(scene: Scene, table) -> Scene:
    from dataclasses import replace

    return replace(scene, table=table)


def _runs(paths: Sequence[str], settings: Sequence[str]) -> Iterator[tuple[str, Scene]]:
    """Every scene with every combination of values, by the name of its folder."""
    from ..ground.errors import InputError

    choices = [(setting(text)[0], several_values(text)) for text in settings]
    if len({name for name, _ in choices}) < len(choices):
        raise typer.BadParameter("a name is set twice; give all its values in one, e.g. k=1,2", param_hint="--set")
    combinations = list(product(*([(name, value) for value in values] for name, values in choices)))
    count = len(paths) * len(combinations)
    if not 2 <= count <= MOST_RUNS:
        raise InputError(
            f"found {count} run{'s' if count > 1 else ''}; expected 2 to {MOST_RUNS}: scenes, or values as in --set k=1,2"
        )
    labels: dict[str, int] = {}
    for path, combination in product(paths, combinations):
        chosen = [f"{name}={text}" for name, text in combination if len(combinations) > 1]
        label = re.sub(r"[^\w.=+-]+", "_", " ".join([*([Path(path).stem] if len(paths) > 1 or not chosen else []), *chosen]))
        labels[label] = labels.get(label, 0) + 1
        own = label if labels[label] == 1 else f"{label}_{labels[label]}"
        yield own, read(path, dict(setting(f"{name}={text}") for name, text in combination))
