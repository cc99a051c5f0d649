"""The static correction, exact for every force: X with M X J^2 + C X J + K X = D outside of the kept modes.

For a force D e^{J t} v the left-out modes follow X e^{J t} v exactly, whatever their number, and beyond it move freely. A static
force so has its full static deflection. This is the mode-acceleration method (Williams 1945), for every force in closed form.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse
from scipy.sparse.linalg import splu

from ...ground.errors import IllConditioned, InputError, MbconstrainedError
from ...ground.tolerances import CORRECTION_RESIDUAL, EPS, NOISE_SAFETY
from ...linalg.blocks import block_slices
from ...signals.bohl import BohlFunction
from .factorization import factorize
from .modal_space import Amplitudes, ModeSpace
from .pencil import ReducedPencil
from .quadratic_pencil import QuadraticPencil
from .sparse_matrices import times
from .undamped_modes import UndampedModes, balanced

#: The refinement steps after which a force cannot be followed.
MOST_STEPS = 60


class StaticCorrection:
    """Solutions of P(s) x = d outside of the kept modes."""

    def __init__(self, pencil: ReducedPencil, undamped: UndampedModes, space: ModeSpace):
        self.pencil, self.undamped, self.space = pencil, undamped, space
        self.quadratic = QuadraticPencil(pencil, undamped)
        self.known: dict[complex, Any] = {}

    def _residual_forces(self, forces: np.ndarray, blocks) -> np.ndarray:
        """D without the part that acts on the kept modes."""
        pencil, space, generator = self.pencil, self.space, scipy.linalg.block_diag(*blocks)
        states = space.modal_forces(forces)
        along, turned = space.displacements(states), space.displacements(space.times_generator(states))
        return forces - times(pencil.mass, turned + along @ generator) - times(pencil.damping, along)

    def followed(self, forces: np.ndarray, blocks) -> np.ndarray:
        """X for D and the diagonal blocks of J, one column of a block after another in its Schur form."""
        correction = np.zeros(forces.shape)
        if not blocks:
            return correction
        left = self._residual_forces(forces, blocks)
        for block, at in zip(blocks, block_slices(blocks)):
            if not left[:, at].any():
                continue
            triangle, turn = scipy.linalg.schur(block, output="complex")
            size = float(np.linalg.norm(forces[:, at]))
            correction[:, at] = (self._columns(left[:, at] @ turn, triangle, size) @ turn.conj().T).real
        return correction

    def _columns(self, right, triangle, size) -> np.ndarray:
        squared, columns = triangle @ triangle, np.zeros(right.shape, dtype=complex)
        for j in range(right.shape[1]):
            inertia, damping = columns[:, :j] @ squared[:j, j], columns[:, :j] @ triangle[:j, j]
            own = right[:, j] - self.pencil.mass @ inertia - self.pencil.damping @ damping
            columns[:, j] = self.solved(complex(triangle[j, j]), own, size)
        return columns

    def solved(self, s: complex, right: np.ndarray, size: float = 0.0) -> np.ndarray:
        """x with P(s) x = right, refined; right has rounding errors of this size."""
        solve, size = self._solver(s), max(np.linalg.norm(right), size)
        solution, rest, before = np.zeros(right.shape, dtype=complex), self._residual(right.astype(complex)), np.inf
        for _ in range(MOST_STEPS):
            solution = self._outside(solution + solve(rest))
            rest = self._residual(balanced(self.pencil, right - self.quadratic.applied(s, solution)))
            floor = NOISE_SAFETY * EPS * np.linalg.norm(abs(self.pencil.stiffness) @ np.abs(solution))
            left = np.linalg.norm(rest)
            if left <= max(CORRECTION_RESIDUAL * size, floor):
                return solution
            if not np.isfinite(left) or left > 2 * before:
                break
            before = left
        rate = f"s = {s.real:.6g} 1/s" if not s.imag else f"{abs(s.imag):.6g} rad/s"
        raise InputError(
            f"force: a mode beyond the {len(self.undamped.values)} computed ones is free, or in resonance with it at {rate}; "
            "increase count"
        )

    def _solver(self, s: complex):
        if not s:  # the first steps of a Neumann series, with factors that are there
            factors = self.undamped.factors
            return lambda right: factors.solve(right.real) + 1j * factors.solve(right.imag)
        for moved in (s, s * (1 + EPS**0.5)):  # next to an eigenvalue in the last digit, which refinement corrects
            if moved in self.known:
                return self.known[moved].solve
            try:
                self.known = {moved: self.quadratic.factors(moved)}
            except IllConditioned:
                continue
            return self.known[moved].solve
        raise InputError(f"force: it is in resonance with an undamped mode at {abs(s):.6g} rad/s; increase count")

    def _outside(self, x: np.ndarray) -> np.ndarray:
        """x without the kept modes: rounding along them is large near resonance."""
        if not self.space.modal:
            return x
        X = self.space.shapes
        weighed = self.pencil.mass @ x
        return x - (X @ (X.T @ weighed.real) + 1j * (X @ (X.T @ weighed.imag)))

    def _residual(self, forces: np.ndarray) -> np.ndarray:
        """Forces without their part on the kept modes, which is rounding error here."""
        if not self.space.modal:
            return forces
        X = self.space.shapes
        return forces - self.pencil.mass @ (X @ (X.T @ forces.real) + 1j * (X @ (X.T @ forces.imag)))


# The energy outside of the kept modes: that of a free motion of the whole system, so that it never grows.
#
# x_rest = x - W a - X z solves M x'' + C x' + K x = 0 between the times at which the force changes, exactly, and there it gains the
# jump of -X z. With x'^T C x' >= 0 its energy is at most that of its starts: sqrt(2 E) <= sum of sqrt(2 E_j), as this is a norm.


@dataclass(frozen=True)
class Remainder:
    """A bound of the motion outside of the kept modes.

    Attributes:
        norm: of its energy norm sqrt(2 E).
        relative: the bound relative to the norm of the whole motion.
        passive: whether it is valid for all times.
        jumps: whether coordinates without mass jump at the start.
    """

    norm: float
    relative: float
    passive: bool
    jumps: bool


def remainder(left: StaticCorrection, displacement, velocity, amplitudes: Amplitudes, followed, smooth: BohlFunction) -> Remainder:
    """The bound for a start, and a force that changes at knots."""
    pencil, space, restarts = left.pencil, left.space, smooth.restarts
    generator = smooth.generator
    z, jumps = restarts.states[:, 0], restarts.jumps[:, 1:]
    states = amplitudes.start[:, None]
    forced = space.modal_forces(np.asarray(_forces(left, smooth)) @ z[:, None])
    kept = space.displacements(states)[:, 0], space.displacements(space.times_generator(states) + forced)[:, 0]
    forced = followed @ z, followed @ (generator @ z)
    rest, jumped = _relaxed(pencil, displacement - kept[0] - forced[0])
    terms = [(displacement, velocity), kept, forced]
    first = _norm(pencil, rest, velocity - kept[1] - forced[1])
    sizes = [_norm(pencil, *term) for term in terms]
    if first <= NOISE_SAFETY * EPS * sum(_rough(pencil, *term) for term in terms):
        first = 0.0
    changes = _norms(pencil, followed, generator, jumps)
    norm = 0.0 if left.undamped.complete and space.modal else float(first + changes.sum())
    whole = max(sizes[0], sizes[1]) + sizes[2] + changes.sum()
    relative = min(norm / np.hypot(norm, whole), 1.0) if norm else 0.0
    return Remainder(norm, float(relative), _is_passive(left), jumped)


def _forces(left: StaticCorrection, smooth: BohlFunction) -> np.ndarray:
    return left.pencil.basis.T @ smooth.coefficients


def _norm(pencil: ReducedPencil, x, v) -> float:
    """(v^T M v + x^T K x)^(1/2)."""
    return max(float(v @ (pencil.mass @ v) + x @ (pencil.stiffness @ x)), 0.0) ** 0.5


def _rough(pencil: ReducedPencil, x, v) -> float:
    """Energy norm of the absolute values: times the unit roundoff it bounds the rounding errors of the norm."""
    x, v = np.abs(x), np.abs(v)
    return float(v @ (abs(pencil.mass) @ v) + x @ (abs(pencil.stiffness) @ x)) ** 0.5


def _norms(pencil: ReducedPencil, followed, generator, jumps) -> np.ndarray:
    """The energy norm of X dz at each of the later changes of the force, shape (K - 1,)."""
    if not jumps.size:
        return np.zeros(0)
    turned = followed @ generator
    square = followed.T @ times(pencil.stiffness, followed) + turned.T @ times(pencil.mass, turned)
    return np.maximum((jumps * (square @ jumps)).sum(axis=0), 0.0) ** 0.5


def _relaxed(pencil: ReducedPencil, rest: np.ndarray) -> tuple[np.ndarray, bool]:
    """The displacement with massless, undamped coordinates in equilibrium between the springs, and whether any of them changed."""
    empty = np.diff(pencil.mass.indptr) + np.diff(pencil.damping.indptr) == 0
    if not empty.any() or pencil.rows.shape[0]:
        return rest, False
    stiffness = scipy.sparse.csr_array(pencil.stiffness)[empty]
    own, forces = scipy.sparse.csc_array(stiffness[:, empty]), stiffness @ rest
    noise = NOISE_SAFETY * EPS * (abs(stiffness) @ np.abs(rest))
    if (np.abs(forces) <= noise).all():
        return rest, False
    relaxed = rest.copy()
    relaxed[empty] -= splu(own).solve(forces)
    moved = np.abs(relaxed - rest).max()
    return relaxed, bool(moved > EPS**0.5 * np.abs(rest).max())


def _is_passive(left: StaticCorrection) -> bool:
    """Whether stiffness and damping supply no energy to the motion outside of the kept modes."""
    values = left.undamped.values
    if (len(values) and values[-1] < 0) or left.undamped.factors.negative != 0:
        return False
    if not left.space.modal and (values < 0).any():
        return False
    C = left.pencil.damping
    diagonal = C.diagonal()
    if (diagonal >= 0).all() and (2 * diagonal >= abs(C).sum(axis=0) * (1 - NOISE_SAFETY * EPS)).all():
        return True
    try:
        lifted = C + scipy.sparse.diags_array(NOISE_SAFETY * EPS * np.where(diagonal > 0, diagonal, np.abs(C.data).max()))
        return factorize(lifted, scipy.sparse.csr_array((0, C.shape[0])), left.pencil.described).negative == 0
    except MbconstrainedError:
        return False
