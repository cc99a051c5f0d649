"""The page of the frequency response of a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ....page.content import PageContent
from ....page.plots.frequency_plots import ResponseLook, frequency_plots
from .frequency_summary import antiresonance_table, facts, peak_table

if TYPE_CHECKING:
    from .scene_frequency import SceneFrequency


def frequency_content(frequency: SceneFrequency) -> PageContent:
    """Plots, tables of peaks and antiresonances, notices, facts."""
    scene, table, response = frequency.scene, frequency.table, frequency.response
    names = scene.equations.coordinates.names
    colors = tuple(names.index(name) if name in names else i for i, name in enumerate(response.outputs))
    look = ResponseLook(tuple(table.plots), table.amplitude, table.phase == "unwrapped", table.axis, frequency.axis_factor, colors)
    return PageContent(
        title=scene.title,
        source=scene.table.source,
        plots=frequency_plots(response, look, frequency.shown.units, frequency.shown.factors),
        tables=tuple(each for each in (peak_table(frequency), antiresonance_table(frequency)) if each is not None),
        notices=frequency.notices,
        facts=facts(frequency),
    )
