"""The command compare: several scenes, or one with several values, run and drawn in common plots."""

from __future__ import annotations

import inspect
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


def command(analysis):
    """The function that typer makes a command of."""

    def run(scenes: Scenes, out: Folder = "", settings: Values = None, json: Json = False) -> None:
        def work() -> int:
            from .printing import show

            folder = Path(out or Path("results") / analysis.name)
            one, files = analysis.of_runs(dict(_runs(scenes, settings or ())), folder)
            files += one.write(folder, analysis.formats)
            show(json, lambda: one.to_dict(files), lambda: one.blocks(files))
            return FINE if one.is_trusted else NOT_TRUSTED

        leave(", ".join(Path(path).name for path in scenes), json, work)

    run.__doc__, run.__name__ = inspect.getdoc(analysis), analysis.name
    return run


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
