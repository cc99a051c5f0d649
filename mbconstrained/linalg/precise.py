"""Arrays of numbers with more digits than float64, for data that spans so many orders of magnitude that 16 are too few.

Such an array has entries of the standard library's ``Decimal`` and dtype object; sums, products and indexing are
NumPy's own. The functions here let one algorithm serve both kinds: which kind an array is decides what is done.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np

from ..tolerances import EPS

#: A stiffness ratio of 1e16 takes 16 digits of the slowest motion away, its elimination and the couplings between
#: fast and slow motions about as many again; this leaves more than float64 holds.
DIGITS = 70

#: Relative rounding noise of one operation.
PRECISE_EPS = 10.0 ** (2 - DIGITS)

#: Zeros are decoupled to this in precise arithmetic, far below float64, so that what is dropped of fast motions is nothing
#: beside slow ones; bases and inverses are right to as much.
DECOUPLED = 1e-30

#: Losing so many digits in float64 is not worth precise arithmetic, and one more for so many states: it takes a tenth of a
#: second for 20 states, seconds for 60, half a minute for the most.
DIGITS_TO_LOSE, STATES_A_DIGIT, MOST_STATES = 2, 12, 120


@contextmanager
def precise_arithmetic() -> Iterator[None]:
    """Within it operations on precise arrays keep ``DIGITS`` digits."""
    with localcontext() as context:
        context.prec = DIGITS
        yield


def is_worthwhile(loss: float, states: int) -> bool:
    """Whether errors ``loss`` times larger than a rounding are worth the time that precise arithmetic takes for so many states.

    >>> is_worthwhile(1e6, 30), is_worthwhile(1e6, 100), is_worthwhile(10.0, 2)
    (True, False, False)
    """
    digits = max(DIGITS_TO_LOSE, states / STATES_A_DIGIT)
    return states <= MOST_STATES and loss > 10.0**digits


def is_precise(array: np.ndarray) -> bool:
    """True for an array of Decimals."""
    return array.dtype.kind == "O"


def precise(array: np.ndarray) -> np.ndarray:
    """The same numbers as Decimals; floats exactly, fractions to all digits of the arithmetic in force.

    >>> precise(np.array([0.5, 3.0])) / 3
    array([Decimal('0.1666666666666666666666666667'), Decimal('1')],
          dtype=object)
    """
    found = np.empty(np.shape(array), dtype=object)
    found.flat = [_decimal(value) for value in np.asarray(array).flat]
    return found


def of_kind(array: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The array as precise as the other one."""
    return precise(array) if is_precise(other) and not is_precise(array) else array


def rounded_to_float(array: np.ndarray) -> np.ndarray:
    """The nearest float64 numbers."""
    return array.astype(float)


def magnitude(array: np.ndarray) -> np.ndarray:
    """Absolute values in float64."""
    return np.abs(floats(array))


def floats(array: np.ndarray) -> np.ndarray:
    """The nearest float64 numbers, the array itself where it has them."""
    return array if array.dtype.kind == "f" else array.astype(float)


def squared(array: np.ndarray) -> np.ndarray:
    """Squares in float64."""
    return floats(array) ** 2


def unit(array: np.ndarray) -> float:
    """Relative rounding noise of one operation on such an array."""
    return PRECISE_EPS if is_precise(array) else EPS


def power_of_two(exponents):
    """2^exponents for a whole exponent or an array of them, precise."""
    if np.ndim(exponents) == 0:
        return Decimal(2) ** int(exponents)
    found = np.empty(np.shape(exponents), dtype=object)
    found.flat = [power_of_two(exponent) for exponent in np.asarray(exponents).flat]
    return found


def solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """matrix^-1 @ right for a regular square matrix; precise ones by Gauss's elimination with row pivoting.

    Raises:
        numpy.linalg.LinAlgError: the matrix is singular.
    """
    if not is_precise(matrix):
        return np.linalg.solve(matrix, right)
    size = len(matrix)
    work = np.hstack([matrix, of_kind(right, matrix)])
    for at in range(size):
        row = at + int(magnitude(work[at:, at]).argmax())
        if not work[row, at]:
            raise np.linalg.LinAlgError("singular matrix")
        work[[at, row]] = work[[row, at]]
        work[at, at:] = work[at, at:] / work[at, at]
        others = np.flatnonzero(work[:, at])
        others = others[others != at]
        work[others, at:] = work[others, at:] - np.multiply.outer(work[others, at], work[at, at:])
    return work[:, size:]


def inverse(matrix: np.ndarray) -> np.ndarray:
    """matrix^-1, as ``solved``."""
    return np.linalg.inv(matrix) if not is_precise(matrix) else solved(matrix, precise(np.eye(len(matrix))))


def _decimal(value) -> Decimal:
    if isinstance(value, Decimal):
        return value
    if isinstance(value, Fraction):
        return Decimal(value.numerator) / Decimal(value.denominator)
    return Decimal(float(value))
