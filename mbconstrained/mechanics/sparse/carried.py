"""What the force does to the modes that are not kept: X with M X J^2 + C X J + K X = D outside of the kept ones.

For a force D e^{J t} v the left-out modes follow X e^{J t} v exactly, whatever their number, and beyond it move freely. A static
force so has its full static deflection. This is the mode-acceleration method (Williams 1945), for every force in closed form.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from ...errors import IllConditioned, InputError
from ...linalg.blocks import block_slices
from ...tolerances import EPS, NOISE_SAFETY
from .matrices import times
from .pencil import ReducedPencil
from .quadratic import QuadraticPencil
from .space import ModeSpace
from .undamped import UndampedModes, balanced

#: Solutions are refined until the residual is this small; after so many steps a force that cannot be followed is told.
SMALL, MOST_STEPS = EPS**0.75, 60


class LeftOut:
    """Solutions of P(s) x = d outside of the kept modes."""

    def __init__(self, pencil: ReducedPencil, undamped: UndampedModes, space: ModeSpace):
        self.pencil, self.undamped, self.space = pencil, undamped, space
        self.quadratic = QuadraticPencil(pencil, undamped)
        self.known: dict[complex, object] = {}

    def driving(self, forces: np.ndarray, blocks) -> np.ndarray:
        """D without what drives the kept modes."""
        pencil, space, generator = self.pencil, self.space, scipy.linalg.block_diag(*blocks)
        states = space.drive(forces)
        along, turned = space.shown(states), space.shown(space.turned(states))
        return forces - times(pencil.mass, turned + along @ generator) - times(pencil.damping, along)

    def followed(self, forces: np.ndarray, blocks) -> np.ndarray:
        """X for D and the diagonal blocks of J, one column of a block after the other in its Schur form.

        Raises:
            InputError: a left-out mode is in resonance with the force, or free.
        """
        found = np.zeros(forces.shape)
        if not blocks:
            return found
        left = self.driving(forces, blocks)
        for block, at in zip(blocks, block_slices(blocks)):
            if not left[:, at].any():
                continue
            triangle, turn = scipy.linalg.schur(block, output="complex")
            size = float(np.linalg.norm(forces[:, at]))
            found[:, at] = (self._columns(left[:, at] @ turn, triangle, size) @ turn.conj().T).real
        return found

    def _columns(self, right, triangle, size) -> np.ndarray:
        squared, found = triangle @ triangle, np.zeros(right.shape, dtype=complex)
        for j in range(right.shape[1]):
            inertia, damping = found[:, :j] @ squared[:j, j], found[:, :j] @ triangle[:j, j]
            own = right[:, j] - self.pencil.mass @ inertia - self.pencil.damping @ damping
            found[:, j] = self.solved(complex(triangle[j, j]), own, size)
        return found

    def solved(self, s: complex, right: np.ndarray, size: float = 0.0) -> np.ndarray:
        """x with P(s) x = right, refined; right is known to the rounding of something of this size."""
        solve, size = self._solver(s), max(np.linalg.norm(right), size)
        found, rest, before = np.zeros(right.shape, dtype=complex), self._undriven(right.astype(complex)), np.inf
        for _ in range(MOST_STEPS):
            found = self._outside(found + solve(rest))
            rest = self._undriven(balanced(self.pencil, right - self.quadratic.applied(s, found)))
            floor = NOISE_SAFETY * EPS * np.linalg.norm(abs(self.pencil.stiffness) @ np.abs(found))
            left = np.linalg.norm(rest)
            if left <= max(SMALL * size, floor):
                return found
            if not np.isfinite(left) or left > 2 * before:
                break
            before = left
        rate = f"s = {s.real:.6g} 1/s" if not s.imag else f"{abs(s.imag):.6g} rad/s"
        raise InputError(
            f"force: a mode that is not among the {len(self.undamped.values)} found is free, or in resonance with it at {rate}; "
            "ask for more modes with count"
        )

    def _solver(self, s: complex):
        if not s:  # the first steps of a Neumann series, with factors that are there
            factors = self.undamped.factors
            return lambda right: factors.solve(right.real) + 1j * factors.solve(right.imag)
        for moved in (s, s * (1 + EPS**0.5)):  # beside an eigenvalue to the last digit, refinement makes up for it
            if moved in self.known:
                return self.known[moved].solve
            try:
                self.known = {moved: self.quadratic.factors(moved)}
            except IllConditioned:
                continue
            return self.known[moved].solve
        raise InputError(f"force: it is in resonance with an undamped mode at {abs(s):.6g} rad/s; ask for more modes with count")

    def _outside(self, x: np.ndarray) -> np.ndarray:
        """x without the kept modes: rounding along them is large near resonance."""
        if not self.space.modal:
            return x
        X = self.space.shapes
        weighed = self.pencil.mass @ x
        return x - (X @ (X.T @ weighed.real) + 1j * (X @ (X.T @ weighed.imag)))

    def _undriven(self, forces: np.ndarray) -> np.ndarray:
        """Forces without what drives the kept modes, which is rounding here."""
        if not self.space.modal:
            return forces
        X = self.space.shapes
        return forces - self.pencil.mass @ (X @ (X.T @ forces.real) + 1j * (X @ (X.T @ forces.imag)))
