"""Some zeros of a precise matrix, with the space that their motion takes place in, in units of their own.

In the units of a faster motion the block of a slow one would have entries much larger than its zeros, and lose as many
digits when it is rounded to float64.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
from scipy.linalg import lapack

from ..tolerances import DECOUPLING_LIMIT
from .precise import inverse, magnitude, power_of_two, precise, rounded_to_float

#: Largest ratio of the couplings of a complex pair: one that is stretched more is nearly a double zero on the real axis.
MOST_STRETCHED = 1e4


@dataclass(frozen=True)
class Part:
    """Some zeros: inverse @ matrix @ basis = block, inverse @ basis = I; all precise."""

    basis: np.ndarray
    inverse: np.ndarray
    block: np.ndarray

    @cached_property
    def zeros(self) -> np.ndarray:
        """The eigenvalues of the block."""
        return np.linalg.eigvals(rounded_to_float(self.block))

    @cached_property
    def projector(self) -> np.ndarray:
        """basis @ inverse in float64."""
        return rounded_to_float(self.basis @ self.inverse)

    @cached_property
    def units(self) -> np.ndarray:
        """Powers of two for the coordinates in which the part of the matrix that belongs to it is balanced."""
        motion = magnitude((self.basis @ self.block) @ self.inverse)
        return 2.0 ** balancing_exponents(np.abs(self.zeros).max() * np.abs(self.projector) + motion)

    @cached_property
    def coupling(self) -> float:
        """Norm of the projector in these units, by the root of its rank: 1 for orthogonal motions."""
        return float(np.linalg.norm(self.projector * self.units / self.units[:, None])) / len(self.block) ** 0.5


def in_schur_form(part: Part) -> Part:
    """The part in a basis of norm one in which its block is a float64 real Schur form."""
    part = _in_own_units(part)
    T, turn = scipy.linalg.schur(rounded_to_float(part.block), output="real")
    ratio = abs(T[1, 0] / T[0, 1]) if len(T) == 2 and T[1, 0] else 0.0
    rotation = _rotation(part.block) if 1 / MOST_STRETCHED < ratio < MOST_STRETCHED else None
    T, turn = rotation or (T, precise(turn))
    basis, back = part.basis @ turn, inverse(turn) @ part.inverse
    size = power_of_two(np.round(np.log2(magnitude(basis).max())))
    return Part(basis / size, back * size, T)


def _rotation(block):
    """A complex pair as [[a, w], [-w, a]], a and w to their own last digits, and the basis in which it is that.

    It stays what it is however its two states are rotated. None where the zeros are real, if only by more digits.
    """
    a = (block[0, 0] + block[1, 1]) / 2
    square = block[0, 0] * block[1, 1] - block[0, 1] * block[1, 0] - a * a
    if square <= 0:
        return None
    w = square.sqrt()
    first = precise(np.array([1.0, 0.0]))
    turn = np.column_stack([first, (block @ first - a * first) / -w])
    return np.array([[float(a), float(w)], [-float(w), float(a)]]), turn


def clustered(parts: list[Part]) -> list[Part]:
    """Join parts whose separation costs more digits than the limit, each with the one whose zeros are nearest."""
    while len(parts) > 1:
        worst = int(np.argmax([part.coupling for part in parts]))
        if parts[worst].coupling <= DECOUPLING_LIMIT:
            break
        distance = [np.abs(np.subtract.outer(parts[worst].zeros, part.zeros)).min() for part in parts]
        distance[worst] = np.inf
        nearest = int(np.argmin(distance))
        together = _together(parts[worst], parts[nearest])
        parts = [part for i, part in enumerate(parts) if i not in (worst, nearest)] + [together]
    return parts


def _together(first: Part, second: Part) -> Part:
    """Two parts as one."""
    count = len(first.block)
    block = precise(np.zeros((count + len(second.block),) * 2))
    block[:count, :count], block[count:, count:] = first.block, second.block
    return _in_own_units(Part(np.hstack([first.basis, second.basis]), np.vstack([first.inverse, second.inverse]), block))


def _in_own_units(part: Part) -> Part:
    """The part in a basis that is orthonormal in the units that its own motion suggests.

    In those of a faster motion the block of a slow one would have entries much larger than its zeros.
    """
    turn = precise(np.linalg.qr(rounded_to_float(part.basis) / part.units[:, None], mode="r"))
    back = inverse(turn)
    return Part(part.basis @ back, turn @ part.inverse, turn @ part.block @ back)


def balancing_exponents(size: np.ndarray) -> np.ndarray:
    """Whole exponents e for which 2^-e A 2^e has rows and columns of about the same size (LAPACK's balancing)."""
    scale = lapack.dgebal(size, scale=1, permute=0)[3]
    return np.round(np.log2(scale))
