"""What the symmetry and signs of M, C and K alone say about energy, whatever the rounding of computed zeros."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..tolerances import noise_of

if TYPE_CHECKING:
    from .system import MechanicalSystem


@dataclass(frozen=True)
class Conservation:
    """Two facts about a system.

    Attributes:
        passive: M, K and the symmetric part of C are positive semidefinite, M and K symmetric: energy cannot
            grow, no zero lies in the right half plane.
        lossless: every zero lies on the real or on the imaginary axis, because energy is kept: passive with a
            skew-symmetric (gyroscopic) C, or no C at all with M, K symmetric and M positive semidefinite.
    """

    passive: bool
    lossless: bool


def conservation_of(system: MechanicalSystem) -> Conservation:
    """Read both off the matrices; constraint rows that do not move change neither."""
    M, C, K = system.mass, system.damping, system.stiffness
    conservative = _symmetric(M) and _symmetric(K) and _positive(M)
    passive = conservative and _positive(K) and _positive(C + C.T)
    lossless = conservative and (not C.any() or (passive and not (C + C.T).any()))
    return Conservation(passive, lossless)


def _symmetric(matrix: np.ndarray) -> bool:
    """Symmetric to within rounding."""
    return bool((np.abs(matrix - matrix.T) <= noise_of(float(np.abs(matrix).max()))).all())


def _positive(matrix: np.ndarray) -> bool:
    """Positive semidefinite to within rounding, each coordinate in units in which it counts as much as the others."""
    size = np.sqrt(np.abs(np.diag(matrix)))
    size[size == 0] = 1.0
    values = np.linalg.eigvalsh(matrix / size / size[:, None])
    return bool(values[0] >= -noise_of(float(np.abs(values).max()), len(values)))
