"""Exponentials of matrices in balls: x' = A x + B u from sample to sample under a hold of the inputs and delays.

Between samples the input is v + m s, s the time since the sample. The exponential of [[A, B, 0], [0, 0, I], [0, 0, 0]] t has
Phi(t) = e^(A t), Gamma_1 = integral of Phi(t - s) B ds and Gamma_2 = integral of Phi(t - s) B s ds in its first row (Van Loan 1978).
An input that is late by m steps and a part rho of a step switches within the step: the state passes through two such pieces.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Literal, TypeAlias

import flint
import numpy as np
import scipy

from ...ground.notices import Notice
from ..rational import rational, rational_matrix, working_precision

Hold: TypeAlias = Literal[0, 1, "impulse"]

#: Bits of the exponentials, and the size up to which they are computed so; larger ones in float64.
BITS, LARGEST_BALLS = 320, 120

#: A delay that is a multiple of the step to this part of a step is one.
SAME_SAMPLE = Fraction(1, 2**44)


@dataclass(frozen=True, eq=False)
class DiscretizedSystem:
    """x_(k+1) = A x_k + B u_k, y_k = C x_k + D u_k, rounded to float64; the first states are those given, less a multiple of u."""

    # the matrices
    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    start_map: np.ndarray  # the first states that belong to the states x(0-) of the continuous system, shape (n, N)
    start_input: np.ndarray  # what u_0 adds to the first states, shape (N, p)
    delayed: tuple[tuple[int, int], ...]  # of each added state the number of its input, and how many samples before
    notices: tuple[Notice, ...] = ()


#: Phi, Gamma_1 and Gamma_2.
Exponentials: TypeAlias = tuple[flint.arb_mat, flint.arb_mat, flint.arb_mat]


@dataclass(frozen=True)
class _Continuous:
    """A, B, C, D in balls."""

    A: flint.arb_mat
    B: flint.arb_mat
    C: flint.arb_mat
    D: flint.arb_mat

    def exponentials(self, time: Fraction) -> Exponentials:
        """Phi, Gamma_1 and Gamma_2 after a time."""
        n, p = self.A.nrows(), self.B.ncols()
        size = n + 2 * p
        t = _ball(time)
        table = [[flint.arb(0)] * size for _ in range(size)]
        for i, (own, driven) in enumerate(zip(self.A.tolist(), self.B.tolist() if p else [[]] * n)):
            table[i][: n + p] = [entry * t for entry in (*own, *driven)]
        for j in range(p):
            table[n + j][n + p + j] = t
        if n > LARGEST_BALLS:
            result = scipy.linalg.expm(np.array([[float(entry.mid()) for entry in row] for row in table]))
            rows = [[flint.arb(entry) for entry in row] for row in result[:n].tolist()]
        else:
            rows = flint.arb_mat(table).exp().tolist()[:n] if size else []
        ends = ((0, n), (n, n + p), (n + p, size))
        Phi, G1, G2 = (flint.arb_mat(n, end - begin, [v for row in rows for v in row[begin:end]]) for begin, end in ends)
        return Phi, G1, G2


def discretized(
    A, B, C, D, slopes, delays: Sequence[Fraction], step: Fraction, hold: Hold, descriptor: np.ndarray | None = None
) -> DiscretizedSystem:
    """E x' = A x + B u, y = C x + D u + slopes u' (the u' before the sample, of a linear hold alone), E regular, rounded once."""
    with working_precision(BITS):
        system = _Continuous(*_in_balls(A, B, descriptor), *map(_balls, (C, D)))
        slopes = _balls(slopes) * (1 / _ball(step))
        exponentials = cache(system.exponentials)
        Phi, *_ = exponentials(step)
        columns, memories, counts = [], [], []
        for j, delay in enumerate(delays):
            count, rho = divmod(delay, step)
            if min(rho, step - rho) < step * SAME_SAMPLE:
                count, rho = round(delay / step), Fraction(0)
            before, now, after, direct_before, direct_now = _pieces(system, exponentials, j, rho, step, hold)
            direct_before, direct_now = direct_before - _column(slopes, j), direct_now + _column(slopes, j)
            columns.append([_floats(m) for m in (before, Phi * after + now, after, direct_before, system.C * after + direct_now)])
            memories.append(bool(columns[-1][0].any() or columns[-1][3].any()))
            counts.append(int(count))
        return _joined(_floats(Phi), _floats(system.C), columns, memories, counts)


def _in_balls(A, B, descriptor) -> tuple[flint.arb_mat, flint.arb_mat]:
    """E^-1 A and E^-1 B, exactly before they become balls."""
    if descriptor is None:
        return _balls(A), _balls(B)
    n, p = B.shape
    solution = rational_matrix(descriptor).solve(rational_matrix(np.hstack([A, B])))
    states, inputs = (
        flint.arb_mat(n, end - begin, [flint.arb(solution[i, j]) for i in range(n) for j in range(begin, end)])
        for begin, end in ((0, n), (n, n + p))
    )
    return states, inputs


def _pieces(
    system: _Continuous, exponentials: Callable[[Fraction], Exponentials], j: int, rho: Fraction, step: Fraction, hold: Hold
) -> tuple[flint.arb_mat, ...]:
    """The factors of u_(k-1), u_k and u_(k+1) in x_(k+1), then of u_(k-1) and u_k in y_k, of the input j late by rho."""
    share, h, B, D = _ball(rho / step), _ball(step), _column(system.B, j), _column(system.D, j)
    nothing, none = flint.arb_mat(B.nrows(), 1), flint.arb_mat(D.nrows(), 1)
    (Phi, *late), (_, *early) = exponentials(step - rho), exponentials(rho)
    G1, G2, F1, F2 = (_column(matrix, j) for matrix in (*late, *early))
    if hold == 0:
        return Phi * F1, G1, nothing, D if rho else none, none if rho else D
    if hold == 1:
        first, second = F1 * share - F2 * (1 / h), F1 * (1 - share) + F2 * (1 / h)
        return Phi * first, G1 - G2 * (1 / h) + Phi * second, G2 * (1 / h), D * share, D * (1 - share)
    return nothing, Phi * B, nothing, none, none if rho else system.C * B


def _joined(Phi, C, columns, memories: Sequence[bool], counts: Sequence[int]) -> DiscretizedSystem:
    """All inputs together, with chains of delays and the states u_(k-1)."""
    (q, n), p = C.shape, len(columns)
    N = n + sum(counts) + sum(memories)
    A, B, outputs, D, start_input = np.zeros((N, N)), np.zeros((N, p)), np.zeros((q, N)), np.zeros((q, p)), np.zeros((N, p))
    A[:n, :n], outputs[:, :n] = Phi, C
    delayed = []
    for j, ((before, now, after, direct_before, direct_now), memory, count) in enumerate(zip(columns, memories, counts)):
        place = n + len(delayed)
        delayed += [(j, i + 1) for i in range(count + memory)]
        if count:
            B[place, j] = 1.0
            A[range(place + 1, place + count), range(place, place + count - 1)] = 1.0
        else:
            start_input[:n, j] = -after[:, 0]
        into, through, at = (A, outputs, place + count - 1) if count else (B, D, j)  # the end of the chain drives the states
        into[:n, at], through[:, at] = now[:, 0], direct_now[:, 0]
        if memory:
            into[place + count, at] = 1.0
            A[:n, place + count], outputs[:, place + count] = before[:, 0], direct_before[:, 0]
    return DiscretizedSystem(A, B, outputs, D, np.eye(n), start_input, tuple(delayed))


def _column(matrix: flint.arb_mat, j: int) -> flint.arb_mat:
    return flint.arb_mat(matrix.nrows(), 1, [matrix[i, j] for i in range(matrix.nrows())])


def _ball(number: Fraction) -> flint.arb:
    return flint.arb(rational(number))


def _balls(matrix: np.ndarray) -> flint.arb_mat:
    rows, columns = matrix.shape
    return flint.arb_mat(rows, columns, [flint.arb(value) for value in matrix.ravel().tolist()])


def _floats(matrix: flint.arb_mat) -> np.ndarray:
    values = [0.0 if entry.contains(0) else float(entry.mid()) for entry in matrix.entries()]
    return np.array(values).reshape(matrix.nrows(), matrix.ncols())
