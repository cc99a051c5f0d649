"""The regular part: x(t) for t > 0 as a Bohl function, for a force of one piece.

The force's generator is appended to the finite part: G = [[T, B C_f], [0, J_f]]. Its zeros are clustered together with
those of A(s), so that resonance needs no special case.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..jordan.weierstrass import WeierstrassForm
from ..linalg.blocks import block_diagonalize
from ..linalg.noise import Noisy, columnwise
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveSmooth
from .forcing import power_of_two_of, scaled_force
from .parts import Start


@dataclass(frozen=True)
class Driven:
    """The finite part with the force appended, in scaled units.

    Attributes:
        matrix: G, shape (n + m, n + m).
        output: x as a function of both, shape (r, n + m).
        inputs: the force's states are those of f divided by these, shape (m,).
    """

    matrix: np.ndarray
    output: np.ndarray
    inputs: np.ndarray


def regular_part(form: WeierstrassForm, start: Start, force: ImpulsiveSmooth) -> tuple[BohlFunction, float]:
    """x(t) for t > 0 in the user's units and the largest decoupling entry, for a force of one piece."""
    driven, scaling = driven_form(form, force), form.companion.scaling
    parts = block_diagonalize(driven.matrix)
    function = BohlFunction(
        scaling.columns[:, None] * (driven.output @ parts.basis),
        tuple(scaling.time * block for block in parts.blocks),
        parts.inverse @ np.concatenate([start.finite, force.smooth.start_at_zero / driven.inputs]),
    )
    return function, parts.coupling


def driven_form(form: WeierstrassForm, force: ImpulsiveSmooth) -> Driven:
    """The finite part with the force appended, each term of the force measured by itself."""
    f = scaled_force(form, force)
    size = power_of_two_of(f.coefficients)  # taken out and put back: squares of noise must not leave the range
    drive = size * (columnwise(form.B.T).T @ Noisy.rounded(f.divided(size).coefficients)).cleaned()
    through = np.zeros_like(f.coefficients)
    for index, derivative in enumerate(f.derivatives(form.highest_impulse + 1)):
        through = through + form.laurent(index).cleaned() @ derivative
    amplitude = _amplitudes(np.vstack([drive, through]), force.smooth.blocks)
    matrix = np.block([[form.T, drive / amplitude], [np.zeros((len(f.start), len(form.T))), f.generator]])
    return Driven(matrix, np.hstack([form.C, through / amplitude]), f.units / amplitude)


def _amplitudes(columns, blocks) -> np.ndarray:
    """Powers of two, one for all states of a block, that bring the largest entry of its columns near 1.

    Each term of the force is measured by itself: a small one must not be lost beside a large one.
    """
    ends = np.cumsum([0, *map(len, blocks)])
    parts = [np.full(end - begin, power_of_two_of(columns[:, begin:end])) for begin, end in zip(ends, ends[1:])]
    return np.concatenate([np.ones(0), *parts])
