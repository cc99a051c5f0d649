"""The systems of a family as stacks of matrices."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from ...ground.checks import counted
from ...ground.display import Displayed
from ...ground.tolerances import noise_of
from ..system import MechanicalSystem
from .stacked_equations import StackedEquations, stacked_equations
from .stacked_poles import StackedPoles, stacked_poles


@dataclass(frozen=True, repr=False, eq=False)
class SystemStack(Displayed):
    """Data of a ``Family``, without the answers to questions about it; its attributes."""

    base: MechanicalSystem
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    static_force: np.ndarray

    def _summary(self) -> str:
        return f"{counted(len(self), 'system')} of {counted(self.base.size, 'coordinate')}"

    def __len__(self) -> int:
        return len(self.mass)

    def __getitem__(self, index: int) -> MechanicalSystem:
        place = range(len(self))[index]  # IndexError where there is none
        base, (M, C, K) = self.base, self.matrices(place)
        units = list(base.units.values())
        return MechanicalSystem(M, C, K, base.constraints, base.names, base.excitation, self.static_force[place], units)

    def __iter__(self) -> Iterator[MechanicalSystem]:
        return (self[index] for index in range(len(self)))

    @cached_property
    def equations(self) -> StackedEquations | None:
        """Equations in stacks of matrices; None where the structure needs rank decisions, which are made for each system."""
        return stacked_equations(*self.matrices(slice(None)), self.base.position_form().null_space)

    @cached_property
    def poles(self) -> StackedPoles | None:
        """Poles and residues in stacks; None without stacked ``equations``."""
        return None if self.equations is None else stacked_poles(self.equations, *self.matrices(slice(None)))

    def matrices(self, at: slice | int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """M, C and K of some systems, or of one."""
        return self.mass[at], self.damping[at], self.stiffness[at]

    def is_free(self, shapes: np.ndarray, of: Literal["stiffness", "damping"]) -> np.ndarray:
        """Return which systems have no springs, or no dampers, that resist some motions, up to rounding errors of the entries.

        Args:
            shapes: displacements that satisfy the constraints, shape (n, z).
            of: the matrices to check.

        Returns:
            Truth values, shape (S,).
        """
        V, matrices = self.base.position_form().null_space, getattr(self, of)
        noise = noise_of(np.abs(V.T) @ np.abs(matrices) @ np.abs(shapes))
        return (np.abs(V.T @ (matrices @ shapes)) <= noise).all(axis=(1, 2))
