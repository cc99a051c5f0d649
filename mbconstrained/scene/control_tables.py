"""The tables of models of kinds "transfer-function" and "state-space": what control engineers write."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ..errors import InputError
from .fields import Name, Number, Table, Unit
from .force_tables import MOST_POWER
from .matrices_tables import Matrix

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
    normal_form: bool = Field(False, description="true: made mechanical first, q'' + C q' + K q = B u with displacements q.")
    coordinates: list[Name] | None = Field(None, description="The names of the displacements of the normal form; q1, q2, …")

    @model_validator(mode="after")
    def _coordinates_of_what(self):
        if self.coordinates is not None and not self.normal_form:
            raise InputError("coordinates are the displacements of the normal form; name states, or give normal_form = true")
        return self
