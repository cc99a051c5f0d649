"""A pencil s F - A with its inputs B in units of its own: equations, states, inputs and time scaled by powers of two.

Changing the units changes the data by exactly such factors, so they are found by a rule that follows such a change. Without
a descriptor matrix F, A is transformed by similarity: the least-squares fit of log2|a_ij| - d_i + d_j - t and
log2|b_ij| - d_i + c_j to zero over all nonzero entries. With one, equations and states are scaled apart, jointly for A and F.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse.csgraph import connected_components

from ...linalg.scaling import joint_scaling
from ...tolerances import EPS, NOISE_SAFETY
from .state_space import StateSpaceData

#: Units of one model lie at most twelve orders of magnitude apart: a coupling smaller than this part of its row and column may
#: be rounding in other units.
WEAK = 1e12 * EPS


@dataclass(frozen=True)
class ScaledPencil:
    """A_s = e A d, F_s = rate e F d, B_s = e B c: with x = d x_s, u = c u_s and t = t_s / rate the same equations.

    Attributes:
        A, F, B: the scaled matrices, entries known to a unit in the last place; an identity F is known exactly.
        through: F_s^-1 B_s, shape (n, p), and ``driven``, a basis W_1 of the same space, orthonormal where there is an F:
            that space, the states that the inputs drive, is known far better than F^-1 where F is ill-conditioned.
        driven_noise: how well it is known, as an angle.
        equation, state, input, rate: e and d, shape (n,), c, shape (p,), and rate: powers of two.
        explicit: True where F is the identity.
        dropped: how many entries of A and B were taken for rounding, and are zero here.
        weak: shape (n, n), True for small entries of A on no cycle: units could make them of any size, so that data alone does
            not tell them from rounding.
        known: how well A and F are known, relative to their size.
    """

    A: np.ndarray
    F: np.ndarray
    B: np.ndarray
    through: np.ndarray
    driven: np.ndarray
    driven_noise: float
    equation: np.ndarray
    state: np.ndarray
    input: np.ndarray
    rate: float
    explicit: bool
    dropped: int
    weak: np.ndarray
    known: float = EPS

    @property
    def solved(self) -> ScaledPencil:
        """The pencil with its equations solved for F x': better known where F makes equations nearly dependent."""
        inverse = np.linalg.inv(self.F)
        A, F, B = (inverse @ matrix for matrix in (self.A, self.F, self.B))
        loss = [
            np.linalg.norm(np.abs(inverse) @ np.abs(one)) / (np.linalg.norm(other) or 1.0)
            for one, other in ((self.A, A), (self.F, F))
        ]
        known = EPS * float(max(1.0, *loss))
        B = B / np.linalg.norm(B, axis=0)
        driven, noise = _driven(F, B, known)
        return replace(self, A=A, F=F, B=B, driven=driven, driven_noise=noise, known=known)

    @property
    def without_weak(self) -> ScaledPencil:
        """The pencil with the weak entries set to zero."""
        return replace(self, A=np.where(self.weak, 0.0, self.A), weak=np.zeros_like(self.weak))


def scaled_pencil(data: StateSpaceData) -> ScaledPencil:
    """Choose the units; without F, set to zero what is mere rounding beside other entries of its row and of its column."""
    return _explicit(data.A, data.B) if data.F is None else _descriptor(data.A, data.B, data.F)


def _explicit(A, B) -> ScaledPencil:
    kept_A, kept_B = _without_rounding(A, B)
    state, inputs, rate = _fitted(kept_A, kept_B)
    equation = 1 / (state * rate)
    scaled_B = equation[:, None] * kept_B * inputs
    dropped = int((kept_A != A).sum() + (kept_B != B).sum())
    scaled_A = equation[:, None] * kept_A * state
    return ScaledPencil(
        scaled_A, np.eye(len(A)), scaled_B, scaled_B, scaled_B, EPS, equation, state, inputs, rate, True, dropped, _weak(kept_A)
    )


def _descriptor(A, B, F) -> ScaledPencil:
    scaling = joint_scaling(np.array([A, F]))
    scaled_A, scaled_F = scaling.apply(np.array([A, F]))
    scaled_B = scaling.rows[:, None] * B
    inputs = np.exp2(-np.round(np.log2(np.linalg.norm(scaled_B, axis=0))))
    scaled_B = scaled_B * inputs
    driven, noise = _driven(scaled_F, scaled_B)
    through = np.linalg.solve(scaled_F, scaled_B)
    units = scaling.rows, scaling.columns, inputs, scaling.time
    return ScaledPencil(scaled_A, scaled_F, scaled_B, through, driven, noise, *units, False, 0, np.zeros(A.shape, dtype=bool))


def _driven(F, B, known: float = EPS) -> tuple[np.ndarray, float]:
    """An orthonormal basis of the states w with F w in the span of B, and how well it is known."""
    n, p = B.shape
    if not p:
        return B, 0.0
    U, lengths, _ = np.linalg.svd(B)
    _, values, rows = np.linalg.svd(U[:, p:].T @ F)
    return rows[n - p :].T, float(known * (lengths[0] / lengths[-1]) * np.linalg.norm(F) / values[-1])


def _weak(A) -> np.ndarray:
    size = np.abs(A)
    small = size <= WEAK * np.minimum(size.max(axis=1, keepdims=True), size.max(axis=0))
    return (size > 0) & small & _on_no_cycle(A)


def _without_rounding(A, B):
    """Zeros for entries within rounding of others of their row and column in the given units, and in the fitted ones as well.

    What is on no cycle of A the fit would bring near 1 whatever it is: there the given units decide alone.
    """
    n, (state, inputs, _) = len(A), _fitted(A, B)
    both, units = np.hstack([A, B]), np.concatenate([state, inputs])
    on_no_cycle = np.hstack([_on_no_cycle(A), np.zeros(B.shape, dtype=bool)])
    drop = _is_rounding(both) & (_is_rounding(both * units / state[:, None]) | on_no_cycle)
    kept = np.where(drop, 0.0, both)
    return kept[:, :n], kept[:, n:]


def _is_rounding(both) -> np.ndarray:
    size = np.abs(both)
    rows, columns = size.max(axis=1, keepdims=True), size.max(axis=0)
    return size <= NOISE_SAFETY * EPS * np.minimum(rows, columns)


def _on_no_cycle(A) -> np.ndarray:
    """Which entries couple parts of A that do not couple back."""
    part = connected_components(A != 0, directed=True, connection="strong")[1]
    return part[:, None] != part


def _fitted(A, B):
    """Powers of two (d, c, rate): the minimum-norm least-squares exponents by the normal equations."""
    n, p = B.shape
    both = np.hstack([A, B])
    i, j = np.nonzero(both)
    of_A = (j < n).astype(float)
    size = n + p + 1
    normal, right, logs = np.zeros((size, size)), np.zeros(size), np.log2(np.abs(both[i, j]))
    places, weights = np.stack([i, j, np.full(len(i), n + p)]), np.stack([np.ones(len(i)), -np.ones(len(i)), of_A])
    for a in range(3):
        np.add.at(right, places[a], weights[a] * logs)
        for b in range(3):
            np.add.at(normal, (places[a], places[b]), weights[a] * weights[b])
    fit = np.exp2(np.round(np.linalg.lstsq(normal, right, rcond=None)[0]))
    return fit[:n], fit[n : n + p], float(fit[-1])
