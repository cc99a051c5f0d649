"""The plots of a motion, of curves in the units of [output]; a run without a page needs none of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..exchange.trajectories import Curves
from ..ground.tolerances import NOT_DRAWN
from ..page.content import Curve, Plot, raised, shortened
from ..page.readings import drawn_times
from ..scene.run.result import MOST_NOISE, ORDERS, Result

if TYPE_CHECKING:
    from ..page.content import TimeFunctions

#: Rounding errors of a rigid translation.
RIGID = 1e-9

#: Most phase planes on a page: the first are drawn, [output] coordinates selects others.
MOST_PLANES = 12


def plots_of(result: Result) -> tuple[Plot, ...]:
    """The requested plots, in the order of the scene."""
    output = result.scene.table.output
    kinds = [*output.plots, *(["quantity"] if output.quantity else [])]
    plots = [] if "plots" in output.model_fields_set else [*_relative_plots(result)]
    for kind in kinds:
        plots += _phase_planes(result) if kind == "phase" else plots_of_kind(result, result.shown_curves(kind))
    count = Counter(plot.title for plot in plots)
    return tuple(_with_unit(plot) if count[plot.title] > 1 else plot for plot in plots)


def _with_unit(plot: Plot) -> Plot:
    """The plot with a unique title: with its unit, or for pure numbers with the names of the curves."""
    source = raised(plot.unit) or shortened(", ".join(curve.name for curve in plot.curves))
    return replace(plot, title=f"{plot.title} ({source})", quantity=plot.quantity or plot.title)


def plots_of_kind(result: Result, curves: Curves) -> list[Plot]:
    """One plot for each unit: curves in m and in rad share no axis."""
    groups: dict[tuple[str, str], list[Curve]] = {}
    functions = result.time_functions(curves.kind)
    times = _drawn_times(result, functions, curves.units)
    values = functions.at(times)
    for i in _wanted(result, curves):
        curve = Curve(curves.names[i], values[i], i, (functions, i))
        groups.setdefault((curves.titles[i], curves.units[i]), []).append(curve)
    phases = result.motion.phases if result.is_switched else ()
    return [Plot(title, unit, times, tuple(drawn), phases=phases) for (title, unit), drawn in groups.items()]


def _relative_plots(result: Result) -> Iterator[Plot]:
    """Under one moving support the displacements relative to it, of coordinates that a slow motion of the support takes along."""
    support, along = _followers(result)
    curves, functions = result.shown_curves("displacement"), result.time_functions("displacement")
    places = [i for i in _wanted(result, curves) if i in along and curves.units[i] == curves.units[support]]
    if not places:
        return
    largest, values = np.abs(curves.values).max(), curves.values[places] - curves.values[support]
    noise = min(functions.noise * largest / (np.abs(values).max() or largest), MOST_NOISE)
    relative = replace(functions, at=lambda times: (own := functions.at(times))[places] - own[support], noise=noise)
    name, unit = curves.names[support], curves.units[support]
    times = _drawn_times(result, relative, [unit] * len(places))
    drawn = tuple(Curve(curves.names[i], row, i, (relative, k)) for k, (i, row) in enumerate(zip(places, relative.at(times))))
    phases = result.motion.phases if result.is_switched else ()
    yield Plot(f"displacement relative to {name}", unit, times, drawn, quantity="relative displacement", phases=phases)


def _followers(result: Result) -> tuple[int, list[int]]:
    """The coordinate of the only moving support, and the coordinates that follow it by as much when it moves slowly, as in a rigid
    translation; none where there are several supports, or other springs hold them.

    K x = A^T lambda, A x = 1 in the row of the support and 0 in all others.
    """
    scene, system = result.scene, result.scene.equations.system
    rows = scene.table.prescribed
    if system is None or system.is_sparse or len(set(rows.values())) != 1 or not set(rows.values()) <= set(system.names):
        return 0, []
    A, size = system.constraint_matrix, system.size
    b = np.concatenate([np.zeros(size), [float(row.name in rows) for row in system.rows]])
    saddle = np.block([[system.stiffness, -A.T], [A, np.zeros((len(A), len(A)))]])
    x = np.linalg.lstsq(saddle, b, rcond=None)[0]
    support = system.names.index(next(iter(rows.values())))
    holds = np.abs(saddle @ x - b).max() <= RIGID * np.abs(saddle).max() and abs(x[support] - 1) <= RIGID
    return support, [i for i in range(size) if holds and i != support and abs(x[i] - 1) <= RIGID]


def _drawn_times(result: Result, functions: TimeFunctions, units: Sequence[str]) -> np.ndarray:
    return drawn_times(functions, float(result.times[0]), float(result.times[-1]), units)


def _wanted(result: Result, curves: Curves) -> list[int]:
    wanted = result.scene.table.output.coordinates if curves.kind in ORDERS else None
    return [i for i, name in enumerate(curves.names) if wanted is None or name in wanted]


def _phase_planes(result: Result) -> list[Plot]:
    """The velocity over the displacement of each coordinate that moves."""
    places, rates = result.shown_curves("displacement"), result.shown_curves("velocity")
    functions = [result.time_functions(curves.kind) for curves in (places, rates)]
    times = np.union1d(*(_drawn_times(result, each, own.units) for each, own in zip(functions, (places, rates))))
    along, up = (each.at(times) for each in functions)
    moving = [i for i in _wanted(result, places) if np.ptp(places.values[i]) > NOT_DRAWN * np.abs(places.values[i]).max()]
    return [
        Plot(
            f"phase plane of {places.names[i]}",
            rates.units[i],
            times,
            (Curve(places.names[i], up[i], i, (functions[1], i)),),
            across=Curve(places.titles[i], along[i], function=(functions[0], i)),
            across_unit=places.units[i],
            quantity=rates.titles[i],
        )
        for i in moving[:MOST_PLANES]
    ]
