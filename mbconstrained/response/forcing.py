"""The force and the values at 0- in the units of the scaled pencil."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log2

import numpy as np

from ..jordan.weierstrass import WeierstrassForm
from ..linalg.blocks import block_matrix, block_slices
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.restarts import Restarts


@dataclass(frozen=True)
class ScaledForce:
    """f in the units of the scaled pencil: coefficients C_f, generator J_f, start v at 0+, and Dirac impulses at t = 0.

    Attributes:
        units: what its states are measured in: its start is that of f divided by them.
        jump: the start, without what is known to be an approximation of nothing.
    """

    coefficients: np.ndarray
    generator: np.ndarray
    start: np.ndarray
    impulses: tuple[np.ndarray, ...]
    units: np.ndarray
    jump: np.ndarray

    def divided(self, size: float) -> ScaledForce:
        """f / size."""
        return replace(self, coefficients=self.coefficients / size, impulses=tuple(g / size for g in self.impulses))

    def derivatives(self, count: int) -> list[np.ndarray]:
        """C_f J_f^i for i = 0 .. count - 1: f^(i) = C_f J_f^i e^{J_f t} v."""
        found = [self.coefficients]
        for _ in range(count - 1):
            found.append(found[-1] @ self.generator)
        return found[:count]


def scaled_force(form: WeierstrassForm, force: ImpulsiveSmooth) -> ScaledForce:
    """f' = rows * f as a function of t' = time * t, its states measured so that chains have couplings near their rates."""
    scaling = form.companion.scaling
    smooth = force.smooth
    size = _units(smooth, scaling.time)
    return ScaledForce(
        scaling.rows[:, None] * smooth.coefficients * size,
        block_matrix(smooth.blocks) / scaling.time * size / size[:, None],
        smooth.start_at_zero / size,
        scaled_impulses(form, force.impulses),
        size,
        smooth.restarts.jumps[:, 0] / size,
    )


def scaled_impulses(form: WeierstrassForm, impulses) -> tuple[np.ndarray, ...]:
    """Factors of delta, delta', ... as functions of t' = time * t, in the units of the scaled pencil's equations."""
    scaling = form.companion.scaling
    return tuple(scaling.rows * g * scaling.time ** (k + 1.0) for k, g in enumerate(impulses))


def _units(smooth: BohlFunction, time: float) -> np.ndarray:
    """Powers of two that the states of the force are measured in."""
    units = [np.ones(0)]
    for block, at in zip(smooth.blocks, block_slices(smooth.blocks)):
        pieces = units_of_pieces(smooth, block, at)
        units.append(_chain_units(block / time) if pieces is None else pieces)
    return np.concatenate(units)


def units_of_pieces(smooth: BohlFunction, block: np.ndarray, at: slice) -> np.ndarray | None:
    """Powers of two for the states of one block of pieces, which are as large as they are; None for others.

    Polynomials of short pieces have large derivatives, and what is far from the size of the others could not be told
    from a slow zero of A(s).
    """
    largest = np.abs(smooth.restarts.states[at]).max(axis=1)
    pieces = isinstance(smooth.start, Restarts) and _level(block) == 1 and (largest > 0).all() and np.isfinite(largest).all()
    return np.exp2(np.round(np.log2(largest))) if pieces else None


def _level(block) -> int:
    """Two for the chain of a complex pair, one for that of a real rate."""
    return 2 if len(block) > 1 and block[1, 0] != 0 else 1


def _chain_units(block) -> np.ndarray:
    """Powers of two for the states of t^k e^{a t} (cos, sin), k descending, that bring the couplings near the rates.

    Where the rates are zero, near 1: the pencil's own unit of time.
    """
    level = _level(block)
    units, rate = np.ones(len(block)), np.abs(block[:level, :level]).max() or 1.0
    for at in range(level, len(block), level):
        coupling = np.abs(block[at - level : at, at : at + level]).max() / rate
        units[at:] = units[at - 1] / 2.0 ** np.round(np.log2(coupling)) if coupling > 0 else units[at - 1]
    return units


def scaled_data(form: WeierstrassForm, initial: np.ndarray, force: ImpulsiveSmooth) -> tuple[np.ndarray, ScaledForce, float]:
    """The stacked values at 0- and the force, both divided by a power of two near their size, and that power.

    All at t = 0 is linear in them; their size shall not take the squares of noise out of range.
    """
    stack, f = form.companion.scaled_stack(initial), scaled_force(form, force)
    size = power_of_two_of(np.concatenate([stack, f.coefficients.ravel(), *f.impulses]))
    return stack / size, f.divided(size), size


def power_of_two_of(matrix) -> float:
    """A power of two near the largest entry, 1 where all are zero."""
    size = np.abs(matrix).max(initial=0.0)
    return 2.0 ** round(log2(size)) if size > 0 else 1.0
