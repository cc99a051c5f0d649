"""The tables of forces and of prescribed motions, one for each kind of signal, and of motions whose end is given."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from typing import Annotated, Any, ClassVar, Literal, get_args

from pydantic import BeforeValidator, Field, WithJsonSchema, create_model
from pydantic.fields import FieldInfo

from ...ground.errors import InputError, shown
from ...ground.quantities import quantity
from ...mechanics.constraints import Level
from .entry_types import (
    MOST_POWER,
    QUANTITY_SCHEMA,
    Angle,
    AngularVelocity,
    Column,
    Frequency,
    Length,
    Name,
    Number,
    Quantity,
    Rate,
    Table,
    Text,
    Time,
    Unit,
    Values,
    Velocity,
)


def _shaped_modes(value):
    """Numbers of modes, and pairs of frequency in Hz and damping ratio."""
    if not isinstance(value, list) or not value:
        raise InputError(f'found {shown(value)}; expected numbers of modes, e.g. [1, 2], or pairs, e.g. [["0.2 Hz", 0.01]]')
    return [_shaped_mode(entry) for entry in value]


def _shaped_mode(entry):
    if isinstance(entry, int) and not isinstance(entry, bool) and entry > 0:
        return entry
    if not isinstance(entry, list) or len(entry) != 2:
        raise InputError(
            f'found {shown(entry)}; expected the number of a mode, or frequency and damping ratio, e.g. ["0.2 Hz", 0.01]'
        )
    return float(quantity(entry[0], "Hz")), float(quantity(entry[1], "1"))


class ShaperTable(Table):
    """An input shaper: a few delayed copies of the signal, after which modes are at rest (ZV, ZVD), or nearly so (EI)."""

    kind: Literal["ZV", "ZVD", "EI"] = Field(
        "ZVD", description="ZV is the shortest; ZVD tolerates errors of the frequency, EI larger ones."
    )
    modes: Annotated[
        Any,
        BeforeValidator(_shaped_modes),
        WithJsonSchema({"title": "numbers of modes, or pairs of frequency and damping ratio", "type": "array", "minItems": 1}),
    ] = Field(
        None,
        description='Numbers in the table of natural frequencies, or pairs, e.g. [["0.2 Hz", 0.01]]; left out: all that oscillate.',
    )
    vibration_limit: Number | None = Field(
        None,
        gt=0,
        lt=1,
        description="Of EI, what is left at the frequency itself, as a part of that without a shaper; 0.05 if left out.",
    )


class ForceBase(Table):
    """Keys of every force."""

    coordinate: Name | None = Field(
        None, description="The coordinate or the input it acts on; for coefficients: the equation of that number."
    )
    factors: dict[Name, Number] | None = Field(
        None,
        description="Instead of coordinate: several on which multiples of one signal act, e.g. { left = 1, right = -0.5 }; one input.",
    )
    name: Name | None = Field(None, description='Of the load by factors as an input; left out: "load on" and its coordinates.')
    delay: Time = Field(0.0, description='It acts later by this, e.g. "2 s"; not negative.')
    speed: Velocity | None = Field(
        None, gt=0, description='Of what moves along a distance, e.g. "20 m/s": records are over x then, and t = x / speed.'
    )
    distance: Length = Field(
        0.0, ge=0, description="It acts later by distance / speed, too, such as the wheelbase at the rear axle of a car."
    )
    shaper: ShaperTable | None = Field(None, description='Input shaper, e.g. { kind = "ZVD" }: the signal leaves no vibration.')

    def _check_places(self) -> None:
        if (self.coordinate is None) == (not self.factors):
            raise InputError("give either coordinate or factors: what does the force act on?")
        if self.name is not None and not self.factors:
            raise InputError("name is that of a load by factors; a force on one coordinate has the name of the coordinate")

    def _check(self) -> None:
        self._check_places()
        if self.delay < 0:
            raise InputError(f"delay: found {self.delay:g} s; expected 0 or a later time")
        if self.distance and self.speed is None:
            raise InputError("distance: it is passed with a speed; give speed, too")
        if self.speed is not None and not self.distance and getattr(self, "kind", "") != "sampled":
            raise InputError("speed: there is nothing along a distance; give distance, or a record over a distance")

    @property
    def places(self) -> dict[str, float]:
        """Factors of the signal by the name of the coordinate or input."""
        return {self.coordinate: 1.0} if self.coordinate is not None else {key: float(one) for key, one in self.factors.items()}

    @property
    def title(self) -> str:
        """Name of the force as an input."""
        return self.coordinate or self.name or f"load on {', '.join(self.places)}"

    @property
    def later(self) -> float:
        """The whole delay in s."""
        return self.delay + self.distance / self.speed if self.distance else self.delay

    @property
    def time_power(self) -> int:
        """The power of seconds by which the unit of the value differs from that of the force."""
        of_kind = _TIME_POWERS.get(getattr(self, "kind", ""))
        return of_kind(self) if of_kind else 0


_TIME_POWERS: dict[str, Callable[[Any], int]] = {
    "ramp": lambda table: -1,
    "power": lambda table: 1 - table.gamma,
    "impulse": lambda table: table.order + 1,
    "term": lambda table: -table.power,
}


class StepTable(ForceBase):
    """value for t >= 0."""

    kind: Literal["step"] = Field(description="Constant from t = 0 on.")
    value: Quantity = Field(description="The force, or the torque on an angle.")


class RampTable(ForceBase):
    """value t."""

    kind: Literal["ramp"] = Field(description="Grows linearly with t.")
    value: Quantity = Field(description='The force by time, e.g. "2 N/s".')


class PowerTable(ForceBase):
    """value t^(gamma-1) / (gamma-1)! for gamma >= 1, the derivatives of Dirac's delta for gamma <= 0."""

    kind: Literal["power"] = Field(description="I_gamma of Hauksdottir: 1 is a step, 2 a ramp, 0 an impulse.")
    gamma: int = Field(ge=-MOST_POWER, le=MOST_POWER, description="The index gamma.")
    value: Quantity = Field(description="The factor.")


class ImpulseTable(ForceBase):
    """value times the derivative of the given order of Dirac's delta at t = 0."""

    kind: Literal["impulse"] = Field(description="An impulsive load (Dirac impulse) at t = 0.")
    order: int = Field(0, ge=0, le=MOST_POWER, description="The order of the derivative of Dirac's delta.")
    value: Quantity = Field(description='The impulse, e.g. "3 N*s".')


class PeriodicTable(ForceBase):
    """Keys of forces with a cosine."""

    value: Quantity = Field(description="The amplitude.")
    angular_frequency: AngularVelocity | None = Field(None, description='w in rad/s, e.g. "12 rad/s" or "300 rpm".')
    frequency: Frequency | None = Field(None, description='w / (2 pi) in Hz, e.g. "2 Hz"; instead of angular_frequency.')
    phase: Angle = Field(0.0, description="The phase of the cosine.")

    def _check(self) -> None:
        super()._check()
        if self.angular_frequency is not None and self.frequency is not None:
            raise InputError("give either angular_frequency (rad/s) or frequency (Hz), not both")

    @property
    def omega(self) -> float:
        """The angular frequency in rad/s."""
        return self.angular_frequency or 2 * math.pi * (self.frequency or 0.0)


class HarmonicTable(PeriodicTable):
    """value cos(w t + phase)."""

    kind: Literal["harmonic"] = Field(description="A cosine from t = 0 on.")

    def _check(self) -> None:
        super()._check()
        if self.angular_frequency is None and self.frequency is None:
            raise InputError('give angular_frequency, e.g. "12 rad/s", or frequency, e.g. "2 Hz"')


class TermTable(PeriodicTable):
    """value t^power e^(rate t) cos(w t + phase)."""

    kind: Literal["term"] = Field(description="One term of a Bohl function.")
    power: int = Field(0, ge=0, le=MOST_POWER, description="The power of t.")
    rate: Rate = Field(0.0, description="The rate of the exponential; negative decays.")


class PulseTable(ForceBase):
    """A pulse of peak value for start <= t < start + duration."""

    kind: Literal["pulse"] = Field(description="Zero before and after; constant between, or of another shape.")
    shape: Literal["rectangle", "half-sine", "versed-sine", "triangle", "sawtooth"] = Field(
        "rectangle", description="sawtooth: ends at its peak."
    )
    value: Quantity = Field(description="The force, or the torque on an angle.")
    start: Time = Field(0.0, description="When it begins.")
    duration: Time = Field(description="Duration of the pulse.")


def _along(value):
    """A time, or a length along which a record is."""
    for unit in ("s", "m"):
        with suppress(InputError):
            quantity(value, unit)
            return value
    return quantity(value, "s")


Along = Annotated[
    Any, BeforeValidator(_along), WithJsonSchema({"examples": ["10 ms", "0.1 m"], "anyOf": [{"type": "number"}, QUANTITY_SCHEMA]})
]


class SampledTable(ForceBase):
    """A record: linear between its samples, zero before the first and after the last."""

    OF_FILE: ClassVar = (  # the keys that say how a file is read
        "column", "time", "step", "unit", "time_unit", "factor", "offset", "header", "array", "decimal", "start", "end", "baseline",
        "baseline_fit",
    )  # fmt: skip

    kind: Literal["sampled"] = Field(description="A record of times and values, in the scene or in a file.")
    times: list[Time] | None = Field(None, description="Times of the samples, ascending; one that stands there twice is a jump.")
    distances: list[Length] | None = Field(None, description="Instead of times distances x of the samples, with a speed.")
    values: list[Quantity] | None = Field(None, description="The force at each of the times.")
    file: Text | None = Field(
        None,
        description="Instead of both a file in the folder of the scene: text with columns of numbers (.csv, .txt, ...), .xlsx, PEER .AT2, "
        "K-NET, ESM, .wav, .uff, or arrays in .npy, .npz, .mat, .mtx, .op4.",
    )
    column: Column | None = Field(None, description="The column of the values, by number or by name in the header; 2 by default.")
    time: Column | None = Field(
        None, description="The column of the times, or with a speed of the distances, by number or name; 1 by default."
    )
    step: Along | None = Field(
        None,
        description="The time, or with a speed the distance, between samples of a file without times; every number is a sample then.",
    )
    unit: Unit | None = Field(None, description='Of the values, e.g. "kN"; by default the one in the header, or SI.')
    time_unit: Unit | None = Field(
        None, description='Of the times, e.g. "ms"; by default the one in the header, or s; of distances m.'
    )
    start: Along | None = Field(None, description="Where the part that acts begins in the file; it becomes t = 0.")
    end: Along | None = Field(None, description="Where the part that acts ends in the file.")
    baseline: Literal["constant", "linear", "quadratic", "cubic"] | None = Field(
        None, description="A polynomial of time that is fitted by least squares and removed; a notice states its size."
    )
    baseline_fit: Literal["record", "integral"] | None = Field(
        None, description="What it is fitted to; integral: of an acceleration its velocity from rest. record if left out."
    )
    factor: Quantity = Field(1.0, description='The values are multiplied by it: a number, or with a unit, e.g. "-1200 kg".')
    offset: Quantity = Field(0.0, description="Is added to the values, after the factor; a force.")
    header: int = Field(0, ge=0, description="So many lines at the start of a text hold no numbers; words are found without it.")
    array: Text | None = Field(
        None, description="The name of the array in an .npz, .mat or .op4 file, or of the sheet in an .xlsx file."
    )
    decimal: Literal[".", ","] | None = Field(None, description="The decimal mark, where the numbers of a text do not tell it.")

    def _check(self) -> None:
        super()._check()
        times = self.times if self.distances is None else self.distances
        if self.times is not None and self.distances is not None:
            raise InputError("give either times or distances, not both")
        if self.file is None and (times is None or self.values is None):
            raise InputError('give times and values, or file, e.g. file = "record.csv"')
        if self.file is not None and (times is not None or self.values is not None):
            raise InputError("give either times and values or file, not both")
        if self.file is None and (given := [key for key in self.OF_FILE if key in self.model_fields_set]):
            raise InputError(f"{', '.join(given)}: for a file only; leave out what is not for times and values")
        if self.file is None and len(times) != len(self.values):
            raise InputError(f"found {len(times)} times and {len(self.values)} values; expected as many of both")
        if self.file is None and (self.distances is None) != (self.speed is None) and not self.distance:
            raise InputError("distances and speed belong together: t = x / speed")

    @property
    def own_times(self) -> list:
        """The times of the samples in the scene."""
        return self.times if self.distances is None else [x / self.speed for x in self.distances]


class MotionBase(Table):
    """Keys of every prescribed motion, in addition to those of a force of its kind."""

    coordinate: Name | None = Field(None, description="The coordinate, joint or point whose motion is prescribed.")
    factors: dict[Name, Number] | None = Field(
        None, description="Instead of coordinate: several that move by multiples of one signal, e.g. { left = 1, right = 0.5 }."
    )
    level: Level = Field("position", description="Level of the value: displacement, velocity or acceleration.")
    name: Name | None = Field(None, description='Of the constraint row; left out: "motion of" and the coordinate.')

    def _check_places(self) -> None:
        if (self.coordinate is None) == (not self.factors):
            raise InputError("give either coordinate or factors: what is it whose motion is prescribed?")

    @property
    def rows(self) -> dict[str, tuple[str, float]]:
        """Coordinate and factor of the signal by the name of the constraint row."""
        if self.coordinate is not None:
            return {self.name or f"motion of {self.coordinate}": (self.coordinate, 1.0)}
        base = self.name or "motion"
        return {f"{base} of {coordinate}": (coordinate, factor) for coordinate, factor in (self.factors or {}).items()}


_FORCES = (StepTable, RampTable, PowerTable, ImpulseTable, HarmonicTable, TermTable, PulseTable, SampledTable)
FORCES: dict[str, type[ForceBase]] = {get_args(table.model_fields["kind"].annotation)[0]: table for table in _FORCES}


#: Descriptions of the values of prescribed motions, whose quantity is the level.
_VALUES = {
    "step": "The displacement, velocity or acceleration; 0 by default: a support at rest, whose motion may be random or any frequency.",
    "ramp": 'Its rate, e.g. "2 mm/s" of a displacement.',
    "impulse": 'The impulse, e.g. "3 mm*s" of a displacement.',
    "pulse": "The largest displacement, velocity or acceleration.",
    "values": "The displacement, velocity or acceleration at each of the times.",
}


@cache
def motion_table(kind: str) -> Any:
    """The table of prescribed motions of a kind; a step of 0 where nothing is given."""
    fields: dict[str, Any] = {}
    for key, of in (("value", kind), ("values", "values")):
        if key in FORCES[kind].model_fields and of in _VALUES:
            own = FORCES[kind].model_fields[key]
            default = 0.0 if kind == "step" else own.default
            fields[key] = own.annotation, FieldInfo.merge_field_infos(own, description=_VALUES[of], default=default)
    if kind == "step":
        fields["kind"] = Literal["step"], Field("step", description="Constant from t = 0 on.")
    name, text = f"{kind.capitalize()}Motion", f'A prescribed motion of the kind "{kind}".'
    return create_model(name, __base__=(MotionBase, FORCES[kind]), __doc__=text, **fields)


# [boundary] and [least_energy].


class EndTable(Table):
    """Values at one end."""

    displacement: Values = Field({}, description="Positions or angles.")
    velocity: Values = Field({}, description="Velocities.")
    acceleration: Values = Field({}, description="Accelerations, for equations of degree 3 and above.")
    state: Values = Field({}, description="States of a state space, instead of all these, e.g. { x1 = 0.1 }.")


class BoundaryTable(Table):
    """Two-point boundary values: some values just after t = 0, others just before T; what is left out is free."""

    start: EndTable = Field(EndTable.model_construct(), description="Values just after t = 0, in the place of [initial].")
    end: EndTable = Field(EndTable.model_construct(), description="Values just before the end T.")
    duration: Time = Field(gt=0, description="T, the time between start and end.")


class LeastEnergyTable(Table):
    """The input u of least energy, the integral of u^2, that moves the model from [initial] to a state; it is zero after T."""

    inputs: list[Name] | None = Field(
        None, description="Coordinates, each with a force on it, or inputs of the model; left out: all coordinates, or all inputs."
    )
    end: EndTable = Field(EndTable.model_construct(), description="The state at T; what is left out is 0.")
    duration: Time = Field(gt=0, description="T, the time between start and end.")
