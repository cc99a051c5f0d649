"""The force as a user of a stepping method gives it: a quick formula on each stretch of time on which nothing happens."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ...linalg.blocks import block_slices
from ...signals import BohlFunction, ImpulsiveSmooth
from ...tolerances import EPS

Formula = Callable[[float], np.ndarray]

#: A term t^k e^(a t) turn(w t): k, a, w, and cos or sin.
Term = tuple[int, float, float, Callable[[float], float]]

#: A time and a knot that differ by less than this many roundings of the last time are the same to a solver: it could not
#: make a step from one to the other.
SAME_TIME = 8.0


@dataclass(frozen=True)
class Stretch:
    """A part of the time between two knots of the force.

    Attributes:
        begin, end: in s; equal where there is no time between them but for rounding.
        times: those of the wanted times in it, its begin included, its end in the last one only; one that is its begin or its
            end but for rounding is taken to be that.
        force: f(t) by the formula of this stretch, beyond its end too.
        impulses: the k-th multiplies the k-th derivative of Dirac's delta at its begin, not those at t = 0.
    """

    begin: float
    end: float
    times: np.ndarray
    force: Formula
    impulses: tuple[np.ndarray, ...]

    @property
    def stops(self) -> np.ndarray:
        """The times and the end: where a solver has to give values."""
        return self.times if len(self.times) and self.times[-1] == self.end else np.append(self.times, self.end)


def stretches(force: ImpulsiveSmooth, times: np.ndarray, matrix: np.ndarray) -> Iterator[Stretch]:
    """From t = 0 to the last of the times, with matrix @ f(t) as the force."""
    blows = {blow.time: blow.impulses for blow in force.later}
    function = force.smooth.mapped(matrix).with_knots(force.knots)
    knots, rounding = knots_of(force, times), SAME_TIME * EPS * times[-1]
    for place, (begin, end) in enumerate(zip(knots, np.append(knots[1:], times[-1]))):
        last = times <= end if place + 1 == len(knots) else times < end
        inside = times[(times >= begin) & last]
        inside = np.where(end - inside <= rounding, end, inside)
        inside = np.where(inside - begin <= rounding, begin, inside)
        stop = end if end - begin > rounding else begin
        yield Stretch(float(begin), float(stop), inside, formula(function, place), blows.get(float(begin), ()))


def knots_of(force: ImpulsiveSmooth, times: np.ndarray) -> np.ndarray:
    """Those that matter up to the last of the times, the first is 0."""
    return force.knots[force.knots <= times[-1]]


def formula(function: BohlFunction, piece: int) -> Formula:
    """One piece of a function of time, written out as a sum of vectors times t^k e^(a t) (cos w t, sin w t)."""
    since, states = function.restarts.knots[piece], function.restarts.states[:, piece]
    columns: dict[Term, np.ndarray] = {}
    others: list[BohlFunction] = []
    for block, at in zip(function.blocks, block_slices(function.blocks)):
        found = _terms(block, function.coefficients[:, at], states[at])
        if found is None:
            others.append(BohlFunction(function.coefficients[:, at], (block,), states[at]))
        for term, column in (found or {}).items():
            columns[term] = columns.get(term, 0.0) + column
    columns = {term: column for term, column in columns.items() if column.any()}
    return _sum(columns, others, float(since), function.size)


def _sum(columns: dict[Term, np.ndarray], others: list[BohlFunction], since: float, size: int) -> Formula:
    matrix = np.array(list(columns.values())).T if columns else np.zeros((size, 0))
    terms = list(columns)

    def value(t: float) -> np.ndarray:
        s = t - since
        return matrix @ [s**k * math.exp(a * s) * turn(w * s) for k, a, w, turn in terms]

    if others:
        return lambda t: value(t) + sum(other(max(t - since, 0.0)) for other in others)
    if all((k, a, w) == (0, 0.0, 0.0) for k, a, w, _ in terms):
        constant = matrix.sum(axis=1)
        return lambda t: constant
    return value


def _terms(block: np.ndarray, coefficients: np.ndarray, start: np.ndarray) -> dict[Term, np.ndarray] | None:
    """C e^(block t) v of a chain: block = D + N, D one rate or one turn, N nilpotent; None where it is none."""
    level = 2 if len(block) > 1 and block[1, 0] != 0 else 1
    diagonal = np.kron(np.eye(len(block) // level), block[:level, :level])
    if diagonal.shape != block.shape:
        return None
    nilpotent = block - diagonal
    if np.tril(nilpotent).any() or not np.array_equal(diagonal @ nilpotent, nilpotent @ diagonal):
        return None
    a, w = float(block[0, 0]), float(block[1, 0]) if level == 2 else 0.0
    turned = (diagonal - a * np.eye(len(block))) @ start / w if w else None
    found: dict[Term, np.ndarray] = {}
    for k in range(len(block) // level):
        found[k, a, w, math.cos] = coefficients @ start
        start = nilpotent @ start / (k + 1)
        if turned is not None:
            found[k, a, w, math.sin] = coefficients @ turned
            turned = nilpotent @ turned / (k + 1)
    return found
