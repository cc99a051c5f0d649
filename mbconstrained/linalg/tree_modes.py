"""The modes of large symmetric models of sparse topology (chains, trees, rings, ladders, beams), without a large dense matrix.

Of damped chains of 250 and 500 masses ``sparse_topology`` takes 0.11 and 0.28 s, where LAPACK's eigenvectors of the dense generator
(geev) take 0.19 and 0.94 s; at 125 masses both take 0.04 s. The slow motions keep the digits that their equations have.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..ground.threads import one_thread
from ..ground.tolerances import DECOUPLING_LIMIT, EPS, FACTOR_DISTANCE, MODE_SUM_ERROR, STALLED_STEP, noise_of
from .arrays import Matrix
from .elimination import SparseQuadratic, are_worth, front_width, sparse_quadratic

# A symmetric system of second order decoupled by the vectors of its coordinates, without an inverse of twice their number.
# For symmetric M, C, K a zero s of P(s) = M s^2 + C s + K with P(s) x = 0 has x^T P(s) = 0 too. With x^T P'(s) x = 1 or -1 the states
# w = (x_m, x_m', x_d) are sums of (x_m, s x_m, x_d) with coefficients x^T ((s M + C) (x_m, x_d) + M x_m'), by residues of P(s)^-1
# (Lancaster 1966, chapter 4). Half of the entries of the vectors are all that is stored.


@dataclass(frozen=True, eq=False)
class ResidueModes:
    """Modes by residues in the form of a ``BlockDiagonal``, with basis and inverse computed on demand.

    Attributes:
        M, C: coefficients, of shape (m, m) and (m + d, m + d).
        shapes: x, real and imaginary parts of pairs side by side, then those of real zeros, shape (m + d, n).
        upper, real: s of pairs, above the real axis, and real ones.
        signs: x^T P'(s) x of real zeros, 1 or -1.
        coupling: the largest sum of |y| |w| over the states, y being the row of the inverse for the vector w.
        exact_blocks: 0: no block is known exactly.
    """

    M: Matrix
    C: Matrix
    shapes: np.ndarray
    upper: np.ndarray
    real: np.ndarray
    signs: np.ndarray
    coupling: float
    exact_blocks: int = 0

    @cached_property
    def blocks(self) -> tuple[np.ndarray, ...]:
        """[[a, b], [-b, a]] of pairs a + i b, then real zeros."""
        a, b = self.upper.real, self.upper.imag
        return (*np.stack([a, b, -b, a], axis=1).reshape(-1, 2, 2), *self.real[:, None, None])

    @cached_property
    def basis(self) -> np.ndarray:
        """Shape (n, n)."""
        m = self.M.shape[0]
        return np.concatenate([self.shapes[:m], self._velocities(self.shapes[:m]), self.shapes[m:]])

    @cached_property
    def inverse(self) -> np.ndarray:
        """Inverse of the basis, shape (n, n)."""
        return self.coordinates(np.eye(self.shapes.shape[1]))

    def modal_output(self, output: Matrix) -> np.ndarray:
        """output @ basis, for an output of shape (r, n)."""
        m = self.M.shape[0]
        velocities = output[:, m : 2 * m]
        result = output[:, :m] @ self.shapes[:m]
        if self.shapes.shape[0] > m:
            result += output[:, 2 * m :] @ self.shapes[m:]
        if abs(velocities).max() > 0:
            result += self._velocities(velocities @ self.shapes[:m])
        return result

    def coordinates(self, states: np.ndarray) -> np.ndarray:
        """inverse @ states, of shape (n, any) or (n,), with one step of refinement."""
        result = self.residues(states)
        return result + self.residues(states - self.states(result))

    def residues(self, states: np.ndarray) -> np.ndarray:
        """inverse @ states by the formula."""
        m = self.M.shape[0]
        places, velocities = np.concatenate([states[:m], states[2 * m :]]), states[m : 2 * m]
        loads, momenta = self.C @ places, self.M @ places[:m]
        loads[:m] += self.M @ velocities
        one, two = self.shapes.T @ loads, self.shapes[:m].T @ momenta
        count = 2 * len(self.upper)
        s, turned = self.upper.reshape(-1, *[1] * (states.ndim - 1)), _complex(one[:count]) + 0j
        turned += s * _complex(two[:count])
        result = np.empty_like(one)
        result[0:count:2], result[1:count:2] = 2 * turned.real, -2 * turned.imag
        signs, real = (part.reshape(-1, *[1] * (states.ndim - 1)) for part in (self.signs, self.real))
        result[count:] = signs * (one[count:] + real * two[count:])
        return result

    def states(self, coordinates: np.ndarray) -> np.ndarray:
        """basis @ coordinates."""
        m = self.M.shape[0]
        rates = np.empty_like(coordinates)
        count, extra = 2 * len(self.upper), [1] * (coordinates.ndim - 1)
        a, b = self.upper.real.reshape(-1, *extra), self.upper.imag.reshape(-1, *extra)
        even, odd = coordinates[0:count:2], coordinates[1:count:2]
        rates[0:count:2], rates[1:count:2] = a * even + b * odd, a * odd - b * even
        rates[count:] = self.real.reshape(-1, *extra) * coordinates[count:]
        places = self.shapes @ coordinates
        return np.concatenate([places[:m], self.shapes[:m] @ rates, places[m:]])

    def _velocities(self, columns: np.ndarray) -> np.ndarray:
        """columns @ diag(blocks)."""
        result, count = columns.copy(), 2 * len(self.upper)
        a, b = self.upper.real, self.upper.imag
        even, odd = columns[:, 0:count:2], columns[:, 1:count:2]
        result[:, 0:count:2], result[:, 1:count:2] = even * a - odd * b, even * b + odd * a
        result[:, count:] *= self.real
        return result


def _complex(rows: np.ndarray) -> np.ndarray:
    return rows[0::2] + 1j * rows[1::2]


# Simultaneous zeros of a real polynomial p, from approximate ones and p'/p, by the method of Ehrlich and Aberth.
# Every zero takes Newton's step for p divided by the distances to all others, so that no two go to the same place (Aberth 1973; for
# eigenproblems Bini, Gemignani and Tisseur 2005). Zeros off the real axis are kept as pairs; near the axis each one moves on its own,
# so that a pair can become two real zeros and two of those a pair.

#: After so many steps what is not found is given up, after the first number where it is more than a part of all and a few.
MANY_STEPS, STEPS, CORRECTION_PART, FEW = 20, 50, 0.1, 8

#: A zero so near to the real axis, relative to its size, goes without its conjugate, unless its last step was a jump across the plane; so do
#: all that are still so far from a zero after some steps. The slow ones of close zeros stay pairs: parted, they would lose their places.
NEAR, JUMP, SLOW = 0.03, 0.3, 12

#: Number of differences of zeros computed at once.
CORRECTION_CHUNK = 1 << 16


@dataclass(frozen=True, eq=False)
class Zeros:
    """The zeros of a real polynomial.

    Attributes:
        upper: one of each pair, above the real axis.
        real: the others.
    """

    upper: np.ndarray
    real: np.ndarray

    @property
    def all(self) -> np.ndarray:
        """Every zero, the conjugates too."""
        return np.concatenate([self.upper, self.upper.conj(), self.real])


def zeros_near(newton: Callable[[np.ndarray], np.ndarray], start: np.ndarray, tolerance: float, left: float = 0.0) -> Zeros | None:
    """As many zeros as approximate ones; None without convergence."""
    pair, free = start.imag > NEAR * np.abs(start), start[np.abs(start.imag) <= NEAR * np.abs(start)]
    free = free * (1 + NEAR * 1j * (-1.0) ** np.arange(len(free)))  # real ones, too, must be able to become pairs
    s, paired = np.concatenate([start[pair], free]), np.arange(np.count_nonzero(pair) + len(free)) < np.count_nonzero(pair)
    if 2 * np.count_nonzero(pair) + len(free) != len(start):
        return None
    moving, last = np.arange(len(s)), np.full(len(s), np.inf)
    for done in range(STEPS):
        with np.errstate(all="ignore"):  # of a zero and itself, and where p is exactly 0
            step = 1 / (_finite(newton, s[moving]) - _others(s, paired, moving))
        s[moving] -= step
        part = np.abs(step) / np.abs(s[moving])
        settled = (part <= tolerance) | ((part <= STALLED_STEP) & (part >= last[moving] / 2))
        last[moving] = part
        moving = moving[~settled]
        if len(moving) <= left * len(s):
            return _sorted(s, paired, tolerance)
        if done > MANY_STEPS and len(moving) > FEW + CORRECTION_PART * len(s):
            return None
        at, steps = s[moving], last[moving]
        is_alone = (np.abs(at.imag) <= NEAR * np.abs(at)) & (steps <= JUMP)
        if done == SLOW:
            is_alone |= steps > NEAR
        alone = moving[paired[moving] & is_alone]
        if len(alone):
            s, paired, moving = _parted(s, paired, moving, alone)
            last = np.full(len(s), np.inf)
    return None


def _finite(newton, s: np.ndarray) -> np.ndarray:
    """p'/p, at a neighbouring point where something vanishes."""
    result = newton(s)
    bad = ~np.isfinite(result)
    if bad.any():
        result[bad] = newton(s[bad] * (1 + EPS**0.5))
    return result


def _others(s: np.ndarray, paired: np.ndarray, moving: np.ndarray) -> np.ndarray:
    """The sum of 1 / (s - z) over all other zeros z and their conjugates, for the iterated ones."""
    result = np.empty(len(moving), dtype=complex)
    a, square, pairs = s.real, s.imag**2, np.count_nonzero(paired)
    for begin in range(0, len(moving), width := max(1, CORRECTION_CHUNK // len(s))):
        at = moving[begin : begin + width]
        differences = s[at, None] - a
        terms, own = np.empty_like(differences), np.arange(len(at))
        terms[:, :pairs] = 2 * differences[:, :pairs] / (differences[:, :pairs] ** 2 + square[:pairs])
        terms[:, pairs:] = 1 / (s[at, None] - s[pairs:])
        terms[own, at] = np.where(paired[at], 1 / (2j * np.where(paired[at], s[at].imag, 1.0)), 0.0)
        result[begin : begin + width] = terms.sum(axis=1)
    return result


def _parted(s: np.ndarray, paired: np.ndarray, moving: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Some of the iterated pairs split into two zeros, slightly displaced from each other."""
    size, rest = NEAR * np.abs(s[at]), np.delete(np.arange(len(s)), at)
    split = np.concatenate([s[at] + size, s[at].conj() - size])
    marks = np.concatenate([np.isin(rest, moving), np.ones(len(split), dtype=bool)])
    paired = np.concatenate([paired[rest], np.zeros(len(split), dtype=bool)])
    return np.concatenate([s[rest], split]), paired, np.flatnonzero(marks)


def _sorted(s: np.ndarray, paired: np.ndarray, tolerance: float) -> Zeros:
    """Free zeros as pairs, where one is near the conjugate of another, and real ones."""
    free = s[~paired]
    above, below = np.flatnonzero(free.imag > tolerance * np.abs(free)), np.flatnonzero(free.imag < -tolerance * np.abs(free))
    alone = np.ones(len(free), dtype=bool)
    for at in above[: len(below)]:
        other = below[np.abs(free[below] - free[at].conj()).argmin()]
        if np.abs(free[other] - free[at].conj()) <= free[at].imag:
            alone[[at, other]] = False
    pairs = np.concatenate([s[paired], free[above][~alone[above]]])
    return Zeros(pairs.real + 1j * np.abs(pairs.imag), np.sort(free[alone].real))


# M x'' + C x' + K x = 0, all symmetric, of sparse topology: its eigenvalues and vectors without a large dense matrix.
# Meant are chains, trees, rings, ladders, beams (``elimination``). Coordinates without mass have no x''. The zeros of a small model
# are those of a dense generator, those of a large one are found from those of its two halves (divide and conquer: Bini, Gemignani and
# Tisseur 2005), with all work in vectors over the zeros. A vector is that of inverse iteration, and each zero is found once more from
# it by Newton's step for x^T P(s) x = 0 (Lancaster 1961), every row of P(s) x summed as (sum of its entries) x_i + sum over j of
# P_ij (x_j - x_i): slow motions of a chain keep their digits so.

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
        """The states (x_m, x_m', x_d) of some coordinates, coupled to no other, decoupled."""
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
