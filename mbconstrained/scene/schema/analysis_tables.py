"""The tables of analyses in addition to a run: [frequency], [random], [shock], [fatigue], [campbell], [orders], [steady], [path], [vary]."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, PlainValidator, WithJsonSchema, field_validator, model_validator

from ...frequency.plots import shown_axis
from ...frequency.random.spectra import Spectrum, kanai_tajimi, psd, road_profile, white_noise
from ...ground.errors import InputError, named, shown
from ...ground.quantities import number_and_unit, quantity
from ..variations import FORMS, Variation, variation_of
from .entry_types import (
    NUMBER_SCHEMA,
    NUMBERS_SCHEMA,
    QUANTITY_SCHEMA,
    Angle,
    AngularVelocity,
    Column,
    Frequency,
    Number,
    Quantity,
    Ratios,
    Table,
    Text,
    Time,
    Vector,
    Velocity,
    number_or_text,
)

ResponseQuantity = Literal[
    "receptance",
    "mobility",
    "accelerance",
    "dynamic stiffness",
    "impedance",
    "apparent mass",
    "transmissibility",
    "force transmissibility",
    "reaction",
    "force",
]
ResponsePlot = Literal["bode", "parts", "nyquist"]

#: Further names of outputs, for descriptions.
NAMES = '"velocity of x", "b - a", "elongation of spring", "force on ground" …'

#: Keys that several analyses have.
_OUTPUTS = f"Coordinates, springs and dampers (their forces), constraint rows (their reactions), {NAMES}; left out: all "
OUTPUTS: Any = Field(None, description=f"{_OUTPUTS}coordinates, and the [[output.quantity]] tables.")
RELATIVE_TO: Any = Field(None, description="A coordinate or prescribed motion, subtracted from the outputs of its unit.")
MotionQuantity = Literal["displacement", "velocity", "acceleration", "reaction", "force", "torque"]
QUANTITY: Any = Field(
    "displacement", description="Quantity of outputs that are named alone; force or torque: of springs and dampers."
)


def check_range(table, unit: str) -> None:
    """Check that the range of a table ascends."""
    if table.highest is not None and (table.lowest or 0.0) >= table.highest:
        raise InputError(f"from is {table.lowest:g} {unit} and to {table.highest:g} {unit}; expected a range that ascends")


def _loss_factors(value):
    if isinstance(value, dict):
        return {name: quantity(factor, "1") for name, factor in value.items()}
    return quantity(value, "1")


def _frequency(value) -> float:
    """A frequency in Hz; an angular velocity is converted by 1 / (2 pi)."""
    try:
        return float(quantity(value, "Hz"))
    except InputError as problem:
        try:
            return float(quantity(value, "rad/s")) / (2 * math.pi)
        except InputError:
            raise problem from None


AnyFrequency = Annotated[
    float,
    PlainValidator(_frequency),
    WithJsonSchema({"unit": "Hz", "examples": ["2 Hz", "600 rpm"], "anyOf": [{"type": "number"}, QUANTITY_SCHEMA]}),
]


def frequency_lines(value):
    """A list of distinct frequencies in Hz, ascending."""
    if not isinstance(value, list) or not value:
        raise InputError(f'found {shown(value)}; expected an array of frequencies, e.g. ["1 Hz", "2.5 Hz"]')
    lines = [_frequency(entry) for entry in value]
    if (bad := min(lines)) < 0:
        raise InputError(f"found {bad:g} Hz; expected frequencies of at least 0")
    return sorted(set(lines))


FrequencyLines = Annotated[Any, BeforeValidator(frequency_lines), WithJsonSchema({**NUMBERS_SCHEMA, "title": "frequencies"})]


class FrequencyTable(Table):
    """Steady response to harmonic loads and prescribed motions over the frequency."""

    MOST_LINES: ClassVar[int] = 100_000

    inputs: list[Text] | None = Field(
        None, description="Coordinates, each a force on it, or names of [[motion]] tables and constraint rows; by default all motions, "
        "or else the loaded coordinates."
    )  # fmt: skip
    outputs: list[Text] | None = OUTPUTS
    quantity: ResponseQuantity = Field(
        "receptance", description="Kind of response of outputs that are named alone: receptance (displacement / force), … force "
        "transmissibility: what springs, dampers and constraint rows pass to the ground by the force that acts."
    )  # fmt: skip
    relative_to: Text | None = RELATIVE_TO
    lowest: AnyFrequency | None = Field(
        None, alias="from", ge=0, description="The lowest frequency; by default a decade below the lowest pole."
    )
    highest: AnyFrequency | None = Field(
        None, alias="to", gt=0, description="The highest frequency; by default a decade above the highest pole."
    )
    spacing: Literal["auto", "linear", "log"] = Field(
        "auto", description="auto: placed by the poles, so that no peak is missed; or even steps of the frequency or its logarithm."
    )
    points: int | None = Field(None, ge=2, le=MOST_LINES, description="Number of evenly spaced frequencies; 401 by default.")
    frequencies: FrequencyLines = Field(None, description="Explicit list of frequencies.")
    modal_damping: Ratios = Field(
        None, description="Damping ratios in addition to that of the model: one for all modes, or one for each."
    )
    loss_factor: Annotated[
        Any,
        BeforeValidator(_loss_factors),
        WithJsonSchema({"anyOf": [*NUMBER_SCHEMA["anyOf"], {"type": "object", "additionalProperties": NUMBER_SCHEMA}]}),
    ] = Field(None, description="Structural damping K (1 + i eta): eta of the model, or by the names of springs.")
    plots: list[ResponsePlot] = Field(
        ["bode"], description="Amplitude and phase; real and imaginary part; one over the other (Nyquist)."
    )
    amplitude: Literal["log", "linear", "dB"] = Field("log", description="The axis of the amplitude.")
    phase: Literal["unwrapped", "wrapped"] = Field("unwrapped", description="wrapped: from -180 to 180 degrees.")
    axis: Annotated[Literal["Hz", "rad/s", "rev/min", "rpm"], AfterValidator(shown_axis)] = Field(
        "Hz", description="The unit of the frequency on the page and in tables."
    )

    def _check(self) -> None:
        of_range = [key for name, key in self._range_keys if name in self.model_fields_set]
        if self.frequencies is not None and of_range:
            raise InputError(f"frequencies and {of_range[0]} cannot both be given; leave out one of them")
        check_range(self, "Hz")
        if self.spacing == "auto":
            if self.points is not None:
                raise InputError('points needs spacing = "linear" or "log"; with "auto" the poles decide how many there are')
        elif self.lowest is None or self.highest is None:
            raise InputError(f'spacing = "{self.spacing}" needs the range: give from and to, e.g. from = "1 Hz", to = "200 Hz"')
        elif self.spacing == "log" and not self.lowest:
            raise InputError("from is 0 Hz; even steps of the logarithm need a positive lowest frequency")

    _range_keys: ClassVar = (("lowest", "from"), ("highest", "to"), ("spacing", "spacing"), ("points", "points"))

    @property
    def is_auto(self) -> bool:
        """Whether the poles place the frequencies."""
        return self.frequencies is None and self.spacing == "auto"

    @property
    def lines(self) -> np.ndarray:
        """The frequencies in Hz, where the poles do not place them, shape (F,)."""
        if self.frequencies is not None:
            return np.array(self.frequencies)
        spaced = np.geomspace if self.spacing == "log" else np.linspace
        return spaced(self.lowest, self.highest, self.points or 401)


#: The kinds of spectra, one key each.
KINDS = ("values", "file", "white", "road", "soil")


def _array_of(unit: str, expected: str) -> BeforeValidator:
    """The type of an array of quantities."""

    def converted(value):
        if not isinstance(value, list):
            raise InputError(f"found {shown(value)}; expected an array of {expected}")
        return [quantity(entry, unit) for entry in value]

    return BeforeValidator(converted)


Corners = Annotated[Any, _array_of("Hz", 'frequencies, e.g. ["10 Hz", "2000 Hz"]'), WithJsonSchema(NUMBERS_SCHEMA)]
_DENSITY_SCHEMA = {"anyOf": [{"type": "number"}, {"type": "string", "title": "a number and the unit of a density"}]}
Density = Annotated[Number, WithJsonSchema(_DENSITY_SCHEMA)]
_DENSITIES_SCHEMA = {"type": "array", "items": _DENSITY_SCHEMA}
Densities = Annotated[Any, _array_of("1", "numbers in the unit of the density"), WithJsonSchema(_DENSITIES_SCHEMA)]


class RoadTable(Table):
    """A road of ISO 8608."""

    road_class: Literal["A", "B", "C", "D", "E", "F", "G", "H"] = Field(alias="class", description="A (very good) to H.")
    speed: Velocity = Field(gt=0, description='Of the vehicle, e.g. "20 m/s".')


class SoilTable(Table):
    """The spectrum of Kanai and Tajimi: white noise filtered by a layer of soil."""

    intensity: Density = Field(
        gt=0, description="Intensity of the acceleration of the rock, one-sided, in the unit of the density."
    )
    frequency: Frequency = Field(2.5, gt=0, description="Natural frequency of the soil.")
    damping_ratio: Number = Field(0.6, gt=0, description="Damping ratio of the soil.")


class CurveTable(Table):
    """Values over the frequency, in the scene or in a file."""

    frequencies: Corners = Field(None, description="Corner frequencies of a table, ascending.")
    file: Text | None = Field(None, description="Instead of both a file with columns, as of a [[force]]: frequencies first.")
    column: Column | None = Field(None, description="The column of the values, by number or by name in the header; 2 by default.")
    header: int = Field(0, ge=0, description="So many lines at the start of the file hold no numbers.")
    array: Text | None = Field(None, description="The name of the array, or of the sheet of an .xlsx file.")
    decimal: Literal[".", ","] | None = Field(None, description="The decimal mark, where the numbers of the file do not tell it.")

    def _check(self) -> None:
        of_file = {"column", "header", "array", "decimal"} & self.model_fields_set
        if self.file is None and of_file:
            raise InputError(f"{', '.join(sorted(of_file))}: for a file only; give file, too")


def _densities(value) -> tuple[Any, list[str]]:
    """Numbers of densities and the units behind them, an empty text for none."""
    if isinstance(value, list):
        pairs = [_densities(one) for one in value]
        return [one for one, _ in pairs], [unit for _, own in pairs for unit in own]
    if not isinstance(value, str):
        return value, [""]
    number, unit = number_and_unit(value)
    return number, [unit]


class RandomInputTable(CurveTable):
    """A random force, or the random motion of a support."""

    on: Text = Field(description="A coordinate, for a force on it, or a [[motion]] or constraint row, for its motion.")
    of: Literal["force", "displacement", "velocity", "acceleration"] = Field("force", description="Quantity of the density.")
    values: Densities = Field(None, description='The one-sided density at the corners, e.g. ["0.01 g^2/Hz", "0.04 g^2/Hz"].')
    unit: Text | None = Field(None, description='Of the density, e.g. "g^2/Hz"; that of the file, or SI when left out.')
    interpolation: Literal["log-log", "linear", "steps"] = Field("log-log", description="Between the corners.")
    white: Density | None = Field(None, gt=0, description="Intensity of white noise, instead of a table.")
    road: RoadTable | None = Field(None, description="Road profile of ISO 8608 (displacement), instead of a table.")
    soil: SoilTable | None = Field(None, description="Ground acceleration of Kanai and Tajimi, instead of a table.")
    delay: Time = Field(0.0, description="The process of the other inputs, later.")

    @model_validator(mode="before")
    @classmethod
    def _with_unit(cls, data):
        """Values such as "0.04 g^2/Hz" as numbers, with their unit in the place of unit."""
        soil = data.get("soil") if isinstance(data, dict) else None
        places = ((data, "values"), (data, "white"), (soil, "intensity"))
        changed = {(key, id(table)): _densities(table[key]) for table, key in places if isinstance(table, dict) and key in table}
        units = list(dict.fromkeys(unit for _, own in changed.values() for unit in own))
        if not any(units):
            return data
        if len(units) > 1 or "unit" in data:
            named = [unit or "numbers without a unit" for unit in (*units, *([data["unit"]] if "unit" in data else []))]
            raise InputError(
                f"found values in {' and '.join(map(str, dict.fromkeys(named)))}; give all of them with the same unit, or unit alone"
            )
        numbers = {key: value for (key, _), (value, _) in changed.items()}
        own = {"soil": {**soil, "intensity": numbers.pop("intensity")}} if "intensity" in numbers else {}
        return {**data, **numbers, **own, "unit": units[0]}

    def _check(self) -> None:
        super()._check()
        given = [key for key in KINDS if getattr(self, key) is not None]
        if len(given) != 1:
            raise InputError(
                f"found {' and '.join(given) or 'no spectrum'}; expected one of values (with frequencies), file, white, road or soil"
            )
        if (self.frequencies is None) != (self.values is None):
            raise InputError("frequencies and values belong together: give both for a table")

    def spectrum(self, curve: Callable) -> Spectrum:
        """The one-sided density; a function of this table reads its file."""
        if self.white is not None:
            return white_noise(self.white, self.of, self.unit)
        if self.road is not None:
            return road_profile(self.road.road_class, self.road.speed)
        if self.soil is not None:
            return kanai_tajimi(self.soil.intensity, self.soil.frequency, self.soil.damping_ratio, self.unit)
        frequencies, values, unit = curve(self)
        return psd(frequencies, values, self.of, unit, self.interpolation)


class RandomTable(Table):
    """The stationary response to random forces and random motions of supports."""

    input: list[RandomInputTable] = Field(min_length=1, description="The random inputs, [[random.input]].")
    outputs: list[Text] | None = Field(None, description=f"{_OUTPUTS}that have the quantity, and the [[output.quantity]] tables.")
    quantity: Literal["displacement", "velocity", "acceleration", "reaction", "force", "elongation"] = Field(
        "displacement", description="Quantity of outputs that are named alone; force and elongation: of springs and dampers."
    )
    relative_to: Text | None = Field(None, description="A coordinate or prescribed motion, subtracted from the outputs.")
    coherence: Number | None = Field(
        None,
        ge=0,
        le=1,
        description="Ordinary coherence of all inputs; independent when left out, coherent where they have delays.",
    )
    duration: Time = Field(60.0, gt=0, description="Duration for the expected largest value.")
    modal_damping: Ratios = Field(None, description="Damping ratios in addition to that of the model.")


ShockQuantity = Literal[
    "absolute acceleration", "relative displacement", "relative velocity", "pseudo-velocity", "pseudo-acceleration"
]


class OscillatorsTable(Table):
    """Single oscillators on a support that moves."""

    of: Text | None = Field(None, description="The [[motion]] whose acceleration acts on them; by default the first that ends.")
    damping_ratio: Number = Field(0.05, ge=0, description="Damping ratio of the oscillators.")
    quality_factor: Number | None = Field(None, gt=0, description="Alternatively: Q = 1 / (2 damping ratio).")
    lowest: AnyFrequency | None = Field(
        None, alias="from", gt=0, description="The lowest natural frequency; by default a tenth of the inverse duration."
    )
    highest: AnyFrequency | None = Field(None, alias="to", gt=0, description="The highest natural frequency.")
    per_octave: int = Field(12, ge=1, le=96, description="Natural frequencies in each octave.")
    frequencies: FrequencyLines = Field(None, description="Explicit list of natural frequencies.")

    def _check(self) -> None:
        if self.quality_factor is not None and "damping_ratio" in self.model_fields_set:
            raise InputError("damping_ratio and quality_factor cannot both be given; leave out one of them")
        if self.frequencies is not None and (given := {"lowest", "highest", "per_octave"} & self.model_fields_set):
            names = {"lowest": "from", "highest": "to"}
            raise InputError(f"frequencies and {names.get(min(given), min(given))} cannot both be given; leave out one of them")
        if self.frequencies is not None and not min(self.frequencies) > 0:
            raise InputError("frequencies: found 0 Hz; expected positive natural frequencies")
        check_range(self, "Hz")

    def lines(self, lowest: float, highest: float) -> np.ndarray:
        """The natural frequencies in Hz, shape (F,)."""
        if self.frequencies is not None:
            return np.array(self.frequencies)
        low, high = self.lowest or lowest, self.highest or highest
        if not low < high:
            low, high = (low, 1e3 * low) if self.lowest else (high / 1e3, high)
        return np.geomspace(low, high, int(np.ceil(self.per_octave * np.log2(high / low))) + 1)


class ShockTable(OscillatorsTable):
    """Peaks of the model, and of single oscillators on its support (the shock response spectrum)."""

    end: Time | None = Field(None, gt=0, description="Until when peaks of the model are searched; by default time.end.")
    outputs: list[Text] | None = Field(
        None, description=f"Further quantities whose peaks are searched: {NAMES}; left out: the [[output.quantity]] tables."
    )
    quantity: ShockQuantity = Field("absolute acceleration", description="Response quantity of the oscillators.")
    interpolation: Literal["linear", "band-limited"] = Field("linear", description="Interpolation of a record between its samples.")
    tripartite: bool = Field(
        False, description="The pseudo-velocity, too, with lines of equal displacement and of equal acceleration."
    )


class FatigueTable(OscillatorsTable):
    """Cycles and damage of the model, and of single oscillators on its support (the fatigue damage spectrum)."""

    exponent: Number = Field(gt=0, description="k of the S-N curve: N = (strength / amplitude)^k cycles to failure.")
    strength: Quantity | None = Field(
        None, description='The amplitude that fails in one cycle, e.g. "40 kN"; left out: amplitudes of equal damage alone.'
    )
    outputs: list[Text] | None = Field(
        None, description=f"{NAMES}; left out: all with the quantity, and [[output.quantity]], that the strength fits."
    )
    quantity: Literal["force", "elongation", "displacement", "velocity", "acceleration", "reaction"] = Field(
        "force", description="Quantity whose cycles are counted; force and elongation: of springs and dampers."
    )
    end: Time | None = Field(None, gt=0, description="Until when cycles are counted; by default time.end.")
    duration: Time = Field(3600.0, gt=0, description="How long the excitation of [random] acts.")
    spectrum: ShockQuantity = Field(
        "pseudo-velocity", description="Response quantity of the oscillators; stresses follow the velocity."
    )


class CampbellTable(Table):
    """Eigenvalues and unbalance response over the speed of a rotor."""

    lowest: AngularVelocity | None = Field(None, alias="from", ge=0, description="The lowest speed; 0 by default.")
    highest: AngularVelocity | None = Field(
        None, alias="to", gt=0, description="The highest speed; by default beyond all critical speeds of order 1."
    )
    points: int = Field(101, ge=2, le=10_001, description="Number of speeds, both ends included.")
    orders: Annotated[list[Annotated[Number, Field(gt=0)]], Field(min_length=1, max_length=12)] = Field(
        [1.0], description="Orders of excitation, multiples of the speed: 1 for unbalance, 2 for a shaft of two stiffnesses."
    )

    def _check(self) -> None:
        check_range(self, "rad/s")
        if len(set(self.orders)) < len(self.orders):
            raise InputError("orders: one is given twice; give each once")


def _one_or_several(convert: Callable[[Any], Any]):
    """A function that converts an entry to a list: a value of its own, or an array of several."""
    return lambda value: [convert(entry) for entry in value] if isinstance(value, list) else [convert(value)]


def _order(value) -> float:
    order = quantity(value, "1")
    if order < 0:
        raise InputError(f"found {order:g}; expected orders of at least 0, multiples of the speed")
    return order


SEVERAL_SCHEMA = WithJsonSchema({"anyOf": [*NUMBER_SCHEMA["anyOf"], NUMBERS_SCHEMA]})
OneOrSeveral = Annotated[Any, BeforeValidator(_one_or_several(number_or_text)), SEVERAL_SCHEMA]


class OrderExcitationTable(Table):
    """A force or a prescribed motion of some orders: amplitude cos(n W t + phase) at the speed W, or unbalance W^2 cos(n W t + phase)."""

    on: Text = Field(description="A coordinate, for a force on it, or a [[motion]] or constraint row, for its motion.")
    order: Annotated[Any, BeforeValidator(_one_or_several(_order)), SEVERAL_SCHEMA] = Field(
        description="n, a multiple of the speed, or several, e.g. [0.5, 1, 1.5]; 0 is a mean value."
    )
    amplitude: OneOrSeveral = Field(None, description='One for each order, e.g. ["20 N*m", "150 N*m"].')
    unbalance: OneOrSeveral = Field(
        None,
        description='Instead of amplitude: mass times eccentricity, e.g. "5 g*mm", or for a torque in kg m²; the force is that times W².',
    )
    phase: Annotated[Any, BeforeValidator(_one_or_several(lambda value: quantity(value, "rad"))), SEVERAL_SCHEMA] = Field(
        [0.0], description="Phase of the cosine: one for all orders, or one for each."
    )
    law: Literal["constant", "speed^2"] = Field(
        "constant",
        description='Of the amplitude over the speed: "speed^2" grows as inertia forces do, and equals amplitude at the speed at.',
    )
    at: AngularVelocity | None = Field(
        None, gt=0, description='With law = "speed^2": the speed at which the amplitudes are those given.'
    )

    def _check(self) -> None:
        if (self.amplitude is None) == (self.unbalance is None):
            raise InputError("give either amplitude or unbalance: how large is the excitation?")
        key = "amplitude" if self.unbalance is None else "unbalance"
        for name, values in ((key, getattr(self, key)), ("phase", self.phase)):
            if len(values) != len(self.order) and not (name == "phase" and len(values) == 1):
                raise InputError(f"found {len(self.order)} in order and {len(values)} in {name}; expected as many of both")
        if twice := [order for order in self.order if self.order.count(order) > 1]:
            raise InputError(
                f"order: {twice[0]:g} is given twice; give each once, or another [[orders.excitation]], which is added"
            )
        if self.unbalance is not None and "law" in self.model_fields_set and self.law == "constant":
            raise InputError("unbalance has a force that grows with the square of the speed; leave law out, or give amplitude")
        if self.unbalance is None and (self.law == "speed^2") != (self.at is not None):
            raise InputError(
                'law = "speed^2" and at belong together, e.g. at = "3000 rpm": the speed at which the amplitudes are those given'
            )
        if self.unbalance is not None and self.at is not None:
            raise InputError("at belongs to amplitudes; an unbalance has its force at every speed, leave at out")


class OrdersTable(Table):
    """The steady response to excitations that are multiples of a speed, over the speed."""

    lowest: AngularVelocity | None = Field(None, alias="from", ge=0, description="The lowest speed; 0 by default.")
    highest: AngularVelocity | None = Field(
        None, alias="to", gt=0, description="The highest speed; by default beyond the resonances of the lowest order."
    )
    points: int = Field(201, ge=2, le=10_001, description="Number of speeds, both ends included, besides those near resonances.")
    excitation: list[OrderExcitationTable] = Field([], description="The excitations, [[orders.excitation]].")
    outputs: list[Text] | None = OUTPUTS
    quantity: MotionQuantity = QUANTITY
    relative_to: Text | None = RELATIVE_TO

    def _check(self) -> None:
        check_range(self, "rad/s")


class SteadyTable(Table):
    """The cycle that remains after all free motion has decayed."""

    period: Time | None = Field(
        None, gt=0, description="Of records, which repeat with it, or of a motion that switches, where nothing tells it; left out: that of "
        "the harmonic loads."
    )  # fmt: skip
    harmonics: int = Field(50, ge=1, le=2000, description="Number of harmonics of a record whose amplitudes are listed.")
    outputs: list[Text] | None = OUTPUTS
    quantity: MotionQuantity = QUANTITY


class PathTable(Table):
    """Straight lines from corner to corner."""

    body: Text = Field(description="A link of the URDF.")
    point: Vector = Field([0.0, 0.0, 0.0], description="Point of the body, in the link's frame.")
    corners: Annotated[list[Vector], Field(min_length=2, max_length=1000)] = Field(
        description="Places of the point in the directions of the ground: where the path starts, turns and ends."
    )
    orientation: Annotated[list[Angle], Field(min_length=3, max_length=3)] | None = Field(
        None, description="Roll, pitch, yaw of the body all along the path; left out: any."
    )
    points: int = Field(21, ge=2, le=1001, description="Number of positions, evenly spaced along the path, both ends included.")

    @field_validator("corners")
    @classmethod
    def _distinct(cls, corners):
        if any(first == second for first, second in pairwise(corners)):
            raise InputError("found the same place twice in succession; expected corners that differ")
        return corners

    @property
    def places(self) -> np.ndarray:
        """Positions (m), shape (points, 3)."""
        corners = np.array(self.corners)
        lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
        return np.array([np.interp(np.linspace(0.0, lengths[-1], self.points), lengths, column) for column in corners.T]).T


Method = Literal["random", "latin hypercube", "sobol", "saltelli", "one at a time"]


def _variations(value) -> dict[str, Variation]:
    if not isinstance(value, dict):
        raise InputError(f"found {shown(value)}; expected names with ranges, lists or distributions: {FORMS}")
    result = {}
    for name, given in value.items():
        with named(name):
            result[name] = variation_of(given)
    return result


def _parts(entry):
    """The entry, or the names and the number of a text such as "k,m=0.5"."""
    if not isinstance(entry, str):
        return entry
    names, _, value = entry.partition("=")
    try:
        return [*(name.strip() for name in names.split(",")), float(value)]
    except ValueError:
        raise InputError(f'found "{entry}"; expected A,B=R, e.g. k,m=0.5') from None


def _correlations(value) -> list[tuple[str, str, float]]:
    entries = [_parts(entry) for entry in (value if isinstance(value, list) else [value])]
    for entry in entries:
        is_entry = isinstance(entry, (list, tuple)) and len(entry) == 3
        if not (is_entry and all(isinstance(name, str) for name in entry[:2]) and isinstance(entry[2], (int, float))):
            raise InputError(f'found {shown(entry)}; expected two parameters and their correlation, e.g. ["k", "m", 0.5]')
    return [(one, other, float(rho)) for one, other, rho in entries]


class VaryTable(Table):
    """Parameters that are varied: by the commands sweep and optimise."""

    MOST_SAMPLES: ClassVar[int] = 100_000_000

    parameters: Annotated[
        dict[str, Any],
        BeforeValidator(_variations),
        WithJsonSchema({"type": "object", "additionalProperties": {"anyOf": [{"type": "string"}, {"type": "array"}]}}),
    ] = Field({}, description=f"By the name of a parameter or by place, as for --set: {FORMS}.")
    method: Method = Field(
        "random",
        description="Sampling of the distributions; saltelli: for Sobol indices; one at a time: low and high values for a tornado plot.",
    )
    samples: int = Field(1000, ge=1, le=MOST_SAMPLES, description="Number of samples, at each combination of given values.")
    seed: int = Field(0, ge=0, le=2**63 - 1, description="Seed of the random numbers.")
    correlation: Annotated[
        list[Any], BeforeValidator(_correlations), WithJsonSchema({"type": "array", "items": {"type": "array"}})
    ] = Field([], description='Of the normal scores of two parameters, e.g. [["k", "m", 0.5]].')
    keep: list[Text] | None = Field(
        None,
        description='Kept quantities of each sample: "frequencies", "response peaks", "random RMS", "maximum x", "x at 2 s", "curve x" …; '
        "left out: frequencies, response peaks and RMS values, and the largest values of the plotted coordinates.",
    )
    limits: dict[Text, Any] = Field(
        {}, description='Whose exceedance has its probability estimated, e.g. { "largest x" = "5 mm" }.'
    )
    minimise: Text | None = Field(None, description='The figure that the command optimise makes least, e.g. "response peak".')
    maximise: Text | None = Field(None, description="Or the one that it makes largest.")
    chunk: int | None = Field(None, ge=1, le=100_000, description="Samples that are computed and stored together.")

    def _check(self) -> None:
        for one, other, rho in self.correlation:
            if not abs(rho) < 1:
                raise InputError(f"correlation: found {rho:g} of {one} and {other}; expected a number between -1 and 1")
            if one == other:
                raise InputError(f'correlation: found "{one}" twice; expected two parameters')
