"""A shock: peaks of a scene's model, and the shock response spectrum of its support or of a record; page and files."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ....frequency.shock.response_spectrum import PARTS, ShockResponseSpectrum, shock_response_spectrum
from ....ground.coordinate_units import rate_unit
from ....ground.display import TextTable, number_text
from ....ground.errors import InputError
from ....ground.notices import Notice, NoticeKind, distinct
from ....mechanics.vibration.peaks import QUANTITIES, Peaks
from ....page.content import Curve, Guide, PageContent, Plot
from ....page.plots.axis import Scale, power_label
from ....page.typeset import raised
from ....signals.impulsive import ImpulsiveSmooth
from ...build.record_file import Record, record_in_si
from ...file.messages import at
from ...quantities.output_units import OutputUnits
from ...schema.analyses.shock_table import ShockTable
from ...schema.scene_schema import OutputTable
from ..report.summary import notices_json, response_blocks
from .scene_response import SceneResponse, csv_of

if TYPE_CHECKING:
    from ....mechanics.constraints import ConstraintRow
    from ..scene import Scene

#: Natural frequencies reach from these parts of the inverse duration of the shock to these of the inverse time between its knots.
LOWEST, HIGHEST, HIGHEST_OF_RECORD = 0.1, 100.0, 0.5

#: Most decades of natural frequencies by default.
DECADES = 4

#: Times of the plot of a shock, over its duration and so much more.
TIMES, LONGER = 2001, 1.2

#: Rows of a table for a terminal, and on the page.
MOST_ROWS, MOST_ROWS_OF_PAGE = 16, 200

G = 9.80665


class SceneShock(SceneResponse):
    """Peaks of a model under the forces and motions of its scene, and the shock response spectrum of a support; or that of a record.

    Attributes:
        table: [shock], with what the command line gives.
        scene: None of a record.
    """

    kind = "shock"

    def __init__(self, name: str, output: OutputTable, table: ShockTable, scene: Scene | None = None, record: Path | None = None):
        super().__init__(name, output)
        self.table, self.scene, self.record = table, scene, record
        self.reading: dict = {}
        self.file_name = scene.file_name if scene else record.name if record else name

    @classmethod
    def of_scene(cls, scene: Scene, table: ShockTable | None = None) -> SceneShock:
        """Of a scene with mass, damping and stiffness."""
        return cls(scene.name, scene.table.output, table or scene.table.shock or ShockTable(), scene)

    @classmethod
    def of_record(cls, path: Path, table: ShockTable, output: OutputTable | None = None, **reading) -> SceneShock:
        """Of the acceleration in a file."""
        own = cls(path.stem, output or OutputTable(), table, record=path)
        own.reading = reading
        return own

    # The shock.

    @cached_property
    def shock(self) -> tuple[str, str, ImpulsiveSmooth] | None:
        """Name, unit of the displacement and acceleration of the support; None where the scene has none that ends."""
        if self.record is not None:
            record = self._record
            return record.name or self.record.stem, "m", record.signal
        with at(self.file_name, "shock.of"):
            if self.table.of is not None:
                row = self._row(self.table.of)
                signal = _acceleration(row)
                if isinstance(signal, str):
                    raise InputError(f'the motion "{self.table.of}" {signal}')
                return self.table.of, row.unit, signal
        for name, coordinate in self._motions.items():
            row = self._row(name)
            signal = _acceleration(row)
            if not isinstance(signal, str):
                return coordinate, row.unit, signal
        return None

    @cached_property
    def _record(self) -> Record:
        return record_in_si(self.record, expected="m/s^2", **self.reading)

    @property
    def _motions(self) -> dict[str, str]:
        """The coordinates of all prescribed motions by the names of their rows."""
        return {name: coordinate for motion in self.scene.table.motion for name, (coordinate, _) in motion.rows.items()}

    def _row(self, name: str) -> ConstraintRow:
        from ....ground.checks import nearest

        motions = self._motions
        by_name = {**{coordinate: row for row, coordinate in motions.items()}, **{row: row for row in motions}}
        if name not in by_name:
            there = f"; there are {', '.join(motions)}" if motions else "; the scene has no [[motion]]"
            raise InputError(f'there is no motion "{name}"{nearest(name, by_name)}{there}')
        return next(row for row in self.scene.equations.system.rows if row.name == by_name[name])

    @cached_property
    def spectrum(self) -> ShockResponseSpectrum | None:
        """The shock response spectrum in SI; None without a shock."""
        return None if self.shock is None else self._spectrum(self.table.quantity)

    def _spectrum(self, quantity: str) -> ShockResponseSpectrum:
        table, (_, _, signal) = self.table, self.shock
        with at(self.file_name, "shock"):
            return shock_response_spectrum(
                signal, table.lines(*_range(signal)), table.damping_ratio, quantity, table.interpolation, table.quality_factor
            )

    @cached_property
    def peaks(self) -> tuple[Peaks, ...]:
        """Of all coordinates and their rates, reactions, and forces of springs and dampers; none of a record."""
        if self.scene is None:
            return ()
        with at(self.file_name, "shock"):
            if self.scene.equations.system is None:
                raise InputError("peaks belong to models with mass, damping and stiffness")
            if self.scene.equations.system.is_sparse:
                raise InputError("peaks are not available for sparse matrices; give arrays")
            every = [self._motion.peaks(self._end, of) for of in QUANTITIES]
        return tuple(one for one in every if one.names)

    @cached_property
    def _motion(self):
        return self.scene.equations.solve()

    @property
    def _end(self) -> float:
        return self.table.end or self.scene.table.time.end

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """How the shock was read, and what makes values doubtful."""
        own = self.spectrum.notices if self.spectrum is not None else ()
        if self.scene is None:
            unknown = Notice(NoticeKind.OMITTED, f"{self.file_name}: the unit of the values is not known; m/s² is taken: give unit")
            return own if self._record.unit else (*own, unknown)
        if self.spectrum is None and self.scene.table.motion:
            reasons = [f'the motion "{name}" {_acceleration(self._row(name))}' for name in self._motions]
            own = (Notice(NoticeKind.OMITTED, f"no shock response spectrum: {'; '.join(reasons)}"),)
        return distinct(self.scene.notices, self.scene.equations.form_notices, self._motion.notices, own)

    # What is shown.

    @property
    def _units(self) -> OutputUnits:
        return self.scene.equations.coordinates.shown if self.scene else OutputUnits(())

    def _shown(self, spectrum: ShockResponseSpectrum) -> tuple[str, float]:
        return self._units.of(spectrum.unit.replace("m", self.shock[1], 1))

    @property
    def title(self) -> str:
        """Of the page."""
        return self.scene.title if self.scene else self.record.name

    @property
    def facts(self) -> tuple[tuple[str, str], ...]:
        """What the shock is, and which oscillators it acts on."""
        lines: list[tuple[str, str]] = []
        if self.spectrum is not None:
            name, unit, signal = self.shock
            size = np.abs(signal(_times(signal))).max()
            shown, factor = self._units.of(rate_unit(unit, 2))
            f, zeta = self.spectrum.frequencies_hz, self.spectrum.damping_ratio
            lines += [
                ("shock", f"{name}, {float(signal.knots[-1]):.4g} s, at most {factor * size:.4g} {shown}"),
                (
                    "oscillators",
                    f"{f[0]:.4g} to {f[-1]:.4g} Hz, damping ratio {zeta:g} (Q = {0.5 / zeta:.4g})" if zeta else "undamped",
                ),
            ]
        if self.scene is not None:
            lines.append(("peaks", f"from 0 to {self._end:g} s, none missed, limits from the left included"))
        return tuple(lines)

    @property
    def tables(self) -> list[TextTable]:
        """The largest values of the spectrum, and the peaks of the model."""
        result = []
        if self.spectrum is not None:
            unit, factor = self._shown(self.spectrum)
            rows = []
            for part in PARTS:
                values = getattr(self.spectrum, part)
                place = int(values.argmax())
                rows.append((part, f"{factor * values[place]:.6g} {unit}", number_text(self.spectrum.frequencies_hz[place])))
            result.append(TextTable(f"Shock response: {self.spectrum.quantity}", ("spectrum", "largest", "at (Hz)"), tuple(rows)))
        return result + [peaks.table(self._units.of) for peaks in self.peaks]

    @property
    def plots(self) -> tuple[Plot, ...]:
        """The spectrum on logarithmic axes, the tripartite plot, the shock over time."""
        if self.spectrum is None:
            return ()
        result = [self._plot(self.spectrum, f"shock response spectrum, {self.spectrum.quantity}", PARTS)]
        if self.table.tripartite:
            velocity = self.spectrum if self.spectrum.quantity == "pseudo-velocity" else self._spectrum("pseudo-velocity")
            unit, factor = self._shown(velocity)
            plot = self._plot(velocity, "tripartite plot of the pseudo-velocity", PARTS[:1])
            result.append(replace(plot, guides=tuple(self._guides(plot, factor))))
        name, unit, signal = self.shock
        shown, factor = self._units.of(rate_unit(unit, 2))
        times = _times(signal)
        result.append(
            Plot(f"acceleration of {name}", shown, times, (Curve(name, factor * signal(times)[0]),), quantity="acceleration")
        )
        return tuple(plot for plot in result if plot is not None)

    def _plot(self, spectrum: ShockResponseSpectrum, title: str, parts: tuple[str, ...]) -> Plot:
        unit, factor = self._shown(spectrum)
        rows = {part: factor * getattr(spectrum, part) for part in parts}
        scale: Scale = "log" if any((row > 0).any() for row in rows.values()) else "linear"
        curves = tuple(Curve(part, row, i) for i, (part, row) in enumerate(rows.items()))
        return Plot(
            title,
            unit,
            spectrum.frequencies_hz,
            curves,
            across_unit="Hz",
            quantity=spectrum.quantity.split(" ")[-1],  # the title has the whole of it
            variable="frequency",
            scales=("log", scale),
        )

    def _guides(self, plot: Plot, factor: float) -> list[Guide]:
        """Lines of equal displacement, v = w d, and of equal acceleration, v = a / w, one for each decade."""
        if plot.scales[1] != "log":
            return []
        across, up = plot.axes
        unit = self.shock[1]
        guides = []
        for exponent, of in ((1.0, unit), (-1.0, rate_unit(unit, 2))):
            shown, own = self._units.of(of)
            corners = np.array([across.low, across.high]) ** -exponent * np.array([[up.low], [up.high]])
            sizes = own / factor * corners / (2 * np.pi) ** exponent
            for power in range(int(np.ceil(np.log10(sizes.min()))), int(np.floor(np.log10(sizes.max()))) + 1):
                guides.append(
                    Guide(
                        f"{power_label(10.0**power)} {raised(shown)}",
                        10.0**power / own * factor * (2 * np.pi) ** exponent,
                        exponent,
                    )
                )
        return guides

    # Page, files, printing.

    @property
    def content(self) -> PageContent:
        """Plots, tables, notices, facts."""
        source = self.scene.table.source if self.scene else "Shock response spectrum"
        tables = tuple(_limited(table, MOST_ROWS_OF_PAGE) for table in self.tables)
        return PageContent(self.title, source, plots=self.plots, tables=tables, notices=self.notices, facts=self.facts)

    @property
    def csv(self) -> dict[str, str]:
        """The spectrum, and the peaks."""
        texts = {}
        if self.spectrum is not None:
            unit, factor = self._shown(self.spectrum)
            values = {f"{part} ({unit})": factor * getattr(self.spectrum, part) for part in PARTS}
            texts[""] = csv_of({"frequency (Hz)": self.spectrum.frequencies_hz, **values})
        if self.peaks:
            columns: dict[str, list] = {
                head: [] for head in ("quantity", "of", "unit", "maximum", "at (s)", "minimum", "minimum at (s)")
            }
            for peaks in self.peaks:
                own = peaks.extrema
                names, factors = zip(*map(self._units.of, peaks.units))
                rows: tuple[Iterable, ...] = (
                    [peaks.quantity] * len(names),
                    peaks.names,
                    names,
                    factors * own.maximum,
                    own.maximum_time,
                    factors * own.minimum,
                    own.minimum_time,
                )
                for column, own_values in zip(columns.values(), rows):
                    column.extend(own_values)
            texts[".peaks"] = csv_of({head: np.array(column) for head, column in columns.items()})
        return texts

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """The spectrum and the peaks in SI."""
        arrays: dict[str, np.ndarray] = {}
        if self.spectrum is not None:
            arrays["frequencies_hz"] = self.spectrum.frequencies_hz
            arrays |= {part: getattr(self.spectrum, part) for part in PARTS}
        for peaks in self.peaks:
            arrays[f"{peaks.quantity}_names"] = np.array(peaks.names)
            for part in ("maximum", "maximum_time", "minimum", "minimum_time"):
                arrays[f"{peaks.quantity}_{part}"] = getattr(peaks.extrema, part)
        return arrays

    def blocks(self) -> list[str | TextTable]:
        """What is printed on 80 columns."""
        heads = (self.scene.heading, self.scene.table.source) if self.scene else (self.title,)
        return response_blocks(heads, self.facts, [_limited(one, MOST_ROWS) for one in self.tables], self.notices, self.files)

    def as_json(self) -> dict:
        """The same as plain data, numbers in SI; the whole spectrum is in the CSV and npz files."""
        spectrum = self.spectrum
        return {
            "title": self.title,
            "spectrum": None
            if spectrum is None
            else {
                "of": self.shock[0],
                "quantity": spectrum.quantity,
                "unit": spectrum.unit.replace("m", self.shock[1], 1),
                "damping_ratio": spectrum.damping_ratio,
                "frequencies_hz": spectrum.frequencies_hz.tolist(),
                **{part: getattr(spectrum, part).tolist() for part in PARTS},
            },
            "peaks": [
                {
                    "quantity": peaks.quantity,
                    "of": name,
                    "unit": unit,
                    "maximum": a,
                    "maximum_time": ta,
                    "minimum": b,
                    "minimum_time": tb,
                }
                for peaks in self.peaks
                for name, unit, a, ta, b, tb in zip(
                    peaks.names,
                    peaks.units,
                    peaks.extrema.maximum.tolist(),
                    peaks.extrema.maximum_time.tolist(),
                    peaks.extrema.minimum.tolist(),
                    peaks.extrema.minimum_time.tolist(),
                )
            ],
            "notices": notices_json(self.notices),
            "trusted": self.is_trusted,
            "files": [str(path) for path in self.files],
        }


def _limited(table: TextTable, most: int) -> TextTable:
    """The first rows, and how many more there are."""
    if len(table.rows) <= most:
        return table
    return replace(table, rows=table.rows[:most], note=f"and {len(table.rows) - most} more")


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


def _range(signal: ImpulsiveSmooth) -> tuple[float, float]:
    """The natural frequencies in Hz by default."""
    knots = np.union1d([0.0], signal.knots)
    duration, gaps = float(knots[-1]), np.diff(knots)
    parts = signal.exact_parts
    is_record = len(knots) > len(parts) + 2
    high = (HIGHEST_OF_RECORD if is_record else HIGHEST) / float(np.median(gaps))
    low = LOWEST / duration
    return max(low, high / 10.0**DECADES), high


def _times(signal: ImpulsiveSmooth) -> np.ndarray:
    """Times of a plot of the signal: even ones and its knots, of a long record some of these."""
    knots = np.asarray(signal.knots, dtype=float)
    some = knots[:: len(knots) // (4 * TIMES) + 1]
    return np.union1d(np.linspace(0.0, LONGER * float(knots[-1]), TIMES), some)
