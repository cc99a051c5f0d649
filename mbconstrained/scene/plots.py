"""What the page of a result plots: curves over time, and phase planes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..page.plot_content import Curve, PhasePlot, Plot
from .curves import ORDERS

if TYPE_CHECKING:
    from .curves import Curves
    from .result import Result

#: More phase planes than this nobody looks at; the first are drawn, [output] coordinates asks for others.
MOST_PLANES = 12

#: What moves less than this share of its largest displacement is rounding.
ROUNDING = 1e-9


def plots_of(result: Result) -> tuple[Plot | PhasePlot, ...]:
    """The plots that the scene asks for, in its order."""
    kinds = result.scene.table.output.plots
    return tuple(
        plot for kind in kinds for plot in (_phase_planes(result) if kind == "phase" else _plots(result, result.curves(kind)))
    )


def _plots(result: Result, curves: Curves) -> list[Plot]:
    """One plot for each unit: curves in m and in rad share no axis."""
    groups: dict[tuple[str, str], list[Curve]] = {}
    for i in _wanted(result, curves):
        groups.setdefault((curves.titles[i], curves.units[i]), []).append(Curve(curves.names[i], curves.values[i], i))
    return [Plot(title, _shown(unit), result.times, tuple(drawn)) for (title, unit), drawn in groups.items()]


def _wanted(result: Result, curves: Curves) -> list[int]:
    wanted = result.scene.table.output.coordinates if curves.kind in ORDERS else None
    return [i for i, name in enumerate(curves.names) if wanted is None or name in wanted]


def _phase_planes(result: Result) -> list[PhasePlot]:
    """The velocity over the displacement of each coordinate that moves."""
    places, rates = result.curves("displacement"), result.curves("velocity")
    moving = [i for i in _wanted(result, places) if np.ptp(places.values[i]) > ROUNDING * np.abs(places.values[i]).max()]
    return [
        PhasePlot(
            title=f"phase plane of {places.names[i]}",
            name=places.names[i],
            titles=(places.titles[i], rates.titles[i]),
            units=(_shown(places.units[i]), _shown(rates.units[i])),
            times=result.times,
            displacement=places.values[i],
            velocity=rates.values[i],
            color=i,
        )
        for i in moving[:MOST_PLANES]
    ]


def _shown(unit: str) -> str:
    return "" if unit == "1" else unit
