"""The tables of models of kinds "matrices", "transfer-function" and "state-space"."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, GetPydanticSchema

from ...ground.errors import InputError, shown
from ...ground.quantities import Expressed, any_quantity
from .entry_types import (
    LINEAR_PHASE,
    MOST_POWER,
    NUMBER_SCHEMA,
    SPEED,
    Angle,
    AngularVelocity,
    DampedTable,
    Eccentric,
    LateTable,
    LinearPhase,
    Name,
    Number,
    Pair,
    Quantity,
    Table,
    Text,
    Time,
    Unit,
)

ConstraintTable = Annotated[Any, LateTable("ConstraintTable", ".element_tables")]


#: Keys that belong to mass, damping and stiffness.
WITHOUT_COEFFICIENTS = (
    "damping", "stiffness", "gyroscopic", "circulatory", "speed", "unbalance", "constraint", "rayleigh_damping", "modal_damping",
    "phase", "transition", "start", "linear_phase",
)  # fmt: skip

Delay = Annotated[Time, Field(ge=0)]

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
    delay: Time = Field(0.0, ge=0, description='Dead time of the input, a factor e^(-delay s), e.g. "0.1 s".')
    input: Name = Field("u", description="The name of the input, on which [[force]] tables act.")
    output: Name = Field("y", description="The name of the output.")
    units: dict[Name, Unit] = Field({}, description='Units of both, e.g. { u = "V", y = "rad" }; "1" when left out.')

    def _check(self) -> None:
        if self.input == self.output:
            raise InputError(f'input and output have the same name, "{self.input}"; names must differ')


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
    delays: dict[Name, Delay] = Field({}, description='Dead times of inputs, e.g. { u1 = "0.1 s" }; none when left out.')
    units: dict[Name, Unit] = Field({}, description='Units of states, inputs, outputs, e.g. { y1 = "m" }; "1" when left out.')
    normal_form: bool = Field(
        False,
        description="true: transformed first to the mechanical normal form q'' + C q' + K q = B u with displacements q; of a singular descriptor "
        "with massless coordinates z1, z2, … for the states that follow the inputs at once.",
    )
    coordinates: list[Name] | None = Field(None, description="The names of the displacements of the normal form; q1, q2, …")

    def _check(self) -> None:
        if self.coordinates is not None and not self.normal_form:
            raise InputError("coordinates are the displacements of the normal form; name states, or give normal_form = true")


CoordinateUnit = Literal["m", "rad", "N", "N*m", "C", "A", "V", "1"]


class MatrixFile(Table):
    """A matrix in a file next to the scene."""

    file: Text = Field(
        description="A .npy, .npz, .mtx, .mat, .op4, .csv or .txt file in the folder of the scene, or in one inside it."
    )
    array: Text | None = Field(None, description="The name of the matrix in an .npz, .mat or .op4 file.")


def _matrix(value) -> MatrixFile | np.ndarray:
    """A file, or the entries unchanged: floats in SI, expressions of parameters or texts with units."""
    if isinstance(value, str):
        return MatrixFile(file=value)
    if isinstance(value, dict):
        return MatrixFile.model_validate(value)
    if not isinstance(value, list) or not value or not all(isinstance(row, list) for row in value):
        raise InputError(f"found {shown(value)}; expected rows of numbers, e.g. [[1, 0], [0, 1]], or the name of a file")
    lengths = {len(row) for row in value}
    if len(lengths) != 1:
        counts = ", ".join(str(len(row)) for row in value[:6])
        raise InputError(f"found rows of {counts} numbers; expected rows of equal length")
    matrix = np.empty((len(value), len(value[0])), dtype=object)
    for place in np.ndindex(matrix.shape):
        entry = value[place[0]][place[1]]
        number, kind = any_quantity(entry)
        matrix[place] = Expressed(number, entry, None, kind) if isinstance(entry, str) else number
    return matrix


def _matrix_schema(schema, handler) -> dict:
    """The JSON Schema of a matrix, which takes time that no scene needs."""
    title = 'rows of numbers in SI, texts with units or expressions of parameters such as "=2*k", or a file'
    rows = {"type": "array", "items": {"type": "array", "items": NUMBER_SCHEMA}}
    return {"title": title, "anyOf": [rows, {"type": "string"}, MatrixFile.model_json_schema()]}


Matrix = Annotated[Any, BeforeValidator(_matrix), GetPydanticSchema(get_pydantic_json_schema=_matrix_schema)]


class MatrixUnbalanceTable(Table):
    """An eccentric mass: the force moment W^2, which turns with the shaft."""

    coordinates: Pair = Field(
        description='The displacements in two planes, the shaft turning from the first to the second, e.g. ["y", "z"].'
    )
    moment: Eccentric = Field(description='Mass times eccentricity, e.g. "20 g*mm".')
    angle: Angle = Field(0.0, description="From the first towards the second plane at t = 0.")


class PhaseTable(Table):
    """One phase of equations that change: what differs from the common ones below [model]."""

    name: Name = Field(description="The name that transitions, events and linear_phase refer to.")
    mass: Matrix = Field(None, description="M in this phase, in the place of the common one.")
    damping: Matrix = Field(None, description="C in this phase, in the place of the common one.")
    stiffness: Matrix = Field(None, description="K in this phase, in the place of the common one.")
    constraint: list[ConstraintTable] = Field([], description="Constraint rows of this phase, in addition to the common ones.")


class TransitionTable(Table):
    """The end of a phase and the one that follows, where a linear output passes a limit, or at a time."""

    source: Name = Field(alias="from", description="The phase that ends.")
    target: Name = Field(alias="to", description="The phase that follows.")
    when: dict[Name, Number] | None = Field(
        None, description="Factors by coordinate, or by constraint row for reactions: the output, e.g. { x1 = 1, x2 = -1 }."
    )
    above: Quantity | None = Field(None, description="The limit that the output rises above.")
    below: Quantity | None = Field(None, description="Or the one that it falls below.")
    at: Time | None = Field(None, gt=0, description="Or a time, in the place of when.")
    quantity: Literal["displacement", "velocity", "reaction"] | None = Field(
        None, description="Of the output; left out: reaction where the names are those of constraint rows, else displacement."
    )
    restitution: Number = Field(
        0.0, ge=0, le=1, description="Of an impact: the velocity of the output is reversed, and the phase goes on, until it rests."
    )
    dwell: Time = Field(0.0, ge=0, description="How long the limit must be exceeded.")


class MatricesTable(DampedTable):
    """M x'' + C x' + K x = f with constraint rows, or A_0 x + A_1 x' + … + A_q x^(q) = f of any degree."""

    kind: Literal["matrices"] = Field(description='"matrices": the equations themselves.')
    coordinates: list[Name] | None = Field(None, description="The names of the coordinates; x1, x2, … when left out.")
    units: dict[Name, CoordinateUnit] = Field(
        {},
        description='Coordinates that are not in m, e.g. { theta = "rad", lambda = "N", charge = "C" }. Loads on a charge (C) or a current '
        "(A) are voltages, those on a voltage (V) currents.",
    )
    mass: Matrix = Field(None, description="M, in kg (kg m² for angles); may be singular.")
    damping: Matrix = Field(None, description="C, in N s/m.")
    stiffness: Matrix = Field(None, description="K, in N/m.")
    gyroscopic: Matrix = Field(None, description="G of a rotor, in kg m²: its damping matrix is C + speed G.")
    circulatory: Matrix = Field(None, description="N of a rotor, in N s/m: its stiffness matrix is K + speed N.")
    speed: AngularVelocity | None = SPEED
    unbalance: list[MatrixUnbalanceTable] = Field([], description="Eccentric masses of a rotor.")
    constraint: list[ConstraintTable] = Field([], description="Constraint rows.")
    phase: list[PhaseTable] = Field([], description="Phases of equations that change, the first at the start; with transitions.")
    transition: list[TransitionTable] = Field([], description="From phase to phase.")
    start: Name | None = Field(None, description="The phase at the start, where it is not the first.")
    linear_phase: LinearPhase = LINEAR_PHASE
    coefficients: list[Matrix] | None = Field(
        None,
        description="[A_0, A_1, …, A_q] instead of mass, damping and stiffness; with free coordinates, which [[motion]] chooses, or more "
        "equations than coordinates they need not be square.",
    )
    equations: list[Name] | None = Field(
        None, description="Names of the rows of coefficients, to which forces belong; those of the coordinates when left out."
    )

    @classmethod
    def _hint(cls, key: str) -> str:
        from .element_tables import lumped_table

        if key not in lumped_table().model_fields:
            return ""
        return f'; {key} is of kind = "lumped"; equations that change have phases and transitions, [[model.phase]] and [[model.transition]]'

    def _check(self) -> None:
        if (self.mass is None) == (self.coefficients is None):
            raise InputError("give either mass (with damping and stiffness) or coefficients = [A_0, A_1, …]")
        if not self.phase and (given := [key for key in ("transition", "start", "linear_phase") if key in self.model_fields_set]):
            raise InputError(f"{given[0]} belongs to equations with phases, [[model.phase]]; leave it out, or name the phases")
        names = [phase.name for phase in self.phase]
        if repeated := next((name for name in names if names.count(name) > 1), None):
            raise InputError(f'phase: the name "{repeated}" is used twice; names must differ')
        if self.coefficients is None:
            if self.equations is not None:
                raise InputError("equations names the rows of coefficients; leave it out")
            return
        if other := next((key for key in WITHOUT_COEFFICIENTS if key in self.model_fields_set), None):
            raise InputError(f"{other} cannot stand with coefficients; write it into A_0, A_1, … or give mass instead")
        if not self.coefficients:
            raise InputError("coefficients is empty; expected [A_0, A_1, …] in ascending powers")
