"""Several runs compared: the curves of each coordinate in one plot, the frequencies in one table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..ground.display import TextTable
from ..page.content import Curve, Plot
from ..scene.run.result import ORDERS
from .base import Analysis, Answer

if TYPE_CHECKING:
    from ..scene.run.scene import Scene

#: The lowest natural frequencies that the table lists.
MOST_FREQUENCIES = 6


class Comparison(Analysis):
    """Run several scenes, or one with several values of parameters, and draw each quantity of all runs in one plot.

    With --set zeta=0.02,0.13 each scene is run with both values. Every run writes its files into a folder of its own name inside
    the output folder, and compare.html has the common plots, at the times of the first run.
    """

    name = "compare"
    handles_choices = True
    switches = "all"
    formats = ("page",)

    @classmethod
    def answer(cls, scene: Scene, progress: Any = None, *, others: Sequence[Scene] = ()) -> Answer:  # type: ignore[override]  # it has no settings
        """The answer of a scene and others; nothing is written."""
        scenes = (scene, *others)
        names = [one.name for one in scenes]
        labels = [f"{name} {names[:i].count(name) + 1}" if names.count(name) > 1 else name for i, name in enumerate(names)]
        return cls.of_runs(dict(zip(labels, scenes)), None)[0]

    @classmethod
    def of_runs(cls, scenes: Mapping[str, Scene], folder: Path | None) -> tuple[Answer, list[Path]]:
        """The answer of scenes by the names of their folders, into which each writes its files, and these; without a folder none."""
        time = next(iter(scenes.values())).table.time
        runs: dict[str, Any] = {}
        for label, scene in scenes.items():
            runs[label] = replace(scene, table=scene.table.model_copy(update={"time": time})).run(folder and folder / label)
        *first, last = runs
        answer = Answer(
            kind="compare",
            name="",
            title=f"{', '.join(first)} and {last}",
            source="Runs compared",
            facts=(("time", time.text),),
            tables=(_table(runs),),
            notices=tuple(notice for run in runs.values() for notice in run.notices if notice.doubtful),
            data={"runs": {label: run.to_dict() for label, run in runs.items()}},
            plots=lambda: _plots(runs),
            keys=("files", "trusted"),
        )
        return answer, [path for run in runs.values() for path in run.files]


def _table(runs: Mapping[str, Any]) -> TextTable:
    """The lowest natural frequencies with their damping ratios, and the error estimate of each run."""
    rows = []
    for label, run in runs.items():
        modes = run.modes if run.system else None
        texts = [f"{hz:.6g} Hz ({ratio:.3g})" for hz, ratio in zip(modes.frequencies_hz, modes.damping_ratios)] if modes else []
        more = ", …" if len(texts) > MOST_FREQUENCIES else ""
        rows.append((label, ", ".join(texts[:MOST_FREQUENCIES]) + more, f"{run.error_estimate:.2g}"))
    return TextTable("Runs", ("run", "natural frequencies (damping ratios)", "error estimate"), tuple(rows))


def _plots(runs: Mapping[str, Any]) -> Iterator[Plot]:
    """A plot of each quantity that all runs have, as the first of them requests."""
    first, *others = runs.values()
    wanted = first.scene.table.output
    for kind in first.kinds:
        if (kind != "quantity" and kind not in wanted.plots) or not all(kind in run.kinds for run in others):
            continue
        groups: dict[tuple[str, str, str], list[Curve]] = {}
        for label, run in runs.items():
            curves, functions = run.shown_curves(kind), run.time_functions(kind)
            for i, (name, title, unit) in enumerate(zip(curves.names, curves.titles, curves.units)):
                if kind not in ORDERS or wanted.coordinates is None or name in wanted.coordinates:
                    groups.setdefault((name, title, unit), []).append(Curve(label, curves.values[i], function=(functions, i)))
        for (name, title, unit), own in groups.items():
            yield Plot(f"{name}: {title}", unit, first.times, tuple(own))
