"""The tables of models of kinds "lumped", "matrices", "transfer-function" and "state-space", of their forces and prescribed motions."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import MISSING
from functools import cache, partial
from typing import Annotated, Any, ClassVar, Literal, get_args, get_origin

import numpy as np
from pydantic import BeforeValidator, Field, PrivateAttr, WithJsonSchema, create_model, model_validator

from ...ground.errors import InputError, shown
from ...ground.quantities import measured
from ...mechanics.constraints import Level
from ...models.elements import Element, Entry, Joins, Numeric, entries_of
from ...models.lumped import ELEMENTS
from ...models.rotor import PlaneValues
from .entry_types import (
    NUMBER_SCHEMA,
    SPEED,
    Acceleration,
    Angle,
    AngularVelocity,
    DampedTable,
    Eccentric,
    Frequency,
    LateTable,
    Name,
    Number,
    Pair,
    Quantity,
    Rate,
    Table,
    TablesByKind,
    Teeth,
    Text,
    Time,
    Unit,
    in_planes,
    quantity_field,
)

MOST_POWER = 20


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

    @model_validator(mode="after")
    def _of_something(self):
        if (self.coordinate is None) == (not self.factors):
            raise InputError("give either coordinate or factors: what does the force act on?")
        if self.name is not None and not self.factors:
            raise InputError("name is that of a load by factors; a force on one coordinate has the name of the coordinate")
        return self

    @property
    def places(self) -> dict[str, float]:
        """Factors of the signal by the name of the coordinate or input."""
        return {self.coordinate: 1.0} if self.coordinate is not None else {key: float(one) for key, one in self.factors.items()}

    @property
    def title(self) -> str:
        """Name of the force as an input."""
        return self.coordinate or self.name or f"load on {', '.join(self.places)}"

    @model_validator(mode="after")
    def _not_earlier(self):
        if self.delay < 0:
            raise InputError(f"delay: found {self.delay:g} s; expected 0 or a later time")
        return self

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

    @model_validator(mode="after")
    def _one_frequency(self):
        if self.angular_frequency is not None and self.frequency is not None:
            raise InputError("give either angular_frequency (rad/s) or frequency (Hz), not both")
        return self

    @property
    def omega(self) -> float:
        """The angular frequency in rad/s."""
        return self.angular_frequency or 2 * math.pi * (self.frequency or 0.0)


class HarmonicTable(PeriodicTable):
    """value cos(w t + phase)."""

    kind: Literal["harmonic"] = Field(description="A cosine from t = 0 on.")

    @model_validator(mode="after")
    def _has_frequency(self):
        if self.angular_frequency is None and self.frequency is None:
            raise InputError('give angular_frequency, e.g. "12 rad/s", or frequency, e.g. "2 Hz"')
        return self


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


Column = Annotated[int, Field(ge=1)] | Text


class SampledTable(ForceBase):
    """A record: linear between its samples, zero before the first and after the last."""

    kind: Literal["sampled"] = Field(description="A record of times and values, in the scene or in a file.")
    times: list[Time] | None = Field(None, description="Times of the samples, ascending; one that stands there twice is a jump.")
    values: list[Quantity] | None = Field(None, description="The force at each of the times.")
    file: Text | None = Field(
        None,
        description="Instead of both a file in the folder of the scene: text with columns of numbers (.csv, .txt, ...), PEER .AT2, "
        "K-NET, ESM, .wav, .uff, or arrays in .npy, .npz, .mat, .mtx, .op4.",
    )
    column: Column | None = Field(None, description="The column of the values, by number or by name in the header; 2 by default.")
    time: Column | None = Field(None, description="The column of the times, by number or name; 1 by default.")
    step: Time | None = Field(None, description="The time between samples of a file without times; every number is a sample then.")
    unit: Unit | None = Field(None, description='Of the values, e.g. "kN"; by default the one in the header, or SI.')
    time_unit: Unit | None = Field(None, description='Of the times, e.g. "ms"; by default the one in the header, or s.')
    factor: Quantity = Field(1.0, description='The values are multiplied by it: a number, or with a unit, e.g. "-1200 kg".')
    offset: Quantity = Field(0.0, description="Is added to the values, after the factor; a force.")
    header: int = Field(0, ge=0, description="So many lines at the start of a text hold no numbers; words are found without it.")
    array: Text | None = Field(None, description="The name of the array in an .npz, .mat or .op4 file.")

    @model_validator(mode="after")
    def _one_source(self):
        if self.file is None and (self.times is None or self.values is None):
            raise InputError('give times and values, or file, e.g. file = "record.csv"')
        if self.file is not None and (self.times is not None or self.values is not None):
            raise InputError("give either times and values or file, not both")
        of_file = ("column", "time", "step", "unit", "time_unit", "factor", "offset", "header", "array")
        if self.file is None and (given := [key for key in of_file if key in self.model_fields_set]):
            raise InputError(f"{', '.join(given)}: for a file only; leave out what is not for times and values")
        if self.file is None and len(self.times) != len(self.values):
            raise InputError(f"found {len(self.times)} times and {len(self.values)} values; expected as many of both")
        return self


class MotionBase(Table):
    """Keys of every prescribed motion, in addition to those of a force of its kind."""

    coordinate: Name | None = Field(None, description="The coordinate, joint or point whose motion is prescribed.")
    factors: dict[Name, Number] | None = Field(
        None, description="Instead of coordinate: several that move by multiples of one signal, e.g. { left = 1, right = 0.5 }."
    )
    level: Level = Field("position", description="Level of the value: displacement, velocity or acceleration.")
    name: Name | None = Field(None, description='Of the constraint row; left out: "motion of" and the coordinate.')

    @model_validator(mode="after")
    def _of_something(self):
        if (self.coordinate is None) == (not self.factors):
            raise InputError("give either coordinate or factors: what is it whose motion is prescribed?")
        return self

    @property
    def rows(self) -> dict[str, tuple[str, float]]:
        """Coordinate and factor of the signal by the name of the constraint row."""
        if self.coordinate is not None:
            return {self.name or f"motion of {self.coordinate}": (self.coordinate, 1.0)}
        base = self.name or "motion"
        return {f"{base} of {coordinate}": (coordinate, factor) for coordinate, factor in (self.factors or {}).items()}


_FORCES = (StepTable, RampTable, PowerTable, ImpulseTable, HarmonicTable, TermTable, PulseTable, SampledTable)
FORCES: dict[str, type[ForceBase]] = {get_args(table.model_fields["kind"].annotation)[0]: table for table in _FORCES}


@cache
def _motion_table(kind: str) -> Any:
    return create_model(
        f"{kind.capitalize()}Motion", __base__=(MotionBase, FORCES[kind]), __doc__=f'A prescribed motion of the kind "{kind}".'
    )


ForceTable = Annotated[Any, TablesByKind(**{kind: partial(FORCES.__getitem__, kind) for kind in FORCES})]
MotionTable = Annotated[Any, TablesByKind(**{kind: partial(_motion_table, kind) for kind in FORCES})]


#: What a table by names is expected to be, by its key.
EXAMPLES = {
    "points": 'points with their distances, e.g. { rear = "-1.5 m", front = "1.2 m" }',
    "coefficients": "coordinates with their factors, e.g. { x1 = 1, q1 = -1 }",
}


class ElementTable(Table):
    """An entry of an element; its keys are the fields of the class, and further spellings of them."""

    element: ClassVar[type[Element]]

    @model_validator(mode="after")
    def _from_spellings(self):
        entries, spellings = entries_of(self.element), self.element.spellings
        for targets in dict.fromkeys(spellings.values()):
            keys = [key for key, own in spellings.items() if own == targets]
            used, given = (
                [key for key in keys if getattr(self, key) is not None],
                [name for name in targets if name in self.model_fields_set],
            )
            if len(used) > 1 or (used and given):
                raise InputError(f"{' and '.join(used + given)} say the same thing; give one of them")
            if not used and any(entries[name].is_required and name not in given for name in targets):
                raise InputError(f"give either {', '.join(keys)}, or {' and '.join(targets)}")
            for key in used:
                value = getattr(self, key)
                for name, one in zip(targets, value if len(targets) > 1 else [value]):
                    object.__setattr__(self, name, one)
        return self

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema, handler):
        """The schema, in which a key may stand for fields that are required."""
        schema = handler.resolve_ref_schema(handler(core_schema))
        entries, spellings = entries_of(cls.element), cls.element.spellings
        for targets in dict.fromkeys(spellings.values()):
            if any(entries[name].is_required for name in targets):
                forms = [[key] for key, own in spellings.items() if own == targets] + [list(targets)]
                schema.setdefault("allOf", []).append({"anyOf": [{"required": form} for form in forms]})
        return schema

    @property
    def given(self) -> dict[str, Any]:
        """The fields of the element; expressions of parameters as such, and texts whose unit depends on the model unchanged."""
        values = {name: getattr(self, name) for name in entries_of(self.element)}
        return {name: value for name, value in values.items() if value is not None}


def _mapping(example: str, value):
    if not isinstance(value, dict) or not value:
        raise InputError(f"found {shown(value)}; expected {example}")
    return value


def _type_of(name: str, entry: Entry) -> Any:
    """The type of a key of a table."""
    about = entry.about
    if isinstance(about, Joins) or name == "name":
        return Name
    if not isinstance(about, Numeric):
        return entry.type
    if entry.type is PlaneValues:
        return in_planes(about.unit)
    one = Teeth if about.range == "whole" else Quantity if about.unit is None else quantity_field(about.unit)
    if get_origin(entry.type) is not Mapping:
        return one if entry.is_number else Annotated[list[one], Field(min_length=2)]  # type: ignore[valid-type]
    numbers = dict[Name, one]  # type: ignore[valid-type]
    return Annotated[numbers, BeforeValidator(partial(_mapping, EXAMPLES[name]))] if entry.is_required else numbers


def _default(entry: Entry, is_replaced: bool) -> Any:
    """The default of a key; required ones that further keys may stand for are left out."""
    if entry.is_required:
        return None if is_replaced else ...
    return {} if entry.field.default is MISSING else None if entry.field.default == "" else entry.field.default


@cache
def table_of(key: str) -> Any:
    """The table of a class of elements."""
    element = ELEMENTS[key]
    entries, spellings = entries_of(element), element.spellings
    replaced = {name for targets in spellings.values() for name in targets}
    keys: dict[str, Any] = {}
    for name, entry in sorted(entries.items(), key=lambda item: item[0] != "name"):
        own, default = _type_of(name, entry), _default(entry, name in replaced)
        keys[name] = (own | None if default is None else own, Field(default, description=getattr(entry.about, "text", entry.about)))
    for spelling, targets in spellings.items():
        own = Teeth if spelling == "teeth" else _type_of(targets[0], entries[targets[0]])
        several = len(targets) > 1
        text = f"{' and '.join(targets)} in one array." if several else f"Another name of {targets[0]}."
        own = Annotated[list[own], Field(min_length=2, max_length=2)] if several else own  # type: ignore[valid-type]
        keys[spelling] = (own | None, Field(None, description=text))
    base = type("_Base", (ElementTable,), {"element": element, "__module__": __name__, "__annotations__": {"element": "ClassVar"}})
    title = "".join(word.title() for word in key.split("_")) + "Table"
    return create_model(title, __base__=base, __doc__=inspect.cleandoc(element.__doc__).split("\n\n")[0], **keys)


class _Lumped(DampedTable):
    """Masses, inertias and massless joints along one axis, and what joins them."""

    kind: Literal["lumped"] = Field(description='"lumped": bodies along one axis, springs, dampers, gears ….')
    gravity: Acceleration | None = Field(None, description="Acceleration of free fall along the axis, negative for downwards.")
    speed: AngularVelocity | None = SPEED
    _order: tuple[str, ...] = PrivateAttr(default=())

    @model_validator(mode="wrap")
    @classmethod
    def _keep_order(cls, data, handler):
        """Coordinates are numbered in the order of the file, which the fields above lose."""
        table = handler(data)
        table._order = tuple(key for key in data if key in cls.model_fields)
        return table

    @property
    def elements(self) -> list[tuple[str, int, ElementTable]]:
        """(key, number, table) of all elements: bodies first, otherwise in the order of the file."""
        keys = sorted((key for key in self._order if key in ELEMENTS), key=lambda key: not ELEMENTS[key].has_coordinates)
        return [(key, number, table) for key in keys for number, table in enumerate(getattr(self, key), 1)]


@cache
def lumped_table() -> Any:
    """The table of lumped models, with a list of each class of elements."""
    lists: dict[str, Any] = {
        key: (list[table_of(key)], Field([], description=f"{element.kind.capitalize()}s.")) for key, element in ELEMENTS.items()
    }
    return create_model("LumpedTable", __base__=_Lumped, __doc__=_Lumped.__doc__, **lists)


ConstraintTable = Annotated[Any, LateTable(partial(table_of, "constraint"))]


#: Keys that belong to mass, damping and stiffness.
WITHOUT_COEFFICIENTS = (
    "damping", "stiffness", "gyroscopic", "circulatory", "speed", "unbalance", "constraint", "rayleigh_damping", "modal_damping",
)  # fmt: skip

Coefficients = Annotated[list[Number], Field(min_length=1, max_length=200)]


class TransferFunctionTable(Table):
    """a(d/dt) y = b(d/dt) u, Y(s)/U(s) = b(s)/a(s)."""

    kind: Literal["transfer-function"] = Field(description='"transfer-function": one input, one output, two polynomials in s.')
    numerator: Coefficients = Field(description="b, the coefficient of the highest power of s first.")
    denominator: Coefficients = Field(description="a, the coefficient of the highest power of s first.")
    gamma: int | None = Field(
        None,
        ge=-MOST_POWER,
        le=MOST_POWER,
        description="The input I_gamma: 1 a step, 2 a ramp, 0 an impulse; [[force]] tables add.",
    )
    input: Name = Field("u", description="The name of the input, on which [[force]] tables act.")
    output: Name = Field("y", description="The name of the output.")
    units: dict[Name, Unit] = Field({}, description='Units of both, e.g. { u = "V", y = "rad" }; "1" when left out.')

    @model_validator(mode="after")
    def _two_names(self):
        if self.input == self.output:
            raise InputError(f'input and output have the same name, "{self.input}"; names must differ')
        return self


class StateSpaceTable(Table):
    """E x' = A x + B u, y = C x + D u."""

    kind: Literal["state-space"] = Field(description='"state-space": A, B, C, D, and E where the system is a descriptor system.')
    A: Matrix = Field(description="n rows and columns.")
    B: Matrix = Field(None, description="n rows, a column for each input; no inputs when left out.")
    C: Matrix = Field(None, description="A row for each output, n columns; no outputs when left out.")
    D: Matrix = Field(None, description="A row for each output, a column for each input; zero when left out.")
    descriptor: Matrix = Field(None, description="E, n rows and columns, singular or not; the identity when left out.")
    states: list[Name] | None = Field(None, description="The names of the states; x1, x2, … when left out.")
    inputs: list[Name] | None = Field(None, description="The names of the inputs, where [[force]] tables act; u1, …")
    outputs: list[Name] | None = Field(None, description="The names of the outputs; y1, y2, … when left out.")
    units: dict[Name, Unit] = Field({}, description='Units of states, inputs, outputs, e.g. { y1 = "m" }; "1" when left out.')
    normal_form: bool = Field(
        False,
        description="true: transformed first to the mechanical normal form q'' + C q' + K q = B u with displacements q; of a singular descriptor "
        "with massless coordinates z1, z2, … for the states that follow the inputs at once.",
    )
    coordinates: list[Name] | None = Field(None, description="The names of the displacements of the normal form; q1, q2, …")

    @model_validator(mode="after")
    def _coordinates_of_what(self):
        if self.coordinates is not None and not self.normal_form:
            raise InputError("coordinates are the displacements of the normal form; name states, or give normal_form = true")
        return self


CoordinateUnit = Literal["m", "rad", "N", "N*m", "1"]


class MatrixFile(Table):
    """A matrix in a file next to the scene."""

    file: Text = Field(
        description="A .npy, .npz, .mtx, .mat, .op4, .csv or .txt file in the folder of the scene, or in one inside it."
    )
    array: Text | None = Field(None, description="The name of the matrix in an .npz, .mat or .op4 file.")


def _matrix(value):
    if isinstance(value, str):
        return MatrixFile(file=value)
    if isinstance(value, dict):
        return MatrixFile.model_validate(value)
    return _numbers(value)


def _numbers(value) -> np.ndarray:
    """The entries unchanged: floats in SI, expressions of parameters or texts with units."""
    if not isinstance(value, list) or not value or not all(isinstance(row, list) for row in value):
        raise InputError(f"found {shown(value)}; expected rows of numbers, e.g. [[1, 0], [0, 1]], or the name of a file")
    lengths = {len(row) for row in value}
    if len(lengths) != 1:
        counts = ", ".join(str(len(row)) for row in value[:6])
        raise InputError(f"found rows of {counts} numbers; expected rows of equal length")
    matrix = np.empty((len(value), len(value[0])), dtype=object)
    for place in np.ndindex(matrix.shape):
        matrix[place] = measured(value[place[0]][place[1]])
    return matrix


Matrix = Annotated[
    Any,
    BeforeValidator(_matrix),
    WithJsonSchema(
        {
            "title": 'rows of numbers in SI, texts with units or expressions of parameters such as "=2*k", or a file',
            "anyOf": [
                {"type": "array", "items": {"type": "array", "items": NUMBER_SCHEMA}},
                {"type": "string"},
                MatrixFile.model_json_schema(),
            ],
        }
    ),
]


class MatrixUnbalanceTable(Table):
    """An eccentric mass: the force moment W^2, which turns with the shaft."""

    coordinates: Pair = Field(
        description='The displacements in two planes, the shaft turning from the first to the second, e.g. ["y", "z"].'
    )
    moment: Eccentric = Field(description='Mass times eccentricity, e.g. "20 g*mm".')
    angle: Angle = Field(0.0, description="From the first towards the second plane at t = 0.")


class MatricesTable(DampedTable):
    """M x'' + C x' + K x = f with constraint rows, or A_0 x + A_1 x' + … + A_q x^(q) = f of any degree."""

    kind: Literal["matrices"] = Field(description='"matrices": the equations themselves.')
    coordinates: list[Name] | None = Field(None, description="The names of the coordinates; x1, x2, … when left out.")
    units: dict[Name, CoordinateUnit] = Field(
        {}, description='Coordinates that are not in m, e.g. { theta = "rad", lambda = "N" }.'
    )
    mass: Matrix = Field(None, description="M, in kg (kg m² for angles); may be singular.")
    damping: Matrix = Field(None, description="C, in N s/m.")
    stiffness: Matrix = Field(None, description="K, in N/m.")
    gyroscopic: Matrix = Field(None, description="G of a rotor, in kg m²: its damping matrix is C + speed G.")
    circulatory: Matrix = Field(None, description="N of a rotor, in N s/m: its stiffness matrix is K + speed N.")
    speed: AngularVelocity | None = SPEED
    unbalance: list[MatrixUnbalanceTable] = Field([], description="Eccentric masses of a rotor.")
    constraint: list[ConstraintTable] = Field([], description="Constraint rows.")
    coefficients: list[Matrix] | None = Field(None, description="[A_0, A_1, …, A_q] instead of mass, damping and stiffness.")

    @model_validator(mode="after")
    def _one_form(self):
        if (self.mass is None) == (self.coefficients is None):
            raise InputError("give either mass (with damping and stiffness) or coefficients = [A_0, A_1, …]")
        if self.coefficients is None:
            return self
        if given := [key for key in WITHOUT_COEFFICIENTS if key in self.model_fields_set]:
            raise InputError(f"{given[0]} cannot stand with coefficients; write it into A_0, A_1, … or give mass instead")
        if not self.coefficients:
            raise InputError("coefficients is empty; expected [A_0, A_1, …] in ascending powers")
        return self
