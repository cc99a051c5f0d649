"""Random vibration of a scene: RMS values and statistics, spectra and a path of the outputs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..exchange.trajectories import RATES
from ..frequency.features import frequencies_by_poles
from ..frequency.random.random_response import RandomResponse, octave_bands
from ..frequency.random.spectra import KINDS, Spectrum
from ..ground.display import TextTable
from ..ground.errors import InputError
from ..ground.notices import distinct
from ..ground.units import density_unit, force_unit, rate_unit
from ..mechanics.channels import channels
from ..page.content import Curve, Plot, Scale, curve_with_gaps
from ..scene.build.data_files import curve_of
from ..scene.file import at
from ..scene.schema.analysis_tables import RandomInputTable, RandomTable
from .base import Analysis, Answer

if TYPE_CHECKING:
    from ..frequency.random.spectra import Spectrum
    from ..scene.run.scene import Scene

#: Lines of the spectra for each decade, besides those that the poles place.
EACH_DECADE = 100

#: White noise is plotted so many decades beyond the poles.
BEYOND = 10.0

#: Spectra are plotted where they are at least this share of their largest value.
LEAST_SHARE = 1e-12

#: The first colour of the inputs, which are dashed.
COLORED = 8

#: Cycles of the median frequency of an output that its path on the page has, and the number of its times.
CYCLES, PATH_TIMES = 24, 1201


class Random(Analysis):
    """The stationary response to the spectra of the table [random]: RMS values, rates, expected largest values.

    Variances are exact integrals, not sums over a grid; one that is infinite is reported with its reason. Writes NAME.random.html,
    .csv and .npz.
    """

    name = "random"
    handles_delays = True
    settings = RandomTable
    options: ClassVar = {"outputs": "--output"}

    @classmethod
    def solve(cls, scene: Scene, settings: RandomTable | None) -> Answer:
        response = random_response(scene, settings)
        shown, system = scene.equations.coordinates.shown, scene.equations.system
        known = channels(system, "inputs")
        excitation = [_Input(name, one, known[name].unit) for name, one in zip(response.inputs, response.spectra.spectra)]
        own = _Outputs(response, list(map(shown.of, response.units, response.outputs)), excitation, shown.of)
        damping = system.damping_notices(any(entry.of != "force" for entry in settings.input)) if system is not None else ()
        return cls.of(
            scene,
            facts=(
                *(("input", f"{one.name}: {one.spectrum.of}, {one.described(shown.of(one.unit)[0])}") for one in excitation),
                ("error estimate", f"{response.error_estimate.max(initial=0.0):.2g} of each variance"),
            ),
            tables=(own.table(settings.duration),),
            notices=distinct(scene.notices, scene.equations.form_notices, damping, response.notices),
            data={
                "quantity": response.quantity,
                "inputs": response.inputs,
                "outputs": response.outputs,
                "units": response.units,
                "rms": response.rms,
                "covariance": response.covariance,
                "zero_crossings_hz": response.crossing_rate(),
                "infinite": response.infinite,
                "error_estimate": response.error_estimate,
            },
            plots=own.plots,
            columns=lambda: {"": own.columns()},
            arrays=own.arrays,
            heading=scene.heading,
        )


def random_response(scene: Scene, table: RandomTable | None = None) -> RandomResponse:
    """The response of a scene to its random inputs, in SI."""
    with at(scene.file_name, "random"):
        excitation, options = random_arguments(scene, table or scene.table.random)
        return scene.equations.system.random_response(*excitation, **options)


def random_arguments(scene: Scene, table: RandomTable | None) -> tuple[tuple, dict]:
    """Arguments of ``MechanicalSystem.random_response``."""
    equations = scene.equations
    if table is None:
        raise InputError(
            "the scene has no table [random]; give its inputs as [[random.input]], with on, of, frequencies and values"
        )
    if equations.control is not None or equations.system is None:
        raise InputError("random vibration needs a model with mass, damping and stiffness")
    excitation = {entry.on: _spectrum(scene, number, entry) for number, entry in enumerate(table.input, 1)}
    if len(excitation) < len(table.input):
        raise InputError("two [[random.input]] have the same name in on; add their spectra")
    delays = {entry.on: entry.delay for entry in table.input} if any(entry.delay for entry in table.input) else None
    free = [name for name in equations.system.names if name not in scene.table.prescribed.values()]
    outputs = table.outputs
    if outputs is None and table.quantity in RATES:
        outputs = [*free, *(name for name in equations.system.quantities if name not in free)]
    further = {key: getattr(table, key) for key in ("relative_to", "modal_damping", "coherence")}
    return (excitation, outputs, table.quantity), {**further, "delays": delays}


def _spectrum(scene: Scene, number: int, entry: RandomInputTable) -> Spectrum:
    with at(scene.file_name, f"random.input[{number}]"):
        return entry.spectrum(lambda table: curve_of(table, scene.folder))


def response_plots(response: RandomResponse) -> Iterator[Plot]:
    """The plots of a response in SI."""
    return _Outputs(response, [(str(unit), 1.0) for unit in response.units]).plots()


@dataclass(frozen=True, eq=False)
class _Input:
    """A random input, with the unit of the displacement of its point."""

    name: str
    spectrum: Spectrum
    place_unit: str

    @property
    def unit(self) -> str:
        order = KINDS[self.spectrum.of]
        return force_unit(self.place_unit) if order is None else rate_unit(self.place_unit, order)

    def described(self, shown: str) -> str:
        """Text on the spectrum; without the size in SI of the unit in which it was given, where that is the one shown."""
        text, _, conversion = self.spectrum.name.partition(", 1 ")
        return text if conversion.startswith(f"{density_unit(shown)} = ") else self.spectrum.name

    def density(self, unit: str, f: np.ndarray) -> np.ndarray | None:
        """Density in a unit, of a motion that of a higher derivative; None in others, NaN where it is zero."""
        order, values = KINDS[self.spectrum.of], np.asarray(self.spectrum(f))
        later = () if order is None else [k for k in range(order + 1, 3) if rate_unit(self.place_unit, k) == unit]
        if unit != self.unit and not later:
            return None
        values = values * (2 * np.pi * f) ** (2 * (later[0] - order)) if unit != self.unit else values
        return np.where(values > 0, values, np.nan)


class _Outputs:
    """The outputs of a random response in the units shown, and its inputs."""

    def __init__(
        self,
        response: RandomResponse,
        shown: list[tuple[str, float]],
        inputs: Sequence[_Input] = (),
        units: Callable[[str], tuple[str, float]] = lambda unit: (unit, 1.0),
    ):
        self.response, self.shown, self.inputs, self.units = response, shown, inputs, units

    def table(self, duration: float) -> TextTable:
        """RMS, rates and the expected largest value of each output."""
        response, rows = self.response, []
        try:
            largest = response.expected_maximum(duration)
        except InputError:  # less than a period: there is no such value
            largest = np.full(len(response.outputs), np.nan)
        each = zip(response.outputs, response.rms, response.crossing_rate(), largest, self.shown)
        for name, rms, rate, top, (unit, factor) in each:
            finite = np.isfinite(rms)
            crossings = "–" if not finite else f"{rate:.4g}" if np.isfinite(rate) else "infinite"
            size = f"{factor * rms:.5g} {unit}" if finite else "infinite"
            rows.append((name, size, crossings, f"{factor * top:.4g} {unit}" if np.isfinite(top) else "–"))
        columns = ("output", "RMS", "zero crossings (Hz)", f"largest in {duration:g} s")
        return TextTable(
            f"Random {response.harmonic.quantity_of()}", columns, tuple(rows), "largest: mean of the largest modulus (Davenport)"
        )

    @cached_property
    def frequencies(self) -> np.ndarray:
        """Frequencies in Hz at which spectra are plotted and written."""
        placed, corners = frequencies_by_poles(self.response.harmonic, with_peaks=False), self.response.spectra.corners
        low = corners[0] if len(corners) and corners[0] > 0 else placed[0] / BEYOND
        high = corners[-1] if len(corners) and np.isfinite(corners[-1]) else BEYOND * placed[-1]
        even = np.geomspace(low, high, int(EACH_DECADE * np.log10(high / low)) + 2)
        return np.unique([low, high, *even[1:-1], *placed[(placed > low) & (placed < high)]])

    @cached_property
    def spectra(self) -> np.ndarray:
        """One-sided power spectral densities of the outputs in the displayed units, shape (p, F)."""
        return self.response.psd(self.frequencies) * np.array([[factor**2] for _, factor in self.shown])

    @cached_property
    def cumulative(self) -> np.ndarray:
        """RMS values up to each frequency in SI, shape (p, F)."""
        return self.response.cumulative_rms(self.frequencies)

    def columns(self) -> dict[str, np.ndarray]:
        heads = (f"{name} ({density_unit(unit)})" for name, (unit, _) in zip(self.response.outputs, self.shown))
        return {"frequency (Hz)": self.frequencies, **dict(zip(heads, self.spectra))}

    def arrays(self) -> dict[str, np.ndarray]:
        """Spectra, RMS values up to each frequency, and covariance in SI."""
        own = {"frequencies_hz": self.frequencies, "psd": self.response.psd(self.frequencies), "cumulative_rms": self.cumulative}
        return {**own, "covariance": self.response.covariance, "outputs": np.array(self.response.outputs)}

    def plots(self) -> Iterator[Plot]:
        """Spectral densities with those of the inputs, RMS values of octaves and up to each frequency by unit, and a sample path of
        the first output."""
        left = list(self.inputs)
        for unit in dict.fromkeys(unit for unit, _ in self.shown):
            chosen = [i for i, (own, _) in enumerate(self.shown) if own == unit]
            if self.spectra[chosen].max() > 0:
                plot, drawn = self._density(unit, chosen)
                left = [one for one in left if one not in drawn]
                yield plot
                yield from self._sums(unit, chosen)
                yield from self._path(unit, chosen)
        for unit in dict.fromkeys(one.unit for one in left):
            yield self._input_plot(unit, [one for one in left if one.unit == unit])

    def _input_plot(self, unit: str, inputs: list[_Input]) -> Plot:
        """The spectra of inputs that have no unit in common with the outputs."""
        shown, factor = self.units(unit)
        rows = [factor**2 * one.density(unit, self.frequencies) for one in inputs]
        curves = tuple(curve_with_gaps(one.name, row, COLORED + i) for i, (one, row) in enumerate(zip(inputs, rows)))
        title = f"spectrum of the input, {', '.join(dict.fromkeys(one.spectrum.of for one in inputs))}"
        square = density_unit(shown).replace("^2", "²")
        axes: dict = {"quantity": "density", "variable": "frequency", "scales": ("log", "log")}
        return Plot(title, square, self.frequencies, curves, across_unit="Hz", **axes)

    def _density(self, unit: str, chosen: list[int]) -> tuple[Plot, list[_Input]]:
        """The spectra of outputs of one unit, and the inputs that stand in the plot with them."""
        largest = self.spectra[chosen].max(axis=0)
        least = LEAST_SHARE * largest.max()
        visible = np.flatnonzero(largest >= least)
        own = slice(visible[0], visible[-1] + 1)
        square = density_unit(unit).replace("^2", "²")
        title, values = f"spectrum of the {self.response.harmonic.quantity_of(chosen)}", np.maximum(self.spectra[:, own], least)
        plot = self._plot(title, square, self.frequencies[own], values, chosen, "density", "log")
        factor = self.shown[chosen[0]][1]
        rows = [(one, one.density(str(self.response.units[chosen[0]]), plot.times)) for one in self.inputs]
        drawn = [(one, factor**2 * row) for one, row in rows if row is not None and np.isfinite(row).any()]
        curves = (
            curve_with_gaps(f"input: {one.name}", np.where(row >= least, row, np.nan), COLORED + i)
            for i, (one, row) in enumerate(drawn)
        )
        return replace(plot, curves=(*plot.curves, *curves)), [one for one, _ in drawn]

    def _sums(self, unit: str, chosen: list[int]) -> Iterator[Plot]:
        """RMS values of octaves as steps, and up to each frequency, of outputs for which they are finite."""
        edges = octave_bands(self.frequencies[0], self.frequencies[-1])
        ends = np.array([edges[:-1], np.nextafter(edges[1:], 0.0)]).T.ravel()
        factors = np.array([[factor] for _, factor in self.shown])
        steps = np.repeat(factors * self.response.rms_in_bands(edges), 2, axis=1)
        kinds = (("RMS of octaves", ends, steps), ("RMS up to a frequency", self.frequencies, factors * self.cumulative))
        for title, f, values in kinds:
            if finite := [i for i in chosen if np.isfinite(values[i]).all()]:
                yield self._plot(title, unit, f, values, finite, "RMS", "linear")

    def _plot(self, title: str, unit: str, f, values, chosen: list[int], quantity: str, scale: Scale) -> Plot:
        curves = tuple(Curve(self.response.outputs[i], values[i], i) for i in chosen)
        return Plot(title, unit, f, curves, across_unit="Hz", quantity=quantity, variable="frequency", scales=("log", scale))

    def _path(self, unit: str, chosen: list[int]) -> Iterator[Plot]:
        """A sample path of the first output that has one, over some cycles of its mean frequency, with its band of one sigma."""
        first = next((i for i in chosen if np.isfinite(self.response.rms[i]) and self.response.rms[i] > 0), None)
        if first is None:
            return
        name, rms, factor = self.response.outputs[first], self.response.rms[first], self.shown[first][1]
        middle = np.searchsorted(self.cumulative[first], np.sqrt(0.5) * rms)
        times = np.linspace(0.0, CYCLES / self.frequencies[min(middle, len(self.frequencies) - 1)], PATH_TIMES)
        try:
            path = self.response.only(name).sample(times, seed=0)[0]
        except InputError:  # motions that no noise reaches have no distribution
            return
        rows = ((name, path, first), ("+σ", np.full(len(times), rms), first + 1), ("−σ", np.full(len(times), -rms), first + 1))
        curves = tuple(Curve(label, factor * row, color) for label, row, color in rows)
        yield Plot(f"a random path of {name}", unit, times, curves, quantity=self.response.harmonic.quantity_of([first]))
