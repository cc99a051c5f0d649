"""Fatigue: cycles and damage of a scene's outputs, and the fatigue damage spectrum of its support or of a record."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, cast

import numpy as np

from ..frequency.fatigue import CycleCount, FatigueDamageSpectrum, fatigue_damage_spectrum, rainflow
from ..frequency.random.spectra import Spectrum
from ..frequency.shock_spectrum import UNITS
from ..ground.display import TextTable, number_text
from ..ground.errors import InputError, named
from ..ground.notices import distinct
from ..ground.quantities import quantity as number_of
from ..mechanics.peaks import cycles
from ..page.content import Curve, Plot
from ..scene.build.data_files import record_in_si
from ..scene.coordinates import OutputUnits
from ..scene.file import at
from ..scene.schema.analysis_tables import FatigueTable
from ..signals.impulsive import ImpulsiveSmooth
from .base import Analysis, Answer
from .random import random_response
from .shock import excitation_of, natural_range, no_spectrum, unknown_unit

if TYPE_CHECKING:
    from ..frequency.random.random_response import RandomResponse
    from ..mechanics.motion import Motion
    from ..scene.run.scene import Scene

#: Ranges of the plot of cycles.
RANGES = 201

#: Decades of natural frequencies beyond the corners of a spectrum that has none.
WHITE = (1.0, 1e3)


class Fatigue(Analysis):
    """Cycles of every spring and damper by the rainflow method with their damage, and the fatigue damage spectrum of a support.

    Turning points are those of the closed-form motion. Under the excitation of [random] the damage is that of Dirlik's formula. Of a record,
    a file with columns of times and values, its cycles, and of an acceleration the spectrum. Writes NAME.fatigue.html, .csv, .cycles.csv and .npz.
    """

    name = "fatigue"
    settings = FatigueTable
    switches = "none"
    options: ClassVar = {"damping_ratio": "--damping", "quality_factor": "--quality", "outputs": "--output"}
    replaced: ClassVar = {
        "damping_ratio": ("quality_factor",), "quality_factor": ("damping_ratio",), "from": ("frequencies",), "to": ("frequencies",)
    }  # fmt: skip

    @classmethod
    def solve(cls, scene: Scene, settings: FatigueTable | None) -> Answer:
        system = scene.equations.system
        with at(scene.file_name, "fatigue"):
            if settings is None:
                raise InputError("give the exponent of the S-N curve: exponent in a table [fatigue], or --exponent")
            if system is None or system.is_sparse:
                raise InputError("cycles belong to models with mass, damping and stiffness, in arrays")
            end, motion = settings.end or scene.table.time.end, cast("Motion", scene.equations.solve())
            histories = _histories(scene, settings, motion, end)
            random = _random(scene, settings, list(histories))
            part = _Counted(settings, scene.equations.coordinates.shown, histories, end, random, settings.quantity)
            spectra, motions = tuple(_spectra(scene, settings)), scene.table.prescribed
            omitted = () if spectra or not motions else (no_spectrum(scene, "fatigue damage spectrum", motions),)
            notices = distinct(scene.notices, scene.equations.form_notices, motion.notices, omitted)
            return cls.of(scene, heading=scene.heading, notices=notices, **_fields(part, spectra))

    @classmethod
    def of_record(cls, path: Path, table: FatigueTable, **reading) -> Answer:
        """Cycles of the record in a file, and of an acceleration the fatigue damage spectrum; reading as in ``record_in_si``."""
        try:
            record = record_in_si(path, expected="m/s^2", **reading)
        except InputError:  # not an acceleration, or wrong in any unit
            record = record_in_si(path, **reading)
        is_acceleration, notices = record.unit in ("m/s^2", ""), (*record.notices, *unknown_unit(path, record))
        unit, name = record.unit or "m/s^2", record.name or path.stem
        with at(path.name, "fatigue"):
            histories = {name: replace(rainflow(record.values), unit=unit)}
            units = OutputUnits((record.unit_in_file,) if record.unit_in_file else ())
            part = _Counted(table, units, histories, float(np.ptp(record.times)), None, "record")
            spectra = (_Damage(table, name, record.signal),) if is_acceleration else ()
            return cls.of_file(path, "Cycles of a record", notices=notices, **_fields(part, spectra))


def _histories(scene: Scene, settings: FatigueTable, motion: Motion, end: float) -> dict[str, CycleCount]:
    """Cycles of the requested outputs; by default of all with the quantity, and of [[output.quantity]], that the strength fits."""
    if settings.outputs is not None:
        return cycles(motion, end, settings.quantity, settings.outputs)
    own = cycles(motion, end, settings.quantity)
    if scene.table.output.quantity:
        own |= cycles(motion, end, settings.quantity, [one for one in motion.system.quantities if one not in own])
    fitting = {name: count for name, count in own.items() if _fits(settings.strength, count.unit)}
    if own and not fitting:
        units = ", ".join(dict.fromkeys(count.unit for count in own.values()))
        raise InputError(f"strength: found {settings.strength!r}; the outputs are in {units}")
    if not own:
        raise InputError(
            f'the model has nothing with the quantity "{settings.quantity}"; springs and dampers need names for force and elongation'
        )
    return fitting


def _fits(strength, unit: str) -> bool:
    if strength is None:
        return True
    with suppress(InputError):
        number_of(strength, unit)
        return True
    return False


def _random(scene: Scene, settings: FatigueTable, outputs: list[str]) -> RandomResponse | None:
    """The response of the outputs to [random]."""
    table = scene.table.random
    if table is None:
        return None
    return random_response(scene, table.model_copy(update={"quantity": settings.quantity, "outputs": outputs, "relative_to": None}))


def _spectra(scene: Scene, settings: FatigueTable) -> Iterator[_Damage]:
    """The damage spectra of the support: under its motion, and under that of [random]."""
    if (excitation := excitation_of(scene, settings.of, scene.table.prescribed)) is not None:
        coordinate, unit, signal = excitation
        if unit == "m":
            yield _Damage(settings, coordinate, signal)
    for entry in scene.table.random.input if scene.table.random else ():
        if entry.of != "force":
            from ..scene.build.data_files import curve_of

            yield _Damage(settings, f"random {entry.on}", entry.spectrum(lambda table: curve_of(table, scene.folder)))


@dataclass(frozen=True, eq=False)
class _Damage:
    """The fatigue damage spectrum of a motion of a support."""

    settings: FatigueTable
    name: str
    excitation: ImpulsiveSmooth | Spectrum

    @cached_property
    def spectrum(self) -> FatigueDamageSpectrum:
        own, time = self.settings, None
        if isinstance(self.excitation, Spectrum):
            corners, time = self.excitation.corners, own.duration
            low, high = (corners[0] or WHITE[0], corners[-1] if np.isfinite(corners[-1]) else WHITE[1]) if corners else WHITE
        else:
            low, high = natural_range(self.excitation)
        return fatigue_damage_spectrum(
            self.excitation, own.lines(low, high), own.exponent, own.damping_ratio, own.spectrum, own.quality_factor, duration=time
        )


@dataclass(frozen=True, eq=False)
class _Counted:
    """The cycles of outputs with their damage, in the units shown."""

    settings: FatigueTable
    units: OutputUnits
    histories: dict[str, CycleCount]
    duration: float
    response: RandomResponse | None
    called: str  # the counted quantity

    def strength(self, unit: str) -> float | None:
        """The strength in the SI unit of an output; None where it is not given."""
        if self.settings.strength is None:
            return None
        with named("strength"):
            size = number_of(self.settings.strength, unit)
            if not size > 0:
                raise InputError(f"found {size:g}; expected a positive strength")
            return size

    @cached_property
    def rows(self) -> list[dict]:
        """The figures of every output as plain data in SI."""
        k, result = self.settings.exponent, []
        for name, own in self.histories.items():
            strength = self.strength(own.unit)
            damage = None if strength is None else own.damage(k, strength)
            result.append({
                "of": name, "unit": own.unit, "cycles": own.total, "largest_range": float(own.ranges.max(initial=0.0)),
                "equivalent_amplitude": own.equivalent_amplitude(k), "damage": damage,
                "life": self.duration / damage if damage else None,
            })  # fmt: skip
        return result

    @cached_property
    def random_rows(self) -> list[dict]:
        """RMS values and damage rates under [random]."""
        R = self.response
        if R is None:
            return []
        result = []
        for i, (name, unit, rms) in enumerate(zip(R.outputs, R.units, R.rms)):
            strength = self.strength(unit)
            rate = None if strength is None else float(R.damage_rate(self.settings.exponent, strength)[i])
            result.append({
                "of": name, "unit": unit, "rms": float(rms), "peaks_hz": float(R.peak_rate[i]), "damage_per_second": rate,
                "damage": None if rate is None else rate * self.settings.duration, "life": 1 / rate if rate else None,
            })  # fmt: skip
        return result

    def tables(self) -> Iterator[TextTable]:
        """Cycles with their damage until the end, and the damage under [random]."""
        k, rows = self.settings.exponent, []
        for row in self.rows:
            unit, factor = self.units.of(row["unit"], row["of"])
            sizes = (f"{number_text(factor * row[key])} {unit}" for key in ("largest_range", "equivalent_amplitude"))
            rows.append((row["of"], f"{row['cycles']:g}", *sizes, *_damage(row)))
        columns = ("of", "cycles", "largest range", "equal amplitude", "damage", "life")
        note = (
            "equal amplitude: of as many equal cycles with the same damage; damage 1 is failure, reached after the life by repetition; "
            "amplitudes count, means do not"
        )
        yield TextTable(f"Cycles of the {self.called} in {self.duration:g} s", columns, tuple(rows), note)
        if self.response is not None:
            own = []
            for row in self.random_rows:
                unit, factor = self.units.of(row["unit"], row["of"])
                own.append((row["of"], f"{number_text(factor * row['rms'])} {unit}", number_text(row["peaks_hz"]), *_damage(row)))
            title = f"Random {self.settings.quantity}, damage in {_duration(self.settings.duration)}, exponent {k:g}"
            yield TextTable(title, ("of", "RMS", "peaks (Hz)", "damage", "life"), tuple(own), "Dirlik's formula")

    def plots(self) -> Iterator[Plot]:
        """Numbers of cycles of at least each range, by unit."""
        for own_unit in dict.fromkeys(count.unit for count in self.histories.values()):
            own = {name: count for name, count in self.histories.items() if count.unit == own_unit and len(count.ranges)}
            if not own:
                continue
            unit, factor = self.units.of(own_unit, next(iter(own)))
            largest = max(count.ranges.max() for count in own.values())
            ranges = np.linspace(0.0, largest, RANGES)
            numbers = {name: count.exceedance(ranges) for name, count in own.items()}
            curves = tuple(
                Curve(name, np.maximum(values, 0.5), i, drawn=values > 0) for i, (name, values) in enumerate(numbers.items())
            )
            yield Plot(
                "cycles of at least a range", "", factor * ranges, curves, across_unit=unit, quantity="cycles", variable="range",
                scales=("linear", "log"),
            )  # fmt: skip


def _damage(row: dict) -> tuple[str, str]:
    if row["damage"] is None:
        return "–", "–"
    damage = number_text(row["damage"]) if np.isfinite(row["damage"]) else "infinite"
    return damage, _duration(row["life"]) if row["life"] is not None else "infinite"


def _duration(seconds: float) -> str:
    """A duration in the largest unit of which it has one or more."""
    sizes = {"years": 31_557_600.0, "days": 86_400.0, "h": 3600.0, "min": 60.0}
    unit, size = next(((unit, size) for unit, size in sizes.items() if seconds >= size), ("s", 1.0))
    return f"{number_text(seconds / size)} {unit}"


def _fields(part: _Counted, damages: tuple[_Damage, ...]) -> dict[str, Any]:
    """The fields of an answer with cycles and damage spectra."""
    k, settings = part.settings.exponent, part.settings
    spectra = {one.name: one.spectrum for one in damages}
    strength, unit = f"strength {settings.strength}" if settings.strength else "no strength given", UNITS[settings.spectrum]
    facts = [("S-N curve", f"N = (strength / amplitude)^{k:g}, {strength}")]
    for own, S in spectra.items():
        zeta = S.damping_ratio
        text = f"{own}, {S.frequencies_hz[0]:.4g} to {S.frequencies_hz[-1]:.4g} Hz, {S.quantity}, damping ratio {zeta:g} (Q = {0.5 / zeta:.4g})"
        facts.append(("damage spectrum", text))

    def columns() -> dict:
        files: dict = {}
        for number, (own, S) in enumerate(spectra.items()):
            head = {"frequency (Hz)": S.frequencies_hz, f"{own}: sum of n a^{k:g} (({unit})^{k:g})": S.damage}
            files[f".{number + 1}" if number else ""] = head
        every = [(name, count.unit) for name, count in part.histories.items() for _ in count.ranges]
        counts = list(part.histories.values())
        shown = [part.units.of(own, name) for name, own in every]
        sizes = {
            key: np.concatenate([getattr(count, key) for count in counts]) if counts else np.zeros(0)
            for key in ("ranges", "means", "counts")
        }
        factors = np.array([factor for _, factor in shown])
        files[".cycles"] = {
            "of": [name for name, _ in every], "unit": [unit for unit, _ in shown],
            "range": sizes["ranges"] * factors, "mean": sizes["means"] * factors, "count": sizes["counts"],
        }  # fmt: skip
        return files

    def arrays() -> dict[str, np.ndarray]:
        result = {}
        for own, count in part.histories.items():
            result |= {f"{own} {key}": getattr(count, key) for key in ("ranges", "means", "counts")}
        for own, S in spectra.items():
            result |= {f"{own} frequencies_hz": S.frequencies_hz, f"{own} damage": S.damage}
        return result

    def plots() -> Iterator[Plot]:
        yield from part.plots()
        for own, S in spectra.items():
            if (S.damage > 0).all():
                yield Plot(
                    f"fatigue damage spectrum of {own}", f"({unit})^{k:g}", S.frequencies_hz, (Curve(own, S.damage),),
                    across_unit="Hz", quantity="damage", variable="frequency", scales=("log", "log"),
                )  # fmt: skip

    keys = ("quantity", "damping_ratio", "frequencies_hz", "damage")
    every = [{"of": own, **{key: getattr(S, key) for key in keys}} for own, S in spectra.items()]
    data = {"exponent": k, "duration": part.duration, "cycles": part.rows, "random": part.random_rows, "spectra": every}
    tables = tuple(part.tables())
    return {"facts": tuple(facts), "tables": tables, "data": data, "plots": plots, "columns": columns, "arrays": arrays}
