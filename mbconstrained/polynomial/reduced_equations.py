"""A directly reducible A(s) as first-order equations w' = S w + ..., and S decoupled; ``polynomial.direct_reduction`` creates them.

M x_m'' + C (x_m', x_d') + K (x_m, x_d) = right sides, the states w = (x_m, x_m', x_d). What nothing couples is decoupled each for
itself, and what rows without stiffness conserve separately from all else, so that zeros at s = 0 are exact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from ..ground.tolerances import (
    DOUBTFUL_SUM,
    EPS,
    REDUCED_AMPLIFICATION,
    ROUNDED_FREE,
    ROUNDING_SUPPORT,
    SIMILAR_EIGENVALUES,
    noise_of,
)
from ..linalg.accurate_products import accurately_solved, exact_row_sums
from ..linalg.arrays import (
    Matrix,
    entries,
    entry_count,
    full,
    hstack,
    is_finite,
    kept,
    of_like_kind,
    shifted_unit,
    vstack,
    zeros_of_kind,
)
from ..linalg.blocks import BlockDiagonal, assembled, block_matrix, block_slices, coupled_rows, zeros_of
from ..linalg.division import is_semidefinite, is_symmetric, solved, without_noise
from ..linalg.eigen import decoupled, is_weakly_coupled
from ..linalg.scaling import balancing_units
from ..linalg.symmetric.symmetric_modes import SymmetricModes, may_be_wide, modes_of_wide_spread, symmetric_modes
from ..linalg.tree_modes.residue_modes import ResidueModes
from ..linalg.tree_modes.topology import SparseTopology, sparse_topology
from .conserved import Conserved, Freed, decoupled_with_conserved

#: Number of states decoupled at once without further structure.
FEW_STATES = 48

#: From this number of states on, a tree is decoupled by its topology: with fewer LAPACK is as fast.
MANY_STATES = 100


class NotReducible(Exception):
    """The violated condition of direct reduction or of a solution by it, as a clause, "the force contains ..."."""


@dataclass(frozen=True, eq=False)
class Reduction:
    """The equations of a directly reducible A(s): second-order ones of x_m, first-order ones of x_d, x = V (x_m, x_d) + Y g.

    Attributes:
        given: A_0, A_1, A_2.
        algebraic, second, first: which rows of A(s) are of which kind.
        chosen: which coordinates of x are x_m and x_d, in this order.
        V: shape (r, m + d); x from x_m and x_d.
        Y: shape (r, k); x from the right sides of the algebraic rows.
        M: shape (m, m), what multiplies x_m''.
        C, K: the coefficients of s and of 1 in all remaining rows, the second-order ones first, shape (m + d, m + d).
        moving: which coordinates have mass or damping.
        conserved: conserved quantities of rows without stiffness, and sums of rows; None without any.
        freed: the sums of rows without stiffness among them, where they were looked for.
        largest_condition: of the parts that were divided by.
        order: order of coordinates for modes of a wide spread; None for the given one.

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
    freed: Freed | None
    largest_condition: float
    order: np.ndarray | None = None

    @property
    def through(self) -> list[Matrix]:
        """Coefficients (A_0 Y, A_1 Y, A_2 Y) of g and its derivatives in the remaining rows, each of shape (m + d, k)."""
        rest = np.concatenate([self.second, self.first])
        return [matrix[rest] @ self.Y for matrix in self.given]

    @property
    def constraining(self) -> np.ndarray:
        """Which algebraic rows constrain coordinates with mass or damping, whose values at 0- have to satisfy them."""
        return np.asarray(abs(self.Y[self.moving]).sum(axis=0)) > 0

    @property
    def state_count(self) -> int:
        """2 m + d."""
        return 2 * len(self.second) + len(self.first)

    @cached_property
    def output(self) -> Matrix:
        """x from the states w = (x_m, x_m', x_d), shape (r, 2 m + d), without Y g."""
        m = len(self.second)
        return hstack(self.V[:, :m], zeros_of_kind((self.V.shape[0], m), self.V), self.V[:, m:])

    def solved(self, right: Matrix) -> tuple[Matrix, Matrix]:
        """(x_m'', x_d') where M x_m'' + C_md x_d' and C_dd x_d' are these right sides, shape (m + d, any)."""
        m = len(self.second)
        if not len(self.first):
            return self.divided_by_mass(right), right[m:]
        rates, C = accurately_solved(self.C[m:, m:], right[m:]), self.C[:m, m:]
        left = without_noise(right[:m] - C @ rates, abs(right[:m]) + abs(C) @ abs(rates))
        return self.divided_by_mass(left), rates

    def divided_by_mass(self, right: Matrix) -> Matrix:
        """M^-1 times a matrix."""
        return accurately_solved(self.M, right)

    @cached_property
    def generator(self) -> Matrix:
        """S, shape (2 m + d, 2 m + d)."""
        m, d = len(self.second), len(self.first)
        by_state = -hstack(self.K[:, :m], self.C[:, :m], self.K[:, m:])
        with np.errstate(over="ignore", invalid="ignore"):  # see ``is_finite``
            accelerations, rates = self.solved(by_state)
        return vstack(shifted_unit(m, 2 * m + d, m, self.K), accelerations, rates)

    @cached_property
    def units(self) -> np.ndarray:
        """Units of the states in which S is balanced."""
        return balancing_units(self.generator)

    @cached_property
    def is_finite(self) -> bool:
        """Whether S is in the range of float64."""
        return is_finite(self.generator)

    @cached_property
    def spread_bound(self) -> float:
        """An upper bound of ``spread`` without eigenvalues, |S| |S^-1| in balanced units; ``spread`` itself where these are known."""
        if self.is_small or self.conserved is not None:
            return self.spread
        balanced = full(self.generator) * self.units / self.units[:, None]
        try:
            inverse = np.linalg.inv(balanced)
        except np.linalg.LinAlgError:
            return np.inf
        return float(np.linalg.norm(balanced, 1) * np.linalg.norm(inverse, 1))

    @cached_property
    def spread(self) -> float:
        """The modulus ratio of the fastest and the slowest eigenvalue, without those of rows without stiffness, and of bodies."""
        known = self.is_small or self.conserved is not None
        moduli = np.abs(zeros_of(self._own_blocks) if known else np.linalg.eigvals(full(self.generator)))
        if self.conserved is not None:
            moduli = moduli[moduli > 0]
        largest = moduli.max(initial=0.0)
        return float(largest / max(moduli.min(initial=largest), EPS * largest)) if largest else 1.0

    @property
    def _own_blocks(self) -> tuple[np.ndarray, ...]:
        """The blocks without exact ones of slow motions of softly supported bodies."""
        blocks = self.decoupled.blocks
        if self.freed is not None and self.is_symmetric:
            sizes = [np.abs(zeros_of([block])).max() for block in blocks]
            return tuple(blocks[i] for i in np.argsort(sizes)[len(self.freed.sums) :])
        return blocks[: len(blocks) - self.decoupled.exact_blocks]

    @cached_property
    def modal_residual(self) -> float:
        """|X^-1 S X - J| / |J| of the modes X with their blocks J."""
        parts, J = self.decoupled, block_matrix(self.decoupled.blocks)
        if not len(J):
            return 0.0
        return float(np.abs(parts.inverse @ (self.generator @ parts.basis) - J).max() / (np.abs(J).max() or 1.0))

    @cached_property
    def is_well_separated(self) -> bool:
        """Whether the modes of S are accurate to a quarter of the digits, and none of them is a combination of huge states.

        An eigenvalue may be accurate and its vector close to another's: where one of two like parts drives the other.
        """
        parts, units = self.decoupled, self.units[:, None]
        if not self.state_count:
            return True
        off = np.abs(parts.inverse @ parts.basis - np.eye(self.state_count)).max()
        sizes = ((parts.basis / units) ** 2).sum(axis=0) * ((parts.inverse.T * units) ** 2).sum(axis=0)
        return bool(max(off, self.modal_residual) <= EPS**0.75 and sizes.max() <= REDUCED_AMPLIFICATION**2)

    @cached_property
    def drives_unstable_part(self) -> bool:
        """Whether a motion grows and not all states are coupled: rounding errors would excite the growth from other states."""
        zeros = self.eigenvalues
        if not (zeros.real > noise_of(np.abs(zeros).max(initial=0.0))).any():
            return False
        return connected_components(csr_array(self.generator), connection="strong")[0] > 1

    @property
    def is_free(self) -> bool:
        """Whether springs balance a free body within rounding errors, which alone would move it."""
        return self.freed is not None and any(len(block) > 1 for block in self.conserved.blocks)

    @property
    def is_small(self) -> bool:
        """Whether the decoupling of S takes negligible time."""
        return self.state_count < FEW_STATES

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """All eigenvalues, of complex pairs the one above the real axis."""
        return zeros_of(self.decoupled.blocks)

    @cached_property
    def is_reciprocal(self) -> bool:
        """Whether M, C and K are symmetric, and no row is without stiffness."""
        return (self.conserved is None or self.freed is not None) and all(
            is_symmetric(matrix) for matrix in (self.M, self.C, self.K)
        )

    @cached_property
    def topology(self) -> SparseTopology | None:
        """Topology of a large model coupled like a chain, a tree, a ring or a ladder; None for any other."""
        if self.state_count < MANY_STATES or self.conserved is not None or not self.is_reciprocal:
            return None
        return sparse_topology(self.M, self.C, self.K)

    @cached_property
    def is_symmetric(self) -> bool:
        """Whether S can be decoupled by a symmetric eigenproblem: all masses, no damping or a proportional one.

        Its shapes have errors relative to their largest entries. So weakly coupled groups that decay or grow differently are left to
        the general method.
        """
        if len(self.first) or not self.is_reciprocal or self._is_softly_supported:
            return False
        damped = entry_count(self.C) > 0
        if damped and not is_symmetric(self.C @ self.divided_by_mass(self.K)):
            return False
        balanced = of_like_kind(self.generator * self.units / self.units[:, None], self.generator)
        return not is_weakly_coupled(balanced) or (not damped and is_semidefinite(self.K))

    @property
    def _is_softly_supported(self) -> bool:
        """Whether a body has a soft support beyond rounding errors, which affect shapes to first order."""
        if self.conserved is None or self.conserved.left is None:
            return False
        sizes = [float(abs(matrix).max()) for matrix in (self.K, self.C)]
        return any(np.abs(left).max() > ROUNDING_SUPPORT * size for left, size in zip(self.freed.remainders, sizes))

    @property
    def rounded_supports(self) -> list[tuple[int, float]]:
        """Free bodies whose support may be rounding errors: number of coordinates, and time from which motions differ."""
        if self.freed is None:
            return []
        left, m = self.freed.remainders[0], self.M.shape[0]
        units = np.abs(left) / np.maximum(EPS * full(abs(self.K).max(axis=0)).reshape(-1), np.finfo(float).tiny)
        bodies = ((units > DOUBTFUL_SUM[0]) & (units <= DOUBTFUL_SUM[1])).any(axis=1) & (units <= DOUBTFUL_SUM[1]).all(axis=1)
        result = []
        for v, rest in zip(self.freed.sums[bodies], left[bodies]):
            stiffness, mass = abs(rest @ v), abs(v[:m] @ (self.M @ v[:m]))
            if stiffness and mass:
                result.append((int(np.count_nonzero(v)), float(np.sqrt(ROUNDED_FREE * mass / stiffness))))
        return result

    @cached_property
    def is_dissipative(self) -> bool:
        """Whether no motion can grow: M, K positive definite, C positive semidefinite, all symmetric."""
        m, d = len(self.second), len(self.first)
        M = vstack(hstack(self.M, zeros_of_kind((m, d), self.M)), zeros_of_kind((d, m + d), self.M))
        return all(is_symmetric(matrix) and is_semidefinite(matrix) for matrix in (M, self.C, self.K))

    @cached_property
    def decoupled(self) -> BlockDiagonal | ResidueModes:
        """S decoupled, with uncoupled parts separate: growth in one part is absent from the others."""
        if self.conserved is not None and not self.is_symmetric:
            parts = decoupled_with_conserved(full(self.generator), self.conserved, self._decoupled_rest)
            return refined(self, parts)
        if self.wide_modes is not None:
            return self.wide_modes
        groups, modes = self._groups, self._topology_modes
        parts = assembled(groups, [own or self._decoupled(states) for own, states in zip(modes, groups)])
        return parts if self.is_symmetric or isinstance(parts, ResidueModes) else refined(self, parts)

    @cached_property
    def wide_modes(self) -> SymmetricModes | BlockDiagonal | None:
        """Modes of symmetric M and K with rates over many orders of magnitude; None for other models, or where inefficient."""
        if self.is_small or len(self.first) or self.conserved is not None:
            return None
        if not (is_symmetric(self.M) and is_symmetric(self.K) and may_be_wide(self.M, self.K)):
            return None
        if len(self._groups) > 1 or self.topology is not None:
            return None
        return modes_of_wide_spread(self.M, self.C, self.K, self.order)

    @property
    def topology_failed(self) -> bool:
        """Whether the computation of modes by topology failed for a large part."""
        tried = zip(self._topology_modes, self._groups)
        return self.topology is not None and any(modes is None and len(states) >= MANY_STATES for modes, states in tried)

    @cached_property
    def _groups(self) -> list[np.ndarray]:
        return _groups(self.generator)

    @cached_property
    def _topology_modes(self) -> list[ResidueModes | None]:
        """The modes of each part by its topology, where that is possible."""
        if self.is_symmetric or self.topology is None:
            return [None] * len(self._groups)
        m = len(self.second)
        coordinates = [np.concatenate([states[states < m], states[states >= 2 * m] - m]) for states in self._groups]
        large = [len(states) >= MANY_STATES for states in self._groups]
        return [self.topology.modes(own) if many else None for own, many in zip(coordinates, large)]

    def _decoupled(self, states: np.ndarray) -> BlockDiagonal:
        """Decoupled form of a part of S: by a symmetric eigenproblem of half the size, where possible."""
        m, result = len(self.second), None
        if self.is_symmetric:
            own = states[states < m]
            bodies = None
            if self.freed is not None:
                there = self.freed.sums[:, own].any(axis=1)
                bodies = np.concatenate([self.freed.sums[None], self.freed.remainders])[:, there][:, :, own]
            result = symmetric_modes(*(matrix[own][:, own] for matrix in (self.M, self.C, self.K)), bodies)
        return decoupled(full(self.generator[states][:, states]), self.units[states]) if result is None else result

    def _decoupled_rest(self, rest: np.ndarray, states: np.ndarray | None, like: np.ndarray | None = None) -> BlockDiagonal:
        """The rest of S without the conserved quantities, decoupled group by group.

        In the units of its states, or in those that balance it, or a matrix like it: those of very small couplings would be far from those
        of all others, and a row of all momenta would bend them.
        """
        units = balancing_units(kept(rest if like is None else like)) if states is None else self.units[states]
        groups = coupled_rows(rest)
        if len(groups) == 1:
            return decoupled(rest, units)
        return assembled(groups, [decoupled(rest[at[:, None], at], units[at]) for at in groups])

    def states(self, initial: np.ndarray) -> np.ndarray:
        """The states at 0+ for values at 0- (S, q, r), shape (n, S)."""
        m, places = len(self.second), initial[:, 0, self.chosen]
        velocities = initial[:, 1, self.chosen[:m]] if m else places[:, :0]
        return np.concatenate([places[:, :m], velocities, places[:, m:]], axis=1).T

    def state(self, values: np.ndarray) -> np.ndarray:
        """w from values (q, r) of x, x', ..."""
        return self.states(values[None])[:, 0]


def _groups(S: Matrix) -> list[np.ndarray]:
    """The states in uncoupled groups."""
    if isinstance(S, np.ndarray):
        return coupled_rows(S)
    count, which = connected_components(S, directed=False)
    return [np.flatnonzero(which == group) for group in range(count)]


# Zeros of a reduced A(s) once more from its equations, where those of S = M^-1 K ... have lost what cancels in them.
#
# A slow motion of a chain has neighbours that move alike: K x is a small difference of large terms, and rounding errors of S move its
# zero by as much as that of the stiffest ones. With the vectors x and u of a zero s, found from S, one step of Newton's method on
#
# u^T P(s) x = 0,  P(s) = M s^2 + C s + K,        s - u^T P(s) x / (u^T P'(s) x)
#
# has an error of the second order in theirs (Lancaster 1961, the generalized Rayleigh quotient), if P(s) x keeps its digits: each
# row is summed as (sum of its entries) x_i + sum over j of K_ij (x_j - x_i), in which nothing large cancels.

#: A matrix of fewer rows is not sparse.
FEW = 48

#: Number of zeros refined at once.
CHUNK = 32


def refined(reduction: Reduction, parts: BlockDiagonal) -> BlockDiagonal:
    """The decoupled form with refined single eigenvalues and pairs [[a, b], [-b, a]]; clusters are unchanged."""
    blocks = list(parts.blocks)
    count = len(blocks) - parts.exact_blocks
    moduli = np.abs(zeros_of(blocks[:count]))
    if SIMILAR_EIGENVALUES * moduli.min(initial=np.inf, where=moduli > 0) >= moduli.max(initial=0.0):
        return parts
    largest, places = max(np.abs(block).max() for block in blocks), block_slices(blocks)
    correction = _correction(reduction)
    for chosen in _chunks([i for i, block in enumerate(blocks[:count]) if _is_single(block)]):
        zeros, right, left = _vectors(parts, [blocks[i] for i in chosen], [places[i] for i in chosen])
        change = correction(zeros, right, left)
        change[~(np.abs(change) <= EPS**0.5 * largest)] = 0.0  # no refinement of what was wrong
        for i, zero in zip(chosen, zeros + change):
            a, b = zero.real, zero.imag
            blocks[i] = np.array([[a, b], [-b, a]]) if len(blocks[i]) == 2 else np.array([[a]])
    return replace(parts, blocks=tuple(blocks))


def _is_single(block: np.ndarray) -> bool:
    """Whether a block is a real eigenvalue other than 0, or a pair in the form [[a, b], [-b, a]]."""
    if len(block) == 1:
        return bool(block[0, 0])
    return len(block) == 2 and block[0, 0] == block[1, 1] and block[0, 1] == -block[1, 0]


def _chunks(numbers: list[int]) -> Iterator[list[int]]:
    for begin in range(0, len(numbers), CHUNK):
        yield numbers[begin : begin + CHUNK]


def _vectors(parts: BlockDiagonal, blocks, places) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The zeros s above the real axis or on it with S x = s x, shape (n, k), and y S = s y, shape (k, n), y x = 1."""
    begin = np.array([place.start for place in places])
    pair = np.array([len(block) == 2 for block in blocks])
    second = begin + pair
    zeros = np.array([block[0, -1] * 1j * (len(block) == 2) + block[0, 0] for block in blocks])
    right = parts.basis[:, begin] + 1j * pair * parts.basis[:, second]
    left = np.where(pair[:, None], (parts.inverse[begin] - 1j * parts.inverse[second]) / 2, parts.inverse[begin])
    return zeros, right, left


def _correction(reduction: Reduction) -> Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]:
    """Newton step of eigenvalues, from them and their vectors in the states (x_m, x_m', x_d)."""
    m, C = len(reduction.second), reduction.C
    damped, stiff = _Differences(C), _Differences(reduction.K)
    first, mass = C[m:, m:].T, reduction.M.T

    def correction(zeros, right, left) -> np.ndarray:
        x = np.vstack([right[:m], right[2 * m :]])
        u = solved(mass, left[:, m : 2 * m].T)
        if first.shape[0]:
            u = np.vstack([u, solved(first, left[:, 2 * m :].T - C[:m, m:].T @ u)])
        inertia = reduction.M @ x[:m]
        residual = zeros * damped(x) + stiff(x)
        residual[:m] += zeros**2 * inertia
        slope = C @ x
        slope[:m] += 2 * zeros * inertia
        return -np.einsum("ik,ik->k", u, residual) / np.einsum("ik,ik->k", u, slope)

    return correction


class _Differences:
    """A square matrix times vectors by differences of their entries, where these are the smaller terms: units may differ."""

    def __init__(self, matrix: Matrix):
        self.matrix = matrix
        row, column, values = entries(matrix)
        beyond = row != column
        self.row, self.column = row[beyond], column[beyond]
        shape = matrix.shape[0], len(self.row)
        if shape[0] < FEW:
            self.factors: Matrix = np.zeros(shape)
            self.factors[self.row, range(shape[1])] = values[beyond]
        else:
            self.factors = csr_array((values[beyond], (self.row, np.arange(shape[1]))), shape=shape)
        self.sums = exact_row_sums(matrix)

    def __call__(self, x: np.ndarray) -> np.ndarray:
        relative, size = x[self.column] - x[self.row], np.abs(x)
        differences = np.abs(self.sums)[:, None] * size + abs(self.factors) @ np.abs(relative)
        less = differences < abs(self.matrix) @ size
        return np.where(less, self.sums[:, None] * x + self.factors @ relative, self.matrix @ x)
