"""The force and the values at 0- in the units of the scaled pencil."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log2

import numpy as np

from ..linalg.blocks import block_matrix, block_slices
from ..linalg.rounding import Noisy
from ..polynomial.decoupling import WeierstrassForm
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.restarts import Restarts


@dataclass(frozen=True, eq=False)
class ScaledForce:
    """f in the units of the scaled pencil: coefficients C_f, generator J_f, start v at 0+, and Dirac impulses at t = 0.

    Attributes:
        units: units of its states: its start is that of f divided by them.
        jump: the start without the states that approximate zero.
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
        derivatives = [self.coefficients]
        for _ in range(count - 1):
            derivatives.append(derivatives[-1] @ self.generator)
        return derivatives[:count]


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
    """Units of the states of the force, powers of two."""
    units = [np.ones(0)]
    for block, at in zip(smooth.blocks, block_slices(smooth.blocks)):
        pieces = units_of_pieces(smooth, block, at)
        units.append(_chain_units(block / time) if pieces is None else pieces)
    return np.concatenate(units)


def units_of_pieces(smooth: BohlFunction, block: np.ndarray, at: slice) -> np.ndarray | None:
    """Units near the size of the states of one block of pieces, powers of two; None for other blocks.

    Polynomials of short pieces have large derivatives, and states of very different size could not be distinguished
    from those of a slow zero of A(s).
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

    All effects at t = 0 are linear in them; divided so, the squares of noise stay in range.
    """
    stack, f = form.companion.scaled_stack(initial), scaled_force(form, force)
    size = power_of_two_of(np.concatenate([stack, f.coefficients.ravel(), *f.impulses]))
    return stack / size, f.divided(size), size


def power_of_two_of(matrix) -> float:
    """A power of two near the largest entry, 1 where all are zero."""
    size = np.abs(matrix).max(initial=0.0)
    return 2.0 ** round(log2(size)) if size > 0 else 1.0


# The finite part driven by the force, in scaled units.


@dataclass(frozen=True, eq=False)
class Driven:
    """y' = T y + D w, w' = J_f w, x = C y + G w with the states w of the force.

    Attributes:
        excitation: D, shape (n, m).
        generator: J_f, shape (m, m).
        through: G, shape (r, m), the share of x by the infinite part.
        units: the states w are those of f divided by these, shape (m,).
    """

    excitation: np.ndarray
    generator: np.ndarray
    through: np.ndarray
    units: np.ndarray


def driven_form(form: WeierstrassForm, force: ImpulsiveSmooth) -> Driven:
    """The form with each term of the force in its own units: a small one must not be lost in the rounding error of a large one."""
    f = scaled_force(form, force)
    if not len(f.start):
        return Driven(np.zeros((len(form.T), 0)), f.generator, f.coefficients, f.units)
    size = power_of_two_of(f.coefficients)  # divided by and multiplied again: squares of noise stay in range
    excitation = size * (form.noisy_B.settled() @ Noisy.rounded(f.divided(size).coefficients)).cleaned()
    through = np.zeros_like(f.coefficients)
    for index, derivative in enumerate(f.derivatives(form.highest_impulse + 1)):
        through = through + form.laurent(index).cleaned() @ derivative
    amplitude = _amplitudes(np.vstack([excitation, through]), force.smooth.blocks)
    return Driven(excitation / amplitude, f.generator, through / amplitude, f.units / amplitude)


def _amplitudes(columns, blocks) -> np.ndarray:
    """Powers of two, one for all states of a block, that bring the largest entry of its columns near 1."""
    parts = [np.full(len(block), power_of_two_of(columns[:, at])) for block, at in zip(blocks, block_slices(blocks))]
    return np.concatenate([np.ones(0), *parts])
