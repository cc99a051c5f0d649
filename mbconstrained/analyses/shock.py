"""A shock: peaks of a scene's model, and the shock response spectrum of its support or of a record."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, cast

import numpy as np

from ..frequency.shock_spectrum import PARTS, ShockResponseSpectrum, shock_response_spectrum
from ..ground.checks import nearest
from ..ground.display import TextTable, number_text
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind, distinct
from ..ground.units import rate_unit
from ..mechanics.peaks import QUANTITIES, Peaks
from ..page.content import Curve, Guide, Plot, Scale, curve_with_gaps, power_label, raised
from ..scene.build.data_files import record_in_si
from ..scene.coordinates import OutputUnits
from ..scene.file import at
from ..scene.run.result import Result
from ..scene.schema.analysis_tables import ShockTable
from ..signals.impulsive import ImpulsiveSmooth
from .base import Analysis, Answer

if TYPE_CHECKING:
    from ..mechanics.constraints import ConstraintRow
    from ..mechanics.motion import Motion
    from ..scene.build.data_files import Record
    from ..scene.run.scene import Scene

#: Natural frequencies reach from these parts of the inverse duration of the shock to these of the inverse time between its knots.
LOWEST, HIGHEST, HIGHEST_OF_RECORD = 0.1, 100.0, 0.5

#: Values below this part of the largest are not drawn on logarithmic axes.
SMALLEST = 1e-6

#: Most decades of natural frequencies by default.
DECADES = 4

#: Times of the plot of a shock, over its duration and so much more.
TIMES, LONGER = 2001, 1.2


class Shock(Analysis):
    """Peaks with their times of every coordinate, reaction, force of an element and named quantity, and the shock response spectrum of a support.

    Peaks are those of the closed-form motion, none is missed between samples. Of a record, a file with columns of times and
    accelerations, the spectrum alone. Writes NAME.shock.html, .csv, .peaks.csv and .npz.
    """

    name = "shock"
    settings = ShockTable
    switches = "all"
    options: ClassVar = {"damping_ratio": "--damping", "quality_factor": "--quality", "outputs": "--output"}
    replaced: ClassVar = {
        "damping_ratio": ("quality_factor",), "quality_factor": ("damping_ratio",), "from": ("frequencies",), "to": ("frequencies",)
    }  # fmt: skip

    @classmethod
    def solve(cls, scene: Scene, settings: ShockTable | None) -> Answer:
        table, system = settings or ShockTable(), scene.equations.system
        motions = scene.table.prescribed
        with at(scene.file_name, "shock.of"):
            excitation = excitation_of(scene, table.of, motions)
        with at(scene.file_name, "shock"):
            if system is None or system.is_sparse:
                sparse, general = (
                    "are not available for sparse matrices; give arrays",
                    "belong to models with mass, damping and stiffness",
                )
                raise InputError(f"peaks {general if system is None else sparse}")
            motion, end = cast("Motion", scene.equations.solve()), table.end or scene.table.time.end
            every = tuple(one for one in (motion.peaks(end, of) for of in QUANTITIES) if one.names)
            further = [name for name in system.quantities if name not in system.elements]  # whose forces have peaks anyway
            if outputs := further if table.outputs is None else table.outputs:
                every += (motion.peaks(end, outputs),)
            part = None if excitation is None else _Spectrum(table, scene.equations.coordinates.shown, *excitation)
        own: tuple[Notice, ...] = () if part is None else part.spectrum.notices
        if part is None and motions:
            own = (no_spectrum(scene, "shock response spectrum", motions),)
        notices = distinct(scene.notices, scene.equations.form_notices, motion.notices, own)
        fields = _fields(part, every, scene.equations.coordinates.shown)
        is_open = any(one.extrema.is_open.any() for one in every)
        scope = "≥ and ≤ may be exceeded, by too many periods or modes below rounding" if is_open else "none missed"
        fields["facts"] += (("peaks", f"from 0 to {end:g} s, {scope}, limits from the left included"),)
        fields["plots"] = lambda: _plots_with_answer(scene, part)
        return cls.of(scene, heading=scene.heading, notices=notices, **fields)

    @classmethod
    def of_record(cls, path: Path, table: ShockTable, **reading) -> Answer:
        """The shock response spectrum of the acceleration in a file; column, step, unit ... as in ``record_in_si``."""
        record = record_in_si(path, expected="m/s^2", **reading)
        units = OutputUnits((record.unit_in_file,) if record.unit_in_file else ())
        with at(path.name, "shock"):
            part = _Spectrum(table, units, record.name or path.stem, "m", record.signal)
            notices = (*distinct(record.notices, part.spectrum.notices), *unknown_unit(path, record))
        return cls.of_file(path, "Shock response spectrum", notices=notices, **_fields(part, (), units))


def unknown_unit(path: Path, record: Record) -> tuple[Notice, ...]:
    """A notice on a record without a unit."""
    text = f"{path.name}: the unit of the values is not known; m/s² is taken: give unit"
    return () if record.unit else (Notice(NoticeKind.OMITTED, text),)


def _fields(part: _Spectrum | None, every: tuple[Peaks, ...], units: OutputUnits) -> dict[str, Any]:
    """The fields of an answer with a spectrum and peaks."""
    rows = [row for peaks in every for row in peaks.rows()]
    shown = [units.of(row["unit"], row["of"]) for row in rows]
    columns: dict[str, dict] = {} if part is None else {"": part.columns()}
    if every:
        sizes = {key: [factor * row[key] for row, (_, factor) in zip(rows, shown)] for key in ("maximum", "minimum")}
        times = {key: [row[f"{key}_time"] for row in rows] for key in ("maximum", "minimum")}
        columns[".peaks"] = {
            **{key: [row[key] for row in rows] for key in ("quantity", "of")}, "unit": [unit for unit, _ in shown],
            "maximum": sizes["maximum"], "at (s)": times["maximum"], "minimum": sizes["minimum"], "minimum at (s)": times["minimum"],
        }  # fmt: skip
    arrays = {} if part is None else part.arrays()
    for peaks in every:
        own = peaks.extrema
        arrays |= {f"{peaks.quantity}_{key}": getattr(own, key) for key in ("maximum", "maximum_time", "minimum", "minimum_time")}
        arrays[f"{peaks.quantity}_names"] = np.array(peaks.names)
    return {
        "facts": () if part is None else part.facts(),
        "tables": (*(() if part is None else (part.table(),)), *(peaks.table(units.of) for peaks in every)),
        "data": {"spectrum": None if part is None else part.data(), "peaks": rows},
        "plots": tuple if part is None else part.plots,
        "columns": lambda: columns,
        "arrays": lambda: arrays,
    }


def _plots_with_answer(scene: Scene, part: _Spectrum | None) -> Iterator[Plot]:
    """The spectrum of the shock, and the shock over time in one plot with the accelerations that answer it."""
    from .motion_plots import plots_of_kind

    result = Result(scene)
    answers = plots_of_kind(result, result.shown_curves("acceleration"))
    for plot in () if part is None else part.plots():
        if plot.variable != "time" or part.name not in [curve.name for one in answers for curve in one.curves]:
            yield plot
    yield from answers


@dataclass(frozen=True, eq=False)
class _Spectrum:
    """The shock response spectrum of a signal, in SI and in the units shown."""

    settings: ShockTable
    units: OutputUnits
    name: str
    unit: str
    signal: ImpulsiveSmooth

    def of(self, quantity: str) -> ShockResponseSpectrum:
        """The spectrum of another quantity."""
        own = self.settings
        lines = own.lines(*natural_range(self.signal))
        return shock_response_spectrum(self.signal, lines, own.damping_ratio, quantity, own.interpolation, own.quality_factor)

    @cached_property
    def spectrum(self) -> ShockResponseSpectrum:
        """The requested spectrum."""
        return self.of(self.settings.quantity)

    def _shown(self, spectrum: ShockResponseSpectrum) -> tuple[str, float]:
        return self.units.of(spectrum.unit.replace("m", self.unit, 1))

    def facts(self) -> tuple[tuple[str, str], ...]:
        """The shock, and the oscillators it acts on."""
        f, zeta = self.spectrum.frequencies_hz, self.spectrum.damping_ratio
        size, (shown, factor) = np.abs(self.signal(_times(self.signal))).max(), self.units.of(rate_unit(self.unit, 2))
        lines = f"{f[0]:.4g} to {f[-1]:.4g} Hz, damping ratio {zeta:g} (Q = {0.5 / zeta:.4g})" if zeta else "undamped"
        shock = f"{self.name}, {float(self.signal.knots[-1]):.4g} s, at most {factor * size:.4g} {shown}"
        return ("shock", shock), ("oscillators", lines)

    def table(self) -> TextTable:
        """The largest values of the spectrum."""
        unit, factor = self._shown(self.spectrum)
        rows = []
        for part in PARTS:
            values = getattr(self.spectrum, part)
            place = int(values.argmax())
            rows.append((part, f"{factor * values[place]:.6g} {unit}", number_text(self.spectrum.frequencies_hz[place])))
        return TextTable(f"Shock response: {self.spectrum.quantity}", ("spectrum", "largest", "at (Hz)"), tuple(rows))

    def data(self) -> dict:
        own = self.spectrum
        unit = own.unit.replace("m", self.unit, 1)
        first = {"of": self.name, "quantity": own.quantity, "unit": unit, "damping_ratio": own.damping_ratio}
        return {**first, **self.arrays()}

    def arrays(self) -> dict[str, np.ndarray]:
        """Frequencies and spectra in SI."""
        return {"frequencies_hz": self.spectrum.frequencies_hz, **{part: getattr(self.spectrum, part) for part in PARTS}}

    def columns(self) -> dict[str, np.ndarray]:
        """Frequencies and spectra in the units shown."""
        unit, factor = self._shown(self.spectrum)
        values = {f"{part} ({unit})": factor * getattr(self.spectrum, part) for part in PARTS}
        return {"frequency (Hz)": self.spectrum.frequencies_hz, **values}

    def plots(self) -> Iterator[Plot]:
        """The spectrum on logarithmic axes, the tripartite plot, the shock over time."""
        yield self._plot(self.spectrum, f"shock response spectrum, {self.spectrum.quantity}", PARTS)
        if self.settings.tripartite:
            velocity = self.spectrum if self.spectrum.quantity == "pseudo-velocity" else self.of("pseudo-velocity")
            plot = self._plot(velocity, "tripartite plot of the pseudo-velocity", PARTS[:1])
            yield replace(plot, guides=tuple(self._guides(plot, self._shown(velocity)[1])))
        (shown, factor), times = self.units.of(rate_unit(self.unit, 2)), _times(self.signal)
        curve = Curve(self.name, factor * self.signal(times)[0])
        yield Plot(f"acceleration of {self.name}", shown, times, (curve,), quantity="acceleration")

    def _plot(self, spectrum: ShockResponseSpectrum, title: str, parts: tuple[str, ...]) -> Plot:
        unit, factor = self._shown(spectrum)
        values = [factor * getattr(spectrum, part) for part in parts]
        least, is_zero = SMALLEST * max(row.max() for row in values), not np.any(values)
        scale: Scale = "linear" if is_zero else "log"
        curves = tuple(
            curve_with_gaps(part, row if is_zero else np.where(row > least, row, np.nan), i)
            for i, (part, row) in enumerate(zip(parts, values))
        )
        quantity = spectrum.quantity.split(" ")[-1]  # the title has the whole of it
        f = spectrum.frequencies_hz
        return Plot(title, unit, f, curves, across_unit="Hz", quantity=quantity, variable="frequency", scales=("log", scale))

    def _guides(self, plot: Plot, factor: float) -> Iterator[Guide]:
        """Lines of equal displacement, v = w d, and of equal acceleration, v = a / w, one for each decade."""
        if plot.scales[1] != "log":
            return
        across, up = plot.axes
        for exponent, of in ((1.0, self.unit), (-1.0, rate_unit(self.unit, 2))):
            shown, own = self.units.of(of)
            corners = np.array([across.low, across.high]) ** -exponent * np.array([[up.low], [up.high]])
            decades = np.log10(own / factor * corners / (2 * np.pi) ** exponent)
            for power in range(int(np.ceil(decades.min())), int(np.floor(decades.max())) + 1):
                level = 10.0**power / own * factor * (2 * np.pi) ** exponent
                left, right = ((f, level * f**exponent) for f in (across.low, across.high))
                name, is_at_left = f"{power_label(10.0**power)} {raised(shown)}", exponent < 0 and left[1] <= up.high
                if exponent < 0 and left[1] > up.high and right[1] > up.low:
                    name = ""  # from the upper to the right edge: the rising lines have their names there
                yield Guide(name, right, left) if is_at_left else Guide(name, left, right)


def excitation_of(scene: Scene, of: str | None, motions: Mapping[str, str]) -> tuple[str, str, ImpulsiveSmooth] | None:
    """Name, unit of the displacement and acceleration of the support; None where the scene has none that ends."""
    for name, coordinate in motions.items() if of is None else [(of, of)]:
        row = _row(scene, name, motions)
        signal = _acceleration(row)
        if not isinstance(signal, str):
            return coordinate, row.unit, signal
        if of is not None:
            raise InputError(f'the motion "{name}" {signal}')
    return None


def no_spectrum(scene: Scene, what: str, motions: Mapping[str, str]) -> Notice:
    """The reasons why no motion has a spectrum."""
    reasons = [f'the motion "{name}" {_acceleration(_row(scene, name, motions))}' for name in motions]
    return Notice(NoticeKind.OMITTED, f"no {what}: {'; '.join(reasons)}")


def _row(scene: Scene, name: str, motions: Mapping[str, str]) -> ConstraintRow:
    by_name = {**{coordinate: row for row, coordinate in motions.items()}, **{row: row for row in motions}}
    if name not in by_name:
        there = f"; there are {', '.join(motions)}" if motions else "; the scene has no [[motion]]"
        raise InputError(f'there is no motion "{name}"{nearest(name, by_name)}{there}')
    return next(row for row in scene.equations.system.rows if row.name == by_name[name])


def _acceleration(row: ConstraintRow) -> ImpulsiveSmooth | str:
    """The acceleration that a row prescribes, or why there is none with an end."""
    signal = row.signal
    if signal is None:
        return "is constant"
    for _ in range(2 - row.order):
        signal = signal.distribution_derivative()
    if signal.impulses or signal.later:
        return 'has an acceleration with Dirac impulses; prescribe the acceleration itself: level = "acceleration"'
    knots = signal.knots
    end = float(knots[-1]) if len(knots) else 0.0
    if (
        not end
        or np.abs(signal(end * np.linspace(1.0, 2.0, 9)[1:])).max() > 1e-12 * np.abs(signal(np.linspace(0.0, end, 257))).max()
    ):
        return "does not end; expected a pulse, a record or another motion that is zero after some time"
    return signal


def natural_range(signal: ImpulsiveSmooth) -> tuple[float, float]:
    """The natural frequencies in Hz by default."""
    knots = np.union1d([0.0], signal.knots)
    duration, gaps = float(knots[-1]), np.diff(knots)
    parts = signal.exact_parts
    is_record = len(knots) > len(parts) + 2
    high = (HIGHEST_OF_RECORD if is_record else HIGHEST) / float(np.median(gaps))
    low = LOWEST / duration
    return max(low, high / 10.0**DECADES), high


def _times(signal: ImpulsiveSmooth) -> np.ndarray:
    """Times of a plot of the signal: even ones and its knots, or some of the knots of a long record."""
    knots = np.asarray(signal.knots, dtype=float)
    some = knots[:: len(knots) // (4 * TIMES) + 1]
    return np.union1d(np.linspace(0.0, LONGER * float(knots[-1]), TIMES), some)
