"""A(s) of degree two or less brought to first-order equations w' = S w + ... by its structure alone, no pencil formed.

Rows without a power of s hold coordinates to others: x = V x_f + Y g, g their right sides (a constraint at position level, a
massless joint without damper). Of the rest, rows with s^2 make accelerations of as many coordinates x_m, those without make
velocities of the others, x_d; the states are w = (x_m, x_m', x_d). Which row is of which kind is read off entries that are
exactly zero, and each part that is divided by must be well conditioned: where that does not hold, the staircase algorithm
(``linalg.staircase``) is the one to ask. For large models this takes milliseconds where that takes minutes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, min_weight_full_bipartite_matching

from ..linalg.blocks import BlockDiagonal, assembled
from ..linalg.eigen import decoupled
from ..linalg.scaling import equilibration
from ..linalg.sparse import condition, is_semidefinite, is_symmetric, solved, without_noise
from ..linalg.symmetric import symmetric_modes
from ..tolerances import EPS
from .matrix import PolynomialMatrix
from .refinement import refined

#: What is divided by may be conditioned so badly, its rows and columns brought to one size: it costs as many digits at most.
MOST_CONDITION = 1e4

#: The stiffness may be conditioned so badly: beyond, a body may be free, which is for the rank decisions to say.
MOST_STIFFNESS_CONDITION = 1e10


@dataclass(frozen=True)
class Reduction:
    """The equations of a plain A(s): second-order ones of x_m, first-order ones of x_d, x = V (x_m, x_d) + Y g.

    Attributes:
        given: A_0, A_1, A_2.
        algebraic, second, first: which rows of A(s) are of which kind.
        chosen: which coordinates of x are x_m and x_d, in this order.
        V: shape (r, m + d); x from x_m and x_d.
        Y: shape (r, k); x from the right sides of the algebraic rows.
        M: shape (m, m), what multiplies x_m''.
        C, K: the coefficients of s and of 1 in all remaining rows, the second-order ones first, shape (m + d, m + d).
        moving: which coordinates have mass or damping.
        largest_condition: of the parts that were divided by.

    All matrices are sparse: what is built of elements mostly is.
    """

    given: list[csr_array]
    algebraic: np.ndarray
    second: np.ndarray
    first: np.ndarray
    chosen: np.ndarray
    V: csr_array
    Y: csr_array
    M: csr_array
    C: csr_array
    K: csr_array
    moving: np.ndarray
    largest_condition: float

    @property
    def through(self) -> list[csr_array]:
        """Coefficients (A_0 Y, A_1 Y, A_2 Y) of g and its derivatives in the remaining rows, each of shape (m + d, k)."""
        rest = np.concatenate([self.second, self.first])
        return [matrix[rest] @ self.Y for matrix in self.given]

    @property
    def held(self) -> np.ndarray:
        """Which algebraic rows hold coordinates that have mass or damping: their values at 0- have to obey them."""
        return np.asarray(abs(self.Y[self.moving]).sum(axis=0)) > 0

    @property
    def state_count(self) -> int:
        """2 m + d."""
        return 2 * len(self.second) + len(self.first)

    @property
    def output(self) -> csr_array:
        """x from the states w = (x_m, x_m', x_d), shape (r, 2 m + d), without Y g."""
        m = len(self.second)
        return scipy.sparse.hstack([self.V[:, :m], csr_array((self.V.shape[0], m)), self.V[:, m:]], format="csr")

    def solved(self, right: csr_array) -> tuple[csr_array, csr_array]:
        """(x_m'', x_d') where M x_m'' + C_md x_d' and C_dd x_d' are these right sides, shape (m + d, any)."""
        m = len(self.second)
        if not len(self.first):
            return self.divided_by_mass(right), right[m:]
        rates, C = solved(self.C[m:, m:], right[m:]), self.C[:m, m:]
        left = without_noise(right[:m] - C @ rates, abs(right[:m]) + abs(C) @ abs(rates))
        return self.divided_by_mass(left), rates

    def divided_by_mass(self, right: csr_array) -> csr_array:
        """M^-1 times a matrix."""
        return solved(self.M, right)

    @cached_property
    def generator(self) -> csr_array:
        """S, shape (2 m + d, 2 m + d)."""
        m, d = len(self.second), len(self.first)
        by_state = -scipy.sparse.hstack([self.K[:, :m], self.C[:, :m], self.K[:, m:]], format="csr")
        accelerations, rates = self.solved(by_state)
        velocities = scipy.sparse.eye_array(m, 2 * m + d, k=m)
        return scipy.sparse.vstack([velocities, accelerations, rates], format="csr")

    @cached_property
    def is_finite(self) -> bool:
        """Whether S is in the range of float64."""
        with np.errstate(over="ignore", invalid="ignore"):
            return bool(np.isfinite(self.generator.data).all())

    @cached_property
    def spread(self) -> float:
        """The modulus of the fastest zero over that of the slowest."""
        moduli = np.abs(np.linalg.eigvals(self.generator.toarray()))
        return float(moduli.max() / max(moduli.min(), EPS * moduli.max()))

    @cached_property
    def is_symmetric(self) -> bool:
        """Whether S can be decoupled by a symmetric eigenproblem: all masses, no damping or one in proportion."""
        if len(self.first) or not all(is_symmetric(matrix) for matrix in (self.M, self.C, self.K)):
            return False
        return not self.C.nnz or is_symmetric(self.C @ self.divided_by_mass(self.K))

    @cached_property
    def is_dissipative(self) -> bool:
        """Whether no motion can grow: M, K positive definite, C positive semidefinite, all symmetric."""
        M = self.M.copy()
        M.resize(self.K.shape)
        return all(is_symmetric(matrix) and is_semidefinite(matrix) for matrix in (M, self.C, self.K))

    @cached_property
    def decoupled(self) -> BlockDiagonal:
        """S decoupled, what nothing couples each for itself: a motion that grows in one part is not in the others."""
        count, which = connected_components(self.generator, directed=False)
        groups = [np.flatnonzero(which == group) for group in range(count)]
        parts = assembled(groups, [self._decoupled(states) for states in groups])
        return parts if self.is_symmetric else refined(self, parts)

    def _decoupled(self, states: np.ndarray) -> BlockDiagonal:
        """Of a part of S: by a symmetric eigenproblem of half the size where that is possible."""
        own, found = states[states < len(self.second)], None
        if self.is_symmetric:
            found = symmetric_modes(*(matrix[own][:, own] for matrix in (self.M, self.C, self.K)))
        return decoupled(self.generator[states][:, states].toarray()) if found is None else found

    def state(self, values: np.ndarray) -> np.ndarray:
        """w from values (q, r) of x, x', ..."""
        masses, firsts = np.split(self.chosen, [len(self.second)])
        velocities = values[1, masses] if len(masses) else np.zeros(0)
        return np.concatenate([values[0, masses], velocities, values[0, firsts]])


def reduction_of(A: PolynomialMatrix) -> Reduction | None:
    """The reduction of A(s), None where its structure is not so plain or a part that has to be regular is not by far."""
    if not 1 <= A.degree <= 2 or A.uncertainty.any() or any(factors is not None for factors in A.factors):
        return None
    A0, A1, A2 = given = [csr_array(matrix) for matrix in A.coefficients] + [csr_array((A.size, A.size))] * (2 - A.degree)
    slow, heavy = ((np.diff(matrix.indptr) > 0) for matrix in (A1, A2))
    algebraic, second, first = (np.flatnonzero(kind) for kind in (~slow & ~heavy, heavy, slow & ~heavy))
    moving = np.zeros(A.size, dtype=bool)
    moving[np.concatenate([A1.indices, A2.indices])] = True
    found = _eliminated(A.coefficients[0][algebraic], static=~moving)
    if found is None or len(second) + len(first) != found[0].shape[1]:
        return None
    V, Y, free, eliminated = found
    m, columns = len(second), np.diff(_product(A2[second], V).tocsc().indptr) > 0
    if columns.sum() != m:
        return None
    order = np.argsort(~columns, kind="stable")  # coordinates with mass first
    V, free = V[:, order], free[order]
    matching = _matching_rows(_product(A2[second], V)[:, :m])
    if matching is None:
        return None
    second = second[matching]
    rest = np.concatenate([second, first])
    K, C, M = _product(A0[rest], V), _product(A1[rest], V), _product(A2[second], V)[:, :m]
    largest = max(eliminated, condition(M), condition(C[m:, m:]) if len(first) else 1.0)
    if largest > MOST_CONDITION or condition(K) > MOST_STIFFNESS_CONDITION:
        return None
    return Reduction(given, algebraic, second, first, free, V, Y, M, C, K, moving, largest)


def _eliminated(rows: np.ndarray, static: np.ndarray) -> tuple[csr_array, csr_array, np.ndarray, float] | None:
    """V, Y with x = V x_f + Y g where rows x = g, which coordinates x_f are, and the condition of the others' part."""
    size = len(static)
    if not len(rows):
        return scipy.sparse.eye_array(size, format="csr"), csr_array((size, 0)), np.arange(size), 1.0
    pivots = _pivots(rows, static)
    own = np.inf if pivots is None else condition(rows[:, pivots])
    if own > MOST_CONDITION:
        return None
    free = np.setdiff1d(np.arange(size), pivots)
    solved = np.linalg.solve(rows[:, pivots], np.hstack([rows[:, free], np.eye(len(rows))]))
    V, Y = np.zeros((size, len(free))), np.zeros((size, len(rows)))
    V[free, range(len(free))], V[pivots], Y[pivots] = 1.0, -solved[:, : len(free)], solved[:, len(free) :]
    return csr_array(V), csr_array(Y), free, own


def _product(left: csr_array, V: csr_array) -> csr_array:
    """left @ V; what is rounding of its terms exactly zero: a mass, damper or spring that is not there."""
    found = csr_array(left @ V)
    return without_noise(found, abs(left) @ abs(V)) if V.nnz > V.shape[1] else found


def _matching_rows(M: csr_array) -> np.ndarray | None:
    """An order of rows that brings the large entries to the diagonal: equations may be named after other coordinates."""
    if is_symmetric(M):
        return np.arange(M.shape[0])
    weights = abs(M)
    weights.data = 1 + np.log(weights.data.max(initial=1.0) / weights.data)
    try:
        rows, columns = min_weight_full_bipartite_matching(weights)
    except ValueError:  # no matching: it is singular
        return None
    return rows[np.argsort(columns)]


def _pivots(rows: np.ndarray, static: np.ndarray) -> np.ndarray | None:
    """A pivot column for each row by elimination, static coordinates before others; None where rows depend on each other."""
    work, found = rows, []
    if len(work):
        work = work * equilibration(np.abs(work))[1]
    for at, row in enumerate(work):
        size = np.abs(row)
        still = np.where(static, size, 0.0)
        pivot = int((still if still.max() * MOST_CONDITION > size.max() else size).argmax())
        if not row[pivot]:
            return None
        found.append(pivot)
        below = at + 1 + np.flatnonzero(work[at + 1 :, pivot])
        if below.size:
            work[below] -= np.multiply.outer(work[below, pivot] / row[pivot], row)
            work[below, pivot] = 0.0
    return np.array(found, dtype=int)
