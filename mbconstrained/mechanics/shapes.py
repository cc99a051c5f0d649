"""Mode shapes: the null vectors of A(s) at its zeros."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from ..linalg.noise import Noisy
from ..linalg.rank import null_columns
from ..polynomial.companion import ScaledCompanion
from ..polynomial.matrix import PolynomialMatrix
from ..tolerances import CLUSTER_SAFETY, EPS, NOISE_SAFETY


def mode_shapes(scaled: ScaledCompanion, zero: complex, multiplicity: int) -> np.ndarray:
    """The null space of A(zero), one shape a column, shape (r, g) with 1 <= g <= multiplicity; real where possible.

    It is read off a QR decomposition with column pivoting. A zero of multiplicity m is known to about eps^(1/m);
    as many diagonal entries below that count as zero, and one at least.

    Args:
        scaled: the scaled coefficients of A(s).
        zero: in 1/s.
        multiplicity: m.
    """
    place = zero / scaled.scaling.time
    value = sum(matrix * place**power for power, matrix in enumerate(scaled.coefficients))
    triangle, order = scipy.linalg.qr(value if value.imag.any() else value.real, mode="r", pivoting=True)
    sizes = np.abs(np.diag(triangle))
    limit = (CLUSTER_SAFETY * EPS) ** (1 / multiplicity) * sizes[0]
    count = min(max(int((sizes <= limit).sum()), 1), multiplicity, scaled.size)
    rank = scaled.size - count
    shapes = np.eye(scaled.size, count, -rank, dtype=triangle.dtype)
    if rank:
        shapes[:rank] = -scipy.linalg.solve_triangular(triangle[:rank, :rank], triangle[:rank, rank:])
    return _normalized(scaled.scaling.columns[:, None] * shapes[np.argsort(order)])


def rest_shapes(A: PolynomialMatrix) -> tuple[np.ndarray, np.ndarray]:
    """The null space of A(0), where no force acts, as rigid body shapes and offset shapes, one a column.

    A shape u can also move on at constant velocity, and so begins a chain of the zero at 0, where A_1 u is balanced
    by some displacement: where w^T A_1 u = 0 for every w with w^T A_0 = 0. The others are offsets.
    """
    A_0, A_1 = Noisy.rounded(A.coefficients[0]), Noisy.rounded(A.coefficients[1])
    right, left = _null_space(A_0), _null_space(A_0.T)
    moving = _null_space(left.T @ A_1 @ right)
    staying = _null_space(moving.T)
    return _normalized((right @ moving).data), _normalized((right @ staying).data)


def _null_space(matrix: Noisy) -> Noisy:
    return null_columns(matrix).null.T


def _normalized(shapes: np.ndarray) -> np.ndarray:
    """Each column divided by its largest entry; real where nothing but rounding is imaginary."""
    largest = np.abs(shapes).argmax(axis=0)
    shapes = shapes / shapes[largest, range(shapes.shape[1])]
    return np.real_if_close(shapes, tol=NOISE_SAFETY * len(shapes) ** 0.5)
