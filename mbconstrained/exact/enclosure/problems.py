"""From the numeric answer back to its data: what the exact engine is asked."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import flint
import numpy as np

from ...checks import counted
from ...notices import Notice
from ...polynomial.matrix import PolynomialMatrix
from ...response.response import Response
from ...signals.impulsive import ImpulsiveSmooth
from ..rational.arithmetic import polynomial
from ..rational.matrix import RationalMatrix
from ..rational.singular import regular_matrix
from .exact_response import ExactResponse
from .shapes import ONE, S, Shape
from .sources import Source, sources_of


def exact_response(A: PolynomialMatrix, initial: np.ndarray, force: ImpulsiveSmooth) -> ExactResponse:
    """x with A(d/dt) x = f from values at 0- of shape (q, r), the data taken as they are.

    Raises:
        SingularPolynomialMatrix: det A(s) = 0 for every s, exactly.
    """
    return ExactResponse(regular_matrix(A), initial, sources_of(force))


def exact_fraction_response(
    numerator: Sequence[Fraction], denominator: Sequence[Fraction], gamma: int | ImpulsiveSmooth
) -> ExactResponse:
    """y with a(d/dt) y = b(d/dt) u from rest, u = I_gamma or an input with one row; b and a with the lowest power first."""
    b, unit = polynomial(numerator), (flint.fmpq(1),)
    if isinstance(gamma, ImpulsiveSmooth):
        acting = sources_of(gamma)
    else:
        shape = Shape(ONE, S**gamma) if gamma > 0 else Shape(S**-gamma)
        acting = (Source(shape, unit, flint.fmpq(0), flint.fmpq(1)),)
    sources = [Source(Shape(b * one.shape.numerator, one.shape.denominator), one.vector, one.time, one.factor) for one in acting]
    a = RationalMatrix([[[c]] for c in denominator])
    return ExactResponse(a, np.zeros((len(denominator) - 1, 1)), sources)


def structure_notices(x: Response, exact: ExactResponse) -> tuple[Notice, ...]:
    """Where the numeric answer took for rounding what the data, taken exactly, are: it is another motion."""
    taken, found = x.pairs.structure.finite_count, exact.matrix.determinant.degree()
    if taken == found:
        return ()
    text = (
        f"taken exactly, the data have {counted(found, 'finite zero')} where the answer has {taken}: it takes differences of the size of "
        "rounding for zero; the bounds belong to the exact data, which move in another way"
    )
    return (Notice("rank", text, doubtful=True),)
