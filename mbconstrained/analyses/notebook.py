"""Pictures of public objects for notebooks: their plots as SVG without a script."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Iterator
from functools import singledispatch
from typing import Any

import numpy as np

from ..frequency.frequency_response import FrequencyResponse
from ..frequency.random.random_response import RandomResponse
from ..frequency.shock_spectrum import PARTS, ShockResponseSpectrum
from ..ground.display import with_unit
from ..ground.errors import MbconstrainedError
from ..mechanics.equations import EquationsOfMotion
from ..mechanics.harmonic_response import frequency_response
from ..mechanics.root_locus import RootLocus
from ..page.content import Curve, Plot, Scale, curve_with_gaps
from ..page.plots import axis_titles, image_groups, plot_image
from ..response.response import Response
from ..scene.build.data_files import Record
from ..scene.run.scene import Scene
from .base import Answer
from .locus import locus_plot
from .motion_plots import plots_of
from .python_models import result_of
from .random import response_plots

#: The receptances of so many coordinates of a system are drawn.
MOST_COORDINATES = 12

#: Pictures below one object; a notebook is not the page.
MOST_PICTURES = 6


def pictures(shown) -> str:
    """The plots of an object as HTML that a notebook shows; each picture is closed in itself and runs no script."""
    try:
        groups = image_groups(plots(shown))
    except MbconstrainedError:  # what is shown has no such answer, or none within float64
        return ""
    more = f"<p>and {len(groups) - MOST_PICTURES} further pictures on the page</p>" if len(groups) > MOST_PICTURES else ""
    return "".join(map(_picture, groups[:MOST_PICTURES])) + more


def _picture(group: tuple[Plot, ...]) -> str:
    across, up = axis_titles(group[0])
    text = html.escape(f"{', '.join(plot.title for plot in group)}: {up} over {across}")
    data = base64.b64encode(plot_image(group, "svg")).decode()
    return f'<img alt="{text}" style="max-width: 100%" src="data:image/svg+xml;base64,{data}"/>'


@singledispatch
def plots(shown) -> Iterable[Plot]:
    """The plots of an object."""
    raise NotImplementedError(type(shown).__name__)  # each type with pictures is registered below


@plots.register
def _(answer: Answer) -> Iterable[Plot]:
    return answer.plots()


@plots.register
def _(scene: Scene) -> Iterable[Plot]:
    """The plots of its run."""
    return scene.unwritten().run().plots()


@plots.register
def _(system: EquationsOfMotion) -> Iterator[Plot]:
    """The receptance of each coordinate under a force on it; of a large model those of the first coordinates."""
    if system.is_sparse:
        return
    names = system.names[:MOST_COORDINATES]
    H = frequency_response(system, inputs=names, outputs=names)
    for unit in dict.fromkeys(H.units.diagonal()):
        own = [i for i in range(len(names)) if H.units[i, i] == unit]
        curves = tuple(curve_with_gaps(names[i], np.abs(H.values[i, i])) for i in own)
        scales: tuple[Scale, Scale] = ("log", "log")
        yield Plot("receptance", unit, H.frequencies_hz, curves, across_unit="Hz", variable="frequency", scales=scales)


@plots.register
def _(motion: Response) -> Iterable[Plot]:
    return plots_of(result_of(motion))


@plots.register
def _(response: FrequencyResponse) -> Iterator[Plot]:
    """Amplitudes and phases at the frequencies of the response, those of one unit side by side."""
    f, is_log = response.frequencies_hz, bool((response.frequencies_hz > 0).all())
    several = len(response.inputs) > 1
    groups: dict[str, list[tuple[str, np.ndarray]]] = {}
    for i, j in np.ndindex(len(response.outputs), len(response.inputs)) if len(f) > 1 else ():
        name = f"{response.outputs[i]} by {response.inputs[j]}" if several else str(response.outputs[i])
        groups.setdefault(str(response.units[i, j]), []).append((name, np.asarray(response.values)[i, j]))
    for unit, entries in groups.items():
        shown = "" if unit == "1" else unit
        amplitudes, phases = (
            tuple(curve_with_gaps(name, part(H)) for name, H in entries) for part in (np.abs, lambda H: np.degrees(np.angle(H)))
        )
        scale: Scale = "log" if is_log else "linear"
        up: Scale = "log" if any((curve.values > 0).any() for curve in amplitudes) else "linear"
        more: dict[str, Any] = {"across_unit": "Hz", "variable": "frequency", "image": f"{response.quantity} {unit}"}
        yield Plot(response.quantity, shown, f, amplitudes, scales=(scale, up), **more)
        yield Plot("phase", "°", f, phases, scales=(scale, "linear"), **more)


@plots.register
def _(response: RandomResponse) -> Iterable[Plot]:
    return response_plots(response)


@plots.register
def _(spectrum: ShockResponseSpectrum) -> Iterator[Plot]:
    curves = tuple(Curve(part, getattr(spectrum, part)) for part in PARTS)
    positive = any((curve.values > 0).any() for curve in curves)
    yield Plot(
        f"shock response spectrum, {spectrum.quantity}", spectrum.unit, spectrum.frequencies_hz, curves, across_unit="Hz",
        quantity=spectrum.quantity, variable="frequency", scales=("log", "log" if positive else "linear"),
    )  # fmt: skip


@plots.register
def _(record: Record) -> Iterator[Plot]:
    if len(record.times):
        name, jumps = record.name or "record", np.append(np.diff(record.times) == 0, False)
        yield Plot(
            name, record.unit, np.where(jumps, np.nextafter(record.times, -np.inf), record.times), (Curve(name, record.values),)
        )


@plots.register
def _(locus: RootLocus) -> Iterator[Plot]:
    low, high = (with_unit(value, locus.unit) for value in locus.values[[0, -1]])
    yield locus_plot(locus, low, high)
