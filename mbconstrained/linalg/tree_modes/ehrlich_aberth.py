"""Simultaneous zeros of a real polynomial p, from approximate ones and p'/p, by the method of Ehrlich and Aberth.

Every zero takes Newton's step for p divided by the distances to all others, so that no two go to the same place (Aberth 1973; for
eigenproblems Bini, Gemignani and Tisseur 2005). Zeros off the real axis are kept as pairs; near the axis each one moves on its own,
so that a pair can become two real zeros and two of those a pair.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...ground.tolerances import EPS, STALLED_STEP

#: After so many steps what is not found is given up, after the first number where it is more than a part of all and a few.
MANY_STEPS, STEPS, CORRECTION_PART, FEW = 20, 50, 0.1, 8

#: A zero so near to the real axis, relative to its size, goes without its conjugate; so do all that have not settled after some
#: steps.
NEAR, SLOW = 0.03, 12

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
    """As many zeros as approximate ones; None without convergence.

    >>> cubic = np.polynomial.Polynomial([-6.0, 11.0, -6.0, 1.0])
    >>> zeros_near(lambda s: cubic.deriv()(s) / cubic(s), np.array([0.5, 2.1, 4.0]), 1e-9).real.round(12).tolist()
    [1.0, 2.0, 3.0]
    """
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
        alone = moving[paired[moving] & ((np.abs(s[moving].imag) <= NEAR * np.abs(s[moving])) | (done == SLOW))]
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
