"""A mass, damping or stiffness matrix as the sum of its elements, which keep their digits next to stiffer ones."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..ground.checks import counted, real_array
from ..ground.errors import InputError
from ..polynomial.polynomial_matrix import Factors


class ElementMatrix:
    """B^T diag(k) B: one row of B and one constant for each spring, damper or mass of a system with n coordinates.

    ``MechanicalSystem`` takes it in the place of a matrix. Assembled in float64, a spring of 1 N/m that hangs on one of 1e16
    N/m is lost (1e16 + 1 = 1e16); as elements both keep all their digits, and so do the motions.

    Args:
        directions: B, shape (m, n): the elongation of element i is B[i] @ x; entries 0, 1, -1 and lever or gear ratios.
        constants: k, shape (m,): N/m, N s/m or kg (N m/rad, N m s/rad, kg m^2).

    Raises:
        InputError: shapes that do not fit, entries that are not finite.

    >>> springs = ElementMatrix([[1, 0], [-1, 1]], [2.0, 3.0])
    >>> springs.matrix
    array([[ 5., -3.],
           [-3.,  3.]])
    """

    def __init__(self, directions, constants):
        self.constants = real_array(constants, "constants", shape=(None,))
        self.directions = real_array(directions, "directions", shape=(len(self.constants), None))

    def __repr__(self) -> str:
        return f"ElementMatrix({counted(self.size, 'coordinate')}, {counted(len(self.constants), 'element')})"

    @property
    def size(self) -> int:
        """The number n of coordinates."""
        return self.directions.shape[1]

    @cached_property
    def matrix(self) -> np.ndarray:
        """The nearest float64 matrix, exactly symmetric, shape (n, n).

        Raises:
            InputError: an entry is beyond the range of float64.
        """
        try:
            return Factors(self.directions.T, self.constants, self.directions).matrix
        except OverflowError:
            raise InputError(
                "elements: B^T diag(k) B has an entry beyond the range of float64; expected directions near 1 and constants "
                "in units in which they are of ordinary size"
            ) from None

    @cached_property
    def spread(self) -> float:
        """The largest of the constants over the smallest, those that are zero left out; at most the largest float64."""
        size = np.abs(self.constants[self.constants != 0])
        if not len(size):
            return 1.0
        with np.errstate(over="ignore"):
            return float(min(size.max() / size.min(), np.finfo(float).max))
