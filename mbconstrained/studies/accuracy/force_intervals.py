"""The force for stepping methods: a fast formula on each interval of time between its jumps and impulses."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...ground.tolerances import EPS
from ...linalg.blocks import block_slices
from ...signals.bohl import BohlFunction
from ...signals.impulsive import ImpulsiveSmooth
from ..study_problem import StudyProblem
from .first_order import Reduced, reduced

Formula = Callable[[float], np.ndarray]

#: A term t^k e^(a t) turn(w t): k, a, w, and cos or sin.
Term = tuple[int, float, float, Callable[[float], float]]

#: A time and a knot within this multiple of the rounding error of the last time are equal for a solver, which could not step
#: from one to the other.
SAME_TIME = 8.0


@dataclass(frozen=True, eq=False)
class Interval:
    """An interval of time between two knots of the force.

    Attributes:
        begin, end: in s; equal where they differ by rounding errors only.
        times: the times of the problem in it, with its begin, and with its end in the last one only; a time within rounding
            error of an end is that end.
        force: f(t) by the formula of this interval, also beyond its end.
        impulses: the k-th multiplies the k-th derivative of Dirac's delta at its begin, not those at t = 0.
    """

    begin: float
    end: float
    times: np.ndarray
    force: Formula
    impulses: tuple[np.ndarray, ...]

    @property
    def stops(self) -> np.ndarray:
        """The times and the end: the output times of a solver."""
        return self.times if len(self.times) and self.times[-1] == self.end else np.append(self.times, self.end)


def intervals(force: ImpulsiveSmooth, times: np.ndarray, matrix: np.ndarray) -> tuple[Interval, ...]:
    """The intervals of time from t = 0 to the last of the times."""
    loads = {load.time: load.impulses for load in force.later}
    function = force.smooth.mapped(matrix).with_knots(force.knots)
    knots, rounding, parts = knots_of(force, times), SAME_TIME * EPS * times[-1], []
    for place, (begin, end) in enumerate(zip(knots, np.append(knots[1:], times[-1]))):
        last = times <= end if place + 1 == len(knots) else times < end
        inside = times[(times >= begin) & last]
        inside = np.where(end - inside <= rounding, end, inside)
        inside = np.where(inside - begin <= rounding, begin, inside)
        stop = end if end - begin > rounding else begin
        parts.append(Interval(float(begin), float(stop), inside, _formula(function, place), loads.get(float(begin), ())))
    return tuple(parts)


@lru_cache(maxsize=4)
def intervals_of(problem: StudyProblem) -> tuple[Interval, ...]:
    """The intervals of a problem with B f(t) as the force, excluded from run times."""
    return intervals(problem.force, problem.times, reduced(problem).B)


#: The number of an interval, the interval and z(begin) -> z at its stops, shape (n, T).
Advance = Callable[[int, Interval, np.ndarray], np.ndarray]


def stepped(problem: StudyProblem, equations: Reduced, parts: Sequence[Interval], advance: Advance) -> np.ndarray:
    """The solution at the times of a problem by steps from interval to interval."""
    state, blocks = equations.start, []
    for number, interval in enumerate(parts):
        if interval.impulses:
            state = state + equations.jump(interval.impulses)
        if interval.end > interval.begin:
            states = advance(number, interval, state)
        else:
            states = np.repeat(state[:, None], max(1, len(interval.times)), axis=1)
        blocks.append(states[:, : len(interval.times)])
        state = states[:, -1]
    return equations.coordinates(np.hstack(blocks), problem.times)


def knots_of(force: ImpulsiveSmooth, times: np.ndarray) -> np.ndarray:
    """The knots of a force up to the last of the times; the first is 0."""
    return force.knots[force.knots <= times[-1]]


def jumps_of(function: BohlFunction) -> dict[float, np.ndarray]:
    """Jumps of the values of a function at each of its knots."""
    restarts = function.restarts
    return dict(zip(restarts.knots.tolist(), (function.coefficients @ restarts.jumps).T))


def _formula(function: BohlFunction, piece: int) -> Formula:
    """One piece of a function of time as a sum of vectors times t^k e^(a t) (cos w t, sin w t)."""
    since, states = float(function.restarts.knots[piece]), function.restarts.states[:, piece]
    columns: dict[Term, np.ndarray] = {}
    for block, at in zip(function.blocks, block_slices(function.blocks)):
        terms = _terms(block, function.coefficients[:, at], states[at])
        if terms is None:
            whole = BohlFunction(function.coefficients, function.blocks, states)
            return lambda t: whole(max(t - since, 0.0))
        for term, column in terms.items():
            columns[term] = columns.get(term, 0.0) + column
    columns = {term: column for term, column in columns.items() if column.any()}
    matrix = np.array(list(columns.values())).T if columns else np.zeros((function.size, 0))
    if all(term[:3] == (0, 0.0, 0.0) for term in columns):
        constant = matrix.sum(axis=1)
        return lambda t: constant
    factors = tuple(columns)

    def value(t: float) -> np.ndarray:
        s = t - since
        return matrix @ [s**k * math.exp(a * s) * turn(w * s) for k, a, w, turn in factors]

    return value


def _terms(block: np.ndarray, coefficients: np.ndarray, start: np.ndarray) -> dict[Term, np.ndarray] | None:
    """C e^(block t) v of a chain: block = D + N, D one rate or one rotation, N nilpotent; None for other blocks."""
    level = 2 if len(block) > 1 and block[1, 0] != 0 else 1
    diagonal = np.kron(np.eye(len(block) // level), block[:level, :level])
    if diagonal.shape != block.shape:
        return None
    nilpotent = block - diagonal
    if np.tril(nilpotent).any() or not np.array_equal(diagonal @ nilpotent, nilpotent @ diagonal):
        return None
    a, w = float(block[0, 0]), float(block[1, 0]) if level == 2 else 0.0
    turned = (diagonal - a * np.eye(len(block))) @ start / w if w else None
    terms: dict[Term, np.ndarray] = {}
    for k in range(len(block) // level):
        terms[k, a, w, math.cos] = coefficients @ start
        start = nilpotent @ start / (k + 1)
        if turned is not None:
            terms[k, a, w, math.sin] = coefficients @ turned
            turned = nilpotent @ turned / (k + 1)
    return terms
