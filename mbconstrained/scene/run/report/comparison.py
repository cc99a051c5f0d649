"""The page of several runs: the curves of each coordinate in one plot, and the frequencies in one table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ....ground.display import TextTable
from ....page.content import Curve, PageContent, Plot
from ..result import ORDERS

#: The lowest natural frequencies that the table lists.
MOST_FREQUENCIES = 6


def comparison(labels: Sequence[str], results: Sequence[Any]) -> PageContent:
    """The content of the page."""
    return PageContent(
        title=" and ".join([", ".join(labels[:-1]), labels[-1]]),
        source="Runs compared",
        plots=tuple(_plots(labels, results)),
        tables=(comparison_table(labels, results),),
        notices=tuple(notice for result in results for notice in result.notices if notice.doubtful),
        facts=(("time", results[0].scene.table.time.text),),
    )


def comparison_table(labels: Sequence[str], results: Sequence[Any]) -> TextTable:
    """The lowest natural frequencies with their damping ratios, and the error estimate of each run."""
    rows = []
    for label, result in zip(labels, results):
        modes = result.modes if result.system else None
        pairs = zip(modes.frequencies_hz, modes.damping_ratios) if modes else ()
        texts = [f"{hz:.6g} Hz ({ratio:.3g})" for hz, ratio in pairs]
        more = ", …" if len(texts) > MOST_FREQUENCIES else ""
        rows.append((label, ", ".join(texts[:MOST_FREQUENCIES]) + more, f"{result.error_estimate:.2g}"))
    return TextTable("Runs", ("run", "natural frequencies (damping ratios)", "error estimate"), tuple(rows))


def _plots(labels: Sequence[str], results: Sequence[Any]) -> list[Plot]:
    shared = [kind for kind in results[0].kinds if all(kind in result.kinds for result in results)]
    wanted = results[0].scene.table.output
    plots = []
    for kind in shared:
        if kind != "quantity" and kind not in wanted.plots:
            continue
        groups: dict[tuple[str, str, str], list[Curve]] = {}
        for label, result in zip(labels, results):
            curves, functions = result.shown_curves(kind), result.time_functions(kind)
            for i, (name, title, unit) in enumerate(zip(curves.names, curves.titles, curves.units)):
                if kind not in ORDERS or wanted.coordinates is None or name in wanted.coordinates:
                    curve = Curve(label, curves.values[i], function=(functions, i))
                    groups.setdefault((name, title, unit), []).append(curve)
        plots += [
            Plot(f"{name}: {title}", "" if unit == "1" else unit, results[0].times, tuple(curves))
            for (name, title, unit), curves in groups.items()
        ]
    return plots
