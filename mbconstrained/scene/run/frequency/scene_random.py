"""Random vibration of a scene: RMS values and statistics, spectra and a path of the outputs, page and files."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ....frequency.features import frequencies_by_poles
from ....frequency.random.random_response import RandomResponse
from ....frequency.random.statistics import octave_bands
from ....ground.display import TextTable, finite_or_none
from ....ground.errors import InputError
from ....ground.notices import Notice, distinct
from ....page.content import Curve, PageContent, Plot
from ....page.plots.axis import Scale
from ...file.messages import at
from ..report.summary import notices_json, response_blocks
from .scene_response import SceneResponse, csv_of

if TYPE_CHECKING:
    from ..scene import Scene

#: Lines of the spectra for each decade, besides those that the poles place.
EACH_DECADE = 100

#: White noise is plotted so many decades beyond the poles.
BEYOND = 10.0

#: Spectra are plotted where they are at least this share of their largest value.
LEAST_SHARE = 1e-12

#: Cycles of the median frequency of an output that its path on the page has, and the number of its times.
CYCLES, PATH_TIMES = 24, 1201


class SceneRandom(SceneResponse):
    """The random response of a scene.

    Attributes:
        scene: what was read.
    """

    kind = "random"

    def __init__(self, scene: Scene):
        super().__init__(scene.name, scene.table.output)
        self.scene = scene

    @cached_property
    def response(self) -> RandomResponse:
        """The response in SI."""
        with at(self.scene.file_name, "random"):
            arguments, options = self.arguments
            return self.scene.equations.system.random_response(*arguments, **options)

    @property
    def arguments(self) -> tuple[tuple, dict]:
        """Those of ``MechanicalSystem.random_response``."""
        table, equations = self.scene.table.random, self.scene.equations
        if table is None:
            raise InputError(
                "the scene has no table [random]; give its inputs as [[random.input]], with on, of, frequencies and values"
            )
        if equations.control is not None or equations.system is None:
            raise InputError("random vibration needs a model with mass, damping and stiffness")
        excitation = {entry.on: entry.spectrum for entry in table.input}
        if len(excitation) < len(table.input):
            raise InputError("two [[random.input]] have the same name in on; add their spectra")
        delays = {entry.on: entry.delay for entry in table.input} if any(entry.delay for entry in table.input) else None
        prescribed = {coordinate for motion in self.scene.table.motion for coordinate, _ in motion.rows.values()}
        free = [name for name in equations.system.names if name not in prescribed]
        outputs = table.outputs or (None if table.quantity == "reaction" else free)
        further = {key: getattr(table, key) for key in ("relative_to", "modal_damping", "coherence")}
        return (excitation, outputs, table.quantity), {**further, "delays": delays}

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """What is worth knowing, and what makes the values doubtful."""
        system, table = self.scene.equations.system, self.scene.table.random
        damping = system.damping_notices(any(entry.of != "force" for entry in table.input)) if system is not None else ()
        return distinct(self.scene.notices, self.scene.equations.form_notices, damping, self.response.notices)

    @cached_property
    def shown(self) -> list[tuple[str, float]]:
        """Name and factor of the unit of each output."""
        units = self.scene.equations.coordinates.shown
        return [units.of(unit) for unit in self.response.units]

    @property
    def table(self) -> TextTable:
        """RMS, rates and the expected largest value of each output."""
        response, duration = self.response, self.scene.table.random.duration
        rates, largest = response.crossing_rate(), self._largest(duration)
        rows = []
        for name, rms, rate, top, (unit, factor) in zip(response.outputs, response.rms, rates, largest, self.shown):
            finite = np.isfinite(rms)
            rows.append(
                (
                    name,
                    f"{factor * rms:.5g} {unit}" if finite else "infinite",
                    _rate(rate, finite),
                    f"{factor * top:.4g} {unit}" if np.isfinite(top) else "–",
                )
            )
        columns = ("output", "RMS", "zero crossings (Hz)", f"largest in {duration:g} s")
        return TextTable(f"Random {response.quantity}", columns, tuple(rows), "largest: mean of the largest modulus (Davenport)")

    def _largest(self, duration: float) -> np.ndarray:
        try:
            return self.response.expected_maximum(duration)
        except InputError:  # less than a period: there is no such value
            return np.full(len(self.response.outputs), np.nan)

    @property
    def facts(self) -> tuple[tuple[str, str], ...]:
        """What is random, and how accurate the results are."""
        inputs = zip(self.response.inputs, self.response.spectra.spectra)
        lines = [("input", f"{name}: {spectrum.of}, {spectrum.name}") for name, spectrum in inputs]
        return (*lines, ("error estimate", f"{self.response.error_estimate.max(initial=0.0):.2g} of each variance"))

    @cached_property
    def frequencies(self) -> np.ndarray:
        """At which spectra are plotted and written, Hz."""
        placed, corners = frequencies_by_poles(self.response.harmonic, with_peaks=False), self.response.spectra.corners
        low = corners[0] if len(corners) and corners[0] > 0 else placed[0] / BEYOND
        high = corners[-1] if len(corners) and np.isfinite(corners[-1]) else BEYOND * placed[-1]
        even = np.geomspace(low, high, int(EACH_DECADE * np.log10(high / low)) + 2)
        return np.unique([low, high, *even[1:-1], *placed[(placed > low) & (placed < high)]])

    @cached_property
    def spectra(self) -> np.ndarray:
        """One-sided spectra of the outputs in the units shown, shape (p, F)."""
        factors = np.array([factor for _, factor in self.shown])
        return self.response.psd(self.frequencies) * factors[:, None] ** 2

    @property
    def plots(self) -> tuple[Plot, ...]:
        """Of each unit the spectra, RMS values of octaves and up to each frequency, and a path of the first output."""
        result: list[Plot] = []
        for unit in dict.fromkeys(unit for unit, _ in self.shown):
            chosen = [i for i, (own, _) in enumerate(self.shown) if own == unit]
            if self.spectra[chosen].max() > 0:
                result += [self._density(unit, chosen), *self._sums(unit, chosen), *self._path(unit, chosen)]
        return tuple(result)

    def _density(self, unit: str, chosen: list[int]) -> Plot:
        largest = self.spectra[chosen].max(axis=0)
        least = LEAST_SHARE * largest.max()
        visible = np.flatnonzero(largest >= least)
        own = slice(visible[0], visible[-1] + 1)
        square = f"({unit})²/Hz" if any(sign in unit for sign in "/ ^") else f"{unit}²/Hz"
        title, values = f"spectrum of the {self.response.quantity}", np.maximum(self.spectra[:, own], least)
        return self._plot(title, square, self.frequencies[own], values, chosen, "density", "log")

    def _sums(self, unit: str, chosen: list[int]) -> list[Plot]:
        """RMS values of octaves as steps, and up to each frequency, of outputs for which they are finite."""
        edges = octave_bands(self.frequencies[0], self.frequencies[-1])
        ends = np.array([edges[:-1], np.nextafter(edges[1:], 0.0)]).T.ravel()
        factors = np.array([[factor] for _, factor in self.shown])
        steps = np.repeat(factors * self.response.rms_in_bands(edges), 2, axis=1)
        kinds = (("RMS of octaves", ends, steps), ("RMS up to a frequency", self.frequencies, factors * self._cumulative))
        plots = []
        for title, f, values in kinds:
            finite = [i for i in chosen if np.isfinite(values[i]).all()]
            plots += [self._plot(title, unit, f, values, finite, "RMS", "linear")] if finite else []
        return plots

    def _plot(self, title: str, unit: str, f, values, chosen: list[int], quantity: str, scale: Scale) -> Plot:
        curves = tuple(Curve(self.response.outputs[i], values[i], i) for i in chosen)
        return Plot(title, unit, f, curves, across_unit="Hz", quantity=quantity, variable="frequency", scales=("log", scale))

    @cached_property
    def _cumulative(self) -> np.ndarray:
        """RMS values up to each frequency in SI, shape (p, F)."""
        return self.response.cumulative_rms(self.frequencies)

    def _path(self, unit: str, chosen: list[int]) -> list[Plot]:
        """A random path of the first of these outputs that has one, over some cycles of its mean frequency, with its band of one sigma."""
        shown = [i for i in chosen if np.isfinite(self.response.rms[i]) and self.response.rms[i] > 0]
        if not shown:
            return []
        first = shown[0]
        name, rms, factor = self.response.outputs[first], self.response.rms[first], self.shown[first][1]
        middle = np.searchsorted(self._cumulative[first], np.sqrt(0.5) * rms)
        times = np.linspace(0.0, CYCLES / self.frequencies[min(middle, len(self.frequencies) - 1)], PATH_TIMES)
        try:
            path = self.response.only(name).sample(times, seed=0)[0]
        except InputError:  # motions that no noise reaches have no distribution
            return []
        band = np.full(len(times), rms)
        rows = ((name, path, first), ("+σ", band, first + 1), ("−σ", -band, first + 1))
        curves = tuple(Curve(label, factor * row, color) for label, row, color in rows)
        return [Plot(f"a random path of {name}", unit, times, curves, quantity=self.response.quantity)]

    @property
    def content(self) -> PageContent:
        """Plots, table, notices, facts."""
        return PageContent(
            self.scene.title,
            self.scene.table.source,
            plots=self.plots,
            tables=(self.table,),
            notices=self.notices,
            facts=self.facts,
        )

    @property
    def csv(self) -> dict[str, str]:
        """The spectra in the units shown."""
        heads = [f"{name} (({unit})^2/Hz)" for name, (unit, _) in zip(self.response.outputs, self.shown)]
        return {"": csv_of({"frequency (Hz)": self.frequencies, **dict(zip(heads, self.spectra))})}

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """Spectra, RMS values up to each frequency, and covariance."""
        return {
            "frequencies_hz": self.frequencies,
            "psd": self.response.psd(self.frequencies),
            "cumulative_rms": self._cumulative,
            "covariance": self.response.covariance,
            "outputs": np.array(self.response.outputs),
        }

    def blocks(self) -> list[str | TextTable]:
        """What is printed on 80 columns."""
        return response_blocks((self.scene.heading, self.scene.table.source), self.facts, [self.table], self.notices, self.files)

    def as_json(self) -> dict:
        """The same as plain data, numbers in SI."""
        response = self.response
        finite = np.isfinite(response.rms)
        return {
            "title": self.scene.title,
            "quantity": response.quantity,
            "inputs": list(response.inputs),
            "outputs": list(response.outputs),
            "units": list(response.units),
            "rms": [float(value) if own else None for value, own in zip(response.rms, finite)],
            "covariance": [list(map(finite_or_none, row)) for row in response.covariance],
            "zero_crossings_hz": list(map(finite_or_none, response.crossing_rate())),
            "infinite": response.infinite,
            "error_estimate": response.error_estimate.tolist(),
            "notices": notices_json(self.notices),
            "trusted": self.is_trusted,
            "files": [str(path) for path in self.files],
        }


def _rate(rate: float, finite: bool) -> str:
    return "–" if not finite else f"{rate:.4g}" if np.isfinite(rate) else "infinite"
