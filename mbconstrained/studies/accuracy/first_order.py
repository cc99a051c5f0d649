"""Reduced equations for stepping methods: of first order, with as few states as possible.

    z' = S z + B f(t),    x = C z + sum over j of H_j f^(j),

the states z being coordinates and derivatives of coordinates without the instantaneous response to the force. With a
nonsingular highest coefficient A_q they are x, x', ..., x^(q-1) and S is the companion matrix. Otherwise they are chosen
among the same by pivoted QR: of the finite pair (C, J, B) of A(s), Y = [C; C J; ...; C J^(q-1)], and of n well-conditioned
rows of it S = Y_s J Y_s^-1 (Moysis et al., Theorem 2.8; the H_j are those of the Laurent expansion, Eq. 18).

Stepping methods also get what they cannot compute: the values at 0+ after the jumps and impulses at t = 0, and the jumps of
the states at a later Dirac impulse.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.linalg

from ...polynomial.jordan_pairs import JordanPairs
from ...response.response import Response
from ...signals.bohl import BohlFunction
from ..study_problem import StudyProblem

#: The size of a state is the one in this share of the time: in a growing motion early errors grow too, and tolerances relative
#: to the size at the end would allow early errors as large as the motion.
BEGINNING = 0.1


@dataclass(frozen=True, eq=False)
class Reduced:
    """z' = S z + B f, x = C z + through.

    Attributes:
        S, B, C: shapes (n, n), (n, r), (r, n).
        through: sum of H_j f^(j) for t > 0, a function with r rows.
        start: z(0+), shape (n,).
        sizes: sizes of the states, shape (n,): of all coordinates together as errors are measured, and so of their derivatives.
        places: coordinate and order of derivative of each state.
        response: the closed form, from which start and sizes are.
    """

    S: np.ndarray
    B: np.ndarray
    C: np.ndarray
    through: BohlFunction
    start: np.ndarray
    sizes: np.ndarray
    places: tuple[tuple[int, int], ...]
    response: Response

    @property
    def count(self) -> int:
        """The number n of states."""
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

    >>> from mbconstrained.studies.study_problem import mechanical_problem
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


def refusal_without_states(problem: StudyProblem) -> str:
    """The reason why stepping methods do not apply to a problem without states; else empty."""
    return "" if reduced(problem).count else "there are no states: x depends on the force at the same time only"


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
