"""Which equations and coordinates make A(s) singular for every s, exactly."""

from __future__ import annotations

from typing import TYPE_CHECKING, NoReturn

from sympy.polys.matrices import DomainMatrix

from ....errors import SingularPolynomialMatrix
from ....polynomial.regularity import singular_sentence
from ..field.fields import field_of

if TYPE_CHECKING:
    from .matrix import SymbolicPolynomialMatrix


def raise_singular(A: SymbolicPolynomialMatrix) -> NoReturn:
    """Say which equations depend on each other and which coordinates are free, from the null spaces over the field.

    Raises:
        SingularPolynomialMatrix: always.
    """
    matrix = A(A.variable)
    rows = DomainMatrix.from_list_sympy(A.size, A.size, matrix.tolist()).convert_to(field_of([*matrix, A.variable]))
    equations, coordinates = _involved(rows.transpose()), _involved(rows)
    text = singular_sentence([A.equations[i] for i in equations], [A.coordinates[i] for i in coordinates])
    raise SingularPolynomialMatrix(text, equations, coordinates)


def _involved(rows: DomainMatrix) -> tuple[int, ...]:
    """The columns that take part in a dependency."""
    null = rows.nullspace().to_Matrix()
    return tuple(j for j in range(null.cols) if any(entry != 0 for entry in null[:, j]))
