"""The frequency response of a scene with its page."""

from __future__ import annotations

from ....page.frequency_page import FrequencyContent
from ....page.plots.frequency_plots import ResponseLook, frequency_plots
from .deflection_shapes import deflections_of
from .frequency_data import FrequencyData
from .frequency_summary import MOST_ROWS_OF_PAGE, antiresonance_table, facts, peak_table


def frequency_content(frequency: FrequencyData) -> FrequencyContent:
    """Plots, tables of peaks and antiresonances, notices, facts."""
    scene, table, response = frequency.scene, frequency.table, frequency.response
    names = scene.equations.coordinates.names
    colors = tuple(names.index(name) if name in names else i for i, name in enumerate(response.outputs))
    look = ResponseLook(tuple(table.plots), table.amplitude, table.phase == "unwrapped", table.axis, frequency.axis_factor, colors)
    inverse, zeros = frequency.is_inverse, antiresonance_table(frequency)
    peaks = frequency.peaks[:MOST_ROWS_OF_PAGE]
    return FrequencyContent(
        title=scene.title,
        source=scene.table.source,
        plots=frequency_plots(response, look, frequency.shown.units, frequency.shown.factors),
        deflections=deflections_of(frequency),
        peaks=peak_table(frequency),
        peak_frequencies=tuple(frequency.axis_factor * peak.frequency_hz for peak in peaks),
        peak_inputs=tuple(0 if inverse else response.inputs.index(peak.input) for peak in peaks),
        axis=table.axis,
        tables=() if zeros is None else (zeros,),
        notices=frequency.notices,
        facts=facts(frequency),
    )


class SceneFrequency(FrequencyData):
    """The frequency response of a scene."""

    @property
    def content(self) -> FrequencyContent:
        """Plots, tables of peaks and antiresonances, notices, facts."""
        return frequency_content(self)
