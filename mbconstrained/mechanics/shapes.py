"""Mode shapes: the null vectors of A(s) at its zeros."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from ..jordan.pairs import FinitePair
from ..linalg.blocks import block_slices
from ..linalg.noise import Noisy
from ..linalg.precise import precise_arithmetic, rounded_to_float
from ..linalg.rank import null_columns
from ..polynomial.companion import known_coefficient
from ..polynomial.matrix import PolynomialMatrix
from ..polynomial.structure import FiniteZero
from ..tolerances import NOISE_SAFETY


def mode_shapes(pair: FinitePair, zero: FiniteZero) -> np.ndarray:
    """The null space of A(zero), one shape a column, shape (r, g), one for each chain of the zero; real where possible.

    A(s) C (s I - J)^-1 B = I, so that A(s) C v = 0 where J v = s v: the shapes are C v with the eigenvectors v of those
    blocks of J that belong to the zero. A(s) itself is never formed: beside stiff parts it has lost the soft ones.
    """
    columns = block_slices(pair.blocks)
    owner = np.repeat(np.arange(len(pair.blocks)), [len(block) for block in pair.blocks])
    values = np.concatenate([np.linalg.eigvals(block) for block in pair.blocks])
    nearest = np.argsort(np.abs(values - zero.value), kind="stable")[: zero.multiplicity]
    chosen = sorted(set(owner[nearest]))
    J = scipy.linalg.block_diag(*(pair.blocks[i] for i in chosen))
    C = np.hstack([pair.C[:, columns[i]] for i in chosen])
    place = zero.value if zero.value.imag else zero.value.real
    vectors = scipy.linalg.svd(J - place * np.eye(len(J)))[2].conj().T
    return _normalized(C @ vectors[:, len(J) - len(zero.partial_multiplicities) :])


def rest_shapes(A: PolynomialMatrix) -> tuple[np.ndarray, np.ndarray]:
    """The null space of A(0), where no force acts, as rigid body shapes and offset shapes, one a column.

    A shape u can also move on at constant velocity, and so begins a chain of the zero at 0, where A_1 u is balanced
    by some displacement: where w^T A_1 u = 0 for every w with w^T A_0 = 0. The others are offsets.
    """
    with precise_arithmetic():
        A_0, A_1 = known_coefficient(A, 0), known_coefficient(A, 1)
        right, left = _null_space(A_0), _null_space(A_0.T)
        moving = _null_space(left.T @ A_1 @ right)
        staying = _null_space(moving.T)
        return tuple(_normalized(rounded_to_float((right @ shapes).data)) for shapes in (moving, staying))


def _null_space(matrix: Noisy) -> Noisy:
    return null_columns(matrix).null.T


def _normalized(shapes: np.ndarray) -> np.ndarray:
    """Each column divided by its largest entry; real where nothing but rounding is imaginary."""
    largest = np.abs(shapes).argmax(axis=0)
    shapes = shapes / shapes[largest, range(shapes.shape[1])]
    return np.real_if_close(shapes, tol=NOISE_SAFETY * len(shapes) ** 0.5)
