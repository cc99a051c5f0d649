"""The mechanical energy of a motion over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .element_matrix import ElementMatrix

if TYPE_CHECKING:
    from .system import MechanicalSystem


@dataclass(frozen=True)
class Energy:
    """Energies in joules, each a number or shape (T,).

    Not included: what dampers have taken up, and the work of forces that vary in time, of impulses and of
    constraint rows with a value at velocity or acceleration level. Without those the total is constant for t > 0.

    Attributes:
        kinetic: 1/2 x'^T M x'.
        strain: 1/2 x^T K x, from the symmetric part of K; zero at x = 0.
        static: -f_0^T x, the potential of the constant forces f_0 (rest lengths, weight) of the system; zero at
            x = 0. Strain and static energy together differ from the energy stored in springs of a given rest length
            and in heights only by a constant.
        total: the sum.
    """

    kinetic: np.ndarray
    strain: np.ndarray
    static: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """kinetic + strain + static."""
        return self.kinetic + self.strain + self.static


def energy_of(system: MechanicalSystem, displacement: np.ndarray, velocity: np.ndarray) -> Energy:
    """The energies at states (n,) or (n, T)."""
    stiffness, _, mass = system.given
    return Energy(
        kinetic=_half_square(mass, velocity),
        strain=_half_square(stiffness, displacement),
        static=-(system.static_force @ displacement),
    )


def _half_square(matrix, vectors):
    """1/2 v^T A v, element by element where A is given so: of stiff springs the difference of products would be mere rounding."""
    if isinstance(matrix, ElementMatrix):
        return matrix.constants @ (matrix.directions @ vectors) ** 2 / 2
    return np.sum(vectors * (matrix @ vectors), axis=0) / 2
