"""The tables of a model of kind "matrices": numbers in the scene file or in a file beside it."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from ..errors import InputError
from .fields import EXPRESSION_SCHEMA, Name, Table, Text
from .lumped_tables import ConstraintTable
from .units import quantity, shown

Unit = Literal["m", "rad", "N", "N*m", "1"]


class MatrixFile(Table):
    """A matrix kept in a file beside the scene."""

    file: Text = Field(description="A .npz, .mtx or .csv file in the folder of the scene, or in one inside it.")
    array: Text | None = Field(None, description="The name of the array in an .npz file.")


def _matrix(value):
    if isinstance(value, str):
        return MatrixFile(file=value)
    if isinstance(value, dict):
        return MatrixFile.model_validate(value)
    return _numbers(value)


def _numbers(value) -> np.ndarray:
    """The entries as they are: floats, some of them perhaps expressions of parameters."""
    if not isinstance(value, list) or not value or not all(isinstance(row, list) for row in value):
        raise InputError(f"found {shown(value)}; expected rows of numbers, e.g. [[1, 0], [0, 1]], or the name of a file")
    lengths = {len(row) for row in value}
    if len(lengths) != 1:
        found = ", ".join(str(len(row)) for row in value[:6])
        raise InputError(f"found rows of {found} numbers; expected rows of equal length")
    found = np.empty((len(value), len(value[0])), dtype=object)
    for place in np.ndindex(found.shape):
        found[place] = quantity(value[place[0]][place[1]], "1")
    return found


Matrix = Annotated[
    Any,
    BeforeValidator(_matrix),
    WithJsonSchema(
        {
            "title": 'rows of numbers in SI or expressions of parameters such as "=2*k", or a file',
            "anyOf": [
                {"type": "array", "items": {"type": "array", "items": {"anyOf": [{"type": "number"}, EXPRESSION_SCHEMA]}}},
                {"type": "string"},
                MatrixFile.model_json_schema(),
            ],
        }
    ),
]


class MatricesTable(Table):
    """M x'' + C x' + K x = f with constraint rows, or A_0 x + A_1 x' + … + A_q x^(q) = f of any degree."""

    kind: Literal["matrices"] = Field(description='"matrices": the equations themselves.')
    coordinates: list[Name] | None = Field(None, description="The names of the coordinates; x1, x2, … when left out.")
    units: dict[Name, Unit] = Field({}, description='Coordinates that are not in m, e.g. { theta = "rad", lambda = "N" }.')
    mass: Matrix = Field(None, description="M, in kg (kg m² for angles); may be singular.")
    damping: Matrix = Field(None, description="C, in N s/m.")
    stiffness: Matrix = Field(None, description="K, in N/m.")
    constraint: list[ConstraintTable] = Field([], description="Constraint rows.")
    coefficients: list[Matrix] | None = Field(None, description="[A_0, A_1, …, A_q] instead of mass, damping and stiffness.")

    @model_validator(mode="after")
    def _one_form(self):
        if (self.mass is None) == (self.coefficients is None):
            raise InputError("give either mass (with damping and stiffness) or coefficients = [A_0, A_1, …]")
        if self.coefficients is not None:
            self._refuse_beside_coefficients()
        return self

    def _refuse_beside_coefficients(self) -> None:
        for key in ("damping", "stiffness", "constraint"):
            if key in self.model_fields_set:
                raise InputError(f"{key} cannot stand beside coefficients; write it into A_0, A_1, … or give mass instead")
        if not self.coefficients:
            raise InputError("coefficients is empty; expected [A_0, A_1, …] in ascending powers")
