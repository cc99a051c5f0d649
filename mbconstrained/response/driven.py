"""The finite part driven by the force: what the decoupled pencil and f make of each other, in scaled units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..jordan.weierstrass import WeierstrassForm
from ..linalg.blocks import block_slices
from ..linalg.noise import Noisy
from ..signals.impulsive import ImpulsiveSmooth
from .forcing import power_of_two_of, scaled_force


@dataclass(frozen=True)
class Driven:
    """y' = T y + D w, w' = J_f w, x = C y + G w with the states w of the force.

    Attributes:
        drive: D, shape (n, m).
        generator: J_f, shape (m, m).
        through: G, shape (r, m): what reaches x through the infinite part.
        units: the states w are those of f divided by these, shape (m,).
    """

    drive: np.ndarray
    generator: np.ndarray
    through: np.ndarray
    units: np.ndarray


def driven_form(form: WeierstrassForm, force: ImpulsiveSmooth) -> Driven:
    """Each term of the force measured by itself: a small one must not be lost beside a large one."""
    f = scaled_force(form, force)
    if not len(f.start):
        return Driven(np.zeros((len(form.T), 0)), f.generator, f.coefficients, f.units)
    size = power_of_two_of(f.coefficients)  # taken out and put back: squares of noise must not leave the range
    drive = size * (form.noisy_B @ Noisy.rounded(f.divided(size).coefficients)).cleaned()
    through = np.zeros_like(f.coefficients)
    for index, derivative in enumerate(f.derivatives(form.highest_impulse + 1)):
        through = through + form.laurent(index).cleaned() @ derivative
    amplitude = _amplitudes(np.vstack([drive, through]), force.smooth.blocks)
    return Driven(drive / amplitude, f.generator, through / amplitude, f.units / amplitude)


def _amplitudes(columns, blocks) -> np.ndarray:
    """Powers of two, one for all states of a block, that bring the largest entry of its columns near 1."""
    parts = [np.full(len(block), power_of_two_of(columns[:, at])) for block, at in zip(blocks, block_slices(blocks))]
    return np.concatenate([np.ones(0), *parts])
