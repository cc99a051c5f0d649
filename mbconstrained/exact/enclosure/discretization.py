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


def discretized(
    A, B, C, D, slopes, delays: Sequence[Fraction], step: Fraction, hold: Hold, descriptor: np.ndarray | None = None
) -> DiscretizedSystem:
    """E x' = A x + B u, y = C x + D u + slopes u' (the u' before the sample, of a linear hold alone), E regular, rounded once."""
    (n, p), given = B.shape, np.hstack([A, B])
    with working_precision(BITS):
        if descriptor is not None:  # E^-1 A and E^-1 B, exactly before they become balls
            given = np.array(rational_matrix(descriptor).solve(rational_matrix(given)).tolist(), dtype=object).reshape(n, n + p)
        generator = np.zeros((n + 2 * p, n + 2 * p), dtype=object)
        generator[:n, : n + p], generator[n : n + p, n + p :] = _balls(given), np.eye(p, dtype=int)
        B, C, D, slopes = generator[:n, n : n + p], _balls(C), _balls(D), _balls(slopes) * (1 / _ball(step))

        @cache
        def exponentials(time: Fraction) -> list[np.ndarray]:
            """Phi, Gamma_1 and Gamma_2 after a time."""
            moved = generator * _ball(time)
            if n > LARGEST_BALLS:
                moved = scipy.linalg.expm(moved.astype(float))
            elif len(moved):
                moved = np.array(flint.arb_mat(moved.tolist()).exp().tolist(), dtype=object)
            return np.split(_balls(moved[:n]), [n, n + p], axis=1)

        Phi, *_ = exponentials(step)
        columns, memories, counts = [], [], []
        for j, delay in enumerate(delays):
            count, rho = divmod(delay, step)
            if min(rho, step - rho) < step * SAME_SAMPLE:
                count, rho = round(delay / step), Fraction(0)
            own = B[:, [j]], C, D[:, [j]]
            before, now, after, direct_before, direct_now = _pieces(own, exponentials, j, rho, step, hold)
            direct_before, direct_now = direct_before - slopes[:, [j]], direct_now + slopes[:, [j]]
            parts = before, _product(Phi, after) + now, after, direct_before, _product(C, after) + direct_now
            columns.append([_floats(part) for part in parts])
            memories.append(bool(columns[-1][0].any() or columns[-1][3].any()))
            counts.append(int(count))
        return _joined(_floats(Phi), _floats(C), columns, memories, counts)


def _pieces(own, exponentials: Callable[[Fraction], list[np.ndarray]], j: int, rho: Fraction, step: Fraction, hold: Hold) -> tuple:
    """The factors of u_(k-1), u_k and u_(k+1) in x_(k+1), then of u_(k-1) and u_k in y_k, of the input j late by rho."""
    share, h, (B, C, D) = _ball(rho / step), _ball(step), own
    nothing, none = 0 * B, 0 * D
    (Phi, *late), (_, *early) = exponentials(step - rho), exponentials(rho)
    G1, G2, F1, F2 = (matrix[:, [j]] for matrix in (*late, *early))
    if hold == 0:
        return _product(Phi, F1), G1, nothing, D if rho else none, none if rho else D
    if hold == 1:
        first, second = F1 * share - F2 * (1 / h), F1 * (1 - share) + F2 * (1 / h)
        through = G1 - G2 * (1 / h) + _product(Phi, second)
        return _product(Phi, first), through, G2 * (1 / h), D * share, D * (1 - share)
    return nothing, _product(Phi, B), nothing, none, none if rho else _product(C, B)


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


def _ball(number: Fraction) -> flint.arb:
    return flint.arb(rational(number))


_balls = np.vectorize(flint.arb, [object])


def _product(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The product of matrices of balls."""
    if not one.size:
        return _balls(np.zeros((len(one), other.shape[1])))
    return np.array((flint.arb_mat(one.tolist()) * flint.arb_mat(other.tolist())).tolist(), dtype=object)


_floats = np.vectorize(lambda entry: 0.0 if entry.contains(0) else float(entry.mid()), [float])
