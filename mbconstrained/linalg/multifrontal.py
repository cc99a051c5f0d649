"""Symmetric P(s) = M s^2 + C s + K of few couplings eliminated for many s at once.

Each coordinate is eliminated with the small dense matrix of its front alone, and hands what it changes there on to the first of it
(multifrontal method: Duff and Reid 1983). All operations are on vectors over s, of coordinates that do not touch together. Nothing is
pivoted: where fronts are one coordinate, in a tree, small pivots do no harm, since every rounding is a relative one of an entry of P(s)
(Demmel and Gragg 1993, for acyclic matrices); in wider ones a small pivot costs digits, gained back from what is left of the equations.
"""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import numpy as np

from ..tolerances import EPS
from .elimination import Elimination, Link, Step

#: So many entries of P(s) and of fronts are held at once: they stay near the processor; so many s at least.
FRONTS, LEAST = 1 << 15, 32


class Multifrontal:
    """P(s) by the entries of K, C and M, in an order of elimination."""

    def __init__(self, order: Elimination, diagonal: np.ndarray, beside: np.ndarray, ends: np.ndarray) -> None:
        """Coordinates as they were given.

        Args:
            diagonal: shape (3, N).
            beside: what couples two coordinates, shape (3, E).
            ends: which these are, shape (2, E).
        """
        self.order, self._data = order, (diagonal, beside, ends)

    def newton(self, s: np.ndarray) -> np.ndarray:
        """p'(s) / p(s) where p = det P, shape as s: the sum of d'/d over all pivots d."""
        if len(s) > self._width:
            return np.concatenate([self.newton(part) for part in np.array_split(s, -(-len(s) // self._width))])
        powers, found, waiting = np.stack([np.ones_like(s), s, s * s]), np.zeros_like(s), {}
        for number, (step, coefficients) in enumerate(zip(self.order.steps, self._columns)):
            column = _column(coefficients, powers, step)
            _reduce(column, step.links, waiting)
            pivot, beside = column[:, 0], column[:, 1:]
            inverse = 1 / pivot[0]
            pivot[1] *= inverse
            found += pivot[1].sum(axis=0)
            if len(step.fronts):
                factor = beside[0] * inverse
                pivot[1] *= -0.5
                beside[1] += pivot[1] * beside[0]
                change = factor[:, None] * beside[:, None]
                change[1] += change[1].swapaxes(0, 1)
                waiting[number] = _with_others(change, step.links, waiting)
        return found

    def factored(self, s: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """1 / d and what the fronts take, by steps, shapes (G, S) and (front, G, S): P = (I + L) D (I + L)^T.

        P is wanted near its zeros: a d that is exactly 0, all of it lost to rounding, becomes a rounding of what it was made of
        (inverse iteration: Wilkinson 1965, chapter 5; LAPACK's stein).
        """
        powers, found, waiting = np.stack([np.ones_like(s), s, s * s]), [], {}
        for number, (step, coefficients) in enumerate(zip(self.order.steps, self._columns)):
            column = _column(coefficients[:1], powers, step)
            _reduce(column, step.links, waiting)
            pivot = column[0, 0]
            if not pivot.all():
                pivot += (pivot == 0) * (EPS * (np.abs(coefficients[0, : len(pivot)]) @ np.abs(powers)))
            inverse = 1 / pivot
            factor = column[0, 1:] * inverse
            if len(factor):
                waiting[number] = _with_others((factor[:, None] * column[0, 1:])[None], step.links, waiting)
            found.append((inverse, factor))
        return found

    def solved(self, factors: list[tuple[np.ndarray, np.ndarray]], right: np.ndarray) -> np.ndarray:
        """P(s)^-1 right for each s, shape (N, S), from ``factored``."""
        x, steps = right[self.order.nodes], list(zip(self.order.steps, factors))
        for step, (inverse, factor) in steps:
            own = x[step.own]
            for places, row, column in step.spread:
                x[places] -= factor[row, column] * own[column]
            own *= inverse
        for step, (_, factor) in reversed(steps):
            if len(factor):
                x[step.own] -= (factor * x[step.fronts]).sum(axis=0)
        found = np.empty_like(x)
        found[self.order.nodes] = x
        return found

    @cached_property
    def _width(self) -> int:
        """How many s at once."""
        entries = [(1 + len(step.fronts)) ** 2 * step.fronts.shape[1] for step in self.order.steps]
        return max(LEAST, FRONTS // max(entries))

    @cached_property
    def _columns(self) -> list[np.ndarray]:
        """By steps (1, s, s^2)-coefficients of the columns of P and of P', shape (2, (1 + front) G, 3)."""
        (diagonal, beside, ends), steps, fronts = self._data, self.order.steps, self.order.fronts
        place, begins = np.empty(len(fronts), dtype=int), [0]
        place[self.order.nodes] = np.arange(len(place))
        first, apart = np.empty((2, len(place)), dtype=int)  # where a column begins, and the distance of its entries
        for step in steps:
            count = step.own.stop - step.own.start
            first[step.own], apart[step.own] = np.arange(begins[-1], begins[-1] + count), count
            begins.append(begins[-1] + count * (1 + len(step.fronts)))
        own, other = np.sort(place[ends], axis=0)
        rows = np.array([1 + fronts[one].index(two) for one, two in zip(own.tolist(), other.tolist())], dtype=int)
        K, C, M = found = np.zeros((3, begins[-1]))
        found[:, first], found[:, first[own] + rows * apart[own]] = diagonal[:, self.order.nodes], beside
        both = np.stack([np.stack([K, C, M], axis=1), np.stack([C, 2 * M, 0 * M], axis=1)])
        return [both[:, begin:end] for begin, end in pairwise(begins)]


def _column(coefficients, powers, step: Step) -> np.ndarray:
    """Entries of P(s), and of P'(s), on the diagonal and beside it, shape (_, 1 + front, G, S)."""
    front, count = step.fronts.shape
    return (coefficients @ powers.view(float)).view(powers.dtype).reshape(len(coefficients), 1 + front, count, -1)


def _reduce(column: np.ndarray, links: tuple[Link, ...], waiting: dict[int, np.ndarray]) -> None:
    """Less what the children take from the coordinates, in place."""
    for link in links:
        column[link.first] -= waiting[link.step][:, 0][:, :, link.given]


def _with_others(change: np.ndarray, links: tuple[Link, ...], waiting: dict[int, np.ndarray]) -> np.ndarray:
    """What the coordinates and, still, their children take from the fronts, shape (_, front, front, G, S)."""
    for link in links:
        if link.others is not None:
            change[link.others] += waiting[link.step][:, 1:, 1:, link.given]
        if link.is_last:
            del waiting[link.step]
    return change
