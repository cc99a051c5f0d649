"""Transfer functions of S models of one structure, from their poles and residues: H(s) = s^p C (s I - J)^-1 B and polynomial parts.

Forces f and prescribed motions b of constraint rows are inputs. x = G^T b + A(s)^-1 (f - (M s^2 + C s + K) G^T b), A(s)^-1 the sum of
residues over s - s_k and the part of massless coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...frequency.harmonic import Harmonic
from ...ground.tolerances import EPS, FORM_ROUNDING
from .stacked_poles import StackedPoles
from .system_stack import SystemStack


@dataclass(frozen=True, eq=False)
class StackedTransfer:
    """H(s) of S models, from m inputs to p outputs.

    Attributes:
        poles: poles of the models.
        outputs: shape (p, n).
        motions: of the coordinates by prescribed motions alone, shape (n, m).
        loads: coefficients of 1, s, s^2 in what acts on the coordinates, each of shape (S, n, m).
        order: p in s^p.
        levels: l in s^-l of each input: that of its prescribed derivative, shape (m,).
    """

    poles: StackedPoles
    outputs: np.ndarray
    motions: np.ndarray
    loads: tuple[np.ndarray, ...]
    order: int
    levels: np.ndarray

    @classmethod
    def of(cls, family: SystemStack, at: slice, harmonic: Harmonic, levels) -> StackedTransfer | None:
        """Transfer functions of some systems of a family for a harmonic response; None where poles do not give it."""
        n, k = family.base.size, len(family.base.rows)
        B, C = harmonic.inputs, harmonic.outputs
        if family.poles is None or B.shape[0] != n + k or C[:, n:].any() or harmonic.imaginary is not None:
            return None
        M, D, K = family.matrices(at)
        motions = family.base.multiplier_map.T @ B[n:]
        loads = [B[:n] - K @ motions] + [-(D @ motions), -(M @ motions)] * bool(motions.any())
        return cls(family.poles.of(at), C[:, :n], motions, tuple(loads), harmonic.power, np.asarray(levels, dtype=int))

    def __call__(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """H and estimates of its absolute errors, shape (S, p, m, F)."""
        poles = self.poles
        s = np.atleast_2d(s)[:, None, :]
        values, pairs = poles.values[:, :, None], (poles.weights == 2)[:, :, None]
        with np.errstate(all="ignore"):
            each = np.where(poles.weights[:, :, None] > 0, 1 / (s - values), 0.0)
            mirrored = np.where(pairs, 1 / (s - values.conj()), 0.0)
            sizes = np.abs(each) + np.abs(mirrored)
            doubt = (2 * poles.shape_errors + FORM_ROUNDING * EPS)[:, :, None] * sizes
            doubt += (poles.value_errors * np.abs(poles.values))[:, :, None] * sizes**2
            total: Any = (self.outputs @ self.motions)[:, :, None]
            error: Any = 0.0
            powers = s[:, :, None]
            for power, (residues, bound, direct) in enumerate(self._terms()):
                shape = (len(values), -1, residues.shape[3])
                part = residues.reshape(shape) @ each + residues.conj().reshape(shape) @ mirrored
                total = total + (part.reshape(*residues.shape[:3], -1) + direct[..., None]) * powers**power
                error = error + (bound.reshape(shape) @ doubt).reshape(*residues.shape[:3], -1) * np.abs(powers) ** power
            factor = powers ** (self.order - self.levels[:, None])
        return total * factor, error * np.abs(factor)

    def residues(self) -> np.ndarray:
        """The residues of H at the poles, shape (S, p, m, P)."""
        s = self.poles.values[:, None, None, :]
        total = sum(residues * s**power for power, (residues, _, _) in enumerate(self._terms()))
        return total * s ** (self.order - self.levels[:, None])

    def _terms(self):
        """For each power of s: residues, a bound of their size by the largest entries of the shapes, and the part without poles."""
        poles = self.poles
        X = self.outputs @ poles.shapes
        largest = np.abs(self.outputs).sum(axis=1)[:, None] * np.abs(poles.shapes).max(axis=1, keepdims=True)
        for load in self.loads:
            rows = (poles.left @ load).transpose(0, 2, 1)[:, None]  # (S, 1, m, P)
            yield X[:, :, None, :] * rows, largest[:, :, None, :] * np.abs(rows), self.outputs @ poles.direct @ load
