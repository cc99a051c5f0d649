"""Reduced equations for stepping methods, of first order with as few states as possible, and their force on each interval of time.

    z' = S z + B f(t),    x = C z + sum over j of H_j f^(j),

the states z being coordinates and derivatives of coordinates without the instantaneous response to the force. With a
nonsingular highest coefficient A_q they are x, x', ..., x^(q-1) and S is the companion matrix. Otherwise they are chosen
among the same by pivoted QR: of the finite pair (C, J, B) of A(s), Y = [C; C J; ...; C J^(q-1)], and of n well-conditioned
rows of it S = Y_s J Y_s^-1 (Moysis et al., Theorem 2.8; the H_j are those of the Laurent expansion, Eq. 18).

Stepping methods also get what they cannot compute: the values at 0+ after the jumps and impulses at t = 0, and the jumps of
the states at a later Dirac impulse.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.linalg

from ...ground.tolerances import EPS
from ...linalg.blocks import block_slices
from ...polynomial.jordan_pairs import JordanPairs
from ...response.response import Response
from ...signals.bohl import BohlFunction
from ...signals.impulsive import ImpulsiveSmooth
from ..study_problem import StudyProblem

#: The size of a state is the one in this share of the time: in a growing motion early errors grow too, and tolerances relative
#: to the size at the end would allow early errors as large as the motion.
BEGINNING = 0.1


@dataclass(frozen=True, eq=False)
class Reduced:
    """z' = S z + B f, x = C z + through."""

    S: np.ndarray  # S, B, C: shapes (n, n), (n, r), (r, n)
    B: np.ndarray
    C: np.ndarray
    through: BohlFunction  # sum of H_j f^(j) for t > 0, a function with r rows
    start: np.ndarray  # z(0+), shape (n,)
    #: sizes of the states, shape (n,): of all coordinates together as errors are measured, and so of their derivatives
    sizes: np.ndarray
    places: tuple[tuple[int, int], ...]  # coordinate and order of derivative of each state
    response: Response  # the closed form, from which start and sizes are

    @property
    def count(self) -> int:
        return len(self.S)

    def jump(self, impulses) -> np.ndarray:
        """The jump of z at impulses sum of c_k delta^(k): sum of S^k B c_k."""
        total, power = np.zeros(self.count), self.B
        for impulse in impulses:
            total, power = total + power @ impulse, self.S @ power
        return total

    def coordinates(self, states: np.ndarray, times: np.ndarray) -> np.ndarray:
        """The solution from the states."""
        x = self.C @ states
        return x if self.through.is_zero else x + self.through(times)


@lru_cache(maxsize=4)
def reduced(problem: StudyProblem) -> Reduced:
    """The reduced equations of a problem, excluded from run times.

    >>> from mbconstrained.analyses.study_problem import mechanical_problem
    >>> from mbconstrained import Constraint, MechanicalSystem
    >>> pair = MechanicalSystem([[1, 0], [0, 3]], stiffness=[[4, 0], [0, 0]], constraints=[Constraint([1, -1])])
    >>> equations = reduced(mechanical_problem("a tied pair", pair, [0.0, 1.0], displacement=[1.0, 1.0]))
    >>> equations.S.round(12), equations.C.round(12)
    (array([[ 0.,  1.],
           [-1.,  0.]]), array([[1., 0.],
           [1., 0.]]))
    """
    response = problem.solve_equations()
    A, pairs = response.polynomial_matrix, response.pairs
    S, B, C, places = (_companion if len(pairs.finite.J) == A.size * A.degree else _minimal)(pairs)
    return Reduced(
        S=S,
        B=B,
        C=C,
        through=_through(pairs, problem.force.smooth, 0),
        start=_start(response, places),
        sizes=sizes_of([response.derivative(order)(problem.times) for order in range(A.degree)], problem.times)[
            [i for _, i in places]
        ],
        places=places,
        response=response,
    )


def sizes_of(values, times) -> np.ndarray:
    """The size of each kind of unknown at the beginning, or later where it is zero there."""
    early = times <= BEGINNING * times[-1]
    largest = (np.abs(own).max(axis=0, initial=0.0) for own in values)
    return np.array([own[early].max(initial=0.0) or own.max(initial=0.0) or 1.0 for own in largest])


def _companion(pairs: JordanPairs):
    """Companion form of A_q x^(q) + ... + A_0 x = f with nonsingular A_q."""
    *lower, highest = pairs.polynomial_matrix.coefficients
    r, q = len(highest), len(lower)
    S, B = np.eye(r * q, k=r), np.zeros((r * q, r))
    if q:
        S[-r:], B[-r:] = -np.linalg.solve(highest, np.hstack(lower)), np.linalg.inv(highest)
    return S, B, np.eye(r, r * q), tuple((k, i) for i in range(q) for k in range(r))


def _minimal(pairs: JordanPairs):
    """Minimal form by selected rows of Y; exactly known rows of S and C are unit vectors."""
    finite, degree = pairs.finite, pairs.polynomial_matrix.degree
    r, n, power = len(finite.C), len(finite.J), finite.C
    stack = [power] + [power := power @ finite.J for _ in range(degree)]
    Y, derivatives = np.vstack(stack[:-1]), np.vstack(stack[1:])
    scaling = finite.form.companion.scaling
    rows = 1 / np.concatenate([scaling.columns * scaling.time**order for order in range(degree)])
    lengths = np.linalg.norm(rows[:, None] * Y, axis=0)
    columns = 1 / np.where(lengths > 0, lengths, 1.0)
    scaled = rows[:, None] * Y * columns
    chosen = np.sort(scipy.linalg.qr(scaled.T, mode="r", pivoting=True)[1][:n])
    inverse = np.linalg.inv(scaled[chosen]) * rows[chosen]
    S, C = derivatives[chosen] * columns @ inverse, finite.C * columns @ inverse
    for state, row in enumerate(chosen):
        if row < r:
            C[row] = np.arange(n) == state
        if row + r in chosen:
            S[state] = chosen == row + r
    places = tuple((int(row % r), int(row // r)) for row in chosen)
    B = np.array([pairs.laurent(-order - 1)[k] for k, order in places]).reshape(n, r)
    return S, B, C, places


def _through(pairs: JordanPairs, force: BohlFunction, order: int) -> BohlFunction:
    """The instantaneous response of x^(order) to f: sum over j of H_(j - order) f^(j), j >= 0."""
    total = force.mapped(pairs.laurent(-order))
    for j in range(1, pairs.form.highest_impulse + order + 1):
        total = total + force.derivative(j).mapped(pairs.laurent(j - order))
    return total


def _start(response: Response, places) -> np.ndarray:
    """The values at 0+ without the instantaneous response to the force."""
    orders = range(response.polynomial_matrix.degree)
    forced = [_through(response.pairs, response.force.smooth, order)(0.0) for order in orders]
    return np.array([response.start[order, k] - forced[order][k] for k, order in places])


Formula = Callable[[float], np.ndarray]

#: A term t^k e^(a t) turn(w t): k, a, w, and cos or sin.
Term = tuple[int, float, float, Callable[[float], float]]

#: A time and a knot within this multiple of the rounding error of the last time are equal for a solver, which could not step
#: from one to the other.
SAME_TIME = 8.0


@dataclass(frozen=True, eq=False)
class Interval:
    """An interval of time between two knots of the force."""

    begin: float  # begin, end: in s; equal where they differ by rounding errors only
    end: float
    #: the times of the problem in it, with its begin, and with its end in the last one only; a time within rounding error of an
    #: end is that end
    times: np.ndarray
    force: Formula  # f(t) by the formula of this interval, also beyond its end
    impulses: tuple[np.ndarray, ...]  # the k-th multiplies the k-th derivative of Dirac's delta at its begin, not those at t = 0

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
