"""The equations that one would find by hand for a stepping method: first order, as few states as there can be.

    z' = S z + B f(t),    x = C z + sum over j of H_j f^(j),

the states z being coordinates and derivatives of coordinates, without what the force does to them at once. With a
nonsingular highest coefficient A_q they are x, x', ..., x^(q-1) and S is the companion matrix. Otherwise they are chosen
among the same by pivoted QR: of the finite pair (C, J, B) of A(s), Y = [C; C J; ...; C J^(q-1)], and of n well-conditioned
rows of it S = Y_s J Y_s^-1 (Moysis et al., Theorem 2.8; the H_j are those of the Laurent expansion, Eq. 18).

What no stepping method finds is handed over: the values at 0+ after the jumps and impulses at t = 0, and by how much the
states jump when a later Dirac impulse strikes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import TypeVar
from weakref import finalize

import numpy as np
import scipy.linalg

from ...jordan import JordanPairs
from ...linalg.noise import Noisy
from ...response import Response
from ...signals import BohlFunction
from ..problem import Problem

Found = TypeVar("Found")

#: The size of a state is the one that it reaches in this part of the time. In a motion that grows, an error made at the
#: beginning grows with it: a size taken at the end would let that error be as large as the motion is at the beginning.
BEGINNING = 0.1

#: Why a method that steps states does not apply.
NO_STATES = "there are no states to step: x follows from the force at every moment"


def once_for_each(find: Callable[[Problem], Found]) -> Callable[[Problem], Found]:
    """What is found for a problem is kept as long as the problem itself: work done by hand, in nobody's time.

    A problem holds arrays and has no hash, so it is known by its id, which is free again only when it is gone.
    """
    known: dict[int, Found] = {}

    @wraps(find)
    def found(problem: Problem) -> Found:
        if id(problem) not in known:
            known[id(problem)] = find(problem)
            finalize(problem, known.pop, id(problem), None)
        return known[id(problem)]

    return found


@dataclass(frozen=True)
class Place:
    """Which state it is: the derivative of this order of one coordinate."""

    coordinate: int
    order: int


@dataclass(frozen=True)
class Reduced:
    """z' = S z + B f, x = C z + through.

    Attributes:
        S, B, C: shapes (n, n), (n, r), (r, n).
        through: sum of H_j f^(j) for t > 0, a function with r rows.
        start: z(0+), shape (n,).
        sizes: of the states, shape (n,): of all coordinates together as errors are measured, and so of their derivatives.
        places: which derivative of which coordinate each state is.
        response: the closed form that the start and the sizes are from.
    """

    S: np.ndarray
    B: np.ndarray
    C: np.ndarray
    through: BohlFunction
    start: np.ndarray
    sizes: np.ndarray
    places: tuple[Place, ...]
    response: Response

    @property
    def count(self) -> int:
        """The number n of states."""
        return len(self.S)

    def kick(self, impulses) -> np.ndarray:
        """By how much z jumps where sum of c_k delta^(k) strikes: sum of S^k B c_k."""
        total, power = np.zeros(self.count), self.B
        for impulse in impulses:
            total, power = total + power @ impulse, self.S @ power
        return total

    def coordinates(self, states: np.ndarray, times: np.ndarray) -> np.ndarray:
        """x, shape (r, T), from z, shape (n, T)."""
        x = self.C @ states
        return x if self.through.is_zero else x + self.through(times)


@once_for_each
def reduced(problem: Problem) -> Reduced:
    """The reduced equations of a problem.

    Raises:
        MbconstrainedError: the problem has no answer.

    >>> from mbconstrained.reports.problem import mechanical_problem
    >>> from mbconstrained.mechanics import Constraint, MechanicalSystem
    >>> pair = MechanicalSystem([[1, 0], [0, 3]], stiffness=[[4, 0], [0, 0]], constraints=[Constraint([1, -1])])
    >>> found = reduced(mechanical_problem("a tied pair", pair, [0.0, 1.0], displacement=[1.0, 1.0]))
    >>> found.S.round(12), found.C.round(12)
    (array([[ 0.,  1.],
           [-1.,  0.]]), array([[1., 0.],
           [1., 0.]]))
    """
    response = problem.solve_equations()
    A, pairs = response.polynomial_matrix, response.pairs
    S, B, C, places = (_companion if len(pairs.finite.J) == A.size * A.degree else _minimal)(pairs)
    sizes = _sizes(response, problem.times, A.degree)
    return Reduced(
        S=S,
        B=B,
        C=C,
        through=_through(pairs, problem.force.smooth, 0),
        start=_start(response, places),
        sizes=np.array([sizes[place.order] for place in places]),
        places=places,
        response=response,
    )


def _companion(pairs: JordanPairs):
    """Of A_q x^(q) + ... + A_0 x = f with A_q nonsingular."""
    *lower, highest = pairs.polynomial_matrix.coefficients
    r, q = len(highest), len(lower)
    S = np.eye(r * q, k=r)
    B = np.zeros((r * q, r))
    if q:
        S[-r:] = -np.linalg.solve(highest, np.hstack(lower))
        B[-r:] = np.linalg.inv(highest)
    return S, B, np.eye(r, r * q), tuple(Place(k, i) for i in range(q) for k in range(r))


def _minimal(pairs: JordanPairs):
    """In chosen rows of Y; a row whose derivative is chosen too is known exactly, as is what does not rise above its noise."""
    finite, degree = pairs.finite, pairs.polynomial_matrix.degree
    r, n, power = len(finite.C), len(finite.J), finite.C
    stack = [power] + [power := power @ finite.J for _ in range(degree)]
    Y, derivatives = np.vstack(stack[:-1]), np.vstack(stack[1:])
    scaling = finite.form.companion.scaling
    rows = 1 / np.concatenate([scaling.columns * scaling.time**order for order in range(degree)])
    columns = 1 / _size_of_columns(rows[:, None] * Y)
    scaled = rows[:, None] * Y * columns
    chosen = np.sort(scipy.linalg.qr(scaled.T, mode="r", pivoting=True)[1][:n])
    inverse = np.linalg.inv(scaled[chosen]) * rows[chosen]
    S, C = (_product(matrix * columns, inverse) for matrix in (derivatives[chosen], finite.C))
    for state, row in enumerate(chosen):
        if row < r:
            C[row] = np.arange(n) == state
        if row + r in chosen:
            S[state] = chosen == row + r
    places = tuple(Place(int(row % r), int(row // r)) for row in chosen)
    B = np.array([pairs.laurent(-place.order - 1)[place.coordinate] for place in places]).reshape(n, r)
    return S, B, C, places


def _size_of_columns(matrix: np.ndarray) -> np.ndarray:
    size = np.linalg.norm(matrix, axis=0)
    return np.where(size > 0, size, 1.0)


def _product(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    return (Noisy.rounded(one) @ Noisy.rounded(two)).cleaned()


def _through(pairs: JordanPairs, force: BohlFunction, order: int) -> BohlFunction:
    """What reaches x^(order) from f and its derivatives at once: sum over j of H_(j - order) f^(j), j >= 0."""
    total = force.mapped(pairs.laurent(-order))
    for j in range(1, pairs.form.highest_impulse + order + 1):
        total = total + force.derivative(j).mapped(pairs.laurent(j - order))
    return total


def _start(response: Response, places) -> np.ndarray:
    """Of the values at 0+ what the force does not bring about at once."""
    orders = {place.order for place in places}
    forced = {order: _through(response.pairs, response.force.smooth, order)(0.0) for order in orders}
    start = response.start
    return np.array([start[place.order, place.coordinate] - forced[place.order][place.coordinate] for place in places])


def _sizes(response: Response, times, degree: int) -> list[float]:
    """Of each derivative, the largest value of any coordinate; later ones where there is none at the beginning."""
    found = []
    for order in range(degree):
        values = np.abs(response.derivative(order)(times)).max(axis=0)
        early = values[times <= BEGINNING * times[-1]].max(initial=0.0)
        found.append(float(early or values.max(initial=0.0) or 1.0))
    return found
