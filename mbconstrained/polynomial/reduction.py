"""A plain A(s) of degree two or less as first-order equations w' = S w + ..., and S decoupled (``polynomial.plain`` finds them).

M x_m'' + C (x_m', x_d') + K (x_m, x_d) = right sides, the states w = (x_m, x_m', x_d). What nothing couples is decoupled each for
itself, and what rows without stiffness conserve apart from all else, so that zeros at s = 0 are exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from ..linalg.blocks import BlockDiagonal, assembled, block_matrix, coupled_rows, zeros_of
from ..linalg.eigen import decoupled
from ..linalg.elimination import are_worth, front_width
from ..linalg.kinds import (
    Matrix,
    below,
    beside,
    entry_count,
    full,
    is_finite,
    kept,
    nothing,
    shifted_unit,
)
from ..linalg.quadratic_modes import quadratic_modes
from ..linalg.scaling import balancing_units
from ..linalg.sparse import divided, is_semidefinite, is_symmetric, without_noise
from ..linalg.structured import StructuredModes
from ..linalg.symmetric import symmetric_modes
from ..tolerances import EPS, noise_of
from .conserved import Conserved, decoupled_beside
from .refinement import refined

#: Modes of so few states as these may be so many times larger than the states that they make, two digits; others go by the pencil.
MOST_AMPLIFIED = 100.0

#: So few states are decoupled at once.
FEW_STATES = 48

#: So many states of a tree are decoupled by way of its graph: fewer are as quickly taken together.
MANY_STATES = 100


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
        conserved: what rows without stiffness keep, and sums of rows; None where there are none.
        sums: v with v K = 0 of these, shape (k, m + d), where they were looked for.
        largest_condition: of the parts that were divided by.

    All matrices are sparse where A(s) is large, for what is built of elements mostly is; those of a small one are full.
    """

    given: list[Matrix]
    algebraic: np.ndarray
    second: np.ndarray
    first: np.ndarray
    chosen: np.ndarray
    V: Matrix
    Y: Matrix
    M: Matrix
    C: Matrix
    K: Matrix
    moving: np.ndarray
    conserved: Conserved | None
    sums: np.ndarray | None
    largest_condition: float

    @property
    def through(self) -> list[Matrix]:
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

    @cached_property
    def output(self) -> Matrix:
        """x from the states w = (x_m, x_m', x_d), shape (r, 2 m + d), without Y g."""
        m = len(self.second)
        return beside(self.V[:, :m], nothing((self.V.shape[0], m), self.V), self.V[:, m:])

    def solved(self, right: Matrix) -> tuple[Matrix, Matrix]:
        """(x_m'', x_d') where M x_m'' + C_md x_d' and C_dd x_d' are these right sides, shape (m + d, any)."""
        m = len(self.second)
        if not len(self.first):
            return self.divided_by_mass(right), right[m:]
        rates, C = divided(self.C[m:, m:], right[m:]), self.C[:m, m:]
        left = without_noise(right[:m] - C @ rates, abs(right[:m]) + abs(C) @ abs(rates))
        return self.divided_by_mass(left), rates

    def divided_by_mass(self, right: Matrix) -> Matrix:
        """M^-1 times a matrix."""
        return divided(self.M, right)

    @cached_property
    def generator(self) -> Matrix:
        """S, shape (2 m + d, 2 m + d)."""
        m, d = len(self.second), len(self.first)
        by_state = -beside(self.K[:, :m], self.C[:, :m], self.K[:, m:])
        with np.errstate(over="ignore", invalid="ignore"):  # ``is_finite`` tells
            accelerations, rates = self.solved(by_state)
        return below(shifted_unit(m, 2 * m + d, m, self.K), accelerations, rates)

    @cached_property
    def units(self) -> np.ndarray:
        """Units of the states in which S is balanced."""
        return balancing_units(self.generator)

    @cached_property
    def is_finite(self) -> bool:
        """Whether S is in the range of float64."""
        return is_finite(self.generator)

    @cached_property
    def spread(self) -> float:
        """The modulus of the fastest zero over that of the slowest, those at 0 left out that rows without stiffness have."""
        known = self.is_small or self.conserved is not None
        moduli = np.abs(self.zeros if known else np.linalg.eigvals(full(self.generator)))
        if self.conserved is not None:
            moduli = moduli[moduli > 0]
        largest = moduli.max(initial=0.0)
        return float(largest / max(moduli.min(initial=largest), EPS * largest)) if largest else 1.0

    @cached_property
    def is_apart(self) -> bool:
        """Whether the decoupled parts of S are what they should be, to a quarter of the digits, and no state is made of huge ones.

        A zero may be well known, and its vector hardly apart from another's: where one of two like parts drives the other.
        """
        parts, S = self.decoupled, full(self.generator)
        if not len(S):
            return True
        units, J = self.units[:, None], block_matrix(parts.blocks)
        off = np.abs(parts.inverse @ parts.basis - np.eye(len(S))).max()
        residual = np.abs(parts.inverse @ (S @ parts.basis) - J).max() / (np.abs(J).max() or 1.0)
        sizes = ((parts.basis / units) ** 2).sum(axis=0) * ((parts.inverse.T * units) ** 2).sum(axis=0)
        return bool(max(off, residual) <= EPS**0.75 and sizes.max() <= MOST_AMPLIFIED**2)

    @cached_property
    def is_driven_apart(self) -> bool:
        """Whether something grows and not all states drive each other: what drives has no part in it, but rounding would give it one."""
        zeros = self.zeros
        if not (zeros.real > noise_of(np.abs(zeros).max(initial=0.0))).any():
            return False
        return connected_components(csr_array(self.generator), connection="strong")[0] > 1

    @property
    def is_free(self) -> bool:
        """Whether a body moves off under a balance of springs: their rounding alone would push it."""
        return self.sums is not None and any(len(block) > 1 for block in self.conserved.blocks)

    @property
    def is_small(self) -> bool:
        """Whether S is decoupled in less time than anything else takes."""
        return self.state_count < FEW_STATES

    @cached_property
    def zeros(self) -> np.ndarray:
        """All of them, of complex pairs the one above the real axis."""
        return zeros_of(self.decoupled.blocks)

    @cached_property
    def is_reciprocal(self) -> bool:
        """Whether M, C and K are symmetric, and no row is without stiffness."""
        return (self.conserved is None or self.sums is not None) and all(is_symmetric(matrix) for matrix in (self.M, self.C, self.K))

    @cached_property
    def is_chain(self) -> bool:
        """Whether it is one of many masses coupled like a chain, a tree, a ring or a ladder (``linalg.quadratic_modes``)."""
        return self.front_width is not None

    @cached_property
    def front_width(self) -> int | None:
        """How wide the elimination of such a model is: 1 for a chain or a tree, 2 for a ring; None for any other."""
        if self.state_count < MANY_STATES or self.conserved is not None or not self.is_reciprocal:
            return None
        width = front_width(self.M, self.C, self.K)
        return width if width is not None and are_worth(width, self.K.shape[0]) else None

    @cached_property
    def is_symmetric(self) -> bool:
        """Whether S can be decoupled by a symmetric eigenproblem: all masses, no damping or one in proportion."""
        if len(self.first) or not self.is_reciprocal:
            return False
        return not entry_count(self.C) or is_symmetric(self.C @ self.divided_by_mass(self.K))

    @cached_property
    def is_dissipative(self) -> bool:
        """Whether no motion can grow: M, K positive definite, C positive semidefinite, all symmetric."""
        m, d = len(self.second), len(self.first)
        M = below(beside(self.M, nothing((m, d), self.M)), nothing((d, m + d), self.M))
        return all(is_symmetric(matrix) and is_semidefinite(matrix) for matrix in (M, self.C, self.K))

    @cached_property
    def decoupled(self) -> BlockDiagonal | StructuredModes:
        """S decoupled, what nothing couples each for itself: a motion that grows in one part is not in the others."""
        if self.conserved is not None and not self.is_symmetric:
            return refined(self, decoupled_beside(full(self.generator), self.conserved, self._decoupled_rest))
        groups, by_couplings = self._groups, self._by_couplings
        parts = assembled(groups, [found or self._decoupled(states) for found, states in zip(by_couplings, groups)])
        return parts if self.is_symmetric or isinstance(parts, StructuredModes) else refined(self, parts)

    @property
    def is_refused(self) -> bool:
        """Whether some part of what is coupled like a chain could not be decoupled by way of its graph."""
        tried = zip(self._by_couplings, self._groups)
        return self.is_chain and any(found is None and len(states) >= MANY_STATES for found, states in tried)

    @cached_property
    def _groups(self) -> list[np.ndarray]:
        return _groups(self.generator)

    @cached_property
    def _by_couplings(self) -> list[StructuredModes | None]:
        """The modes of each part by way of its graph, where that is possible."""
        if self.is_symmetric or not self.is_chain:
            return [None] * len(self._groups)
        return [self._part_by_couplings(states) if len(states) >= MANY_STATES else None for states in self._groups]

    def _part_by_couplings(self, states: np.ndarray) -> StructuredModes | None:
        m = len(self.second)
        own = states[states < m]
        every = np.concatenate([own, states[states >= 2 * m] - m])
        return quadratic_modes(self.M[own][:, own], *(matrix[every][:, every] for matrix in (self.C, self.K)))

    def _decoupled(self, states: np.ndarray) -> BlockDiagonal:
        """Of a part of S: by a symmetric eigenproblem of half the size, where that is possible."""
        m, found = len(self.second), None
        if self.is_symmetric:
            own = states[states < m]
            resting = np.zeros((0, m)) if self.sums is None else self.sums
            resting = resting[resting[:, own].any(axis=1)][:, own]
            found = symmetric_modes(*(csr_array(matrix[own][:, own]) for matrix in (self.M, self.C, self.K)), resting)
        return decoupled(full(self.generator[states][:, states]), self.units[states]) if found is None else found

    def _decoupled_rest(self, rest: np.ndarray, states: np.ndarray | None) -> BlockDiagonal:
        """What is left of S beside what is conserved, group by group; its part on these states where it is one."""
        units = balancing_units(kept(rest)) if states is None else self.units[states]
        groups = coupled_rows(rest)
        if len(groups) == 1:
            return decoupled(rest, units)
        return assembled(groups, [decoupled(rest[at[:, None], at], units[at]) for at in groups])

    def state(self, values: np.ndarray) -> np.ndarray:
        """w from values (q, r) of x, x', ..."""
        m = len(self.second)
        velocities = values[1, self.chosen[:m]] if m else np.zeros(0)
        places = values[0, self.chosen]
        return np.concatenate([places[:m], velocities, places[m:]])


def _groups(S: Matrix) -> list[np.ndarray]:
    """The states in parts that nothing couples to each other."""
    if isinstance(S, np.ndarray):
        return coupled_rows(S)
    count, which = connected_components(S, directed=False)
    return [np.flatnonzero(which == group) for group in range(count)]
