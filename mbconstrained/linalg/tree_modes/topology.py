"""M x'' + C x' + K x = 0, all symmetric, of sparse topology: its eigenvalues and vectors without a large dense matrix.

Meant are chains, trees, rings, ladders, beams (``elimination``). Coordinates without mass have no x''. The zeros of a small model
are those of a dense generator, those of a large one are found from those of its two halves (divide and conquer: Bini, Gemignani and
Tisseur 2005), with all work in vectors over the zeros. A vector is that of inverse iteration, and each zero is found once more from
it by Newton's step for x^T P(s) x = 0 (Lancaster 1961), every row of P(s) x summed as (sum of its entries) x_i + sum over j of
P_ij (x_j - x_i): slow motions of a chain keep their digits so.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...ground.threads import one_thread
from ...ground.tolerances import DECOUPLING_LIMIT, EPS, FACTOR_DISTANCE, MODE_SUM_ERROR, noise_of
from ..arrays import Matrix
from .ehrlich_aberth import Zeros, zeros_near
from .fronts import SparseQuadratic, sparse_quadratic
from .ordering import are_worth, front_width
from .residue_modes import ResidueModes

#: The zeros of so many states at most are those of a dense matrix.
DENSE = 120

#: Steps smaller than this part of a zero are the last ones: of halves, of the whole.
HALVES, WHOLE = 1e-4, 1e-8

#: So many zeros of a half need not settle: the last take as many steps as all others, and they are but where the whole begins.
LEFT = 0.2

#: A half has at least this part of the coordinates: what has very many branches at one place is not divided.
LEAST_HALF = 0.2

#: Entries of vectors computed at once, or the share of the zeros: their memory stays small relative to the answer.
CHUNK, PART = 1 << 14, 16

#: So often at most a vector is corrected, once at least: what is left may be rounding while much of its neighbours is in it.
CORRECTIONS = 5

#: In experiments they were recovered to this share of EPS, by the digits that the slowest motion keeps in K x.
KEPT = 1 / 16


@dataclass(frozen=True, eq=False)
class SparseTopology:
    """A symmetric model whose coordinates can be eliminated with narrow fronts.

    Attributes:
        M: shape (m, m), of x_m, the first coordinates.
        C, K: shape (m + d, m + d).
        width: width of the widest front: 1 for a chain or a tree, 2 for a ring or a ladder.
    """

    M: Matrix
    C: Matrix
    K: Matrix
    width: int

    def modes(self, coordinates: np.ndarray) -> ResidueModes | None:
        """The states (x_m, x_m', x_d) of some coordinates, coupled to no other, decoupled.

        Returns:
            None where zeros are hardly separated, or the slowest motion is lost in the rounding errors of K x.
        """
        heavy = coordinates[coordinates < self.M.shape[0]]
        C, K = (matrix[coordinates][:, coordinates] for matrix in (self.C, self.K))
        return _modes_of(self.M[heavy][:, heavy], C, K)


def sparse_topology(M: Matrix, C: Matrix, K: Matrix) -> SparseTopology | None:
    """The topology of a symmetric model, None where its fronts are too wide for its size.

    >>> sparse_topology(np.eye(3), np.zeros((3, 3)), np.diag([2.0, 2, 1]) - np.eye(3, k=1) - np.eye(3, k=-1)).width
    1
    """
    width = front_width(M, C, K)
    return SparseTopology(M, C, K, width) if width is not None and are_worth(width, K.shape[0]) else None


def _modes_of(M: Matrix, C: Matrix, K: Matrix) -> ResidueModes | None:
    P = sparse_quadratic(M, C, K)
    if P is None or not are_worth(P.narrow.order.width, P.size) or np.count_nonzero(P.is_heavy) != M.shape[0]:
        return None
    with np.errstate(all="ignore"):  # checked at the end
        if not _keeps_digits(P):
            return None
        zeros = _zeros(P, WHOLE)
        if zeros is None or 2 * len(zeros.upper) + len(zeros.real) != P.zero_count:
            return None
        result = _modes(P, zeros, M, C)
        return result if result is not None and _is_complete(result) else None


def _keeps_digits(P: SparseQuadratic) -> bool:
    """Whether the slowest motion exceeds rounding errors of K x: not for long beams, but for chains, by differences."""
    x = np.random.default_rng(0).standard_normal((P.size, 1))
    solver = P.together
    factors = solver.factored(np.zeros(1))
    for _ in range(2):
        x = solver.solved(factors, x)
        x /= np.abs(x).max()
    return P.kept_digits(x) >= KEPT * EPS / MODE_SUM_ERROR


def _zeros(P: SparseQuadratic, tolerance: float) -> Zeros | None:
    """All eigenvalues, from approximate ones: those of both halves where the model is large."""
    start = _dense(P) if P.zero_count <= DENSE else _of_halves(P)
    return None if start is None else zeros_near(P.newton, start, tolerance, LEFT if tolerance == HALVES else 0.0)


def _of_halves(P: SparseQuadratic) -> np.ndarray | None:
    halves, result = P.halves(), []
    if min(half.size for half in halves) < LEAST_HALF * P.size:
        return None
    for half in halves:
        if half.zero_count <= DENSE:
            own = _dense(half)
        else:
            zeros = _zeros(half, HALVES)
            own = None if zeros is None else zeros.all
        if own is None:
            return None
        result.append(own)
    start = np.concatenate(result)
    return start * (1 + HALVES * np.random.default_rng(0).standard_normal(len(start)))  # halves may be alike


def _dense(P: SparseQuadratic) -> np.ndarray | None:
    """The eigenvalues of the generator, states (x, x_m')."""
    (K, C, M), heavy, n = P.dense(), np.flatnonzero(P.is_heavy), P.size
    size = n + len(heavy)
    rates, states = np.zeros((2, size, size))
    rates[:n, :n], rates[:n, n:], states[:n, :n] = C, M[:, heavy], -K
    rates[range(n, size), heavy] = 1.0
    np.fill_diagonal(states[n:, n:], 1.0)
    try:
        with one_thread(size):
            return np.linalg.eigvals(np.linalg.solve(rates, states))
    except np.linalg.LinAlgError:  # a mass or a damper of it is singular by itself
        return None


def _modes(P: SparseQuadratic, zeros: Zeros, M: Matrix, C: Matrix) -> ResidueModes | None:
    """The vectors of all eigenvalues; None where one is nearly multiple or has a large residual."""
    upper, real, pairs = zeros.upper.copy(), zeros.real.copy(), len(zeros.upper)
    shapes, signs, worst = np.empty((P.size, P.zero_count)), np.empty(len(real)), 0.0
    for s, at in _chunks(upper, real, max(1, CHUNK // P.size, P.zero_count // PART)):
        result, x, square, coupling = _vectors(P, s)
        if not coupling <= DECOUPLING_LIMIT:
            return None
        worst = max(worst, coupling)
        if s.dtype == complex:
            x /= np.sqrt(square)
            upper[at], shapes[P.places, 2 * at.start : 2 * at.stop : 2] = result, x.real
            shapes[P.places, 2 * at.start + 1 : 2 * at.stop : 2] = x.imag
        else:
            real[at], signs[at] = result, np.sign(square)
            shapes[P.places, 2 * pairs + at.start : 2 * pairs + at.stop] = x / np.sqrt(np.abs(square))
    return ResidueModes(M, C, shapes, upper, real, signs, worst)


def _chunks(upper: np.ndarray, real: np.ndarray, width: int) -> Iterator[tuple[np.ndarray, slice]]:
    for part in (upper, real):
        for begin in range(0, len(part), width):
            at = slice(begin, min(begin + width, len(part)))
            yield part[at], at


def _vectors(P: SparseQuadratic, s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """The zeros, their vectors x, x^T P'(s) x and the largest sum of |y| |w| (``ResidueModes``), infinite where P(s) x is not 0.

    P is factored next to the zeros, where it is regular; what then is left of P(s) x corrects x (Neumaier 1985).
    """
    solver = P.together
    factors = solver.factored(s * (1 + FACTOR_DISTANCE))
    x = solver.solved(factors, np.random.default_rng(0).standard_normal((P.size, len(s))).astype(s.dtype))
    for done in range(CORRECTIONS + 1):
        x /= np.abs(x).max(axis=0)
        residual, damping, inertia = P.applied(s, x)
        square = np.einsum("ik,ik->k", x, damping + 2 * s * inertia)
        s = s - np.einsum("ik,ik->k", x, residual) / square
        size = np.abs(x)
        K, C, M = np.abs(P.diagonal) @ size**2
        terms = K + np.abs(s) * C + np.abs(s) ** 2 * M
        if done and (np.einsum("ik,ik->k", size, np.abs(residual)) <= noise_of(terms, P.size)).all():
            weight = s * inertia
            sums = np.einsum("ik,ik->k", size, np.abs(weight + damping) + np.abs(weight))
            return s, x, square, float((sums / np.abs(square)).max())
        x -= solver.solved(factors, residual)
    return s, x, square, np.inf


def _is_complete(result: ResidueModes) -> bool:
    """Whether modal coordinates are recovered from their sum, which means that there are as many modes as states."""
    sample = np.random.default_rng(0).choice([-1.0, 1.0], size=(result.shapes.shape[1], 2))
    return bool(np.abs(result.residues(result.states(sample)) - sample).max() <= MODE_SUM_ERROR)
