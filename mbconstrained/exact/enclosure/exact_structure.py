"""The number of finite zeros of the exact data, where that of a numeric answer differs, and the entry of A(s) on which it depends."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...ground.checks import counted
from ...ground.notices import Notice, NoticeKind
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ..rational.rational_matrix import RationalMatrix

if TYPE_CHECKING:
    from ...response.response import Response
    from .exact_response import ExactResponse

#: In larger matrices no single entry decides, and each costs a determinant.
MOST_ENTRIES = 64


def structure_notices(x: Response, exact: ExactResponse) -> tuple[Notice, ...]:
    """A notice where the number of finite zeros of the exact data differs from that of the numeric answer."""
    numeric_count, exact_count = x.solution.finite_count, exact.matrix.determinant.degree()
    if numeric_count == exact_count:
        return ()
    text = (
        f"the exact data have {counted(exact_count, 'finite zero')} where the answer has {numeric_count}: it treats differences of the "
        "size of rounding errors as zero; the bounds belong to the exact data, whose motion is a different one"
    )
    return (Notice(NoticeKind.RANK, text, doubtful=True),)


def deciding_entry(A: PolynomialMatrix) -> str:
    """The entry of A(s) of which the least relative change makes the highest coefficient of det A(s) vanish.

    det A(s) is of first degree in each entry, so that two determinants give that change exactly.

    >>> deciding_entry(PolynomialMatrix([[[1.0, 0.0], [0.0, 1.0]], [[1.0, 1.0], [1.0, 1.0 + 2**-50]]]))
    'the entry of A_1 in the equation "equation 1" for x1, 1, decides: less by 8.9e-16 of itself it lowers the rank'
    """
    exact = RationalMatrix.of(A)
    places = np.argwhere(A.coefficients).tolist()
    if len(places) > MOST_ENTRIES or not exact.determinant:
        return ""
    highest, given = exact.determinant.degree(), [matrix.tolist() for matrix in A.exact_coefficients]
    changes = {}
    for power, i, j in places:
        entry, doubled = given[power][i][j], [[[*row] for row in matrix] for matrix in given]
        doubled[power][i][j] = 2 * entry
        slope = RationalMatrix(doubled).determinant[highest] - exact.determinant[highest]
        if slope:
            changes[power, i, j] = float(-exact.determinant[highest] / slope)
    if not changes:
        return ""
    (power, i, j), change = min(changes.items(), key=lambda item: abs(item[1]))
    return (
        f'the entry of A_{power} in the equation "{A.equations[i]}" for {A.coordinates[j]}, {A.coefficients[power, i, j]:.17g}, decides: '
        f"{'more' if change > 0 else 'less'} by {abs(change):.2g} of itself it lowers the rank"
    )
